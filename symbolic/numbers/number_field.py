"""One real number field per scene, grown on demand.

The field is a tower ``Q(2 cos(2 pi/N)) (sqrt g_1) ... (sqrt g_r)``: a real cyclotomic base for
regular rings, square roots for the lengths of rim directions.  Its elements are sparse sums of products of the
roots (:mod:`nonsmooth.symbolic.numbers.number`), so a sum of three square roots stays three terms however many square
roots the scene holds.

Why this and not one primitive element: the degree doubles with every new wheel length, while the
numbers that a contact state needs hold at most three of them.  A generator is adjoined only when it
is proved to be no square yet (:mod:`nonsmooth.symbolic.numbers.square_roots`), hence the products of the
generators are linearly independent.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from fractions import Fraction

from flint import arb, ctx, fmpq, fmpq_poly, fmpz_poly

from nonsmooth.symbolic.numbers.coefficients import Coefficient, Rational, as_fmpq, bits
from nonsmooth.symbolic.numbers.number import HUGE, Number
from nonsmooth.symbolic.numbers.rational_directions import direction_beside, rational_direction
from nonsmooth.symbolic.numbers.rounded import rounded
from nonsmooth.symbolic.numbers.square_roots import square_root
from nonsmooth.symbolic.numbers.work_limit import WorkMeter


class NumberField:
    """The field ``Q(2 cos(2 pi/N), sqrt g_1, ..., sqrt g_r)``, r growing on demand.

    Args:
        order: N of the base ``Q(2 cos(2 pi/N))``; 1 gives the rationals.
        measured: turns t of angles ``pi t`` that stand for rational directions
            (:mod:`nonsmooth.symbolic.numbers.measured_angles`).
        remarks: sentences about the scene's file that a reader of any result must see: how its numbers were read,
            and what in it was not.
    """

    def __init__(self, order: int = 1, measured: Iterable[Fraction] = (), remarks: Iterable[str] = ()) -> None:
        self.order = order
        self.remarks = tuple(remarks)
        self.measured = tuple(measured)
        self._measured = {angle % 2 for turn in self.measured for angle in (turn, Fraction(1, 2) - turn)}
        minimal = fmpz_poly.cos_minpoly(order)
        self.base_degree = minimal.degree()
        self.modulus: fmpq_poly | None = fmpq_poly(minimal) if self.base_degree > 1 else None
        self.radicands: list[Number] = []
        self._radicand_products: dict[int, Number] = {}
        self._float_products: dict[int, float] = {}
        self._root_balls: dict[tuple[int, int], arb] = {}
        self.root_floats: list[float] = []
        self._square_roots: dict[Number, Number] = {}
        self.base_float = 2 * math.cos(2 * math.pi / order)
        self.meter: WorkMeter | None = None  # counts products while a limit is set
        self.rounded_signs = 0  # how many decisions were those of a rounded number alone
        self.zero = Number(self, {})
        self.one = self.rational(1)

    def rational(self, value: Rational) -> Number:
        """Embed a rational number."""
        number = as_fmpq(value)
        return Number(self, {0: self.coefficient(number)} if number else {})

    def __call__(self, value: Number | Rational) -> Number:
        """Element of this field from a rational, or the element itself."""
        if isinstance(value, Number):
            if value.field is not self:
                raise ValueError("required a number of this field, received one of another field")
            return value
        return self.rational(value)

    def coefficient(self, value: fmpq) -> Coefficient:
        """A rational as an element of the base field."""
        return value if self.modulus is None else fmpq_poly([value])

    def two_cos(self, multiple: int) -> Number:
        """``2 cos(2 pi k/N)`` as a polynomial in the base generator (Chebyshev, ``2 T_k(c/2)``)."""
        k = multiple % self.order
        polynomial = fmpq_poly(fmpz_poly.chebyshev_t(min(k, self.order - k)))
        scaled = polynomial(fmpq_poly([0, fmpq(1, 2)])) * 2
        if self.modulus is None:  # N in {1, 2, 3, 4, 6}: the base generator is an integer
            return self.rational(scaled(fmpq(round(self.base_float))))
        return self.collected({0: scaled % self.modulus})

    def has_angle(self, turn: Fraction) -> bool:
        """Whether cos and sin of ``pi * turn`` are numbers of this field, exactly or as a measured angle's."""
        return turn % 2 in self._measured or self.order % base_order([turn]) == 0

    def cos_pi(self, turn: Fraction) -> Number:
        """``cos(pi * turn)``: square roots for multiples of pi/12, the base field otherwise.

        Of a measured angle it is that of its rational direction, with the box around it.

        Raises:
            ValueError: if the base field does not hold it (see :func:`base_order`).
        """
        if turn % 2 in self._measured:
            return rounded(self.rational(rational_direction(turn)[0]), direction_beside(turn)[0])
        if 12 % turn.denominator == 0:
            twelfths = int(turn * 12) % 24
            twelfths = min(twelfths, 24 - twelfths)
            value = self._cos_twelfth(min(twelfths, 12 - twelfths))
            return value if twelfths <= 6 else -value
        multiple = turn * self.order / 2
        if multiple.denominator != 1:
            raise ValueError(f"required an angle of the field of order {self.order}, received pi*{turn}")
        return self.two_cos(multiple.numerator) / 2

    def _cos_twelfth(self, k: int) -> Number:
        """``cos(k pi/12)`` for 0 <= k <= 6."""
        root = self.sqrt
        match k:
            case 1:
                return (root(6) + root(2)) / 4
            case 2:
                return root(3) / 2
            case 3:
                return root(2) / 2
            case 5:
                return (root(6) - root(2)) / 4
            case _:
                return self.rational({0: Fraction(1), 4: Fraction(1, 2), 6: Fraction(0)}[k])

    def sin_pi(self, turn: Fraction) -> Number:
        """``sin(pi * turn) = cos(pi * (1/2 - turn))``."""
        return self.cos_pi(Fraction(1, 2) - turn)

    def sqrt(self, value: Number | Rational) -> Number:
        """Non-negative square root; adjoins a generator when the field does not hold it yet.

        Raises:
            ValueError: if the value is negative.
        """
        number = self(value)
        if number not in self._square_roots:
            self._square_roots[number] = square_root(self, number)
        return self._square_roots[number]

    def adjoin(self, radicand: Number) -> Number:
        """Add the generator ``sqrt(radicand)``; the caller has proved it is not in the field yet."""
        self.radicands.append(radicand)
        self.root_floats.append(math.sqrt(float(radicand)) if -HUGE < float(radicand) < HUGE else math.inf)
        return Number(self, {1 << (len(self.radicands) - 1): self.coefficient(fmpq(1))})

    # ---- what the arithmetic of its elements needs ------------------------------------------------------

    def collected(self, terms: Mapping[int, Coefficient]) -> Number:
        """The element with these terms; zero coefficients are dropped."""
        return Number(self, {mask: c for mask, c in terms.items() if c})

    def radicand_product(self, mask: int) -> Number:
        """``prod_{i in mask} g_i``."""
        if mask not in self._radicand_products:
            product = self.one
            for i in bits(mask):
                product = product * self.radicands[i]
            self._radicand_products[mask] = product
        return self._radicand_products[mask]

    def float_product(self, mask: int) -> float:
        """``prod_{i in mask} sqrt(g_i)`` in floats."""
        if mask not in self._float_products:
            self._float_products[mask] = math.prod((self.root_floats[i] for i in bits(mask)), start=1.0)
        return self._float_products[mask]

    def root_ball(self, index: int) -> arb:
        """Enclosure of a generator at the working precision of ``flint.ctx``."""
        key = (index, ctx.prec)
        if key not in self._root_balls:
            self._root_balls[key] = self.radicands[index].ball().sqrt()
        return self._root_balls[key]

    def base_ball(self) -> arb:
        """Enclosure of ``2 cos(2 pi/N)`` at the working precision of ``flint.ctx``."""
        key = (-1, ctx.prec)
        if key not in self._root_balls:
            self._root_balls[key] = 2 * arb.cos_pi_fmpq(fmpq(2, self.order))
        return self._root_balls[key]


def base_order(turns: Iterable[Fraction]) -> int:
    """Order N of the smallest base that holds cos and sin of every angle ``pi * turn``."""
    order = 1
    for turn in turns:
        for angle in (turn, Fraction(1, 2) - turn):
            if 12 % angle.denominator:
                order = math.lcm(order, 2 * angle.denominator)
    return order
