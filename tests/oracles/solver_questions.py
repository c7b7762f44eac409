"""Lyapunov's conditions as questions for solvers modulo theories, and Z3 and cvc5 asked."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, product
from multiprocessing import get_context
from multiprocessing.connection import Connection
from typing import Any, NamedTuple, TypeAlias

import sympy as sp
import z3

# ---- Z3 and cvc5 on questions in nonlinear real arithmetic, with a time limit that holds ---------

Solve: TypeAlias = Callable[[str, float], str]  # from a script and seconds to sat, unsat or unknown

RUNS = 3  # of quick questions, the shortest of which counts
QUICK = 2.0  # seconds
STARTS = 20.0  # seconds that a process may take beside the questions


class Question(NamedTuple):
    """A script, and what an answer to it would refute."""

    about: str
    text: str


class Answer(NamedTuple):
    """What a solver says of a V: ``proved``, ``refuted`` or ``unknown``, about what, and after how many seconds."""

    said: str
    about: str
    seconds: float


def with_z3(text: str, seconds: float) -> str:
    """Z3, by its procedure for nonlinear real arithmetic."""
    solver = z3.SolverFor("QF_NRA")
    solver.set("timeout", max(1, int(seconds * 1000)))
    solver.from_string(text)
    return str(solver.check())


def with_cvc5(text: str, seconds: float) -> str:
    """cvc5, by cylindrical algebraic coverings."""
    import cvc5  # a dependency of the benchmarks only

    manager = cvc5.TermManager()
    solver = cvc5.Solver(manager)
    solver.setOption("nl-cov", "true")
    solver.setOption("tlimit-per", str(max(1, int(seconds * 1000))))
    symbols = cvc5.SymbolManager(manager)
    parser = cvc5.InputParser(solver, symbols)
    parser.setStringInput(cvc5.InputLanguage.SMT_LIB_2_6, text, "question")
    answer = ""
    while not (command := parser.nextCommand()).isNull():
        answer = str(command.invoke(solver, symbols)).strip() or answer
    return answer


def ask(solve: Solve, questions: Sequence[Question], patience: float) -> Answer:
    """All questions until one is answered, or time is over."""
    begin, left_open = time.perf_counter(), ""
    for question in questions:
        left = patience - (time.perf_counter() - begin)
        said = solve(question.text, left) if left > 0 else "unknown"
        if said == "sat":
            return Answer("refuted", question.about, time.perf_counter() - begin)
        if said != "unsat":
            left_open = left_open or question.about
    return Answer("unknown" if left_open else "proved", left_open, time.perf_counter() - begin)


def ask_apart(solve: Solve, questions: Sequence[Question], patience: float) -> Answer:
    """The same in a process that is ended when time is over: within coverings cvc5 does not look at the clock."""
    context = get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=_answer, args=(theirs, solve, list(questions), patience))
    process.start()
    found: Answer | None = ours.recv() if ours.poll(patience + STARTS) else None
    process.kill()
    process.join()
    return found or Answer("unknown", "a question that was not ended in time", patience)


def _answer(channel: Connection, solve: Solve, questions: Sequence[Question], patience: float) -> None:
    solve("(set-logic QF_NRA)(declare-const x Real)(assert (> (* x x) 2.0))(check-sat)", 1)  # loads the library
    found = ask(solve, questions, patience)
    if found.seconds < QUICK:
        found = min((found, *(ask(solve, questions, patience) for _ in range(RUNS - 1))), key=lambda a: a.seconds)
    channel.send(found)


# ---- Lyapunov's conditions on a V of a switched system as questions for solvers modulo theories, as SMT-LIB text.
#
# Built from the formulas with SymPy and no cell, face or polynomial of the program: every pattern of signs of all
# switching and bending surfaces is a cell if a point is strictly inside. On each closed cell ``V <= 0`` or ``grad V .
# f >= 0`` away from the checked point would refute V. So would ``grad V . v >= 0`` where surfaces Z vanish, one on
# which V bends among them, and v is a convex combination of the fields of all cells that meet there, with unknown
# weights and tangent to Z: at almost all times at which a solution is there its velocity is such a v. A V for which
# no question has an answer is positive and falls along every Filippov solution. Surfaces have to be planes.

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
