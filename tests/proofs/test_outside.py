"""Polygons outside of which no start comes to the point: around the certified region, and false ones refused."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.proofs.checker.basin import Plane
from nonsmooth.proofs.checker.descriptions import describe
from nonsmooth.proofs.checker.outside import closed, is_counterclockwise, meet, require_simple, show_outside, winding
from nonsmooth.proofs.checker.positivity import Proofs
from nonsmooth.proofs.checker.roots import read_subject
from nonsmooth.proofs.checker.work import RejectedError
from nonsmooth.proofs.kernel.subject import about
from nonsmooth.proofs.system_certificates import certificate_of, certificate_text
from nonsmooth.proofs.systems.basin import AXES, EFFORTS, find_borders, left_of
from nonsmooth.proofs.systems.basin_rings import FloatField, RingGrowth, next_ring
from nonsmooth.proofs.systems.outer_ring import find_outer_ring, find_traps, other_rests, ring_of
from nonsmooth.reports.checks.check import check_system
from nonsmooth.symbolic.files.system_builder import build_system
from tests.oracles.floats import midpoint
from tests.plain import refused
from tests.thorough import keep, thorough

COARSE = RingGrowth(0.12, 0.05, 0.04)
CIRCLE = ["-y - x*(1 - x**2 - y**2)", "x - y*(1 - x**2 - y**2)"]  # attracts inside the unit circle, exactly


def with_coarse_region(name: str, document: dict[str, Any], pace: RingGrowth = COARSE) -> Any:
    """The check of a system in x and y with a coarse search."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(EFFORTS, "fast", replace(EFFORTS["fast"], pace=pace, starts=21))
        return check_system(build_system(document, name, Path(f"{name}.toml"))).with_region("fast")


@cache
def circle() -> Any:
    return with_coarse_region("circle", {"system": {"states": ["x", "y"], "rhs": CIRCLE}})


@cache
def text_of(check: Callable[[], Any]) -> str:
    return certificate_text(certificate_of(check().evidence))


def certificate(check: Callable[[], Any]) -> dict[str, Any]:
    """A certificate of a check, to be changed."""
    record: dict[str, Any] = json.loads(text_of(check))
    return record


def test_the_polygon_is_around_the_circle() -> None:
    """All of it is outside of the true region, and near it; what it is filled by is a lower bound of the true share."""
    basin = circle().evidence.reach.basin
    sizes = np.linalg.norm(ring_of(basin.outside), axis=1)
    assert sizes.min() > 1
    assert sizes.max() < 1.2
    ring = basin.border
    area = float(np.sum(ring[:, 0] * np.roll(ring[:, 1], -1) - ring[:, 1] * np.roll(ring[:, 0], -1)) / 2)
    assert 0.6 < basin.filled < area / np.pi


def test_what_is_said_of_it() -> None:
    """In words, in JSON, and in a certificate that the checker accepts."""
    record = circle().facts()["basin"]
    assert "no start outside of a polygon of" in record["text"]
    assert re.search(r"of the starts sampled within -[0-9.]+ <= x <= [0-9.]+, -[0-9.]+ <= y <= ", record["text"])
    assert len(record["outside"]["polygon"]) > 20
    document = certificate(circle)
    assert any("outside" in claim for claim in document["statement"]["claims"])
    assert not refused(document)


@pytest.mark.parametrize("scale", keep(1, [Fraction(9, 10), Fraction(1, 2)]))
def test_a_smaller_polygon_is_refused(scale: Fraction) -> None:
    """From between it and the circle all starts come home."""
    forged = certificate(circle)
    claim = next(c["outside"] for c in forged["statement"]["claims"] if "outside" in c)
    entry = next(e["hypotheses"] for e in forged["evidence"] if e["theorem"] == "outside")
    claim["unit"] = entry["unit"] = str(Fraction(entry["unit"]) * scale)
    assert refused(forged)


