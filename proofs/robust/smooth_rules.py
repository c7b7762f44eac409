"""Rules ``ellipse`` and ``roller`` over a box of parameters: one equilibrium nearby for every array, which attracts.

With g the gradient of D in the twist (force and moment), an equilibrium is a zero of ``F(c, omega) = g(xi; c)`` at the
twist of a body that turns about its own centre, ``xi = (omega c_y, -omega c_x, omega)``.  Krawczyk's operator ::

    K(Z) = z_0 - Y F(z_0; Q) + (1 - Y F'(Z; Q))(Z - z_0)

maps the box Z into its interior only where, for every array of the box Q, Z holds exactly one zero.  About it, to first
order, ``c' = A c`` with ``A = V + omega J + (J c) w^T``, ``(V; w) = -(dg/dxi)^-1 dg/dc``.  Where dg/dxi is positive
definite, the trace of A negative and its determinant positive, all over Z and Q, each of these equilibria attracts
exponentially.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import TypeAlias

import numpy as np
from flint import arb, arb_mat, ctx

from nonsmooth.analysis.contact_rule import smooth_rule_of
from nonsmooth.proofs.robust.load_box import LoadBox, load_box
from nonsmooth.proofs.robust.wheel_force import HAS_ROLLERS, LOAD, TWIST, WheelBox
from nonsmooth.symbolic.numbers.enclosures import rational_below
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.tolerances import Tolerance

PRECISION = 64  # bits of the balls
INFLATIONS = 12  # of the box Z
GROWTH = 1.125  # of the image of the box, which is the next one
LEAST = 2.0**-50  # of its half-widths
NEWTON_STEPS = 20  # in floats, to the middle of the box, at most
DONE = LEAST / 16  # a step that moves the middle no more

Matrix: TypeAlias = list[list[arb]]


@dataclass(frozen=True)
class EquilibriumBox:
    """Where the equilibria of all arrays are.

    Attributes:
        squared: bound of ``|c|^2``.
        drift: bound of ``|omega|`` there (1/time).
    """

    squared: Fraction
    drift: Fraction


@dataclass(frozen=True)
class _Balance:
    """g and its slopes over a box: values (3), by the twist (3 x 3), by c (3 x 2), and what parameters add to g (3)."""

    value: list[arb]
    by_twist: Matrix
    by_place: Matrix
    spread: list[arb]


class _Springs:
    """All wheels and their loads."""

    def __init__(self, scene: Scene, box: Tolerance, loads: LoadBox, nominal: LoadBox) -> None:
        has_rollers = HAS_ROLLERS[scene.contact.rule]
        self._wheels = [WheelBox.of(wheel, box, has_rollers=has_rollers) for wheel in scene.wheels]
        self._loads, self._nominal = loads, nominal

    def balance(self, z: Sequence[arb], *, whole: bool) -> _Balance | None:
        """At places and spins ``z = (c_x, c_y, omega)``; None where a wheel may stick or lift off."""
        x, y, omega = z
        twist = (omega * y, -omega * x, omega)
        loads, middles = self._loads.at((x, y)), self._nominal.at((x, y))
        value, spread = [arb(0)] * 3, [arb(0)] * 3
        by_twist, by_place = [[arb(0)] * 3 for _ in range(3)], [[arb(0)] * 2 for _ in range(3)]
        for wheel, load, middle, form in zip(self._wheels, loads, middles, self._loads.forms, strict=True):
            wrench = wheel.wrench(twist, load if whole else middle, whole=whole)
            if wrench is None or not load > 0:
                return None
            sizes = [*wheel.sizes, abs(load - middle)]
            for k, entry in enumerate(wrench):
                value[k] += entry.value
                for j in range(TWIST):
                    by_twist[k][j] += entry.slopes[j]
                for j in range(2):
                    by_place[k][j] += entry.slopes[LOAD] * form[j + 1]
                for slope, size in zip(entry.slopes[TWIST:], sizes, strict=True):
                    spread[k] += slope * size * arb(0, 1)
        return _Balance(value, by_twist, by_place, spread)


def equilibrium_box(scene: Scene, box: Tolerance) -> EquilibriumBox | None:
    """The equilibria of all arrays of a box about a centred scene, where they are proved to attract; else None."""
    with ctx.workprec(PRECISION):
        loads, nominal = load_box(scene, box.position.ball()), load_box(scene, arb(0))
        start = _start(scene)
        if loads is None or nominal is None or start is None:
            return None
        springs = _Springs(scene, box, loads, nominal)
        middle = _newton(springs, start)
        return None if middle is None else _proved(springs, middle)


@lru_cache(maxsize=8)  # many boxes about one scene are asked for
def _start(scene: Scene) -> list[float] | None:
    """The point, and the spin of the minimizer there, in floats."""
    minima = smooth_rule_of(scene).minima(scene, np.zeros((1, 2)))
    omega = float(minima.twists[0, 2])
    return [0.0, 0.0, omega] if np.isfinite(omega) else None


def _newton(springs: _Springs, start: list[float]) -> list[float] | None:
    """An equilibrium of the scene itself, in floats; nothing rests on it but where the box lies."""
    z = np.array(start)
    for _ in range(NEWTON_STEPS):
        found = springs.balance([arb(float(entry)) for entry in z], whole=False)
        if found is None:
            return None
        slope = np.array([[float(entry) for entry in row] for row in _chained(found, [arb(float(e)) for e in z])])
        try:
            step = np.linalg.solve(slope, [float(entry) for entry in found.value])
        except np.linalg.LinAlgError:
            return None
        z -= step
        if not np.isfinite(z).all():
            return None
        if np.abs(step).max() <= DONE:
            break
    return [float(entry) for entry in z]


def _chained(balance: _Balance, z: Sequence[arb]) -> Matrix:
    """``F'``: by c and omega, through the twist and through the loads."""
    x, y, omega = z
    through = [[arb(0), omega, y], [-omega, arb(0), -x], [arb(0), arb(0), arb(1)]]  # of the twist by (c_x, c_y, omega)
    rows = []
    for k in range(3):
        row = [sum((balance.by_twist[k][m] * through[m][j] for m in range(3)), arb(0)) for j in range(3)]
        rows.append([row[0] + balance.by_place[k][0], row[1] + balance.by_place[k][1], row[2]])
    return rows


