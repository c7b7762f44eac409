"""How much a full turn about the equilibrium multiplies small distances, in balls or by the next terms.

*One field.*  Along a homogeneous field f without radial directions ``d log|c| / d angle = (c . f)/(c x f)``.  On a cone
with rays a and b and ``c = (1 - t) a + t b`` this is the integral over 0 < t < 1 of
``(c . f)(a x b) / ((c x f)(c . c))``, a rational function without poles there, which is enclosed with all digits that
are needed (arb: Johansson 2018).  The sum over all cones, in the sense in which solutions turn, is the logarithm of the
factor.

*Arbitrary switching.*  Where all fields turn about the equilibrium in one sense, every mixture does, and its growth per
angle lies between those of the fields: with normal parts n_i of one sign, ``(sum w_i rho_i)/(sum w_i n_i)`` is a mean
of the ``rho_i/n_i``.  So the largest growth of a full turn is the integral of ``max_i rho_i/abs(n_i)``.  Which field
grows most changes only where two of them are parallel, at roots of ``f_i x f_j``, which are isolated exactly: between
them one field's growth is integrated in balls, and on the short pieces around them the maximum is enclosed by its
values.  Below zero every solution contracts, above zero the worst switching lets one grow (for two linear fields:
Boscain 2002).

*A fused focus*: both fields touch a straight switching line at the equilibrium from inside; solutions turn about it.
Let xi be the line's form and eta a coordinate along it.  With ``xi' = a eta + b xi + q eta^2 + ...`` and
``eta' = -s c + d eta + ...`` on the side where xi has the sign s, and ``a c > 0`` on both sides, a solution that leaves
the line at ``eta_0`` comes back, through the side s, at distance ``eta_0 + k_s eta_0^2 + ...`` with

    k_s = 2/3 ((b + d)/|c| + s q/|a|).

To leading order (weights 2 and 1) the turn is a tie; ``k = k_+ + k_-`` decides: positive is unstable, negative is
asymptotically stable (Filippov 1988, sec. 19; Coll, Gasull and Prohens 2001).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import reduce
from itertools import combinations
from typing import TypeAlias

from flint import acb, acb_poly, arb, ctx

from nonsmooth.analysis.cells.fan import Wedge, by_angle
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.cells.switched_cells import PlaneField
from nonsmooth.proofs.inequalities.real_roots import RealRoot, between_rays, positive_roots, separated
from nonsmooth.proofs.systems.ray_moves import Frame, TangentCone, TangentFan, build_tangent_fan, turning
from nonsmooth.symbolic.numbers.coefficients import rational_ball
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.number_text import brief_text
from nonsmooth.symbolic.numbers.plane import around, cross, dot, same_direction
from nonsmooth.symbolic.numbers.polynomial import Polynomial, in_generators
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

PRECISIONS = (64, 128, 256)  # bits, tried in turn until the sign is clear


@dataclass(frozen=True)
class TurnGrowth:
    """A full turn.

    Attributes:
        sense: 1 counterclockwise, -1 clockwise.
        low: a lower bound of the factor.
        high: an upper bound of it.
        sign: of the factor's logarithm; 0 where it is not known.
    """

    sense: int
    low: str
    high: str
    sign: int

    def __str__(self) -> str:
        return f"a full turn multiplies small distances by {self.factor}"

    @property
    def factor(self) -> str:
        """The factor in words: its bounds, or the digits that they share."""
        if self.low == self.high:
            return f"a factor of {self.low}, rounded"
        return f"a factor between {self.low} and {self.high}"


def turn_growth(fan: TangentFan) -> TurnGrowth | None:
    """The growth of a full turn; None where not all cones are turned through in one sense."""
    senses = {_sense(cone) for cone in fan.cones}
    if len(senses) != 1 or 0 in senses:
        return None
    sense = senses.pop()
    total, whole = arb(0), (Fraction(0), Fraction(1))
    for bits in PRECISIONS:
        with ctx.workprec(bits):
            total = sum((_integral_between(growth_on_chord(cone, sense), *whole) for cone in fan.cones), arb(0))
            if total > 0 or total < 0:
                break
    return growth_of_logarithm(total, sense)


def growth_of_logarithm(total: arb, sense: int) -> TurnGrowth:
    """The turn whose factor has an enclosed logarithm."""
    found = 1 if total > 0 else -1 if total < 0 else 0
    factor = total.exp()
    return TurnGrowth(sense, factor.lower().str(8, radius=False), factor.upper().str(8, radius=False), found)


def _sense(cone: TangentCone) -> int:
    """The sense in which the field turns; read off at both rays and inside, where it is known to keep its sign."""
    across = turning(cone.leading)[0]
    signs = {sign(across(ray)) for ray in (cone.start, cone.inner, cone.end)}
    return signs.pop() if len(signs) == 1 else 0


def growth_on_chord(cone: TangentCone, sense: int) -> Callable[[acb], acb]:
    """``d log|c| / dt`` along ``c = (1 - t) start + t end`` for solutions that turn in the given sense."""
    across, radial = (_on_chord(form, cone) for form in turning(cone.leading))
    x, y = (Polynomial.variable(cone.leading[0].field, cone.leading[0].variables, name) for name in "xy")
    square = _on_chord(dot((x, y), (x, y)), cone)
    area = acb(cross(cone.start, cone.end).ball()) * sense
    return lambda t: radial(t) * area / (across(t) * square(t))


def _on_chord(form: Polynomial, cone: TangentCone) -> acb_poly:
    """A form on ``(1 - t) start + t end``, with balls for coefficients."""
    terms = in_generators(form.terms, [cone.start, cone.end])
    share, rest = acb_poly([0, 1]), acb_poly([1, -1])
    total = acb_poly([0])
    for (first, second), c in terms.items():
        total += acb_poly([acb(form.field(c).ball())]) * rest ** int(first) * share ** int(second)
    return total


Rate: TypeAlias = Callable[[acb], acb]

PRECISION = 128  # bits of all balls
EVALUATIONS = 10**6  # of an integrand: forms of high degree take a tenth of them
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
        return f"a full turn under the worst switching multiplies small distances by {self.turn.factor}"


def worst_turn(system: SwitchedSystem) -> WorstTurn | None:
    """The worst turn about the checked point; None where not all fields turn in one sense without radial directions."""
    fans = [build_tangent_fan(member) for member in system.members]
    known = [fan for fan in fans if fan is not None]
    if len(known) < len(fans) or len({fan.degree for fan in known}) > 1 or any(map(_is_touched, known)):
        return None
    cones = list(_common_cones(known))
    senses = {_strict_sense(cone) for members in cones for cone in members}
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
        inner = Wedge(start, end).inner
        known = (next(cone for cone in fan.cones if cone.holds(inner)) for fan in fans)
        yield tuple(replace(cone, start=start, end=end) for cone in known)


def _strict_sense(cone: TangentCone) -> int:
    """The strict sense in which a field turns on a whole closed cone; 0 where it has none."""
    across = turning(cone.leading)[0]
    ends = {across(cone.start).sign(), across(cone.end).sign()}
    along = between_rays(across, cone.start, cone.end)
    return ends.pop() if len(ends) == 1 and along and not positive_roots(along) else 0


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
        along = between_rays(cross(first.leading, second.leading), first.start, first.end)
        roots += positive_roots(along) if along else []
    short = [_shortened(root) for root in separated(roots)]
    return [(r.low / (1 + r.low), r.high / (1 + r.high)) for r in short]


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
    values = [rate(acb(rational_ball((low + high) / 2))).real for rate in rates]
    largest = [k for k, value in enumerate(values) if not any(value < other for other in values)]
    return reduce(arb.union, (_integral_between(rates[k], low, high) for k in largest))


def _integral_between(rate: Rate, low: Fraction, high: Fraction) -> arb:
    start, end = acb(rational_ball(low)), acb(rational_ball(high))
    return arb(acb.integral(lambda u, _: rate(u), start, end, eval_limit=EVALUATIONS).real)


def _enclosed_on(rates: Sequence[Rate], low: Fraction, high: Fraction) -> arb:
    """The integral of the largest rate over a short piece, from the values on it."""
    if low >= high:
        return arb(0)
    piece = rational_ball(low).union(rational_ball(high))
    hull = reduce(arb.union, (rate(acb(piece)).real for rate in rates))
    return hull * (rational_ball(high) - rational_ball(low))


@dataclass(frozen=True)
class FusedFocus:
    """A full turn about a fused focus.

    Attributes:
        coefficient: k.
    """

    coefficient: Number

    @property
    def sign(self) -> int:
        """Of k: what the turn does to small distances."""
        return self.coefficient.sign()

    def __str__(self) -> str:
        k = brief_text(self.coefficient)
        return f"a full turn takes a small distance s on the switching line to s + k s^2, k = {k}"


def fused_focus(system: SwitchedSystem, frame: Frame) -> FusedFocus | None:
    """The turn about the equilibrium where the first form of the frame is the only surface there; None elsewhere."""
    fan = build_tangent_fan(system, frame=frame)
    if fan is None or not _only_switches_on_second_axis(fan):
        return None
    sides = [_side(fan, s) for s in (1, -1)]
    kept = [side for side in sides if side is not None]
    if len(kept) < len(sides) or kept[0][0] != kept[1][0]:
        return None
    return FusedFocus((kept[0][1] + kept[1][1]) * 2 / 3)


def _only_switches_on_second_axis(fan: TangentFan) -> bool:
    """Whether one straight surface, the second axis, passes through the point."""
    return all(
        not surfaces or (len(surfaces) == 1 and surfaces[0].degree == 1 and not cone.start[0])
        for cone, surfaces in zip(fan.cones, fan.surfaces, strict=True)
    )


def _side(fan: TangentFan, s: int) -> tuple[int, Number] | None:
    """The sense of the turn and ``(b + d)/|c| + s q/|a|`` on one side; None where the field does not touch inside."""
    field = next(cone.field for cone in fan.cones if sign(cone.inner[0]) == s)
    a, b, q, offset = (_coefficient(field, 0, e) for e in ((0, 1), (1, 0), (0, 2), (0, 0)))
    c, d = _coefficient(field, 1, (0, 0)) * -s, _coefficient(field, 1, (0, 1))
    if offset or sign(a) * sign(c) <= 0:
        return None
    return sign(a), (b + d) / abs(c) + q * s / abs(a)


def _coefficient(field: PlaneField, row: int, exponents: tuple[int, int]) -> Number:
    return field[row].terms.get(exponents, field[row].field.zero)
