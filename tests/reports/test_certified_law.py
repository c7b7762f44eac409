"""The law of the closed loop is the one that the feedback clause certifies, and its paths keep what is certified.

The oracle takes nothing from the program but numbers of its JSON (P and w, or that slow turns are meant; twists and
speeds): it picks the rows of rule ``nearest`` literally, minimizes D of the other rules by a linear or a conic program
of its own, and makes small steps.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from fractions import Fraction
from itertools import product
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.fields import feedback_laws
from nonsmooth.proofs.clauses.feedback.by_rows import FeedbackResult
from nonsmooth.proofs.theorem4 import check_cells
from nonsmooth.reports.checks.subject import Invocation
from nonsmooth.reports.derivations.derivation import derive_report
from nonsmooth.reports.output.document import Figure, Math, Paragraph, Section, Text
from nonsmooth.symbolic.files.scene_file import load_scene
from tests.conftest import Arrays
from tests.oracles.floats import Floats
from tests.oracles.wheels_in_floats import Contacts, J, NearestRows, Rate, followed, pose_rate
from tests.reports.conftest import Invoke
from tests.reports.derived import derived
from tests.thorough import few, keep, thorough

Record: TypeAlias = dict[str, Any]

GRADIENT = (
    "four-wheel", "rectangle", "ring-3", "ring-5", "ring-6", "ring-8", "grid-4x4", "elliptic", "spiral-30", "outward",
)  # fmt: skip
SLOW = {"conveyor-3": (0.006, 0.1), "saddle": (0.05, 0.2)}  # size of the starts in (x, y) and in theta
MOVED = """
name = "moved"
friction = {{ mu_roll = 1, mu_side = "1/2" }}
check = {{ equilibrium = [{x}, {y}], radius = "1/2" }}
"""


def literal_rows(source: str, rule: str = "nearest") -> NearestRows:
    """Of a scene's wheels in floats, c measured from the checked point."""
    return NearestRows(Contacts.of(load_scene(source, rule=rule).recentred()))


def gradient_rate(rows: NearestRows, shape: Floats, weight: float) -> Rate:
    """``u = -(a, b)`` as the clause's text writes it, gain one."""
    array = rows.contacts

    def rate(pose: Floats) -> Floats:
        c, theta = pose[:2], pose[2]
        first, _, second = rows.at(c)
        i, j = first.wheel, second.wheel
        assert second.is_roll
        di, dj, pi, pj = array.rims[i], array.rims[j], array.positions[i], array.positions[j]
        slope = shape @ c
        b = (weight * theta - slope @ (J @ (pi - c))) / (dj @ (J @ (pj - pi)))
        a = slope @ di - (di @ dj) * b
        wanted = {i: -a, j: -b}
        return rows.rate(c, lambda own: wanted[own.wheel])

    return rate


def slow_rate(rows: NearestRows, length: float) -> Rate:
    """The law of slow turns as the clause's text writes it, gain one."""

    def rate(pose: Floats) -> Floats:
        c, theta = pose[:2], pose[2]
        nearest = rows.contacts.positions[rows.at(c)[0].wheel]
        p = nearest / np.linalg.norm(nearest)
        r, s = c @ p, c @ (J @ p)
        omega = s / length - (theta - s * s / (2 * r * length))
        wanted = np.array([*((1 - omega) * r * (J @ p)), omega])
        return rows.rate(c, lambda own: own.row @ wanted)

    return rate


def radius_of(name: str) -> float:
    return float(load_scene(name).check.radius)


def certified_rate(name: str, record: Record) -> tuple[Rate, float]:
    """The rate of the certified law of rule ``nearest``, and a time in which the body comes most of the way home."""
    rows = literal_rows(name)
    if record["cascade"] is not None:
        return slow_rate(rows, radius_of(name)), 200.0
    shape, weight = np.array(record["lyapunov"]["P"]), record["lyapunov"]["w"]
    return gradient_rate(rows, shape, weight), min(5 / record["rate"], 60.0)


