"""The array of driven wheels that a certificate is about: its wheels as rows of equations, and their loads.

J is the quarter turn.  A *twist* is ``(vx, vy, omega, 1)``; the body at c moves by ``c' = v + omega J c``, measured
from the checked point.  A *row* is the vector of an equation ``row . twist = 0``.  With ``v(p) = v + omega J p`` the
wheel at p with the rim direction d, the normal n = J d and the speed u has the rows ``d . v(p) = u``, rolling, and
``n . v(p) = 0``, no side slip; one with a friction axis a has ``a . v(p) = u a . d`` and ``J a . v(p) = u J a . d``.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import Any, TypeAlias

from .tower import Field, Number, Vector, cross, dot, is_zero, negative, normal_to, signs, total
from .work import items, require, take, whole

MAX_WHEELS = 20_000
NEAREST, BOX = "nearest", "box"

Row: TypeAlias = tuple[str, int]  # "R" (rolling) or "S" (no side slip), and the number of the wheel, from 1
Limits: TypeAlias = Sequence[dict[Row, Number]]  # the friction limit of each loaded row, at each corner of a cell


@dataclass(frozen=True)
class Wheel:
    """One wheel, seen from the checked point.

    Attributes:
        place: ``(p_x, p_y, 1)``.
        rows: the rolling and the side row as ``(a, b, c, -u)``.
        friction: their coefficients.
        drive: None without a friction axis; with one, whether the drive moves the wheel along the axis and there is no
            friction across it, so that its speed along the axis can be any, as that of a rim can.
    """

    place: Vector
    rows: tuple[Vector, Vector]
    friction: Vector
    drive: bool | None


@dataclass(frozen=True)
class Array:
    """The subject of a certificate; wheels are numbered from 1.

    Attributes:
        field: of all its numbers.
        at: the checked point.
        radius: half the side of the checked square.
        rule: ``nearest`` or ``box``.
        wheels: by number.
        loads: for each wheel ``(b, c, a)`` with ``N = a + b x + c y`` where a table is given; empty otherwise.
        elastic: whether the wheels are identical springs.
        tolerances: of positions, headings, speeds and both coefficients of friction; None without.
    """

    field: Field
    at: Vector
    radius: Number
    rule: str
    wheels: dict[int, Wheel]
    loads: dict[int, Vector]
    elastic: bool
    tolerances: Vector | None

    @cached_property
    def rows(self) -> dict[Row, Vector]:
        """All rows, wheel by wheel."""
        return {(kind, k): row for k, w in self.wheels.items() for kind, row in zip("RS", w.rows, strict=True)}

    @cached_property
    def friction(self) -> dict[Row, Number]:
        """The coefficient of each row."""
        return {(kind, k): mu for k, w in self.wheels.items() for kind, mu in zip("RS", w.friction, strict=True)}


TOLERANCES = "position heading speed mu_roll mu_side"


def read_array(data: Any) -> Array:
    """The array of a statement."""
    numbers, wheels, rule, loads, at_data, radius_data, tolerances = take(
        data, "field wheels rule loads at radius", "tolerances"
    )
    field = Field(numbers)
    at, radius = field.vector(at_data, 2), field.parse(radius_data)
    require(rule in (NEAREST, BOX) and (rule == BOX or loads is None), "a rule, nearest or box, and loads under box")
    require(radius.sign() > 0, "a positive radius")
    entries = items(wheels, most=MAX_WHEELS)
    listed = {k: read_wheel(field, at, f"wheel {k}", entry) for k, entry in enumerate(entries, 1)}
    elastic, table = loads == "elastic", dict[int, Vector]()
    if rule == BOX and not elastic:
        for k, form in zip(listed, items(loads, len(listed)), strict=True):
            a, b, c = field.vector(form, 3)
            table[k] = (b, c, a + b * at[0] + c * at[1])
    sizes = None if tolerances is None else tuple(map(field.parse, take(tolerances, TOLERANCES)))
    return Array(field, at, radius, rule, listed, table, elastic, sizes)


def read_wheel(field: Field, at: Vector, name: str, data: Any) -> Wheel:
    """The claim: unit vectors for directions, and friction that is not negative.  Without an axis it is the rim."""
    *pairs, speed, axis = take(data, "position direction friction speed", "axis")
    position, direction, friction = (field.vector(pair, 2) for pair in pairs)
    grip = direction if axis is None else field.vector(axis, 2)
    one, u = field.rational(1), field.parse(speed)
    lengths = signs(dot(v, v) - one for v in (direction, grip))
    sound = not any(lengths) and min(signs(friction)) >= 0
    require(sound, f"{name}: a unit direction, and friction that is not negative")
    (a, b), p, q = grip, position[0] - at[0], position[1] - at[1]
    along, across = dot(grip, direction), cross(grip, direction)
    rows = (a, b, b * p - a * q, -(u * along)), (-b, a, a * p + b * q, -(u * across))
    drive = None if axis is None else bool(along.sign()) and not friction[1].sign()
    return Wheel((p, q, one), rows, friction, drive)


# ---- loads ---------------------------------------------------------------------------------------


def friction_limits(array: Array, loaded: Any, corners: Sequence[Vector]) -> Limits:
    """The friction limits ``mu N`` of the loaded rows at each corner, up to one positive factor at each.

    The claim: the listed wheels are those that carry load in the cell.  Elastic: ``N_i = max(0, m_i . y)`` with
    ``m_i = (p_i, 1)`` and ``y = A^-1 (c, 1)``, A the sum of ``m m^T`` over the loaded wheels: a spring carries load
    where its form is not negative, and the others have no load because theirs is not positive.
    """
    forms, active = array.loads, set(array.loads)
    if array.elastic:
        active = {whole(k, len(array.wheels)) for k in items(loaded)}
        forms = _elastic_forms(array, active)
    loads = [{k: dot(form, corner) for k, form in forms.items()} for corner in corners]
    sound = all(load.sign() * (1 if k in active else -1) >= 0 for at_corner in loads for k, load in at_corner.items())
    require(sound and (loaded is None) == (not array.elastic), "the wheels that carry load")
    friction = array.friction
    return [{row: friction[row] * at_corner[row[1]] for row in friction if row[1] in active} for at_corner in loads]


def _elastic_forms(array: Array, active: set[int]) -> dict[int, Vector]:
    """The forms ``m_i . adj(A) (c, 1)``: adj(A) is A^-1 up to a positive factor."""
    carrying = [array.wheels[k].place for k in active]
    require(carrying, "loaded wheels that are not collinear")
    gram = [tuple(total([m[r] * m[s] for m in carrying]) for s in range(3)) for r in range(3)]
    adjugate = [normal_to(gram[r - 2], gram[r - 1]) for r in range(3)]
    require(dot(gram[0], adjugate[0]).sign() > 0, "loaded wheels that are not collinear")
    return {k: tuple(dot(column, wheel.place) for column in adjugate) for k, wheel in array.wheels.items()}


def edge_slopes(rows: dict[Row, Vector], slips: dict[Row, int], limits: Limits) -> Iterator[tuple[Vector, list[int]]]:
    """Each way out of a twist along an edge, and the signs of the slope of D along it under each of the limits.

    D is a sum of ``limit |slip|`` over rows.  The planes of the rows that a twist satisfies cut the neighbourhood into
    cones on which D is linear; their edges are the intersections of two planes, in both senses.  The slope along m is
    the sum of ``limit |row . m|`` over those rows, which is the same along -m, and ``g . m`` with the sum g of ``limit
    sign(slip) row`` over the others, which is the opposite.  Rows and limits are taken as whole numbers.
    """
    whole_rows, whole_limits = _without_denominators(rows, limits)
    zero = whole_rows[next(iter(rows))][0] * 0
    others = [row for row in limits[0] if slips[row]]
    pulls = [
        [sum((whole_rows[row][k] * (at_corner[row] * slips[row]) for row in others), start=zero) for k in range(3)]
        for at_corner in whole_limits
    ]
    tight = [row for row, side in slips.items() if not side]
    for a, b in combinations(tight, 2):
        edge = normal_to(whole_rows[a], whole_rows[b])
        if is_zero(edge):
            continue
        reaches = {row: abs(dot(edge, whole_rows[row])) for row in tight if row in limits[0]}
        there, back = list[int](), list[int]()
        for at_corner, pull in zip(whole_limits, pulls, strict=True):
            even = sum((at_corner[row] * reach for row, reach in reaches.items()), start=zero)
            odd = dot(edge, pull)
            there.append((even + odd).sign())
            back.append((even - odd).sign())
        yield edge, there
        yield negative(edge), back


def _without_denominators(rows: dict[Row, Vector], limits: Limits) -> tuple[dict[Row, Vector], Limits]:
    """Positive multiples that are whole: of each normal, and at each corner of all limits, by which D is the same."""
    bottoms = {row: _common_denominator(normal[:3]) for row, normal in rows.items()}
    normals = {row: tuple(x * bottoms[row] for x in normal[:3]) for row, normal in rows.items()}
    whole_limits: list[dict[Row, Number]] = []
    for at_corner in limits:
        quotients = {row: limit / bottoms[row] for row, limit in at_corner.items()}
        bottom = _common_denominator(quotients.values())
        whole_limits.append({row: limit * bottom for row, limit in quotients.items()})
    return normals, whole_limits


def _common_denominator(numbers: Iterable[Number]) -> int:
    return math.lcm(*(number.bottom for number in numbers))
