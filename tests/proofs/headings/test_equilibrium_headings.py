"""Headings of rest against an oracle with its own geometry, loads and minimizer: motions and chattering paths."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import TypeAlias

import numpy as np
import pytest
from flint import arb, ctx
from numpy.typing import NDArray

from nonsmooth.analysis.bodies.set_motion import SetGuesses
from nonsmooth.analysis.cells.contact_rule import smooth_rule_of
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseMinimizer, minima_under
from nonsmooth.proofs.answers.answer import Heading, Position
from nonsmooth.proofs.answers.heading import HeadingKind, HeadingsOfRest, headings_of_rest
from nonsmooth.proofs.headings.stay import set_motion
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.contact_set import whole
from nonsmooth.symbolic.mechanics.scene import Scene
from tests.oracles.floats import Floats
from tests.oracles.wheels_in_floats import Contacts, pose_rate
from tests.thorough import few, keep, thorough

Field: TypeAlias = tuple[str, str]

HEADINGS = 181  # looked at around; none of them brings a wheel to the edge
STAYS = 1e-7  # speed of a centre of mass that stays
STEP = 1e-3  # of a chattering path
ARRIVED = 2 * STEP  # such a path ends this close to rest; it starts at ten times that

SWIRL = "-x - 8/7*y + x*x*y/4", "-x - y/2 - y*y*x/28 - 3/28*x*x*x"
FAST = "-x - 6/7*y + 3/14*x*x*y", "-9/7*x - 2*y + 3/28*y*y*x + 1/14*x*x*x"
SKEW = "-x + y/3", "-2*y - x/5"


def scene_of(folder: Path, field: Field, size: tuple[str, str], columns: int, side: str, at: str = "[0, 0]") -> Scene:
    """A rectangle on 4 rows of wheels."""
    file = folder / "body.toml"
    file.write_text(
        f'[grid]\nrows = 4\ncolumns = {columns}\n[field]\nkind = "expression"\nx = "{field[0]}"\ny = "{field[1]}"\n'
        f'[body]\nshape = "rectangle"\nwidth = "{size[0]}"\nheight = "{size[1]}"\n'
        f'[friction]\nmu_roll = 1\nmu_side = "{side}"\n[contact]\nrule = "ellipse"\n'
        f"[check]\nradius = 0.1\nlength = 1\nequilibrium = {at}\n"
    )
    return load_scene(file)


def swirl(folder: Path) -> Scene:
    return scene_of(folder, SWIRL, ("21/10", "17/10"), 5, "1")


def fast(folder: Path) -> Scene:
    return scene_of(folder, FAST, ("3", "2"), 4, "1/5")


def found_at_point(scene: Scene) -> HeadingsOfRest:
    found = headings_of_rest(scene)
    assert found is not None
    return found


# ---- the oracle ----------------------------------------------------------------------------------


@dataclass
class Oracle:
    """A rectangle on wheels."""

    scene: Scene
    half: tuple[float, float]

    def __post_init__(self) -> None:
        self.contacts = Contacts.of(self.scene)

    def under(self, pose: Floats) -> NDArray[np.bool_]:
        c, s = math.cos(pose[2]), math.sin(pose[2])
        away = self.contacts.positions - pose[:2]
        across, along = away @ [c, s], away @ [-s, c]
        return np.asarray((np.abs(across) < self.half[0]) & (np.abs(along) < self.half[1]))

    def rate(self, under: NDArray[np.bool_], centre: Floats) -> Floats | None:
        """``(c', theta')``; None where the body tips."""
        pressed = np.flatnonzero(under)
        while len(pressed) >= 3:
            moments = np.vstack([np.ones(len(pressed)), self.contacts.positions[pressed].T])
            loads, _, rank, _ = np.linalg.lstsq(moments, np.array([1.0, *centre]), rcond=None)
            if rank < 3:
                return None
            if loads.min() >= 0:
                model = self.contacts.model(pressed.tolist())
                return pose_rate(EllipseMinimizer().minimize(model, loads[None]).twists[0], centre)
            pressed = np.delete(pressed, int(np.argmin(loads)))
        return None

    def chatter(self, start: Floats, until: float) -> Floats:
        """Euler's steps: the mean of the last ones."""
        pose, poses = start.copy(), []
        for _ in range(round(until / STEP)):
            rate = self.rate(self.under(pose), pose[:2])
            assert rate is not None
            pose = pose + STEP * rate
            poses.append(pose)
        return np.asarray(np.mean(poses[-20:], axis=0))


