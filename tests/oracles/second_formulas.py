"""Numbers, formulas and evidence of certificates, read by docs/specification.md alone: for the second checker."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from itertools import permutations, product
from typing import Any, TypeAlias

from flint import Ordering, ctx, fmpq, fmpq_mat, fmpq_mpoly, fmpq_mpoly_ctx, fmpq_series

SIZE = 9  # variables: those of eight states, of a face, or the coordinates in a simplex
RING = fmpq_mpoly_ctx.get(tuple("abcdefghi"), Ordering.lex)
GENS, ZERO, ONE = RING.gens(), RING.constant(0), RING.constant(1)
TOKEN = re.compile(r"(?:\d[\d_]*\.?[\d_]*|\.\d[\d_]*)(?:[eE][+-]?\d{1,3})?|[A-Za-z]\w*|\*\*|[-+*/(),]")
Poly: TypeAlias = fmpq_mpoly
SignOf: TypeAlias = Callable[[Poly], int]


class RefusedError(ValueError):
    """What a certificate does not show."""


def need(holds: object, what: str) -> None:
    if not holds:
        raise RefusedError(what)


def number(data: Any) -> fmpq:
    need(type(data) is str and re.fullmatch(r"-?[0-9]{1,4000}(/[0-9]{1,4000})?", data), "a number")
    top, _, bottom = data.partition("/")
    need(not bottom or int(bottom), "a number")
    return fmpq(int(top), int(bottom or 1))


def keys(data: Any, names: str, more: str = "") -> list[Any]:
    need(type(data) is dict and set(names.split()) <= set(data) <= {*names.split(), *more.split()}, f"keys {names}")
    return [data[name] for name in names.split()]


def terms(p: Poly) -> list[tuple[tuple[int, ...], fmpq]]:
    return [(tuple(map(int, e)), c) for e, c in p.to_dict().items()]


def degree(p: Poly) -> int:
    return max((sum(e) for e, _ in terms(p)), default=0)


def at_zero(p: Poly) -> fmpq:
    """The value where all variables are zero."""
    return p.to_dict().get((0,) * SIZE, fmpq(0))


# ---- formulas ------------------------------------------------------------------------------------


WAVES = {"sin": (5, 2), "cos": (6, 2), "tanh": (5, 2), "atan": (5, 2), "exp": (2, 1)}  # the power with e, and the step
Tree: TypeAlias = tuple[Any, ...]  # what is done, and to what: trees, but a name or a number


class Formula:
    """A formula by the grammar of the page, and its values."""

    def __init__(self, text: Any) -> None:
        need(type(text) is str and len(text) <= 4000 and not re.search(r"[^A-Za-z0-9_.+*/(), -]", text), "a formula")
        self.rest = [*TOKEN.findall(text), ""]
        need("".join(self.rest) == text.replace(" ", ""), "a formula")
        self.tree = self.sum()
        need(self.rest == [""], "the end of a formula")

    def take(self, *wanted: str) -> str:
        return self.rest.pop(0) if self.rest[0] in wanted else ""

    def sum(self) -> Tree:
        tree = self.term()
        while sign := self.take("+", "-"):
            tree = (sign, tree, self.term())
        return tree

    def term(self) -> Tree:
        tree = self.factor()
        while sign := self.take("*", "/"):
            tree = (sign, tree, self.factor())
        return tree

    def factor(self) -> Tree:
        if sign := self.take("+", "-"):
            return (sign, self.factor())
        atom = self.atom()
        return ("**", atom, self.exponent()) if self.take("**") else atom

    def exponent(self) -> int:
        token = self.rest.pop(0)
        if token == "(":
            value = self.exponent()
            need(self.take(")"), "a bracket")
            return value
        need(re.fullmatch("0|[1-9][0-9]?", token) and int(token) <= 40, "an exponent")
        return int(token)

    def atom(self) -> Tree:
        token = self.rest.pop(0)
        if token == "(" or (token[:1].isalpha() and self.take("(")):
            parts = [self.sum()]
            while token != "(" and self.take(","):
                parts.append(self.sum())
            need(self.take(")"), "a bracket")
            return parts[0] if token == "(" else (token, *parts)
        if token[:1].isalpha():
            return ("name", token)
        mantissa, _, power = token.replace("_", "").lower().partition("e")
        before, _, after = mantissa.partition(".")
        need((before + after).isdecimal(), "a number in a formula")
        need(not re.fullmatch("0[0-9_]*[1-9][0-9_]*", token), "whole numbers that begin with no 0")
        need(not re.search("_(?![0-9])|(?<![0-9])_", token), "digits around underscores")
        return ("number", fmpq(int(before + after), 10 ** len(after)) * fmpq(10) ** int(power or 0))


def waves_in(*trees: Any) -> list[Tree]:
    """Those under the fewest operations first, and from left to right."""
    found, level = list[Tree](), [own for own in trees if type(own) is tuple]
    while level:
        found += [own for own in level if own[0] in WAVES]
        level = [part for own in level for part in own[1:] if type(part) is tuple]
    return found


@cache
def taylor(kind: str) -> list[fmpq]:
    """The coefficients of a wave's Taylor series at 0, by FLINT."""
    before, ctx.cap = ctx.cap, 20
    try:
        return list(getattr(fmpq_series([0, 1], prec=20), kind)())
    finally:
        ctx.cap = before


