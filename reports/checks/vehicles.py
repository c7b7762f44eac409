"""What every contact rule says of one vehicle, in every form of ``nonsmooth vehicle SCENE``."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from nonsmooth.analysis.bodies.vehicles import (
    CurvedMotion,
    VehicleMotion,
    friction_ratio,
    turns,
    vehicle_motion,
    vehicle_motions,
)
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.proofs.findings import Record
from nonsmooth.reports.figures.style import INK, LINES, legend_below, length_label, new_figure, view_square, wrapped
from nonsmooth.reports.figures.wheels import draw_wheel
from nonsmooth.reports.output.document import Block, Paragraph, sentences, table
from nonsmooth.reports.output.facts import exact_texts, floats
from nonsmooth.reports.output.refusals import RefusedError
from nonsmooth.reports.studies.result import FORMATS, DataTable, Formats, Result
from nonsmooth.symbolic.mechanics.vehicles import FORMULA, Vehicle
from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact, one_line
from nonsmooth.symbolic.numbers.number_text import float_text, percent_text, short_text
from nonsmooth.symbolic.numbers.plane import in_floats
from nonsmooth.symbolic.numbers.plane_arrays import Floats, float_points, max_norm, norms, places_of, spread, turned

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


SCHEMA = "nonsmooth-vehicle/1"
YAML = ".yaml"  # parameters of a controller
ROUNDING = 1e-13  # of the speeds, sizes or weight of a vehicle: a smaller number is rounding of a zero
UNSTATED = "speeds and rates in the scene's units"
DIGITS = 6  # significant, of a controller's parameter: more than any vehicle keeps


@dataclass(frozen=True, repr=False)
class VehicleResult(Result):
    """The motion of a vehicle under its own rule and under all others, and what follows from one measured spin.

    Attributes:
        vehicle: with its commanded speeds.
        spin: measured rate of turn at these speeds (radian/time); None where none is given.

    Raises:
        SceneError: for a spin of a vehicle without two sides that turn it.
    """

    vehicle: Vehicle
    spin: float | None = None

    formats: ClassVar[Formats] = {
        **FORMATS,
        YAML: lambda found, ending: found.controller_lines().encode(),
    }

    def __post_init__(self) -> None:
        if self.spin is not None and self.vehicle.turn is None:
            required = "a track and two sides that run at different speeds, for a measured spin"
            raise SceneError(self.vehicle.scene.origin, "vehicle", required, StatedFact("a vehicle without"))

    @property
    def twist(self) -> tuple[float, float, float] | None:
        """``(v_x, v_y, omega)`` under the vehicle's own rule; None where several are allowed."""
        twist = motion_record(self.own)["twist"]
        return None if twist is None else (twist[0], twist[1], twist[2])

    @property
    def multiplier(self) -> float | None:
        """The effective track over the track."""
        return self.own.multiplier

    def __repr__(self) -> str:
        return f"{self.summary()}: twist {self.twist}, multiplier {self.multiplier}"

    @cached_property
    def own(self) -> VehicleMotion:
        """What the vehicle's own rule says."""
        return vehicle_motion(self.vehicle)

    @cached_property
    def turns(self) -> tuple[CurvedMotion, ...]:
        """From straight on to in place, sampled."""
        return turns(self.vehicle)

    @property
    def formula(self) -> str | None:
        """Of the multiplier, where it is known."""
        is_known = self.vehicle.has_four_equal_wheels and self.own.rule.name == "ellipse"
        return FORMULA if is_known else None

    @property
    def controller(self) -> dict[str, float] | None:
        """Parameters of ROS 2's ``diff_drive_controller``; None where the vehicle has no track, or does not turn.

        It divides the difference of the wheel speeds by ``wheel_separation * wheel_separation_multiplier``, so the
        multiplier is the effective track over the track.  Its lengths are in metres; so are those of a scene that
        states no unit.
        """
        vehicle, multiplier = self.vehicle, self.own.multiplier
        if vehicle.track is None or multiplier is None:
            return None
        metres = float(vehicle.scene.units.metres or 1)
        parameters = {"wheel_separation": float(vehicle.track) * metres, "wheel_separation_multiplier": multiplier}
        if vehicle.wheel_radius is not None:
            parameters["wheel_radius"] = float(vehicle.wheel_radius) * metres
        return {name: float(f"{value:.{DIGITS}g}") for name, value in parameters.items()}

    def controller_lines(self) -> str:
        """The parameters as YAML of a node named ``diff_drive_controller``.

        Raises:
            RefusedError: where there are none.
        """
        if self.controller is None:
            required = "required a vehicle with a track whose sides run at different speeds"
            raise RefusedError(f"{self.vehicle.scene.origin}: {required}, received one without a multiplier")
        lines = [f"    {name}: {value!r}" for name, value in self.controller.items()]
        return "\n".join(["diff_drive_controller:", "  ros__parameters:", *lines]) + "\n"

    # ---- JSON, rows and picture ------------------------------------------------------------------

    def facts(self) -> Record:
        """JSON with stable keys."""
        vehicle, motion = self.vehicle, motion_record(self.own)
        known = {
            "track": vehicle.track,
            "wheel_base": vehicle.wheel_base,
            "wheel_radius": vehicle.wheel_radius,
            "centre_of_mass": vehicle.centre_of_mass,
            "speeds": tuple(wheel.speed for wheel in vehicle.scene.wheels),
        }
        exact = {key: exact_texts(value) for key, value in known.items() if value is not None}
        return {
            "schema": SCHEMA,
            "vehicle": vehicle.name,
            "wheels": len(vehicle.scene.wheels),
            **{key: floats(value) for key, value in known.items()},
            **motion,
            "exact": {**exact, **motion["exact"]},
            "formula": self.formula,
            "rules": [
                {"refused": str(motion)} if isinstance(motion, RefusalError) else motion_record(motion)
                for motion in vehicle_motions(vehicle)
            ],
            "turns": [turn._asdict() for turn in self.turns],
            "measured": self._measured,
            "spin": self._spin,
            "diff_drive_controller": self.controller,
            "notes": list(vehicle.scene.field.remarks),
        }

    @cached_property
    def _measured(self) -> Record | None:
        """What was measured, how far the prediction is off, and the friction ratio that meets it; None without."""
        measured, predicted = self.vehicle.measured, self.own.multiplier
        if measured is None:
            return None
        ratio = self.vehicle.friction_ratio(measured)
        return {
            "multiplier": float(measured),
            "source": self.vehicle.source or None,
            "error": None if predicted is None else predicted / float(measured) - 1,
            "friction_ratio": friction_ratio(self.vehicle, float(measured)),
            "exact": {"multiplier": exact_texts(measured), "friction_ratio": exact_texts(ratio)},
        }

    @cached_property
    def _spin(self) -> Record | None:
        """The multiplier and the friction ratio of a measured spin; None without."""
        multiplier = self.vehicle.float_multiplier(self.spin) if self.spin else None
        if multiplier is None:
            return None
        ratio = friction_ratio(self.vehicle, multiplier)
        return {"rate": self.spin, "multiplier": multiplier, "friction_ratio": ratio}

    def table(self) -> DataTable:
        """One line for each commanded curvature."""
        motion = ("v_x", "v_y", "omega", "icr_x", "icr_y")
        lines = []
        for left, right, curvature, twist, icr, *rest in self.turns:
            lines.append((left, right, curvature, *twist, *(icr or (None, None)), *rest))
        return DataTable(("left", "right", "curvature", *motion, "left_centre", "right_centre", "multiplier"), lines)

    def draw(self, ax: Axes) -> None:
        """The wheels with slips and forces, the centre of mass and the instant centre."""
        motion, scene = self.own, self.vehicle.scene
        places = places_of(scene.wheels)
        middle = (places.min(axis=0) + places.max(axis=0)) / 2
        half = max(0.75 * spread(places), max_norm(places - middle) / (0.96 - 2 * REACH))  # arrows stay inside
        for wheel in scene.wheels:
            draw_wheel(ax, wheel, 2 * half * RIM, named=len(scene.wheels) <= 12)
        along = float_points(wheel.unit_grip for wheel in scene.wheels)
        frames = np.stack([along, turned(along)], axis=1)
        fastest = scene.fastest
        _draw_arrows(ax, places, frames, motion.slips, fastest, 2 * half * REACH, LINES[1], "slip over the ground")
        _draw_arrows(ax, places, frames, motion.forces, 1.0, 2 * half * REACH, LINES[0], "friction force")
        centre = in_floats(self.vehicle.centre_of_mass)
        ax.plot(*centre, marker="+", color=INK, markersize=11, linestyle="none", label="centre of mass")
        if motion.icr is not None and max_norm(motion.icr - middle) <= half:
            ax.plot(*motion.icr, "o", color=LINES[2], fillstyle="none", label="instant centre")
        view_square(ax, in_floats(middle), half)
        ax.set(xlabel=length_label("x (forward)", scene.units), ylabel=length_label("y (left)", scene.units))
        ax.set_title(wrapped(f"{one_line(scene.name)}, rule {motion.rule.name}"), parse_math=False, fontsize="medium")

    def figure(self) -> Figure:
        """The wheels with slips and forces; beside them the instant centres, where there are turns."""
        figure = new_figure(10 if self.turns else 5.5, 5.5)
        panels = figure.subplots(1, 2 if self.turns else 1, squeeze=False)[0]
        self.draw(panels[0])
        legend_below(figure, panels[0].get_legend_handles_labels()[0], 4, fontsize="small")
        if self.turns:
            _draw_turns(panels[1], self.turns)
            panels[1].set_ylabel(length_label("y of the instant centre", self.vehicle.scene.units))
        return figure

    # ---- text ------------------------------------------------------------------------------------

    def written(self, ending: str) -> str:
        """Parameters, or the vehicle."""
        return "parameters of diff_drive_controller" if ending == YAML else self.summary()

    def summary(self) -> str:
        """One line."""
        vehicle, unit = self.vehicle, str(self.vehicle.scene.units.length)
        sizes = [f"{len(vehicle.scene.wheels)} wheels", f"rule {self.own.rule.name}"]
        for name, value in (("track", vehicle.track), ("wheel base", vehicle.wheel_base)):
            if value is not None:
                sizes.append(f"{name} {short_text(value)} {unit}".rstrip())
        return f"{one_line(vehicle.name)}: {', '.join(sizes)}"

    def blocks(self) -> Sequence[Block]:
        """The motion under every rule, the slips and forces of the wheels, and what follows from measurements."""
        return [*sentences(self.summary()), self._rules(), self._wheels(), *sentences(*self._remarks())]

    def _rules(self) -> Block:
        """The motion under every rule that says one."""
        rows = []
        for motion in vehicle_motions(self.vehicle):
            if not isinstance(motion, RefusalError):
                rows.append((motion.rule.name, *_twist_cells(motion_record(motion)), _multiplier_cell(motion)))
        return table(("rule", "v_x", "v_y", "omega", "turns about", "multiplier"), rows)

    def _wheels(self) -> Block:
        """Slips and forces of every wheel under the vehicle's own rule."""
        motion, rows = motion_record(self.own), []
        if motion["slips"] is None:
            several = (
                f"rule {motion['rule']} allows {len(motion['twists'])} twists and their mixtures: no slips are named"
            )
            return Paragraph((several,))
        for k, wheel in enumerate(self.vehicle.scene.wheels):
            force = ["-", "-"] if motion["forces"] is None else map(_cell, motion["forces"][k])
            rows.append((str(wheel.index), short_text(wheel.speed), *map(_cell, motion["slips"][k]), *force))
        header = ("wheel", "speed", "slip along", "slip across", "force along", "force across")
        return table(header, rows)

    def _remarks(self) -> Iterator[str]:
        measured, spin = self._measured, self._spin
        if self.formula is not None:
            yield f"effective track multiplier of four equal wheels: {self.formula}"
        if measured is not None and measured["error"] is not None:
            source = f" ({measured['source']})" if measured["source"] else ""
            error, ratio = percent_text(measured["error"]), _ratio_text(measured["friction_ratio"])
            text = f"measured {float_text(measured['multiplier'])}{source}: the prediction is off by {error}"
            yield f"{text}; met by mu_S/mu_R = {ratio}"
        if spin is not None:
            multiplier, ratio = float_text(spin["multiplier"]), _ratio_text(spin["friction_ratio"])
            yield f"spin {float_text(spin['rate'])}: multiplier {multiplier}, mu_S/mu_R = {ratio}"
        if self.own.forces is not None:
            units = self.vehicle.scene.units
            known = f"lengths in {units.length}, speeds in {units.speed}, omega in rad/s"
            yield f"forces as shares of the weight; {known if units.length else UNSTATED}"
        if self.controller is not None:
            yield "diff_drive_controller: " + ", ".join(f"{key}: {value}" for key, value in self.controller.items())


