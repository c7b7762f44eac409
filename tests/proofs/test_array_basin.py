"""Regions of arrays as triangles: the checker accepts them and no forged ones, and bodies by small steps end there."""

from __future__ import annotations

import copy
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from nonsmooth.proofs.answers import array_basin
from nonsmooth.proofs.answers.array_basin import NoBasin
from nonsmooth.proofs.checker.array_basin import ArrayPlane
from nonsmooth.proofs.checker.contact import Cells
from nonsmooth.proofs.checker.statements import refusal
from nonsmooth.proofs.checker.wheels import read_array
from nonsmooth.proofs.systems.basin_mesh import BasinEffort
from nonsmooth.proofs.systems.basin_rings import RingGrowth
from tests.certificates.corpus import good_arrays, text_of
from tests.evidence.array_basins import basin_of, drawn, strays
from tests.oracles.measured_tables import MeasuredTable

COARSE = BasinEffort(RingGrowth(0.2, 0.05, 0.04), 15)


@pytest.fixture
def coarse(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(array_basin.EFFORTS, "fast", (COARSE,))


@pytest.mark.usefixtures("coarse")
@pytest.mark.parametrize(("seed", "rule"), [(2, "nearest"), (4, "box")])
def test_bodies_end_where_it_is_certified(seed: int, rule: str) -> None:
    """Under rule box in the area of rest, which the polygon holds; the share is that of the largest square."""
    table = MeasuredTable.random(seed, rule, off=(0.0, 3.0, 9.0)[seed % 3])
    basin = basin_of(table, "fast")
    assert not isinstance(basin, NoBasin)
    assert basin.triangles.share > 0.9
    assert basin.within is not None
    assert not strays(table, basin, drawn(basin, 40, seed))


# ---- forged ones ---------------------------------------------------------------------------------


def outward(hypotheses: Any) -> None:
    """The first polygon and the last change places in W."""
    corners = hypotheses["mesh"]["corners"]
    corners[:] = [f"{x} {y} {2 - int(value)}" for x, y, value in (text.split(" ") for text in corners)]


def folded(hypotheses: Any) -> None:
    """The polygon in which bodies end is not convex."""
    hypotheses["mesh"]["corners"][0] = "-1 0 0"


def beyond(hypotheses: Any) -> None:
    """The mesh reaches the border of its square."""
    corners = hypotheses["mesh"]["corners"]
    corners[8:] = [text.replace("15", "16") for text in corners[8:]]


def less(hypotheses: Any) -> None:
    """A triangle is missing, so that solutions may meet another border below the level."""
    del hypotheses["mesh"]["triangles"][-3]


def wider(hypotheses: Any) -> None:
    """A square of which the cells do not tell."""
    hypotheses["within"] = "3/4"


def smaller(hypotheses: Any) -> None:
    """A disc that does not hold the polygon."""
    hypotheses["squared_radius"] = "1/257"


def lower(hypotheses: Any) -> None:
    """A level below which no triangle lies."""
    hypotheses["below"] = 0


@pytest.mark.parametrize("forge", [outward, folded, beyond, less, wider, smaller, lower])
def test_forged_meshes_are_rejected(forge: Callable[[Any], None]) -> None:
    """Also where the claim is forged with them."""
    good = copy.deepcopy(good_arrays()["array-four-wheel-basin"])
    assert not refusal(good, len(text_of(good)))
    hypotheses = good["evidence"][1]["hypotheses"]
    forge(hypotheses)
    good["statement"]["claims"][-1] = {"attracts": {name: hypotheses[name] for name in ("mesh", "below")}}
    assert refusal(good, len(text_of(good)))


def test_enclosed_cells_are_a_superset() -> None:
    """Cells that float geometry says are met are among those of the checker, and float velocities in its boxes."""
    good = good_arrays()["array-four-wheel-basin"]
    array, hypotheses = read_array(good["statement"]["subject"]), good["evidence"][1]["hypotheses"]
    cells = Cells(array, hypotheses["points"], hypotheses["cells"])
    plane, random = ArrayPlane(cells, "1/1024"), np.random.default_rng(1)
    points = [[entry.enclosure(40)[0] / 2**40 for entry in point] for point in cells.points]
    outlines = [np.array([[points[k][0], points[k][1]] for k in cell.polygon]) * 1024 for cell in cells.listed]
    for _ in range(200):
        a, b, c = random.integers(-500, 500, (3, 2))
        if (b - a)[0] * (c - a)[1] < (b - a)[1] * (c - a)[0]:
            b, c = c, b
        places = [(int(x), int(y)) for x, y in (a, b, c)]
        inside = np.einsum("ij,jk->ik", random.dirichlet(np.ones(3), 30), np.array([a, b, c]))
        crossed = {k for k, outline in enumerate(outlines) if any(holds(outline, x) for x in inside)}
        assert crossed <= plane.crossing(places) <= plane.touching(places)
    for k, cell in enumerate(cells.listed):
        vx, vy, omega = (entry.enclosure(40)[0] / 2**40 for entry in cell.motions[0].twist[:3])
        x, y = 300, -200
        parts = [[field.along(unit).on([(x, y)])[0] for unit in ((1, 0), (0, 1))] for field in plane.fields(k)]
        true = np.array([vx - omega * y / 1024, vy + omega * x / 1024])
        scaled = np.array(parts, dtype=float) / 2.0**96 / 1024
        assert np.allclose(scaled, true, atol=1e-9)


def holds(outline: Any, place: Any) -> bool:
    """Whether a polygon, counterclockwise, has a place well inside."""
    along = np.roll(outline, -1, axis=0) - outline
    across = place - outline
    return bool((along[:, 0] * across[:, 1] - along[:, 1] * across[:, 0]).min() > 1e-6)
