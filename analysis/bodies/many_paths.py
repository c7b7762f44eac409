"""Where a body ends from many starts, sampled: all paths of a body with an outline at once, in floats.

The steps are explicit (Heun's), of a length of their own for each path.  At an edge a path chatters from one contact
set to the other: the discrete form of Filippov's sliding, right to the order of a step.  Means over windows of steps
smooth it out: where the mean hardly moves, steps are halved, and a path whose mean still hardly moves with the
shortest steps rests (of a rule that keeps rows, the place: the steps drift to a heading there, at a rate that the rule
leaves open), unless it goes to and fro by many steps: then it circles, and is followed to the last time.  A path ends
too where the body tips and where no wheel is left under it.  Nothing is proved.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.bodies.many_cells import CellMotions
from nonsmooth.analysis.bodies.many_contacts import NOBODY, Mask, Numbers
from nonsmooth.analysis.bodies.many_rates import LeastDissipation, ManyRates, Motions, Rates
from nonsmooth.analysis.bodies.moving_outline import MovingOutline
from nonsmooth.analysis.contact_rule import CellRule, SmoothRule
from nonsmooth.analysis.fields.contact_model import Floats, contact_model
from nonsmooth.symbolic.contact_set import require_elastic
from nonsmooth.symbolic.scene import Scene

STEP = 0.04  # of the wheels' spacing at the fastest wheel's speed
HALVINGS = 3  # from the longest step to the shortest
WINDOW = 20  # steps over which a pose is averaged
SLOW = 0.04  # speed of the mean, of the fastest wheel's, below which steps are halved; above thrice it, doubled
RESTS = 5e-3  # the same with the shortest steps, over a few windows: the body rests
WINDOWS = 4  # in a row for rest
CHATTER = 6.0  # shortest steps of the fastest wheel: how far a pose at rest may go to and fro; farther, it circles
CROSSINGS = 8.0  # of the array at the fastest wheel's speed: the last time unless one is given

OnStep = Callable[[int, int], None]


class BodyEnd(StrEnum):
    """How a sampled path ends."""

    REST = "the body rests"
    TIPS = "the body tips"
    LEAVES = "no wheel is left under the body"
    TIME = "still moving at the last time"
    UNKNOWN = "no motion was found"


ENDS = tuple(BodyEnd)


@dataclass(frozen=True)
class BodyEnds:
    """Ends of sampled paths from m starts.

    Attributes:
        starts: poses (m, 3).
        poses: at the end (m, 3); at rest the mean of the last steps.
        times: at which each path ends (m,).
        reasons: places in :data:`ENDS`, (m,).
        over: numbers, as in the scene, of the two wheels (m, 2) over whose line the body tips; 0 for none.
        until: the last time.
    """

    starts: Floats
    poses: Floats
    times: Floats
    reasons: Numbers
    over: Numbers
    until: float

    def by(self, reason: BodyEnd) -> Mask:
        """Which starts end so, (m,)."""
        return np.asarray(self.reasons == ENDS.index(reason))


class _State:
    """All paths."""

    def __init__(self, starts: Floats, step: float) -> None:
        count = len(starts)
        self.poses, self.times = starts.copy(), np.zeros(count)
        self.steps = np.full(count, step)
        self.reasons: NDArray[np.int_] = np.full(count, -1)
        self.over = np.full((count, 2), NOBODY)
        self.means, self.anchors = starts.copy(), np.full((count, 3), np.nan)
        self.extents = np.zeros((count, 3))  # of the poses in the last window
        self.quiet = np.zeros(count, int)  # windows in a row with the shortest steps

    @property
    def going(self) -> Numbers:
        """The numbers of the paths that have not ended."""
        return np.flatnonzero(self.reasons < 0)

    def end(self, paths: Numbers, reason: BodyEnd) -> None:
        """Note why these paths end."""
        self.reasons[paths] = ENDS.index(reason)


class ManyPaths:
    """Follows one body from many starts."""

    def __init__(self, scene: Scene, rule: SmoothRule | CellRule) -> None:
        """For a scene with a body, all its wheels in ``scene.wheels``.

        Raises:
            ValueError: for a scene without a body.
            SceneError: for a table of loads, which are known for one contact set only, and for unknown loads.
        """
        if scene.body is None:
            raise ValueError("required a scene with a body")
        if rule.needs_loads:
            require_elastic(scene)
        self._numbers = np.array([*(wheel.index for wheel in scene.wheels), 0])
        self._scene, self._rule = scene, rule
        self._model = rule.contacts(scene) if isinstance(rule, SmoothRule) else contact_model(scene)
        self._outline = MovingOutline(scene.body, self._model.positions)
        self._turning = 0.0 if rule.keeps_rows else self._outline.size
        self._fastest = float(np.abs(self._model.speeds).max())

    def last_time(self) -> float:
        """A few crossings of the array at the fastest wheel's speed."""
        places = self._model.positions
        extent = float(np.hypot(*(places.max(axis=0) - places.min(axis=0))))
        return CROSSINGS * extent / (self._fastest or 1.0)

    def follow(self, starts: Floats, until: float | None = None, report: OnStep | None = None) -> BodyEnds:
        """Ends of the paths from poses (m, 3), theta measured from the checked heading.

        Args:
            starts: poses.
            until: last time; :meth:`last_time` unless given.
            report: told from time to time how many of all paths have ended.
        """
        last = self.last_time() if until is None else until
        longest = min(STEP * self.spacing / (self._fastest or 1.0), last / WINDOW)
        state, field = _State(starts, longest), ManyRates(self._motions(len(starts)), self._outline, starts)
        while len(state.going):
            self._window(state, field, last)
            self._judge(state, longest)
            if report is not None:
                report(len(starts) - len(state.going), len(starts))
        return BodyEnds(starts, state.poses, state.times, state.reasons, self._numbers[state.over], last)

    def _motions(self, count: int) -> Motions:
        """How bodies move that stand, on a number of paths."""
        if isinstance(self._rule, SmoothRule):
            return LeastDissipation(self._model, self._outline.size, count)
        return CellMotions(self._scene, self._rule)

    def _window(self, state: _State, field: ManyRates, last: float) -> None:
        """A window of steps of every path."""
        sums, lowest, highest = np.zeros_like(state.poses), state.poses.copy(), state.poses.copy()
        for _ in range(WINDOW):
            paths = state.going
            if not len(paths):
                return
            self._step(state, field, paths, last)
            sums[paths] += state.poses[paths]
            lowest[paths] = np.minimum(lowest[paths], state.poses[paths])
            highest[paths] = np.maximum(highest[paths], state.poses[paths])
        going = state.going
        state.means[going] = sums[going] / WINDOW
        state.extents = highest - lowest

    def _step(self, state: _State, field: ManyRates, paths: Numbers, last: float) -> None:
        """Heun's step; Euler's where the trial pose does not stand."""
        poses = state.poses[paths]
        here = field.at(poses, paths)
        _end_fallen(state, paths, here)
        stands = ~here.tips & here.known
        paths, poses, rates = paths[stands], poses[stands], here.rates[stands]
        if not len(paths):
            return
        steps = np.minimum(state.steps[paths], last - state.times[paths])
        there = field.at(poses + steps[:, None] * rates, paths)
        usable = ~there.tips & there.known
        mean = np.where(usable[:, None], (rates + there.rates) / 2, rates)
        state.poses[paths] = poses + steps[:, None] * mean
        state.times[paths] += steps
        state.end(paths[state.times[paths] >= last * (1 - 1e-12)], BodyEnd.TIME)

    def _judge(self, state: _State, longest: float) -> None:
        """Shorten and lengthen steps by how fast the means move, and end what rests."""
        paths = state.going
        shortest = longest / 2**HALVINGS
        spans = WINDOW * state.steps[paths]
        drift = self._distance(state.means[paths] - state.anchors[paths]) / spans / (self._fastest or 1.0)
        count = np.maximum(state.quiet[paths], 1)
        drift /= count
        short = state.steps[paths] <= shortest * 1.001
        waits = short & (drift < SLOW)
        full = waits & (state.quiet[paths] >= WINDOWS)
        chatters = self._distance(state.extents[paths]) < CHATTER * shortest * (self._fastest or 1.0)
        rests = full & (drift < RESTS) & chatters
        state.poses[paths[rests]] = state.means[paths[rests]]
        state.end(paths[rests], BodyEnd.REST)
        state.quiet[paths] = np.where(waits & ~full, state.quiet[paths] + 1, 0)
        again = ~waits | full
        state.anchors[paths[again]] = state.means[paths[again]]
        state.quiet[paths[again & short]] = 1
        slower, faster = paths[(drift < SLOW) & ~short], paths[(drift > 3 * SLOW)]
        state.steps[slower] /= 2
        state.anchors[slower] = np.nan
        state.steps[faster] = np.minimum(2 * state.steps[faster], longest)

    def _distance(self, differences: Floats) -> Floats:
        """Sizes of differences of poses, as lengths; of places alone under a rule that leaves headings at rest open."""
        return np.asarray(np.hypot(*differences[:, :2].T) + self._turning * np.abs(differences[:, 2]))

    @property
    def spacing(self) -> float:
        """The middle one of the wheels' distances from their nearest neighbours, at most the body's size."""
        from scipy.spatial import cKDTree

        places = self._model.positions
        if len(places) < 2:
            return self._outline.size
        nearest = cKDTree(places).query(places, k=2)[0][:, 1]
        return min(float(np.median(nearest)), self._outline.size)


def _end_fallen(state: _State, paths: Numbers, here: Rates) -> None:
    """End the paths of bodies that do not stand, and those without a motion."""
    state.over[paths] = here.over
    state.end(paths[~here.known], BodyEnd.UNKNOWN)
    state.end(paths[here.tips], BodyEnd.TIPS)
    state.end(paths[here.tips & here.none], BodyEnd.LEAVES)


def turned_heading(angles: Floats) -> Floats:
    """Angles in ``(-pi, pi]``."""
    return math.pi - np.mod(math.pi - angles, 2 * math.pi)
