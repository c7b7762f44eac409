"""The law of imposed twists as a digital controller runs it: sampled, its speeds held until the next sample.

The event-driven path (:mod:`nonsmooth.analysis.fields.driven_field`) follows the exact Filippov solution; where many
cones of directions of c meet at ``c = 0`` it has too many patterns of modes to try.  Here the law chooses at times h
apart, so that switches are late by at most h; V falls to the order of ``h^2`` beside its start.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nonsmooth.analysis.fields.driven_field import ImposedMotions
from nonsmooth.analysis.fields.switched_field import Vector
from nonsmooth.analysis.trajectories.result import End, EndReason, State, Trajectory

STEP = 0.02  # h, of the shortest time in which a twist answers: 1 over the gain and its squared size
MOST_STEPS = 20_000
SHOWN = 1_000  # states that the trajectory keeps


def follow_held(cones: Sequence[ImposedMotions], start: Sequence[float], until: float, gain: float) -> Trajectory:
    """The path of ``(x, y, theta)`` from a start, measured from the checked point and with l for the unit of length.

    Args:
        cones: the law; they go around.
        start: the pose.
        until: last time, unless 20,000 samples end before.
        gain: k (1/time).

    Returns:
        Method ``sampled``: states without events, as no switch is located.
    """
    fastest = max(float((cone.twists**2).sum(axis=1).max()) for cone in cones)
    step = STEP / (gain * fastest)
    count = min(int(np.ceil(until / step)), MOST_STEPS)
    step = min(step, until / count)
    pose, poses = np.array(start, dtype=float), [np.array(start, dtype=float)]
    for _ in range(count):
        pose = _moved(pose, _imposed(cones, pose, gain), step)
        poses.append(pose)
    kept = np.unique(np.linspace(0, count, min(count, SHOWN) + 1).round().astype(int))
    states: list[State] = [tuple(poses[k].tolist()) for k in kept]
    times = tuple(float(k * step) for k in kept)
    return Trajectory("exact", "sampled", times, tuple(states), (), End(times[-1], states[-1], EndReason.TIME), None)


def _imposed(cones: Sequence[ImposedMotions], pose: Vector, gain: float) -> Vector:
    """The twist ``-k (g . xi_l) xi_l`` of the largest ``|g . xi_l|``, as the body then moves."""
    cone = next((cone for cone in cones if _holds(cone, pose)), cones[0])
    products = cone.twists @ pose
    chosen = int(np.argmax(np.abs(products)))
    return np.asarray(-gain * products[chosen] * cone.motions[chosen](pose[:2]))


def _holds(cone: ImposedMotions, pose: Vector) -> bool:
    """Whether the direction of c lies in the cone: left of its first ray and right of its last."""
    if cone.rays is None:
        return True
    (ax, ay), (bx, by) = (ray[:2] for ray in cone.rays)
    x, y = pose[:2]
    return bool(ax * y - ay * x >= 0 >= bx * y - by * x)


def _moved(pose: Vector, twist: Vector, time: float) -> Vector:
    """A rigid motion of constant spatial twist ``c' = v + omega J c``, exactly."""
    x, y, theta = pose
    vx, vy, omega = twist
    turn = omega * time
    cosine, sine = np.cos(turn), np.sin(turn)
    along = np.sinc(turn / np.pi) * time  # sin(turn)/omega
    across = time * np.sinc(turn / (2 * np.pi)) * np.sin(turn / 2)  # (1 - cos(turn))/omega
    moved = (
        cosine * x - sine * y + along * vx - across * vy,
        sine * x + cosine * y + across * vx + along * vy,
        theta + turn,
    )
    return np.array(moved)
