"""What a derivation report is about: a scene, how it was asked for, and what several sections need, computed once."""

from __future__ import annotations

import shlex
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from nonsmooth.analysis.minimizers.agreement import Agreement, compare_rules
from nonsmooth.proofs.answers.answers import Answers, full_answers
from nonsmooth.proofs.answers.contradictions import reconciled
from nonsmooth.proofs.clauses.feedback.by_rows import FeedbackResult
from nonsmooth.proofs.clauses.workspace import Announce, unheard
from nonsmooth.proofs.findings import Record
from nonsmooth.proofs.theorem4 import CellCheck, Check, check_theorem4
from nonsmooth.reports.checks.answers import check_record, partition_record, states_record
from nonsmooth.reports.output.console import PROGRAM, own_version
from nonsmooth.reports.output.document import Section
from nonsmooth.symbolic.mechanics.scene import Scene

# ---- references ----------------------------------------------------------------------------------
#
# The works that a report rests on, and how to cite this program.


@dataclass(frozen=True)
class Reference:
    """One work."""

    authors: str
    title: str
    where: str

    @property
    def text(self) -> str:
        """As a list of references shows it."""
        return f"{self.authors}: {self.title}. {self.where}."


PAPER = Reference(
    "T. D. Murphey, J. W. Burdick",
    "On the Stability and Design of Distributed Manipulation Control Systems",
    "IEEE International Conference on Robotics and Automation, 2001",
)
FILIPPOV = Reference("A. F. Filippov", "Differential Equations with Discontinuous Righthand Sides", "Kluwer, 1988")
SHEVITZ_PADEN = Reference(
    "D. Shevitz, B. Paden",
    "Lyapunov stability theory of nonsmooth systems",
    "IEEE Transactions on Automatic Control 39, 1994",
)
BACCIOTTI_CERAGIOLI = Reference(
    "A. Bacciotti, F. Ceragioli",
    "Stability and stabilization of discontinuous systems and nonsmooth Lyapunov functions",
    "ESAIM: Control, Optimisation and Calculus of Variations 4, 1999",
)
BROCKETT = Reference(
    "R. W. Brockett",
    "Asymptotic stability and feedback stabilization",
    "In: Differential Geometric Control Theory, Birkhäuser, 1983",
)
RYAN = Reference(
    "E. P. Ryan",
    "On Brockett's condition for smooth stabilizability and its necessity in a context of nonsmooth feedback",
    "SIAM Journal on Control and Optimization 32, 1994",
)
JURDJEVIC_QUINN = Reference(
    "V. Jurdjevic, J. P. Quinn", "Controllability and stability", "Journal of Differential Equations 28, 1978"
)
HOMOGENEITY = Reference(
    "E. Bernuau, D. Efimov, W. Perruquetti, A. Polyakov",
    "On homogeneity and its application in sliding mode control",
    "Journal of the Franklin Institute 351, 2014",
)


def how_to_cite() -> str:
    """BibTeX of this program and of the paper whose method it implements."""
    return f"""@software{{nonsmooth,
  title   = {{nonsmooth: a nonsmooth stability analysis workbench}},
  author  = {{{{The nonsmooth developers}}}},
  version = {{{own_version()}}},
  license = {{Apache-2.0}}
}}
@inproceedings{{MurpheyBurdick2001,
  author    = {{Murphey, Todd D. and Burdick, Joel W.}},
  title     = {{On the Stability and Design of Distributed Manipulation
               Control Systems}},
  booktitle = {{IEEE International Conference on Robotics and Automation}},
  year      = {{2001}}
}}"""


# ---- the subject of a report ---------------------------------------------------------------------


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
class ReportSubject(ABC):
    """A scene, how it was asked for, and lazily what the sections share.

    Attributes:
        scene: what is reported.
        invocation: how the report was asked for.
        parts: names of the sections that are written.
        announce: hears the steps of the check and the names of the sections.
    """

    scene: Any
    invocation: Invocation
    parts: tuple[str, ...]
    announce: Announce = unheard

    @property
    @abstractmethod
    def result(self) -> Any:
        """The verdict with its evidence."""

    @property
    @abstractmethod
    def headline(self) -> str:
        """The verdict in a line."""

    @property
    @abstractmethod
    def records(self) -> Record:
        """The exact records of what is reported, for JSON."""

    @property
    @abstractmethod
    def left_out(self) -> Sequence[str]:
        """What was not computed, and why, in sentences."""

    @property
    @abstractmethod
    def works(self) -> list[Reference]:
        """What the verdict rests on."""


UNMISSED = "it is about other scenes"  # of sections that nobody looks for in a report


@dataclass(frozen=True)
class ReportPart:
    """A section under its name on the command line.

    Attributes:
        name: for ``--only`` and ``--without``.
        build: the section.
        lacks: why the subject has no such section, empty where it has; reports tell it unless it is :data:`UNMISSED`.
    """

    name: str
    build: Callable[[Any], Section]
    lacks: Callable[[Any], str] = lambda subject: ""


class ArraySubject(ReportSubject):
    """An array of wheels."""

    scene: Scene

    @cached_property
    def _checked(self) -> tuple[Check, Answers]:
        """The check with the answers, compared with each other."""
        result = check_theorem4(self.scene, announce=self.announce)
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
    def headline(self) -> str:
        """The verdict of Theorem 4."""
        return f"Theorem 4: {self.result.verdict}"

    @property
    def cells(self) -> CellCheck:
        """The check of a rule with cells.

        Raises:
            TypeError: under rule ``ellipse``, which has none; a section that needs cells says so first.
        """
        if not isinstance(self.result, CellCheck):
            raise TypeError(f"required a check with cells, received rule {self.scene.contact.rule}")
        return self.result

    @cached_property
    def agreement(self) -> Agreement:
        """The contact rules side by side."""
        return compare_rules(self.scene)

    @property
    def records(self) -> Record:
        """The check, its cells and its contact states."""
        result = self.result
        check = {key: value for key, value in check_record(result, self.answers).items() if key != "seconds"}
        records: Record = {"check": check, "partition": None, "contact_states": None}
        if isinstance(result, CellCheck):
            records["partition"] = partition_record(result.partition)
            records["contact_states"] = states_record(result.partition)
        return records

    @property
    def left_out(self) -> list[str]:
        """The contact states without equations, and what no verdict needs."""
        result = self.result
        said = [f"{skipped.what} ({skipped.count}): {skipped.why}." for skipped in result.skipped]
        if isinstance(result, CellCheck):
            count, possible = len(result.partition.states), result.census.possible
            words = f"Equations are written for the {count} contact states that own a cell, out of {possible}"
            said.insert(0, f"{words} row triples.")
        return said

    @property
    def works(self) -> list[Reference]:
        """The paper, Filippov, Shevitz and Paden, and those that clause 4 uses."""
        feedback = self.result.results["feedback"]
        works = [PAPER, FILIPPOV, SHEVITZ_PADEN]
        if isinstance(feedback, FeedbackResult):
            works += [HOMOGENEITY] if feedback.cascade is not None else []
            works += [JURDJEVIC_QUINN] if feedback.has_lyapunov else []
        if getattr(feedback, "obstruction", None) is not None:
            works += [BROCKETT, RYAN]
        return works
