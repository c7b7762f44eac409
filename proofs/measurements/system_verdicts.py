"""Verdicts on extreme plain systems: units of length and time change none, and evidence has to stand.

Rates of the two states in an extreme ratio are another system, for which no invariance holds: there the verdict (which
may be *undecided*) has to verify its own evidence.
"""

from __future__ import annotations

from fractions import Fraction

from nonsmooth.analysis.measurements.cases.friction_ratio import RATIOS
from nonsmooth.analysis.measurements.cases.scales import POWERS
from nonsmooth.analysis.measurements.harness import Case
from nonsmooth.analysis.measurements.rows import ResultRow, Rows, asserted
from nonsmooth.proofs.systems.system_stability import SystemResult, system_check
from nonsmooth.symbolic.similar_scenes import scaled_system, with_rate_ratio
from nonsmooth.symbolic.switched_system import SwitchedSystem

STATE, TIME, RATES = "state scale", "time scale", "ratio of rates"
SAME = "the verdict of the system in its own units, with evidence that verifies"


def system_verdict_rows(scene: SwitchedSystem) -> Rows:
    """Scales of state and time, then ratios of the two rates."""
    unit = system_check(scene)
    for power in POWERS:
        factor = Fraction(10) ** power
        yield _row(STATE, f"1e{power}", system_check(scaled_system(scene, length=factor)), unit)
    for power in POWERS:
        factor = Fraction(10) ** power
        yield _row(TIME, f"1e{power}", system_check(scaled_system(scene, speed=factor)), unit)
    for name, ratio in RATIOS.items():
        found = system_check(with_rate_ratio(scene, ratio))
        ok = found.check()
        error = 0.0 if ok else None
        yield asserted(RATES, name, str(found.verdict), "evidence that verifies", ok=ok, error=error)


def _row(case: str, parameter: str, found: SystemResult, unit: SystemResult) -> ResultRow:
    same = (found.verdict, found.method, found.equilibrium) == (unit.verdict, unit.method, unit.equilibrium)
    error = 0.0 if same else None
    return asserted(case, parameter, str(found.verdict), SAME, ok=same and found.check(), error=error)


SYSTEM_VERDICTS = Case("verdicts", system=system_verdict_rows)
