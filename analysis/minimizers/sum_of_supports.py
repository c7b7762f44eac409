"""``min_y sum_i w_i h_i(E_i y - e_i) - G . y``: sums of support functions of plane convex sets, many problems at once.

The unknowns are three; ``h_i(r) = max p . r over p in K_i`` with K_i a friction set in units of its half-axes, G a pull
(mostly none).  The dual is ``max -sum w_i p_i . e_i`` over forces p_i in K_i that balance it, ``sum w_i E_i^T p_i =
G``; unknowns and balanced forces in their sets with equal values prove each other (:meth:`SupportSums.judge`), however
they were found.

Three methods find it.

- *Holding* (:func:`by_holding`), for whole discs, where one contact sticks or none.  The sum is smooth but where a
  contact sticks, and two that stick leave no choice of y.  The contact that slips least at a guess is held: one unknown
  is left, and the force that balances the others is that of the contact.  Where it is too large the contact slips, by
  an amount that is known to second order; from there Newton's method takes all unknowns.  Nearly all problems of few
  contacts end here.
- *Multipliers* (:func:`by_multipliers`), for any sets that know their nearest point.  With a stiffness c the forces are
  ``p_i(y) = nearest point of K_i to p_i + c r_i(y)``; they are the derivative of a convex function of y that has a
  continuous gradient, which Newton's method minimizes; then p takes their place.  Far from the solution that takes some
  dozens of steps, beside it two or three, and there it ends with the rounding of doubles.
- *Smoothing* (:func:`by_smoothing`), for cut discs.  Norms become ``sqrt(|r|^2 + g^2)``, and steps are Newton's on
  ``sqrt(|r|^2 + g^2) p = r`` with p as an unknown of its own (Chan, Golub and Mulet): full steps of y settle from
  anywhere while g falls to a third with each.  After seven steps multipliers finish most problems.

Arrays have the shape (n, m): n sets, m problems, in blocks that fit the processor's cache.

References: Rockafellar (1976), Math. Oper. Res. 1; Chan, Golub, Mulet (1999), SIAM J. Sci. Comput. 20; Conn, Gould,
Toint (2000), Trust-Region Methods, section 7.3 (the equation of a radius); Li, Sun, Toh (2018), SIAM J. Optim. 28
(Newton's method within the method of multipliers).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from nonsmooth.symbolic.mechanics.friction_set import FrictionSets, UnitDiscs
from nonsmooth.symbolic.numbers.plane_arrays import Floats, Indices, Mask, row_products

TINY = 1e-300  # keeps 0/0 at 0
ROUNDING = 1e-16  # multiple of the identity beside a Hessian, of its trace: a singular one (a face) stays solvable
REGULAR = 1e-14  # the same where nothing else keeps steps short
CACHED = 16384  # sets handled together: their arrays fit the processor's cache
# Problems handled together at least: fewer would pay more for Python than for floats.  With many more, products of
# matrices for hundreds of wheels are so large that BLAS shares them among threads, which takes ten times as long.
SMALLEST_BLOCK = 32
COMPACT = 0.9  # unsolved share of a block at which the solved problems are taken out

# What proves a solution.
GAP = 1e-13  # relative to the value: rounding of the sum
GAP_FLOOR = 2e-18  # relative to the value at y = 0: below lies the rounding of the slips themselves
EXCESS = 1e-15  # of a force over its set: rounding of a unit vector
IMBALANCE = 4e-15  # relative to the sum of the weights: rounding of the sum
SLIP_NOISE = 1e-15  # of slips: rounding.  Where all are no larger nothing slips, and no gap is small beside the value


class SupportSums:
    """Problems; weights are divided by their sums.

    Args:
        weights: w, shape (n, m).
        maps: E_i, shape (n, 2, 3), columns of comparable size.
        targets: e_i of order 1, shape (2, n, m), or (2, n, 1) for all problems alike.
        sets: K_i.
        pulls: G, shape (3, m); none unless given.
    """

    def __init__(
        self, weights: Floats, maps: Floats, targets: Floats, sets: FrictionSets, pulls: Floats | None = None
    ) -> None:
        whole = np.maximum(weights.sum(axis=0), TINY)
        self.weights, self.pulls = weights / whole, None if pulls is None else pulls / whole
        self.maps, self.targets, self.sets = maps, targets, sets
        self._columns = maps.transpose(2, 1, 0).reshape(3, -1)
        self._pairs = np.concatenate(quadratic_parts(maps)).T
        self.start = (self.weights * np.sqrt(np.square(targets).sum(axis=0))).sum(axis=0)

    def take(self, chosen: Mask | Indices) -> SupportSums:
        """Only some problems."""
        targets = self.targets if self.targets.shape[-1] == 1 else self.targets[..., chosen]
        pulls = None if self.pulls is None else self.pulls[:, chosen]
        return SupportSums(self.weights[:, chosen], self.maps, targets, self.sets, pulls)

    def moved(self, y: Floats) -> Floats:
        """``E_i y``, shape (2, n, m), of y (3, m)."""
        return self.maps.transpose(1, 0, 2) @ y

    def slips(self, y: Floats) -> Floats:
        """``E_i y - e_i``."""
        return self.moved(y) - self.targets

    def values(self, y: Floats) -> Floats:
        """What is to be least, shape (m,)."""
        value = (self.weights * self.sets.support(*self.slips(y))).sum(axis=0)
        return value if self.pulls is None else value - (self.pulls * y).sum(axis=0)

    def total(self, forces: Floats) -> Floats:
        """``sum_i w_i E_i^T p_i - G``, shape (3, m)."""
        total = self._columns @ np.concatenate(self.weights * forces)
        return total if self.pulls is None else total - self.pulls

    def hessian(self, rates: Floats) -> Floats:
        """Upper triangles of ``sum_i w_i E_i^T S_i E_i``, shape (6, m), for ``S_i = rates (xx, yy, xy)``, (3, n, m)."""
        return self._pairs @ np.concatenate(self.weights * rates)

    def newton_step(self, total: Floats, rates: Floats, shift: Floats | float, rounding: float) -> Floats:
        """``-(sum_i w_i E_i^T S_i E_i + shift)^-1 total`` with ``S_i = rates (xx, yy, xy)``, shape (3, n, m).

        The shift is made larger by ``rounding`` of the trace.
        """
        matrix = self.hessian(rates)
        return -_solve(matrix, total, shift + rounding * (matrix[0] + matrix[3] + matrix[5]) + TINY)

    def judge(self, slips: Floats, forces: Floats) -> Judgement:
        """What slips and forces prove of each other."""
        sizes, excess = self.sets.support(*slips), self.sets.excess(*forces)
        values = (self.weights * sizes).sum(axis=0)
        gap = np.abs((self.weights * (sizes - slips[0] * forces[0] - slips[1] * forces[1])).sum(axis=0))
        beyond, imbalance = np.maximum(excess.max(axis=0), 0.0), np.abs(self.total(forces)).max(axis=0)
        proved = (gap <= GAP * values + GAP_FLOOR * self.start) | (sizes.max(axis=0) <= SLIP_NOISE)
        proved &= (beyond <= EXCESS) & (imbalance <= IMBALANCE)
        lacks = gap + beyond * values + imbalance  # of power, at speeds of order one
        finite = np.isfinite(lacks)
        return Judgement(values, excess, np.where(finite, lacks, np.inf), proved & finite)


class Judgement(NamedTuple):
    """Values (m,), by how much forces leave their sets (n, m), what lacks to a proof and whether it is one, (m,)."""

    values: Floats
    excess: Floats
    lacks: Floats
    proved: Mask


class Solutions:
    """The best unknowns (3, m) and forces (2, n, m) so far, what they lack, and whether they are proved, (m,).

    By multipliers, also the Newton steps that come next, relative to the unknowns, (m,).
    """

    def __init__(self, sets: int, problems: int) -> None:
        self.y, self.forces = np.zeros((3, problems)), np.zeros((2, sets, problems))
        self.lacks, self.proved = np.full(problems, np.inf), np.zeros(problems, bool)
        self.steps = np.full(problems, np.inf)

    def keep(self, at: Indices, y: Floats, forces: Floats, lacks: Floats, proved: Mask) -> None:
        """Keep solutions of problems ``at`` that are proved, the last ones of them, or lack less than before."""
        chosen = np.flatnonzero(proved | (~self.proved[at] & (lacks < self.lacks[at])))
        at = at[chosen]
        self.y[:, at], self.forces[..., at] = y.take(chosen, axis=-1), forces.take(chosen, axis=-1)
        self.lacks[at], self.proved[at] = lacks[chosen], proved[chosen]


# ---- the method of multipliers -------------------------------------------------------------------

STIFFNESS = 1e4  # c beside a solution, over the mean slip
PUSH = 0.5  # share of the slack of a force up to which c times the slip may push it where a contact sticks
FIRST_STIFFNESS = 10.0  # from nothing
STIFFER = 10.0  # factor of c after a multiplier step that lacks too much
STIFFEST = 1e12
LESS_STIFF = 1e8  # where loads differ by many orders of magnitude rounding of more hides the small ones
FALL = 0.1  # what it should lack after a multiplier step, relative to before
LOOSE = 0.1  # imbalance, times c, at which p takes the place of multipliers
ANCHOR = 1e-3  # weight of the distance to the last y, over c: a curvature for all directions
FLATTER = 0.5  # share of the first slope along a step up to which it may rise at its end
PASSES = 3000  # from nothing: most problems take some forty, those with weights of many magnitudes a thousand
SETTLED = 1e-13  # step, relative to the unknowns, after which no other is needed


def by_multipliers(
    sums: SupportSums,
    y: Floats,
    forces: Floats,
    stiffness: Floats,
    passes: int = PASSES,
    stiffest: float = STIFFEST,
) -> Solutions:
    """Solutions from unknowns (3, m), forces (2, n, m) and stiffness (m,).

    Each pass looks at one trial of each problem: a Newton step that ends on a rising slope is halved; where the forces
    nearly balance they become the multipliers.
    """
    found = Solutions(*forces.shape[1:])
    at, base, step, share = np.arange(y.shape[1]), y, np.zeros_like(y), np.ones(y.shape[1])
    anchor, falls, last = y, np.full(y.shape[1], np.inf), np.full(y.shape[1], np.inf)
    for _ in range(passes):
        trial = base + share * step
        slips = sums.slips(trial)
        near = sums.sets.nearest(*(forces + stiffness * slips))
        pull = ANCHOR / stiffness
        slope = sums.total(near.force) + pull * (trial - anchor)
        rise = (slope * step).sum(axis=0)
        short = rise > FLATTER * falls
        newton = sums.newton_step(slope, stiffness * near.rates, pull, ROUNDING)
        linear = near.force + near.along(stiffness * sums.moved(newton))
        values, excess, lacks, proved = sums.judge(slips, linear)
        known = found.proved[at]
        found.keep(at, trial, linear, lacks, proved)
        moved = np.abs(newton).max(axis=0) / np.maximum(np.abs(trial).max(axis=0), TINY)
        found.steps[at] = moved
        # a gap grows as the square of the error: a proof alone does not say that the unknowns are right to rounding
        going = ~(known & proved & (moved <= SETTLED))
        if not going.any():
            break
        balanced = ~short & (np.abs(slope).max(axis=0) <= np.maximum(LOOSE / (1 + stiffness), SLIP_NOISE * stiffness))
        slow = balanced & ((stiffness * values < STIFFNESS) | (lacks > FALL * last))
        forces = np.where(balanced, linear / np.maximum(1 + excess, 1.0), forces)
        last, anchor = np.where(balanced, lacks, last), np.where(balanced, trial, anchor)
        stiffness = np.where(slow, np.minimum(stiffness * STIFFER, stiffest), stiffness)
        falls = np.where(short, falls, np.where(balanced, np.inf, -(slope * newton).sum(axis=0)))
        base, step, share = np.where(short, base, trial), np.where(short, step, newton), np.where(short, share / 2, 1.0)
        if np.count_nonzero(going) < COMPACT * len(at):
            at, sums, forces = at[going], sums.take(going), forces[..., going]
            base, step, anchor = base[:, going], step[:, going], anchor[:, going]
            share, falls, last, stiffness = share[going], falls[going], last[going], stiffness[going]
    return found


def finished(
    sums: SupportSums,
    y: Floats,
    forces: Floats,
    softness: Floats | float,
    passes: int,
    stiffest: float = STIFFEST,
) -> Solutions:
    """Solutions by multipliers from unknowns and forces beside them, with 1/c at least ``softness``."""
    mean_slip = sums.judge(sums.slips(y), forces).values
    softness = np.maximum(mean_slip / STIFFNESS, np.maximum(softness, 1 / stiffest))
    return by_multipliers(sums, y, forces, 1 / softness, passes, stiffest)


def softness_that_sticks(sums: SupportSums, y: Floats, forces: Floats) -> Floats:
    """The least 1/c, shape (m,), at which contacts that stick are pushed no further than :data:`PUSH`.

    Of the slip of a contact and the slack of its force one vanishes at the solution: it sticks where the slip is the
    smaller one.
    """
    slips, slack = sums.sets.support(*sums.slips(y)), -sums.sets.excess(*forces)
    return np.where(slips < slack, slips / (PUSH * slack), 0.0).max(axis=0)


# ---- holding -------------------------------------------------------------------------------------

HELD_STEPS = 5  # of Newton's method in one unknown
SLIP_STEPS = 5  # of Newton's method for the size of a slip
FREE_STEPS = 6  # of Newton's method in three unknowns


class HeldContact(NamedTuple):
    """The contact k that is held in each problem.

    Attributes:
        at: k and the numbers of the problems, indices of arrays (n, m).
        weights: of the contacts, (m,).
        way: t of length one with ``E_k t = 0``, shape (3, m).
        back: B with ``E_k B = 1`` and ``B^T t = 0``, shape (3, 2, m).
    """

    at: tuple[Indices, Indices]
    weights: Floats
    way: Floats
    back: Floats

    def take(self, chosen: Indices) -> HeldContact:
        """Only some problems."""
        at = self.at[0][chosen], np.arange(len(chosen))
        return HeldContact(at, self.weights[chosen], self.way[:, chosen], self.back[..., chosen])


def by_holding(found: Solutions, at: Indices, sums: SupportSums, guess: Floats) -> None:
    """Keep what Newton's method finds for discs of radius one, from guesses of the unknowns (3, m)."""
    held = _least_slipping(sums, guess)
    y, units, step = _along_way(sums, held, guess)
    force = -_transposed(held.back, sums.total(units)) / np.maximum(held.weights, TINY)
    forces = units.copy()
    forces[:, *held.at] = force
    _keep_settled(found, at, sums, y, forces, step)
    rest = np.flatnonzero(~found.proved[at])
    if not len(rest):
        return
    few, fixed = sums.take(rest), held.take(rest)
    start = y[:, rest] + _little_slip(few, fixed, units[..., rest], few.slips(y[:, rest]), force[:, rest])
    start = np.where(few.values(start) < few.values(guess[:, rest]), start, guess[:, rest])
    _keep_settled(found, at[rest], few, *_freely(few, start))


