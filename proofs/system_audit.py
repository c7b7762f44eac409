"""Somebody else's Lyapunov function, checked exactly: valid, invalid with a witness, or undecided.

V is a formula in the displacement from the checked equilibrium; its decimals are exact, so a V that came out of a float
solver is judged as it was printed.  Valid means: V is zero at the equilibrium and positive elsewhere in the domain, and
does not increase along any Filippov solution there (:mod:`nonsmooth.proofs.systems.derivatives` in two states,
:mod:`nonsmooth.proofs.many_states.examination` in others, and where the former leaves it open).  The domain is the
checked cube; for a plain system of cones in two states it is the plane.  Wheel arrays move with the exact pose rate
``v + omega J c``.

Where the right-hand sides only enclose the stated field (sines and cosines of states lie between polynomials,
:mod:`nonsmooth.symbolic.formulas.enclosed_functions`), what holds along all of these holds along the field; a point at
which V increases along one of them refutes nothing.  Then the derivative of V along the stated field is evaluated in
balls, inside cells at such a point or beside it: where a ball is positive, V increases along the solution through its
place.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from fractions import Fraction
from itertools import product
from typing import Any, TypeAlias

from flint import arb, ctx

from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.cells.contact_rule import has_cells
from nonsmooth.analysis.cells.switched_cells import LyapunovCell, lyapunov_cells, partition_cells
from nonsmooth.proofs.findings import Translation
from nonsmooth.proofs.kernel.cells import BeyondReachError, require_denominators
from nonsmooth.proofs.many_states import examination as many
from nonsmooth.proofs.many_states.examination import ExaminedLyapunov, NotZeroError
from nonsmooth.proofs.orbits.ball_steps import in_balls
from nonsmooth.proofs.sums_of_squares.prove import Effort
from nonsmooth.proofs.systems.derivatives import (
    RISES,
    Decrease,
    InvariantMotion,
    Refutation,
    decide_invariant_motion,
    examine,
    refutations,
)
from nonsmooth.proofs.systems.domain import Domain, domains, plane_cells
from nonsmooth.proofs.systems.findings import ExaminedFunction, PlaneFunction
from nonsmooth.symbolic.files.system_builder import parse_lyapunov
from nonsmooth.symbolic.files.system_document import with_parameters
from nonsmooth.symbolic.formulas.expression import formula_refused
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression, SignOf
from nonsmooth.symbolic.formulas.trees import ExpressionError
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.notebook import ShortRepr, html_table
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.messages.scene_kind import SceneKind
from nonsmooth.symbolic.numbers.coefficients import as_fraction
from nonsmooth.symbolic.numbers.lazy import evaluated
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.systems.switched_system import (
    PLANE,
    Enclosed,
    SwitchedSystem,
    require_stated,
    with_known_numbers,
)

BITS = 128
ASIDE = Fraction(1, 256)  # of the half-width: how far beside a point cells are looked into
MOST_STATES = 6  # up to which all sides of a point are looked at


NOT_OF_THE_FIELD = "V increases along polynomials between which sines lie; along the field itself that is not shown"


class _OnSurfaceError(Exception):
    """A place at which some formula switches."""


def rising_place(
    system: SwitchedSystem, lyapunov: PiecewiseExpression, point: Sequence[Any]
) -> tuple[Number, ...] | None:
    """A point or a place beside it at which V is shown to increase along the stated field; None shows nothing.

    Args:
        system: with sines or cosines of states.
        lyapunov: V in the displacement from the checked point, with the states' names.
        point: such a displacement, in the checked cube.
    """
    if not system.rewriting.named_rhs:
        return None
    with ctx.workprec(BITS):
        return next((tuple(p) for p in _places(system, point) if _rate_at(system, lyapunov, p) > 0), None)


def _places(system: SwitchedSystem, point: Sequence[Any]) -> Iterator[list[Number]]:
    """The point, and places of the cube on all sides of it."""
    centre = [system.field(evaluated(c)) for c in point]
    yield centre
    sides = product((1, -1), repeat=len(centre)) if len(centre) <= MOST_STATES else ()
    for side in sides:
        steps = [system.check.radius * (ASIDE * s / (k + 2)) for k, s in enumerate(side)]
        yield [c * (1 - ASIDE) + step for c, step in zip(centre, steps, strict=True)]


def _rate_at(system: SwitchedSystem, lyapunov: PiecewiseExpression, place: Sequence[Number]) -> arb:
    """A ball around ``grad V . f`` at a place; the whole line where a formula switches there, or is no polynomial."""
    names = (*system.states, *(wave.name for wave in system.rewriting.names))
    displacement = {name: Polynomial.variable(system.field, names, name) for name in names}
    centre = system.named(system.check.equilibrium)
    stated = {name: part + centre[name] if name in centre else part for name, part in displacement.items()}

    def sign_of(expression: Polynomial) -> int:  # what switches holds no sines
        terms = {exponents[: len(place)]: c for exponents, c in expression.terms.items()}
        value = sign(Polynomial(system.field, system.states, terms)(place))
        if not value:
            raise _OnSurfaceError
        return value

    try:
        rates = [part.polynomial(stated, sign_of) for part in system.rewriting.named_rhs]
        potential = lyapunov.polynomial(displacement, sign_of)
        waves = _waves(system, place, sign_of)
    except (_OnSurfaceError, ExpressionError):
        return arb(0, "inf")
    values = [*(c.ball() for c in place), *waves]
    total = potential * 0
    for name, rate in zip(system.states, rates, strict=True):
        total += potential.derivative(name) * rate
    return in_balls(total)(values)


def _waves(system: SwitchedSystem, place: Sequence[Number], sign_of: SignOf) -> list[arb]:
    """Balls around the sines and the like at a place."""
    states = system.displaced(system.states)
    arguments = (system.argument_of(wave, states, sign_of)(place) for wave in system.rewriting.names)
    return [getattr(v.ball(), wave.kind)() for v, wave in zip(arguments, system.rewriting.names, strict=True)]


KEY = "lyapunov"
NOT_OF_THE_NUMBERS = (
    "V increases along fields with bounds of irrational numbers; along the field itself that is not shown"
)


class AuditVerdict(StrEnum):
    """Whether V is a Lyapunov function on the domain."""

    VALID = "valid"
    INVALID = "invalid"
    UNDECIDED = "undecided"

    @property
    def exit_status(self) -> int:
        """0 valid, 1 invalid, 3 undecided."""
        return {"valid": 0, "invalid": 1}.get(self.value, 3)


Judgement: TypeAlias = tuple[AuditVerdict, Translation | None, str, Any]  # verdict, what V proves, reason, witness

JUDGED = {
    Decrease.STRICT: (AuditVerdict.VALID, Translation.ASYMPTOTICALLY_STABLE),
    Decrease.WEAK: (AuditVerdict.VALID, Translation.STABLE),
    Decrease.REFUTED: (AuditVerdict.INVALID, None),
    Decrease.UNDECIDED: (AuditVerdict.UNDECIDED, None),
}


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
        function: V with its conditions, an :class:`ExaminedFunction`; None where it is not looked at.
    """

    scene: Scene | SwitchedSystem
    lyapunov: str
    verdict: AuditVerdict
    proves: Translation | None
    reason: str
    witness: Any
    function: Any

    def _repr_html_(self) -> str:
        rows = [(self.lyapunov, self.verdict, self.proves or "nothing", self.reason)]
        return html_table(f"{self.scene.name}: audit of V", ("V", "verdict", "proves", "reason"), rows)

    def check(self) -> bool:
        """Whether deciding again gives the same: that refuses what was changed since, and repeats an error.

        A verdict on somebody's V has no certificate; that of a check, with this V in the file, has one.
        """
        return audit(self.scene, self.lyapunov) == self


