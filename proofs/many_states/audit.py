"""Somebody else's V of a system in three states and more: valid, invalid with a witness, or undecided."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction

from nonsmooth.proofs.kernel.sign_cells import BeyondReachError
from nonsmooth.proofs.many_states.denominators import require_denominators
from nonsmooth.proofs.many_states.examination import RISES, FailurePoint, NotZeroError, examine
from nonsmooth.proofs.many_states.examined_lyapunov import ExaminedLyapunov
from nonsmooth.proofs.systems.derivatives import Decrease
from nonsmooth.proofs.systems.invariance import Staying
from nonsmooth.proofs.systems.lyapunov_audit import KEY, AuditVerdict
from nonsmooth.proofs.systems.stated_rise import NOT_OF_THE_FIELD, rising_place
from nonsmooth.proofs.verdicts import Translation
from nonsmooth.symbolic.enclosed_numbers import NoEnclosureError, enclose_numbers
from nonsmooth.symbolic.expression import ExpressionError
from nonsmooth.symbolic.files.system_file import parse_lyapunov
from nonsmooth.symbolic.notebook import ShortRepr, html_table
from nonsmooth.symbolic.piecewise import PiecewiseExpression
from nonsmooth.symbolic.scene_error import SceneError, requirement
from nonsmooth.symbolic.switched_system import SwitchedSystem

NOT_OF_THE_NUMBERS = (
    "V increases along fields with bounds of irrational numbers; along the field itself that is not shown"
)


@dataclass(frozen=True, repr=False)
class ManyStateAudit(ShortRepr):
    """Verdict on one V, on the checked cube.

    Attributes:
        scene: the system.
        lyapunov: V as it was written.
        verdict: whether it is a Lyapunov function.
        proves: what it shows of the equilibrium; None where it shows nothing.
        reason: one sentence for people.
        function: V with its conditions; None where the system or V is not looked at.
        witness: where V fails.
    """

    scene: SwitchedSystem
    lyapunov: str
    verdict: AuditVerdict
    proves: Translation | None
    reason: str
    function: ExaminedLyapunov | None
    witness: FailurePoint | None = None

    def _repr_html_(self) -> str:
        rows = [(self.lyapunov, self.verdict, self.proves or "nothing", self.reason)]
        return html_table(f"{self.scene.name}: audit of V", ("V", "verdict", "proves", "reason"), rows)

    def check(self) -> bool:
        """Verify the inequalities, that they are about V and the system, and what follows."""
        if self.function is None:
            return audit_many(self.scene, self.lyapunov) == self
        stated = parse_lyapunov(self.lyapunov, self.scene.states, self.scene.origin, KEY).text
        return (
            stated == self.function.formula.text
            and self.function.check(self.scene)
            and self == _result(self.scene, self.lyapunov, self.function)
        )


def audit_many(scene: SwitchedSystem, lyapunov: str) -> ManyStateAudit:
    """Check a V of a system in three states and more.

    Args:
        scene: the system.
        lyapunov: V in the displacement from the checked point, with the states' names.

    Raises:
        SceneError: for text that is no such formula.
    """
    require_denominators(scene)
    formula = parse_lyapunov(lyapunov, scene.states, scene.origin, KEY)
    if not all(scene.field.has_angle(turn) for turn in formula.turns()):
        raise SceneError(scene.origin, KEY, "angles that occur in the scene, or multiples of pi/12", lyapunov)
    with suppress(NoEnclosureError):
        scene = enclose_numbers(scene)
    try:
        found = ExaminedLyapunov(formula, scene.check.radius, examine(scene, formula, scene.check.radius))
    except BeyondReachError as error:
        verdict = AuditVerdict.INVALID if isinstance(error, NotZeroError) else AuditVerdict.UNDECIDED
        return ManyStateAudit(scene, lyapunov, verdict, None, str(error), None)
    except ExpressionError as error:
        raise SceneError(scene.origin, KEY, requirement(error), lyapunov) from None
    return _result(scene, lyapunov, found)


def _result(scene: SwitchedSystem, lyapunov: str, found: ExaminedLyapunov) -> ManyStateAudit:
    """The verdict that follows from the conditions."""
    examination = found.examination
    if found.attraction(scene) is not None:
        reason = f"{examination.reason}, and {Staying.NONE}"
        return ManyStateAudit(scene, lyapunov, AuditVerdict.VALID, Translation.ASYMPTOTICALLY_STABLE, reason, found)
    verdict, proves = {
        Decrease.STRICT: (AuditVerdict.VALID, Translation.ASYMPTOTICALLY_STABLE),
        Decrease.WEAK: (AuditVerdict.VALID, Translation.STABLE),
        Decrease.REFUTED: (AuditVerdict.INVALID, None),
        Decrease.UNDECIDED: (AuditVerdict.UNDECIDED, None),
    }[examination.verdict]
    reason, witness = examination.reason, examination.failure
    if witness is not None and scene.only_encloses:
        witness = _stated_failure(scene, found.formula, witness)
        if witness is None:
            verdict = AuditVerdict.UNDECIDED
            reason = NOT_OF_THE_NUMBERS if scene.encloses_numbers else NOT_OF_THE_FIELD
    return ManyStateAudit(scene, lyapunov, verdict, proves, reason, found, witness)


def _stated_failure(system: SwitchedSystem, formula: PiecewiseExpression, found: FailurePoint) -> FailurePoint | None:
    """What refutes V for the stated field, where right-hand sides only enclose it; None where nothing does."""
    if found.meaning != RISES:
        return found
    if system.encloses_numbers:
        return None
    place = rising_place(system, formula, found.point)
    rational = () if place is None else tuple(c.as_rational() for c in place)
    known = tuple(Fraction(int(c.p), int(c.q)) for c in rational if c is not None)
    return FailurePoint(known, None, RISES) if known and len(known) == len(rational) else None
