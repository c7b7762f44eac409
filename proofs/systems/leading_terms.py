"""Stability decided by leading terms: the fan of tangent cones with homogeneous fields of one degree.

Directions turn and distances grow along a homogeneous field as functions of the direction alone.  F of the leading
terms holds a radial vector on a ray where ``c x f`` vanishes in a cone, or where the fields beside a surface turn about
it in opposite senses.  Then for the leading terms, and for whatever is added of higher order
(Filippov 1988, sec. 16; Bernuau, Efimov, Perruquetti and Polyakov 2014):

- an outward radial vector: unstable.  With terms of higher order that is said only where they cannot remove it: inside
  a cone ``c x f`` changes its sign there, on a surface both fields turn strictly;
- radial vectors, all inward: no solution turns past them, every one ends up near one: asymptotically stable;
- none: all solutions turn in one sense, and the distance is multiplied in a full turn by the exponential of the
  integral of ``(c . f)/(c x f)`` over the angle: its sign, enclosed by balls, decides.

Where the sliding motion on a straight surface is zero to leading order and both fields push strictly, its own first
term takes that place.  A ray that several surfaces touch may hide thin cells between them: then only what happens
elsewhere is said.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import reduce
from itertools import combinations
from typing import Any, TypeAlias

from flint import acb, arb, ctx

from nonsmooth.analysis.cells.fan import Wedge, by_angle
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.cells.switched_cells import PlaneField
from nonsmooth.proofs.findings import Translation
from nonsmooth.proofs.inequalities.real_roots import (
    RealRoot,
    along_ray,
    between_rays,
    germ_sign,
    positive_roots,
    samples_between,
    separated,
    value,
)
from nonsmooth.proofs.systems.ray_moves import (
    UNWEIGHTED,
    Frame,
    TangentCone,
    TangentFan,
    Weights,
    axes_frame,
    build_tangent_fan,
    is_simple,
    rays_between,
    turning,
)
from nonsmooth.symbolic.numbers.coefficients import rational_ball
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.number_text import brief_text, place_text
from nonsmooth.symbolic.numbers.plane import around, cross, dot, same_direction
from nonsmooth.symbolic.numbers.polynomial import Polynomial, in_generators
from nonsmooth.symbolic.systems.switched_system import PLANE, SwitchedSystem

WEIGHTS: tuple[Weights, ...] = (UNWEIGHTED, (2, 1), (1, 2), (3, 1), (1, 3), (3, 2), (2, 3))
LINE_WEIGHTS: tuple[Weights, ...] = ((2, 1), (3, 1), (3, 2))


@dataclass(frozen=True)
class RadialMotion:
    """A ray on which F of the leading terms holds a radial vector.

    Attributes:
        ray: a vector along it (close to it where it has no name in the field).
        direction: 1 outward, -1 inward, 0 at rest.
        lasting: whether terms of higher order cannot remove it.
        sliding: whether it is a sliding motion between two cones.
    """

    ray: Point
    direction: int
    lasting: bool
    sliding: bool


@dataclass(frozen=True)
class LeadingTerms:
    """Decision by leading terms.

    Attributes:
        verdict: strong stability of the equilibrium.
        frame: the linear forms that take the place of x and y.
        weights: of these.
        motions: the radial motions.
        growth: of a full turn, where there is no radial motion.
    """

    verdict: Translation
    frame: Frame
    weights: Weights
    motions: tuple[RadialMotion, ...]
    growth: TurnGrowth | FusedFocus | None

    def reason(self, states: Sequence[str]) -> str:
        """One sentence for people, in the names of the states."""
        return f"to leading order {self._what()}{self._weighted(states)}"

    def _what(self) -> str:
        if self.growth is not None:
            return str(self.growth)
        outward = [m for m in self.motions if m.direction > 0]
        motion = outward[0] if outward else self.motions[0]
        where = f"the ray through {place_text(motion.ray, 5)}" if self.weights == UNWEIGHTED else "a curve"
        if outward:
            return f"a solution {'slides' if motion.sliding else 'runs'} outward along {where}"
        count = len(self.motions)
        more = f" and {count - 1} more" if count > 1 else ""
        return f"all radial motions lead inward (along {where}{more})"

    def _weighted(self, states: Sequence[str]) -> str:
        if self.weights == UNWEIGHTED:
            return ""
        names = tuple(states)
        first, second = (Polynomial(f[0].field, names, {e: c for e, c in _named(f) if c}) for f in self.frame)
        return f", with weights {self.weights[0]} and {self.weights[1]} of {first} and {second}"


def _named(form: Point) -> list[tuple[tuple[int, int], Number]]:
    """The terms of a linear form by its coefficients."""
    return [((1, 0), form[0]), ((0, 1), form[1])]


def decide_leading_terms(system: SwitchedSystem) -> LeadingTerms | None:
    """Decide by the first frame and weights whose leading terms do; None where none do.

    The equilibrium must hold 0 in its Filippov set.
    """
    if system.only_encloses and len(system.rewriting.written) == 1:
        leading = _of_enclosed(system)
        if leading is not None or system.rewriting.waves:
            return leading
    if system.others:
        worst = _worst_turn(system)
        if worst is None or not worst.sign or (system.only_encloses and worst.sign > 0):
            return None  # what only encloses the field may turn out where the field does not
        return _by_turn(axes_frame(system), UNWEIGHTED, worst)
    for frame, weights in _coordinates(system):
        fan = build_tangent_fan(system, weights, frame)
        leading = decide_fan_of_leading_terms(fan) if fan is not None else None
        if leading is not None:
            return leading
    return _by_fused_focus(system)


def _of_enclosed(system: SwitchedSystem) -> LeadingTerms | None:
    """Of sines, cosines and norms that are enclosed: where all members have the same leading terms, so has the field.

    The field is affine in every weight between its members, so what they do not share is of higher order throughout.
    """
    first, *others = system.members
    for frame, weights in _coordinates(first):
        fan = build_tangent_fan(first, weights, frame)
        suffices = fan is not None and needs_no_other_terms(fan)
        leading = decide_fan_of_leading_terms(fan) if fan is not None and suffices else None
        if leading is not None and all(_leading(build_tangent_fan(m, weights, frame)) == _leading(fan) for m in others):
            return leading
    return None


def needs_no_other_terms(fan: TangentFan) -> bool:
    """Whether no field touches a surface, and no sliding motion vanishes, to leading order."""
    for before, after, surfaces in rays_between(fan):
        turns, speeds = zip(*(_turn_and_speed(c.leading, after.start) for c in (before, after)), strict=True)
        if surfaces and (not all(map(sign, turns)) or _slide(turns, speeds) == 0):
            return False
    return True


def _slide(turns: Sequence[Any], speeds: Sequence[Any]) -> int | None:
    """The sign of the sliding motion of two fields on a ray; None where they do not oppose each other."""
    if sign(turns[0]) * sign(turns[1]) >= 0:
        return None
    return sign(cross(turns, speeds)) * sign(turns[0] - turns[1])


def _leading(fan: TangentFan | None) -> tuple[object, ...] | None:
    """What a decision by leading terms rests on."""
    if fan is None or fan.is_exact:
        return None if fan is None else (fan,)
    return (fan.degree, fan.surfaces, *((cone.start, cone.end, cone.leading) for cone in fan.cones))


def _by_fused_focus(system: SwitchedSystem) -> LeadingTerms | None:
    """The next terms, where the leading ones tie on a switching line that both fields touch."""
    for frame in _line_frames(system):
        focus = fused_focus(system, frame)
        if focus is not None and focus.sign:
            return _by_turn(frame, LINE_WEIGHTS[0], focus)
    return None


def _coordinates(system: SwitchedSystem) -> Iterator[tuple[Frame, Weights]]:
    """Frames with weights: x and y with all of them, then each switching line as the form of larger weight."""
    axes = axes_frame(system)
    yield from ((axes, weights) for weights in WEIGHTS)
    for frame in _line_frames(system):
        if not all(form in axes for form in frame):
            yield from ((frame, weights) for weights in LINE_WEIGHTS)


def _line_frames(system: SwitchedSystem) -> Iterator[Frame]:
    """Each switching line through the point with another form."""
    lines = (line for line in system.surfaces(system.displaced(PLANE)) if line.degree == 1 and line.is_homogeneous)
    forms = [(line.slope(0), line.slope(1)) for line in lines]
    for form in forms:
        yield form, next(f for f in (*forms, *axes_frame(system)) if cross(form, f))


def decide_fan_of_leading_terms(fan: TangentFan) -> LeadingTerms | None:
    """Decide one fan; None where the leading terms leave it open."""
    motions = tuple(radial_motions(fan))
    exact = fan.is_exact and fan.weights == UNWEIGHTED
    if any(m.direction > 0 and (m.lasting or exact) for m in motions):
        return LeadingTerms(Translation.UNSTABLE, fan.frame, fan.weights, motions, None)
    if not all(is_simple(surfaces, after.start) for _, after, surfaces in rays_between(fan)):
        return None  # perhaps thin cells
    if motions:
        if any(m.direction >= 0 for m in motions):
            return None
        return LeadingTerms(Translation.ASYMPTOTICALLY_STABLE, fan.frame, fan.weights, motions, None)
    growth = turn_growth([fan])
    return None if growth is None or not growth.sign else _by_turn(fan.frame, fan.weights, growth)


def _by_turn(frame: Frame, weights: Weights, growth: TurnGrowth | FusedFocus) -> LeadingTerms:
    """What a full turn with a known sign of its growth says."""
    verdict = Translation.UNSTABLE if growth.sign > 0 else Translation.ASYMPTOTICALLY_STABLE
    return LeadingTerms(verdict, frame, weights, (), growth)


def radial_motions(fan: TangentFan) -> Iterator[RadialMotion]:
    """All rays on which F of the leading terms holds a radial vector; one of each kind where there are many."""
    for cone in fan.cones:
        yield from _inner_motions(cone)
    for before, after, surfaces in rays_between(fan):
        yield from _motions_on_ray(fan, before, after, surfaces)


# ---- inside a cone -------------------------------------------------------------------------------


def _inner_motions(cone: TangentCone) -> Iterator[RadialMotion]:
    """Rays ``start + t end`` inside a cone on which the field is radial."""
    across, radial = (between_rays(form, cone.start, cone.end) for form in turning(cone.leading))
    if not across:
        yield from _everywhere_radial(cone, radial)
        return
    for root in positive_roots(across):
        before, after = value(across, root.low).sign(), value(across, root.high).sign()
        t = root.exact()
        yield RadialMotion(_ray(cone, root.low if t is None else t), root.sign_of(radial), before != after, False)


def _everywhere_radial(cone: TangentCone, radial: Sequence[Number]) -> Iterator[RadialMotion]:
    """A cone in which every ray is radial: one of each direction."""
    roots = positive_roots(radial) if radial else []
    places: list[Fraction | RealRoot] = [*samples_between(roots), *roots]
    for place in places:
        here = place.sign_of(radial) if isinstance(place, RealRoot) else value(radial, place).sign() if radial else 0
        t = place.low if isinstance(place, RealRoot) else place
        yield RadialMotion(_ray(cone, t), here, not roots, False)


def _ray(cone: TangentCone, t: Any) -> Point:
    return cone.start[0] + cone.end[0] * t, cone.start[1] + cone.end[1] * t


# ---- on a ray between two cones ------------------------------------------------------------------


def _motions_on_ray(
    fan: TangentFan, before: TangentCone, after: TangentCone, surfaces: Sequence[Polynomial]
) -> Iterator[RadialMotion]:
    ray = after.start
    turns, speeds = zip(*(_turn_and_speed(cone.leading, ray) for cone in (before, after)), strict=True)
    smooth = not surfaces and fan.weights == UNWEIGHTED  # the ray only divides a quadrant or the plane
    constant = fan.degree == 0 and fan.weights == UNWEIGHTED and len(surfaces) == 1 and surfaces[0].degree == 1
    for k, cone in enumerate((before, after)):
        if not turns[k]:
            lasting = smooth and _crosses_itself(before, after)
            if constant and sign(speeds[k]) > 0:
                lasting = _keeps_out(cone.field, ray, inward=(-1, 1)[k], other=sign(turns[1 - k]))
            yield RadialMotion(ray, sign(speeds[k]), lasting, False)
    slide = _slide(turns, speeds)
    if slide is not None:
        alone = len(surfaces) == 1 and is_simple(surfaces, ray)
        if not slide and fan.weights == UNWEIGHTED and alone and surfaces[0].degree == 1:
            slide = _first_slide(before.field, after.field, ray) * sign(turns[0] - turns[1])
        yield RadialMotion(ray, slide, alone, True)


def _keeps_out(field: PlaneField, ray: Point, *, inward: int, other: int) -> bool:
    """Whether a field with an outward value along a straight side of its cone leads a solution away.

    It does where the next term of ``c x f`` along the side points into the cone, or where there is none, and where the
    field on the other side pushes back: then a solution slides outward.

    Args:
        field: of the cone.
        ray: the side.
        inward: the sign of ``c x f`` of velocities that point into the cone.
        other: the sign of ``c x f`` on the other side.
    """
    return germ_sign(along_ray(turning(field)[0], ray)) * inward >= 0 or other == inward


def _crosses_itself(before: TangentCone, after: TangentCone) -> bool:
    """Whether ``c x f`` of one smooth field changes its sign across the ray between two cones."""
    ray, across = after.start, turning(after.leading)[0]
    beside = [_closer(ray, cone.inner, across) for cone in (before, after)]
    return beside[0] * beside[1] < 0


def _closer(ray: Point, place: Point, across: Polynomial) -> int:
    """The sign of a form at directions that come arbitrarily near to a ray on which it vanishes."""
    return next((sign(c) for c in between_rays(across, ray, place) if c), 0)


def _turn_and_speed(field: PlaneField, ray: Point) -> tuple[Any, Any]:
    across, radial = turning(field)
    return across(ray), radial(ray)


def _first_slide(before: PlaneField, after: PlaneField, ray: Point) -> int:
    """The sign of ``n_1 rho_2 - n_2 rho_1`` at points of a straight ray near the equilibrium."""
    (a, b), (c, d) = ([along_ray(form, ray) for form in turning(field)] for field in (before, after))
    return germ_sign(a * d - c * b)


# ---- how much a full turn multiplies small distances ---------------------------------------------
#
# In balls, or by the next terms.
#
# *One field.*  Along a homogeneous field f without radial directions ``d log|c| / d angle = (c . f)/(c x f)``.  On a
# cone with rays a and b and ``c = (1 - t) a + t b`` this is the integral over 0 < t < 1 of ``(c . f)(a x b) / ((c x
# f)(c . c))``, a rational function without poles there, which is enclosed with all digits that are needed (arb:
# Johansson 2018).  The sum over all cones, in the sense in which solutions turn, is the logarithm of the factor.
#
# *Arbitrary switching.*  Where all fields turn about the equilibrium in one sense, every mixture does, and its growth
# per angle lies between those of the fields: with normal parts n_i of one sign, ``(sum w_i rho_i)/(sum w_i n_i)`` is a
# mean of the ``rho_i/n_i``.  So the largest growth of a full turn is the integral of ``max_i rho_i/abs(n_i)``.  Which
# field grows most changes only where two of them are parallel, at roots of ``f_i x f_j``, which are isolated exactly:
# between them one field's growth is integrated in balls, and on the short pieces around them the maximum is enclosed by
# its values.  Below zero every solution contracts, above zero the worst switching lets one grow (for two linear fields:
# Boscain 2002).
#
# *A fused focus*: both fields touch a straight switching line at the equilibrium from inside; solutions turn about it.
# Let xi be the line's form and eta a coordinate along it.  With ``xi' = a eta + b xi + q eta^2 + ...`` and ``eta' = -s
# c + d eta + ...`` on the side where xi has the sign s, and ``a c > 0`` on both sides, a solution that leaves the line
# at ``eta_0`` comes back, through the side s, at distance ``eta_0 + k_s eta_0^2 + ...`` with
#
#     k_s = 2/3 ((b + d)/|c| + s q/|a|).
#
# To leading order (weights 2 and 1) the turn is a tie; ``k = k_+ + k_-`` decides: positive is unstable, negative is
# asymptotically stable (Filippov 1988, sec. 19; Coll, Gasull and Prohens 2001).


PRECISIONS = (64, 128, 256)  # bits, tried in turn until the sign is clear


@dataclass(frozen=True)
class TurnGrowth:
    """A full turn.

    Attributes:
        sense: 1 counterclockwise, -1 clockwise.
        low: a lower bound of the factor.
        high: an upper bound of it.
        sign: of the factor's logarithm; 0 where it is not known.
        is_worst: whether it is the turn with the most growth under arbitrary switching.
    """

    sense: int
    low: str
    high: str
    sign: int
    is_worst: bool = False

    def __str__(self) -> str:
        turn = "a full turn under the worst switching" if self.is_worst else "a full turn"
        factor = f"of {self.low}, rounded" if self.low == self.high else f"between {self.low} and {self.high}"
        return f"{turn} multiplies small distances by a factor {factor}"


def turn_growth(fans: Sequence[TangentFan]) -> TurnGrowth | None:
    """The growth of a full turn, the largest of several fields that may act; None where not all turn in one sense."""
    cones = list(_common_cones(fans))
    senses = {_sense(cone) for members in cones for cone in members}
    if len(senses) != 1 or 0 in senses:
        return None
    sense, total, growth_sign = senses.pop(), arb(0), 0
    for bits in PRECISIONS:
        with ctx.workprec(bits):
            total = sum((_largest_growth(members, sense) for members in cones), arb(0))
            growth_sign = 1 if total > 0 else -1 if total < 0 else 0
            if growth_sign:
                break
    low, high = (end.str(8, radius=False) for end in (total.exp().lower(), total.exp().upper()))
    return TurnGrowth(sense, low, high, growth_sign, is_worst=len(fans) > 1)


def growth_on_chord(cone: TangentCone, sense: int) -> Callable[[acb], acb]:
    """``d log|c| / dt`` along ``c = (1 - t) start + t end`` for solutions that turn in the given sense."""
    across, radial = (_on_chord(form, cone) for form in turning(cone.leading))
    place = Polynomial.coordinates(cone.leading[0].field, PLANE)
    square = _on_chord(dot(place, place), cone)
    area = acb(cross(cone.start, cone.end).ball()) * sense
    return lambda t: radial(t) * area / (across(t) * square(t))


def _on_chord(form: Polynomial, cone: TangentCone) -> Callable[[acb], acb]:
    """A form on ``(1 - t) start + t end``, with balls for coefficients.

    It is not expanded in powers of t: coefficients far apart in size would cancel there, near one of the rays.
    """
    terms = in_generators(form.terms, [cone.start, cone.end])
    ball_terms = [(int(first), int(second), acb(form.field(c).ball())) for (first, second), c in terms.items()]
    return lambda t: sum((c * (1 - t) ** first * t**second for first, second, c in ball_terms), acb(0))


Rate: TypeAlias = Callable[[acb], acb]

EVALUATIONS = 10**6  # of an integrand: forms of high degree take a tenth of them
WIDTH = Fraction(1, 2**40)  # of the pieces around roots


def _worst_turn(system: SwitchedSystem) -> TurnGrowth | None:
    """The worst turn about the checked point; None where not all fields turn in one sense without radial directions."""
    fans = [build_tangent_fan(member) for member in system.members]
    tangent_fans = [fan for fan in fans if fan is not None]
    if (
        len(tangent_fans) < len(fans)
        or len({fan.degree for fan in tangent_fans}) > 1
        or any(map(_is_touched, tangent_fans))
    ):
        return None
    return turn_growth(tangent_fans)


def _is_touched(fan: TangentFan) -> bool:
    """Whether a surface of a member passes through the point: those are left to other searches."""
    return any(fan.surfaces)


def _common_cones(fans: Sequence[TangentFan]) -> Iterator[tuple[TangentCone, ...]]:
    """Cones on which every member has one field, counterclockwise: one cone for each member."""
    rays: list[Point] = []
    for fan in fans:
        rays += [c.start for c in fan.cones if not any(same_direction(c.start, ray) for ray in rays)]
    for start, end in around(sorted(rays, key=by_angle)):
        inner = Wedge(start, end).inner
        cones = (next(cone for cone in fan.cones if cone.holds(inner)) for fan in fans)
        yield tuple(replace(cone, start=start, end=end) for cone in cones)


def _sense(cone: TangentCone) -> int:
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
    valid_sides = [side for side in sides if side is not None]
    if len(valid_sides) < len(sides) or valid_sides[0][0] != valid_sides[1][0]:
        return None
    return FusedFocus((valid_sides[0][1] + valid_sides[1][1]) * 2 / 3)


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
