"""Measurements that compare verdicts, and the registry of all: the studies of ``precision``, the cases of ``stress``.

Pruning: the check of Theorem 4 that leaves out what no verdict needs against the one that leaves out nothing; the error
is the number of verdicts that differ: 0, always.  Extreme arrays: lengths and the place of the origin change no
verdict, and under rule ``nearest`` the frictions matter by their order only; beside that, exact numbers of the verdict
(largest ``V*/|c|``, drift) must be the same or scale as they should.  Extreme plain systems: units of length and time
change no verdict; for other ratios of their rates no invariance holds.  Every verdict verifies its evidence; where the
scene's own verdict has a certificate that the stand-alone checker accepts, with an arithmetic of its own, the others
must have one too.  Where the scene is refused, so are the others.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from functools import cache, partial
from typing import Any

from nonsmooth.analysis.bodies.mass_study import MASS
from nonsmooth.analysis.cells.filippov import RelativeRate
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.measurements.cases import (
    COLLINEAR,
    DETERMINANTS,
    FEEDBACK,
    FRICTION,
    LOADS,
    OFFSETS,
    POWERS,
    RATIOS,
    SCALES,
    STARTS,
    SWITCHES,
    nearly_in_line,
)
from nonsmooth.analysis.measurements.harness import Assessment, Case, Clock, ResultRow, Rows, Study, StudyPlan, Trial
from nonsmooth.analysis.measurements.path_studies import SYSTEM_PATHS, TRAJECTORIES
from nonsmooth.analysis.measurements.studies import BOX_MINIMIZERS, DERIVATION, ELLIPSE_MINIMIZERS, UPPER_DERIVATIVE
from nonsmooth.proofs.certificate import build_certificate
from nonsmooth.proofs.kernel.subject import NoCertificateError
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.proofs.theorem4 import CellCheck, Check, SmoothCheck, check_theorem4
from nonsmooth.symbolic.mechanics.contact_states import possible_triples
from nonsmooth.symbolic.mechanics.rule import CONTACT_RULES
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.mechanics.similar_scenes import moved, scaled, with_friction_ratio
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem, scaled_system, with_rate_ratio

# ---- pruning -------------------------------------------------------------------------------------

PRUNED, WHOLE = "pruned", "whole"


def build_pruning(scene: Scene) -> StudyPlan:
    """The plan for every contact rule; a rule that refuses the array fails, and says why."""
    trials = []
    for rule in CONTACT_RULES:
        ruled = scene.under(rule)
        judge = partial(_judge_pruning, cache(partial(_checked, ruled, False)))
        trials += [
            Trial(f"{rule}, {kind}", partial(_checked, ruled, prune), judge)
            for kind, prune in ((WHOLE, False), (PRUNED, True))
        ]
    return StudyPlan("the verdicts of the check that leaves out nothing", tuple(trials))


def _checked(scene: Scene, prune: bool, clock: Clock | None = None) -> Check:
    return check_theorem4(scene, prune=prune)


def verdicts(result: Check) -> tuple[str, ...]:
    """The theorem's verdict and those of its clauses."""
    return (result.verdict.value, *(result.verdict.value for _, result in result.clauses))


def _judge_pruning(whole: Callable[[], Check], check: Check) -> Assessment:
    work = {"row triples": possible_triples(len(check.scene.wheels))}
    if isinstance(check, CellCheck):
        partition = check.partition
        work |= {"wheels": partition.wheels_considered, "contact states": len(partition.states)}
        work["cells"] = len(partition.cells)
    work["left out"] = len(check.skipped)
    differing = sum(mine != theirs for mine, theirs in zip(verdicts(check), verdicts(whole()), strict=True))
    return Assessment(float(differing), work=work, note="; ".join(step.what for step in check.skipped))


PRUNING = Study(
    "pruning", "pruning: verdicts that differ from those of a whole check", "verdicts that differ", build_pruning
)

# ---- verdicts on extreme arrays ------------------------------------------------------------------


class ArrayVerdict:
    """The verdict on an array, or its refusal, with what is compared.

    Attributes:
        text: the verdict of the theorem.
        genuine: whether its evidence verifies.
        clauses: all verdicts, and whether the stand-alone checker accepts a certificate.
        worst: the largest ``V*/|c|``, a speed; None where it is not computed.
        drift: rates of rotation.
    """

    def __init__(self, scene: Scene) -> None:
        self.genuine = True
        self.clauses: tuple[str, ...] = ("refused",)
        self.worst: RelativeRate | None = None
        self.drift: tuple[Number, ...] = ()
        try:
            result = check_theorem4(scene, beside=False)
        except RefusalError as refusal:
            self.text = f"refused: {' '.join(str(refusal).split())[:60]}"
            return
        self.text, self.genuine = str(result.verdict), result.check()
        self.clauses = (*verdicts(result), "certified" if _is_certified(result) else "no certificate")
        if isinstance(result, CellCheck) and result.translation.lemma is None:
            self.worst = result.translation.worst
            self.drift = () if result.rotation.drift is None else result.rotation.drift.interval

    def row(
        self, case: str, parameter: str, other: ArrayVerdict, name: str, slower: Fraction = Fraction(1)
    ) -> ResultRow:
        """Compared with another verdict, whose rates of rotation are multiplied by a factor first."""
        apart = [_difference(rate, wanted * slower) for rate, wanted in zip(self.drift, other.drift, strict=False)]
        if (
            self.worst is not None
            and other.worst is not None
            and (self.worst < other.worst or other.worst < self.worst)
        ):
            apart.append(_difference(float(self.worst.value), float(other.worst.value)))
        alike = (self.worst is None) == (other.worst is None) and len(self.drift) == len(other.drift)
        error = max(apart, default=0.0)
        ok = self.genuine and self.clauses == other.clauses and alike and not error
        criterion = f"the same verdicts and exact numbers as {name}, with evidence that verifies"
        return ResultRow(case, parameter, self.text, error, ok, criterion)