def test_a_polygon_without_a_unit_is_refused() -> None:
    """Also where its corners are outside of the circle in whole units: the statement would have no length."""
    forged = certificate(circle)
    ring = ["2 -2", "2 2", "-2 2", "-2 -2"]
    for claim in forged["statement"]["claims"]:
        claim.update({"outside": {"unit": None, "corners": ring}} if "outside" in claim else {})
    for entry in forged["evidence"]:
        if entry["theorem"] == "outside":
            entry["hypotheses"] |= {"unit": None, "corners": ring}
    assert "a unit" in refused(forged)


def test_no_polygon_where_the_basin_reaches_to_infinity() -> None:
    """Of ``x y < 1`` none is found."""
    document = {"system": {"states": ["x", "y"], "rhs": ["-x + 2*x**2*y", "-y"]}}
    system = build_system(document, "hyperbola", Path("hyperbola.toml"))
    angles = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    border = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    assert find_outer_ring(read_subject(about(system)), [], border, RingGrowth(0.12, 0.05, 0.04), 1_000) is None


SIMPLE = {
    "triangle": [(2, 0), (-1, 2), (-1, -2)],
    "reentrant": [(4, -4), (4, 4), (0, 1), (-4, 4), (-4, -4)],
}
CROSSED = {
    "eight": [(4, -4), (4, 4), (-4, -4), (-4, 4)],
    "spike": [(4, -4), (4, 4), (4, 8), (4, 2), (-4, 4), (-4, -4)],
    "touching": [(4, -4), (4, 4), (0, -4), (-4, 4), (-4, -4)],
    "twice": [(4, -4), (4, 4), (-4, 4), (-4, -4), (4, -4), (4, 4), (-4, 4), (-4, -4)],
}


@pytest.mark.parametrize("name", SIMPLE)
def test_simple_polygons(name: str) -> None:
    """Counterclockwise about the origin, and from the other side not."""
    require_simple(SIMPLE[name])
    away = [(x + 100, y) for x, y in SIMPLE[name]]
    rings = (SIMPLE[name], SIMPLE[name][::-1], away, away[::-1])
    assert [winding(ring) for ring in rings] == [1, -1, 0, 0]
    assert [is_counterclockwise(ring) for ring in rings] == [True, False, True, False]


@pytest.mark.parametrize("name", CROSSED)
def test_polygons_that_meet_themselves(name: str) -> None:
    """Refused."""
    with pytest.raises(RejectedError):
        require_simple(CROSSED[name])


def test_sides_meet_as_points_on_them_do() -> None:
    """Against a literal definition: two sides on a small grid meet where some point of one is on the other."""
    random = np.random.default_rng(1)
    for _ in range(400):
        a, b, c, d = ((int(x), int(y)) for x, y in random.integers(-3, 4, (4, 2)))
        if a == b or c == d:
            continue
        assert meet((a, b), (c, d), 5, 5) == literally_meet(a, b, c, d), (a, b, c, d)


def literally_meet(a: Any, b: Any, c: Any, d: Any) -> bool:
    """By Cramer's rule in fractions, or where parallel by projections."""
    r, s = (b[0] - a[0], b[1] - a[1]), (d[0] - c[0], d[1] - c[1])
    between = (c[0] - a[0], c[1] - a[1])
    bottom = r[0] * s[1] - r[1] * s[0]
    if bottom:
        t = Fraction(between[0] * s[1] - between[1] * s[0], bottom)
        u = Fraction(between[0] * r[1] - between[1] * r[0], bottom)
        return 0 <= t <= 1 and 0 <= u <= 1
    if between[0] * r[1] - between[1] * r[0]:
        return False
    length = r[0] ** 2 + r[1] ** 2
    ends = sorted(Fraction((p[0] - a[0]) * r[0] + (p[1] - a[1]) * r[1], length) for p in (c, d))
    return ends[0] <= 1 and ends[1] >= 0