def sense(tree: Tree) -> int:
    """1 where a formula has no negative value as it is written, -1 where it has no positive one, else 0."""
    kind, *parts = tree
    if kind in ("number", "Abs") or (kind == "**" and parts[1] % 2 == 0):
        return 1
    senses = [sense(own) for own in parts] if kind in ("+", "-", "*", "/") else [0]
    if kind in ("*", "/"):
        return senses[0] * senses[1]
    last = senses[-1] * (-1 if kind == "-" else 1)
    return last if last == senses[0] or len(senses) == 1 else 0


class Reading:
    """Values of formulas where names, the signs of switching expressions and the ends of waves are known."""

    def __init__(self, names: Mapping[str, Poly], sign_of: SignOf | None = None, order: int = 0) -> None:
        self.names, self.sign_of, self.order = names, sign_of, order

    def value(self, text: Any) -> Poly:
        """Of a formula without waves."""
        tree = Formula(text).tree
        need(not waves_in(tree), "sines and cosines in right-hand sides alone")
        return self.of_tree(tree, [])

    def fields(self, side: Sequence[Any]) -> Iterator[list[Poly]]:
        """A right-hand side with all its waves at both ends, the last one's changing first."""
        trees = [Formula(own).tree for own in side]
        waves = [waves_in(own) for own in trees]
        need(sum(map(len, waves)) <= 5, "at most five sines and cosines")
        for ends in product((0, 1), repeat=sum(map(len, waves))):
            rest = iter(ends)
            marked = [[(wave, next(rest)) for wave in found] for found in waves]
            yield [self.of_tree(own, known) for own, known in zip(trees, marked, strict=True)]

    def of_tree(self, tree: Tree, ends: list[tuple[Tree, int]]) -> Poly:
        kind, *parts = tree
        if kind == "name":
            need(parts[0] in self.names, "a name of a state")
            return self.names[parts[0]]
        if kind == "number":
            return RING.constant(parts[0])
        if kind in WAVES:
            need(len(parts) == 1 and not waves_in(*parts), f"arguments of {kind}")
            need(kind != "exp" or sense(parts[0]) < 0, "exp of what is not positive")
            end = next(own for wave, own in ends if wave is tree)
            return self.wave(kind, self.of_tree(parts[0], []), end)
        need(kind in "+-*/" or not waves_in(*parts), "sines and cosines in sums and products")
        if kind == "**":
            return self.of_tree(parts[0], []) ** parts[1]
        values = [self.of_tree(own, ends) for own in parts]
        return self.operation(kind, values) if kind in "+-*/" else self.call(kind, values)

    def wave(self, kind: str, v: Poly, end: int) -> Poly:
        power, step = WAVES[kind]
        last = power + step * self.order
        value = ZERO
        for k, c in enumerate(taylor(kind)[: last + 1]):
            value = value + v**k * (c * end if k == last else c)
        return value

    def operation(self, kind: str, values: list[Poly]) -> Poly:
        if len(values) == 1:
            return values[0] if kind == "+" else -values[0]
        first, second = values
        if kind == "/":
            need(second and not degree(second), "a division by a number")
            return first * (1 / at_zero(second))
        return first * second if kind == "*" else first + second if kind == "+" else first - second

    def call(self, name: str, values: list[Poly]) -> Poly:
        if name in ("Max", "max", "Min", "min"):
            value = values[0]
            for other in values[1:]:
                value = self.chosen(value, other, 1 if name in ("Max", "max") else -1)
            return value
        need(len(values) == {"sat": 3, "sign": 1, "sgn": 1, "Abs": 1, "relu": 1}.get(name), f"arguments of {name}")
        if name == "sat":
            return self.chosen(values[1], self.chosen(values[2], values[0], -1), 1)
        sign = self.sign(values[0])
        return {"Abs": values[0] * sign, "relu": values[0] * max(sign, 0)}.get(name, ONE * sign)

    def chosen(self, a: Poly, b: Poly, sense: int) -> Poly:
        return a if self.sign(a - b) in (0, sense) else b

    def sign(self, value: Poly) -> int:
        need(self.sign_of is not None or not value, "a polynomial without switching")
        return self.sign_of(value) if value and self.sign_of is not None else 0


