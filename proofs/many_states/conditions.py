"""Lyapunov's conditions on cells and faces, as polynomial inequalities.

V is one polynomial on each cell of the surfaces on which it bends, and continuous.  Let c(t) be a solution.  At almost
all times at which exactly the bending surfaces ``l_j, j in B`` vanish, each ``l_j(c(t))`` has derivative 0, and V(c(t))
has the derivative of any one piece beside the face: with a piece of gradient g and any functions mu_j on the face,

    V' = g . c' = (g + sum_j mu_j grad l_j) . c',    c' a mixture of the fields f of all cells that meet there.

So V' < 0 follows if ``(g + sum_j mu_j grad l_j) . f < 0`` for each of these fields; by the duality of linear programs
nothing is lost at a point by looking for such mu instead of all convex weights that slide.  For B empty these are the
inequalities on closed cells, which suffice where V is smooth; on faces mu is a polynomial that is searched.  Where all
fields agree on a face, the closed cells suffice too.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from itertools import combinations

from flint import fmpq

from nonsmooth.proofs.many_states.affine_faces import AffineFace, build_face, unit, whole_space
from nonsmooth.proofs.many_states.sign_cells import (
    BeyondReachError,
    Pattern,
    RationalTerms,
    SignCell,
    SignCells,
    rational_terms,
)
from nonsmooth.proofs.sums_of_squares.ansatz import Condition, monomials_between
from nonsmooth.symbolic.numbers.polynomial import Exponents, Terms, add_terms, multiply_terms

MOST_FACES = 400  # inequalities on faces


class ConditionSense(StrEnum):
    """What is asked."""

    POSITIVE = "V > 0"
    FALLS = "V' < 0"


@dataclass(frozen=True)
class ScaledInequality:
    """One inequality, in the displacement divided by the half-width of the cube.

    Attributes:
        sense: of V or of its derivative.
        condition: affine in the coefficients of V, and in those of mu after them.
        signs: of the surfaces on the cell whose field it is about.
        zero: numbers of the surfaces that vanish on the face; empty on a cell.
        group: the face, by number; inequalities of one face share mu. -1 on a cell.
        functions: what V is a sum of, there.
        multipliers: of each parameter of mu, the surface and the monomial that it stands before.
        member: the number of the right-hand side whose field it is about.
    """

    sense: ConditionSense
    condition: Condition
    signs: Pattern
    zero: tuple[int, ...]
    group: int
    functions: tuple[RationalTerms, ...]
    multipliers: tuple[tuple[int, int, Exponents], ...] = ()
    member: int = 0


Pieces = Mapping[Pattern, tuple[RationalTerms, ...]]  # on each cell, the polynomial of every function of a basis


@dataclass(frozen=True)
class Questions:
    """All conditions on a V.

    Attributes:
        listed: the inequalities.
        coefficients: of V, how many.
        parameters: with those of all mu.
    """

    listed: tuple[ScaledInequality, ...]
    coefficients: int
    parameters: int


def scaled(terms: Mapping[Exponents, fmpq], factor: fmpq) -> RationalTerms:
    """A polynomial in the variables divided by a factor."""
    return {e: c * factor ** sum(e) for e, c in terms.items()}


class _Builder:
    """What the conditions of one V, or of one basis, are built from."""

    def __init__(self, cells: SignCells, pieces: Pieces) -> None:
        count, rho = len(cells.states), cells.radius
        self.count = count
        self.surfaces = [scaled(rational_terms(s), rho) for s in cells.surfaces]
        self.cells = [
            SignCell(c.signs, tuple(tuple(scaled(p, rho) for p in field) for field in c.velocities))
            for c in cells.cells
        ]
        self.pieces = {signs: tuple(scaled(p, rho) for p in own) for signs, own in pieces.items()}
        self.size = len(next(iter(self.pieces.values())))
        self.bending = bending_surfaces(cells, pieces)
        self.parameters = self.size
        by_bends: dict[tuple[tuple[int, int], ...], tuple[RationalTerms, ...]] = {}
        for signs, own in pieces.items():
            if by_bends.setdefault(self.at_bends(signs), own) != own:
                raise BeyondReachError("V bends on a curved surface")

    def at_bends(self, signs: Pattern, but: Sequence[int] = ()) -> tuple[tuple[int, int], ...]:
        """The signs of the bending surfaces, less some."""
        return tuple((j, signs[j]) for j in self.bending if j not in but)

    def guards(self, signs: Sequence[tuple[int, int]], face: AffineFace) -> list[RationalTerms] | None:
        """Guards on a face; None where they leave nothing of it."""
        found = []
        for j, sign in signs:
            own = face.restricted({e: c * sign for e, c in self.surfaces[j].items()})
            if own and not any(map(sum, own)):
                if next(iter(own.values())) < 0:
                    return None
                continue
            if own:
                found.append(own)
        return found

    def condition(
        self, slopes: Mapping[int, RationalTerms], guards: Sequence[RationalTerms], face: AffineFace, *, away: bool
    ) -> Condition:
        """The condition that ``sum_k parameter_k slopes_k`` is positive."""
        bounds = tuple(form for form in face.coordinates if any(map(sum, form)))
        kept = {k: {e: c for e, c in slope.items() if c} for k, slope in slopes.items()}
        return Condition({}, {k: s for k, s in kept.items() if s}, tuple(guards), bounds, face.dimension, away)

    def positive(self) -> Iterator[ScaledInequality]:
        """V on each cell of the surfaces on which it bends."""
        space, seen = whole_space(self.count), set()
        for cell in self.cells:
            signs = self.at_bends(cell.signs)
            if signs in seen:
                continue
            seen.add(signs)
            slopes = dict(enumerate(self.pieces[cell.signs]))
            condition = self.condition(slopes, self.guards(signs, space) or (), space, away=False)
            yield ScaledInequality(ConditionSense.POSITIVE, condition, cell.signs, (), -1, self.pieces[cell.signs])

    def on_cells(self) -> Iterator[ScaledInequality]:
        """``-grad V . f`` on closed cells."""
        space = whole_space(self.count)
        for cell in self.cells:
            guards = self.guards(tuple(enumerate(cell.signs)), space) or ()
            for member, velocity in _different_fields(cell):
                slopes = {k: _along(p, velocity, self.count) for k, p in enumerate(self.pieces[cell.signs])}
                condition = self.condition(slopes, guards, space, away=False)
                yield ScaledInequality(
                    ConditionSense.FALLS, condition, cell.signs, (), -1, self.pieces[cell.signs], member=member
                )

    def on_faces(self) -> Iterator[ScaledInequality]:
        """The same on faces on which V bends, with mu."""
        number = 0
        for zero, face in self._places().items():
            if self._is_elsewhere(face):
                continue
            groups: dict[tuple[tuple[int, int], ...], list[SignCell]] = {}
            for cell in self.cells:
                groups.setdefault(self.at_bends(cell.signs, zero), []).append(cell)
            for cells in groups.values():
                asked = list(self._on_face(face, zero, cells, number))
                number += bool(asked)
                yield from asked

    def _places(self) -> dict[tuple[int, ...], AffineFace]:
        """Where bending surfaces vanish together, by all that vanish there: more than n planes may share a line."""
        found: dict[tuple[int, ...], AffineFace] = {}
        for size in range(1, min(len(self.bending), self.count) + 1):
            for chosen in combinations(self.bending, size):
                face = build_face([self.surfaces[j] for j in chosen], self.count)
                if face is not None:
                    found.setdefault(tuple(j for j in self.bending if not face.restricted(self.surfaces[j])), face)
        return found

    def _is_elsewhere(self, face: AffineFace) -> bool:
        """Whether it is the checked point or out of the cube."""
        origin = (0,) * face.dimension
        still = [form.get(origin, fmpq(0)) for form in face.coordinates if not any(map(sum, form))]
        return (not face.dimension and not any(still)) or any(abs(value) > 1 for value in still)

    def _on_face(
        self, face: AffineFace, zero: Sequence[int], cells: Sequence[SignCell], number: int
    ) -> Iterator[ScaledInequality]:
        pieces = [self.pieces[cell.signs] for cell in cells]
        if all(piece == pieces[0] for piece in pieces) or self._agree(face, zero, cells):
            return
        origin = (0,) * face.dimension
        away = any(form.get(origin) for form in face.coordinates)
        degree = max((sum(e) for piece in pieces for p in piece for e in p), default=1) - 1
        shapes = monomials_between(face.dimension, 0, max(degree, 0))
        start, functions = self.parameters, tuple(map(face.restricted, pieces[0]))
        named = tuple(enumerate(((j, shape) for j in zero for shape in shapes), start))
        multipliers = tuple((number, j, shape) for number, (j, shape) in named)
        for cell in cells:
            others = [(j, s) for j, s in enumerate(cell.signs) if j not in zero]
            guards = self.guards(others, face)
            if guards is None:
                continue
            for member, velocity in _different_fields(cell):
                slopes = {k: face.restricted(_along(p, velocity, self.count)) for k, p in enumerate(pieces[0])}
                pushes = {j: face.restricted(_along(self.surfaces[j], velocity, self.count)) for j in zero}
                slopes.update({k: multiply_terms(pushes[j], {shape: fmpq(1)}) for k, j, shape in multipliers})
                condition = self.condition(slopes, guards, face, away=away)
                yield ScaledInequality(
                    ConditionSense.FALLS, condition, cell.signs, tuple(zero), number, functions, multipliers, member
                )
        self.parameters += len(multipliers)

    def _agree(self, face: AffineFace, zero: Sequence[int], cells: Sequence[SignCell]) -> bool:
        """Whether on the face the fields are those of the cells on one side of all its surfaces."""
        by_side: dict[Pattern, dict[Pattern, object]] = {}
        for cell in cells:
            side = tuple(cell.signs[j] for j in zero)
            rest = tuple(s for j, s in enumerate(cell.signs) if j not in zero)
            fields = [[face.restricted(part) for part in field] for field in cell.velocities]
            by_side.setdefault(side, {})[rest] = fields
        whole = max(by_side.values(), key=len)
        return all(whole.get(rest) == fields for side in by_side.values() for rest, fields in side.items())


def build_questions(cells: SignCells, pieces: Pieces) -> Questions:
    """All conditions on ``V = sum_k coefficient_k function_k``.

    Args:
        cells: of the system and of all functions.
        pieces: of every function on every cell.

    Raises:
        BeyondReachError: for a V that bends on a curved surface, and for too many faces.
    """
    builder = _Builder(cells, pieces)
    listed = [*builder.positive(), *builder.on_cells()]
    for count, question in enumerate(builder.on_faces()):
        if count == MOST_FACES:
            raise BeyondReachError(f"over {MOST_FACES} inequalities on faces where V bends")
        listed.append(question)
    return Questions(tuple(listed), builder.size, builder.parameters)


def bending_surfaces(cells: SignCells, pieces: Pieces) -> tuple[int, ...]:
    """The surfaces across which the polynomials change.

    Raises:
        BeyondReachError: where one is curved, or the functions are not continuous.
    """
    found = set()
    for signs, own in pieces.items():
        for j, sign in enumerate(signs):
            other = pieces.get((*signs[:j], -sign, *signs[j + 1 :]))
            if other is None or other == own:
                continue
            if cells.surfaces[j].degree > 1:
                raise BeyondReachError("V bends on a curved surface")
            _require_continuous(cells, own, other, j)
            found.add(j)
    return tuple(sorted(found))


def _require_continuous(cells: SignCells, own: Sequence[RationalTerms], other: Sequence[RationalTerms], j: int) -> None:
    face = build_face([rational_terms(cells.surfaces[j])], len(cells.states))
    for first, second in zip(own, other, strict=True):
        jump = add_terms(first, {e: -c for e, c in second.items()})
        if face is not None and jump and face.restricted(jump):
            raise BeyondReachError("V is not continuous")


def _different_fields(cell: SignCell) -> Iterator[tuple[int, tuple[RationalTerms, ...]]]:
    """The fields of a cell, equal ones once, with the number of the first right-hand side that has it."""
    for member, field in enumerate(cell.velocities):
        if field not in cell.velocities[:member]:
            yield member, field


def _along(potential: Mapping[Exponents, fmpq], velocity: Sequence[RationalTerms], count: int) -> Terms:
    """``-grad V . f``."""
    total: Terms = {}
    for k in range(count):
        step = unit(count, k)
        slope = {tuple(map(int.__sub__, e, step)): -c * e[k] for e, c in potential.items() if e[k]}
        total = add_terms(total, multiply_terms(slope, velocity[k]))
    return total
