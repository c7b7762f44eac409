"""Scenes that come from somebody else: which files they may name, and what they may cost."""

from __future__ import annotations

import time
import tomllib
from pathlib import Path

import pytest

from nonsmooth.symbolic.files.documents import MAX_NESTING, MAX_PARTS, toml_excess
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.files.system_file import load_any
from nonsmooth.symbolic.messages.scene_error import SceneError
from tests.thorough import few

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
