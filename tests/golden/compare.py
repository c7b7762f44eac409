"""What differs between two records of a row, in three classes of equality.

*exact*: exit statuses, verdicts, keys, words, refusals, exact values.  *float*: numbers that are printed or stored as
floats, to 1e-9.  *not weaker*: what is searched may differ (a V) or grow (a region, a rate), and ``undecided`` may
become decided; which keys and phrases these are is said in ``classes.toml``.  The matrix shows what changed.  It says
nothing of what is true.
"""

from __future__ import annotations

import ast
import operator
import re
import tomllib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any

from tests.golden.contents import split

CLOSE = 1e-9  # of floats, relative to the larger one and to 1
NOISE = 10  # times as large may an error be
UNDECIDED = "undecided"
TIME_OUT, DONE = "time-out", "done"
SAMPLES = 41  # of a region along each state
SMALLEST_SHARE = 0.98  # of the region before, by samples


@dataclass(frozen=True)
class Difference:
    """One place at which a record is not what it was.

    Attributes:
        path: where, such as ``steps.0.out.translation.verdict``.
        before, after: what was and is there; "(nothing)" for what is missing.
        allowed: that the difference is one of *not weaker*: more is shown than before.
    """

    path: str
    before: Any
    after: Any
    allowed: bool = False

    def __str__(self) -> str:
        return f"{self.path}: {_short(self.before)} -> {_short(self.after)}"


def _short(value: Any) -> str:
    text = str(value)
    return text if len(text) <= 200 else f"{text[:140]} ... {text[-50:]}"


class Nothing:
    """Stands where a key or an item is missing."""

    def __str__(self) -> str:
        return "(nothing)"


NOTHING = Nothing()


@cache
def _classes() -> dict[str, list[str]]:
    text = (Path(__file__).parent / "classes.toml").read_text(encoding="utf-8")
    return tomllib.loads(text)


def _is(kind: str, path: str) -> bool:
    """Whether a path is of a class; its end counts, and exact texts are of the class of their number."""
    place = path.replace(".exact.", ".")
    return any(fnmatchcase(place, f"*.{pattern}") for pattern in _classes()[kind])


def differences(before: Any, after: Any, path: str = "") -> Iterator[Difference]:
    """Every difference, also the allowed ones.

    Args:
        before, after: two records, or parts of them at the same place.
        path: that place.
    """
    if _is("ignored", path):
        return
    if isinstance(before, Mapping) and isinstance(after, Mapping):
        yield from _of_tables(before, after, path)
    elif isinstance(before, list) and isinstance(after, list):
        yield from _of_lists(before, after, path)
    elif not _are_equal(before, after, path):
        yield Difference(path, before, after, _is_not_weaker(before, after, path))


def _of_tables(before: Mapping[str, Any], after: Mapping[str, Any], path: str) -> Iterator[Difference]:
    """Of two tables: key by key.  Where a verdict is new, its reason and evidence are too.

    A time limit that a faster machine meets says nothing of the product.
    """
    if before.get("outcome") == TIME_OUT and after.get("outcome") == DONE:
        return
    if before.get("verdict") == UNDECIDED != after.get("verdict", UNDECIDED):
        yield Difference(f"{path}.verdict", UNDECIDED, after["verdict"], allowed=True)
        return
    if "V" in before and "V" in after and before["V"] != after["V"]:
        yield from _of_searched(before, after, path)
        return
    for key in {**before, **after}:
        place = f"{path}.{key}"
        if key in before and key in after:
            yield from differences(before[key], after[key], place)
        elif not _is("ignored", place):
            yield Difference(place, before.get(key, NOTHING), after.get(key, NOTHING))


def _of_lists(before: list[Any], after: list[Any], path: str) -> Iterator[Difference]:
    if len(before) == len(after):
        for k, (a, b) in enumerate(zip(before, after, strict=True)):
            yield from differences(a, b, f"{path}.{k}")
        return
    if all(isinstance(line, str) for line in (*before, *after)):
        lost = [line for line in before if line not in after]
        new = [line for line in after if line not in before]
        yield Difference(path, lost or f"{len(before)} lines", new or f"{len(after)} lines")
    else:
        yield Difference(path, f"{len(before)} items", f"{len(after)} items")


def _are_equal(before: Any, after: Any, path: str) -> bool:
    if isinstance(before, bool) or isinstance(after, bool):
        return before is after
    if isinstance(before, int) and isinstance(after, int):
        return before == after
    if isinstance(before, int | float) and isinstance(after, int | float):
        if _is("noise", path):
            return abs(after) <= NOISE * abs(before) + CLOSE
        return abs(before - after) <= CLOSE * max(1, abs(before), abs(after))
    if isinstance(before, str) and isinstance(after, str):
        return before == after or (".exact." not in path and _are_equal_texts(before, after))
    return before == after


