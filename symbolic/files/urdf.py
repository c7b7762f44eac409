"""Wheels of a robot description (URDF), read with the parser of the standard library.

A wheel is the child of a ``continuous`` joint whose axis lies level, across the robot.  Joints are followed from the
root link; their origins turn by roll, pitch and yaw.  Positions are rounded to a nanometre, which is what makes them
exact.  Documents with a type declaration or entities are refused before they are parsed, and so is anything large:
nothing in a file can expand.  Xacro is a program, not a description: expand it first.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

from nonsmooth.symbolic.scene_error import SceneError, StatedFact

MAX_BYTES = 4 << 20
MAX_JOINTS = 2_000
DIGITS = 9  # decimals of a position in metres, and of a direction
LEVEL = 2.0**-7  # largest upward part of a unit axle that counts as level

Matrix = tuple[tuple[float, float, float], tuple[float, float, float], tuple[float, float, float]]
Point = tuple[float, float, float]
_UNIT: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@dataclass(frozen=True)
class UrdfWheel:
    """A wheel of a robot description: where it is, where it heads, and its radius where a cylinder states one."""

    joint: str
    position: tuple[Fraction, Fraction]
    heading: tuple[Fraction, Fraction]
    radius: Fraction | None


def read_urdf(text: str, file: str, key: str) -> tuple[UrdfWheel, ...]:
    """The wheels of a robot, in the order of the file.

    Raises:
        SceneError: for text that is no robot description, or one without wheels.
    """
    root = _robot(text, file, key)
    joints = [joint for joint in root.iter("joint") if joint.find("child") is not None]
    if len(joints) > MAX_JOINTS:
        raise SceneError(file, key, f"at most {MAX_JOINTS} joints", StatedFact(f"{len(joints)}"))
    reader = _Reader({_link(joint, "child"): joint for joint in joints}, _radii(root), file, key)
    wheels = tuple(wheel for joint in joints for wheel in reader.wheel(joint))
    if not wheels:
        raise SceneError(file, key, "continuous joints with level axles", StatedFact("none"))
    return wheels


def _robot(text: str, file: str, key: str) -> ET.Element:
    """The root element; what could expand is refused before it is parsed."""
    if "<!" in text.replace("<!--", ""):
        raise SceneError(file, key, "a robot description without declarations", StatedFact("one with <!...>"))
    try:
        root = ET.fromstring(text)
    except ET.ParseError as error:
        raise SceneError(file, key, "a robot description (XML)", StatedFact(f"an error: {str(error)[:80]}")) from None
    if root.tag != "robot":
        raise SceneError(file, key, "a <robot> of URDF", StatedFact(f"<{root.tag[:40]}>"))
    return root


def _link(joint: ET.Element, end: str) -> str:
    element = joint.find(end)
    return "" if element is None else element.get("link", "")


def _radii(root: ET.Element) -> dict[str, str]:
    """Radius of the first cylinder of each link, as text."""
    cylinders = ((link.get("name", ""), link.find(".//cylinder")) for link in root.iter("link"))
    return {name: cylinder.get("radius", "") for name, cylinder in cylinders if cylinder is not None}


@dataclass(frozen=True)
class _Reader:
    joints: dict[str, ET.Element]  # by child link
    radii: dict[str, str]
    file: str
    key: str

    def wheel(self, joint: ET.Element) -> Iterator[UrdfWheel]:
        """The wheel at a joint, if it is one."""
        if joint.get("type") != "continuous":
            return
        turn, place = self._pose(joint)
        axle = _applied(turn, self._triple(joint.find("axis"), "xyz", (1.0, 0.0, 0.0)))
        size = math.hypot(*axle)
        if not size or abs(axle[2]) > LEVEL * size:
            return
        forward = axle[1] / math.hypot(*axle[:2]), -axle[0] / math.hypot(*axle[:2])  # axle x upward
        if (forward[0], forward[1]) < (0.0, 0.0):
            forward = -forward[0], -forward[1]
        radius = self.radii.get(_link(joint, "child"))
        yield UrdfWheel(
            joint.get("name", ""),
            (_rounded(place[0]), _rounded(place[1])),
            (_rounded(forward[0]), _rounded(forward[1])),
            _rounded(self._number(radius)) if radius else None,
        )

    def _pose(self, joint: ET.Element) -> tuple[Matrix, Point]:
        """Rotation and place of a joint in the root's frame."""
        chain: list[ET.Element] = []
        seen: ET.Element | None = joint
        while seen is not None:
            if len(chain) > len(self.joints):
                raise SceneError(self.file, self.key, "a tree of links", StatedFact("a ring of joints"))
            chain.append(seen)
            seen = self.joints.get(_link(seen, "parent"))
        turn, place = _UNIT, (0.0, 0.0, 0.0)
        for link in reversed(chain):
            origin = link.find("origin")
            step = _applied(turn, self._triple(origin, "xyz", (0.0, 0.0, 0.0)))
            place = place[0] + step[0], place[1] + step[1], place[2] + step[2]
            turn = _product(turn, _rotation(*self._triple(origin, "rpy", (0.0, 0.0, 0.0))))
        return turn, place

    def _triple(self, element: ET.Element | None, name: str, default: Point) -> Point:
        text = None if element is None else element.get(name)
        if text is None:
            return default
        parts = [self._number(part) for part in text.split()]
        if len(parts) != 3:
            raise SceneError(self.file, self.key, f"three numbers in {name}", text)
        return parts[0], parts[1], parts[2]

    def _number(self, text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise SceneError(self.file, self.key, "finite numbers (expand xacro first)", text)
        return value


def _rounded(value: float) -> Fraction:
    return Fraction(round(Fraction(value) * 10**DIGITS), 10**DIGITS)


def _rotation(roll: float, pitch: float, yaw: float) -> Matrix:
    """``Rz(yaw) Ry(pitch) Rx(roll)``, the order of URDF."""
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a), math.sin(a)) for a in (roll, pitch, yaw))
    return (
        (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
        (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
        (-sp, cp * sr, cp * cr),
    )


def _applied(matrix: Matrix, vector: Point) -> Point:
    x, y, z = (sum(a * b for a, b in zip(row, vector, strict=True)) for row in matrix)
    return x, y, z


def _product(left: Matrix, right: Matrix) -> Matrix:
    columns = [_applied(left, column) for column in zip(*right, strict=True)]
    first, second, third = zip(*columns, strict=True)
    return first, second, third
