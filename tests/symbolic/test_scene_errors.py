"""Whatever is wrong with a scene: one SceneError, one printable line, naming the file and the key."""

from __future__ import annotations

import datetime
import pickle
from decimal import Decimal
from pathlib import Path
from typing import Any

import pytest

from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.scene_error import SceneError, StatedFact, shown
from tests.thorough import few

FRICTION = '[friction]\nmu_roll = 1\nmu_side = "1/2"\n'
WHEEL = "[[wheel]]\nposition = [1, 0]\n"
TWO = WHEEL + "[[wheel]]\nposition = [0, 2]\n"
RING = "[ring]\ncount = 3\n"
CSV = '[wheels]\nfile = "w.csv"\n'
LONGEST_LINE = 500  # characters; the longest message lists ten keys

MALFORMED = [
    # file
    ("", "wheel", "one of"),
    ("x = [", "", "TOML"),
    ("a = 1\na = 2", "", "TOML"),
    ("[[[[", "", "TOML"),
    ("x = " + "[" * 5000 + "]" * 5000, "", "brackets"),
    ("x = " + "1" * 5000, "", "too long"),
    ("x = 1e" + "9" * 30, "", "too long"),
    ("x = 2024-99-99", "", "TOML"),
    ("#" + "x" * 1_100_000, "", "1 MB"),
    # structure
    (f"{FRICTION}{TWO}[check]\nradus = 1", "check.radus", "equilibrium, radius, lyapunov"),
    (f'colour = "red"\n{FRICTION}{TWO}', "colour", "name, description"),
    (f'"a\\nb\\u0007" = 1\n{FRICTION}{TWO}', r"a\nb\x07", "one of the keys"),
    (f'{FRICTION}{RING}[field]\nkind = "spiral"\nangel = 1', "field.angel", "speed, kind, angle"),
    (f'{FRICTION}{RING}[field]\nkind = "spiral"', "field.angle", "a value"),
    (f'{FRICTION}{RING}[field]\nkind = "vortex"', "field.kind", "spiral, expression, received 'vortex'"),
    (f'{FRICTION}{RING}[field]\nspeed = "unit"', "field.kind", "received nothing"),
    (f"{FRICTION}{RING}[field]\nkind = []", "field.kind", "received []"),
    (f"{FRICTION}{RING}[field]\nkind = 1", "field.kind", "received 1"),
    (f"field = 3\n{FRICTION}{RING}", "field", "table"),
    (f"check = 3\n{FRICTION}{RING}", "check", "table"),
    (f"ring = []\n{FRICTION}", "ring", "table"),
    (f"{FRICTION}[wheel]\nposition = [1, 0]", "wheel", "[[wheel]]"),
    (f"wheel = [1, 2]\n{FRICTION}", "wheel[1]", "table"),
    (f"name = 3\n{FRICTION}{TWO}", "name", "text"),
    (f'name = "a\\nb"\n{FRICTION}{TWO}', "name", "printable"),
    (f'name = "{"x" * 300}"\n{FRICTION}{TWO}', "name", "200 characters"),
    ('[system]\nstates = ["x"]\nrhs = ["-sign(x)"]', "system", "an array of wheels"),
    # how many wheels, and where
    (FRICTION, "wheel", "one of"),
    (f"wheel = []\n{FRICTION}", "wheel", "two wheels"),
    (FRICTION + WHEEL, "wheel", "two wheels"),
    (FRICTION + "[grid]\nrows = 1\ncolumns = 1", "grid", "two to 250000 wheels"),
    (FRICTION + TWO + RING, "wheel and ring", "one of"),
    (FRICTION + RING + "[grid]\nrows = 2\ncolumns = 2", "ring and grid", "one of"),
    (FRICTION + TWO + '[[wheel]]\nposition = ["1/2 + 0.5", 0]', "wheel[3].position", "the place of wheel 1"),
    (FRICTION + "[[wheel]]\nposition = [1]\n" + TWO, "wheel[1].position", "two numbers"),
    (FRICTION + TWO + "[[wheel]]\nposition = 1", "wheel[3].position", "two numbers"),
    (FRICTION + TWO + "[[wheel]]\nspeed = 1", "wheel[3].position", "a value"),
    (FRICTION + "[ring]\ncount = 361", "ring.count", "at most 360"),
    (FRICTION + "[ring]\ncount = 1", "ring.count", "at least 2"),
    (FRICTION + "[ring]\ncount = 3.0", "ring.count", "integer"),
    (FRICTION + '[ring]\ncount = "3"', "ring.count", "integer"),
    (FRICTION + "[ring]\ncount = true", "ring.count", "integer"),
    (FRICTION + "[ring]\ncount = 3\nradius = 0", "ring.radius", "positive"),
    (FRICTION + '[ring]\ncount = 3\nradius = "1 - sqrt(2)"', "ring.radius", "received 1 - sqrt(2)"),
    (FRICTION + '[ring]\ncount = 3\nphase = "1 + pi"', "ring.phase", "multiple of pi"),
    (FRICTION + "[grid]\nrows = 1000\ncolumns = 1000", "grid", "250000"),
    (FRICTION + "[grid]\nrows = 10000000000000000000000\ncolumns = 1", "grid.rows", "at most"),
    (FRICTION + "[grid]\nrows = -2\ncolumns = 2", "grid.rows", "at least 1"),
    (FRICTION + "[grid]\nrows = 2\ncolumns = 2\npitch = -1", "grid.pitch", "positive"),
    (FRICTION + "[grid]\nrows = 3\ncolumns = 3", "field", "wheel 5, position (0, 0) (or a heading such as [1, 0]"),
    # headings and fields
    (FRICTION + WHEEL + "heading = [0, 0]\n" + TWO, "wheel[1].heading", "nonzero"),
    (FRICTION + WHEEL + "heading = [1, 2, 3]\n" + TWO, "wheel[1].heading", "two numbers"),
    (FRICTION + WHEEL + 'heading = "inwards"\n' + TWO, "wheel[1].heading", "inward"),
    (FRICTION + WHEEL + "heading = true\n" + TWO, "wheel[1].heading", '45, "45 deg", "0.8 rad" or "pi/4"'),
    (FRICTION + WHEEL + 'heading = "45 grad"\n' + TWO, "wheel[1].heading", "angle"),
    (FRICTION + WHEEL + 'heading = "pi deg"\n' + TWO, "wheel[1].heading", "angle"),
    (FRICTION + WHEEL + 'heading = "sqrt(2) rad"\n' + TWO, "wheel[1].heading", "angle"),
    (FRICTION + WHEEL + 'heading = "nan deg"\n' + TWO, "wheel[1].heading", "angle"),
    (FRICTION + TWO + '[units]\nangle = "grad"', "units.angle", "'deg' or 'rad', received 'grad'"),
    (FRICTION + TWO + "[units]\nangle = 3", "units.angle", "'deg' or 'rad', received 3"),
    ("units = 3\n" + FRICTION + TWO, "units", "table"),
    (FRICTION + TWO + '[units]\nlength = "ft"', "units.length", "'m', 'cm', 'mm' or 'in', received 'ft'"),
    (FRICTION + TWO + '[units]\nlength = "mm"\nspeed = "m"', "units.speed", "'mm/s' or 'in/s', received 'm'"),
    (FRICTION + TWO + '[units]\nspeed = "m/s"', "units.length", "length beside speed = m/s, received nothing"),
    (FRICTION + TWO + '[units]\ntime = "s"', "units.time", "one of the keys length, speed, angle, received"),
    (FRICTION + "[[wheel]]\nposition = [0, 0]\nheading = 'inward'\n" + WHEEL, "wheel[1].heading", "(0, 0)"),
    (FRICTION + TWO + '[field]\nkind = "squeeze"', "field", "wheel 2, position (0, 2)"),
    (FRICTION + TWO + '[field]\nkind = "elliptic"\na = 0', "field", "wheel 1, position (1, 0)"),
    (FRICTION + TWO + '[field]\nkind = "elliptic"\na = "x"', "field.a", "a formula of numbers"),
    (FRICTION + TWO + '[field]\nkind = "expression"\nx = "1/y"\ny = "x"', "field.x", "finite"),
    (FRICTION + TWO + '[field]\nkind = "expression"\nx = "sqrt(-x)"\ny = "x"', "field.x", "non-negative"),
    (FRICTION + TWO + '[field]\nkind = "radial"\nspeed = "fast"', "field.speed", "unit"),
    # numbers
    (FRICTION + WHEEL + "speed = nan\n" + TWO, "wheel[1].speed", "received NaN"),
    (FRICTION + WHEEL + "speed = -inf\n" + TWO, "wheel[1].speed", "finite"),
    (FRICTION + WHEEL + 'speed = "nan"\n' + TWO, "wheel[1].speed", "a finite number, received 'nan'"),
    (FRICTION + WHEEL + "speed = true\n" + TWO, "wheel[1].speed", "received true"),
    (FRICTION + WHEEL + "speed = []\n" + TWO, "wheel[1].speed", "received []"),
    (FRICTION + WHEEL + "speed = 2024-01-01\n" + TWO, "wheel[1].speed", "received 2024-01-01"),
    (FRICTION + WHEEL + "speed = 1e999\n" + TWO, "wheel[1].speed", "exponent"),
    (FRICTION + WHEEL + f"speed = 0x{'f' * 9000}\n" + TWO, "wheel[1].speed", "36000 bits"),
    (FRICTION + WHEEL + 'speed = ""\n' + TWO, "wheel[1].speed", "number"),
    (FRICTION + WHEEL + 'speed = "1/0"\n' + TWO, "wheel[1].speed", "finite"),
    (FRICTION + WHEEL + 'speed = "2**9999"\n' + TWO, "wheel[1].speed", "exponent"),
    (FRICTION + WHEEL + 'speed = "((9**64)**64)**64"\n' + TWO, "wheel[1].speed", "bits"),
    (FRICTION + WHEEL + 'speed = "(((2*cos(pi/5))**64)**64)**64"\n' + TWO, "wheel[1].speed", "bits"),
    (FRICTION + WHEEL + "speed = \"__import__('os').system('true')\"\n" + TWO, "wheel[1].speed", "formula"),
    (FRICTION + WHEEL + f'speed = "{"(" * 190 + ")" * 190}"\n' + TWO, "wheel[1].speed", "number"),
    (FRICTION + WHEEL + f'speed = "{"1" * 500}"\n' + TWO, "wheel[1].speed", "400 characters"),
    (FRICTION + WHEEL + 'speed = """1\n\u0007+"""\n' + TWO, "", "TOML"),
    (FRICTION + WHEEL + 'speed = "\\u001b[31m\\n1"\n' + TWO, "wheel[1].speed", r"\x1b[31m\n1"),
    ("".join(f'[[wheel]]\nposition = ["sqrt({k})", {k}]\n' for k in range(1, 400)) + FRICTION,
     "wheel[313].position", "square roots"),
    # friction
    (TWO, "friction.mu_roll", "wheel 1"),
    (f"[friction]\nmu_roll = 1\n{TWO}", "friction.mu_side", "wheel 1"),
    (f"{WHEEL}mu_roll = 1\nmu_side = 1\n[[wheel]]\nposition = [0, 2]", "friction.mu_roll", "wheel 2"),
    (f"[friction]\nmu_roll = -1\nmu_side = 1\n{TWO}", "friction.mu_roll", "at least 0"),
    (f"[friction]\nmu_roll = 0\nmu_side = 0.0\n{TWO}", "friction", "above 0"),
    (FRICTION + WHEEL + 'mu_side = "1 - sqrt(2)"\n' + TWO, "wheel[1].mu_side", "at least 0"),
    (FRICTION + TWO + "[[wheel]]\nposition = [5, 5]\nmu_roll = 0\nmu_side = 0", "wheel[3]", "above 0"),
    # contact and check
    (FRICTION + TWO + '[contact]\nrule = "closest"', "contact.rule", "'nearest', 'box', 'ellipse' or 'roller'"),
    (FRICTION + TWO + "[contact]\nrule = 3", "contact.rule", "'nearest', 'box', 'ellipse' or 'roller'"),
    (FRICTION + TWO + '[contact]\nloads = "plastic"', "contact.loads", "elastic"),
    (FRICTION + TWO + "[contact]\nloads = [[1, 0, 0]]", "contact.loads", "2 rows"),
    (FRICTION + TWO + "[contact]\nloads = [[1, 0], [1, 0]]", "contact.loads", "[c0, cx, cy]"),
    (FRICTION + TWO + "[contact]\nloads = [[1, 0, nan], [1, 0, 0]]", "contact.loads", "finite"),
    (FRICTION + TWO + '[contact]\nloads = [[1, 0, "1/0"], [1, 0, 0]]', "contact.loads[1]", "finite"),
    (FRICTION + TWO + "[contact]\nloads = {rows = []}", "contact.loads", "elastic"),
    (FRICTION + TWO + '[contact]\nloads = {kind = "elastic", heigth = 1}', "contact.loads", "height, stiffness"),
    (FRICTION + TWO + '[contact]\nloads = {kind = "elastic", height = -1}', "contact.loads.height", ">= 0"),
    (FRICTION + TWO + '[contact]\nloads = {kind = "elastic", stiffness = 1}', "contact.loads.stiffness", "below 1"),
    (FRICTION + TWO + '[contact]\nloads = {kind = "plastic"}', "contact.loads", '"measured"'),
    (FRICTION + TWO + '[contact]\nloads = {kind = "any", height = 1}', "contact.loads", "none"),
    (FRICTION + TWO + '[contact]\nloads = {kind = "measured"}', "contact.loads", "values"),
    (FRICTION + TWO + '[contact]\nloads = {kind = "measured", values = [1]}', "contact.loads.values", "2 values"),
    (FRICTION + TWO + '[contact]\nloads = {kind = "measured", values = [1, -1]}', "contact.loads.values[2]", ">= 0"),
    (FRICTION + TWO + '[contact]\nloads = {kind = "measured", values = [0, 0]}', "contact.loads.values", "not zero"),
    (FRICTION + TWO + '[contact]\nloads = {kind = "measured", values = [1, 1]}', "contact.loads", "not collinear"),
    (FRICTION + TWO + "[contact]\nloads = []\ntable = []", "contact.table", "either"),
    (FRICTION + TWO + "[check]\nradius = 0", "check.radius", "positive"),
    (FRICTION + TWO + '[check]\nradius = "sqrt(2) - 3/2"', "check.radius", "positive"),
    (FRICTION + TWO + "[check]\nequilibrium = [0, 0, 0]", "check.equilibrium", "two numbers"),
    (FRICTION + TWO + '[check]\nequilibrium = [0, "1/0"]', "check.equilibrium", "finite"),
    (FRICTION + TWO + '[check]\nlyapunov = "x**2 + z**2"', "check.lyapunov", "x, y, numbers"),
    (FRICTION + TWO + "[check]\nlyapunov = []", "check.lyapunov", "formula"),
]  # fmt: skip

