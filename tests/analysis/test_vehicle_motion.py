"""Vehicles on their own wheels: the exact multiplier met by the solver, and oracles that know nothing of either."""

from __future__ import annotations

from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize

from nonsmooth.analysis.bodies.vehicles import VehicleMotion, friction_ratio, turns, vehicle_motion
from nonsmooth.analysis.cells.contact_rule import all_rules, contact_rule
from nonsmooth.analysis.cells.loads import LoadError
from nonsmooth.symbolic.files.documents import builtin_vehicles
from nonsmooth.symbolic.files.vehicle_file import build_vehicle, load_vehicle
from nonsmooth.symbolic.mechanics.vehicles import Vehicle
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from tests.oracles.wheels_in_floats import places_of
from tests.thorough import few, thorough

MEASURED = ("lynx-wh05", "jackal", "husky-a200", "leo-rover", "panther-wh01", "rosbot", "warthog")
SOLVER = 1e-12  # of the multiplier
SEARCH = 1e-6  # of twists, by a search that knows no derivative


def vehicle(side: Any = 1, **keys: Any) -> Vehicle:
    table = {"track": Decimal("0.6"), "wheel_base": Decimal("0.5"), **keys}
    return build_vehicle({"vehicle": table, "friction": {"mu_roll": 1, "mu_side": side}}, "test", Path("test.toml"))


def literal_twist(places: Floats, speeds: Floats, loads: Floats, roll: float, side: float) -> Floats:
    """Least dissipation by a simplex search over (v_x, v_y, omega): wheels head along x."""

    def dissipation(twist: Floats) -> float:
        along = twist[0] - twist[2] * places[:, 1] - speeds
        across = twist[1] + twist[2] * places[:, 0]
        return float((loads * np.sqrt((roll * along) ** 2 + (side * across) ** 2)).sum())

    found = np.zeros(3)
    for _ in range(4):
        options = {"xatol": 1e-12, "fatol": 1e-16, "maxiter": 4000}
        found = minimize(dissipation, found, method="Nelder-Mead", options=options).x
    return np.asarray(found)


@pytest.mark.parametrize("name", MEASURED)
@pytest.mark.parametrize("side", [Decimal("0.3"), 1, Decimal("2.5")])
def test_the_solver_meets_the_formula(name: str, side: Any) -> None:
    known = load_vehicle(name)
    assert known.track is not None
    assert known.wheel_base is not None
    table = {"track": str(known.track), "wheel_base": str(known.wheel_base)}
    motion = vehicle_motion(vehicle(side, **table))
    formula = 1 + (float(side) * float(known.wheel_base / known.track)) ** 2
    assert motion.exact_multiplier is not None
    solved = motion.vehicle.float_multiplier(float(motion.twists[0][2]))
    assert solved == pytest.approx(formula, rel=SOLVER)
    assert solved == pytest.approx(float(motion.exact_multiplier), rel=SOLVER)
    assert motion.gap is not None
    assert motion.gap < SOLVER


def test_seven_vehicles_without_a_fit() -> None:
    errors = []
    for name in MEASURED:
        known = load_vehicle(name)
        motion = vehicle_motion(known)
        assert known.measured is not None
        assert motion.multiplier is not None
        errors.append(100 * (motion.multiplier / float(known.measured) - 1))
    assert np.round(errors, 1).tolist() == [0.3, -0.9, -1.3, -1.9, -6.8, -8.6, 10.8]


@pytest.mark.parametrize("centre", [["0.05", "0.03"], ["-0.1", "0"]])
@pytest.mark.parametrize(("left", "right"), [(-1, 1), ("0.2", "0.9")])
def test_a_literal_search_finds_the_same_twist(centre: list[str], left: Any, right: Any) -> None:
    motion = vehicle_motion(vehicle("0.7", centre_of_mass=centre, left=left, right=right, rows=3))
    assert motion.exact is None
    places = places_of(motion.vehicle.scene)
    moments = np.column_stack([np.ones(6), places]).T
    loads = np.linalg.pinv(moments) @ [1, *map(float, centre)]  # springs of equal stiffness, none lifts off
    assert loads.min() > 0
    speeds = np.where(places[:, 1] > 0, float(left), float(right))
    assert motion.twists[0] == pytest.approx(literal_twist(places, speeds, loads, 1.0, 0.7), abs=SEARCH)


def test_forces_and_moments_balance() -> None:
    motion = vehicle_motion(vehicle("0.7", centre_of_mass=["0.05", "0.03"]))
    places = places_of(motion.vehicle.scene)
    assert motion.forces is not None
    assert motion.slips is not None
    assert np.abs(motion.forces.sum(axis=0)).max() < SOLVER
    assert abs((places[:, 0] * motion.forces[:, 1] - places[:, 1] * motion.forces[:, 0]).sum()) < SOLVER
    assert (motion.forces * motion.slips).sum(axis=1).max() < 0


@pytest.mark.parametrize("centre", [(0.25, 2.0), pytest.param((0.0, 2.0), marks=thorough)])
def test_a_car_that_rolls_does_not_slip(centre: tuple[float, float]) -> None:
    """Ackermann steering: wheels turned about one centre, at speeds in proportion to their distance from it."""
    table = []
    for x, y in ((0.5, 0.3), (0.5, -0.3), (-0.5, 0.3), (-0.5, -0.3)):
        arm = np.array([x, y]) - centre
        heading = [Decimal(str(-arm[1])), Decimal(str(arm[0]))]
        table.append({"position": [Decimal(str(x)), Decimal(str(y))], "heading": heading, "speed": _length(heading)})
    data = {"vehicle": {}, "wheel": table, "friction": {"mu_roll": 1, "mu_side": 1}}
    car = build_vehicle(data, "car", Path("car.toml"))
    for rule in all_rules():
        motion = vehicle_motion(car, rule)
        assert motion.exact is not None
        assert [tuple(map(float, twist)) for twist in motion.exact] == [(centre[1], -centre[0], 1.0)]
        assert motion.icr == pytest.approx(centre)
        assert motion.exact_icr is not None
        assert tuple(map(float, motion.exact_icr)) == centre
    forces = vehicle_motion(car).forces
    assert forces is not None
    assert not forces.any()


