"""The field of a rule without cells: rows against the minimizer written from its definition, pictures, refusals."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import minimize

import nonsmooth as ns
from nonsmooth.analysis.fields.contact_model import contact_model
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.analysis.minimizers.sampling import sample_field
from tests.reports.conftest import Invoke
from tests.thorough import few

TIGHT = {"xatol": 1e-10, "fatol": 1e-14, "maxiter": 4000}
SAME = 1e-4  # of velocities: a simplex finds a minimum to the root of its rounding


def array(name: str, rule: str = "ellipse") -> ns.Array:
    loaded = ns.load(name)
    assert isinstance(loaded, ns.Array)
    return loaded.with_(rule=rule)


def dissipation(own: ns.Array, loads: np.ndarray, twist: np.ndarray) -> float:
    """``sum N_i |(mu_R r_i, mu_S s_i)|``, word by word."""
    total = 0.0
    for wheel, load in zip(own.scene.wheels, loads, strict=True):
        p, d = (np.array([float(v) for v in pair]) for pair in (wheel.position, wheel.unit_direction))
        velocity = twist[:2] + twist[2] * np.array([-p[1], p[0]])
        along, across = velocity @ d - float(wheel.speed), velocity @ np.array([-d[1], d[0]])
        total += load * np.hypot(float(wheel.friction.roll) * along, float(wheel.friction.side) * across)
    return float(total)


@pytest.mark.parametrize("name", ["spiral-30", "off-center", "ring-5"])
def test_rows_are_minimizers_of_the_dissipation(name: str) -> None:
    own = array(name)
    field = sample_field(own.scene, 5)
    for k in (1, 7, 13, 22):
        place = field.points[k]
        loads = loads_at(contact_model(own.scene), place[None])[0]
        found = minimize(partial(dissipation, own, loads), np.zeros(3), method="Nelder-Mead", options=TIGHT)
        vx, vy, omega = found.x
        expected = np.array([vx - omega * place[1], vy + omega * place[0], omega])
        assert np.abs(np.append(field.velocities[k], field.rates[k]) - expected).max() <= SAME


def test_the_checked_point_attracts_and_v_falls() -> None:
    field = sample_field(array("spiral-30").scene, 21)
    away = np.hypot(*field.points.T) > 0
    assert (field.upper_derivative[away] < 0).all()
    assert field.rests.sum() == 1


def test_a_carried_body_does_not_approach() -> None:
    """It turns about the point: V* is zero, and not what rounding leaves of it."""
    assert not sample_field(array("conveyor-3").scene, 11).upper_derivative.any()


@few(1)
@pytest.mark.parametrize("rule", ["ellipse", "roller"])
def test_pictures_records_and_views(rule: str, invoke: Invoke) -> None:
    out = " ".join(invoke("partition", "four-wheel", "--rule", rule).out.split())
    assert f"rule {rule} has no cells; its field at 41 x 41 points, sampled" in out
    drawn = f"f.svg: rule {rule} has no cells, so --show cells and rates draw one picture: streamlines over V*, 1681 "
    assert invoke("partition", "four-wheel", "--rule", rule, "--show", "rates", "-o", "f.svg").out.startswith(drawn)
    again = array("four-wheel", rule).field()
    assert again.save("again.svg").read_bytes() == Path("f.svg").read_bytes()
    assert invoke("partition", "four-wheel", "--rule", rule, "--json").record == again.to_dict()
    assert len(repr(again).splitlines()) <= 12
