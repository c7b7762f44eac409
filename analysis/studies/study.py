"""A study: methods at their settings, each with its error against a yardstick and its run time.

A study is first built (:class:`Plan`: the yardstick and a list of trials, nothing timed yet) and then measured trial by
trial, so that a caller can show progress and keep what is finished when it is interrupted.  Work-precision diagrams in
this manner: Hairer, Norsett & Wanner 1993, sec. II.10.

The time is the shortest of several runs, the one that other processes disturbed least.  The time limit is cooperative:
work looks at its clock wherever it loops, so a limit is overrun by at most one step of a loop.  Once a setting of a
method runs out of time the harder ones after it are not tried.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from nonsmooth.symbolic.scene import Scene

LONGEST_NOTE = 100  # characters of a solver's own message


class Outcome(StrEnum):
    """How a trial ended."""

    DONE = "done"
    TIME_OUT = "time-out"
    FAILED = "failed"


class OutOfTime(Exception):
    """A trial that reached its time limit."""


class LeftOut(Exception):
    """A study that a scene does not allow; the message says why."""


class Clock:
    """A time limit that work asks after.

    Args:
        seconds: the limit, from now.
    """

    def __init__(self, seconds: float) -> None:
        self._start, self._limit = time.perf_counter(), seconds

    @property
    def elapsed(self) -> float:
        """Seconds since the start."""
        return time.perf_counter() - self._start

    def check(self) -> None:
        """Raise :class:`OutOfTime` once the limit is reached."""
        if self.elapsed > self._limit:
            raise OutOfTime


@dataclass(frozen=True)
class Limits:
    """How long to measure.

    Attributes:
        runs: number of runs of which the shortest counts; fewer where they would not fit into the limit.
        seconds: time limit of one trial with all its runs.
    """

    runs: int = 3
    seconds: float = 5.0


@dataclass(frozen=True)
class Finding:
    """What a result is worth.

    Attributes:
        error: distance from the yardstick, in the study's quantity; 0 only where they are equal exactly.
        details: other errors by name.
        work: counts of what was done, by name.
        note: what else there is to say.
    """

    error: float
    details: Mapping[str, float] = field(default_factory=dict)
    work: Mapping[str, int] = field(default_factory=dict)
    note: str = ""


@dataclass(frozen=True)
class Trial:
    """One method at one setting.

    Attributes:
        method: name of the method.
        work: what is timed; it looks at the clock where it loops.
        judge: the error of its result; not timed.
        parameter: what the setting is called; None for a method without one.
        setting: value of the parameter.
        repeats: how often ``work`` does the same thing; the time is divided by it.
    """

    method: str
    work: Callable[[Clock], Any]
    judge: Callable[[Any], Finding]
    parameter: str | None = None
    setting: float | None = None
    repeats: int = 1

    @property
    def name(self) -> str:
        """For example ``hysteresis, width 0.001``."""
        return self.method if self.setting is None else f"{self.method}, {self.parameter} {self.setting:.3g}"


@dataclass(frozen=True)
class Order:
    """How a method's error depends on its setting.

    Attributes:
        expected: slope of log(error) over log(setting) that theory predicts; None where it predicts none.
        why: the reason, in one sentence.
    """

    expected: float | None
    why: str


@dataclass(frozen=True)
class Plan:
    """The trials of a study for one scene.

    Attributes:
        reference: the yardstick.
        trials: by method, settings from easy to hard.
        orders: what theory says of the methods that have a setting.
        note: what there is to say of the scene.
        rounding: errors below this are rounding, or beyond the digits of the yardstick, and tell no order.
    """

    reference: str
    trials: tuple[Trial, ...]
    orders: Mapping[str, Order] = field(default_factory=dict)
    note: str = ""
    rounding: float = 1e-13


@dataclass(frozen=True)
class Study:
    """A question that several methods answer.

    Attributes:
        name: what the command line calls it.
        title: what is compared.
        quantity: the error with its unit.
        build: the plan for a scene; raises :class:`LeftOut` where there is none.
    """

    name: str
    title: str
    quantity: str
    build: Callable[[Scene], Plan]


@dataclass(frozen=True)
class Row:
    """One measured trial: its error and time are None unless it is done."""

    study: str
    method: str
    parameter: str | None
    setting: float | None
    error: float | None
    seconds: float | None
    reference: str
    outcome: Outcome = Outcome.DONE
    details: Mapping[str, float] = field(default_factory=dict)
    work: Mapping[str, int] = field(default_factory=dict)
    note: str = ""


class Measurement:
    """The trials of one study, measured one by one in the order of its plan."""

    def __init__(self, study: Study, plan: Plan, limits: Limits) -> None:
        self.study, self.plan, self.limits = study, plan, limits
        self._out_of_time: dict[str, Trial] = {}

    def measure(self, trial: Trial) -> Row:
        """Run a trial and judge its result."""
        earlier = self._out_of_time.get(trial.method)
        if earlier is not None:
            return self._without_result(trial, Outcome.TIME_OUT, f"not tried: {earlier.name} ran out of time")
        try:
            result, seconds = self._timed(trial)
        except OutOfTime:
            self._out_of_time[trial.method] = trial
            return self._without_result(trial, Outcome.TIME_OUT, f"not done within {self.limits.seconds:g} s")
        except (RuntimeError, ValueError, ArithmeticError) as error:  # what methods raise that give up
            return self._without_result(trial, Outcome.FAILED, _first_sentence(str(error)))
        found = trial.judge(result)
        labels = (self.study.name, trial.method, trial.parameter, trial.setting)
        known = (found.details, found.work, found.note)
        return Row(*labels, found.error, seconds / trial.repeats, self.plan.reference, Outcome.DONE, *known)

    def _timed(self, trial: Trial) -> tuple[Any, float]:
        """The result of the first run, and the time of the shortest."""
        clock = Clock(self.limits.seconds)
        result = trial.work(clock)
        clock.check()
        best = clock.elapsed
        for _ in range(self.limits.runs - 1):
            if clock.elapsed + best > self.limits.seconds:
                break
            again = Clock(self.limits.seconds)
            trial.work(again)
            best = min(best, again.elapsed)
        return result, best

    def _without_result(self, trial: Trial, outcome: Outcome, note: str) -> Row:
        labels = (self.study.name, trial.method, trial.parameter, trial.setting)
        return Row(*labels, None, None, self.plan.reference, outcome, note=note)


def _first_sentence(message: str) -> str:
    """What a method says of its failure, on one line."""
    sentence = message.partition("\n")[0].partition(". ")[0]
    return sentence if len(sentence) <= LONGEST_NOTE else f"{sentence[:LONGEST_NOTE]} ..."
