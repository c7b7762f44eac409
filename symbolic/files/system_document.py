"""The tables of a scene file with ``[system]``: which keys there are, and what each must be.

A new table or key of plain systems is declared here; :mod:`nonsmooth.symbolic.files.system_builder` reads it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from keyword import iskeyword
from typing import Annotated, Any

from pydantic import Field, PlainValidator, StrictBool

from nonsmooth.symbolic.files.scene_values import Exact, ExactField, Name, TomlTable, read_exact
from nonsmooth.symbolic.formulas.enclosed_functions import WAVES
from nonsmooth.symbolic.formulas.expression import formula_refused, with_whole_exponents
from nonsmooth.symbolic.formulas.formula_text import first_that_holds, indicator, product_text
from nonsmooth.symbolic.formulas.piecewise import NUMBERS, SWITCHES
from nonsmooth.symbolic.formulas.trees import ExpressionError, formula_tree, names_of, with_names, written
from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact

# ---- named parameters of a plain system: numbers that stand in its formulas by name --------------
#
# In a formula every parameter's name is replaced by its value before anything else is done, so results, reports and
# certificates show formulas that are complete by themselves.


MAX_PARAMETERS = 40
NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,19}")


def read_parameters(value: object) -> dict[str, Any]:
    """A table of numbers by name, as they were written.

    Raises:
        ValueError: for anything else.
    """
    if not isinstance(value, dict) or not all(isinstance(name, str) for name in value):
        raise ValueError("required a table of numbers such as { k = 2 }")
    if len(value) > MAX_PARAMETERS:
        raise ValueError(f"required at most {MAX_PARAMETERS} parameters")
    return dict(value)


def parameter_texts(parameters: Mapping[str, Any], taken: Collection[str], file: str) -> dict[str, str]:
    """What stands for each name in a formula.

    Args:
        parameters: values by name.
        taken: names that mean something else: states and functions.
        file: for messages.

    Raises:
        SceneError: for a name that is taken or no name, and for a value that is no number.
    """
    texts = {}
    for name, value in parameters.items():
        key = f"system.parameters.{name}"
        if not NAME.fullmatch(name) or name in taken:
            raise SceneError(file, key, "a name that is no state and no function", name)
        texts[name] = _text(value, file, key)
    return texts


def _text(value: Any, file: str, key: str) -> str:
    with formula_refused(file, key, value):
        number = read_exact(value)
    return str(number) if isinstance(number, Fraction) else number.text


def with_parameters(formula: object, texts: Mapping[str, str]) -> object:
    """A formula with its parameters replaced, and whole exponents in digits.

    A formula that has neither, and what is none, stays as it is written.
    """
    if not isinstance(formula, str):
        return formula
    try:
        tree = formula_tree(formula)
        values = {name: formula_tree(texts[name]) for name in names_of(tree) & texts.keys()}
        text = written(with_whole_exponents(with_names(tree, values)))
        return formula if text == written(tree) else text
    except ExpressionError:
        return formula


def names_in(formula: object) -> set[str]:
    """All names in a formula."""
    try:
        return names_of(formula_tree(formula))
    except ExpressionError:
        return set()


# ---- the document --------------------------------------------------------------------------------


MAX_STATES = 8
_STATE = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,19}")
RESERVED = {*NUMBERS, *SWITCHES, *WAVES}


def is_state(value: object) -> bool:
    """Whether a value can name a state: formulas are read as Python does, where ``lambda`` means something else."""
    fits = isinstance(value, str) and _STATE.fullmatch(value) is not None
    return fits and value not in RESERVED and not iskeyword(str(value))


def read_states(value: object) -> tuple[str, ...]:
    """One or more different names.

    Raises:
        ValueError: for anything else.
    """
    names = value if isinstance(value, list) else []
    fit = [name for name in names if is_state(name)]
    if not 1 <= len(set(fit)) == len(names) <= MAX_STATES:
        texts = [name for name in names if isinstance(name, str)]
        other = next((name for name in texts if name in RESERVED or iskeyword(name)), None)
        is_odd = any(_STATE.fullmatch(name) is None for name in texts)
        words = ', of letters a to z, digits and "_"' if is_odd else ""
        words = words if other is None else f"; {other} means something else in formulas"
        raise ValueError(f'required 1 to {MAX_STATES} different names such as ["x", "y"]{words}')
    return tuple(fit)


def read_formulas(value: object) -> tuple[object, ...]:
    """A list of formulas, or a list of such lists: arbitrary switching between them.

    Raises:
        ValueError: for anything else.
    """
    if not isinstance(value, list):
        raise ValueError("required a list of formulas, one for each state")
    return tuple(value)


def read_numbers(value: object) -> tuple[Exact, ...]:
    """A list of numbers.

    Raises:
        ValueError: for anything else.
    """
    if not isinstance(value, list):
        raise ValueError("required a list of numbers, one for each state")
    return tuple(map(read_exact, value))


class SystemTable(TomlTable):
    """``[system]``: the states, one right-hand side for each (or ``[[region]]`` tables), and named numbers in them.

    ``overlap`` says that of region tables all act whose guards hold.
    """

    states: Annotated[tuple[str, ...], PlainValidator(read_states)]
    rhs: Annotated[tuple[object, ...] | None, PlainValidator(read_formulas)] = None
    overlap: StrictBool = False
    parameters: Annotated[dict[str, object], PlainValidator(read_parameters)] = Field(default_factory=dict)


class SystemCheckTable(TomlTable):
    """``[check]``: the equilibrium, the half-width of the cube about it, and a Lyapunov function V."""

    equilibrium: Annotated[tuple[Exact, ...] | None, PlainValidator(read_numbers)] = None
    radius: ExactField = Fraction(1, 2)
    lyapunov: object = None


class SystemDocument(TomlTable):
    """A whole scene file of a switched system."""

    name: Name = None
    description: Name = None
    system: SystemTable
    region: tuple[RegionTable, ...] = ()
    check: SystemCheckTable = SystemCheckTable()


# ---- regions -------------------------------------------------------------------------------------
#
# The first table whose guards hold counts; the last one has no guards and holds everywhere else, so the fields cover
# all states and nothing is ambiguous.  A guard is a factor, 1 where it holds and 0 elsewhere, so the tables become one
# formula for each state (:mod:`nonsmooth.symbolic.formulas.formula_text`).  On borders values are ignored as everywhere
# (Filippov 1988, sec. 4); but a guard with absolute values may be zero on a whole cell, where it counts.
#
# Where tables overlap all of them act whose guards hold: arbitrary switching between one right-hand side for each
# table, which is that table where its guards hold, and elsewhere the first one whose guards do.


MAX_REGIONS = 12
_GUARD = re.compile(r"([^<>=]+)(<=|>=|<|>)([^<>=]+)")

Checker = Callable[[object, str], None]  # of a formula under a key


def read_texts(value: object) -> tuple[object, ...]:
    """A list, or one text.

    Raises:
        ValueError: for anything else.
    """
    if isinstance(value, str):
        return (value,)
    if not isinstance(value, list):
        raise ValueError('required a list of texts such as ["x > 0"]')
    return tuple(value)


class RegionTable(TomlTable):
    """``[[region]]``: guards such as "x > 0" that all hold there, and one right-hand side for each state."""

    where: Annotated[tuple[object, ...], PlainValidator(read_texts)] = ()
    rhs: Annotated[tuple[object, ...], PlainValidator(read_texts)]


@dataclass(frozen=True)
class Guarded:
    """A table as texts: what is 1 where each of its guards holds and 0 elsewhere, and its formulas."""

    truths: tuple[str, ...]
    rhs: tuple[str, ...]


def regions_as_formulas(
    tables: Sequence[RegionTable], states: Sequence[str], check: Checker, file: str, *, overlap: bool = False
) -> tuple[object, ...]:
    """One formula for each state; where tables overlap a list of them for each table with guards.

    Args:
        tables: in order.
        states: their names.
        check: refuses what is no formula of the states.
        file: for messages.
        overlap: whether all tables act whose guards hold.

    Raises:
        SceneError: for guards that are none, a last table with guards or another one without, too many tables, and
            another number of formulas than states.
    """
    if len(tables) > MAX_REGIONS:
        raise SceneError(file, "region", f"at most {MAX_REGIONS} tables", StatedFact(f"{len(tables)}"))
    regions = [_guarded(table, states, check, file, f"region[{k}]") for k, table in enumerate(tables, 1)]
    for k, region in enumerate(regions, 1):
        if bool(region.truths) is (k == len(regions)):
            expected = "guards in all tables but the last one, which holds everywhere else"
            raise SceneError(file, f"region[{k}].where", expected, StatedFact(f"{len(region.truths)}"))
    *guarded, last = regions

    def formulas(order: Sequence[Guarded]) -> list[str]:
        return [
            first_that_holds([(product_text(region.truths), region.rhs[j]) for region in order], last.rhs[j])
            for j in range(len(states))
        ]

    if not overlap:
        return tuple(formulas(guarded))
    return tuple(formulas([region, *(other for other in guarded if other is not region)]) for region in guarded)


def _guarded(table: RegionTable, states: Sequence[str], check: Checker, file: str, key: str) -> Guarded:
    if len(table.rhs) != len(states):
        expected = f"{len(states)} formulas, one for each state"
        raise SceneError(file, f"{key}.rhs", expected, StatedFact(f"{len(table.rhs)}"))
    guards = [_guard(text, check, file, f"{key}.where[{j}]") for j, text in enumerate(table.where, 1)]
    for j, formula in enumerate(table.rhs, 1):
        check(formula, f"{key}.rhs[{j}]")
    return Guarded(tuple(guards), tuple(f"({str(formula).strip()})" for formula in table.rhs))


def compared(value: object) -> tuple[str, str, str] | None:
    """The left side of a guard, its comparison and its right side; None for what is no guard."""
    parts = _GUARD.fullmatch(value) if isinstance(value, str) else None
    if parts is None:
        return None
    left, comparison, right = (part.strip() for part in parts.groups())
    return left, comparison, right


def _guard(value: Any, check: Checker, file: str, key: str) -> str:
    """What is 1 where the guard holds, and 0 elsewhere."""
    parts = compared(value)
    if parts is None:
        raise SceneError(file, key, 'a guard such as "x - y > 0", with one of < <= > >=', value)
    left, comparison, right = parts
    for side in (left, right):
        check(side, key)
    if comparison.startswith("<"):
        left, right = right, left
    return indicator(f"({left}) - ({right})", strict=not comparison.endswith("="))
