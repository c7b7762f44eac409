"""Feedback laws for rule ``nearest`` with both rows of wheel i and the roll row of wheel j: speeds from the pose.

With ``V = |c|^2 + l^2 theta^2`` (c from the equilibrium at the origin, l a length) and ``xi = g_i u_i + g_j u_j`` the
rate is ``V'/2 = a u_i + b u_j`` with ``a = (c, l^2 theta) . g_i``, ``b = (c, l^2 theta) . g_j``.

- *gradient*: ``u = -k (a, b)``, so ``V' = -2k (a^2 + b^2)`` (Jurdjevic & Quinn 1978, "L_g V"); also for other V;
- *printed*: ``u_j = -k l theta, u_i = |u_j| + k|c|``, for ``l = 1`` as Murphey & Burdick print it in sec. 3.3; it turns
  the body the wrong way where the torque of wheel j has the other sign;
- *corrected*: ``u_j = -g k l theta`` with g the sign of that torque;
- *cascade*: ``omega = -k theta`` and ``v = s k |c| d_i - (n_i . J p_i) omega n_i``, a sign s for each nearest wheel;
- *tangential*, for rims at right angles to ``p_i``: ``v = (k - omega) r J p_i/|p_i|`` and ``omega = k (s/l - Theta)``
  with ``(r, s) = (c . p_i, c . J p_i)/|p_i|`` and ``Theta = theta - s^2/(2 r l)``, so c runs around the equilibrium.

The last two impose a motion with ``n_i . v + (n_i . J p_i) omega = 0`` by ``u_w = d_w . (v + omega J p_w)``.

In every cell each speed of each law is k times a fixed combination of a few terms of the pose (:class:`LawKind`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from functools import partial
from operator import mul
from typing import SupportsFloat, TypeAlias

import numpy as np

from nonsmooth.analysis.fields.constant_field import Pose, Speeds
from nonsmooth.symbolic.mechanics.contact_states import ContactState, RowKind
from nonsmooth.symbolic.numbers.plane_arrays import turned

Coefficients: TypeAlias = tuple[float, ...]


class LawKind(StrEnum):
    """What the speeds are combinations of; the value says it."""

    GRADIENT = "X = (1 + e) x + f y, Y = f x + (1 - e) y, T = w theta + Y x - X y"
    CASCADE = "r = sqrt(x^2 + y^2), x, y, theta"
    PAPER = "r = sqrt(x^2 + y^2), h = |theta|, theta"
    SLOW_TURNS = "A = (1 - W) r, W = s/l - theta + s^2/(2 r l), where (r, s) is c along and across the nearest p_i"
    DRIVEN = "g . xi_l, g = (x, y, w theta), for the xi_l of the region with the largest |g . xi_l|"

    def terms(self, constants: Mapping[str, float], axes: Sequence[Coefficients], *pose: float) -> Sequence[float]:
        """The terms at a pose.

        Args:
            constants: e, f, w or l.
            axes: the direction of the nearest wheel (slow turns), or the twists xi_l (driven).
            pose: ``(x, y, theta)``.
        """
        x, y, theta = pose
        if self is LawKind.GRADIENT:
            e, f = constants["e"], constants["f"]
            along, across = (1 + e) * x + f * y, f * x + (1 - e) * y
            return along, across, constants["w"] * theta + across * x - along * y
        if self is LawKind.CASCADE:
            return math.hypot(x, y), x, y, theta
        if self is LawKind.PAPER:
            return math.hypot(x, y), abs(theta), theta
        if self is LawKind.SLOW_TURNS:
            ((a, b),) = axes
            r, s, length = a * x + b * y, a * y - b * x, constants["l"]
            turn = s / length - theta + (s * s / (2 * r * length) if r > 0 else 0.0)
            return (1 - turn) * r, turn
        products = np.array(axes) @ (x, y, constants["w"] * theta)
        chosen = int(np.argmax(np.abs(products)))
        return [-float(products[chosen]) * (k == chosen) for k in range(len(products))]


@dataclass(frozen=True, eq=False)
class CellLaw:
    """A law of rule ``nearest``: in every cell each speed is the gain times a combination of a few terms of the pose.

    Attributes:
        kind: what the terms are.
        gain: k.
        rows: of a contact state the coefficients of the terms for each wheel that acts; a ``ValueError`` where the law
            is none of these wheels.
        constants: of the terms.
    """

    kind: LawKind
    gain: float
    rows: Callable[[ContactState], Mapping[int, Coefficients]]
    constants: Mapping[str, float] = field(default_factory=dict)

    def axes(self, state: ContactState) -> tuple[Coefficients, ...]:
        """What the terms ask for beside the constants: of slow turns the direction of the nearest wheel."""
        return (_outward(state),) if self.kind is LawKind.SLOW_TURNS else ()

    def __call__(self, state: ContactState) -> Speeds:
        """The speeds from the pose, in the cells with a contact state."""
        rows, axes, gain = self.rows(state).items(), self.axes(state), self.gain
        terms_at = partial(self.kind.terms, self.constants, axes)

        def speeds(pose: Pose) -> Mapping[int, float]:
            terms = terms_at(*map(float, pose))
            return {wheel: gain * sum(map(mul, row, terms)) for wheel, row in rows}

        return speeds


def gradient_law(gain: float, shape: tuple[float, float] = (0.0, 0.0), weight: float = 1.0) -> CellLaw:
    """``u_w = -k (P c, w theta + P c . J c) . g_w`` for every wheel that acts.

    That is half the rate of ``V = c^T P c + w theta^2`` by u_w, under exact kinematics.

    Args:
        gain: k (1/time).
        shape: (e, f) of ``P = [[1 + e, f], [f, 1 - e]]``.
        weight: w (length^2).
    """

    def rows(state: ContactState) -> dict[int, Coefficients]:
        return {wheel: floats(-entry for entry in field) for wheel, field in state.control_fields.items()}

    e, f = shape
    return CellLaw(LawKind.GRADIENT, gain, rows, {"e": e, "f": f, "w": weight})


def printed_law(gain: float, length: float = 1.0) -> CellLaw:
    """``u_j = -k l theta, u_i = |u_j| + k|c|`` in every cell, with ``l = 1`` as printed.

    Args:
        gain: k (1/time).
        length: l, what a radian counts as.
    """
    return _paper_law(gain, length, corrected=False)


def corrected_law(gain: float, length: float = 1.0) -> CellLaw:
    """``u_j = -g k l theta, u_i = |u_j| + k|c|`` with g the sign of wheel j's torque in the cell.

    Args:
        gain: k (1/time).
        length: l, what a radian counts as.
    """
    return _paper_law(gain, length, corrected=True)


def _paper_law(gain: float, length: float, *, corrected: bool) -> CellLaw:
    def rows(state: ContactState) -> dict[int, Coefficients]:
        _require_two_inputs(state)
        nearest, second = state.rows[0].wheel.index, state.rows[2].wheel.index
        torque = state.control_fields[second][2]
        turn = -length * (torque.sign() if corrected else 1)
        return {nearest: (1.0, length, 0.0), second: (0.0, 0.0, turn)}

    return CellLaw(LawKind.PAPER, gain, rows)


def cascade_law(gain: float, signs: Mapping[int, int]) -> CellLaw:
    """Theta decays by itself, c runs along the rim of the nearest wheel (module ``cascade_law``).

    Where a wheel is nearest that is not nearest at the point, the law says nothing; there ``v . d = -k c . d``, which
    brings c nearer along the rim and is certified by nothing.

    Args:
        gain: k (1/time).
        signs: of the translation along the rim, by the number of the nearest wheel.
    """

    def rows(state: ContactState) -> dict[int, Coefficients]:
        wheel = state.rows[0].wheel
        d, p = np.array(floats(wheel.unit_direction)), np.array(floats(wheel.position))
        n = turned(d)
        lever, sign = float(n @ turned(p)), signs.get(wheel.index)
        found = {}
        for index, row in _roll_rows(state).items():
            along, turn = float(row[:2] @ d), lever * float(row[:2] @ n) - row[2]
            by_place = (0.0, -along * d[0], -along * d[1]) if sign is None else (sign * along, 0.0, 0.0)
            found[index] = floats((*by_place, turn))
        return found

    return CellLaw(LawKind.CASCADE, gain, rows)


def tangential_law(gain: float, length: float) -> CellLaw:
    """C runs around the equilibrium and comes nearer by turning to and fro, for rims at right angles to ``p_i``.

    Args:
        gain: k (1/time).
        length: l: the smaller, the more the body turns.
    """

    def rows(state: ContactState) -> dict[int, Coefficients]:
        across = turned(np.array(_outward(state)))
        return {index: (float(row[:2] @ across), row[2]) for index, row in _roll_rows(state).items()}

    return CellLaw(LawKind.SLOW_TURNS, gain, rows, {"l": length})


def _outward(state: ContactState) -> Coefficients:
    """The unit vector to the nearest wheel."""
    p = np.array(floats(state.rows[0].wheel.position))
    return floats(p / np.hypot(*p))


def _roll_rows(state: ContactState) -> dict[int, Coefficients]:
    """Of each wheel that acts ``u_w = row . (v, omega)``, for a motion which the nearest wheel's side row allows.

    With a side row in third place, as it may be away from the equilibrium, the nearest wheel alone does its part.
    """
    _require_a_pair(state)
    acting = [row for row in (state.rows[0], state.rows[2]) if row.kind is RowKind.ROLL]
    return {row.wheel.index: floats(row.unit_normal) for row in acting}


def floats(values: Iterable[SupportsFloat]) -> Coefficients:
    """Numbers in floats, zero without a sign."""
    return tuple(float(value) + 0.0 for value in values)


def _require_a_pair(state: ContactState) -> None:
    if not state.is_of_a_pair:
        raise ValueError(
            f"required both rows of one wheel and one of another (no row without friction), received {state.name}"
        )
    askew = [row.wheel.index for row in state.rows if row.wheel.axis is not None]
    if askew:
        raise ValueError(f"required friction axes along the rims, received another axis at wheel {askew[0]}")


def _require_two_inputs(state: ContactState) -> None:
    _require_a_pair(state)
    if state.rows[2].kind is not RowKind.ROLL:
        raise ValueError(f"required a roll row in third place (mu_side < mu_roll), received {state.name}")
