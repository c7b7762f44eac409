"""Thousands of random arrays and systems, of which the fast tests try a few: counts, and what none may contradict.

The number of tied arrays can be set for a shorter run: ``NONSMOOTH_TIED_ARRAYS=5000 make bench``.
"""

from __future__ import annotations

import json
import os
import statistics
import time
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from fractions import Fraction
from itertools import repeat
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest

from nonsmooth.analysis.cells.box import build_box_partition
from nonsmooth.analysis.cells.loads import LoadError
from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.fields.contact_model import contact_model
from nonsmooth.analysis.measurements.harness import measure
from nonsmooth.analysis.minimizers.agreement import PointLocator
from nonsmooth.analysis.minimizers.box_minimizers import BoxHighs
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseMinimizer
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.analysis.minimizers.minimum import Functional, dissipation
from nonsmooth.proofs.clauses.translation.on_cells import decide_translation
from nonsmooth.proofs.measurements import CASES
from nonsmooth.proofs.robust.box import BoxRingProof
from nonsmooth.proofs.robust.nearest import inner_radius
from nonsmooth.proofs.robust.smooth_rules import SmoothDisc
from nonsmooth.reports.cli import app
from nonsmooth.reports.output.console import run
from nonsmooth.symbolic.files.documents import builtin_scenes
from nonsmooth.symbolic.files.scene_file import load_any, load_scene
from nonsmooth.symbolic.mechanics.scene import Scene, Tolerance
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.benchmarks.conftest import Stopwatch
from tests.built_in import planar_systems
from tests.conftest import Arrays
from tests.measured_arrays import Kind, measured_array
from tests.oracles.box_paths import box_contradiction, contradiction, observe_box
from tests.oracles.clause_evidence import evidence_holds
from tests.oracles.nearest_paths import observe
from tests.oracles.tied_arrays import scene_of, tied_array, tied_box, turning_pool, untied_array
from tests.plain import decided
from tests.proofs import test_symmetries as symmetries
from tests.proofs.robust.drawn_arrays import drawn_model, small_box
from tests.proofs.robust.test_nearest_bounds import twists
from tests.proofs.robust.test_smooth_discs import box_of
from tests.proofs.switched_oracle import Judge, Switched, leaves, random_conewise, random_relay

# ---- Two hundred random arrays through every symmetry of the fast tests. -------------------------

SYMMETRIC = 100  # of each kind: any wheels, and wheels on a circle
MAPS = (symmetries.TURN_3_4_5, 1), (symmetries.MIRROR, -1)
PLAIN = (
    symmetries.test_speeds,
    symmetries.test_time_reversal_swaps_the_ends_of_the_drift,
    symmetries.test_frictions,
    symmetries.test_reversed_rims_with_reversed_speeds_are_the_same_wheels,
    symmetries.test_the_length_of_a_rim_direction_does_not_matter,
    symmetries.test_numbering,
    symmetries.test_a_wheel_too_far_away_to_matter,
    symmetries.test_translation_of_the_array_with_its_equilibrium,
)


def test_every_symmetry(arrays: Arrays, stopwatch: Stopwatch) -> None:
    builders: tuple[Callable[[int], Scene], ...] = (
        lambda seed: arrays.random(seed, 3 + seed % 6).recentred(),
        arrays.cocircular,
    )
    for build in builders:
        for seed in range(1000, 1000 + SYMMETRIC):
            for matrix, sense in MAPS:
                symmetries.test_orthogonal_maps(build, seed, matrix, sense)
            symmetries.test_lengths(build, seed, Fraction(7, 3))
            for relation in PLAIN:
                relation(build, seed)
    stopwatch.report(f"{2 * SYMMETRIC} random arrays, {len(PLAIN) + 3} symmetries each: all hold")


# ---- A hundred thousand arrays with exact coincidences, ten thousand without, and some under ``box``: against
# paths.

TIED = int(os.environ.get("NONSMOOTH_TIED_ARRAYS", "100000"))
BLOCK = 250
FIRST_TIED = 1_000_000  # seeds that the fast tests do not use
LARGEST_SHARE_UNDECIDED = 0.02  # of arrays without a coincidence


def judged(first: int, tied: bool) -> tuple[Counter[str], list[int]]:
    """Verdicts of a block of arrays, and the seeds of those that paths contradict."""
    seen, wrong = Counter[str](), []
    for seed in range(first, first + BLOCK):
        wheels = tied_array(seed)[0] if tied else untied_array(seed)
        result = decide_translation(build_nearest_partition(scene_of(Arrays(), wheels)))
        seen[str(result.verdict)] += 1
        if not evidence_holds(result) or contradiction(result, observe(wheels, seed=seed, starts=6)):
            wrong.append(seed)
    return seen, wrong


