"""Chains of masses with dry friction on a belt, solved in 40 digits: a reference for sliding on several surfaces.

``v_i' = -k_i x_i + sum_j c (x_j - x_i) - d_i v_i - F_i sign(v_i - b)`` over the neighbours j, rational numbers
throughout.  Each mass slips one way or the other or sticks to the belt, so two masses have nine modes with a linear
field each; its flow is the exponential of a matrix.  Events are the zeros of ``v_i - b`` (slip) and of
``F_i^2 - g_i^2`` (stick, g_i the other forces): bracketed by small steps in floats, located by bisection and secants in
40 digits.  Nothing of the program is used.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np

DIGITS = 40
STATES = (("x", "v"), ("y", "w"), ("z", "u"))
STEP = 0.004  # of the search for brackets: some hundredths of the shortest period
SERIES_ENDS = 1e-60  # size of the last term


@dataclass(frozen=True)
class StickSlip:
    """Numbers of all masses."""

    stiffness: tuple[Fraction, ...]
    coupling: Fraction
    damping: tuple[Fraction, ...]
    friction: tuple[Fraction, ...]
    belt: Fraction

    @property
    def masses(self) -> range:
        return range(len(self.stiffness))

    def neighbours(self, k: int) -> list[int]:
        return [j for j in (k - 1, k + 1) if j in self.masses]

    def formulas(self) -> list[str]:
        """Right-hand sides in the states x, v, y, w, z, u."""
        rhs = []
        for k, (here, speed) in enumerate(STATES[: len(self.masses)]):
            springs = [f"{self.coupling}*({STATES[j][0]} - {here})" for j in self.neighbours(k)]
            spring = " + ".join([f"-{self.stiffness[k]}*{here}", *springs])
            rhs += [speed, f"{spring} - {self.damping[k]}*{speed} - {self.friction[k]}*sign({speed} - {self.belt})"]
        return rhs

    def force(self, k: int) -> list[Fraction]:
        """All forces on a mass but dry friction, as coefficients of (x, v, y, w, ...)."""
        row = [Fraction(0)] * (2 * len(self.masses))
        row[2 * k] = -self.stiffness[k] - self.coupling * len(self.neighbours(k))
        for j in self.neighbours(k):
            row[2 * j] = self.coupling
        row[2 * k + 1] = -self.damping[k]
        return row

    def matrix(self, mode: tuple[int, ...]) -> list[list[Fraction]]:
        """Of ``z' = A z`` for ``z = (x, v, y, w, ..., 1)``; 0 is sticking."""
        rows, size = [], 2 * len(mode) + 1
        for k, side in enumerate(mode):
            rows.append([Fraction(int(j == 2 * k + 1)) for j in range(size)])
            rows.append([Fraction(0)] * size if not side else [*self.force(k), -side * self.friction[k]])
        return [*rows, [Fraction(0)] * size]


def random_stick_slip(seed: int, masses: int = 2) -> tuple[StickSlip, list[Fraction]]:
    """Numbers of size one, and a start."""
    each = range(masses)
    rng = np.random.default_rng(seed)

    def pick(low: float, high: float) -> Fraction:
        return Fraction(int(rng.integers(round(100 * low), round(100 * high) + 1)), 100)

    system = StickSlip(
        tuple(pick(0.5, 3) for _ in each),
        pick(0.2, 2),
        tuple(pick(0, 0.3) for _ in each),
        tuple(pick(0.3, 1.5) for _ in each),
        pick(0.1, 1),
    )
    return system, [pick(-1, 1) for _ in range(2 * masses)]


def reference_events(system: StickSlip, start: list[Fraction], until: float) -> tuple[list[Any], list[Any]]:
    """Times of all events, and the state at the end, in 40 digits."""
    with mpmath.workdps(DIGITS):
        z = mpmath.matrix([_exact(v) for v in [*start, Fraction(1)]])
        time = mpmath.mpf(0)
        times: list[Any] = []
        mode = tuple(_after(system, z, k, None) for k in system.masses)
        while True:
            found = _first_event(system, mode, z, until - time)
            if found is None:
                end = _flow(system, mode)(until - time) * z
                return times, list(end[: 2 * len(mode)])
            span, k = found
            z, time = _flow(system, mode)(span) * z, time + span
            if mode[k]:
                z[2 * k + 1] = _exact(system.belt)
            times.append(time)
            sides = list(mode)
            sides[k] = _after(system, z, k, mode[k])
            mode = tuple(sides)


