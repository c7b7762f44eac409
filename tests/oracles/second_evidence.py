"""Claims and their evidence by docs/specification.md: squares, simplices and mixtures; a part of the second checker."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import permutations, product
from typing import Any

from flint import fmpq

from tests.oracles.second_formulas import GENS, RING, SIZE, ZERO, Poly, at_zero, degree, keys, need, number, terms


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
        steps = [
            {degree(r.p) - degree(r.q[j]) for r in self.rows if r.p and r.q[j]} for j in range(len(self.rows[0].q))
        ]
        return all(len({sum(e) for e, _ in terms(p)}) <= 1 for p in polys) and all(len(own) <= 1 for own in steps)


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
