"""Tangent cones of sign patterns: on which sides of the surfaces through a state there are states."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nonsmooth.analysis.fields.convex_weights import origin_distance
from nonsmooth.analysis.fields.switched_field import Vector

# Relative to unit gradients: an open cone narrower than this is not told from an empty one.
CONE_SLACK = 1e-9


def has_points(pattern: Sequence[int], normals: Sequence[Vector]) -> bool:
    """Whether the tangent cone ``n_k . d = 0`` (held), ``side n_k . d > 0`` (others) is not empty.

    By Gordan's theorem the open cone is empty iff a convex combination of the projected normals is zero.
    """
    held = [n for n, side in zip(normals, pattern, strict=True) if not side]
    others = [side * n for n, side in zip(normals, pattern, strict=True) if side]
    if held:
        basis = span(np.array(held).T)
        others = [n - basis @ (basis.T @ n) for n in others]
    return not others or origin_distance(np.array(others)) > CONE_SLACK


def sign_patterns(normals: Sequence[Vector]) -> tuple[tuple[int, ...], ...]:
    """Every pattern of -, 0, + of surfaces through a point whose tangent cone has points; most zeros first.

    One surface after the other: a pattern without points has none with a further sign.  In the plane n lines leave
    4 n + 1 patterns of 3^n.
    """
    patterns: list[tuple[int, ...]] = [()]
    for count in range(1, len(normals) + 1):
        longer = [(*pattern, side) for pattern in patterns for side in (-1, 0, 1)]
        patterns = longer if count == 1 else [p for p in longer if has_points(p, normals[:count])]
    return tuple(sorted(patterns, key=lambda p: (-p.count(0), p)))


def span(columns: Vector) -> Vector:
    """Orthonormal basis of the span of some columns."""
    basis, values, _ = np.linalg.svd(columns, full_matrices=False)
    return np.asarray(basis[:, values > CONE_SLACK])
