"""Lyapunov's conditions for a V in many states: each claim of the theorem shown, refuted at a point, or left open."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from flint import fmpq

from nonsmooth.proofs.checker.positivity import Claim
from nonsmooth.proofs.checker.roots import read_subject
from nonsmooth.proofs.checker.work import MALFORMED, RejectedError
from nonsmooth.proofs.findings.verdicts import Translation
from nonsmooth.proofs.inequalities.prover import Counterexample, Proof
from nonsmooth.proofs.inequalities.subdivision import value_at
from nonsmooth.proofs.kernel.cells import (
    BeyondReachError,
    SignCells,
    StatedCells,
    stated_cells,
    surfaces_of,
)
from nonsmooth.proofs.kernel.claims import Functions
from nonsmooth.proofs.kernel.search import SQUARES, decide_claim, stability_hypotheses
from nonsmooth.proofs.kernel.second_function import find_attraction
from nonsmooth.proofs.kernel.squares import Shown, condition_of, find
from nonsmooth.proofs.kernel.subject import NoCertificateError, about
from nonsmooth.proofs.many_states.witnesses import Point, as_fractions, refuting_point, rising_slide
from nonsmooth.proofs.sums_of_squares.prove import Effort
from nonsmooth.proofs.systems.derivatives import Decrease, Refutation
from nonsmooth.proofs.systems.domain import Domain
from nonsmooth.proofs.systems.findings import ExaminedFunction, Reach
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

RISES = "V increases"
SLIDES_UP = "V increases along a solution that slides on a face"
WORK = 4_000  # coefficients looked at for one claim beside sums of squares: a second or less
SENSES = {Effort.HASTY: (), Effort.STRICT: (True,), Effort.FULL: (True, False), Effort.ALONE: ()}
POSITIVE, CELL, FACE = "V", "cell", "face"  # what names of claims begin with


class NotZeroError(BeyondReachError):
    """A V that is no Lyapunov function because it is not zero at the equilibrium."""


@dataclass(frozen=True)
class Asked:
    """A claim with what is known of it.

    Attributes:
        claim: as the theorem states it, strict.
        found: its evidence, strict or not; None where there is none.
        against: a point that refutes the weakest claim that was asked, if one was met.
    """

    claim: Claim
    found: Shown | None
    against: Counterexample[Claim] | None = None

    @property
    def is_about_fall(self) -> bool:
        """Whether it is about V', not V."""
        return self.claim.name.split()[0] != POSITIVE


PROVES = {Decrease.STRICT: Translation.ASYMPTOTICALLY_STABLE, Decrease.WEAK: Translation.STABLE}