# ---- derivatives and subspaces ---------------------------------------------------------------------


def on(p: Poly, coordinates: Sequence[Poly]) -> Poly:
    return p.compose(*coordinates, *[ZERO] * (SIZE - len(coordinates)))


def along(v: Poly, f: Sequence[Poly]) -> Poly:
    return sum((v.derivative(k) * own for k, own in enumerate(f)), ZERO)


def solve(lines: Sequence[Poly], n: int) -> tuple[list[Poly], int]:
    """All n variables where affine functions vanish, in those without a pivot; none where they do nowhere."""
    rows = [[own.derivative(k) for k in range(n)] + [own] for own in lines]
    matrix = fmpq_mat([[at_zero(entry) for entry in row] for row in rows])
    reduced, rank = matrix.rref()
    pivots = [next(k for k in range(n + 1) if reduced[i, k]) for i in range(rank)]
    if n in pivots:
        return [], 0
    free = [k for k in range(n) if k not in pivots]
    named = dict(zip(free, GENS, strict=False))
    for i, k in enumerate(pivots):
        named[k] = sum((-reduced[i, j] * named[j] for j in free), ZERO - reduced[i, n])
    return [named[k] for k in range(n)], len(free)


# ---- claims and their evidence: squares, simplices, pairs and mixtures ---------------------------


@dataclass
class Row:
    """``p + sum mu q > 0`` where guards are not negative, on one side of a face; guards are open by name.

    Rates of earlier steps are zero where it matters.
    """

    p: Poly
    guards: dict[str, Poly]
    q: list[Poly] = field(default_factory=list)
    side: tuple[int, ...] = ()
    open: Collection[str] = ()
    earlier: Sequence[Poly] = ()


@dataclass
class Claim:
    """Rows with common functions mu in n variables."""

    name: str
    n: int
    rows: list[Row]
    strict: bool
    bounded: bool = True
    at_origin: bool = False
    border: str = ""

    def is_of_forms(self) -> bool:
        polys = [p for row in self.rows for p in (row.p, *row.q)]
        return all(len({sum(e) for e, _ in terms(p)}) <= 1 for p in polys) and self._degrees_fit()

    def _degrees_fit(self) -> bool:
        """Whether some numbers e make ``deg p = deg q_j + e_j`` in each row, of what is not zero there: a graph."""
        edges: dict[Any, list[tuple[Any, int]]] = {}
        for i, row in enumerate(self.rows):
            for j, own in enumerate((row.p, *row.q)):
                if own:
                    edges.setdefault(("row", i), []).append((("column", j), -degree(own)))
                    edges.setdefault(("column", j), []).append((("row", i), degree(own)))
        height: dict[Any, int] = {}
        for start in edges:
            waiting = [] if start in height else [start]
            height.setdefault(start, 0)
            while waiting:
                node = waiting.pop()
                for other, step in edges[node]:
                    if other not in height:
                        height[other] = height[node] + step
                        waiting.append(other)
                    elif height[other] != height[node] + step:
                        return False
        return True


