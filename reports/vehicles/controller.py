"""Parameter lines of ROS 2's ``diff_drive_controller`` for a vehicle.

The controller divides the difference of the wheel speeds by ``wheel_separation * wheel_separation_multiplier``, so the
multiplier is the effective track over the track.
"""

from __future__ import annotations

from nonsmooth.symbolic.vehicles.vehicle import Vehicle

DIGITS = 6  # significant, of a parameter: more than any vehicle keeps


def controller_parameters(vehicle: Vehicle, multiplier: float | None) -> dict[str, float] | None:
    """The parameters by name; None where the vehicle has no track, or does not turn."""
    if vehicle.track is None or multiplier is None:
        return None
    parameters = {"wheel_separation": float(vehicle.track), "wheel_separation_multiplier": multiplier}
    if vehicle.wheel_radius is not None:
        parameters["wheel_radius"] = float(vehicle.wheel_radius)
    return {name: float(f"{value:.{DIGITS}g}") for name, value in parameters.items()}


def controller_lines(vehicle: Vehicle, multiplier: float | None) -> str | None:
    """The parameters as YAML of a node named ``diff_drive_controller``; None as above."""
    parameters = controller_parameters(vehicle, multiplier)
    if parameters is None:
        return None
    lines = ["diff_drive_controller:", "  ros__parameters:"]
    return "\n".join([*lines, *(f"    {name}: {value!r}" for name, value in parameters.items())]) + "\n"
