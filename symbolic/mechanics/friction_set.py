"""The friction forces that a wheel can carry: an ellipse, perhaps cut by a strip, or a box.

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

Under rule ``box`` they are ``|x| <= 1, |y| <= 1``: all slips lie at corners, ``D/N = |X| + |Y|``.

The formulas are written once, for exact numbers, balls of python-flint, floats, and arrays of floats or of intervals,
which hold the sets of many wheels.  Where it is not told to which piece a slip belongs, an interval holds the values of
both.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, fields
from enum import StrEnum
from functools import cached_property
from typing import Any, Generic, NamedTuple, Protocol, TypeAlias, cast

import numpy as np
from flint import arb

from nonsmooth.symbolic.mechanics.load_model import Three, X
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.plane_arrays import Floats, Mask


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

    def __init_subclass__(cls, **keywords: Any) -> None:
        """Refuse a shape that would be proved as an ellipse.

        Raises:
            TypeError: for another support with the pieces of the ellipse's border.
        """
        super().__init_subclass__(**keywords)
        if cls.support is not CutEllipse.support and cls.piece is CutEllipse.piece:
            raise TypeError(f"required piece, gradient, bend and holds_strictly of {cls.__name__}, or FloatShape")

    def map(self, number: Callable[[X], Any]) -> CutEllipse[Any]:
        """The same set in another arithmetic."""
        shape: type[CutEllipse[Any]] = type(self)
        return shape(number(self.along), number(self.across), number(self.cut))

    @property
    def is_cut(self) -> bool:
        """Whether the strip takes anything away; of one wheel."""
        return self.cut != 1 and bool(self.across != 0)

    @cached_property
    def is_whole(self) -> bool:
        """Whether no strip takes anything away; of arrays of floats."""
        return bool((self.cut == 1).all())

    @cached_property
    def corner(self) -> X:
        """``sqrt(1 - kappa^2)``: x at a corner."""
        return _root((1 - self.cut) * (1 + self.cut))

    @classmethod
    def units(cls, cut: Floats) -> CutEllipse[Any]:
        """The sets of n wheels in units of their half-axes, kappa (n,), for arrays (..., n)."""
        shape: type[CutEllipse[Any]] = cls
        return shape(1.0, 1.0, cut)

    @classmethod
    def searched(cls, cut: Floats) -> FrictionSets:
        """The same for minimizers, which ask for the nearest force of a set too; for points (2, n, m)."""
        return UnitDiscs(cut)

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
        return self._either(r, s, lambda: self.corner * abs(x) + self.cut * abs(y), lambda: self._length(x, y))

    def gradient(self, r: X, s: X) -> tuple[X, X]:
        """Its derivatives by r and s; in arrays some force of the set where none is determined.

        Raises:
            ValueError: for a slip of one wheel that determines no force, or balls that do not tell its piece.
        """
        x, y = self._weighted(r, s)
        rho = self._either(r, s, lambda: self.corner * _sign(x), lambda: x / _divisor(_length(x, y)))
        tau = self._either(r, s, lambda: self.cut * _sign(y), lambda: y / _divisor(_length(x, y)))
        return self.along * rho, self.across * tau

    def hessian(self, r: X, s: X) -> Three[X]:
        """Its second derivatives ``(rr, rs, ss)``; in arrays zero where there are none, of intervals all numbers.

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
        flat = 0 * x
        if _is_enclosure(x):  # where x may be zero D has an edge beside the corner
            flat = flat / x
        return self._either(r, s, lambda: flat, lambda: product * product / _divisor(_length(x, y)) ** 3)

    def holds_strictly(self, x: X, y: X) -> bool:
        """Whether ``(alpha x, beta y)`` lies inside, off the border; of balls whether it certainly does."""
        return bool(x * x + y * y < 1) and (not self.is_cut or bool(abs(y) < self.cut))

    def gauge(self, x: X, y: X) -> X:
        """By which factor the set must grow to hold ``(alpha x, beta y)`` on its border; of arrays of floats."""
        sizes = self._length(x, y)
        return sizes if self.is_whole else np.maximum(sizes, np.abs(y) / self.cut)

    def slip_cone(self, x: X, y: X, slack: float) -> tuple[Floats, Mask]:
        """Which slips go with a force of the set, ``-(alpha x, beta y)``: its normal cone; of arrays of floats (...).

        Inside the set none; on the arc a non-negative multiple of ``-(x, y)``; on a straight side one across against y;
        at a corner any between these two.

        Args:
            x: of the force.
            y: of the force.
            slack: a force so close to the border, in parts, counts as on it.

        Returns:
            two linear forms of ``(X, Y)``, shape (..., 2, 2), and which of them are zero, (..., 2); the others are at
            least zero.
        """
        slips, zero = np.hypot(x, y) >= 1 - slack, np.zeros_like(x)
        first = np.where(slips, [-x, -y], [zero + 1, zero])
        second = np.where(slips, [-y, x], [zero, zero + 1])
        equations = np.array([~slips, np.ones_like(slips)])
        if not self.is_whole:
            at_cut = (np.abs(y) >= (1 - slack) * self.cut) & (self.cut < 1)
            side, corner = at_cut & ~slips, at_cut & slips
            first = np.where(corner, [-np.sign(x), zero], first)
            second = np.where(side, [zero, -np.sign(y)], second)
            second = np.where(corner, [np.abs(y) * np.sign(x), -np.abs(x) * np.sign(y)], second)
            equations[1] &= ~at_cut
        return np.moveaxis(np.array([first, second]), (0, 1), (-2, -1)), np.moveaxis(equations, 0, -1)

    def room(self, x: X, y: X, turning: float) -> Floats:
        """How far a force of the set may move in each direction, symmetric matrices (n, 2, 2); of arrays of floats.

        Its slack; but a force on the arc may turn (by ``turning`` at least), since that lengthens it by the square
        only.  One at a cut moves along the cut, one at a corner not at all.
        """
        size, shares = np.hypot(x, y), np.column_stack([x, y])
        unit = shares / _divisor(size)[:, None]
        slack = 1 - np.minimum(size, 1.0)[:, None, None]
        along = unit[:, :, None] * unit[:, None, :]
        room = slack * along + np.maximum(slack, turning) * (np.eye(2) - along)
        if not self.is_whole:
            to_cut = np.where(self.cut < 1, 1 - np.minimum(np.abs(y) / self.cut, 1.0), 1.0)
            narrow = np.column_stack([np.maximum(to_cut, slack[:, 0, 0]), to_cut])
            room *= narrow[:, :, None] * narrow[:, None, :]
        return np.asarray(room)

    def rounded_arc(self, r: X, s: X, third: X) -> Three[X]:
        """Lengths ``sqrt(X^2 + Y^2 + Z^2)`` of slips with a third part Z, and ``X`` and ``Y`` over them."""
        x, y = self._weighted(r, s)
        size = self._length(self._length(x, y), third)
        return size, x / size, y / size

    def rounded_gradient(self, r: X, s: X, third: X) -> tuple[X, X]:
        """Forces inside the sets: the gradient of the support function of a slip with a third part; arrays of floats.

        The third part Z rounds the edges of D where slips vanish: ``sqrt(X^2 + Y^2 + Z^2)`` on the arc,
        ``sqrt(1 - kappa^2) sqrt(X^2 + Z^2) + kappa |Y|`` at a corner.
        """
        _, rho, tau = self.rounded_arc(r, s, third)
        if self.is_whole:
            return self.along * rho, self.across * tau
        x = self.along * r
        rho = np.where(np.abs(tau) > self.cut, self.corner * x / _length(x, third), rho)
        return self.along * rho, self.across * np.clip(tau, -self.cut, self.cut)

    def rounded_hessian(self, r: X, s: X, third: X) -> Three[X]:
        """The derivatives ``(rr, rs, ss)`` of that.

        At a corner the one across is of ``kappa sqrt(Y^2 + Z^2)``: D is straight there, but Newton's method must not
        lose where that begins.
        """
        size, rho, tau = self.rounded_arc(r, s, third)
        rr, rs, ss = (1 - rho * rho) / size, -rho * tau / size, (1 - tau * tau) / size
        if not self.is_whole:
            (x, y), turns = self._weighted(r, s), np.abs(tau) > self.cut
            rr = np.where(turns, self.corner * _rounded_bend(x, third), rr)
            rs = np.where(turns, 0.0, rs)
            ss = np.where(turns, self.cut * _rounded_bend(y, third), ss)
        return self.along**2 * rr, self.along * self.across * rs, self.across**2 * ss

    def _length(self, x: Any, y: Any) -> Any:
        return _length(x, y)

    def _weighted(self, r: Any, s: Any) -> tuple[Any, Any]:
        return self.along * r, self.across * s

    def _excess(self, x: Any, y: Any) -> Any:
        """Positive at a corner, negative on the arc."""
        if _is_enclosure(x):  # a whole ellipse has no corner, wherever a slip may be
            return (self.corner * abs(y) - self.cut * abs(x)).below_zero(self.cut.is_one)
        if _is_float(x):  # squares would overflow
            return self.corner * abs(y) - self.cut * abs(x)
        square = self.cut * self.cut
        return (1 - square) * y * y - square * x * x

    def _either(self, r: X, s: X, corner: Callable[[], Any], arc: Callable[[], Any]) -> Any:
        """What holds at a corner, or what holds on the arc."""
        x, y = self._weighted(r, s)
        if isinstance(x, np.ndarray):
            return arc() if self.is_whole else np.where(self._excess(x, y) > 0, corner(), arc())
        if _is_enclosure(x):
            return self._excess(x, y).by_sign(corner(), arc())
        piece = self.piece(r, s)
        if piece in (BorderPiece.KINK, BorderPiece.OPEN):
            raise ValueError("required slips that determine a force, received others")
        return corner() if piece is BorderPiece.CORNER else arc()


