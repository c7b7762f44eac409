"""An oracle for relay systems and conewise-linear systems in floats, apart from the program's own code and theory.

A system is given by lines and, for each pattern of their signs, an affine field ``A c + b``.  Two judges:

- formulas: eigenvectors and equivalent control on the lines (Utkin 1992), growth of a full turn by quadrature; it does
  not know where a sign is within ``CLEAR`` of zero;
- paths: Euler polygons from a circle with steps in proportion to the distance, which chatter along sliding lines.
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from tests.oracles import floats

Array: TypeAlias = NDArray[np.float64]

CLEAR = 1e-9
STEPS, FINENESS = 6000, 2e-3
FAR = 1e9
NOT_FAR = 20.0  # growth that is no sign of leaving


@dataclass(frozen=True)
class Affine:
    """``A c + b`` in whole numbers over a common denominator."""

    matrix: tuple[tuple[Fraction, Fraction], tuple[Fraction, Fraction]]
    constant: tuple[Fraction, Fraction]


@dataclass(frozen=True)
class Switched:
    """``c' = sum over subsets of lines of (product of their signs) (A c + b)``."""

    lines: tuple[tuple[int, int], ...]
    terms: tuple[tuple[tuple[int, ...], Affine], ...]  # the lines whose signs multiply the field

    @property
    def rhs(self) -> tuple[str, str]:
        """Both formulas."""
        formulas = []
        for row in (0, 1):
            parts = []
            for chosen, field in self.terms:
                (a, b), c = field.matrix[row], field.constant[row]
                signs = "".join(f"*sign({self.lines[k][0]}*x + {self.lines[k][1]}*y)" for k in chosen)
                parts.append(f"(({a})*x + ({b})*y + ({c})){signs}")
            formulas.append(" + ".join(parts))
        return formulas[0], formulas[1]

    def field(self, signs: tuple[int, ...]) -> tuple[Array, Array]:
        """A and b for a pattern of signs."""
        matrix, constant = np.zeros((2, 2)), np.zeros(2)
        for chosen, field in self.terms:
            side = math.prod(signs[k] for k in chosen)
            matrix += side * np.array([[float(v) for v in row] for row in field.matrix])
            constant += side * np.array([float(v) for v in field.constant])
        return matrix, constant

    def signs_at(self, point: Array) -> tuple[int, ...]:
        """The pattern at a point off the lines."""
        return tuple(1 if a * point[0] + b * point[1] > 0 else -1 for a, b in self.lines)


def unit(angle: float) -> Array:
    return np.array([math.cos(angle), math.sin(angle)])


def turn(a: Array, b: Array) -> float:
    return float(a[0] * b[1] - a[1] * b[0])


