"""What there is to say where a body does not stand at the checked pose: that it tips, and why; there is no verdict."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from nonsmooth.proofs.answers.answer import Answer, Heading, Pose, Position
from nonsmooth.proofs.facts import said
from nonsmooth.proofs.verdicts import Theorem4
from nonsmooth.reports.answers import answers_record
from nonsmooth.reports.records import CHECK_SCHEMA
from nonsmooth.reports.result import Tabular
from nonsmooth.reports.short_text import short_lines

if TYPE_CHECKING:
    from nonsmooth.symbolic.contact_set import TipsError
    from nonsmooth.symbolic.scene import Scene

NOT_ASKED = "not asked: the body tips"


@dataclass(frozen=True, repr=False)
class TippedResult(Tabular):
    """The answer to a check of a body that tips.

    Attributes:
        scene: the array, with the body.
        tipping: which wheels are under the body, and why it does not stand on them.
    """

    scene: Scene
    tipping: TipsError

    @property
    def position(self) -> Answer:
        """That it tips."""
        return Answer("position", Position.TIPS, (said(f"a body with {self.tipping.why}"),))

    @property
    def heading(self) -> Answer:
        """Not asked."""
        return Answer("heading", Heading.UNDECIDED, (said(NOT_ASKED),))

    @property
    def pose(self) -> Answer:
        """Not asked."""
        return Answer("pose", Pose.UNDECIDED, (said(NOT_ASKED),))

    @property
    def theorem4(self) -> str:
        """Its hypotheses are not met."""
        return str(Theorem4.HYPOTHESES_NOT_MET)

    @staticmethod
    def exit_status(required: Sequence[str]) -> int:
        """1, whatever is required: the body is not where it should be."""
        del required
        return 1

    def to_dict(self) -> dict[str, Any]:
        """The JSON record of ``nonsmooth check --json``."""
        return {
            "schema": CHECK_SCHEMA,
            "scene": self.scene.name,
            "wheels": len(self.scene.wheels),
            "rule": self.scene.contact.rule,
            "contact_set": {"wheels": list(self.tipping.carrying), "margin": None},
            "answers": answers_record((self.position, self.heading, self.pose), None),
            "theorem4": {"verdict": self.theorem4, "reason": self.tipping.why},
        }

    def rows(self) -> list[dict[str, str]]:
        """One row for each question."""
        return [
            {"question": answer.name, "verdict": str(answer.verdict), "why": answer.sentence}
            for answer in (self.position, self.heading, self.pose)
        ]

    def __repr__(self) -> str:
        said = [(answer.name, repr(answer)) for answer in (self.position, self.heading, self.pose)]
        return short_lines(f"{self.scene.name}: {len(self.scene.wheels)} wheels, rule {self.scene.contact.rule}", said)
