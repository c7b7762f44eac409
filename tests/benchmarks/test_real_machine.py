"""What the commands say of real machines, beside MuJoCo: outlines, heights, rollers, headings and closed loops.

Each line that a test of a command prints is one line of the table in ``docs/choose.md``.
"""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from nonsmooth.symbolic.files.scene_file import load_scene
from tests.benchmarks.conftest import Stopwatch
from tests.body_engine import TIME_CONSTANT, inward_grid, random_grid, run_beside_engine, with_random_body
from tests.measured_arrays import Kind, measured_array
from tests.real_machine import (
    Floats,
    Loop,
    Machine,
    Scattered,
    deflection,
    height_errors,
    machine,
    outline_pose,
    resting_heading,
    returning_heading,
    roller_errors,
    scattered_heading,
)
from tests.roller_engine import creep_rates

POSES, HANGING = 200, 50  # poses on the grid, and of bodies that may hang over its border
REACH, BEYOND = 1.7, 2.7  # of the centre of mass from the middle
MARGIN = 0.05  # pitches from the edge
MEDIAN, MOST = 3e-4, 2e-3  # relative errors of twists: the median, and nine of ten
HEIGHTS = 40  # arrays on wheels of unequal height
OWN_LOADS = 1e-4  # median with the loads of the engine; the largest seen of four medians 4e-5
ROLLERS, ROLLER_MEDIAN = 100, 2e-3
HEADINGS, HEADING = 4, 0.02  # paths to rest; radians
KEPT = [4, 6, 11, 13, 14, 16, 18, 23]  # mirrored arrays whose heading keeps on level wheels: the first eight
LAG = 2e-2  # relative, of the error of a closed loop: the engine settles, and the law acts on samples


def test_bodies_with_an_outline(stopwatch: Stopwatch, tmp_path: Path) -> None:
    poses = [outline_pose(seed, REACH, tmp_path) for seed in range(POSES)]
    poses += [outline_pose(seed, BEYOND, tmp_path) for seed in range(HANGING)]
    inside = [pose for pose in poses if not pose.tips and not pose.fell and pose.margin > MARGIN]
    for name, errors in (
        ("no outline", [pose.without for pose in inside]),
        ("outline", [pose.error for pose in inside]),
    ):
        median, most = np.median(errors), np.quantile(errors, 0.9)
        stopwatch.report(f"{name}: {len(errors)} twists, median {median:.1e}, nine of ten below {most:.1e}")
    assert median < MEDIAN
    assert most < MOST
    fell, tips = [pose for pose in poses if pose.fell], [pose for pose in poses if pose.tips]
    predicted = sum(pose.tips for pose in fell)
    stopwatch.report(f"{len(fell)} plates fell, {predicted} of them predicted; {len(tips)} predicted to tip")
    assert fell
    assert predicted == len(fell)


@pytest.mark.parametrize("share", [0.03, 0.1, 0.3, 1.0])
def test_wheels_of_unequal_height(share: float, stopwatch: Stopwatch, tmp_path: Path) -> None:
    """Level springs are wrong; the engine's own loads, given as measured, are right."""
    errors = np.array([height_errors(seed, share, tmp_path) for seed in range(HEIGHTS)])
    (level, own), most = np.median(errors, axis=0), np.quantile(errors, 0.9, axis=0)
    stopwatch.report(
        f"heights scattered by {share:.0%}: level springs median {level:.1e}, nine of ten below {most[0]:.1e}; "
        f"measured loads {own:.1e} and {most[1]:.1e}"
    )
    assert own < OWN_LOADS
    assert own < level / 10


def test_rollers(stopwatch: Stopwatch, tmp_path: Path) -> None:
    """Where the twist jumps, the engine's loads decide on which side a body is: those few arrays are far off."""
    found = [roller_errors(seed, tmp_path) for seed in range(ROLLERS)]
    stiff, errors = np.array([side > 0.1 for side, _ in found]), np.array([each for _, each in found])
    for name, chosen in (("mu_S up to 0.1", ~stiff), ("mu_S 0.1 to 0.5", stiff)):
        for rule, column in zip(("roller", "ellipse", "box"), errors[chosen].T, strict=True):
            median, most = np.median(column), np.quantile(column, 0.9)
            stopwatch.report(f"{name}, rule {rule}: median {median:.1e}, nine of ten below {most:.1e}")
    medians = np.median(errors, axis=0)
    assert medians[0] < ROLLER_MEDIAN
    assert medians[0] < medians[1] / 10
    assert np.quantile(errors[stiff, 0], 0.9) < np.quantile(errors[stiff, 2], 0.9) / 10


