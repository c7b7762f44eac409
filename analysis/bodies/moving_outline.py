"""The outline of a moving body in floats: how deep each wheel lies under it, and how fast that changes.

With ``q_i = R(theta)^T (p_i - c)`` the place of wheel i in the body's frame (turned to the checked heading), its depth
is ``g_i = min over sides of (h_e - n_e . q_i)`` for a polygon with outward unit normals n_e, and ``R - |q_i - m|`` for
a disc about m: positive strictly under the body, negative beside it.  ``q_i' = -R(theta)^T (c' + omega J (p_i - c))``,
minus the velocity of the body at the wheel, seen from the body.
"""

from __future__ import annotations

import numpy as np

from nonsmooth.symbolic.mechanics.body import Body, Disc
from nonsmooth.symbolic.numbers.plane_arrays import (
    Floats,
    Indices,
    float_points,
    norm,
    norms,
    polygon_sides,
    row_products,
    spread,
    turned,
)

SAME_SIDE = 1e-9  # of the body's size: sides this nearly as deep bound the depth together


class MovingOutline:
    """Depths of wheels under a body at poses ``(x, y, theta)``."""

    def __init__(self, body: Body, places: Floats) -> None:
        """For wheels at places (n, 2)."""
        self.places = np.asarray(places, float)
        self._middle = np.array(body.centroid, float)
        self._radius: float | None = None
        if isinstance(body.outline, Disc):
            self._radius = float(body.outline.radius)
            self.size = self._radius + norm(self._middle)
            return
        corners = float_points(body.vertices)
        sides = polygon_sides(corners)
        self._normals, self._heights = sides[:, :2], -sides[:, 2]
        self.corners = corners
        self.size = float(norms(corners).max())

    @property
    def spacing(self) -> float:
        """The middle one of the wheels' distances from their nearest neighbours, at most the body's size."""
        from scipy.spatial import cKDTree

        if self.count < 2:
            return self.size
        nearest = cKDTree(self.places).query(self.places, k=2)[0][:, 1]
        return min(float(np.median(nearest)), self.size)

    @property
    def count(self) -> int:
        """Number n of wheels."""
        return len(self.places)

    def depths(self, pose: Floats) -> Floats:
        """``g_i`` at one pose (3,), shape (n,); at poses (m, 3), shape (m, n)."""
        return self._below(_seen(self.places, pose))

    def depths_at(self, places: Floats, poses: Floats) -> Floats:
        """Depths (m, k) of places (m, k, 2) of their own at each of the poses (m, 3)."""
        return self._below(_seen(places, poses))

    def headings_under_edge(self, away: Floats) -> tuple[Indices, Floats]:
        """Headings at which places lie under the edge: rows of the places (m, 2) from the centre of mass, and theta.

        ``theta = arg(q) - arg(n) +- acos(h/|q|)`` for a side, ``arg(q) - arg(m) +- acos(...)`` for a disc about m.
        """
        reach = norms(away)
        if self._radius is None:
            directions, shares = self._normals, self._heights / reach[:, None]
        else:
            offset = norm(self._middle)
            directions = self._middle[None]
            shares = ((reach**2 + offset**2 - self._radius**2) / (2 * reach * offset))[:, None]
        rows, sides = np.nonzero(np.abs(shares) < 1)
        half = np.arccos(shares[rows, sides])
        between = np.arctan2(*away[rows].T[::-1]) - np.arctan2(*directions[sides].T[::-1])
        rows, thetas = np.concatenate([rows, rows]), np.concatenate([between - half, between + half])
        poses = np.column_stack([np.zeros((len(thetas), 2)), thetas])
        on_edge = np.abs(self.depths_at(away[rows, None], poses)[:, 0]) <= SAME_SIDE * self.size
        return rows[on_edge], thetas[on_edge]

    def _below(self, places: Floats) -> Floats:
        """Depths of places in the body's frame."""
        if self._radius is not None:
            return self._radius - np.hypot(*np.moveaxis(places - self._middle, -1, 0))
        return np.asarray((self._heights - places @ self._normals.T).min(axis=-1))

    def rates(self, pose: Floats, rate: Floats, wheels: list[int]) -> Floats:
        """``g_i'`` of some wheels at a pose whose rate is ``(c', theta')``, along the motion; shape (k,)."""
        (x, y, theta), (vx, vy, omega) = pose, rate
        away = self.places[wheels] - [x, y]
        seen = _seen(self.places, pose)[wheels]
        c, s = np.cos(theta), np.sin(theta)
        drift = -np.array([vx, vy]) - omega * turned(away)
        moved = drift @ np.array([[c, -s], [s, c]])  # R^T on the left of every row
        if self._radius is not None:
            out = seen - self._middle
            return -row_products(out, moved) / norms(out)
        depths = self._heights - seen @ self._normals.T
        deepest = depths.min(axis=1, keepdims=True)
        slopes = np.where(depths <= deepest + SAME_SIDE * self.size, -(moved @ self._normals.T), np.inf)
        return slopes.min(axis=1)

    def gradient(self, pose: Floats, wheel: int) -> Floats:
        """``(R n_e, -n_e x q_i)``, the derivative of ``g_i`` by ``(x, y, theta)``, n_e of the deepest side; (3,).

        In the middle of a disc all directions are alike, and one is taken.
        """
        seen = _seen(self.places[[wheel]], pose)[0]
        if self._radius is not None:
            out = seen - self._middle
            normal = out / norm(out) if out.any() else np.array([1.0, 0.0])
        else:
            normal = self._normals[int(np.argmin(self._heights - self._normals @ seen))]
        c, s = np.cos(pose[2]), np.sin(pose[2])
        turning = normal[1] * seen[0] - normal[0] * seen[1]
        return np.array([c * normal[0] - s * normal[1], s * normal[0] + c * normal[1], turning])


class WholePlane(MovingOutline):
    """The outline of a body that covers all wheels, wherever it is; no wheel comes to its edge."""

    def __init__(self, places: Floats) -> None:
        """For wheels at places (n, 2)."""
        self.places = np.asarray(places, float)
        self.size = spread(self.places) or 1.0

    def depths(self, pose: Floats) -> Floats:
        """Infinite."""
        return np.full((*np.shape(pose)[:-1], self.count), np.inf)


def _seen(places: Floats, pose: Floats) -> Floats:
    """``q_i``."""
    pose = np.asarray(pose, float)
    away = places - pose[..., None, :2]
    c, s = np.cos(pose[..., None, 2]), np.sin(pose[..., None, 2])
    return np.stack([c * away[..., 0] + s * away[..., 1], c * away[..., 1] - s * away[..., 0]], axis=-1)
