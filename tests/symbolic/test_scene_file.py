"""Scene files: every key of the format, checked against floats and identities that use none of the reader."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest

import nonsmooth as ns
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.load_model import UnknownLoads
from nonsmooth.symbolic.mechanics.scene import LoadTable, Scene
from nonsmooth.symbolic.mechanics.similar_scenes import moved, scaled
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.numbers.plane import cross, dot
from tests.thorough import keep

FRICTION = '[friction]\nmu_roll = 1\nmu_side = "1/2"\n'
TWO = "[[wheel]]\nposition = [1, 0]\n[[wheel]]\nposition = [0, 2]\n"
FLOAT_ERROR = 1e-14  # a few roundings of numbers of size 1

Load = Callable[..., Scene]


@pytest.fixture
def load(tmp_path: Path) -> Load:
    """Loads a scene from text; further files by name."""

    def load_text(text: str, files: dict[str, str] | None = None, **overrides: Any) -> Scene:
        for name, content in {"my.toml": text, **(files or {})}.items():
            (tmp_path / name).write_text(content, encoding="utf-8")
        return load_scene(tmp_path / "my.toml", **overrides)

    return load_text


def exact(*numbers: Any) -> tuple[Any, ...]:
    """Numbers to compare field elements with, one by one."""
    return numbers


def floats(scene: Scene) -> list[tuple[float, float]]:
    return [(float(w.position[0]), float(w.position[1])) for w in scene.wheels]


def direction_of(load: Load, heading: str, position: str = "[3, 4]") -> tuple[float, float]:
    wheels = f"[[wheel]]\nposition = {position}\nheading = {heading}\n[[wheel]]\nposition = [9, 9]\n"
    x, y = load(FRICTION + wheels).wheels[0].unit_direction
    return float(x), float(y)


# ---- numbers -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("0.1", Fraction(1, 10)),
        ('"0.1"', Fraction(1, 10)),
        ("-1_000.250", Fraction(-4001, 4)),
        ("1e-3", Fraction(1, 1000)),
        ('"1e3"', Fraction(1000)),
        ('" 2/3 "', Fraction(2, 3)),
        ('"(1/2)**3 - 2*(1 - 3)"', Fraction(33, 8)),
        ('"cos(pi/3)"', Fraction(1, 2)),
        ('"sqrt(9/4)"', Fraction(3, 2)),
        ("0x10", Fraction(16)),
        ("123456789012345678901234567890", Fraction(123456789012345678901234567890)),
    ],
)
def test_numbers_are_exact(load: Load, text: str, value: Fraction) -> None:
    scene = load(f"{FRICTION}[[wheel]]\nposition = [{text}, 1]\n[[wheel]]\nposition = [0, 2]\n")
    assert scene.wheels[0].position[0] == value


def test_irrational_numbers_share_one_field(load: Load) -> None:
    scene = load(f'{FRICTION}[[wheel]]\nposition = ["sqrt(2)", "cos(pi/5)"]\n[[wheel]]\nposition = [0, 2]\n')
    x, y = scene.wheels[0].position
    assert x.field is y.field is scene.field
    assert x * x == 2
    assert 4 * y * y - 2 * y == 1  # minimal polynomial of cos 36°


# ---- headings and speeds ---------------------------------------------------------------------


@pytest.mark.parametrize(
    ("heading", "expected"),
    [
        ('"inward"', (-0.6, -0.8)),
        ('"outward"', (0.6, 0.8)),
        ('"pi/3"', (0.5, math.sqrt(3) / 2)),
        ('"-2*pi/5"', (math.cos(-0.4 * math.pi), math.sin(-0.4 * math.pi))),
        ('"0.25*pi + pi/2"', (-math.sqrt(0.5), math.sqrt(0.5))),
        ("0", (1.0, 0.0)),
        ("[5, -12]", (5 / 13, -12 / 13)),
        ('["sqrt(2)", "sqrt(2)"]', (math.sqrt(0.5), math.sqrt(0.5))),
    ],
)
def test_headings(load: Load, heading: str, expected: tuple[float, float]) -> None:
    assert direction_of(load, heading) == pytest.approx(expected, abs=FLOAT_ERROR)


def test_wheel_without_field_points_inward_with_unit_speed(load: Load) -> None:
    wheel = load(FRICTION + TWO).wheels[1]
    assert wheel.unit_direction == exact(0, -1)
    assert wheel.speed == 1


def test_who_decides_the_speed(load: Load) -> None:
    wheels = "\n".join(
        f"[[wheel]]\nposition = [{k}, 1]\n{own}"
        for k, own in enumerate(["", 'heading = "inward"', "speed = 3", 'heading = "inward"\nspeed = -4'])
    )
    scene = load(f'{FRICTION}{wheels}\n[field]\nkind = "elliptic"\na = 2\nb = 5\nspeed = "7/2"\n')
    assert [w.given_speed for w in scene.wheels] == [Fraction(7, 2), 1, 3, -4]
    assert [w.direction for w in scene.wheels] == [exact(0, -5), exact(-1, -1), exact(-4, -5), exact(-3, -1)]


def test_magnitude_is_the_length_of_the_field(load: Load) -> None:
    scene = load(f'{FRICTION}{TWO}[field]\nkind = "elliptic"\na = 2\nb = 5\nspeed = "magnitude"\n')
    assert [w.given_speed for w in scene.wheels] == [None, None]
    assert [w.speed for w in scene.wheels] == [2, 10]


# ---- fields ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("keys", "psi"),
    [
        ('kind = "radial"', lambda x, y: (-x, -y)),
        ('kind = "elliptic"\na = 2\nb = "1/3"', lambda x, y: (-2 * x, -y / 3)),
        ('kind = "saddle"\na = 2\nb = 3', lambda x, y: (-2 * x, 3 * y)),
        ('kind = "saddle"', lambda x, y: (-x, y)),
        ('kind = "squeeze"', lambda x, y: (-math.copysign(1, x), 0)),
        (
            'kind = "spiral"\nangle = "pi/5"',
            lambda x, y: (
                -x * math.cos(math.pi / 5) + y * math.sin(math.pi / 5),
                -x * math.sin(math.pi / 5) - y * math.cos(math.pi / 5),
            ),
        ),
        (
            'kind = "expression"\nx = "-x - y/2 + x*y**2"\ny = "sqrt(x**2 + y**2)"',
            lambda x, y: (-x - y / 2 + x * y**2, math.hypot(x, y)),
        ),
    ],
)
def test_fields(load: Load, keys: str, psi: Callable[[float, float], tuple[float, float]]) -> None:
    scene = load(f"{FRICTION}[grid]\nrows = 2\ncolumns = 4\npitch = 0.5\n[field]\n{keys}\n")
    for wheel, (x, y) in zip(scene.wheels, floats(scene), strict=True):
        direction = float(wheel.direction[0]), float(wheel.direction[1])
        assert direction == pytest.approx(psi(x, y), abs=FLOAT_ERROR)


@pytest.mark.parametrize(("angle", "cosine", "sine"), [("pi/6", "sqrt(3)/2", "1/2"), ("pi/2", "0", "1")])
def test_spiral_turns_inward_counterclockwise(load: Load, angle: str, cosine: str, sine: str) -> None:
    field = f'[field]\nkind = "spiral"\nangle = "{angle}"\n'
    table = f'[contact]\ntable = [["{cosine}", "{sine}", 0], [0, 0, 0]]\n'
    scene = load(FRICTION + TWO + field + table)
    assert isinstance(scene.contact.loads, LoadTable)
    c, s, _ = scene.contact.loads.rows[0]
    for wheel in scene.wheels:
        inward = -wheel.position[0], -wheel.position[1]
        assert dot(inward, wheel.direction) == c * dot(inward, inward)
        assert cross(inward, wheel.direction) == s * dot(inward, inward)


# ---- layouts ---------------------------------------------------------------------------------


@pytest.mark.parametrize("count", [2, 3, 5, 7, 8, 12, 17])
def test_ring_positions(load: Load, count: int) -> None:
    scene = load(f'{FRICTION}[ring]\ncount = {count}\nradius = "3/2"\nphase = "pi/4"\n')
    angles = [math.pi / 4 + 2 * math.pi * k / count for k in range(count)]
    expected = [(1.5 * math.cos(a), 1.5 * math.sin(a)) for a in angles]
    for found, wanted in zip(floats(scene), expected, strict=True):
        assert found == pytest.approx(wanted, abs=FLOAT_ERROR)
    assert all(dot(w.position, w.position) == Fraction(9, 4) for w in scene.wheels)
    assert all(w.length == Fraction(3, 2) for w in scene.wheels)


def test_ring_has_radius_one_and_phase_zero(load: Load) -> None:
    assert load(f"{FRICTION}[ring]\ncount = 4\n").wheels[1].position == exact(0, 1)


def test_grid_is_centred_and_runs_upwards_row_by_row(load: Load) -> None:
    scene = load(f"{FRICTION}[grid]\nrows = 2\ncolumns = 3\npitch = 2\n[field]\nkind = 'radial'\n")
    assert floats(scene) == [(-2, -1), (0, -1), (2, -1), (-2, 1), (0, 1), (2, 1)]
    assert [w.index for w in scene.wheels] == [1, 2, 3, 4, 5, 6]


def test_csv_wheels(load: Load) -> None:
    table = (
        "\ufeffx, y,heading,speed,mu_roll,mu_side\n"
        "1,0.10,,,,\r\n"
        "\n"
        'sqrt(2)/2,"2","[3, 4]",1/2,3,4\n'
        "-1e1,.5,pi/5,,,0\n"
        '"0",-1,outward,2,,\n'
    )
    field = '[field]\nkind = "saddle"\nspeed = "magnitude"\n'
    scene = load(f'{FRICTION}[wheels]\nfile = "wheels.csv"\n{field}', {"wheels.csv": table})
    first, second, third, fourth = scene.wheels
    assert first.position == exact(1, Fraction(1, 10))
    assert first.direction == exact(-1, Fraction(1, 10))
    assert first.given_speed is None
    assert second.position[0] * second.position[0] == Fraction(1, 2)
    assert second.unit_direction == exact(Fraction(3, 5), Fraction(4, 5))
    assert second.speed == Fraction(1, 2)
    assert (second.friction.roll, second.friction.side) == exact(3, 4)
    assert third.position == exact(-10, Fraction(1, 2))
    assert float(third.direction[0]) == pytest.approx(math.cos(math.pi / 5), abs=FLOAT_ERROR)
    assert (third.speed, third.friction.roll, third.friction.side) == exact(1, 1, 0)
    assert (*fourth.direction, fourth.speed) == exact(0, -1, 2)


@pytest.mark.parametrize("count", keep(1, [2_000, 10_000]))
def test_thousands_of_wheels_cost_no_square_roots(load: Load, count: int) -> None:
    """What makes large tables cheap: lengths wait until they are asked for, and friction is shared."""
    table = "x,y,heading\n" + "".join(
        f"{k % 100}.{k:05d},{k // 100}.5,{'inward' if k % 2 else 'pi/3'}\n" for k in range(count)
    )
    scene = load(f'{FRICTION}[wheels]\nfile = "wheels.csv"\n', {"wheels.csv": table})
    assert len(scene.wheels) == count
    assert len(scene.field.radicands) == 1  # sqrt(3) of the heading; no lengths yet
    assert len({id(w.friction) for w in scene.wheels}) == 1


# ---- friction, contact, check ------------------------------------------------------------------


def test_friction_of_the_wheel_comes_first(load: Load) -> None:
    wheels = "[[wheel]]\nposition = [1, 0]\nmu_side = 3\n[[wheel]]\nposition = [0, 2]\nmu_roll = 0\n"
    first, second = load(FRICTION + wheels).wheels
    assert (first.friction.roll, first.friction.side) == exact(1, 3)
    assert (second.friction.roll, second.friction.side) == exact(0, Fraction(1, 2))


def test_friction_may_be_left_out_when_every_wheel_names_its_own(load: Load) -> None:
    own = "mu_roll = 1\nmu_side = 2\n"
    scene = load(f"[[wheel]]\nposition = [1, 0]\n{own}[[wheel]]\nposition = [0, 2]\n{own}")
    assert all((w.friction.roll, w.friction.side) == exact(1, 2) for w in scene.wheels)


def test_defaults(load: Load) -> None:
    scene = load(FRICTION + TWO)
    assert scene.name == "my"
    assert scene.source.endswith("my.toml")
    assert (scene.contact.rule, scene.contact.loads) == ("nearest", None)
    assert scene.check.equilibrium == exact(0, 0)
    assert scene.check.radius == Fraction(1, 2)
    assert scene.check.named_lyapunov is None


def test_check_and_name(load: Load) -> None:
    text = f'name = "Förderer 7"\ndescription = "two wheels"\n{FRICTION}{TWO}'
    check = '[check]\nequilibrium = ["1/3", -0.5]\nradius = "sqrt(2)"\nlyapunov = "x**2 + 2*y**2"\n'
    scene = load(text + check)
    assert scene.name == "Förderer 7"
    assert scene.check.equilibrium == exact(Fraction(1, 3), Fraction(-1, 2))
    assert scene.check.radius**2 == 2
    assert scene.check.lyapunov is not None
    assert scene.check.named_lyapunov == "x**2 + 2*y**2"


def test_a_lyapunov_function_may_switch_and_brings_its_angles(load: Load) -> None:
    text = "Abs(x) + cos(pi/5)*Abs(y - sign(x))"
    scene = load(f'{FRICTION}{TWO}[check]\nlyapunov = "{text}"\n')
    assert scene.check.named_lyapunov == text
    assert float(scene.field.cos_pi(Fraction(1, 5))) == pytest.approx(math.cos(math.pi / 5), abs=FLOAT_ERROR)


@pytest.mark.parametrize(
    "keys", ['loads = [[1, 0, 0], ["1/2", 0, 2]]', "loads = {table = [[1, 0, 0], [0.5, 0, 2]]}",
             "table = [[1, 0, 0], [0.5, 0, 2]]"]
)  # fmt: skip
def test_load_table(load: Load, keys: str) -> None:
    scene = load(f'{FRICTION}{TWO}[contact]\nrule = "box"\n{keys}\n')
    assert scene.contact.rule == "box"
    assert isinstance(scene.contact.loads, LoadTable)
    assert scene.contact.loads.rows == (exact(1, 0, 0), exact(Fraction(1, 2), 0, 2))


def test_elastic_loads(load: Load) -> None:
    scene = load(f'{FRICTION}{TWO}[contact]\nrule = "ellipse"\nloads = "elastic"\n')
    assert (scene.contact.rule, scene.contact.loads) == ("ellipse", None)


THREE = FRICTION + "".join(f"[[wheel]]\nposition = {place}\nheading = 0\n" for place in ("[0, 0]", "[2, 0]", "[0, 2]"))


@pytest.mark.parametrize("loads", ['"any"', '{kind = "any"}'])
def test_any_load(load: Load, loads: str) -> None:
    assert load(f"{FRICTION}{TWO}[contact]\nloads = {loads}\n").contact.loads == UnknownLoads()


def test_scattered_springs(load: Load) -> None:
    scene = load(f'{FRICTION}{TWO}[contact]\nloads = {{kind = "elastic", height = 0.1, stiffness = "1/20"}}\n')
    assert isinstance(scene.contact.loads, UnknownLoads)
    scatter = scene.contact.loads.scatter
    assert scatter is not None
    assert [str(scatter.height), str(scatter.stiffness)] == ["1/10", "1/20"]


@pytest.mark.parametrize("keys", ["", ", height = 0", ", height = 0, stiffness = 0.0"])
def test_springs_without_scatter_are_elastic(load: Load, keys: str) -> None:
    assert load(f'{FRICTION}{TWO}[contact]\nloads = {{kind = "elastic"{keys}}}\n').contact.loads is None


@pytest.mark.parametrize("at", ["", ", at = [0.5, 1]"])
def test_measured_loads_balance_everywhere(load: Load, at: str) -> None:
    """Of three wheels loads are known from the pose alone; here one of 40 N is measured as 2/4 of the weight."""
    scene = load(f'{THREE}[contact]\nrule = "box"\nloads = {{kind = "measured", values = [10, 10, 20]{at}}}\n')
    assert isinstance(scene.contact.loads, LoadTable)
    half = Fraction(1, 2)
    assert scene.contact.loads.rows == (exact(1, -half, -half), exact(0, half, 0), exact(0, 0, half))


def test_overrides_replace_the_file(load: Load) -> None:
    text = f'{FRICTION}{TWO}[check]\nradius = 1\nequilibrium = [1, 1]\nlyapunov = "x**2 + 3*y**2"\n'
    scene = load(text, rule="ellipse", radius="sqrt(3)/2", at="0.25, -cos(pi/5)")
    assert scene.contact.rule == "ellipse"
    assert scene.check.radius**2 == Fraction(3, 4)
    assert scene.check.equilibrium[0] == Fraction(1, 4)
    assert float(scene.check.equilibrium[1]) == pytest.approx(-math.cos(math.pi / 5), abs=FLOAT_ERROR)
    assert scene.check.lyapunov is not None


# ---- ``speed_limit`` of scene files: for all wheels, for one, in a CSV table; in units; and what is refused.

HEAD = '[friction]\nmu_roll = 1\nmu_side = "1/2"\n'
RING = "[ring]\ncount = 3\n"
SLOW = '[field]\nkind = "radial"\nspeed = "1/10"\n'
LIMITED = (
    "[[wheel]]\nposition = [1, 0]\nspeed_limit = 2\n[[wheel]]\nposition = [0, 2]\n[[wheel]]\nposition = [-1, -1]\n"
)


def scene_of(tmp_path: Path, text: str, table: str = "") -> Path:
    (tmp_path / "w.csv").write_text(table, encoding="utf-8")
    file = tmp_path / "s.toml"
    file.write_text(HEAD + text, encoding="utf-8")
    return file


def limits(file: Path) -> list[Fraction | None]:
    found = []
    for wheel in load_scene(file).wheels:
        rational = None if wheel.speed_limit is None else wheel.speed_limit.as_rational()
        found.append(None if rational is None else Fraction(int(rational.p), int(rational.q)))
    return found


def test_there_is_none_unless_stated(tmp_path: Path) -> None:
    file = scene_of(tmp_path, RING)
    assert limits(file) == [None] * 3
    assert load_scene(file).speed_limits == {}


def test_for_all_wheels_and_for_one(tmp_path: Path) -> None:
    assert limits(scene_of(tmp_path, f"{RING}[drive]\nspeed_limit = 1.5\n")) == [Fraction(3, 2)] * 3
    assert limits(scene_of(tmp_path, f"{LIMITED}[drive]\nspeed_limit = 3\n")) == [2, 3, 3]
    assert limits(scene_of(tmp_path, LIMITED)) == [2, None, None]


def test_in_a_table(tmp_path: Path) -> None:
    table = "x,y,speed_limit\n1,0,2\n0,1,\n-1,-1,5/2\n"
    assert limits(scene_of(tmp_path, '[wheels]\nfile = "w.csv"\n', table)) == [2, None, Fraction(5, 2)]


def test_in_the_files_unit_of_speed(tmp_path: Path) -> None:
    units = '[units]\nlength = "mm"\nspeed = "m/s"\n'
    file = scene_of(tmp_path, f"{RING}{SLOW}{units}[drive]\nspeed_limit = 0.25\n")
    assert limits(file) == [250] * 3


def test_from_python_and_in_similar_scenes() -> None:
    array = ns.Array.ring(3, mu_roll=1, mu_side="1/2", speed_limit="3/2")
    one = array.scene.field.one
    assert array.scene.speed_limits == {k: one * Fraction(3, 2) for k in (1, 2, 3)}
    assert scaled(array.scene, Fraction(7)).speed_limits == array.scene.speed_limits
    assert moved(array.scene, Fraction(1), Fraction(2)).recentred().speed_limits == array.scene.speed_limits
    wheels = [ns.Wheel(p, speed_limit=2) for p in ((1, 0), (0, 1))]
    mixed = ns.Array([*wheels, ns.Wheel((-1, -1))], mu_roll=1, mu_side=1).scene.speed_limits
    assert {index: float(limit) for index, limit in mixed.items()} == {1: 2, 2: 2}


def test_a_speed_at_its_limit_is_within_it(tmp_path: Path) -> None:
    assert limits(scene_of(tmp_path, f"{RING}[drive]\nspeed_limit = 1\n")) == [1] * 3
    magnitude = '[field]\nkind = "radial"\nspeed = "magnitude"\n[ring]\ncount = 3\nradius = "sqrt(2)"\n'
    assert load_scene(scene_of(tmp_path, f'{magnitude}[drive]\nspeed_limit = "sqrt(2)"\n')).speed_limits


def test_bad_cells_of_a_table_name_their_line(tmp_path: Path) -> None:
    for cell, message in (("0", "w.csv:3.speed_limit: required a positive number"), ("x", "w.csv:3.speed_limit: requ")):
        table = f"x,y,speed_limit\n1,0,2\n0,1,{cell}\n-1,-1,2\n"
        with pytest.raises(SceneError) as caught:
            load_scene(scene_of(tmp_path, '[wheels]\nfile = "w.csv"\n', table))
        assert message in str(caught.value)


# ---- ``[tolerance]`` of a scene file: what it holds, and bad values in one line that names the key.

FOUR_WHEEL = Path(__file__).parents[2] / "symbolic" / "scenes" / "four-wheel.toml"


def with_table(folder: Path, lines: str) -> Scene:
    file = folder / "scene.toml"
    file.write_text(f"{FOUR_WHEEL.read_text(encoding='utf-8')}\n[tolerance]\n{lines}\n", encoding="utf-8")
    return load_scene(file)


def test_entries_are_exact_and_wheels_keep_their_field(tmp_path: Path) -> None:
    """A tolerance of one degree brings no cosine of one degree into the scene's numbers."""
    scene = with_table(tmp_path, 'position = "1/1000"\nheading = "1 deg"\nspeed = 0.02\nmu_side = "1/5"')
    found = scene.tolerances
    assert found is not None
    entries = (found.position, found.speed, found.mu_roll, found.mu_side, found.centre_of_mass)
    assert [str(entry) for entry in entries] == ["1/1000", "1/50", "0", "1/5", "0"]
    assert found.heading == Fraction(1, 180)
    assert found.names == ("position", "heading", "speed", "mu_side")
    assert scene.field.base_degree == load_scene("four-wheel").field.base_degree
    assert load_scene("four-wheel").tolerances is None


def test_formulas_beside_the_wheels_may_hold_any_angle(tmp_path: Path) -> None:
    """They ended in "required an angle of the field of order 1"."""
    scene = with_table(tmp_path, 'position = "cos(pi/7)/100"\n[feedback]\ndelay = "cos(pi/9)"')
    assert scene.tolerances is not None
    assert scene.loop_errors is not None
    found = float(scene.tolerances.position), float(scene.loop_errors.delay)
    assert found == pytest.approx((math.cos(math.pi / 7) / 100, math.cos(math.pi / 9)))


def test_boxes_grow_and_shrink(tmp_path: Path) -> None:
    scene = with_table(tmp_path, 'position = "1/10"\nheading = "2 deg"')
    assert scene.tolerances is not None
    double = scene.tolerances.times(Fraction(2))
    assert (str(double.position), double.heading) == ("1/5", Fraction(4, 180))
    assert scene.tolerances.without("position").names == ("heading",)
    larger = scaled(scene, Fraction(10)).tolerances
    assert larger is not None
    assert (str(larger.position), larger.heading) == ("1", Fraction(2, 180))
