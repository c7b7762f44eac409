"""Cells of a sweep's grid that are certified as a whole: every array between their corners, and within its tolerances.

A cell is one scene, the middle of it, with tolerances that are larger by half the cell's sides: what is proved of all
arrays within those holds in the whole cell.  What is not proved is left open; nothing is sampled.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise, product
from typing import Any, TypeAlias

from nonsmooth.analysis.cells.contact_rule import rule_of
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.proofs.findings import Certainty, Record
from nonsmooth.proofs.robust.decide import decided_statement
from nonsmooth.reports.sweeps.base import Base
from nonsmooth.reports.sweeps.borders import has_place
from nonsmooth.reports.sweeps.sweep_plan import Axis, Entry, SweepError, SweepPlan, Value
from nonsmooth.symbolic.files.key_paths import Path
from nonsmooth.symbolic.mechanics.contact_set import standing
from nonsmooth.symbolic.mechanics.scene import LoadTable, Scene
from nonsmooth.symbolic.mechanics.springs import MeasuredTable
from nonsmooth.symbolic.messages.scene_error import SceneError, one_line, shown

TABLE = "tolerance"
ENTRIES = ("position", "heading", "speed", "mu_roll", "mu_side")
ROOM = 1 + Fraction(1, 2**20)  # of half a side: headings of the scene are right to 1e-15
HALF_TURN = 180  # degrees
FOLLOWING = ("inward", "outward", "that of the field")  # headings that follow the position of a wheel

Sides: TypeAlias = tuple[tuple[Value, Value], ...]


@dataclass(frozen=True)
class CertifiedCell:
    """One cell of the grid.

    Attributes:
        sides: from where to where, along each axis.
        verdict: whether a bound is proved for all of it.
        ends_within: radius of the disc in which every body ends (length); None where none is proved.
        starts_within: radius of the disc of starts (length); None where only starts close by are meant, or none.
        why: why not, else empty.
    """

    sides: Sides
    verdict: Certainty
    ends_within: Fraction | None
    starts_within: Fraction | None
    why: str


@dataclass(frozen=True)
class Cells:
    """All cells of a grid.

    Attributes:
        base: the scene with a table of tolerances in which every entry stands.
        paths: what the scene of a cell changes: the numbers that vary, and the tolerances.
        sides: of every cell.
        entries: the values of ``paths`` for every cell.
    """

    base: Base
    paths: tuple[Path, ...]
    sides: tuple[Sides, ...]
    entries: tuple[tuple[Entry, ...], ...]


def exact_base(base: Base) -> Base:
    """The scene without tolerances."""
    return replace(base, document={key: value for key, value in base.document.items() if key != TABLE})


def planned_cells(base: Base, plan: SweepPlan) -> Cells:
    """The cells of a grid, before anything is proved.

    Raises:
        SweepError: for draws, values that do not ascend, and numbers that are not in boxes of tolerances.
    """
    _require_cells(plan)
    _require_independent(base, plan)
    given = base.document.get(TABLE) or {}
    whole = replace(base, document={**base.document, TABLE: {**dict.fromkeys(ENTRIES, 0), **given}})
    paths = (*(axis.path for axis in plan.axes), *((TABLE, name) for name in ENTRIES))
    tolerances = None if TABLE not in base.document else base.scene((), ()).tolerances
    stated = {name: "0" if tolerances is None else str(getattr(tolerances, name)) for name in ENTRIES}
    radians = (base.document.get("units") or {}).get("angle") == "rad"
    sides = tuple(_sides_of(plan))
    return Cells(whole, paths, sides, tuple(_entries(plan, cell, stated, radians=radians) for cell in sides))


def _require_cells(plan: SweepPlan) -> None:
    if plan.draws is not None:
        raise SweepError("certify: required a grid of scenes, received random draws")
    for axis in plan.axes:
        if _entry_of(axis) is None:
            allowed = "positions, headings, speeds, mu_roll, mu_side of wheels or the checked point"
            raise SweepError(f"certify: required numbers that tolerances follow ({allowed}), received {axis.name}")
        if len(_values(axis)) < 2 or not has_place(axis.values):
            raise SweepError(f"certify: required two or more rational values of {axis.name} that ascend")


def _require_independent(base: Base, plan: SweepPlan) -> None:
    """Refuse a number of a wheel that another one follows, or should turn with: tolerances move each on its own.

    A checked point that varies is a tolerance of all positions.  With it a table changes the loads of all wheels at
    once, which no tolerance does; those of springs balance wherever the wheels are.
    """
    friction, is_tilted = base.document.get("friction") or {}, _rests_on_tilted_table(base.scene((), ()))
    for axis in plan.axes:
        if axis.path[0] == "check" and is_tilted:
            expected = f"elastic or measured loads, or a table of constant ones, since {axis.name} varies"
            raise SweepError(f"certify: required {expected}, received a table that is affine in c")
        if axis.path[0] != "wheel":
            continue
        place = int(axis.path[1])
        wheel = base.document["wheel"][place]
        grip = wheel.get("axis", friction.get("axis"))
        if axis.path[2] == "heading" and grip is not None:
            raise SweepError(f"certify: required a friction axis that turns with {axis.name}, received {shown(grip)}")
        for name, value in (("heading", wheel.get("heading", "that of the field")), ("axis", grip)):
            if axis.path[2] == "position" and value in FOLLOWING:
                expected = f"an angle or a direction as {name} of wheel {place + 1}, since {axis.name} varies"
                raise SweepError(f"certify: required {expected}, received {shown(value)}")


def _rests_on_tilted_table(scene: Scene) -> bool:
    """Whether motions depend on a table of loads that change with the body's place."""
    loads = scene.contact.loads
    if not isinstance(loads, LoadTable) or isinstance(loads, MeasuredTable):
        return False
    return rule_of(scene).needs_loads and any(b or c for _, b, c in loads.rows)


