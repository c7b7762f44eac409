"""Paths in other units and far from the origin: lengths and speeds from 1e-9 to 1e9, arrays moved by up to 1e9.

A scaled field has scaled paths, so the error in half-widths must not depend on the scale.  A field moved away loses
the digits that its coordinates share: the condition is the distance in half-widths.
"""

from __future__ import annotations

from fractions import Fraction

from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.measurements.cases.followed_field import (
    START,
    FollowedField,
    cells_of,
    followed_array,
    followed_system,
)
from nonsmooth.analysis.measurements.harness import Case
from nonsmooth.analysis.measurements.rows import EPSILON, ResultRow, Rows, judged, refused
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.similar_scenes import moved, scaled, scaled_system
from nonsmooth.symbolic.switched_system import SwitchedSystem

POWERS = (-9, -6, -3, 3, 6, 9)  # of ten
OFFSETS = (3, 6, 9)  # powers of ten, in units of length
ROUNDINGS = 64  # along a path


def array_scale_rows(scene: Scene) -> Rows:
    """An array in other units of length, and far from the origin; one refusal for all paths without cells."""
    cells = cells_of(scene)
    if isinstance(cells, RefusalError):
        yield refused("paths", f"rule {scene.contact.rule}", cells, expected=True)
        return
    for power in POWERS:
        yield _row("geometry scale, path", f"1e{power}", _array(scaled(scene, Fraction(10) ** power)))
    for power in OFFSETS:
        yield _row("far from the origin, path", f"1e{power}", _array(moved(scene, Fraction(10) ** power, Fraction(0))))


def system_scale_rows(scene: SwitchedSystem) -> Rows:
    """A plain system in other units of length and of time."""
    for power in POWERS:
        yield _row(
            "state scale, path", f"1e{power}", followed_system(scaled_system(scene, length=Fraction(10) ** power))
        )
    for power in POWERS:
        faster = scaled_system(scene, speed=Fraction(10) ** power)
        yield _row("time scale, path", f"1e{power}", followed_system(faster))


def _array(scene: Scene) -> FollowedField:
    return followed_array(build_partition(scene), Kinematics.LEADING)


def _row(case: str, parameter: str, followed: FollowedField) -> ResultRow:
    start = followed.place(*START)
    reached = followed.reference.reached(start, followed.span)
    until = reached.time
    path = simulate(followed.field, start, until)
    offset = max(abs(x) for x in followed.centre) / followed.radius + 1
    growth = offset * followed.amplification(start, until, max(followed.slack, 1e-7 * followed.radius))
    bound = 2 * growth * (ROUNDINGS * EPSILON + followed.slack / followed.radius / offset) + followed.step_error
    why = "rounding and slack times amplification"
    error = followed.distance(path.end.state, reached.state)
    return judged(case, parameter, str(path.end.reason), error, bound, condition=growth, why=why)


SCALES = Case("scales", array=array_scale_rows, system=system_scale_rows)
