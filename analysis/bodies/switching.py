"""Which motion follows where wheels lie exactly under the edge of a body: Filippov's construction.

At a pose where the wheels Z lie under the edge, each subset of Z may carry beside the wheels B well under the body, and
has a motion ``f_S`` of its own.  A subset *goes on* if its own motion takes its wheels under the body and the others
of Z out.  Where none does, the path slides: weights ``0 <= w_i <= 1`` of the wheels mix the motions,
``f = sum over S of prod_(i in S) w_i prod_(i not in S) (1 - w_i) f_S``, so that the sliding wheels stay under the edge,
``g_i' = 0``.  One wheel leaves no choice; for more of them that product is one of Filippov's solutions (Alexander
and Seidman 1998), and the path is not called unique.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations, product

import numpy as np

from nonsmooth.analysis.bodies.moving_outline import MovingOutline
from nonsmooth.analysis.bodies.set_motion import ContactSets, SetMotion, TippedError, Wheels
from nonsmooth.analysis.bodies.supports import CarryingWheels
from nonsmooth.analysis.trajectories.result import TrajectoryError
from nonsmooth.symbolic.numbers.plane_arrays import Floats, max_norm

# ---- products of weights that mix the motions of all subsets of some wheels ----------------------
#
# As where several lie under the edge.


STEPS = 40  # of Newton's method for the weights
WEIGHT_ERROR = 1e-12  # of the rates of the depths, relative to the largest


def subsets_of(wheels: Sequence[int]) -> Iterator[frozenset[int]]:
    """All subsets, in the order in which :func:`mixed_of` weighs them: the last wheel changes first."""
    for bits in product((False, True), repeat=len(wheels)):
        yield frozenset(wheel for wheel, bit in zip(wheels, bits, strict=True) if bit)


def _shares(weights: Floats) -> Floats:
    """``prod_(i in S) w_i prod_(i not in S) (1 - w_i)`` for every subset S."""
    shares = np.ones(1)
    for weight in weights:
        shares = np.outer(shares, [1 - weight, weight]).ravel()
    return shares


def mixed_of(corners: Floats, weights: Floats) -> Floats:
    """The motions (2^k, d) of all subsets of k wheels, mixed."""
    return _shares(weights) @ corners


def balancing_weights(rates: Floats, count: int, start: Floats) -> Floats | None:
    """Weights with which the rates (2^k, k) of the depths vanish, by Newton's method; None where it does not end."""
    weights = np.clip(start, 0.0, 1.0) if start.shape == (count,) else np.full(count, 0.5)
    scale = np.abs(rates).max() or 1.0
    for _ in range(STEPS):
        here = mixed_of(rates, weights)
        if max_norm(here) <= WEIGHT_ERROR * scale:
            return weights
        slopes = np.empty((count, count))
        for k in range(count):  # linear in each weight
            low, high = weights.copy(), weights.copy()
            low[k], high[k] = 0.0, 1.0
            slopes[:, k] = mixed_of(rates, high) - mixed_of(rates, low)
        try:
            weights = weights - np.linalg.solve(slopes, here)
        except np.linalg.LinAlgError:
            return None
    return None


# ---- the motion that follows ---------------------------------------------------------------------


# Where a slide ends the weight of a wheel is zero or one, and the motion beyond is tangent to the edge: up to so much
# rounding, of the weights and of the largest rate of a depth.  Who slides on from there comes nowhere.
ROUNDED = 1e-7
GONE = 1.0  # a weight that is so far beyond its ends belongs to a slide that has ended
MOST_AT_ONCE = 6  # wheels under the edge at one pose: 64 subsets


