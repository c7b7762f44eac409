"""What the evidence of a clause's result says by definition: for tests that look at evidence, and forge it.

The product confirms evidence where it finds it, and the checker of certificates confirms what they state.  Here the
objects themselves are held against the definitions, with nothing searched: multiplied out, compared, evaluated.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import singledispatch
from itertools import pairwise
from typing import Any

from flint import ctx

from nonsmooth.analysis.bodies.gyration import squared_radius_of_disc
from nonsmooth.analysis.cells.fan import CellCone, by_angle, is_plane
from nonsmooth.analysis.cells.load_sets import load_set
from nonsmooth.proofs.boxes.linearization import inward_pull
from nonsmooth.proofs.checker import fan as checker
from nonsmooth.proofs.clauses.at_point.cocircular import cocircular_array
from nonsmooth.proofs.clauses.at_point.ellipse import EllipsePoint, Situation, motion_with
from nonsmooth.proofs.clauses.at_point.every_load import float_loads, is_admissible
from nonsmooth.proofs.clauses.at_point.mass import (
    PRECISION,
    MassLimit,
    Pencil,
    _is_confirmed,
    hurwitz_determinant,
)
from nonsmooth.proofs.clauses.clause import Witness
from nonsmooth.proofs.clauses.equilibrium.clause import EquilibriumResult
from nonsmooth.proofs.clauses.feedback.by_friction import DrivenFeedback
from nonsmooth.proofs.clauses.feedback.driven_law import LawCone, gains, in_scene
from nonsmooth.proofs.clauses.feedback.every_load_law import EveryLoadLaw, wheels_of
from nonsmooth.proofs.clauses.feedback.twist_candidates import BoxTwist, ImposedTwist, rank_of
from nonsmooth.proofs.clauses.rotation.clause import RotationResult, _has_short_paths
from nonsmooth.proofs.clauses.translation.at_point import (
    EllipseTranslation,
    EveryLoadTranslation,
    _decay,
    home_disc,
    turning_disc,
)
from nonsmooth.proofs.clauses.translation.fan_stability import FanResult
from nonsmooth.proofs.clauses.translation.on_cells import (
    TranslationResult,
    _local_rates,
    _rests_on_ray,
    local_derivatives,
    squared_reach,
)
from nonsmooth.proofs.clauses.translation.quadratic import (
    QuadraticCertificate,
    QuadraticDecrease,
    _pairs,
    shaped,
)
from nonsmooth.proofs.findings import Equilibrium, Feedback, Rotation, Translation
from nonsmooth.symbolic.mechanics.contact_states import inner
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.numbers.plane import around, cross, dot, plus


@singledispatch
def evidence_holds(result: Any) -> bool:
    """Whether the evidence of a result is what its verdict needs; that it is about an array is not looked at."""
    raise TypeError(f"required evidence of a clause, received {type(result).__name__}")


# ---- clause 1 ----------------------------------------------------------------------------


@evidence_holds.register
def _(result: EquilibriumResult) -> bool:
    """Weights that mix the velocities to zero, or a direction in which all of them point."""
    if result.verdict is Equilibrium.UNDECIDED:
        return not result.weights and result.separator is None
    if result.verdict is Equilibrium.HOLDS:
        total = sum(result.weights.values())
        x = sum(w * result.twists[k].vx for k, w in result.weights.items())
        y = sum(w * result.twists[k].vy for k, w in result.weights.items())
        return bool(total == 1 and x == 0 and y == 0 and all(w >= 0 for w in result.weights.values()))
    if result.separator is None or not result.twists:
        return False
    return all(dot(result.separator, t.velocity).sign() > 0 for t in result.twists)


# ---- clause 2 on cells -------------------------------------------------------------------


@evidence_holds.register
def _(fan: FanResult) -> bool:
    """The verdict of the stand-alone checker on these cones."""
    rays: list[Any] = [(*cone.start, 1) for cone in fan.cones]
    cones = []
    for k, cone in enumerate(fan.cones):
        ends = (-1, -1) if is_plane(cone) else (k, (k + 1) % len(rays))
        twists: Any = cone.twists
        cones.append(checker.Cone(*ends, twists))
    return checker.Fan(cones, rays).verdict() == (None if fan.verdict is Translation.UNDECIDED else fan.verdict)


@evidence_holds.register
def _(result: TranslationResult) -> bool:
    """V* at the vertices, its largest rate, the region, and what the fan and another V add."""
    rates = list(_local_rates(result.derivatives))
    exact = all(
        rate == 2 * dot(d.twist.velocity, vertex)
        for d in result.derivatives
        for rate, vertex in zip(d.rates, d.cell.polygon.vertices, strict=True)
    )
    slopes = [d.relative() for d in result.derivatives]
    bounded = not any(result.worst < s for s in slopes) and any(not s < result.worst for s in slopes)
    if not rates or not exact or not bounded:
        return False
    if result.lemma is not None and cocircular_array(result.lemma.scene) is None:
        return False
    if result.quadratic is not None and not (result.fan and result.quadratic.cones == result.fan.cones):
        return False
    if result.quadratic is not None and not (
        evidence_holds(result.quadratic) and _stays_supported(result, result.quadratic)
    ):
        return False
    highest = max(rate.sign() for _, rate in rates)
    if result.verdict is Translation.UNDECIDED and result.fan is None:
        return result.region_radius is None and result.quadratic is None
    if highest > 0:  # V is refuted and the fan decides alone
        return result.witness is not None and _is_attained(result, result.witness) and _fan_says(result)
    if result.fan is not None and result.fan.verdict is Translation.UNSTABLE:
        return False  # V* <= 0 shows stability: one of the two is wrong
    strict = highest < 0
    rest = result.witness is None or _rests_on_ray(result.derivatives, result.witness.point)
    decided = result.verdict is (Translation.ASYMPTOTICALLY_STABLE if strict else Translation.STABLE)
    return rest and _region_holds(result, strict=strict) and (decided or _fan_says(result))


def _fan_says(result: TranslationResult) -> bool:
    if result.fan is None or not evidence_holds(result.fan) or result.fan.verdict is not result.verdict:
        return False
    local = {d.cell.index for d in local_derivatives(result.derivatives)}
    return {cone.cell.index for cone in result.fan.cones if isinstance(cone, CellCone)} == local


def _region_holds(result: TranslationResult, *, strict: bool) -> bool:
    radius = result.region_radius
    if result.support is not None and not result.support.stands:
        return radius is None
    if radius is None or radius.sign() <= 0:
        return False
    if result.support is not None and radius * radius > result.support.squared_distance:
        return False
    return squared_reach(result.derivatives, strict=strict, within=radius) >= radius * radius


def _stays_supported(result: TranslationResult, quadratic: QuadraticCertificate) -> bool:
    if result.support is not None and not result.support.stands:
        return False
    sides = () if result.support is None else result.support.sides
    return all(quadratic.level <= quadratic.least_on(p, q) for p, q in sides)


def _is_attained(result: TranslationResult, witness: Witness) -> bool:
    return witness.value.sign() > 0 and any(
        witness.value == 2 * dot(d.twist.velocity, witness.point)
        for d in local_derivatives(result.derivatives)
        if d.cell.polygon.contains(witness.point)
    )


@evidence_holds.register
def _(own: QuadraticCertificate) -> bool:
    """Each P is positive, falls as it says on every ray, and the region stays in the fan."""
    swift = own.swift or own.descent
    falling = _falls(own.descent, own.cones) and _falls(swift, own.cones) and own.speed(swift) > 0
    return falling and sign(own.level) > 0 and own.level <= own.largest_level()


def _falls(own: QuadraticDecrease, cones: Sequence[CellCone]) -> bool:
    """``r^T P v <= -m |r|`` and negative, without taking the root."""
    a, b = own.shape
    for ray, velocity in _pairs(cones):
        slope = dot(ray, shaped(own.shape, velocity))
        if not (sign(slope) < 0 and sign(slope * slope - own.decay * own.decay * dot(ray, ray)) >= 0):
            return False
    return a * a + b * b < 1 and own.decay > 0


# ---- clause 3 ----------------------------------------------------------------------------


@evidence_holds.register
def _(result: RotationResult) -> bool:
    """The drift by weights and multipliers, and where theta is stable what bounds it."""
    if result.drift is not None and not result.drift.check():
        return False
    if result.verdict is Rotation.UNDECIDED:
        return True
    if result.drift is None:
        return False
    spins = any(result.drift.interval)
    if result.verdict is Rotation.UNSTABLE:
        return spins
    bounded = result.rotation_per_distance is not None or not any(map(any, result.drift.twists))
    return not spins and (
        bounded or (result.fan is not None and _has_short_paths(result.fan) and evidence_holds(result.fan))
    )


# ---- without cells -----------------------------------------------------------------------


@evidence_holds.register
def _(point: EllipsePoint) -> bool:
    """The twist that is named is such a motion, with that linearization; not that the body is driven away."""
    zero = point.scene.field.zero
    if not point.region.polygon.contains((zero, zero)):
        return False
    if point.twist is None:
        return point.linearization is None and point.situation in (Situation.MOVED, Situation.OPEN)
    found = motion_with(point.scene, point.region, point.twist)
    if found is None or (found.situation, found.held) != (point.situation, point.held):
        return False
    return point.linearization in (None, found.linearization)


@evidence_holds.register
def _(result: EllipseTranslation) -> bool:
    """The situation, the masses and the disc."""
    point, mass = result.point, result.mass
    if mass is not None and not (
        mass.linearization == point.linearization
        and mass.squared_radius == squared_radius_of_disc(point.scene)
        and evidence_holds(mass)
    ):
        return False
    discs = [None, home_disc(point.scene, point.region, point.linearization)]
    if point.turns_within is not None:
        discs.append(turning_disc(point, point.turns_within))
    return result.region_radius in discs and evidence_holds(point)


@evidence_holds.register
def _(limit: MassLimit) -> bool:
    """Both masses by the determinant."""
    with ctx.workprec(PRECISION):
        determinant = hurwitz_determinant(Pencil.of(limit.linearization, limit.squared_radius))
        return _is_confirmed(limit.stable_to, limit.unstable_at, determinant)


@evidence_holds.register
def _(result: EveryLoadTranslation) -> bool:
    """The forces of every wheel, or what the witness does."""
    point, load = result.point, result.load
    if result.verdict is Translation.UNSTABLE:
        decay = _decay(point)
        return decay is not None and load is not None and is_admissible(point.scene, load) and decay.throws_out(load)
    if result.comes_home:
        return point.slope is not None and inward_pull(point.slope) is not None
    return load is None


# ---- clause 4 ----------------------------------------------------------------------------


@evidence_holds.register
def _(feedback: DrivenFeedback) -> bool:
    """The twists and the rate (stabilizable), or that all off the plane is excluded (no certificate)."""
    normal, kappa = feedback.obstruction, feedback.kappa
    if feedback.verdict is Feedback.NO_CERTIFICATE and normal is not None:
        off = [c for c in feedback.candidates if inner(normal, in_scene(c.twist, feedback.length))]
        return any(normal) and all(candidate.is_excluded for candidate in off)
    if feedback.verdict is Feedback.STABILIZABLE and kappa is not None:
        fast = kappa > 0 and all(gains(cone.vectors, kappa) and evidence_holds(cone) for cone in feedback.cones)
        law = feedback.every_load
        safe = law is None or all(_holds_under_every_load(law, cone) for cone in feedback.cones)
        return fast and safe and _go_around(feedback.cones)
    claims = feedback.verdict in (Feedback.NO_CERTIFICATE, Feedback.STABILIZABLE)
    return not claims and (feedback.beyond is None or evidence_holds(feedback.beyond))


@evidence_holds.register
def _(cone: LawCone) -> bool:
    """Three independent twists, each the only minimizer."""

    def is_unique(imposed: ImposedTwist) -> bool:
        if cone.rays is None:
            return imposed.is_unique
        return isinstance(imposed, BoxTwist) and imposed.is_unique_towards(plus(*cone.rays))

    return rank_of(cone.twists) == 3 and all(map(is_unique, (*cone.twists, *cone.elsewhere)))


def _holds_under_every_load(law: EveryLoadLaw, cone: LawCone) -> bool:
    if not 0 < law.slack < 1 or cone.rays is not None or rank_of(cone.twists) != 3:
        return False
    return law.holds(cone.twists, wheels_of(law.scene), float_loads(load_set(law.scene).bound))


def _go_around(cones: Sequence[LawCone]) -> bool:
    """Whether cones cover all directions of c: one all around, or each from the last ray of the one before it."""
    rays = [cone.rays for cone in cones if cone.rays is not None]
    if len(rays) != len(cones) or not rays:
        return len(cones) == 1
    chained = all(before[1] == after[0] for before, after in around(rays))
    ordered = all(by_angle(a[0]) < by_angle(b[0]) for a, b in pairwise(rays))
    return chained and ordered and all(sign(cross(*pair)) > 0 for pair in rays)