COMPETITION = ["x*(3 - x - 2*y)", "y*(3 - 2*x - y)"]  # (0, 3) and (3, 0) attract; (1, 1) is a saddle


@cache
def competition() -> Any:
    """The check of one of the two places of rest."""
    document = {"system": {"states": ["x", "y"], "rhs": COMPETITION}, "check": {"equilibrium": [0, 3]}}
    return with_coarse_region("competition", document)


def test_a_trap_about_another_place_of_rest() -> None:
    """It holds starts that go there, in floats, and lies on its side of the saddle's border x = y."""
    ((place, hypotheses),) = competition().evidence.reach.basin.traps
    assert place == pytest.approx([3, -3], abs=1e-3)
    ring = ring_of(hypotheses) + np.array([0.0, 3.0])
    assert (ring[:, 0] > ring[:, 1]).all()
    x, y = ((ring + ring.mean(axis=0)) / 2).T
    for _ in range(4000):
        step = 0.005 / (1 + np.hypot(x, y))
        x, y = x + step * x * (3 - x - 2 * y), y + step * y * (3 - 2 * x - y)
    assert np.abs(x - 3).max() < 1e-2
    assert np.abs(y).max() < 1e-2


def test_what_is_said_of_a_trap() -> None:
    """Lower and upper shares, polygons in JSON, and a certificate."""
    record = competition().facts()["basin"]
    low, high = (
        float(share) for share in re.findall(r"so ([0-9.]+) % to ([0-9.]+) % of the sampled", record["text"])[0]
    )
    assert re.search(r"no start inside of a polygon about \(-?[0-9.]+, -?[0-9.]+\) does", record["text"])
    assert 0 < low < 50 < high < 100  # the true share is about a half
    assert len(record["traps"]) == 1
    document = certificate(competition)
    assert any("no start inside a polygon" in line for line in describe(document["statement"]))
    assert not refused(document)


@pytest.mark.parametrize("way", ["turned over", "about the point", "larger"])
def test_other_traps_are_refused(way: str) -> None:
    forged = certificate(competition)
    claim = next(c["outside"] for c in forged["statement"]["claims"] if "outside" in c)
    corners = list(claim["corners"])
    if way == "turned over":
        corners.reverse()
    elif way == "about the point":
        corners = ["1 -1", "-1 -1", "-1 1", "1 1"]
    else:
        corners = [f"{2 * int(x)} {2 * int(y)}" for x, y in (corner.split(" ") for corner in corners)]
    claim["corners"] = corners
    for entry in forged["evidence"]:
        if entry["theorem"] == "outside":
            entry["hypotheses"]["corners"] = corners
    assert refused(forged)


@thorough  # without sines: test_a_trap_about_another_place_of_rest
def test_traps_beside_a_pendulum() -> None:
    """About the next lower positions, with sines: the checker takes them, and no larger ones."""
    document = {"system": {"states": ["x", "y"], "rhs": ["y", "-sin(x) - y/2"]}}
    evidence = with_coarse_region("pendulum", document, RingGrowth(0.08, 0.03, 0.04)).evidence
    basin = evidence.reach.basin
    assert basin is not None
    assert sorted(place[0] for place, _ in basin.traps) == pytest.approx([-2 * np.pi, 2 * np.pi], abs=1e-3)
    _, hypotheses = basin.traps[0]
    system, unit = read_subject(about(evidence.scene)), Fraction(hypotheses["unit"])
    show_outside(system, hypotheses, Proofs({}))
    for share in (Fraction(9, 8), Fraction(7, 8)):
        with pytest.raises(RejectedError):
            show_outside(system, {**hypotheses, "unit": str(unit * share)}, Proofs({}))