def _length(vector: list[Decimal]) -> str:
    return f"sqrt(({vector[0]})**2 + ({vector[1]})**2)"


def test_box_friction_turns_without_an_effective_track() -> None:
    """Its kink holds the roll rows: the multiplier is 1, which every vendor's constant refutes."""
    motion = vehicle_motion(load_vehicle("husky-a200"), contact_rule("box"))
    assert not motion.is_unique
    assert motion.multiplier == 1
    assert motion.icr is None
    assert motion.slips is None


@few(4)
@pytest.mark.parametrize("name", builtin_vehicles())
def test_every_built_in_vehicle_moves_under_every_rule(name: str) -> None:
    for rule in all_rules():
        motion = vehicle_motion(load_vehicle(name), rule)
        assert isinstance(motion, VehicleMotion)
        assert np.isfinite(motion.twists).all()


def test_mecanum_wheels_move_sideways_and_swerve_wheels_spin() -> None:
    sideways = vehicle_motion(load_vehicle("mecanum-base")).twists[0]
    assert sideways == pytest.approx((0, 1, 0), abs=1e-9)
    spin = vehicle_motion(load_vehicle("swerve-base"))
    assert spin.exact is not None
    assert str(spin.exact[0].omega) == "2*sqrt(2)"


def test_a_tread_tends_to_the_integral_of_its_contacts() -> None:
    """Two line contacts of length L: the moments of evenly spread friction, by quadrature over the tread."""
    from scipy.integrate import quad
    from scipy.optimize import brentq

    length, track = 1.2, 0.8

    def moment(omega: float) -> float:
        along = 1 - omega * track / 2

        def density(x: float) -> float:
            across = omega * x
            return float((across * x - along * track / 2) / np.hypot(along, across))

        return float(quad(density, -length / 2, length / 2)[0])

    limit = 2 / (brentq(moment, 0.1, 2.4) * track)
    errors = []
    for rows in (20, 60):
        tread = vehicle(rows=rows, track="0.8", wheel_base="1.2")
        found = vehicle_motion(tread).multiplier
        assert found is not None
        errors.append(abs(found - limit))
    assert errors[1] < 0.03
    assert errors[1] < errors[0] / 2


def test_instant_centres_of_treads_keep_their_place_where_the_load_is_even() -> None:
    found = turns(load_vehicle("husky-a200"))
    centres = [turn.left_centre for turn in found if turn.left_centre is not None]
    assert found[0].multiplier is None
    assert found[-1].curvature is None
    assert np.ptp(centres) < SOLVER
    assert centres[0] == pytest.approx(float(load_vehicle("husky-a200").track or 0) * 1.8510478045613181 / 2)


def test_a_heavy_rear_moves_the_instant_centre_back() -> None:
    centres = [turn.icr for turn in turns(vehicle(centre_of_mass=["-0.1", 0]))]
    assert all(centre[0] < 0 for centre in centres if centre is not None)


@few(1)
@pytest.mark.parametrize("ratio", ["0.8658", "3"])
@pytest.mark.parametrize("keys", [{}, {"centre_of_mass": ["0.05", "0.02"]}, {"rows": 3}])
def test_a_spin_tells_the_friction_ratio(ratio: str, keys: dict[str, Any]) -> None:
    spun = turns(vehicle(ratio, **keys))[-1].multiplier
    assert spun is not None
    assert friction_ratio(vehicle(**keys), spun) == pytest.approx(float(ratio), rel=1e-8)
    assert friction_ratio(vehicle(**keys), 0.5) is None


def test_middle_wheels_that_do_not_slip_hide_the_friction_ratio() -> None:
    """They have no side slip to pay for, and hold the rate of their speeds up to a ratio of about 0.6."""
    motion = vehicle_motion(vehicle("0.4", rows=3))
    assert motion.multiplier == pytest.approx(1, abs=SOLVER)
    assert friction_ratio(vehicle(rows=3), 1.0) is None


def test_an_uneven_load_on_the_sides_stops_the_turn() -> None:
    """Where side friction is large the heavier side drags the lighter one along: there is no effective track."""
    motion = vehicle_motion(vehicle("5", centre_of_mass=["0", "0.02"]))
    assert motion.twists[0] == pytest.approx((-1, 0, 0), abs=1e-9)
    assert motion.multiplier is None
    assert motion.icr is None


@pytest.mark.parametrize("rule", ["box", "ellipse", "roller"])
@pytest.mark.parametrize("x", [2, "1/4"])
def test_a_vehicle_that_tips_is_refused_by_the_key_of_its_own_file(rule: str, x: Any) -> None:
    """Beyond its wheels and over their edge; the keys of an array, such as check.equilibrium, are not in the file."""
    standing = vehicle(centre_of_mass=[x, 0])
    with pytest.raises(LoadError, match=r"^vehicle.centre_of_mass: required a point inside.*the vehicle tips over$"):
        vehicle_motion(standing, contact_rule(rule))
