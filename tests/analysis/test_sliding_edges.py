"""Edges with sliding, rest or departure, against trajectories that start beside them and against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.analysis.fields.constant_field import array_field
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.fields.sliding_edges import EdgeKind, SwitchingStretch, switching_stretches
from nonsmooth.analysis.trajectories.result import EventKind
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.symbolic.files.scene_file import load_scene

STEP = 1e-6  # distance beside an edge, of lengths of order one
AHEAD = 1e-4  # time in which a path that slides is on the edge, and one that is repelled is away from it
NAMES = (
    "four-wheel",
    "four-wheel-side",
    "rectangle",
    "ring-5",
    "elliptic",
    "spiral-30",
    "saddle",
    "outward",
    "off-center",
)


def middle(stretch: SwitchingStretch) -> tuple[np.ndarray, np.ndarray]:
    """A point on the stretch away from its ends, and a unit normal."""
    start, end = np.array(stretch.start), np.array(stretch.end)
    along = (end - start) / np.hypot(*(end - start))
    return 0.55 * start + 0.45 * end, np.array([-along[1], along[0]])


@pytest.mark.parametrize("name", NAMES)
def test_paths_beside_an_edge_do_what_its_kind_says(name: str) -> None:
    partition = build_partition(load_scene(name))
    field = array_field(partition, Kinematics.EXACT)
    for stretch in switching_stretches(partition):
        point, normal = middle(stretch)
        for side in (1, -1):
            path = simulate(field, (*(point + side * STEP * normal), 0.0), AHEAD)
            kinds = {event.kind for event in path.events}
            off = abs(float(np.dot(path.array[-1, :2] - point, normal)))
            if stretch.kind is EdgeKind.REPELLING:
                assert kinds <= {EventKind.NONUNIQUE}
                assert off >= STEP / 2
            else:
                expected = EventKind.SLIDE if stretch.kind is EdgeKind.SLIDING else EventKind.REST
                assert expected in kinds
                assert off < STEP / 100


@pytest.mark.parametrize("name", NAMES)
def test_all_other_edges_are_crossed(name: str) -> None:
    """From the middle of an edge without a stretch, the two neighbours move to the same side."""
    partition = build_partition(load_scene(name))
    stretches = {frozenset(s.cells) for s in switching_stretches(partition)}
    cells = array_field(partition, Kinematics.EXACT).cells
    for edge in cells.edges:
        if edge.left is None or edge.right is None:
            continue
        beside = [partition.cells[k] for k in (edge.left, edge.right)]
        if frozenset(cell.index for cell in beside) in stretches:
            continue
        a, b = (np.array(cells.points[k], dtype=float) for k in (edge.start, edge.end))
        place, along = (a + b) / 2, b - a
        speeds = []
        for cell in beside:
            vx, vy, omega = (float(value) for value in cell.twists[0])
            speeds.append(along[0] * (vy + omega * place[0]) - along[1] * (vx - omega * place[1]))
        assert speeds[0] * speeds[1] >= 0


def kinds(partition: Partition) -> dict[EdgeKind, int]:
    found = [stretch.kind for stretch in switching_stretches(partition)]
    return {kind: found.count(kind) for kind in set(found)}


def test_the_papers_array() -> None:
    """Eq. (3): the axes are rest, the diagonals repel; eq. (4): everything slides inward."""
    assert kinds(build_partition(load_scene("four-wheel-side"))) == {EdgeKind.RESTING: 4, EdgeKind.REPELLING: 4}
    assert kinds(build_partition(load_scene("four-wheel"))) == {EdgeKind.SLIDING: 8}
    assert kinds(build_partition(load_scene("conveyor-3"))) == {}


def test_an_edge_may_change_its_kind_along_the_way() -> None:
    """On the elliptic array's rays between 30-degree sectors the normal speed vanishes at a point of the edge."""
    stretches = [s for s in switching_stretches(build_partition(load_scene("elliptic"))) if s.cells == (1, 3)]
    assert {s.kind for s in stretches} == {EdgeKind.SLIDING, EdgeKind.REPELLING}
    (outer,) = [s for s in stretches if s.kind is EdgeKind.SLIDING]
    (inner,) = [s for s in stretches if s.kind is EdgeKind.REPELLING]
    assert np.hypot(*outer.end) > np.hypot(*inner.start)
