"""Wheels on rollers that turn freely, as wheels without rollers.

A wheel with a friction axis ``a_i`` and no friction across it constrains ``a_i . v(p_i) = u_i a_i . d_i`` and nothing
else.  So does a wheel whose rim points along ``a_i`` and runs at ``u_i a_i . d_i``: a mecanum wheel is an omniwheel
whose rim stands along the axes of its rollers and whose speed is that of the drive times the cosine of their angle.
Where the cosine is not zero, each speed of the one is a speed of the other, so that both can be driven alike.
"""

from __future__ import annotations

from dataclasses import replace

from nonsmooth.symbolic.mechanics.scene import Scene, Wheel


def askew_wheels(scene: Scene) -> tuple[Wheel, ...]:
    """The wheels whose friction axis is not their rim."""
    return tuple(wheel for wheel in scene.wheels if wheel.axis is not None)


def with_rims_along_axes(scene: Scene) -> Scene | None:
    """The same array with rims along the friction axes.

    None where a wheel that has an axis of its own also has friction across it, or is driven at right angles to it.
    """
    if not askew_wheels(scene):
        return scene
    wheels = [_along_axis(wheel) for wheel in scene.wheels]
    found = tuple(wheel for wheel in wheels if wheel is not None)
    return replace(scene, wheels=found) if len(found) == len(wheels) else None


def _along_axis(wheel: Wheel) -> Wheel | None:
    if wheel.axis is None:
        return wheel
    along, _ = wheel.gains
    if wheel.friction.side or not along:
        return None
    cosine, limit = along / wheel.grip_length, wheel.speed_limit
    return replace(
        wheel,
        direction=wheel.axis,
        axis=None,
        given_speed=wheel.speed * cosine,
        speed_limit=None if limit is None else limit * cosine,
    )
