"""Switched fields: surfaces, the faces that a path can keep to, and what following a solution takes of a field.

A *face* is a set a path can keep to: some surfaces held at zero, the others on one side.  With nothing held it is a
cell, with one surface held a sliding mode, with more a codimension-two (or higher) mode, in the plane a point of rest.
Its motions are the elements of the hull of the adjacent cells' fields that are tangent to the surfaces held (Filippov
1988, sec. 4; Utkin's equivalent control).

There are two kinds of cells: sign patterns of switching functions in any number of states
(:class:`nonsmooth.analysis.fields.sign_field.SignField`), and polygons of the plane
(:class:`nonsmooth.analysis.fields.polygon_field.PolygonField`) with constant twists or smooth fields.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol, TypeAlias

import numpy as np

from nonsmooth.analysis.fields.convex_weights import origin_distance
from nonsmooth.symbolic.numbers.plane_arrays import Floats

Velocity: TypeAlias = Callable[[float, Floats], Floats]
Mode: TypeAlias = Any  # a sign pattern or the number of a cell

# Relative to the size of the domain: the distance within which a state counts as on a surface. Above the integrator's
# error (1e-12), so that a path aimed at a corner is found to reach it.
SURFACE_SLACK = 1e-10
LARGE = 1e70  # an entry of a matrix of which floats may not hold powers of four


@dataclass(frozen=True, eq=False)
class Surface:
    """A switching function with its gradient; flat where that is constant."""

    name: str
    value: Callable[[Floats], float]
    gradient: Callable[[Floats], Floats]
    flat: bool = False
    _kept: dict[str, Any] = field(default_factory=dict, init=False, repr=False)  # of a flat surface

    def steepness(self, x: Floats) -> float:
        """The length of the gradient."""
        return self._kept.get("steepness") or self._keep("steepness", length(self.gradient(x)))

    def normal(self, x: Floats) -> Floats:
        """The gradient of unit length."""
        found = self._kept.get("normal")
        return self._keep("normal", self.gradient(x) / self.steepness(x)) if found is None else found

    def _keep(self, name: str, found: Any) -> Any:
        if self.flat:
            self._kept[name] = found
        return found


class NoVelocityError(RuntimeError):
    """A place at which a field has no value."""


class ScalarVelocity:
    """A velocity that does not depend on time, in single floats: arrays of few states cost several times as much.

    Attributes:
        rates: the time derivatives of all states from the states, one by one.
    """

    def __init__(self, rates: Callable[..., tuple[float, ...]]) -> None:
        self.rates = rates

    def __call__(self, t: float, x: Floats) -> Floats:
        """The rates as an array."""
        return np.array(self.rates(*x.tolist()))


class DifferentiatedVelocity(ScalarVelocity, ABC):
    """A velocity whose derivatives are not known from its values at some distance: it turns within less."""

    @abstractmethod
    def derivatives(self, x: Floats, steps: Floats) -> Floats:
        """The matrix of them, shape (n, n); by differences over these steps of what does not turn."""


def differences(function: Callable[[Floats], Floats], x: Floats, steps: Floats) -> Floats:
    """The derivatives of a function by all states, a column for each, by forward differences."""
    here = function(x)
    with np.errstate(invalid="ignore", over="ignore"):
        return np.column_stack([(function(x + move) - here) / move[k] for k, move in enumerate(np.diag(steps))])


class AffineVelocity(ScalarVelocity):
    """``A x + b``, of which a Taylor series is the motion.

    Args:
        rates: the same, as of any velocity in single floats.
        matrix: A, row by row.
        offset: b.

    Attributes:
        size: of A, a bound on its eigenvalues, zero where these vanish and the motion is a polynomial.
        scaled: the entries of A and of b over the size, if it is not zero, row by row.
    """

    def __init__(self, rates: Callable[..., tuple[float, ...]], matrix: Floats, offset: Floats) -> None:
        super().__init__(rates)
        most = float(np.abs(matrix).max(initial=0.0))
        scale = most if most > LARGE else 1.0
        self.size = scale * float(np.abs(np.linalg.matrix_power(matrix / scale, 4)).sum(axis=1).max()) ** (1 / 4)
        unit = self.size or 1.0
        self.scaled = (*(matrix / unit).ravel().tolist(), *(offset / unit).tolist())


def affine_surface(name: str, normal: Sequence[float], offset: float = 0.0) -> Surface:
    """``normal . x - offset``."""
    vector = np.array(normal, dtype=float)
    return Surface(name, lambda x: float(vector.dot(x)) - offset, lambda x: vector, flat=True)


@dataclass(frozen=True, eq=False)
class Member:
    """A cell's smooth field under its name."""

    name: str
    velocity: Velocity


