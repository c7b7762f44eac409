"""How long solutions take to the point: by a V about roots of states that falls fast enough for its size.

Of a homogeneous field with negative degree -e every solution arrives at a point that attracts.  Let all states have
weight one in their roots w, and S be the sum of ``c_k Abs(w_k)``.  A form V of degree p with ``V <= S^p`` and
``V' <= -a S^(p - e)`` bounds the time of arrival by ``p S^e/(a e)``
(:func:`nonsmooth.proofs.checker.theorems.show_arrival`).  For given c the largest a is that of a linear program in the
coefficients of V and a; c are then chosen such that ``c_k^p`` is V on the axis of the k-th root, and V is searched
again.  The two numbers of the rounded V are read off samples, with something to spare.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from fractions import Fraction
from math import ceil, floor, log10
from typing import NamedTuple

import numpy as np

from nonsmooth.proofs.checker.cells import Cell
from nonsmooth.proofs.checker.lyapunov import Shift
from nonsmooth.proofs.checker.polynomials import Polynomial, constant
from nonsmooth.proofs.checker.positivity import Claim
from nonsmooth.proofs.checker.theorems import ASYMPTOTICALLY_STABLE
from nonsmooth.proofs.checker.work import RejectedError
from nonsmooth.proofs.findings import Record
from nonsmooth.proofs.inequalities.linear_program import solve_program
from nonsmooth.proofs.kernel.cells import BeyondReachError
from nonsmooth.proofs.kernel.homogeneity import Homogeneity
from nonsmooth.proofs.kernel.rooted_functions import (
    MOST_ADDED,
    ROUNDS,
    SEEDS,
    InRoots,
    at_samples,
    functions_of,
    in_units,
    of_two_fields,
    products,
    samples,
    seen_in_roots,
    text_of,
    units_of,
)
from nonsmooth.proofs.kernel.search import DeferredClaims, NotShownError, Search, stability_hypotheses
from nonsmooth.proofs.kernel.written import roundings
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from nonsmooth.symbolic.numbers.polynomial import BEYOND_FLOATS
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

SIZES = 2  # choices of c, one after the other
FEW_DIGITS, DIGITS = 2, 3  # of c, of which the largest is one, and of other numbers
DENOMINATOR = 256  # of the coefficients of V
SPARE = (Fraction(31, 32), Fraction(7, 8), Fraction(1, 2))  # parts of the rate that samples allow, tried in turn
ROOM = Fraction(33, 32)  # of the largest V at samples
TINY = 2.0**-30  # of the largest, rates that count as none
THINNED, SLACK = 6, 1 / 64  # of samples the first ones; of the rate that others may lack


class Arrival(NamedTuple):
    """Every solution is at the point after at most ``factor (sum_k size_k Abs(x_k)^(1/q_k))^power``.

    Attributes:
        factor: T.
        size: the numbers by which the states count.
        orders: q of each state.
        power: e.
        entry: the theorem that shows it, as a certificate holds it.
    """

    factor: Fraction
    size: tuple[Fraction, ...]
    orders: tuple[int, ...]
    power: int
    entry: Record

    def words(self, states: Sequence[str]) -> str:
        """The bound for a start, in formulas of its states."""
        kinds = {1: "abs({})", 2: "sqrt(abs({}))"}
        sizes = [
            kinds.get(q, f"abs({{}})**(1/{q})").format(state) for state, q in zip(states, self.orders, strict=True)
        ]
        parts = [size if c == 1 else f"{float(c):g}*{size}" for c, size in zip(self.size, sizes, strict=True)]
        power = "" if self.power == 1 else f"**{self.power}"
        size = parts[0] if len(parts) == 1 and not power else f"({' + '.join(parts)}){power}"
        return f"{float(self.factor):g}*{size}"


@BEYOND_FLOATS
def find_arrival(system: SwitchedSystem, homogeneity: Homogeneity) -> Arrival | None:
    """A bound of the time of arrival, for all starts; None where none is found.

    Args:
        system: of which the point attracts.
        homogeneity: its weights.
    """
    arrivals: list[Arrival] = []
    with suppress(BeyondReachError, NotShownError, RejectedError, SceneError):
        about = seen_in_roots(system, homogeneity) if homogeneity.arrives else None
        if about is None:
            return None
        highest = 2 * max(about.orders)
        for degree in (highest - 1, highest):
            arrival = _Forms(about, degree).arrival()
            arrivals += [] if arrival is None else [arrival]
    return min(arrivals, key=lambda bound: bound.factor * sum(bound.size), default=None)


class _Forms:
    """Forms V of one degree, by their values at samples."""

    def __init__(self, about: InRoots, degree: int) -> None:
        self.about, self.degree = about, degree
        self.listed = list(products(about.orders, degree))
        self.functions = functions_of(about, self.listed)
        self.units = units_of(about, self.listed)
        falling = [self._falling(k, self.functions.zero) for k in range(len(self.listed))]
        self.falls = at_samples(falling, SEEDS) / self.units
        self.unit = float(np.abs(self.falls).max())  # of rates

    def arrival(self) -> Arrival | None:
        """A bound by the V that is best for two sizes, one after the other."""
        size = tuple(1 / unit for unit in self.about.units)
        chosen = self._best(size)
        for _ in range(SIZES):
            better = self._size_of(chosen) if chosen is not None else None
            if better is None:
                return None
            size, chosen = better, self._best(better)
        return self._shown(chosen, size) if chosen is not None else None

    def _falling(self, number: int, shift: Shift) -> list[Claim]:
        """That the derivative of a product, with a shift, is negative on cells, and of mixtures that keep to a face."""
        functions = self.functions
        functions.number, functions.proofs = number, DeferredClaims()
        functions.show_falls("", shift, strict=True)
        return list(of_two_fields(functions.proofs.claims))

    def _powers_of_size(self, size: Sequence[Fraction], exponent: int) -> Callable[[Cell], Polynomial]:
        """``S^exponent`` on cells."""
        inclusion, names = self.functions.inclusion, self.about.seen.coordinates

        def power_of(cell: Cell) -> Polynomial:
            total = constant(inclusion.count, 0)
            for name, weight in zip(names, size, strict=True):
                coordinate = inclusion.domain.displacement[name]
                total += coordinate.times(weight * inclusion.surfaces.sign_on(cell.signs, coordinate))
            return total.power(exponent)

        return power_of

    def _best(self, size: Sequence[Fraction]) -> Floats | None:
        """The coefficients of V with ``V <= S^p`` and the largest a with ``V' <= -a S^(p - e)``, at samples."""
        speeds, heights = self._speeds(size), self._heights(size)
        inside = speeds > 0
        falls = np.column_stack([self.falls[inside] / (self.unit * speeds[inside, None]), -np.ones(inside.sum())])
        low = np.column_stack([heights, np.zeros(len(heights))])
        chosen, used = None, np.arange(len(falls)) % THINNED == 0
        for _ in range(ROUNDS):
            chosen = _largest_last(falls[used], low[::THINNED])
            if chosen is None or not chosen[-1] > TINY:
                return None
            gaps = falls @ chosen
            if gaps.min() >= -chosen[-1] * SLACK:
                break
            used[np.argsort(gaps)[:MOST_ADDED]] = True
        return None if chosen is None else chosen[:-1]

    def _speeds(self, size: Sequence[Fraction]) -> Floats:
        """What ``a = 1`` takes from the values of :attr:`falls`."""
        power = self._powers_of_size(size, self.degree + self.about.degree)
        shifted = at_samples([self._falling(0, power)], SEEDS)
        return np.asarray(self.falls[:, 0] * self.units[0] - shifted[:, 0])

    def _heights(self, size: Sequence[Fraction]) -> Floats:
        """The products over ``S^p`` at samples of all cells."""
        places = samples(self.functions.count, SEEDS) * np.array(self.about.units, dtype=float)
        sizes = (np.abs(places) @ np.array(size, dtype=float)) ** self.degree
        columns = [product.at_places(places) / sizes for product in self.listed]
        return np.stack(columns, axis=1) / self.units

    def _size_of(self, chosen: Floats) -> tuple[Fraction, ...] | None:
        """Numbers c with ``c_k^p`` in proportion to V on the axes; None where V is not positive there."""
        axes = np.eye(len(self.about.orders))
        heights = np.stack([product.at_places(axes) for product in self.listed], axis=1) @ chosen
        if not heights.min() > 0:
            return None
        sizes = heights ** (1 / self.degree) / np.array(self.about.units, dtype=float)
        return tuple(rounded_up(Fraction(float(size)), FEW_DIGITS) for size in sizes / sizes.max())

    def _shown(self, chosen: Floats, size: tuple[Fraction, ...]) -> Arrival | None:
        """The bound with V in rational numbers; None where its claims are not shown."""
        (scaled,) = roundings(chosen, [DENOMINATOR])
        function = in_units(scaled, self.listed, self.about)
        rounded, speeds = np.array(scaled, dtype=float), self._speeds(size)
        inside = speeds > 0
        speed, height = (self.falls[inside] @ rounded / speeds[inside]).min(), (self._heights(size) @ rounded).max()
        if not (TINY * self.unit < speed < np.inf and TINY < height < np.inf):
            return None
        is_line = len(size) == 1  # of one state V is a power
        room, parts = (Fraction(1), (Fraction(1),)) if is_line else (ROOM, SPARE)
        above = rounded_up(Fraction(float(height)) * room, DIGITS)
        stated = stability_hypotheses(self.about.cells, text_of(self.about, function), ASYMPTOTICALLY_STABLE)
        hypotheses = self.about.hypotheses({**stated, "everywhere": True})
        search, power = Search(), -self.about.degree
        for part in parts:
            factor = rounded_up(self.degree * above / (power * Fraction(float(speed)) * part), DIGITS)
            slow = self.degree * above / (power * factor)
            arrival = {"size": list(map(str, size)), "above": str(above), "speed": str(slow), "power": power}
            with suppress(NotShownError):
                entry, _ = search.entry(self.about.subject, "lyapunov", {**hypotheses, "arrival": arrival})
                return Arrival(factor, size, self.about.orders, power, entry)
        return None


def _largest_last(falls: Floats, low: Floats) -> Floats | None:
    """The numbers with ``falls x >= 0`` and ``low x <= 1`` of which the last, not negative, is largest."""
    count = falls.shape[1]
    upper, right = np.vstack([-falls, low]), np.concatenate([np.zeros(len(falls)), np.ones(len(low))])
    costs, bounds = [*[0.0] * (count - 1), -1.0], [*[(None, None)] * (count - 1), (0.0, None)]
    solution = solve_program(costs, A_ub=upper, b_ub=right, bounds=bounds)
    return np.asarray(solution.x) if solution.status == 0 else None


def rounded_up(value: Fraction, digits: int) -> Fraction:
    """The next larger decimal with so many digits."""
    unit = Fraction(10) ** (floor(log10(value)) + 1 - digits)
    return ceil(value / unit) * unit