def test_headings_that_level_wheels_keep(stopwatch: Stopwatch, tmp_path: Path) -> None:
    """On wheels of unequal height bodies spin, and stay beside the point; with ``height`` nothing is promised."""
    found: list[Scattered] = []
    file = tmp_path / "mirrored.toml"
    for seed in KEPT:
        file.write_text(measured_array(Kind.MIRRORED, seed), encoding="utf-8")
        one = scattered_heading(file, seed, Fraction(3, 10), tmp_path)
        assert one is not None
        found.append(one)
    spin = [one for one in found if abs(one.turning) > 1e-3]
    beside = max(one.beside for one in found)
    stopwatch.report(
        f"heights scattered by 30 %: {len(spin)} of {len(KEPT)} spin, up to {beside:.2f} l beside the point"
    )
    assert len(spin) == len(KEPT)
    assert not any(one.scattered[1] == "keeps" for one in spin)


def test_headings_of_rest(stopwatch: Stopwatch, tmp_path: Path) -> None:
    returning = [returning_heading(offset, tmp_path) for offset in (0.05, -0.05)]
    seeds, resting = iter(range(100)), list[tuple[float, float]]()
    while len(resting) < HEADINGS:
        found = resting_heading(next(seeds), tmp_path)
        resting += [] if found is None else [found]
    apart = [max(abs(said - seen) for said, seen in pairs) for pairs in (returning, resting)]
    stopwatch.report(
        f"headings that the body turns to: within {apart[0]:.4f} rad; of paths that end at rest: {apart[1]:.4f}"
    )
    assert max(apart) < HEADING


# ---- closed loops --------------------------------------------------------------------------------


START = np.array(
    [0.009, 0.006, 0.012]
)  # in units of the scene's length, and radians: laws are certified near the point
LARGEST = 1e-3  # speed of rims at the start
LOOPS = ["ring-3", "ring-5", "mirrored 4", "mirrored 8", "mirrored 11"]


LIMIT = 1 / 3  # of what the law asks for at the start
UNEVEN = Fraction(3, 10)  # of the mean deflection
FRAGILE, HEIGHTS_OF_FRAGILE = "cocircular 22", (-1, 1, 1, -1, -1)  # heights on which a law of level springs fails
STALLED = 0.5  # of the error at the start


def source_of(name: str, folder: Path) -> Path:
    """The file of a built-in scene, or of a random one."""
    kind, _, seed = name.partition(" ")
    if not seed:
        return Path(load_scene.__code__.co_filename).parents[1] / "scenes" / f"{name}.toml"
    file = folder / f"{kind}{seed}.toml"
    file.write_text(measured_array(Kind(kind), int(seed)), encoding="utf-8")
    return file


def driven(driving: Machine, lowered: Floats | None = None) -> Loop:
    """From the start, at a gain at which no rim runs faster than :data:`LARGEST` without limits."""
    length = float(driving.scene.check.length)
    start = START * [length, length, 1]
    gain = LARGEST / max(abs(speed) for speed in driving.speeds(*start.tolist()).values())
    return driving.drive(start, gain, 2 / driving.rate, lowered)


@pytest.mark.parametrize("name", LOOPS)
def test_certified_loops_decay_as_certified(name: str, stopwatch: Stopwatch, tmp_path: Path) -> None:
    loop = driven(machine(source_of(name, tmp_path), tmp_path))
    stopwatch.report(
        f"closed loop of {name}: error {loop.errors[-1] / loop.errors[0]:.3f} of the start at 2/(kappa k), "
        f"at most {loop.late:.3f} of what is certified"
    )
    assert loop.late < 1 + LAG


