"""Inequalities on simplicial cones by the coefficients of forms in the corners, and by cuts, over any exact field.

*Coefficients.*  Written in the corners, ``F(sum lambda_i P_i) = sum c_e lambda^e``, a form is non-negative if all
``c_e`` are (Bernstein's form without the binomials), and then it vanishes inside a face exactly if no monomial with a
positive coefficient lives on that face alone: strictness is read off.  Where guards g are ``>= 0`` it is enough that
this holds of ``F - c g`` with a number c >= 0, and where h is zero of ``F - c h`` with any c.  A part on which a guard
is negative has no point of the cell.  Where some coefficient is negative the cone is cut in two.

*Cuts.*  The longest edge is halved, breadth first, so that a point that refutes the claim is met early and all parts
shrink: the search ends wherever the form is positive.  It does not end at a zero inside the cone or inside an edge;
then other ways prove it, or propose where to cut.

A claim in the plane (:mod:`nonsmooth.proofs.inequalities.forms`) and one of a certificate in any number of states
(:mod:`nonsmooth.proofs.kernel.simplices`) go through the same cuts.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from enum import Enum
from functools import lru_cache
from itertools import combinations
from math import prod
from typing import Any, TypeAlias

from flint import fmpq

from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.polynomial import Terms, add_terms, multiply_terms, with_mixture
from nonsmooth.symbolic.numbers.work_limit import UNLIMITED, WorkMeter

Vector: TypeAlias = tuple[Any, ...]

LONG_BITS = 512  # of a rational coefficient that costs as much again as a short one
IRRATIONAL_WORK = 4  # a product of two irrational terms costs about this many rational ones

# ---- how much work the inequalities of one question may take together ----------------------------
#
# Counted, so that no machine's speed matters.  Each inequality has limits of its own
# (:mod:`nonsmooth.proofs.inequalities.prover`); many that are all hard still take minutes.  Inside
# :func:`shared_effort` they draw on one meter, in coefficients looked at.  What it no longer pays for is left
# undecided, after a little work on each inequality still; nothing that is shown depends on it.


_meter: ContextVar[WorkMeter | None] = ContextVar("effort", default=None)


def effort_left() -> int:
    """The work that may still be done."""
    meter = _meter.get()
    return UNLIMITED if meter is None else max(meter.left, 0)


def take_effort(units: int) -> None:
    """Note work that is done."""
    meter = _meter.get()
    if meter is not None:
        meter.left -= units


def require_effort(units: int) -> None:
    """Take work that nothing can be said without.

    Raises:
        WorkLimitError: where none is left.
    """
    meter = _meter.get()
    if meter is not None:
        meter.spend(units)


@contextmanager
def shared_effort(units: int) -> Iterator[None]:
    """Limit the work inside a block; within another block, what is done counts for both."""
    outer = _meter.get()
    inner = WorkMeter(units) if outer is None else outer.within(units)
    token = _meter.set(inner)
    try:
        yield
    finally:
        _meter.reset(token)
        take_effort(inner.units - inner.left)


@contextmanager
def effort_of_its_own(units: int) -> Iterator[None]:
    """The same apart from all others: for what is decided again later and must come out equal."""
    token = _meter.set(WorkMeter(units))
    try:
        yield
    finally:
        _meter.reset(token)


# ---- forms in the corners, and cuts --------------------------------------------------------------


class Role(Enum):
    """What a corner is to the cell."""

    POINT = "a point of the cell"
    ORIGIN = "the origin"
    LIMIT = "a direction in which points of the cell lie, but no point itself"


@dataclass(frozen=True)
class FormsClaim:
    """What is claimed of forms on a cell.

    Attributes:
        strict: whether ``> 0`` is claimed, or ``>= 0``.
        at_origin: whether it is claimed at the origin too.
        weighted: whether the last variable is w, so that vectors with ``w = 0`` are no points.
        border: the name of a guard; where it is zero nothing is claimed strictly.  Empty without one.
        by_sides: whether zeros may lie where a guard is negative; the checker of certificates knows no such leaf.
    """

    strict: bool
    at_origin: bool
    weighted: bool = True
    border: str = ""
    by_sides: bool = False

    def role(self, vector: Vector) -> Role:
        """What a vector is to the cell."""
        if not self.weighted:
            return Role.POINT
        if not vector[-1]:
            return Role.LIMIT
        return Role.POINT if any(vector[:-1]) else Role.ORIGIN

    def is_about(self, vector: Vector) -> bool:
        """Whether something is claimed at a vector."""
        role = self.role(vector)
        return role is Role.POINT or (role is Role.ORIGIN and self.at_origin)

    def faces(self, corners: Sequence[Vector], border: Terms | None = None) -> list[int]:
        """The smallest faces, as bit masks of corners, such that a form that is positive inside them is it everywhere.

        They are the corners about which something is claimed, and the edges from any other point among the corners to
        another such one or to a direction.  (A form without negative coefficients is meant.)
        """
        points = [k for k, corner in enumerate(corners) if self.role(corner) is not Role.LIMIT]
        free = [k for k in points if not self.is_about(corners[k])]
        if border is not None:
            free += [k for k in points if k not in free and not face_sign(border, 1 << k)]
        beside = [k for k in range(len(corners)) if k in free or k not in points]
        return [1 << k for k in points if k not in free] + [1 << k | 1 << j for k in free for j in beside if j != k]


@dataclass
class SubCone:
    """A simplicial cone on its way to being proved.

    Attributes:
        corners: independent, in the variables of the forms.
        places: the corners in the root's barycentric coordinates (halvings only), which measure its size.
        values: for each inequality the coefficients of p in the corners, and of the polynomials q.
        guards: for each inequality those of its guards, by name.
        zeros: those of the polynomials that are zero, by name.
        depth: number of cuts above it.
        node: what shows it, or where it is cut; None as long as neither is known.
    """

    corners: tuple[Vector, ...]
    places: tuple[Vector, ...]
    values: list[list[Terms]]
    guards: list[dict[str, Terms]]
    zeros: dict[str, Terms]
    depth: int
    node: Any = field(default=None)

    @property
    def form(self) -> Terms:
        """The coefficients of p of the first inequality."""
        return self.values[0][0]

    @property
    def work(self) -> int:
        """What it costs to look at this part and cut it in two, in products of short rational coefficients."""
        return sum(_work_of(c) for terms in self._forms() for c in terms.values())

    def _forms(self) -> Iterator[Terms]:
        for forms in self.values:
            yield from forms
        for guards in self.guards:
            yield from guards.values()
        yield from self.zeros.values()

    def with_corner(self, kept: int, replaced: int, share: Any) -> SubCone:
        """The part in which ``(1 - share) P_kept + share P_replaced`` takes the place of ``P_replaced``."""

        def changed(terms: Terms) -> Terms:
            return with_mixture(terms, kept, replaced, 1 - share, share)

        return SubCone(
            _with_mixed(self.corners, kept, replaced, share),
            _with_mixed(self.places, kept, replaced, fmpq(1, 2)),
            [list(map(changed, forms)) for forms in self.values],
            [{name: changed(guard) for name, guard in guards.items()} for guards in self.guards],
            {name: changed(zero) for name, zero in self.zeros.items()},
            self.depth + 1,
        )


def root_part(
    corners: Sequence[Vector],
    values: Sequence[Sequence[Terms]],
    guards: Sequence[Mapping[str, Terms]],
    zeros: Mapping[str, Terms] | None = None,
) -> SubCone:
    """A cone that nothing was cut from, with the forms in its corners."""
    count = len(corners)
    places = tuple(tuple(fmpq(int(i == k)) for i in range(count)) for k in range(count))
    return SubCone(tuple(corners), places, list(map(list, values)), list(map(dict, guards)), dict(zeros or {}), 0)


def _with_mixed(vectors: Sequence[Vector], kept: int, replaced: int, share: Any) -> tuple[Vector, ...]:
    mixed = tuple(a * (1 - share) + b * share for a, b in zip(vectors[kept], vectors[replaced], strict=True))
    return (*vectors[:replaced], mixed, *vectors[replaced + 1 :])


def _work_of(coefficient: Any) -> int:
    """Of one coefficient: by its length, or by its number of irrational terms."""
    if isinstance(coefficient, Number):
        return IRRATIONAL_WORK * len(coefficient.terms) ** 2 or 1
    return 1 + (coefficient.height_bits() // LONG_BITS if isinstance(coefficient, fmpq) else 0)


# ---- what coefficients show --------------------------------------------------------------------


@lru_cache(maxsize=1 << 14)
def support(exponents: tuple[int, ...]) -> int:
    """The corners that occur in a monomial, as a bit mask."""
    return sum(1 << k for k, e in enumerate(exponents) if e)


def is_nonnegative(terms: Terms) -> bool:
    """Whether no coefficient is negative."""
    return all(sign(c) >= 0 for c in terms.values())


def has_positive(terms: Terms, face: int) -> bool:
    """Whether a monomial on the face alone has a positive coefficient."""
    return any(sign(c) > 0 for e, c in terms.items() if not support(e) & ~face)


def face_sign(form: Terms, face: int) -> int:
    """Sign of a form at the sum of a face's corners."""
    return sign(sum((c for e, c in form.items() if not support(e) & ~face), fmpq(0)))


