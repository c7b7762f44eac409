"""A new stepper is one file, and follows whatever the engine follows."""

from __future__ import annotations

import math

import numpy as np
import pytest

from nonsmooth.analysis.fields.sign_field import SignField
from nonsmooth.analysis.fields.switched_field import affine_surface
from nonsmooth.analysis.trajectories.result import EventKind, Trajectory
from nonsmooth.analysis.trajectories.trajectory import follow_smooth
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from tests.rehearsals.midpoint import ImplicitMidpoint

SURFACE = affine_surface("x", (1, 0))


def oscillator(signs: tuple[int, ...]) -> object:
    """``x'' = -x`` to the right of ``x = 0``, ``x'' = -4 x`` to the left: half turns of pi/2 and pi/4, by hand."""
    stiffness = 1.0 if signs[0] > 0 else 4.0
    return lambda t, x: np.array([x[1], -stiffness * x[0]])


def path(step: float, until: float) -> Trajectory:
    field = SignField(("x", "v"), (SURFACE,), oscillator)  # type: ignore[arg-type]
    return follow_smooth(field, (1.0, 0.0), until, stepper=ImplicitMidpoint(step))


def test_it_keeps_the_energy_of_an_oscillator_between_events() -> None:
    first = path(0.1, 10.0).pieces[0]
    energies = [x * x + v * v for x, v in (first.state(time) for time in first.times[:-1])]
    assert energies == pytest.approx([1.0] * len(energies), abs=1e-14)


def test_its_events_come_to_those_of_the_true_path_in_second_order() -> None:
    """The path crosses x = 0 after a quarter turn, and after each half turn on either side."""
    exact = [math.pi / 2, math.pi, 2 * math.pi, 5 * math.pi / 2]
    errors = []
    for step in (2e-2, 1e-2):
        events = [float(e.t) for e in path(step, 8.0).events if e.kind is EventKind.CROSS]
        assert len(events) == len(exact)
        errors.append(np.abs(np.array(events) - exact).max())
    assert errors[1] < 1e-3
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.2)


def test_a_slide_is_followed_by_it_too() -> None:
    """``x' = -sign(x), v' = 1``: on x = 0 from t = 1/2 on."""

    def flow(signs: tuple[int, ...]) -> object:
        return lambda t, x: np.array([-float(signs[0]), 1.0])

    field = SignField(("x", "v"), (SURFACE,), flow)  # type: ignore[arg-type]
    found = follow_smooth(field, (0.5, 0.0), 1.0, stepper=ImplicitMidpoint(0.03))
    assert [event.kind for event in found.events] == [EventKind.SLIDE]
    assert float(found.events[0].t) == pytest.approx(0.5, abs=1e-15)
    end: Floats = np.array(found.end.state)
    assert end == pytest.approx([0.0, 1.0], abs=1e-14)
