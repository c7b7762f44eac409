"""Where bodies end under a rule without cells: paths of many starts at once, in floats.

The field ``c' = v(c) + omega(c) J c`` is continuous, so all paths are integrated together (Bogacki and Shampine's pair
of orders 2 and 3, then backward differentiation formulas where the field is stiff) until each has left the square or
stands still; Newton's method then finds where the field vanishes.
Where twists jump, as under rule ``roller``, bodies may slide to a point at full speed and stay there, in steps to and
fro: one that gets nowhere for a while is taken to stand.
Along the paths D is slightly smoothed, and each minimizer begins at the last one of its path; at the starts and where
the bodies stand it is the rule's own, with its proof.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from nonsmooth.analysis.cells.contact_rule import SmoothRule, smooth_rule_of
from nonsmooth.analysis.fields.contact_model import contacts_under
from nonsmooth.analysis.minimizers.ellipse_minimizer import minima_under
from nonsmooth.analysis.minimizers.many_twists import MovingTwists
from nonsmooth.analysis.minimizers.minimum import free_motions, may_jump
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.under_way import tell_count
from nonsmooth.symbolic.numbers.plane_arrays import (
    Floats,
    Indices,
    Mask,
    field_beside,
    max_norm,
    max_norms,
    norm,
    norms,
    point_velocities,
)

MOST_MINIMA = 10_000  # proved minimizations in all: a few seconds; what still moves then stays unknown
SMALLEST = 50  # minimizations that take as long as what every call costs, however few points it has
MOST_WORK = 6_500_000_000  # multiplications of all steps of smoothed minimizations: some thirteen seconds
MOST_FACES = 1_000  # points at which several motions tie, as they may by symmetry; more, and nothing is determined
CROSSINGS = 8.0  # of the square at the largest speed of the starts: how long the first stretch of time is
STRETCHES = 5  # of time, each twice as long as the one before
TOLERANCE = 1e-3  # of the half side, for each step: enough to tell places apart
STILL = 1e-3  # of the largest speed of the starts: slower bodies stand still
EXPLICIT_STEPS, IMPLICIT_STEPS = 50, 2_000  # in one stretch of time; what still moves then goes on from there
NEWTON_STEPS = 8
STEP = 1e-6  # of the half side: over which the field is differentiated
PIECES = 24  # of a stretch, where twists jump; a body that gets nowhere in two of them stands
BRISK = 0.1  # of the largest speed of the starts: bodies that get nowhere at such a speed step to and fro
SHRINKING, TIMES = 14, 8  # steps to and fro get half as long so often, and are made so many times
JUMPED = 1e-4  # of the half side: to which a place that jumps surround is rounded
GRID = 1e-12  # of the half side: to which places are rounded, so that zero is zero
TOGETHER = 1e-2  # of the half side: bodies that stand closer together stand at one place
SAME = 1e-6  # of the half side: places that Newton's method brings closer together are one place


@dataclass(frozen=True)
class SmoothEnds:
    """Ends of paths from m starts, sampled.

    Attributes:
        places: where bodies stand still, (k, 2).
        reached: number of the place for each start; -1 where the body leaves the square, -2 where it still moves.
        speeds: of a body at each place, in parts of the largest speed of the starts, (k,): zero to rounding where the
            field is known to vanish, not a number where it was not asked.
    """

    places: Floats
    reached: Indices
    speeds: Floats


LEFT, MOVING = -1, -2


class UndeterminedError(RuntimeError):
    """The motion is not determined somewhere: minimizers that are not unique, or not proved."""


class _BudgetSpentError(RuntimeError):
    """All minimizations that are allowed are spent."""


class _Field:
    """``c' = v + omega J c`` by the minimizers of a rule, counted."""

    def __init__(self, scene: Scene, rule: SmoothRule, paths: int) -> None:
        self._scene, self._rule = scene, rule
        self._left, self._faces = MOST_MINIMA, MOST_FACES
        self._model = contacts_under(rule, scene)
        self._moving = MovingTwists(self._model, paths)
        self.fastest = 0.0  # of the starts

    @property
    def jumps(self) -> bool:
        """Whether twists may jump."""
        return may_jump(self._model)

    def __call__(self, points: Floats) -> Floats:
        """Velocities at points (m, 2), shape (m, 2), by proved minimizers.

        Raises:
            UndeterminedError: where minimizers are not unique at too many points.
            _BudgetSpentError: once no more minimizations are allowed.
        """
        return point_velocities(self._proved(points), points)

    def begin(self, points: Floats) -> Floats:
        """The same at the starts of all paths."""
        twists = self._proved(points)
        self._moving.remember(twists, np.arange(len(points)))
        return point_velocities(twists, points)

    def _proved(self, points: Floats) -> Floats:
        self._left -= max(len(points), SMALLEST)
        if self._left < 0:
            raise _BudgetSpentError
        found = minima_under(self._rule, self._scene, points)
        self._faces -= len(found.faces)
        if self._faces < 0:
            raise UndeterminedError(f"required minimizers that are unique at all but {MOST_FACES} points")
        return found.twists

    def along(self, points: Floats, paths: Indices) -> Floats:
        """Velocities at points (m, 2) of the paths of these numbers (m,), by smoothed minimizers where these settle.

        Raises:
            UndeterminedError, _BudgetSpentError: see :meth:`__call__`.
        """
        if self._moving.work > MOST_WORK:
            raise _BudgetSpentError
        twists, settled = self._moving.at(points, paths)
        if not settled.all():
            twists[~settled] = self._proved(points[~settled])
            self._moving.remember(twists[~settled], paths[~settled])
        return point_velocities(twists, points)


