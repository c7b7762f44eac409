"""Where a body ends from many starts, sampled: all paths of a body with an outline at once, in floats.

The steps are explicit (Heun's), of a length of their own for each path.  A step that comes to an edge ends just beyond
it.  Where the motion there leads back a path chatters from one contact set to the other: the discrete form of
Filippov's sliding, right to the order of a step.  Means over windows of steps smooth it out: where the mean hardly
moves, steps are halved.  A path whose mean still hardly moves with the shortest steps rests (of a rule that keeps rows,
the place: the steps drift to a heading there, at a rate that the rule leaves open), unless it goes to and fro by many
steps: then it circles, and is followed to the last time.

One that moves on slowly, and within a window no farther than its mean does, drifts smoothly, and takes long steps
again.  One that rests but drifts smoothly on leaps ahead by its mean rates, to the last time or to where it moves
faster: it may turn to where other wheels carry it.

On the same wheels motions of a rule without cells change smoothly, yet some within a layer narrower than a step.  There
a path would go to and fro as well, and drift by the mean of the motions on both sides, which is not the one within.  So
a step after which the motion has turned back is taken again, half as long, unless the mean hardly moves, down to where
it is told from a jump.

A path ends too where a body's own motion has died out, where it tips, where no wheel is left under it, and after much
work: of last times far beyond the usual one.  Nothing is proved.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple, Protocol

import numpy as np

from nonsmooth.analysis.bodies.moving_outline import MovingOutline
from nonsmooth.analysis.bodies.outline_field import CellsBySet, SetCells
from nonsmooth.analysis.cells.contact_rule import CellRule, Rule, SmoothRule
from nonsmooth.analysis.cells.polygon import HalfPlane
from nonsmooth.analysis.fields.contact_model import ContactModel, contacts_under
from nonsmooth.analysis.fields.polygon_field import CellSides
from nonsmooth.analysis.fields.switched_field import Surface
from nonsmooth.analysis.minimizers.many_twists import NOBODY, LeastTwists, carrying_first, nearest_wheels, widest_gaps
from nonsmooth.symbolic.mechanics.contact_set import require_springs
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.plane import Pose
from nonsmooth.symbolic.numbers.plane_arrays import Floats, Indices, Mask, point_velocities

STEP = 0.04  # of the wheels' spacing at the fastest wheel's speed
HALVINGS = 3  # from the longest step to the shortest
LAYER_HALVINGS = 10  # the same within a layer; what turns back yet is a jump
JUMP_WINDOWS = 2  # in which a path chatters that has met a jump, before it looks for layers again
STILL = 1e-4  # speed of a body, of the fastest wheel's, below which it rests
WINDOW = 20  # steps over which a pose is averaged
SLOW = 0.04  # speed of the mean, of the fastest wheel's, below which steps are halved; above thrice it, doubled
RESTS = 5e-3  # the same with the shortest steps, over a few windows: the body rests
WINDOWS = 4  # in a row for rest
DRIFTS = 2.0  # of how far its mean moves: a body that goes no farther within a window moves smoothly
DRIFT_STEPS = 4  # of the longest steps: what slow and smooth bodies take
LEAPS = 60  # of a path that all but rests, at most
FIRST_LEAP = 8  # windows
LONGER = 4.0  # the next leap, and shorter where mean rates have changed over the last
STEADY = 0.1  # of the mean rates: how much their directions may change
CHATTER = 6.0  # shortest steps of the fastest wheel: how far a pose at rest may go to and fro; farther, it circles
BEYOND = 0.05  # of a step: how far beyond an edge it ends that comes to it
MORE_WINDOWS = 1_000  # than the shortest steps take to the usual last time: after them paths are given up
CROSSINGS = 8.0  # of the array at the fastest wheel's speed: the last time unless one is given

OnStep = Callable[[int, int, str], None]  # paths that have ended, paths in all, and up to when all are followed


class BodyEnd(StrEnum):
    """How a sampled path ends."""

    REST = "the body rests"
    TIPS = "the body tips"
    LEAVES = "no wheel is left under the body"
    TIME = "still moving at the last time"
    UNKNOWN = "no motion was found"
    LOST = "not followed to the end"


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
        turning: rates of theta (m,), means over the last windows of steps; not a number where none was seen.
        until: the last time.
    """

    starts: Floats
    poses: Floats
    times: Floats
    reasons: Indices
    over: Indices
    turning: Floats
    until: float

    def by(self, reason: BodyEnd) -> Mask:
        """Which starts end so, (m,)."""
        return np.asarray(self.reasons == ENDS.index(reason))


