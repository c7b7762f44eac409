"""The subject of a certificate of a plain system, and the numbers that certificates can hold."""

from __future__ import annotations

import re
from collections.abc import Iterator
from fractions import Fraction
from itertools import product
from typing import Any

from nonsmooth.symbolic.enclosed_numbers import MOST_PLACES, bounds_of
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.piecewise import PiecewiseExpression, parse_piecewise
from nonsmooth.symbolic.scene_error import one_line
from nonsmooth.symbolic.sine_enclosures import Wave
from nonsmooth.symbolic.switched_system import SwitchedSystem

NUMBERS = re.compile(r"\b(pi|sqrt|sin|cos)\b")


class NoCertificateError(ValueError):
    """A verdict that has no certificate, in one line."""


def about(system: SwitchedSystem) -> dict[str, Any]:
    """What a certificate is about; where roots of states stand for these, what was stated, and of which states.

    Sines and cosines of states stay in the right-hand sides where there is one field, and its numbers can be written.

    Raises:
        NoCertificateError: for a point that no certificate can name.
    """
    at = system.check.equilibrium
    if system.by_roots is not None:
        names, rooted = system.by_roots.roots.states, system.by_roots.roots.rooted
        stated = [z * abs(z) if name in rooted else z for name, z in zip(names, at, strict=True)]
        rhs = [[one_line(formula) for formula in member] for member in system.written]
        return {"states": list(names), "rhs": rhs, "at": list(map(exact_text, stated)), "roots": list(rooted)}
    return {
        "states": list(system.states),
        "rhs": _with_waves(system) or [[one_line(side.text) for side in member.rhs] for member in system.members],
        "at": [exact_text(value) for value in at],
    }


def _with_waves(system: SwitchedSystem) -> list[list[str]]:
    """The right-hand sides with sines and cosines, irrational numbers at their bounds; none where that is not possible.

    The number of terms with irrational numbers is limited, and these may not stand beside switching functions.
    """
    terms = [list(_terms(side, system)) for side in system.named_rhs]
    bounds = [own for side in terms for own, _ in side]
    if not system.names or not all(bounds) or sum(len(own) > 1 for own in bounds) > MOST_PLACES:
        return []
    found = []
    for chosen in product(*bounds):
        rest = iter(chosen)
        found.append([_sum((next(rest), factor) for _, factor in side) for side in terms])
    return found


def _terms(side: PiecewiseExpression, system: SwitchedSystem) -> Iterator[tuple[list[str], str]]:
    """The terms of a formula: a number, or bounds of it, and what it is multiplied with; no bounds for other formulas.

    With ``cos v - 1`` in place of ``cos v`` constant terms cancel, so that the point remains one of rest.
    """
    waves = {own.name: f"{own.kind}({_argument(own, system)})" for own in system.names}
    if side.switching_parts:
        named = re.compile(rf"\b({'|'.join(map(re.escape, waves))})\b")
        text = one_line(side.text)
        can_be_written = not NUMBERS.search(named.sub("w", text))
        yield ["1"] if can_be_written else [], f"({named.sub(lambda own: waves[own[0]], text)})"
        return
    factors = {name: name for name in system.states} | waves
    values = {name: Polynomial.variable(system.field, tuple(factors), name) for name in factors}
    for wave in system.names:
        if wave.kind == "cos":
            values[wave.name] += 1
            factors[wave.name] = f"({waves[wave.name]} - 1)"
    for exponents, value in side.polynomial(values, lambda _: 0).terms.items():
        powers = zip(factors.values(), exponents, strict=True)
        exact = value.as_rational()
        bounds = bounds_of(value) if exact is None else (exact,)
        yield list(map(str, bounds)), "*".join(factor for factor, exponent in powers for _ in range(exponent))


def _argument(wave: Wave, system: SwitchedSystem) -> str:
    values = dict(zip(system.states, system.coordinates(), strict=True))
    return str(parse_piecewise(wave.argument, system.states).polynomial(values, lambda _: 0))


def _sum(terms: Iterator[tuple[str, str]]) -> str:
    """A sum of products of a number and something."""
    parts = []
    for number, factor in terms:
        sign, size = ("-", number[1:]) if number.startswith("-") else ("+", number)
        parts.append(f"{sign} {factor if size == '1' and factor else '*'.join(filter(None, (size, factor)))}")
    joined = " ".join(parts) or "0"
    return joined.removeprefix("+ ") if not joined.startswith("- ") else f"-{joined[2:]}"


def exact_text(value: Number | Fraction) -> str:
    """A rational number as certificates write it.

    Raises:
        NoCertificateError: for a number with roots.
    """
    text = str(value)
    if not set(text) <= set("-0123456789/"):
        raise NoCertificateError(f"a certificate of a plain system needs rational numbers, received {text[:60]}")
    return text
