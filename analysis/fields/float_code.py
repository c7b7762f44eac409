"""Functions of single floats in straight-line code, which Python compiles: for few numbers NumPy's calls take longer.

The code is written here and by who calls :func:`compiled`: it holds names that they make, floats, sums and products.
No name and no text of a user is part of it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import lru_cache
from types import CodeType, FunctionType
from typing import Any, TypeAlias

Numbers: TypeAlias = tuple[float, ...]
KEPT = 512  # functions: paths of one system from many starts compile its fields once


def names(letter: str, count: int) -> list[str]:
    """So many names: x0, x1, ..."""
    return [f"{letter}{k}" for k in range(count)]


def listed(entries: Iterable[str]) -> str:
    """Entries of a tuple, each with its comma."""
    return "".join(f"{entry}, " for entry in entries)


def weighted(terms: Iterable[tuple[float, Sequence[str]]]) -> str:
    """A sum of products of a finite coefficient and names, without those whose coefficient is zero."""
    products = ["*".join([repr(float(weight)), *factors]) for weight, factors in terms if weight]
    return " + ".join(products) or "0.0"


@lru_cache(maxsize=KEPT)
def compiled(arguments: str, *lines: str) -> Callable[..., Any]:
    """The function with these arguments and lines; it may call ``abs`` and ``max``."""
    module = compile(f"def written({arguments}):\n    " + "\n    ".join(lines), "<written out>", "exec")
    (code,) = (constant for constant in module.co_consts if isinstance(constant, CodeType))
    return FunctionType(code, {"abs": abs, "max": max})