@dataclass(frozen=True, eq=False)
class Face:
    """A set that a path can keep to.

    Attributes:
        name: what events call it.
        keep: surfaces held at zero.
        bounds: ``side * h >= 0`` for the others.
        members: fields of the cells around it.
    """

    name: str
    keep: tuple[Surface, ...]
    bounds: tuple[tuple[Surface, int], ...]
    members: tuple[Member, ...]


def length(vector: Floats) -> float:
    """Euclidean norm."""
    return math.sqrt(vector.dot(vector))


class FacedField(Protocol):
    """What it takes to follow a solution of a switched field by events: the faces at every state."""

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states."""

    @property
    def kinematics(self) -> str:
        """``exact``, ``leading`` or ``given``."""

    @property
    def size(self) -> float:
        """Typical size of the states, which sets the slack of surfaces."""

    @property
    def unit(self) -> float:
        """The unit of length of x and y, in that of the scene."""

    @property
    def tied_members(self) -> frozenset[str]:
        """Members that are one of several possible fields of their cell."""

    @property
    def heading(self) -> int | None:
        """Index of the state that may drift at rest, where there is one."""

    def faces_at(self, x: Floats) -> list[Face]:
        """Every face whose closure holds a state, cells last; none outside the domain."""

    def has_contact(self, x: Floats) -> bool:
        """Whether curved surfaces touch at a state, so that cells may lie there that no tangent cone shows."""

    def on_border(self, x: Floats) -> bool:
        """Whether a state lies on the border of the domain."""


class SwitchedField(FacedField, Protocol):
    """What it takes to follow a solution by events (faces), or a little late or smoothed (modes).

    A mode is a sign pattern or the number of a cell.  Its margin at a state is the distance to its nearest surface,
    negative outside.
    """

    def mode_at(self, x: Floats) -> Mode | None:
        """The mode at a state; None outside the domain."""

    def velocity(self, mode: Mode) -> Velocity:
        """The field of a mode."""

    def mode_name(self, mode: Mode) -> str:
        """What the mode is called."""

    def margin(self, mode: Mode, x: Floats) -> float:
        """Signed distance from the border of a mode (units of the state), positive inside."""

    def following(self, mode: Mode, x: Floats, width: float) -> Mode | None:
        """The mode after one has been left by ``width``; None outside the domain."""

    def blend(self, x: Floats, width: float) -> Iterator[tuple[Velocity, float]]:
        """Fields with convex weights that vary continuously over ``width`` to either side of a surface."""


# ---- tangent cones of sign patterns --------------------------------------------------------------
#
# On which sides of the surfaces through a state there are states.


# Relative to unit gradients: an open cone narrower than this is not told from an empty one.
CONE_SLACK = 1e-9
OF_ONE_SURFACE = ((0,), (-1,), (1,))  # its patterns, whatever its normal


def has_points(pattern: Sequence[int], normals: Sequence[Floats]) -> bool:
    """Whether the tangent cone ``n_k . d = 0`` (held), ``side n_k . d > 0`` (others) is not empty.

    By Gordan's theorem the open cone is empty iff a convex combination of the projected normals is zero.
    """
    held = [n for n, side in zip(normals, pattern, strict=True) if not side]
    others = [side * n for n, side in zip(normals, pattern, strict=True) if side]
    if held:
        basis = span(np.array(held).T)
        others = [n - basis @ (basis.T @ n) for n in others]
    return not others or origin_distance(np.array(others)) > CONE_SLACK


def sign_patterns(normals: Sequence[Floats]) -> tuple[tuple[int, ...], ...]:
    """Every pattern of -, 0, + of surfaces through a point whose tangent cone has points; most zeros first.

    One surface after the other: a pattern without points has none with a further sign.  In the plane n lines leave
    4 n + 1 patterns of 3^n.
    """
    if len(normals) == 1:
        return OF_ONE_SURFACE
    patterns: list[tuple[int, ...]] = [()]
    for count in range(1, len(normals) + 1):
        longer = [(*pattern, side) for pattern in patterns for side in (-1, 0, 1)]
        patterns = [p for p in longer if has_points(p, normals[:count])]
    return tuple(sorted(patterns, key=lambda p: (-p.count(0), p)))


def span(columns: Floats) -> Floats:
    """Orthonormal basis of the span of some columns."""
    basis, values, _ = np.linalg.svd(columns, full_matrices=False)
    return basis[:, values > CONE_SLACK]