def _are_equal_texts(before: str, after: str) -> bool:
    """Equal words and numbers: whole ones exactly, others as floats; searched numbers may be others."""
    for pattern in _classes()["phrases"]:
        before, after = (re.sub(pattern, "(searched)", text) for text in (before, after))
    words, numbers = split(before)
    other_words, other_numbers = split(after)
    return words == other_words and all(
        a == b or ({"."} & {*a, *b} and abs(float(a) - float(b)) <= CLOSE * max(1, abs(float(a)), abs(float(b))))
        for a, b in zip(numbers, other_numbers, strict=True)
    )


def _is_not_weaker(before: Any, after: Any, path: str) -> bool:
    """Whether what is said now is at least as much as before."""
    if before == UNDECIDED or _is("searched", path):
        return isinstance(after, type(before))
    if before is None or isinstance(before, Nothing):
        return _is("grows", path) or _is("shrinks", path)
    numbers = [_number(value) for value in (before, after)]
    if None in numbers:
        return False
    old, new = numbers
    return (_is("grows", path) and new > old) or (_is("shrinks", path) and new < old)


def _number(value: Any) -> Any:
    """A float, or a fraction as text; None for anything else."""
    if isinstance(value, str):
        try:
            top, _, bottom = value.partition("/")
            return int(top) / int(bottom or 1)
        except ValueError:
            return None
    return value if isinstance(value, int | float) else None


def _of_searched(before: Mapping[str, Any], after: Mapping[str, Any], path: str) -> Iterator[Difference]:
    """Of two proofs with different V: verdicts as they were, the region not smaller, the rate not slower."""
    yield Difference(f"{path}.V", before["V"], after["V"], allowed=True)
    for key in ("verdict", "proves"):
        yield from differences(before.get(key), after.get(key), f"{path}.{key}")
    old, new = (_size_of_region(record) for record in (before, after))
    if old != new:
        yield Difference(f"{path}.region (size by samples)", old, new, new >= SMALLEST_SHARE * old)
    for key, number in (("rate", "kappa"), ("gain", "gamma")):
        a, b = (record.get(key) for record in (before, after))
        if (a is None) != (b is None):
            yield Difference(f"{path}.{key}", a, b, a is None)
        elif not isinstance(a, Mapping) or not isinstance(b, Mapping):
            yield from differences(a, b, f"{path}.{key}")
        elif a.get("kind") == b.get("kind"):
            yield from differences(a[number], b[number], f"{path}.{key}.{number}")


def _size_of_region(record: Mapping[str, Any]) -> float:
    """The measure of ``V < level`` in the box of the region; 0 without one, infinite where all of space is proved."""
    if record.get("domain", {}).get("kind") in {"plane", "space"}:
        return float("inf")
    region = record.get("region")
    if not region or "level" not in region:
        return 0.0
    tree = ast.parse(record["V"], mode="eval").body
    states = record.get("states") or _states_of(tree, 2 if record["domain"]["kind"] == "square" else 3)
    half = float(region["within"])
    steps = [half * (2 * k / (SAMPLES - 1) - 1) for k in range(SAMPLES)]
    points = list(product(steps, repeat=len(states)))
    inside = sum(_formula(tree, dict(zip(states, point, strict=True))) < region["level"] for point in points)
    return inside / len(points) * (2 * half) ** len(states)


def _states_of(tree: ast.expr, count: int) -> list[str]:
    """The names in V, which are those of its states, with others where it does not hold so many."""
    known = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)} - _FUNCTIONS.keys()
    return [*sorted(known), *(f"other{k}" for k in range(count - len(known)))]


_FUNCTIONS: dict[str, Callable[..., float]] = {
    "Abs": abs,
    "Max": max,
    "Min": min,
    "sqrt": lambda x: x**0.5,
    "sign": lambda x: (x > 0) - (x < 0),
    "relu": lambda x: max(x, 0.0),
}
_OPERATORS: dict[type[ast.operator], Callable[[float, float], float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
}


def _formula(node: ast.expr, at: Mapping[str, float]) -> float:
    """A formula of the states, by its tree."""
    match node:
        case ast.Constant(value=value):
            return float(value)  # type: ignore[arg-type]
        case ast.Name(id=name):
            return at[name]
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return -_formula(operand, at)
        case ast.Call(func=ast.Name(id=name), args=arguments):
            return _FUNCTIONS[name](*(_formula(argument, at) for argument in arguments))
        case ast.BinOp(left=left, op=kind, right=right):
            return _OPERATORS[type(kind)](_formula(left, at), _formula(right, at))
    raise ValueError(f"a formula of states, numbers and known functions, not {ast.unparse(node)}")