class Judge:
    """By formulas: ``asymptotically stable``, ``unstable`` or None."""

    def __init__(self, system: Switched) -> None:
        self.system = system
        angles = sorted({math.atan2(s * a, -s * b) for a, b in system.lines for s in (1, -1)})
        self.cones = list(zip(angles, [*angles[1:], angles[0] + 2 * math.pi], strict=True))
        self.fields = [system.field(system.signs_at(unit((a + b) / 2))) for a, b in self.cones]
        self.frozen = any(np.any(b != 0) for _, b in self.fields)

    def verdict(self) -> str | None:
        """By the radial directions of the leading terms, or the growth of a full turn."""
        signs = list(self.radial_signs())
        if any(s is None for s in signs):
            return None
        if any(s > 0 for s in signs if s is not None):
            return "unstable"
        if signs:
            return "asymptotically stable"
        return self.by_growth()

    def velocity(self, k: int, direction: Array) -> Array:
        matrix, constant = self.fields[k]
        return constant if self.frozen else np.asarray(matrix @ direction)

    def radial_signs(self) -> Iterator[int | None]:
        """Signs of all radial motions; None where one is too close to call."""
        for k, cone in enumerate(self.cones):
            yield from self.inside(k, cone)
        for k, (angle, _) in enumerate(self.cones):
            yield from self.on_line(k - 1, k, unit(angle))

    def inside(self, k: int, cone: tuple[float, float]) -> Iterator[int | None]:
        matrix, constant = self.fields[k]
        if self.frozen:
            eigenpairs = [(constant, 1.0)]
        else:
            values, vectors = np.linalg.eig(matrix)
            eigenpairs = [(s * vectors[:, j].real, values[j].real) for j in (0, 1) for s in (1, -1)]
            if np.abs(values.imag).max() > CLEAR:
                return
        for vector, value in eigenpairs:
            size = float(np.hypot(*vector))
            if size < CLEAR:
                yield None
                continue
            where = (math.atan2(vector[1], vector[0]) - cone[0]) % (2 * math.pi)
            width = cone[1] - cone[0]
            if min(where, abs(where - width), 2 * math.pi - where) < CLEAR:
                yield None
            elif where < width:
                yield None if abs(value) < CLEAR else int(math.copysign(1, value))
            elif self.frozen and abs(where - math.pi) < width and width > math.pi + CLEAR:
                yield None
        if self.frozen:  # straight home inside a cone: the opposite of the velocity lies in it
            where = (math.atan2(-constant[1], -constant[0]) - cone[0]) % (2 * math.pi)
            if where < cone[1] - cone[0]:
                yield -1

    def on_line(self, before: int, after: int, ray: Array) -> Iterator[int | None]:
        f, g = self.velocity(before, ray), self.velocity(after, ray)
        n, m = turn(ray, f), turn(ray, g)
        if min(abs(n), abs(m)) < CLEAR:
            yield None
        elif n * m < 0:
            weight = m / (m - n)
            speed = float((weight * f + (1 - weight) * g) @ ray)
            if abs(speed) < CLEAR and self.frozen:
                speed = self.equivalent_control(before, after, ray, weight)
            yield None if abs(speed) < CLEAR else int(math.copysign(1, speed))

    def equivalent_control(self, before: int, after: int, ray: Array, weight: float) -> float:
        """Rate of the sliding motion on a line along which the constant parts cancel: its eigenvalue."""
        (a, b), (c, d) = self.fields[before], self.fields[after]
        normal = np.array([-ray[1], ray[0]])
        # on s ray: weight w(s) = w + s w' keeps the normal part zero
        slope = -float(normal @ (weight * a @ ray + (1 - weight) * c @ ray)) / float(normal @ (b - d))
        return float(ray @ (weight * a @ ray + (1 - weight) * c @ ray + slope * (b - d)))

    def by_growth(self) -> str | None:
        """The sign of the growth of a full turn."""
        from scipy.integrate import quad

        total, senses = 0.0, set()
        for k, (low, high) in enumerate(self.cones):

            def rate(angle: float, k: int = k) -> float:
                u = unit(angle)
                v = self.velocity(k, u)
                return float(u @ v) / turn(u, v)

            middle = unit((low + high) / 2)
            senses.add(math.copysign(1, turn(middle, self.velocity(k, middle))))
            total += quad(rate, low, high, limit=400)[0]
        if len(senses) != 1 or abs(total) < 1e-6:
            return None
        return "unstable" if total * senses.pop() > 0 else "asymptotically stable"


def leaves(system: Switched) -> bool:
    """Whether polygons go away and do not come back, also in ten times as many steps.

    Stable systems may first go away ten thousandfold: seed 50293 of :func:`random_conewise`.
    """
    for steps in (STEPS, 10 * STEPS):
        far, end = spread(system, steps=steps)
        if end < max(NOT_FAR, far / 2):
            return False
    return True


