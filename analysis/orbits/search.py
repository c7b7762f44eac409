"""Periodic orbits from a start: the one nearby, or else the one that the path approaches, or comes from.

A path that returns to a small distance from where it began is improved by shooting, whatever its stability.  If it
does not, it is followed for half of the given time, and what it has come to then is looked at in the same way; at last
the start itself, however far from the orbit.  Where all that finds nothing, the same is done backwards in time: there
orbits attract that repel.  What is found is an orbit forwards in time in any case: its turn has closed so.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np

from nonsmooth.analysis.fields.sign_field import SignField, Signs
from nonsmooth.analysis.fields.switched_field import ScalarVelocity, Velocity
from nonsmooth.analysis.orbits.orbit import Orbit, OrbitError, follow_turn, newton_system
from nonsmooth.analysis.trajectories.faces import largest
from nonsmooth.analysis.trajectories.follow import find_root
from nonsmooth.analysis.trajectories.result import EndReason, TrajectoryError
from nonsmooth.analysis.trajectories.smooth_path import Leg, follow_legs, onto
from nonsmooth.symbolic.numbers.plane_arrays import Floats, max_norm, spread
from nonsmooth.symbolic.numbers.work_limit import WorkLimitError, WorkMeter

RUNS_AWAY = "the path runs away"
EVALUATIONS = 240_000  # of a field, along one path
SHOOTING = 1_000_000  # in all of shooting: some seconds; the derivative of each turn takes 4 n + 1 for one of the path
NEARBY = 0.1  # of the extent of the path: a start that returns so near is beside an orbit
RETURNS = 12  # that are compared: an orbit may pass the section several times in a turn
PREFERRED = 4.0  # an earlier return is taken unless a later one is so many times nearer
SAME = 1e-9  # of the extent of the path: returns so near are equally near, whatever rounding left of them
SHORTER = 6  # times that are tried where a path cannot be followed to the end, each a quarter of the last
STANDS = 1e-9  # relative to the size of the states: the extent of a path that stands still


def find_orbit(field: SignField, start: Sequence[float], until: float) -> Orbit:
    """The periodic orbit that a start is near, or else the one that its path approaches, or comes from.

    Args:
        field: the field.
        start: initial state.
        until: time for which the path is followed; twice the time of approach and two periods at least.

    Raises:
        OrbitError: where none is found, with the reason.
        ValueError: for a start outside the domain.
    """
    try:
        return _find_along(field, start, until)
    except OrbitError as error:
        refusal = error
    try:
        found = _find_along(_reversed(field), start, until)
    except (OrbitError, ValueError):
        raise refusal from None
    try:
        with _limited(field, SHOOTING) as limited:
            return _begun_well(shoot(limited, found.point, found.period))
    except (OrbitError, TrajectoryError, WorkLimitError):
        place = np.round(found.point, 6).tolist()
        raise OrbitError(
            f"backwards in time the path comes to an orbit through {place} of period {found.period:.6g}, which repels "
            "so strongly that no turn of it can be followed forwards"
        ) from None


def _find_along(field: SignField, start: Sequence[float], until: float) -> Orbit:
    """The orbit that a start is near, or that its path approaches.

    Raises:
        OrbitError: where none is found, with the reason.
        ValueError: for a start outside the domain.
    """
    legs, refusal = _legs(field, start, until)
    refusals = []
    places = [(0.0, NEARBY), (legs[-1].end / 2, math.inf), (0.0, math.inf)] if legs else []
    try:
        with _limited(field, SHOOTING) as limited:
            for number, (first, within) in enumerate(places):
                if number == 1:
                    if refusal:
                        break
                    _require_motion(field, legs)
                try:
                    x, period = _return_after(legs, first, within)
                except OrbitError as error:
                    refusals.append(str(error))
                    continue
                try:
                    return _begun_well(shoot(limited, x, period))
                except (OrbitError, TrajectoryError) as error:
                    grows = "; turns of the path still grow: a later --until may find one" if _grows(legs) else ""
                    refusals.append(f"{error}{grows}")
    except WorkLimitError:
        raise OrbitError(f"no periodic orbit is found within {SHOOTING} evaluations of the field") from None
    raise OrbitError(refusal or refusals[1])


def _grows(legs: Sequence[Leg]) -> bool:
    """Whether the second half of a path is clearly wider than the first."""
    halves: tuple[list[Floats], list[Floats]] = ([], [])
    for leg in legs:
        for t, x in zip(leg.stretch.times, leg.stretch.states, strict=True):
            halves[t > legs[-1].end / 2].append(x)
    first, second = (spread(np.array(half)) for half in halves)
    return second > first * (1 + NEARBY)


@contextmanager
def _limited(field: SignField, evaluations: int) -> Iterator[SignField]:
    """The same field, whose evaluations are limited within the block: so many, however fast the machine is.

    Raises:
        WorkLimitError: from the field, once there are too many.
    """
    meter = WorkMeter(evaluations)
    counts = True

    def counted(evaluate: Callable[..., Any]) -> Callable[..., Any]:
        def evaluated(*place: Any) -> Any:
            if counts:
                meter.spend(1)
            return evaluate(*place)

        return evaluated

    def flow(signs: Signs) -> Velocity:
        velocity = field.flow(signs)
        if isinstance(velocity, ScalarVelocity):
            return ScalarVelocity(counted(velocity.rates))
        return counted(velocity)

    try:
        yield replace(field, flow=flow)
    finally:
        counts = False


def _legs(field: SignField, start: Sequence[float], until: float) -> tuple[tuple[Leg, ...], str]:
    """The legs of a path that take time; and why they end before the last time, empty where they do not.

    Where a path runs away or cannot be followed, the legs are those of the longest of some shorter times.
    """
    reason, refusal = "", f"the path cannot be followed until t = {until:g}: it runs away, or has no continuation"
    for k in range(SHORTER):
        try:
            with _limited(field, EVALUATIONS) as limited:
                path, legs = follow_legs(limited, start, until / 4**k)
        except TrajectoryError:
            reason = refusal
            continue
        except WorkLimitError:
            reason = f"the path until t = {until:g} takes more than {EVALUATIONS} evaluations of the field"
            continue
        if path.end.reason in {EndReason.ESCAPES, EndReason.FAR}:
            reason = refusal if path.end.reason is EndReason.ESCAPES else RUNS_AWAY
            continue
        legs = tuple(leg for leg in legs if leg.end > leg.start)
        if not reason and (not legs or legs[-1].end < until):
            reason = f"the path ends before t = {until:g}, or its switches accumulate"
        return legs, reason
    return (), reason


def _reversed(field: SignField) -> SignField:
    """The field backwards in time."""

    def flow(signs: Signs) -> Velocity:
        forwards = field.flow(signs)
        if isinstance(forwards, ScalarVelocity):
            rates = forwards.rates
            return ScalarVelocity(lambda *x: tuple([-rate for rate in rates(*x)]))
        return lambda t, x: -forwards(t, x)

    return replace(field, flow=flow)


def _begun_well(orbit: Orbit) -> Orbit:
    """The same orbit, gone through once, begun inside a leg.

    Where a family of orbits may fill the surroundings, that of the start itself is kept: another start may belong to
    another one.
    """
    try:
        inside = single_turn(_begun_inside(orbit))
    except OrbitError:  # turns from there may close ten thousand times worse, as beside a saddle
        return single_turn(orbit)
    if inside.stability != "undecided":
        return inside
    here = single_turn(orbit)
    return inside if here.legs[0].motion.face.keep and not here.is_one_slide else here


def _require_motion(field: SignField, legs: Sequence[Leg]) -> None:
    """Refuse a path whose second half stands still."""
    late = [leg for leg in legs if leg.end > legs[-1].end / 2]
    places = np.array([x for leg in late for t, x in zip(leg.stretch.times, leg.stretch.states, strict=True)])
    if spread(places[1:]) <= STANDS * field.size:
        raise OrbitError("the path comes to rest, not to a periodic orbit")


def _return_after(legs: Sequence[Leg], time: float, within: float) -> tuple[Floats, float]:
    """A state soon after a time, and when the path returns to it.

    Raises:
        OrbitError: where it does not, to a part ``within`` of the extent of the path from there on.
    """
    later = [leg for leg in legs if leg.end > time]
    leg = later[0]
    moment = max(time, leg.start) if time else leg.start
    x = leg.at(moment)
    along = leg.motion(moment, x)
    places = np.array([state for other in later for state in other.stretch.states])
    extent = spread(places)
    if math.isinf(len(x) * max_norm(along) * extent):  # heights over the section are beyond floats
        raise OrbitError(RUNS_AWAY)
    returns = _returns(later, x, along, moment)
    near = [(t, distance) for t, distance in returns if distance <= within * extent]
    if not near:
        raise OrbitError(
            f"no return to {np.round(x, 6).tolist()} until t = {legs[-1].end:g}: required a start nearer to the orbit, "
            "or a later --until"
        )
    least = min(distance for _, distance in near)
    near_enough = max(PREFERRED * least, SAME * extent)
    return x, next(t for t, distance in near if distance <= near_enough) - moment


def _returns(legs: Sequence[Leg], x: Floats, along: Floats, moment: float) -> list[tuple[float, float]]:
    """Times at which the path crosses the section ``along . (y - x) = 0`` forward, with the distance from x."""
    found: list[tuple[float, float]] = []
    previous: tuple[float, float] | None = None
    for leg in legs:
        for t in leg.stretch.times:
            if t <= (moment if previous is None else previous[0]):
                continue
            height = float(along @ (leg.at(t) - x))
            if previous is not None and previous[1] < 0 <= height:
                crossed = _crossing(leg, x, along, previous, (t, height))
                found.append((crossed, float(np.linalg.norm(leg.at(crossed) - x))))
                if len(found) >= RETURNS:
                    return found
            previous = (t, height)
    return found


def _crossing(leg: Leg, x: Floats, along: Floats, before: tuple[float, float], after: tuple[float, float]) -> float:
    """Time of a crossing between two steps of a leg; heights are turned, as roots are looked for from above."""
    return find_root(lambda t: -float(along @ (leg.at(t) - x)), (before[0], -before[1]), (after[0], -after[1]))


def _begun_inside(orbit: Orbit) -> Orbit:
    """The same orbit, begun in the middle of its longest leg in a cell, else of its longest leg."""
    legs = orbit.legs
    longest = max(legs, key=lambda leg: (not leg.motion.face.keep, leg.end - leg.start))
    middle = longest.at((longest.start + longest.end) / 2)
    return shoot(orbit.field, middle, orbit.period)


def single_turn(orbit: Orbit) -> Orbit:
    """The same orbit, gone through once: two turns close as well as one, where a start returned closer after two."""
    first = orbit.legs[0]
    extent = orbit.extent
    for time, distance in _returns(orbit.legs, first.first, first.motion(0.0, first.first), 0.0):
        if distance <= SAME * extent and time < orbit.period * (1 - SAME):
            return shoot(orbit.field, first.first, time)
    return orbit


# ---- Newton's method on a turn -------------------------------------------------------------------
#
# ``(M - 1) dx + f dT = -(phi_T(x) - x)`` with the monodromy matrix M, and ``f . dx = 0`` to fix the phase (Seydel 2010,
# "Practical Bifurcation and Stability Analysis", ch. 7).  A surface that is held where the turn begins stays held.


STEPS = 12  # of Newton's method; five are usual
CLOSED = 1e-9  # relative to the size of the states: a turn that closes no better is none
CLOSE = 1e-12  # and one that closes so well is not improved: the integrator errs as much
TRUST = 0.5  # of the orbit's extent and of its period: a longer step leaves what the derivative describes
SMALLEST = 1e-6  # relative to the size of the states: a smaller orbit is an equilibrium


def shoot(field: SignField, x: Floats, period: float) -> Orbit:
    """The periodic orbit beside a turn that nearly closes.

    Args:
        field: the field.
        x: start, inside a leg.
        period: time of the turn, nearly.

    Raises:
        OrbitError: where Newton's method finds none, or the turn has no derivative.
        TrajectoryError: where a path cannot be followed.
    """
    turn = follow_turn(field, x, period)
    for _ in range(STEPS):
        if turn.gap <= CLOSE * field.size:
            break
        following = _improved(turn)
        if following.gap >= turn.gap:
            break
        turn = following
    if turn.extent <= SMALLEST * field.size:
        raise OrbitError("Newton's method comes to an equilibrium, not to a periodic orbit")
    if turn.gap > CLOSED * max(field.size, turn.extent):
        raise OrbitError(f"Newton's method leaves a gap of {turn.gap:.3g} after one turn")
    return turn


def _improved(turn: Orbit) -> Orbit:
    """After one step of Newton's method, cut to where its derivative can be trusted."""
    x, smallest = turn.point, SMALLEST * turn.field.size
    system, speed = newton_system(turn)
    move = np.linalg.lstsq(system, np.append(x - turn.legs[-1].last, 0.0), rcond=None)[0]
    longer = float(move[-1]) / speed / turn.period  # where an equilibrium is near, turns last ever longer
    wider = largest(move[:-1]) / max(turn.extent, smallest)
    share = min(1.0, TRUST / max(abs(longer), wider, TRUST))
    start = onto(x + share * move[:-1], turn.legs[0].motion.face.keep, turn.field.size)
    return follow_turn(turn.field, start, turn.period * (1 + share * longer))
