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
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TypeAlias

from nonsmooth.analysis.fields.cellwise_field import Pose, Speeds, StateLaw, control_columns
from nonsmooth.symbolic.mechanics.constraints import RowKind
from nonsmooth.symbolic.mechanics.contact_states import ContactState
from nonsmooth.symbolic.numbers.plane import dot, in_floats, turned

Imposed: TypeAlias = tuple[float, float, float]  # (v_x, v_y, omega)


def gradient_law(gain: float, shape: tuple[float, float] = (0.0, 0.0), weight: float = 1.0) -> StateLaw:
    """``u_w = -k (P c, w theta + P c . J c) . g_w`` for every wheel that acts.

    That is half the rate of ``V = c^T P c + w theta^2`` by u_w, under exact kinematics.

    Args:
        gain: k (1/time).
        shape: (e, f) of ``P = [[1 + e, f], [f, 1 - e]]``.
        weight: w (length^2).
    """
    e, f = shape

    def prepare(state: ContactState) -> Speeds:
        fields = control_columns(state)

        def speeds(pose: Pose) -> Mapping[int, float]:
            x, y, theta = map(float, pose)
            along, across = (1 + e) * x + f * y, f * x + (1 - e) * y
            turning = weight * theta + across * x - along * y
            return {wheel: -gain * (a * along + b * across + c * turning) for wheel, a, b, c in fields}

        return speeds

    return prepare


def printed_law(gain: float, length: float = 1.0) -> StateLaw:
    """``u_j = -k l theta, u_i = |u_j| + k|c|`` in every cell, with ``l = 1`` as printed.

    Args:
        gain: k (1/time).
        length: l, what a radian counts as.
    """
    return _paper_law(gain, length, corrected=False)


def corrected_law(gain: float, length: float = 1.0) -> StateLaw:
    """``u_j = -g k l theta, u_i = |u_j| + k|c|`` with g the sign of wheel j's torque in the cell.

    Args:
        gain: k (1/time).
        length: l, what a radian counts as.
    """
    return _paper_law(gain, length, corrected=True)


def cascade_law(gain: float, signs: Mapping[int, int]) -> StateLaw:
    """Theta decays by itself, c runs along the rim of the nearest wheel (module ``cascade_law``).

    Where a wheel is nearest that is not nearest at the point, the law says nothing; there ``v . d = -k c . d``, which
    brings c nearer along the rim and is certified by nothing.

    Args:
        gain: k (1/time).
        signs: of the translation along the rim, by the number of the nearest wheel.
    """

    def prepare(state: ContactState) -> Speeds:
        _require_a_pair(state)
        wheel = state.rows[0].wheel
        (d_x, d_y), (p_x, p_y) = in_floats(wheel.unit_direction), map(float, wheel.position)
        (n_x, n_y), sign = turned((d_x, d_y)), signs.get(wheel.index)
        lever = dot((n_x, n_y), turned((p_x, p_y)))

        def twist(x: float, y: float, theta: float) -> Imposed:
            omega = -gain * theta
            along = gain * (-x * d_x - y * d_y if sign is None else sign * math.hypot(x, y))
            across = -lever * omega
            return along * d_x + across * n_x, along * d_y + across * n_y, omega

        return _imposed(state, twist)

    return prepare


def tangential_law(gain: float, length: float) -> StateLaw:
    """C runs around the equilibrium and comes nearer by turning to and fro, for rims at right angles to ``p_i``.

    Args:
        gain: k (1/time).
        length: l: the smaller, the more the body turns.
    """

    def prepare(state: ContactState) -> Speeds:
        _require_a_pair(state)
        x_of, y_of = map(float, state.rows[0].wheel.position)
        out_x, out_y = x_of / math.hypot(x_of, y_of), y_of / math.hypot(x_of, y_of)

        def twist(x: float, y: float, theta: float) -> Imposed:
            r, s = x * out_x + y * out_y, y * out_x - x * out_y
            lead = s * s / (2 * r * length) if r > 0 else 0.0
            omega = gain * (s / length - (theta - lead))
            across = (gain - omega) * r
            return -across * out_y, across * out_x, omega

        return _imposed(state, twist)

    return prepare


def _imposed(state: ContactState, twist: Callable[[float, float, float], Imposed]) -> Speeds:
    """The speeds at which the wheels that act impose a twist which the nearest wheel's side row allows.

    With a side row in third place, as it may be away from the equilibrium, the nearest wheel alone does its part.
    """
    acting = [row for row in (state.rows[0], state.rows[2]) if row.kind is RowKind.ROLL]
    rows = [(row.wheel.index, tuple(map(float, row.unit_normal))) for row in acting]

    def speeds(pose: Pose) -> Mapping[int, float]:
        v_x, v_y, omega = twist(*map(float, pose))
        return {wheel: a * v_x + b * v_y + c * omega for wheel, (a, b, c) in rows}

    return speeds


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


def _paper_law(gain: float, length: float, *, corrected: bool) -> StateLaw:
    def prepare(state: ContactState) -> Speeds:
        _require_two_inputs(state)
        nearest, second = state.rows[0].wheel.index, state.rows[2].wheel.index
        torque = state.control_fields[second][2]
        turn = -gain * length * (torque.sign() if corrected else 1)

        def speeds(pose: Pose) -> Mapping[int, float]:
            steer = turn * float(pose[2])
            return {nearest: abs(steer) + gain * math.hypot(pose[0], pose[1]), second: steer}

        return speeds

    return prepare
