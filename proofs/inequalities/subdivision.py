"""Proofs of signs by cutting simplicial cones in two until the coefficients show the sign on each part.

The longest edge is halved, breadth first, so that a point that refutes the claim is met early and all parts shrink:
the search ends wherever the form is positive.  It does not end at a zero inside the cone or inside an edge; then other
ways (:mod:`nonsmooth.proofs.inequalities.prover`) prove it, or propose where to cut.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations
from typing import Any, TypeAlias

from flint import fmpq

from nonsmooth.proofs.inequalities.effort import take_effort
from nonsmooth.proofs.inequalities.forms import Pieces, Problem, Role, Vector, face_sign, face_sum
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.numbers.polynomial import with_mixture

NEARBY_STEPS = 40  # distances 4^-k tried beside a corner that is no point of the claim


@dataclass(frozen=True)
class Leaf:
    """A part of the cone on which the coefficients show the claim."""


@dataclass(frozen=True)
class Split:
    """Generators ``first`` and ``second`` with ``m = (1 - weight) g_first + weight g_second`` between them.

    The part ``near`` has m in place of ``second``, the part ``far`` in place of ``first``.
    """

    first: int
    second: int
    weight: Any
    near: Tree
    far: Tree


Tree: TypeAlias = Leaf | Split


@dataclass(frozen=True)
class Stuck:
    """Generators of a part of the cone on which the sign was not found."""

    generators: tuple[Vector, ...]


@dataclass(frozen=True)
class Violation:
    """A point, in the form's variables, at which the claim is false."""

    point: Vector


class SubCone:
    """A part of the cone on its way to being proved.

    Attributes:
        generators: of the part.
        places: the generators in the root's barycentric coordinates (halvings only), which measure its size.
        pieces: coefficients in the generators.
        depth: number of cuts above it.
    """

    __slots__ = ("depth", "generators", "parts", "pieces", "places", "split")

    def __init__(self, generators: tuple[Vector, ...], places: tuple[Vector, ...], pieces: Pieces, depth: int) -> None:
        self.generators, self.places, self.pieces, self.depth = generators, places, pieces, depth
        self.split: tuple[int, int, Any] | None = None
        self.parts: tuple[SubCone, SubCone] | None = None

    def tree(self) -> Tree:
        """The cuts below, without coefficients."""
        if self.split is None or self.parts is None:
            return Leaf()
        return Split(*self.split, self.parts[0].tree(), self.parts[1].tree())


Cut: TypeAlias = Callable[["SubCone"], "tuple[int, int, Any] | Violation | None"]


def subdivide(problem: Problem, budget: int, cut: Cut | None = None) -> Tree | Violation | Stuck:
    """Prove by coefficients, breadth first, within a budget.

    Args:
        problem: the claim.
        budget: work that may be done, in coefficients (those of one part at least).
        cut: proposes where to split a part because the form touches zero on its edge.
    """
    count = len(problem.generators)
    places = tuple(tuple(Fraction(int(i == k)) for i in range(count)) for k in range(count))
    root = SubCone(problem.generators, places, problem.coefficients, 0)
    waiting = deque([root])
    while waiting and budget > 0:
        node = waiting.popleft()
        budget -= node.pieces.work
        take_effort(node.pieces.work)
        if problem.settles(node.generators, node.pieces):
            continue
        violation = _violation(problem, node)
        if violation is not None:
            return violation
        split = cut(node) if cut is not None else None
        if isinstance(split, Violation):
            return split
        node.split = split or (*_edge_to_halve(node), fmpq(1, 2))
        node.parts = _halves(node, *node.split)
        waiting.extend(node.parts)
    return Stuck(waiting[0].generators) if waiting else root.tree()


def verify(problem: Problem, tree: Tree) -> bool:
    """Re-verify a tree: the parts cover the cone because each is cut in two, and each leaf's coefficients are
    computed anew from the form.
    """
    waiting: list[tuple[tuple[Vector, ...], Tree]] = [(problem.generators, tree)]
    while waiting:
        generators, part = waiting.pop()
        if isinstance(part, Split):
            if not sign(part.weight) > 0 or not sign(1 - part.weight) > 0:
                return False
            middle = _mixture(generators, part.first, part.second, part.weight)
            waiting.append((_replaced(generators, part.second, middle), part.near))
            waiting.append((_replaced(generators, part.first, middle), part.far))
        elif not problem.settles(generators, problem.pieces(generators)):
            return False
    return True


def _mixture(vectors: Sequence[Vector], first: int, second: int, weight: Any) -> Vector:
    return tuple(a * (1 - weight) + b * weight for a, b in zip(vectors[first], vectors[second], strict=True))


def _replaced(vectors: Sequence[Vector], k: int, vector: Vector) -> tuple[Vector, ...]:
    return (*vectors[:k], vector, *vectors[k + 1 :])


def _edge_to_halve(part: SubCone) -> tuple[int, int]:
    """The longest edge as seen in the root's barycentric coordinates, so that all parts shrink.

    Near a corner where the form is zero its sign may depend on the direction alone, and halving the longest edge would
    give similar parts for ever: every second time only edges between other corners are looked at.
    """
    corners = range(len(part.generators))
    others = [k for k in corners if face_sign(part.pieces, 1 << k)] if part.depth % 2 else []
    if part.depth % 2 and len(others) < 2 and any(part.pieces.guards):
        # beside a curve that ends at the origin, and zero at another corner too: halving at the origin leads nowhere
        others = [k for k in corners if any(part.generators[k][:-1])]
    return max(
        combinations(others if len(others) > 1 else corners, 2),
        key=lambda edge: sum((a - b) ** 2 for a, b in zip(part.places[edge[0]], part.places[edge[1]], strict=True)),
    )


def _halves(node: SubCone, first: int, second: int, weight: Any) -> tuple[SubCone, SubCone]:
    middle = _mixture(node.generators, first, second, weight)
    place = _mixture(node.places, first, second, Fraction(1, 2))
    near = node.pieces.mapped(lambda terms: with_mixture(terms, first, second, 1 - weight, weight))
    far = node.pieces.mapped(lambda terms: with_mixture(terms, second, first, weight, 1 - weight))
    return (
        SubCone(
            _replaced(node.generators, second, middle), _replaced(node.places, second, place), near, node.depth + 1
        ),
        SubCone(_replaced(node.generators, first, middle), _replaced(node.places, first, place), far, node.depth + 1),
    )


def _violation(problem: Problem, node: SubCone) -> Violation | None:
    """A point of the part where the claim is false, if a corner, a strict face or the middle shows one."""
    generators, count = node.generators, len(node.generators)
    faces = problem.strict_faces(generators, except_origin=problem.except_origin) if problem.strict else []
    for face in dict.fromkeys([*(1 << k for k in range(count)), (1 << count) - 1, *faces]):
        here = face_sign(node.pieces, face)
        if here < 0 or (here == 0 and face in faces):
            point = face_sum(generators, face)
            if problem.is_violated_at(point):
                return Violation(point)
            if here < 0 and not problem.guards and problem.role(point) is not Role.POINT:
                nearby = _towards(problem, point, generators)
                if nearby is not None:
                    return nearby
    return None


def _towards(problem: Problem, start: Vector, generators: Sequence[Vector]) -> Violation | None:
    """A violating point near a direction or the origin, which are no points of the claim themselves."""
    for k in range(NEARBY_STEPS):
        for other in generators:
            point = tuple(a + b * fmpq(1, 4**k) for a, b in zip(start, other, strict=True))
            if problem.is_violated_at(point):
                return Violation(point)
    return None
