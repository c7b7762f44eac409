"""Lyapunov's conditions for a V in many states: each inequality proved, refuted at a point, or left open."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from flint import fmpq

from nonsmooth.proofs.many_states.conditions import ConditionSense, Questions, ScaledInequality, build_questions
from nonsmooth.proofs.many_states.face_witness import as_fractions, rising_slide
from nonsmooth.proofs.many_states.samples import Point, exact_value, refuting_point
from nonsmooth.proofs.many_states.sign_cells import (
    BeyondReachError,
    RationalTerms,
    SignCells,
    adjoining,
    build_cells,
    piece_on,
    rational_terms,
    surfaces_of,
)
from nonsmooth.proofs.sums_of_squares.ansatz import Condition, build_ansatz
from nonsmooth.proofs.sums_of_squares.conic_program import solve_inside
from nonsmooth.proofs.sums_of_squares.prove import Effort, Proved, normalized, prove_positive
from nonsmooth.proofs.sums_of_squares.rounded_parameters import round_parameters
from nonsmooth.proofs.systems.derivatives import Decrease
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.polynomial import add_terms
from nonsmooth.symbolic.piecewise import PiecewiseExpression
from nonsmooth.symbolic.switched_system import SwitchedSystem

SLIDES_UP = "V increases along a solution that slides on a face"
MU_DENOMINATORS = (1 << 6, 1 << 16)  # of the functions mu on faces, tried in turn


class NotZeroError(BeyondReachError):
    """A V that is no Lyapunov function because it is not zero at the equilibrium."""


@dataclass(frozen=True)
class Inequality:
    """One condition on V with what is known of it.

    Attributes:
        question: what is asked; parameters are the functions mu on its face.
        mu: their values, by number.
        proved: the evidence; None where there is none.
    """

    question: ScaledInequality
    mu: Mapping[int, fmpq]
    proved: Proved | None

    def check(self) -> bool:
        """Whether the evidence is about the question, and proves it strictly or weakly."""
        return self.proved is None or self.proved.proves_condition(with_values(self.question.condition, self.mu))


@dataclass(frozen=True)
class FailurePoint:
    """Where V fails: the displacement from the checked point, the value there, and what it means."""

    point: tuple[Fraction, ...]
    value: Fraction
    meaning: str


@dataclass(frozen=True)
class Examination:
    """Lyapunov's conditions on a cube about the checked point.

    Attributes:
        cells: the cube, cut until the fields and V are smooth.
        inequalities: all of them, unless one is refuted.
        verdict: what follows.
        failure: where a condition fails.
        reason: one sentence for people.
    """

    cells: SignCells
    inequalities: tuple[Inequality, ...]
    verdict: Decrease
    failure: FailurePoint | None
    reason: str

    @property
    def is_homogeneous(self) -> bool:
        """Whether cells are cones and every inequality is about forms: then it holds at every distance."""
        if self.verdict not in (Decrease.STRICT, Decrease.WEAK):
            return False
        conditions = (with_values(i.question.condition, i.mu) for i in self.inequalities)
        return (
            self.cells.are_cones
            and self.cells.beyond
            and all(len({sum(e) for e in c.support}) <= 1 for c in conditions)
        )


def potential_pieces(system: SwitchedSystem, cells: SignCells, formula: PiecewiseExpression) -> RationalPieces:
    """V on every cell."""
    pieces: RationalPieces = {}
    for cell in cells.cells:
        signs = dict(zip(cells.surfaces, cell.signs, strict=True))
        pieces[cell.signs] = (rational_terms(piece_on(system, formula, signs)),)
    return pieces


RationalPieces = dict[tuple[int, ...], tuple[RationalTerms, ...]]


def examine(
    system: SwitchedSystem, formula: PiecewiseExpression, radius: Number, *, effort: Effort = Effort.FULL
) -> Examination:
    """Decide Lyapunov's conditions for a V.

    Args:
        system: in any number of states.
        formula: V, in the displacement under the states' names.
        radius: half the side of the cube.
        effort: how far proofs are looked for, and whether it is also asked if V merely does not increase.

    Raises:
        BeyondReachError: for a system or a V that is not decided here.
        SceneError: for formulas that cannot be used.
    """
    cells, questions = questions_on(system, formula, radius)
    failure = find_failure(cells, questions)
    if failure is not None:
        return Examination(cells, (), Decrease.REFUTED, failure, failure.meaning)
    inequalities = []
    for asked in by_face(questions.listed):
        answered = answers(asked, effort)
        inequalities += answered
        if any(i.proved is None for i in answered):
            failure = find_slide(system, formula, cells, asked) if effort is Effort.FULL else None
            if failure is not None:
                return Examination(cells, (), Decrease.REFUTED, failure, failure.meaning)
            break
    verdict, reason = _conclude(inequalities)
    return Examination(cells, tuple(inequalities), verdict, None, reason)


def questions_on(system: SwitchedSystem, formula: PiecewiseExpression, radius: Number) -> tuple[SignCells, Questions]:
    """The cells of a cube for a V, and the inequalities that V has to satisfy there.

    Raises:
        NotZeroError: for a V that is not zero at the point.
        BeyondReachError: for a system or a V that is not decided here.
        SceneError: for formulas that cannot be used.
    """
    cells = build_cells(system, radius, surfaces_of(system, formula))
    pieces = potential_pieces(system, cells, formula)
    zero = (0,) * len(cells.states)
    if any(zero in pieces[cell.signs][0] for cell in adjoining(cells)):
        raise NotZeroError("V is not zero at the equilibrium")
    questions = build_questions(cells, pieces)
    one = {k: fmpq(1) for k in range(questions.coefficients)}
    listed = tuple(replace(q, condition=with_values(q.condition, one)) for q in questions.listed)
    return cells, replace(questions, listed=listed)


def with_values(condition: Condition, values: Mapping[int, fmpq]) -> Condition:
    """A condition in which some parameters are numbers."""
    total = dict(condition.constant)
    for k, slope in condition.slopes.items():
        if k in values:
            total = add_terms(total, {e: c * values[k] for e, c in slope.items()})
    slopes = {k: slope for k, slope in condition.slopes.items() if k not in values}
    return replace(condition, constant={e: c for e, c in total.items() if c}, slopes=slopes)


def find_failure(cells: SignCells, questions: Questions) -> FailurePoint | None:
    """A point of a cell at which V is not positive or increases; None where none is found."""
    for question in questions.listed:
        if question.group >= 0:
            continue
        positive = question.sense is ConditionSense.POSITIVE
        point = refuting_point(question.condition, strictly=not positive)
        if point is not None:
            value = exact_value(question.condition.constant, point)
            return _failure(cells, point, value, positive=positive)
    return None


def find_slide(
    system: SwitchedSystem, formula: PiecewiseExpression, cells: SignCells, asked: Sequence[ScaledInequality]
) -> FailurePoint | None:
    """A point of a face at which V increases along a solution that slides; None where none is found.

    Args:
        system: in any number of states; where its right-hand sides only enclose the field, nothing is found.
        formula: V.
        cells: of the cube.
        asked: the questions of one face, or of one cell.
    """
    if asked[0].group < 0 or system.waves:
        return None
    found = rising_slide(cells, potential_pieces(system, cells, formula), asked[0].zero)
    return None if found is None else FailurePoint(as_fractions(found[0]), _fraction(found[1]), SLIDES_UP)


def _failure(cells: SignCells, point: Point, value: fmpq, *, positive: bool) -> FailurePoint:
    place = tuple(_fraction(x * cells.radius) for x in point)
    if positive:
        return FailurePoint(place, _fraction(value), "V is not positive")
    return FailurePoint(place, _fraction(-value / cells.radius), "V increases")


def _fraction(value: fmpq) -> Fraction:
    return Fraction(int(value.p), int(value.q))


def by_face(listed: Sequence[ScaledInequality]) -> Iterator[list[ScaledInequality]]:
    """The questions of each face together, those on cells one by one."""
    together: list[ScaledInequality] = []
    for question in listed:
        if together and (question.group < 0 or question.group != together[-1].group):
            yield together
            together = []
        together.append(question)
    if together:
        yield together


def answers(asked: Sequence[ScaledInequality], effort: Effort) -> list[Inequality]:
    """Proofs of the inequalities of one cell or one face, as far as they are found."""
    open_ones = [Inequality(question, {}, None) for question in asked]
    if asked[0].group < 0:
        return [_answer(question, {}, effort) for question in asked]
    for mu in _proposals(asked, weakly=effort is Effort.FULL):
        found = []
        for question in asked:
            found.append(_answer(question, mu, effort))
            if found[-1].proved is None:
                break
        else:
            return found
    return open_ones


def _answer(question: ScaledInequality, mu: Mapping[int, fmpq], effort: Effort) -> Inequality:
    """A proof of one inequality; V itself must be positive."""
    own = Effort.STRICT if effort is Effort.FULL and question.sense is ConditionSense.POSITIVE else effort
    return Inequality(question, mu, prove_positive(with_values(question.condition, mu), own))


def _proposals(asked: Sequence[ScaledInequality], *, weakly: bool) -> Iterator[dict[int, fmpq]]:
    """Functions mu for one face."""
    numbers = sorted({k for question in asked for k in question.condition.slopes})
    place = {k: i for i, k in enumerate(numbers)}
    own = []
    for question in asked:
        slopes = {place[k]: slope for k, slope in question.condition.slopes.items()}
        own.append(normalized(replace(question.condition, slopes=slopes)))
    problems = [(condition, build_ansatz(condition)) for condition in own]
    solved = solve_inside(problems, len(numbers), bounded=False)
    for denominator in MU_DENOMINATORS if solved is not None else ():
        values = None if solved is None else round_parameters(*solved, denominator)
        if values is not None:
            yield dict(zip(numbers, values, strict=True))
    if weakly and solved is None:
        yield dict.fromkeys(numbers, fmpq(0))


def _conclude(inequalities: Sequence[Inequality]) -> tuple[Decrease, str]:
    for inequality in inequalities:
        if inequality.proved is None:
            return Decrease.UNDECIDED, _open_words(inequality)
    if all(i.proved is not None and i.proved.claim.strict for i in inequalities):
        return Decrease.STRICT, Decrease.STRICT.value
    return Decrease.WEAK, Decrease.WEAK.value


def _open_words(inequality: Inequality) -> str:
    if inequality.question.group >= 0:
        return "no sum of squares shows that V falls where it bends"
    return f"no sum of squares shows {inequality.question.sense} on a cell, and no point refutes it"