def _keep_settled(found: Solutions, at: Indices, sums: SupportSums, y: Floats, forces: Floats, step: Floats) -> None:
    """Keep what unknowns and forces are worth after the last step (3, m): proved only where it settled."""
    judged = sums.judge(sums.slips(y), forces)
    settled = np.abs(step).max(axis=0) <= SETTLED * np.abs(y).max(axis=0)
    found.keep(at, y, forces, judged.lacks, judged.proved & settled)


def _least_slipping(sums: SupportSums, y: Floats) -> HeldContact:
    """The loaded contacts that slip least."""
    slips = np.where(sums.weights > 0, sums.sets.support(*sums.slips(y)), np.inf)
    contacts = slips.argmin(axis=0)
    at = contacts, np.arange(len(contacts))
    first, second = sums.maps[contacts].transpose(1, 2, 0)
    normal = np.cross(first, second, axis=0)
    area = (normal * normal).sum(axis=0)
    back = np.array([np.cross(second, normal, axis=0), np.cross(normal, first, axis=0)]) / area
    return HeldContact(at, sums.weights[at], normal / np.sqrt(area), back.transpose(1, 0, 2))


def _along_way(sums: SupportSums, held: HeldContact, y: Floats) -> tuple[Floats, Floats, Floats]:
    """The best unknowns that hold the contacts, the forces of all others (2, n, m), and the last step (3, m)."""
    y = y - row_products(held.back, sums.slips(y)[:, *held.at])
    (r, s), (along, across) = sums.slips(y), sums.moved(held.way)
    weights, square = sums.weights.copy(), along * along + across * across
    weights[held.at] = 0.0
    pull = 0.0 if sums.pulls is None else (held.way * sums.pulls).sum(axis=0)
    a = np.zeros(y.shape[1])
    for _ in range(HELD_STEPS):
        x, z = r + a * along, s + a * across
        inverse = 1 / np.maximum(np.sqrt(x * x + z * z), TINY)
        rate = (x * along + z * across) * inverse
        bend = (weights * inverse * (square - rate * rate)).sum(axis=0)
        step = (pull - (weights * rate).sum(axis=0)) / np.maximum(bend, TINY)
        a = a + step
    units = np.array([x * inverse, z * inverse])
    units[:, *held.at] = 0.0
    return y + held.way * a, units, held.way * step


