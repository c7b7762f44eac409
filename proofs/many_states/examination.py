"""Lyapunov's conditions for a V in many states: each claim of the theorem shown, refuted at a point, or left open."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction

import numpy as np
from flint import fmpq, fmpq_mat

from nonsmooth.proofs.checker.cells import Cell, Face, Inclusion
from nonsmooth.proofs.checker.polynomials import Polynomial
from nonsmooth.proofs.checker.positivity import Claim
from nonsmooth.proofs.checker.work import RejectedError
from nonsmooth.proofs.findings import Record, Translation
from nonsmooth.proofs.inequalities.linear_program import best_mixture
from nonsmooth.proofs.inequalities.prover import Counterexample, Proof
from nonsmooth.proofs.inequalities.subdivision import value_at
from nonsmooth.proofs.kernel.bases import functions_on
from nonsmooth.proofs.kernel.cells import BeyondReachError, SignCells, StatedCells, stated_cells, surfaces_of
from nonsmooth.proofs.kernel.search import SQUARES, DeferredClaims, Functions, decide_claim
from nonsmooth.proofs.kernel.squares import Shown, condition_of, find
from nonsmooth.proofs.kernel.written import rational_slopes, terms_of
from nonsmooth.proofs.sums_of_squares.ansatz import Condition
from nonsmooth.proofs.sums_of_squares.prove import Effort
from nonsmooth.proofs.systems.derivatives import Decrease, Refutation
from nonsmooth.proofs.systems.domain import Domain
from nonsmooth.proofs.systems.findings import ExaminedFunction, Reach
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression
from nonsmooth.symbolic.numbers.coefficients import as_fraction
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.polynomial import float_values
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

# ---- points at which conditions on V fail: floats look for them, rational arithmetic decides -----
#
# *On cells*: a point at which an inequality is false.
#
# *On faces*, where V bends, solutions that slide may raise V.  At a rational point of a face let ``l_j = 0`` for j in
# Z, with no other surface through it, and let f_i be the fields of all cells that meet there.  A mixture with ``sum_i
# w_i grad l_j . f_i = 0`` for j in Z is a velocity along the face, and V(c(t)) has the derivative ``sum_i w_i g . f_i``
# with the gradient g of any one piece.  A linear program finds the largest.  If it is positive, with as many positive
# weights as there are equations, then these weights depend continuously on the place near the point: there is a
# solution along the face, and V rises along it.


POINTS = 1_500
HALVINGS = 10  # of the distance from the point
FINE = 1 << 10  # denominator of a point, in parts of its distance
TRIES = 6

Point = tuple[fmpq, ...]


def refuting_point(condition: Condition, *, strictly: bool) -> Point | None:
    """A point inside the guards at which p is negative (or zero, unless ``strictly``); None where none is found.

    Args:
        condition: without parameters.
        strictly: whether zero refutes nothing.
    """
    rng = np.random.default_rng(0)
    cloud = rng.uniform(-1, 1, (POINTS, condition.variables))
    axes = np.eye(condition.variables)
    cloud = np.vstack([axes, -axes, cloud])
    halved = 0.5 ** rng.integers(0, HALVINGS, len(cloud))
    points = cloud * halved[:, None]
    inside = np.ones(len(points), dtype=bool)
    for guard in condition.guards:
        inside &= float_values(guard, points) > 0
    points, halved = points[inside], halved[inside]
    if not len(points):
        return None
    order = min(map(sum, condition.constant), default=0)
    value = float_values(condition.constant, points) / halved**order
    for k in np.argsort(value)[:TRIES]:
        step = FINE * round(1 / float(halved[k]))
        point = tuple(fmpq(round(float(x) * step), step) for x in points[k])
        exact = value_at(condition.constant, point)
        fails = exact < 0 or (not exact and not strictly and any(point))
        if fails and all(value_at(guard, point) > 0 for guard in condition.guards):
            return point
    return None


def as_fractions(point: Sequence[fmpq]) -> tuple[Fraction, ...]:
    """The same numbers."""
    return tuple(as_fraction(x) for x in point)


FACE_POINTS = 80  # of one face, half of them at the largest distance
FACE_HALVINGS = 6  # of the distance from the point
FACE_FINE = 1 << 6  # denominator of a coordinate, in parts of its distance
EXTREME = 0.5  # the share of coordinates that are least or largest


def rising_slide(conditions: Functions, zero: Sequence[int]) -> tuple[tuple[Fraction, ...], Fraction] | None:
    """A point of a face and a positive derivative of V along a solution from there; None where none is found.

    Args:
        conditions: on V; all fields of a cell may act.
        zero: the surfaces that vanish on the face.
    """
    inclusion = conditions.inclusion
    face = next((face for face in inclusion.faces() if face.zero == tuple(zero)), None)
    if face is None or face.curved or not face.dimension:
        return None
    radius = inclusion.domain.radius
    for point in _points(face):
        here = [sign(_value(surface, point)) for surface in inclusion.surfaces.listed]
        if not _is_clear(inclusion, here):
            continue
        around = [cell for cell in inclusion.cells if all(s in {0, c} for s, c in zip(here, cell.signs, strict=True))]
        through = [surface for surface, s in zip(inclusion.surfaces.listed, here, strict=True) if not s]
        rise = _largest_rise(conditions, through, around, point)
        if rise is not None:
            return tuple(x * radius for x in as_fractions(point)), rise / radius
    return None


def _points(face: Face) -> Iterator[Point]:
    """Rational points of a face in the cube, nearer and farther; many of them near its border or near other faces."""
    rng = np.random.default_rng(0)
    for _ in range(FACE_POINTS):
        scale = fmpq(1, FACE_FINE << max(0, int(rng.integers(-FACE_HALVINGS, FACE_HALVINGS))))
        inside = rng.integers(1, FACE_FINE, face.dimension)
        sizes = np.where(rng.random(face.dimension) < EXTREME, rng.choice((1, FACE_FINE), face.dimension), inside)
        free = [scale * int(k) for k in sizes * rng.choice((-1, 1), face.dimension)]
        point = tuple(_value(form, free) for form in face.coordinates)
        if any(point) and all(abs(x) <= 1 for x in point):
            yield point


def _is_clear(inclusion: Inclusion, signs: Sequence[int]) -> bool:
    """Whether every listed cell with the signs of a point meets there.

    That is so if all surfaces are planes, for a segment from the point into such a cell keeps its signs; and if the
    surfaces through the point are planes in general position.
    """
    listed = inclusion.surfaces.listed
    if all(surface.degree == 1 for surface in listed):
        return True
    here = [surface for surface, s in zip(listed, signs, strict=True) if not s]
    return all(surface.degree == 1 for surface in here) and _rank([rational_slopes(h) for h in here]) == len(here)


def _largest_rise(
    conditions: Functions, through: Sequence[Polynomial], around: Sequence[Cell], point: Point
) -> Fraction | None:
    """The largest derivative of V along the surfaces through a point, if a solution is shown to have it."""
    normals: list[list[fmpq]] = []
    for form in through:
        if _rank([*normals, rational_slopes(form)]) > len(normals):
            normals.append(rational_slopes(form))
    if not around:
        return None
    potential = conditions.potential(around[0])
    gradient = [_value(potential.derivative(k), point) for k in range(potential.count)]
    fields = dict.fromkeys(
        tuple(_value(part, point) for part in velocity) for cell in around for _, velocity in cell.fields
    )
    rises = [_dot(gradient, velocity) for velocity in fields]
    across = [tuple(_dot(normal, velocity) for normal in normals) for velocity in fields]
    if max(rises) <= 0 or any(min(speeds) > 0 or max(speeds) < 0 for speeds in zip(*across, strict=True)):
        return None  # V rises along none of them, or all leave a surface to one side: so do their mixtures
    field = NumberField()
    columns = [(*map(field, speeds), field.one) for speeds in across]
    target = (*(field.zero for _ in normals), field.one)
    mixture = best_mixture(columns, target, [field(rise) for rise in rises])
    if mixture is None or mixture.value.sign() <= 0 or len(mixture.weights) <= len(normals):
        return None
    rise = mixture.value.as_rational()
    return None if rise is None else as_fraction(rise)


def _value(polynomial: Polynomial, point: Sequence[fmpq]) -> fmpq:
    return fmpq(value_at(terms_of(polynomial), point))


def _rank(rows: Sequence[Sequence[fmpq]]) -> int:
    return int(fmpq_mat([list(row) for row in rows]).rank()) if rows else 0


def _dot(first: Sequence[fmpq], second: Sequence[fmpq]) -> fmpq:
    return sum((a * b for a, b in zip(first, second, strict=True)), fmpq(0))


# ---- the examination -----------------------------------------------------------------------------


RISES = "V increases"
SLIDES_UP = "V increases along a solution that slides on a face"
WORK = 4_000  # coefficients looked at for one claim beside sums of squares: a second or less
SENSES = {Effort.HASTY: (), Effort.STRICT: (True,), Effort.FULL: (True, False), Effort.ALONE: ()}
POSITIVE, FACE = "V", "face"  # what names of claims begin with


class NotZeroError(BeyondReachError):
    """A V that is no Lyapunov function because it is not zero at the equilibrium."""


@dataclass(frozen=True)
class ExaminedClaim:
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
    asked: tuple[ExaminedClaim, ...] = ()
    failure: Refutation | None = None

    @property
    def cells(self) -> SignCells:
        """The cells of the cube."""
        return self.stated.cells

    @property
    def proofs(self) -> Record:
        """The evidence of what is shown, by the names of the claims."""
        return {question.claim.name: question.found.evidence for question in self.asked if question.found is not None}

    @property
    def is_homogeneous(self) -> bool:
        """Whether cells are cones and every claim is about forms: then it holds at every distance."""
        if self.decrease not in PROVES:
            return False
        return (
            self.cells.are_cones and self.cells.beyond and are_about_forms([question.claim for question in self.asked])
        )

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
        proofs = [question.found for question in self.asked]
        if None in proofs:
            return Decrease.UNDECIDED
        return Decrease.STRICT if all(proof is not None and proof.strict for proof in proofs) else Decrease.WEAK

    @property
    def is_kept(self) -> bool:
        """Whether V, one polynomial, has V' = 0 on all cells."""
        values = [
            inequality.value
            for question in self.asked
            if question.is_about_fall
            for inequality in question.claim.inequalities
        ]
        return self.decrease is Decrease.WEAK and not self.formula.switching_parts and not any(values)

    @property
    def reason(self) -> str:
        """The same as a sentence."""
        if self.failure is not None:
            return self.failure.meaning
        open_question = next((question for question in self.asked if question.found is None), None)
        return self.decrease.value if open_question is None else _open_words(open_question)

    @property
    def witness(self) -> Refutation | None:
        """Where one of them fails."""
        return self.failure

    def attraction(self, system: SwitchedSystem) -> Record | None:
        """LaSalle's principle with its evidence, for a V that does not rise; None where that is not found.

        Where V and the fields are forms on cones every solution is attracted.
        """
        if self.decrease is not Decrease.WEAK:
            return None
        from nonsmooth.proofs.kernel.second_function import find_attraction

        return find_attraction(system, self.formula, self.radius, everywhere=True)

    def known_proofs(self, reach: Reach) -> Record:
        """The evidence that was found of its conditions and its reach, by the names of claims."""
        proofs = {**self.stated.proofs, **self.proofs}
        for more in (reach.near, reach.region, reach.rate, reach.gain):
            proofs |= {} if more is None else more.proofs
        return proofs