def audit(scene: Scene | SwitchedSystem, lyapunov: str) -> AuditResult:
    """Decide whether somebody's V is a Lyapunov function of an array or a plain system.

    Args:
        scene: a wheel array (rule ``nearest`` or ``box``) or a plain system.
        lyapunov: V in (x, y), or in the system's states; ``sign`` and ``Abs`` are allowed, max(a, b) is
            ``(a + b + Abs(a - b))/2``.

    Raises:
        SceneError: for text that is no formula of the states.
    """
    if scene.kind is SceneKind.SYSTEM and not scene.is_planar:
        return _audit_in_space(scene, lyapunov)
    audited = audited_cells(scene, lyapunov)
    if audited is None:
        rule = scene.contact.rule if scene.kind is SceneKind.ARRAY else None
        reason = f'rule "{rule}" moves the array by a field without cells, which is not audited'
        return AuditResult(scene, lyapunov, AuditVerdict.UNDECIDED, None, reason, None, None)
    formula, domain, cells = audited
    function: ExaminedFunction = PlaneFunction(examine(cells), domain, formula, _states(scene))
    if scene.kind is SceneKind.SYSTEM and function.decrease is Decrease.UNDECIDED:
        function = _by_squares(scene, formula) or function
    verdict, proves, reason, witness = _judged_in_the_plane(scene, function, cells)
    return AuditResult(scene, lyapunov, verdict, proves, reason, witness, function)