def _exact(value: Fraction) -> Any:
    return mpmath.mpf(value.numerator) / value.denominator


def _force(system: StickSlip, z: Any, k: int) -> Any:
    return sum(_exact(c) * z[j] for j, c in enumerate(system.force(k)))


def _after(system: StickSlip, z: Any, k: int, before: int | None) -> int:
    """The mode of a mass from a state on: stuck masses (0) have just been torn off."""
    gap = z[2 * k + 1] - _exact(system.belt)
    if before is None and gap:
        return 1 if gap > 0 else -1
    force = _force(system, z, k)
    if before != 0 and abs(force) <= _exact(system.friction[k]):
        return 0
    return 1 if force > 0 else -1


def _flow(system: StickSlip, mode: tuple[int, ...]) -> Callable[[Any], Any]:
    matrix = mpmath.matrix([[_exact(c) for c in row] for row in system.matrix(mode)])
    return lambda span: mpmath.expm(matrix * span, method="taylor")


def _watched(system: StickSlip, mode: tuple[int, ...], k: int) -> Callable[[Any], Any]:
    """What is positive as long as a mass keeps to its mode."""
    belt, friction = system.belt, system.friction[k]
    if mode[k]:
        return lambda z: mode[k] * (z[2 * k + 1] - _exact(belt))
    return lambda z: _exact(friction) ** 2 - _force(system, z, k) ** 2


def _first_event(system: StickSlip, mode: tuple[int, ...], z: Any, span: Any) -> tuple[Any, int] | None:
    """Time and mass of the next event."""
    step = np.array(mpmath.expm(mpmath.matrix([[_exact(c) for c in r] for r in system.matrix(mode)]) * STEP).tolist())
    step, state = step.astype(float), np.array([float(v) for v in z])
    values = [_float_watch(system, mode, k) for k in system.masses]
    for count in range(int(float(span) / STEP) + 2):
        state = step @ state
        fallen = [k for k in system.masses if values[k](state) < 0]
        if fallen and (count or any(values[k](state) < -1e-12 for k in fallen)):
            low = mpmath.mpf(STEP) * count
            roots = [(_root(system, mode, z, k, low, low + mpmath.mpf(STEP)), k) for k in fallen]
            first = min(roots)
            return first if first[0] < span else None
    return None


def _float_watch(system: StickSlip, mode: tuple[int, ...], k: int) -> Callable[[Any], float]:
    row = np.array([float(c) for c in system.force(k)])
    belt, friction = float(system.belt), float(system.friction[k])
    if mode[k]:
        return lambda z: float(mode[k] * (z[2 * k + 1] - belt))
    return lambda z: friction**2 - float(row @ z[: len(row)]) ** 2


def _root(system: StickSlip, mode: tuple[int, ...], z: Any, k: int, low: Any, high: Any) -> Any:
    """Where what is watched falls through zero, by bisection on the exact flow from the start of a short bracket."""
    z, watched, before = _flow(system, mode)(low) * z, _watched(system, mode, k), low
    matrix = mpmath.matrix([[_exact(c) for c in row] for row in system.matrix(mode)])
    low, high = low - before, high - before
    if before == 0:  # just after an event it may start from zero: the first moment at which it is clearly positive
        low = high
        while watched(_moved(matrix, z, low)) <= 0:
            low = low / 2
            if low < mpmath.mpf(10) ** -30:
                raise AssertionError("required a mode that lasts")
    tolerance = mpmath.mpf(10) ** -60
    return before + mpmath.findroot(
        lambda t: watched(_moved(matrix, z, t)), (low, high), solver="anderson", tol=tolerance
    )


def _moved(matrix: Any, z: Any, span: Any) -> Any:
    """``exp(A span) z`` by its series, which is short for a short span."""
    total, term, count = z, z, 0
    while mpmath.norm(term, mpmath.inf) > SERIES_ENDS:
        count += 1
        term = matrix * term * (span / count)
        total = total + term
    return total