class Switching:
    """Motions near the edge of one body."""

    def __init__(self, sets: ContactSets, outline: MovingOutline) -> None:
        self._sets, self._outline = sets, outline

    def next_support(self, pose: Floats, carrying: Wheels, edge: Sequence[int]) -> CarryingWheels:
        """How the body goes on from a pose with the wheels ``edge`` under its edge.

        Raises:
            TippedError: where no way to go on carries the body.
            TrajectoryError: where none is found, or too many wheels lie under the edge.
        """
        if len(edge) > MOST_AT_ONCE:
            raise TrajectoryError(
                f"required at most {MOST_AT_ONCE} wheels under the edge at once, received {len(edge)}"
            )
        motions = self._motions(pose, carrying, edge)
        nothing = ROUNDED * max(map(max_norm, motions.values()))
        for rounding, least in ((0.0, ROUNDED), (nothing, 0.0)):
            going = [subset for subset, rates in motions.items() if _goes_on(subset, rates, edge, rounding)]
            if going:
                return CarryingWheels(carrying | max(going, key=len), unique=len(going) == 1)
            for sliding in (some for size in range(1, len(edge) + 1) for some in combinations(edge, size)):
                support = self._slide(carrying, edge, sliding, motions, least, rounding)
                if support is not None:
                    return support
        if len(motions) < 2 ** len(edge):
            raise TippedError
        raise TrajectoryError("required a way to go on from wheels under the edge, received none that was found")

    def rate(self, support: CarryingWheels, pose: Floats, weights: Floats) -> tuple[Floats, Floats]:
        """The pose rate on a support, and the weights of its sliding wheels; the given ones are where Newton starts."""
        if not support.sliding:
            return self._sets.rate(support.carrying, pose), weights
        corners = [self._sets.rate(support.carrying | subset, pose) for subset in subsets_of(support.sliding)]
        return self.mixed(support, pose, corners, weights)

    def mixed(
        self, support: CarryingWheels, pose: Floats, corners: list[Floats], weights: Floats
    ) -> tuple[Floats, Floats]:
        """:meth:`rate` from the rates of :meth:`motions`."""
        if not support.sliding:
            return corners[0], weights
        wheels = list(support.sliding)
        depths = [self._outline.rates(pose, corner, wheels) for corner in corners]
        found = balancing_weights(np.array(depths), len(wheels), weights)
        if (
            found is None
        ):  # as beyond the end of a slide, where a wheel bears nothing: it has gone the way of all motions
            found = np.where(np.mean(depths, axis=0) > 0, 1.0 + GONE, -GONE)
        return mixed_of(np.array(corners), found), found

    def motions(self, support: CarryingWheels, pose: Floats) -> list[SetMotion]:
        """The motions that :meth:`rate` mixes."""
        return [self._sets.motion(support.carrying | subset, pose) for subset in subsets_of(support.sliding)]

    def _motions(self, pose: Floats, carrying: Wheels, edge: Sequence[int]) -> dict[Wheels, Floats]:
        """The rates of the depths of the edge's wheels, by the subset that carries; without those that tip."""
        motions: dict[Wheels, Floats] = {}
        for subset in subsets_of(edge):
            if not self._sets.carries(carrying | subset, pose):
                continue
            rate = self._sets.rate(carrying | subset, pose)
            motions[subset] = self._outline.rates(pose, rate, list(edge))
        if not motions:
            raise TippedError
        return motions

    @staticmethod
    def _slide(
        carrying: Wheels,
        edge: Sequence[int],
        sliding: tuple[int, ...],
        motions: dict[Wheels, Floats],
        least: float,
        rounding: float,
    ) -> CarryingWheels | None:
        """A support on which these wheels stay under the edge while the other wheels of the edge go one way.

        Their weights are more than ``least``, and as much less than one; rates up to a rounding go either way.
        """
        others = [wheel for wheel in edge if wheel not in sliding]
        places = [edge.index(wheel) for wheel in sliding]
        for inside in subsets_of(others):
            chosen = [motions.get(inside | subset) for subset in subsets_of(sliding)]
            if any(rates is None for rates in chosen):
                continue
            corners = np.array(chosen)
            weights = balancing_weights(corners[:, places], len(sliding), np.full(len(sliding), 0.5))
            if weights is None or not ((weights > least) & (weights < 1 - least)).all():
                continue
            mixed = mixed_of(corners, weights)
            if _goes_on(inside, mixed[[edge.index(wheel) for wheel in others]], others, rounding):
                return CarryingWheels(carrying | inside, sliding, unique=len(sliding) == 1)
        return None


def _goes_on(subset: Wheels, rates: Floats, edge: Sequence[int], rounding: float) -> bool:
    """Whether the wheels of a subset come under the body, and the others out; rates up to a rounding may be either."""
    into = zip((wheel in subset for wheel in edge), rates, strict=True)
    return all(rate > -rounding if inside else rate < rounding for inside, rate in into)
