"""Vehicle files, and the effective track multiplier, derived and by a calculation that shares nothing with it."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import pytest
import sympy

from nonsmooth.symbolic.files.documents import builtin_scenes, builtin_systems, builtin_vehicles, read_document
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.files.vehicle_file import build_vehicle, load_vehicle, vehicle_descriptions
from nonsmooth.symbolic.mechanics.vehicles import FORMULA, Vehicle
from nonsmooth.symbolic.messages.scene_error import SceneError

# ---- Vehicle files: what is built, and what is refused in one line -------------------------------

FRICTION = "[friction]\nmu_roll = 1\nmu_side = 1\n"
SIDES = "[vehicle]\ntrack = 0.6\nwheel_base = 0.5\n"


def vehicle(folder: Path, text: str) -> Vehicle:
    file = folder / "v.toml"
    file.write_text(text, encoding="utf-8")
    return load_vehicle(file)


def test_names_of_built_in_vehicles_are_files_of_their_own() -> None:
    folder = Path(__file__).resolve().parents[2] / "symbolic" / "scenes" / "vehicles"
    assert sorted(builtin_vehicles()) == sorted(path.stem for path in folder.glob("*.toml"))
    assert not set(builtin_vehicles()) & {*builtin_scenes(), *builtin_systems()}
    assert tuple(vehicle_descriptions()) == builtin_vehicles()
    assert all(load_vehicle(name).name == name for name in builtin_vehicles())


def test_rows_stand_evenly_and_run_at_the_speed_of_their_side(tmp_path: Path) -> None:
    built = vehicle(tmp_path, f"{SIDES}rows = 3\nleft = 2\nright = 3\n{FRICTION}")
    places = [tuple(map(str, wheel.position)) for wheel in built.scene.wheels]
    assert places == [(x, y) for x in ("1/4", "0", "-1/4") for y in ("3/10", "-3/10")]
    assert [str(wheel.speed) for wheel in built.scene.wheels] == ["2", "3"] * 3
    assert (str(built.left), str(built.right)) == ("2", "3")
    assert built.scene.contact.rule == "ellipse"


def test_wheels_of_their_own_leave_no_side_speeds(tmp_path: Path) -> None:
    text = f"{SIDES}{FRICTION}[[wheel]]\nposition = [0.4, 0.1]\nheading = 30\nspeed = 2\n"
    built = vehicle(tmp_path, text)
    assert len(built.scene.wheels) == 5
    assert (built.left, str(built.right)) == (None, "1")
    assert built.turn is None


def test_a_wheel_between_the_sides_is_of_neither(tmp_path: Path) -> None:
    """It was driven as a right one, without a word."""
    castor = f"{SIDES}left = 1\nright = 2\n{FRICTION}[[wheel]]\nposition = [0.5, 0]\n"
    with pytest.raises(SceneError, match=r"wheel\[1\].speed: required the speed of a wheel at y = 0"):
        vehicle(tmp_path, castor)
    built = vehicle(tmp_path, f"{castor}speed = 2\n")
    assert [str(wheel.speed) for wheel in built.scene.wheels] == ["1", "2"] * 2 + ["2"]
    assert built.turn is None


def test_units_of_speed_are_converted(tmp_path: Path) -> None:
    text = f'[units]\nlength = "m"\nspeed = "cm/s"\n{SIDES}left = 10\nright = 20\n{FRICTION}'
    assert str(vehicle(tmp_path, text).right) == "1/5"


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (
            f"[vehicle]\nwheel_base = 1\n{FRICTION}",
            "vehicle.track: required a track beside wheel_base, received nothing",
        ),
        (f"[vehicle]\n{FRICTION}", "vehicle.wheel_base: required track and wheel_base, or wheels of"),
        (
            f"[vehicle]\ntrack = -1\nwheel_base = 1\n{FRICTION}",
            "vehicle.track: required a positive number, received -1",
        ),
        (f"{SIDES}rows = 1\n{FRICTION}", "vehicle.rows: required"),
        (f"{SIDES}rows = 501\n{FRICTION}", "vehicle.rows: required"),
        (f"{SIDES}speed = 1\n{FRICTION}", "vehicle.speed: required one of"),
        (SIDES, "friction.mu_roll: required a number, since wheel 1 names none"),
        (f"{SIDES}measured = 0\n{FRICTION}", "vehicle.measured: required a positive number"),
        (f"{SIDES}{FRICTION}[grid]\nrows = 2\ncolumns = 2\n", "grid: required one of"),
        (f'{SIDES}{FRICTION}[contact]\nrule = "x"\n', "contact.rule: required"),
        (FRICTION, "vehicle: required a vehicle on its own wheels"),
        ('[system]\nstates = ["x"]\nrhs = ["-x"]\n', "vehicle: required a vehicle on its own wheels"),
        ("vehicle = 3\n", "vehicle: required"),
    ],
)
def test_what_cannot_be_used_is_refused(tmp_path: Path, text: str, line: str) -> None:
    with pytest.raises(SceneError) as caught:
        vehicle(tmp_path, text)
    assert line in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_vehicle_is_no_array() -> None:
    with pytest.raises(SceneError, match="husky-a200: vehicle: required an array of wheels"):
        load_scene("husky-a200")


# ---- The effective track multiplier: derived with SymPy, and by a calculation that shares nothing with the
# derivation.

BASE, TRACK, ROLL, SIDE, SPEED = sympy.symbols("L W mu_R mu_S u", positive=True)
OMEGA = sympy.Symbol("omega")
CLAIMED = 1 + (SIDE / ROLL) ** 2 * (BASE / TRACK) ** 2


def weighted_slips_squared() -> list[sympy.Expr]:
    """``mu_R^2 r_i^2 + mu_S^2 s_i^2`` of four wheels at ``(+-L/2, +-W/2)``, left ones at the speed ``-u``."""
    squares = []
    for ahead in (1, -1):
        for left in (1, -1):
            x, y = ahead * BASE / 2, left * TRACK / 2
            along, across = -OMEGA * y + left * SPEED, OMEGA * x  # v(p) = omega J p, less u_i d_i with u_i = -left u
            squares.append((ROLL * along) ** 2 + (SIDE * across) ** 2)
    return squares


def test_the_derivation_ends_in_the_formula() -> None:
    """All weighted slips are alike, so D is the root of one quadratic, least where that is least."""
    square = sympy.expand(weighted_slips_squared()[0])
    (rate,) = sympy.solve(sympy.diff(square, OMEGA), OMEGA)
    assert sympy.simplify(2 * SPEED / (rate * TRACK) - CLAIMED) == 0
    written = FORMULA.replace("(mu_S/mu_R)", "(mu_S/mu_R)*1").replace("^2 (L", "**2*(L").replace("^2", "**2")
    assert sympy.simplify(sympy.parse_expr(written.replace("*1**2", "**2"), _names()) - CLAIMED) == 0


def _names() -> dict[str, sympy.Symbol]:
    return {"L": BASE, "W": TRACK, "mu_R": ROLL, "mu_S": SIDE}


def test_forces_balance_at_the_formulas_rate_and_nowhere_else() -> None:
    """Newton's own words: at the rate of the formula the moments of the friction ellipses cancel, symbolically."""
    omega = sympy.Symbol("omega", positive=True)
    forces, moment = sympy.zeros(2, 1), sympy.Integer(0)
    for ahead in (1, -1):
        for left in (1, -1):
            x, y = ahead * BASE / 2, left * TRACK / 2
            along, across = -omega * y + left * SPEED, omega * x
            size = sympy.sqrt((ROLL * along) ** 2 + (SIDE * across) ** 2)
            fx, fy = -(ROLL**2) * along / size, -(SIDE**2) * across / size
            forces += sympy.Matrix([fx, fy])
            moment += x * fy - y * fx
    assert sympy.simplify(forces) == sympy.zeros(2, 1)
    rates = sympy.solve(sympy.numer(sympy.together(sympy.simplify(moment))), omega)
    assert [sympy.simplify(2 * SPEED / (TRACK * rate) - CLAIMED) for rate in rates] == [0]


