"""Poses at which a body may rest with one wheel under its edge, and points at which it may rest on one set of wheels.

Floats that propose, under a rule without cells.  Contact sets, and pairs of them that differ by one wheel, are met on
a grid of places about a point, at every heading with a wheel under the edge.  On a pair with the motions F_1 (without
the wheel) and F_2 (with it) a body rests under the edge iff ``(1 - w) F_1(c) + w F_2(c) = 0`` with ``0 < w < 1``: three
equations for ``(x, y, w)``, which know nothing of the heading; that is one at which the wheel lies under the edge.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from flint import arb

from nonsmooth.analysis.bodies.moving_outline import MovingOutline
from nonsmooth.analysis.cells.contact_rule import SmoothRule
from nonsmooth.analysis.fields.contact_model import ContactModel, contacts_under
from nonsmooth.analysis.minimizers.many_twists import MotionsOnSets
from nonsmooth.symbolic.mechanics.edge_headings import BallOutline
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.plane import XY, in_floats
from nonsmooth.symbolic.numbers.plane_arrays import (
    Floats,
    Indices,
    Mask,
    max_norm,
    max_norms,
    norm,
    norms,
    row_norms,
    row_products,
    squared_norms,
)

PLACES = 25  # along each side of the square of places
HEADINGS = 360  # over a full turn: to see whether a set of wheels carries at a place
GENERIC = 0.0137, 0.0071  # shift of the places, in steps: symmetric arrays bring no two wheels to the edge at once
STARTS = 2  # of them from which it is followed, those where its motions nearly cancel
MOST_STARTS = 1200  # of all pairs
STEPS = 30  # of Newton's method
SLOWED, PATIENCE = 0.05, 8  # residual, of the fastest wheel's speed, above which so many steps led nowhere
SHORT, STALLED = 1e-4, 1e-3  # steps, of the body's size, at which such a residual is that of a kink
SHORTENED = 0.4  # share of a step that is tried after one that raised the residual
DIFFERENCE = 1e-4  # of the body's size: for slopes
LONGEST = 0.3  # step, of the half-width of the square
SETTLED = 1e-6  # residual, of the fastest wheel's speed
SHORTEST = 1e-9  # step, of the body's size
AT_REST = 1e-3  # speed on both sets, of the fastest wheel's, below which the body rests on either
BALANCED = 1e-9  # force and moment of a body at rest, of all friction
LOADED_SETS = 10  # that are tried for one contact set
ALIKE = 1e-5  # of the body's size: places closer together are one


@dataclass(frozen=True)
class SeenRest:
    """A pose at which a body may rest.

    Attributes:
        place: ``(x, y)``.
        theta: the heading, or one at which the same wheels carry where none lies under the edge.
        wheels: places, in the list of wheels, of those well under the body, ascending.
        edge: of the one under its edge, if there is one.
    """

    place: XY
    theta: float
    wheels: tuple[int, ...]
    edge: tuple[int, ...] = ()


@dataclass(frozen=True)
class ObservedSets:
    """What was met on the grid.

    Attributes:
        sets: contact sets (k, n).
        pairs: contact sets without a wheel (m, n), of pairs that differ by it; one row for each place.
        wheels: the wheels by which they differ (m,).
        centres: places at which the pairs were met (m, 2).
    """

    sets: Mask
    pairs: Mask
    wheels: Indices
    centres: Floats


class RestSearch:
    """Looks for rest of one body about one point."""

    def __init__(self, scene: Scene, rule: SmoothRule) -> None:
        """For a scene with a body, all its wheels in ``scene.wheels``.

        Raises:
            ValueError: for a scene without a body.
        """
        if scene.body is None:
            raise ValueError("required a scene with a body")
        self.model: ContactModel = contacts_under(rule, scene)
        self._outline = MovingOutline(scene.body, self.model.positions)
        self._balls = BallOutline(scene.body)
        self._point = np.array(scene.check.place)
        self._fastest = max_norm(self.model.speeds) or 1.0
        self._motions = MotionsOnSets(self.model, self._outline.size)
        self._pulls = self._forces_at_rest()
        self.reach = self._outline.spacing

    def meet(self) -> ObservedSets:
        """The contact sets about the point."""
        steps = np.linspace(-self.reach, self.reach, PLACES)
        width = steps[1] - steps[0]
        sets: dict[bytes, Mask] = {}
        pairs: dict[tuple[bytes, int, int], tuple[Mask, Floats]] = {}
        places = [self._point + np.add((x, y), np.multiply(GENERIC, width)) for x in steps for y in steps]
        for number, place in enumerate(sorted(places, key=lambda at: norm(at - self._point))):
            wheels, headings = self._outline.headings_under_edge(self.model.positions - place)
            poses = np.column_stack([np.tile(place, (len(headings), 1)), headings])
            under = self._outline.depths(poses) > 0
            for wheel, without in zip(wheels, under, strict=True):
                without[wheel] = False
                including = without.copy()
                including[wheel] = True
                pairs.setdefault((without.tobytes(), int(wheel), number), (without, place))
                for carrying in (without, including):
                    sets.setdefault(carrying.tobytes(), carrying)
        count = self.model.wheels
        return ObservedSets(
            np.array(list(sets.values())).reshape(-1, count),
            np.array([without for without, _ in pairs.values()]).reshape(-1, count),
            np.array([wheel for _, wheel, _ in pairs], int),
            np.array([place for _, place in pairs.values()]).reshape(-1, 2),
        )

    def under_the_edge(self, met: ObservedSets) -> list[SeenRest]:
        """Rest off the point with one wheel under the edge, on the pairs met."""
        if not len(met.pairs):
            return []
        without, wheels, including, start = self._nearly_at_rest(met)
        unknowns, settled = self._newton(without, including, start)
        first, second = (self._motions.at(sets, unknowns[:, :2]) for sets in (without, including))
        fast = np.minimum(*(max_norms(found.rates) for found in (first, second))) > AT_REST * self._fastest
        inside = (unknowns[:, 2] > 0) & (unknowns[:, 2] < 1)
        near = max_norms(unknowns[:, :2] - self._point) <= self.reach
        kept: list[SeenRest] = []
        for k in np.flatnonzero(settled & fast & inside & near & first.known & second.known):
            x, y = (float(value) for value in unknowns[k, :2])
            carrying = tuple(int(j) for j in np.flatnonzero(without[k]))
            for theta in self._headings(without[k], int(wheels[k]), (x, y)):
                rest = SeenRest((x, y), theta, carrying, (int(wheels[k]),))
                if self._distance(rest) > ALIKE * self._outline.size and not any(map(partial(self._alike, rest), kept)):
                    kept.append(rest)
        return kept

    def on_one_set(self, met: ObservedSets) -> list[SeenRest]:
        """Rest off the point on one set of wheels, where all slip: forces and moment balance; the nearest first."""
        found = []
        for carrying in met.sets:
            place = self._balanced(carrying)
            if place is None or max_norm(place - self._point) > self.reach:
                continue
            headings = np.linspace(-np.pi, np.pi, HEADINGS, endpoint=False)
            under = self._outline.depths(np.column_stack([np.tile(place, (HEADINGS, 1)), headings])) > 0
            same = np.flatnonzero((under == carrying).all(axis=1))
            if len(same):
                wheels = tuple(int(k) for k in np.flatnonzero(carrying))
                found.append(SeenRest(in_floats(place), float(headings[same[len(same) // 2]]), wheels))
        away = [rest for rest in found if self._distance(rest) > ALIKE * self._outline.size]
        return sorted(away, key=lambda rest: (self._distance(rest), rest.wheels))

    def _distance(self, rest: SeenRest) -> float:
        """From the point."""
        return norm(np.array(rest.place) - self._point)

    def _alike(self, first: SeenRest, second: SeenRest) -> bool:
        """Whether two poses of rest are one: the same wheel under the edge, and nearly the same pose."""
        size = self._outline.size
        apart = [*np.subtract(first.place, second.place), (first.theta - second.theta) * size]
        return first.edge == second.edge and bool(max_norm(apart) <= ALIKE * size)

    def _nearly_at_rest(self, met: ObservedSets) -> tuple[Mask, Indices, Mask, Floats]:
        """The pairs whose motions nearly cancel: without the wheel, the wheel, with it, and ``(x, y, w)`` to start at.

        The nearest to zero of all ``(1 - w) F_1 + w F_2`` is compared with the larger of both.
        """
        including = met.pairs.copy()
        including[np.arange(len(met.wheels)), met.wheels] = True
        first, second = (self._motions.at(sets, met.centres) for sets in (met.pairs, including))
        along = second.rates - first.rates
        square = np.maximum(squared_norms(along), np.finfo(float).tiny)
        share = np.clip(-row_products(first.rates, along) / square, 0.0, 1.0)
        sizes = np.maximum(*(row_norms(found.rates) for found in (first, second)))
        left = row_norms(first.rates + share[:, None] * along) / np.maximum(sizes, np.finfo(float).tiny)
        left[~(first.known & second.known)] = np.inf
        chosen = _least(left, met)
        starts = np.column_stack([met.centres[chosen], share[chosen]])
        return met.pairs[chosen], met.wheels[chosen], including[chosen], starts

    def _newton(self, without: Mask, including: Mask, starts: Floats) -> tuple[Floats, Mask]:
        """``(x, y, w)`` of every pair, (m, 3), and whether the residual vanishes; steps that raise it are shortened."""
        unknowns, steps = starts.copy(), np.zeros((len(starts), 3))
        least = np.full(len(starts), np.inf)
        going = np.ones(len(starts), bool)
        rates = np.zeros((2, len(starts), 3))
        for count in range(STEPS):
            at = np.flatnonzero(going)
            if not len(at):
                break
            trial = unknowns[at] + steps[at]
            values, slopes, known, rates[:, at] = self._residuals((without[at], including[at]), trial, rates[:, at])
            left = np.where(known, max_norms(values) / self._fastest, np.inf)
            better = left < least[at]
            steps[at[~better]] *= SHORTENED
            gained = at[better]
            unknowns[gained], least[gained] = trial[better], left[better]
            steps[gained] = self._newton_steps(values[better], slopes[better])
            lost = max_norms(unknowns[at, :2] - self._point) > 2 * self.reach
            lengths = max_norms(steps[at]) / self._outline.size
            short = (lengths <= SHORTEST) | ((lengths <= SHORT) & (least[at] > STALLED))
            lost |= (least[at] > SLOWED) & (count >= PATIENCE)
            going[at] = np.isfinite(least[at]) & (least[at] > SETTLED) & ~lost & ~short
        return unknowns, least <= SETTLED

    def _newton_steps(self, values: Floats, slopes: Floats) -> Floats:
        """Solutions of the linearized equations (m, 3), none longer than a share of the square."""
        steps = np.array([np.linalg.lstsq(a, -b, rcond=None)[0] for a, b in zip(slopes, values, strict=True)])
        steps = steps.reshape(-1, 3)
        size = np.maximum(norms(steps[:, :2]) / (LONGEST * self.reach), 1.0)
        return steps / size[:, None]

    def _residuals(
        self, sets: tuple[Mask, Mask], unknowns: Floats, near: Floats
    ) -> tuple[Floats, Floats, Mask, Floats]:
        """``(1 - w) F_1 + w F_2`` (m, 3), its slopes (m, 3, 3), where both are known, and both of them (2, m, 3).

        Minimizers start from rates (2, m, 3) near them.
        """
        share, h = unknowns[:, 2, None], DIFFERENCE * self._outline.size
        both = np.concatenate(sets)
        here = self._motions.at(both, np.tile(unknowns[:, :2], (2, 1)), near.reshape(-1, 3))
        shifts = np.repeat([[h, 0.0], [0.0, h]], len(both), axis=0)
        centres = np.tile(unknowns[:, :2], (4, 1)) + shifts
        there = self._motions.at(np.tile(both, (2, 1)), centres, np.tile(here.rates, (2, 1)))
        rates = here.rates.reshape(2, -1, 3)
        moved = (there.rates.reshape(2, 2, -1, 3) - rates) / h
        known = np.asarray(here.known.reshape(2, -1).all(axis=0) & there.known.reshape(4, -1).all(axis=0))
        columns = [(1 - share) * first + share * second for first, second in moved]
        slopes = np.stack([*columns, rates[1] - rates[0]], axis=2)
        return (1 - share) * rates[0] + share * rates[1], slopes, known, rates

    def _headings(self, without: Mask, wheel: int, place: XY) -> list[float]:
        """At which the wheel lies under the edge, and of the others exactly those of a set under the body."""
        x, y = (float(entry) for entry in self.model.positions[wheel] - place)
        found = []
        for edge in self._balls.edge_headings(wheel, (arb(x), arb(y))):
            theta = float(edge.theta.mid())
            under = self._outline.depths(np.array([*place, theta])) > 0
            under[wheel] = False
            if (under == without).all():
                found.append(theta)
        return found

    def _balanced(self, carrying: Mask) -> Floats | None:
        """``c`` with ``sum N_i(c) f_i (1, p_i) = 0``, f_i at rest; None where there is none, or wheels stick."""
        wheels = np.flatnonzero(carrying)
        if len(wheels) < 3 or not self._pulls[wheels].any(axis=1).all():
            return None
        pulls = self._pulls[wheels]
        moments = np.column_stack([np.ones(len(wheels)), self.model.positions[wheels]])
        loaded, scale = np.ones(len(wheels), bool), np.abs(pulls).max()
        for _ in range(LOADED_SETS):
            stiffness = moments[loaded].T @ moments[loaded]
            if np.linalg.matrix_rank(stiffness) < 3:
                return None
            forms = moments @ np.linalg.inv(stiffness)
            balance = pulls[loaded].T @ forms[loaded]
            place, *_ = np.linalg.lstsq(balance[:, 1:], -balance[:, 0], rcond=None)
            pressed = forms @ [1.0, *place] > 0
            if (pressed == loaded).all():
                residual = np.abs(balance @ [1.0, *place]).max()
                return np.asarray(place) if residual <= BALANCED * scale else None
            loaded = pressed
        return None

    def _forces_at_rest(self) -> Floats:
        """Force and moment of every wheel under a body at rest, for each unit of load, (n, 3)."""
        forces = np.column_stack(self.model.sets.gradient(*self.model.targets.reshape(-1, 2).T))
        return row_products(forces[:, :, None], self.model.rows.reshape(-1, 2, 3))


def _least(left: Floats, met: ObservedSets) -> Indices:
    """The rows from which pairs are followed, those with the least residual first."""
    taken: dict[tuple[bytes, int], int] = {}
    chosen = []
    for k in np.argsort(left, kind="stable"):
        key = met.pairs[k].tobytes(), int(met.wheels[k])
        taken[key] = taken.get(key, 0) + 1
        if taken[key] <= STARTS and np.isfinite(left[k]):
            chosen.append(k)
    return np.array(chosen[:MOST_STARTS], int)