@dataclass(frozen=True)
class ExaminedLyapunov(ExaminedFunction):
    """A V with Lyapunov's conditions on a cube about the checked point.

    Attributes:
        formula: V, in the displacement under the states' names.
        radius: half the side of the cube.
        stated: the cube, cut until the fields and V are smooth.
        conditions: from which claims on V are derived.
        asked: all claims up to the first that is not shown; none where one is refuted.
        failure: where a condition fails.
    """

    formula: PiecewiseExpression
    radius: Number
    stated: StatedCells
    conditions: Functions = field(compare=False)
    asked: tuple[Asked, ...] = ()
    failure: Refutation | None = None

    @property
    def cells(self) -> SignCells:
        """The cells of the cube."""
        return self.stated.cells

    @property
    def proofs(self) -> dict[str, Any]:
        """The evidence of what is shown, by the names of the claims."""
        return {own.claim.name: own.found.evidence for own in self.asked if own.found is not None}

    @property
    def is_homogeneous(self) -> bool:
        """Whether cells are cones and every claim is about forms: then it holds at every distance."""
        if self.decrease not in PROVES:
            return False
        return self.cells.are_cones and self.cells.beyond and are_about_forms([own.claim for own in self.asked])

    @property
    def domain(self) -> Domain:
        """Where the conditions hold: at every distance where all of them are about forms."""
        return Domain(None if self.is_homogeneous else self.radius)

    @property
    def stated_on(self) -> Domain:
        """The cube."""
        return Domain(self.radius)

    @property
    def decrease(self) -> Decrease:
        """What follows from them."""
        if self.failure is not None:
            return Decrease.REFUTED
        found = [own.found for own in self.asked]
        if None in found:
            return Decrease.UNDECIDED
        return Decrease.STRICT if all(own is not None and own.strict for own in found) else Decrease.WEAK

    @property
    def is_kept(self) -> bool:
        """Whether V, one polynomial, has V' = 0 on all cells."""
        values = [own.value for asked in self.asked if asked.is_about_fall for own in asked.claim.inequalities]
        return self.decrease is Decrease.WEAK and not self.formula.switching_parts and not any(values)

    @property
    def reason(self) -> str:
        """The same as a sentence."""
        if self.failure is not None:
            return self.failure.meaning
        left = next((own for own in self.asked if own.found is None), None)
        return self.decrease.value if left is None else _open_words(left)

    @property
    def witness(self) -> Refutation | None:
        """Where one of them fails."""
        return self.failure

    def attraction(self, system: SwitchedSystem) -> dict[str, Any] | None:
        """LaSalle's principle with its evidence, for a V that does not rise; None where that is not found.

        Where V and the fields are forms on cones every solution is attracted.
        """
        if self.decrease is not Decrease.WEAK:
            return None
        return find_attraction(system, self.formula, self.radius, everywhere=True)

    def known_entry(self, reach: Reach) -> dict[str, Any]:
        """The theorem with its evidence, as a certificate holds it: what V shows, where from, and how fast."""
        region, rate = reach.region, reach.rate
        falls = self.decrease is Decrease.STRICT
        verdict = str(PROVES[self.decrease])
        hypotheses = stability_hypotheses(self.stated.record, self.formula.text, verdict) | {
            "everywhere": falls and self.is_homogeneous,
            "level": None if region is None else str(region.level),
            "rate": None if rate is None else rate.record,
        }
        proofs = {**self.stated.proofs, **self.proofs}
        for more in (reach.near, region, rate, reach.gain):
            proofs |= {} if more is None else more.proofs
        return {"theorem": "lyapunov", "hypotheses": hypotheses, "proofs": proofs}


def are_about_forms(claims: Sequence[Claim]) -> bool:
    """Whether claims on the cube hold at every distance."""
    from nonsmooth.proofs.kernel.claims import Collected

    noted = Collected()
    for claim in claims:
        noted.note_form(claim)
    return noted.are_forms


def examine(
    system: SwitchedSystem, formula: PiecewiseExpression, radius: Number, *, effort: Effort = Effort.FULL
) -> ExaminedLyapunov:
    """Decide Lyapunov's conditions for a V.

    Args:
        system: in any number of states.
        formula: V, in the displacement under the states' names.
        radius: half the side of the cube.
        effort: how far proofs are looked for, and whether it is also asked if V merely does not increase.

    Raises:
        NotZeroError: for a V that is not zero at the point.
        BeyondReachError: for a system or a V that is not decided here.
        SceneError: for formulas that cannot be used.
    """
    stated, conditions = conditions_on(system, formula, radius)
    examined = ExaminedLyapunov(formula, radius, stated, conditions)
    claims = conditions.claims()
    failure = find_failure(stated.cells, claims)
    asked: list[Asked] = []
    while failure is None and len(asked) < len(claims):
        asked.append(answer(claims[len(asked)], effort))
        if asked[-1].found is None:
            failure = _met_failure(stated.cells, asked[-1])
            if failure is None and effort is Effort.FULL:
                failure = find_slide(system, conditions, asked[-1].claim)
            break
    return replace(examined, asked=tuple(asked) if failure is None else (), failure=failure)


