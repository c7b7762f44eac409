"""What a derivation report is about: the scene, its check, and what several sections need, computed once."""

from __future__ import annotations

import shlex
from dataclasses import dataclass
from functools import cached_property

from nonsmooth.analysis.minimizers.agreement import Agreement, compare_rules
from nonsmooth.proofs.answers.answers import Answers, full_answers
from nonsmooth.proofs.answers.contradictions import reconciled
from nonsmooth.proofs.clauses.workspace import Announce, unheard
from nonsmooth.proofs.theorem4 import check_theorem4
from nonsmooth.proofs.theorem4_result import CellCheck, Check
from nonsmooth.proofs.verified import verified
from nonsmooth.reports.console import PROGRAM
from nonsmooth.symbolic.scene import Scene


@dataclass(frozen=True)
class Invocation:
    """How the report was asked for, so that it can name the commands that reproduce it and its figures.

    Attributes:
        scene: name or file of the scene, as typed.
        options: those that change the scene (``--rule``, ``--radius``, ``--at``), with their values.
        rest: the other options of ``derive``.
    """

    scene: str
    options: tuple[str, ...] = ()
    rest: tuple[str, ...] = ()

    @property
    def derive(self) -> str:
        """The command that writes the report."""
        return shlex.join([PROGRAM, "derive", self.scene, *self.options, *self.rest])

    def line(self, command: str, *extra: str) -> str:
        """Another command about the same scene."""
        return shlex.join([PROGRAM, command, self.scene, *self.options, *extra])


@dataclass(frozen=True, eq=False)
class Subject:
    """A scene, how it was asked for, and lazily what the sections share.

    Attributes:
        scene: the array.
        invocation: how the report was asked for.
        parts: names of the sections that are written.
        announce: hears the steps of the check.
    """

    scene: Scene
    invocation: Invocation
    parts: tuple[str, ...]
    announce: Announce = unheard

    @cached_property
    def _checked(self) -> tuple[Check, Answers]:
        """The check, its evidence verified once more, with the answers; compared with each other."""
        result = check_theorem4(self.scene, announce=self.announce)
        self.announce("verification of the evidence")
        result = verified(result)
        return reconciled(result, full_answers(result))

    @property
    def result(self) -> Check:
        """The check."""
        return self._checked[0]

    @property
    def answers(self) -> Answers:
        """Position, heading and pose, where bodies go, and what the other rules say."""
        return self._checked[1]

    @property
    def cells(self) -> CellCheck:
        """The check of a rule with cells.

        Raises:
            TypeError: under rule ``ellipse``, which has none; a part that needs cells says so first.
        """
        if not isinstance(self.result, CellCheck):
            raise TypeError(f"required a check with cells, received rule {self.scene.contact.rule}")
        return self.result

    @cached_property
    def agreement(self) -> Agreement:
        """The contact rules side by side."""
        return compare_rules(self.scene)
