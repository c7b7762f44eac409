"""Tables of scene files: wheels as spreadsheets write them, bodies, and regions of plain systems."""

from __future__ import annotations

import codecs
import operator
import re
from fractions import Fraction
from itertools import permutations
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from nonsmooth.analysis.fields.system_field import system_field
from nonsmooth.proofs.kernel_strategies import decide_by_solution
from nonsmooth.proofs.system_decision import checked_point, decide_system
from nonsmooth.proofs.system_facts import rewriting_words
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.files.system_builder import build_system
from nonsmooth.symbolic.files.wheel_csv import parse_wheels
from nonsmooth.symbolic.mechanics.body import Disc, Footprint, PolygonShape
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.numbers.number_field import FirstRemark, angle_notes
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.oracles.floats import value
from tests.thorough import keep

# ---- Tables of wheels as spreadsheets write them: separators, headers, comments, and columns that are not read.

SCENE = '[friction]\nmu_roll = 1\nmu_side = 0.5\n[wheels]\nfile = "w.csv"\n'
UNTOLD = "w.csv states no heading: all wheels drive toward (0, 0); a column heading, or [field], says otherwise"
CELLS = [
    {"x": "0.5", "y": "1", "heading": "pi/2", "speed": "2", "mu_roll": "3", "mu_side": "4"},
    {"x": "-1", "y": "1e-1", "heading": "[3, 4]", "speed": "", "mu_roll": "", "mu_side": ""},
]


def load(folder: Path, table: str | bytes) -> Scene:
    (folder / "my.toml").write_text(SCENE, encoding="utf-8")
    (folder / "w.csv").write_bytes(table.encode() if isinstance(table, str) else table)
    return load_scene(folder / "my.toml")


def table_of(columns: tuple[str, ...], separator: str = ",") -> str:
    quoted = [[f'"{row[c]}"' if separator in row[c] else row[c] for c in columns] for row in CELLS]
    return "\n".join(separator.join(line) for line in [list(columns), *quoted]) + "\n"


def check_wheels(scene: Scene) -> None:
    first, second = scene.wheels
    assert list(first.position) == [Fraction(1, 2), 1]
    assert list(first.direction) == [0, 1]
    assert [first.speed, first.friction.roll, first.friction.side] == [2, 3, 4]
    assert list(second.position) == [-1, Fraction(1, 10)]
    assert list(second.direction) == [3, 4]
    assert [second.speed, second.friction.roll, second.friction.side] == [1, 1, Fraction(1, 2)]


@pytest.mark.parametrize("separator", [",", ";", "\t"])
@pytest.mark.parametrize("columns", list(permutations(CELLS[0]))[::97])
def test_any_order_of_columns_and_any_separator(tmp_path: Path, columns: tuple[str, ...], separator: str) -> None:
    scene = load(tmp_path, table_of(columns, separator))
    check_wheels(scene)
    assert angle_notes(scene.field) == ()


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_marks_ends_of_lines_and_upper_case(tmp_path: Path, end: str) -> None:
    text = table_of(tuple(CELLS[0])).replace("x,y,heading,speed", ' X ,Y,"Heading",SPEED').replace("\n", end)
    check_wheels(load(tmp_path, codecs.BOM_UTF8 + text.encode()))


def test_comments_and_blank_lines_keep_the_numbers_of_lines(tmp_path: Path) -> None:
    head, *rows = table_of(tuple(CELLS[0])).splitlines()
    lines = ['# from "CAD, 5" wheels', "", head, "  # the front", rows[0], "", "#;,", rows[1]]
    check_wheels(load(tmp_path, "\n".join(lines)))
    with pytest.raises(SceneError, match=r"w\.csv:9\.x: required .*, received 'one'$"):
        load(tmp_path, "\n".join([*lines, "one,1,,,,"]))