class _State:
    """All paths."""

    def __init__(self, starts: Floats, longest: float) -> None:
        count = len(starts)
        self.poses, self.times = starts.copy(), np.zeros(count)
        self.longest, self.steps = longest, np.full(count, longest)
        self.reasons: Indices = np.full(count, -1)
        self.over = np.full((count, 2), NOBODY)
        self.means, self.anchors = starts.copy(), np.full((count, 3), np.nan)
        self.extents = np.zeros((count, 3))  # of the poses in the last window
        self.turning = np.full(count, np.nan)  # mean rates of theta
        self.quiet = np.zeros(count, int)  # windows in a row with the shortest steps
        self.drifts = np.zeros(count, bool)  # slowly and smoothly, so that long steps do
        self.slow = np.zeros(count, bool)  # in the mean, whether smoothly or not
        self.at_jump = np.zeros(count, int)  # windows in which it chatters there
        self.turned_back = np.zeros(count, bool)  # within the last window, on the same wheels
        self.crossed = np.zeros(count, bool)  # an edge, in the last step
        self.rested = np.full(count, np.nan)  # since when it all but rests
        self.leaps, self.leap_times = np.zeros(count, int), np.zeros(count)  # how many, and how long the last was
        self.leap_starts, self.leap_rates = np.zeros(count), np.zeros((count, 3))  # when, and mean rates then
        self.mean_times, self.anchor_times = np.zeros(count), np.zeros(count)

    @property
    def shortest(self) -> float:
        """The shortest step but in layers."""
        return self.longest / 2**HALVINGS

    @property
    def going(self) -> Indices:
        """The numbers of the paths that have not ended."""
        return np.flatnonzero(self.reasons < 0)

    def end(self, paths: Indices, reason: BodyEnd) -> None:
        """Note why these paths end."""
        self.reasons[paths] = ENDS.index(reason)


class _Seen(NamedTuple):
    """What the last windows of steps show of the paths that go on.

    Attributes:
        paths: their numbers.
        rates: of their means.
        drift: the speeds of these, of the fastest wheel's; not numbers where none is known yet.
        short: whether steps are the shortest.
        waits: whether means all but rest with these.
        full: whether they do so for enough windows to tell.
        wanders: whether poses go farther within a window than their mean does.
        near: whether they keep as near each other as those of a body at rest.
    """

    paths: Indices
    rates: Floats
    drift: Floats
    short: Mask
    waits: Mask
    full: Mask
    wanders: Mask
    near: Mask