def _sides_of(plan: SweepPlan) -> Iterator[Sides]:
    """The sides of all cells, the last axis fastest."""
    yield from product(*(pairwise(_values(axis)) for axis in plan.axes))


def _values(axis: Axis) -> list[Any]:
    return [axis.values.value(k) for k in range(axis.values.count or 0)]


def _entries(plan: SweepPlan, sides: Sides, stated: Mapping[str, str], *, radians: bool) -> tuple[Entry, ...]:
    """The middle of a cell, and its tolerances."""
    middles = [low.between(high, Fraction(1, 2)) for low, high in sides]
    larger = dict.fromkeys(ENTRIES, Fraction(0))
    for axis, (low, high), middle in zip(plan.axes, sides, middles, strict=True):
        name = _entry_of(axis)
        side = replace(low, constant=high.constant - low.constant, multiple=high.multiple - low.multiple)
        if name is not None:
            larger[name] += _size(name, side, middle, radians=radians) / 2 * ROOM
    sizes = (_enlarged(name, stated[name], larger[name]) for name in ENTRIES)
    return (*(middle.entry for middle in middles), *sizes)


def _enlarged(name: str, stated: str, size: Fraction) -> str:
    """A tolerance larger by half a side; of a share s of a value within a share h of the middle, ``s + h + s h``."""
    if name == "heading":
        return f"({stated} + {size})*pi rad"
    return f"{stated} + {size}" if name == "position" else f"{stated} + {size} + ({stated})*({size})"


def _size(name: str, side: Value, middle: Value, *, radians: bool) -> Fraction:
    """A side of a cell in the unit of its tolerance: a length, a share of the middle, or a turn in half turns."""
    if name == "heading":
        return _turn(side, radians=radians)
    if side.multiple or middle.multiple:
        raise SweepError(f"certify: required rational values of {name}, received multiples of pi")
    if name == "position":
        return side.constant
    if not middle.constant:
        raise SweepError(f"certify: required {name} of one sign, for a tolerance is a share of it; received 0")
    return side.constant / abs(middle.constant)


def _turn(side: Value, *, radians: bool) -> Fraction:
    in_degrees = side.unit == "deg" or (not side.unit and not side.multiple and not radians)
    if in_degrees and not side.multiple:
        return side.constant / HALF_TURN
    if not side.constant and side.unit != "deg":
        return side.multiple
    raise SweepError("certify: required headings in degrees or as multiples of pi, received radians")


def _entry_of(axis: Axis) -> str | None:
    """The tolerance that follows a number; None for others."""
    table, *middle, last = axis.path
    if table == "check":
        return "position" if middle == ["equilibrium"] else None
    if table == "friction":
        return str(last) if last in ("mu_roll", "mu_side") else None
    if table != "wheel":
        return None
    if middle[1:] == ["position"]:
        return "position"
    return str(last) if last in ("heading", "speed", "mu_roll", "mu_side") else None


def cell_outcome(base: Base, paths: Sequence[Path], entries: Sequence[Entry]) -> Record:
    """What is proved of one cell, as a record that a store holds."""
    try:
        found = decided_statement(standing(base.scene(paths, entries)))
    except (SceneError, RefusalError) as error:
        return {"verdict": str(Certainty.UNDECIDED), "radius": None, "start": None, "why": one_line(str(error))}
    radius, start = (None if value is None else str(value) for value in (found.radius, found.start))
    why = "" if found.verdict is Certainty.CERTIFIED else found.reason
    return {"verdict": str(found.verdict), "radius": radius, "start": start, "why": why}


def certified_cell(sides: Sides, outcome: Any) -> CertifiedCell:
    """A cell from its record."""
    radius, start = (None if outcome[key] is None else Fraction(outcome[key]) for key in ("radius", "start"))
    return CertifiedCell(sides, Certainty(outcome["verdict"]), radius, start, outcome["why"])