def smooth_ends(scene: Scene, starts: Floats, origin: tuple[float, float] = (0.0, 0.0)) -> SmoothEnds:
    """Follow every start over a centred scene.

    Args:
        scene: the array; its rule has no cells.
        starts: (m, 2) positions in the checked square.
        origin: what is added to the places: the coordinates of the centre.

    Raises:
        TypeError: for a rule with cells.
        UndeterminedError: where the motion is not determined.
    """
    rule = smooth_rule_of(scene)
    if free_motions(scene):
        raise UndeterminedError("required friction against every motion, received a free one")
    radius, field = scene.check.half_width, _Field(scene, rule, len(starts))
    points, reached = np.array(starts, dtype=float), np.full(len(starts), MOVING)
    still = np.zeros(len(points), bool)
    try:
        _follow_all(field, points, reached, still, radius)
        found = _gathered(points, reached, still, radius)
        stands = [_where_it_stands(field, place, radius) for place in found]
        places = np.array([place for place, _ in stands]).reshape(-1, 2)
        speeds = np.array([speed for _, speed in stands]) / (field.fastest or 1.0)
    except _BudgetSpentError:
        places = _gathered(points, reached, still, radius)
        speeds = np.full(len(places), np.nan)
    grid = GRID * radius
    measured = np.round((places + origin) / grid) * grid + 0.0  # adding zero makes -0 a 0
    return _merged(SmoothEnds(measured, reached, speeds), SAME * radius)


def _merged(ends: SmoothEnds, distance: float) -> SmoothEnds:
    """The same with places that lie closer together than a distance as one: the first of them."""
    first = [int(np.argmax(norms(ends.places - place) <= distance)) for place in ends.places]
    kept = sorted(set(first))
    numbers = np.array([kept.index(k) for k in first] + [MOVING, LEFT])  # -1 and -2 stay as they are
    return SmoothEnds(ends.places[kept], numbers[ends.reached], ends.speeds[kept])


