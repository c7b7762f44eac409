"""The harness of ``precision`` and ``stress``: what is measured, how it is timed and judged, and what comes out.

A :class:`Study` times methods at their settings against one reference (work-precision diagrams: Hairer, Norsett &
Wanner 1993, sec. II.10); a :class:`Case` yields results at extreme parameters, each judged by a criterion of its own.
Both come down to :class:`ResultRow`, one after the other, so that a caller can show progress and keep what is finished
when it is interrupted.  A new one is one object in :mod:`nonsmooth.analysis.measurements.studies` or
:mod:`nonsmooth.analysis.measurements.cases`, and one line in :mod:`nonsmooth.proofs.measurements`.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from statistics import linear_regression
from typing import Any, TypeAlias, TypeVar, cast

from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.scene_kind import SceneKind
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

EPSILON = 2.0**-52  # relative spacing of doubles
LONGEST_NOTE = 100  # characters of a solver's own message


# ---- rows ----------------------------------------------------------------------------------------


class Outcome(StrEnum):
    """How a result came about; a row of a stress case may also say it in words, such as a verdict."""

    DONE = "done"
    TIME_OUT = "time-out"
    FAILED = "failed"
    REFUSED = "refused"
    FAULT = "fault"


@dataclass(frozen=True)
class ResultRow:
    """One result beside its reference."""

    name: str  # the study, or what a stress case stresses
    parameter: str | None = None  # what is varied: the name of the setting in a study, its value as text in a case
    outcome: str = Outcome.DONE  # an outcome, a verdict, or the end of a path
    error: float | None = None  # 0 only where reference and result are equal exactly; None: nothing was computed
    ok: bool = True  # whether the criterion holds: for a study, that there is a result
    note: str = ""  # the criterion, the refusal, or what else there is to say
    condition: float | None = None  # by which rounding of the input is amplified; None: no system is solved
    method: str = ""  # what a study measures
    setting: float | None = None  # value of the parameter in a study
    seconds: float | None = None  # processor time of a study's method
    reference: str = ""  # what a study compares with
    details: Mapping[str, float] = field(default_factory=dict)  # other errors by name
    work: Mapping[str, int] = field(default_factory=dict)  # counts of what was done, by name


Rows: TypeAlias = Iterator[ResultRow]


def judged(
    case: str, parameter: str, outcome: str, error: float, bound: float, *, condition: float | None = None, why: str
) -> ResultRow:
    """A row that is ok iff its error is a number within a bound; ``why`` says where the bound comes from."""
    ok = math.isfinite(error) and error <= bound
    return ResultRow(case, parameter, outcome, error, ok, f"error <= {bound:.2g}: {why}", condition)


def refused(case: str, parameter: str, message: object, *, expected: bool) -> ResultRow:
    """A refusal; ok where the case asks for one."""
    return ResultRow(case, parameter, Outcome.REFUSED, ok=expected, note=" ".join(str(message).split()))


def counted(number: int, what: str) -> str:
    """``1 event``, ``2 events``, ``2 switches``."""
    plural = "es" if what.endswith("ch") else "s"
    return f"{number} {what}{'' if number == 1 else plural}"


# ---- time ----------------------------------------------------------------------------------------

REPEATED = 0.25  # share of the time limit that the runs of one trial may take together
BETWEEN = 0.01  # seconds between two looks at the processor time

Result = TypeVar("Result")


class TrialTimeout(Exception):
    """A trial that reached its time limit."""


class Clock:
    """A limit on processor time, from now, that work asks after wherever it loops.

    Nothing is interrupted from outside: the limit is overrun by at most one step of a loop, results are never
    half-made, and no signal, thread or second process is needed.  Processor time is what a method costs, whatever else
    the machine does meanwhile.
    """

    def __init__(self, seconds: float) -> None:
        self._start, self._limit = time.process_time(), seconds
        self._asked = time.perf_counter()

    @property
    def elapsed(self) -> float:
        """Seconds of processor time since the start."""
        return time.process_time() - self._start

    def check(self) -> None:
        """Raise :class:`TrialTimeout` once the limit is reached.

        Asking the system for processor time may take longer than a step does: within :data:`BETWEEN` it is not asked
        again.
        """
        now = time.perf_counter()
        if now - self._asked < min(BETWEEN, self._limit / 10):
            return
        self._asked = now
        if self.elapsed > self._limit:
            raise TrialTimeout


@dataclass(frozen=True)
class Limits:
    """How long to measure: the shortest of some runs counts, each within a limit in seconds.

    There are fewer runs where they would take more than :data:`REPEATED` of the limit: long runs are disturbed less.
    """

    runs: int = 3
    seconds: float = 5.0


USUAL = Limits()


def timed(work: Callable[[Clock], Result], limits: Limits) -> tuple[Result, float]:
    """The result of the first run, and the time of the shortest: the one that the machine disturbed least.

    Raises:
        TrialTimeout: where the first run takes longer than the limit.
    """
    clock = Clock(limits.seconds)
    result = work(clock)
    clock.check()
    best = clock.elapsed
    for _ in range(limits.runs - 1):
        if clock.elapsed + best > REPEATED * limits.seconds:
            break
        again = Clock(limits.seconds)
        work(again)
        best = min(best, again.elapsed)
    return result, best


# ---- studies -------------------------------------------------------------------------------------


class LeftOut(Exception):
    """A study that a scene does not allow; the message says why."""


@dataclass(frozen=True)
class Assessment:
    """What the result of a trial is worth: its error, and other errors, counts of work and remarks for its row."""

    error: float
    details: Mapping[str, float] = field(default_factory=dict)
    work: Mapping[str, int] = field(default_factory=dict)
    note: str = ""


@dataclass(frozen=True)
class Trial:
    """One method at one setting: work that is timed, and a judge of its result that is not."""

    method: str
    work: Callable[[Clock], Any]  # looks at the clock where it loops, and leaves it alone where it does not
    judge: Callable[[Any], Assessment]
    parameter: str | None = None  # what the setting is called; None for a method without one
    setting: float | None = None
    repeats: int = 1  # how often the work does the same thing; the time is divided by it

    @property
    def name(self) -> str:
        """For example ``hysteresis, width 0.001``."""
        return self.method if self.setting is None else f"{self.method}, {self.parameter} {self.setting:.3g}"


@dataclass(frozen=True)
class Order:
    """The slope of log(error) over log(setting) that theory predicts, None where it predicts none, and why."""

    expected: float | None
    why: str


@dataclass(frozen=True)
class StudyPlan:
    """What a study does for one scene."""

    reference: str = ""  # what results are compared with
    trials: tuple[Trial, ...] = ()  # by method, settings from easy to hard
    orders: Mapping[str, Order] = field(default_factory=dict)  # of the methods that have a setting
    note: str = ""  # what there is to say of the scene
    rounding: float = 1e-13  # errors below are rounding, or beyond the digits of the reference, and tell no order


@dataclass(frozen=True)
class Study:
    """A question that several methods answer, each with an error and a processor time."""

    name: str  # on the command line
    title: str  # what is compared
    quantity: str  # the error with its unit
    build: Callable[[Any], StudyPlan]  # the plan for a scene, in which nothing is timed yet; or raises LeftOut

    def rows(self, plan: StudyPlan, limits: Limits, report: Progress) -> Rows:
        """A row for each trial, in their order; once a setting of a method runs out of time, no harder one is tried."""
        out_of_time: set[str] = set()
        for number, trial in enumerate(plan.trials):
            report(number, len(plan.trials), f"{self.name}: {trial.name}")
            row = self.measure(trial, plan, limits, tried=trial.method not in out_of_time)
            if row.outcome is Outcome.TIME_OUT:
                out_of_time.add(trial.method)
            yield row

    def measure(self, trial: Trial, plan: StudyPlan, limits: Limits, *, tried: bool = True) -> ResultRow:
        """Run a trial and judge its result; what methods raise that give up is an outcome, not a fault."""
        row = ResultRow(
            self.name, trial.parameter, method=trial.method, setting=trial.setting, reference=plan.reference
        )
        if not tried:
            return replace(row, outcome=Outcome.TIME_OUT, ok=False, note="not tried after a time-out")
        try:
            result, seconds = timed(trial.work, limits)
        except TrialTimeout:
            return replace(row, outcome=Outcome.TIME_OUT, ok=False, note=f"not done within {limits.seconds:g} s")
        except (RuntimeError, ValueError, ArithmeticError) as error:
            return replace(row, outcome=Outcome.FAILED, ok=False, note=_first_sentence(str(error)))
        found = trial.judge(result)
        known = replace(row, details=found.details, work=found.work, note=found.note)
        return replace(known, error=found.error, seconds=seconds / trial.repeats)


def _first_sentence(message: str) -> str:
    """What a method says of its failure, on one line."""
    sentence = message.partition("\n")[0].partition(". ")[0]
    return sentence if len(sentence) <= LONGEST_NOTE else f"{sentence[:LONGEST_NOTE]} ..."


# ---- cases ---------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Case:
    """A family of stiff or extreme cases, each row with a reference of its own, a criterion and its reason.

    It has rows of arrays, of plain systems, or of both; a family that raises ends in a row that is not ok.
    """

    name: str
    array: Callable[[Scene], Rows] | None = None
    system: Callable[[SwitchedSystem], Rows] | None = None

    def rows(self, scene: Scene | SwitchedSystem) -> Rows:
        """The rows of a scene, none where the family is not about such scenes."""
        family: Callable[[Any], Rows] | None = self.array if scene.kind is SceneKind.ARRAY else self.system
        if family is None:
            return
        try:
            yield from family(scene)
        except LeftOut as omitted:
            yield refused(self.name, "", omitted, expected=True)
        except Exception as fault:
            reason = f"{type(fault).__name__}: {' '.join(str(fault).split())}"
            yield ResultRow(self.name, "", Outcome.FAULT, ok=False, note=reason)


# ---- runs ----------------------------------------------------------------------------------------

Progress: TypeAlias = Callable[[int, int, str], None]  # steps done, steps in all (0: not known), and what is done now


def _silent(done: int, total: int, what: str) -> None:
    """Where nobody watches."""


@dataclass
class Measured:
    """A study or case with its finished rows; a study that the scene does not allow has no plan, for a reason."""

    of: Study | Case
    plan: StudyPlan | None = None
    rows: list[ResultRow] = field(default_factory=list)
    left_out: str = ""

    @property
    def study(self) -> Study:
        """The study that was measured."""
        return cast("Study", self.of)

    @property
    def slopes(self) -> list[FittedSlope]:
        """The slope of every method with a setting."""
        return [] if self.plan is None else fitted_slopes(self.plan, self.rows)


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


def measure(scene: Any, items: Iterable[Study | Case], limits: Limits = USUAL, report: Progress = _silent) -> Run:
    """Measure one after the other; an interrupt keeps every finished row."""
    finished: list[Measured] = []
    for item in items:
        measured = Measured(item)
        try:
            report(0, 0, item.name)
            for row in _rows(measured, scene, limits, report):
                measured.rows.append(row)  # one by one: an interrupt keeps them
        except LeftOut as reason:
            measured.left_out = str(reason)
        except KeyboardInterrupt:
            finished += [measured] if measured.rows else []
            return Run(scene, limits, tuple(finished), complete=False)
        finished.append(measured)
    return Run(scene, limits, tuple(finished), complete=True)


def _rows(measured: Measured, scene: Any, limits: Limits, report: Progress) -> Rows:
    if isinstance(measured.of, Study):
        measured.plan = measured.of.build(scene)
        yield from measured.of.rows(measured.plan, limits, report)
        return
    for number, row in enumerate(measured.of.rows(scene), 1):
        report(number, 0, f"{measured.of.name}: {row.name}, {row.parameter}")
        yield row


# ---- slopes --------------------------------------------------------------------------------------

FEWEST = 4  # settings: fewer make no line


@dataclass(frozen=True)
class FittedSlope:
    """A fitted slope beside the expected one; ``value`` is None where too few errors are above rounding."""

    method: str
    parameter: str
    order: Order
    value: float | None = None
    first: float | None = None
    last: float | None = None


def log_slope(settings: Sequence[float], errors: Sequence[float]) -> float:
    """Least-squares slope of log(error) over log(setting).

    Raises:
        ValueError: for fewer than two different settings.
    """
    return linear_regression(list(map(math.log, settings)), list(map(math.log, errors))).slope


def fitted_slopes(plan: StudyPlan, rows: Sequence[ResultRow]) -> list[FittedSlope]:
    """The slope of every method of a plan that has a setting; errors at rounding level say nothing and are left out."""
    slopes = []
    for method, order in plan.orders.items():
        measured = [row for row in rows if row.method == method]
        parameter = next((row.parameter for row in measured if row.parameter), "setting")
        told = [(row.setting, row.error) for row in measured if row.setting and row.error and row.error > plan.rounding]
        slope = FittedSlope(method, parameter, order)
        if len(told) >= FEWEST:
            settings, errors = zip(*told, strict=True)
            slope = replace(slope, value=log_slope(settings, errors), first=settings[0], last=settings[-1])
        slopes.append(slope)
    return slopes
