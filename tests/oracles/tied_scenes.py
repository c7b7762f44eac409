"""Arrays at whose equilibrium a velocity lies exactly along a ray: once certified as asymptotically stable."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

from tests.conftest import WheelData
from tests.oracles.nearest_paths import Wheel

if TYPE_CHECKING:
    from nonsmooth.symbolic.mechanics.scene import Scene
    from tests.conftest import Arrays


def scene_of(arrays: Arrays, wheels: list[Wheel]) -> Scene:
    data = [WheelData(w.position, w.direction, w.speed, (w.roll, w.side)) for w in wheels]
    return arrays.scene(data, radius=Fraction(1, 10))


def wheel(position: tuple[str, str], heading: tuple[str, str], speed: str) -> Wheel:
    (x, y), (a, b) = position, heading
    numbers = [Fraction(text) for text in (x, y, a, b, speed)]
    return Wheel((numbers[0], numbers[1]), (numbers[2], numbers[3]), numbers[4], Fraction(1), Fraction(1, 2))


LEAVES_LIKE_A_ROOT = [
    wheel(("8/17", "-15/17"), ("0", "1"), "133325/642872"),
    wheel(("12/13", "5/13"), ("15/17", "-8/17"), "-7"),
    wheel(("-9/41", "40/41"), ("21/29", "-20/29"), "-5/4"),
]
CENTRE = [
    wheel(("0", "1"), ("1", "0"), "1"),
    wheel(("2", "1"), ("0", "1"), "-1"),
    wheel(("2", "-1"), ("0", "1"), "-4"),
]
LEAVES_FROM_1E_9 = [
    wheel(("0", "-1"), ("-4/5", "-3/5"), "-5/2"),
    wheel(("1", "0"), ("-4/5", "-3/5"), "-1"),
    wheel(("-1", "0"), ("4/5", "-3/5"), "1/25"),
]