class Box(CutEllipse[X]):
    """``|x| <= 1, |y| <= 1``, in numbers whose ``cut`` is one; slips are at corners, unless they are along an axis."""

    @property
    def is_cut(self) -> bool:
        """Two strips meet in it."""
        return True

    @property
    def is_whole(self) -> bool:
        """So it is no ellipse."""
        return False

    @property
    def corner(self) -> X:
        """One, as the cut."""
        return self.cut

    def piece(self, r: X, s: X) -> BorderPiece:
        """A corner, but for slips along an axis."""
        signs = [_sign(entry) for entry in self._weighted(r, s)]
        kink = BorderPiece.KINK if 0 in signs else BorderPiece.CORNER
        return BorderPiece.OPEN if None in signs else kink

    def support(self, r: X, s: X) -> X:
        """``D/N = |X| + |Y|``."""
        x, y = self._weighted(r, s)
        return abs(x) + abs(y)

    def holds_strictly(self, x: X, y: X) -> bool:
        """As of the ellipse."""
        return bool(abs(x) < 1) and bool(abs(y) < 1)

    def gauge(self, x: X, y: X) -> X:
        """As of the ellipse."""
        return np.maximum(np.abs(x), np.abs(y))

    def slip_cone(self, x: X, y: X, slack: float) -> tuple[Floats, Mask]:
        """As of the ellipse, each direction on its own."""
        force = np.stack([x, y], axis=-1)
        at_limit = np.abs(force) >= 1 - slack
        return np.where(at_limit, -np.sign(force), 1.0)[..., None] * np.eye(2), ~at_limit

    def room(self, x: X, y: X, turning: float) -> Floats:
        """The slack in each direction."""
        return np.asarray((1 - np.minimum(np.abs(np.column_stack([x, y])), 1.0))[..., None] * np.eye(2))

    def rounded_gradient(self, r: X, s: X, third: X) -> tuple[X, X]:
        """That of ``alpha sqrt(r^2 + w^2) + beta sqrt(s^2 + w^2)`` with ``w = Z/alpha``."""
        width = third / self.along
        return self.along * r / _length(r, width), self.across * s / _length(s, width)

    def rounded_hessian(self, r: X, s: X, third: X) -> Three[X]:
        """Its derivatives ``(rr, rs, ss)``."""
        width = third / self.along
        return self.along * _rounded_bend(r, width), r - r, self.across * _rounded_bend(s, width)

    def _excess(self, x: Any, y: Any) -> Any:
        return np.ones_like(x)  # gradient and bend of arrays take it


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


