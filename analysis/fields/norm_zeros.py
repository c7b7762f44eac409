"""Where norms are zero that a field divides by: Filippov's motion that keeps to the place, and how it is left.

In unit control ``x' = a + B u`` with ``u = sigma/abs(sigma)`` and ``sigma = W x + w`` (Gutman 1979) the field jumps
where ``sigma = 0``: F holds what every u of at most unit length gives there, the hull of all unit vectors.  A motion
keeps to the place if ``W (a + B u) = 0`` has a solution with ``abs(u) <= 1``: Utkin's equivalent control (1992).
Elsewhere solutions leave it, as they begin with a unit vector with

    W a + W B u = r u,    r > 0,

since u turns infinitely fast there until that holds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from operator import mul

import numpy as np

from nonsmooth.analysis.fields.float_code import Numbers
from nonsmooth.analysis.fields.sign_field import SignField, Signs
from nonsmooth.analysis.fields.switched_field import (
    DifferentiatedVelocity,
    ScalarVelocity,
    Velocity,
    differences,
    length,
)
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from nonsmooth.symbolic.numbers.polynomial import Polynomial

RANK = 1e-9  # of the largest singular value: smaller ones are zero
OPEN = 1e-9  # of an equation that a control may leave open, relative to what it has to balance


@dataclass(frozen=True, eq=False)
class NormZero:
    """The places ``W x + w = 0`` at which the norm ``s = abs(W x + w)`` is zero.

    Attributes:
        name: of the norm.
        rows: W, shape (k, n), of rank k.
        offset: w, shape (k,).
    """

    name: str
    rows: Floats
    offset: Floats

    @cached_property
    def columns(self) -> Floats:
        """The shortest motions, shape (n, k), of unit speed in each entry of sigma."""
        return np.asarray(np.linalg.pinv(self.rows))

    def sigma(self, x: Floats) -> Floats:
        """The vector of which s is the length."""
        return np.asarray(self.rows @ x + self.offset)

    def size(self, *x: float) -> float:
        """The norm s at a state."""
        return math.hypot(*[sum(map(mul, row, x), w) for row, w in self._listed])

    @cached_property
    def _listed(self) -> list[tuple[list[float], float]]:
        return list(zip(self.rows.tolist(), self.offset.tolist(), strict=True))


def norm_zero(square: Polynomial, name: str) -> NormZero:
    """The zeros of the root of a sum of squares of affine functions, under its name."""
    slopes = [square.derivative(name) for name in square.variables]
    hessian = np.array(
        [[float(slope.derivative(name).constant_value or 0) for name in slope.variables] for slope in slopes]
    )
    values, vectors = np.linalg.eigh(hessian / 2)
    kept = values > RANK * values.max(initial=0.0)
    rows = np.sqrt(values[kept])[:, None] * vectors[:, kept].T
    gradient = [
        float(slope([slope.field.zero] * len(slopes))) for slope in slopes
    ]  # at the origin: twice the transpose of W
    return NormZero(name, rows, np.linalg.pinv(rows).T @ gradient / 2)


class NormVelocity(DifferentiatedVelocity):
    """A field with norms, beside their zeros.

    Args:
        rates: from the states and what is named in formulas, affine in each norm s and 1/s.
        values: of the names, from the states.
        sizes: the numbers of the names of s, with s.
        inverses: the numbers of those of 1/s, with s.
    """

    def __init__(
        self,
        rates: Callable[..., Numbers],
        values: Callable[..., Numbers],
        sizes: Mapping[int, NormZero],
        inverses: Mapping[int, NormZero],
    ) -> None:
        self._rates, self._values, self._sizes, self._inverses = rates, values, sizes, inverses
        super().__init__(lambda *x: rates(*x, *values(*x)))

    def derivatives(self, x: Floats, steps: Floats) -> Floats:
        """By the chain rule: those of a norm are ``sigma W/s``."""
        known = list(self._values(*x.tolist()))
        held = {k: known[k] for k in (*self._sizes, *self._inverses)}

        def with_norms(place: Floats, norms: Mapping[int, float]) -> Floats:
            values = {**dict(enumerate(self._values(*place.tolist()))), **norms}
            return np.array(self._rates(*place.tolist(), *[values[k] for k in range(len(known))]))

        found = differences(lambda place: with_norms(place, held), x, steps)
        for k, zero in (*self._sizes.items(), *self._inverses.items()):
            slope = with_norms(x, {**held, k: 1.0}) - with_norms(x, {**held, k: 0.0})
            sigma = zero.sigma(x)
            along = sigma @ zero.rows / (length(sigma) or 1.0)
            found += np.outer(slope, along if k in self._sizes else -along * held[k] ** 2)
        return found


class HeldVelocity(ScalarVelocity):
    """The velocity that keeps to zeros of norms, beyond its domain with a control that is too large.

    Args:
        zeros: the places.
        alone: a, from a state.
        slopes: D, shape (places, n, n): a displacement d, of which u is ``W d``, adds ``D d`` to the rates.
    """

    def __init__(
        self, zeros: Sequence[NormZero], alone: Callable[[Floats], Floats], slopes: Callable[[Floats], Floats]
    ) -> None:
        self._alone, self._slopes, self._zeros = alone, slopes, zeros
        self._rows = np.vstack([zero.rows for zero in zeros])
        ends = np.cumsum([len(zero.rows) for zero in zeros])
        self._blocks = [slice(int(end) - len(zero.rows), int(end)) for zero, end in zip(zeros, ends, strict=True)]
        super().__init__(self._velocity)

    def _parts(self, x: Floats) -> tuple[Floats, Floats]:
        """The rates without control, a, and B at a state."""
        blocks = [slope @ zero.columns for slope, zero in zip(self._slopes(x), self._zeros, strict=True)]
        return self._alone(x), np.hstack(blocks)

    def _velocity(self, *x: float) -> Numbers:
        alone, inputs = self._parts(np.array(x))
        control = np.linalg.lstsq(self._rows @ inputs, -self._rows @ alone, rcond=RANK)[0]
        return tuple((alone + inputs @ control).tolist())

    def control(self, x: Floats) -> Floats | None:
        """The equivalent control; None where nothing keeps to the place."""
        alone, inputs = self._parts(x)
        matrix, drift = self._rows @ inputs, self._rows @ alone
        control = np.linalg.lstsq(matrix, -drift, rcond=RANK)[0]
        return np.asarray(control) if length(matrix @ control + drift) <= OPEN * length(drift) else None

    def lengths(self, x: Floats) -> list[float]:
        """Those of the vectors u, infinite where there are none."""
        control = self.control(x)
        return [math.inf if control is None else length(control[block]) for block in self._blocks]

    def margin(self, x: Floats) -> float:
        """How much the longest of the vectors u is shorter than one."""
        return 1 - max(self.lengths(x))

    def input_matrix(self, x: Floats) -> Floats:
        """``W B`` at a state."""
        return np.asarray(self._rows @ self._parts(x)[1])

    def outward_speed(self, x: Floats) -> float:
        """The largest speed at which sigma grows beside the place, whatever its direction, if it is one place.

        It is the maximum of ``u . (W a + W B u)`` over unit vectors: ``m + g . u/2`` with ``(m - S) u = g/2``, m at
        least the largest eigenvalue of ``S``, the symmetric part of ``W B``, and ``g = W a``.
        """
        alone, inputs = self._parts(x)
        matrix, drift = self._rows @ inputs, self._rows @ alone
        symmetric = (matrix + matrix.T) / 2
        shift, unit = _secular(symmetric, drift / 2, float(np.linalg.eigvalsh(symmetric).max()))
        return shift + float(drift @ unit) / 2

    def way_out(self, place: int, x: Floats) -> Floats:
        """The control with which solutions leave one of the places, while they keep to the others."""
        alone, inputs = self._parts(x)
        matrix, drift = self._rows @ inputs, self._rows @ alone
        left = np.zeros(len(drift), bool)
        left[self._blocks[place]] = True
        kept = np.linalg.pinv(matrix[~left][:, ~left])
        carried = matrix[left][:, ~left] @ kept
        own_matrix, own_drift = (
            matrix[left][:, left] - carried @ matrix[~left][:, left],
            drift[left] - carried @ drift[~left],
        )
        largest = max(0.0, float(np.linalg.eigvals(own_matrix).real.max()))
        _, unit = _secular(own_matrix, own_drift, largest)
        control = np.empty(len(drift))
        control[left] = unit / (length(unit) or 1.0)
        control[~left] = -kept @ (drift[~left] + matrix[~left][:, left] @ control[left])
        return control

    def leaving(self, place: int) -> ScalarVelocity:
        """The velocity of solutions that leave one of the places, as they begin."""

        def rates(*x: float) -> Numbers:
            state = np.array(x)
            alone, inputs = self._parts(state)
            return tuple((alone + inputs @ self.way_out(place, state)).tolist())

        return ScalarVelocity(rates)


def _secular(matrix: Floats, drift: Floats, least: float) -> tuple[float, Floats]:
    """The largest r above some number, and the unit vector u, with ``(r - M) u = g``.

    Where there is none, that number with the shortest vector, which is no longer than one.
    """
    from scipy.optimize import brentq

    def vector(shift: float) -> Floats:
        return np.asarray(np.linalg.lstsq(shift * np.eye(len(drift)) - matrix, drift, rcond=None)[0])

    most = least + length(drift) + float(np.abs(matrix).sum()) + abs(least)
    low = least + RANK * (most - least)
    if length(vector(low)) <= 1:
        return low, vector(low)
    shift = float(brentq(lambda r: length(vector(r)) - 1, low, 2 * most))
    return shift, vector(shift)


@dataclass(frozen=True, eq=False, kw_only=True)
class NormField(SignField):
    """A plain switched system that divides by norms.

    Attributes:
        zeros: of these norms.
        keeping: the field of the motions that keep to some of these places, by their numbers, and a width, that stands
            in denominators for a smaller norm, as the least number that counts does.
    """

    zeros: tuple[NormZero, ...]
    keeping: Callable[[tuple[int, ...], float], SignField]

    def leaving(self, held: tuple[int, ...], k: int) -> SignField:
        """The field of the motions that leave one of the places that were kept to."""
        field, place = self.keeping(held, 0.0), held.index(k)

        def flow(signs: Signs) -> Velocity:
            velocity = field.flow(signs)
            return velocity.leaving(place) if isinstance(velocity, HeldVelocity) else velocity

        return replace(field, flow=flow)
