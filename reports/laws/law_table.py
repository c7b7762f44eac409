"""A feedback law as a table of regions and speeds, in floats; poses are measured from the checked point.

In every region each speed is a fixed combination of a few terms of the pose, times the gain k: the table lists the
combinations, and :mod:`nonsmooth.reports.laws.law_languages` writes them as programs.  The law is the one that the
feedback clause certifies, or under rule ``nearest`` another by name, which the table then says is not certified.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from nonsmooth.analysis.cells.partition import Cell
from nonsmooth.analysis.fields.feedback_laws import CellLaw, Coefficients, LawKind, floats
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.motion.saturation import demand
from nonsmooth.proofs.answers.pose import late_and_wrong
from nonsmooth.proofs.clauses.feedback.by_friction import DrivenFeedback
from nonsmooth.proofs.clauses.feedback.by_rows import FeedbackResult
from nonsmooth.proofs.clauses.feedback.clause import AnyFeedback
from nonsmooth.proofs.clauses.feedback.driven_law import LawCone, in_scene, rim_speeds
from nonsmooth.proofs.clauses.feedback.gradient_law import LevelRegion
from nonsmooth.proofs.clauses.feedback.loop_bounds import FEW_ROUNDINGS, certified_error, ultimate_bound, wheel_speed
from nonsmooth.proofs.findings import Feedback
from nonsmooth.proofs.theorem4 import CellCheck, Check
from nonsmooth.reports.laws.feedback_loop import build_loop
from nonsmooth.reports.output.study_options import LawName
from nonsmooth.symbolic.mechanics.scene import LoopErrors, Scene
from nonsmooth.symbolic.mechanics.similar_scenes import in_own_length
from nonsmooth.symbolic.numbers.number_text import brief_text, float_text, lower_text, upper_text

NEARBY = "from starts near the checked point; how near is not known"
SEAM = 1e-9  # of the half-width of the square: regions meet within rounding
BEYOND = 1e100  # all sizes of poses and gains, so that no product overflows
DIGITS = 6  # of speeds in words


class NoLawError(ValueError):
    """A check that certifies no law; ``str(error)`` is one line."""


@dataclass(frozen=True)
class LawRegion:
    """A part of the plane of c in which the speeds are the same combinations.

    Attributes:
        name: of the cell, or of the directions of c.
        where: its corners, or what else it is, in words.
        sides: ``(a, b, c)`` with ``a + b x + c y >= 0`` inside.
        speeds: for each wheel that is driven the coefficients of the terms; of a driven law one for each twist.
        axes: the direction of the nearest wheel (slow turns), or the twists xi_l (driven).
        corners: of a cell (m, 2); empty for directions of c.
    """

    name: str
    where: str
    sides: tuple[Coefficients, ...]
    speeds: Mapping[int, Coefficients]
    axes: tuple[Coefficients, ...] = ()
    corners: tuple[Coefficients, ...] = ()

    def depth(self, x: float, y: float) -> float:
        """Distance of a displacement from the nearest side, negative outside of it; 0 where there are no sides."""
        return min(((a + b * x + c * y) / math.hypot(b, c) for a, b, c in self.sides), default=0.0)


@dataclass(frozen=True)
class LawTable:
    """A law of one check.

    Attributes:
        scene: the array, measured from the checked point.
        kind: what the speeds are combinations of.
        regions: they cover what was built of the checked square, or all directions of c.
        constants: e, f, w or l.
        formula: the law in plain text.
        status: that the feedback clause certifies it, or that it does not.
        is_certified: whether it does.
        certified: from which starts it is certified, in words.
        rate: how fast the error falls, in words; empty where no rate is certified.
        effort: how fast wheels run at most, and in which region, in words.
        gains: with which k it is certified, in words; empty where it is not certified.
    """

    scene: Scene
    kind: LawKind
    regions: tuple[LawRegion, ...]
    constants: Mapping[str, float]
    formula: str = ""
    status: str = "certified by the feedback clause"
    is_certified: bool = True
    certified: str = NEARBY
    rate: str = ""
    effort: str = ""
    gains: str = ""

    def speeds(self, x: float, y: float, theta: float, k: float = 1.0) -> dict[int, float]:
        """The speed of every rim that is driven, by the number of its wheel, within the limits of speed.

        Args:
            x: displacement of the centre of mass from the checked point (length).
            y: the same.
            theta: turn of the body (radian).
            k: gain (1/time).

        Raises:
            ValueError: for a place that is in no region, and for what is no number or infinite.
        """
        if not all(abs(value) < BEYOND for value in (x, y, theta, k)):
            raise ValueError(f"required a pose and a gain of sizes below {BEYOND:g}, received {(x, y, theta, k)}")
        region = self.region_at(x, y)
        terms = self.kind.terms(self.constants, region.axes, x, y, theta)
        wanted = {wheel: k * float(np.dot(row, terms)) for wheel, row in region.speeds.items()}
        size = max(1.0, demand(wanted, {wheel: float(limit) for wheel, limit in self.scene.speed_limits.items()}))
        return {wheel: speed / size for wheel, speed in wanted.items()}

    def region_at(self, x: float, y: float) -> LawRegion:
        """The region that holds the displacement; between two of them, by rounding, the one it is deepest in.

        Raises:
            ValueError: where none holds it.
        """
        depths = [region.depth(x, y) for region in self.regions]
        best = int(np.argmax(depths))
        if depths[best] < -SEAM * self.scene.check.half_width:
            raise ValueError(f"required a place in a region of the law, received ({x}, {y})")
        return self.regions[best]

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
    LawKind.PAPER: ("r", "h", "theta"),
    LawKind.SLOW_TURNS: ("A", "W"),
}


def law_table(check: Check, name: LawName = LawName.CERTIFIED) -> LawTable:
    """The law that the feedback clause of a check certifies, or another by name.

    Args:
        check: the check.
        name: of a law of rule ``nearest``, certified or not.

    Raises:
        NoLawError: where the clause certifies none, or the array has none of this name.
    """
    feedback, scene = check.feedback.holding, check.scene.recentred()
    named = name is not LawName.CERTIFIED
    if not named and feedback.verdict is not Feedback.STABILIZABLE:
        raise NoLawError(f"required a certified feedback law; the feedback clause says {feedback.verdict}")
    if isinstance(feedback, DrivenFeedback):
        if named:
            raise NoLawError(f"required rule nearest for the {name} law, received {scene.contact.rule}")
        return _driven(scene, feedback)
    if not (isinstance(feedback, FeedbackResult) and isinstance(check, CellCheck)):
        raise NoLawError(f"required a law of cells or of imposed twists, received rule {scene.contact.rule}")
    try:
        loop = build_loop(check.partition, name, Kinematics.EXACT, feedback)
        table = _by_cells(scene, loop.wanted, check.partition.cells)
    except ValueError as error:
        raise NoLawError(str(error)) from None
    table = replace(table, formula=loop.formula, status=f"{loop.name} law, {loop.status}")
    if not loop.is_certified:
        return replace(table, is_certified=False, certified="", effort=_effort_by_terms(table))
    gains = _gains_text(feedback, scene)
    table = replace(table, certified=_region_text(feedback), rate=_rate_text(feedback, scene), gains=gains)
    by_v = table.kind is LawKind.GRADIENT
    return replace(table, effort=_effort_by_v(table, feedback, scene) if by_v else _effort_by_terms(table))


def _driven(scene: Scene, feedback: DrivenFeedback) -> LawTable:
    """The law of three imposed twists of rules ``box``, ``ellipse`` and ``roller``."""
    scaled = in_own_length(scene)
    cones = tuple(_cone(scaled, cone, feedback) for cone in feedback.cones)
    table = LawTable(scene, LawKind.DRIVEN, cones, {"w": float(feedback.length) ** 2}, feedback.law or "")
    table = replace(table, certified=_reach_text(feedback), rate=_rate_text(feedback, scene))
    return replace(table, effort=_effort_by_v(table, feedback, scene), gains=_gains_text(feedback, scene))


def _by_cells(scene: Scene, law: CellLaw, cells: Sequence[Cell]) -> LawTable:
    """A law of rule ``nearest``.

    Raises:
        ValueError: for a law that the wheels of a cell do not allow.
    """
    regions = tuple(_region(cell, law.rows(cell.states[0]), law.axes(cell.states[0])) for cell in cells)
    return LawTable(scene, law.kind, regions, law.constants)


# ---- what is said of it --------------------------------------------------------------------------


def _rate_text(feedback: AnyFeedback, scene: Scene) -> str:
    """``V' <= -2 kappa k V`` near the point, or in the cells there; slower where speeds are limited."""
    kappa = feedback.certified_kappa
    if kappa is None:
        return ""
    limited = ", while no wheel is at its limit" if scene.speed_limits else ""
    falls = f"near the point the error sqrt(V) shrinks at least like exp(-{lower_text(kappa, 4)} k t)"
    return f"{falls}{limited}, V = {feedback.lyapunov}"


