"""Scene files that ask for as much work as they can: one line and status 2, or a verdict, within bounded work.

Small ones are checked here; the thorough ones are run with a limit of processor time, as a user would run them.
"""

from __future__ import annotations

import re
import resource
import subprocess
import sys
import time
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
import pytest
from scipy.sparse import coo_array

from nonsmooth.analysis.cells.loads import LoadError, elastic_loads_at
from nonsmooth.proofs.findings import Translation
from nonsmooth.proofs.inequalities.linear_program import solve_program
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.reports.cli import app
from nonsmooth.reports.output.console import run
from nonsmooth.symbolic.files.scene_file import load_scene, load_system
from nonsmooth.symbolic.messages.scene_error import SceneError
from tests.thorough import thorough

SECONDS = 10.0  # of processor time, for the reading alone
ALLOWED = 60  # seconds of processor time of a whole command on a busy machine; an idle one takes some 20 at most
RANDOM = np.random.default_rng(1)


def digits(count: int) -> str:
    return "".join(map(str, RANDOM.integers(1, 10, count)))


def system(f: str, g: str = "-y", more: str = "") -> str:
    return f'[system]\nstates = ["x", "y"]\nrhs = ["{f}", "{g}"]\n{more}\n'


def regions(guards: Sequence[str], inside: Sequence[str] = ("1", "1"), outside: Sequence[str] = ("-x", "-2*y")) -> str:
    tables = [f'[[region]]\nwhere = "{guard}"\nrhs = ["{inside[0]}", "{inside[1]}"]\n' for guard in guards]
    return '[system]\nstates = ["x", "y"]\n' + "".join(tables) + f'[[region]]\nrhs = ["{outside[0]}", "{outside[1]}"]\n'


def inward(places: Iterable[tuple[object, object]]) -> str:
    """Wheels at some places that push to the origin."""
    return "".join(f'[[wheel]]\nheading = "inward"\nposition = [{x}, {y}]\n' for x, y in places)


def array(rule: str, wheels: int, length: int) -> str:
    """Wheels at random places, whose coordinates are long fractions, about the middle of the square."""
    places = RANDOM.integers(-50, 51, (wheels, 2))
    entry = '[[wheel]]\nposition = ["{}/11 + {}/1{}", "{}/13 + 1/7{}"]\nheading = "pi/{}"\nspeed = 1\n'
    tables = [
        entry.format(x, digits(length), digits(length), y, digits(length), k % 6 + 1) for k, (x, y) in enumerate(places)
    ]
    head = f'[friction]\nmu_roll = 1\nmu_side = "1/2"\n[contact]\nrule = "{rule}"\n[check]\nradius = "1/100"\n'
    return head + "equilibrium = [0, 0]\n" + "".join(tables)


REFUSED: dict[str, str | bytes] = {
    "a large exponent": system("x**(10**9)"),
    "another one": system("x**1000000000"),
    "a tower of powers": system("-x*((((1e399)**16)**16)**16)"),
    "powers of powers": system("-x*(((((7**16)**16)**16)**16)**16)"),
    "a high degree": system("*".join(["(x + y + 1)"] * 200)),
    "brackets": system("(" * 5000 + "-x" + ")" * 5000),
    "minus signs": system("-" * 19001 + "x"),
    "digits": system("-x*" + "9" * 1000),
    "a quotient of digits": system("-x/" + "7" * 6000),
    "a power of ten": system("-x*1e999999999"),
    "a long text": system("x" * 1_000_000),
    "many tables": regions(["x > 0"] * 3000),
    "many states": '[system]\nstates = ["x"' + ', "x"' * 20_000 + ']\nrhs = ["1"]\n',
    "nested lists": "a = " + "[" * 5000 + "]" * 5000,
    "a dotted key": ".".join("a" * 100_000) + " = 1",
    "a whole number": "a = " + "9" * 100_000,
    "no text": b"\x00\x01",
    "no UTF-8": b"\xff\xfe[system]\x80",
    "empty": "",
}


def written(folder: Path, content: str | bytes) -> str:
    file = folder / "scene.toml"
    file.write_bytes(content if isinstance(content, bytes) else content.encode())
    return str(file)


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_read_is_refused_in_one_line(tmp_path: Path, name: str) -> None:
    file = written(tmp_path, REFUSED[name])
    start = time.process_time()
    for load in (load_system, load_scene):
        with pytest.raises(SceneError) as refused:
            load(file)
        assert "\n" not in str(refused.value)
        assert len(str(refused.value)) < 600
    assert time.process_time() - start < SECONDS


def test_a_square_beyond_the_range_of_floats_is_checked(tmp_path: Path) -> None:
    """Floats propose nothing there; the verdict is exact, and this ended in a fault."""
    small = "1/" + "9" * 390
    scene = system("-x - sign(y)*x**2/7", more=f'[check]\nradius = "{small}"\n')
    assert decide_system(load_system(written(tmp_path, scene))).verdict is Translation.ASYMPTOTICALLY_STABLE