def degree_of(form: Terms) -> int:
    """The degree of a form in the corners; 0 of zero."""
    return sum(next(iter(form), ()))


def raised(form: Terms, degree: int, corners: Sequence[Vector]) -> Terms:
    """The same form times a power of w, the last variable, so that it has a larger degree."""
    count = len(corners)
    weight = {tuple(int(i == k) for i in range(count)): c[-1] for k, c in enumerate(corners) if c[-1]}
    while form and degree_of(form) < degree:
        form = multiply_terms(form, weight)
    return form


def shows(part: SubCone, sought: FormsClaim, k: int, form: Terms) -> bool:
    """Whether the coefficients of a form show of it what the k-th inequality claims of p."""
    if not is_nonnegative(form):
        return False
    return not sought.strict or _is_positive(form, sought.faces(part.corners, part.guards[k].get(sought.border)))


def _is_positive(form: Terms, faces: Sequence[int]) -> bool:
    return all(has_positive(form, face) for face in faces)


def shown_by(
    part: SubCone, sought: FormsClaim, k: int, free: frozenset[str] = frozenset()
) -> str | dict[str, Any] | None:
    """What shows the k-th inequality on a part without functions mu; None where coefficients do not tell.

    Args:
        part: the part.
        sought: what is claimed there.
        k: the number of the inequality.
        free: the guards whose zeros do not matter.

    Returns:
        The name of a guard that is positive nowhere on the part, or multiples of guards and zeros to take off p.
    """
    p, guards = part.values[k][0], part.guards[k]
    if shows(part, sought, k, p):
        return {}
    outside = _outside_by(part, sought, guards, free)
    if outside is not None:
        return outside
    for name, taken in {**guards, **part.zeros}.items():
        degree = max(degree_of(p), degree_of(taken))
        value, less = (raised(form, degree, part.corners) for form in (p, taken))
        factor = multiplier(value, less, signed=name in guards)
        if factor is None:
            continue
        rest = add_terms(value, {e: -c * factor for e, c in less.items()})
        if shows(part, sought, k, rest) or (sought.by_sides and _is_positive_inside(part, sought, rest, less, factor)):
            return {name: factor}
    return None


