"""What every contact rule says of one vehicle, in every form of ``nonsmooth vehicle SCENE``."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property

from rich.console import Group, RenderableType
from rich.text import Text

from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.vehicles.curvature import CurvedMotion, friction_ratio, turns
from nonsmooth.analysis.vehicles.motion import VehicleMotion, vehicle_motion, vehicle_motions
from nonsmooth.reports.exact_record import Record, exact_texts, floats
from nonsmooth.reports.terminal import header_table
from nonsmooth.reports.vehicles.controller import controller_parameters
from nonsmooth.symbolic.number_text import float_text, percent_text, short_text
from nonsmooth.symbolic.scene_error import SceneError, StatedFact, one_line
from nonsmooth.symbolic.vehicles.multiplier import FORMULA, exact_friction_ratio, has_four_equal_wheels
from nonsmooth.symbolic.vehicles.vehicle import Vehicle

SCHEMA = "nonsmooth-vehicle/1"
ROUNDING = 1e-13  # of the speeds, sizes or weight of a vehicle: a smaller number is rounding of a zero


@dataclass(frozen=True)
class VehicleReport:
    """The motion of a vehicle under its own rule and under all others, and what follows from one measured spin.

    Attributes:
        vehicle: with its commanded speeds.
        spin: measured rate of turn at these speeds (radian/time); None where none is given.

    Raises:
        SceneError: for a spin of a vehicle without two sides that turn it.
    """

    vehicle: Vehicle
    spin: float | None = None

    def __post_init__(self) -> None:
        if self.spin is not None and not self.vehicle.turns_by_sides:
            required = "a track and two sides that run at different speeds, for a measured spin"
            raise SceneError(self.vehicle.scene.origin, "vehicle", required, StatedFact("a vehicle without"))

    @cached_property
    def own(self) -> VehicleMotion:
        """What the vehicle's own rule says."""
        return vehicle_motion(self.vehicle)

    @cached_property
    def motions(self) -> tuple[VehicleMotion | RefusalError, ...]:
        """What every rule says."""
        return vehicle_motions(self.vehicle)

    @cached_property
    def turns(self) -> tuple[CurvedMotion, ...]:
        """From straight on to in place, sampled."""
        return turns(self.vehicle)

    @property
    def error(self) -> float | None:
        """Predicted over measured multiplier, less one."""
        measured, predicted = self.vehicle.measured, self.own.multiplier
        return None if measured is None or predicted is None else predicted / float(measured.multiplier) - 1

    @property
    def spin_multiplier(self) -> float | None:
        """The multiplier of the measured spin."""
        vehicle = self.vehicle
        if not self.spin or vehicle.left is None or vehicle.right is None or vehicle.track is None:
            return None
        return float(vehicle.right - vehicle.left) / (self.spin * float(vehicle.track))

    # ---- forms -----------------------------------------------------------------------------------

    def record(self) -> Record:
        """JSON with stable keys."""
        vehicle, own = self.vehicle, self.own
        known = {
            "track": vehicle.track,
            "wheel_base": vehicle.wheel_base,
            "wheel_radius": vehicle.wheel_radius,
            "centre_of_mass": vehicle.centre_of_mass,
            "speeds": tuple(wheel.speed for wheel in vehicle.scene.wheels),
        }
        motion = motion_record(own)
        exact = {key: exact_texts(value) for key, value in known.items() if value is not None}
        head = {"schema": SCHEMA, "vehicle": vehicle.name, "wheels": len(vehicle.scene.wheels)}
        return {
            **head,
            **{key: floats(value) for key, value in known.items()},
            **motion,
            "exact": {**exact, **motion["exact"]},
            "formula": FORMULA if has_four_equal_wheels(vehicle) and own.rule.name == "ellipse" else None,
            "rules": [_refusable(motion) for motion in self.motions],
            "turns": [turn_record(turn) for turn in self.turns],
            "measured": self.measured_record(),
            "spin": self._spin_record(),
            "diff_drive_controller": controller_parameters(vehicle, own.multiplier),
            "notes": list(vehicle.scene.field.remarks),
        }

    def lines(self) -> Iterator[tuple[object, ...]]:
        """One line for each commanded curvature."""
        motion = ("v_x", "v_y", "omega", "icr_x", "icr_y")
        yield "left", "right", "curvature", *motion, "left_centre", "right_centre", "multiplier"
        for turn in self.turns:
            icr = turn.icr or (None, None)
            centres = turn.left_centre, turn.right_centre
            yield turn.left, turn.right, turn.curvature, *turn.twist, *icr, *centres, turn.multiplier

    def picture(self, suffix: str) -> bytes:
        """The wheels with slips and forces, and the instant centres over curvature."""
        from nonsmooth.reports.figures.vehicle import vehicle_figure

        return vehicle_figure(self.own, self.turns, suffix)

    def summary(self) -> str:
        """One line."""
        return self._head()

    def view(self) -> RenderableType:
        """What a terminal shows."""
        parts: list[RenderableType] = [Text(self._head()), self._rules_table(), self._wheels_table()]
        parts += [Text(line) for line in self._remarks()]
        return Group(*parts)

    # ---- parts -----------------------------------------------------------------------------------

    def _head(self) -> str:
        vehicle, unit = self.vehicle, str(self.vehicle.scene.units.length)
        sizes = [f"{len(vehicle.scene.wheels)} wheels", f"rule {self.own.rule.name}"]
        for name, value in (("track", vehicle.track), ("wheel base", vehicle.wheel_base)):
            if value is not None:
                sizes.append(f"{name} {short_text(value)} {unit}".rstrip())
        return f"{one_line(vehicle.name)}: {', '.join(sizes)}"

    def _rules_table(self) -> RenderableType:
        table = header_table("rule", "v_x", "v_y", "omega", "instant centre", "multiplier")
        for motion in self.motions:
            if isinstance(motion, RefusalError):
                continue
            table.add_row(motion.rule.name, *_twist_cells(motion), _multiplier_text(motion))
        return table

    def _wheels_table(self) -> RenderableType:
        table = header_table("wheel", "speed", "slip along", "slip across", "force along", "force across")
        own = self.own
        if own.slips is None:
            return Text(f"rule {own.rule.name} allows {len(own.twists)} twists and their mixtures: no slips are named")
        for k, wheel in enumerate(own.vehicle.scene.wheels):
            force = ["-", "-"] if own.forces is None else [_shown(part) for part in clean(own.forces[k], 1.0)]
            slip = [_shown(part) for part in clean(own.slips[k], own.speed)]
            table.add_row(str(wheel.index), short_text(wheel.speed), *slip, *force)
        return table

    def _remarks(self) -> Iterator[str]:
        if has_four_equal_wheels(self.vehicle) and self.own.rule.name == "ellipse":
            yield f"effective track multiplier of four equal wheels: {FORMULA}"
        measured = self.vehicle.measured
        if measured is not None and self.error is not None:
            source = f" ({measured.source})" if measured.source else ""
            text = f"measured {float_text(measured.multiplier)}{source}: the prediction is off by "
            yield f"{text}{percent_text(self.error)}; met by mu_S/mu_R = {self._ratio_text(float(measured.multiplier))}"
        if self.spin_multiplier is not None:
            multiplier, ratio = float_text(self.spin_multiplier), self._ratio_text(self.spin_multiplier)
            yield f"spin {float_text(self.spin or 0)}: multiplier {multiplier}, mu_S/mu_R = {ratio}"
        if self.own.forces is not None:
            yield "forces as shares of the weight; speeds and rates in the scene's units"
        parameters = controller_parameters(self.vehicle, self.own.multiplier)
        if parameters is not None:
            yield "diff_drive_controller: " + ", ".join(f"{key}: {value}" for key, value in parameters.items())

    def _ratio_text(self, multiplier: float) -> str:
        ratio = friction_ratio(self.vehicle, multiplier)
        return "none" if ratio is None else float_text(ratio)

    def measured_record(self) -> Record | None:
        """What was measured, how far the prediction is off, and the friction ratio that meets it; None without."""
        measured = self.vehicle.measured
        if measured is None:
            return None
        exact = exact_friction_ratio(self.vehicle, measured.multiplier)
        return {
            "multiplier": float(measured.multiplier),
            "source": measured.source or None,
            "error": self.error,
            "friction_ratio": friction_ratio(self.vehicle, float(measured.multiplier)),
            "exact": {"multiplier": exact_texts(measured.multiplier), "friction_ratio": exact_texts(exact)},
        }

    def _spin_record(self) -> Record | None:
        if self.spin_multiplier is None:
            return None
        ratio = friction_ratio(self.vehicle, self.spin_multiplier)
        return {"rate": self.spin, "multiplier": self.spin_multiplier, "friction_ratio": ratio}


