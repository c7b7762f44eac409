"""What Python hands over, as entries of a scene file.

A float means its shortest decimal: ``0.1`` is one tenth.  Fractions, SymPy numbers and texts mean what they say; a text
is a formula such as ``"sqrt(2)/2"`` and is never evaluated as code.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from decimal import Decimal
from fractions import Fraction
from numbers import Integral, Real
from typing import Any, TypeAlias

from nonsmooth.symbolic.numbers.number import Number

Entry: TypeAlias = Any  # a number, a formula, a list of entries, or a table


def entry(value: Any) -> Entry:
    """The value as a scene file would hold it."""
    if value is None or isinstance(value, bool | str | Decimal):
        return value
    if isinstance(value, Mapping):
        return table(value)
    if isinstance(value, Integral):
        return int(value)
    if isinstance(value, Fraction | Number):
        return str(value)
    if isinstance(value, Real):
        return Decimal(repr(float(value)))
    if isinstance(value, Iterable):
        return [entry(part) for part in value]
    return str(value)  # a SymPy number prints as a formula


def as_json(value: Entry) -> Entry:
    """An entry as JSON holds it: a decimal as a number where a float holds it exactly, else as a text."""
    match value:
        case Decimal():
            return float(value) if Decimal(repr(float(value))) == value else str(value)
        case list() | tuple():
            return [as_json(part) for part in value]
        case Mapping():
            return {str(key): as_json(part) for key, part in value.items()}
    return value


def table(values: Mapping[str, Any]) -> dict[str, Entry]:
    """A table of entries without those that are None."""
    return {key: entry(value) for key, value in values.items() if value is not None}