def array_verdict_rows(scene: Scene) -> Rows:
    """Friction ratios (rule ``nearest``), then scales, offsets and wheels nearly in line under the scene's rule."""
    nearest = scene.under("nearest")
    plain = {side: ArrayVerdict(with_friction_ratio(nearest, Fraction(2) ** side)) for side in (-1, 0, 1)}
    for parameter, ratio in RATIOS.items():
        side = (ratio > 1) - (ratio < 1)
        changed = ArrayVerdict(with_friction_ratio(nearest, ratio))
        yield changed.row("friction ratio, rule nearest", parameter, plain[side], f"mu_S/mu_R = {2.0**side:g}")
    unit = ArrayVerdict(scene)
    for power in POWERS:
        factor = Fraction(10) ** power
        changed = ArrayVerdict(scaled(scene, factor))
        yield changed.row("geometry scale", f"1e{power}", unit, "the scene's own size", 1 / factor)
    for power in OFFSETS:
        changed = ArrayVerdict(moved(scene, Fraction(10) ** power, -(Fraction(10) ** power) / 3))
        yield changed.row("far from the origin", f"1e{power}", unit, "the scene in its place")
    for power in DETERMINANTS:
        changed = ArrayVerdict(nearly_in_line(scene, power))
        yield _evident("wheels nearly in line", f"1e-{power}", changed.text, changed.genuine)


def _evident(case: str, parameter: str, verdict: str, genuine: bool) -> ResultRow:
    """A verdict that nothing is compared with."""
    return ResultRow(case, parameter, verdict, 0.0 if genuine else None, genuine, "evidence that verifies")


def _is_certified(result: CellCheck | SmoothCheck) -> bool:
    """Whether there is a certificate that the stand-alone checker accepts."""
    try:
        build_certificate(result)
    except NoCertificateError:
        return False
    return True


def _difference(rate: Any, wanted: Any) -> float:
    """Relative; zero iff equal exactly (extreme scenes share the field of their scene)."""
    return 0.0 if rate == wanted else abs(float(rate) - float(wanted)) / (abs(float(wanted)) or 1.0)


ARRAY_VERDICTS = Case("verdicts", array=array_verdict_rows)

# ---- verdicts on extreme plain systems -----------------------------------------------------------


def system_verdict_rows(scene: SwitchedSystem) -> Rows:
    """Scales of state and time, then ratios of the two rates."""
    stated, criterion = decide_system(scene), "the verdict of the system in its own units, with evidence that verifies"
    for case, quantity in (("state scale", "length"), ("time scale", "speed")):
        for power in POWERS:
            changed = decide_system(scaled_system(scene, **{quantity: Fraction(10) ** power}))
            same = (changed.verdict, changed.method, changed.equilibrium) == (
                stated.verdict,
                stated.method,
                stated.equilibrium,
            )
            ok, error = same and changed.check(), 0.0 if same else None
            yield ResultRow(case, f"1e{power}", str(changed.verdict), error, ok, criterion)
    for parameter, ratio in RATIOS.items():
        changed = decide_system(with_rate_ratio(scene, ratio))
        yield _evident("ratio of rates", parameter, str(changed.verdict), changed.check())


SYSTEM_VERDICTS = Case("verdicts", system=system_verdict_rows)

# ---- the registry --------------------------------------------------------------------------------

STUDIES: tuple[Study, ...] = (
    TRAJECTORIES,
    UPPER_DERIVATIVE,
    BOX_MINIMIZERS,
    ELLIPSE_MINIMIZERS,
    DERIVATION,
    MASS,
    PRUNING,
)
SYSTEM_STUDIES: tuple[Study, ...] = (SYSTEM_PATHS,)  # of plain systems
CASES: tuple[Case, ...] = (
    ARRAY_VERDICTS,
    SYSTEM_VERDICTS,
    FRICTION,
    LOADS,
    COLLINEAR,
    SCALES,
    STARTS,
    SWITCHES,
    FEEDBACK,
)
