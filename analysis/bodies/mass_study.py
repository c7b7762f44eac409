"""Full dynamics against the quasi-static contact rules: distance of the paths against mass.

As the mass goes to 0 at a fixed weight (or, which is the same, as the wheels turn more slowly) the velocity settles in
a time of order m on the one at which friction balances: the minimizer of the dissipation, for the friction sets of the
scene's own rule, or for ellipses where that has cells.  So the distance to the path of that rule falls like m (a slow
manifold in the sense of Fenichel 1979), once m is small enough: where the functional is nearly flat in one direction,
friction barely damps it, the rule's own field turns around within a narrow strip, and until m is small beside that
strip the distance falls like ``sqrt(m)`` (measured, not derived: three wheels in a ring, from (0.2, 0.4), down to
m = 1e-7).  The distances to the paths of other rules do not go to zero: they go to the distance of these paths from
that of the limit, which is listed as theirs.

Of a body with an outline both sides follow the wheels that enter and leave
(:mod:`nonsmooth.analysis.bodies.mass_path`, :mod:`nonsmooth.analysis.bodies.path`,
:mod:`nonsmooth.analysis.bodies.outline_field`).  It may slide along the edge at which a wheel enters and leaves it.
There the swings of a light body mix the loads, while the rule's path mixes the motions (Filippov): such a path is no
limit, and none is stated.

Distances are the largest over common times: the end of either path, where it leaves the checked square or tips, ends
the comparison, a rest does not.  Paths are compared at sampled times: a sampled maximum is a lower bound.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from nonsmooth.analysis.bodies.gyration import squared_radius
from nonsmooth.analysis.bodies.mass_path import MassPath, simulate_dynamics
from nonsmooth.analysis.bodies.newton_euler import DynamicPath, RigidBody, disc
from nonsmooth.analysis.bodies.outline_field import CellPath
from nonsmooth.analysis.bodies.path import RELATIVE_TOLERANCE, smooth_path
from nonsmooth.analysis.bodies.supports import carried_contacts
from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.cells.contact_rule import CellRule, SmoothRule, all_rules, contact_rule, massless_rule
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.fields.constant_field import array_field
from nonsmooth.analysis.fields.contact_model import contact_model, contacts_under
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.measurements.harness import Assessment, Clock, LeftOut, Order, Study, StudyPlan, Trial
from nonsmooth.analysis.trajectories.result import BROKEN_OFF, EventKind, Trajectory, TrajectoryError
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.symbolic.mechanics.contact_set import whole
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.notebook import ShortRepr, html_table
from nonsmooth.symbolic.numbers.number_text import float_text
from nonsmooth.symbolic.numbers.plane import Pose, pose_in_floats
from nonsmooth.symbolic.numbers.plane_arrays import Floats, max_norm, norms

COMPARED = 1001  # times at which two paths are compared, both ends included
LADDER = 5  # masses of a ladder, each a tenth of the one before


@dataclass(frozen=True)
class PathDistance:
    """How far two paths are apart.

    Attributes:
        rule: the contact rule of the path that is compared with.
        position: largest ``|c - c_rule|`` (length).
        rotation: largest ``|theta - theta_rule|`` (radians).
        until: last time at which both exist.
    """

    rule: str
    position: float
    rotation: float
    until: float


@dataclass(frozen=True)
class MassRow:
    """Full dynamics at one mass.

    Attributes:
        body: mass and inertia.
        distances: from the path of each contact rule that has one.
        evaluations: how often forces were computed.
    """

    body: RigidBody
    distances: tuple[PathDistance, ...]
    evaluations: int

    def distance(self, rule: str) -> PathDistance:
        """The distance from the path of one rule.

        Raises:
            KeyError: for a rule without a path.
        """
        return {distance.rule: distance for distance in self.distances}[rule]


@dataclass(frozen=True, repr=False)
class MassStudy(ShortRepr):
    """A ladder of masses.

    Attributes:
        start: ``(x, y, theta)``, at rest.
        until: last time.
        rows: one per mass, in the order given.
        limits: distances of the other rules' paths from that of the rule that is the limit, what their columns tend to;
            None where that path slides along an edge of the body's outline.
        skipped: rules without a path, and why.
    """

    start: Pose
    until: float
    rows: tuple[MassRow, ...]
    limits: tuple[PathDistance, ...] | None
    skipped: Mapping[str, str]

    def _repr_html_(self) -> str:
        found = [(float_text(row.body.mass, 3), distance) for row in self.rows for distance in row.distances]
        found += [("-> 0", limit) for limit in self.limits or ()]
        rows = [
            (mass, distance.rule, float_text(distance.position, 3), float_text(distance.rotation, 3))
            for mass, distance in found
        ]
        head = (
            f"full dynamics from {self.start} at rest, until t = {self.until:g}: largest distance from each rule's path"
        )
        return html_table(head, ("mass", "rule", "of (x, y)", "of theta"), rows)


def mass_ladder(body: RigidBody, count: int = LADDER) -> tuple[RigidBody, ...]:
    """Bodies of one shape, each a tenth as heavy as the one before.

    Args:
        body: the first of them.
        count: how many.
    """
    return tuple(replace(body, mass=body.mass / 10**k, inertia=body.inertia / 10**k) for k in range(count))


def rule_path(scene: Scene, rule: str, start: Sequence[float], until: float) -> Trajectory:
    """The quasi-static path of one contact rule, exact kinematics; of a body with an outline from set to set of wheels.

    Raises:
        RefusalError: where the rule has no cells, or no loads exist.
        ValueError: for a start outside the checked square, or at which a body with an outline tips.
        SceneError: for a table of loads beside an outline.
        TrajectoryError: where the path cannot be followed.
    """
    chosen = scene.under(rule)
    contact = contact_rule(rule)
    if isinstance(contact, SmoothRule):
        return smooth_path(contact, chosen, start, until)
    if scene.body is not None and isinstance(contact, CellRule):
        return CellPath(whole(chosen), contact).follow(start, until)
    return simulate(array_field(build_partition(chosen), Kinematics.EXACT), start, until)


def body_path(scene: Scene, body: RigidBody, start: Sequence[float], until: float) -> DynamicPath:
    """Full dynamics from rest: on all wheels, or of a body with an outline on those under it.

    Friction forces are those of :func:`nonsmooth.analysis.cells.contact_rule.massless_rule`.

    Raises:
        ValueError: for a start at which a body with an outline tips.
        SceneError: for a table of loads beside an outline.
        TrajectoryError: where the path cannot be followed.
    """
    contacts, outlined = carried_contacts(massless_rule(scene), scene)
    return MassPath(contacts, body, outlined).follow(start, until)


def mass_study(scene: Scene, bodies: Sequence[RigidBody], start: Sequence[float], until: float) -> MassStudy:
    """Follow full dynamics for every body, and every contact rule, from one start.

    Args:
        scene: the array.
        bodies: see :func:`mass_ladder`.
        start: ``(x, y, theta)``.
        until: last time.

    Raises:
        ValueError: for a last time that is not positive, or numbers that are not finite.
        nonsmooth.analysis.cells.loads.LoadError: for a start without loads.
        nonsmooth.analysis.trajectories.result.TrajectoryError: where the integrator gives up.
    """
    x, y, theta = pose_in_floats(start)
    paths: dict[str, Trajectory] = {}
    skipped: dict[str, str] = {}
    limit = massless_rule(scene).name
    for rule in all_rules(scene):
        try:
            paths[rule.name] = rule_path(scene, rule.name, (x, y, theta), until)
        except (RefusalError, ValueError, TrajectoryError) as error:
            if rule.name == limit:
                raise
            skipped[rule.name] = str(error)
    samples, rows = PathSamples(), []
    for body in bodies:
        path = body_path(scene, body, (x, y, theta), until)
        apart = (path_distance(rule, path.trajectory, other, until, samples) for rule, other in paths.items())
        rows.append(MassRow(body, tuple(apart), path.evaluations))
    return MassStudy((x, y, theta), float(until), tuple(rows), _limits(limit, paths, until, samples), skipped)


class PathSamples:
    """States of paths at :data:`COMPARED` times, found once for all paths that each is compared with."""

    def __init__(self) -> None:
        self._found: dict[tuple[int, float], tuple[Trajectory, Floats]] = {}  # and the path: ids are of what lives

    def until(self, path: Trajectory, last: float) -> Floats:
        """States (m, 3) at equal steps from time 0 to the last time."""
        key = id(path), last
        if key not in self._found:
            self._found[key] = path, path.sample(np.linspace(0.0, last, COMPARED))
        return self._found[key][1]


def _limits(
    limit: str, paths: Mapping[str, Trajectory], until: float, samples: PathSamples
) -> tuple[PathDistance, ...] | None:
    """What the columns of the other rules tend to; None where the path that should be the limit slides on an edge."""
    if any(event.kind is EventKind.SLIDE for event in paths[limit].events):
        return None
    others = [(rule, path) for rule, path in paths.items() if rule != limit]
    return tuple(path_distance(rule, paths[limit], path, until, samples) for rule, path in others)


def rules_by_limit(scene: Scene) -> tuple[str, ...]:
    """The names of all rules, the one that full dynamics approach first."""
    limit = massless_rule(scene).name
    return (limit, *(rule.name for rule in all_rules(scene) if rule.name != limit))


def path_distance(
    rule: str, path: Trajectory, other: Trajectory, until: float, samples: PathSamples | None = None
) -> PathDistance:
    """Largest distance up to a time; ``other`` is the path of the rule, ``samples`` holds what is known of both."""
    samples = samples or PathSamples()
    last = min([until, *(float(one.end.t) for one in (path, other) if one.end.reason in BROKEN_OFF)])
    apart = samples.until(path, last) - samples.until(other, last)
    return PathDistance(rule, float(norms(apart).max()), max_norm(apart[:, 2]), last)


# ---- a body --------------------------------------------------------------------------------------


def body_of(scene: Scene, mass: float) -> RigidBody:
    """The body of a scene with a mass per weight.

    Its inertia is ``rho^2`` times as large where the scene states that, else that of a uniform plate of the outline,
    else that of a disc as large as the array.  The height of its centre of mass is 0 unless the scene states it.

    Raises:
        ValueError: for a mass that cannot be used.
    """
    stated = scene.inertia
    if scene.body is None and (stated is None or stated.squared_radius is None):
        body = disc(contact_model(scene), mass)
    else:
        body = RigidBody(mass, mass * float(squared_radius(scene)))
    if stated is None or stated.centre_height is None:
        return body
    return replace(body, centre_height=float(stated.centre_height))


# ---- the study of precision ----------------------------------------------------------------------
#
# Here the model is in question and not a method: the reference is the path that the body takes as its mass goes to 0,
# that of rule ``ellipse``, integrated far below the distances measured.  Full dynamics approaches it like the mass; the
# other rules stay where they are, so their rows tell what a contact rule costs and what it misses.


MASSES = tuple(10.0**-k for k in (1, 2, 3, 4, 5))  # in units of R/u^2: R half the square, u the largest speed
MASS_START = (0.4, 0.8)  # in units of R, from the checked point
TIMES = 4.0  # in units of R/u
LIKE_MASS = Order(
    1.0, "velocity settles within a time like m; later where D is nearly flat (see the theory: full dynamics)"
)


def build_masses(scene: Scene) -> StudyPlan:
    """Full dynamics and the quasi-static rules from one start in every scene's own units.

    Raises:
        LeftOut: where nothing drives the body, or the rule that is the limit has no path.
    """
    rule = massless_rule(scene)
    model, radius = contacts_under(rule, scene), scene.check.half_width
    speed = float(abs(model.speeds).max())
    if not speed:
        raise LeftOut("no wheel is driven")
    x, y = (float(at) + radius * share for at, share in zip(scene.check.equilibrium, MASS_START, strict=True))
    start, until = (x, y, 0.0), TIMES * radius / speed
    try:
        limit = rule_path(scene, rule.name, start, until)
    except (RefusalError, TrajectoryError) as error:
        raise LeftOut(str(error)) from None

    def judge(followed: tuple[Trajectory, dict[str, int]]) -> Assessment:
        path, work = followed
        apart = path_distance(rule.name, path, limit, until)
        return Assessment(apart.position, {"theta": apart.rotation}, work)

    def with_mass(mass: float, clock: Clock) -> tuple[Trajectory, dict[str, int]]:
        path = simulate_dynamics(model, disc(model, mass), start, until)
        return path.trajectory, {"evaluations": path.evaluations}

    def by_rule(other: str, clock: Clock) -> tuple[Trajectory, dict[str, int]]:
        return rule_path(scene, other, start, until), {}

    unit = radius / speed**2
    trials = [Trial("full dynamics", partial(with_mass, mass * unit), judge, "mass", mass) for mass in MASSES]
    others = [other.name for other in all_rules() if other.name != rule.name]
    trials += [Trial(f"rule {other}", partial(by_rule, other), judge) for other in others]
    reference = f"path of rule {rule.name}, {RELATIVE_TOLERANCE:g} per step, from ({x:g}, {y:g}) until t = {until:g}"
    return StudyPlan(reference, tuple(trials), {"full dynamics": LIKE_MASS}, rounding=RELATIVE_TOLERANCE * 100)


MASS = Study(
    "masses", "full dynamics as the mass goes to 0: distance from rule ellipse", "path distance [length]", build_masses
)
