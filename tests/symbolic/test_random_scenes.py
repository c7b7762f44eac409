"""Random scene files, tables and bytes: a scene or one SceneError on one line, nothing else."""

from __future__ import annotations

import math
from collections.abc import Mapping
from decimal import Decimal
from pathlib import Path
from typing import Any, TypeAlias

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.scene_error import SceneError
from tests.thorough import examples, keep, thorough

Strategy: TypeAlias = st.SearchStrategy[Any]

LONGEST_LINE = 500  # characters

TEXTS = st.one_of(
    st.text(max_size=12),
    st.sampled_from(["inward", "outward", "pi/3", "-pi/5", "nan", "inf", "1/2", "sqrt(2)", "cos(pi/5)"]),
    st.sampled_from(["1/0", "sqrt(-1)", "x", "-x", "y/2", "x*y", "2**64", "9**-9", "((", "a\nb", "\x1b"]),
    st.sampled_from(["unit", "magnitude", "radial", "spiral", "nearest", "box", "elastic", "w.csv"]),
)
NUMBERS = st.one_of(
    st.integers(-3, 6),
    st.integers(-(10**30), 10**30),
    st.sampled_from([Decimal(t) for t in ("nan", "-inf", "1e400", "-1e-401", "0.5", "1.25", "1e-9")]),
)
VALUES = st.recursive(
    st.one_of(NUMBERS, NUMBERS, TEXTS, st.booleans()),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(TEXTS, inner, max_size=2),
    max_leaves=6,
)


def table(required: Mapping[str, Strategy], optional: Mapping[str, Strategy]) -> Strategy:
    """A sensible table; a third of them have a key too many or a value of any kind."""
    keys = st.sampled_from([*required, *optional]) | TEXTS
    spoilt = st.dictionaries(keys, VALUES, max_size=1)
    good = st.fixed_dictionaries(dict(required), optional=dict(optional))
    return st.builds(lambda a, b: {**a, **b}, good, st.just({}) | st.just({}) | spoilt)


COMPONENTS = st.integers(-3, 3) | st.sampled_from(["1/2", "sqrt(2)", "cos(pi/5)"])
PAIRS = st.lists(COMPONENTS, min_size=2, max_size=2)
HEADINGS = st.sampled_from(["inward", "outward", "pi/3", 0]) | PAIRS
COEFFICIENTS = st.sampled_from([0, 1, 2, "1/2", "sqrt(2)", Decimal("0.1"), -1])
WHEELS = table(
    {"position": PAIRS},
    {"heading": HEADINGS, "speed": COEFFICIENTS, "mu_roll": COEFFICIENTS, "mu_side": COEFFICIENTS},
)
SPEEDS = st.sampled_from(["unit", "magnitude", 3])
FIELDS = st.one_of(
    table({"kind": st.sampled_from(["radial", "squeeze"])}, {"speed": SPEEDS}),
    table({"kind": st.sampled_from(["elliptic", "saddle"])}, {"a": COEFFICIENTS, "b": COEFFICIENTS}),
    table({"kind": st.just("spiral"), "angle": st.sampled_from(["pi/6", "pi/7", 0])}, {}),
    table({"kind": st.just("expression"), "x": TEXTS, "y": st.sampled_from(["x", "-y", "1"])}, {}),
)
RINGS = table({"count": st.integers(0, 9)}, {"radius": COEFFICIENTS, "phase": HEADINGS})
GRIDS = table({"rows": st.integers(0, 4), "columns": st.integers(0, 4)}, {"pitch": COEFFICIENTS})
LAYOUTS: Strategy = st.one_of(
    st.fixed_dictionaries({"wheel": st.lists(WHEELS, max_size=4)}),
    st.fixed_dictionaries({"ring": RINGS}),
    st.fixed_dictionaries({"grid": GRIDS}),
    st.just({"wheels": {"file": "w.csv"}}),
    st.just({}),
)
REST = table(
    {"friction": table({"mu_roll": COEFFICIENTS, "mu_side": COEFFICIENTS}, {})},
    {
        "name": TEXTS,
        "field": FIELDS,
        "contact": table({}, {"rule": st.sampled_from(["nearest", "box"]), "loads": st.just("elastic")}),
        "check": table({}, {"equilibrium": PAIRS, "radius": COEFFICIENTS, "lyapunov": TEXTS}),
    },
)
DOCUMENTS = st.builds(lambda layout, rest: {**rest, **layout}, LAYOUTS, REST)
OVERRIDES = st.fixed_dictionaries({}, optional={"rule": TEXTS, "radius": TEXTS, "at": TEXTS})
CELLS = st.text(max_size=5) | st.sampled_from(
    ["", "1", "-2.5", "pi/3", "inward", "sqrt(2)", "nan", "1e999", '"[1, 2]"']
)
PLACES = {"1": 1, "-2.5": -2.5, "cos(pi/5)": math.cos(math.pi / 5), "sqrt(2)": math.sqrt(2), "3/7": 3 / 7, "0": 0}
HEADERS = st.text(max_size=9) | st.sampled_from(["x,y", "x,y,heading,speed", "y,x,mu_side,mu_roll"])