def small_starts(region: float) -> list[Floats]:
    """Within a distance of the equilibrium, on different sides, headings of both signs."""
    sides = [(0.9, 0.3, 0.3), (-0.4, 0.8, -0.4), (-0.7, -0.6, 0.4), (0.2, -0.95, -0.2)]
    return [region * np.array(side) for side in sides]


# ---- the certified law brings the body home, by an integrator of its own -------------------------


@few(1)
@pytest.mark.parametrize("number", keep(1, [1, 2]))
@pytest.mark.parametrize("name", keep(2, [*GRADIENT, *SLOW]))
def test_small_starts_come_home_under_the_certified_law(invoke: Invoke, name: str, number: int) -> None:
    """The clause's law by its text and the literal rule; the product's default path tells the same."""
    record = invoke("check", name, "--rule", "nearest", "--json").record["feedback"]
    rate, until = certified_rate(name, record)
    place, heading = SLOW.get(name, (0.4 * record["region"]["level"] ** 0.5,) * 2)
    for side in small_starts(1.0)[:number]:
        start = side * (place, place, heading)
        path = followed(rate, start, until, until / 2000)
        sizes = np.linalg.norm(path, axis=1)
        assert sizes[-1] < 0.45 * sizes[0], (start, sizes[-1])
        assert np.abs(np.array(path)[:, :2]).max() < radius_of(name)
        shown = invoke("simulate", name, "--rule", "nearest", "--from", typed(start), "--feedback", "--until",
                       f"{until:.6g}", "--json").record  # fmt: skip
        assert shown["law"]["certified"] is True
        assert shown["law"]["starts_inside"] is True
        assert shown["end"]["reason"] != "the body leaves the checked domain"
        assert np.linalg.norm(shown["end"]["state"]) < 0.5 * sizes[0]


@few(1)
@pytest.mark.parametrize("name", ["four-wheel", "ring-5", "outward", "conveyor-3", "saddle"])
def test_the_first_steps_are_those_of_the_certified_law(invoke: Invoke, name: str) -> None:
    """Position and heading after a short time, by small steps of the literal rule."""
    record = invoke("check", name, "--rule", "nearest", "--json").record["feedback"]
    rate, _ = certified_rate(name, record)
    for start in small_starts(0.05):
        path = followed(rate, start, 0.05, 1e-4)
        shown = invoke("simulate", name, "--from", typed(start), "--feedback", "--until", "0.05", "--json").record
        assert np.abs(path[-1] - np.array(shown["end"]["state"])).max() < 1e-5


def typed(start: Floats) -> str:
    return ",".join(repr(float(value)) for value in start)


# ---- the certified rate holds wherever the answer says so ----------------------------------------

FIFTH = """
friction = { mu_roll = 1, mu_side = "1/2" }
check = { radius = "3/4", length = 1 }
wheel = [
    { position = [1, 0], heading = "inward" },
    { position = [0, 1], heading = "inward" },
    { position = [-1, 0], heading = "inward" },
    { position = [0, -1], heading = "inward" },
    { position = ["3/4", "3/4"], heading = "275 deg" },
]
"""


def test_errors_fall_at_the_certified_rate_from_wherever_it_is_said_to_hold(invoke: Invoke, tmp_path: Path) -> None:
    """The fifth wheel is the nearest away from the point alone: there V falls too, and more slowly."""
    file = tmp_path / "fifth.toml"
    file.write_text(FIFTH, encoding="utf-8")
    record = invoke("check", str(file), "--json").record
    said, feedback = record["answers"]["pose"], record["feedback"]
    shape, weight = np.array(feedback["lyapunov"]["P"]), feedback["lyapunov"]["w"]
    stated, whole = (float(found) for found in re.findall(r"below (\d\.\d+)", said["reason"]))
    assert whole**2 == pytest.approx(feedback["region"]["level"], rel=1e-3)
    rate = gradient_rate(literal_rows(str(file)), shape, weight)

    def slowest(error: float) -> float:
        """The least ``-V'/(2 V)`` on the level of an error, over directions of the pose."""
        found = []
        for pose in np.random.default_rng(1).normal(size=(2000, 3)):
            scaled = pose * error / np.sqrt(pose[:2] @ shape @ pose[:2] + weight * pose[2] ** 2)
            slope = np.array([*(shape @ scaled[:2]), weight * scaled[2]])
            found.append(-slope @ rate(scaled) / error**2)
        return float(min(found))

    assert slowest(0.99 * stated) >= said["rate"]
    assert 0 < slowest(0.99 * whole) < said["rate"]


