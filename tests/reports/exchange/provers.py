"""Z3 and cvc5 on exported problems, and a reader of KeYmaera X's arithmetic that shares nothing with what writes it."""

from __future__ import annotations

import random
import re
import subprocess
import sys
from collections.abc import Iterator
from fractions import Fraction
from functools import cache
from pathlib import Path

SECONDS = 20


def answers(file: Path, *command: str) -> list[str]:
    """What a solver answers to the queries of a file."""
    done = subprocess.run([*command, str(file)], capture_output=True, text=True, timeout=60 * SECONDS, check=False)
    return done.stdout.split()


def z3_answers(file: Path) -> list[str]:
    """What Z3 answers, by the program that its package installs."""
    return answers(file, str(Path(sys.executable).parent / "z3"), f"-t:{SECONDS * 1000}")


TOKEN = re.compile(r"\s*(>=|->|[()&|!*+^=>]|\(-|[0-9]+|[a-z][0-9]+|true|-|/)")


@cache
def tokens_of(text: str) -> tuple[str, ...]:
    """The tokens of a formula, which is read at many points."""
    found, place, end = [], 0, len(text.rstrip())
    while place < end:
        match = TOKEN.match(text, place)
        assert match is not None, text[place : place + 40]
        found.append(match.group(1))
        place = match.end()
    return tuple(found)


class Kyx:
    """The value of a formula of real arithmetic at a point, by the grammar of KeYmaera X.

    ``->`` binds least and to the right, then ``|``, ``&``, ``!``, comparisons, ``+``, ``*`` and ``/``, minus, ``^``.
    """

    def __init__(self, text: str, at: dict[str, Fraction]) -> None:
        self.tokens, self.at, self.next = tokens_of(text), at, 0

    def peek(self) -> str:
        return self.tokens[self.next] if self.next < len(self.tokens) else ""

    def truth(self) -> bool:
        value = self.implication()
        assert self.next == len(self.tokens), self.tokens[self.next :]
        return value

    def implication(self) -> bool:
        left = self.either()
        if self.peek() == "->":
            self.next += 1
            right = self.implication()
            return right or not left
        return left

    def either(self) -> bool:
        value = self.both()
        while self.peek() == "|":
            self.next += 1
            value = self.both() or value
        return value

    def both(self) -> bool:
        value = self.atom()
        while self.peek() == "&":
            self.next += 1
            value = self.atom() and value
        return value

    def atom(self) -> bool:
        if self.peek() == "!":
            self.next += 1
            return not self.atom()
        if self.peek() == "true":
            self.next += 1
            return True
        start = self.next
        try:
            left = self.sum()
            operator = self.peek()
            if operator not in (">=", ">", "="):
                raise ValueError(operator)
            self.next += 1
            right = self.sum()
            return {">=": left >= right, ">": left > right, "=": left == right}[operator]
        except ValueError:
            self.next = start
            assert self.peek() == "("
            self.next += 1
            value = self.implication()
            assert self.peek() == ")"
            self.next += 1
            return value

    def sum(self) -> Fraction:
        value = self.product()
        while self.peek() == "+":
            self.next += 1
            value += self.product()
        return value

    def product(self) -> Fraction:
        value = self.power()
        while self.peek() in ("*", "/"):
            operator = self.peek()
            self.next += 1
            right = self.power()
            value = value * right if operator == "*" else value / right
        return value

    def power(self) -> Fraction:
        if self.peek() == "-":
            self.next += 1
            return -self.power()
        value = self.number()
        if self.peek() == "^":
            self.next += 1
            value = value ** int(self.number())
        return value

    def number(self) -> Fraction:
        token = self.peek()
        self.next += 1
        if token == "(":
            value = self.sum()
            if self.peek() != ")":
                raise ValueError(token)
            self.next += 1
            return value
        if token.isdecimal():
            return Fraction(token)
        if token in self.at:
            return self.at[token]
        raise ValueError(token)


ENTRY = re.compile(
    r'Theorem "([^"]+)"\n\nProgramVariables\n((?:  Real [a-z][0-9]+;\n)+)End\.\n\nProblem\n(.*?)\nEnd\.\n\n'
    r'Tactic "\1: Proof"\n  QE\nEnd\.\n\nEnd\.\n',
    re.DOTALL,
)


def kyx_problems(text: str) -> Iterator[tuple[list[str], str]]:
    """The variables and the formula of each theorem of an archive, of which nothing else may be left."""
    head, _, entries = text.partition("*/\n")
    assert head.startswith("/*")
    left = ENTRY.sub("", entries)
    assert not left.strip(), left[:200]
    for match in ENTRY.finditer(entries):
        yield re.findall(r"Real ([a-z][0-9]+);", match.group(2)), match.group(3)


def random_point(variables: list[str], source: random.Random) -> dict[str, Fraction]:
    """Coordinates of the cube, some of them zero, and weights that add up to 1."""
    at = {name: Fraction(source.choice([0, source.randint(-8, 8)]), 8) for name in variables if name[0] == "z"}
    weights = [name for name in variables if name[0] == "w"]
    shares = {name: Fraction(source.randint(0, 3)) for name in weights}
    total = sum(shares.values()) or Fraction(1)
    return {**at, **{name: share / total for name, share in shares.items()}}