def show(claim: Claim, evidence: Any) -> None:
    for kind, shown_by in (("simplices", by_simplices), ("pairs", by_pairs)):
        if kind in evidence:
            shown_by(claim, *keys(evidence, kind))
            return
    own = keys(evidence, "squares", "mu")[0] if "squares" in evidence else keys(evidence, "mixture")[0]
    mu = [sum((monomial(e, claim.n) * number(c) for c, e in f), ZERO) for f in evidence.get("mu") or []]
    need(len(mu) == len(claim.rows[0].q) and len(own) == len(claim.rows), f"evidence of {claim.name}")
    for row, data in zip(claim.rows, own, strict=True):
        asked = row.p + sum((f * g for f, g in zip(mu, row.q, strict=True)), ZERO)
        positive = (by_squares if "squares" in evidence else by_mixture)(claim, row, asked, data)
        need(positive or not claim.strict, f"something positive in {claim.name}")


def by_pairs(claim: Claim, listed: Any) -> None:
    need(all(len(row.q) == 1 for row in claim.rows), "one function mu")
    numbered = permutations(enumerate(claim.rows), 2)
    asked = [(i, j, a, b) for (i, a), (j, b) in numbered if a.side != b.side]
    for (i, j, a, b), evidence in zip(asked, listed, strict=True):
        guards = {**a.guards, **{f"{name}'": g for name, g in b.guards.items()}, "sp": a.q[0], "sq": -b.q[0]}
        mixed = zip(a.earlier, b.earlier, strict=True)
        guards |= {f"sv{k}": w * b.q[0] - v * a.q[0] for k, (w, v) in enumerate(mixed)}
        row = Row(b.p * a.q[0] - a.p * b.q[0], guards, open=("sp", "sq"))
        name = f"{claim.name} pair {i} {j}"
        show(Claim(name, claim.n, [row], claim.strict, claim.bounded, claim.at_origin, claim.border), evidence)


def monomial(exponents: Any, n: int) -> Poly:
    need(len(exponents) == n and all(type(k) is int and 0 <= k <= 40 for k in exponents), "exponents")
    return RING.from_dict({(*exponents, *[0] * (SIZE - n)): fmpq(1)})


def by_squares(claim: Claim, row: Row, asked: Poly, blocks: Any) -> bool:
    positive = False
    for block in blocks:
        guards, monomials, gram = keys(block, "guards monomials gram")
        m = [monomial(e, claim.n) for e in monomials]
        need([len(r) for r in gram] == list(range(1, len(m) + 1)), "rows up to the diagonal")
        q = [[number(gram[max(i, j)][min(i, j)]) for j in range(len(m))] for i in range(len(m))]
        part = sum((m[i] * m[j] * q[i][j] for i in range(len(m)) for j in range(len(m))), ZERO)
        for name in guards:
            part *= row.guards[name]
        asked -= part
        alone = {tuple(map(bool, e)) for e in monomials if sum(map(bool, e)) <= 1}
        apart = any(not any(e) for e in alone) or (not claim.at_origin and len(alone) == claim.n)
        positive |= rank(q) == len(m) and not guards and apart
    need(not asked, f"squares that add to {claim.name}")
    return positive


def rank(q: list[list[fmpq]]) -> int:
    """By symmetric elimination; refuses what is not positive semidefinite."""
    for k in range(len(q)):
        need(q[k][k] > 0 or not any(q[k][k:]), "a positive semidefinite matrix")
        for i in range(k + 1, len(q) if q[k][k] else 0):
            q[i] = [a - q[i][k] / q[k][k] * b for a, b in zip(q[i], q[k], strict=True)]
    return sum(q[k][k] > 0 for k in range(len(q)))


def by_mixture(claim: Claim, row: Row, asked: Poly, weights: Any) -> bool:
    need(not row.q and all(number(w) >= 0 for w in weights.values()), "multipliers that are not negative")
    rest = asked - sum((row.guards[name] * number(w) for name, w in weights.items()), ZERO)
    slopes = sum((abs(c) for e, c in terms(rest) if any(e)), fmpq(0))
    least = at_zero(rest) - slopes
    need(degree(rest) <= 1 and (claim.bounded or not slopes) and least >= 0, f"an affine mixture of {claim.name}")
    return bool(least > 0)


def roots(n: int, *, bounded: bool) -> Iterator[list[list[fmpq]]]:
    """Corners (z, w) of the simplices of the cube, or of the space."""
    for signs in product((1, -1), repeat=n):
        units = [[fmpq(s * (i == k)) for i in range(n)] + [fmpq(0)] for k, s in enumerate(signs)]
        for order in permutations(range(n)) if bounded else [()]:
            corners = [[fmpq(0)] * n + [fmpq(1)]]
            for k in order:
                corners.append([x + y for x, y in zip(corners[-1], units[k], strict=True)])
            yield corners if bounded else corners + units


