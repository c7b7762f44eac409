"""The explicit partition of rule ``box``: against parametric programming, against one linear program per point."""

from __future__ import annotations

import time
from dataclasses import replace
from fractions import Fraction
from math import comb

import numpy as np
import pytest

from nonsmooth.analysis.cells.box import build_box_partition
from nonsmooth.analysis.fields.contact_model import ContactModel, contact_model
from nonsmooth.analysis.minimizers.agreement import PointLocator
from nonsmooth.analysis.minimizers.box_minimizers import BoxHighs
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.scene import Scene
from tests.benchmarks.conftest import Stopwatch
from tests.conftest import Arrays

REQUIRED_OVER_PPOPT = 250
REQUIRED_OVER_HIGHS = 1_000
LARGEST_SECONDS = 60  # for a 10 x 10 grid on two cores


def four_wheel(arrays: Arrays) -> Scene:
    return arrays.four_wheel((1, Fraction(1, 5)))


def parametric_program(model: ContactModel, radius: float) -> object:
    """The dual: ``max b . f`` subject to ``A^T f = 0``, ``|f_k| <= mu_k N_k(c)``, affine in the parameter c."""
    from ppopt.mplp_program import MPLP_Program

    corners = np.array([[0.0, 0.0], [radius, 0.0], [0.0, radius]])
    limits = model.limits(loads_at(model, corners)).reshape(3, -1)
    slopes = (limits[1:] - limits[0]).T / radius
    count = len(model.targets)
    rows = np.vstack([model.rows.T, np.eye(count), -np.eye(count)])
    offsets = np.concatenate([np.zeros(3), limits[0], limits[0]]).reshape(-1, 1)
    dependence = np.vstack([np.zeros((3, 2)), slopes, slopes])
    square = np.vstack([np.eye(2), -np.eye(2)])
    return MPLP_Program(
        rows,
        offsets,
        -model.targets.reshape(-1, 1),
        np.zeros((count, 2)),
        square,
        radius * np.ones((4, 1)),
        dependence,
        equality_indices=[0, 1, 2],
    )


@pytest.mark.filterwarnings("ignore")  # the other package's own warnings are not ours to mend
@pytest.mark.parametrize("name", ["combinatorial", "graph"])
def test_partition_against_parametric_programming(arrays: Arrays, stopwatch: Stopwatch, name: str) -> None:
    """PPOPT splits the square into many more regions than there are twists, because its vertices are dual ones."""
    pytest.importorskip("ppopt", reason="PPOPT is a dependency of the benchmarks only: pip install '.[bench]'")
    from ppopt.mp_solvers.solve_mpqp import mpqp_algorithm, solve_mpqp

    model = contact_model(four_wheel(arrays))
    cells = len(build_box_partition(four_wheel(arrays)).cells)
    algorithm = getattr(mpqp_algorithm, name)
    regions = len(solve_mpqp(parametric_program(model, 0.5), algorithm).critical_regions)
    theirs, ours = stopwatch.in_turn(
        lambda: solve_mpqp(parametric_program(model, 0.5), algorithm),
        lambda: build_box_partition(four_wheel(arrays)),
    )
    stopwatch.report(
        f"four-wheel partition: {ours * 1e3:.1f} ms exactly ({cells} cells), PPOPT {name} {theirs * 1e3:.0f} ms "
        f"({regions} regions), {theirs / ours:.0f}x (required {REQUIRED_OVER_PPOPT}x)"
    )
    assert theirs >= REQUIRED_OVER_PPOPT * ours


@pytest.mark.parametrize("name", ["four-wheel", "grid-4x4"])
def test_point_location_against_linear_programs(stopwatch: Stopwatch, name: str) -> None:
    scene = load_scene(name, rule="box")
    locator, model = PointLocator(build_box_partition(scene)), contact_model(scene)
    points = np.random.default_rng(0).uniform(-0.5, 0.5, (100_000, 2))
    few = points[:100]
    loads = loads_at(model, few)
    solving, locating = stopwatch.in_turn(
        lambda: BoxHighs().minimize(model, loads), lambda: locator.twists(points), rounds=3
    )
    solved, located = solving / len(few), locating / len(points)
    stopwatch.report(
        f"{name}: {located * 1e6:.2f} us per located point, {solved * 1e6:.0f} us per linear program, "
        f"{solved / located:.0f}x (required {REQUIRED_OVER_HIGHS}x)"
    )
    assert solved >= REQUIRED_OVER_HIGHS * located


def test_growth_with_the_number_of_cells(arrays: Arrays, stopwatch: Stopwatch) -> None:
    """Grids of 4 to 100 wheels: work follows the cells found, not the C(2n, 3) candidates."""
    stopwatch.report("wheels  triples   cells  seconds  ms per cell")
    for side in (2, 4, 6, 8, 10):
        scene = arrays.grid(side, side, (1, Fraction(1, 5)))
        if side == 2:  # wheels at (+-1/2, +-1/2): stay inside the support polygon
            scene = replace(scene, check=replace(scene.check, radius=scene.field(Fraction(2, 5))))
        start = time.perf_counter()
        partition = build_box_partition(scene)
        seconds = time.perf_counter() - start
        wheels, cells = side * side, len(partition.cells)
        stopwatch.report(
            f"{wheels:6d} {comb(2 * wheels, 3):8d} {cells:7d} {seconds:8.2f} {1e3 * seconds / cells:12.1f}"
        )
        assert partition.tiles
        assert seconds <= LARGEST_SECONDS
