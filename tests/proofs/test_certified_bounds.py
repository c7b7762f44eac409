"""What certificates of arrays state beside verdicts: drift, the way home by another V, rotation, the rate of the law.

The oracle follows bodies by small steps, and shares no theorem with the checker (:mod:`tests.oracles.array_bounds`).
"""

from __future__ import annotations

import copy
from fractions import Fraction
from typing import Any, TypeAlias

import pytest

from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.proofs.certificate import build_certificate
from nonsmooth.proofs.theorem4 import check_cells
from tests.array_certificates import check_certificate, evidence, said
from tests.built_in import checked
from tests.conftest import Arrays
from tests.oracles.array_bounds import assert_bounds_hold
from tests.thorough import few

Record: TypeAlias = dict[str, Any]

SEEDS = [13, 16, 63]  # arrays that attract although |c|^2 grows; the law of the last is by another P


def number(data: Any) -> Fraction:
    return Fraction(data)


FOUND: dict[int, tuple[Any, Record]] = {}


def of_seed(arrays: Arrays, seed: int) -> tuple[Any, Record]:
    """The check of an array and its certificate, once in a process."""
    if seed not in FOUND:
        result = check_cells(arrays.cocircular(seed))
        FOUND[seed] = result, build_certificate(result)
    return FOUND[seed]


@few(1)
@pytest.mark.parametrize("seed", SEEDS)
def test_bodies_come_home_as_is_stated(arrays: Arrays, seed: int) -> None:
    result, certificate = of_seed(arrays, seed)
    own = said(certificate)
    assert {"drift", "swing", "arrival", "feedback rate"} <= set(own)
    printed = result.translation
    assert Fraction(own["arrival"]["rate"]) >= 1 / Fraction(printed.arrival_per_distance)
    assert float(Fraction(own["swing"]["squared_swing"])) <= float(printed.swing_radius) ** 2
    assert float(Fraction(own["swing"]["squared_radius"])) >= float(printed.home_radius) ** 2 * (1 - 2e-6)
    partition = build_nearest_partition(arrays.cocircular(seed).recentred())
    assert_bounds_hold(certificate["statement"]["claims"], partition, number)


def put(certificate: Record, path: tuple[Any, ...], data: Any) -> Record:
    """The certificate with other data in its hypotheses; it claims what these say."""
    forged = copy.deepcopy(certificate)
    holder: Any = evidence(forged)
    for key in path[:-1]:
        holder = holder[key]
    holder[path[-1]] = data
    own, kept = evidence(forged), [c for c in forged["statement"]["claims"] if not set(c) & {"swing", "arrival"}]
    ellipse = own["ellipse"]
    start = {"squared_radius": ellipse["squared_radius"]}
    kept.append({"swing": {**start, "squared_swing": ellipse["squared_swing"]}})
    kept.append({"arrival": {**start, "rate": ellipse["arrival"]["rate"]}})
    law = {key: own["law"].get(key) for key in ("form", "weight", "kappa", "squared_reach")}
    forged["statement"]["claims"] = [c for c in kept if "feedback rate" not in c] + [{"feedback rate": law}]
    return forged


FORGED: dict[str, tuple[tuple[Any, ...], Any, str]] = {
    "a larger start": (("ellipse", "squared_radius"), "1", "an ellipse that holds the disc of starts"),
    "no start": (("ellipse", "squared_radius"), "0", "a positive quadratic form"),
    "a smaller swing": (("ellipse", "squared_swing"), "1/16", "an ellipse in the disc that bodies stay in"),
    "a negative swing": (("ellipse", "squared_swing"), "-1", "a positive quadratic form"),
    "an ellipse beyond the cells": (("ellipse", "level"), "1", "an ellipse"),
    "no bend": (("ellipse", "bend"), "0", "a bound of what the rotation adds to V"),
    "a negative bend": (("ellipse", "bend"), "-1", "a bound of what the rotation adds to V"),
    "an indefinite form": (("ellipse", "form"), ["1", "2", "1"], "a positive quadratic form"),
    "a round form": (("ellipse", "form"), ["1", "0", "1"], ""),
    "a faster arrival": (("ellipse", "arrival", "rate"), "2", "a rate at which bodies arrive"),
    "a negative arrival": (("ellipse", "arrival", "rate"), "-1", "a rate at which bodies arrive"),
    "no speeds": (("ellipse", "arrival", "speeds"), [], "positive speeds"),
    "faster speeds": (("ellipse", "arrival", "speeds"), ["9"] * 16, "a speed at which V falls"),
    "rising speeds": (("ellipse", "arrival", "speeds"), ["1/9", "1/8"], "positive speeds"),
    "many speeds": (("ellipse", "arrival", "speeds"), ["1/9"] * 65, "a list of at most 64 items"),
    "no bend on the way": (("ellipse", "arrival", "bend"), "0", "a bound of what the rotation adds to V"),
    "a low level": (("ellipse", "arrival", "level"), "1/1000", "a level that holds the disc of starts"),
    "a turn where it spins": (("ellipse", "turn"), "1000", "a body that arrives, and rests"),
    "a faster law": (("law", "kappa"), "2", "a rate at which the law lets V fall"),
    "no rate": (("law", "kappa"), "0", "a positive weight and rate"),
    "a light heading": (("law", "weight"), "1/1000000000", "a"),
    "a law of another V": (("law", "form"), ["1", "9/10", "1"], "a distance within which the rate holds"),
    "a wider drift": (("drift",), ["-100", "100", "1"], "rate at rest"),
    "a drift turned round": (("drift",), ["1", "-1", "-1"], "a drift over a positive denominator"),
    "a turn about a disc": (("turn",), "1000", "a disc of starts"),
}


@pytest.mark.parametrize("name", FORGED)
def test_forged_bounds_are_rejected(arrays: Arrays, name: str) -> None:
    path, data, why = FORGED[name]
    _, certificate = of_seed(arrays, 13)
    refused = check_certificate(put(certificate, path, data))
    assert refused
    assert why in refused


def test_a_distance_of_the_law_is_load_bearing(arrays: Arrays) -> None:
    """Where P is no multiple of the unit matrix, the rotation turns V."""
    _, certificate = of_seed(arrays, 63)
    reach = Fraction(evidence(certificate)["law"]["squared_reach"])
    for key, data in (("squared_reach", str(4 * reach)), ("slack", "0"), ("least", "1"), ("squared_reach", "0")):
        assert "a distance at which the rotation adds little" in check_certificate(put(certificate, ("law", key), data))
    assert "a distance within which" in check_certificate(put(certificate, ("law", "squared_reach"), None))


def test_a_body_that_is_not_turned_anywhere() -> None:
    """Rule box on an array of outward rims: no cell of the square turns the body."""
    certificate = build_certificate(checked("outward", "box"))
    own = said(certificate)
    assert own["turning"] == {"squared_radius": evidence(certificate)["disc"], "per_distance": "0"}
    assert own["drift"] == ["0", "0", "1"]
    for factor in ("-1", "1"):
        forged = copy.deepcopy(certificate)
        evidence(forged)["turn"] = factor
        for claim in forged["statement"]["claims"]:
            if "turning" in claim:
                claim["turning"]["per_distance"] = factor
        assert bool(check_certificate(forged)) == (factor == "-1")
