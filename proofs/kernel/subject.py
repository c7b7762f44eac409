"""The subject of a certificate of a plain system, and how its numbers are written.

An irrational number is a sum of products of *generators*, the square roots and the ``2 cos(2 pi/N)`` of the scene's
field.  The subject lists those that its formulas need, each with a name and as the only root above a bound of a
polynomial; formulas are stated in these names, so that nobody need know what ``sqrt`` and ``cos`` of numbers mean.

Sines and cosines of states are stated as such, of polynomials that are zero at the point: the checker knows what
encloses them.  Irrational numbers beside them are put at rational bounds, one right-hand side for each choice of these.
Where there are norms of states, all right-hand sides that enclose the stated one are stated.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import product
from typing import Any

from nonsmooth.proofs.findings import Generators, Record
from nonsmooth.symbolic.formulas.enclosed_functions import ONE_AT_ZERO, Wave
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression, parse_piecewise
from nonsmooth.symbolic.formulas.trees import formula_tree, replaced, with_names, written
from nonsmooth.symbolic.messages.scene_error import one_line
from nonsmooth.symbolic.numbers.coefficients import bits
from nonsmooth.symbolic.numbers.number import Number, Tower
from nonsmooth.symbolic.numbers.polynomial import Polynomial, written_powers
from nonsmooth.symbolic.systems.switched_system import (
    MOST_PLACES,
    PLANE,
    NoEnclosureError,
    SeenByRoots,
    SwitchedSystem,
    bounds_of,
    enclose_numbers,
)

NUMBERS = re.compile(r"\b(pi|sqrt|sin|cos)\b")
LONGEST_NAME = 31  # characters
IN_NAMES = {"+": "p", "-": "m", "*": "t", "/": "o", " ": ""}  # letters for what is written of a radicand


class NoCertificateError(ValueError):
    """A verdict that has no certificate, in one line."""


def about(system: SwitchedSystem) -> Record:
    """What a certificate is about; where roots of states stand for these, what was stated, and of which states.

    Sines and cosines of states stay in the right-hand sides where there is one field, and its numbers can be written.

    Raises:
        NoCertificateError: for a point or numbers that no certificate can name.
    """
    at = system.stated_point
    if system.by_roots is not None:
        return _with_roots(system, system.by_roots)
    with_waves = _with_waves(system)
    rhs = with_waves or [[formula_in_names(side, system) for side in member.rhs] for member in system.members]
    subject: Record = {"states": list(system.states), "rhs": rhs}
    subject |= {"order": system.rewriting.order} if with_waves and system.rewriting.order else {}
    irrational = [] if with_waves else list(_irrational_numbers(system))
    if not irrational:
        return {**subject, "at": list(map(exact_text, at))}
    generators, named = _named_numbers(irrational, system)
    return {**subject, "at": [generators.encoded(value) for value in at], **named}


def _named_numbers(irrational: Sequence[Number], system: SwitchedSystem) -> tuple[Generators, Record]:
    """The generators of irrational numbers, and their list as a subject has it.

    Raises:
        NoCertificateError: for a state that has the name of a generator.
    """
    generators = Generators([irrational])
    names = [_base_name(system.field)] if generators.base else []
    names += [_root_name(system.field.radicands[i]) for i in generators.numbering]
    if not set(names).isdisjoint(system.stated_states):
        raise NoCertificateError(
            f"a certificate of a plain system names numbers {names}, received states of these names"
        )
    entries = generators.of_field(system.field)
    return generators, {"numbers": [{"name": name, **entry} for name, entry in zip(names, entries, strict=True)]}


def subjects_of(system: SwitchedSystem) -> Iterator[SwitchedSystem]:
    """What a certificate about a system may speak of: the system itself, then one in rational numbers that encloses it.

    In three states and more verdicts are about such an enclosure, which is tried first.
    """
    comes_first = len(system.states) <= len(PLANE)
    if comes_first:
        yield system
    try:
        enclosure = enclose_numbers(system)
    except NoEnclosureError:
        enclosure = system
    if enclosure is not system or not comes_first:
        yield enclosure


def _with_roots(system: SwitchedSystem, by_roots: SeenByRoots) -> Record:
    """What was stated of a system in roots of states, and of which states these are.

    What was stated with fractions, or with functions of numbers, is written without them.
    """
    roots, extended = by_roots.roots, by_roots.extended
    sides = [member.rhs[: len(roots.states)] for member in extended.members]
    with_functions = any(NUMBERS.search(side.text) for member in sides for side in member)
    if not system.rewriting.waves and (system.rewriting.denominators or with_functions):
        rhs = [[roots.restored(formula_in_names(side, extended)) for side in member] for member in sides]
    else:
        rhs = [[one_line(formula) for formula in member] for member in system.rewriting.written]
    subject = {"states": list(roots.states), "rhs": rhs, "at": list(map(exact_text, system.stated_point))}
    orders = {"orders": list(roots.orders)} if set(roots.orders) != {2} else {}
    order = {"order": system.rewriting.order} if system.rewriting.waves else {}
    irrational = list(_irrational_numbers(system))
    _, named = _named_numbers(irrational, system) if irrational else (None, {})
    return {**subject, "roots": list(roots.rooted), **orders, **order, **named}


def _irrational_numbers(system: SwitchedSystem) -> Iterator[Number]:
    """Those of the right-hand sides, of the point, and of the V that is stated."""
    formulas = [side for member in system.members for side in member.rhs]
    for formula in (*formulas, system.check.lyapunov):
        yield from (number for _, number in _numbers_of(formula, system) if number.as_rational() is None)
    yield from (value for value in system.check.equilibrium if value.as_rational() is None)


def _numbers_of(formula: PiecewiseExpression, system: SwitchedSystem) -> Iterator[tuple[ast.expr, Number]]:
    """The largest parts of a formula that are numbers and irrational, or written with a function.

    The checker reads no function of numbers: ``sqrt(4)`` and ``sin(pi/6)`` are rational, too.
    """
    for node, expression in formula.numbers.items():
        number = expression.value(system.field)
        if number.as_rational() is None or any(isinstance(part, ast.Call) for part in ast.walk(node)):
            yield node, number


# ---- sines and cosines of states --------------------------------------------------------------


def _with_waves(system: SwitchedSystem) -> list[list[str]]:
    """The right-hand sides with sines and cosines, irrational numbers at their bounds; none where that is not possible.

    The number of terms with irrational numbers is limited, and these may not stand beside switching functions.
    """
    if system.rewriting.names_roots:
        return []
    terms = [list(_terms(side, system)) for side in system.rewriting.named_rhs]
    bounds = [choices for side in terms for choices, _ in side]
    written = not any(_stays(wave, system) and NUMBERS.search(wave.argument) for wave in system.rewriting.names)
    if (
        not system.rewriting.names
        or not written
        or not all(bounds)
        or sum(len(choices) > 1 for choices in bounds) > MOST_PLACES
    ):
        return []
    rhs = []
    for chosen in product(*bounds):
        rest = iter(chosen)
        rhs.append([_sum((next(rest), factor) for _, factor in side) for side in terms])
    return rhs


def _terms(side: PiecewiseExpression, system: SwitchedSystem) -> Iterator[tuple[list[str], str]]:
    """The terms of a formula: a number, or bounds of it, and what it is multiplied with; no bounds for other formulas.

    With ``cos v - 1`` in place of ``cos v`` constant terms cancel, so that the point remains one of rest.
    """
    waves = {wave.name: f"{wave.kind}({_argument_text(wave, system)})" for wave in system.rewriting.names}
    if side.switching_parts:
        names = dict.fromkeys(waves, ast.Name("w"))
        can_be_written = not NUMBERS.search(written(with_names(side.tree, names)))
        meant = with_names(side.tree, {name: formula_tree(text) for name, text in waves.items()})
        yield ["1"] if can_be_written else [], f"({written(meant)})"
        return
    factors = {name: name for name in system.states} | waves
    values = {name: Polynomial.variable(system.field, tuple(factors), name) for name in factors}
    for wave in system.rewriting.names:
        if wave.kind in ONE_AT_ZERO:
            values[wave.name] += 1
            factors[wave.name] = f"({waves[wave.name]} - 1)"
    for exponents, value in side.polynomial(values, lambda _: 0).terms.items():
        powers = zip(factors.values(), exponents, strict=True)
        exact = value.as_rational()
        bounds = bounds_of(value) if exact is None else (exact,)
        yield list(map(str, bounds)), "*".join(factor for factor, exponent in powers for _ in range(exponent))


def _argument_text(wave: Wave, system: SwitchedSystem) -> str:
    """What a sine is of, multiplied out where it may be."""
    return one_line(wave.argument) if _stays(wave, system) else str(system.argument_of(wave))


def _stays(wave: Wave, system: SwitchedSystem) -> bool:
    """Whether what a sine is of stays as it is written: that of exp, as its sign is seen there, and what switches."""
    return wave.kind == "exp" or bool(parse_piecewise(wave.argument, system.states).switching_parts)


def _sum(terms: Iterator[tuple[str, str]]) -> str:
    """A sum of products of a number and something."""
    parts = []
    for number, factor in terms:
        sign, size = ("-", number[1:]) if number.startswith("-") else ("+", number)
        parts.append(f"{sign} {factor if size == '1' and factor else '*'.join(filter(None, (size, factor)))}")
    joined = " ".join(parts) or "0"
    return joined.removeprefix("+ ") if not joined.startswith("- ") else f"-{joined[2:]}"


# ---- texts -------------------------------------------------------------------------------------


def exact_text(value: Number | Fraction) -> str:
    """A rational number as certificates write it.

    Raises:
        NoCertificateError: for a number with roots.
    """
    text = str(value)
    if not set(text) <= set("-0123456789/"):
        raise NoCertificateError(f"a certificate of a plain system needs rational numbers, received {text[:60]}")
    return text


def formula_in_names(formula: PiecewiseExpression, system: SwitchedSystem) -> str:
    """A formula with every irrational number in the names of generators, and no function of numbers."""
    named = {node: formula_tree(number_in_names(number)) for node, number in _numbers_of(formula, system)}
    return written(replaced(formula.tree, named.get)) if named else one_line(formula.text)


def polynomial_in_names(polynomial: Polynomial) -> str:
    """A polynomial as a formula with every irrational number in the names of generators."""
    if all(value.as_rational() is not None for value in polynomial.terms.values()):
        return str(polynomial)
    parts = []
    for exponents, number in polynomial.terms.items():
        powers = written_powers(polynomial.variables, exponents)
        parts.append("*".join([*powers, *([f"({number_in_names(number)})"] if number != 1 or not powers else [])]))
    return " + ".join(parts)


def number_in_names(number: Number) -> str:
    """A number as a sum of products of named generators, such as ``1/2*sqrt_2 - 3``."""
    parts = []
    for mask, coefficient in sorted(number.terms.items(), reverse=True):
        roots = [_root_name(number.field.radicands[i]) for i in bits(mask)]
        powers: Sequence[Any] = [coefficient] if number.field.modulus is None else coefficient.coeffs()
        for exponent, share in enumerate(powers):
            base = f"{_base_name(number.field)}**{exponent}" if exponent > 1 else _base_name(number.field)
            factors = [base, *roots] if exponent else roots
            if share:
                sign, size = ("-", -share) if share < 0 else ("", share)
                parts.append(sign + "*".join([*([str(size)] if size != 1 or not factors else []), *factors]))
    return " + ".join(parts).replace("+ -", "- ") or "0"


def _base_name(field: Tower) -> str:
    """The name of ``2 cos(2 pi/N)``."""
    return f"two_cos_{field.order}"


def _root_name(radicand: Number) -> str:
    """The name of a square root, such as ``sqrt_2``.

    Raises:
        NoCertificateError: where it would be too long.
    """
    written = str(radicand)
    for sign, letter in IN_NAMES.items():
        written = written.replace(sign, letter)
    name = re.sub("[^A-Za-z0-9_]", "_", f"sqrt_{written}")
    if len(name) > LONGEST_NAME:
        raise NoCertificateError(f"a certificate of a plain system needs short roots, received sqrt({radicand})")
    return name