class ManyPaths:
    """Follows one body from many starts."""

    def __init__(self, scene: Scene, rule: Rule, *, of_places: bool = False) -> None:
        """For a scene with a body, all its wheels in ``scene.wheels``.

        With ``of_places`` a body rests where its place does, however it turns there.

        Raises:
            ValueError: for a scene without a body.
            SceneError: for a table of loads, which are known for one contact set only, and for unknown loads.
        """
        if scene.body is None:
            raise ValueError("required a scene with a body")
        if rule.needs_loads:
            require_springs(scene)
        self._numbers = np.array([*scene.numbers, 0])
        self._scene, self._rule, self._has_layers = scene, rule, isinstance(rule, SmoothRule)
        self._model = contacts_under(rule, scene)
        self._outline = MovingOutline(scene.body, self._model.positions)
        self._turning = 0.0 if rule.keeps_rows or of_places else self._outline.size
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
            report: told from time to time how many of all paths have ended, and up to when all are followed.
        """
        last = self.last_time() if until is None else until
        longest = min(STEP * self.spacing / (self._fastest or 1.0), last / WINDOW)
        state, field = _State(starts, longest), ManyRates(self._motions(len(starts)), self._outline, starts)
        windows = MORE_WINDOWS + math.ceil(min(last, self.last_time()) * 2**HALVINGS / (WINDOW * longest or 1.0))
        while len(state.going) and windows:
            windows -= 1
            self._window(state, field, last)
            self._leap(state, field, *self._judge(state, last), last)
            if report is not None:
                going = state.going
                reached = float(state.times[going].min()) if len(going) else last
                report(len(starts) - len(going), len(starts), f"t = {reached:.3g} of {last:.3g}")
        state.end(state.going, BodyEnd.LOST)
        self._end_slow(state)
        over = self._numbers[state.over]
        return BodyEnds(starts, state.poses, state.times, state.reasons, over, state.turning, last)

    def _end_slow(self, state: _State) -> None:
        """Bodies that all but rest at the last time, and moved on slowly before, rest: since when they all but did."""
        late = (state.reasons == ENDS.index(BodyEnd.TIME)) & ~np.isnan(state.rested)
        slow = late & self._keeps_near(state.extents, state.shortest)
        state.end(np.flatnonzero(slow), BodyEnd.REST)
        state.times[slow] = state.rested[slow]

    def _motions(self, count: int) -> Motions:
        """How bodies move that stand, on a number of paths."""
        if isinstance(self._rule, SmoothRule):
            return LeastDissipation(self._model, self._outline.size, count)
        return CellMotions(self._scene, self._rule)

    def _window(self, state: _State, field: ManyRates, last: float) -> None:
        """A window of steps of every path."""
        times = np.zeros(len(state.poses))
        sums, lowest, highest = np.zeros_like(state.poses), state.poses.copy(), state.poses.copy()
        for _ in range(WINDOW):
            paths = state.going
            if not len(paths):
                return
            self._step(state, field, paths, last)
            sums[paths] += state.poses[paths]
            times[paths] += state.times[paths]
            lowest[paths] = np.minimum(lowest[paths], state.poses[paths])
            highest[paths] = np.maximum(highest[paths], state.poses[paths])
        going = state.going
        state.means[going], state.mean_times[going] = sums[going] / WINDOW, times[going] / WINDOW
        state.extents = highest - lowest

    def _step(self, state: _State, field: ManyRates, paths: Indices, last: float) -> None:
        """Heun's step; Euler's where the trial pose does not stand."""
        poses = state.poses[paths]
        here = field.at(poses, paths)
        _end_fallen(state, paths, here)
        self._end_still(state, paths, here)
        goes = state.reasons[paths] < 0
        paths, poses, rates, wheels = paths[goes], poses[goes], here.rates[goes], here.wheels[goes]
        if not len(paths):
            return
        reach = state.longest * self._fastest / np.maximum(self._distance(rates), 1e-300)
        steps = np.minimum(state.steps[paths], last - state.times[paths])
        steps = np.where(state.drifts[paths], np.minimum(steps, reach), steps)
        there = field.at(poses + steps[:, None] * rates, paths)
        crosses = wheels != there.wheels
        usable = ~there.tips & there.known
        mean = np.where(usable[:, None], (rates + there.rates) / 2, rates)
        comes = np.flatnonzero(crosses & ~state.crossed[paths] & ~state.slow[paths])
        if len(comes):
            ahead = steps[comes, None] * rates[comes]
            shares = field.shares_to_edges(poses[comes], poses[comes] + ahead, paths[comes])
            steps[comes] *= np.minimum(shares + BEYOND, 1.0)
            mean[comes] = rates[comes]
        state.crossed[paths] = crosses
        if self._has_layers:
            back = paths[usable & ~crosses & self._turns_back(rates, there.rates)]
            steps[np.isin(paths, _halve(state, back))] = 0.0
        state.poses[paths] = poses + steps[:, None] * mean
        state.times[paths] += steps
        state.end(paths[state.times[paths] >= last * (1 - 1e-12)], BodyEnd.TIME)

    def _end_still(self, state: _State, paths: Indices, here: Rates) -> None:
        """End the paths of bodies that stand and do not move."""
        speeds = np.hypot(*here.rates[:, :2].T) + self._outline.size * np.abs(here.rates[:, 2])
        still = ~here.tips & here.known & (speeds < STILL * self._fastest)
        state.turning[paths[still]] = here.rates[still, 2]
        state.end(paths[still], BodyEnd.REST)

    def _turns_back(self, first: Floats, second: Floats) -> Mask:
        """Where the second of two motions is more than a right angle off the first."""
        return np.asarray((first * second) @ [1.0, 1.0, self._outline.size**2] < 0)

    def _judge(self, state: _State, last: float) -> tuple[Indices, Floats]:
        """End what rests, and choose the next steps, by how fast the means move.

        Returns:
            Those which all but rest and drift smoothly, and their mean rates.
        """
        seen = self._seen(state)
        paths, rests = seen.paths, seen.full & (seen.drift < RESTS) & seen.near
        state.turning[paths] = seen.rates[:, 2]
        state.drifts[paths[seen.full & (seen.drift >= RESTS) & ~seen.wanders]] = True
        state.drifts[paths[(seen.drift < RESTS) | seen.wanders]] = False
        state.rested[paths[seen.drift >= RESTS]] = np.nan
        still = rests & (seen.wanders | self._goes_no_farther(state, seen, last))
        state.poses[paths[still]] = state.means[paths[still]]
        state.end(paths[still], BodyEnd.REST)
        self._count_windows(state, seen)
        self._choose_steps(state, paths, seen.drift)
        return paths[rests & ~still], seen.rates[rests & ~still]

    def _seen(self, state: _State) -> _Seen:
        """What the last windows show."""
        paths = state.going
        spans = state.mean_times[paths] - state.anchor_times[paths]
        rates = (state.means[paths] - state.anchors[paths]) / spans[:, None]
        fastest, extents = self._fastest or 1.0, state.extents[paths]
        drift = self._distance(rates) / fastest
        short = state.steps[paths] <= state.shortest * 1.001
        waits = short & (drift < SLOW)
        full = waits & (state.quiet[paths] >= np.where(np.isnan(state.rested[paths]), WINDOWS, 1))
        # who goes to and fro goes farther within a window than its mean does, and needs the shortest steps
        wanders = self._distance(extents) > DRIFTS * drift * fastest * WINDOW * state.steps[paths]
        return _Seen(paths, rates, drift, short, waits, full, wanders, self._keeps_near(extents, state.shortest))

    def _goes_no_farther(self, state: _State, seen: _Seen, last: float) -> Mask:
        """Who would not go a shortest step by the last time, has leapt often, or of whom the place alone is asked."""
        is_near = seen.drift * (last - state.times[seen.paths]) < state.shortest
        return np.asarray(is_near | (state.leaps[seen.paths] >= LEAPS) | (self._turning == 0))

    def _count_windows(self, state: _State, seen: _Seen) -> None:
        """Go on counting windows of those that wait; the others' means are compared with the last one from now on."""
        paths, again = seen.paths, ~seen.waits | seen.full
        state.quiet[paths] = np.where(again, 0, state.quiet[paths] + 1)
        state.quiet[paths[again & seen.short]] = 1
        state.anchors[paths[again]] = state.means[paths[again]]
        state.anchor_times[paths[again]] = state.mean_times[paths[again]]

    def _leap(self, state: _State, field: ManyRates, paths: Indices, rates: Floats, last: float) -> None:
        """Move paths far ahead by their mean rates, to the next edge at most, as if these died out evenly.

        A leap is longer than the last one where rates have kept their directions since, else shorter.
        """
        if not len(paths):
            return
        state.rested[paths] = np.where(np.isnan(state.rested[paths]), state.times[paths], state.rested[paths])
        steady, decay = self._decay(state, paths, rates)
        times = state.leap_times[paths] * np.where(steady, LONGER, 1 / LONGER)
        times = np.where(state.leaps[paths] == 0, FIRST_LEAP * WINDOW * state.steps[paths], times)
        times = np.minimum(times, last - state.times[paths])
        state.leap_times[paths], state.leap_rates[paths], state.leap_starts[paths] = times, rates, state.times[paths]
        # the times in which bodies would move as far at their rates of now
        spans = np.where(decay > 0, -np.expm1(-decay * times) / np.where(decay > 0, decay, 1.0), times)
        spans = np.minimum(spans, state.longest * self._fastest / np.maximum(self._distance(rates), 1e-300))
        poses = state.poses[paths]
        shares = field.shares_to_edges(poses, poses + spans[:, None] * rates, paths)
        spans *= np.minimum(shares * (1 + BEYOND), 1.0)
        state.poses[paths] = poses + spans[:, None] * rates
        left = np.maximum(1 - decay * spans, np.exp(-decay * times))
        state.times[paths] += np.where(decay > 0, -np.log(left) / np.where(decay > 0, decay, 1.0), spans)
        state.leaps[paths] += 1
        state.anchors[paths] = np.nan
        state.end(paths[state.times[paths] >= last * (1 - 1e-12)], BodyEnd.TIME)

    def _decay(self, state: _State, paths: Indices, rates: Floats) -> tuple[Mask, Floats]:
        """Whether mean rates have kept their directions since the last leap, and at which rates they die out."""
        before, spans = state.leap_rates[paths], state.times[paths] - state.leap_starts[paths]
        weights = np.array([1.0, 1.0, self._turning**2])
        factors = (before * rates) @ weights / np.maximum(before**2 @ weights, 1e-300)
        steady = (factors > 0) & (self._distance(rates - factors[:, None] * before) <= STEADY * self._distance(rates))
        decay = -np.log(np.where(steady, np.minimum(factors, 1.0), 1.0)) / np.maximum(spans, 1e-300)
        return steady, decay

    def _choose_steps(self, state: _State, paths: Indices, drift: Floats) -> None:
        """Shorten and lengthen the steps of paths whose means move at these speeds, not numbers where not known yet."""
        longest, shortest, drifts = state.longest, state.shortest, state.drifts[paths]
        state.slow[paths] = np.where(np.isnan(drift), state.slow[paths], drift < SLOW)
        slower = paths[(drift < SLOW) & (state.steps[paths] > shortest * 1.001) & ~drifts]
        state.steps[slower] /= 2
        state.anchors[slower] = np.nan
        state.steps[paths[(drift > 3 * SLOW) & ~state.turned_back[paths] | drifts]] *= 2
        state.steps[paths] = np.minimum(state.steps[paths], np.where(drifts, DRIFT_STEPS * longest, longest))
        slow = paths[state.slow[paths]]  # these chatter in layers too
        state.steps[slow] = np.maximum(state.steps[slow], shortest)
        state.turned_back[paths] = False
        state.at_jump[paths] = np.maximum(state.at_jump[paths] - 1, 0)

    def _keeps_near(self, extents: Floats, shortest: float) -> Mask:
        """Whether poses that differ so much within a window go to and fro by no more than a body at rest may."""
        return np.asarray(self._distance(extents) < CHATTER * shortest * (self._fastest or 1.0))

    def _distance(self, differences: Floats) -> Floats:
        """Sizes of differences of poses, as lengths; of places alone under a rule that leaves headings at rest open."""
        return np.asarray(np.hypot(*differences[:, :2].T) + self._turning * np.abs(differences[:, 2]))

    @property
    def spacing(self) -> float:
        """See :class:`nonsmooth.analysis.bodies.moving_outline.MovingOutline`."""
        return self._outline.spacing