def _outside_by(part: SubCone, sought: FormsClaim, guards: Mapping[str, Terms], free: frozenset[str]) -> str | None:
    """A guard that is positive nowhere on the part, and zero at no point that counts unless it is free."""
    for name, guard in guards.items():
        negative = {e: -c for e, c in guard.items()}
        if is_nonnegative(negative) and (name in free or _is_positive(negative, sought.faces(part.corners))):
            return name
    return None


def _is_positive_inside(part: SubCone, sought: FormsClaim, rest: Terms, guard: Terms, factor: Any) -> bool:
    """Whether ``rest + factor guard`` is positive at all points that count, face by face.

    Inside each face the rest is positive, or the guard is negative (no point of the cell lies there), or
    ``factor guard`` is positive.

    Args:
        part: the part.
        sought: what is claimed there.
        rest: without negative coefficients.
        guard: of the same degree.
        factor: not negative.
    """
    faces, telling = sought.faces(part.corners), {-1, 1} if factor else {-1}
    supersets = (m for m in range(1 << len(part.corners)) if any(not face & ~m for face in faces))
    return all(has_positive(rest, face) or _one_sign(guard, face) in telling for face in supersets)


def _one_sign(terms: Terms, face: int) -> int:
    """The sign that all coefficients of a form on a face share, and with them its values inside; 0 without one."""
    signs = {sign(c) for e, c in terms.items() if not support(e) & ~face}
    return signs.pop() if len(signs) == 1 else 0