def motion_record(motion: VehicleMotion) -> Record:
    """What one rule says; ``twist`` and what follows from it are null where several twists are allowed."""
    exact = motion.exact
    twists = [clean_twist(motion, twist) for twist in motion.twists]
    return {
        "rule": motion.rule.name,
        "unique": motion.is_unique,
        "twist": twists[0] if motion.is_unique else None,
        "twists": twists,
        "slips": None if motion.slips is None else [clean(slip, motion.speed) for slip in motion.slips],
        "forces": None if motion.forces is None else [clean(force, 1.0) for force in motion.forces],
        "icr": None if motion.icr is None else clean(motion.icr, motion.size),
        "multiplier": motion.multiplier,
        "gap": motion.gap,
        "exact": {
            "twist": exact_texts(tuple(exact[0])) if exact and motion.is_unique else None,
            "twists": None if exact is None else [exact_texts(tuple(twist)) for twist in exact],
            "icr": exact_texts(motion.exact_icr),
            "multiplier": exact_texts(motion.exact_multiplier),
        },
    }


def clean(values: Iterable[float], scale: float) -> list[float]:
    """Floats in which rounding of zeros, beside numbers of the size ``scale``, is zero."""
    return [0.0 if abs(value) <= ROUNDING * scale else float(value) for value in values]