MALFORMED_CSV = [
    ("", "w.csv:1", "x and y"),
    ("x,heading\n1,0\n", "w.csv:1", "x and y"),
    ("x,y,headng\n1,0,red\n", "w.csv:1", "mu_side,speed_limit,axis,contact (is heading meant?), received 'headng'"),
    ("# wheels\n\nx,y,speed_rpm\n1,0,3\n", "w.csv:3", "(is speed meant?), received 'speed_rpm'"),
    ("x;y\n0,5;1\n2;2\n", "w.csv:2.x", "a decimal point instead of a comma, received '0,5'"),
    ('x,y\n"0,5",1\n2,2\n', "w.csv:2.x", "a decimal point instead of a comma, received '0,5'"),
    ("x\ty\theading\n1\t2\t0,5\n2\t2\t\n", "w.csv:2.heading", "a decimal point"),
    ("x,y\n0,5,1\n2,2\n", "w.csv:2", "2 cells (decimals with a point, not a comma), received 3"),
    ("x|y\n1|2\n", "w.csv:1", "a header with x and y, received one without x and y"),
    ("X,y,x\n1,0,1\n", "w.csv:1", "once"),
    ("x,y,x\n1,0,1\n", "w.csv:1", "once"),
    ("x,y\n", "wheel", "two wheels"),
    ("x,y\n1,2\n", "wheel", "two wheels"),
    ("x,y\n1,2\n3\n", "w.csv:3", "2 cells"),
    ("x,y\n1,2\n3,4,5\n", "w.csv:3", "2 cells"),
    ("x,y\n1,2\n\n3, \n", "w.csv:4.y", "empty cell"),
    ("x,y,speed\n1,2,+Infinity\n", "w.csv:2.speed", "finite"),
    ("x,y,speed\n1,2,\x1b[1m\n", "w.csv:2.speed", r"\x1b[1m"),
    ("x,y\n1,2\n1.0,2e0\n", "w.csv:3.position", "(1, 2), the place of wheel 1"),
    ("x,y\n1,1e401\n", "w.csv:2.y", "exponent"),
    ("x,y\n1,1/0\n2,2\n", "w.csv:2.y", "finite"),
    ("x,y\n0,0\n2,2\n", "field", "wheel 1, position (0, 0)"),
    ("x,y,heading\n1,1,\"[0, 0]\"\n2,2,\n", "w.csv:2.heading", "nonzero"),
    ("x,y,heading\n1,1,north\n", "w.csv:2.heading", "inward"),
    ("x,y,mu_roll\n1,1,-1\n2,2,\n", "w.csv:2.mu_roll", "at least 0"),
    ("x,y\n1,\x00\n", "w.csv", "required"),
    ('x,y\n1,"2\n', "w.csv:2", "CSV"),
    ("x,y\n1," + "1" * 200_000 + "\n", "w.csv:2", "CSV"),
    ("x,y\n" + "".join(f"{k},1\n" for k in range(250_001)), "w.csv", "250000"),
]  # fmt: skip