def _proved(springs: _Springs, middle: list[float]) -> EquilibriumBox | None:
    """Krawczyk's test, and the linearization, on a box that is inflated until it maps into itself."""
    centre = [arb(entry) for entry in middle]
    at_centre, over_box = springs.balance(centre, whole=False), springs.balance(centre, whole=True)
    if at_centre is None or over_box is None:
        return None
    inverse = _inverse(_chained(at_centre, centre))
    if inverse is None:
        return None
    offsets = [at_centre.value[k] + over_box.spread[k] for k in range(3)]
    shift = [-sum((inverse[k][m] * offsets[m] for m in range(3)), arb(0)) for k in range(3)]
    sizes = [GROWTH * abs(entry).upper() + LEAST for entry in shift]
    for _ in range(INFLATIONS):
        z = [entry + size * arb(0, 1) for entry, size in zip(centre, sizes, strict=True)]
        found = springs.balance(z, whole=True)
        if found is None:
            return None
        image = _krawczyk(inverse, _chained(found, z), shift, sizes)
        if all(abs(entry) < size for entry, size in zip(image, sizes, strict=True)):
            return _attracting(found, z)
        sizes = [GROWTH * abs(entry).upper() + LEAST for entry in image]
    return None


def _krawczyk(inverse: Matrix, slope: Matrix, shift: list[arb], sizes: list[arb]) -> list[arb]:
    """``K(Z) - z_0``."""
    image = []
    for k in range(3):
        total = shift[k]
        for j in range(3):
            entry = arb(int(j == k)) - sum((inverse[k][m] * slope[m][j] for m in range(3)), arb(0))
            total += entry * sizes[j] * arb(0, 1)
        image.append(total)
    return image


def _inverse(matrix: Matrix) -> Matrix | None:
    """About the inverse, in floats; None where there is none."""
    try:
        found = np.linalg.inv(np.array([[float(entry) for entry in row] for row in matrix]))
    except np.linalg.LinAlgError:
        return None
    return [[arb(float(entry)) for entry in row] for row in found]


def _attracting(balance: _Balance, z: Sequence[arb]) -> EquilibriumBox | None:
    """Bounds of the box, where A is Hurwitz all over it."""
    x, y, omega = z
    if not _is_positive_definite(balance.by_twist):
        return None
    response = _response(balance)
    if response is None:
        return None
    v, w = [[response[r, c] for c in range(2)] for r in range(2)], [response[2, c] for c in range(2)]
    a, b = v[0][0] - y * w[0], v[0][1] - omega - y * w[1]
    c, d = v[1][0] + omega + x * w[0], v[1][1] + x * w[1]
    if not (a + d < 0 and a * d - b * c > 0):
        return None
    return EquilibriumBox(-rational_below(-(x * x + y * y)), -rational_below(-abs(omega)))


def _response(balance: _Balance) -> arb_mat | None:
    """``(V; w) = -(dg/dxi)^-1 dg/dc``, shape 3 x 2, preconditioned by about the inverse."""
    inverse = _inverse(balance.by_twist)
    if inverse is None:
        return None
    near_identity, right = arb_mat(inverse) * arb_mat(balance.by_twist), arb_mat(inverse) * arb_mat(balance.by_place)
    try:
        return -near_identity.solve(right)
    except ZeroDivisionError:
        return None


def _is_positive_definite(matrix: Matrix) -> bool:
    """Sylvester's criterion for all symmetric matrices in a ball."""
    (a, b, c), (_, d, e), (_, _, f) = matrix
    minor = a * d - b * b
    whole = a * (d * f - e * e) - b * (b * f - e * c) + c * (b * e - d * c)
    return bool(a > 0 and minor > 0 and whole > 0)