def _states(scene: Scene | SwitchedSystem) -> tuple[str, ...]:
    return scene.states if scene.kind is SceneKind.SYSTEM else PLANE


def _formula(scene: Scene | SwitchedSystem, lyapunov: str) -> PiecewiseExpression:
    """V.

    Raises:
        SceneError: for text that is no formula of the states over the scene's field.
    """
    formula = parse_lyapunov(with_parameters(lyapunov, {}), _states(scene), scene.origin, KEY)
    if not all(scene.field.has_angle(turn) for turn in formula.turns()):
        raise SceneError(scene.origin, KEY, "angles that occur in the scene, or multiples of pi/12", lyapunov)
    return formula


# ---- in the plane ----------------------------------------------------------------------------------


def audited_cells(
    scene: Scene | SwitchedSystem, lyapunov: str
) -> tuple[PiecewiseExpression, Domain, tuple[LyapunovCell, ...]] | None:
    """V, its domain, and that cut until the field and V are smooth; None for a rule without cells.

    Raises:
        SceneError: for text that is no formula of the states over the scene's field.
    """
    formula = _formula(scene, lyapunov)
    if scene.kind is SceneKind.SYSTEM:
        require_stated(scene)
        require_denominators(scene)
        domain = domains(scene, formula, plane_cells(scene))[0]
        cells = plane_cells(scene, domain.radius)
    elif has_cells(scene):
        domain, cells = Domain(scene.check.radius), partition_cells(build_partition(scene.recentred()))
    else:
        return None
    return formula, domain, lyapunov_cells(cells, formula, _states(scene), scene.origin, KEY)


def _by_squares(system: SwitchedSystem, formula: PiecewiseExpression) -> ExaminedFunction | None:
    """V shown by sums of squares, which are few at high degrees, where subdivision gives up; None where it is not."""
    try:
        examined = many.examine(with_known_numbers(system), formula, system.check.radius, effort=Effort.ALONE)
    except (BeyondReachError, ExpressionError):
        return None
    return examined if examined.decrease in many.PROVES else None