def names(cases: list[tuple[str, str, str]]) -> list[str]:
    """Short test names; some cases are a megabyte long."""
    return [f"{number}-{ascii(key or 'file')[1:-1]}" for number, (_, key, _) in enumerate(cases)]


def error_of(path: Path, **overrides: Any) -> SceneError:
    with pytest.raises(SceneError) as caught:
        load_scene(path, **overrides)
    return caught.value


def check_line(error: SceneError, file: str) -> None:
    line = str(error)
    assert line.isprintable(), line
    assert len(line) <= LONGEST_LINE, line
    assert file in line
    assert ": required " in line
    assert ", received " in line


@pytest.mark.parametrize(("text", "key", "words"), MALFORMED, ids=names(MALFORMED))
def test_malformed_scene(tmp_path: Path, text: str, key: str, words: str) -> None:
    (tmp_path / "my.toml").write_text(text, encoding="utf-8")
    error = error_of(tmp_path / "my.toml")
    check_line(error, "my.toml")
    assert f"my.toml: {key}: required" in str(error) if key else "my.toml: required" in str(error)
    assert words in str(error)


@few(1)
@pytest.mark.parametrize(("table", "key", "words"), MALFORMED_CSV, ids=names(MALFORMED_CSV))
def test_malformed_csv(tmp_path: Path, table: str, key: str, words: str) -> None:
    (tmp_path / "my.toml").write_text(FRICTION + CSV, encoding="utf-8")
    (tmp_path / "w.csv").write_text(table, encoding="utf-8")
    error = error_of(tmp_path / "my.toml")
    check_line(error, "my.toml")
    assert f": {key}" in str(error)
    assert words in str(error)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("none.csv", "no such file"),
        (".", "directory"),
        ("", "directory"),
        ("a\\u0000b", "no such file"),
        ("x" * 5000, "readable file"),
        ("binary.csv", "UTF-8"),
    ],
)
def test_missing_csv(tmp_path: Path, name: str, words: str) -> None:
    (tmp_path / "my.toml").write_text(f'{FRICTION}[wheels]\nfile = "{name}"\n', encoding="utf-8")
    (tmp_path / "binary.csv").write_bytes(b"x,y\n\xff\xfe\x00")
    error = error_of(tmp_path / "my.toml")
    check_line(error, "my.toml: wheels.file")
    assert words in str(error)


