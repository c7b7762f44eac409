"""Full dynamics against the quasi-static rules: distance of the paths, by mass and by run time.

Here the model is in question and not a method: the reference is the path that the body takes as its mass goes to 0,
that of rule ``ellipse``, integrated far below the distances measured.  Full dynamics approaches it like the mass; the
other rules stay where they are, so their rows tell what a contact rule costs and what it misses.
"""

from __future__ import annotations

from functools import partial
from typing import Any

from nonsmooth.analysis.bodies.mass_study import massless_limit, path_distance, rule_path
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.contact_rule import all_rules
from nonsmooth.analysis.dynamics.ellipse_path import RELATIVE_TOLERANCE
from nonsmooth.analysis.dynamics.newton_euler import DynamicPath, disc, simulate_dynamics
from nonsmooth.analysis.fields.contact_model import ContactModel, contact_model
from nonsmooth.analysis.measurements.harness import Study
from nonsmooth.analysis.measurements.study_plan import Assessment, LeftOut, Order, StudyPlan, Trial
from nonsmooth.analysis.measurements.timing import Clock
from nonsmooth.analysis.trajectories.result import Trajectory, TrajectoryError
from nonsmooth.symbolic.scene import Scene

Pose = tuple[float, float, float]

MASSES = tuple(10.0**-k for k in (1, 2, 3, 4, 5))  # in units of R/u^2: R half the square, u the largest speed
START = (0.4, 0.8)  # in units of R, from the checked point
TIMES = 4.0  # in units of R/u
LIKE_MASS = Order(
    1.0, "velocity settles within a time like m; later where D is nearly flat (see the theory: full dynamics)"
)


def build_masses(scene: Scene) -> StudyPlan:
    """The plan, from one start in every scene's own units.

    Raises:
        LeftOut: where nothing drives the body, or rule ``ellipse`` has no path.
    """
    model, radius = contact_model(scene), float(scene.check.radius)
    speed = float(abs(model.speeds).max())
    if not speed:
        raise LeftOut("no wheel is driven")
    x, y = (float(at) + radius * share for at, share in zip(scene.check.equilibrium, START, strict=True))
    start, until, unit = (x, y, 0.0), TIMES * radius / speed, radius / speed**2
    try:
        limit = rule_path(scene, massless_limit(), start, until)
    except (RefusalError, TrajectoryError) as error:
        raise LeftOut(str(error)) from None
    judge = partial(_judge, limit, until)
    trials = [
        Trial("full dynamics", partial(_with_mass, model, mass * unit, start, until), judge, "mass", mass)
        for mass in MASSES
    ]
    trials += [
        Trial(f"rule {rule.name}", partial(_by_rule, scene, rule.name, start, until), judge)
        for rule in all_rules()
        if not rule.is_massless_limit
    ]
    reference = f"path of rule ellipse, {RELATIVE_TOLERANCE:g} per step, from ({x:g}, {y:g}) until t = {until:g}"
    return StudyPlan(reference, tuple(trials), {"full dynamics": LIKE_MASS}, rounding=RELATIVE_TOLERANCE * 100)


def _with_mass(model: ContactModel, mass: float, start: Pose, until: float, clock: Clock) -> DynamicPath:
    return simulate_dynamics(model, disc(model, mass), start, until)


def _by_rule(scene: Scene, rule: str, start: Pose, until: float, clock: Clock) -> Trajectory:
    return rule_path(scene, rule, start, until)


def _judge(limit: Trajectory, until: float, path: Any) -> Assessment:
    work = {"evaluations": path.evaluations} if isinstance(path, DynamicPath) else {}
    trajectory = path.trajectory if isinstance(path, DynamicPath) else path
    apart = path_distance(massless_limit(), trajectory, limit, until)
    return Assessment(apart.position, {"theta": apart.rotation}, work)


MASS = Study(
    "masses", "full dynamics as the mass goes to 0: distance from rule ellipse", "path distance [length]", build_masses
)
