"""The options of ``nonsmooth simulate``, and of the methods of Python that follow paths, map starts and find orbits."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.reports.output.refusals import LARGEST, LEAST, OptionError
from nonsmooth.reports.output.study_options import LawName, Options, PathMethod, option
from nonsmooth.symbolic.mechanics.units import AngleUnit
from nonsmooth.symbolic.numbers.plane import Pose

if TYPE_CHECKING:
    from nonsmooth.symbolic.mechanics.scene import Scene

# Headings of the help: what an option belongs to.
PATH = "One path"
LOOP = "Closed loop of an array"
MAP = "Map of many starts"
FAILED = "Failed wheels of an array"
TABLES = "Tables within the tolerances of an array"
ORBIT = "Periodic orbit of a plain system"
BODY = "A body with mass (--method dynamics)"

UNTIL = 2.0  # last time of a single path, where none is given
POSE = ("x", "y", "theta")


@dataclass(frozen=True, kw_only=True)
class SimulateOptions(Options):
    """What to simulate."""

    start: str | Sequence[float] | None = option(
        None,
        "Start in world coordinates, such as 0.2,sqrt(2)/4,pi/6 or 180,120,5deg: one number per state. A heading "
        "without a unit is in that of the scene's angles.",
        str | None,
        flag="--from",
        heading=PATH,
        metavar="X,Y,THETA",
    )
    grid: int | None = option(
        None, "Map where N x N starts in the square end, instead of one path.", heading=MAP, metavar="N"
    )
    until: float | None = option(None, "Last time; 2 unless given, with --grid until all have ended.", str, metavar="T")
    heading: float = option(
        0.0,
        "Heading of all starts with --grid, such as 30deg or pi/6; without a unit in that of the scene's angles.",
        str,
        heading=MAP,
        metavar="THETA",
    )
    headings: int | None = option(
        None,
        "Which headings return, and from how far: a body with an outline from N headings of a full turn, at the place "
        "of --from or the checked point.",
        heading=MAP,
        metavar="N",
    )
    kinematics: Kinematics = option(Kinematics.EXACT, "Exact pose, or leading order as in the paper.")
    method: PathMethod = option(
        PathMethod.EVENTS, "Events, the paper's hysteresis, smoothing, or full dynamics.", heading=PATH
    )
    width: float = option(
        1e-3, "Width of --method hysteresis or smoothed, in units of the state.", str, heading=PATH, metavar="W"
    )
    feedback: bool = option(False, "Close the loop by the law that check certifies.", heading=LOOP)
    law: LawName = option(
        LawName.CERTIFIED,
        "Another feedback law, with --feedback, certified or not: printed is the paper's, cascade takes theta first "
        "(tangential rims: its length l is the checked radius).",
        heading=LOOP,
    )
    gain: float = option(1.0, "Gain of the law, with --feedback (1/time).", str, heading=LOOP, metavar="K")
    mass: float | None = option(
        None,
        "With --method dynamics: mass per weight, 1/g; unless given that of standard gravity in the scene's [units], "
        "and 0.1 without units.",
        str,
        heading=BODY,
        metavar="M",
    )
    inertia: float | None = option(
        None,
        "With --method dynamics: inertia per weight; unless given that of a plate of the body's outline, or of a disc "
        "as large as the array.",
        str,
        heading=BODY,
        metavar="I",
    )
    compare_masses: bool = option(
        False,
        "With --method dynamics: its distance from each rule's path, for M, M/10, ..., M/10000.",
        heading=BODY,
    )
    fail: str | None = option(
        None,
        "Also with these wheels failed together, such as 5,7, or every wheel alone (any): stopped, and lifted. How far "
        "the end moves, and what no longer comes home, --from one start or those of --grid.",
        heading=FAILED,
        metavar="N,...|any",
    )
    tables: int | None = option(
        None,
        "How far from the point bodies end on N tables drawn within [tolerance], by all tolerances at once and by each "
        "alone: sampled.",
        heading=TABLES,
        metavar="N",
    )
    seed: int = option(0, "Seed of --tables: equal seeds draw equal tables.", heading=TABLES, metavar="S")
    certified: bool = option(False, "With --tables, beside the sample what is proved for every table.", heading=TABLES)
    orbit: bool = option(
        False,
        "The periodic orbit near --from, or that its path approaches until --until (100 unless given), or comes from: "
        "period, Floquet multipliers, stability, and whether that is proved.",
        heading=ORBIT,
    )

    def __post_init__(self) -> None:
        """In Python ``feedback`` may name a law; a typed heading waits for the scene's unit (:meth:`read_for`).

        Raises:
            OptionError: for texts that are no numbers, and a heading that is no angle.
        """
        for name in ("until", "width", "gain", "mass", "inertia"):
            typed = getattr(self, name)
            if isinstance(typed, str):
                object.__setattr__(self, name, _value(f"--{name}", typed, is_angle=False))
        if isinstance(self.feedback, str):
            object.__setattr__(self, "law", self.feedback)
            object.__setattr__(self, "feedback", True)
        if isinstance(self.heading, str) and not _value("--heading", self.heading, is_angle=True):
            object.__setattr__(self, "heading", 0.0)  # the default, which needs no unit
        super().__post_init__()

    @property
    def closed_by(self) -> LawName | None:
        """The feedback law; None for the scene's own speeds."""
        return self.law if self.feedback else None

    @property
    def is_plain(self) -> bool:
        """Whether it is the open loop by events with exact kinematics, which every rule offers."""
        return (self.method, self.kinematics, self.closed_by) == (PathMethod.EVENTS, Kinematics.EXACT, None)

    @property
    def last(self) -> float:
        """The last time of a single path."""
        return self.until or UNTIL

    def read_for(self, scene: Scene) -> SimulateOptions:
        """The options with numbers for what was typed: an angle without a unit is in that of the scene's angles.

        Numbers of Python are radians.

        Raises:
            OptionError: for no numbers, and an angle that names no unit where the scene states none either.
        """
        unit = unit_of_typed_angles(scene)
        start = self.place(POSE, angle="theta", unit=unit) if isinstance(self.start, str) else self.start
        typed = self.heading
        heading = _value("--heading", typed, is_angle=True, unit=unit) if isinstance(typed, str) else typed
        return replace(self, start=start, heading=heading)

    @property
    def pose(self) -> Pose:
        """The start of a body over an array; its heading may hold pi.

        Raises:
            OptionError: for anything else.
        """
        x, y, theta = self.place(POSE, angle="theta")
        return x, y, theta

    def place(
        self, states: Sequence[str], angle: str = "", unit: AngleUnit | None = AngleUnit.RADIAN
    ) -> tuple[float, ...]:
        """The start: a finite number for each state; typed ones may be formulas, that of the state ``angle`` with pi.

        Args:
            states: their names.
            angle: the state that is an angle.
            unit: of an angle that names none.

        Raises:
            OptionError: for anything else.
        """
        required = f"--from: required {len(states)} numbers {','.join(states)}"
        if self.start is None:
            raise OptionError(f"{required}, received nothing")
        given: Any = self.start.split(",") if isinstance(self.start, str) else self.start
        parts = tuple(given) if isinstance(given, Iterable) else (given,)
        if len(parts) != len(states):
            received = repr(self.start[:60]) if isinstance(self.start, str) else len(parts)
            raise OptionError(f"{required}, received {received}")
        return tuple(
            _value(f"--from: {name}", part, is_angle=name == angle, unit=unit) if isinstance(part, str) else float(part)
            for name, part in zip(states, parts, strict=True)
        )

    def require_numbers(self) -> None:
        """Refuse numbers that no simulation takes.

        Raises:
            OptionError: naming the option.
        """
        for flag, value in (("--until", self.until), ("--width", self.width), ("--gain", self.gain)):
            if value is not None and not (math.isfinite(value) and value > 0):
                raise OptionError(f"{flag}: required a positive number, received {value}")
        if not LEAST <= self.gain <= LARGEST:
            raise OptionError(f"--gain: required a number of {LEAST:g} to {LARGEST:g}, received {self.gain}")


def unit_of_typed_angles(scene: Scene) -> AngleUnit | None:
    """The unit of typed angles that name none; None where the scene's own were taken for degrees untold."""
    from nonsmooth.symbolic.files.scene_values import AngleReading

    if scene.units.in_degrees:
        return AngleUnit.DEGREE
    return None if AngleReading.WITHOUT_UNIT.value in scene.field.remarks else AngleUnit.RADIAN


def _value(where: str, text: str, *, is_angle: bool, unit: AngleUnit | None = AngleUnit.RADIAN) -> float:
    """A number as typed, or an angle (radian), with or without its unit.

    Raises:
        OptionError: for anything else.
    """
    from nonsmooth.symbolic.files.scene_values import read_start_angle, read_start_value
    from nonsmooth.symbolic.messages.scene_error import requirement, shown

    try:
        value = read_start_angle(text, unit) if is_angle else read_start_value(text)
    except OverflowError:
        value = math.inf
    except ValueError as error:
        raise OptionError(f"{where}: required {requirement(error)}, received {shown(text)}") from None
    if not math.isfinite(value):
        raise OptionError(f"{where}: required a number within the range of floats, received {shown(text)}")
    return value
