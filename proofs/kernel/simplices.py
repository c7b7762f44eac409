"""The search for trees of simplices on whose leaves coefficients show an inequality, in the form the checker follows.

Each root simplex of the domain is cut first where affine guards change their sign on an edge, so that no part lies on
both sides; parts outside the cell are left.  Then the edge is halved between the corners to which the most negative
coefficient belongs, and every fourth time the longest one, so that all parts shrink.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import combinations
from typing import Any, TypeAlias

from flint import fmpq, fmpq_poly

from nonsmooth.proofs.checker.polynomials import Polynomial, unit
from nonsmooth.proofs.checker.positivity import Claim, pairs, root_simplices
from nonsmooth.proofs.inequalities.forms import multiplier
from nonsmooth.symbolic.numbers.polynomial import in_generators, with_mixture

Exponents: TypeAlias = tuple[int, ...]
Form: TypeAlias = dict[Exponents, fmpq]
Corner: TypeAlias = tuple[fmpq, ...]


LARGEST_MU = 1e6  # value of a function mu at a corner
MU_DENOMINATORS = (1 << 4, 1 << 12, 1 << 24)  # of these values, tried in turn
SLACK = 2.0**-23  # by which a coefficient that a linear program finds may be negative: exact arithmetic decides


@dataclass
class SimplexPart:
    """A simplex on its way to being shown.

    Attributes:
        corners: in homogeneous coordinates.
        values: for each inequality the forms of p and of the polynomials q.
        guards: for each inequality the forms of its guards.
        zeros: the forms of the polynomials that are zero, where there is one inequality.
        depth: the number of cuts above it.
        node: its tree, once it is known.
    """

    corners: tuple[Corner, ...]
    values: list[list[Form]]
    guards: list[dict[str, Form]]
    zeros: dict[str, Form]
    depth: int
    node: Any = field(default=None)


def search(claim: Claim, work: int) -> dict[str, Any] | None:
    """A tree for every root simplex of a claim.

    Args:
        claim: of functions mu it has at most one where polynomials are zero.
        work: coefficients that may be looked at.

    Returns:
        The evidence; None where it was not found with this work, or where the claim is false at a corner.
    """
    if len(claim.inequalities[0].pushes) == 1:
        found = [search(own, work) for own in pairs(claim)]
        return None if any(own is None for own in found) else {"pairs": found}
    if claim.inequalities[0].pushes and any(inequality.zeros for inequality in claim.inequalities):
        return None
    trees = []
    for corners in root_simplices(claim.count, bounded=claim.bounded):
        root = _root(claim, corners)
        left = _grow(claim, root, work)
        if left is None:
            return None
        work = left
        trees.append(_tree(root))
    return {"simplices": trees}


def _root(claim: Claim, corners: Sequence[Sequence[Fraction]]) -> SimplexPart:
    exact = tuple(tuple(fmpq(x.numerator, x.denominator) for x in corner) for corner in corners)
    values = [[_form(own, exact) for own in (i.value, *i.pushes)] for i in claim.inequalities]
    guards = [{name: _form(own, exact) for name, own in i.guards.items() if name[0] == "s"} for i in claim.inequalities]
    zeros = {name: _form(own, exact) for name, own in claim.inequalities[0].zeros.items()}
    return SimplexPart(exact, values, guards, zeros, 0)


def _form(value: Polynomial, corners: Sequence[Corner]) -> Form:
    """A polynomial as a form of its own degree in barycentric coordinates."""
    degree = value.degree
    terms = {(*e, degree - sum(e)): fmpq(c.numerator, c.denominator) for e, c in value.terms.items()}
    return in_generators(terms, corners)


def _grow(claim: Claim, root: SimplexPart, work: int) -> int | None:
    """Cut a root simplex until every leaf is shown; the work that is left, None where it is not shown."""
    waiting = [root]
    while waiting:
        part = waiting.pop(0)
        work -= sum(len(form) for forms in part.values for form in forms)
        if work <= 0:
            return None
        leaf = _leaf(claim, part)
        if leaf is not None:
            part.node = leaf
            continue
        if _is_refuted(claim, part):
            return None
        i, j, share = _cut(claim, part)
        near, far = _halves(part, i, j, share)
        part.node = (i, j, share, near, far)
        waiting += [near, far]
    return work


def _leaf(claim: Claim, part: SimplexPart) -> dict[str, Any] | None:
    """The multipliers with which the coefficients show all inequalities on a part."""
    asked = zip(claim.inequalities, part.guards, strict=True)
    outside = [_outside(claim, part, inequality.open, guards) for inequality, guards in asked]
    inside = [k for k, name in enumerate(outside) if name is None]
    mu = _common_mu(claim, part, inside)
    if mu is None:
        return _by_multiplier(claim, part)
    leaf: dict[str, Any] = {}
    if any(map(any, mu)):
        leaf["mu"] = [[str(value) for value in own] for own in mu]
    if any(outside):
        leaf["on"] = [{} if name is None else name for name in outside]
    return leaf


def _by_multiplier(claim: Claim, part: SimplexPart) -> dict[str, Any] | None:
    """A multiple of one guard, or of one polynomial that is zero, to take off an inequality without functions mu."""
    (own, *pushes), *others = part.values
    if pushes or others:
        return None
    for name, form in {**part.guards[0], **part.zeros}.items():
        degree = max(_degree(own), _degree(form))
        value, taken = (_raised(each, degree, part.corners) for each in (own, form))
        factor = multiplier(value, taken, signed=name not in part.zeros)
        if factor is None:
            continue
        rest = {e: value.get(e, fmpq(0)) - factor * taken.get(e, fmpq(0)) for e in {*value, *taken}}
        if not claim.strict or is_positive(claim, part.corners, rest):
            return {"on": [{name: str(factor)}]}
    return None


def _outside(claim: Claim, part: SimplexPart, free: frozenset[str], guards: dict[str, Form]) -> str | None:
    """A guard that is positive nowhere on the part."""
    for name, form in guards.items():
        if all(value <= 0 for value in form.values()):
            negated = {e: -value for e, value in form.items()}
            if name in free or is_positive(claim, part.corners, negated):
                return name
    return None


def _common_mu(claim: Claim, part: SimplexPart, inside: Sequence[int]) -> list[list[fmpq]] | None:
    """Values at the corners of affine functions mu with which the coefficients of all ``p + sum mu q`` show them.

    The functions zero are tried first; then a linear program proposes values, and exact arithmetic decides.
    """
    size, count = len(part.corners), len(part.values[0]) - 1
    nothing = [[fmpq(0)] * size for _ in range(count)]
    if all(_shows(claim, part, k, part.values[k][0]) for k in inside):
        return nothing
    for mu in _proposed_mu([part.values[k] for k in inside], part.corners, count) if count else ():
        if all(_shows(claim, part, k, _with_mu(part.values[k], mu, part.corners)) for k in inside):
            return mu
    return None


def _proposed_mu(inside: Sequence[Sequence[Form]], corners: Sequence[Corner], count: int) -> Iterator[list[list[fmpq]]]:
    """Values of mu that make the least coefficient as large as they can, rounded.

    Coefficients that no mu changes are left out; of the others, each is divided by its largest entry.
    """
    from scipy.optimize import linprog

    rows, least, size = [], [], len(corners)
    for value, *pushes in inside:
        slopes = [_times_coordinate(push, k) for push in pushes for k in range(size)]
        degree = max(_degree(form) for form in (value, *slopes))
        own, others = _raised(value, degree, corners), [_raised(slope, degree, corners) for slope in slopes]
        for e in {e for slope in others for e in slope}:
            here = float(own.get(e, fmpq(0)))
            row = [float(slope.get(e, fmpq(0))) for slope in others]
            largest = max(abs(here), *map(abs, row))
            rows.append([*(-entry / largest for entry in row), 1.0])
            least.append(here / largest)
    bounds = [(-LARGEST_MU, LARGEST_MU)] * (size * count) + [(None, 1.0)]
    found = linprog([0.0] * (size * count) + [-1.0], A_ub=rows, b_ub=least, bounds=bounds) if rows else None
    if found is None or found.x is None or found.x[-1] < -SLACK:
        return
    for denominator in MU_DENOMINATORS:
        values = [fmpq(round(float(x) * denominator), denominator) for x in found.x[:-1]]
        yield [values[j * size : (j + 1) * size] for j in range(count)]


def _with_mu(forms: Sequence[Form], mu: Sequence[Sequence[fmpq]], corners: Sequence[Corner]) -> Form:
    """The form ``p + sum mu q``."""
    parts = [forms[0]]
    for push, values in zip(forms[1:], mu, strict=True):
        for k, value in enumerate(values):
            if value:
                parts.append({e: c * value for e, c in _times_coordinate(push, k).items()})
    degree = max(map(_degree, parts))
    total: Form = {}
    for part in parts:
        for e, value in _raised(part, degree, corners).items():
            total[e] = total.get(e, fmpq(0)) + value
    return total


def _times_coordinate(form: Form, k: int) -> Form:
    return {(*e[:k], e[k] + 1, *e[k + 1 :]): value for e, value in form.items()}


def _degree(form: Form) -> int:
    return sum(next(iter(form), ()))


def _raised(form: Form, degree: int, corners: Sequence[Corner]) -> Form:
    """The same form times a power of w, the last homogeneous coordinate."""
    while form and _degree(form) < degree:
        total: Form = {}
        for e, value in form.items():
            for k, corner in enumerate(corners):
                if corner[-1]:
                    key = (*e[:k], e[k] + 1, *e[k + 1 :])
                    total[key] = total.get(key, fmpq(0)) + value * corner[-1]
        form = total
    return form


def _shows(claim: Claim, part: SimplexPart, k: int, form: Form) -> bool:
    """Whether the coefficients of a form show the k-th inequality on a part."""
    if any(value < 0 for value in form.values()):
        return False
    return not claim.strict or is_positive(claim, part.corners, form, part.guards[k].get(claim.border))


def is_positive(claim: Claim, corners: Sequence[Corner], found: Form, border: Form | None = None) -> bool:
    """Whether a form without negative coefficients is positive at all points of the part that count.

    Neither the origin, unless it is claimed, nor points at which the guard with the form ``border`` is zero count.
    """
    size = len(corners)
    points = {k for k, corner in enumerate(corners) if corner[-1]}
    free = {k for k in points if not (claim.at_origin or any(corners[k][:-1]))}
    if border is not None:
        free |= {k for k in points if not _at(border, k, size)}
    if not all(_at(found, k, size) for k in points - free):
        return False
    beside = [k for k in range(size) if k in free or k not in points]
    pairs_of = {(k, i) for k in free for i in beside if i != k}
    return all(any(value for e, value in found.items() if e[k] + e[i] == sum(e)) for k, i in pairs_of)


def _is_refuted(claim: Claim, part: SimplexPart) -> bool:
    """Whether an inequality without mu is false at a corner that lies in the closed cell."""
    size = len(part.corners)
    for k, corner in enumerate(part.corners):
        if not corner[-1] or (not any(corner[:-1]) and not claim.at_origin):
            continue
        if any(_at(form, k, size) for form in part.zeros.values()):
            continue
        for forms, guards in zip(part.values, part.guards, strict=True):
            if len(forms) > 1 or any(_at(form, k, size) <= 0 for form in guards.values()):
                continue
            here = _at(forms[0], k, size)
            if here < 0 or (claim.strict and not here):
                return True
    return False


def _at(form: Form, k: int, size: int) -> fmpq:
    return form.get(tuple(_degree(form) * int(i == k) for i in range(size)), fmpq(0))


def _cut(claim: Claim, part: SimplexPart) -> tuple[int, int, fmpq]:
    """Where to cut: an affine guard that changes its sign on an edge, else the edge of doubt, else the longest."""
    size = len(part.corners)
    for guards in part.guards:
        for form in guards.values():
            if _degree(form) != 1:
                continue
            at = [form.get(unit(size, k), fmpq(0)) for k in range(size)]
            for i, j in combinations(range(size), 2):
                if at[i] * at[j] < 0:
                    return i, j, at[i] / (at[i] - at[j])
    share = rational_root(part) if size == 2 else None
    if share is not None:
        return 0, 1, share
    edge = _edge_of_doubt(part) if part.depth % 4 < 3 else None
    if edge is None:
        edge = _longest_edge(part.corners, near=part.depth % 2 == 0)
    return (*edge, fmpq(1, 2))


def rational_root(part: SimplexPart) -> fmpq | None:
    """Where a polynomial vanishes inside an interval, as a share of it: halving alone would never meet that place."""
    forms = [form for own in part.values for form in own[:1]] + [form for own in part.guards for form in own.values()]
    for form in forms:
        if not (any(value > 0 for value in form.values()) and any(value < 0 for value in form.values())):
            continue
        top = _degree(form)
        ratio = fmpq_poly([form.get((top - k, k), fmpq(0)) for k in range(top + 1)])  # in t_1 / t_0
        for factor, _ in ratio.numer().factor()[1]:
            if factor.degree() == 1 and (root := fmpq(-int(factor[0]), int(factor[1]))) > 0:
                return root / (1 + root)
    return None


def _edge_of_doubt(part: SimplexPart) -> tuple[int, int] | None:
    """Between the two corners to which the most negative coefficient of a p belongs most."""
    lowest, place = fmpq(0), None
    for forms in part.values:
        for e, value in forms[0].items():
            if value < lowest:
                lowest, place = value, e
    if place is None:
        return None
    first, second = sorted(range(len(place)), key=lambda k: -place[k])[:2]
    return (first, second) if place[second] else None


def _longest_edge(corners: Sequence[Corner], *, near: bool) -> tuple[int, int]:
    """The longest edge where the space is drawn into a cube; every second time one that does not end at the origin."""
    places = []
    for corner in corners:
        size = max(map(abs, corner))
        places.append([float(x / size) for x in corner[:-1]])
    edges = list(combinations(range(len(corners)), 2))
    away = [edge for edge in edges if all(any(corners[k][:-1]) for k in edge)]
    return max(
        away if near and away else edges,
        key=lambda edge: sum((a - b) ** 2 for a, b in zip(places[edge[0]], places[edge[1]], strict=True)),
    )


def _halves(part: SimplexPart, i: int, j: int, share: fmpq) -> tuple[SimplexPart, SimplexPart]:
    middle = tuple((1 - share) * a + share * b for a, b in zip(part.corners[i], part.corners[j], strict=True))
    return _half(part, j, i, share, middle), _half(part, i, j, 1 - share, middle)


def _half(part: SimplexPart, moved: int, kept: int, share: fmpq, middle: Corner) -> SimplexPart:
    def cut(form: Form) -> Form:
        return with_mixture(form, kept, moved, 1 - share, share)

    corners = (*part.corners[:moved], middle, *part.corners[moved + 1 :])
    values = [list(map(cut, forms)) for forms in part.values]
    guards = [{name: cut(form) for name, form in own.items()} for own in part.guards]
    zeros = {name: cut(form) for name, form in part.zeros.items()}
    return SimplexPart(corners, values, guards, zeros, part.depth + 1)


def _tree(root: SimplexPart) -> Any:
    """The tree below a part, as certificates write it."""
    if isinstance(root.node, dict):
        return root.node
    i, j, share, near, far = root.node
    return [i, j, str(share), _tree(near), _tree(far)]
