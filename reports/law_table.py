"""The certified feedback law as a table of regions and speeds, in floats; poses are measured from the checked point.

In every region each speed is a fixed combination of a few terms of the pose, times the gain k: the table lists the
combinations, and :mod:`nonsmooth.reports.law_program` writes them as a program.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import SupportsFloat, TypeAlias

import numpy as np

from nonsmooth.analysis.cells.partition import Cell
from nonsmooth.analysis.plane_arrays import turned
from nonsmooth.proofs.clauses.feedback.by_friction import DrivenFeedback
from nonsmooth.proofs.clauses.feedback.by_rows import FeedbackResult
from nonsmooth.proofs.clauses.feedback.cascade_law import CascadeLaw, Descent
from nonsmooth.proofs.clauses.feedback.driven_law import LawCone, in_scene, rim_speeds
from nonsmooth.proofs.clauses.feedback.facts import AnyFeedback
from nonsmooth.proofs.clauses.feedback.gradient_law import LevelRegion
from nonsmooth.proofs.clauses.feedback.loop_bounds import wheel_speed
from nonsmooth.proofs.theorem4_result import CellCheck, Check
from nonsmooth.proofs.verdicts import Feedback
from nonsmooth.symbolic.constraints import RowKind
from nonsmooth.symbolic.contact_states import ContactState
from nonsmooth.symbolic.number_text import brief_text, float_text, lower_text
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.similar_scenes import in_own_length

Floats: TypeAlias = tuple[float, ...]


NEARBY = "from starts near the checked point; how near is not known"


class NoLawError(ValueError):
    """A check that certifies no law; ``str(error)`` is one line."""


class LawKind(StrEnum):
    """What the speeds are combinations of; the value says it."""

    GRADIENT = "X = (1 + e) x + f y, Y = f x + (1 - e) y, T = w theta + Y x - X y"
    CASCADE = "r = sqrt(x^2 + y^2), x, y, theta"
    SLOW_TURNS = "A = (1 - W) r, W = s/l - theta + s^2/(2 r l), where (r, s) is c along and across the nearest p_i"
    DRIVEN = "g . xi_l, g = (x, y, w theta), for the xi_l of the region with the largest |g . xi_l|"


@dataclass(frozen=True)
class LawRegion:
    """A part of the plane of c in which the speeds are the same combinations.

    Attributes:
        name: of the cell, or of the directions of c.
        where: its corners, or what else it is, in words.
        sides: ``(a, b, c)`` with ``a + b x + c y >= 0`` inside.
        speeds: for each wheel that is driven the coefficients of the terms; of a driven law one for each twist.
        axes: the direction of the nearest wheel (slow turns), or the twists xi_l (driven).
    """

    name: str
    where: str
    sides: tuple[Floats, ...]
    speeds: Mapping[int, Floats]
    axes: tuple[Floats, ...] = ()


@dataclass(frozen=True)
class LawTable:
    """The law of one check.

    Attributes:
        scene: the array, measured from the checked point.
        kind: what the speeds are combinations of.
        regions: they cover what was built of the checked square, or all directions of c.
        constants: e, f, w or l.
        certified: from which starts it is certified, in words.
        effort: how fast wheels run at most, in words; empty where that is not known.
    """

    scene: Scene
    kind: LawKind
    regions: tuple[LawRegion, ...]
    constants: Mapping[str, float]
    certified: str = NEARBY
    effort: str = ""

    def rows(self) -> list[dict[str, str]]:
        """One row for each region, twist and wheel: where, and the speed of its rim.

        With limits each row has its wheel's: all speeds of a region are scaled by one factor to keep them.
        """
        rows = [row for region in self.regions for row in self._rows_of(region)]
        limits = {str(index): repr(float(limit)) for index, limit in self.scene.speed_limits.items()}
        return [row | {"speed_limit": limits.get(row["wheel"], "")} for row in rows] if limits else rows

    def _rows_of(self, region: LawRegion) -> Iterable[dict[str, str]]:
        if self.kind is not LawKind.DRIVEN:
            for wheel, speed in region.speeds.items():
                yield _row(region, "", wheel, f"k ({_sum(speed, TERMS[self.kind])})")
            return
        for index, twist in enumerate(region.axes):
            name = f"({', '.join(map(repr, twist))})"
            for wheel, speed in region.speeds.items():
                yield _row(region, name, wheel, f"-k (g . xi_l) {speed[index]!r}")


TERMS = {
    LawKind.GRADIENT: ("X", "Y", "T"),
    LawKind.CASCADE: ("r", "x", "y", "theta"),
    LawKind.SLOW_TURNS: ("A", "W"),
}


def law_table(check: Check) -> LawTable:
    """The law that the feedback clause of a check certifies.

    Raises:
        NoLawError: where it certifies none.
    """
    feedback, scene = check.feedback.holding, check.scene.recentred()
    if feedback.verdict is not Feedback.STABILIZABLE:
        raise NoLawError(f"required a certified feedback law; the feedback clause says {feedback.verdict}")
    table = _table(check, feedback, scene)
    fastest = wheel_speed(feedback, scene)
    if fastest is None:
        return table
    return replace(table, effort=f"{float(fastest)!r} k sqrt(V), V = {feedback.lyapunov}")


def _table(check: Check, feedback: AnyFeedback, scene: Scene) -> LawTable:
    if isinstance(feedback, DrivenFeedback):
        own = in_own_length(scene)
        cones = tuple(_cone(own, cone, feedback) for cone in feedback.cones)
        return LawTable(scene, LawKind.DRIVEN, cones, {"w": float(feedback.length) ** 2}, _reach_text(feedback))
    if not (isinstance(feedback, FeedbackResult) and isinstance(check, CellCheck)):
        raise NoLawError(f"required a law of cells or of imposed twists, received rule {scene.contact.rule}")
    return replace(_by_cells(scene, feedback, check.partition.cells), certified=_region_text(feedback))


def _by_cells(scene: Scene, feedback: FeedbackResult, cells: Sequence[Cell]) -> LawTable:
    """The law of rule ``nearest``."""
    if feedback.cascade is None:
        (e, f), weight = feedback.lyapunov.shape, feedback.lyapunov.weight
        constants = {"e": float(e), "f": float(f), "w": float(weight)}
        return LawTable(scene, LawKind.GRADIENT, tuple(map(_gradient, cells)), constants)
    if feedback.cascade.descent is Descent.SLOW_TURNS:
        length = {"l": float(scene.check.radius)}
        return LawTable(scene, LawKind.SLOW_TURNS, tuple(map(_slow_turns, cells)), length)
    signs = _signs(feedback.cascade)
    return LawTable(scene, LawKind.CASCADE, tuple(_cascade(cell, signs) for cell in cells), {})


def _region_text(feedback: FeedbackResult) -> str:
    if feedback.region is None:
        return NEARBY
    meant = f", V = {feedback.lyapunov}" if isinstance(feedback.region, LevelRegion) else ""
    return f"from starts with {feedback.region}{meant}"


def _reach_text(feedback: DrivenFeedback) -> str:
    """Under rule ``box`` V falls in a square about the point; the largest level of V within it brings bodies home."""
    if feedback.every_load is not None:
        return f"{NEARBY}, under every load that the scene leaves open"
    if feedback.reach is None:
        return NEARBY
    weight = "" if feedback.length == 1 else f"{float(feedback.lyapunov.weight)!r} "
    return f"from starts with x^2 + y^2 + {weight}theta^2 < {lower_text(feedback.reach, 4)}^2"


def _row(region: LawRegion, twist: str, wheel: int, speed: str) -> dict[str, str]:
    return {"region": region.name, "where": region.where, "xi_l": twist, "wheel": str(wheel), "speed": speed}


def _sum(coefficients: Sequence[float], names: Sequence[str]) -> str:
    return " + ".join(f"{value!r} {name}" for value, name in zip(coefficients, names, strict=True) if value) or "0"


def _region(cell: Cell, speeds: Mapping[int, Floats], axes: tuple[Floats, ...] = ()) -> LawRegion:
    corners = [f"({', '.join(map(brief_text, vertex))})" for vertex in cell.polygon.vertices]
    sides = tuple(_floats((s.offset, -s.normal[0], -s.normal[1])) for s in cell.polygon.sides)
    return LawRegion(f"cell {cell.index}", f"corners {', '.join(corners)}", sides, speeds, axes)


def _gradient(cell: Cell) -> LawRegion:
    """``u_w = -k (a X + b Y + c T)`` with the control field (a, b, c) of wheel w."""
    fields = cell.states[0].control_fields
    return _region(cell, {wheel: _floats(-entry for entry in field) for wheel, field in fields.items()})


def _signs(cascade: CascadeLaw) -> dict[int, int]:
    return {wheel.index: sign for wheel, sign in zip(cascade.wheels, cascade.signs, strict=True)}


def _roll_rows(state: ContactState) -> dict[int, Floats]:
    """Of each wheel that acts: ``u_w = row . (v, omega)``."""
    acting = [row for row in (state.rows[0], state.rows[2]) if row.kind is RowKind.ROLL]
    return {row.wheel.index: _floats(row.unit_normal) for row in acting}


def _cascade(cell: Cell, signs: Mapping[int, int]) -> LawRegion:
    """``omega = -k theta`` and ``v = k s r d - (n . J p) omega n``; ``-k c . d`` for ``k s r`` where no s is known."""
    state = cell.states[0]
    wheel = state.rows[0].wheel
    d, p = np.array(_floats(wheel.unit_direction)), np.array(_floats(wheel.position))
    n = turned(d)
    lever, sign = float(n @ turned(p)), signs.get(wheel.index)
    speeds = {}
    for index, row in _roll_rows(state).items():
        along, turn = float(row[:2] @ d), lever * float(row[:2] @ n) - row[2]
        by_place = (0.0, -along * d[0], -along * d[1]) if sign is None else (sign * along, 0.0, 0.0)
        speeds[index] = _floats((*by_place, turn))
    return _region(cell, speeds)


def _slow_turns(cell: Cell) -> LawRegion:
    """``v = (k - omega) r J p_i/|p_i|`` and ``omega = k W``: the rows times these."""
    state = cell.states[0]
    p = np.array(_floats(state.rows[0].wheel.position))
    out = p / np.hypot(*p)
    across = turned(out)
    speeds = {index: (float(row[:2] @ across), row[2]) for index, row in _roll_rows(state).items()}
    return _region(cell, speeds, (_floats(out),))


def _cone(own: Scene, cone: LawCone, feedback: DrivenFeedback) -> LawRegion:
    """The twists of a cone in the scene's unit, and the speeds that impose each."""
    columns = [rim_speeds(own, imposed) for imposed in cone.twists]
    speeds = {wheel.index: tuple(column[k] for column in columns) for k, wheel in enumerate(own.wheels)}
    twists = tuple(_floats(in_scene(imposed.twist, feedback.length)) for imposed in cone.twists)
    if cone.rays is None:
        return LawRegion("all directions", "everywhere", (), speeds, twists)
    (ax, ay), (bx, by) = (_floats(ray) for ray in cone.rays)
    start, end = (float_text(float(np.degrees(np.arctan2(y, x))) % 360, 4) for x, y in ((ax, ay), (bx, by)))
    sides = ((0.0, -ay, ax), (0.0, by, -bx))
    return LawRegion(f"directions {start} to {end} degrees", "of c, counterclockwise", sides, speeds, twists)


def _floats(values: Iterable[SupportsFloat]) -> Floats:
    return tuple(float(value) + 0.0 for value in values)
