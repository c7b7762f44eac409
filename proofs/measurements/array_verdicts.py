"""Verdicts on extreme arrays: what invariance demands of them, and that their evidence stands.

Lengths and the place of the origin change no verdict, and under rule ``nearest`` the frictions matter by their order
only; beside that, exact numbers of the verdict (largest ``V*/|c|``, drift) must be the same or scale as they should.
Every verdict verifies its evidence; where the scene's own verdict has a certificate that the stand-alone checker
accepts, with an arithmetic of its own, the others must have one too.  Where the scene is refused, so are the others.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction

from nonsmooth.analysis.cells.filippov import RelativeRate
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.measurements.cases.friction_ratio import RATIOS
from nonsmooth.analysis.measurements.cases.near_collinear import DETERMINANTS, nearly_in_line
from nonsmooth.analysis.measurements.cases.scales import OFFSETS, POWERS
from nonsmooth.analysis.measurements.harness import Case
from nonsmooth.analysis.measurements.rows import ResultRow, Rows, asserted
from nonsmooth.proofs.certificate import CertificateError, build_certificate
from nonsmooth.proofs.theorem4 import check_theorem4
from nonsmooth.proofs.theorem4_result import CellCheck, SmoothCheck
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.similar_scenes import moved, scaled, with_friction_ratio

FRICTION, SCALE, FAR, IN_LINE = "friction ratio", "geometry scale", "far from the origin", "wheels nearly in line"
SAME = "the same verdicts and exact numbers as {}, with evidence that verifies"


class ArrayVerdict:
    """The verdict on an array, or its refusal, with what is compared."""

    def __init__(self, scene: Scene) -> None:
        self.genuine, self.clauses, self.worst, self.drift = True, (), None, ()
        try:
            result = check_theorem4(scene)
        except RefusalError as refusal:
            self.text = f"refused: {' '.join(str(refusal).split())[:60]}"
            self.clauses = ("refused",)
            return
        self.text = str(result.verdict)
        parts = (result.equilibrium, result.translation, result.rotation, result.feedback)
        self.clauses = (str(result.verdict), *(str(part.verdict) for part in parts))
        self.genuine = result.check()
        self.clauses += ("certified" if _is_certified(result) else "no certificate",)
        if isinstance(result, CellCheck) and result.translation.lemma is None:
            self.worst = result.translation.worst
            self.drift = () if result.rotation.drift is None else result.rotation.drift.interval

    clauses: tuple[str, ...]
    worst: RelativeRate | None  # the largest V*/|c|, a speed
    drift: tuple[Number, ...]  # rates of rotation

    def row(self, case: str, parameter: str, other: ArrayVerdict, factors: Sequence[Fraction], name: str) -> ResultRow:
        """Compared with another verdict, whose numbers are multiplied by factors first."""
        errors = [0.0]
        if self.worst is not None and other.worst is not None:
            errors.append(_rates_apart(self.worst, other.worst.scaled(factors[0])))
        for own, reference, factor in zip(self.drift, other.drift, factors[1:], strict=False):
            errors.append(_numbers_apart(own, reference * factor))
        error = max(errors)
        alike = (self.worst is None) == (other.worst is None) and len(self.drift) == len(other.drift)
        same = self.clauses == other.clauses and alike
        ok = self.genuine and same and not error
        return asserted(case, parameter, self.text, SAME.format(name), ok=ok, error=error)

    def alone(self, case: str, parameter: str) -> ResultRow:
        """Evidence that verifies; nothing to compare with."""
        error = 0.0 if self.genuine else None
        return asserted(case, parameter, self.text, "evidence that verifies", ok=self.genuine, error=error)


def array_verdict_rows(scene: Scene) -> Rows:
    """Friction ratios (rule ``nearest``), then scales, offsets and wheels nearly in line under the scene's rule."""
    nearest = replace(scene, contact=replace(scene.contact, rule="nearest"))
    plain = {side: ArrayVerdict(with_friction_ratio(nearest, Fraction(2) ** side)) for side in (-1, 0, 1)}
    for name, ratio in RATIOS.items():
        side = (ratio > 1) - (ratio < 1)
        found = ArrayVerdict(with_friction_ratio(nearest, ratio))
        yield found.row(FRICTION, name, plain[side], (Fraction(1),) * 3, f"mu_S/mu_R = {2.0**side:g}")
    unit = ArrayVerdict(scene)
    for power in POWERS:
        factor = Fraction(10) ** power
        factors = (Fraction(1), 1 / factor, 1 / factor)
        yield ArrayVerdict(scaled(scene, factor)).row(SCALE, f"1e{power}", unit, factors, "the scene's own size")
    for power in OFFSETS:
        away = ArrayVerdict(moved(scene, Fraction(10) ** power, -(Fraction(10) ** power) / 3))
        yield away.row(FAR, f"1e{power}", unit, (Fraction(1),) * 3, "the scene in its place")
    for power in DETERMINANTS:
        yield ArrayVerdict(nearly_in_line(scene, power)).alone(IN_LINE, f"1e-{power}")


def _is_certified(result: CellCheck | SmoothCheck) -> bool:
    """Whether there is a certificate that the stand-alone checker accepts."""
    try:
        build_certificate(result)
    except CertificateError:
        return False
    return True


def _rates_apart(own: RelativeRate, wanted: RelativeRate) -> float:
    """Zero iff equal exactly; compared without their roots, which may be out of reach."""
    return _difference(float(own.value), float(wanted.value)) if own < wanted or wanted < own else 0.0


def _numbers_apart(own: Number, wanted: Number) -> float:
    """Zero iff equal exactly (extreme scenes share the field of their scene)."""
    return 0.0 if own == wanted else _difference(float(own), float(wanted))


def _difference(own: float, wanted: float) -> float:
    return abs(own - wanted) / (abs(wanted) or 1.0)


ARRAY_VERDICTS = Case("verdicts", array=array_verdict_rows)
