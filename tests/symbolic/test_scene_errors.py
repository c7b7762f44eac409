"""Whatever is wrong with a scene: one SceneError, one printable line, naming the file and the key."""

from __future__ import annotations

import datetime
import pickle
from decimal import Decimal
from pathlib import Path
from typing import Any

import pytest

from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact, shown
from tests.thorough import few

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
