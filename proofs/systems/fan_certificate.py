"""Certificates of plain systems in two states that the frozen field at the point decides, without V.

Where the fields ``f_i(0)`` on the tangent cones at the equilibrium decide, a certificate states the system, the
verdict, and what shows it: the radial velocities of the frozen field, each with its ray, or the gain of a full turn.
The stand-alone checker (:mod:`nonsmooth.proofs.system_checker`, ``FanCertificate``) finds cones, velocities, motions
and gain from the formulas again, and takes rational numbers only.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.proofs.system_checker import FAN_SCHEMA, check_certificate
from nonsmooth.proofs.systems.leading_terms import radial_motions
from nonsmooth.proofs.systems.system_certificate import (
    NoCertificateError,
    about,
    accepted,
    exact_text,
    notes,
    require_no_roots,
)
from nonsmooth.proofs.systems.system_stability import SystemResult
from nonsmooth.proofs.systems.tangent_fan import TangentFan, build_tangent_fan
from nonsmooth.proofs.verdicts import Translation
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.plane import around, cross, dot, same_direction
from nonsmooth.symbolic.switched_system import SwitchedSystem


@dataclass(frozen=True)
class FrozenCone:
    """A cone less than a half turn with the velocity ``f(0)`` of its field."""

    start: Point
    end: Point
    velocity: Point


@dataclass(frozen=True)
class RadialVelocity:
    """A radial velocity of the frozen inclusion, with a vector along its ray."""

    ray: Point
    velocity: Point

    @property
    def is_outward(self) -> bool:
        """Whether it leads away from the equilibrium."""
        return bool(sign(dot(self.ray, self.velocity)) > 0)

    @property
    def record(self) -> dict[str, list[str]]:
        """As the certificate writes it."""
        return {"ray": [exact_text(v) for v in self.ray], "velocity": [exact_text(v) for v in self.velocity]}


def build_fan_certificate(result: SystemResult) -> dict[str, Any]:
    """The certificate of a verdict by the frozen field, accepted by the stand-alone checker.

    Args:
        result: of a check that no V decides.

    Raises:
        NoCertificateError: for an undecided verdict, for a verdict on which the velocities at the equilibrium do not
            decide, for several right-hand sides, for numbers with roots, and where the checker does not show it.
    """
    require_no_roots(result.scene)
    if result.verdict is Translation.UNDECIDED:
        raise NoCertificateError("a certificate needs a verdict, received undecided")
    return accepted(fan_statement(result.scene, result.verdict), check_certificate)


def fan_statement(system: SwitchedSystem, verdict: Translation) -> dict[str, Any]:
    """What a certificate by the frozen field states, true or not.

    Args:
        system: in two states.
        verdict: not undecided.

    Raises:
        NoCertificateError: where the velocities at the equilibrium show nothing, and for numbers with roots.
    """
    cones = _frozen_cones(system)
    motions = list(radial_velocities(cones))
    if verdict is Translation.UNSTABLE:
        outward = [motion for motion in motions if motion.is_outward]
        motions = (outward or _slow_departures(system, motions) or motions)[:1]
    return {
        "schema": FAN_SCHEMA,
        **about(system),
        "verdict": str(verdict),
        "motions": [motion.record for motion in motions],
        "gain": None if motions else exact_text(full_turn_gain(cones)),
        "notes": notes(system),
    }


def _slow_departures(system: SwitchedSystem, motions: Sequence[RadialVelocity]) -> list[RadialVelocity]:
    """Of the radial velocities that are zero, those with a sliding motion that leads outward by its first term."""
    fan = build_tangent_fan(system)
    rays = [m.ray for m in radial_motions(fan) if m.direction > 0 and m.lasting] if fan is not None else []
    zero = [motion for motion in motions if not any(map(sign, motion.velocity))]
    return [motion for motion in zero if any(same_direction(motion.ray, ray) for ray in rays)]


def _frozen_cones(system: SwitchedSystem) -> list[FrozenCone]:
    """The cones of the fan with their velocities.

    Raises:
        NoCertificateError: where there is no such fan, or all velocities are zero.
    """
    if len(system.members) > 1:
        raise NoCertificateError("a certificate by velocities at the equilibrium needs one right-hand side")
    fan = build_tangent_fan(system)
    if fan is None or fan.degree:
        raise NoCertificateError(
            "a certificate without V needs fields that do not all vanish at the equilibrium, "
            "between curves with rational tangents"
        )
    return [FrozenCone(cone.start, cone.end, _constant(fan, k)) for k, cone in enumerate(fan.cones)]


def _constant(fan: TangentFan, k: int) -> Point:
    f, g = fan.cones[k].leading
    return f.terms.get((0, 0), f.field.zero), g.terms.get((0, 0), g.field.zero)


def radial_velocities(cones: Sequence[FrozenCone]) -> Iterator[RadialVelocity]:
    """All radial velocities of a frozen field, but those of a field along a ray across which it jumps.

    Args:
        cones: counterclockwise, neighbours sharing their rays.
    """
    for velocity in dict.fromkeys(cone.velocity for cone in cones):
        opposite = (-velocity[0], -velocity[1])
        for ray in (velocity, opposite):
            if any(map(sign, velocity)) and _is_inside(cones, velocity, ray):
                yield RadialVelocity(ray, velocity)
    for before, after in _jumps(cones):
        slide = _sliding_velocity(after.start, before.velocity, after.velocity)
        if slide is not None:
            yield RadialVelocity(after.start, slide)


def _jumps(cones: Sequence[FrozenCone]) -> Iterator[tuple[FrozenCone, FrozenCone]]:
    """Neighbours with different velocities."""
    return ((before, after) for before, after in around(cones) if before.velocity != after.velocity)


def _is_inside(cones: Sequence[FrozenCone], velocity: Point, ray: Point) -> bool:
    """Whether a direction lies inside the cones of a velocity: in one of them, or between two of them."""
    own = (cone for cone in cones if cone.velocity == velocity)
    if any(sign(cross(cone.start, ray)) > 0 and sign(cross(ray, cone.end)) > 0 for cone in own):
        return True
    on_ray = [pair for pair in around(cones) if not cross(pair[1].start, ray) and sign(dot(pair[1].start, ray)) > 0]
    return any(cone.velocity == velocity == other.velocity for cone, other in on_ray)


def _sliding_velocity(ray: Point, before: Point, after: Point) -> Point | None:
    """The mixture of two velocities along a ray; None where they do not push to opposite sides."""
    p, q = cross(ray, before), cross(ray, after)
    if sign(p) * sign(q) >= 0:
        return None
    scale = (q - p).inverse()
    return (before[0] * q - after[0] * p) * scale, (before[1] * q - after[1] * p) * scale


def full_turn_gain(cones: Sequence[FrozenCone]) -> Number:
    """By what a full turn multiplies the distance, where all cones are crossed in one sense.

    Raises:
        NoCertificateError: where some are not.
    """
    senses = {sign(cross(ray, cone.velocity)) for cone in cones for ray in (cone.start, cone.end)}
    if senses not in ({1}, {-1}):
        raise NoCertificateError(
            "a certificate without V needs a radial velocity that decides, or velocities at the equilibrium that "
            "all cross their switching lines in one sense"
        )
    gain = cross(cones[0].start, cones[0].velocity) * cross(cones[0].end, cones[0].velocity).inverse()
    for cone in cones[1:]:
        gain = gain * cross(cone.start, cone.velocity) * cross(cone.end, cone.velocity).inverse()
    return gain if senses == {1} else gain.inverse()
