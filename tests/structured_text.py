"""A small interpreter of Structured Text (IEC 61131-3), enough to run an exported law as a controller does.

It knows one function block with variables of kinds REAL, INT and their arrays, assignments, IF, FOR, and the functions
ABS, SQRT, MAX and MIN.  What it does not know, and what a compiler of the language refuses, is an error: names declared
twice or not at all (case does not matter), constants and loop variables that are assigned, indices that are not INT or
lie outside of their array, arrays with another number of values than places, comments within comments, reals without a
point.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

TOKEN = re.compile(r"\s*(\d+\.\d+(?:E[-+]?\d+)?|\d+|[A-Za-z_]\w*|:=|\.\.|<=|>=|<>|[-+*/()\[\],;:=<>])")
FUNCTIONS: Mapping[str, Callable[..., float]] = {"ABS": abs, "SQRT": math.sqrt, "MAX": max, "MIN": min}
OPERATIONS: Mapping[str, Callable[[Any, Any], Any]] = {
    "OR": lambda a, b: a or b,
    "AND": lambda a, b: a and b,
    "=": lambda a, b: a == b,
    "<>": lambda a, b: a != b,
    "<": lambda a, b: a < b,
    ">": lambda a, b: a > b,
    "<=": lambda a, b: a <= b,
    ">=": lambda a, b: a >= b,
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b,
}
LEVELS = (("OR",), ("AND",), ("=", "<>"), ("<", ">", "<=", ">="), ("+", "-"), ("*", "/"))
KEYWORDS = (
    r"FUNCTION_BLOCK|END_FUNCTION_BLOCK|VAR|VAR_INPUT|VAR_OUTPUT|CONSTANT|END_VAR|ARRAY|OF|LREAL|INT|"
    r"IF|THEN|ELSIF|ELSE|END_IF|FOR|TO|DO|END_FOR|AND|OR"
)


class StructuredTextError(ValueError):
    """A text that is no program of the language."""


@dataclass
class Variable:
    """One name.

    Attributes:
        section: ``VAR_INPUT`` and so on.
        kind: LREAL or INT.
        shape: the last index of each dimension; none for a single value.
        values: by index.
    """

    section: str
    kind: str
    shape: tuple[int, ...]
    values: dict[tuple[int, ...], float]


class FunctionBlock:
    """A function block with its variables, which stay from one call to the next."""

    def __init__(self, text: str) -> None:
        """Read a text."""
        self._tokens, self._at = _tokens(text), 0
        self.variables: dict[str, Variable] = {}
        self._take("FUNCTION_BLOCK")
        self.name = self._name()
        while self._next in ("VAR", "VAR_INPUT", "VAR_OUTPUT"):
            self._section()
        self._body = self._statements("END_FUNCTION_BLOCK")
        self._take("END_FUNCTION_BLOCK")
        if self._at != len(self._tokens):
            raise StructuredTextError(f"after the block: {self._next}")

    def __call__(self, **inputs: float | Sequence[float]) -> None:
        """One cycle; inputs that are not given keep their values."""
        for name, value in inputs.items():
            variable = self.variables[name.upper()]
            if variable.section != "VAR_INPUT":
                raise StructuredTextError(f"no input: {name}")
            given = value if isinstance(value, Sequence) else [value]
            variable.values.update(zip(variable.values, given, strict=True))
        for statement in self._body:
            statement()

    def __getitem__(self, name: str) -> list[float]:
        """The values of a variable, in order."""
        return list(self.variables[name.upper()].values.values())

    # ---- tokens --------------------------------------------------------------------------------

    @property
    def _next(self) -> str:
        return self._tokens[self._at] if self._at < len(self._tokens) else ""

    def _take(self, *expected: str) -> str:
        token = self._next
        if expected and token not in expected:
            raise StructuredTextError(f"required {' or '.join(expected)}, received {token!r} (token {self._at})")
        self._at += 1
        return token

    def _name(self) -> str:
        token = self._take()
        if not re.fullmatch(r"[A-Z_]\w*", token) or re.fullmatch(KEYWORDS, token) or token in FUNCTIONS:
            raise StructuredTextError(f"required a name, received {token!r}")
        return token

    # ---- declarations --------------------------------------------------------------------------

    def _section(self) -> None:
        section = self._take()
        if section == "VAR" and self._next == "CONSTANT":
            section = f"VAR {self._take()}"
        while self._next != "END_VAR":
            names = [self._name()]
            while self._next == ",":
                self._take()
                names.append(self._name())
            self._take(":")
            shape, kind = self._type()
            values = self._initial(shape, kind)
            self._take(";")
            for name in names:
                if name in self.variables:
                    raise StructuredTextError(f"declared twice: {name}")
                self.variables[name] = Variable(section, kind, shape, dict(values))
        self._take("END_VAR")

    def _type(self) -> tuple[tuple[int, ...], str]:
        shape: list[int] = []
        if self._next == "ARRAY":
            self._take("ARRAY")
            separator = self._take("[")
            while separator != "]":
                self._take("1")
                self._take("..")
                shape.append(int(self._take()))
                separator = self._take(",", "]")
            self._take("OF")
        return tuple(shape), self._take("LREAL", "INT")

    def _initial(self, shape: tuple[int, ...], kind: str) -> dict[tuple[int, ...], float]:
        places = list(product(*(range(1, last + 1) for last in shape)))
        if self._next != ":=":
            return dict.fromkeys(places, 0)
        self._take(":=")
        if not shape:
            return {(): self._number(kind)}
        values, separator = [], self._take("[")
        while separator != "]":
            values.append(self._number(kind))
            separator = self._take(",", "]")
        if len(values) != len(places):
            raise StructuredTextError(f"required {len(places)} values, received {len(values)}")
        return dict(zip(places, values, strict=True))

    def _number(self, kind: str) -> float:
        sign = -1 if self._next == "-" and self._take() else 1
        token = self._take()
        if kind == "INT" and "." in token:
            raise StructuredTextError(f"required an INT, received {token}")
        return sign * (float(token) if "." in token else int(token))

    # ---- statements ----------------------------------------------------------------------------

    def _statements(self, *ends: str) -> list[Callable[[], None]]:
        found = []
        while self._next not in ends:
            found.append({"IF": self._if, "FOR": self._for}.get(self._next, self._assignment)())
            self._take(";")
        return found

    def _assignment(self) -> Callable[[], None]:
        variable, place = self._target()
        if variable.section in ("VAR_INPUT", "VAR CONSTANT"):
            raise StructuredTextError("required a variable that may be assigned")
        self._take(":=")
        value = self._expression()

        def assign() -> None:
            found = value()
            if variable.kind == "INT" and not isinstance(found, int):
                raise StructuredTextError(f"required an INT, received {found}")
            variable.values[place()] = found

        return assign

    def _if(self) -> Callable[[], None]:
        branches, word = [], self._take("IF")
        while word in ("IF", "ELSIF"):
            condition = self._expression()
            self._take("THEN")
            branches.append((condition, self._statements("ELSIF", "ELSE", "END_IF")))
            word = self._take()
        if word == "ELSE":
            branches.append((lambda: True, self._statements("END_IF")))
            self._take("END_IF")

        def run() -> None:
            chosen = next((body for condition, body in branches if condition()), [])
            for statement in chosen:
                statement()

        return run

    def _for(self) -> Callable[[], None]:
        self._take("FOR")
        variable, place = self._target()
        if variable.kind != "INT" or variable.section != "VAR":
            raise StructuredTextError("required a local INT to count with")
        self._take(":=")
        first = self._expression()
        self._take("TO")
        last = self._expression()
        self._take("DO")
        body = self._statements("END_FOR")
        self._take("END_FOR")

        def run() -> None:
            for count in range(int(first()), int(last()) + 1):
                variable.values[place()] = count
                for statement in body:
                    statement()

        return run

    def _target(self) -> tuple[Variable, Callable[[], tuple[int, ...]]]:
        name = self._name()
        if name not in self.variables:
            raise StructuredTextError(f"not declared: {name}")
        variable, indices = self.variables[name], list[Callable[[], Any]]()
        if self._next == "[":
            separator = self._take("[")
            while separator != "]":
                indices.append(self._expression())
                separator = self._take(",", "]")

        def place() -> tuple[int, ...]:
            found = tuple(index() for index in indices)
            if not all(isinstance(index, int) for index in found) or found not in variable.values:
                raise StructuredTextError(f"{name}: no place {found}")
            return found

        return variable, place

    # ---- expressions ---------------------------------------------------------------------------

    def _expression(self, level: int = 0) -> Callable[[], Any]:
        if level == len(LEVELS):
            return self._unary()
        value = self._expression(level + 1)
        while self._next in LEVELS[level]:
            operation = OPERATIONS[self._take()]
            value = _applied(operation, value, self._expression(level + 1))
        return value

    def _unary(self) -> Callable[[], Any]:
        if self._next == "-":
            self._take()
            inner = self._unary()
            return lambda: -inner()
        if self._next == "(":
            self._take()
            value = self._expression()
            self._take(")")
            return value
        if self._next[:1].isdigit():
            token = self._take()
            number = float(token) if "." in token else int(token)
            return lambda: number
        if self._next in FUNCTIONS:
            return self._call()
        variable, place = self._target()
        return lambda: variable.values[place()]

    def _call(self) -> Callable[[], Any]:
        function, values = FUNCTIONS[self._take()], list[Callable[[], Any]]()
        separator = self._take("(")
        while separator != ")":
            values.append(self._expression())
            separator = self._take(",", ")")
        return lambda: function(*(value() for value in values))


def _applied(operation: Callable[[Any, Any], Any], first: Callable[[], Any], second: Callable[[], Any]) -> Any:
    return lambda: operation(first(), second())


def _tokens(text: str) -> list[str]:
    """In capitals: the language does not tell cases apart."""
    text.encode("ascii")
    for comment in re.findall(r"\(\*(.*?)\*\)", text, flags=re.DOTALL):
        if "(*" in comment:
            raise StructuredTextError("a comment within a comment")
    rest, found, at = re.sub(r"\(\*.*?\*\)", " ", text, flags=re.DOTALL).rstrip(), [], 0
    while at < len(rest):
        match = TOKEN.match(rest, at)
        if match is None:
            raise StructuredTextError(f"not understood: {rest[at : at + 20]!r}")
        found.append(match[1].upper())
        at = match.end()
    return found