def motion_record(motion: VehicleMotion) -> Record:
    """What one rule says; ``twist`` and what follows from it are null where several twists are allowed."""
    exact, speed, size = motion.exact, motion.speed, motion.size
    twists = [_clean(twist, speed, speed, speed / size) for twist in motion.twists]
    return {
        "rule": motion.rule.name,
        "unique": motion.is_unique,
        "twist": twists[0] if motion.is_unique else None,
        "twists": twists,
        "slips": None if motion.slips is None else [_clean(slip, speed, speed) for slip in motion.slips],
        "forces": None if motion.forces is None else [_clean(force, 1.0, 1.0) for force in motion.forces],
        "icr": None if motion.icr is None else _clean(motion.icr, size, size),
        "multiplier": motion.multiplier,
        "gap": motion.gap,
        "exact": {
            "twist": exact_texts(tuple(exact[0])) if exact and motion.is_unique else None,
            "twists": None if exact is None else [exact_texts(tuple(twist)) for twist in exact],
            "icr": exact_texts(motion.exact_icr),
            "multiplier": exact_texts(motion.exact_multiplier),
        },
    }


def _clean(values: Iterable[float], *scales: float) -> list[float]:
    """Floats in which rounding of zeros, beside numbers of the size of the scales, is zero."""
    return [
        0.0 if abs(value) <= ROUNDING * scale else float(value) for value, scale in zip(values, scales, strict=True)
    ]


