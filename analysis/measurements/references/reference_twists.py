"""Exact and 60-digit minimizers of the dissipation at single points: references for the numerical ones.

Box: the twist of the exact cell that holds the point.  Ellipse: where no loaded wheel sticks, D is smooth and convex
around its minimizer, so Newton's method in balls (python-flint) from a float answer ends at the only stationary point;
its residual gradient says how many digits hold.  Points where a wheel sticks, or where the minimizer is not unique,
are left out: there D has a kink, and the twist is no number to compare with.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np
from flint import arb, arb_mat, ctx

from nonsmooth.analysis.cells.loads import load_regions, value_at
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.analysis.fields.contact_model import Floats, contact_model
from nonsmooth.analysis.measurements.references.ball_dissipation import Group, derivatives
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseInterior
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.analysis.minimizers.proved import proved
from nonsmooth.symbolic.constraints import scene_rows
from nonsmooth.symbolic.scene import Scene

Exact: TypeAlias = tuple[Any, Any, Any]  # numbers of the field, or balls

POINTS = 12  # at which the minimizers are compared
TRIED = 60  # points from which they are taken
DIGITS = 60
PRECISION = 400  # bits: 120 digits, of which the Hessian may cost half
RESIDUAL = arb(10) ** -(DIGITS + 10)  # of the gradient, which is a sum of weights of total one
NEWTON_STEPS = 12  # six double the digits of a float answer beyond the precision
STICKS = 1e-6  # a slip relative to the fastest wheel below which the wheel may stick


@dataclass(frozen=True)
class ReferenceTwist:
    """A point, read exactly from floats, and the minimizing twist there."""

    point: tuple[float, float]
    twist: Exact

    def error(self, found: Floats) -> float:
        """Largest difference of an entry: formed exactly or in balls, then rounded."""
        with ctx.workprec(PRECISION):
            return max(float(abs(exact - _like(exact, value))) for exact, value in zip(self.twist, found, strict=True))


def box_references(partition: Partition) -> tuple[ReferenceTwist, ...]:
    """The exact twists of rule ``box`` at points inside cells with one twist."""
    found = []
    for point in _points(partition.scene):
        x, y = (partition.scene.field(Fraction(value)) for value in point)
        cells = partition.cells_at((x, y))
        if len(cells) == 1 and len(cells[0].twists) == 1:
            found.append(ReferenceTwist(point, cells[0].twists[0]))
    return tuple(found[:POINTS])


def ellipse_references(scene: Scene) -> tuple[ReferenceTwist, ...]:
    """The twists of rule ``ellipse`` to 60 digits at points where every loaded wheel slips.

    Raises:
        nonsmooth.analysis.cells.loads.LoadError: where the loads do not exist.
    """
    model = contact_model(scene)
    points = list(_points(scene))
    loads = loads_at(model, points)
    minima = EllipseInterior().minimize(model, loads)
    twists = minima.twists
    slips = np.hypot(*np.moveaxis(model.slips(twists), -1, 0))
    smooth = ((slips > STICKS * np.abs(model.targets).max()) | (loads == 0)).all(axis=1)
    chosen = np.flatnonzero(smooth & proved(minima)).tolist()
    regions = load_regions(scene)
    found = []
    for k in chosen:
        x, y = (scene.field(Fraction(value)) for value in points[k])
        region = next(r for r in regions if r.polygon.contains((x, y)))
        with ctx.workprec(PRECISION):
            exact_loads = [value_at(form, (x, y)).ball() for form in region.forces]
            twist = _stationary(scene, exact_loads, twists[k])
        if twist is not None:
            found.append(ReferenceTwist(points[k], twist))
        if len(found) == POINTS:
            break
    return tuple(found)


def _points(scene: Scene) -> Iterator[tuple[float, float]]:
    rng = np.random.default_rng(0)
    centre, radius = [float(x) for x in scene.check.equilibrium], float(scene.check.radius)
    for shares in rng.integers(-255, 256, (TRIED, 2)) / 256:
        yield centre[0] + radius * float(shares[0]), centre[1] + radius * float(shares[1])


def _like(exact: Any, value: float) -> Any:
    """A float as an exact operand of a ball or of a field element."""
    return arb(float(value)) if isinstance(exact, arb) else Fraction(float(value))


def _stationary(scene: Scene, loads: list[arb], guess: Floats) -> Exact | None:
    """Newton's method on ``sum_i |w_i|``, ``w_i`` the two slips of wheel i weighted by its friction limits.

    None where D has no curvature in some direction, as without friction across the rims: it has a kink then.
    """
    groups = _weighted_rows(scene, loads)
    twist = arb_mat([[arb(float(value))] for value in guess])
    for _ in range(NEWTON_STEPS):
        gradient, hessian = derivatives(groups, twist)
        if all(abs(entry) < RESIDUAL for entry in gradient.entries()):
            return tuple(twist.entries())  # type: ignore[return-value]  # three entries
        try:
            step = hessian.solve(gradient)
        except ZeroDivisionError:
            return None
        twist = arb_mat([[(a - b).mid()] for a, b in zip(twist.entries(), step.entries(), strict=True)])
    raise ArithmeticError("required a stationary point of D near the float answer, received none")


def _weighted_rows(scene: Scene, loads: list[arb]) -> list[Group]:
    """For each loaded wheel the matrix A (2, 3) and the vector b (2, 1) of ``w = A xi - b``."""
    forms = []
    for wheel, carried, rows in zip(scene.wheels, loads, zip(*[iter(scene_rows(scene))] * 2, strict=True), strict=True):
        load = carried / wheel.grip_length.ball()
        weights = [load * mu.ball() for mu in (wheel.friction.roll, wheel.friction.side)]
        if carried > 0:
            matrix = [[w * entry.ball() for entry in row.normal] for w, row in zip(weights, rows, strict=True)]
            forms.append((arb_mat(matrix), arb_mat([[w * r.rhs.ball()] for w, r in zip(weights, rows, strict=True)])))
    return forms