def _end_fallen(state: _State, paths: Indices, here: Rates) -> None:
    """End the paths of bodies that do not stand, and those without a motion."""
    state.over[paths] = here.over
    state.end(paths[~here.known], BodyEnd.UNKNOWN)
    state.end(paths[here.tips], BodyEnd.TIPS)
    state.end(paths[here.tips & here.none], BodyEnd.LEAVES)


def _halve(state: _State, paths: Indices) -> Indices:
    """Halve the steps of paths that have stepped over a layer; those which are to take the step again.

    One that turns back with the shortest steps too has met a jump of motions on the same wheels, where it may chatter.
    """
    state.turned_back[paths] = True
    paths = paths[state.at_jump[paths] == 0]
    halvings = np.where(state.slow[paths], HALVINGS, LAYER_HALVINGS)
    again = state.steps[paths] > state.longest / 2.0**halvings * 1.001
    state.steps[paths[again]] /= 2
    jumps = paths[~again & ~state.slow[paths]]
    state.steps[jumps], state.at_jump[jumps] = state.longest, JUMP_WINDOWS
    return paths[again]


def turned_heading(angles: Floats) -> Floats:
    """Angles in ``(-pi, pi]``."""
    return math.pi - np.mod(math.pi - angles, 2 * math.pi)


