"""Many random edits: every view comes to its end, no worker is left over, and nothing is written to the log."""

from __future__ import annotations

from tests.random_edits import Hand
from tests.workbench_server import Workbench

EDITS = 80  # the benchmark makes 10,000


def test_random_edits_leave_nothing_behind(server: Workbench) -> None:
    hand = Hand(server, "four-wheel", seed=1)
    for _ in range(EDITS):
        hand.edit()
    assert hand.seen["exact"] > EDITS // 20
    assert hand.seen["error"] > EDITS // 200
    assert len(server.workers_left(3)) == 3
    assert "Traceback" not in server.log.read_text()
