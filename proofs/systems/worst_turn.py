"""The worst full turn under arbitrary switching, enclosed by balls.

Where all fields turn about the equilibrium in one sense, every mixture does, and its growth per angle lies between
those of the fields: with normal parts n_i of one sign, ``(sum w_i rho_i)/(sum w_i n_i)`` is a mean of the
``rho_i/n_i``.  So the largest growth of a full turn is the integral of ``max_i rho_i/abs(n_i)``.  Which field grows
most changes only where two of them are parallel, at roots of ``f_i x f_j``, which are isolated exactly: between them
one field's growth is integrated in balls, and on the short pieces around them the maximum is enclosed by its values.
Below zero every solution contracts, above zero the worst switching lets one grow (for two linear fields: Boscain 2002).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import combinations
from typing import TypeAlias

from flint import acb, arb, ctx, fmpq

from nonsmooth.analysis.cells.fan import by_angle
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.cells.switched_cells import PlaneField
from nonsmooth.proofs.inequalities.dense_polynomials import trimmed
from nonsmooth.proofs.inequalities.real_roots import RealRoot, positive_roots, separated
from nonsmooth.proofs.systems.tangent_fan import TangentCone, TangentFan, build_tangent_fan, turning
from nonsmooth.proofs.systems.turn_growth import TurnGrowth, growth_of_logarithm, growth_on_chord
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.polynomial import Polynomial, in_generators
from nonsmooth.symbolic.plane import around, cross, same_direction
from nonsmooth.symbolic.switched_system import SwitchedSystem

Rate: TypeAlias = Callable[[acb], acb]

PRECISION = 128  # bits of all balls
WIDTH = Fraction(1, 2**40)  # of the pieces around roots


@dataclass(frozen=True)
class WorstTurn:
    """The full turn with the most growth.

    Attributes:
        turn: encloses the factor.
    """

    turn: TurnGrowth

    @property
    def sign(self) -> int:
        """Of the factor's logarithm; 0 where it is not known."""
        return self.turn.sign

    def __str__(self) -> str:
        factor = f"between {self.turn.low} and {self.turn.high}"
        return f"a full turn under the worst switching multiplies small distances by a factor {factor}"


def worst_turn(system: SwitchedSystem) -> WorstTurn | None:
    """The worst turn about the checked point; None where not all fields turn in one sense without radial directions."""
    fans = [build_tangent_fan(member) for member in system.members]
    known = [fan for fan in fans if fan is not None]
    if len(known) < len(fans) or len({fan.degree for fan in known}) > 1 or any(map(_is_touched, known)):
        return None
    cones = list(_common_cones(known))
    senses = {_sense(cone) for members in cones for cone in members}
    if len(senses) != 1 or 0 in senses:
        return None
    sense = senses.pop()
    with ctx.workprec(PRECISION):
        total = sum((_largest_growth(members, sense) for members in cones), arb(0))
        return WorstTurn(growth_of_logarithm(total, sense))


def _is_touched(fan: TangentFan) -> bool:
    """Whether a surface of a member passes through the point: those are left to other searches."""
    return any(fan.surfaces)


def _common_cones(fans: Sequence[TangentFan]) -> Iterator[tuple[TangentCone, ...]]:
    """Cones on which every member has one field, counterclockwise: one cone for each member."""
    rays: list[Point] = []
    for fan in fans:
        rays += [c.start for c in fan.cones if not any(same_direction(c.start, known) for known in rays)]
    for start, end in around(sorted(rays, key=by_angle)):
        inner = (start[0] + end[0], start[1] + end[1])
        yield tuple(replace(_cone_at(fan, inner), start=start, end=end) for fan in fans)


def _cone_at(fan: TangentFan, direction: Point) -> TangentCone:
    inside = (c for c in fan.cones if cross(c.start, direction) >= 0 and cross(direction, c.end) > 0)
    return next(inside)


def _sense(cone: TangentCone) -> int:
    """The strict sense in which a field turns on a whole closed cone; 0 where it has none."""
    across = turning(cone.leading)[0]
    ends = {across(cone.start).sign(), across(cone.end).sign()}
    along = _along(across, cone)
    return ends.pop() if len(ends) == 1 and along and not positive_roots(along) else 0


def _along(form: Polynomial, cone: TangentCone) -> list[Number]:
    """A form on ``start + t end``, ascending in t; empty where it is zero."""
    terms = in_generators(form.terms, [cone.start, cone.end])
    return trimmed([form.field(terms.get((form.degree - k, k), 0)) for k in range(form.degree + 1)])


def _largest_growth(members: Sequence[TangentCone], sense: int) -> arb:
    """Encloses the integral of the largest growth per angle over a cone."""
    rates = [growth_on_chord(cone, sense) for cone in members]
    total, start = arb(0), Fraction(0)
    for low, high in [*_short_pieces(members), (Fraction(1), Fraction(1))]:
        total += _integral_of_largest(rates, start, low)
        total += _enclosed_on(rates, low, high)
        start = high
    return total


def _short_pieces(members: Sequence[TangentCone]) -> list[tuple[Fraction, Fraction]]:
    """Around every root of ``f_i x f_j``, in ``c = (1 - u) start + u end``."""
    roots: list[RealRoot] = []
    for first, second in combinations(members, 2):
        along = _along(_product(first.leading, second.leading), first)
        roots += positive_roots(along) if along else []
    short = [_shortened(root) for root in separated(roots)]
    return [(r.low / (1 + r.low), r.high / (1 + r.high)) for r in short]


def _product(f: PlaneField, g: PlaneField) -> Polynomial:
    return cross(f, g)


def _shortened(root: RealRoot) -> RealRoot:
    while root.high - root.low > WIDTH:
        root = root.halved()
    return root


def _integral_of_largest(rates: Sequence[Rate], low: Fraction, high: Fraction) -> arb:
    """The integral of the rate that is largest in the middle, and so, without roots between, everywhere.

    Rates that balls do not tell apart there are all taken: one of them is the largest.
    """
    if low >= high:
        return arb(0)
    values = [rate(acb(_ball((low + high) / 2))).real for rate in rates]
    largest = [k for k, value in enumerate(values) if not any(value < other for other in values)]
    integrals = [_integral(rates[k], low, high) for k in largest]
    hull = integrals[0]
    for integral in integrals[1:]:
        hull = hull.union(integral)
    return hull


def _integral(rate: Rate, low: Fraction, high: Fraction) -> arb:
    return arb(acb.integral(lambda u, _: rate(u), acb(_ball(low)), acb(_ball(high))).real)


def _enclosed_on(rates: Sequence[Rate], low: Fraction, high: Fraction) -> arb:
    """The integral of the largest rate over a short piece, from the values on it."""
    if low >= high:
        return arb(0)
    piece = _ball(low).union(_ball(high))
    values = [rate(acb(piece)).real for rate in rates]
    hull = values[0]
    for value in values[1:]:
        hull = hull.union(value)
    return hull * (_ball(high) - _ball(low))


def _ball(value: Fraction) -> arb:
    return arb(fmpq(value.numerator, value.denominator))
