"""The numbers that certificates of arrays state beside verdicts, against floats: paths, a linear program, samples.

Nothing here knows the theorems: the range of the drift is a linear program over the motions at the point, bodies are
followed by small steps, and the rate of a law is looked at where V and its derivative can be computed.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np
from scipy.optimize import linprog

from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.symbolic.mechanics.scene import Scene
from tests.oracles.floats import Floats
from tests.oracles.wheels_in_floats import Contacts

Record: TypeAlias = dict[str, Any]

STARTS, STEPS = 12, 2_000
SAMPLES = 100
CLOSE = 1e-9


def assert_bounds_hold(claims: Sequence[Record], partition: Partition, number: Any) -> None:
    """Every claim of a kind that is looked at here, of an array with its cells.

    Args:
        claims: of a certificate.
        partition: the cells about the checked point, found anew.
        number: the number that data of the certificate stand for.
    """

    def value(data: Any) -> float:
        return float(number(data))

    for claim in claims:
        ((kind, about),) = claim.items()
        if kind == "drift":
            low, high, bottom = map(value, about)
            assert np.allclose(drift(partition), [low / bottom, high / bottom], rtol=CLOSE, atol=CLOSE)
        elif kind in ("swing", "arrival", "turning"):
            bounds = {key: value(data) for key, data in about.items()}
            assert_paths_obey(partition, **bounds)
        elif kind == "feedback rate":
            reach = about["squared_reach"]
            form = np.array([value(entry) for entry in about["form"]])
            squared = np.inf if reach is None else value(reach)
            assert_law_falls(partition, form, value(about["weight"]), value(about["kappa"]), squared)


def drift(partition: Partition) -> list[float]:
    """The least and the largest omega of mixtures of motions at the point that do not move it."""
    zero = partition.scene.field.zero
    twists = np.array([[float(x) for x in own] for cell in partition.cells_at((zero, zero)) for own in cell.twists])
    equal, goal = np.vstack([twists[:, :2].T, np.ones(len(twists))]), [0.0, 0.0, 1.0]
    ends = [linprog(sign * twists[:, 2], A_eq=equal, b_eq=goal, method="highs") for sign in (1, -1)]
    assert all(end.status == 0 for end in ends)
    return [float(ends[0].fun), -float(ends[1].fun)]


class Fields:
    """The motions of all cells in floats, and the sides of the cells as ``n . c + d >= 0``, the last one repeated."""

    def __init__(self, partition: Partition) -> None:
        self.polygons = [np.array([[float(x) for x in v] for v in cell.polygon.vertices]) for cell in partition.cells]
        self.twists = [np.array([[float(x) for x in own] for own in cell.twists]) for cell in partition.cells]
        most = max(map(len, self.polygons))
        corners = np.array([np.vstack([own, *[own[:1]] * (most - len(own))]) for own in self.polygons])
        after = np.array([np.vstack([own[1:], *[own[:1]] * (most - len(own) + 1)]) for own in self.polygons])
        along = after - corners
        lengths = np.maximum(np.hypot(along[..., 0], along[..., 1]), 1e-300)
        self.normals = np.stack([-along[..., 1], along[..., 0]], axis=-1) / lengths[..., None]
        self.offsets = -(self.normals * corners).sum(axis=-1)

    def at(self, places: Floats, source: np.random.Generator) -> Floats:
        """For each place a motion of a cell that holds it, nearly; any of those that tie."""
        slacks = (np.einsum("csk,pk->pcs", self.normals, places) + self.offsets).min(axis=-1)
        own = [self.twists[k] for k in slacks.argmax(axis=1)]
        return np.array([twists[source.integers(len(twists))] for twists in own])


def assert_paths_obey(
    partition: Partition,
    squared_radius: float,
    rate: float | None = None,
    squared_swing: float | None = None,
    per_distance: float | None = None,
) -> None:
    """Bodies from the border of the disc arrive in time, stay in the larger disc, turn no more than is said.

    Steps chatter along lines at which motions oppose each other, by as much as they are long.
    """
    fields, source = Fields(partition), np.random.default_rng(3)
    start = np.sqrt(squared_radius)
    fastest = max(float(np.hypot(own[:, 0], own[:, 1]).max()) for own in fields.twists)
    seconds = start / rate if rate else 4 * start / max(fastest, CLOSE)
    step = seconds / STEPS
    slack = 20 * step * fastest + CLOSE
    angles = source.uniform(0, 2 * np.pi, STARTS)
    c = start * np.column_stack([np.cos(angles), np.sin(angles)])
    turned, farthest = np.zeros(STARTS), np.zeros(STARTS)
    for _ in range(STEPS):
        x, y, omega = fields.at(c, source).T
        turned += np.where(np.hypot(*c.T) > slack, abs(omega) * step, 0)  # at the point steps turn it to and fro
        c = c + step * np.column_stack([x - omega * c[:, 1], y + omega * c[:, 0]])
        farthest = np.maximum(farthest, np.hypot(*c.T))
    assert rate is None or (np.hypot(*c.T) <= slack).all()
    assert squared_swing is None or (farthest <= np.sqrt(squared_swing) + slack).all()
    assert per_distance is None or (turned <= per_distance * start * 1.02 + slack).all()


def assert_law_falls(partition: Partition, form: Floats, weight: float, kappa: float, squared_reach: float) -> None:
    """``a_i^2 + a_j^2 >= kappa V`` at random places near the point, for the wheels that are nearest there."""
    assert kappa > 0
    assert weight > 0
    p, q, s = form
    matrix, source = np.array([[p, q], [q, s]]), np.random.default_rng(4)
    near = min(np.sqrt(squared_reach), _reach(partition))
    for size in near * 10.0 ** -source.uniform(0, 4, SAMPLES):
        angle = source.uniform(0, 2 * np.pi)
        c = size * np.array([np.cos(angle), np.sin(angle)])
        fields = control_fields(partition.scene, c)
        for theta in size * np.append(source.normal(size=8) * 10 ** source.uniform(-1, 1, 8), 0):
            slope = matrix @ c
            gains = [slope @ (g[:2] + g[2] * np.array([-c[1], c[0]])) + weight * theta * g[2] for g in fields]
            value = c @ slope + weight * theta * theta
            assert sum(gain * gain for gain in gains) >= kappa * value * (1 - CLOSE)


def _reach(partition: Partition) -> float:
    """A distance within which all cells hold the point."""
    zero = partition.scene.field.zero
    local = {id(cell) for cell in partition.cells_at((zero, zero))}
    away = [own for own, cell in zip(Fields(partition).polygons, partition.cells, strict=True) if id(cell) not in local]
    distances = [_distance(a, b) for own in away for a, b in zip(own, np.roll(own, -1, axis=0), strict=True)]
    return min([float(partition.scene.check.radius), *distances])


def _distance(a: Floats, b: Floats) -> float:
    along = b - a
    share = np.clip(-(a @ along) / (along @ along), 0, 1)
    return float(np.hypot(*(a + share * along)))


def control_fields(scene: Scene, c: Floats) -> list[Floats]:
    """What unit speeds of the two nearest wheels with independent rows do, by solving three equations."""
    contacts = Contacts.of(scene)
    nearest, *others = np.argsort(np.hypot(*(contacts.positions - c).T)).tolist()
    first, side = contacts.rows([nearest])[0]
    rolls = (contacts.row(wheel, contacts.rims[wheel]) for wheel in others)
    second = next(own for own in rolls if abs(np.linalg.det([first, side, own])) > CLOSE)
    rows = np.array([first, side, second])
    return [np.linalg.solve(rows, [1.0, 0, 0]), np.linalg.solve(rows, [0, 0, 1.0])]