def multiplier(form: Terms, taken: Terms, *, signed: bool = True) -> Any:
    """The middle of the numbers c for which no coefficient of ``form - c taken`` is negative; None without any.

    Args:
        form: a form.
        taken: another one, of the same degree.
        signed: whether c must not be negative.
    """
    taken = {e: c for e, c in taken.items() if sign(c)}
    if any(sign(c) < 0 and e not in taken for e, c in form.items()):
        return None
    ratios = [(sign(c), form.get(e, 0 * c) / c) for e, c in taken.items()]
    least = max((ratio for side, ratio in ratios if side < 0), default=None)
    most = min((ratio for side, ratio in ratios if side > 0), default=None)
    if signed and (least is None or sign(least) < 0):
        least = fmpq(0)
    if least is None:
        return None if most is None else most - 1
    if most is None:
        return least + 1
    return (least + most) / 2 if least <= most else None


# ---- cuts --------------------------------------------------------------------------------------

NEARBY_STEPS = 40  # distances 4^-k tried beside a corner at which nothing is claimed


@dataclass(frozen=True)
class Violation:
    """A point, in the variables of the forms, at which a claim is false."""

    point: Vector


@dataclass(frozen=True)
class UndecidedCorners:
    """Corners of a part of a cone on which the sign was not found."""

    corners: tuple[Vector, ...]


@dataclass(frozen=True)
class ConeCut:
    """A cut at ``(1 - share) P_first + share P_second``, which replaces P_second in ``near`` and P_first in ``far``."""

    first: int
    second: int
    share: Any
    near: SubCone
    far: SubCone


LeafSearch: TypeAlias = Callable[[SubCone], Any]  # what shows all inequalities on a part; None where it is not known
Proposal: TypeAlias = Callable[[SubCone], "tuple[int, int, Any] | Violation | None"]  # where to cut: edge and share


def subdivide(
    roots: Sequence[SubCone], sought: FormsClaim, budget: int, leaf: LeafSearch, propose: Proposal | None = None
) -> Violation | UndecidedCorners | None:
    """Prove inequalities by coefficients, breadth first, within a budget; None where they are proved.

    Each part then has its node: what shows it, or its cut.

    Args:
        roots: cones that cover the cell.
        sought: what is claimed.
        budget: work that may be done, in coefficients (those of one part at least).
        leaf: what shows the inequalities on a part.
        propose: where to cut a part; where it says nothing, the longest edge is halved.
    """
    waiting = deque(roots)
    while waiting and budget > 0:
        part = waiting.popleft()
        work = part.work
        budget -= work
        take_effort(work)
        part.node = leaf(part)
        if part.node is not None:
            continue
        split = _find_violation(part, sought) or (propose(part) if propose is not None else None)
        if isinstance(split, Violation):
            return split
        if len(part.corners) == 1:  # one ray: nothing is left to cut
            return UndecidedCorners(part.corners)
        first, second, share = split or (*_edge_to_halve(part), fmpq(1, 2))
        near, far = part.with_corner(first, second, share), part.with_corner(second, first, 1 - share)
        part.node = ConeCut(first, second, share, near, far)
        waiting += (near, far)
    return UndecidedCorners(waiting[0].corners) if waiting else None