def _cell(value: float) -> str:
    return float_text(value, 4)


def _ratio_text(ratio: float | None) -> str:
    return "none" if ratio is None else float_text(ratio)


def _range(low: str, high: str) -> str:
    """``0.5``, ``+/-0.5`` or ``0.2 to 0.5``."""
    if low == high:
        return low
    return f"+/-{high}" if low == f"-{high}" else f"{low} to {high}"


def _twist_cells(motion: Record) -> tuple[str, ...]:
    """``v_x, v_y, omega`` and the instant centre; of several twists and their mixtures the range of each."""
    twists = motion["twists"]
    if len(twists) > 1:
        ends = [(_cell(min(entries)), _cell(max(entries))) for entries in zip(*twists, strict=True)]
        return *(_range(low, high) for low, high in ends), "-"
    icr = "-" if motion["icr"] is None else "({}, {})".format(*map(_cell, motion["icr"]))
    return *map(_cell, twists[0]), icr


def _multiplier_cell(motion: VehicleMotion) -> str:
    exact = motion.exact_multiplier
    if exact is None:
        return "-" if motion.multiplier is None else float_text(motion.multiplier)
    text = short_text(exact)
    return text if text == float_text(exact) else f"{text} = {float_text(exact)}"


# ---- the picture ---------------------------------------------------------------------------------
#
# The picture of a vehicle: its wheels with slips and forces, and the instant centres over the commanded curvature.


