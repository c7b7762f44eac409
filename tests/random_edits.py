"""Random edits of a scene, as a hand on the page would make them."""

from __future__ import annotations

import copy
import random
from typing import Any

from tests.workbench_server import Workbench

KINDS = ("drag", "drag", "drag", "turn", "slide", "rule", "exact", "starts", "nonsense")
RULES = (*["nearest"] * 6, "ellipse", "box")
MOST = 6  # wheels
LEFT = 0.85  # of the views
FAULT = "fault of the program"
OPERATIONS: tuple[dict[str, Any], ...] = (
    {"kind": "add", "position": [0.3, 0.2]},
    {"kind": "mirror", "axis": "x"},
    {"kind": "mirror", "axis": "y", "wheels": [1]},
    {"kind": "rotate", "angle": "15 deg"},
    {"kind": "snap", "step": "1/4"},
    {"kind": "copy", "wheels": [1], "offset": [0.35, 0.1]},
    {"kind": "delete", "wheels": [1]},
    {"kind": "expand"},
)


class Hand:
    """Edits a scene over and over; what cannot be used is seen to be refused, and taken back."""

    def __init__(self, server: Workbench, name: str, seed: int) -> None:
        self.server, self.random = server, random.Random(seed)
        self.first = self.document = server.document(name)
        self.tab, self.sequence = f"hand-{seed}", 0
        self.seen: dict[str, int] = {}

    def edit(self) -> None:
        """One edit, and the view of what comes of it; most views are left for the next one, as in a drag."""
        kept, kind = self.document, self.random.choice(KINDS)
        self.document = copy.deepcopy(kept)
        getattr(self, f"_{kind}")()
        self.sequence += 1
        starts = [[self.random.uniform(-0.4, 0.4), self.random.uniform(-0.4, 0.4), 0.0]]
        more: dict[str, Any] = {"starts": starts} if kind == "starts" else {}
        is_left = self.random.random() < LEFT
        names = self._look(is_left, {"want": ["paths"], **more})
        for name in names:
            self.seen[name] = self.seen.get(name, 0) + 1
        if "error" in names:
            self.document = kept
        elif len(self.document["wheel"]) > MOST:
            self.document = self.first

    def _look(self, is_left: bool, more: dict[str, Any]) -> list[str]:
        """The stages of the view of the document, or the first of them."""
        with self.server.stream(self.document, tab=self.tab, sequence=self.sequence, **more) as lines:
            stages = [next(lines)] if is_left else list(lines)
        names = [stage["stage"] for stage in stages]
        assert is_left or names[-1] == "done"
        assert {stage["sequence"] for stage in stages} == {self.sequence}
        assert not any(FAULT in stage.get("message", "") for stage in stages), self.document
        return names

    def _wheel(self) -> dict[str, Any]:
        found: dict[str, Any] = self.random.choice(self.document["wheel"])
        return found

    def _drag(self) -> None:
        self._wheel()["position"] = [round(self.random.uniform(-1.5, 1.5), 2) for _ in "xy"]

    def _turn(self) -> None:
        self._wheel()["heading"] = self.random.choice(["inward", "outward", self.random.randrange(0, 360, 15)])

    def _slide(self) -> None:
        key = self.random.choice(["mu_roll", "mu_side"])
        self.document["friction"][key] = round(self.random.uniform(0, 2), 2)

    def _rule(self) -> None:
        self.document["contact"] = {"rule": self.random.choice(RULES)}

    def _starts(self) -> None:
        """Nothing of the scene changes."""

    def _exact(self) -> None:
        operation = self.random.choice(OPERATIONS)
        reply = self.server.ask("/api/edit", {"document": self.document, "operation": operation})
        assert reply.status in {200, 400}, reply
        if reply.status == 200:
            self.document = reply.json["document"]

    def _nonsense(self) -> None:
        self._wheel()["speed"] = self.random.choice(["9**9**9", "fast", "sqrt(-1)", [], None, "1/0"])
