"""The motion at the checked point under every load of a set, for the rules that minimize D.

Loads enter D linearly, so "a twist minimizes D" is a convex condition on them: it holds for all of them iff it holds at
the corners of their set, and where a function of the wheels alone implies it (what each wheel adds to the slope,
below), no corner is needed. Where it fails, one load of the set is the witness: under it the exact decision for known
loads finds that the point is no equilibrium.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from fractions import Fraction
from functools import cached_property
from itertools import combinations

import numpy as np

from nonsmooth.analysis.cells.box import build_box_partition
from nonsmooth.analysis.cells.contact_rule import has_cells, rule_of
from nonsmooth.analysis.cells.filippov import filippov_twists
from nonsmooth.analysis.cells.load_sets import LoadPolytope, Loads, LoadSet, SpringLoads, load_set, priced
from nonsmooth.analysis.cells.loads import LoadError, LoadRegion
from nonsmooth.analysis.cells.polygon import checked_square
from nonsmooth.proofs.boxes.linearization import Slip, Slope, slips_at, spin_candidates
from nonsmooth.proofs.clauses.at_point.cocircular import cocircular_array
from nonsmooth.proofs.clauses.at_point.ellipse import are_strict, common_twist, ellipse_point, held_forces, is_carried
from nonsmooth.proofs.findings import Equilibrium, Fact, Quantity
from nonsmooth.symbolic.mechanics.contact_states import (
    Row,
    Triple,
    Twist,
    added,
    combine,
    cross_product,
    independent,
    inner,
    rows_with_friction,
    scaled,
    scene_rows,
)
from nonsmooth.symbolic.mechanics.load_model import UnknownLoads
from nonsmooth.symbolic.mechanics.scene import Contact, Scene
from nonsmooth.symbolic.mechanics.springs import carried_table
from nonsmooth.symbolic.numbers.lazy import FLOAT_DOUBT
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_text import brief_text
from nonsmooth.symbolic.numbers.plane import cross, separating_direction
from nonsmooth.symbolic.numbers.plane_arrays import Floats, float_points
from nonsmooth.symbolic.numbers.square_roots import NestingError

# ---- sets of loads in floats ---------------------------------------------------------------------
#
# The least of linear functions over them with bounds of their errors, and samples.


INSIDE = 2.0**-10  # part of the middle in samples: at a corner wheels carry nothing


@dataclass(frozen=True, eq=False)
class FloatLoads:
    """``sum_k weights_k centres_k`` over all convex weights, plus ``[-1, 1]`` times each generator.

    Attributes:
        centres: the corners of the set, or the centre of a zonotope, (m, n).
        generators: of the zonotope, (g, n); none where the set is the hull of its corners.
    """

    centres: Floats
    generators: Floats

    @property
    def sizes(self) -> Floats:
        """Bounds of the loads of all wheels, (n,)."""
        reach: Floats = np.abs(self.centres).max(axis=0) + np.abs(self.generators).sum(axis=0)
        return reach

    def lowest(self, prices: Floats) -> Floats:
        """The least ``sum prices_i N_i``, rounded; prices (..., n)."""
        values: Floats = (prices @ self.centres.T).min(axis=-1) - np.abs(prices @ self.generators.T).sum(axis=-1)
        return values

    def doubt(self, sizes: Floats) -> Floats:
        """A bound of the error of the least value where rounded prices are sums of terms of these sizes, (..., n)."""
        error: Floats = sizes @ self.sizes * FLOAT_DOUBT
        return error

    def samples(self, directions: Floats) -> Floats:
        """Loads close to the corners at which linear functions (k, n) are least; under them every wheel carries."""
        ends = self.centres[np.argmin(directions @ self.centres.T, axis=1)]
        ends = ends - np.sign(directions @ self.generators.T) @ self.generators
        middle = self.centres.mean(axis=0)
        return np.unique((1 - INSIDE) * ends + INSIDE * middle, axis=0)


def float_loads(loads: LoadPolytope) -> FloatLoads:
    """A set of loads, each number rounded once."""
    count = len(loads.middle)
    generators = loads.generators if isinstance(loads, SpringLoads) else ()
    corners = (loads.centre,) if isinstance(loads, SpringLoads) else loads.corners or ()
    return FloatLoads(float_points(corners).reshape(-1, count), float_points(generators).reshape(-1, count))


# ---- what every wheel adds to the slope and to the curvature of D --------------------------------
#
# Per unit of its load, about a spin at the point.
#
# For ``D = sum N_i f_i`` about the twist ``xi_0 = (0, 0, omega)`` (centred scene)::
#
#     grad f_i = pull_i,        Hess f_i = bend_i w_i w_i^T        (bend_i = 0 at a corner of the friction set)
#
# as in :mod:`nonsmooth.proofs.boxes.linearization`.  Let one matrix B (3 x 2) give ``pull_i = B p_i`` for all
# wheels.  Then at every centre of mass c and under *every* admissible load ``grad D(xi_0) = sum N_i B p_i = B c``: it
# does not depend on how the wheels share the weight.  So ``xi_0`` minimizes D at c = 0 under every load, and to first
# order the body moves with ``xi - xi_0 = -H(N)^-1 B c``, ``H(N) = sum N_i bend_i w_i w_i^T``.


def wheel_slips(scene: Scene, omega: Number) -> tuple[Slip[Number], ...] | None:
    """Every wheel about ``(0, 0, omega)``; None where a term of D has no two derivatives, or a wheel no friction."""
    slips = slips_at(scene, under_load(scene, (scene.field.one,) * len(scene.wheels)), omega)
    return slips if len(slips) == len(scene.wheels) and all(slip.is_smooth for slip in slips) else None


def under_load(scene: Scene, loads: Loads) -> LoadRegion:
    """The loads at the point of a centred scene as the clauses at a point ask for them; how they change is left out."""
    zero = scene.field.zero
    domain = checked_square(scene)
    loaded = frozenset(wheel.index for wheel, load in zip(scene.wheels, loads, strict=True) if load)
    return LoadRegion(domain, tuple((load, zero, zero) for load in loads), loaded)


def common_slope(slips: Sequence[Slip[Number]]) -> Slope | None:
    """The B with ``pull_i = B p_i`` for every wheel; None where there is none, or exact numbers do not tell."""
    pair = next(((p, q) for p, q in combinations(slips, 2) if cross(p.position, q.position)), None)
    if pair is None or not _may_have_slope(slips, pair):
        return None
    p, q = pair
    scale = cross(p.position, q.position).inverse()
    try:
        slope = (
            scaled(added(scaled(p.pull, q.position[1]), scaled(q.pull, -p.position[1])), scale),
            scaled(added(scaled(q.pull, p.position[0]), scaled(p.pull, -q.position[0])), scale),
        )
        return slope if has_slope(slips, slope) else None
    except NestingError:
        return None


def _may_have_slope(slips: Sequence[Slip[Number]], pair: tuple[Slip[Number], Slip[Number]]) -> bool:
    """Whether balls leave a B open: where they do not, the roots in exact pulls need not be looked for.

    B is that of the pair: ``cross(p, q) pull_i = cross(p_i, q) pull_p + cross(p, p_i) pull_q`` for every wheel i.
    """
    p, q = pair
    try:
        pulls = [slip.map(Number.ball).pull for slip in (p, q, *slips)]
    except ValueError:  # balls that do not tell on which piece of its border a force is
        return True
    whole = cross(p.position, q.position).ball()
    for slip, pull in zip(slips, pulls[2:], strict=True):
        share, rest = cross(slip.position, q.position).ball(), cross(p.position, slip.position).ball()
        missing = (whole * x - share * a - rest * b for x, a, b in zip(pull, *pulls[:2], strict=True))
        if not all(entry.contains(0) for entry in missing):
            return False
    return True


def has_slope(slips: Sequence[Slip[Number]], slope: Slope) -> bool:
    """Whether ``pull_i = B p_i`` for every wheel."""
    return all(combine(wheel.position, slope) == wheel.pull for wheel in slips)


# ---- the motion at the point ---------------------------------------------------------------------


MOST_SHOWN = 8  # wheels whose loads are all written into a sentence
FEW_SHOWN = 3  # of more wheels


class EveryLoad(StrEnum):
    """What the body does at the point, whatever the load."""

    CARRIED = "carried by all wheels without slip"
    SMOOTH = "smooth minimizer"
    UNIQUE = "held: no other motion near the point"
    TIED = "a minimizer, under some loads not the only one"
    MOVED = "driven away under some load"
    OPEN = "not decided"


@dataclass(frozen=True)
class EveryLoadPoint:
    """The situation at the point with its evidence.

    Attributes:
        scene: the array, centred.
        loads: the set of loads.
        situation: see :class:`EveryLoad`.
        reason: one sentence for people.
        twist: a minimizer of D under every load, where one is known.
        slope: B, where ``pull_i = B p_i`` (smooth minimizers).
        witness: a load under which the point is no equilibrium.
    """

    scene: Scene
    loads: LoadSet
    situation: EveryLoad
    reason: str
    twist: Twist | None = None
    slope: Slope | None = None
    witness: Loads | None = None

    @property
    def equilibrium(self) -> Equilibrium:
        """Whether the translation part of the motion vanishes at the point under every load."""
        if self.situation is EveryLoad.OPEN:
            return Equilibrium.UNDECIDED
        if self.situation is EveryLoad.MOVED or self.twist is None or any(self.twist.velocity):
            return Equilibrium.FAILS
        return Equilibrium.HOLDS

    def undecided(self, reason: str) -> EveryLoadPoint:
        """The same point without a claim."""
        return replace(self, situation=EveryLoad.OPEN, twist=None, slope=None, witness=None, reason=reason)


def is_admissible(scene: Scene, loads: Loads) -> bool:
    """``N >= 0, sum N_i = 1, sum N_i p_i = 0``."""
    zero = scene.field.zero
    pairs = list(zip(loads, scene.positions, strict=True))
    moments = (sum((n * p[axis] for n, p in pairs), zero) for axis in (0, 1))
    return all(n >= 0 for n in loads) and sum(loads, zero) == 1 and not any(moments)


def every_load_point(scene: Scene) -> EveryLoadPoint:
    """Decide the situation at the point of a centred scene whose loads are unknown.

    Raises:
        LoadError: where the loads do not exist, or are too many.
    """
    loads = load_set(scene)
    if has_cells(scene):
        return _box_point(scene, loads)
    return _smooth_point(scene, loads)


def _smooth_point(scene: Scene, loads: LoadSet) -> EveryLoadPoint:
    zero = scene.field.zero
    region = under_load(scene, loads.reached.middle)
    carried = common_twist(scene, region)
    if carried is not None:
        reason = f"the twist ({', '.join(map(brief_text, carried))}) satisfies every row with friction of every wheel"
        # the wheels that carry fix the motion iff ``sum N_i a_k a_k^T``, linear in the loads, is positive definite
        corners = loads.bound.corners or (loads.bound.least,)
        fixed = all(is_carried(scene, under_load(scene, corner), carried) for corner in corners)
        situation = EveryLoad.CARRIED if fixed else EveryLoad.TIED
        return EveryLoadPoint(scene, loads, situation, reason, carried)
    if _rests_by_sticking(scene, loads):
        reason = "under every load the sticking wheels balance the others strictly inside their friction limits"
        return EveryLoadPoint(scene, loads, EveryLoad.UNIQUE, reason, Twist(zero, zero, zero))
    rates = spin_candidates(scene, region)
    for rate in rates:
        slips = wheel_slips(scene, rate)
        slope = None if slips is None else common_slope(slips)
        if slope is not None:
            reason = f"at {_motion_text(rate)} the friction of every wheel is linear in its place, so that it balances"
            reason += " under every load"
            return EveryLoadPoint(scene, loads, EveryLoad.SMOOTH, reason, Twist(zero, zero, rate), slope)
    reason = "forces do not balance alike under every load, but no load is found under which the body leaves the point"
    return _moved_or_open(scene, loads, _suspects(scene, loads, rates), reason)


def _motion_text(rate: Number) -> str:
    return f"the spin {brief_text(rate)}" if rate else "rest"


def _moved_or_open(scene: Scene, loads: LoadSet, suspects: Iterable[Loads], reason: str) -> EveryLoadPoint:
    """The point under the first of some loads that drives the body away; open for a reason where none does."""
    load = next((load for load in suspects if _is_refuted(scene, load)), None)
    if load is None:
        return EveryLoadPoint(scene, loads, EveryLoad.OPEN, reason)
    reason = f"under the load {load_text(load)} the body is driven away from the point"
    return EveryLoadPoint(scene, loads, EveryLoad.MOVED, reason, witness=load)


def load_text(loads: Loads) -> str:
    """The shares of the weight, rounded: of all wheels, of many those that carry most."""
    if len(loads) > MOST_SHOWN:
        heaviest = sorted(range(len(loads)), key=lambda k: -float(loads[k]))[:FEW_SHOWN]
        named = ", ".join(f"{float(loads[k]):.4g} on wheel {k + 1}" for k in heaviest)
        return f"({named}, the rest on others)"
    return f"({', '.join(f'{float(load):.4g}' for load in loads)})"


def _rolls(scene: Scene, twist: Twist) -> bool:
    """Whether every row with friction holds: D = 0, whatever the load and wherever the body is."""
    return not any(row.residual(twist) for row in rows_with_friction(scene))


def _rests_by_sticking(scene: Scene, loads: LoadSet) -> bool:
    """Whether sticking wheels hold the body at every corner of the set; strictly inside is a convex condition too."""
    if all(wheel.scaled_speed and wheel.friction.roll for wheel in scene.wheels) or loads.bound.corners is None:
        return False
    return all(
        are_strict(held_forces(scene, under_load(scene, corner), scene.field.zero)) for corner in loads.bound.corners
    )


def _suspects(scene: Scene, loads: LoadSet, rates: Sequence[Number]) -> Iterator[Loads]:
    """Loads under which a spin at one of the rates is far from balance; every wheel carries under them."""
    reached = loads.reached
    yield reached.middle
    for rate in rates:
        slips = wheel_slips(scene, rate)
        for axis in range(3) if slips is not None else ():
            prices = _prices(slips or (), axis)
            for side in (1, -1):
                yield mixed(reached.lowest([price * side for price in prices]), reached.middle)


def _prices(slips: Sequence[Slip[Number]], axis: int) -> list[Number]:
    """What each wheel adds to one component of the gradient, per unit of load; rounded where roots nest too deep."""
    try:
        return [slip.pull[axis] for slip in slips]
    except NestingError:
        return [slip.along.field.rational(Fraction(slip.map(float).pull[axis])) for slip in slips]


def mixed(first: Loads, second: Loads, share: int = 1) -> Loads:
    """A mean of two loads, of which the first counts so many times."""
    return tuple((share * a + b) / (share + 1) for a, b in zip(first, second, strict=True))


def _is_refuted(scene: Scene, load: Loads) -> bool:
    """Whether the point is no equilibrium under one load that may be, decided as for loads that are known."""
    if not is_admissible(scene, load):
        return False
    if has_cells(scene):
        return is_driven_away(scene, load)
    return ellipse_point(scene, (under_load(scene, load),)).equilibrium is Equilibrium.FAILS


def _box_point(scene: Scene, loads: LoadSet) -> EveryLoadPoint:
    """Slopes of D at a motion about the point are linear in the loads: exact linear programs over their set.

    Where a slope vanishes under some load, other motions minimize D there too, and beside the point all velocities may
    point to one side; the lemma on inward rims, c . v <= 0, excludes that, and so does a motion with D = 0, which is
    least beside the point too.
    """
    zero = scene.field.zero
    for rate in _box_rates(scene):
        slopes = build_slopes(scene, rate)
        least = -1 if slopes is None else slopes.least_sign(loads.bound)
        rolls = _rolls(scene, Twist(zero, zero, rate))
        if least > 0 or (least == 0 and (rolls or cocircular_array(scene) is not None)):
            situation = EveryLoad.UNIQUE if least > 0 else EveryLoad.TIED
            how = "D rises in every direction" if least > 0 else "D falls in no direction"
            reason = f"at {_motion_text(rate)} {how}, under every load"
            return EveryLoadPoint(scene, loads, situation, reason, Twist(zero, zero, rate))
    reason = "rest is not shown to be the motion under every load, nor is a load found that drives the body away"
    return _moved_or_open(scene, loads, moving_loads(scene, loads), reason)


def _box_rates(scene: Scene) -> list[Number]:
    """Rest, and the spins at which a wheel rolls without slip."""
    rates = {scene.field.zero: None}
    for row in scene_rows(scene):
        if row.normal[2]:
            rates[row.rhs / row.normal[2]] = None
    return list(rates)


# ---- slopes under the box rule -------------------------------------------------------------------
#
# At ``xi_0 = (0, 0, omega)`` let Z be the rows without residual, ``s_k`` the sign of the other residuals and ``b_k``
# the friction of a row per unit of load.  Along a direction m ::
#
#     D'(xi_0; m) = sum_i N_i price_i(m),
#     price_i(m) = sum_{k of i, in Z} b_k |a_k . m| + sum_{k of i, not in Z} b_k s_k a_k . m
#
# which is linear on the cells that the planes ``a_k . m = 0``, k in Z, cut out of all m.  So, where the ``a_k`` span, D
# falls along no m iff it falls along none of the rays ``+-a_k x a_l``, and ``min over loads of D' >= 0`` is a linear
# program for each of them, solved at a corner of the set of loads.
#
# Twenty wheels have hundreds of rays and of corners: floats with a bound of their error leave out the slopes that are
# certainly positive, and every other is computed exactly.


HALVINGS = 12  # of the square in which a load is followed: at the point the loads are positive
SUSPECTS = 4  # loads that are tried as witnesses: each takes the cells of a known load


@dataclass(frozen=True, eq=False)
class BoxSlopes:
    """The slopes of D at one twist.

    Attributes:
        scene: the array, centred.
        rows: those with friction.
        signs: of their residuals at the twist.
        rays: the directions that decide.
    """

    scene: Scene
    rows: tuple[Row, ...]
    signs: tuple[int, ...]
    rays: tuple[Triple, ...]

    def prices(self, k: int) -> list[Number]:
        """``price_i`` along a ray, exactly."""
        prices = [self.scene.field.zero] * len(self.scene.wheels)
        for row, side in zip(self.rows, self.signs, strict=True):
            rate = inner(row.normal, self.rays[k])
            change = rate * side if side else abs(rate)
            prices[self.scene.places[row.wheel.index]] += row.friction * change / row.wheel.length
        return prices

    @cached_property
    def float_prices(self) -> tuple[Floats, Floats]:
        """Rounded prices of all rays, shape (rays, wheels), and bounds of their errors."""
        normals = float_points(row.normal for row in self.rows)
        weights = np.array([float(row.friction) / float(row.wheel.length) for row in self.rows])
        rays = float_points(self.rays)
        signs, rates = np.array(self.signs), rays @ normals.T
        parts = np.where(signs == 0, np.abs(rates), rates * signs) * weights
        sizes = np.abs(rays) @ np.abs(normals).T * weights
        wheels = np.zeros((len(self.rows), len(self.scene.wheels)))
        wheels[np.arange(len(self.rows)), [self.scene.places[row.wheel.index] for row in self.rows]] = 1
        return parts @ wheels, sizes @ wheels * FLOAT_DOUBT

    def float_lowest(self, loads: LoadPolytope) -> tuple[Floats, Floats]:
        """The least slope along every ray over a set of loads, rounded, and bounds of the errors."""
        prices, doubts = self.float_prices
        floats = float_loads(loads)
        return floats.lowest(prices), doubts @ floats.sizes + floats.doubt(np.abs(prices))

    def least_sign(self, loads: LoadPolytope) -> int:
        """The sign of the least slope over all rays and loads."""
        values, doubt = self.float_lowest(loads)
        least = 1
        for k in np.argsort(values):
            if values[k] > doubt[k]:
                continue
            prices = self.prices(int(k))
            least = min(least, priced(prices, loads.lowest(prices)).sign())
            if least < 0:
                break
        return least


def build_slopes(scene: Scene, omega: Number) -> BoxSlopes | None:
    """The slopes at ``(0, 0, omega)``; None where the rows that hold there do not span."""
    twist = Twist(scene.field.zero, scene.field.zero, omega)
    rows = tuple(rows_with_friction(scene))
    signs = tuple(row.residual(twist).sign() for row in rows)
    rays = _rays([row for row, side in zip(rows, signs, strict=True) if not side])
    return None if rays is None else BoxSlopes(scene, rows, signs, rays)


def _rays(tight: Sequence[Row]) -> tuple[Triple, ...] | None:
    """``+-a_k x a_l`` of the rows without residual; None where they do not span."""
    normals = [row.normal for row in tight]
    if len(independent(normals)) < 3:
        return None
    products = {cross_product(a, b): None for a, b in combinations(normals, 2)}
    return tuple(scaled(ray, side) for ray in products if any(ray) for side in (1, -1))


def moving_loads(scene: Scene, loads: LoadSet) -> Iterator[Loads]:
    """Loads under which D falls from rest, the steepest first; every wheel carries under them."""
    reached = loads.reached
    yield reached.middle
    slopes = build_slopes(scene, scene.field.zero)
    if slopes is None:
        return
    values, _ = slopes.float_lowest(reached)
    for k in np.argsort(values)[:SUSPECTS]:
        prices = slopes.prices(int(k))
        lowest = reached.lowest(prices)
        if priced(prices, lowest).sign() < 0:
            yield mixed(lowest, reached.middle, 3)


def is_driven_away(scene: Scene, load: Loads) -> bool:
    """Whether the point is no equilibrium under a load that is carried to its neighbourhood; every wheel carries."""
    table = carried_table(load, scene.positions)
    known = replace(scene, contact=Contact(scene.contact.rule, table))
    for _ in range(HALVINGS):
        try:
            partition = build_box_partition(known)
        except LoadError:
            known = replace(known, check=replace(known.check, radius=known.check.radius / 2))
            continue
        velocities = [twist.velocity for twist in filippov_twists(partition)]
        return separating_direction(velocities) is not None
    return False


# ---- what is said of loads that are unknown ------------------------------------------------------
#
# Which are meant, and the load for which a clause fails.


def load_facts(scene: Scene) -> Iterator[Fact]:
    """Which loads the verdicts speak of; nothing where they are known."""
    unknown = scene.contact.loads
    if isinstance(unknown, UnknownLoads):
        words = f"loads: {unknown.words}"
        if not rule_of(scene).needs_loads:
            words = f"rule {scene.contact.rule} asks for no loads: what it says holds for all of them"
        yield Fact("loads", unknown.words, words)


def witness_load(loads: Loads | None) -> Fact:
    """The load for which a clause fails, wheel by wheel, as shares of the weight."""
    return Fact("load", Quantity(loads))
