"""Closed loops with limited speeds: limits kept, certified rates kept, orbits unchanged; against brute force.

The brute force shares no code with the program: it orders wheels by distance, solves three constraint equations, takes
the law from its formula and goes on by tiny steps.
"""

from __future__ import annotations

import csv
import json
import math
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.analysis.fields.contact_model import ContactRows, contact_model
from nonsmooth.analysis.minimizers.box_minimizers import BoxHighs
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseMinimizer
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.analysis.minimizers.minimum import Minimizer
from nonsmooth.analysis.trajectories.result import EventKind
from nonsmooth.proofs.clauses.feedback.by_friction import decide_driven_feedback
from nonsmooth.proofs.clauses.feedback.by_rows import FeedbackResult
from nonsmooth.proofs.clauses.feedback.driven_law import rim_speeds
from nonsmooth.proofs.clauses.feedback.gradient_law import LimitedRate
from nonsmooth.proofs.clauses.feedback.loop_bounds import limited_speed
from nonsmooth.reports.cli import app
from nonsmooth.reports.output.console import run
from nonsmooth.reports.simulations.paths import ArrayPath, PathResult
from nonsmooth.symbolic.mechanics.similar_scenes import in_own_length
from tests.oracles.floats import Floats
from tests.oracles.wheels_in_floats import Contacts, J, NearestRows
from tests.thorough import few, keep

SLACK = 1e-9  # of V and times along integrated paths
SLOW: dict[str, Any] = {"field": {"kind": "radial", "speed": "1/100"}}  # speeds of the open loop, below every limit