def test_a_loop_whose_speeds_end(stopwatch: Stopwatch, tmp_path: Path) -> None:
    """Where a wheel is at its limit sqrt(V) falls at least at the stated speed, elsewhere at the stated rate."""
    free = machine(source_of("ring-5", tmp_path), tmp_path)
    length = float(free.scene.check.length)
    start = START * [length, length, 1]
    asked = max(abs(speed) for speed in free.speeds(*start.tolist()).values())
    text = source_of("ring-5", tmp_path).read_text("utf-8")
    file = tmp_path / "limited.toml"
    limit = LARGEST * LIMIT
    drive, field = f"[drive]\nspeed_limit = {limit!r}\n[ring]", 'kind = "radial"\nspeed = 1e-5'
    slow = text.replace("[ring]", drive).replace('kind = "radial"', field)
    file.write_text(slow, encoding="utf-8")
    limited = machine(file, tmp_path)
    gain = LARGEST / asked
    loop = limited.drive(start, gain, 2 / limited.rate + 2)
    speed = limited.speed / gain  # per unit of k t
    falls = -np.diff(loop.errors) / np.diff(loop.times)
    least = np.minimum(limited.rate * loop.errors[1:], speed)
    stopwatch.report(
        f"speeds that end: up to {loop.largest:.3f} of the limit; sqrt(V) falls at {(falls / least).min():.2f} times "
        f"what is certified, or faster; {loop.errors[-1] / loop.errors[0]:.3f} of the start is left"
    )
    assert loop.largest == pytest.approx(1)
    assert (falls > least * (1 - LAG)).all()
    assert loop.errors[-1] < 0.3 * loop.errors[0]


@pytest.mark.parametrize("name", [*LOOPS, "mirrored 2", "mirrored 5", FRAGILE])
def test_loops_certified_for_wheels_of_unequal_height(name: str, stopwatch: Stopwatch, tmp_path: Path) -> None:
    """The error falls as certified for every height within 30 % of the mean deflection, here at the largest ones."""
    driving = machine(source_of(name, tmp_path), tmp_path, UNEVEN)
    depth = float(UNEVEN) * deflection(driving.scene, time_constant=TIME_CONSTANT)
    signs = np.random.default_rng(1).choice([-1, 1], len(driving.scene.wheels))
    loop = driven(driving, depth * (np.array(HEIGHTS_OF_FRAGILE) if name == FRAGILE else signs))
    stopwatch.report(
        f"{name}, heights scattered by 30 %: certified rate {driving.rate:.3f} k; error "
        f"{loop.errors[-1] / loop.errors[0]:.3f} of the start at 2/(kappa k), at most {loop.late:.3f} of what is "
        "certified"
    )
    assert loop.late < 1 + LAG


def test_a_law_of_level_springs_stalls_on_unequal_wheels(stopwatch: Stopwatch, tmp_path: Path) -> None:
    """It is not certified for these heights; the law that is certified for them, above, comes home on them."""
    driving = machine(source_of(FRAGILE, tmp_path), tmp_path)
    depth = float(UNEVEN) * deflection(driving.scene, time_constant=TIME_CONSTANT)
    loop = driven(driving, depth * np.array(HEIGHTS_OF_FRAGILE))
    stopwatch.report(
        f"{FRAGILE}, heights scattered by 30 %, law of level springs: error {loop.errors[-1] / loop.errors[0]:.2f} of "
        f"the start at 2/(kappa k), {loop.late:.1f} times what is certified of level wheels"
    )
    assert loop.errors[-1] > STALLED * loop.errors[0]


# ---- whole paths of bodies with an outline -------------------------------------------------------

RUNS = 3  # of each kind; the third random one reacts strongly to loads: poses come out 0.11 apart
LATE = 0.08  # of changes, at wheels of speed one; the engine is late by some per cent


@pytest.mark.parametrize("kind", ["random", "inward"])
def test_paths(kind: str, stopwatch: Stopwatch) -> None:
    runs = []
    for seed in range(RUNS):
        rng = np.random.default_rng(seed + 1)
        grid = random_grid(rng) if kind == "random" else inward_grid(Fraction(1, 2))
        runs.append(run_beside_engine(with_random_body(grid, rng, 1.2), 0.7))
    alike, tips = sum(run.changes_alike(LATE) for run in runs), sum(run.tips_alike for run in runs)
    far = max(run.error for run in runs)
    stopwatch.report(
        f"{kind}: {alike} of {RUNS} paths with the same changes, {tips} with the same end, poses {far:.3f} apart"
    )
    assert all(run.path.end.reason.name == "TIPS" for run in runs if run.fell is not None)
    assert alike >= RUNS - 1


# ---- rollers that stand --------------------------------------------------------------------------

CREEP = 2e-2  # relative, of the speed at which the body comes home near the point


@pytest.mark.parametrize("side", [0.02, 0.05, 0.1, 0.2, 0.5])
def test_creep_at_rest(side: float, stopwatch: Stopwatch) -> None:
    rates = creep_rates(side)
    stopwatch.report(f"creep at rest, mu_S = {side}: {rates[0]:.4f}, {rates[1]:.4f} |c|; sqrt(2) = {np.sqrt(2):.4f}")
    assert rates == pytest.approx(np.sqrt(2), rel=CREEP)
