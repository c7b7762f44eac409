"""What does a body with inertia do, of a scene whose units say what gravity is?

The clauses and the answers from them are about bodies without inertia, the limit of slow wheels.  Here the body is
heavy: near its place of rest by the five eigenvalues of the linearized full dynamics, in balls
(:class:`nonsmooth.proofs.clauses.at_point.mass.Pencil`), which is a proof; how long it swings from a ring of starts is
simulated (:mod:`nonsmooth.analysis.bodies.settling`), and called so.  The slowest eigenvalue would be wrong by a factor
of two there.  *Unstable* does not say that the body leaves: it may stay on a small limit cycle, which is followed.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache

import numpy as np
from flint import arb, arb_mat, ctx

from nonsmooth.analysis.bodies.gyration import squared_radius
from nonsmooth.analysis.bodies.mass_study import body_of
from nonsmooth.analysis.bodies.newton_euler import RigidBody
from nonsmooth.analysis.bodies.settling import FACTORS, Settling, SettlingResult, massless_holds_to, settle
from nonsmooth.analysis.bodies.supports import StartTipsError
from nonsmooth.analysis.cells.loads import LoadError
from nonsmooth.analysis.trajectories.result import TrajectoryError
from nonsmooth.proofs.answers.answer import (
    DIGITS,
    Answer,
    Inertia,
    angle_at_least,
    angle_at_most,
    at_least,
    at_most,
    has_dynamics,
)
from nonsmooth.proofs.boxes.enclosed_rest import EnclosedRest, enclosed_rest, unknowns_at_rest
from nonsmooth.proofs.boxes.enclosures import is_positive_definite
from nonsmooth.proofs.clauses.at_point.mass import PRECISION, Pencil, mass_limits
from nonsmooth.proofs.findings import Fact, Quantity, Translation, said
from nonsmooth.symbolic.mechanics.contact_set import ContactSet, alone, checked_scene, contact_set
from nonsmooth.symbolic.mechanics.edge_headings import ball_of
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.under_way import part_of
from nonsmooth.symbolic.numbers.coefficients import rational_ball
from nonsmooth.symbolic.numbers.number_text import float_text
from nonsmooth.symbolic.numbers.plane import XY, Pose, in_floats
from nonsmooth.symbolic.numbers.rounded import either_way

STARTS = 4  # on a circle about the point, of half the half-width of the checked square
COMPARED = 1  # of them, with its massless path
BESIDE = 0.5  # of the accuracy: from an unstable place of rest to one more start
FIRST = 0.4  # radian, of the first of them: off the lines of symmetry of most arrays
FADES = 4.0  # time constants of the slowest motion in a chunk
PERIODS = 12.0  # of the slowest swing at most
CROSSINGS = 2.0, 40.0  # least and most length of a chunk, in times of crossing the circle at the wheels' speed
MOST_WORK = 20_000  # evaluations of all forces on all starts: some seconds; those that are left are not followed
UNFOLLOWED = (ValueError, TrajectoryError, LoadError)  # where a path cannot be followed
DISC, PLATE, STATED = "that of a disc as large as the array", "that of a uniform plate", "as stated"


# ---- proved, near the place of rest ------------------------------------------------------------


@dataclass(frozen=True)
class NearRest:
    """The linearized full dynamics at an enclosed place of rest.

    Attributes:
        verdict: by five eigenvalues.
        why_not: why it is undecided; empty where it is not.
        place: of rest, from the checked point; None where none is enclosed.
        spin: the rotation rate there.
        eigenvalues: in floats, of the middle of the enclosure; empty where there is none.
        stable_to: with the speeds of all wheels up to this factor times as large it is stable; None where that is open.
        unstable_at: with this factor it is not; None where ``stable_to`` is only as far as was looked.
    """

    verdict: Inertia
    why_not: str = ""
    place: XY | None = None
    spin: float = 0.0
    eigenvalues: tuple[complex, ...] = ()
    stable_to: Fraction | None = None
    unstable_at: Fraction | None = None


VERDICTS = {
    Translation.ASYMPTOTICALLY_STABLE: Inertia.STABLE,
    Translation.UNSTABLE: Inertia.UNSTABLE,
    Translation.UNDECIDED: Inertia.UNDECIDED,
}
VERDICT_WORDS = {
    Inertia.STABLE: "close to its place of rest it comes to rest there, by enclosed eigenvalues",
    Inertia.UNSTABLE: "close to its place of rest it swings or drifts away from it, by enclosed eigenvalues",
}
TURNING_WORDS = "its centre of mass comes to rest, close to its place of rest, by enclosed eigenvalues"


def near_rest(scene: Scene) -> NearRest:
    """What a body with inertia does near the place of rest at or beside the checked point of a scene with gravity."""
    array, kept = alone(scene).recentred(), contact_set(scene)
    with either_way(scene.field):
        rest = enclosed_rest(array)
    if rest is None:
        return NearRest(Inertia.UNDECIDED, "no place of rest is enclosed at which forces have derivatives")
    place, spin = in_floats(rest.place), float(rest.spin)
    if rest.balance.size > 3:
        return NearRest(Inertia.UNDECIDED, "a wheel sticks at the place of rest: no linearization", place, spin)
    if not kept.keeps(rest.distance, Fraction(0)):
        away = f"{at_most(rest.distance)}{scene.units.after_length} away"
        why = f"at the place of rest, up to {away}, other wheels may carry it"
        return NearRest(Inertia.UNDECIDED, why, place, spin)
    with ctx.workprec(PRECISION):
        near = _linearized(scene, rest, place, spin)
    if kept.angle is None or 0 in rest.spin:
        return near
    said_of = TURNING_WORDS if near.verdict is Inertia.STABLE else VERDICT_WORDS.get(near.verdict, near.why_not)
    why = f"on the wheels that carry it here {said_of}; but {_until_others(scene, kept, rest)}"
    return NearRest(Inertia.UNDECIDED, why, place, spin, near.eigenvalues)


def _until_others(scene: Scene, kept: ContactSet, rest: EnclosedRest) -> str:
    """How fast a body turns at its place of rest, and how long the same wheels carry it there for certain."""
    margin, angle = kept.margin, kept.angle
    if margin is None or angle is None:
        return ""
    free, fastest = angle * (1 - rest.distance / margin), Fraction(at_most(abs(rest.spin)))
    turning = f"its heading does not: there it turns all the time, at up to {angle_at_most(fastest, scene.units)}/s"
    beyond = f"after {angle_at_least(free, scene.units)}, {at_least(free / fastest)} s at least"
    return f"{turning}, and {beyond}, others may come under it"


def _linearized(scene: Scene, rest: EnclosedRest, place: XY, spin: float) -> NearRest:
    (x, y), omega = rest.place, rest.spin
    linearized = rest.balance.at(unknowns_at_rest(arb_mat([[x], [y], [omega]])), rest.place)
    if linearized is None or scene.inertia is None:
        return NearRest(Inertia.UNDECIDED, "a wheel may stick or lift off at the place of rest", place, spin)
    height = ball_of(scene.inertia.centre_height or scene.field.zero)
    pencil = Pencil.about(linearized[1], linearized[2], rest.place, omega, ball_of(squared_radius(scene)), height)
    mass = 1 / ball_of(scene.inertia.gravity)
    verdict = VERDICTS[pencil.stability(mass)]
    values = tuple(np.roots([float(value.mid()) for value in reversed(pencil.characteristic(mass))]).tolist())
    why_not = "five eigenvalues: the signs of their real parts are not told" if verdict is Inertia.UNDECIDED else ""
    near = NearRest(verdict, why_not, place, spin, values)
    is_light = rest.stability is Translation.ASYMPTOTICALLY_STABLE
    limits = mass_limits(pencil) if is_light and is_positive_definite(pencil.damping.tolist()) else None
    if limits is None:
        return near
    stable_to, unstable_at = limits
    low = Fraction(at_least(_factor(stable_to, mass)))
    high = None if unstable_at is None else Fraction(at_most(_factor(unstable_at, mass)))
    return NearRest(verdict, why_not, place, spin, values, low, high)


def _factor(limit: Fraction, mass: arb) -> arb:
    """Speeds count as the square root of the mass."""
    return (rational_ball(limit) / mass).sqrt()


# ---- simulated ---------------------------------------------------------------------------------


@dataclass(frozen=True)
class Simulated:
    """What becomes of bodies from a ring of starts.

    Attributes:
        radius: of the ring (length).
        bodies: one for each start that was followed.
        asked: how many starts there are.
        massless_holds_to: factor of the speeds of all wheels up to which bodies keep within the accuracy of their
            massless paths, one of a few that were tried, 0 where the lowest does not; None where that is not known.
        why_not: why some were not followed.
        tip: how many of them do not stand where they would start.
    """

    radius: float
    bodies: tuple[SettlingResult, ...]
    asked: int
    massless_holds_to: float | None = None
    why_not: str = ""
    tip: int = 0

    def those(self, kind: Settling) -> list[SettlingResult]:
        """The bodies of which this becomes."""
        return [body for body in self.bodies if body.kind is kind]


def simulated(scene: Scene, near: NearRest) -> Simulated:
    """Follow bodies from the ring, heading as checked, and beside them massless ones."""
    radius = scene.check.half_width / 2
    at_x, at_y = map(float, scene.check.equilibrium)
    starts = _ring(scene, radius)
    if near.verdict is Inertia.UNSTABLE and near.place is not None:  # beside it, for a small limit cycle
        starts.insert(0, (at_x + near.place[0] + BESIDE * float(scene.accuracy), at_y + near.place[1], 0.0))
    followed = _followed(scene, near, radius, starts, "starts with inertia")
    try:
        return followed if followed.why_not else replace(followed, massless_holds_to=_massless(scene, followed.bodies))
    except UNFOLLOWED as error:
        return replace(followed, why_not=str(error))


def from_stated(scene: Scene, near: NearRest) -> Simulated | None:
    """The same from half of the stated radius, where that is larger than the checked one: over other wheels too."""
    if scene.check.wider is None or scene.inertia is None:
        return None
    radius = float(scene.check.wider) / 2
    return _followed(scene, near, radius, _ring(scene, radius), "starts with inertia farther out")


def _followed(scene: Scene, near: NearRest, radius: float, starts: list[Pose], step: str) -> Simulated:
    """What becomes of bodies from some starts, as far as they are followed."""
    followed, crossing = Simulated(radius, (), len(starts)), _crossing(scene, radius)
    body = _body(scene)
    if body is None:
        return followed
    for k, start in enumerate(starts):
        if sum(one.work for one in followed.bodies) > MOST_WORK:
            return replace(followed, why_not="it takes long")
        with part_of(k, len(starts), step):
            try:
                settled = settle(scene, body, start, float(scene.accuracy), *_chunk(near, crossing))
            except StartTipsError:
                followed = replace(followed, tip=followed.tip + 1)
            except UNFOLLOWED as error:
                return replace(followed, why_not=str(error))
            else:
                followed = replace(followed, bodies=(*followed.bodies, settled))
    return followed


def _ring(scene: Scene, radius: float) -> list[Pose]:
    """Poses on a circle about the point, heading as checked."""
    x, y = map(float, scene.check.equilibrium)
    angles = [FIRST + 2 * math.pi * k / STARTS for k in range(STARTS)]
    return [(x + radius * math.cos(angle), y + radius * math.sin(angle), 0.0) for angle in angles]


def _crossing(scene: Scene, radius: float) -> float:
    """How long a body takes over a radius at the speed of the fastest wheel."""
    return radius / (scene.fastest or 1.0)


def _body(scene: Scene) -> RigidBody | None:
    """With its own mass; None of a scene that does not say what gravity is."""
    return None if scene.inertia is None else body_of(scene, 1 / float(scene.inertia.gravity))


def settled_from(scene: Scene, start: Pose) -> SettlingResult | None:
    """Follow one body from rest until it settles; None of a scene that does not say what gravity is.

    Raises:
        ValueError: for a start at which the body does not stand.
        LoadError: for a start without loads.
        TrajectoryError: where the path cannot be followed.
    """
    scene = checked_scene(scene)
    body, crossing = _body(scene), _crossing(scene, scene.check.half_width / 2)
    if body is None:
        return None
    return settle(scene, body, start, float(scene.accuracy), *_chunk(near_rest(scene), crossing))


def _chunk(near: NearRest, crossing: float) -> tuple[float, bool, float]:
    """How long a chunk is, whether swings fade or grow in it, and how much of what is slowest fades in it, at most 1.

    Only of a stable place of rest it is known that what is slow there fades.
    """
    shortest, longest = (times * crossing for times in CROSSINGS)
    slow = min((abs(value.real) for value in near.eigenvalues), default=0.0)
    swings = [value for value in near.eigenvalues if value.imag > 0]
    fades = near.verdict is Inertia.STABLE and slow > 0
    alone = math.inf if fades else longest
    most = PERIODS * 2 * math.pi / min(value.imag for value in swings) if swings else alone
    chunk = max(shortest, min(FADES / slow if slow else math.inf, most))
    slowest = min((abs(value.real) for value in swings), default=0.0)
    return chunk, slowest * chunk >= FADES, min(1.0, slow * chunk / FADES) if fades else 1.0


def _massless(scene: Scene, bodies: Sequence[SettlingResult]) -> float | None:
    """Over the time in which bodies settle, from the first starts; None where some do not settle."""
    times, body = [one.settles_after for one in bodies if one.settles_after is not None], _body(scene)
    until = max(times, default=0.0)
    if len(times) < len(bodies) or not until or body is None:
        return None
    return massless_holds_to(scene, body, [one.start for one in bodies[:COMPARED]], float(scene.accuracy), until)


# ---- the answer --------------------------------------------------------------------------------


def inertia_answer(scene: Scene) -> Answer | None:
    """Of a body with inertia, beside the answer on the position; None where its scene does not say what gravity is."""
    if not has_dynamics(scene):
        return None
    if scene.contact.loads_are_unknown:
        return Answer("inertia", Inertia.UNDECIDED, (said("loads are not known: no path is followed"),))
    return _answered(_SameObject(scene))


@dataclass(frozen=True, eq=False)
class _SameObject:
    """A question, the same where it is about the same object."""

    scene: Scene

    def __hash__(self) -> int:
        return id(self.scene)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _SameObject) and self.scene is other.scene


@lru_cache(maxsize=16)  # an answer is asked for several times
def _answered(asked: _SameObject) -> Answer:
    scene = asked.scene
    near = near_rest(scene)
    followed = simulated(scene, near)
    farther = from_stated(scene, near)
    return Answer("inertia", near.verdict, (*_proved(scene, near), *_seen(scene, followed, farther)))


def _proved(scene: Scene, near: NearRest) -> Iterator[Fact]:
    """What the linearization says, and of which body."""
    unit, inertia = scene.units.after_length, scene.inertia
    gravity = 0.0 if inertia is None else float(inertia.gravity)
    stated = inertia is not None and inertia.squared_radius is not None
    kind = STATED if stated else DISC if scene.body is None else PLATE
    radius = squared_radius(scene)
    yield Fact("gravity", Quantity(None if inertia is None else inertia.gravity))
    yield Fact("squared_radius", Quantity(radius))
    of = f"g = {float_text(gravity, DIGITS)}{unit}/s^2, I/m = {_plain(float(radius))}{unit}^2, {kind}"
    height = None if inertia is None else inertia.centre_height
    yield Fact("centre_height", Quantity(height))
    of += f"; centre of mass {float_text(float(height), DIGITS)}{unit} above the wheels" if height else ""
    yield said(f"a body with inertia ({of})")
    yield said(VERDICT_WORDS.get(near.verdict, near.why_not))
    yield Fact("stable_to", Quantity(near.stable_to))
    yield Fact("unstable_at", Quantity(near.unstable_at))
    if near.stable_to is not None and near.unstable_at is not None:
        low, high = at_least(near.stable_to), at_most(near.unstable_at)
        yield said(f"it is stable up to {low} times these speeds, and unstable at {high} times")


def _seen(scene: Scene, followed: Simulated, farther: Simulated | None) -> Iterator[Fact]:
    """What the simulation says, from near starts and from the radius that is stated."""
    unit, accuracy = scene.units.after_length, float_text(float(scene.accuracy), DIGITS)
    at_rest, cycles = followed.those(Settling.AT_REST), followed.those(Settling.LIMIT_CYCLE)
    settles = len(followed.bodies) == followed.asked == len(at_rest)
    yield Fact("status", "simulated")
    yield Fact("swings", max(one.swings or 0 for one in at_rest) if settles else None)
    yield Fact("settles_after", max(one.settles_after or 0.0 for one in at_rest) if settles else None)
    yield Fact("limit_cycle", max((one.amplitude or 0.0 for one in cycles), default=None))
    yield Fact("massless_holds_to", followed.massless_holds_to)
    yield Fact("from", [_record(one) for one in followed.bodies])
    beside = " and one beside it" if followed.asked > STARTS else ""
    away = f"{STARTS} starts {float_text(followed.radius, DIGITS)}{unit} away"
    yield said(f"simulated from {away}{beside}: {_becomes(scene, followed)}")
    if farther is not None:
        yield Fact("from_stated", {"tip": farther.tip, "from": [_record(one) for one in farther.bodies]})
        stated = float_text(2 * farther.radius, DIGITS)
        of = f"half of the {stated}{unit} that are stated, so also over other wheels"
        yield said(
            f"from {STARTS} starts {float_text(farther.radius, DIGITS)}{unit} away, {of}: {_becomes(scene, farther)}"
        )
    if followed.massless_holds_to is not None:
        yield said(_alike(followed.massless_holds_to, accuracy + unit))


def _becomes(scene: Scene, followed: Simulated) -> str:
    """What becomes of bodies from a ring of starts, and of how many of them where that is not all."""
    unit, accuracy = scene.units.after_length, float_text(float(scene.accuracy), DIGITS)
    at_rest, cycles = followed.those(Settling.AT_REST), followed.those(Settling.LIMIT_CYCLE)
    parts = []
    if at_rest:
        swings = max(one.swings or 0 for one in at_rest)
        count = "" if len(at_rest) == followed.asked else f"{len(at_rest)} "
        within = f"within {accuracy}{unit} of where {'they end' if count else 'it ends'}"
        after = max(one.settles_after or 0.0 for one in at_rest)
        when = f"after {float_text(after, 3)} s" if after else "already at the start"
        parts.append(f"{count}{within} {when}, {_swings(swings)}")
    if cycles:
        size = max(one.amplitude or 0.0 for one in cycles)
        parts.append(f"{len(cycles)} on a limit cycle, up to {float_text(size, 3)}{unit} from its middle")
    for kind in (Settling.THROWN_OFF, Settling.OPEN):
        those = len(followed.those(kind))
        parts += [f"{those} {kind}"] if those else []
    parts += [f"{followed.tip} of {followed.asked} tip where they start"] if followed.tip else []
    parts += [f"not all are followed: {followed.why_not}"] if followed.why_not else []
    return ", ".join(parts)


def _plain(value: float) -> str:
    """Four digits, without a power of ten up to a million."""
    return f"{float(float_text(value, DIGITS)):.6g}"


def _swings(most: int) -> str:
    return f"with up to {most} swing{'' if most == 1 else 's'}" if most else "without a swing"


def _record(one: SettlingResult) -> dict[str, object]:
    return {
        "start": list(one.start),
        "end": list(one.end),
        "what": str(one.kind),
        "settles_after": one.settles_after,
        "swings": one.swings,
        "limit_cycle": one.amplitude,
    }


def _alike(factor: float, accuracy: str) -> str:
    """Up to which speeds it moves as one without inertia."""
    if not factor:
        return f"without inertia it moves otherwise, by more than {accuracy}, even at {FACTORS[0]:g} of these speeds"
    most = "at least " if factor == FACTORS[-1] else ""
    return f"without inertia it moves alike, within {accuracy}, up to {most}{float_text(factor, 3)} times these speeds"
