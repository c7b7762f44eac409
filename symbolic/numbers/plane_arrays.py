"""Types of arrays, and arrays of plane vectors in floats, the coordinates last: from exact ones, and products as in
:mod:`nonsmooth.symbolic.numbers.plane`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from nonsmooth.symbolic.numbers import plane

Floats: TypeAlias = NDArray[np.float64]
Mask: TypeAlias = NDArray[np.bool_]
Indices: TypeAlias = NDArray[np.int_]


def float_points(points: Iterable[Iterable[Any]]) -> Floats:
    """Points of exact numbers as floats of shape (m, 2); so are vectors of any other length, a row for each."""
    return np.array([list(map(float, point)) for point in points])


def places_of(wheels: Iterable[Any]) -> Floats:
    """Positions of wheels, shape (n, 2)."""
    return float_points(wheel.position for wheel in wheels)


def even_angles(count: int) -> Floats:
    """Angles around a full turn from zero on (radian), all as far apart, shape (count,)."""
    return 2 * np.pi * np.arange(count) / count


def unit_vectors(angles: Floats | float) -> Floats:
    """Unit vectors at angles (radian), shape (..., 2)."""
    return np.stack([np.cos(angles), np.sin(angles)], axis=-1)


def norm(vector: Iterable[Any]) -> float:
    """The length of a vector of the plane."""
    return float(np.hypot(*vector))


def norms(vectors: Floats) -> Floats:
    """Lengths of vectors of shape (..., 2); of longer ones those of their first two coordinates."""
    return np.hypot(*_coordinates(vectors))


def following(corners: Floats) -> Floats:
    """The next of each corner around a polygon, shape (m, n)."""
    return np.roll(corners, -1, axis=0)


def polygon_sides(corners: Floats) -> Floats:
    """Rows ``(n_x, n_y, offset)``, one per side of a polygon, counterclockwise, with ``n . p + offset <= 0`` behind it.

    n is its outward unit normal; zero where two corners are one.
    """
    along = following(corners) - corners
    normals = -turned(along) / (norms(along)[:, None] + np.finfo(float).tiny)
    return np.column_stack([normals, -row_products(normals, corners)])


def grid_points(across: Floats, up: Floats) -> Floats:
    """Points of a grid with these coordinates, shape (m, 2); x runs first."""
    return np.stack(np.meshgrid(across, up), axis=-1).reshape(-1, 2)


def row_products(a: Floats, b: Floats) -> Floats:
    """Inner products of vectors of any dimension, shape (m, n)."""
    return (a * b).sum(axis=1)


def distinct_rows(rows: Any) -> Floats:
    """The rows in lexicographic order, each once.

    As :func:`numpy.unique` finds them, which compares rows as records and takes eight times as long for a million.
    """
    ordered = rows[np.lexsort(rows.T[::-1])] if rows.shape[1] else rows
    differs = np.any(ordered[1:] != ordered[:-1], axis=1)
    return ordered[np.append(np.ones(len(ordered[:1]), dtype=bool), differs)]


def finite_rows(vectors: Floats) -> Mask:
    """Which vectors, shape (m, n), have finite entries alone."""
    return np.asarray(np.isfinite(vectors).all(axis=1))


def row_norms(vectors: Floats) -> Floats:
    """Lengths of vectors of any dimension, shape (m, n)."""
    return np.linalg.norm(vectors, axis=1)


def max_norms(vectors: Floats) -> Floats:
    """The largest absolute value of an entry of each vector, shape (m, n)."""
    return np.abs(vectors).max(axis=1)


def squared_norms(vectors: Floats) -> Floats:
    """Squares of the lengths of vectors of any dimension, shape (m, n)."""
    return (vectors**2).sum(axis=1)


def are_finite(entries: Any) -> bool:
    """Whether all entries are finite numbers."""
    return bool(np.isfinite(entries).all())


def max_norm(entries: Any) -> float:
    """The largest absolute value of an entry; zero without any."""
    return float(np.abs(entries).max(initial=0.0))


def unit_rows(vectors: Floats) -> Floats:
    """Vectors of any dimension, shape (m, n), divided by their lengths."""
    return vectors / row_norms(vectors)[:, None]


def spread(points: Floats) -> float:
    """The largest difference of a coordinate among points, shape (m, n)."""
    return float(np.ptp(points, axis=0).max(initial=0.0))


def turned(vectors: Floats) -> Floats:
    """``J v``: a quarter turn counterclockwise of vectors of shape (..., 2)."""
    return np.stack(plane.turned(_coordinates(vectors)), axis=-1)


def point_velocities(twists: Floats, points: Floats) -> Floats:
    """``v + omega J c`` for spatial twists of shape (..., 3) and points c of shape (..., 2)."""
    return twists[..., :2] + twists[..., 2:] * turned(points)


def with_neighbours(step: float) -> Floats:
    """The origin and the points a step east, west, north and south of it."""
    return step * np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]])


def field_beside(velocity: Callable[[Floats], Floats], place: Floats, step: float) -> tuple[Floats, Floats]:
    """The velocity at a place of the plane and its derivative, by differences."""
    here, east, west, north, south = velocity(place + with_neighbours(step))
    return here, np.column_stack([east - west, north - south]) / (2 * step)


def dot(a: Floats, b: Floats) -> Floats:
    """Inner products of vectors of shape (..., 2)."""
    return plane.dot(_coordinates(a), _coordinates(b))


def cross(a: Floats, b: Floats) -> Floats:
    """``a_x b_y - a_y b_x`` for vectors of shape (..., 2)."""
    return plane.cross(_coordinates(a), _coordinates(b))


def _coordinates(vectors: Floats) -> tuple[Floats, Floats]:
    return vectors[..., 0], vectors[..., 1]
