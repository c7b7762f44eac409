"""Whatever is wrong with a scene, or asks for too much: one SceneError, one printable line."""

from __future__ import annotations

import datetime
import math
import pickle
import re
import time
import tomllib
from decimal import Decimal
from pathlib import Path
from typing import Any

import pytest
from flint import arb, ctx

from nonsmooth.analysis.cells import box, nearest
from nonsmooth.proofs import theorem4
from nonsmooth.reports.cli import app
from nonsmooth.reports.output.console import run
from nonsmooth.symbolic.files.documents import MAX_NESTING, MAX_PARTS, toml_excess
from nonsmooth.symbolic.files.scene_file import load_any, load_scene
from nonsmooth.symbolic.files.scene_values import read_exact, read_start_angle
from nonsmooth.symbolic.formulas.trees import ExpressionError
from nonsmooth.symbolic.mechanics.rule import CONTACT_RULES
from nonsmooth.symbolic.messages.scene_error import RULES, SceneError, StatedFact, is_meant, shown
from nonsmooth.symbolic.numbers import enclosures
from nonsmooth.symbolic.numbers.enclosures import MOST_BITS, rational_below, square_root
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.number_text import real_text
from nonsmooth.symbolic.numbers.work_limit import WorkLimitError, watched, work_limit
from tests.thorough import few

# ---- Whatever is wrong with a scene: one SceneError, one printable line, naming the file and the key.

FRICTION = '[friction]\nmu_roll = 1\nmu_side = "1/2"\n'
WHEEL = "[[wheel]]\nposition = [1, 0]\n"
TWO = WHEEL + "[[wheel]]\nposition = [0, 2]\n"
RING = "[ring]\ncount = 3\n"
CSV = '[wheels]\nfile = "w.csv"\n'
LONGEST_LINE = 500  # characters; the longest message lists ten keys

# Other cases are rows of tests/golden/rows.toml (refused-001.toml to refused-table-26.toml); these are long, no text,
# or asked of the library alone.
MALFORMED = [
    ("x = " + "[" * 5000 + "]" * 5000, "", "brackets"),
    ("x = " + "1" * 5000, "", "too long"),
    ("#" + "x" * 1_100_000, "", "1 MB"),
    ('[system]\nstates = ["x"]\nrhs = ["-sign(x)"]', "system", "an array of wheels"),
    (FRICTION + WHEEL + f"speed = 0x{'f' * 9000}\n" + TWO, "wheel[1].speed", "36000 bits"),
    (FRICTION + WHEEL + f'speed = "{"1" * 500}"\n' + TWO, "wheel[1].speed", "400 characters"),
    ("".join(f'[[wheel]]\nposition = ["sqrt({k})", {k}]\n' for k in range(1, 400)) + FRICTION,
     "wheel[313].position", "square roots"),
    ("field = 0.5\n" + FRICTION + RING, "field", "a table, received 0.5"),
]  # fmt: skip