# ---- one law under one name ----------------------------------------------------------------------


@few(1)
@pytest.mark.parametrize(
    ("name", "law"), keep(2, [("outward", "gradient"), ("conveyor-3", "cascade"), ("saddle", "cascade")])
)
@pytest.mark.usefixtures("without_paths", "without_other_rules")
def test_terminal_json_and_report_name_the_same_law(invoke: Invoke, tmp_path: Path, name: str, law: str) -> None:
    clause = invoke("check", name, "--json").record["feedback"]
    start = ("simulate", name, "--from", "0.01,0.005,0.01", "--feedback", "--until", "1")
    record = invoke(*start, "--json").record
    assert record["feedback"] == record["law"]["name"] == law
    assert record["law"]["formula"] == clause["law"]
    assert record["law"]["region"] == clause["region"]["text"]
    text = " ".join(invoke(*start).out.split())
    assert f"{law} law, certified by the feedback clause" in text
    assert clause["law"] in text
    report = derive_report(load_scene(name), Invocation(name), ("feedback", "trajectories")).document.sections
    feedback, loop = (plain_text(find(report, title)) for title in ("Feedback law", "With feedback"))
    assert f"certifies the {law} law" in feedback
    assert f"Under the {law} law, certified by the feedback clause" in loop
    assert "corrected" not in loop + feedback
    for kept in ("svg", "json"):
        invoke(*start, "-o", str(tmp_path / f"path.{kept}"))
    assert json.loads((tmp_path / "path.json").read_text(encoding="utf-8"))["law"]["name"] == law


def test_a_law_by_name_is_labelled(invoke: Invoke) -> None:
    """The certified law under its own name is certified; others are not, whatever the array."""
    for name, law, certified in (
        ("four-wheel", "gradient", True),
        ("four-wheel", "corrected", False),
        ("four-wheel", "printed", False),
        ("conveyor-3", "cascade", True),
        ("conveyor-3", "gradient", False),
    ):
        common = ("simulate", name, "--from", "0.01,0.005,0.01", "--until", "0.1", "--feedback", "--law", law)
        record = invoke(*common, "--json").record["law"]
        assert (record["name"], record["certified"]) == (law, certified)
        assert ("not certified" in " ".join(invoke(*common).out.split())) == (not certified)


@thorough
def test_only_the_papers_array_is_compared_with_its_figures() -> None:
    for name, its_own in (("four-wheel", True), ("outward", False)):
        report = derived(name).document.sections
        captions = [plain(block.caption) for section in whole(report) for block in section.blocks
                    if isinstance(block, Figure)]  # fmt: skip
        assert any(re.search(r"Figure \d", caption) for caption in captions) == its_own


@thorough
def test_a_side_row_away_from_the_point_does_not_stop_the_certified_law(arrays: Arrays) -> None:
    """Another cell of the square leaves one input; the law is certified by the cells at the point."""
    scene = arrays.cocircular(181, (1, Fraction(1, 2))).recentred()
    report = derive_report(scene, Invocation("test"), ("trajectories",))
    assert report.result.feedback.law is not None
    loop = find(report.document.sections, "With feedback")
    assert "certified by the feedback clause" in plain_text(loop)


# ---- the checked point is the origin of the law --------------------------------------------------