def random_array(seed: int) -> ns.Array:
    """Wheels on the unit circle, rims about inward, each with a limit of its own; one of them without any."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(3, 7))
    angles = np.sort(2 * np.pi * (np.arange(count) + rng.uniform(-0.2, 0.2, count)) / count)
    wheels = []
    for k, angle in enumerate(angles):
        half = Fraction(math.tan((angle - math.pi) / 2)).limit_denominator(40)  # a rational point of the circle
        place = (-(1 - half**2) / (1 + half**2), -2 * half / (1 + half**2))
        (x, y), turn = map(float, place), rng.uniform(-0.3, 0.3)
        rim = (-x * math.cos(turn) + y * math.sin(turn), -x * math.sin(turn) - y * math.cos(turn))
        heading = (round(rim[0], 3), round(rim[1], 3))
        limit = None if k == 0 else round(float(rng.uniform(0.05, 0.2)), 3)
        wheels.append(ns.Wheel(place, heading=heading, speed="1/100", speed_limit=limit))
    return ns.Array(wheels, mu_roll=1, mu_side="1/2", length=round(float(rng.uniform(0.5, 1.5)), 2))


def turned_rectangle() -> ns.Array:
    """Rims turned so far from inward that only a V with ``P != I`` serves."""
    corners = [(2, 1), (-2, 1), (-2, -1), (2, -1)]
    rims = [(-4 * x + 3 * y, -3 * x - 4 * y) for x, y in corners]
    wheels = [ns.Wheel(p, heading=d, speed="1/1000", speed_limit="1/50") for p, d in zip(corners, rims, strict=True)]
    return ns.Array(wheels, mu_roll=1, mu_side="1/2", length=1)


ARRAYS: dict[str, ns.Array] = {
    "shaped": turned_rectangle(),
    "four wheels": ns.Array.ring(4, phase="pi/4", mu_roll=1, mu_side="1/2", speed_limit="1/10", length=1, **SLOW),
    "five in millimetres": ns.Array.ring(
        5, radius=200, mu_roll=1, mu_side="1/2", speed_limit=15, units={"length": "mm"}, **SLOW
    ),
    **{f"random {seed}": random_array(seed) for seed in (1, 2, 3, 5)},
}


@cache
def feedback_of(name: str) -> tuple[FeedbackResult, LimitedRate]:
    """What the check of an array finds, once for all tests."""
    found = ARRAYS[name].check().evidence.feedback
    assert isinstance(found, FeedbackResult)
    assert found.limited
    return found, found.limited


def starts(array: ns.Array, limited: LimitedRate, lyapunov: Any, count: int, seed: int = 0) -> list[Floats]:
    """Random starts just inside the certified level."""
    rng = np.random.default_rng(seed)
    found = []
    for direction in rng.normal(size=(count, 3)):
        z = direction * np.array([1, 1, 1 / float(array.scene.check.length)])
        found.append(z * math.sqrt(0.98 * float(limited.level) / value(lyapunov, z)))
    return found


def value(lyapunov: Any, pose: Any) -> float:
    """``c^T P c + w theta^2``."""
    (e, f), w = (float(entry) for entry in lyapunov.shape), float(lyapunov.weight)
    x, y, theta = pose
    return float((1 + e) * x * x + 2 * f * x * y + (1 - e) * y * y + w * theta * theta)


def speeds_of(path: PathResult, times: Any = None) -> Floats:
    assert isinstance(path, ArrayPath)
    return path.speeds(times)


def test_only_a_path_under_a_law_has_one_and_its_speeds() -> None:
    array = ARRAYS["four wheels"]
    own, closed = (array.simulate((0.1, 0.2, 0.3), until=0.1, feedback=wanted) for wanted in (False, True))
    assert own.loop is None
    assert closed.loop is not None
    assert speeds_of(closed).shape == (len(closed.t), 4)
    with pytest.raises(ValueError, match="required a closed loop, received the scene's own speeds"):
        speeds_of(own)


def test_states_at_many_times_are_those_at_each() -> None:
    """Along a path of several stretches, before it, at its ends and after it, whatever the order of the times."""
    path = ARRAYS["four wheels"].simulate((0.1, 0.2, 0.3), until=2.0, feedback=True, gain=3.0).trajectory
    assert len(path.pieces) > 1
    ends = [piece.end for piece in path.pieces]
    times = [-1.0, *np.linspace(0, 2, 200), *path.times, *ends, 3.0, 1.0, 0.1]
    assert path.sample(times).tolist() == [list(path.at(time)) for time in times]


@few(1)
@pytest.mark.parametrize("gain", [0.5, 4.0])
@pytest.mark.parametrize("name", keep(3, ARRAYS))
def test_limits_are_kept_and_v_falls_as_certified(name: str, gain: float) -> None:
    array = ARRAYS[name]
    feedback, limited = feedback_of(name)
    limits = {index: float(limit) for index, limit in array.scene.speed_limits.items()}
    assert feedback.rate is not None
    kappa, speed = float(feedback.rate.kappa), float(limited.speed)
    ever = False
    for start in starts(array, limited, feedback.lyapunov, 3):
        path = array.simulate(tuple(start), until=6.0, feedback=True, gain=gain)
        speeds = speeds_of(path)
        for index, limit in limits.items():
            assert np.nanmax(np.abs(speeds[:, index - 1]), initial=0.0) <= limit * (1 + 1e-12)
        times = np.linspace(0, path.t[-1], 2000)
        roots = np.sqrt([value(feedback.lyapunov, pose) for pose in path.trajectory.sample(times.tolist())])
        certified = np.minimum(gain * kappa * roots[1:], speed) * np.diff(times)
        assert (np.diff(roots) <= -certified * (1 - 1e-6) + SLACK * roots[0]).all()
        inside = gain * gain * roots[:-1] ** 2 <= float(limited.held)
        exponential = roots[:-1] * np.exp(-gain * kappa * np.diff(times))
        assert (roots[1:] <= exponential + SLACK * roots[0])[inside].all()
        begun = [event for event in path.trajectory.events if event.kind is EventKind.LIMIT]
        if feedback.lyapunov.length is not None or gain >= 1:
            assert all(gain**2 * value(feedback.lyapunov, e.state) > float(limited.free) * (1 - 1e-9) for e in begun)
        ever = ever or bool(begun)
    assert ever or gain < 1


ORBITS = [("shaped", 1), ("four wheels", 1), ("shaped", 2), ("four wheels", 2), ("random 5", 2)]  # and how many starts


@few(1)
@pytest.mark.parametrize(("name", "count"), keep(2, ORBITS))
def test_orbits_are_those_without_limits(name: str, count: int) -> None:
    """V falls strictly along both, so the pose is a function of V: it must be the same one."""
    array = ARRAYS[name]
    feedback, limited = feedback_of(name)
    free = ns.Array.of_document({key: part for key, part in array.document.items() if key != "drive"})
    if "wheel" in array.document:
        wheels = [{k: v for k, v in wheel.items() if k != "speed_limit"} for wheel in array.document["wheel"]]
        free = ns.Array.of_document({**array.document, "wheel": wheels})
    assert not free.scene.speed_limits
    for start in starts(array, limited, feedback.lyapunov, count, seed=7):
        slow, fast = (
            own.simulate(tuple(start), until=until, feedback=True, gain=3.0)
            for own, until in ((array, 5.0), (free, 5.0))
        )
        assert any(event.kind is EventKind.LIMIT for event in slow.trajectory.events)
        dense = fast.trajectory.sample(np.linspace(0, fast.t[-1], 20001).tolist())
        fallen = np.array([value(feedback.lyapunov, pose) for pose in dense])
        for time in np.linspace(0, slow.t[-1], 60):
            pose = np.array(slow.trajectory.at(float(time)), float)
            own = value(feedback.lyapunov, pose)
            if own <= fallen[-1]:
                break
            expected = [np.interp(-own, -fallen, column) for column in dense.T]
            assert np.abs(pose - expected).max() < 2e-5 * math.sqrt(fallen[0])


def brute_force(array: ns.Array, start: Floats, gain: float, until: float, steps: int) -> Floats:
    """The limited loop by the words of the rule and the formula of the law for ``V = |c|^2 + l^2 theta^2``."""
    contacts = Contacts.of(array.scene)
    rows = NearestRows(contacts)
    limits = [math.inf if w.speed_limit is None else float(w.speed_limit) for w in array.scene.wheels]
    weight = float(array.scene.check.length) ** 2
    pose = np.array(start, float)

    for _ in range(steps):
        c, theta = pose[:2], pose[2]
        first, _, second = rows.at(c)
        i, j = first.wheel, second.wheel
        (p, q), (d, e) = contacts.positions[[i, j]], contacts.rims[[i, j]]
        b = (weight * theta - c @ (J @ p)) / (e @ (J @ (q - p)))
        a = c @ d - (d @ e) * b
        u = {i: -gain * a, j: -gain * b}
        share = min(1.0, *(limits[wheel] / abs(speed) if speed else math.inf for wheel, speed in u.items()))
        pose = pose + until / steps * rows.rate(c, lambda own: share * u[own.wheel])  # noqa: B023 - called at once
    return pose


@few(1)
@pytest.mark.parametrize("finest", keep(1, [4_000, 16_000]))
@pytest.mark.parametrize("name", keep(2, ["five in millimetres", "four wheels", "random 2"]))
def test_paths_against_brute_force(name: str, finest: int) -> None:
    array = ARRAYS[name]
    feedback, limited = feedback_of(name)
    assert feedback.lyapunov.length is not None
    (start,) = starts(array, limited, feedback.lyapunov, 1, seed=3)
    gain, until = 3.0, 2.0
    path = array.simulate(tuple(start), until=until, feedback=True, gain=gain)
    size = math.sqrt(value(feedback.lyapunov, start))
    end = np.array(path.trajectory.end.state, float)
    for steps in (finest // 4, finest):  # Euler's method passes switches late, so that errors fall but not evenly
        gap = brute_force(array, start, gain, until, steps) - end
        assert math.sqrt(value(feedback.lyapunov, gap)) < 5 / steps * size


def test_a_cascade_keeps_its_orbits_and_its_heading_decays() -> None:
    """Under the law that takes theta first, theta falls along both; how fast is not said."""
    free = ns.Array.ring(4, phase="pi/4", mu_roll=1, mu_side="1/2", length=1, **SLOW)
    array = free.with_(speed_limit="1/20")
    start, gain = (0.1, 0.2, 0.3), 3.0
    slow, fast = (own.simulate(start, until=3.0, feedback="cascade", gain=gain) for own in (array, free))
    dense = fast.trajectory.sample(np.linspace(0, fast.t[-1], 20001).tolist())
    for time in np.linspace(0, slow.t[-1], 50):
        pose = np.array(slow.trajectory.at(float(time)), float)
        expected = [np.interp(-pose[2], -dense[:, 2], column) for column in dense.T]
        assert np.abs(pose - expected).max() < 1e-5
    assert np.nanmax(np.abs(speeds_of(slow))) <= 0.05 * (1 + 1e-12)
    assert slow.state[-1, 2] > fast.state[-1, 2] > 0


@pytest.mark.parametrize("rule", ["box", "ellipse"])
def test_minimizers_scale_with_all_speeds_together(rule: str) -> None:
    """D is homogeneous in twist and speeds together: what the laws of these rules rest on where speeds end."""
    rng = np.random.default_rng(4)
    model = contact_model(ARRAYS["random 2"].scene)
    minimizer: Minimizer = BoxHighs() if rule == "box" else EllipseMinimizer()
    loads = loads_at(model, rng.uniform(-0.2, 0.2, (5, 2)))
    for load in loads:
        targets = np.zeros(2 * model.wheels)
        targets[::2] = rng.normal(size=model.wheels)
        one, other = (
            minimizer.minimize(ContactRows(model.rows, share * targets, model.friction), load) for share in (1.0, 0.3)
        )
        assert np.abs(0.3 * one.twists - other.twists).max() < 1e-7


@few(1)
@pytest.mark.parametrize("rule", ["box", "ellipse"])
@pytest.mark.parametrize("name", ["ring-3", "ring-5"])
def test_the_error_falls_at_the_stated_speed_where_speeds_end(name: str, rule: str) -> None:
    """Speeds of the law, scaled to the limit, given to a minimizer: sqrt(V) falls at that speed or at the rate."""
    array = ns.load(name).with_(rule=rule, speed_limit=1)
    assert isinstance(array, ns.Array)
    scene = in_own_length(array.scene.recentred())
    feedback = decide_driven_feedback(scene)
    speed = limited_speed(feedback, scene)
    assert feedback.kappa is not None
    assert speed is not None
    pose = array.check().pose
    assert pose["speed"] == speed
    model, rng = contact_model(scene), np.random.default_rng(9)
    minimizer: Minimizer = BoxHighs() if rule == "box" else EllipseMinimizer()
    reach, gain, ended = float(scene.check.radius) * 1e-4, 3e5, 0
    (cone,) = feedback.cones
    vectors = np.array([[float(x) for x in imposed.twist] for imposed in cone.twists])
    for _ in range(20):
        size = reach * 10 ** -rng.uniform(0, 3)
        c = rng.uniform(-1, 1, 2) * size
        g = np.array([*c, rng.normal() * size])
        best = int(np.argmax(np.abs(vectors @ g)))
        wanted = -gain * (vectors[best] @ g) * np.array(rim_speeds(scene, cone.twists[best]))
        factor = min(1.0, 1.0 / np.abs(wanted).max())
        ended += factor < 1
        load = loads_at(model, c[None])[0]
        targets = model.targets_of(factor * wanted)
        (twist,) = minimizer.minimize(ContactRows(model.rows, targets, model.friction), load).twists
        size = np.sqrt(g @ g)
        falls = -float(g @ twist) / size
        assert falls >= min(float(speed), gain * float(feedback.kappa) * size) * (1 - 1e-2)
    assert 0 < ended < 20


def test_paths_say_when_speeds_end_in_every_format(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file, table = tmp_path / "s.toml", tmp_path / "path.csv"
    ring = '[ring]\ncount = 5\n[field]\nkind = "radial"\nspeed = "1/100"\n[check]\nlength = 1\n'
    file.write_text(
        f'[friction]\nmu_roll = 1\nmu_side = "1/2"\n[drive]\nspeed_limit = "1/10"\n{ring}', encoding="utf-8"
    )
    simulate = ("simulate", str(file), "--from", "0.1,0.15,0.3", "--feedback", "--gain", "3", "--until", "4")
    assert run(app, (*simulate, "--json", "-o", str(table))) == 0
    record = json.loads(capsys.readouterr().out)
    assert record["law"]["gain"] == 3
    kinds = [(event["kind"], event["surface"]) for event in record["events"] if event["kind"] in {"limit", "free"}]
    assert kinds == [("limit", "wheel 1 at the largest speed"), ("free", "no wheel is at its largest speed")]
    assert {len(row) for row in record["speeds"]} == {5}
    assert len(record["speeds"]) == len(record["t"])
    known = [abs(speed) for row in record["speeds"] for speed in row if speed is not None]
    assert max(known) == 0.1
    free = next(event["t"] for event in record["events"] if event["kind"] == "free")
    for time, row in zip(record["t"], record["speeds"], strict=True):
        top = max(abs(speed) for speed in row if speed is not None)
        assert (top == pytest.approx(0.1, rel=1e-9)) == (time <= free + 1e-9)
    header, *lines = csv.reader(table.read_text(encoding="utf-8").splitlines())
    assert header == ["t", "x", "y", "theta", "u_1", "u_2", "u_3", "u_4", "u_5"]
    cells = [[None if cell == "" else float(cell) for cell in line[4:]] for line in lines]
    assert cells == record["speeds"]
    picture = tmp_path / "path.svg"
    assert run(app, (*simulate, "-o", str(picture))) == 0
    assert b"speeds u_i" in picture.read_bytes() or b"DejaVu" in picture.read_bytes()
    capsys.readouterr()


@pytest.mark.usefixtures("without_paths", "without_other_rules")
def test_what_is_said_of_limited_speeds(tmp_path: Path) -> None:
    name = "five in millimetres"
    array = ARRAYS[name]
    feedback, limited = feedback_of(name)
    record = array.check().to_dict()["feedback"]["limited"]
    assert record["speed"] == pytest.approx(float(limited.speed))
    assert feedback.rate is not None
    assert float(limited.speed) <= 15 * math.sqrt(feedback.rate.kappa)
    metres = array.check().pose
    assert metres["speed"] == limited.speed
    assert "where speeds are limited" in metres.sentence
    four = ns.load("four-wheel")
    assert isinstance(four, ns.Array)
    unlimited = four.check()
    assert unlimited.to_dict()["feedback"]["limited"] is None
    assert unlimited.pose["speed"] is None
