"""Elastic loads where some of them go to zero: centres of mass that approach the edge of the support polygon.

The float loads are compared with exact ones at the same float point.  The condition is that of the moments of the
loaded wheels, ``(1, p_i)`` with lengths in units of the array: how far the loads move with the centre of mass.
Beyond the edge the body tips, and loads must be refused.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from nonsmooth.analysis.cells.loads import LoadError, elastic_loads_at
from nonsmooth.analysis.fields.contact_model import ContactModel, Floats, contact_model
from nonsmooth.analysis.measurements.harness import Case
from nonsmooth.analysis.measurements.rows import EPSILON, ResultRow, Rows, asserted, judged, refused
from nonsmooth.analysis.minimizers.float_loads import RESIDUAL, elastic_loads
from nonsmooth.symbolic.number_text import power_text
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.similar_scenes import scaled
from nonsmooth.symbolic.support_polygon import support_polygon

EDGE, SCALE = "loads at the support edge", "loads, geometry scale"
DEPTHS = (1e-1, 1e-3, 1e-6, 1e-9, 1e-12)  # shares of the way from the edge to the middle of the wheels
BEYOND = (1e-9, 1e-3)  # shares of that way outside
SCALES = (-9, -6, -3, 3, 6, 9)  # powers of ten
ALONG = 0.3719  # share of the edge: a place of no symmetry
ROUNDINGS = 16  # of a sum of loads


def support_rows(scene: Scene) -> Rows:
    """Loads towards the longest edge and beyond it; a refusal for wheels on one line."""
    hull = support_polygon([wheel.position for wheel in scene.wheels])
    model = contact_model(scene)
    if len(hull) < 3:
        try:
            elastic_loads(model, model.positions.mean(axis=0))
        except LoadError as refusal:
            yield refused(EDGE, "wheels on one line", refusal, expected=True)
        return
    edge, inward = _longest_edge(np.array([[float(x) for x in corner] for corner in hull]), model)
    for depth in DEPTHS:
        yield _row(EDGE, power_text(depth), scene, model, edge + depth * inward)
    for depth in BEYOND:
        parameter = f"{power_text(depth)} outside"
        try:
            loads = elastic_loads(model, edge - depth * inward)
        except LoadError as refusal:
            yield refused(EDGE, parameter, refusal, expected=True)
        else:
            yield asserted(EDGE, parameter, f"loads {loads[0]}", "required a refusal", ok=False)


def scale_rows(scene: Scene) -> Rows:
    """The same loads in other units of length."""
    if len(support_polygon([wheel.position for wheel in scene.wheels])) < 3:
        return
    for power in SCALES:
        larger = scaled(scene, Fraction(10) ** power)
        model = contact_model(larger)
        middle = model.positions.mean(axis=0)
        point = middle + 0.2171 * (model.positions[0] - middle) + 0.1443 * (model.positions[1] - middle)
        yield _row(SCALE, f"1e{power}", larger, model, point)


def _longest_edge(hull: Floats, model: ContactModel) -> tuple[Floats, Floats]:
    """A point of the longest edge, and the way from there to the middle of the wheels."""
    following = np.roll(hull, -1, axis=0)
    k = int(np.argmax(np.hypot(*(following - hull).T)))
    point = hull[k] + ALONG * (following[k] - hull[k])
    return point, model.positions.mean(axis=0) - point


def _row(case: str, parameter: str, scene: Scene, model: ContactModel, point: Floats) -> ResultRow:
    x, y = (scene.field(Fraction(float(value))) for value in point)
    try:
        truth = elastic_loads_at(scene, (x, y))
    except LoadError as refusal:  # rounding has put the point outside
        return refused(case, parameter, refusal, expected=False)
    loads = elastic_loads(model, point)[0]
    error = max(abs(float(exact - Fraction(float(load)))) for exact, load in zip(truth, loads, strict=True))
    condition = _condition(model, loads)
    verdict = f"{int((loads > 0).sum())} wheels loaded, smallest load {loads[loads > 0].min():.2g}"
    bound = RESIDUAL + ROUNDINGS * EPSILON * condition
    return judged(case, parameter, verdict, error, bound, condition=condition, why="stated residual, rounding")


def _condition(model: ContactModel, loads: Floats) -> float:
    """Of the moments of the loaded wheels."""
    middle = model.positions.mean(axis=0)
    arms = (model.positions - middle) / np.abs(model.positions - middle).max()
    moments = np.column_stack([np.ones(len(arms)), arms])[loads > 0]
    return float(np.linalg.cond(moments)) if len(moments) > 2 else 1.0


def _array_rows(scene: Scene) -> Rows:
    yield from support_rows(scene)
    yield from scale_rows(scene)


LOADS = Case("loads", array=_array_rows)