def _little_slip(sums: SupportSums, held: HeldContact, units: Floats, slips: Floats, force: Floats) -> Floats:
    """The change of y with which contacts slip that a force f (2, m) pushes, where the others change to second order.

    With S the Hessian of the others by the slip of the contact, their best answer along t taken out, the slip is ``v =
    s q``, ``(s S + w_k) q = w_k f`` and ``|q| = 1``; Newton's method solves ``1/|q| = 1`` for s.
    """
    rates = _turns(units) / np.maximum(sums.sets.support(*slips), TINY)
    rates[:, *held.at] = 0.0
    hessian = sums.hessian(rates)[_SQUARE].reshape(3, 3, -1)
    bent = row_products(hessian, held.way)
    bend = np.maximum((held.way * bent).sum(axis=0), TINY)
    coupled = _transposed(held.back, bent)
    first, second = (_transposed(held.back, row_products(hessian, held.back[:, k])) for k in range(2))
    xx, xy = (first - coupled[0] * coupled / bend) / held.weights
    yy = (second - coupled[1] * coupled / bend)[1] / held.weights
    s = np.zeros(force.shape[1])
    for _ in range(SLIP_STEPS):
        q = _solve_pair(1 + s * xx, s * xy, 1 + s * yy, force)
        turned = _solve_pair(1 + s * xx, s * xy, 1 + s * yy, np.array([xx * q[0] + xy * q[1], xy * q[0] + yy * q[1]]))
        size = np.sqrt((q * q).sum(axis=0))
        s = np.maximum(s + size * size * (size - 1) / np.maximum((q * turned).sum(axis=0), TINY), 0.0)
    slip = s * q
    return row_products(held.back, slip) - held.way * ((coupled * slip).sum(axis=0) / bend)


