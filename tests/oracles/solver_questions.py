"""Lyapunov's conditions on a V of a switched system as questions for solvers modulo theories, as SMT-LIB text.

Built from the formulas with SymPy and no cell, face or polynomial of the program: every pattern of signs of all
switching and bending surfaces is a cell if a point is strictly inside.  On each closed cell ``V <= 0`` or ``grad V . f
>= 0`` away from the checked point would refute V.  So would ``grad V . v >= 0`` where surfaces Z vanish, one on which V
bends among them, and v is a convex combination of the fields of all cells that meet there, with unknown weights and
tangent to Z: at almost all times at which a solution is there its velocity is such a v.  A V for which no question has
an answer is positive and falls along every Filippov solution.  Surfaces have to be planes.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, product
from typing import Any, TypeAlias

import sympy as sp

from tests.oracles.solvers import Question, with_z3

Signs: TypeAlias = tuple[int, ...]

HEADER = "(set-logic QF_NRA)"


def largest(a: Any, b: Any) -> Any:
    return (a + b + (a - b) * sp.sign(a - b)) / 2


def least(a: Any, b: Any) -> Any:
    return (a + b - (a - b) * sp.sign(a - b)) / 2


NAMES = {
    "sgn": sp.sign,
    "sign": sp.sign,
    "Abs": lambda a: a * sp.sign(a),
    "Max": largest,
    "Min": least,
    "relu": lambda a: largest(a, 0),
    "sat": lambda a, low, high: largest(least(a, high), low),
}


@dataclass(frozen=True)
class Stated:
    """A system and a V on a cube, in the displacement from the checked point.

    Attributes:
        states: their symbols.
        rhs: the formulas, with unknown signs.
        potential: V, likewise.
        surfaces: linear polynomials.
        signs: their unknown signs.
        bending: numbers of the surfaces in V.
        radius: half-width of the cube.
    """

    states: tuple[Any, ...]
    rhs: tuple[Any, ...]
    potential: Any
    surfaces: tuple[Any, ...]
    signs: tuple[Any, ...]
    bending: frozenset[int]
    radius: Any

    def field(self, cell: Signs) -> list[Any]:
        return [sp.expand(f.subs(dict(zip(self.signs, cell, strict=True)))) for f in self.rhs]

    def piece(self, cell: Signs) -> Any:
        return sp.expand(self.potential.subs(dict(zip(self.signs, cell, strict=True))))

    def along(self, cell: Signs, velocity: Sequence[Any]) -> Any:
        piece = self.piece(cell)
        return sp.expand(sum(sp.diff(piece, x) * v for x, v in zip(self.states, velocity, strict=True)))


def read(states: Sequence[str], rhs: Sequence[str], at: Sequence[Any], radius: Any, potential: str) -> Stated:
    """Formulas as they are written, V in the displacement."""
    symbols = tuple(sp.Symbol(name, real=True) for name in states)
    known = {**NAMES, **dict(zip(states, symbols, strict=True))}
    moved = {x: x + sp.Rational(str(e)) for x, e in zip(symbols, at, strict=True)}
    fields = [sp.sympify(text, known, rational=True).subs(moved, simultaneous=True) for text in rhs]
    energy = sp.sympify(potential, known, rational=True)
    surfaces: list[Any] = []

    def with_unknown_signs(formula: Any) -> Any:
        """Inner signs first; a surface and its multiples have one sign."""
        for found in sorted(formula.atoms(sp.sign), key=sp.count_ops):
            plane = sp.Poly(found.args[0], *symbols)
            if plane.total_degree() != 1:
                raise ValueError(f"required planes as surfaces, received {found.args[0]}")
            leading = plane.LC()
            normal = sp.expand(plane.as_expr() / leading)
            if normal not in surfaces:
                surfaces.append(normal)
            unknown = sp.Symbol(f"sign_{surfaces.index(normal)}")
            formula = formula.subs(found, unknown if leading > 0 else -unknown)
        return formula

    written = [with_unknown_signs(f) for f in fields]
    function = with_unknown_signs(energy)
    signs = tuple(sp.Symbol(f"sign_{k}") for k in range(len(surfaces)))
    bending = frozenset(k for k, s in enumerate(signs) if function.has(s))
    half = sp.Rational(str(radius))
    return Stated(symbols, tuple(written), function, tuple(surfaces), signs, bending, half)


# ---- text ----------------------------------------------------------------------------------------


def number(value: Any) -> str:
    p, q = abs(value.p), value.q
    size = f"{p}.0" if q == 1 else f"(/ {p}.0 {q}.0)"
    return f"(- {size})" if value < 0 else size


def polynomial(expression: Any, symbols: Sequence[Any]) -> str:
    terms = []
    for exponents, coefficient in sp.Poly(expression, *symbols).terms():
        factors = [number(coefficient)]
        factors += [str(x) for x, e in zip(symbols, exponents, strict=True) for _ in range(e)]
        terms.append(f"(* {' '.join(factors)})" if len(factors) > 1 else factors[0])
    return f"(+ {' '.join(terms)})" if len(terms) > 1 else terms[0]


def script(symbols: Sequence[Any], claims: Sequence[str]) -> str:
    declared = [f"(declare-const {x} Real)" for x in symbols]
    return "\n".join([HEADER, *declared, *(f"(assert {claim})" for claim in claims), "(check-sat)"])


class Questions:
    """All questions on a V.

    Args:
        stated: the system and V.
        rises: what refutes: ``>=`` that V falls strictly, ``>`` that it does not increase.
    """

    def __init__(self, stated: Stated, rises: str = ">=") -> None:
        self.stated, self.relation = stated, rises
        patterns = product((1, -1), repeat=len(stated.surfaces))
        self.cells = [p for p in patterns if with_z3(self.inside(p), 10) == "sat"]

    def inside(self, cell: Signs) -> str:
        return script(self.stated.states, [*self.cube(), *self.side(cell, range(len(cell)), ">")])

    def cube(self) -> list[str]:
        reach = number(self.stated.radius)
        return [f"(<= (- {reach}) {x} {reach})" for x in self.stated.states]

    def away(self) -> str:
        return f"(or {' '.join(f'(not (= {x} 0.0))' for x in self.stated.states)})"

    def side(self, cell: Signs, which: Sequence[int] | range, relation: str) -> list[str]:
        return [f"({relation} {polynomial(cell[k] * self.stated.surfaces[k], self.stated.states)} 0.0)" for k in which]

    def __iter__(self) -> Iterator[Question]:
        stated = self.stated
        for cell in self.cells:
            here = [*self.cube(), self.away(), *self.side(cell, range(len(cell)), ">=")]
            states = stated.states
            low = f"(<= {polynomial(stated.piece(cell), states)} 0.0)"
            rises = f"({self.relation} {polynomial(stated.along(cell, stated.field(cell)), states)} 0.0)"
            yield Question(f"V > 0 on {cell}", script(states, [*here, low]))
            yield Question(f"V' < 0 on {cell}", script(states, [*here, rises]))
        for size in range(1, min(len(stated.surfaces), len(stated.states)) + 1):
            for zero in combinations(range(len(stated.surfaces)), size):
                if stated.bending & set(zero):
                    yield from self.on_faces(zero)

    def on_faces(self, zero: tuple[int, ...]) -> Iterator[Question]:
        others = [k for k in range(len(self.stated.surfaces)) if k not in zero]
        by_side: dict[Signs, list[Signs]] = {}
        for cell in self.cells:
            by_side.setdefault(tuple(cell[k] for k in others), []).append(cell)
        for meeting in by_side.values():
            yield Question(f"V' < 0 where {zero} vanish", self.sliding(zero, others, meeting))

    def sliding(self, zero: Sequence[int], others: Sequence[int], meeting: Sequence[Signs]) -> str:
        """With a weight for each field that is there; those that agree are one."""
        stated = self.stated
        fields = list({tuple(stated.field(cell)) for cell in meeting})
        weights = sp.symbols(f"w_0:{len(fields)}")
        mixed = [sum(w * f[i] for w, f in zip(weights, fields, strict=True)) for i in range(len(stated.states))]
        symbols = [*stated.states, *weights]
        claims = [*self.cube(), self.away(), *self.side(meeting[0], others, ">"), *self.side(meeting[0], zero, "=")]
        claims += [f"(>= {w} 0.0)" for w in weights] + [f"(= {polynomial(sum(weights) - 1, symbols)} 0.0)"]
        for k in zero:
            push = sum(sp.diff(stated.surfaces[k], x) * v for x, v in zip(stated.states, mixed, strict=True))
            claims.append(f"(= {polynomial(sp.expand(push), symbols)} 0.0)")
        claims.append(f"({self.relation} {polynomial(stated.along(meeting[0], mixed), symbols)} 0.0)")
        return script(symbols, claims)
