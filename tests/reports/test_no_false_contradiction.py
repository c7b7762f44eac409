"""A law that is certified near the point only promises nothing elsewhere: no path from there contradicts it."""

from __future__ import annotations

from fractions import Fraction

from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.proofs.clauses.feedback.by_rows import decide_feedback
from nonsmooth.reports.laws.feedback_loop import build_loop
from nonsmooth.reports.output.study_options import LawName
from nonsmooth.reports.simulations.paths import follow_cells
from nonsmooth.reports.simulations.simulate_options import SimulateOptions
from tests.conftest import Arrays, WheelData

FRICTION = (1, Fraction(1, 2))
# Theta first goes away from zero; the square leaves the support polygon, so no region is certified.
SHAPED = [WheelData((1, -2), (-1, 1)), WheelData((2, 1), (2, 2)), WheelData((-1, 2), (3, -2))]
START = (-0.036, 0.4987, -0.05)


def test_theta_may_rise_under_a_law_by_v_without_a_region(arrays: Arrays) -> None:
    partition = build_nearest_partition(arrays.scene(SHAPED, FRICTION, radius=Fraction(5, 2)))
    feedback = decide_feedback(partition)
    assert feedback.law is not None
    assert feedback.region is None
    assert feedback.cascade is None
    loop = build_loop(partition, LawName.CERTIFIED, Kinematics.EXACT, feedback)
    path = follow_cells(partition, SimulateOptions(start=START, feedback=True), loop)
    thetas = [abs(float(state[2])) for state in path.states]
    assert max(thetas) > thetas[0] + 0.01
    loop.refuse_contradiction(path)
