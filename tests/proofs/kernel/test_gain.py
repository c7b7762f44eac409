"""Gains in certificates: what an additive disturbance adds to the derivative of V, along disturbed polygons."""

from __future__ import annotations

import json
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from nonsmooth.proofs.checker.cells import read_system
from nonsmooth.proofs.checker.descriptions import describe
from nonsmooth.proofs.kernel.search import NotShownError, Search
from nonsmooth.proofs.system_certificates import certificate_of
from tests.oracles.mutants import Record
from tests.plain import refused
from tests.proofs.test_disturbance_gain import SYSTEMS, checked, value
from tests.thorough import keep


def gain_of(record: Record) -> Any:
    (own,) = (claim["gain"] for claim in record["statement"]["claims"] if "gain" in claim)
    return own


@pytest.mark.parametrize(("rhs", "function"), keep(2, SYSTEMS[3:] + SYSTEMS[:3]))
def test_the_gain_that_is_printed_is_stated_and_no_smaller_one(rhs: tuple[str, str], function: str) -> None:
    result = checked(rhs, function)
    assert result.reach.gain is not None
    record = certificate_of(result)
    own = gain_of(record)
    assert (own["gamma"], own["kappa"]) == (str(result.reach.gain.gamma), str(result.reach.gain.rate.kappa))
    assert any(f"+ {own['gamma']} |d|" in line for line in describe(record["statement"]))
    smaller = json.loads(json.dumps(record))
    hypotheses = next(entry["hypotheses"] for entry in smaller["evidence"] if "gain" in entry["hypotheses"])
    hypotheses["gain"] = gain_of(smaller)["gamma"] = str(result.reach.gain.gamma * Fraction(3, 4))
    assert "gradient" in refused(smaller)


@pytest.mark.parametrize(("rhs", "function"), [SYSTEMS[4], SYSTEMS[7]])
def test_no_disturbance_adds_more(rhs: tuple[str, str], function: str) -> None:
    """``V' <= -kappa + gamma |d|`` along ``f + d`` beside ``x = 0``, and along the mixture that stays on it.

    With a third of gamma it would be false.
    """
    own = gain_of(certificate_of(checked(rhs, function)))
    kappa, gamma = float(Fraction(own["kappa"])), float(Fraction(own["gamma"]))
    assert own["kind"] == "finite"
    rng = np.random.default_rng(5)
    d = rng.normal(size=(2, 4000)) * rng.uniform(0, 8, 4000)
    y = rng.uniform(0.01, 0.5, 4000) * rng.choice([-1, 1], 4000)
    right, left = (np.array([value(text, side * 1e-9, y) + np.zeros(4000) for text in rhs]) + d for side in (1, -1))
    share = right[0] / (right[0] - left[0])
    stays = (share > 0) & (share < 1)
    sliding = right + share * (left - right)
    risen = [
        _derivative(function, np.full(4000, 1e-6), y, right),
        _derivative(function, np.full(4000, -1e-6), y, left),
        np.where(stays, _derivative(function, np.zeros(4000), y, sliding), -np.inf),
    ]
    sizes = np.hypot(*d)
    assert stays.sum() > 400
    assert max((rise + kappa - gamma * sizes).max() for rise in risen) < 1e-4
    assert max((rise + kappa - gamma / 3 * sizes).max() for rise in risen) > 0.1


def _derivative(function: str, x: Any, y: Any, velocity: Any, h: float = 1e-9) -> Any:
    """Of V in floats, in the direction of a velocity."""
    return (value(function, x + h * velocity[0], y + h * velocity[1]) - value(function, x, y)) / h


def test_surfaces_that_meet_off_the_point_have_no_gain() -> None:
    """At (1/8, 0) V bends on two surfaces: a disturbance may hold solutions there, and nothing is said of them."""
    system = read_system({"states": ["x", "y"], "rhs": [["-sgn(x)", "-sgn(y)"]], "at": ["0", "0"]})
    for function, more in (("Abs(x) + Abs(y)", []), ("Abs(x) + Abs(y) + Max(x - 1/8, 0)", ["x - 1/8"])):
        hypotheses = {
            "cells": {"within": "1/2", "surfaces": ["x", "y", *more], "empty": ["-.+"] if more else []},
            "function": function,
            **{"second": None, "verdict": "asymptotically stable", "everywhere": False, "level": None, "below": False},
            "rate": {"kind": "finite", "kappa": "1/2"},
        }
        _, shown = Search().entry(system, "lyapunov", hypotheses)
        assert "rate" in shown[-1]
        if more:
            with pytest.raises(NotShownError, match="meet at the point alone"):
                Search().entry(system, "lyapunov", {**hypotheses, "gain": "3"})
        else:
            assert "gain" in Search().entry(system, "lyapunov", {**hypotheses, "gain": "3"})[1][-1]