def test_missing_file_names_the_closest_built_in_scenes() -> None:
    with pytest.raises(SceneError, match=r"^four-weel: required .* such as four-wheel or .* no such file$"):
        load_scene("four-weel")


@pytest.mark.parametrize("source", ["", "\0", "a\nb", "\ud800", "x" * 10_000, "/", "a/b.toml"], ids=range(7))
def test_no_such_file(source: str) -> None:
    with pytest.raises(SceneError) as caught:
        load_scene(source)
    check_line(caught.value, "")


def test_directories_and_devices_are_no_scenes(tmp_path: Path) -> None:
    assert "a directory" in str(error_of(tmp_path))
    assert "no regular file" in str(error_of(Path("/dev/zero")))


@pytest.mark.parametrize("data", [b"\xff\xfe", b"\x80", b"\x89PNG\r\n\x1a\n\x00", bytes(range(256))])
def test_binary_file(tmp_path: Path, data: bytes) -> None:
    (tmp_path / "my.toml").write_bytes(data)
    check_line(error_of(tmp_path / "my.toml"), "my.toml")


@pytest.mark.parametrize(
    ("overrides", "key"),
    [
        ({"rule": "closest"}, "contact.rule"),
        ({"rule": ""}, "contact.rule"),
        ({"radius": "nan"}, "check.radius"),
        ({"radius": "-1"}, "check.radius"),
        ({"radius": "x"}, "check.radius"),
        ({"at": "1"}, "check.equilibrium"),
        ({"at": "1,2,3"}, "check.equilibrium"),
        ({"at": "1,\n"}, "check.equilibrium"),
        ({"at": "[0, 0]"}, "check.equilibrium"),
    ],
)
def test_overrides_are_checked_like_the_file(overrides: dict[str, Any], key: str) -> None:
    with pytest.raises(SceneError) as caught:
        load_scene("four-wheel", **overrides)
    check_line(caught.value, f"four-wheel: {key}: ")


def test_error_carries_its_values(tmp_path: Path) -> None:
    (tmp_path / "my.toml").write_text(f"{FRICTION}{TWO}speed = 'nan'\n", encoding="utf-8")
    error = error_of(tmp_path / "my.toml")
    assert error.file == str(tmp_path / "my.toml")
    assert (error.key, error.value) == ("wheel[2].speed", "nan")
    assert str(error).endswith(f"my.toml: wheel[2].speed: required {error.expected}, received 'nan'")
    copy = pickle.loads(pickle.dumps(error))
    assert str(copy) == str(error)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (StatedFact("no such file"), "no such file"),
        ("a\n'b'", "\"a\\n'b'\""),
        (Decimal("1.50"), "1.50"),
        ([1, "a", [True]], "[1, 'a', [true]]"),
        ([1, 2, 3, 4, 5], "[1, 2, 3, 4, ...]"),
        ({"a": 1}, "a table"),
        (1 << 20_000, "an integer of 20001 bits"),
        (datetime.date(2024, 1, 2), "2024-01-02"),
        ("x" * 100, "'" + "x" * 56 + "..."),
    ],
    ids=range(9),
)
def test_shown(value: object, text: str) -> None:
    assert shown(value) == text
