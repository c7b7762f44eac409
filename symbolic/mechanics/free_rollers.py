"""Wheels on rollers that turn freely, as wheels without rollers; and motions that nothing resists.

A wheel with a friction axis ``a_i`` and no friction across it constrains ``a_i . v(p_i) = u_i a_i . d_i`` and nothing
else.  So does a wheel whose rim points along ``a_i`` and runs at ``u_i a_i . d_i``: a mecanum wheel is an omniwheel
whose rim stands along the axes of its rollers and whose speed is that of the drive times the cosine of their angle.
Where the cosine is not zero, each speed of the one is a speed of the other, so that both can be driven alike.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from nonsmooth.symbolic.mechanics.contact_states import Row, Triple, basis_of, complement, rows_with_friction
from nonsmooth.symbolic.mechanics.scene import Scene, Wheel
from nonsmooth.symbolic.numbers.number_text import brief_text


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


# ---- free motions: the twists that no row with friction resists, exactly -------------------------
#
# A row with friction resists a twist xi unless ``a_k . xi = 0``.  So the free twists are the kernel of the rows with
# friction, and along each of them D is constant: if xi minimizes D, so does xi plus any free twist.  Free rollers with
# all their axes through one point, for example, leave the rotation about it free.


def free_twists(scene: Scene) -> tuple[Triple, ...]:
    """A basis of the twists that no row with friction of any wheel resists; empty where every motion is resisted."""
    return kernel(rows_with_friction(scene))


def kernel(rows: Iterable[Row]) -> tuple[Triple, ...]:
    """A basis of the twists that satisfy ``a_k . xi = 0`` for rows of which at least one is there."""
    return complement(basis_of(row.normal for row in rows))


def free_text(twists: Sequence[Triple]) -> str:
    """In words, that these motions are free; empty where there are none."""
    if not twists:
        return ""
    listed = ", ".join(f"({', '.join(brief_text(entry) for entry in twist)})" for twist in twists)
    return f"no row with friction resists the motion{'s' if len(twists) > 1 else ''} xi = {listed}"
