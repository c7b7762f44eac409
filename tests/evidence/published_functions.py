"""``python -m tests.evidence.published_functions --folder DIR``: published Lyapunov functions, audited exactly.

The folder holds the files BPoly, FLyap and FSOSTOOL of the folder ``benchmarks`` of the code for Alfarano, Charton and
Hayat, "Global Lyapunov functions: a long-standing open problem in mathematics, with symbolic transformers" (NeurIPS
2024; repository facebookresearch/Lyapunov).  Its licence is not a free one (CC BY-NC 4.0): nothing of it is kept here.
Each line is a polynomial system in prefix notation, and a V that is said to be a Lyapunov function of it on all of
space.  For each

- ``audit`` decides on the cube within 1/2 of the point whether V is positive and does not rise;
- a witness is looked for, in all of space, by fractions and in a few lines that share nothing with the product: a place
  where ``V' > 0``, or a direction u in which the lowest form of V' is positive, so that V rises at ``t u`` for every
  small t, arbitrarily near the point.

Each is examined in a process of its own, for ``--seconds`` of a processor at most and 3 GB: what is stopped there is
undecided, and says so.

A line of JSON for each is written into ``--into``, and what stands there is not computed again.  Status 1 where the
two contradict each other: a V that is called valid rises in the cube, or one called invalid is positive and does not
rise at its witness, by fractions.
"""

from __future__ import annotations

import argparse
import math
import re
import resource
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from typing import TypeAlias

import numpy as np

import nonsmooth as ns
from nonsmooth.proofs.system_audit import audit
from tests.evidence.measured_tables import Lines, Record

Polynomial: TypeAlias = dict[tuple[int, ...], Fraction]

FILES = ("BPoly", "FLyap", "FSOSTOOL")
HALF = Fraction(1, 2)  # of the side of the checked cube
DIRECTIONS, LENGTHS = 1_500, (1e-2, 0.1, 0.4, 1.0, 3.0, 10.0)
FINE = 1 << 12  # denominator of the coordinates of a witness beside its length
SEEN = 1e-6  # of the sum of the sizes of all terms: a value that is taken to be positive, in floats
MEMORY = 3 << 30  # bytes that an audit may take
DIGITS = re.compile(r"-?\d+(/\d+)?")  # a rational number
OPERATORS = ("+", "-", "*", "^")


# ---- reading -------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Published:
    """A system and the function that is published for it.

    Attributes:
        name: file and line.
        field: the right-hand sides.
        function: V.
    """

    name: str
    field: tuple[Polynomial, ...]
    function: Polynomial

    @property
    def rate(self) -> Polynomial:
        """``V'``."""
        total: Polynomial = {}
        for k, side in enumerate(self.field):
            slope = {
                tuple(e - (j == k) for j, e in enumerate(exponents)): exponents[k] * value
                for exponents, value in self.function.items()
                if exponents[k]
            }
            total = added(total, multiplied(slope, side))
        return total


def published(file: Path) -> Iterator[Published]:
    """The lines of a file."""
    lines = [line.split("|")[1].replace("\t", " <V> ").split() for line in file.read_text().splitlines()]
    # whole numbers are written digit by digit, to the base ten or a thousand
    base = 10 if all(len(token) == 1 for line in lines for token in line if token.isdigit()) else 1000
    for number, line in enumerate(lines):
        field, function = (part.split() for part in " ".join(line).split(" <V> "))
        head, *sides = " ".join(field).split(" <SPECIAL_3> ")
        count = int("".join(head.split()[1:]))
        texts = [side.split() for side in (*sides, " ".join(function))]
        *parsed, last = (_parsed(tokens, count, base) for tokens in texts)
        yield Published(f"{file.name} {number}", tuple(parsed), last)