def test_other_columns_are_not_read_and_a_note_says_so(tmp_path: Path) -> None:
    text = "z;x;Colour;y\n1;0.5;=cmd|' /C calc'!A0;1\n2;-1;;1e-1\n"
    scene = load(tmp_path, text)
    assert [list(wheel.position) for wheel in scene.wheels] == [[Fraction(1, 2), 1], [-1, Fraction(1, 10)]]
    assert angle_notes(scene.field) == (UNTOLD, "columns of the table of wheels that are not read: z, Colour")


@pytest.mark.parametrize("column", ["angle", "Direction", "theta", "orientation", "angle_deg", "Winkel [deg]"])
def test_a_column_that_looks_like_a_heading_is_refused(tmp_path: Path, column: str) -> None:
    with pytest.raises(SceneError, match=r"\(is heading meant\?\)"):
        load(tmp_path, f"x,y,{column}\n1,1,225\n-1,1,-45\n")
    assert angle_notes(load(tmp_path, f"x,y,heading,{column}\n1,1,pi,225\n-1,1,0,-45\n").field) == (
        f"columns of the table of wheels that are not read: {column}",
    )


def test_no_heading_at_all_is_said_above_all_results(tmp_path: Path) -> None:
    (note,) = load(tmp_path, "x,y\n1,1\n-1,1\n").field.remarks
    assert (note, type(note)) == (UNTOLD, FirstRemark)
    assert load(tmp_path, "x,y,heading\n1,1,pi\n-1,1,\n").field.remarks == ()
    (tmp_path / "w.csv").write_text("x,y\n1,1\n-1,1\n", encoding="utf-8")
    (tmp_path / "my.toml").write_text(f'{SCENE}[field]\nkind = "radial"\n', encoding="utf-8")
    assert load_scene(tmp_path / "my.toml").field.remarks == ()


def test_the_note_is_short_and_shows_names_only(tmp_path: Path) -> None:
    names = ["x", "y", "a", "b" * 31, "wheel no. 1", "\x1b[1m", "d", "", ""]
    rows = [["1", "2", *["?"] * 7], ["2", "2", *[""] * 7]]
    scene = load(tmp_path, "\n".join(",".join(row) for row in [names, *rows]))
    expected = "columns of the table of wheels that are not read: a, (no name), wheel no. 1, (no name), 1 more"
    assert angle_notes(scene.field) == (UNTOLD, expected)


def test_a_cell_of_another_column_may_hold_anything() -> None:
    rows = parse_wheels('x,y,remark\n1,2,"two\nlines, and ""quotes"""\n3,4,\n', "w.csv", "my.toml").rows
    assert [[row.x, row.y] for row in rows] == [[Fraction(1), Fraction(2)], [Fraction(3), Fraction(4)]]


@pytest.mark.parametrize("name", ["type", "supplier", "z", "diameter", "index", "colour", "note", "anglet"])
def test_columns_that_are_not_taken_for_misspelt_ones(name: str) -> None:
    assert parse_wheels(f"x,y,{name}\n1,2,\n", "w.csv", "my.toml").ignored == (name,)


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        ("headings", "heading"),
        ("heading_deg", "heading"),
        ("speeds", "speed"),
        ("mu_rol", "mu_roll"),
        ("MuSide", "mu_side"),
    ],
)
def test_misspelt_columns(name: str, meant: str) -> None:
    with pytest.raises(SceneError) as caught:
        parse_wheels(f"x,y,{name}\n1,2,\n", "w.csv", "my.toml")
    known = "x,y,heading,speed,mu_roll,mu_side,speed_limit,axis,contact"
    assert (
        str(caught.value)
        == f"my.toml: w.csv:1: required a header out of {known} (is {meant} meant?), received '{name}'"
    )


def test_more_columns_than_a_table_of_wheels_has() -> None:
    with pytest.raises(SceneError, match=r"^my\.toml: w\.csv:1: required at most 200 columns, received 1000002$"):
        parse_wheels(f"x,y{',a' * 1_000_000}\n", "w.csv", "my.toml")