class Approach(NamedTuple):
    """How a force nears that of a slip while the slip changes: ``dp = move + A dr``; of arrays (...).

    Attributes:
        move: its entries.
        slopes: of A, by rows.
        bearing: ``(a, b)`` of the rollers' speeds, ``dt = a + b dp_2``; None where nothing is cut.
    """

    move: tuple[Floats, Floats]
    slopes: tuple[Floats, Floats, Floats, Floats]
    bearing: tuple[Floats, Floats] | None

    @property
    def rates(self) -> Floats:
        """The symmetric part of A, entries ``(xx, yy, xy)``, shape (3, ...)."""
        a00, a01, a10, a11 = self.slopes
        return np.array([a00, a11, (a01 + a10) / 2])

    def change(self, r: Floats, s: Floats) -> Floats:
        """``dp``, shape (2, ...), where the slip changes by (r, s)."""
        (d0, d1), (a00, a01, a10, a11) = self.move, self.slopes
        return np.array([d0 + a00 * r + a01 * s, d1 + a10 * r + a11 * s])

    def turned(self, change: Floats) -> Floats | float:
        """``dt``, where the force changes by dp."""
        return 0.0 if self.bearing is None else self.bearing[0] + self.bearing[1] * change[1]


class FrictionSets(Protocol):
    """The sets of n contacts in units of their half-axes, arrays of shape (n, m) in and out."""

    def support(self, r: Floats, s: Floats) -> Floats:
        """``max p . (r, s)`` over the set."""

    def nearest(self, x: Floats, y: Floats) -> NearestForce:
        """The nearest points of the sets, and how they move."""

    def excess(self, x: Floats, y: Floats) -> Floats:
        """How far, in parts, a point must shrink towards zero to lie in the set; at most zero inside."""