RIM = 0.05  # half of a rim's length, of the width of the view
REACH = 0.22  # length of the largest arrow, of the width of the view
TOO_SMALL = 1e-9  # slips beside the largest speed, and forces beside the weight, that are no more than rounding


def _draw_arrows(
    axes: Axes, places: Floats, frames: Floats, parts: Floats | None, scale: float, reach: float, color: str, label: str
) -> None:
    """Vectors (n, 2) given along and across the friction axes, the longest as long as ``reach``.

    None are drawn where all are rounding beside the scale.
    """
    if parts is None or max_norm(parts) <= TOO_SMALL * scale:
        return
    vectors = (parts[:, :, None] * frames).sum(axis=1)
    vectors *= reach / norms(vectors).max()
    axes.quiver(
        *places.T, *vectors.T, angles="xy", scale_units="xy", scale=1, color=color, width=0.006, label=label, zorder=4
    )


def _draw_turns(axes: Axes, turns: Sequence[CurvedMotion]) -> None:
    """Instant centres over the share of turning: 0 straight on, 1 in place."""
    share = [2 / np.pi * np.arctan2(turn.right - turn.left, turn.right + turn.left) for turn in turns]
    reach = 4 * max(abs(turn.left_centre or 0) for turn in turns)
    centres_of_rotation = [
        turn.icr[1] if turn.icr is not None and abs(turn.icr[1]) <= reach else None for turn in turns
    ]
    treads = {"left tread": [turn.left_centre for turn in turns], "right tread": [turn.right_centre for turn in turns]}
    for color, (label, centres) in zip(LINES, (treads | {"vehicle": centres_of_rotation}).items(), strict=False):
        points = [(x, y) for x, y in zip(share, centres, strict=True) if y is not None]
        if points:
            axes.plot(*zip(*points, strict=True), marker=".", color=color, label=label)
    axes.set(xlabel="commanded turn: 0 straight on, 1 in place", xlim=(0, 1.02))
    axes.set_title("instant centres of rotation, sampled", fontsize="medium")
    axes.grid(color="0.9", linewidth=0.6)
    if axes.lines:
        axes.legend(frameon=False, fontsize="small")
