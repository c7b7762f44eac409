"""The minimizers of the dissipation at single points, against the exact or 60-digit twist.

A linear program ends at a vertex: its simplex answer is right to rounding or wrong altogether, whatever tolerance it
is given.  The explicit minimizer (box) looks its twist up in exact cells; the program's interior point (ellipse) ends
with Newton steps and reaches rounding.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from nonsmooth.analysis.cells.box import build_box_partition
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.fields.contact_model import ContactModel, Floats, contact_model
from nonsmooth.analysis.measurements.harness import Study
from nonsmooth.analysis.measurements.references.reference_twists import (
    DIGITS,
    ReferenceTwist,
    box_references,
    ellipse_references,
)
from nonsmooth.analysis.measurements.study_plan import Assessment, LeftOut, Order, StudyPlan, Trial
from nonsmooth.analysis.measurements.timing import Clock
from nonsmooth.analysis.minimizers.box_minimizers import MAX_WHEELS, BoxEnumeration, BoxHighs
from nonsmooth.analysis.minimizers.choice import Minimizer
from nonsmooth.analysis.minimizers.dissipation import Functional, dissipation
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseInterior
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.analysis.minimizers.point_location import PointLocator
from nonsmooth.symbolic.scene import Scene

Entrant = tuple[str, float | None, Minimizer]  # method, tolerance, minimizer

TOLERANCES = tuple(10.0**-k for k in (2, 4, 6, 8, 10))  # HiGHS accepts none below 1e-10
VERTEX = Order(None, "the simplex method ends at a vertex: right to rounding, whatever the tolerance")
DIFFERENCES = Order(None, "the tolerance bounds a differenced gradient, which holds no more than eight digits")
FEWEST = 4  # points: fewer are no comparison


def build_box(scene: Scene) -> StudyPlan:
    """The plan for rule ``box``, whatever the scene's own rule.

    Raises:
        LeftOut: where the loads do not exist in the square.
    """
    boxed = replace(scene, contact=replace(scene.contact, rule="box"))
    try:
        partition = build_box_partition(boxed)
    except RefusalError as error:
        raise LeftOut(str(error)) from None
    references = _enough(box_references(partition), "inside a cell with one twist")
    points, model = _points(references), contact_model(boxed)
    judge = partial(_judge, references)
    trials = [
        Trial("explicit cells, with building them", partial(_build_and_look_up, boxed, points), judge),
        Trial("explicit cells, built before", partial(_look_up, PointLocator(partition), points), judge),
    ]
    named: list[Entrant] = [("HiGHS", tolerance, BoxHighs(tolerance)) for tolerance in TOLERANCES]
    if model.wheels <= MAX_WHEELS:
        named.append(("enumeration", None, BoxEnumeration()))
    trials += _minimizing(named, model, references)
    return StudyPlan(f"exact twist of the cell at {len(points)} points", tuple(trials), {"HiGHS": VERTEX})


def build_ellipse(scene: Scene) -> StudyPlan:
    """The plan for rule ``ellipse``, whatever the scene's own rule.

    Raises:
        LeftOut: where the loads do not exist in the square, or a wheel sticks nearly everywhere.
    """
    try:
        references = _enough(ellipse_references(scene), "where every loaded wheel slips")
    except RefusalError as error:
        raise LeftOut(str(error)) from None
    points, model = _points(references), contact_model(scene)
    trials = _minimizing([("interior point", None, EllipseInterior())], model, references)
    judge = partial(_judge, references)
    trials += [Trial("BFGS", partial(_by_bfgs, model, points, t), judge, "tolerance", t) for t in TOLERANCES]
    reference = f"minimizer by Newton's method to {DIGITS} digits at {len(points)} points"
    return StudyPlan(reference, tuple(trials), {"BFGS": DIFFERENCES})


QUANTITY = "twist error [length/time, rad/time]"
BOX_MINIMIZERS = Study("minimizers-box", "minimizers of D, rule box: largest error of a twist", QUANTITY, build_box)
ELLIPSE_MINIMIZERS = Study(
    "minimizers-ellipse", "minimizers of D, rule ellipse: largest error of a twist", QUANTITY, build_ellipse
)


def _enough(references: tuple[ReferenceTwist, ...], where: str) -> tuple[ReferenceTwist, ...]:
    if len(references) < FEWEST:
        raise LeftOut(f"required {FEWEST} points {where}, received {len(references)}")
    return references


def _points(references: Sequence[ReferenceTwist]) -> Floats:
    return np.array([reference.point for reference in references])


def _minimizing(entrants: Iterable[Entrant], model: ContactModel, references: Sequence[ReferenceTwist]) -> list[Trial]:
    points, judge = _points(references), partial(_judge, references)
    trials = []
    for method, tolerance, minimizer in entrants:
        setting = () if tolerance is None else ("tolerance", tolerance)
        trials.append(Trial(method, partial(_minimized, minimizer, model, points), judge, *setting))
    return trials


# ---- methods -------------------------------------------------------------------------------------


def _minimized(minimizer: Minimizer, model: ContactModel, points: Floats, clock: Clock) -> Floats:
    return minimizer.minimize(model, loads_at(model, points)).twists


def _build_and_look_up(scene: Scene, points: Floats, clock: Clock) -> Floats:
    return PointLocator(build_box_partition(scene)).twists(points)


def _look_up(locator: PointLocator, points: Floats, clock: Clock) -> Floats:
    return locator.twists(points)


def _by_bfgs(model: ContactModel, points: Floats, tolerance: float, clock: Clock) -> Floats:
    """SciPy's BFGS with differenced gradients, from rest: what one writes down first."""
    from scipy.optimize import minimize

    def minimizer_at(load: Floats) -> Floats:
        def value(twist: Floats) -> float:
            clock.check()
            return float(dissipation(Functional.ELLIPSE, model, load, twist))

        return np.asarray(minimize(value, np.zeros(3), method="BFGS", options={"gtol": tolerance}).x)

    return np.array([minimizer_at(load) for load in loads_at(model, points)])


def _judge(references: Sequence[ReferenceTwist], found: Floats) -> Assessment:
    return Assessment(max(reference.error(twist) for reference, twist in zip(references, found, strict=True)))
