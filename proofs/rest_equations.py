"""What rests in a cell, on a border and at a corner of a plain system, as equations in balls, with their Jacobians."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from flint import arb, arb_mat

from nonsmooth.analysis.fields.stated_field import StatedField
from nonsmooth.proofs.boxes.all_zeros import Box
from nonsmooth.proofs.boxes.enclosures import Map
from nonsmooth.proofs.orbits.ball_steps import BallPolynomials
from nonsmooth.symbolic.formulas.enclosed_functions import ONE_AT_ZERO
from nonsmooth.symbolic.numbers.number import Number

SLOPES: dict[str, Callable[[arb, arb], arb]] = {  # from what a function is of, and its value
    "sin": lambda v, value: v.cos(),
    "cos": lambda v, value: -v.sin(),
    "tanh": lambda v, value: 1 - value * value,
    "atan": lambda v, value: 1 / (1 + v * v),
    "exp": lambda v, value: value,
}


class FieldInBalls:
    """A field with its Jacobian."""

    def __init__(self, stated: StatedField, states: Sequence[str]) -> None:
        self.stated, self.count = stated, len(states)
        slopes = [rate.derivative(name) for rate in stated.rates for name in stated.rates[0].variables]
        self._all = BallPolynomials([*stated.rates, *slopes])
        self._waves = [
            (wave.kind, BallPolynomials([wave.argument, *(wave.argument.derivative(name) for name in states)]))
            for wave in stated.waves
        ]

    def at(self, x: Sequence[arb]) -> tuple[list[arb], list[list[arb]]]:
        """The rates (n,), and their derivatives (n, n), over a box."""
        n, waves, turns = self.count, list[arb](), list[list[arb]]()
        for kind, argument in self._waves:
            v, *slopes = map(arb, argument(x))
            value = getattr(v, kind)()
            waves.append(value)
            turns.append([SLOPES[kind](v, value) * slope for slope in slopes])
        values = list(map(arb, self._all([*x, *waves])))
        rates, rest = values[:n], values[n:]
        width = n + len(waves)
        rows = [rest[k * width : (k + 1) * width] for k in range(n)]
        return rates, [
            [row[j] + sum((row[n + k] * turn[j] for k, turn in enumerate(turns)), start=arb(0)) for j in range(n)]
            for row in rows
        ]

    def exactly_at(self, place: Sequence[Number]) -> list[Number] | None:
        """The rates at an exact place; None where a sine or the like is of something else than zero there."""
        if any(wave.argument(place) for wave in self.stated.waves):
            return None
        one = self.stated.rates[0].field.one
        waves = [one * (wave.kind in ONE_AT_ZERO) for wave in self.stated.waves]
        return [rate([*place, *waves]) for rate in self.stated.rates]


def cell_equations(field: FieldInBalls) -> Map:
    """``f = 0``."""

    def at(z: arb_mat) -> tuple[arb_mat, arb_mat]:
        rates, slopes = field.at(z.entries())
        return arb_mat([[rate] for rate in rates]), arb_mat(slopes)

    return at


def sliding_equations(first: FieldInBalls, second: FieldInBalls, surface: BallPolynomials) -> Map:
    """``l f + (1 - l) g = 0, s = 0`` in x and l."""

    def at(z: arb_mat) -> tuple[arb_mat, arb_mat]:
        *x, share = z.entries()
        (f, f_slopes), (g, g_slopes) = first.at(x), second.at(x)
        s, *normal = map(arb, surface(x))
        values = [[b + share * (a - b)] for a, b in zip(f, g, strict=True)]
        rows = [
            [*(q + share * (p - q) for p, q in zip(slopes, other, strict=True)), a - b]
            for slopes, other, a, b in zip(f_slopes, g_slopes, f, g, strict=True)
        ]
        return arb_mat([*values, [s]]), arb_mat([*rows, [*normal, arb(0)]])

    return at


def on_border(around: Sequence[FieldInBalls], surface: BallPolynomials, box: Box) -> Box | None:
    """The part of a box of x and l in which all zeros are: a coordinate on ``s = 0``, and l by the speeds across it."""
    *x, share = box
    _, *normal = map(arb, surface(x))
    k = max(range(len(x)), key=lambda j: abs(float(normal[j].mid())))
    if not normal[k].contains(0):
        middle = [*x[:k], arb(x[k].mid()), *x[k + 1 :]]
        at_zero = middle[k] - arb(surface(middle)[0]) / normal[k]
        if not at_zero.overlaps(x[k]):
            return None
        x[k] = x[k].intersection(at_zero)
    first, second = (in_direction(normal, field.at(x)[0]) for field in around)
    if not (second - first).contains(0):
        needed = second / (second - first)
        if not needed.overlaps(share):
            return None
        share = share.intersection(needed)
    return [*x, share]


def corner_equations(first: BallPolynomials, second: BallPolynomials) -> Map:
    """``s = t = 0``."""

    def at(z: arb_mat) -> tuple[arb_mat, arb_mat]:
        (s, *s_slopes), (t, *t_slopes) = (list(map(arb, polynomial(z.entries()))) for polynomial in (first, second))
        return arb_mat([[s], [t]]), arb_mat([s_slopes, t_slopes])

    return at


def in_direction(first: Sequence[arb], second: Sequence[arb]) -> arb:
    """The inner product of two vectors."""
    return sum((a * b for a, b in zip(first, second, strict=True)), start=arb(0))
