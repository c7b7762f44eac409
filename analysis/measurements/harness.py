"""The harness of all measurements: what is measured, against which reference, and a run over many of them.

A :class:`Measurement` is built for a scene and then yields row after row, so that a caller can show progress and keep
what is finished when it is interrupted.  There are two kinds: a :class:`Study` times methods at their settings
(work-precision diagrams: Hairer, Norsett & Wanner 1993, sec. II.10), and a :class:`Case` stresses a scene's results and
judges each by a criterion.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from typing import Any, TypeAlias, cast

from nonsmooth.analysis.measurements.rows import Outcome, ResultRow, Rows, asserted
from nonsmooth.analysis.measurements.study_plan import LeftOut, StudyPlan, Trial
from nonsmooth.analysis.measurements.timing import Limits, OutOfTime, timed
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.switched_system import SwitchedSystem

Progress: TypeAlias = Callable[[int, int, str], None]  # steps done, steps in all (0: not known), and what is done now
NO_PLAN, USUAL = StudyPlan(), Limits()
LONGEST_NOTE = 100  # characters of a solver's own message


def _silent(done: int, total: int, what: str) -> None:
    """Where nobody watches."""


class Measurement(ABC):
    """Something that is measured of a scene, row by row.

    A new one is one file that ends in a :class:`Study` or a :class:`Case`, and one line in
    :mod:`nonsmooth.proofs.measurements.registry`.  The commands, their files and figures then know it.
    """

    name: str

    def build(self, scene: Any) -> StudyPlan:
        """What is known before anything is measured; raises :class:`LeftOut` where the scene does not allow it."""
        return NO_PLAN

    @abstractmethod
    def rows(self, scene: Any, plan: StudyPlan = NO_PLAN, limits: Limits = USUAL, report: Progress = _silent) -> Rows:
        """Measure; a row is yielded as soon as it is finished."""


@dataclass(frozen=True)
class Study(Measurement):
    """A question that several methods answer, each with an error and a processor time.

    Once a setting of a method runs out of time the harder ones after it are not tried.  What methods raise that give
    up is an outcome, not a fault.

    Attributes:
        name: what the command line calls it.
        title: what is compared.
        quantity: the error with its unit.
        plan: the plan for a scene; raises :class:`LeftOut` where there is none.
    """

    name: str
    title: str
    quantity: str
    plan: Callable[[Any], StudyPlan]

    def build(self, scene: Any) -> StudyPlan:
        """The reference and the trials; nothing is timed yet."""
        return self.plan(scene)

    def rows(self, scene: Scene, plan: StudyPlan = NO_PLAN, limits: Limits = USUAL, report: Progress = _silent) -> Rows:
        """One row for each trial, in the order of the plan."""
        out_of_time: set[str] = set()
        for number, trial in enumerate(plan.trials):
            report(number, len(plan.trials), f"{self.name}: {trial.name}")
            if trial.method in out_of_time:
                yield self._without_result(trial, plan, Outcome.TIME_OUT, "not tried after a time-out")
                continue
            row = self.measure(trial, plan, limits)
            if row.outcome is Outcome.TIME_OUT:
                out_of_time.add(trial.method)
            yield row

    def measure(self, trial: Trial, plan: StudyPlan, limits: Limits) -> ResultRow:
        """Run a trial and judge its result."""
        try:
            result, seconds = timed(trial.work, limits)
        except OutOfTime:
            return self._without_result(trial, plan, Outcome.TIME_OUT, f"not done within {limits.seconds:g} s")
        except (RuntimeError, ValueError, ArithmeticError) as error:  # what methods raise that give up
            return self._without_result(trial, plan, Outcome.FAILED, _first_sentence(str(error)))
        found, row = trial.judge(result), self._row(trial, plan)
        known = replace(row, details=found.details, work=found.work, note=found.note)
        return replace(known, error=found.error, seconds=seconds / trial.repeats)

    def _without_result(self, trial: Trial, plan: StudyPlan, outcome: Outcome, note: str) -> ResultRow:
        return replace(self._row(trial, plan), outcome=outcome, ok=False, note=note)

    def _row(self, trial: Trial, plan: StudyPlan) -> ResultRow:
        labels = (self.name, trial.method, trial.parameter, trial.setting)
        return ResultRow(*labels, reference=plan.reference)


@dataclass(frozen=True)
class Case(Measurement):
    """A family of stiff or extreme cases, each row with a reference of its own, a criterion and its reason.

    Attributes:
        name: what the family is called where it runs, and where it raises.
        array: the rows of an array; None where the family is not about arrays.
        system: the rows of a plain system; None where the family is not about systems.
    """

    name: str
    array: Callable[[Scene], Rows] | None = None
    system: Callable[[SwitchedSystem], Rows] | None = None

    def rows(
        self,
        scene: Scene | SwitchedSystem,
        plan: StudyPlan = NO_PLAN,
        limits: Limits = USUAL,
        report: Progress = _silent,
    ) -> Rows:
        """The rows of a scene; whatever the family raises becomes a last row that is not ok."""
        family: Callable[[Any], Rows] | None = self.array if isinstance(scene, Scene) else self.system
        if family is None:
            return
        try:
            for number, row in enumerate(family(scene), 1):
                report(number, 0, f"{self.name}: {row.name}, {row.parameter}")
                yield row
        except Exception as fault:
            reason = f"{type(fault).__name__}: {' '.join(str(fault).split())}"
            yield asserted(self.name, "", Outcome.FAULT, reason, ok=False)


def _first_sentence(message: str) -> str:
    """What a method says of its failure, on one line."""
    sentence = message.partition("\n")[0].partition(". ")[0]
    return sentence if len(sentence) <= LONGEST_NOTE else f"{sentence[:LONGEST_NOTE]} ..."


@dataclass
class Measured:
    """A measurement with its finished rows; the plan is None where the scene does not allow it, for a reason."""

    of: Measurement
    plan: StudyPlan | None = None
    rows: list[ResultRow] = field(default_factory=list)
    left_out: str = ""


@dataclass(frozen=True)
class Run:
    """Measurements of one scene, in their order; ``complete`` is False where the work was interrupted."""

    scene: Any
    limits: Limits
    measured: tuple[Measured, ...]
    complete: bool

    @property
    def rows(self) -> list[ResultRow]:
        """The rows of all measurements."""
        return [row for measured in self.measured for row in measured.rows]

    @property
    def ok(self) -> bool:
        """Whether everything was tried and is as it should be."""
        return self.complete and all(row.ok for row in self.rows)


def measure(scene: Any, measurements: Iterable[Measurement], limits: Limits = USUAL, report: Progress = _silent) -> Run:
    """Measure one after the other; an interrupt keeps every finished row."""
    finished: list[Measured] = []
    for measurement in measurements:
        measured = Measured(measurement)
        try:
            report(0, 0, measurement.name)
            measured.plan = measurement.build(scene)
            for row in measurement.rows(scene, measured.plan, limits, report):
                measured.rows.append(row)  # one by one: an interrupt keeps them
        except LeftOut as reason:
            measured.left_out = str(reason)
        except KeyboardInterrupt:
            finished += [measured] if measured.rows else []
            return Run(scene, limits, tuple(finished), complete=False)
        finished.append(measured)
    return Run(scene, limits, tuple(finished), complete=True)


def study_of(measured: Measured) -> Study:
    """The study that was measured."""
    return cast("Study", measured.of)