# ---- cells of many poses -------------------------------------------------------------------------


class _Table:
    """The cells on one set of wheels."""

    def __init__(self, cells: SetCells) -> None:
        self._sides = CellSides([[_half_plane(*side) for side in cell.sides] for cell in cells.cells])
        self._twists = np.array([cell.twist for cell in cells.cells])

    def twists(self, centres: Floats) -> Floats:
        """The twist of the cell that holds each centre (m, 2), or is nearest to it; shape (m, 3)."""
        return np.asarray(self._twists[self._sides.depths(centres).argmax(axis=1)])


def _half_plane(line: Surface, sign: int) -> HalfPlane:
    """The places on one side of a line."""
    origin = np.zeros(3)
    a, b, _ = (-sign * line.gradient(origin)).tolist()
    return HalfPlane((a, b), sign * line.value(origin))


class CellMotions:
    """The motions by cells; those of each set are built once.  Where motions tie the first is taken."""

    def __init__(self, scene: Scene, rule: CellRule) -> None:
        """For an array with all its wheels."""
        self._sets, self._count = CellsBySet(scene, rule), len(scene.wheels)
        self._known: dict[bytes, _Table] = {}

    def of(self, near: Indices, carrying: Mask, levers: Floats, poses: Floats, paths: Indices) -> tuple[Floats, Mask]:
        """See :meth:`nonsmooth.analysis.bodies.many_paths.Motions.of`.

        Raises:
            RefusalError: where the motion on some wheels is not determined.
        """
        under = np.zeros((len(poses), self._count), bool)
        rows, columns = np.nonzero(carrying)
        under[rows, near[rows, columns]] = True
        sets, group = np.unique(np.packbits(under, axis=1), axis=0, return_inverse=True)
        twists = np.zeros((len(poses), 3))
        for k in range(len(sets)):
            members = np.flatnonzero(group.reshape(-1) == k)
            twists[members] = self._table(under[members[0]]).twists(poses[members, :2])
        rates = np.column_stack([point_velocities(twists, poses[:, :2]), twists[:, 2]])
        return rates, np.ones(len(poses), bool)

    def _table(self, under: Mask) -> _Table:
        key = under.tobytes()
        if key not in self._known:
            self._known[key] = _Table(self._sets.of(frozenset(np.flatnonzero(under).tolist())))
        return self._known[key]


