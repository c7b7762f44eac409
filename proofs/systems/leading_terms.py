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

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.cells.switched_cells import PlaneField
from nonsmooth.proofs.findings.verdicts import Translation
from nonsmooth.proofs.inequalities.real_roots import (
    RealRoot,
    along_ray,
    between_rays,
    germ_sign,
    positive_roots,
    samples_between,
    value,
)
from nonsmooth.proofs.systems.full_turns import FusedFocus, TurnGrowth, WorstTurn, fused_focus, turn_growth, worst_turn
from nonsmooth.proofs.systems.lyapunov_rows import lines_through
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
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.number_text import place_text
from nonsmooth.symbolic.numbers.plane import cross
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

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
    growth: TurnGrowth | FusedFocus | WorstTurn | None

    def reason(self, states: Sequence[str]) -> str:
        """One sentence for people, in the names of the states."""
        return f"to leading order {self._what()}{self._weighted(states)}"

    def _what(self) -> str:
        if self.growth is not None:
            return str(self.growth)
        outward = [m for m in self.motions if m.direction > 0]
        told = outward[0] if outward else self.motions[0]
        where = f"the ray through {place_text(told.ray, 5)}" if self.weights == UNWEIGHTED else "a curve"
        if outward:
            return f"a solution {'slides' if told.sliding else 'runs'} outward along {where}"
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
    if system.waves and len(system.written) == 1:
        return _of_enclosed(system)
    if system.others:
        worst = worst_turn(system)
        if worst is None or not worst.sign or (system.waves and worst.sign > 0):
            return None  # what only encloses the field may turn out where the field does not
        return _by_turn(axes_frame(system), UNWEIGHTED, worst)
    for frame, weights in _coordinates(system):
        fan = build_tangent_fan(system, weights, frame)
        found = decide_fan_of_leading_terms(fan) if fan is not None else None
        if found is not None:
            return found
    return _by_fused_focus(system)


def _of_enclosed(system: SwitchedSystem) -> LeadingTerms | None:
    """Of sines and cosines that are enclosed: where all members have the same leading terms, so has the field.

    The field is affine in every weight between its members, so what they do not share is of higher order throughout.
    """
    first, *others = system.members
    for frame, weights in _coordinates(first):
        fan = build_tangent_fan(first, weights, frame)
        known = fan is not None and needs_no_other_terms(fan)
        found = decide_fan_of_leading_terms(fan) if fan is not None and known else None
        if found is not None and all(_leading(build_tangent_fan(m, weights, frame)) == _leading(fan) for m in others):
            return found
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
    return sign(turns[0] * speeds[1] - turns[1] * speeds[0]) * sign(turns[0] - turns[1])


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
    forms = [_coefficients(line) for line in lines_through(system)]
    for form in forms:
        yield form, next(f for f in (*forms, *axes_frame(system)) if cross(form, f))


def _coefficients(line: Polynomial) -> Point:
    zero = line.field.zero
    return line.terms.get((1, 0), zero), line.terms.get((0, 1), zero)


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
    growth = turn_growth(fan)
    return None if growth is None or not growth.sign else _by_turn(fan.frame, fan.weights, growth)


def _by_turn(frame: Frame, weights: Weights, growth: TurnGrowth | FusedFocus | WorstTurn) -> LeadingTerms:
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