class UnitDiscs(CutEllipse[Any]):
    """The sets of many wheels in units of their half-axes: discs of radius one that strips cut; floats of order one."""

    def __init__(self, cuts: Floats) -> None:
        """For kappa (n,) and points of shape (2, n, m), or kappa and points of shapes that go together."""
        super().__init__(1.0, 1.0, cuts[:, None] if cuts.ndim == 1 else cuts)

    def excess(self, x: Floats, y: Floats) -> Floats:
        """How far beyond its set a force lies, in parts of it; at most 0 inside."""
        return np.asarray(self.gauge(x, y) - 1)

    def _weighted(self, r: Any, s: Any) -> tuple[Any, Any]:
        return r, s

    def _length(self, x: Any, y: Any) -> Any:
        return np.sqrt(x * x + y * y)

    def nearest(self, x: Floats, y: Floats) -> NearestForce:
        """The nearest forces of the sets."""
        rate = 1 / np.maximum(np.sqrt(x * x + y * y), 1.0)
        force = np.array([x * rate, y * rate])
        normal = np.where(rate < 1, force, 0.0)
        if self.is_whole:
            return NearestForce(force, rate, normal)
        beyond = np.abs(y) > self.cut
        side = beyond & (np.abs(x) < self.corner)
        corner = beyond & ~side & (self.corner * np.abs(y) > self.cut * np.abs(x))
        bound = side | corner
        force[0] = np.where(side, x, np.where(corner, np.sign(x) * self.corner, force[0]))
        force[1] = np.where(bound, np.sign(y) * self.cut, force[1])
        normal[0], normal[1] = np.where(bound, 0.0, normal[0]), np.where(bound, side, normal[1])
        return NearestForce(force, np.where(bound, side, rate), normal)

    def rounded_arc(self, r: Floats, s: Floats, third: Floats | float) -> tuple[Floats, Floats, Floats]:
        """In one root."""
        size = np.sqrt(r * r + s * s + third * third)
        return size, r / size, s / size

    def rounded_support(self, r: Floats, s: Floats, turning: Floats, third: Floats | float) -> Floats:
        """``sqrt(r^2 + (s - t)^2 + Z^2) + kappa sqrt(t^2 + Z^2)``: least by the speed t of its rollers, the support."""
        size = self._length(self._length(r, s - turning), third)
        return np.asarray(size if self.is_whole else size + self.cut * self._length(turning, third) * (self.cut < 1))

    def rollers(self, r: Floats, s: Floats) -> Floats:
        """The speeds t of rollers at which that is least without a third part; zero where nothing is cut."""
        if self.is_whole:
            return np.zeros_like(s)
        turning = np.sign(s) * np.maximum(np.abs(s) - self.cut * np.abs(r) / _divisor(self.corner), 0.0)
        return np.where(self.cut < 1, turning, 0.0)

    def approach(
        self, slip: Sequence[Floats] | Floats, force: Floats, turning: Floats, third: Floats | float
    ) -> Approach:
        """A step of Newton's method towards the rounded force of a slip, with the force as an unknown of its own.

        On ``rho p = w``, ``w = (r, s - t)`` and ``rho = sqrt(|w|^2 + Z^2)`` (Chan, Golub and Mulet 1999).  The force
        across is that of the rollers' bearing, too, ``sqrt(t^2 + Z^2) p_2 = kappa t``; linearized it gives
        ``dt = a + b dp_2``, which is taken out.
        """
        z0, z1 = force
        size, u0, u1 = self.rounded_arc(slip[0], slip[1] - turning, third)
        # dp = d + A dr with A = (1 - p u^T)/size and d = u - p
        d0, d1 = u0 - z0, u1 - z1
        a00, a01, a10, a11 = (1 - z0 * u0) / size, -z0 * u1 / size, -z1 * u0 / size, (1 - z1 * u1) / size
        if self.is_whole:
            return Approach((d0, d1), (a00, a01, a10, a11), None)
        cut, bearing = self.cut < 1, self._length(turning, third)
        room = np.where(cut, self.cut - z1 * turning / bearing, 1.0)
        a = np.where(cut, (bearing * z1 - self.cut * turning) / room, 0.0)
        b = np.where(cut, bearing / room, 0.0)
        share = 1 / (1 + b * a11)
        d1 = (d1 - a11 * a) * share
        d0 = d0 - a01 * (a + b * d1)
        a10, a11 = a10 * share, a11 * share
        return Approach((d0, d1), (a00 - b * a01 * a10, a01 - b * a01 * a11, a10, a11), (a, b))

    def longest_step(self, force: Floats, change: Floats) -> Floats:
        """The largest t at which ``force + t change`` lies in its set, for forces in it."""
        (x, y), (dx, dy) = force, change
        square, product, slack = dx * dx + dy * dy, x * dx + y * dy, np.maximum(1 - x * x - y * y, 0.0)
        longest = np.where(square > 0, (np.sqrt(product * product + square * slack) - product) / square, np.inf)
        if self.is_whole:
            return longest
        return np.where(dy == 0, longest, np.minimum(longest, (np.sign(dy) * self.cut - y) / dy))


