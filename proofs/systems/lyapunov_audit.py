"""Somebody else's Lyapunov function, checked exactly: valid, invalid with a witness, or undecided.

V is a formula in the displacement from the checked equilibrium; its decimals are exact, so a V that came out of a float
solver is judged as it was printed.  Valid means: V is zero at the equilibrium and positive elsewhere in the domain, and
does not increase along any Filippov solution there (:mod:`nonsmooth.proofs.systems.derivatives`).  The domain is the
checked square; for a plain system of cones it is the plane.  Wheel arrays move with the exact pose rate ``v + omega J
c``.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.cells.switched_cells import (
    FieldCell,
    LyapunovCell,
    lyapunov_cells,
    partition_cells,
    system_cells,
)
from nonsmooth.analysis.contact_rule import CellRule, rule_of
from nonsmooth.proofs.inequalities.strata import RISES, Refutation
from nonsmooth.proofs.systems.denominators import require_denominators
from nonsmooth.proofs.systems.derivatives import Decrease, LyapunovResult, examine, inhabited, refutations
from nonsmooth.proofs.systems.domain import Domain, domain_names, domains
from nonsmooth.proofs.systems.invariance import Staying, decide_staying
from nonsmooth.proofs.systems.stated_rise import NOT_OF_THE_FIELD, rising_place
from nonsmooth.proofs.verdicts import Translation
from nonsmooth.symbolic.files.system_file import parse_lyapunov
from nonsmooth.symbolic.notebook import ShortRepr, html_table
from nonsmooth.symbolic.numbers.lazy import evaluated
from nonsmooth.symbolic.piecewise import PiecewiseExpression
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.scene_error import SceneError
from nonsmooth.symbolic.switched_system import PLANE, SwitchedSystem, require_stated

KEY = "lyapunov"


class AuditVerdict(StrEnum):
    """Whether V is a Lyapunov function on the domain."""

    VALID = "valid"
    INVALID = "invalid"
    UNDECIDED = "undecided"

    @property
    def exit_status(self) -> int:
        """0 valid, 1 invalid, 3 undecided."""
        return {"valid": 0, "invalid": 1}.get(self.value, 3)


@dataclass(frozen=True, repr=False)
class AuditResult(ShortRepr):
    """Verdict on one V.

    Attributes:
        scene: the array or system.
        lyapunov: V as it was written.
        verdict: whether it is a Lyapunov function on the domain.
        proves: what it shows of the equilibrium; None where it shows nothing.
        reason: one sentence for people.
        witness: where it fails.
        result: all inequalities; None for a contact rule without cells.
    """

    scene: Scene | SwitchedSystem
    lyapunov: str
    verdict: AuditVerdict
    proves: Translation | None
    reason: str
    witness: Refutation | None
    result: LyapunovResult | None

    @property
    def domain_text(self) -> str:
        """Where V is looked at, in words: the checked square, or the plane."""
        if not isinstance(self.scene, SwitchedSystem):
            return Domain(self.scene.check.radius).text(PLANE)
        formula = parse_lyapunov(self.lyapunov, self.scene.states, self.scene.origin, KEY)
        return domain_names(self.scene, formula)[0].text(self.scene.states)

    def _repr_html_(self) -> str:
        rows = [(self.lyapunov, self.verdict, self.proves or "nothing", self.reason)]
        return html_table(f"{self.scene.name}: audit of V", ("V", "verdict", "proves", "reason"), rows)

    def check(self) -> bool:
        """Verify that the inequalities are about V on the system's cells, that they hold, and what follows."""
        if self.result is None:
            return self.verdict is AuditVerdict.UNDECIDED
        if any(cell.potential.field is not self.scene.field for cell in self.result.cells):
            return False
        cells = audited_cells(self.scene, self.lyapunov)
        about_them = cells is not None and self.result.cells == inhabited(cells)
        return about_them and self.result.check() and self == _result(self.scene, self.lyapunov, self.result)


