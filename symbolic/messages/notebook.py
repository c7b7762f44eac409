"""What a notebook shows of a result, and how a package offers its public names: without any other package.

Results have ``_repr_html_`` (a plain table) or ``_repr_latex_`` (a formula); the full reports are in
``nonsmooth.reports``.  A package's names are looked up when they are first used, so that importing it
costs nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from importlib import import_module
from typing import Any

MOST_SHOWN = 2_000  # characters of the representation of a result
LONGEST_ENTRY = 80  # characters of one of its entries


class ShortRepr:
    """A dataclass that prints its numbers and texts, and of everything larger only what it is (``repr=False``)."""

    def __repr__(self) -> str:
        fields: Mapping[str, Any] = getattr(self, "__dataclass_fields__", {})
        parts = [f"{name}={_brief(getattr(self, name))}" for name, field in fields.items() if field.repr]
        return f"{type(self).__name__}({', '.join(parts)})"[:MOST_SHOWN]


def _brief(value: object) -> str:
    if isinstance(value, str | int | float | None):
        return repr(value)[:LONGEST_ENTRY]
    if isinstance(value, Mapping | Sequence):
        return f"<{len(value)} entries>"
    return f"<{type(value).__name__}>"


def html_table(caption: str, header: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A table in HTML; every text is escaped."""
    from html import escape  # with a table of all names of characters: only a notebook needs it

    head = "".join(f"<th>{escape(name)}</th>" for name in header)
    body = "".join(f"<tr>{''.join(f'<td>{escape(str(cell))}</td>' for cell in row)}</tr>" for row in rows)
    return f"<table><caption>{escape(caption)}</caption><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def on_demand(package: str, modules: Mapping[str, str]) -> Callable[[str], Any]:
    """The ``__getattr__`` of a package that offers names of its modules (PEP 562).

    Args:
        package: the package's name.
        modules: for each public name the module, below the package, that defines it.
    """

    def look_up(name: str) -> Any:
        if name not in modules:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        return getattr(import_module(f"{package}.{modules[name]}"), name)

    return look_up
