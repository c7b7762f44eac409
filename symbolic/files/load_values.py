"""The loads of a scene file: a model by name, a table, a scatter of springs, or loads measured at one pose."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Annotated, NamedTuple, TypeAlias

from pydantic import PlainValidator

from nonsmooth.symbolic.files.scene_values import Exact, Numbers, read_exact, read_pair
from nonsmooth.symbolic.mechanics.load_model import LoadScatter, UnknownLoads
from nonsmooth.symbolic.mechanics.scene import LoadTable
from nonsmooth.symbolic.mechanics.springs import NoSpringsError, carried_table, centre_of, largest_correction
from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_text import short_text
from nonsmooth.symbolic.numbers.plane import Vector

EXPECTED = (
    'required "elastic", "any", rows [[c0, cx, cy], ...], or a table of kind "elastic" (with height or stiffness) '
    'or "measured" (with values)'
)
WITHIN = Fraction(1, 20)  # of the mean load: how far measured loads may be from the balance at the stated pose


class LoadRows(NamedTuple):
    """Rows ``[c0, cx, cy]``, one for each wheel."""

    rows: tuple[tuple[Exact, Exact, Exact], ...]


class ScatteredSprings(NamedTuple):
    """Springs that are not quite equal."""

    height: Exact
    stiffness: Exact


class MeasuredLoads(NamedTuple):
    """Loads of all wheels at one pose, in any unit; the centre of mass there, where it is stated."""

    values: tuple[Exact, ...]
    at: tuple[Exact, Exact] | None
    within: Exact


StatedLoads: TypeAlias = LoadRows | ScatteredSprings | MeasuredLoads | UnknownLoads


def read_loads(value: object) -> StatedLoads | None:
    """``elastic`` (None), ``any``, [[c0, cx, cy], ...], {table = [...]}, or a table with a kind.

    Raises:
        ValueError: for anything else.
    """
    if value == "elastic":
        return None
    if value == "any":
        return UnknownLoads()
    if isinstance(value, dict) and "kind" in value:
        return _of_kind(value)
    rows = value["table"] if isinstance(value, dict) and set(value) == {"table"} else value
    if not isinstance(rows, list) or not all(isinstance(row, list) for row in rows):
        raise ValueError(EXPECTED)
    if not all(len(row) == 3 for row in rows):
        raise ValueError("required rows of three numbers [c0, cx, cy]")
    return LoadRows(tuple((read_exact(a), read_exact(b), read_exact(c)) for a, b, c in rows))


def _of_kind(table: Mapping[str, object]) -> StatedLoads | None:
    match table["kind"]:
        case "any":
            _require_keys(table, ())
            return UnknownLoads()
        case "elastic":
            _require_keys(table, ("height", "stiffness"))
            if len(table) == 1:
                return None
            return ScatteredSprings(read_exact(table.get("height", 0)), read_exact(table.get("stiffness", 0)))
        case "measured":
            _require_keys(table, ("values", "at", "within"))
            return _measured(table)
        case _:
            raise ValueError('required kind = "any", "elastic" or "measured"')


def _require_keys(table: Mapping[str, object], keys: Sequence[str]) -> None:
    unknown = [key for key in table if key not in ("kind", *keys)]
    if unknown:
        named = ", ".join(keys) or "none"
        raise ValueError(f'required no key {unknown[0]!r} beside kind = "{table["kind"]}" (keys: {named})')


def _measured(table: Mapping[str, object]) -> MeasuredLoads:
    values = table.get("values")
    if not isinstance(values, list) or not values:
        raise ValueError('required values = [N_1, N_2, ...] beside kind = "measured"')
    at = None if "at" not in table else read_pair(table["at"])
    within = read_exact(table["within"]) if "within" in table else WITHIN
    return MeasuredLoads(tuple(map(read_exact, values)), at, within)


Loads = Annotated[StatedLoads | None, PlainValidator(read_loads)]


def build_loads(
    stated: StatedLoads | None, numbers: Numbers, positions: Sequence[Vector]
) -> LoadTable | UnknownLoads | None:
    """The load model in exact numbers.

    Raises:
        SceneError: for a number of loads that is not that of the wheels, and for values that cannot be.
    """
    match stated:
        case LoadRows():
            return _table(stated, numbers, len(positions))
        case UnknownLoads():
            return stated
        case ScatteredSprings():
            return _scattered(stated, numbers)
        case MeasuredLoads():
            return _carried(stated, numbers, positions)
        case _:
            return None


def _table(stated: LoadRows, numbers: Numbers, wheels: int) -> LoadTable:
    if len(stated.rows) != wheels:
        expected = f"{wheels} rows [c0, cx, cy], one for each wheel"
        raise SceneError(numbers.file, "contact.loads", expected, StatedFact(f"{len(stated.rows)}"))
    key = "contact.loads[{}]"
    exact = tuple(
        (numbers(a, key.format(k)), numbers(b, key.format(k)), numbers(c, key.format(k)))
        for k, (a, b, c) in enumerate(stated.rows, 1)
    )
    return LoadTable(exact)


def _scattered(stated: ScatteredSprings, numbers: Numbers) -> UnknownLoads | None:
    """Springs without any scatter are the elastic loads."""
    height = _share(stated.height, numbers, "contact.loads.height")
    stiffness = _share(stated.stiffness, numbers, "contact.loads.stiffness")
    if (stiffness - 1).sign() >= 0:
        received = StatedFact(short_text(stiffness))
        raise SceneError(numbers.file, "contact.loads.stiffness", "a share of the stiffness below 1", received)
    return UnknownLoads(LoadScatter(height, stiffness)) if height or stiffness else None


def _share(value: Exact, numbers: Numbers, key: str) -> Number:
    number = numbers(value, key)
    if number.sign() < 0:
        raise SceneError(numbers.file, key, "a number >= 0", StatedFact(short_text(number)))
    return number


def _carried(stated: MeasuredLoads, numbers: Numbers, positions: Sequence[Vector]) -> LoadTable:
    """Measured loads at every pose: see :mod:`nonsmooth.symbolic.mechanics.springs`."""
    if len(stated.values) != len(positions):
        expected = f"{len(positions)} values, one for each wheel"
        raise SceneError(numbers.file, "contact.loads.values", expected, StatedFact(f"{len(stated.values)}"))
    key = "contact.loads.values"
    values = [_share(value, numbers, f"{key}[{k}]") for k, value in enumerate(stated.values, 1)]
    if not any(values):
        raise SceneError(numbers.file, key, "a load that is not zero", StatedFact("zeros"))
    try:
        table = carried_table(values, positions)
    except NoSpringsError:
        received = StatedFact(f"{len(positions)} wheels on one line")
        raise SceneError(numbers.file, "contact.loads", "three wheels that are not collinear", received) from None
    _require_balance(stated, numbers, table, centre_of(values, positions))
    return table


def _require_balance(stated: MeasuredLoads, numbers: Numbers, table: LoadTable, centre: Vector) -> None:
    """Refuse values whose centre is not where the pose is said to have been."""
    if stated.at is None:
        return
    x, y = (numbers(value, "contact.loads.at") for value in stated.at)
    within = numbers.positive(stated.within, "contact.loads.within")
    if largest_correction(table, centre, (x, y)) * len(table.rows) > within:
        place = f"({float(centre[0]):.6g}, {float(centre[1]):.6g})"
        expected = f"{place}, where the values put the centre of mass (to within {short_text(within)} of the mean load)"
        raise SceneError(numbers.file, "contact.loads.at", expected, StatedFact(f"({float(x):.6g}, {float(y):.6g})"))