def audit(scene: Scene | SwitchedSystem, lyapunov: str) -> AuditResult:
    """Check a Lyapunov function.

    Args:
        scene: a wheel array (rule ``nearest`` or ``box``) or a plain system.
        lyapunov: V in (x, y), or in the system's states; ``sign`` and ``Abs`` are allowed, max(a, b) is
            ``(a + b + Abs(a - b))/2``.

    Raises:
        SceneError: for text that is no such formula.
    """
    cells = audited_cells(scene, lyapunov)
    return _result(scene, lyapunov, None if cells is None else examine(cells))


def audited_cells(scene: Scene | SwitchedSystem, lyapunov: str) -> tuple[LyapunovCell, ...] | None:
    """The domain, cut until the field and V are smooth; None for a rule without cells.

    Raises:
        SceneError: for text that is no formula of the states over the scene's field.
    """
    file = scene.origin
    states = scene.states if isinstance(scene, SwitchedSystem) else PLANE
    formula = parse_lyapunov(lyapunov, states, file, KEY)
    if not all(scene.field.has_angle(turn) for turn in formula.turns()):
        raise SceneError(file, KEY, "angles that occur in the scene, or multiples of pi/12", lyapunov)
    cells = _field_cells(scene, formula)
    return None if cells is None else lyapunov_cells(cells, formula, states, file, KEY)


def _field_cells(scene: Scene | SwitchedSystem, lyapunov: PiecewiseExpression) -> tuple[FieldCell, ...] | None:
    if isinstance(scene, SwitchedSystem):
        require_stated(scene)
        require_denominators(scene)
        return system_cells(scene, domains(scene, lyapunov)[0])
    if not isinstance(rule_of(scene), CellRule):
        return None
    return partition_cells(build_partition(scene.recentred()))


def _result(scene: Scene | SwitchedSystem, lyapunov: str, result: LyapunovResult | None) -> AuditResult:
    """The verdict that follows from the inequalities."""
    if result is None:
        rule = scene.contact.rule if isinstance(scene, Scene) else None
        reason = f'rule "{rule}" moves the array by a field without cells, which is not audited'
        return AuditResult(scene, lyapunov, AuditVerdict.UNDECIDED, None, reason, None, None)
    verdict, proves = {
        Decrease.STRICT: (AuditVerdict.VALID, Translation.ASYMPTOTICALLY_STABLE),
        Decrease.WEAK: (AuditVerdict.VALID, Translation.STABLE),
        Decrease.REFUTED: (AuditVerdict.INVALID, None),
        Decrease.UNDECIDED: (AuditVerdict.UNDECIDED, None),
    }[result.verdict]
    reason, witness = result.reason, result.witness
    if result.verdict is Decrease.REFUTED and isinstance(scene, SwitchedSystem) and scene.waves:
        witness = _stated_refutation(scene, lyapunov, result)
        reason = NOT_OF_THE_FIELD if witness is None else witness.meaning
        verdict = AuditVerdict.UNDECIDED if witness is None else verdict
    if result.verdict is Decrease.WEAK and isinstance(scene, SwitchedSystem):
        formula = parse_lyapunov(lyapunov, scene.states, scene.origin, KEY)
        staying = decide_staying(scene, formula, scene.check.radius, result.cells)
        reason = f"{reason}{', and' if staying is Staying.NONE else ';'} {staying}"
        proves = Translation.ASYMPTOTICALLY_STABLE if staying is Staying.NONE else proves
    return AuditResult(scene, lyapunov, verdict, proves, reason, _named(witness), result)


def _stated_refutation(system: SwitchedSystem, lyapunov: str, result: LyapunovResult) -> Refutation | None:
    """What refutes V for the stated field, where sines and cosines of states are enclosed; None where nothing does."""
    formula = parse_lyapunov(lyapunov, system.states, system.origin, KEY)
    for found in refutations(result.cells, result.definite, result.strata):
        if not found.is_of_rates:
            return found
        place = rising_place(system, formula, found.point)
        if place is not None:
            return Refutation((place[0], place[1]), None, RISES)
    return None


def _named(witness: Refutation | None) -> Refutation | None:
    """The witness with every late number carried out."""
    if witness is None:
        return None
    x, y, value = map(evaluated, (*witness.point, witness.value))
    return Refutation((x, y), value, witness.meaning)
