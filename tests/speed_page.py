"""The measured parts of ``docs/speed.md``: ``python -m tests.speed_page docs``, which ``make bench`` calls.

Work of this program beside the same work by other software, in one run: both take turns, nine times, and the median of
the nine ratios of processor times is what each row must reach.  So a busy machine slows both.  Each pair is compared in
a test or benchmark of its own, named on the page; here only times are taken.  The exit status is 1 where a ratio is
missed; the page is written all the same, and says so.
"""

from __future__ import annotations

import gc
import io
import os
import platform
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import redirect_stdout
from dataclasses import replace
from fractions import Fraction
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple

import numpy as np

from nonsmooth.analysis.cells.box import build_box_partition
from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.fields.constant_field import array_field
from nonsmooth.analysis.fields.contact_model import contact_model, contacts_under
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.reports.output.files import output_path, write_whole
from nonsmooth.reports.output.processes import GARBAGE_THRESHOLD
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.scene import Scene
from tests.conftest import Arrays

ROUNDS = 9
Work = Callable[[], object]
MEASURED = re.compile(r"(?s)(<!-- (machine|ratios|starts|growth) -->\n).*?(?=<!-- end -->)")


class Pair(NamedTuple):
    """The same work twice.

    Attributes:
        work: what is done.
        other: by what else.
        prepare: both, ours first, ready to be timed.
        required: the other's time over ours, at least.
        asked: what is to be reached in the end; None where the required ratio is all that was asked.
        source: where both results are compared.
        repeats: of ours in each round, whose mean counts: short runs may fall into a slow moment.
        share: how many times as many points ours takes: times of the page are of as many as the other takes.
    """

    work: str
    other: str
    prepare: Callable[[], tuple[Work, Work]]
    required: float
    asked: float | None
    source: str
    repeats: int = 10
    share: int = 1


class Timed(NamedTuple):
    """Medians of the rounds: seconds of ours and of the other, and their ratio."""

    ours: float
    theirs: float
    ratio: float


# ---- the pairs -----------------------------------------------------------------------------------

FEW, SHARE = 40, 100  # points of SciPy and CVXPY, and how many times as many ours takes at once


def partition_beside_ppopt(name: str) -> tuple[Work, Work]:
    from ppopt.mp_solvers.solve_mpqp import mpqp_algorithm, solve_mpqp

    from tests.benchmarks.test_box_speed import four_wheel, parametric_program

    algorithm, model = getattr(mpqp_algorithm, name), contact_model(four_wheel(Arrays()))
    return (
        lambda: build_box_partition(four_wheel(Arrays())),
        lambda: solve_mpqp(parametric_program(model, 0.5), algorithm),
    )


def triples_beside_sympy() -> tuple[Work, Work]:
    import sympy

    from tests.benchmarks.test_symbolic_derivation import by_number_field, by_sympy

    def theirs() -> None:
        sympy.core.cache.clear_cache()
        by_sympy()

    return lambda: by_number_field(Arrays()), theirs


def twists_beside_highs() -> tuple[Work, Work]:
    from nonsmooth.analysis.minimizers.agreement import PointLocator
    from nonsmooth.analysis.minimizers.box_minimizers import BoxHighs
    from nonsmooth.analysis.minimizers.float_loads import loads_at

    scene = load_scene("four-wheel", rule="box")
    locator, model = PointLocator(build_box_partition(scene)), contact_model(scene)
    points = np.random.default_rng(0).uniform(-0.5, 0.5, (SHARE * FEW, 2))
    loads = loads_at(model, points[:FEW])
    return lambda: locator.twists(points), lambda: BoxHighs().minimize(model, loads)


def minimizer_beside_cvxpy() -> tuple[Work, Work]:
    """CVXPY's program is stated once with parameters."""
    from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseMinimizer
    from nonsmooth.analysis.minimizers.minimum import Functional
    from tests.benchmarks.test_minimizer_speed import loads_of
    from tests.oracles.cvxpy_programs import CvxpyMinimizer

    model = contact_model(load_scene("four-wheel"))
    stated = CvxpyMinimizer(Functional.ELLIPSE, compiled=True)
    few, many = loads_of(model, FEW), loads_of(model, SHARE * FEW)
    return lambda: EllipseMinimizer().minimize(model, many), lambda: stated.minimize(model, few)


def events_beside_hysteresis() -> tuple[Work, Work]:
    from nonsmooth.analysis.trajectories.hysteresis import simulate_hysteresis

    field = array_field(build_nearest_partition(load_scene("four-wheel", radius="1")), Kinematics.EXACT)
    start, until, width = (0.8, 0.3, 0.0), 1.0, 1e-3
    return (
        partial(simulate, field, start, until),
        partial(simulate_hysteresis, field, start, until, width, width),
    )