MALFORMED_CSV = [
    ("x,y\n1,\x00\n", "w.csv", "required"),
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


# ---- Messages that guess what was meant ----------------------------------------------------------


def test_every_other_name_of_a_rule_is_one_of_ours() -> None:
    assert set(RULES.values()) <= set(CONTACT_RULES)
    assert not set(RULES) & set(CONTACT_RULES)


@pytest.mark.parametrize(
    ("given", "known", "meant"),
    [
        ("mu_syde", ["mu_roll", "mu_side"], " (is mu_side meant?)"),
        ("Omni-wheels", list(CONTACT_RULES), " (is roller meant?)"),
        ("omni", ["nearest", "box"], ""),
        ("frog", list(CONTACT_RULES), ""),
        ("weight", ["height", "mass", "width"], " (is mass meant?)"),
        ("weight", ["height", "width"], " (is height meant?)"),
        ("direction", ["heading", "speed"], " (is heading meant?)"),
        (7, list(CONTACT_RULES), ""),
        ("x" * 10**6, ["x"], ""),
    ],
)
def test_what_is_meant(given: object, known: list[str], meant: str) -> None:
    assert is_meant(given, known) == meant


@pytest.mark.parametrize(
    ("text", "hint"),
    [
        ("15 %", '(for 15 % write "15/100")'),
        ("15%", '(for 15 % write "15/100")'),
        ("4 kg", "mass in kg (is 4 meant?)"),
        ("0.5m", "(is 0.5 meant?)"),
        ("0.25 m/s", "(is 0.25 meant?)"),
        ("4 cats", 'a formula such as "sqrt(2)/2"'),
    ],
)
def test_a_number_with_a_unit_is_told_what_to_write(text: str, hint: str) -> None:
    with pytest.raises(ExpressionError, match=re.escape(hint)):
        read_exact(text)


@pytest.mark.parametrize(
    ("text", "value"),
    [("30deg", math.pi / 6), (" -90 deg", -math.pi / 2), ("0.5 rad", 0.5), ("0 deg", 0.0), ("pi/6", math.pi / 6)],
)
def test_angles_may_name_their_unit(text: str, value: float) -> None:
    assert abs(read_start_angle(text) - value) <= math.ulp(value)


# ---- Scenes that come from somebody else: which files they may name, and what they may cost ------

TABLE = "x,y\n1,0\n0,2\n-1,0\n"
SECRET = "password-of-root-3141592653589793"
LIMIT = 2.0  # seconds; the longest of these texts took 100 s before it was bounded


def scene_naming(name: str) -> str:
    return f'[friction]\nmu_roll = 1\nmu_side = "1/2"\n[wheels]\nfile = "{name}"\n'


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A scene's folder with a table in it and another one beside it."""
    (tmp_path / "scenes" / "tables").mkdir(parents=True)
    for place in ("outside.csv", "scenes/inside.csv", "scenes/tables/below.csv"):
        (tmp_path / place).write_text(TABLE, encoding="utf-8")
    return tmp_path / "scenes"


def refusal(folder: Path, name: str) -> str:
    (folder / "my.toml").write_text(scene_naming(name), encoding="utf-8")
    with pytest.raises(SceneError) as caught:
        load_any(folder / "my.toml")
    return str(caught.value)


@pytest.mark.parametrize("name", ["inside.csv", "tables/below.csv", "tables/../inside.csv", "./inside.csv"])
def test_a_table_in_the_folder_of_the_scene_is_read(folder: Path, name: str) -> None:
    (folder / "my.toml").write_text(scene_naming(name), encoding="utf-8")
    assert len(load_scene(folder / "my.toml").wheels) == 3


@pytest.mark.parametrize(
    "name", ["../outside.csv", "tables/../../outside.csv", "/etc/passwd", "../none.csv", "/dev/zero"]
)
def test_a_table_outside_the_folder_is_refused(folder: Path, name: str) -> None:
    line = refusal(folder, name)
    assert "--allow-outside" in line
    assert "a path that leads outside" in line


def test_links_are_resolved(folder: Path) -> None:
    (folder / "link.csv").symlink_to(folder.parent / "outside.csv")
    (folder / "up").symlink_to(folder.parent)
    (folder / "fine.csv").symlink_to(folder / "inside.csv")
    for name in ("link.csv", "up/outside.csv"):
        assert "a path that leads outside" in refusal(folder, name)
    (folder / "my.toml").write_text(scene_naming("fine.csv"), encoding="utf-8")
    assert len(load_scene(folder / "my.toml").wheels) == 3


def test_links_that_lead_to_each_other(folder: Path) -> None:
    (folder / "a.csv").symlink_to(folder / "b.csv")
    (folder / "b.csv").symlink_to(folder / "a.csv")
    assert "required" in refusal(folder, "a.csv")


def test_the_user_may_allow_files_outside(folder: Path) -> None:
    (folder / "my.toml").write_text(scene_naming("../outside.csv"), encoding="utf-8")
    assert len(load_scene(folder / "my.toml", allow_outside=True).wheels) == 3
    loaded = load_any(folder / "my.toml", allow_outside=True)
    assert len(loaded.wheels) == 3  # type: ignore[union-attr]


@pytest.mark.parametrize(
    "text",
    [
        SECRET,
        f"{SECRET}:0:0:root\nmore\n",
        f"a,{SECRET},b\n",
        f"x,{SECRET}\n",
        f"x,heading,{SECRET}=1\n",
        f"y,heading,speed\n{SECRET},1,2\n",
        f'x,y\n"{SECRET}',
    ],
)
def test_a_file_that_is_no_table_is_not_shown(folder: Path, text: str) -> None:
    (folder / "secret").write_text(text, encoding="utf-8")
    assert SECRET not in refusal(folder, "secret")


def test_only_the_offending_cell_is_shown_and_cut(folder: Path) -> None:
    cell = "1" * 30 + "z" * 500
    (folder / "bad.csv").write_text(f"x,y\n1,2\n{cell},{SECRET}\n", encoding="utf-8")
    line = refusal(folder, "bad.csv")
    assert "'111" in line
    assert "z" * 60 not in line
    assert SECRET not in line


# ---- what a TOML text may cost -----------------------------------------------------------

COSTLY = {
    "dotted key": ".".join(["a"] * 200_000) + " = 1\n",
    "quoted parts": ".".join(['"a"'] * 100_000) + " = 1\n",
    "literal parts": ".".join(["'a'"] * 100_000) + " = 1\n",
    "spaces between": " . ".join(["a"] * 100_000) + " = 1\n",
    "header": "[" + ".".join(["a"] * 200_000) + "]\n",
    "inline table": "a = {" + ".".join(["a"] * 200_000) + " = 1}\n",
    "after a string": 'name = """x\n"""\n' + ".".join(["b"] * 200_000) + " = 1\n",
    "many long keys": "".join(f"b{k}." + ".".join(["a"] * 1000) + " = 1\n" for k in range(400)),
}


@pytest.mark.parametrize("case", COSTLY)
def test_dotted_keys_are_refused_at_once(tmp_path: Path, case: str) -> None:
    (tmp_path / "my.toml").write_text(COSTLY[case], encoding="utf-8")
    start = time.process_time()
    with pytest.raises(SceneError, match=f"keys of at most {MAX_PARTS} parts, received one of "):
        load_any(tmp_path / "my.toml")
    assert time.process_time() - start < LIMIT


LONG = [
    '"' * 900_000,
    "'" * 900_000,
    '"""' + '\\"""' * 200_000,
    '"\\' * 400_000,
    "#." * 400_000,
    "." * 16 + "a" * 900_000,
    "=[" * 400_000,
    "{" * 900_000,
    "'''" + "''" * 400_000,
    'a = "' + "." * 900_000,
    "\n" * 900_000,
]


@few(4)
@pytest.mark.parametrize("text", LONG, ids=range(len(LONG)))
def test_the_bounds_are_tested_in_linear_time(text: str) -> None:
    start = time.process_time()
    toml_excess(text)
    assert time.process_time() - start < LIMIT


DOTS = "." * 1000
WITHIN = [
    f'a = "{DOTS}"',
    f"a = '{DOTS}'",
    f'a = """\n{DOTS}\n"""',
    f"a = '''{DOTS}'''",
    f"# {DOTS}\na = 1",
    f'a = "x" # {DOTS}',
    f'a = "\\"{DOTS}"',
    f'a = """"{DOTS}"""" # four quotes: one belongs to the text',
    f"a = ''''{DOTS}''''",
    f'a = """\\"""{DOTS}"""',
    f'"{DOTS}" = 1',
    f'a = ["{DOTS}", "[[[[", \'{{{{\']',
    "a = [" + "1.5, " * 5000 + "]",
    "a.b.c = {d.e = 1.5}\n[x.y]\nz = 2024-01-02T03:04:05.678",
    ".".join(["a"] * MAX_PARTS) + " = 1",
    "a = " + "[" * MAX_NESTING + "]" * MAX_NESTING,
    "".join(f"[[a]]\nb = [{k}]\n" for k in range(5000)),
]


@pytest.mark.parametrize("text", WITHIN, ids=range(len(WITHIN)))
def test_strings_comments_and_numbers_are_no_keys(text: str) -> None:
    tomllib.loads(text)
    assert toml_excess(text) is None


@pytest.mark.parametrize(
    "text",
    [
        ".".join(["a"] * (MAX_PARTS + 1)) + " = 1",
        "a = " + "[" * (MAX_NESTING + 1) + "]" * (MAX_NESTING + 1),
        "a = '''b''''\n" + ".".join(["b"] * (MAX_PARTS + 1)) + " = 1",
        'a = "#"\n' + ".".join(["b"] * (MAX_PARTS + 1)) + " = 1",
        'a = "\\\\"\n' + ".".join(["b"] * (MAX_PARTS + 1)) + " = 1",
    ],
    ids=range(5),
)
def test_one_more_is_too_much(text: str) -> None:
    tomllib.loads(text)
    assert toml_excess(text) is not None


# ---- The limit on exact arithmetic: it counts, it ends, it nests, and what it ends is refused in one line.

FEW = 100


def test_products_are_counted_and_the_limit_ends_them() -> None:
    field = NumberField()
    three = field(3)
    with pytest.raises(WorkLimitError), work_limit(field, FEW):
        three ** (1 << FEW)
    assert field.meter is None
    assert three * three == 9


def test_what_is_spent_inside_counts_outside() -> None:
    field = NumberField()

    def spend() -> None:
        with work_limit(field, FEW):
            field(3) * field(5)

    with work_limit(field, FEW):
        for _ in range(FEW):
            spend()
        with pytest.raises(WorkLimitError):
            spend()


def test_long_products_count_more() -> None:
    field = NumberField()
    long = field(3) ** 10_000
    with pytest.raises(WorkLimitError), work_limit(field, 10):
        long * long


@pytest.mark.parametrize(("rule", "module"), [("nearest", nearest), ("box", box)])
def test_cells_beyond_the_limit_are_refused_in_one_line(
    rule: str, module: object, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(module, "PARTITION_UNITS", FEW)
    for command in (["check", "off-center", "--rule", rule], ["partition", "off-center", "--rule", rule]):
        assert run(app, command) == 2
        printed = capsys.readouterr()
        assert not printed.out
        assert printed.err.startswith("nonsmooth: off-center: wheels: required an array with cells of rule")
        assert printed.err.count("\n") == 1


def test_a_check_beyond_the_limit_is_refused(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(theorem4, "CHECK_UNITS", FEW)
    assert run(app, ["check", "ring-5", "--rule", "ellipse"]) == 2
    assert "all clauses within" in capsys.readouterr().err


def test_the_search_for_other_equilibria_is_left_out_where_it_is_too_much(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(theorem4, "SEARCH_UNITS", FEW)
    result = theorem4.check_theorem4(load_scene("rectangle"))
    assert result.other_equilibria is None
    assert "search for other equilibria" in {skipped.what for skipped in result.skipped}
    assert result.check()
    assert result.verdict is theorem4.check_theorem4(load_scene("rectangle")).verdict


def test_a_number_of_very_many_digits_is_written_as_an_enclosure() -> None:
    """Python refuses to write integers of more than 4,300 digits: such an area ended in a traceback."""
    field = NumberField()
    number = field(3) ** 20_000 / field(7) ** 10_000
    assert number.size_bits > MOST_BITS
    assert real_text(number).startswith("[")
    assert real_text(field(2) / 3) == "2/3"


def test_the_root_of_a_long_number_is_a_ball_around_it() -> None:
    field = NumberField()
    root = square_root((field(3) ** 20_000 + 1) / field(7) ** 10_000)
    assert not field.radicands
    assert not hasattr(root, "field")
    low = rational_below(root)
    assert low > 0
    assert field(low) ** 2 < (field(3) ** 20_000 + 1) / field(7) ** 10_000
    assert square_root(field(8)) == 2 * field.sqrt(2)


def test_the_root_in_a_field_of_very_many_roots_is_a_ball_around_it(monkeypatch: pytest.MonkeyPatch) -> None:
    field = NumberField()
    number = 3 + 2 * field.sqrt(2)
    assert square_root(number) == 1 + field.sqrt(2)
    monkeypatch.setattr(enclosures, "MOST_ROOTS", 0)
    found = square_root(number)
    assert isinstance(found, arb)
    with ctx.workprec(512):
        assert found.contains((1 + field.sqrt(2)).ball())


def test_the_command_line_says_once_which_angles_are_measured(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "my.toml"
    field = '[field]\nkind = "spiral"\nangle = "pi/180"\n'
    path.write_text(f"[friction]\nmu_roll = 1\nmu_side = 0.5\n[ring]\ncount = 4\n{field}", encoding="utf-8")
    run(app, ["check", str(path), "--rule", "all", "--radius", "0.25"])
    words = " ".join(capsys.readouterr().out.split())
    assert words.count("angles taken as measured: 1/180*pi") == 1


def test_a_limit_of_few_units_ends_also_where_somebody_looks_on() -> None:
    """The meter that looks up now and then compares once for both: a limit below its step must not slip through."""
    field, looks = NumberField(), list[None]()
    three = field(3)
    with watched(field, lambda: looks.append(None)), work_limit(field, 5):
        for _ in range(5):
            _ = three * three
        with pytest.raises(WorkLimitError):
            _ = three * three
    assert not looks
    with watched(field, lambda: looks.append(None)):
        for _ in range(1000):
            _ = three * three
    assert len(looks) == 4
