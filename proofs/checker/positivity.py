"""Inequalities between polynomials, and the kinds of evidence that show them; none is searched for here.

An *inequality* says ``p + sum_j mu_j q_j > 0`` at the points of a domain at which all guards g are ``>= 0`` and all
polynomials of a second list are zero.  A *claim* is a list of inequalities for which there are common functions mu, of
the place and not necessarily continuous.  The domain is the cube ``|z_k| <= 1`` or the whole space.  A claim is strict
(``>``) or not (``>=``), and a strict one leaves out the origin or does not.

*squares*: for each inequality ``p + sum_j mu_j q_j = sum_i G_i m_i^T Q_i m_i + sum_j r_j h_j``, products G of guards,
vectors m of monomials, positive semidefinite matrices Q, any polynomials r times the polynomials h that are zero, and
polynomials mu (Putinar 1993).  It is strict if one G is 1, this Q is definite, and its monomials vanish together at the
origin only, or nowhere.

*simplices*: the domain is a fixed union of simplices, whose corners may be directions.  A tree cuts each of them at
points of its edges.  On each leaf affine functions mu and numbers ``lambda_g >= 0`` and ``nu_h`` are given for which
the coefficients of ``p + sum mu q - sum lambda g - sum nu h`` in barycentric coordinates are not negative.  It is
strict if they are positive at all corners but the origin, and on every edge from the origin to a direction.  Or a guard
is named that has no positive coefficient: the open cell has no point on the leaf, and its closure lies in the others.

*pairs*: for a claim with one function mu, evidence of the claims that say that one exists (:func:`pairs`).

*mixture*: numbers lambda for which ``p - sum lambda g`` is affine, with its least value on the domain not negative.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from itertools import permutations, product
from math import comb, lcm, prod
from typing import Any, TypeAlias

from .polynomials import MAX_DEGREE, Coefficient, Coefficients, Exponents, Polynomial, collect, constant, unit, variable
from .tower import Field, Number
from .work import BUDGET, bits, items, longest, product_cost, rational, require, take, whole

MAX_SQUARES, MAX_ROWS, MAX_FACTORS = 400, 200, 4
MAX_CUBE = 4  # dimensions in which the cube is cut into simplices

Corner: TypeAlias = tuple[Coefficient, ...]  # (z_1, ..., z_n, w): the point z / w, or the direction z where w = 0


@dataclass(frozen=True)
class Inequality:
    """``p + sum_j mu_j q_j > 0`` where guards are not negative and some polynomials are zero.

    Attributes:
        value: p.
        guards: by name.
        pushes: the polynomials q.
        zeros: the polynomials h that are zero, by name.
        side: of the field that the inequality is about, on a face.
        weak: other values, which the mixtures that matter make zero.
        open: guards by name that count where they are positive; the closure of these points is what matters.
    """

    value: Polynomial
    guards: Mapping[str, Polynomial]
    pushes: tuple[Polynomial, ...] = ()
    zeros: Mapping[str, Polynomial] = field(default_factory=dict)
    side: tuple[int, ...] = ()
    weak: tuple[Polynomial, ...] = ()
    open: frozenset[str] = frozenset()


@dataclass(frozen=True)
class Claim:
    """Inequalities with common functions mu.

    Attributes:
        name: that of its evidence in the certificate.
        inequalities: all in the same variables.
        strict: whether ``> 0`` is claimed.
        at_origin: whether a strict claim includes the origin.
        bounded: whether the domain is the cube, not the whole space.
        border: the name of a guard; where it is zero nothing is claimed strictly.  Empty without one.
    """

    name: str
    inequalities: tuple[Inequality, ...]
    strict: bool
    at_origin: bool = False
    bounded: bool = True
    border: str = ""

    @property
    def count(self) -> int:
        """The number of variables."""
        return self.inequalities[0].value.count

    def number(self, data: Any) -> Coefficient:
        """A number of its evidence: in the field of its own irrational numbers, if it has any."""
        return rational(data) if type(data) is str or self.field is None else self.field.parse(data)

    @cached_property
    def field(self) -> Field | None:
        """That of its irrational numbers; None where all are rational."""
        polynomials = (
            p for i in self.inequalities for p in (i.value, *i.guards.values(), *i.pushes, *i.zeros.values())
        )
        return next((c.field for p in polynomials for c in p.terms.values() if type(c) is Number), None)

    @property
    def is_homogeneous(self) -> bool:
        """Whether it says of a place what it says of all its positive multiples, the bounds of the cube left aside.

        All polynomials are forms; and where ``p + sum mu q > 0`` at a place, mu times powers of the distance do it at
        its multiples.  The same is asked of the values that mixtures make zero.
        """
        for inequality in self.inequalities:
            surfaces = [guard for name, guard in inequality.guards.items() if name[0] == "s"]
            if not all(form.is_form for form in (inequality.value, *inequality.weak, *inequality.pushes, *surfaces)):
                return False
        values = zip(*((inequality.value, *inequality.weak) for inequality in self.inequalities), strict=True)
        pushes = [inequality.pushes for inequality in self.inequalities]
        return all(scale_together([(one, *q) for one, q in zip(column, pushes, strict=True)]) for column in values)


def scale_together(rows: Sequence[Sequence[Polynomial]]) -> bool:
    """Whether forms have one degree in every row, once that of each column is raised by a number of its own.

    The numbers are those of the functions mu.  A form that is zero has any degree; so rows with a common column are
    followed from one to the next, and one that has none in common with those before begins anew.
    """
    raised: dict[int, int] = {}  # the numbers that are known, by columns
    waiting = list({tuple((k, form.degree) for k, form in enumerate(row) if form): None for row in rows})
    while waiting:
        row = next((candidate for candidate in waiting if any(k in raised for k, _ in candidate)), waiting[0])
        waiting.remove(row)
        whole_degree = next((degree + raised[k] for k, degree in row if k in raised), 0)
        for k, degree in row:
            if raised.setdefault(k, whole_degree - degree) != whole_degree - degree:
                return False
    return True


def show(claim: Claim, evidence: Any) -> None:
    """Show a claim by its evidence.

    Raises:
        RejectedError: where the evidence does not show it.
    """
    kinds = [kind for kind in KINDS if type(evidence) is dict and kind in evidence]
    require(len(kinds) == 1, f"evidence of {claim.name}")
    KINDS[kinds[0]](claim, evidence)


class Proofs:
    """The evidence of claims, by name; each is used once, and whether all were about forms is noted."""

    def __init__(self, data: Any) -> None:
        require(type(data) is dict, "proofs by name")
        self.left, self.are_forms = dict(data), True

    def evidence(self, name: str) -> Any:
        """The evidence of a name, once."""
        require(name in self.left, f"a proof of {name}")
        return self.left.pop(name)

    def evidence_if_any(self, name: str) -> Any:
        """The same; None where there is none."""
        return self.left.pop(name, None)

    def show(self, claim: Claim) -> None:
        """Show a claim by the evidence of its name."""
        show(claim, self.evidence(claim.name))
        self.note_form(claim)

    def shows(self, claim: Claim) -> bool:
        """Show a claim that nothing needs, if there is evidence of its name; whether there is."""
        if claim.name not in self.left:
            return False
        self.show(claim)
        return True

    def note_form(self, claim: Claim) -> None:
        """Note whether a claim that was shown is about forms."""
        self.are_forms = self.are_forms and claim.is_homogeneous

    def of_part(self, data: Any) -> Proofs:
        """The evidence of a theorem about a part of the subject."""
        return Proofs(data)

    def require_used(self) -> None:
        """Nothing is left over."""
        require(not self.left, "proofs of claims that are asked")


def pairs(claim: Claim) -> Iterator[Claim]:
    """The claims that say that a function mu exists, where there is one: ``p_i |q_j| + p_j |q_i| > 0``.

    Where ``q_i > 0 > q_j`` the inequalities i and j bound mu from below and from above; this is that the bounds leave
    room.  It is that V falls along the mixture of two fields that is tangent to the face.  Where q_i is zero, or both
    fields belong to one side, the claims about closed cells say enough.
    """
    require(all(len(inequality.pushes) == 1 for inequality in claim.inequalities), "one function mu")
    for (i, a), (j, b) in permutations(enumerate(claim.inequalities), 2):
        if a.side == b.side:
            continue
        rise, fall = a.pushes[0], -b.pushes[0]
        guards = {**a.guards, **{f"{name}'": guard for name, guard in b.guards.items()}, "sp": rise, "sq": fall}
        for k, (value, other) in enumerate(zip(a.weak, b.weak, strict=True)):
            guards[f"sv{k}"] = -(value * fall + other * rise)
        room = Inequality(a.value * fall + b.value * rise, guards, zeros=a.zeros, open=frozenset(("sp", "sq")))
        yield Claim(f"{claim.name} pair {i} {j}", (room,), claim.strict, claim.at_origin, claim.bounded, claim.border)


def _show_by_pairs(claim: Claim, evidence: Any) -> None:
    (listed,) = take(evidence, "pairs")
    claims = list(pairs(claim))
    for one, proof in zip(claims, items(listed, len(claims)), strict=True):
        show(one, proof)


# ---- sums of squares ---------------------------------------------------------------------------


def _show_by_squares(claim: Claim, evidence: Any) -> None:
    squares, mu = take(evidence, "squares", "mu")
    size = len(claim.inequalities[0].pushes)
    functions = [read_polynomial(function_data, claim.count) for function_data in items(mu or [], size)]
    for inequality, listed in zip(claim.inequalities, items(squares, len(claim.inequalities)), strict=True):
        polynomial = inequality.value
        for function, push in zip(functions, inequality.pushes, strict=True):
            polynomial += function * push
        total, positive = constant(claim.count, 0), False
        for entry in items(listed, most=MAX_SQUARES):
            if type(entry) is dict and "zero" in entry:
                name, factor = take(entry, "zero factor")
                require(name in inequality.zeros, "polynomials that are zero")
                total += read_polynomial(factor, claim.count) * inequality.zeros[name]
                continue
            square = Square(entry, claim.count)
            total += square.expanded(inequality.guards)
            definite = square.rank() == len(square.gram) and not square.guards
            positive = positive or (definite and square.separates(at_origin=claim.at_origin))
        require(total == polynomial, f"a sum of squares that is the polynomial of {claim.name}")
        require(positive or not claim.strict, f"a positive square for {claim.name}")


def read_polynomial(data: Any, count: int) -> Polynomial:
    """A polynomial as a list of pairs of coefficient and exponents."""
    terms: dict[Exponents, Fraction] = {}
    for entry in items(data):
        value, exponents = items(entry, 2)
        key = tuple(whole(k, MAX_DEGREE) for k in items(exponents, count))
        collect(terms, key, rational(value))
    return Polynomial(count, terms)


class Square:
    """``G m^T Q m``: a product of guards, monomials, and the rows of Q up to the diagonal."""

    def __init__(self, data: Any, count: int) -> None:
        guards, monomials, gram = take(data, "guards monomials gram")
        self.count, self.guards = count, items(guards, most=MAX_FACTORS)
        self.monomials = [
            tuple(whole(k, MAX_DEGREE) for k in items(monomial, count)) for monomial in items(monomials, most=MAX_ROWS)
        ]
        rows = items(gram, len(self.monomials))
        self.gram = [[rational(value) for value in items(row, i + 1)] for i, row in enumerate(rows)]

    def expanded(self, guards: Mapping[str, Polynomial]) -> Polynomial:
        """The polynomial that it is."""
        total: dict[Exponents, Fraction] = {}
        BUDGET.spend(1 + len(self.gram) ** 2)
        for i, row in enumerate(self.gram):
            for j, value in enumerate(row):
                key = tuple(map(int.__add__, self.monomials[i], self.monomials[j]))
                collect(total, key, value if i == j else 2 * value)
        expanded = Polynomial(self.count, total)
        for name in self.guards:
            require(type(name) is str and name in guards, "guards that hold there")
            expanded *= guards[name]
        return expanded

    def rank(self) -> int:
        """The rank of Q, by elimination without fractions (Bareiss 1968).

        Raises:
            RejectedError: unless Q is positive semidefinite: every pivot is positive, or zero with the rest of its row.
        """
        values = [value for row in self.gram for value in row]
        BUDGET.spend(1 + len(values) * (1 + longest(values) ** 2 // 4096))
        bottom = common_denominator(values)
        BUDGET.spend(len(values) * product_cost(bottom.bit_length(), longest(values)))
        rest = [[int(value * bottom) for value in row] for row in self.gram]
        size, before, rank = len(rest), 1, 0
        for k in range(size):
            pivot = rest[k][k]
            require(pivot > 0 or not any(rest[i][k] for i in range(k, size)), "positive semidefinite matrices")
            if not pivot:
                continue
            BUDGET.spend((size - k) ** 2 * (1 + pivot.bit_length() ** 2 // 2048))
            for i in range(k + 1, size):
                for j in range(k + 1, i + 1):
                    rest[i][j] = (pivot * rest[i][j] - rest[i][k] * rest[j][k]) // before
            before = pivot
            rank += 1
        return rank

    def separates(self, *, at_origin: bool) -> bool:
        """Whether the monomials vanish together nowhere, or, where that is enough, at the origin only."""
        if any(not any(m) for m in self.monomials):
            return True
        alone = {next(k for k, e in enumerate(m) if e) for m in self.monomials if sum(map(bool, m)) == 1}
        return not at_origin and len(alone) == self.count


# ---- simplices ---------------------------------------------------------------------------------


def root_simplices(count: int, *, bounded: bool) -> Iterator[tuple[Corner, ...]]:
    """The simplices that the domain consists of; each has the origin as its first corner.

    The cube in n variables: ``2^n n!``, for signs s and orders k of the axes with the corners
    ``0, s_k1 e_k1, s_k1 e_k1 + s_k2 e_k2, ...``.  The space: ``2^n``, for signs s with the directions ``s_k e_k``.
    """
    require(count <= MAX_CUBE, f"simplices in at most {MAX_CUBE} variables")
    origin = (*[Fraction(0)] * count, Fraction(1))
    for signs in product((1, -1), repeat=count):
        steps = [tuple(Fraction(s * e) for e in unit(count, k)) for k, s in enumerate(signs)]
        if not bounded:
            yield (origin, *((*step, Fraction(0)) for step in steps))
            continue
        for order in permutations(range(count)):
            corners = [origin]
            for k in order:
                moved = (a + b for a, b in zip(corners[-1][:count], steps[k], strict=True))
                corners.append((*moved, Fraction(1)))
            yield tuple(corners)


def _show_by_simplices(claim: Claim, evidence: Any) -> None:
    (trees,) = take(evidence, "simplices")
    roots = list(root_simplices(claim.count, bounded=claim.bounded))
    for corners, tree in zip(roots, items(trees, len(roots)), strict=True):
        _show_on_simplex(claim, corners, tree)


def _show_on_simplex(claim: Claim, corners: tuple[Corner, ...], tree: Any) -> None:
    """Follow the tree of one simplex: a cut is ``[i, j, t, near, far]``, a leaf an object with multipliers.

    The new corner is ``(1 - t) P_i + t P_j``; it takes the place of ``P_j`` in the near part and of ``P_i`` in the far.
    """
    waiting = [(corners, [Forms(inequality, corners) for inequality in claim.inequalities], tree)]
    while waiting:
        corners, forms, node = waiting.pop()
        if type(node) is dict:
            _show_on_leaf(claim, corners, forms, node)
            continue
        first, second, share, near, far = items(node, 5)
        i, j, t = whole(first, claim.count), whole(second, claim.count), claim.number(share)
        require(i != j and 0 < t < 1, "cuts inside an edge")
        BUDGET.spend(1 + len(corners) * product_cost(longest((*corners[i], *corners[j])), bits(t)))
        middle = tuple((1 - t) * a + t * b for a, b in zip(corners[i], corners[j], strict=True))
        waiting.append((_replaced(corners, j, middle), [group.cut(j, i, t) for group in forms], near))
        waiting.append((_replaced(corners, i, middle), [group.cut(i, j, 1 - t) for group in forms], far))


def _replaced(corners: tuple[Corner, ...], k: int, corner: Corner) -> tuple[Corner, ...]:
    return (*corners[:k], corner, *corners[k + 1 :])


class Forms:
    """The polynomials of an inequality as forms in the barycentric coordinates of a simplex, each of its own degree.

    Those of p and of the polynomials q follow the cuts; a guard is looked at only where a leaf names it.
    """

    def __init__(self, inequality: Inequality, corners: Sequence[Corner]) -> None:
        self.inequality = inequality
        self.named = {**inequality.guards, **inequality.zeros}
        self.forms = [barycentric(polynomial, corners) for polynomial in (inequality.value, *inequality.pushes)]

    def cut(self, moved: int, kept: int, share: Coefficient) -> Forms:
        """On the part whose corner ``moved`` is ``share`` of itself and the rest of the corner ``kept``."""
        part = object.__new__(Forms)
        part.inequality, part.named = self.inequality, self.named
        part.forms = [cut_form(form, moved, kept, share) for form in self.forms]
        return part

    def combined(
        self, mu: Sequence[Sequence[Coefficient]], multipliers: Mapping[str, Coefficient], corners: Sequence[Corner]
    ) -> Coefficients:
        """The coefficients of ``p + sum mu q - sum lambda g - sum nu h``, all raised to one degree by powers of w.

        Functions mu are given by their values at the corners.
        """
        parts: list[tuple[Coefficients, Coefficient, int | None]] = [(self.forms[0], Fraction(1), None)]
        for values, form in zip(mu, self.forms[1:], strict=False):
            parts += [(form, value, k) for k, value in enumerate(values)]
        for name, factor in multipliers.items():
            parts.append((barycentric(self.named[name], corners), -factor, None))
        degree = max(degree_of(form) + (k is not None) for form, factor, k in parts if factor)
        total = Coefficients()
        for form, factor, k in parts:
            if factor:
                add(total, raised(form, degree - (k is not None), corners), factor, k)
        return total

    def is_outside(self, name: str, claim: Claim, corners: Sequence[Corner]) -> bool:
        """Whether a guard is positive nowhere on the simplex, and where it is not open zero nowhere either."""
        negated = {e: -value for e, value in barycentric(self.named[name], corners).items()}
        below = all(value >= 0 for value in negated.values())
        return below and (name in self.inequality.open or _is_positive(claim, corners, negated))


def degree_of(form: Coefficients) -> int:
    """The degree of a form."""
    return sum(next(iter(form), ()))


def barycentric(value: Polynomial, corners: Sequence[Corner]) -> Coefficients:
    """A polynomial p of degree d as the form ``w^d p(z / w)`` of the coordinates t with ``(z, w) = sum_k t_k P_k``.

    In whole numbers it is computed of p times a common denominator, and of corners times denominators of their own.
    """
    degree, size, columns = value.degree, len(corners), range(value.count + 1)
    terms = {(*e, degree - sum(e)): c for e, c in value.terms.items()}
    if any(type(c) is Number for numbers in (value.terms.values(), *corners) for c in numbers):
        lines = [Polynomial(size, {unit(size, k): corner[i] for k, corner in enumerate(corners)}) for i in columns]
        return dict(Polynomial(value.count + 1, terms).on(lines, size).terms)
    bottom = common_denominator(terms.values())
    scales = [common_denominator(corner) for corner in corners]
    whole_corners = [[int(x * scale) for x in corner] for corner, scale in zip(corners, scales, strict=True)]
    coordinates = [{k: corner[i] for k, corner in enumerate(whole_corners) if corner[i]} for i in columns]
    form = _substituted({e: int(c * bottom) for e, c in terms.items()}, coordinates, (0,) * size)
    lengths = max(map(int.bit_length, form.values()), default=0), bottom.bit_length()
    BUDGET.spend(len(form) * product_cost(lengths[0], lengths[1] + degree * max(map(int.bit_length, scales))))
    return {e: Fraction(c, bottom * prod(map(pow, scales, e))) for e, c in form.items()}


def common_denominator(values: Iterable[Fraction]) -> int:
    """Of some rational numbers."""
    bottom = 1
    for value in values:
        BUDGET.spend(product_cost(bottom.bit_length(), bits(value)))
        bottom = lcm(bottom, value.denominator)
    return bottom


def _substituted(
    terms: Mapping[Exponents, int], coordinates: Sequence[Mapping[int, int]], still: Exponents
) -> dict[Exponents, int]:
    """A polynomial in whole numbers where the variables are linear forms, by Horner's scheme in one after the other.

    Args:
        terms: by the exponents of all variables.
        coordinates: the coefficients of each linear form by the numbers of its variables.
        still: the exponents of a number.
    """
    if not terms:
        return {}
    if not coordinates:
        return {still: sum(terms.values())}
    by_exponent: dict[int, dict[Exponents, int]] = {}
    for (first, *others), c in terms.items():
        by_exponent.setdefault(first, {})[tuple(others)] = c
    total: dict[Exponents, int] = {}
    for exponent in range(max(by_exponent), -1, -1):
        lengths = [max(map(int.bit_length, form.values()), default=0) for form in (total, coordinates[0])]
        BUDGET.spend(1 + len(total) * len(coordinates[0]) * product_cost(*lengths))
        times: dict[Exponents, int] = {}
        for e, c in total.items():
            for k, factor in coordinates[0].items():
                key = (*e[:k], e[k] + 1, *e[k + 1 :])
                times[key] = times.get(key, 0) + c * factor
        total = times
        for e, c in _substituted(by_exponent.get(exponent, {}), coordinates[1:], still).items():
            total[e] = total.get(e, 0) + c
    return {e: c for e, c in total.items() if c}


def raised(form: Coefficients, degree: int, corners: Sequence[Corner]) -> Coefficients:
    """A form times the power of w that gives it a larger degree."""
    for _ in range(degree - degree_of(form) if form else 0):
        total = Coefficients()
        for k, corner in enumerate(corners):
            add(total, form, corner[-1], k)
        form = total
    return form


def add(total: Coefficients, form: Coefficients, factor: Coefficient, k: int | None = None) -> None:
    """Add a multiple of a form, times the k-th coordinate where one is given."""
    if not factor:
        return
    BUDGET.spend(len(form) * product_cost(longest(form.values()), bits(factor)))
    for e, value in form.items():
        collect(total, e if k is None else (*e[:k], e[k] + 1, *e[k + 1 :]), factor * value)


def cut_form(form: Coefficients, moved: int, kept: int, share: Coefficient) -> Coefficients:
    """The form after ``t_kept -> t_kept + (1 - share) t_moved`` and ``t_moved -> share t_moved``."""
    degree = degree_of(form)
    BUDGET.spend(1 + len(form) * (1 + degree) * product_cost(longest(form.values()), degree * bits(share)))
    rest, coefficients = 1 - share, Coefficients()
    for exponents, value in form.items():
        top, power = exponents[kept], exponents[moved]
        scaled = value * share**power
        for k in range(top + 1):
            key = list(exponents)
            key[kept], key[moved] = top - k, power + k
            collect(coefficients, tuple(key), scaled * comb(top, k) * rest**k)
    return coefficients


def _show_on_leaf(claim: Claim, corners: Sequence[Corner], forms: Sequence[Forms], leaf: Any) -> None:
    mu_data, listed = take(leaf, "", "mu on")
    listed_mu = items(mu_data, len(forms[0].inequality.pushes)) if mu_data else []
    mu = [[claim.number(value) for value in items(values, len(corners))] for values in listed_mu]
    for group, data in zip(forms, items(listed, len(forms)) if listed else [{}] * len(forms), strict=True):
        if type(data) is str:
            require(
                data in group.inequality.guards and group.is_outside(data, claim, corners),
                f"a guard that is negative, for {claim.name}",
            )
            continue
        require(type(data) is dict and set(data) <= set(group.named), "multipliers of guards that hold there")
        multipliers = {name: claim.number(value) for name, value in data.items()}
        signed = group.inequality.guards
        require(all(v >= 0 for name, v in multipliers.items() if name in signed), "multipliers that are not negative")
        form = group.combined(mu, multipliers, corners)
        require(all(value >= 0 for value in form.values()), f"coefficients that are not negative, for {claim.name}")
        border = barycentric(group.named[claim.border], corners) if claim.border in group.named else None
        positive = not claim.strict or _is_positive(claim, corners, form, border)
        require(positive, f"positive coefficients for {claim.name}")


def _is_positive(
    claim: Claim, corners: Sequence[Corner], form: Coefficients, border: Coefficients | None = None
) -> bool:
    """Whether a form without negative coefficients is positive at all points of a simplex that count.

    The origin may not count, nor do points at which the guard with the form ``border`` is zero.  At a point the
    coordinates are positive for some set of corners, one of them no direction.  Such a set holds a corner that counts,
    or it is one corner that does not, or it holds one of these with another one or with a direction.
    """
    points = {k for k, corner in enumerate(corners) if corner[-1]}
    free = {k for k in points if not (claim.at_origin or any(corners[k][:-1]))}
    if border is not None:
        free |= {k for k in points if not border.get(_at_corner(border, k, len(corners)))}
    if not all(form.get(_at_corner(form, k, len(corners))) for k in points - free):
        return False
    beside = [k for k in range(len(corners)) if k in free or k not in points]
    pairs_of = {(k, i) for k in free for i in beside if i != k}
    return all(any(value for e, value in form.items() if e[k] + e[i] == sum(e)) for k, i in pairs_of)


def _at_corner(form: Coefficients, k: int, size: int) -> Exponents:
    """The exponents of the coefficient that is the value at a corner."""
    return tuple(degree_of(form) * e for e in unit(size, k))


# ---- mixtures ----------------------------------------------------------------------------------


def _show_by_mixture(claim: Claim, evidence: Any) -> None:
    (mixtures,) = take(evidence, "mixture")
    for inequality, data in zip(claim.inequalities, items(mixtures, len(claim.inequalities)), strict=True):
        require(type(data) is dict and not inequality.pushes, "multipliers by guard")
        total = inequality.value
        for name, value in data.items():
            factor = claim.number(value)
            require(name in inequality.guards and factor >= 0, "multipliers of guards, not negative")
            total += inequality.guards[name].times(-factor)
        require(total.degree <= 1, f"an affine mixture for {claim.name}")
        slopes = [abs(total.slope(k)) for k in range(total.count)]
        require(claim.bounded or not any(slopes), f"a mixture that is bounded for {claim.name}")
        least = total.at_origin - sum(slopes)
        require(least > 0 or (not claim.strict and not least), f"a mixture that is not negative, for {claim.name}")


def cube_guards(coordinates: Sequence[Polynomial], count: int) -> dict[str, Polynomial]:
    """The guards of the cube for affine coordinates: ``1 - z_k^2``, ``1 - z_k`` and ``1 + z_k``, named b, u and d."""
    one, guards = constant(count, 1), {}
    for k, form in enumerate(coordinates):
        if form.degree:
            guards.update({f"b{k}": one - form * form, f"u{k}": one - form, f"d{k}": one + form})
    return guards


def identity(count: int) -> tuple[Polynomial, ...]:
    """The variables themselves."""
    return tuple(variable(count, k) for k in range(count))


# The kinds of evidence by the keys of their objects; a new one is a function and a line here.
KINDS: dict[str, Callable[[Claim, Any], None]] = {
    "squares": _show_by_squares,
    "simplices": _show_by_simplices,
    "pairs": _show_by_pairs,
    "mixture": _show_by_mixture,
}