def toml(value: object) -> str:
    """A value in TOML's inline notation."""
    match value:
        case bool():
            return str(value).lower()
        case str():
            return f'"{"".join(f"{chr(92)}U{ord(c):08X}" for c in value)}"'
        case list():
            return f"[{', '.join(toml(item) for item in value)}]"
        case dict():
            return f"{{{', '.join(f'{toml(key)} = {toml(item)}' for key, item in value.items())}}}"
        case Decimal() if value.is_finite():
            return f"{value:e}"
    return str(value).lower().replace("infinity", "inf")


def toml_document(document: Mapping[str, object]) -> str:
    return "\n".join(f"{toml(key)} = {toml(value)}" for key, value in document.items())


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("random")


def outcome(path: Path, **overrides: Any) -> Scene | SceneError:
    try:
        return load_scene(path, **overrides)
    except SceneError as error:
        line = str(error)
        assert line.isprintable(), line
        assert len(line) <= LONGEST_LINE, line
        assert line.startswith(str(path)), line
        return error


@examples(600)
@given(document=DOCUMENTS, overrides=OVERRIDES | st.just({}))
def test_random_documents(folder: Path, document: dict[str, object], overrides: dict[str, str]) -> None:
    (folder / "random.toml").write_text(toml_document(document), encoding="utf-8")
    (folder / "w.csv").write_text("x,y,heading\n1,2,\n3,4,pi/3\n", encoding="utf-8")
    scene = outcome(folder / "random.toml", **overrides)
    if isinstance(scene, Scene):
        assert len(scene.wheels) >= 2
        assert len({wheel.position for wheel in scene.wheels}) == len(scene.wheels)
        assert all(wheel.direction[0] or wheel.direction[1] for wheel in scene.wheels)
        assert all(wheel.friction.roll >= 0 and wheel.friction.side >= 0 for wheel in scene.wheels)
        assert scene.check.radius > 0
    else:
        assert "a TOML document" not in scene.expected  # the test wrote valid TOML


@thorough  # about all random cases, which `make bench` runs
def test_random_documents_reach_both_outcomes_and_many_keys(folder: Path) -> None:
    scenes: list[Scene] = []
    keys: set[str] = set()

    @settings(max_examples=300)
    @given(document=DOCUMENTS)
    def sample(document: dict[str, object]) -> None:
        (folder / "sample.toml").write_text(toml_document(document), encoding="utf-8")
        found = outcome(folder / "sample.toml")
        if isinstance(found, Scene):
            scenes.append(found)
        else:
            keys.add(found.key.split("[")[0].split(".")[0])

    sample()
    assert len(scenes) > 20
    assert {"wheel", "ring", "grid", "friction", "field", "contact", "check"} <= keys


@examples(300)
@given(data=st.binary(max_size=200) | st.text(max_size=200).map(str.encode))
def test_random_bytes(folder: Path, data: bytes) -> None:
    (folder / "bytes.toml").write_bytes(data)
    assert isinstance(outcome(folder / "bytes.toml"), SceneError)


ROWS = st.lists(st.lists(CELLS, min_size=2, max_size=4).map(",".join), max_size=4)
GOOD_CELLS = st.sampled_from(sorted(PLACES))
GOOD_ROWS = st.lists(st.lists(GOOD_CELLS, min_size=2, max_size=2).map(",".join), min_size=2, max_size=4)


@pytest.mark.parametrize("count", keep(1, [50, 400]))
def test_random_wheel_tables(folder: Path, count: int) -> None:
    """A table that is read has one wheel per row, where the row says, with the friction of the scene."""
    scenes = refused = 0

    @settings(max_examples=count)
    @given(table=st.tuples(HEADERS, ROWS) | st.tuples(st.sampled_from(["x,y", "y,x"]), GOOD_ROWS))
    def sample(table: tuple[str, list[str]]) -> None:
        nonlocal scenes, refused
        header, rows = table
        text = '[friction]\nmu_roll = 1\nmu_side = 1\n[wheels]\nfile = "table.csv"\n'
        (folder / "table.toml").write_text(text, encoding="utf-8")
        (folder / "table.csv").write_text("\n".join([header, *rows]), encoding="utf-8")
        found = outcome(folder / "table.toml")
        if isinstance(found, SceneError):
            refused += 1
            return
        scenes += 1
        filled = [list(map(PLACES.get, row.split(","))) for row in rows if row.strip()]
        places = [(float(wheel.position[0]), float(wheel.position[1])) for wheel in found.wheels]
        turn = -1 if header.startswith("y,x") else 1
        assert places == [pytest.approx(row[:2][::turn], rel=1e-15) for row in filled]

    sample()
    assert min(scenes, refused) > count / 8