def joined(sets: Sequence[FrictionSet], array: Callable[[list[Number]], X]) -> CutEllipse[X]:
    """The sets of many wheels, of one shape, in arrays."""
    shape: Any = type(sets[0])
    return cast(CutEllipse[X], shape(*(array([getattr(each, entry.name) for each in sets]) for entry in fields(shape))))


def float_sets(sets: Iterable[FrictionSet]) -> CutEllipse[Any]:
    """The same, each exact number rounded once."""
    return joined(list(sets), lambda numbers: np.array([float(number) for number in numbers]))


# ---- arithmetics ---------------------------------------------------------------------------------


def _is_float(x: Any) -> bool:
    return isinstance(x, (float, np.ndarray, np.floating))


def _is_enclosure(x: Any) -> bool:
    """Whether these are intervals: they have no sign, but take both of two values where it is not told."""
    return hasattr(x, "by_sign")


def _root(x: Any) -> Any:
    return np.sqrt(x) if _is_float(x) else x.sqrt()


def _length(x: Any, y: Any) -> Any:
    if _is_float(x):
        return np.hypot(x, y)
    if _is_enclosure(x):
        return (x.square + y.square).sqrt()
    if not isinstance(x, arb) and not (x and y):  # no exact root is looked for where one is known
        return abs(x + y)
    return (x * x + y * y).sqrt()


def _rounded_bend(x: Any, width: Any) -> Any:
    """The second derivative of ``sqrt(x^2 + width^2)``."""
    return width**2 / _length(x, width) ** 3


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