# ---- rates of many poses -------------------------------------------------------------------------
#
# At each pose the wheels strictly under the outline carry; their loads and the least dissipation give ``(c', theta')``,
# or the cells of a rule on these wheels.


AROUND = 0.25  # of the body's size: how far it moves before the wheels near it are looked up again


@dataclass(frozen=True)
class Rates:
    """What is known at m poses.

    Attributes:
        rates: ``(c', theta')``, shape (m, 3), zero where the body does not stand.
        tips: where it does not.
        over: numbers of the two wheels (m, 2) over whose line it tips, -1 for none.
        none: where no wheel is under the body.
        known: where the motion was found.
        wheels: a number for the set of wheels that carry (m,), which others hardly have.
    """

    rates: Floats
    tips: Mask
    over: Indices
    none: Mask
    known: Mask
    wheels: Floats


class Motions(Protocol):
    """Motions of many bodies that stand."""

    def of(self, near: Indices, carrying: Mask, levers: Floats, poses: Floats, paths: Indices) -> tuple[Floats, Mask]:
        """``(c', theta')`` (m, 3) at poses (m, 3) of the paths of these numbers (m,), and whether it was found.

        Args:
            near: numbers of wheels (m, k).
            carrying: which of them carry.
            levers: ``p_i - c``, shape (m, k, 2).
            poses: of the bodies.
            paths: their numbers.
        """