def _follow_all(field: _Field, points: Floats, reached: Indices, still: Mask, radius: float) -> None:
    """Move the points along until they have left or stand still; all three arrays are changed in place."""
    fastest = field.fastest = float(norms(field.begin(points)).max())
    if not fastest:  # all stand where they start
        still[:] = True
        return
    until = CROSSINGS * radius / fastest
    pieces = PIECES if field.jumps else 1
    earlier, before = np.full_like(points, np.inf), points.copy()
    for _ in range(STRETCHES):
        for _ in range(pieces):
            moving = (reached == MOVING) & ~still
            if not moving.any():
                return
            tell_count(len(points) - int(moving.sum()), len(points), "starts of the square")
            points[moving] = _followed(field, points[moving], np.flatnonzero(moving), until / pieces, radius)
            reached[moving & (max_norms(points) > radius)] = LEFT
            inside = np.flatnonzero(moving & (reached == MOVING))
            if len(inside):
                speeds = norms(field.along(points[inside], inside)) / fastest
                nowhere = norms(points[inside] - earlier[inside]) <= TOGETHER * radius
                still[inside] = (speeds <= STILL) | (nowhere & (speeds >= BRISK))
            earlier, before = before, points.copy()
        until *= 2


def _followed(field: _Field, starts: Floats, paths: Indices, until: float, radius: float) -> Floats:
    """Where the bodies are after a time; one that leaves the square stops a little outside.

    Where some directions decay much faster than bodies move, explicit steps stay short: after many of them the rest of
    the time is left to backward differentiation formulas.
    """
    from scipy.integrate import BDF, RK23
    from scipy.sparse import block_diag

    def rates(t: float, flat: Floats) -> Any:
        points = flat.reshape(-1, 2)
        inside = max_norms(points) <= radius
        found = np.zeros_like(points)
        if inside.any():
            found[inside] = field.along(points[inside], paths[inside])
        return found.ravel()

    within = {"rtol": TOLERANCE, "atol": TOLERANCE * radius}
    solver = RK23(rates, 0.0, starts.ravel(), until, **within)
    _take_steps(solver, EXPLICIT_STEPS)
    if solver.status == "running":
        one_by_one = block_diag([np.ones((2, 2))] * len(starts))  # no body knows of another
        solver = BDF(rates, solver.t, solver.y, until, jac_sparsity=one_by_one, **within)
        _take_steps(solver, IMPLICIT_STEPS)
    return solver.y.reshape(-1, 2)


def _take_steps(solver: Any, most: int) -> None:
    """Let an integrator of SciPy go on for some steps, or to its end."""
    for _ in range(most):
        if solver.status != "running":
            return
        solver.step()


def _where_it_stands(field: _Field, place: Floats, radius: float) -> tuple[Floats, float]:
    """A zero of the field beside a place; where the field is not small there, the point to which jumps lead.

    And the speed of a body there, not a number where jumps lead.
    """
    vanishing, speed = _where_it_vanishes(field, place, radius)
    if not (field.jumps and field.fastest) or norm(field(vanishing[None])[0]) < BRISK * field.fastest:
        return vanishing, speed
    path, step, found = np.zeros(1, int), TOGETHER * radius / field.fastest, place
    for _ in range(SHRINKING):
        for _ in range(TIMES):
            found = found + step * field.along(found[None], path)[0]
            if np.hypot(*(found - place)) > 2 * TIMES * TOGETHER * radius or max_norm(found) > radius:
                return vanishing, speed
        step /= 2
    return np.round(found / (JUMPED * radius)) * JUMPED * radius, float("nan")


def _where_it_vanishes(field: _Field, place: Floats, radius: float) -> tuple[Floats, float]:
    """A zero of the field beside a place where it is small, and the speed there.

    The best place seen, where Newton's method finds none.
    """
    step = STEP * radius
    best, least = place, float("inf")
    for _ in range(NEWTON_STEPS):
        if max_norm(place) > radius:
            break
        here, slope = field_beside(field, place, step)
        speed = norm(here)
        if not speed < least:
            break
        best, least = place, speed
        place = place - np.linalg.lstsq(slope, here, rcond=None)[0]
    return best, least


def _gathered(points: Floats, reached: Indices, still: Mask, radius: float) -> Floats:
    """Bodies that stand close together as one place each, (k, 2); what they reached is written down."""
    places: list[Floats] = []
    left = still.copy()
    while left.any():
        first = points[np.flatnonzero(left)[0]]
        here = left & (norms(points - first) <= TOGETHER * radius)
        reached[here] = len(places)
        places.append(points[here].mean(axis=0))
        left &= ~here
    return np.array(places).reshape(-1, 2)