def _parsed(tokens: Sequence[str], count: int, base: int) -> Polynomial:
    """A polynomial from its tokens, operators first.

    Raises:
        ValueError: for tokens that are left over, or are none of ours.
    """
    place = 0

    def term() -> Polynomial:
        nonlocal place
        token, place = tokens[place], place + 1
        if token in OPERATORS:
            left, right = term(), term()
            if token == "^":
                return _power(left, int(right[(0,) * count]), count)
            if token == "*":
                return multiplied(left, right)
            return added(left, right if token == "+" else {e: -value for e, value in right.items()})
        if token in {"INT+", "INT-"}:
            value = 0
            while place < len(tokens) and tokens[place].isdigit():
                value, place = value * base + int(tokens[place]), place + 1
            return {(0,) * count: Fraction(-value if token == "INT-" else value)}
        if token[0] == "x" and token[1:].isdigit():
            return {tuple(int(k == int(token[1:])) for k in range(count)): Fraction(1)}
        raise ValueError(f"required an operator, a number or a state, received {token}")

    found = term()
    if place < len(tokens):
        raise ValueError(f"required one polynomial, received {tokens[place:]} after it")
    return {e: value for e, value in found.items() if value}


def added(left: Polynomial, right: Polynomial) -> Polynomial:
    """The sum."""
    total = dict(left)
    for exponents, value in right.items():
        total[exponents] = total.get(exponents, Fraction(0)) + value
    return {e: value for e, value in total.items() if value}


def multiplied(left: Polynomial, right: Polynomial) -> Polynomial:
    """The product."""
    total: Polynomial = {}
    for a, x in left.items():
        for b, y in right.items():
            exponents = tuple(map(int.__add__, a, b))
            total[exponents] = total.get(exponents, Fraction(0)) + x * y
    return {e: value for e, value in total.items() if value}


def _power(base: Polynomial, exponent: int, count: int) -> Polynomial:
    found: Polynomial = {(0,) * count: Fraction(1)}
    for _ in range(exponent):
        found = multiplied(found, base)
    return found


def text(polynomial: Polynomial, names: Sequence[str]) -> str:
    """As formulas of scenes are written."""
    terms = []
    for exponents, value in polynomial.items():
        powers = [f"{name}**{e}" for name, e in zip(names, exponents, strict=True) if e]
        terms.append("*".join([f"({value})", *powers]))
    return " + ".join(terms) or "0"


# ---- witnesses -----------------------------------------------------------------------------------


def value_at(polynomial: Polynomial, place: Sequence[Fraction]) -> Fraction:
    """Exactly."""
    total = Fraction(0)
    for exponents, value in polynomial.items():
        total += value * math.prod(x**e for x, e in zip(place, exponents, strict=True))
    return total


def positive_place(polynomial: Polynomial, units: np.ndarray, length: float) -> list[Fraction] | None:
    """A place at about a distance at which a polynomial is positive, exactly; None where floats see none."""
    places = units * length
    total, size = np.zeros(len(places)), np.zeros(len(places))
    for exponents, value in polynomial.items():
        term = float(value) * np.prod(places ** np.array(exponents), axis=1)
        total, size = total + term, size + abs(term)
    best = int((total / np.where(size > 0, size, 1.0)).argmax())
    if total[best] <= SEEN * size[best]:
        return None
    place = [Fraction(round(float(x) / length * FINE), FINE) * Fraction(length) for x in places[best]]
    return place if value_at(polynomial, place) > 0 else None


def lowest_form(polynomial: Polynomial) -> Polynomial:
    """The terms of the least degree."""
    least = min(map(sum, polynomial), default=0)
    return {e: value for e, value in polynomial.items() if sum(e) == least}


def refuted(own: Published) -> Record:
    """Where V rises: arbitrarily near the point, and at a place."""
    rate = own.rate
    source = np.random.default_rng(0)
    units = source.normal(size=(DIRECTIONS, len(own.field)))
    units /= np.linalg.norm(units, axis=1, keepdims=True)
    near = positive_place(lowest_form(rate), units, 1.0)
    found = next((place for length in LENGTHS if (place := positive_place(rate, units, length))), None)
    return {"rises_along": near and list(map(str, near)), "rises_at": found and list(map(str, found))}