@pytest.mark.parametrize("tied", [True, False], ids=["tied", "untied"])
def test_no_verdict_is_contradicted_by_paths(stopwatch: Stopwatch, tied: bool) -> None:
    turning_pool()  # once, before the processes part
    count = TIED if tied else TIED // 10
    seen, wrong = Counter[str](), list[int]()
    with ProcessPoolExecutor(mp_context=get_context("fork")) as workers:
        starts = range(FIRST_TIED, FIRST_TIED + count, BLOCK)
        for verdicts, seeds in workers.map(judged, starts, repeat(tied)):
            seen += verdicts
            wrong += seeds
    total = sum(seen.values())
    share = seen["undecided"] / total
    kind = "with coincidences" if tied else "without"
    stopwatch.report(f"{total} arrays {kind}: {dict(seen)}, {share:.2%} undecided, {len(wrong)} contradicted")
    assert wrong == []
    assert tied or share <= LARGEST_SHARE_UNDECIDED


def test_no_verdict_at_corners_of_box_cells_is_contradicted_by_paths(stopwatch: Stopwatch) -> None:
    seen, wrong = Counter[str](), []
    for seed in range(FIRST_TIED, FIRST_TIED + TIED // 100):
        wheels, at, partition = tied_box(Arrays(), seed)
        result = decide_translation(partition)
        seen[str(result.verdict)] += 1
        if box_contradiction(result, observe_box(wheels, at)):
            wrong.append(seed)
    stopwatch.report(f"{sum(seen.values())} corners of cells under box: {dict(seen)}, {len(wrong)} contradicted")
    assert wrong == []


# ---- Plain switched systems: 1,000 random ones of two kinds. -------------------------------------

COUNT = 1_000
FIRST_SYSTEM = 50_000  # seeds apart from those of the tests
MOST_UNDECIDED = 0.02


@pytest.mark.parametrize("generate", [random_relay, random_conewise])
def test_random_systems(stopwatch: Stopwatch, generate: Callable[[int], Switched]) -> None:
    seen: Counter[str] = Counter()
    against, slowest, began = {}, 0.0, time.perf_counter()
    for seed in range(FIRST_SYSTEM, FIRST_SYSTEM + COUNT):
        system, here = generate(seed), time.perf_counter()
        found = str(decided(system.rhs).verdict)
        slowest = max(slowest, time.perf_counter() - here)
        seen[found] += 1
        known = Judge(system).verdict()
        if found != "undecided" and known is not None and found != known:
            against[seed] = (found, known)
        elif found == "asymptotically stable" and leaves(system):
            against[seed] = (found, "a path leaves")
    spent = time.perf_counter() - began
    stopwatch.report(
        f"{COUNT} of {generate.__name__}: {dict(seen)}, wrong {against}, {spent:.0f} s, slowest {slowest:.1f} s"
    )
    assert against == {}
    assert seen["undecided"] <= MOST_UNDECIDED * COUNT


# ---- Thousands of arrays within tolerances, solved in floats: none breaks what is said, and how sharp it is.

DRAWN, PLACES = 1_000, 5
SLOPE_ARRAYS = 40
ROUNDING = 1e-7


@pytest.mark.parametrize(("name", "radius"), [("four-wheel", "7/10"), ("ring-5", "9/20"), ("spiral-30", "1/2")])
def test_no_array_breaks_the_disc(name: str, radius: str, stopwatch: Stopwatch) -> None:
    scene = load_scene(name, rule="box", radius=radius).recentred()
    within, rng = small_box(scene), np.random.default_rng(20)
    rule = BoxRingProof(scene)
    found, rests = rule.disc(within, Fraction(radius)), float(rule.rest_radius(within, Fraction(radius)))
    assert found is not None
    slowest, moved = np.inf, 0.0
    for k in range(DRAWN):
        model = drawn_model(scene, within, rng, corner=k % 2 == 0)
        angles = rng.uniform(0, 2 * np.pi, 2 * PLACES)
        sizes = np.r_[rng.uniform(float(found.radius), float(found.start), PLACES), np.full(PLACES, rests)]
        points = sizes[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
        motions = twists(model, points)
        rates = -(points[:PLACES] * motions[:PLACES, :2]).sum(axis=1) / sizes[:PLACES]
        slowest = min(slowest, float(rates.min()))
        moved = max(moved, float(np.abs(motions[PLACES:]).max())) if rests else moved
    stopwatch.report(
        f"{name}: ends within {float(found.radius):.3g}, rests within {rests:.3g}; {DRAWN * PLACES} points outside: "
        f"rate at least {slowest:.3g}, certified {float(min(found.rates)):.3g}; fastest at rest {moved:.1e}"
    )
    assert slowest >= float(min(found.rates)) - ROUNDING
    assert moved < ROUNDING


SHARE = Fraction(1, 64)  # of the tolerances: small enough that all grows in proportion to it


def farthest_outward(scene: Scene, box: Tolerance, most: float) -> float:
    """The largest distance at which some array of the box moves its body away from the point, of those tried."""
    rng, angles = np.random.default_rng(30), 2 * np.pi * np.arange(32) / 32
    rays, farthest = np.column_stack([np.cos(angles), np.sin(angles)]), 0.0
    sizes = most * np.linspace(0.02, 1.2, 60)
    points = (sizes[:, None, None] * rays).reshape(-1, 2)
    for _ in range(SLOPE_ARRAYS):
        model = drawn_model(scene, box, rng, corner=True)
        motions = EllipseMinimizer().minimize(model, loads_at(model, points)).twists
        outward = ((points * motions[:, :2]).sum(axis=1) >= 0).reshape(len(sizes), -1).any(axis=1)
        farthest = max(farthest, float(sizes[outward].max(initial=0.0)))
    return farthest


@pytest.mark.parametrize("rule", ["ellipse", "roller"])
@pytest.mark.parametrize("name", ["four-wheel", "ring-6"])
def test_the_radius_per_tolerance_beside_what_arrays_do(name: str, rule: str, stopwatch: Stopwatch) -> None:
    """Toward zero the certified radius is in proportion to the tolerances, and not far above what arrays need."""
    scene = load_scene(name, rule=rule).recentred()
    most, proof = Fraction(str(inner_radius(scene))), SmoothDisc(scene)
    certified = []
    for share in (SHARE, SHARE / 4):
        disc = proof.disc(box_of(scene, share), most)
        assert disc is not None
        certified.append(float(disc.radius / share))
    observed = farthest_outward(scene, box_of(scene, SHARE), certified[0] * float(SHARE)) / float(SHARE)
    stopwatch.report(
        f"{name}, rule {rule}: radius by tolerances {certified[0]:.3g} and {certified[1]:.3g} certified, "
        f"{observed:.3g} observed, {certified[0] / observed:.2g} times"
    )
    assert observed <= certified[0]
    assert max(certified) < 1.5 * min(certified)


# ---- The cells' twists against linear programs at a thousand points per array. -------------------

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


# ---- Every built-in scene and system under stress: all rows ok, each within five minutes; random arrays as well.

LEAST_ROWS, MINUTES = 30, 5


def hold(name: str, scene: Scene | SwitchedSystem, stopwatch: Stopwatch) -> None:
    start = time.perf_counter()
    rows = measure(scene, CASES).rows
    seconds = time.perf_counter() - start
    stopwatch.report(f"{name}: {len(rows)} rows in {seconds:.1f} s")
    assert [row for row in rows if not row.ok] == []
    assert len(rows) >= LEAST_ROWS
    assert seconds <= 60 * MINUTES


@pytest.mark.parametrize("name", [*builtin_scenes(), *planar_systems()])
def test_built_in(name: str, stopwatch: Stopwatch) -> None:
    hold(name, load_any(name), stopwatch)


@pytest.mark.parametrize("rule", ["box", "ellipse"])
@pytest.mark.parametrize("name", ["four-wheel", "off-center"])
def test_other_rules(name: str, rule: str, stopwatch: Stopwatch) -> None:
    hold(f"{name}, rule {rule}", load_scene(name, rule=rule), stopwatch)


@pytest.mark.parametrize("seed", range(6))
def test_arrays_at_random(seed: int, arrays: Arrays, stopwatch: Stopwatch) -> None:
    hold(f"random array {seed}", arrays.random(seed, 3 + seed % 4), stopwatch)
    hold(f"cocircular array {seed}", arrays.cocircular(seed), stopwatch)


# ---- Arrays as they are measured, at large: a hundred of each kind under every rule, and scenes that are too large.

MEASURED = 100
MEDIAN, LONGEST = 1, 10  # seconds of processor time
RULES = ("nearest", "box", "ellipse")
TOO_LONG = 120  # seconds for whatever is too large: an answer, or one line that says what is too much


def checked(path: Path, rule: str, capsys: pytest.CaptureFixture[str]) -> tuple[float, str]:
    """Seconds and verdict of ``check --json``."""
    start = time.process_time()
    status = run(app, ["check", str(path), "--rule", rule, "--json"])
    seconds = time.process_time() - start
    printed = capsys.readouterr()
    if status == 2:
        assert printed.err.count("\n") == 1
        return seconds, "refused"
    return seconds, str(json.loads(printed.out)["theorem4"]["verdict"])


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("kind", Kind)
def test_a_hundred_measured_arrays(
    kind: Kind, rule: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], stopwatch: Stopwatch
) -> None:
    path, times, verdicts = tmp_path / "my.toml", list[float](), Counter[str]()
    for seed in range(MEASURED):
        path.write_text(measured_array(kind, seed), encoding="utf-8")
        seconds, verdict = checked(path, rule, capsys)
        times.append(seconds)
        verdicts[verdict] += 1
    median, longest = statistics.median(times), max(times)
    stopwatch.report(f"{MEASURED} {kind}, {rule}: median {median:.2f} s, longest {longest:.2f} s, {dict(verdicts)}")
    assert median <= MEDIAN
    assert longest <= LONGEST


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("count", [101, 360])
def test_rings_of_many_wheels_end(
    count: int, rule: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], stopwatch: Stopwatch
) -> None:
    path = tmp_path / "my.toml"
    ring = f"[ring]\ncount = {count}\n[check]\nradius = 0.25\n"
    path.write_text(f"[friction]\nmu_roll = 1\nmu_side = 0.2\n{ring}", encoding="utf-8")
    seconds, verdict = checked(path, rule, capsys)
    stopwatch.report(f"ring of {count}, {rule}: {seconds:.1f} s, {verdict}")
    assert seconds <= TOO_LONG