def spread(system: Switched, start: float = 1e-4, steps: int = STEPS) -> tuple[float, float]:
    """Largest distance that a polygon from a circle reaches, and the largest at the end, both over the radius."""
    table = {signs: system.field(signs) for signs in product((1, -1), repeat=len(system.lines))}

    def velocity(points: Array) -> Array:
        velocities = np.empty_like(points)
        patterns = np.column_stack([np.where(points @ np.array(line) >= 0, 1, -1) for line in system.lines])
        for signs, (matrix, constant) in table.items():
            here = np.all(patterns == signs, axis=1)
            velocities[here] = points[here] @ matrix.T + constant
        return velocities

    return floats.spread(velocity, start, steps, FINENESS, FAR * start)


# ---- random systems ------------------------------------------------------------------------------


def random_relay(seed: int) -> Switched:
    """One or two relays and a linear part."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(1, 3))
    lines = _random_lines(rng, count)
    drift = Affine(_matrix(rng), (Fraction(0), Fraction(0)))
    relays = [((k,), Affine(_matrix(rng, scale=0), _vector(rng))) for k in range(count)]
    return Switched(lines, (((), drift), *relays))


def random_conewise(seed: int) -> Switched:
    """Four cones between two lines with any four matrices."""
    rng = np.random.default_rng(seed)
    lines = _random_lines(rng, 2)
    zero = (Fraction(0), Fraction(0))
    bias = int(rng.integers(-4, 3))
    base = _matrix(rng)
    spin = int(rng.integers(-6, 7))
    shifted = ((base[0][0] + bias, base[0][1] - spin), (base[1][0] + spin, base[1][1] + bias))
    terms: list[tuple[tuple[int, ...], Affine]] = [((), Affine(shifted, zero))]
    terms += [(chosen, Affine(_matrix(rng), zero)) for chosen in ((0,), (1,), (0, 1))]
    return Switched(lines, tuple(terms))


def _random_lines(rng: np.random.Generator, count: int) -> tuple[tuple[int, int], ...]:
    lines: list[tuple[int, int]] = []
    while len(lines) < count:
        a, b = (int(v) for v in rng.integers(-3, 4, size=2))
        if (a or b) and all(a * d - b * c for c, d in lines):
            lines.append((a, b))
    return tuple(lines)


def _matrix(rng: np.random.Generator, scale: int = 4) -> tuple[tuple[Fraction, Fraction], tuple[Fraction, Fraction]]:
    a, b, c, d = (Fraction(int(v), 2) for v in rng.integers(-scale, scale + 1, size=4))
    return (a, b), (c, d)


def _vector(rng: np.random.Generator) -> tuple[Fraction, Fraction]:
    a, b = (Fraction(int(v), 2) for v in rng.integers(-6, 7, size=2))
    return a, b


def random_fan(seed: int, *, drift: bool = True) -> Switched:
    """One to three lines, relays that push to them and along them, products of relays, perhaps a linear part."""
    source = random.Random(seed)
    lines: list[tuple[int, int]] = []
    count = source.randint(1, 3)
    while len(lines) < count:
        a, b = source.randint(-3, 3), source.randint(-3, 3)
        if (a or b) and all(a * d - b * c for c, d in lines):
            lines.append((a, b))
    push, along, rest = source.randint(-1, 3), source.choice((-3, 0, 0, 3)), source.randint(0, 4)
    terms: list[tuple[tuple[int, ...], Affine]] = []
    for chosen in product((False, True), repeat=count):
        taken = tuple(k for k in range(count) if chosen[k])
        if len(taken) < 3:
            velocity = [Fraction(source.randint(-rest, rest), 2) for _ in range(2)]
            if len(taken) == 1:
                a, b = lines[taken[0]]
                velocity = [velocity[0] - push * a - along * b, velocity[1] - push * b + along * a]
            c, d, e, f = (Fraction(source.randint(-2, 2) if drift and len(taken) < 2 else 0) for _ in range(4))
            terms.append((taken, Affine(((c, d), (e, f)), (velocity[0], velocity[1]))))
    return Switched(tuple(lines), tuple(terms))