def _gains_text(feedback: AnyFeedback, scene: Scene) -> str:
    """Of an exact pose every gain serves, since k is a scale of time; of a late one those below a bound, or none."""
    exact = "every k > 0 serves as long as the pose is exact and not late"
    if scene.loop_errors is not None:
        return f"{exact}; {late_and_wrong(feedback, scene.loop_errors, scene).words}"
    nothing = LoopErrors(scene.field.zero, scene.field.zero, Fraction(0))
    bound = None if isinstance(feedback, FeedbackResult) else ultimate_bound(feedback, nothing)
    if bound is None or bound.largest_delay is None:
        return f"{exact}; of a late one no k is known that does"
    age = f"tau{scene.units.after_time} old"
    return f"{exact}; of one that is {age}, each below {lower_text(bound.largest_delay, 2)}/tau is certified"


def _effort_by_v(table: LawTable, feedback: AnyFeedback, scene: Scene) -> str:
    """The largest speed by the error sqrt(V): over all poses, and in the certified region."""
    bound = wheel_speed(feedback, scene)
    if bound is None:  # no law that V certifies
        return ""
    where = table.regions[bound.place].name if table.kind is LawKind.DRIVEN else f"cell {bound.place}"
    text = f"{upper_text(bound.by_root, DIGITS)} k sqrt(V)"
    if bound.by_level:
        text += f" + {upper_text(bound.by_level, DIGITS)} k V"
    text += f", V = {feedback.lyapunov} (the largest of all regions: {where})"
    error = certified_error(feedback)
    if error is None:
        return text
    fastest = upper_text(bound.at_error(error) * (1 + FEW_ROUNDINGS), DIGITS)
    return f"{text}, which is {fastest} k{scene.units.after_speed} on the border of the certified region"