RECENT = 3  # twists that a path remembers: trial poses, and the two sides of an edge, each have one of their own


class LeastDissipation:
    """The motions that dissipate the least, each found from that of the last few twists of its path which does best."""

    def __init__(self, model: ContactModel, size: float, count: int) -> None:
        """For a number of paths of a body of some size."""
        self._least, self._size, self._recent = LeastTwists(model, size), size, np.zeros((count, RECENT, 3))

    def of(self, near: Indices, carrying: Mask, levers: Floats, poses: Floats, paths: Indices) -> tuple[Floats, Mask]:
        """See :meth:`Motions.of`."""
        found = self._least.of(near, carrying, levers, self._recent[paths])
        self._recent[paths] = np.concatenate([found.rates[:, None], self._recent[paths, :-1]], axis=1)
        return found.rates / [1.0, 1.0, self._size], found.known


class ManyRates:
    """Rates along many paths; each path keeps the wheels near it."""

    def __init__(self, motions: Motions, outline: MovingOutline, poses: Floats) -> None:
        """For paths that begin at poses (m, 3)."""
        self._motions, self._outline, self._size = motions, outline, outline.size
        self._centres = poses[:, :2].copy()
        self._marks = np.random.default_rng(0).random(len(outline.places) + 1)  # any set of wheels has a sum of its own
        self._near = nearest_wheels(outline.places, self._centres, self._size * (1 + AROUND))

    def at(self, poses: Floats, paths: Indices) -> Rates:
        """The rates at poses (m, 3) of the paths of these numbers (m,)."""
        self._look_around(poses, paths)
        near = self._near[paths]
        levers = self._outline.places[near] - poses[:, None, :2]
        depths = self._outline.depths_at(self._outline.places[near], poses)
        carrying = (depths > 0) & (near != NOBODY)
        order, carrying, levers = carrying_first(carrying, levers)
        near = np.take_along_axis(near, order, axis=1)
        gaps, first, second = widest_gaps(levers, carrying)
        tips = np.asarray(~(gaps < np.pi))
        over = np.stack([np.take_along_axis(near, k[:, None], axis=1)[:, 0] for k in (first, second)], axis=1)
        over[~tips | (carrying.sum(axis=1) < 2)] = NOBODY
        rates, known = np.zeros((len(poses), 3)), tips.copy()
        stands = np.flatnonzero(~tips)
        if len(stands):
            standing = near[stands], carrying[stands], levers[stands], poses[stands], paths[stands]
            found = self._motions.of(*standing)
            rates[stands], known[stands] = found
        wheels = np.where(carrying, self._marks[near], 0.0).sum(axis=1)
        return Rates(rates, tips, over, np.asarray(~carrying.any(axis=1)), known, wheels)

    def shares_to_edges(self, before: Floats, after: Floats, paths: Indices) -> Floats:
        """Which share (m,) of a step between two poses (m, 3) a body moves until a wheel comes to its edge.

        As if depths changed evenly over the step; 1 where no wheel comes or goes.
        """
        near = self._near[paths]
        first, last = (self._outline.depths_at(self._outline.places[near], poses) for poses in (before, after))
        changes = ((first > 0) != (last > 0)) & (near != NOBODY)
        shares = np.where(changes, first / np.where(changes, first - last, 1.0), 1.0)
        return np.asarray(shares.min(axis=1, initial=1.0))

    def _look_around(self, poses: Floats, paths: Indices) -> None:
        """Look up the wheels near those bodies that have moved far, of all paths that are asked for."""
        moved = np.hypot(*(poses[:, :2] - self._centres[paths]).T)
        if moved.max(initial=0.0) < AROUND * self._size:
            return
        self._centres[paths] = poses[:, :2]
        found = nearest_wheels(self._outline.places, poses[:, :2], self._size * (1 + AROUND))
        width = max(found.shape[1], self._near.shape[1])
        near = np.full((len(self._near), width), NOBODY)
        near[:, : self._near.shape[1]] = self._near
        near[paths] = NOBODY
        near[paths, : found.shape[1]] = found
        self._near = near