def clean_twist(motion: VehicleMotion, twist: Iterable[float]) -> list[float]:
    """A twist in which rounding of zeros is zero."""
    vx, vy, omega = twist
    return [*clean((vx, vy), motion.speed), *clean((omega,), motion.speed / motion.size)]


def _refusable(motion: VehicleMotion | RefusalError) -> Record:
    return {"refused": str(motion)} if isinstance(motion, RefusalError) else motion_record(motion)


def turn_record(turn: CurvedMotion) -> Record:
    """The motion for one commanded curvature."""
    return {
        "left": turn.left,
        "right": turn.right,
        "curvature": turn.curvature,
        "twist": list(turn.twist),
        "icr": None if turn.icr is None else list(turn.icr),
        "left_centre": turn.left_centre,
        "right_centre": turn.right_centre,
        "multiplier": turn.multiplier,
    }


def _shown(value: float) -> str:
    return float_text(value, 4)


def _twist_cells(motion: VehicleMotion) -> tuple[str, str, str, str]:
    twists = [clean_twist(motion, twist) for twist in motion.twists]
    if len(twists) > 1:
        low, high = (_shown(of(twist[2] for twist in twists)) for of in (min, max))
        return f"{len(twists)} and", "mixtures", low if low == high else f"{low} to {high}", "-"
    icr = "-" if motion.icr is None else "({}, {})".format(*map(_shown, clean(motion.icr, motion.size)))
    vx, vy, omega = map(_shown, twists[0])
    return vx, vy, omega, icr


def _multiplier_text(motion: VehicleMotion) -> str:
    exact = motion.exact_multiplier
    if exact is not None:
        text = short_text(exact)
        return text if text == float_text(exact) else f"{text} = {float_text(exact)}"
    return "-" if motion.multiplier is None else float_text(motion.multiplier)