def events_beside_scipy() -> tuple[Work, Work]:
    from nonsmooth.analysis.fields.system_field import system_field
    from nonsmooth.symbolic.files.scene_file import load_system
    from tests.benchmarks.test_trajectory_speed import flower_path, scipy_events

    return partial(flower_path, system_field(load_system("flower"))), partial(scipy_events, dense=False)


def audit_beside_z3() -> tuple[Work, Work]:
    from nonsmooth.proofs.system_audit import audit
    from tests.benchmarks.test_solver_speed import Case, decrease, questions_of, system_of
    from tests.oracles.solver_questions import ask, with_z3

    potential = "Abs(x + y) + x**2 + x*y/2 + y**2/2"
    case = Case("sliding on x + y", "x y", ["y", "-2*sign(x + y) + x/2"], potential)
    system = system_of(case, case.radius)
    questions = questions_of(case, potential, case.radius, ">=")
    if decrease(audit(system, potential)).name != "STRICT" or ask(with_z3, questions, 20.0).said != "proved":
        raise ValueError("required a V that both prove")
    return lambda: audit(system, potential), lambda: ask(with_z3, questions, 20.0)


def feedback_beside_z3() -> tuple[Work, Work]:
    from tests.benchmarks.test_feedback_speed import rate_beside_z3

    return rate_beside_z3()


def body_beside_mujoco() -> tuple[Work, Work]:
    """A plate on 36 wheels with inward rims; the engine's wheels are so slow that its loads are those at rest."""
    from nonsmooth.analysis.bodies.path import BodyPath
    from tests.body_engine import BRISK, TIME_CONSTANT, TIMESTEP, ellipse, inward_grid, plate_engine, with_random_body

    scene = with_random_body(inward_grid(Fraction(1, 2)), np.random.default_rng(1), 1.2)
    x, y = (float(entry) for entry in scene.check.equilibrium)
    until = 0.2

    def theirs() -> None:
        plate = plate_engine(scene, (x, y, 0.0), BRISK, timestep=TIMESTEP, time_constant=TIME_CONSTANT)
        plate.step(1.0 + until / BRISK)

    return lambda: BodyPath(contacts_under(ellipse(), scene), scene).follow([x, y, 0.0], until), theirs


PAIRS = (
    Pair(
        "exact partition of rule `box`, four wheels",
        "PPOPT, graph",
        partial(partition_beside_ppopt, "graph"),
        250,
        250,
        "test_box_speed",
    ),
    Pair(
        "the same",
        "PPOPT, combinatorial",
        partial(partition_beside_ppopt, "combinatorial"),
        500,
        500,
        "test_box_speed",
    ),
    Pair(
        "40 regular triples of rows, exactly",
        "SymPy, LUsolve and simplify",
        triples_beside_sympy,
        400,
        400,
        "test_symbolic_derivation",
    ),
    Pair(
        "feedback inequalities of four wheels, eight cones",
        "Z3",
        feedback_beside_z3,
        150,
        150,
        "test_feedback_speed",
    ),
    Pair(
        "40 twists of rule `box` at points, of 4,000",
        "SciPy, HiGHS",
        twists_beside_highs,
        500,
        None,
        "test_box_speed",
        share=SHARE,
    ),
    Pair(
        "40 minimizers of rule `ellipse`, of 4,000",
        "CVXPY with parameters",
        minimizer_beside_cvxpy,
        300,
        300,
        "test_minimizer_speed",
        repeats=1,
        share=SHARE,
    ),
    Pair(
        "one path by events, rule `nearest`",
        "hysteresis of width 1/1000",
        events_beside_hysteresis,
        10,
        None,
        "test_trajectory_speed",
    ),
    Pair(
        "26 crossings of a piecewise linear system",
        "SciPy, events without dense output",
        events_beside_scipy,
        5,
        5,
        "test_trajectory_speed",
        repeats=1,
    ),
    Pair("audit of a V in the plane", "Z3, questions alone", audit_beside_z3, 0.5, None, "test_solver_speed"),
    Pair("path of a plate on 36 wheels", "MuJoCo", body_beside_mujoco, 10, None, "test_real_machine", repeats=1),
)


def measured(pair: Pair) -> Timed:
    """Both in turn."""
    with redirect_stdout(io.StringIO()):  # PPOPT says where it begins
        ours, theirs = pair.prepare()
        ours(), theirs()
        rounds = [(seconds(ours, pair.repeats) / pair.share, seconds(theirs, 1)) for _ in range(ROUNDS)]
    return Timed(*(median(column) for column in zip(*((a, b, b / a) for a, b in rounds), strict=True)))


def seconds(work: Work, repeats: int) -> float:
    """Mean processor time."""
    start = time.process_time()
    for _ in range(repeats):
        work()
    return (time.process_time() - start) / repeats


# ---- starts --------------------------------------------------------------------------------------

MOST = 1.4  # of `import sympy`
COMMANDS = tuple(("check", "four-wheel", "--rule", rule) for rule in ("nearest", "box", "ellipse", "roller"))