def by_simplices(claim: Claim, trees: Any) -> None:
    waiting = list(zip(roots(claim.n, bounded=claim.bounded), trees, strict=True))
    while waiting:
        corners, tree = waiting.pop()
        if type(tree) is dict:
            leaf(claim, corners, tree)
            continue
        i, j, share, near, far = tree
        need(type(i) is type(j) is int and {i, j} <= set(range(claim.n + 1)) and i != j, "an edge")
        need(0 < number(share) < 1, "a cut inside an edge")
        ends = zip(corners[i], corners[j], strict=True)
        new = [(1 - number(share)) * x + number(share) * y for x, y in ends]
        waiting += [([*corners[:k], new, *corners[k + 1 :]], part) for k, part in ((j, near), (i, far))]


def form(p: Poly, corners: Sequence[Sequence[fmpq]], top: int) -> Poly:
    """``w^top p(z / w)`` in the coordinates of a simplex."""
    *z, w = [sum((t * own[i] for t, own in zip(GENS, corners, strict=False)), ZERO) for i in range(len(corners))]
    total = ZERO
    for e, c in terms(p):
        part = w ** (top - sum(e)) * c
        for own, k in zip(z, e, strict=False):
            part *= own**k
        total += part
    return total


def leaf(claim: Claim, corners: Sequence[Sequence[fmpq]], data: Any) -> None:
    keys(data, "", "mu on")
    mu = [sum((t * number(v) for t, v in zip(GENS, own, strict=False)), ZERO) for own in data.get("mu") or []]
    need(len(mu) in (0, len(claim.rows[0].q)), "functions mu")
    for row, own in zip(claim.rows, data.get("on") or [{} for _ in claim.rows], strict=True):
        if type(own) is str:
            outside = form(-row.guards[own], corners, degree(row.guards[own]))
            need(all(c >= 0 for _, c in terms(outside)), "a guard that is nowhere positive")
            need(own in row.open or is_positive(claim, corners, outside, None), "a guard that is negative")
            continue
        need(all(number(v) >= 0 for v in own.values()), "multipliers that are not negative")
        parts = [row.p, *(row.guards[name] for name in own)]
        top = max([degree(p) for p in parts] + [degree(q) + 1 for q in row.q if mu])
        total = form(row.p - sum((row.guards[name] * number(v) for name, v in own.items()), ZERO), corners, top)
        total += sum((f * form(q, corners, top - 1) for f, q in zip(mu, row.q, strict=False)), ZERO)
        need(all(c >= 0 for _, c in terms(total)), f"coefficients that are not negative, of {claim.name}")
        level = row.guards.get(claim.border)
        border = None if level is None else form(level, corners, degree(level))
        need(not claim.strict or is_positive(claim, corners, total, border), f"positive coefficients of {claim.name}")


def is_positive(claim: Claim, corners: Sequence[Sequence[fmpq]], total: Poly, border: Poly | None) -> bool:
    """The rule of the page about corners and edges."""
    found, every = supports(total), range(len(corners))
    points = {k for k in every if corners[k][-1]}
    free = {k for k in points if not (claim.at_origin or any(corners[k][:-1]))}
    free |= {k for k in points if border is not None and not {frozenset({k}), frozenset()} & supports(border)}
    edges = [{k, i} for k in free for i in every if i != k and (i in free or i not in points)]
    return all(any(own <= {k} for own in found) for k in points - free) and all(
        any(own <= edge for own in found) for edge in edges
    )


def supports(p: Poly) -> set[frozenset[int]]:
    """The coordinates in each term."""
    return {frozenset(k for k in range(SIZE) if e[k]) for e, _ in terms(p)}


class Proofs:
    """Evidence by name, each used once."""

    def __init__(self, data: Any) -> None:
        self.left, self.are_forms = dict(data), True

    def show(self, claim: Claim) -> None:
        need(claim.name in self.left, f"a proof of {claim.name}")
        show(claim, self.left.pop(claim.name))
        self.are_forms = self.are_forms and claim.is_of_forms()
