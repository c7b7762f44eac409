"""``python -m tests.evidence.array_basins``: basins of measured tables as triangles, and bodies that start in them.

Tables as in ``tests.evidence.measured_tables``, under rules ``nearest`` and ``box``.  Of each: the share of the sampled
starts that are certified, or why nothing is; and how many of ``--starts`` random bodies in the triangles end, by small
steps of an oracle that knows no cells, where the certificate says that they do.  The study ends with status 1 where one
does not.
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from nonsmooth.proofs.answers.array_basin import ArrayBasin, NoBasin, find_array_basin
from nonsmooth.symbolic.files.scene_file import load_scene
from tests.oracles.floats import Floats
from tests.oracles.measured_tables import MeasuredTable, SmallSteps

OFF = (0.0, 3.0, 9.0)  # degrees by which headings are wrong
RULES = ("nearest", "box")
STEPS = ((200.0, 900), (2000.0, 900))  # of the square's half-width a step is one part, and how many there are


def basin_of(table: MeasuredTable, effort: str) -> ArrayBasin | NoBasin:
    """The basin that is certified of a table, through its scene file."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "table.toml"
        file.write_text(table.toml, encoding="utf-8")
        return find_array_basin(load_scene(str(file)), effort, lambda what, done, total: None)


def drawn(basin: ArrayBasin, count: int, seed: int) -> Floats:
    """Random places in the triangles, as many in a small one as in a large one."""
    random, own = np.random.default_rng(seed), basin.triangles
    chosen = own.corners[random.choice(own.simplices, count)][:, :, :2]
    return np.asarray(np.einsum("ij,ijk->ik", random.dirichlet(np.ones(3), count), chosen))


class LiftedSteps(SmallSteps):
    """Bodies that go on where wheels are lifted: springs that would pull carry nothing, and the others all of it.

    With the wheels W in touch the loads are ``(p_i, 1) . y``, where ``sum_W (p_i, 1) (p_i, 1)^T y = (c, 1)``; the set W
    of those that are positive is found by Newton's method for the convex function that y minimizes.
    """

    def _loads(self, places: Floats) -> Floats:
        arms = np.column_stack([self.places, np.ones(len(self.places))])
        asked = np.column_stack([places, np.ones(len(places))])
        touches = np.ones((len(places), len(arms)), dtype=bool)
        while True:
            stiffness = np.einsum("pw,wi,wj->pij", touches, arms, arms)
            loads = np.linalg.solve(stiffness, asked[:, :, None])[:, :, 0] @ arms.T
            if np.array_equal(loads > 0, touches):
                return np.maximum(loads, 0.0)
            touches = loads > 0

    def _stops(self, places: Floats) -> NDArray[np.bool_]:
        return np.zeros(len(places), dtype=bool)


def strays(table: MeasuredTable, basin: ArrayBasin, starts: Floats) -> int:
    """How many bodies are not where they are said to end, after steps of one length, and then of a tenth of it."""
    oracle, x = LiftedSteps(table), starts
    for parts, count in STEPS:
        step = basin.half / parts
        for _ in range(count):
            velocity = oracle.velocity(x)
            speed = np.linalg.norm(velocity, axis=1)[:, None]
            x = x + np.where(speed > 0, step * velocity / np.maximum(speed, 1e-12), 0.0)
    room = (basin.within or 0.0) + 2 * basin.half / STEPS[-1][0]  # bodies go to and fro over lines by a step
    return int(np.sum(np.linalg.norm(x, axis=1) > room))


def main() -> int:
    """Print a line for each table, and the shares; how many bodies went astray."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--seeds", default="0,10")
    parser.add_argument("--effort", default="fast", choices=("fast", "best"))
    parser.add_argument("--starts", type=int, default=500, help="bodies of each table")
    chosen = parser.parse_args()
    first, last = (int(part) for part in chosen.seeds.split(","))
    shares, astray, followed = list[float](), 0, 0
    for seed in range(first, last):
        for rule in RULES:
            table = MeasuredTable.random(seed, rule, off=OFF[seed % len(OFF)])
            begin = time.process_time()
            basin = basin_of(table, chosen.effort)
            seconds = time.process_time() - begin
            if isinstance(basin, NoBasin):
                print(f"{seed:3} {rule:8} none: {basin.why} ({seconds:.1f} s)", flush=True)
                continue
            lost = strays(table, basin, drawn(basin, chosen.starts, seed))
            astray, followed = astray + lost, followed + chosen.starts
            shares.append(basin.triangles.share)
            ends = f"ends within {basin.within:.4g} mm" if basin.within is not None else "comes home"
            size = f"{len(basin.triangles.simplices):6} triangles, {seconds:5.1f} s"
            print(f"{seed:3} {rule:8} share {shares[-1]:.4f}, {size}, {ends}, astray {lost}", flush=True)
    if shares:
        print(f"{len(shares)} tables: share {min(shares):.4f} at least, {statistics.median(shares):.4f} in the median")
    print(f"{followed} bodies followed, {astray} astray")
    return 1 if astray else 0


if __name__ == "__main__":
    raise SystemExit(main())
