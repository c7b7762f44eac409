"""Built-in scenes keep what their names promise; random files are a scene or one SceneError."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any, TypeAlias

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import nonsmooth.symbolic.files.scene_file
from nonsmooth.symbolic.files.documents import builtin_descriptions, builtin_scenes
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.contact_set import standing
from nonsmooth.symbolic.mechanics.contact_states import Twist, cross_product, scene_rows, side_row
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.numbers.plane import cross, dot
from tests.four_wheel import CORNERS
from tests.thorough import examples, keep, thorough

# ---- Built-in scenes: what their names promise ---------------------------------------------------

HALF = Fraction(1, 2)


def positions(scene: Scene) -> list[tuple[object, object]]:
    return [wheel.position for wheel in scene.wheels]


def frictions(scene: Scene) -> set[tuple[object, object]]:
    return {(wheel.friction.roll, wheel.friction.side) for wheel in scene.wheels}


def turn_of(scene: Scene) -> set[tuple[int, int]]:
    """Signs of the inward and the counterclockwise part of every rim direction."""
    return {
        (-dot(wheel.position, wheel.direction).sign(), -cross(wheel.position, wheel.direction).sign())
        for wheel in scene.wheels
    }


def test_names_are_those_on_disk() -> None:
    folder = Path(str(nonsmooth.symbolic.files.scene_file.__file__)).parents[1] / "scenes"
    assert sorted(builtin_scenes()) == sorted(path.stem for path in folder.glob("*.toml"))


def test_every_scene_has_a_description() -> None:
    descriptions = builtin_descriptions()
    assert tuple(descriptions) == builtin_scenes()
    assert len(set(descriptions.values())) == len(descriptions)
    assert all(10 < len(text) < 110 and "\n" not in text for text in descriptions.values())


@pytest.mark.parametrize("name", builtin_scenes())
def test_every_scene_loads(name: str) -> None:
    scene = load_scene(name)
    assert (scene.name, scene.source) == (name, name)
    assert scene.contact.rule == "nearest"
    assert scene.check.radius in (HALF, HALF / 2, Fraction(1, 5))
    assert not any(scene.check.equilibrium)
    special = {
        "four-wheel-side": {(HALF, 1)},
        "differential-drive": {(1, HALF), (Fraction(1, 100), Fraction(1, 1000))},
        "omni-3": {(1, 0)},
        "mecanum-4": {(1, 0)},
        "roller-bed": {(HALF, Fraction(1, 10))},
    }
    assert frictions(scene) == special.get(name, {(1, HALF)})
    speeds = {"differential-drive": {1, 2}, "mecanum-4": {3, -3}}
    assert {wheel.speed for wheel in scene.wheels} == speeds.get(name, {1})
    assert {wheel.axis is None for wheel in scene.wheels} == {name not in ("mecanum-4", "roller-bed")}


@pytest.mark.parametrize("name", ["four-wheel", "four-wheel-side"])
def test_four_wheel(name: str) -> None:
    scene = load_scene(name)
    assert positions(scene) == CORNERS  # in the order of the quadrants
    assert turn_of(scene) == {(1, 0)}


@pytest.mark.parametrize("count", [3, 5, 6, 8])
def test_rings(count: int) -> None:
    scene = load_scene(f"ring-{count}")
    assert len(scene.wheels) == count
    assert all(dot(p, p) == 1 for p in (wheel.position for wheel in scene.wheels))
    assert turn_of(scene) == {(1, 0)}
    angles = [math.atan2(float(w.position[1]), float(w.position[0])) % math.tau for w in scene.wheels]
    assert angles == pytest.approx([math.tau * k / count for k in range(count)])


def test_grid() -> None:
    scene = load_scene("grid-4x4")
    steps = [Fraction(k, 2) for k in (-3, -1, 1, 3)]
    assert positions(scene) == [(x, y) for y in steps for x in steps]
    assert turn_of(scene) == {(1, 0)}


def test_rectangle() -> None:
    scene = load_scene("rectangle")
    assert positions(scene) == [(2, 1), (-2, 1), (-2, -1), (2, -1)]
    assert turn_of(scene) == {(1, 0)}


def test_elliptic() -> None:
    scene = load_scene("elliptic")
    assert len(scene.wheels) == 6
    assert all(w.direction == (-w.position[0], -2 * w.position[1]) for w in scene.wheels)


def test_spiral_is_inward_turned_by_30_degrees() -> None:
    scene = load_scene("spiral-30")
    for wheel in scene.wheels:
        inward = -wheel.position[0], -wheel.position[1]
        assert 2 * cross(inward, wheel.unit_direction) == dot(inward, inward).sqrt()  # sin 30° = 1/2
        assert dot(inward, wheel.unit_direction) > 0


def test_conveyor_rims_are_tangential() -> None:
    scene = load_scene("conveyor-3")
    assert len(scene.wheels) == 3
    assert turn_of(scene) == {(0, 1)}
    first, second, _ = (wheel.position for wheel in scene.wheels)
    assert dot(first, second) == -HALF  # cos 120°


def test_outward() -> None:
    assert positions(load_scene("outward")) == CORNERS
    assert turn_of(load_scene("outward")) == {(-1, 0)}


def test_saddle() -> None:
    scene = load_scene("saddle")
    assert positions(scene) == CORNERS
    assert all(w.direction == (-w.position[0], w.position[1]) for w in scene.wheels)


def test_the_differential_drive_is_carried_about_the_middle_of_its_axle() -> None:
    """All four wheels agree with the spin (0, 0, -1), and the axle lines of the drive wheels are one line."""
    scene = load_scene("differential-drive")
    zero, one = scene.field.zero, scene.field.one
    assert all(not row.residual(Twist(zero, zero, -one)) for row in scene_rows(scene))
    first, second = (side_row(wheel).normal for wheel in scene.wheels[:2])
    assert not any(cross_product(first, second))


def test_omniwheels_stand_along_their_ring() -> None:
    assert turn_of(load_scene("omni-3")) == {(0, 1)}


def test_mecanum_wheels_are_driven_by_the_textbook_for_a_turn_of_one_radian_per_second() -> None:
    """Rollers on the ground along the ring, at 45 degrees to the rims: ``u = v_x -+ v_y -+ (l_x + l_y) omega``."""
    scene = load_scene("mecanum-4")
    vx, vy, omega, reach = 0, 0, 1, 2 + 1
    textbook = [vx - vy - reach * omega, vx + vy - reach * omega, vx - vy + reach * omega, vx + vy + reach * omega]
    assert [wheel.speed for wheel in scene.wheels] == textbook
    for wheel in scene.wheels:
        assert 2 * dot(wheel.unit_grip, wheel.unit_direction) ** 2 == 1  # cos 45 degrees, squared
        assert cross(wheel.position, wheel.grip)


def test_a_carton_of_2_6_by_1_6_pitches_lies_on_4_of_36_wheels() -> None:
    scene = load_scene("carton-on-6x6")
    assert len(scene.wheels) == 36
    assert len(standing(scene).wheels) == 4
    assert scene.body is not None
    assert "13/5 x 8/5" in scene.body.words


def test_rollers_of_the_bed_are_parallel_and_run_across_their_axes() -> None:
    for wheel in load_scene("roller-bed").wheels:
        assert [str(x) for x in (*wheel.grip, *wheel.direction)] == ["0", "1", "1", "0"]


def test_origin_of_off_center_lies_inside_one_cell_and_moves() -> None:
    """The two nearest wheels are unique, and their rims meet at the origin without being parallel."""
    wheels = sorted(load_scene("off-center").wheels, key=lambda w: dot(w.position, w.position))
    distances = [dot(w.position, w.position) for w in wheels]
    assert distances[0] < distances[1] < distances[2]
    nearest, second = wheels[:2]
    assert cross(nearest.direction, second.direction)
    assert not cross(nearest.position, nearest.direction)
    assert not cross(second.position, second.direction)
    assert nearest.speed == 1  # so the velocity v of the origin has d . v = 1: it is no equilibrium


def test_a_file_of_that_name_does_not_hide_a_built_in_scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "four-wheel").write_text("nonsense", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    assert load_scene("four-wheel").name == "four-wheel"


def test_overrides_apply_to_built_in_scenes() -> None:
    scene = load_scene("ring-5", rule="box", radius="1/3", at="0,1/4")
    assert scene.contact.rule == "box"
    assert scene.check.radius == Fraction(1, 3)
    assert scene.check.equilibrium[1] == Fraction(1, 4)


def test_numbers_in_built_in_scenes_are_no_floats() -> None:
    folder = Path(str(nonsmooth.symbolic.files.scene_file.__file__)).parents[1] / "scenes"
    for path in folder.glob("*.toml"):
        assert not re.search(r"= *-?\d*\.\d", path.read_text(encoding="utf-8")), path.name


# ---- Random scene files, tables and bytes: a scene or one SceneError on one line, nothing else.

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