def are_about_forms(claims: Sequence[Claim]) -> bool:
    """Whether claims on the cube hold at every distance."""
    noted = DeferredClaims()
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
    questions: list[ExaminedClaim] = []
    while failure is None and len(questions) < len(claims):
        questions.append(answer(claims[len(questions)], effort))
        if questions[-1].found is None:
            failure = _met_failure(stated.cells, questions[-1])
            if failure is None and effort is Effort.FULL:
                failure = find_slide(system, conditions, questions[-1].claim)
            break
    return replace(examined, asked=tuple(questions) if failure is None else (), failure=failure)


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


def answer(claim: Claim, effort: Effort) -> ExaminedClaim:
    """A proof of a claim by any kind of evidence, as far as one is found; V itself must be positive.

    Sums of squares come first: their functions mu serve for rates, too.
    """
    if effort is Effort.FULL and claim.name.split()[0] == POSITIVE:
        effort = Effort.STRICT
    proof, against = find(claim, effort), None
    for strict in SENSES[effort]:
        if proof is None:
            outcome = decide_claim(replace(claim, strict=strict), WORK, but=SQUARES)
            proof = Shown(outcome.evidence, strict) if isinstance(outcome, Proof) else None
            against = outcome if isinstance(outcome, Counterexample) else None
    return ExaminedClaim(claim, proof, against)


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


def _met_failure(cells: SignCells, question: ExaminedClaim) -> Refutation | None:
    """A point that was met in the search of a proof about a cell, at which V is not positive or increases."""
    kind, counterexample = question.claim.name.split()[0], question.against
    if counterexample is None or kind == FACE or (kind != POSITIVE and not counterexample.value):
        return None
    return _failure(cells, counterexample.point, counterexample.value, positive=kind == POSITIVE)


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
    slide = rising_slide(conditions, [j for j, sign in enumerate(signs[0]) if sign == "0"])
    return None if slide is None else Refutation(*slide, SLIDES_UP)


def _failure(cells: SignCells, point: Point, value: fmpq, *, positive: bool) -> Refutation:
    place, at_point = as_fractions([x * cells.radius for x in point]), as_fraction(value)
    if positive:
        return Refutation(place, at_point, "V is not positive")
    return Refutation(place, -at_point / as_fraction(cells.radius), RISES)


def _open_words(question: ExaminedClaim) -> str:
    if question.claim.name.split()[0] == FACE:
        return "no proof was found that V falls where it bends"
    sense = "V' < 0" if question.is_about_fall else "V > 0"
    return f"no proof was found of {sense} on a cell, and no point refutes it"