def _judged_in_the_plane(
    scene: Scene | SwitchedSystem, function: ExaminedFunction, cells: Sequence[LyapunovCell]
) -> Judgement:
    """The verdict that follows from the inequalities."""
    verdict, proves = JUDGED[function.decrease]
    reason, witness = function.reason, function.witness
    if scene.kind is SceneKind.ARRAY:
        return verdict, proves, reason, _named(witness)
    if isinstance(function, PlaneFunction) and function.decrease is Decrease.REFUTED and scene.rewriting.waves:
        witness = _stated_refutation(scene, function)
        reason = NOT_OF_THE_FIELD if witness is None else witness.meaning
        verdict = AuditVerdict.UNDECIDED if witness is None else verdict
    if function.decrease is Decrease.WEAK:
        staying = decide_invariant_motion(scene, function.formula, scene.check.radius, cells)
        reason = f"{reason}{', and' if staying is InvariantMotion.NONE else ';'} {staying}"
        proves = Translation.ASYMPTOTICALLY_STABLE if staying is InvariantMotion.NONE else proves
    return verdict, proves, reason, _named(witness)


def _stated_refutation(system: SwitchedSystem, function: PlaneFunction) -> Refutation | None:
    """What refutes V for the stated field, where sines and cosines of states are enclosed; None where nothing does."""
    result, formula = function.result, function.formula
    for refutation in refutations(result.cells, result.definite, result.strata):
        if not refutation.is_of_rates:
            return refutation
        place = None if formula is None else rising_place(system, formula, refutation.point)
        if place is not None:
            return Refutation((place[0], place[1]), None, RISES)
    return None


def _named(witness: Refutation | None) -> Refutation | None:
    """The witness with every late number carried out."""
    if witness is None:
        return None
    x, y, value = map(evaluated, (*witness.point, witness.value))
    return Refutation((x, y), value, witness.meaning)


# ---- in one state, and in three and more -----------------------------------------------------------


def _audit_in_space(scene: SwitchedSystem, lyapunov: str) -> AuditResult:
    require_stated(scene)
    require_denominators(scene)
    formula, radius = _formula(scene, lyapunov), scene.check.radius
    scene = with_known_numbers(scene)
    try:
        with formula_refused(scene.origin, KEY, lyapunov):
            piece = formula.polynomial(scene.named(), lambda _: 1)
            if any(number.as_rational() is None for number in piece.terms.values()):
                raise BeyondReachError("a V with irrational numbers is audited in two states alone")
            function = many.examine(scene, formula, radius)
    except BeyondReachError as error:
        verdict = AuditVerdict.INVALID if isinstance(error, NotZeroError) else AuditVerdict.UNDECIDED
        return AuditResult(scene, lyapunov, verdict, None, str(error), None, None)
    verdict, proves, reason, witness = _judged_in_space(scene, function)
    return AuditResult(scene, lyapunov, verdict, proves, reason, witness, function)


def _judged_in_space(scene: SwitchedSystem, function: ExaminedLyapunov) -> Judgement:
    """The verdict that follows from the conditions."""
    if function.attraction(scene) is not None:
        reason = f"{function.reason}, and {InvariantMotion.NONE}"
        return AuditVerdict.VALID, Translation.ASYMPTOTICALLY_STABLE, reason, None
    verdict, proves = JUDGED[function.decrease]
    reason, witness = function.reason, function.witness
    if witness is not None and scene.only_encloses:
        witness = _stated_failure(scene, function.formula, witness)
        if witness is None:
            verdict = AuditVerdict.UNDECIDED
            reason = NOT_OF_THE_NUMBERS if Enclosed.NUMBERS in scene.rewriting.encloses else NOT_OF_THE_FIELD
    return verdict, proves, reason, witness


def _stated_failure(system: SwitchedSystem, formula: PiecewiseExpression, refutation: Refutation) -> Refutation | None:
    """What refutes V for the stated field, where right-hand sides only enclose it; None where nothing does."""
    if refutation.meaning != many.RISES:
        return refutation
    if Enclosed.NUMBERS in system.rewriting.encloses:
        return None
    place = rising_place(system, formula, refutation.point)
    rational = () if place is None else tuple(c.as_rational() for c in place)
    known = tuple(as_fraction(c) for c in rational if c is not None)
    return Refutation(known, None, many.RISES) if known and len(known) == len(rational) else None