def _turns(units: Floats) -> Floats:
    """The derivative of units (2, n, m) by slips of length one, its entries ``(xx, yy, xy)``: across, nothing along."""
    x, z = units
    return np.array([z * z, x * x, -x * z])


def _freely(sums: SupportSums, y: Floats) -> tuple[Floats, Floats, Floats]:
    """Unknowns, forces and the last step, after Newton steps in all three unknowns.

    Forces take part in the last step, which balances them: those of slips that are nearly zero hardly know where to.
    """
    for _ in range(FREE_STEPS):
        slips = sums.slips(y)
        inverse = 1 / np.maximum(sums.sets.support(*slips), TINY)
        units = slips * inverse
        xx, yy, xy = rates = _turns(units) * inverse
        step = sums.newton_step(sums.total(units), rates, 0.0, REGULAR)
        y = y + step
    along, across = sums.moved(step)
    return y, units + np.array([xx * along + xy * across, xy * along + yy * across]), step


# ---- smoothing -----------------------------------------------------------------------------------

SMOOTHER_STEPS = 50
FASTEST = 0.3  # factor of g with a step: the slips of contacts that stick have to follow
BLOCKED = 0.2  # share of a step of the forces below which g rises
RISE = 3.0  # factor of g then
TO_BORDER = 0.95  # share of the way to the border of its set that a force takes
HOLDS = (1, 3, 5)  # steps after which holding tries to finish
FINISHES = (7, 10, 14, 20, 30, 50)  # steps after which multipliers try to finish
FINISH_PASSES = 8


