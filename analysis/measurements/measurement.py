"""Measuring the trials of a study, one by one.

The time is processor time, the shortest of several runs: the one that the rest of the machine disturbed least.  Once a
setting of a method runs out of time the harder ones after it are not tried.  What methods raise that give up is an
outcome, not a fault.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from nonsmooth.analysis.measurements.clock import Clock, OutOfTime
from nonsmooth.analysis.measurements.study import Outcome, Plan, Row, Study, Trial

REPEATED = 0.25  # share of the time limit that the runs of one trial may take together
LONGEST_NOTE = 100  # characters of a solver's own message


@dataclass(frozen=True)
class Limits:
    """How long to measure.

    Attributes:
        runs: number of runs of which the shortest counts; fewer where they would take more than :data:`REPEATED` of
            the limit, since long runs are disturbed less.
        seconds: time limit of one run.
    """

    runs: int = 3
    seconds: float = 5.0


class Measurement:
    """The trials of one study, measured one by one in the order of its plan."""

    def __init__(self, study: Study, plan: Plan, limits: Limits) -> None:
        self.study, self.plan, self.limits = study, plan, limits
        self._out_of_time: set[str] = set()

    def measure(self, trial: Trial) -> Row:
        """Run a trial and judge its result."""
        if trial.method in self._out_of_time:
            return self._without_result(trial, Outcome.TIME_OUT, "not tried after a time-out")
        try:
            result, seconds = self._timed(trial)
        except OutOfTime:
            self._out_of_time.add(trial.method)
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
            if clock.elapsed + best > REPEATED * self.limits.seconds:
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