def test_beside_the_column_itself_a_similar_name_is_no_mistake() -> None:
    assert parse_wheels("x,y,heading,heading_old\n1,2,0,7\n", "w.csv", "my.toml").ignored == ("heading_old",)


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("x;y\n0,5;1\n", "w.csv:2.x: required a decimal point instead of a comma, received '0,5'"),
        ("x\ty\n1\t,5\n", "w.csv:2.y: required a decimal point instead of a comma, received ',5'"),
        ('x,y\n"1,234",0\n', "w.csv:2.x: required a decimal point instead of a comma, received '1,234'"),
        ("x,y\n0,5,1\n", "w.csv:2: required 2 cells (decimals with a point, not a comma), received 3"),
        ("x;y\n0;5;1\n", "w.csv:2: required 2 cells, received 3"),
        ("x,y\n1\n", "w.csv:2: required 2 cells, received 1"),
    ],
)
def test_decimal_commas_are_refused(text: str, line: str) -> None:
    with pytest.raises(SceneError) as caught:
        parse_wheels(text, "w.csv", "my.toml")
    assert str(caught.value) == f"my.toml: {line}"


# ---- ``[body]``: footprints from their centroid, and what is refused -----------------------------

HEAD = '[friction]\nmu_roll = 1\nmu_side = "1/2"\n[ring]\ncount = 4\n[body]\n'


def footprint(folder: Path, text: str) -> Footprint:
    file = folder / "my.toml"
    file.write_text(HEAD + text)
    body = load_scene(file).body
    assert body is not None
    return body.outline


def texts(shape: Footprint) -> list[tuple[str, str]]:
    assert isinstance(shape, PolygonShape)
    return [(str(x), str(y)) for x, y in shape.vertices]


def test_discs_and_rectangles(tmp_path: Path) -> None:
    disc = footprint(tmp_path, 'shape = "disc"\nradius = "sqrt(2)/2"\n')
    assert isinstance(disc, Disc)
    assert str(disc.radius) == "sqrt(2)/2"
    box = footprint(tmp_path, 'shape = "rectangle"\nwidth = "sin(pi/5)"\nheight = 0.5\n')
    assert [y for _, y in texts(box)] == ["-1/4", "-1/4", "1/4", "1/4"]
    assert isinstance(box, PolygonShape)
    assert box.is_centrally_symmetric


@pytest.mark.parametrize("vertices", ["[[0, 0], [3, 0], [0, 3]]", "[[0, 3], [3, 0], [0, 0]]"])
def test_polygons_are_turned_counterclockwise_about_their_centroid(vertices: str, tmp_path: Path) -> None:
    found = footprint(tmp_path, f'shape = "polygon"\nvertices = {vertices}\n')
    assert set(texts(found)) == {("-1", "-1"), ("2", "-1"), ("-1", "2")}
    assert isinstance(found, PolygonShape)
    (a, b), (c, d), (e, f) = found.vertices
    assert ((c - a) * (f - b) - (d - b) * (e - a)).sign() > 0
    assert not found.is_centrally_symmetric


def test_corners_of_half_a_turn_are_allowed(tmp_path: Path) -> None:
    found = footprint(tmp_path, 'shape = "polygon"\nvertices = [[0,0],[1,0],[2,0],[2,2],[1,2],[0,2]]\n')
    assert isinstance(found, PolygonShape)
    assert found.is_centrally_symmetric
    assert len(found.vertices) == 6


MILLIMETRES = '[units]\nlength = "mm"\n'


def heavy(folder: Path, text: str, units: str = MILLIMETRES) -> Scene:
    file = folder / "heavy.toml"
    wheels = '[ring]\ncount = 4\n[friction]\nmu_roll = "1/2"\nmu_side = "1/4"\n[contact]\nrule = "ellipse"\n'
    file.write_text(f"{units}{wheels}{text and '[body]'}\n{text}")
    return load_scene(file)


