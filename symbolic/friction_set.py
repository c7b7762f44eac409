"""The friction forces that a wheel can carry under a rule without cells: an ellipse, perhaps cut by a strip.

For a wheel with normal force N these are, along and across its rim ::

    N (alpha x, beta y)    with    x^2 + y^2 <= 1,    |y| <= kappa,    0 < kappa <= 1

With slips ``(r, s)``, ``X = alpha r`` and ``Y = beta s`` the power that they take is the support function ::

    D/N = sqrt(X^2 + Y^2)                            where (1 - kappa^2) Y^2 <= kappa^2 X^2     (on the arc)
    D/N = sqrt(1 - kappa^2) |X| + kappa |Y|          elsewhere                                  (at a corner)

Its gradient is minus the force per unit of load, its Hessian how that turns with the slip ::

    arc        (alpha X, beta Y)/f                                        (alpha beta)^2/f^3 [s^2, -r s; -r s, r^2]
    corner     (alpha sqrt(1 - kappa^2) sgn r, beta kappa sgn s)          0

So it is continuously differentiable where ``r != 0``, twice where moreover the two pieces do not meet.  For
``kappa = 1``, the whole ellipse, there are no corners.

The formulas are written once, for exact numbers, balls of python-flint, floats, and arrays of floats, which hold the
sets of many wheels.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property
from typing import Any, Generic, NamedTuple, TypeAlias, TypeVar

import numpy as np
from flint import arb
from numpy.typing import NDArray

from nonsmooth.symbolic.numbers.number import Number

Floats: TypeAlias = NDArray[np.float64]
X = TypeVar("X", bound=Any)  # numbers of one arithmetic


class BorderPiece(StrEnum):
    """Where on the border of the set the force of a slip lies."""

    ARC = "on the arc"
    CORNER = "at a corner"
    KINK = "not determined"  # no slip, or a slip across a straight side
    SEAM = "where arc and corner meet"
    OPEN = "not told by balls"


@dataclass(frozen=True)
class CutEllipse(Generic[X]):
    """The set of one wheel per unit of normal force; in arrays, shape (n,), the sets of n wheels.

    Attributes:
        along: alpha, at least 0.
        across: beta, at least 0.
        cut: kappa, above 0 and at most 1.
    """

    along: X
    across: X
    cut: X

    def map(self, number: Callable[[X], Any]) -> CutEllipse[Any]:
        """The same set in another arithmetic."""
        return CutEllipse(number(self.along), number(self.across), number(self.cut))

    @property
    def is_cut(self) -> bool:
        """Whether the strip takes anything away; of one wheel."""
        return self.cut != 1 and bool(self.across != 0)

    @cached_property
    def corner(self) -> X:
        """``sqrt(1 - kappa^2)``: x at a corner."""
        return _root((1 - self.cut) * (1 + self.cut))

    def piece(self, r: X, s: X) -> BorderPiece:
        """Where the force of slips r along and s across lies, of one wheel."""
        x, y = self._weighted(r, s)
        signs = _sign(x), _sign(y)
        if self.is_cut and signs[0]:
            excess = _sign(self._excess(x, y))
            pieces = (BorderPiece.ARC, BorderPiece.SEAM, BorderPiece.CORNER)
            return BorderPiece.OPEN if excess is None else pieces[int(excess) + 1]
        if not self.is_cut and any(signs):
            return BorderPiece.ARC
        return BorderPiece.OPEN if None in signs[: 1 if self.is_cut else 2] else BorderPiece.KINK

    def support(self, r: X, s: X) -> X:
        """``D/N``."""
        x, y = self._weighted(r, s)
        return self._either(r, s, lambda: self.corner * abs(x) + self.cut * abs(y), lambda: _length(x, y))

    def gradient(self, r: X, s: X) -> tuple[X, X]:
        """Its derivatives by r and s; in arrays some force of the set where none is determined.

        Raises:
            ValueError: for a slip of one wheel that determines no force, or balls that do not tell its piece.
        """
        x, y = self._weighted(r, s)
        rho = self._either(r, s, lambda: self.corner * _sign(x), lambda: x / _divisor(_length(x, y)))
        tau = self._either(r, s, lambda: self.cut * _sign(y), lambda: y / _divisor(_length(x, y)))
        return self.along * rho, self.across * tau

    def hessian(self, r: X, s: X) -> tuple[X, X, X]:
        """Its second derivatives ``(rr, rs, ss)``; in arrays zero where there are none.

        Raises:
            ValueError: as for the gradient.
        """
        bend = self.bend(r, s)
        return bend * s * s, -bend * r * s, bend * r * r

    def bend(self, r: X, s: X) -> X:
        """The factor of ``(s, -r) (s, -r)^T`` in the Hessian.

        Raises:
            ValueError: as for the gradient.
        """
        (x, y), product = self._weighted(r, s), self.along * self.across
        return self._either(r, s, lambda: 0 * x, lambda: product * product / _divisor(_length(x, y)) ** 3)

    def holds_strictly(self, x: X, y: X) -> bool:
        """Whether ``(alpha x, beta y)`` lies inside, off the border; of balls whether it certainly does."""
        return bool(x * x + y * y < 1) and (not self.is_cut or bool(abs(y) < self.cut))

    def _weighted(self, r: Any, s: Any) -> tuple[Any, Any]:
        return self.along * r, self.across * s

    def _excess(self, x: Any, y: Any) -> Any:
        """Positive at a corner, negative on the arc."""
        if _is_float(x):  # squares would overflow
            return self.corner * abs(y) - self.cut * abs(x)
        square = self.cut * self.cut
        return (1 - square) * y * y - square * x * x

    def _either(self, r: X, s: X, corner: Callable[[], Any], arc: Callable[[], Any]) -> Any:
        """What holds at a corner, or what holds on the arc."""
        x, y = self._weighted(r, s)
        if isinstance(x, np.ndarray):
            return np.where(self._excess(x, y) > 0, corner(), arc())
        piece = self.piece(r, s)
        if piece in (BorderPiece.KINK, BorderPiece.OPEN):
            raise ValueError("required slips that determine a force, received others")
        return corner() if piece is BorderPiece.CORNER else arc()


FrictionSet: TypeAlias = CutEllipse[Number]


class NearestForce(NamedTuple):
    """The point of a plane convex set that is nearest to a given one, and how it moves with it; of arrays (...).

    Its derivative is ``rate (1 - normal normal^T)``: the identity inside (no normal), along the border where that is
    smooth, and nothing at a corner.

    Attributes:
        force: the point, shape (2, ...).
        rate: shape (...).
        normal: shape (2, ...).
    """

    force: Floats
    rate: Floats
    normal: Floats

    @property
    def rates(self) -> Floats:
        """The derivative's entries ``(xx, yy, xy)``, shape (3, ...)."""
        x, y = self.normal
        return np.array([self.rate * (1 - x * x), self.rate * (1 - y * y), -self.rate * x * y])

    def along(self, change: Floats) -> Floats:
        """The derivative times a change of the given point, shape (2, ...)."""
        x, y = self.normal
        return np.asarray(self.rate * (change - self.normal * (x * change[0] + y * change[1])))