# ---- the study -----------------------------------------------------------------------------------


def examined(own: Published) -> Record:
    """What the audit says, and what fractions say."""
    names = [f"x{k}" for k in range(len(own.field))]
    system = ns.System(names, [text(side, names) for side in own.field], radius=HALF).system
    result = audit(system, text(own.function, names))
    place = [] if result.witness is None else getattr(result.witness, "point", ())
    # an irrational place serves by a rational one next to it: what is claimed there is a strict inequality
    witness = [str(x) if DIGITS.fullmatch(str(x)) else str(Fraction(float(x))) for x in place]
    return {
        "states": len(names),
        "verdict": str(result.verdict),
        "proves": str(result.proves or ""),
        "reason": result.reason,
        "witness": witness,
        **refuted(own),
    }


def bounded(own: Published, seconds: int) -> Record:
    """What :func:`examined` says, within bounds of time and memory."""
    fork = get_context("fork")
    here, there = fork.Pipe(duplex=False)
    child = fork.Process(target=_send_examined, args=(own, seconds, there))
    child.start()
    there.close()
    try:
        return dict(here.recv())
    except EOFError:  # the process ended without an answer
        reason = f"stopped after {seconds} s, or at {MEMORY >> 30} GB"
        answer = {"states": len(own.field), "verdict": "undecided", "proves": "", "reason": reason, "witness": []}
        return {**answer, **refuted(own)}
    finally:
        child.join()


def _send_examined(own: Published, seconds: int, there: Connection) -> None:
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    spent = resource.getrusage(resource.RUSAGE_SELF)
    most = round(spent.ru_utime + spent.ru_stime) + seconds
    resource.setrlimit(resource.RLIMIT_CPU, (most, most))
    there.send(examined(own))


def contradiction(own: Published, found: Mapping[str, object]) -> str:
    """What is wrong with an answer; empty where nothing is."""
    rises, witness = found["rises_at"], found["witness"]
    if found["verdict"] == "valid":
        if found["rises_along"] is not None:
            return "valid, but V rises near the point"
        if isinstance(rises, list) and max(abs(Fraction(x)) for x in rises) <= HALF:
            return "valid, but V rises in the cube"
    if found["verdict"] == "invalid":
        place = [Fraction(x) for x in witness] if isinstance(witness, list) else []
        if not any(place):  # of linear systems on the whole plane, as the audit says
            return "invalid, without a place beside the point"
        if value_at(own.function, place) > 0 and value_at(own.rate, place) <= 0:
            return "invalid, but V is positive and does not rise at its witness"
    return ""


def main() -> int:
    """Examine what the arguments say, and print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--folder", type=Path, required=True)
    parser.add_argument("--into", type=Path, required=True, help="a file of lines of JSON")
    parser.add_argument("--most-states", type=int, default=9)
    parser.add_argument("--seconds", type=int, default=20, help="of a processor, for each")
    asked = parser.parse_args()
    lines, wrong = Lines(asked.into), 0
    for name in FILES:
        counts: Counter[str] = Counter()
        for own in published(asked.folder / name):
            if len(own.field) > asked.most_states:
                continue
            found = lines.of(own.name, partial(bounded, own, asked.seconds))
            counts[str(found["verdict"])] += 1
            if found["verdict"] == "invalid":
                counts[f"invalid: {found['reason']}"] += 1
            counts["rises somewhere, by fractions"] += found["rises_at"] is not None
            counts["rises arbitrarily near the point"] += found["rises_along"] is not None
            said = contradiction(own, found)
            wrong += bool(said)
            if said:
                print(f"{own.name}: {said}", flush=True)
        print(f"{name}: {dict(counts)}", flush=True)
    return int(bool(wrong))


if __name__ == "__main__":
    raise SystemExit(main())