@few(2)
@pytest.mark.parametrize("law", [(), ("--law", "corrected"), ("--law", "gradient")])
@pytest.mark.parametrize("kinematics", ["exact", "leading"])
def test_away_from_the_worlds_origin_the_body_comes_home_too(
    invoke: Invoke, tmp_path: Path, law: tuple[str, ...], kinematics: str
) -> None:
    """The same array about (5, 3) and about (0, 0): the same path, moved."""
    ends = []
    for x, y in ((0, 0), (5, 3)):
        wheels = "".join(
            f"[[wheel]]\nposition = [{x + p}, {y + q}]\nheading = [{-p}, {-q}]\nspeed = 1\n"
            for p, q in ((1, 1), (-1, 1), (-1, -1), (1, -1))
        )
        file = tmp_path / "moved.toml"
        file.write_text(MOVED.format(x=x, y=y) + wheels, encoding="utf-8")
        options = ("--feedback", *law, "--kinematics", kinematics, "--until", "6", "--json")
        record = invoke("simulate", str(file), "--from", f"{x + 0.25},{y + 0.125},0.25", *options).record
        ends.append(np.array(record["end"]["state"]) - (x, y, 0))
    assert np.abs(ends[1] - ends[0]).max() < 1e-6
    assert np.linalg.norm(ends[1]) < 0.05


# ---- a verdict and a path that contradict each other are never printed together ------------------


@pytest.fixture
def pushing(monkeypatch: pytest.MonkeyPatch) -> None:
    """The certified law with all signs turned: what a wrong certificate would look like."""
    own = feedback_laws.gradient_law

    def turned(gain: float, *rest: Any) -> Any:
        return own(-gain, *rest)

    monkeypatch.setattr("nonsmooth.reports.laws.feedback_loop.gradient_law", turned)


@pytest.mark.usefixtures("pushing")
def test_a_path_that_contradicts_its_certificate_decides_nothing(invoke: Invoke) -> None:
    outcome = invoke("simulate", "four-wheel", "--from", "0.1,0.05,0.1", "--feedback")
    assert (outcome.status, outcome.out) == (3, "")
    assert outcome.err.count("\n") == 1
    assert "feedback law and path contradict each other" in outcome.err
    assert "the feedback clause certifies that V falls under the gradient law where" in outcome.err
    assert "but the path from (0.1, 0.05, 0.1), as it was computed, leaves the checked square" in outcome.err
    with pytest.raises(RuntimeError, match="please report this"):
        derive_report(load_scene("four-wheel"), Invocation("four-wheel"), ("trajectories",))


@pytest.mark.usefixtures("pushing")
def test_a_path_from_outside_the_region_contradicts_nothing(invoke: Invoke) -> None:
    record = invoke("simulate", "four-wheel", "--from", "0.4,0.4,0.1", "--feedback", "--json").record
    assert record["law"]["starts_inside"] is False
    assert record["end"]["reason"] == "the body leaves the checked domain"


# ---- the other rules -----------------------------------------------------------------------------


def box_minimizer(array: Contacts, c: Floats, speeds: Floats) -> Floats:
    """``sum N (mu_R |r| + mu_S |s|)`` as a linear program."""
    return array._replace(speeds=speeds).box(list(range(len(speeds))), c)


def ellipse_minimizer(array: Contacts, c: Floats, speeds: Floats) -> Floats:
    """``sum N sqrt(mu_R^2 r^2 + mu_S^2 s^2)`` by least squares, reweighted until the twist stands still."""
    size = float(np.abs(speeds).max())
    loads_of_wheels = array.loads(list(range(len(speeds))), c)
    carrying, loads = list(loads_of_wheels), np.array(list(loads_of_wheels.values()))
    rows, targets = array._replace(speeds=speeds).rows(carrying)
    scale = array.friction[carrying].ravel()
    twist: Floats = np.zeros(3)
    for _ in range(400):
        slips = (scale * (rows @ twist - targets)).reshape(-1, 2)
        own = np.sqrt((slips**2).sum(axis=1) + (1e-7 * size) ** 2)
        weights = np.repeat(loads / own, 2) * scale**2
        normal, right = rows.T @ (weights[:, None] * rows), rows.T @ (weights * targets)
        before, twist = twist, np.asarray(np.linalg.solve(normal, right), float)
        if np.abs(twist - before).max() < 1e-9 * size:
            break
    return twist