class UnitDiscs:
    """The sets of many wheels in units of their half-axes: discs of radius one that strips cut; floats of order one.

    Attributes:
        cuts: kappa, shape (n, 1), for points of shape (2, n, m).
        whole: whether no strip takes anything away.
    """

    def __init__(self, cuts: Floats) -> None:
        self.cuts, self.whole = cuts[:, None], bool((cuts == 1).all())
        self._corner = np.sqrt((1 - self.cuts) * (1 + self.cuts))

    def support(self, r: Floats, s: Floats) -> Floats:
        """``max p . (r, s)`` over the set."""
        arc = np.sqrt(r * r + s * s)
        if self.whole:
            return arc
        r, s = np.abs(r), np.abs(s)
        return np.where(self._corner * s > self.cuts * r, self._corner * r + self.cuts * s, arc)

    def excess(self, x: Floats, y: Floats) -> Floats:
        """How far beyond its set a force lies, in parts of it; at most 0 inside."""
        sizes = np.sqrt(x * x + y * y)
        return (sizes if self.whole else np.maximum(sizes, np.abs(y) / self.cuts)) - 1

    def nearest(self, x: Floats, y: Floats) -> NearestForce:
        """The nearest forces of the sets."""
        rate = 1 / np.maximum(np.sqrt(x * x + y * y), 1.0)
        force = np.array([x * rate, y * rate])
        normal = np.where(rate < 1, force, 0.0)
        if self.whole:
            return NearestForce(force, rate, normal)
        beyond = np.abs(y) > self.cuts
        side = beyond & (np.abs(x) < self._corner)
        corner = beyond & ~side & (self._corner * np.abs(y) > self.cuts * np.abs(x))
        bound = side | corner
        force[0] = np.where(side, x, np.where(corner, np.sign(x) * self._corner, force[0]))
        force[1] = np.where(bound, np.sign(y) * self.cuts, force[1])
        normal[0], normal[1] = np.where(bound, 0.0, normal[0]), np.where(bound, side, normal[1])
        return NearestForce(force, np.where(bound, side, rate), normal)

    def longest_step(self, force: Floats, change: Floats) -> Floats:
        """The largest t at which ``force + t change`` lies in its set, for forces in it."""
        (x, y), (dx, dy) = force, change
        square, product, slack = dx * dx + dy * dy, x * dx + y * dy, np.maximum(1 - x * x - y * y, 0.0)
        longest = np.where(square > 0, (np.sqrt(product * product + square * slack) - product) / square, np.inf)
        if self.whole:
            return longest
        return np.where(dy == 0, longest, np.minimum(longest, (np.sign(dy) * self.cuts - y) / dy))


def float_sets(sets: Iterable[FrictionSet]) -> CutEllipse[Any]:
    """The sets of many wheels as arrays, each exact number rounded once."""
    entries = np.array([[float(each.along), float(each.across), float(each.cut)] for each in sets])
    return CutEllipse(*entries.T)


# ---- arithmetics ---------------------------------------------------------------------------------


def _is_float(x: Any) -> bool:
    return isinstance(x, (float, np.ndarray, np.floating))


def _root(x: Any) -> Any:
    return np.sqrt(x) if _is_float(x) else x.sqrt()


def _length(x: Any, y: Any) -> Any:
    if _is_float(x):
        return np.hypot(x, y)
    if not isinstance(x, arb) and not (x and y):  # no exact root is looked for where one is known
        return abs(x + y)
    return (x * x + y * y).sqrt()


def _divisor(size: Any) -> Any:
    """One in place of the zeros of an array, whose quotients are not used."""
    return np.where(size == 0, 1.0, size) if isinstance(size, np.ndarray) else size


def _sign(x: Any) -> Any:
    """The sign of a number; None where a ball does not tell."""
    if _is_float(x):
        return np.sign(x)
    if isinstance(x, arb):
        return 1 if x > 0 else -1 if x < 0 else 0 if x.is_zero() else None
    return x.sign()