class Smoothed(NamedTuple):
    """Iterates: unknowns (3, m), forces (2, n, m) inside their sets, speeds of rollers (n, m), and g (m,)."""

    y: Floats
    forces: Floats
    turning: Floats
    g: Floats

    def take(self, chosen: Mask) -> Smoothed:
        """Only some problems."""
        return Smoothed(*(array[..., chosen] for array in self))


def by_smoothing(
    weights: Floats,
    maps: Floats,
    targets: Floats,
    sets: FrictionSets,
    passes: int = PASSES,
    pulls: Floats | None = None,
) -> tuple[Floats, Floats]:
    """Minimizers y, shape (m, 3), and forces, shape (m, n, 2), with ``sum_i w_i E_i^T p_i = G``, by all methods.

    Args:
        weights: w, shape (m, n), at least 0.
        maps: E_i, shape (n, 2, 3), columns of comparable size.
        targets: e_i of order 1, shape (n, 2), or (m, n, 2) where every problem has its own.
        sets: K_i; of others than cut discs multipliers find all.
        passes: of multipliers, from nothing, for what smoothing does not finish.
        pulls: G, shape (m, 3); none unless given.  One beyond all friction leaves nothing to find.
    """
    size = max(SMALLEST_BLOCK, CACHED // weights.shape[1])
    found = []
    with np.errstate(all="ignore"):  # a problem at the limit of doubles may divide by 0; that step is not kept
        for first in range(0, max(len(weights), 1), size):
            block = slice(first, first + size)
            offsets = targets[block] if targets.ndim == 3 else targets[None]
            columns = np.ascontiguousarray(offsets.transpose(2, 1, 0))
            back = None if pulls is None else np.ascontiguousarray(pulls[block].T)
            sums = SupportSums(np.ascontiguousarray(weights[block].T), maps, columns, sets, back)
            found.append(_solved(sums, sets, passes))
    forces = [each.forces.transpose(2, 1, 0) for each in found]
    return np.concatenate([each.y.T for each in found]), np.concatenate(forces)


def _solved(sums: SupportSums, sets: FrictionSets, passes: int) -> Solutions:
    """The problems of one block."""
    n, m = sums.weights.shape
    found, at = Solutions(n, m), np.arange(m)
    if isinstance(sets, UnitDiscs):
        at, sums = _smoothed(found, at, sums, sets)
    stiffness = np.full(len(at), FIRST_STIFFNESS)
    rest = by_multipliers(sums, np.zeros((3, len(at))), np.zeros((2, n, len(at))), stiffness, passes)
    found.keep(at, rest.y, rest.forces, rest.lacks, rest.proved)
    return found


def _smoothed(found: Solutions, at: Indices, sums: SupportSums, sets: UnitDiscs) -> tuple[Indices, SupportSums]:
    """The problems that holding, and steps of smoothing, leave without a proof; the others are found."""
    n, m = sums.weights.shape
    first = np.broadcast_to(np.maximum(sums.start, TINY), m)
    state = Smoothed(np.zeros((3, m)), np.zeros((2, n, m)), np.zeros((n, m)), first)
    for count in range(1, SMOOTHER_STEPS + 1):
        state = smoother_step(sums, sets, state)
        if count in HOLDS and sets.is_whole:
            by_holding(found, at, sums, state.y)
        elif count in FINISHES:
            _finish(found, at, sums, state, LESS_STIFF if FINISHES.index(count) % 2 == 0 else STIFFEST)
        else:
            continue
        going = ~found.proved[at]
        at, sums, state = at[going], sums.take(going), state.take(going)
        if not len(at):
            break
    return at, sums


def _finish(found: Solutions, at: Indices, sums: SupportSums, state: Smoothed, stiffest: float) -> None:
    """Keep what the iterates are worth, and what multipliers make of them."""
    judged = sums.judge(sums.slips(state.y), state.forces)
    found.keep(at, state.y, state.forces, judged.lacks, judged.proved)
    softness = softness_that_sticks(sums, state.y, state.forces)
    better = finished(sums, state.y, state.forces, softness, FINISH_PASSES, stiffest)
    found.keep(at, better.y, better.forces, better.lacks, better.proved)


def smoother_step(sums: SupportSums, sets: UnitDiscs, state: Smoothed) -> Smoothed:
    """One step of y, forces and rollers, and the next g."""
    near = sets.approach(sums.slips(state.y), state.forces, state.turning, state.g)
    step = sums.newton_step(sums.total(state.forces + near.move), near.rates, 0.0, REGULAR)
    change = near.change(*sums.moved(step))
    shares = np.minimum(1.0, TO_BORDER * sets.longest_step(state.forces, change).min(axis=0))
    g = state.g * np.where(shares < BLOCKED, RISE, np.maximum(FASTEST, 1 - shares))
    after = Smoothed(state.y + step, state.forces + shares * change, state.turning + near.turned(change), g)
    sound = np.isfinite(g) & np.isfinite(after.y).all(axis=0) & np.isfinite(after.forces).all(axis=(0, 1))
    stays = state._replace(g=RISE * state.g)
    return Smoothed(*(np.where(sound, new, old) for new, old in zip(after, stays, strict=True)))


# ---- three unknowns ------------------------------------------------------------------------------

_ROW, _COLUMN = np.triu_indices(3)
_SQUARE = [0, 1, 2, 1, 3, 4, 2, 4, 5]  # entries of a symmetric matrix in its upper triangle


def _transposed(matrix: Floats, vector: Floats) -> Floats:
    """``B^T v`` of m matrices (3, 2, m) and vectors (3, m)."""
    return (matrix * vector[:, None]).sum(axis=0)


def _solve_pair(xx: Floats, xy: Floats, yy: Floats, right: Floats) -> Floats:
    """Solve m symmetric systems of two unknowns for right sides (2, m)."""
    return np.array([yy * right[0] - xy * right[1], xx * right[1] - xy * right[0]]) / (xx * yy - xy * xy)


def quadratic_parts(maps: Floats) -> Floats:
    """Upper triangles of ``E_i^T S E_i`` as sums over the entries ``(xx, yy, xy)`` of S, for maps E (n, 2, 3).

    Shape (3, n, 6).
    """
    first, second = maps[:, 0], maps[:, 1]
    return np.stack([_products(first, first), _products(second, second), 2 * _products(first, second)])


def _products(first: Floats, second: Floats) -> Floats:
    """Upper triangles of the symmetric parts of ``first_i second_i^T``, shape (n, 6)."""
    outer = np.einsum("ni,nj->nij", first, second)
    return ((outer + outer.transpose(0, 2, 1)) / 2)[:, _ROW, _COLUMN]


def _solve(matrix: Floats, right: Floats, shift: Floats) -> Floats:
    """Solve m systems with upper triangles (6, m) for right sides (3, m) by LDL^T in closed form."""
    xx, xy, xz, yy, yz, zz = matrix
    d0 = xx + shift
    l10, l20 = xy / d0, xz / d0
    d1 = yy + shift - l10 * xy
    rest = yz - l10 * xz
    l21 = rest / d1
    d2 = zz + shift - l20 * xz - l21 * rest
    x0, x1, x2 = right
    x1 = x1 - l10 * x0
    x2 = (x2 - l20 * x0 - l21 * x1) / d2
    x1 = x1 / d1 - l21 * x2
    return np.array([x0 / d0 - l10 * x1 - l20 * x2, x1, x2])