def imposed_rate(array: Contacts, cones: list[Record], minimizer: Callable[[Contacts, Floats, Floats], Floats]) -> Rate:
    """The law of the clause: of the cone's three twists the one of largest ``|g . xi_l|``, by its speeds."""

    def holds(cone: Record, c: Floats) -> bool:
        if cone["from"] is None:
            return True
        first, last = J @ np.array(cone["from"]), J @ np.array(cone["to"])
        return bool(first @ c >= 0 >= last @ c)

    def rate(pose: Floats) -> Floats:
        c = pose[:2]
        twists = next(cone for cone in cones if holds(cone, c))["twists"]
        products = [float(pose @ np.array(entry["twist"])) for entry in twists]
        best = int(np.argmax(np.abs(products)))
        if abs(products[best]) < 1e-12:
            return np.zeros(3)
        return pose_rate(minimizer(array, c, -products[best] * np.array(twists[best]["speeds"])), c)

    return rate


@few(1)
@pytest.mark.parametrize(
    ("name", "rule"),
    keep(4, product(("four-wheel", "conveyor-3", "outward", "saddle", "ring-6", "off-center"), ("box", "ellipse"))),
)
@pytest.mark.parametrize("count", keep(1, [1, 2]))
def test_small_starts_come_home_under_the_other_rules(invoke: Invoke, name: str, rule: str, count: int) -> None:
    record = invoke("check", name, "--rule", rule, "--json").record["feedback"]
    assert record["verdict"] == "stabilizable"
    minimizer = box_minimizer if rule == "box" else ellipse_minimizer
    rate = imposed_rate(literal_rows(name, rule).contacts, record["cones"], minimizer)
    reach = record["rate_reach"] or 0.02
    for start in small_starts(0.2 * reach)[:count]:
        until = min(4 / record["rate"], 30.0)
        path = followed(rate, start, until, until / 60)
        assert np.linalg.norm(path[-1]) < 0.3 * np.linalg.norm(start), (start, path[-1])


# ---- helpers -------------------------------------------------------------------------------------


def whole(sections: tuple[Section, ...]) -> list[Section]:
    return [part for section in sections for part in (section, *whole(section.subsections))]


def find(sections: tuple[Section, ...], title: str) -> Section:
    return next(section for section in whole(sections) if section.title == title)


def plain(text: Text) -> str:
    parts = (p if isinstance(p, str) else p.plain if isinstance(p, Math) else p.text for p in text)
    return "".join(parts)


def plain_text(section: Section) -> str:
    texts = [block.text for block in section.blocks if isinstance(block, Paragraph)]
    captions = [block.caption for block in section.blocks if isinstance(block, Figure)]
    return " ".join(plain(text) for text in (*texts, *captions))


FAR_WHEEL = """
name = "far wheel"
friction = { mu_roll = 1, mu_side = "1/2" }
check = { radius = "0.2" }
wheel = [
    { position = [0.29, 0.09], heading = "30 deg" },
    { position = [0.01, 0.3], heading = "150 deg" },
    { position = [-0.3, 0.01], heading = "90 deg" },
    { position = [0.01, -0.3], heading = "0 deg" },
]
"""


def test_the_law_goes_on_where_a_wheel_is_nearest_that_is_not_at_the_point(tmp_path: Path) -> None:
    file = tmp_path / "far.toml"
    file.write_text(FAR_WHEEL, encoding="utf-8")
    scene = load_scene(str(file))
    feedback = check_cells(scene).feedback
    assert isinstance(feedback, FeedbackResult)
    assert feedback.cascade is not None
    nearest = {state.rows[0].wheel.index for state in build_partition(scene).states}
    assert nearest > {wheel.index for wheel in feedback.cascade.wheels}
    array = ns.load(file)
    assert isinstance(array, ns.Array)
    path = array.simulate((0.19, 0.19, 0.1), 20.0, feedback=True)
    assert np.hypot(*path.state[-1, :2]) < 1e-6
    assert abs(path.state[-1, 2]) < 1e-6
