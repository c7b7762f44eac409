"""Feedback of extreme gain: the closed loop of gain k is that of gain one in a time k times as short.

The gradient law is linear on every cell (leading-order kinematics), so its path is known at 60 digits over its first
crossings.  The corrected law is then followed over the same span of time whatever the gain: at high gain it is stiff,
the integrator turns implicit, and the pose must be where gain one takes it after k times as long.
"""

from __future__ import annotations

import numpy as np

from nonsmooth.analysis.cells.partition import Partition, RefusalError
from nonsmooth.analysis.fields.cellwise_field import feedback_field
from nonsmooth.analysis.fields.feedback_laws import corrected_law, gradient_law
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.measurements.cases.followed_field import cells_of
from nonsmooth.analysis.measurements.harness import Case
from nonsmooth.analysis.measurements.references.reference_fields import gradient_reference
from nonsmooth.analysis.measurements.rows import ResultRow, Rows, counted, judged, refused
from nonsmooth.analysis.trajectories.result import EndReason, Trajectory
from nonsmooth.analysis.trajectories.smooth_path import follow_smooth
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.symbolic.number_text import power_text
from nonsmooth.symbolic.scene import Scene

GRADIENT, CORRECTED = "feedback gain, gradient law", "feedback gain, corrected law"
GAINS = (1e-6, 1e-3, 1.0, 1e3, 1e6, 1e8)
UNTIL = 2.0  # the same for all gains
PLACE = (0.4171, 0.2443, 0.3)  # start in half-widths, and theta
COMPARISONS = 25  # moments
TURNS = 1.0  # duration in times 1/k over which the linear loop is compared
COMPARED = 6.0  # durations 1/k over which the corrected law is compared with gain one
MOST_EVENTS = 400  # after which a loop that keeps switching ends, as it says
ACCURACY = 1e-10  # relative to the start: a hundred steps of 1e-12


def feedback_rows(partition: Partition) -> Rows:
    """Both laws at every gain; one refusal where the rule leaves no two inputs."""
    try:
        slow = _corrected(partition, 1.0, COMPARED)
    except ValueError as refusal:
        yield refused(CORRECTED, "any", refusal, expected=True)
        return
    for gain in GAINS:
        yield _gradient_row(partition, gain)
        yield _corrected_row(partition, gain, slow)


def _start(partition: Partition) -> tuple[float, float, float]:
    (x, y), radius = partition.scene.check.equilibrium, float(partition.scene.check.radius)
    return float(x) + PLACE[0] * radius, float(y) + PLACE[1] * radius, PLACE[2]


def _size(partition: Partition) -> float:
    return max(abs(x) for x in _start(partition))


def _gradient_row(partition: Partition, gain: float) -> ResultRow:
    start = _start(partition)
    weight = partition.scene.check.length**2
    reference = gradient_reference(partition, gain, weight).reached(start, TURNS / gain)
    law = gradient_law(gain, weight=float(weight))
    path = simulate(feedback_field(partition, law, Kinematics.LEADING), start, reference.time)
    gaps = [abs(float(a) - b) for a, b in zip(path.end.state, reference.state, strict=True)]
    verdict = f"{counted(reference.crossings, 'crossing')}: {path.end.reason}"
    error = max(gaps) / _size(partition)
    return judged(GRADIENT, power_text(gain), verdict, error, ACCURACY, why="a hundred steps of the integrator")


def _corrected(partition: Partition, gain: float, until: float) -> Trajectory:
    law = corrected_law(gain, float(partition.scene.check.length))
    field = feedback_field(partition, law, Kinematics.EXACT)
    return follow_smooth(field, _start(partition), until, max_events=MOST_EVENTS)


def _corrected_row(partition: Partition, gain: float, slow: Trajectory) -> ResultRow:
    """Compared as long as both last; later the pose must not have grown."""
    path = _corrected(partition, gain, UNTIL)
    verdict = f"{counted(len(path.times), 'step')}, {path.method}: {path.end.reason}"
    common = np.linspace(0, min(float(slow.end.t), gain * float(path.end.t)), COMPARISONS)
    errors = np.abs(path.sample(common / gain) - slow.sample(common))
    error = float(errors.max())
    if path.end.reason is EndReason.TIME and slow.end.reason is EndReason.TIME and gain * UNTIL > COMPARED:
        x, y = (float(value) for value in partition.scene.check.equilibrium)
        last, before = (np.hypot(*(np.array(p.end.state[:2]) - (x, y))) + abs(p.end.state[2]) for p in (path, slow))
        error = max(error, float(last - before))
    return judged(
        CORRECTED, power_text(gain), verdict, error / _size(partition), ACCURACY, why="gain one, k times as long"
    )


def _array_rows(scene: Scene) -> Rows:
    cells = cells_of(scene.recentred())  # the laws lead to the origin, which is to be the checked point
    if isinstance(cells, RefusalError):
        yield refused("feedback gain", f"rule {scene.contact.rule}", cells, expected=True)
    else:
        yield from feedback_rows(cells)


FEEDBACK = Case("feedback", array=_array_rows)