def _effort_by_terms(table: LawTable) -> str:
    """The largest speed by the sizes of the terms, wheel by wheel and region by region."""
    if table.kind is LawKind.GRADIENT:
        named = [(row, region) for region in table.regions for row in region.speeds.values()]
        row, region = max(named, key=lambda pair: math.hypot(*pair[0]))
        x, y, t = (_upper(abs(value)) for value in row)
        return f"{x} k |X| + {y} k |Y| + {t} k |T| in {region.name}, where a control field is the longest"
    by_place = [(_by_place(table, row), region) for region in table.regions for row in region.speeds.values()]
    by_turn = [(_by_turn(table, row), region) for region in table.regions for row in region.speeds.values()]
    place, first = max(by_place, key=lambda pair: pair[0])
    turn, second = max(by_turn, key=lambda pair: pair[0])
    names = ("|A|", "|W|") if table.kind is LawKind.SLOW_TURNS else ("r", "|theta|")
    where = first.name if first is second else f"{first.name} by place, {second.name} by heading"
    return f"{_upper(place)} k {names[0]} + {_upper(turn)} k {names[1]} (the largest of all regions: {where})"


def _by_place(table: LawTable, row: Coefficients) -> float:
    """The speed of a wheel over r, or over ``|A|``, at most."""
    return abs(row[0]) + math.hypot(*row[1:3]) if table.kind is LawKind.CASCADE else abs(row[0])


def _by_turn(table: LawTable, row: Coefficients) -> float:
    """The speed of a wheel over ``|theta|``, or over ``|W|``, at most."""
    return abs(row[1]) + abs(row[2]) if table.kind is LawKind.PAPER else abs(row[-1])


def _upper(value: float) -> str:
    return upper_text(Fraction(value) * (1 + FEW_ROUNDINGS), DIGITS) if value else "0"


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
    terms = [f"{value!r} {name}" for value, name in zip(coefficients, names, strict=True) if value]
    return " + ".join(terms).replace("+ -", "- ") or "0"


def _region(cell: Cell, speeds: Mapping[int, Coefficients], axes: tuple[Coefficients, ...]) -> LawRegion:
    corners = [f"({', '.join(map(brief_text, vertex))})" for vertex in cell.polygon.vertices]
    sides = tuple(floats((s.offset, -s.normal[0], -s.normal[1])) for s in cell.polygon.sides)
    vertices = tuple(map(floats, cell.polygon.vertices))
    return LawRegion(f"cell {cell.index}", f"corners {', '.join(corners)}", sides, speeds, axes, vertices)


def _cone(scene: Scene, cone: LawCone, feedback: DrivenFeedback) -> LawRegion:
    """The twists of a cone in the scene's unit, and the speeds that impose each."""
    columns = [rim_speeds(scene, imposed) for imposed in cone.twists]
    speeds = {wheel.index: tuple(column[k] for column in columns) for k, wheel in enumerate(scene.wheels)}
    twists = tuple(floats(in_scene(imposed.twist, feedback.length)) for imposed in cone.twists)
    if cone.rays is None:
        return LawRegion("all directions", "everywhere", (), speeds, twists)
    (ax, ay), (bx, by) = (floats(ray) for ray in cone.rays)
    start, end = (float_text(float(np.degrees(np.arctan2(y, x))) % 360, 4) for x, y in ((ax, ay), (bx, by)))
    sides = ((0.0, -ay, ax), (0.0, by, -bx))
    return LawRegion(f"directions {start} to {end} degrees", "of c, counterclockwise", sides, speeds, twists)