@pytest.mark.parametrize("rhs", [["-x", "-y"], ["-sign(x) - x", "-y - sign(x - 3)/8"], ["-x - x**3", "-y + x**2"]])
def test_no_other_place_of_rest(rhs: list[str]) -> None:
    surfaces = ["x", "x - 3"] if "sign" in rhs[0] else []
    system = read_subject({"states": ["x", "y"], "rhs": [rhs], "at": ["0", "0"]})
    assert other_rests(FloatField(Plane(system, "1", surfaces, Proofs({}))), 2.0) == []


def test_a_ring_that_folds_onto_itself_grows_on() -> None:
    """The neighbours of one of its points are at the same place."""
    system = read_subject(about(ns.System(["x", "y"], ["-x", "-y"]).system))
    field = FloatField(Plane(system, "1", [], Proofs({})))
    ring = np.array([[1.0, 0.0], [2.0, 0.0], [1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])
    assert np.isfinite(next_ring(field, ring, RingGrowth(0.1, 0.1, 0.1), 10.0, 0)).all()


SPRING = ["y", "-x + x**3 - y"]  # saddles at (-1, 0) and (1, 0); the basin between their stable manifolds is unbounded
STEPS, STEP = 2_000, 0.01


def comes(field: Callable[[Any, Any], Any], starts: Any) -> Any:
    """Which starts come near the origin in floats, by the midpoint rule."""
    x = starts.T.copy()
    with np.errstate(all="ignore"):
        for _ in range(STEPS):
            x = midpoint(lambda place: np.stack(field(*place)), x, STEP)
    return np.hypot(*x) < 0.2


@cache
def spring() -> Any:
    """The check of a spring that weakens."""
    document = {"system": {"states": ["x", "y"], "rhs": SPRING}}
    return with_coarse_region("spring", document, RingGrowth(0.1, 0.03, 0.04))


def test_lines_beside_saddles_bound_the_basin_of_a_spring() -> None:
    """In words, in JSON, in a picture and in a certificate; the true share lies between the lower and the upper one."""
    record, basin = spring().facts()["basin"], spring().evidence.reach.basin
    assert "no start beyond lines beside the saddles (-1, 0) and (1, 0) does" in record["text"]
    low, high = (
        float(share) for share in re.findall(r"so ([0-9.]+) % to ([0-9.]+) % of the sampled", record["text"])[0]
    )
    _, coming = basin.sampled
    assert low < 100 * coming / basin.square[2] < high < 1.1 * 100 * coming / basin.square[2]
    assert sorted(saddle["at"][0] for saddle in record["saddles"]) == pytest.approx([-1, 1], abs=1e-5)
    assert {len(saddle["ends"]) for saddle in record["saddles"]} == {2}
    axes = spring().plot()
    assert axes.get_xlim() == pytest.approx(basin.window[0])
    document = certificate(spring)
    assert sum("no start to the right of a line" in line for line in describe(document["statement"])) == 2
    assert not refused(document)


@pytest.mark.parametrize("way", ["back", "nearer", "ends turned", "ends exchanged", "without ends"])
def test_other_lines_are_refused(way: str) -> None:
    forged = certificate(spring)
    entry = next(e["hypotheses"] for e in forged["evidence"] if e["theorem"] == "outside")
    if way == "back":
        entry.update(corners=entry["corners"][::-1], ends=entry["ends"][::-1])
    elif way == "nearer":
        entry["unit"] = str(Fraction(entry["unit"]) * Fraction(49, 50))
    elif way == "ends turned":
        entry["ends"] = [" ".join(str(-int(x)) for x in end.split(" ")) for end in entry["ends"]]
    elif way == "ends exchanged":
        entry["ends"] = entry["ends"][::-1]
    else:
        del entry["ends"]
    next(claim["outside"] for claim in forged["statement"]["claims"] if "outside" in claim).update(
        {key: entry[key] for key in ("unit", "corners", *(["ends"] if "ends" in entry else []))}
    )
    assert refused(forged)


SADDLES: dict[str, tuple[list[str], Callable[[Any, Any], Any]]] = {
    "a place of rest that meets another": (["-x + x**2", "-y"], lambda x, y: (-x + x**2, -y)),
    "turning": (["y", "-x - y/2 + x**2 - x*y/2"], lambda x, y: (y, -x - y / 2 + x**2 - x * y / 2)),
    "two nonlinear parts": (["-x + y + x**3", "-y + x**2"], lambda x, y: (-x + y + x**3, -y + x**2)),
    "saturated": (
        ["y", "-y + x - (Abs(3*x/2 + 1) - Abs(3*x/2 - 1))"],
        lambda x, y: (y, -y + x - 2 * np.clip(1.5 * x, -1, 1)),
    ),
}


@pytest.mark.parametrize("name", SADDLES)
def test_no_start_beyond_a_line_comes(name: str) -> None:
    """Followed in floats; near the saddle some do, and the line is nearly there."""
    rhs, field = SADDLES[name]
    surfaces = ["3*x/2 + 1", "3*x/2 - 1"] if name == "saturated" else []
    system = read_subject({"states": ["x", "y"], "rhs": [rhs], "at": ["0", "0"]})
    angles = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    border = 0.8 * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    borders = find_borders(system, surfaces, border, RingGrowth(0.04, 0.012, 0.04))
    assert borders
    for saddle, hypotheses in borders:
        random = np.random.default_rng(1)
        starts = np.concatenate([random.uniform(-2, 2, (300, 2)), saddle + random.normal(0, 0.05, (300, 2))])
        before = left_of(hypotheses, starts)
        coming = comes(field, starts)
        assert not (coming & ~before).any()
        assert coming[300:].any()
        assert np.linalg.norm(ring_of(hypotheses) - saddle, axis=1).min() < 0.02


def test_the_side_of_a_chain_with_half_lines() -> None:
    """The point is to the left of random chains where the nearest side says so."""
    random, tried = np.random.default_rng(1), 0
    for _ in range(3_000):
        chain = [(int(x), int(y)) for x, y in random.integers(-9, 10, (random.integers(1, 5), 2))]
        first, last = (AXES[k] for k in random.integers(0, 4, 2))
        whole = closed(chain, first, last)
        try:
            require_simple(whole)
        except RejectedError:
            continue
        side = nearest_side(
            np.array([np.add(chain[0], np.multiply(99, first)), *chain, np.add(chain[-1], np.multiply(99, last))])
        )
        if side is not None:
            tried += 1
            assert (winding(whole) == 1) == (side > 0), (chain, first, last)
            assert is_counterclockwise(whole)
    assert tried > 200


def nearest_side(chain: Any) -> float | None:
    """Positive where the origin is to the left of the side nearest to it; None where a corner is as near."""
    a, b = chain[:-1].astype(float), chain[1:].astype(float)
    along = b - a
    share = np.clip(-(a * along).sum(axis=1) / (along**2).sum(axis=1), 0, 1)
    distance = np.hypot(*(a + share[:, None] * along).T)
    k = int(distance.argmin())
    if not 0 < share[k] < 1 or distance[k] == 0:
        return None
    return float(along[k, 1] * a[k, 0] - along[k, 0] * a[k, 1])


def test_polygons_about_a_field_that_repeats_itself_have_few_corners() -> None:
    """Those of the pendulum about both neighbours: velocities lead into them over longer sides, too."""
    rhs = [["y", "-1/2*y - sin(x)"]]
    system = read_subject({"states": ["x", "y"], "rhs": rhs, "at": ["0", "0"]})
    angles = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    border = 2.5 * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    traps = find_traps(system, [], border, RingGrowth(0.04, 0.012, 0.04), 300)
    assert sorted(round(place[0]) for place, _ in traps) == [-6, 6]
    assert all(len(polygon["corners"]) < 500 for _, polygon in traps)
    for place, polygon in traps:
        spread = ring_of(polygon) - place
        assert np.abs(spread).max() > 4
