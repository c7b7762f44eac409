"""Scene files with a ``[system]`` table in any number of states, read to follow solutions.

The tables are those of :mod:`nonsmooth.symbolic.files.system_file`; what a check needs besides (``[check]``) is not
looked at, its radius apart.
"""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Annotated, Any

from pydantic import PlainValidator

from nonsmooth.symbolic.files.scene_document import Name
from nonsmooth.symbolic.files.scene_file import deep_nesting_refused, read_document
from nonsmooth.symbolic.files.scene_validation import validate
from nonsmooth.symbolic.files.scene_values import ExactField, Numbers, Table, angles, field_of
from nonsmooth.symbolic.files.system_file import is_state, parse_lyapunov
from nonsmooth.symbolic.scene_error import Fact, SceneError
from nonsmooth.symbolic.switched_equations import SwitchedEquations

MAX_STATES = 8


def read_states(value: object) -> tuple[str, ...]:
    """One or more different names.

    Raises:
        ValueError: for anything else.
    """
    names = value if isinstance(value, list) else []
    fit = [name for name in names if is_state(name)]
    if not 1 <= len(set(fit)) == len(names) <= MAX_STATES:
        raise ValueError(f'required 1 to {MAX_STATES} different names such as ["x", "y"]')
    return tuple(fit)


def read_formulas(value: object) -> tuple[object, ...]:
    """A list of formulas.

    Raises:
        ValueError: for anything else.
    """
    if not isinstance(value, list):
        raise ValueError("required a list of formulas, one for each state")
    return tuple(value)


class EquationsTable(Table):
    """``[system]``: states and their right-hand sides."""

    states: Annotated[tuple[str, ...], PlainValidator(read_states)]
    rhs: Annotated[tuple[object, ...], PlainValidator(read_formulas)]


class EquationsCheckTable(Table):
    """``[check]``: only the radius matters here."""

    equilibrium: object = None
    radius: ExactField = Fraction(1, 2)
    lyapunov: object = None


class EquationsDocument(Table):
    """A whole scene file of a plain switched system."""

    name: Name = None
    description: Name = None
    system: EquationsTable
    check: EquationsCheckTable = EquationsCheckTable()


def holds_system(source: str | Path) -> bool:
    """Whether a scene is a plain switched system.

    Raises:
        SceneError: for a file that cannot be read.
    """
    try:
        return "system" in read_document(source)[0]
    except RecursionError:
        return False


def load_equations(source: str | Path) -> SwitchedEquations:
    """Read the equations of a plain switched system.

    Raises:
        SceneError: for whatever cannot be used.
    """
    with deep_nesting_refused(source):
        return _equations(*read_document(source))


def _equations(data: dict[str, Any], file: str, path: Path) -> SwitchedEquations:
    document = validate(EquationsDocument, data, file)
    table, check = document.system, document.check
    if len(table.rhs) != len(table.states):
        expected = f"{len(table.states)} formulas, one for each state"
        raise SceneError(file, "system.rhs", expected, Fact(f"{len(table.rhs)}"))
    formulas = tuple(
        parse_lyapunov(text, table.states, file, f"system.rhs[{k}]") for k, text in enumerate(table.rhs, 1)
    )
    turns = [turn for formula in formulas for turn in formula.turns()]
    numbers = Numbers(file, field_of([*turns, *angles(check)]))
    radius = numbers.positive(check.radius, "check.radius")
    return SwitchedEquations(document.name or path.stem, numbers.field, table.states, formulas, radius, file)
