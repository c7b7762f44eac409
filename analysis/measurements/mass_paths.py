"""The study ``masses`` of ``precision``: paths of bodies with less and less mass.

Here the model is in question and not a method: the reference is the path that the body takes as its mass goes to 0,
that of rule ``ellipse``, integrated far below the distances measured.  Full dynamics approaches it like the mass; the
other rules stay where they are, so their rows tell what a contact rule costs and what it misses.
"""

from __future__ import annotations

from functools import partial

from nonsmooth.analysis.bodies.mass_path import simulate_dynamics
from nonsmooth.analysis.bodies.mass_study import massless_limit, path_distance, rule_path
from nonsmooth.analysis.bodies.path import RELATIVE_TOLERANCE
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.contact_rule import all_rules
from nonsmooth.analysis.dynamics.newton_euler import disc
from nonsmooth.analysis.fields.contact_model import contact_model
from nonsmooth.analysis.measurements.harness import Assessment, Clock, LeftOut, Order, Study, StudyPlan, Trial
from nonsmooth.analysis.trajectories.result import Trajectory, TrajectoryError
from nonsmooth.symbolic.scene import Scene

MASSES = tuple(10.0**-k for k in (1, 2, 3, 4, 5))  # in units of R/u^2: R half the square, u the largest speed
MASS_START = (0.4, 0.8)  # in units of R, from the checked point
TIMES = 4.0  # in units of R/u
LIKE_MASS = Order(
    1.0, "velocity settles within a time like m; later where D is nearly flat (see the theory: full dynamics)"
)


def build_masses(scene: Scene) -> StudyPlan:
    """Full dynamics and the quasi-static rules from one start in every scene's own units.

    Raises:
        LeftOut: where nothing drives the body, or rule ``ellipse`` has no path.
    """
    model, radius = contact_model(scene), float(scene.check.radius)
    speed = float(abs(model.speeds).max())
    if not speed:
        raise LeftOut("no wheel is driven")
    x, y = (float(at) + radius * share for at, share in zip(scene.check.equilibrium, MASS_START, strict=True))
    start, until = (x, y, 0.0), TIMES * radius / speed
    try:
        limit = rule_path(scene, massless_limit(), start, until)
    except (RefusalError, TrajectoryError) as error:
        raise LeftOut(str(error)) from None

    def judge(followed: tuple[Trajectory, dict[str, int]]) -> Assessment:
        path, work = followed
        apart = path_distance(massless_limit(), path, limit, until)
        return Assessment(apart.position, {"theta": apart.rotation}, work)

    def with_mass(mass: float, clock: Clock) -> tuple[Trajectory, dict[str, int]]:
        path = simulate_dynamics(model, disc(model, mass), start, until)
        return path.trajectory, {"evaluations": path.evaluations}

    def by_rule(rule: str, clock: Clock) -> tuple[Trajectory, dict[str, int]]:
        return rule_path(scene, rule, start, until), {}

    unit = radius / speed**2
    trials = [Trial("full dynamics", partial(with_mass, mass * unit), judge, "mass", mass) for mass in MASSES]
    others = [rule.name for rule in all_rules() if not rule.is_massless_limit]
    trials += [Trial(f"rule {rule}", partial(by_rule, rule), judge) for rule in others]
    reference = f"path of rule ellipse, {RELATIVE_TOLERANCE:g} per step, from ({x:g}, {y:g}) until t = {until:g}"
    return StudyPlan(reference, tuple(trials), {"full dynamics": LIKE_MASS}, rounding=RELATIVE_TOLERANCE * 100)


MASS = Study(
    "masses", "full dynamics as the mass goes to 0: distance from rule ellipse", "path distance [length]", build_masses
)
