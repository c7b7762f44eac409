"""Scenes that must behave like a given one: scaled, sped up, moved away, or with another ratio of frictions.

All changes are exact.  What has to follow:

- *scaled* (positions, square, equilibrium times s; speeds kept): twists ``(v, omega/s)``, the same verdicts;
- *moved* (array and equilibrium shifted alike): the same verdicts about the shifted point;
- *with friction ratio* r (``mu_S = r mu_R``): under rule ``nearest`` only ``r < 1``, ``= 1`` or ``> 1`` matters;
- a plain system *scaled* by s, ``x' = s f(x/s)``, or *sped up* by k, ``x' = k f(x)``: the same verdict.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction

from nonsmooth.symbolic.piecewise import PiecewiseExpression, parse_piecewise
from nonsmooth.symbolic.scene import Friction, LoadTable, Scene, Wheel
from nonsmooth.symbolic.system import SystemScene


def with_wheels(scene: Scene, change: Callable[[Wheel], Wheel]) -> Scene:
    """Every wheel changed alike."""
    return replace(scene, wheels=tuple(change(wheel) for wheel in scene.wheels))


def scaled(scene: Scene, factor: Fraction) -> Scene:
    """All lengths times a positive factor; surface speeds stay."""

    def larger(wheel: Wheel) -> Wheel:
        x, y = wheel.position
        return replace(wheel, position=(x * factor, y * factor), given_speed=wheel.speed)

    (x, y), loads = scene.check.equilibrium, scene.contact.loads
    if loads is not None:
        loads = LoadTable(tuple((a, b / factor, c / factor) for a, b, c in loads.rows))
    check = replace(
        scene.check, equilibrium=(x * factor, y * factor), radius=scene.check.radius * factor, lyapunov=None
    )
    return replace(with_wheels(scene, larger), contact=replace(scene.contact, loads=loads), check=check)


def moved(scene: Scene, x: Fraction, y: Fraction) -> Scene:
    """Array, load table and equilibrium shifted alike."""

    def shifted(wheel: Wheel) -> Wheel:
        return replace(wheel, position=(wheel.position[0] + x, wheel.position[1] + y))

    (p, q), loads = scene.check.equilibrium, scene.contact.loads
    if loads is not None:
        loads = LoadTable(tuple((a - b * x - c * y, b, c) for a, b, c in loads.rows))
    check = replace(scene.check, equilibrium=(p + x, q + y))
    return replace(with_wheels(scene, shifted), contact=replace(scene.contact, loads=loads), check=check)


def with_friction_ratio(scene: Scene, ratio: Fraction) -> Scene:
    """``mu_R = 1`` and ``mu_S = ratio`` at every wheel."""
    friction = Friction(scene.field.one, scene.field(ratio))
    return with_wheels(scene, lambda wheel: replace(wheel, friction=friction))


def scaled_system(scene: SystemScene, length: Fraction = Fraction(1), speed: Fraction = Fraction(1)) -> SystemScene:
    """``x' = k s f(x/s)`` for a length s and a speed k."""
    shrunk = {name: f"({name}/({length}))" for name in scene.states}
    rhs = tuple(_parsed(f"({speed})*({length})*({_renamed(f, shrunk)})", scene.states) for f in scene.rhs)
    x, y = scene.check.equilibrium
    check = replace(
        scene.check,
        equilibrium=(x * length, y * length),
        radius=scene.check.radius * length,
        lyapunov=_parsed(_renamed(scene.check.lyapunov, shrunk), scene.states),
    )
    return replace(scene, rhs=(rhs[0], rhs[1]), check=check)


def with_rate_ratio(scene: SystemScene, ratio: Fraction) -> SystemScene:
    """``x' = f_1, y' = r f_2``."""
    first, second = scene.rhs
    return replace(scene, rhs=(first, _parsed(f"({ratio})*({second.text})", scene.states)))


def _renamed(formula: PiecewiseExpression, names: dict[str, str]) -> str:
    pattern = re.compile(rf"\b({'|'.join(map(re.escape, names))})\b")
    return pattern.sub(lambda found: names[found[0]], formula.text)


def _parsed(text: str, states: tuple[str, str]) -> PiecewiseExpression:
    return parse_piecewise(text, states)