def test_all_weighted_slips_are_alike() -> None:
    first, *others = (sympy.expand(square) for square in weighted_slips_squared())
    assert others == [first] * 3


@pytest.mark.parametrize("name", ["jackal", "warthog"])
def test_the_ratio_is_the_inverse_of_the_formula(name: str) -> None:
    vehicle = load_vehicle(name)
    assert vehicle.track is not None
    assert vehicle.wheel_base is not None
    assert vehicle.measured is not None
    ratio = vehicle.friction_ratio(vehicle.measured)
    assert ratio is not None
    assert 1 + (ratio * vehicle.wheel_base / vehicle.track) ** 2 == vehicle.measured
    assert vehicle.friction_ratio(vehicle.scene.field.rational(Fraction(1, 2))) is None


@pytest.mark.parametrize(
    ("change", "value"), [("centre_of_mass", [0.01, 0]), ("rows", 3)], ids=["centre of mass", "six wheels"]
)
def test_the_formula_is_about_four_equal_wheels(change: str, value: object) -> None:
    data, file, path = read_document("jackal")
    other = build_vehicle({**data, "vehicle": {**data["vehicle"], change: value}}, file, path)
    assert load_vehicle("jackal").has_four_equal_wheels
    assert not other.has_four_equal_wheels
    assert other.friction_ratio(other.scene.field.rational(2)) is None