def starts() -> dict[tuple[str, ...], float]:
    """Median of nine ratios of whole commands, interpreter included, over ``import sympy``; bytecode is there."""
    from tests.benchmarks.test_cold_start import COMMAND_LINE, processor_time, with_bytecode

    ratios: dict[tuple[str, ...], list[float]] = {command: [] for command in COMMANDS}
    with tempfile.TemporaryDirectory() as folder:
        environment = with_bytecode(Path(folder))
        for round_number in range(ROUNDS + 1):
            sympy = processor_time(environment, "-c", "import sympy")
            for command, found in ratios.items():
                took = processor_time(environment, *COMMAND_LINE, *command)
                if round_number:  # the first writes bytecode
                    found.append(took / sympy)
    return {command: median(found) for command, found in ratios.items()}


# ---- growth --------------------------------------------------------------------------------------

SIDES = (2, 4, 6, 8, 10)


def grid(side: int) -> Scene:
    scene = Arrays().grid(side, side, (1, Fraction(1, 5)))
    if side > 2:
        return scene
    # wheels at (+-1/2, +-1/2): stay inside the support polygon
    return replace(scene, check=replace(scene.check, radius=scene.field(Fraction(2, 5))))


def grow(side: int) -> str:
    """Cells of rule ``box``, seconds, and the largest memory of a process that does nothing else."""
    scene = grid(side)
    start = time.process_time()
    cells = len(build_box_partition(scene).cells)
    took = time.process_time() - start
    held = re.search(r"VmHWM:\s*(\d+) kB", Path("/proc/self/status").read_text(encoding="ascii"))
    return f"{cells} {took} {int(held[1]) / 1024 if held else 0}"  # getrusage would count what the parent held


def growth() -> Iterator[tuple[str, ...]]:
    for side in SIDES:
        command = [sys.executable, "-m", "tests.speed_page", "--grow", str(side)]
        said = subprocess.run(command, check=True, capture_output=True, text=True).stdout.split()
        cells, took, memory = int(said[0]), float(said[1]), float(said[2])
        yield f"{side**2}", f"{cells}", f"{took:.2f}", f"{1e3 * took / cells:.1f}", f"{memory:.0f}"


# ---- the page ------------------------------------------------------------------------------------


def ratio_rows(found: Sequence[tuple[Pair, Timed]]) -> Iterator[tuple[str, ...]]:
    for pair, timed in found:
        asked = "" if pair.asked is None else f"{pair.asked:g}"
        reached = f"{timed.ratio:.3g}" + ("" if timed.ratio >= pair.required else " (missed)")
        times = (f"{1e3 * took:.3g} ms" for took in (timed.ours, timed.theirs))
        yield pair.work, pair.other, *times, reached, f"{pair.required:g}", asked, f"`{pair.source}`"


def table(header: Sequence[str], rows: Iterator[tuple[str, ...]]) -> str:
    lines = [header, ["---"] * len(header), *rows]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def machine() -> str:
    load = f"{os.getloadavg()[0]:.1f} processes waiting on {os.cpu_count()} cores as it ended"
    return f"Python {platform.python_version()} on {platform.machine()}; {load}.\n"


def write_page(folder: Path) -> list[str]:
    """Measure, write ``speed.md``, and say what was missed."""
    found = []
    for pair in PAIRS:
        found.append((pair, measured(pair)))
        print(f"{pair.work}, {pair.other}: {found[-1][1].ratio:.3g}", flush=True)
    cold = starts()
    begun = ((f"`nonsmooth {' '.join(command)}`", f"{ratio:.2f}", f"{MOST}") for command, ratio in cold.items())
    header = ("work", "beside", "ours", "the other", "ratio", "required", "asked", "compared in")
    grown = table(("wheels", "cells", "s", "ms per cell", "memory [MB]"), growth())
    parts: dict[str, str] = {
        "ratios": table(header, ratio_rows(found)),
        "starts": table(("command", "over `import sympy`", "at most"), begun),
        "growth": grown,
        "machine": machine(),
    }
    page = folder / "speed.md"
    text = MEASURED.sub(lambda part: part[1] + parts[part[2]], page.read_text(encoding="utf-8"))
    write_whole(output_path(str(page), (".md",)), text.encode())
    late = [f"{pair.work}, {pair.other}: {timed.ratio:.3g}" for pair, timed in found if timed.ratio < pair.required]
    return late + [f"{' '.join(command)}: {ratio:.2f}" for command, ratio in cold.items() if ratio > MOST]


def main(arguments: Sequence[str]) -> Any:
    gc.set_threshold(GARBAGE_THRESHOLD)  # as every command does
    if arguments[0] == "--grow":
        print(grow(int(arguments[1])))
        return 0
    missed = write_page(Path(arguments[0]))
    return f"missed: {'; '.join(missed)}" if missed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