# ---- where the paths gather ----------------------------------------------------------------------
#
# Bodies that rest within a small distance of each other rest at one place (single linkage).  A place may have a whole
# range of headings: the wheels under the body say where it rests, and many headings may have the same wheels under it.


TOGETHER = 0.02  # of the wheels' spacing or the body's size: bodies that rest closer together rest at one place


@dataclass(frozen=True)
class PathEnd:
    """One place at which bodies rest, or another way to end.

    Attributes:
        reason: how the paths end.
        starts: their numbers.
        share: of all starts.
        pose: a middle one ``(x, y, theta)`` of the poses at rest; None elsewhere.
        headings: the least and the largest heading at rest, theta without full turns; None elsewhere.
        where: words for the last places of bodies that still move; empty where these are all over.
    """

    reason: BodyEnd
    starts: Indices
    share: float
    pose: Pose | None = None
    headings: tuple[float, float] | None = None
    where: str = ""

    @property
    def text(self) -> str:
        """In words."""
        if self.pose is None or self.headings is None:
            return f"{self.reason.value}, {self.where}" if self.where else self.reason.value
        x, y, _ = (f"{_plain(value):.4g}" for value in self.pose)
        low, high = (f"{math.degrees(_plain(value)):.4g}" for value in self.headings)
        heading = low if low == high else f"{low} to {high}"
        return f"{self.reason.value} at ({x}, {y}), heading {heading} deg"


def destinations(ends: BodyEnds, distance: float) -> list[PathEnd]:
    """Places of rest, largest share first, then the other ends.

    Args:
        ends: of the paths.
        distance: below which bodies rest together, in lengths.
    """
    resting = np.flatnonzero(ends.by(BodyEnd.REST))
    found = []
    for group in _linked(ends.poses[resting, :2], distance):
        found.append(_at_rest(ends, resting[group]))
    found.sort(key=lambda one: (-one.share, one.text))
    for reason in BodyEnd:
        starts = np.flatnonzero(ends.by(reason))
        if reason is not BodyEnd.REST and len(starts):
            found.append(PathEnd(reason, starts, len(starts) / len(ends.starts)))
    return found


def _at_rest(ends: BodyEnds, starts: Indices) -> PathEnd:
    """The middle of the poses: means of x and y, and the heading that is the middle one around the first."""
    poses = ends.poses[starts]
    first = poses[0, 2]
    headings = np.sort(first + turned_heading(poses[:, 2] - first))
    x, y = poses[:, :2].mean(axis=0)
    middle = headings[len(headings) // 2]
    turn = turned_heading(middle) - middle
    pose = (float(x), float(y), float(middle + turn))
    outermost = (float(headings[0] + turn), float(headings[-1] + turn))
    return PathEnd(BodyEnd.REST, starts, len(starts) / len(ends.starts), pose, outermost)


def _linked(places: Floats, distance: float) -> list[Indices]:
    """Groups of points (m, 2) linked by steps of at most a distance."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    if not len(places):
        return []
    pairs = cKDTree(places).query_pairs(distance, output_type="ndarray")
    links = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(places), len(places)))
    count, labels = connected_components(links, directed=False)
    return [np.flatnonzero(labels == k) for k in range(count)]


def _plain(value: float) -> float:
    """Rounding of zero as zero."""
    return 0.0 if abs(value) < 5e-5 else value