def conditions_on(
    system: SwitchedSystem, formula: PiecewiseExpression, radius: Number
) -> tuple[StatedCells, Functions]:
    """The cells of a cube for a V, and what Lyapunov's theorem asks of V there.

    Raises:
        NotZeroError: for a V that is not zero at the point.
        BeyondReachError: for a system or a V that is not decided here.
        SceneError: for formulas that cannot be used.
    """
    stated = stated_cells(system, radius, surfaces_of(system, formula))
    conditions = functions_on(system, stated, [formula.text])
    try:
        conditions.show_zero()
    except RejectedError:
        raise NotZeroError("V is not zero at the equilibrium") from None
    return stated, conditions


def functions_on(system: SwitchedSystem, stated: StatedCells, texts: Sequence[str | list[list[str]]]) -> Functions:
    """Functions on cells of a system.

    Raises:
        BeyondReachError: for functions that are not continuous, or bend on curved surfaces.
    """
    try:
        return Functions(read_subject(about(system)), stated.record, texts)
    except (*MALFORMED, RejectedError, NoCertificateError) as error:
        raise BeyondReachError(f"required {error}") from None


def answer(claim: Claim, effort: Effort) -> Asked:
    """A proof of a claim by any kind of evidence, as far as one is found; V itself must be positive.

    Sums of squares come first: their functions mu serve for rates, too.
    """
    if effort is Effort.FULL and claim.name.split()[0] == POSITIVE:
        effort = Effort.STRICT
    found, against = find(claim, effort), None
    for strict in SENSES[effort]:
        if found is None:
            outcome = decide_claim(replace(claim, strict=strict), WORK, but=SQUARES)
            found = Shown(outcome.evidence, strict) if isinstance(outcome, Proof) else None
            against = outcome if isinstance(outcome, Counterexample) else None
    return Asked(claim, found, against)


def find_failure(cells: SignCells, claims: Sequence[Claim]) -> Refutation | None:
    """A point of a cell at which V is not positive or increases; None where none is found."""
    for claim in claims:
        kind = claim.name.split()[0]
        if kind == FACE:
            continue
        (inequality,) = claim.inequalities
        condition = condition_of(claim, inequality, ())
        point = refuting_point(condition, strictly=kind != POSITIVE)
        if point is not None:
            value = value_at(condition.constant, point)
            return _failure(cells, point, value, positive=kind == POSITIVE)
    return None


def _met_failure(cells: SignCells, own: Asked) -> Refutation | None:
    """A point that was met in the search of a proof about a cell, at which V is not positive or increases."""
    kind, met = own.claim.name.split()[0], own.against
    if met is None or kind == FACE or (kind != POSITIVE and not met.value):
        return None
    return _failure(cells, met.point, met.value, positive=kind == POSITIVE)


def find_slide(system: SwitchedSystem, conditions: Functions, claim: Claim) -> Refutation | None:
    """A point of a face at which V increases along a solution that slides; None where none is found.

    Args:
        system: in any number of states; where its right-hand sides only enclose the field, nothing is found.
        conditions: on V.
        claim: about the face; about a cell nothing is found.
    """
    kind, *signs = claim.name.split()  # without a surface there are no signs
    if kind != FACE or system.only_encloses:
        return None
    found = rising_slide(conditions, [j for j, sign in enumerate(signs[0]) if sign == "0"])
    return None if found is None else Refutation(*found, SLIDES_UP)


def _failure(cells: SignCells, point: Point, value: fmpq, *, positive: bool) -> Refutation:
    place, (at_point,) = as_fractions([x * cells.radius for x in point]), as_fractions([value])
    if positive:
        return Refutation(place, at_point, "V is not positive")
    return Refutation(place, -at_point / as_fractions([cells.radius])[0], RISES)


def _open_words(own: Asked) -> str:
    if own.claim.name.split()[0] == FACE:
        return "no proof was found that V falls where it bends"
    sense = "V' < 0" if own.is_about_fall else "V > 0"
    return f"no proof was found of {sense} on a cell, and no point refutes it"