BEYOND = "*1e300*1e300"


@pytest.mark.usefixtures("without_reach")
def test_numbers_beyond_floats_propose_nothing(tmp_path: Path) -> None:
    """Rows for linear and conic programs hold infinities there; warnings are errors in the tests."""
    for name, f, g in (
        ("linear rows", f"-x{BEYOND} + y**2{BEYOND}", f"-y{BEYOND}"),
        ("conic rows", f"-x - sign(y)*x**2{BEYOND}", f"-y{BEYOND}"),
    ):
        verdict = decide_system(load_system(written(tmp_path, system(f, g)))).verdict
        assert verdict is Translation.ASYMPTOTICALLY_STABLE, name


def test_a_line_beyond_floats_bounds_no_mesh(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The mesh of a basin ended in "OverflowError: int too large to convert to float"."""
    file = written(tmp_path, system("y", "-x - y - (Max(x - 1/4, 0) + Min(x + 1e300, 0))"))
    assert run(app, ["check", file]) == 0
    assert "asymptotically stable" in " ".join(capsys.readouterr().out.split())


def test_linear_programs_beyond_floats_have_no_solution() -> None:
    """SciPy raised a ValueError, with which `check` ended (`y, -x - y - sign(x + 1e300*y)`)."""
    for costs, table in (([np.inf, 1.0], np.eye(2)), ([1.0, 1.0], coo_array(np.array([[np.nan, 1.0]])))):
        found = solve_program(costs, A_ub=table, b_ub=np.ones(table.shape[0]))
        assert (found.status == 0, found.success, found.x) == (False, False, None)
    assert solve_program([1.0, 1.0], A_ub=coo_array(np.eye(2)), b_ub=np.ones(2)).success


def test_a_half_width_beyond_floats_is_refused(tmp_path: Path) -> None:
    scene = system("-x - sign(y)*x**2/7", more=f'[check]\nradius = "{"9" * 390}"\n')
    with pytest.raises(SceneError, match=r"check\.radius: required a number of at most"):
        load_system(written(tmp_path, scene))


def test_loads_of_long_coordinates_are_refused(tmp_path: Path) -> None:
    """Each load is a fraction over the common denominator of all positions."""
    scene = load_scene(written(tmp_path, array("ellipse", 150, 190)))
    with pytest.raises(LoadError, match="common denominator") as refused:
        elastic_loads_at(scene, scene.check.equilibrium)
    assert "\n" not in str(refused.value)


LONG = "9" * 380
CHECKED = {
    "empty quartic": regions(["x**2*y - x**4 - y**2 > 0"]),
    "tangent parabolas": regions(["(y - x**2)*(y - 2*x**2) < 0"]),
    "degree 16": regions(["(x + 2*y)**16 - x**2*y**3 - y**15 + x**9 > 0"]),
    "long quartic": regions([f"x**4*{LONG} - y**2*{LONG[:300]} + x*y*x/{LONG[:350]} > 0"]),
    "sextics": regions([f"x**6 + {k}*y**5 - x*y*{k + 1}/7 + x**2*y > 0" for k in range(4)]),
    "eleven parabolas": regions([f"{k + 1}*y - {k * k + 1}*x**2 > 0" for k in range(11)]),
    "kinks": system("-x" + "".join(f" - Abs(x - {k}*y/7)/100" for k in range(40))),
    "long lines": system(f"-x - sign({LONG}*x + {LONG[:370]}*y)/3", f"-y - sign(y*{LONG[:333]} - x*{LONG[:377]})/2"),
    "a small square": system("-x - sign(y)*x**2/7", more=f'[check]\nradius = "1/{LONG}"\n'),
    "a high V": system("-x - sign(x)", more='[check]\nlyapunov = "(x**2 + y**2)**8 + Abs(x)**15"\n'),
    "large V": system(
        "-x - sign(y)*x**2/7", "-y**3 - y", f'[check]\nlyapunov = "(x**2 + y**2)**8*{LONG} + x**3*y**13/{LONG[:370]}"\n'
    ),
    "fast waves": system("-x - sin(x*1e300)*sin(y*1e300)", "-y + sin(x*1e300) - sign(y)"),
    "one state": f'[system]\nstates = ["x"]\nrhs = ["-x**16*sign(x)*{LONG} - (x + 1/{LONG})**15*x"]\n',
    "wheels, nearest": array("nearest", 300, 150),
    "wheels, box": array("box", 30, 150),
    "wheels, ellipse": array("ellipse", 30, 150),
}
COMMANDS = ("check", "simulate", "derive")


@thorough
@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("name", CHECKED)
def test_commands_end(tmp_path: Path, name: str, command: str) -> None:  # small: the test above, test_emptiness
    file = written(tmp_path, CHECKED[name])
    limits = (ALLOWED, ALLOWED + 5)
    run = subprocess.run(
        [sys.executable, "-m", "nonsmooth", command, file],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        check=False,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, limits),
    )
    assert run.returncode in (0, 1, 2, 3)
    assert "Traceback" not in run.stderr
    if run.returncode == 2:
        told = re.compile(r".* \(\d+ s\)")  # of long work, every ten seconds
        assert len([line for line in run.stderr.strip().splitlines() if not told.fullmatch(line)]) == 1


@pytest.mark.parametrize(
    ("key", "wheel", "friction"),
    [
        ("friction.mu_roll", "", "mu_roll = 1e400\nmu_side = 0.4"),
        ("wheel[2].position", "position = [-1e390, 0.1]\nspeed = 0.3", "mu_roll = 0.8\nmu_side = 0.4"),
        ("wheel[2].speed", "position = [-0.2, 0.1]\nspeed = 1e400", "mu_roll = 0.8\nmu_side = 0.4"),
    ],
)
def test_a_number_beyond_floats_is_named_where_they_fail(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], key: str, wheel: str, friction: str
) -> None:
    """``check`` ended in "ValueError: math domain error" and the like."""
    usual = [f"position = [{x}, {y}]\nspeed = 0.3" for x, y in ((0.2, 0.1), (-0.2, 0.1), (-0.2, -0.1), (0.2, -0.1))]
    tables = [f'[[wheel]]\nheading = "inward"\n{own}\n' for own in (usual[0], wheel or usual[1], *usual[2:])]
    file = written(tmp_path, f"[friction]\n{friction}\n[check]\nradius = 0.1\nequilibrium = [0, 0]\n{''.join(tables)}")
    for command in (["check", file, "--rule", "ellipse"], ["export", file, "--rule", "ellipse"]):
        assert run(app, command) == 2
        said = capsys.readouterr().err
        assert said.startswith(f"nonsmooth: {file}: {key}: required 0 or a size of 1e-150 to 1e+150")
        assert said.count("\n") == 1


@pytest.mark.parametrize(
    ("table", "key", "value"),
    [
        ("check", "accuracy", "1e400"),
        ("check", "accuracy", "1e-400"),
        ("check", "length", "1e400"),
        ("drive", "speed_limit", "1e160"),
        ("body", "mass", "1e160"),
        ("body", "gravity", "1e-400"),
    ],
)
def test_a_number_that_floats_fail_on_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], table: str, key: str, value: str
) -> None:
    """``check`` ended in "OverflowError: integer division result too large for a float" and the like."""
    wheels = inward(((1, 1), (-1, 1), (-1, -1), (1, -1)))
    units = 'units = { length = "m" }\n' if table == "body" else ""
    file = written(tmp_path, f"{units}[friction]\nmu_roll = 1\nmu_side = 0.5\n[{table}]\n{key} = {value}\n{wheels}")
    assert run(app, ["check", file]) == 2
    said = capsys.readouterr().err
    assert re.search(rf"{table}\.{key}: required (0 or )?a size of 1e-\d+ to 1e\+\d+", said)
    assert said.count("\n") == 1


@pytest.mark.parametrize("command", [["check"], ["simulate", "--grid", "2"], ["sweep", "--vary", "mu_side=0.1:0.2:2"]])
def test_a_place_beyond_floats_is_refused_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: list[str]
) -> None:
    """A sweep ended in an AttributeError; under `nearest` NumPy warned of infinite floats beside the refusal."""
    wheels = inward(((-1, "1e400"), (1, 0), (0, -1)))
    file = written(tmp_path, f"[friction]\nmu_roll = 1\nmu_side = 0.5\n{wheels}")
    assert run(app, [command[0], file, *command[1:]]) == 2
    said = capsys.readouterr().err
    assert "wheel[1].position: required 0 or a size of 1e-150 to 1e+150" in said
    assert said.count("\n") == 1


def test_a_square_beyond_its_support_is_refused_in_a_short_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its half-width was written with four hundred digits."""
    file = written(tmp_path, "[friction]\nmu_roll = 1\nmu_side = 0.5\n[ring]\ncount = 4\n[check]\nradius = 1e400\n")
    assert run(app, ["check", file, "--rule", "ellipse"]) == 2
    assert "received ~1.00000e+400" in capsys.readouterr().err


def test_paths_of_gains_whose_powers_are_beyond_floats(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """NumPy warned of overflows, and a map ended in "OverflowError: Numerical result out of range"."""
    file = written(tmp_path, system("-x/8 - y*(3 - sign(x*y))/2", "x*(3 + sign(x*y))/2 - 1e300*y"))
    assert run(app, ["simulate", file, "--from", "0.1,0.2"]) == 0
    assert "ends 0.0779 from the checked point" in capsys.readouterr().out  # exp(-1/4)/10: y rests at once
    assert run(app, ["simulate", file, "--grid", "3"]) == 0
    assert "not followed to the end" in capsys.readouterr().out