def inside(entry_low: float, entry_high: float, theta: float) -> bool:
    return (theta - entry_low) % (2 * math.pi) < entry_high - entry_low


# ---- at the checked point ------------------------------------------------------------------------


@few(2)
@pytest.mark.parametrize(
    ("field", "size", "columns", "side", "at"),
    [
        (SWIRL, ("21/10", "17/10"), 5, "1", "[0, 0]"),
        (FAST, ("3", "2"), 4, "1/5", "[0, 0]"),
        (SKEW, ("13/5", "8/5"), 5, "1/2", "[0, 0]"),
        (SKEW, ("13/5", "8/5"), 5, "1/2", '["1/20", "1/30"]'),
        (("-x", "-y"), ("13/5", "8/5"), 4, "1/2", "[0, 0]"),
        (("-x + 1/3", "-y + 1/5"), ("13/5", "8/5"), 5, "1/2", "[0, 0]"),
    ],
)
def test_a_grid_of_headings_finds_what_is_listed_and_no_more(
    field: Field, size: tuple[str, str], columns: int, side: str, at: str, tmp_path: Path
) -> None:
    scene = scene_of(tmp_path, field, size, columns, side, at)
    found = found_at_point(scene)
    ranges = [
        (entry, float(entry.low), float(entry.high))
        for entry in found.found
        if entry.low is not None and entry.high is not None
    ]
    singles = [entry for entry in found.found if entry.kind is HeadingKind.ISOLATED]
    assert all(one.edge for one in found.undecided)  # no range of headings is left open here
    oracle = Oracle(scene, (float(eval_fraction(size[0])) / 2, float(eval_fraction(size[1])) / 2))
    centre = np.array([float(x) for x in scene.check.equilibrium])
    rates: dict[bytes, Floats | None] = {}
    turning: list[tuple[float, float]] = []
    for theta in np.linspace(-math.pi, math.pi, HEADINGS, endpoint=False) + 0.00131:
        under = oracle.under(np.array([*centre, theta]))
        if under.tobytes() not in rates:
            rates[under.tobytes()] = oracle.rate(under, centre)
        rate = rates[under.tobytes()]
        listed = [entry for entry, low, high in ranges if inside(low, high, float(theta))]
        stays = rate is not None and float(np.abs(rate[:2]).max()) <= STAYS
        assert len(listed) == stays, theta
        if rate is not None and stays:
            assert listed[0].rests == (abs(rate[2]) <= STAYS)
            assert listed[0].wheels == tuple(scene.wheels[k].index for k in np.flatnonzero(under))
            turning.append((float(theta), float(rate[2])))
    crossings = [
        (low, high)
        for (low, before), (high, after) in pairwise(turning)
        if before * after < -(STAYS**2) and high - low < 0.1
    ]
    opened = [float(one.low) for one in found.undecided]
    for low, high in crossings:
        inner = [entry.heading or 0.0 for entry in singles if inside(low, high, entry.heading or 0.0)]
        assert inner or any(inside(low, high, theta) for theta in opened)
    counted = sum(any(inside(low, high, one.heading or 0.0) for low, high in crossings) for one in singles)
    assert counted == len([one for one in singles if abs(one.heading or 0.0) < math.pi - 0.05])


def eval_fraction(text: str) -> float:
    above, _, below = text.partition("/")
    return int(above) / int(below or 1)


@pytest.fixture(scope="module")
def turning(tmp_path_factory: pytest.TempPathFactory) -> tuple[Scene, HeadingsOfRest]:
    """A body with single headings of rest, and what is found of it."""
    scene = fast(tmp_path_factory.mktemp("fast"))
    return scene, found_at_point(scene)


def test_what_a_single_heading_does_is_left_open(turning: tuple[Scene, HeadingsOfRest]) -> None:
    """Turns that meet are reported, and claimed of nothing."""
    single = [entry for entry in turning[1].found if entry.kind is HeadingKind.ISOLATED]
    assert (8, 9) in [entry.edge for entry in single]
    assert not any(entry.proved or entry.attracts for entry in single)
    assert {(entry.position, entry.verdict) for entry in single} == {(Position.UNDECIDED, Heading.UNDECIDED)}
    assert {entry.reason.split(";")[0] for entry in single} == {
        "the body turns to it from both sides",
        "the body turns away from it on both sides",
    }


