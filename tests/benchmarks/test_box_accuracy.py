"""The cells' twists against linear programs at a thousand points per array."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np

from nonsmooth.analysis.cells.box import build_box_partition
from nonsmooth.analysis.cells.loads import LoadError
from nonsmooth.analysis.fields.contact_model import contact_model
from nonsmooth.analysis.minimizers.agreement import PointLocator
from nonsmooth.analysis.minimizers.box_minimizers import BoxHighs
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.analysis.minimizers.minimum import Functional, dissipation
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.scene import Scene
from tests.benchmarks.conftest import Stopwatch
from tests.conftest import Arrays

POINTS = 1_000
RELATIVE = 1e-9  # of the optimum: the linear program returns a vertex, accurate to rounding


def compared(arrays: Arrays) -> dict[str, Scene]:
    """Rings, grids, an elliptic field and random rational arrays."""
    friction = (1, Fraction(1, 5))
    scenes = {f"ring-{n}": arrays.ring(n, friction, Fraction(1, 4)) for n in range(3, 9)}
    scenes |= {f"grid {n} x {n}": arrays.grid(n, n, friction, Fraction(2, 5)) for n in (2, 4, 6)}
    scenes["elliptic"] = load_scene("elliptic", rule="box")
    for seed in range(40):
        scene = arrays.random(seed, 5)
        scenes[f"random {seed}"] = replace(scene, check=replace(scene.check, radius=scene.field(1) / 8))
    return scenes


def test_the_cells_attain_the_optimum(arrays: Arrays, stopwatch: Stopwatch) -> None:
    worst, refused = 0.0, 0
    for name, scene in compared(arrays).items():
        try:
            partition = build_box_partition(scene)
        except LoadError:
            refused += 1  # the body would tip somewhere in the square
            continue
        rng = np.random.default_rng(0)
        centre = np.array([float(x) for x in scene.check.equilibrium])
        points = centre + rng.uniform(-1, 1, (POINTS, 2)) * float(scene.check.radius)
        model = contact_model(scene)
        loads = loads_at(model, points)
        ours = dissipation(Functional.BOX, model, loads, PointLocator(partition).twists(points))
        theirs = BoxHighs().minimize(model, loads).values
        error = float(((ours - theirs) / np.maximum(theirs, np.median(theirs))).max())
        worst = max(worst, error)
        stopwatch.report(
            f"{name:12s} {len(partition.cells):4d} cells, largest excess of D over the optimum {error:.1e}"
        )
        assert partition.tiles
        assert loads.min() >= 0
        assert error <= RELATIVE
    stopwatch.report(f"largest relative excess {worst:.1e} (allowed {RELATIVE}), {refused} arrays refused")