def test_gravity_is_known_where_a_unit_of_length_is_stated(tmp_path: Path) -> None:
    known = heavy(tmp_path, "").inertia
    assert known is not None
    assert (float(known.gravity), known.squared_radius, known.is_stated) == (9806.65, None, False)
    assert heavy(tmp_path, "", units="").inertia is None
    on_the_moon = heavy(tmp_path, "gravity = 1620").inertia
    assert on_the_moon is not None
    assert float(on_the_moon.gravity) == 1620


def test_mass_cancels_and_inertia_counts_by_its_share(tmp_path: Path) -> None:
    light, heavier = (heavy(tmp_path, f"mass = {mass}\ninertia = {mass * 300}") for mass in (1, 7))
    for scene in (light, heavier):
        assert scene.inertia is not None
        assert scene.inertia.squared_radius == 300
    assert light.body is None
    plain = heavy(tmp_path, "mass = 3").inertia
    assert plain is not None
    assert plain.squared_radius is None


# ---- Region tables: the field inside each against the table that a reader would pick, and verdicts of equal systems.

COMPARISONS = {"<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge}
TABLES: list[list[dict[str, Any]]] = [
    [{"where": ["x > 0"], "rhs": ["y", "-1 - y"]}, {"rhs": ["y", "1 - y"]}],
    [
        {"where": ["x > 0", "y >= x"], "rhs": ["-1", "-2"]},
        {"where": "x**2 + y**2 <= 1", "rhs": ["x - y", "x"]},
        {"where": ["y < 1/2", "x < -y"], "rhs": ["0", "x*y"]},
        {"rhs": ["1", "sgn(y)"]},
    ],
]


def built(tables: list[dict[str, Any]], states: tuple[str, ...] = ("x", "y"), **system: Any) -> SwitchedSystem:
    document = {"system": {"states": list(states), **system}, "region": tables}
    return build_system(document, "t", Path("t.toml"))


def picked(tables: list[dict[str, Any]], named: dict[str, float]) -> list[float]:
    """The right-hand side of the first table whose guards hold."""
    return all_picked(tables, named)[0]


def all_picked(tables: list[dict[str, Any]], named: dict[str, float]) -> list[list[float]]:
    """The right-hand sides of all tables whose guards hold."""

    def holds(guard: str) -> bool:
        left, sign, right = re.split(r"(<=|>=|<|>)", guard)
        return bool(COMPARISONS[sign](value(left, **named), value(right, **named)))

    def guards(table: dict[str, Any]) -> list[str]:
        where = table.get("where", [])
        return [where] if isinstance(where, str) else where

    sides = [table["rhs"] for table in tables if all(map(holds, guards(table)))]
    return [[float(value(text, **named)) for text in side] for side in sides]


@pytest.mark.parametrize("tables", TABLES)
def test_the_first_table_whose_guards_hold_counts(tables: list[dict[str, Any]]) -> None:
    field = system_field(built(tables))
    for x in np.random.default_rng(3).uniform(-2, 2, (200, 2)):
        signs = tuple(1 if surface.value(x) > 0 else -1 for surface in field.surfaces)
        assert field.flow(signs)(0.0, x) == pytest.approx(picked(tables, {"x": x[0], "y": x[1]}))


@pytest.mark.parametrize("tables", TABLES)
def test_tables_that_overlap_all_act(tables: list[dict[str, Any]]) -> None:
    """The last one, without guards, where no other does."""
    fields = [system_field(member) for member in built(tables, overlap=True).members]
    most = 0
    for x in np.random.default_rng(3).uniform(-2, 2, (200, 2)):
        found = set()
        for field in fields:
            signs = tuple(1 if surface.value(x) > 0 else -1 for surface in field.surfaces)
            found.add(tuple(np.round(field.flow(signs)(0.0, x), 9)))
        named = {"x": x[0], "y": x[1]}
        expected = all_picked(tables[:-1], named) or all_picked(tables[-1:], named)
        assert found == {tuple(np.round(own, 9)) for own in expected}
        most = max(most, len(found))
    assert most == min(2, len(tables) - 1)


@pytest.mark.usefixtures("without_reach")
def test_a_verdict_of_overlapping_tables() -> None:
    """Both fields attract, and their mean does not; one of them alone is what the first table that holds says."""
    tables = [
        {"where": ["x > -1/4"], "rhs": ["-x + 4*y", "-y"]},
        {"where": ["x < 1/4"], "rhs": ["-x", "4*x - y"]},
        {"rhs": ["0", "0"]},
    ]
    assert decide_system(built(tables)).verdict == "asymptotically stable"
    found = decide_by_solution(checked_point(built(tables, overlap=True)))
    assert found is not None
    assert found.verdict == "unstable"


SINE = {"states": ["x", "y"], "rhs": ["y", "-k*sin(x) - y"], "parameters": {"k": [1, 2]}}


@pytest.mark.parametrize(
    ("system", "words", "refused"),
    [
        (
            built(TABLES[1], overlap=True),
            "where [[region]] tables overlap any of them acts",
            r"overlap: required false",
        ),
        (
            build_system({"system": SINE}, "t", Path("t")),
            "k takes any value of its interval",
            r"k: required a number",
        ),
    ],
)
def test_it_is_said_why_there_are_several_right_hand_sides(system: SwitchedSystem, words: str, refused: str) -> None:
    assert words in rewriting_words(system)
    with pytest.raises(SceneError, match=refused):
        system_field(system)


RELAY = [{"where": ["x > 0"], "rhs": ["-1", "-y"]}, {"rhs": ["1", "-y"]}]
ROOT = "sqrt(Abs(x))*sgn(x)"
IN_ROOTS = [{"where": ["x > 0"], "rhs": [f"y - 3/2*{ROOT}", "-1"]}, {"rhs": [f"y - 3/2*{ROOT}", "1"]}]
GUARDED_BY_ROOTS = [{"where": [f"y >= -{ROOT}"], "rhs": ["y", "-2"]}, {"rhs": ["y", "2"]}]
BY_SIGNS = [
    (RELAY, ["-sgn(x)", "-y"]),
    (IN_ROOTS, [f"y - 3/2*{ROOT}", "-sgn(x)"]),
    (TABLES[0], ["y", "-sgn(x) - y"]),
    (GUARDED_BY_ROOTS, ["y", f"-2*sgn(y + {ROOT})"]),
]


@pytest.mark.usefixtures("without_reach")
@pytest.mark.parametrize(("tables", "rhs"), keep(2, BY_SIGNS))
def test_tables_and_signs_have_the_same_verdict(tables: list[dict[str, Any]], rhs: list[str]) -> None:
    by_tables = decide_system(built(tables))
    by_signs = decide_system(build_system({"system": {"states": ["x", "y"], "rhs": rhs}}, "t", Path("t.toml")))
    assert (by_tables.verdict, by_tables.reason) == (by_signs.verdict, by_signs.reason)
    assert by_tables.check()


def test_tables_take_parameters_sines_and_one_state() -> None:
    tables = [{"where": ["x < c"], "rhs": ["k"]}, {"rhs": ["-k*sin(x)/(1 + x**2)"]}]
    found = decide_system(built(tables, ("x",), parameters={"k": 2, "c": 0}))
    assert str(found.verdict) == "asymptotically stable"


@pytest.mark.parametrize(
    ("guard", "verdict"), [("Abs(x) - x <= 0", "unstable"), ("Abs(x) - x < 0", "asymptotically stable")]
)
def test_a_guard_that_is_zero_on_a_whole_cell_holds_there_or_not(guard: str, verdict: str) -> None:
    """Where x > 0 the guard is zero: with ``<=`` it holds, and ``x' = x``."""
    tables = [{"where": [guard], "rhs": ["x"]}, {"rhs": ["-x"]}]
    assert str(decide_system(built(tables, ("x",))).verdict) == verdict