def test_the_body_turns_to_a_heading_or_away_as_is_said(turning: tuple[Scene, HeadingsOfRest]) -> None:
    scene, found = turning
    oracle = Oracle(scene, (1.5, 1.0))
    for entry in found.found:
        if entry.kind is HeadingKind.ISOLATED and entry.heading is not None:
            rates = [oracle.rate(oracle.under(np.array([0, 0, entry.heading + d])), np.zeros(2)) for d in (-1e-6, 1e-6)]
            assert rates[0] is not None
            assert rates[1] is not None
            sense = 1 if entry.reason.startswith("the body turns to it") else -1
            assert sense * rates[0][2] > 0 > sense * rates[1][2]


@few(1)
@pytest.mark.parametrize("rule", keep(2, ["nearest", "ellipse", "box", "roller"]))
def test_nothing_rests_on_a_conveying_bed_under_any_rule(rule: str) -> None:
    found = found_at_point(load_scene("roller-bed", rule=rule))
    assert not found.found
    assert not found.undecided


def test_what_is_not_decided_is_named(tmp_path: Path) -> None:
    found = found_at_point(swirl(tmp_path))
    assert found.undecided
    assert all(one.edge and one.reason for one in found.undecided)


# ---- around the point ----------------------------------------------------------------------------


@thorough  # the small one: test_a_grid_of_headings_finds_what_is_listed_and_no_more
def test_the_search_finds_a_pose_that_paths_come_back_to(tmp_path: Path) -> None:
    found = headings_of_rest(fast(tmp_path), around=True)
    assert found is not None
    pose = (0.0759428, -0.111969, 2.1382672)
    listed = [(*map(float, entry.at), entry.heading) for entry in found.found if len(entry.edge) == 1]
    assert any(one == pytest.approx(pose, abs=1e-6) for one in listed)
    last = Oracle(whole(fast(tmp_path)), (1.5, 1.0)).chatter(pose + np.array([0.02, -0.01, 0.02]), 0.4)
    assert np.abs(last - pose).max() < ARRIVED


@thorough  # the small one: test_a_grid_of_headings_finds_what_is_listed_and_no_more
def test_the_search_finds_the_mirror_images_of_what_it_finds(tmp_path: Path) -> None:
    """A half turn takes this scene into itself, and so its poses of rest."""
    found = headings_of_rest(swirl(tmp_path), around=True)
    assert found is not None
    assert found.reach == pytest.approx(1)
    single = [entry for entry in found.found if entry.kind is HeadingKind.ISOLATED and len(entry.edge) == 1]
    assert len(single) >= 20
    assert not any(entry.proved for entry in single)
    poses = np.array([[*map(float, entry.at), entry.heading or 0.0] for entry in single])
    for x, y, theta in poses:
        turns = np.angle(np.exp(1j * (poses[:, 2] - theta)))
        assert (np.abs(poses - [-x, -y, theta])[:, :2].max(axis=1) + np.abs(turns) < 1e-4).any()


def test_balls_hold_the_motion_on_wheels_with_friction_axes(tmp_path: Path) -> None:
    text = (Path(__file__).parents[3] / "symbolic" / "scenes" / "roller-bed.toml").read_text(encoding="utf-8")
    file = tmp_path / "bed.toml"
    file.write_text(text.replace('x = "1"', 'x = "1 + y/3"').replace('y = "0"', 'y = "x/4"'))
    scene = whole(load_scene(file, rule="ellipse"))
    rule = smooth_rule_of(scene)
    wheels = [10, 11, 12, 18, 19, 20]
    part = replace(scene, wheels=tuple(scene.wheels[k] for k in wheels), body=None)
    centre = (float(part.wheels[1].position[0]) + 0.03, 0.04)
    with ctx.workprec(256):
        motion = set_motion(scene, SetGuesses(scene, rule), wheels, (arb(centre[0]), arb(centre[1])))
    assert motion is not None
    expected = minima_under(rule, part, np.array([centre])).twists[0]
    np.testing.assert_allclose([float(entry) for entry in motion.twist], expected, atol=1e-8)
    assert max(float(entry.rad()) for entry in motion.twist) < 1e-30
