"""Numbers and formulas of certificates, read by the grammar of docs/specification.md: a part of the second checker."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import product
from typing import Any, TypeAlias

from flint import Ordering, fmpq, fmpq_mat, fmpq_mpoly, fmpq_mpoly_ctx

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


WAVES = {"sin": 1, "cos": 0}  # the least power in the series
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
            end = next(own for wave, own in ends if wave is tree)
            return self.wave(kind, Reading(self.names).of_tree(parts[0], []), end)
        need(kind in "+-*/" or not waves_in(*parts), "sines and cosines in sums and products")
        if kind == "**":
            return self.of_tree(parts[0], []) ** parts[1]
        values = [self.of_tree(own, ends) for own in parts]
        return self.operation(kind, values) if kind in "+-*/" else self.call(kind, values)

    def wave(self, kind: str, v: Poly, end: int) -> Poly:
        power = WAVES[kind]
        own = value = v if power else ONE
        last = 6 - power + 2 * self.order
        while power < last:
            own = own * v * v * fmpq(-1, (power + 1) * (power + 2))
            power += 2
            value = value + (own * end if power == last else own)
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
