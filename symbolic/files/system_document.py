"""The tables of a scene file with ``[system]``: which keys there are, and what each must be.

A new table or key of plain systems is declared here; :mod:`nonsmooth.symbolic.files.system_file` reads it.
"""

from __future__ import annotations

import re
from fractions import Fraction
from typing import Annotated

from pydantic import Field, PlainValidator

from nonsmooth.symbolic.files.parameters import read_parameters
from nonsmooth.symbolic.files.region_tables import RegionTable
from nonsmooth.symbolic.files.scene_document import Name
from nonsmooth.symbolic.files.scene_values import Exact, ExactField, TomlTable, read_exact
from nonsmooth.symbolic.piecewise import NUMBERS, SWITCHES

MAX_STATES = 8
_STATE = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,19}")
RESERVED = {*NUMBERS, *SWITCHES}


def is_state(value: object) -> bool:
    """Whether a value can name a state."""
    return isinstance(value, str) and _STATE.fullmatch(value) is not None and value not in RESERVED


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
    """``[system]``: the states, one right-hand side for each (or ``[[region]]`` tables), and named numbers in them."""

    states: Annotated[tuple[str, ...], PlainValidator(read_states)]
    rhs: Annotated[tuple[object, ...] | None, PlainValidator(read_formulas)] = None
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