def _edge_to_halve(part: SubCone) -> tuple[int, int]:
    """The longest edge as seen in the root's barycentric coordinates, so that all parts shrink.

    Near a corner where the form is zero its sign may depend on the direction alone, and halving the longest edge would
    give similar parts for ever: every second time only edges between other corners are looked at.
    """
    corners = range(len(part.corners))
    others = [k for k in corners if face_sign(part.form, 1 << k)] if part.depth % 2 else []
    if part.depth % 2 and len(others) < 2 and any(part.guards):
        # beside a curve that ends at the origin, and zero at another corner too: halving at the origin leads nowhere
        others = [k for k in corners if any(part.corners[k][:-1])]
    return max(
        combinations(others if len(others) > 1 else corners, 2),
        key=lambda edge: sum((a - b) ** 2 for a, b in zip(part.places[edge[0]], part.places[edge[1]], strict=True)),
    )


def _find_violation(part: SubCone, sought: FormsClaim) -> Violation | None:
    """A point where an inequality without functions mu is false: a corner, inside a face, or near a direction."""
    count = len(part.corners)
    faces = sought.faces(part.corners) if sought.strict else []
    for k, (form, *pushes) in enumerate(part.values):
        for face in dict.fromkeys([*(1 << i for i in range(count)), (1 << count) - 1, *faces]) if not pushes else ():
            here = face_sign(form, face)
            if here > 0 or not (here or face in faces):
                continue
            weights = [fmpq(face >> i & 1) for i in range(count)]
            violation = _violation_at(part, sought, k, weights)
            if violation is None and here < 0 and not any(part.guards):
                violation = _violation_beside(part, sought, k, weights)
            if violation is not None:
                return violation
    return None


def _violation_beside(part: SubCone, sought: FormsClaim, k: int, weights: Sequence[fmpq]) -> Violation | None:
    """One near a direction or the origin, at which nothing is claimed itself."""
    for step in range(NEARBY_STEPS):
        for i in range(len(weights)):
            near = [w + fmpq(int(i == j), 4**step) for j, w in enumerate(weights)]
            if (violation := _violation_at(part, sought, k, near)) is not None:
                return violation
    return None


def _violation_at(part: SubCone, sought: FormsClaim, k: int, weights: Sequence[fmpq]) -> Violation | None:
    """The weighted sum of the corners, if the k-th inequality is false there, inside all guards."""
    point = tuple(_weighted(coordinates, weights) for coordinates in zip(*part.corners, strict=True))
    if not sought.is_about(point) or any(sign(value_at(guard, weights)) <= 0 for guard in part.guards[k].values()):
        return None
    here = sign(value_at(part.values[k][0], weights))
    fails = here < 0 or (sought.strict and not here)
    return Violation(point) if fails and not any(value_at(zero, weights) for zero in part.zeros.values()) else None


def _weighted(values: Sequence[Any], weights: Sequence[fmpq]) -> Any:
    """A sum; weights are mostly zero and one, and a product of long numbers is dear."""
    parts = (c if w == 1 else c * w for c, w in zip(values, weights, strict=True) if w)
    return sum(parts, 0 * values[0])


def value_at(terms: Mapping[tuple[int, ...], Any], point: Sequence[fmpq]) -> Any:
    """A polynomial at a rational point; a form in the corners of a part at a weighted sum of these."""
    monomials = [prod((x**e for x, e in zip(point, exponents, strict=True) if e), start=fmpq(1)) for exponents in terms]
    return _weighted(list(terms.values()), monomials) if terms else fmpq(0)
