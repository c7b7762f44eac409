"""Places of rest that are known within rounding: enclosed, judged, and the twist around them."""

from __future__ import annotations

import json
import math
import random
from dataclasses import replace
from fractions import Fraction
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import mpmath
import numpy as np
import pytest
from flint import arb, arb_mat

import nonsmooth as ns
from nonsmooth.analysis.cells.contact_rule import smooth_rule_of
from nonsmooth.analysis.minimizers.ellipse_minimizer import minima_under
from nonsmooth.proofs.answers.answers import answers_of
from nonsmooth.proofs.answers.destinations import best_point
from nonsmooth.proofs.boxes.balanced_forces import BalancedForces
from nonsmooth.proofs.boxes.enclosed_rest import EnclosedRest, enclosed_rest
from nonsmooth.proofs.boxes.intervals import Intervals
from nonsmooth.proofs.findings import Translation
from nonsmooth.proofs.robust import touching_rings
from nonsmooth.proofs.robust.ends import COARSE, velocity_of
from nonsmooth.proofs.robust.level_sets import (
    Distance,
    LevelFunction,
    RingPieces,
    SectorFunction,
    shapes_about,
    short_levels,
)
from nonsmooth.proofs.robust.rest_points import (
    DISCS,
    _affine_twists,
    _rising,
    affine_rates,
    attracting_disc,
    is_carried_away,
    refined_rates,
)
from nonsmooth.proofs.robust.touching_rings import FINER, FINEST, FIRST_PIECES, least_rate, piece_rates
from nonsmooth.proofs.theorem4 import SmoothCheck, check_smooth
from nonsmooth.reports.cli import app
from nonsmooth.reports.output.console import run
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.edge_headings import ball_of
from nonsmooth.symbolic.mechanics.friction_set import CutEllipse
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.plane_arrays import field_beside
from nonsmooth.symbolic.numbers.rounded import certain_sign, enclosed, plain, rounded
from tests.oracles.measured_tables import MeasuredTable, SmallSteps
from tests.proofs.forged import with_results
from tests.thorough import few, keep, thorough

# ---- Clauses 1 to 3 at a place of rest that is the point within rounding, against forces in forty digits.
#
# The oracle knows nothing of boxes: it takes the headings as they are stated, or moved by less than they were
# rounded, finds the place where forces balance by Newton's method, and differentiates the motion beside it.

DIGITS = 40
AWAY = Fraction(1, 10**6)  # another member of a box of numbers
HELD = 1e-4  # of the fastest rim: a slip that is taken to be zero, where norms are rounded by a hundredth of that
MOVED = 9e-16  # by which sines and cosines may have been rounded


class Forces:
    """Force and moment on a body, in the words of the rule, at headings that may be moved.

    Wheels that small steps show to be held, along their rim or across it too, keep these slips at zero by forces that
    are unknown: ``unknowns`` are the twist and then these.
    """

    def __init__(self, table: MeasuredTable, moved: float, seed: int) -> None:
        draw, self.table = random.Random(seed), table
        self.wheels = []
        for x, y, degrees, speed in table.rows:
            angle = mpmath.radians(degrees) + mpmath.mpf(draw.uniform(-moved, moved))
            self.wheels.append((x, y, mpmath.cos(angle), mpmath.sin(angle), mpmath.mpf(str(speed))))
        moments = mpmath.matrix([[1, x, y] for x, y, *_ in self.wheels])
        self.springs = moments * (moments.T * moments) ** -1
        body = SmallSteps(table)
        (slow,) = body.twists(np.zeros((1, 2)))
        slips = np.abs(np.stack([body.along @ slow - body.speeds, body.across @ slow])) < HELD * body.speeds.max()
        self.held = [(bool(along), bool(along and across)) for along, across in slips.T]

    def balance(self, place: Any, unknowns: Any) -> list[Any]:
        """The gradient of D in the twist (v, omega) about the origin, and the slips that are held."""
        a, b = (mpmath.mpf(str(mu)) for mu in (self.table.roll, self.table.side))
        loads, total = self.springs * mpmath.matrix([1, *place]), [mpmath.mpf(0)] * 3
        twist, forces, slips = unknowns[:3], list(unknowns[3:]), []
        self.are_held: list[bool] = []
        for (x, y, dx, dy, speed), load, (along, across) in zip(self.wheels, loads, self.held, strict=True):
            ux, uy = twist[0] - twist[2] * y, twist[1] + twist[2] * x
            r, s = dx * ux + dy * uy - speed, dx * uy - dy * ux
            slips += [r] * along + [s] * across
            if along:
                f = forces.pop(0)
                g = forces.pop(0) if across else b * mpmath.sign(s)
                self.are_held.append(self.holds(f, g, across=across))
            elif self.table.rule == "ellipse":
                size = mpmath.sqrt((a * r) ** 2 + (b * s) ** 2)
                f, g = a * a * r / size, b * b * s / size
            elif abs(s) * mpmath.sqrt(a * a - b * b) <= b * abs(r):
                f, g = a * r / mpmath.hypot(r, s), a * s / mpmath.hypot(r, s)
            else:
                f, g = mpmath.sqrt(a * a - b * b) * mpmath.sign(r), b * mpmath.sign(s)
            px, py = load * (f * dx - g * dy), load * (f * dy + g * dx)
            total = [total[0] + px, total[1] + py, total[2] + x * py - y * px]
        return total + slips

    def holds(self, f: Any, g: Any, *, across: bool) -> bool:
        """Whether a wheel can carry forces along and across its rim, in its friction set; on a straight side of it."""
        a, b = self.table.roll, self.table.side
        if self.table.rule == "ellipse":
            return bool((f / a) ** 2 + (g / b) ** 2 < 1)
        return bool(f * f + g * g < a * a and (abs(g) < b or not across))

    def rest(self, near: tuple[float, float], spin: float) -> tuple[Any, ...]:
        """Where a body rests, how fast it turns there, and the forces of wheels that are held."""

        def equations(x: Any, y: Any, omega: Any, *forces: Any) -> list[Any]:
            return self.balance((x, y), (omega * y, -omega * x, omega, *forces))

        start = *near, spin, *[0.0] * int(np.sum(self.held))
        unknowns = tuple(mpmath.findroot(equations, start, tol=1e-60, maxsteps=60))
        equations(*unknowns)
        assert all(self.are_held)
        return unknowns

    def slope(self, rest: tuple[Any, ...]) -> Any:
        """Of c' by c, by differences."""
        x, y, omega, *forces = rest
        step, columns = mpmath.mpf(10) ** -15, []
        for dx, dy in ((step, 0), (0, step)):
            sides = []
            for sign in (1, -1):
                place = x + sign * dx, y + sign * dy
                start = omega * y, -omega * x, omega, *forces
                v = mpmath.findroot(lambda *each, at=place: self.balance(at, each), start, tol=1e-60, maxsteps=60)
                sides.append((v[0] - v[2] * place[1], v[1] + v[2] * place[0]))
            columns.append([(p - q) / (2 * step) for p, q in zip(*sides, strict=True)])
        return mpmath.matrix(columns).T


@cache
def checked(table: MeasuredTable, *, at_best: bool) -> SmoothCheck:
    """The clauses at the point of a table, or at the place to which most of a few bodies come."""
    with TemporaryDirectory() as folder:
        file = Path(folder) / "table.toml"
        file.write_text(table.toml, encoding="utf-8")
        scene = load_scene(str(file))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("nonsmooth.proofs.answers.destinations.FEW_STARTS", 3)
        return check_smooth(best_point(scene).scene if at_best else scene)


def rest_of(check: SmoothCheck) -> EnclosedRest:
    rest = check.equilibrium.point.rest
    assert rest is not None
    return rest


def confirm(table: MeasuredTable, check: SmoothCheck) -> None:
    """What the clauses say is so of the stated table, and of tables within its rounding."""
    rest, at = rest_of(check), check.scene.check.equilibrium
    point = [mpmath.mpf(plain(entry).accurate_ball(200).mid().str(50, radius=False)) for entry in at]
    for seed, moved in ((0, 0.0), (1, MOVED), (2, MOVED)):
        forces = Forces(table, moved, seed)
        found = forces.rest((float(point[0]), float(point[1])), float(rest.spin))
        x, y, omega, *_ = found
        distance = check.equilibrium.rounding_distance
        assert distance is not None
        assert mpmath.hypot(x - point[0], y - point[1]) <= mpmath.mpf(distance.numerator) / distance.denominator
        low, high = rest.rates
        assert low <= float(omega) + 1e-13
        assert float(omega) - 1e-13 <= high
        roots, _ = mpmath.eig(forces.slope(found))
        top = max(mpmath.re(root) for root in roots)
        assert float(rest.spectral_abscissa) == pytest.approx(float(top), rel=1e-9, abs=1e-9)
        assert check.translation.verdict == ("asymptotically stable" if top < 0 else "unstable")
        assert check.rotation.verdict == "unstable"
        assert low * high > 0


@pytest.mark.usefixtures("without_law")
@pytest.mark.parametrize(("seed", "rule"), keep(3, [(s, r) for s in range(20) for r in ("ellipse", "roller")]))
def test_clauses_of_symmetric_tables_are_those_of_forces_in_forty_digits(seed: int, rule: str) -> None:
    table = MeasuredTable.symmetric(seed, rule)
    check = checked(table, at_best=False)
    if check.equilibrium.point.rest is None:
        assert check.equilibrium.verdict != "holds"
        return
    with mpmath.workdps(DIGITS + 40):
        confirm(table, check)


@pytest.mark.parametrize(("seed", "rule"), keep(1, [(s, r) for s in (3, 0, 7, 9) for r in ("ellipse", "roller")]))
def test_clauses_at_enclosed_points_are_those_of_forces_in_forty_digits(seed: int, rule: str) -> None:
    table = MeasuredTable.random(seed, rule, off=3.0)
    check = checked(table, at_best=True)
    assert check.equilibrium.verdict == "holds"
    assert check.verdict == "holds"
    assert "only rounding tells from the point" in check.reason
    with mpmath.workdps(DIGITS + 40):
        confirm(table, check)


def test_a_check_with_forged_balls_does_not_verify() -> None:
    check = checked(MeasuredTable.symmetric(1, "ellipse"), at_best=False)
    assert check.check()
    point, rest = check.equilibrium.point, rest_of(check)
    nearer = replace(rest, place=(rest.place[0] / 2, rest.place[1] / 2))
    faster = replace(rest, slope=rest.slope * arb(2))
    for forged in (nearer, faster, replace(rest, spin=-rest.spin)):
        assert forged != rest
        result = replace(check.equilibrium, point=replace(point, rest=forged))
        assert not with_results(check, equilibrium=result).check()
        moved = replace(check.translation, point=replace(point, rest=forged))
        assert not with_results(check, translation=moved).check()


def test_a_point_that_is_only_near_is_no_equilibrium() -> None:
    table = MeasuredTable.random(3, "ellipse", off=3.0)
    check = checked(table, at_best=True)
    x, y = check.scene.check.equilibrium
    scene = check.scene
    near = scene.checked_at((plain(x) + scene.accuracy / 10**9, plain(y)), scene.check.radius)
    assert check_smooth(near).equilibrium.verdict == "fails"


BY_ANGLE = '"53.13010235415598 deg"'
EXACT = """
[friction]
mu_roll = 5
mu_side = 1
[[wheel]]
position = ["-3/5", "-4/5"]
heading = "53.13010235415598 deg"
[[wheel]]
position = ["3/5", "4/5"]
heading = [-3, -4]
[[wheel]]
position = ["4/5", "-3/5"]
heading = [-4, 3]
[[wheel]]
position = ["-4/5", "3/5"]
heading = [4, -3]
"""


def test_wheels_that_slip_as_slowly_as_places_are_rounded_are_not_held(tmp_path: Path) -> None:
    """Six wheels with rims along a ring, in thousandths: at rest the body turns so that all slip by some hundred
    thousandths of their speed.
    """
    ring = [(1000, 0), (500, 866), (-500, 866), (-1000, 0), (-500, -866), (500, -866)]
    wheels = "".join(
        f'[[wheel]]\nposition = ["{x}/1000", "{y}/1000"]\nheading = "{90 + 60 * k} deg"\nspeed = 1\n'
        for k, (x, y) in enumerate(ring)
    )
    (tmp_path / "ring.toml").write_text(f'[friction]\nmu_roll = 1\nmu_side = "1/2"\n{wheels}')
    scene = load_scene(tmp_path / "ring.toml", rule="ellipse")
    rest, check = enclosed_rest(scene), check_smooth(scene)
    assert rest is not None
    assert (check.equilibrium.verdict, check.rotation.verdict) == ("holds", "unstable")

    def dissipation(omega: Any) -> Any:
        total = mpmath.mpf(0)
        for k, (x, y) in enumerate(ring):
            angle = mpmath.radians(90 + 60 * k)
            along = omega * (x * mpmath.sin(angle) - y * mpmath.cos(angle)) / 1000 - 1
            across = omega * (x * mpmath.cos(angle) + y * mpmath.sin(angle)) / 1000
            total += mpmath.sqrt(along**2 + across**2 / 4)
        return total

    with mpmath.workdps(40):
        spin = mpmath.findroot(lambda omega: mpmath.diff(dissipation, omega), (1, mpmath.mpf("1.00002")))
        assert all(abs(bound - spin) < 1e-12 for bound in map(float, rest.rates))
        assert 1e-6 < abs(spin - 1) < 1e-4


@pytest.mark.parametrize("skew", [60, 75, 90])
@pytest.mark.parametrize("count", [3, 5])
def test_three_rims_that_do_not_slip_turn_bodies_about_an_enclosed_place(count: int, skew: int, tmp_path: Path) -> None:
    """Of rings of rollers in thousandths, wherever the centre of mass is nearby; by an independent minimizer."""
    angles = [360 * k // count for k in range(count)]
    wheels = "".join(
        f'[[wheel]]\nposition = ["{round(1000 * math.cos(math.radians(a)))}/1000", '
        f'"{round(1000 * math.sin(math.radians(a)))}/1000"]\nheading = "{a + skew} deg"\nspeed = 1\n'
        for a in angles
    )
    (tmp_path / "ring.toml").write_text(f'[friction]\nmu_roll = 1\nmu_side = "1/2"\n{wheels}')
    scene = load_scene(tmp_path / "ring.toml", rule="roller")
    rest = enclosed_rest(scene)
    if rest is None:  # a wheel on the axis of symmetry may roll either way
        assert (count, skew) == (5, 90)
        return
    assert rest.stability is Translation.STABLE
    x, y, omega = (float(entry.mid()) for entry in (*rest.place, rest.spin))
    near = np.random.default_rng(count).uniform(-0.02, 0.02, (50, 2))
    twists = minima_under(smooth_rule_of(scene), scene, near).twists
    assert twists == pytest.approx(np.tile([omega * y, -omega * x, omega], (50, 1)), abs=1e-9)


@few(1)
@pytest.mark.parametrize("rule", ["ellipse", "roller"])
def test_whether_a_body_turns_is_undecided_where_some_members_turn_it(rule: str, tmp_path: Path) -> None:
    (tmp_path / "my.toml").write_text(EXACT)
    check = check_smooth(load_scene(tmp_path / "my.toml", rule=rule))
    assert check.equilibrium.verdict == "holds"
    assert check.rotation.verdict == "undecided"
    assert check.rotation.reason.startswith("rounding decides")
    assert check.verdict == "undecided"
    heading = {answer.name: answer for answer in answers_of(check)}["heading"]
    assert (heading.verdict, "rounding decides" in heading.sentence) == ("undecided", True)


def test_stability_that_only_some_members_have_is_undecided() -> None:
    check = checked(MeasuredTable.symmetric(1, "ellipse"), at_best=False)
    rest = rest_of(check)
    a, b, c, d = rest.slope.entries()
    wide = replace(rest, slope=type(rest.slope)([[a.union(-a), b], [c, d.union(-d)]]))
    assert wide.stability == "undecided"
    assert wide.spectral_abscissa.contains(0)
    result = replace(check.translation, point=replace(check.translation.point, rest=wide))
    assert result.reason.startswith("rounding decides")


def test_numbers_whose_given_member_is_zero_keep_their_box() -> None:
    number = rounded(NumberField().zero, AWAY)
    assert ball_of(number).rad() > 0


def test_places_whose_given_member_is_the_origin_keep_their_box() -> None:
    scene: Scene = load_scene("four-wheel", rule="ellipse")
    place = rounded(scene.field.zero, AWAY)
    there = scene.checked_at((place, place), scene.check.radius).recentred()
    assert there.wheels[0].position[0].ball().rad() > 0
    rest = enclosed_rest(there)
    assert rest is None or math.isclose(float(rest.place[0].rad()), 1e-15, rel_tol=10)


@pytest.mark.parametrize(("seed", "rule"), keep(1, [(1, "ellipse"), (3, "ellipse")]))
def test_bodies_from_the_disc_come_home_in_the_time_that_is_said(seed: int, rule: str) -> None:
    table = MeasuredTable.symmetric(seed, rule)
    check = checked(table, at_best=False)
    position = answers_of(check)[0]
    assert position.verdict == "comes home"
    within, after, body = float(position["within"]), float(position["after"]), SmallSteps(table)
    assert float(position["ends_within"]) >= float(check.equilibrium.rounding_distance or 0)
    starts = within * np.array([[math.cos(angle), math.sin(angle)] for angle in np.arange(6.0)])
    ends, _ = body.paths(starts, [after], float(check.scene.accuracy))
    assert np.hypot(*ends[0].T).max() < 1e-3 * float(check.scene.accuracy)


@pytest.mark.usefixtures("without_law")
def test_a_disc_that_attracts_falls_at_its_rate() -> None:
    table = MeasuredTable.symmetric(3, "ellipse")
    scene = checked(table, at_best=False).scene.recentred()
    rest = enclosed_rest(scene)
    assert rest is not None
    disc = attracting_disc(rest, [scene.accuracy / 64])
    assert disc is not None
    near, body = disc.radius / 16, SmallSteps(table)
    start = float(disc.radius) * np.array([[math.cos(angle), math.sin(angle)] for angle in np.arange(6.0)])
    ends, _ = body.paths(start, [float(disc.time_to(near, disc.radius))], float(near))
    assert np.hypot(*ends[0].T).max() <= float(near) * 1.01


@pytest.mark.usefixtures("without_law")
def test_no_disc_attracts_to_a_place_that_repels() -> None:
    """Forged as one that attracts."""
    scene = checked(MeasuredTable.symmetric(4, "ellipse"), at_best=False).scene.recentred()
    rest = enclosed_rest(scene)
    assert rest is not None
    assert rest.stability == "unstable"
    forged = replace(rest, slope=rest.slope - arb_mat([[100, 0], [0, 100]]))
    assert forged.stability == "asymptotically stable"
    assert attracting_disc(forged, [scene.accuracy * share for share in DISCS]) is None


# ---- Rest points without simple coordinates: enclosed, taken by ``--at auto``, and judged there.


def file_of(folder: Path, table: MeasuredTable) -> str:
    file = folder / "table.toml"
    file.write_text(table.toml, encoding="utf-8")
    return str(file)


@thorough  # test_python_takes_an_enclosed_point_too
@pytest.mark.usefixtures("without_paths", "without_other_rules")
@pytest.mark.parametrize("rule", keep(1, ["ellipse", "roller"]))
def test_a_measured_table_is_checked_where_bodies_come_to_rest(
    rule: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table = MeasuredTable.random(3, rule, off=3.0)
    status = run(app, ["check", file_of(tmp_path, table), "--at", "auto", "--require", "position", "--json"])
    found = json.loads(capsys.readouterr().out)
    position, heading = found["answers"]["position"], found["answers"]["heading"]
    assert (status, position["verdict"], heading["verdict"]) == (0, "comes home", "drifts")
    assert position["ends_within"] < 1e-11
    body, place = SmallSteps(table), np.array(position["at"])
    for angle in (1.0,):
        start = place + 15 * np.array([math.cos(angle), math.sin(angle)])
        end, _ = body.end(start, 20.0, 0.02)
        assert np.hypot(*(end - place)) < 0.03
    assert abs(body.twists(place[None])[0, 2] / body.length) == pytest.approx(heading["largest_rate"], rel=1e-3)


def test_python_takes_an_enclosed_point_too(tmp_path: Path) -> None:
    array = ns.load(file_of(tmp_path, MeasuredTable.random(1, "ellipse", off=3.0)))
    assert isinstance(array, ns.Array)
    checked = array.check(at="auto")
    assert checked.position.verdict == "comes home"
    assert checked.at == pytest.approx((1.01973, 1.64126), abs=1e-5)


def test_clauses_are_undecided_rather_than_those_of_the_number_that_stands_for_the_point() -> None:
    scene = checked(MeasuredTable.random(3, "ellipse", off=3.0), at_best=True).scene
    x, y = scene.check.equilibrium
    assert [certain_sign(entry - plain(entry)) for entry in (x, y)] == [0, 0]
    assert x.ball().rad() < 1e-11


def test_what_vanishes_at_the_number_in_the_middle_is_not_taken_for_zero() -> None:
    field = NumberField()
    ball = arb("0.123456789", 1e-13)
    x, y = enclosed(field, ball, 0.7), enclosed(field, ball, -0.6)
    assert x.ball().contains(ball)
    middle = x.exact
    for vanishing in (x - middle, x - y, x * x - 2 * x * middle + middle * middle):
        assert certain_sign(vanishing) == 0
        before = field.rounded_signs
        vanishing.sign()
        assert field.rounded_signs > before
    before = field.rounded_signs
    assert (x * y - y * x).sign() == 0
    assert (x - 1).sign() == -1
    assert field.rounded_signs == before


# ---- The twist over small polygons, to first order, and what it shows of slow spirals, against another minimizer.

LEVELS = short_levels(np.array([0.3, 0.275]), 16)  # mm: on these tables motions change fast
SHAPES = (Distance(), SectorFunction.of_ellipse(np.array([[2.0, 0.5], [0.5, 1.0]]), 64))
NEWTON = 2e-4  # of the fastest rim: what small steps round away


def measured(folder: Path, table: MeasuredTable) -> Scene:
    file = folder / "table.toml"
    file.write_text(table.toml, encoding="utf-8")
    return load_scene(str(file)).recentred()


@pytest.mark.parametrize(("seed", "rule"), [(1, "ellipse"), (2, "ellipse"), (0, "roller"), (1, "roller")])
def test_twists_are_those_of_an_independent_minimizer(seed: int, rule: str, tmp_path: Path) -> None:
    table = MeasuredTable.random(seed, rule, off=9.0)
    forces, body, rng = BalancedForces(measured(tmp_path, table)), SmallSteps(table), np.random.default_rng(seed)
    pieces = SHAPES[1].pieces(LEVELS[1:], LEVELS[:1])
    free = forces.minimizers(pieces.middles)
    found = _affine_twists(forces, pieces, free)
    assert found is not None
    middle, by_place, rest, is_enclosed = found
    assert is_enclosed.mean() > 0.5
    shares = rng.dirichlet(np.ones(4), len(pieces.corners))
    places = (shares[:, :, None] * pieces.corners).sum(axis=1)
    away, slack = places - pieces.middles, NEWTON * body.speeds.max()
    twists = body.twists(places)
    for ends, sign in (("low", 1), ("high", -1)):
        slope = getattr(by_place, ends)
        bound = getattr(middle, ends) + (slope * away[:, None]).sum(axis=2) + getattr(rest, ends)
        assert (sign * (twists - bound)[is_enclosed] >= -slack).all()
    assert (rest.high - rest.low)[is_enclosed].max() < 0.2 * np.abs(by_place.low).max() * LEVELS[0]


@pytest.mark.parametrize("shape", SHAPES)
def test_rates_bound_how_fast_small_steps_fall(shape: LevelFunction, tmp_path: Path) -> None:
    """At random places of quadrangles and of their halves, for V and for -V."""
    table = MeasuredTable.random(1, "ellipse", off=9.0)
    forces, body, rng = BalancedForces(measured(tmp_path, table)), SmallSteps(table), np.random.default_rng(0)
    for turned in (False, True):
        pieces = shape.pieces(LEVELS[1:], LEVELS[:1])
        pieces = pieces.turned if turned else pieces
        pieces = pieces.halves[0]
        free = forces.minimizers(pieces.middles)
        rates = affine_rates(forces, pieces, free)
        shares = rng.dirichlet(np.ones(4), len(rates))
        places = (shares[:, :, None] * pieces.corners).sum(axis=1)
        slopes = np.stack([(shares * slope.middle).sum(axis=1) for slope in pieces.slopes], axis=1)
        sizes = np.hypot(*places.T) if isinstance(shape, Distance) else np.ones(len(places))
        falls = -(slopes * body.velocity(places)).sum(axis=1) / sizes
        known = np.isfinite(rates)
        assert (rates[known] <= falls[known] + NEWTON * body.speeds.max()).all()
        assert known.any()  # the point is not where bodies rest: they come nearer, or go away


def test_halves_cover_quadrangles_exactly() -> None:
    levels = short_levels(np.array([3.0, 2.0]), 16)
    pieces = SHAPES[1].pieces(levels[1:], levels[:1])
    area, halves, is_exact = _areas(pieces.corners).sum(), pieces, np.array(True)
    for _ in range(4):
        halves, is_exact = halves.halves
        assert is_exact.all()
        assert _areas(halves.corners).min() > 0
        assert _areas(halves.corners).sum() == pytest.approx(area, rel=1e-14)
    longest = SHAPES[1].pieces(np.array([math.pi]), np.array([math.pi * 1.1])).halves
    assert not longest[1].all()  # no bits to spare: levels of 53 bits


def _areas(corners: np.ndarray) -> np.ndarray:
    first, second = corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]
    return np.asarray(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]) / 2


def test_forces_and_bends_of_intervals_hold_those_of_the_slips_inside() -> None:
    rng = np.random.default_rng(0)
    cuts = np.where(rng.random(400) < 0.3, 1.0, rng.uniform(0.1, 0.9, 400))
    low = rng.uniform(-1, 1, (2, 400))
    r, s = (Intervals(entry, entry + rng.uniform(0, 0.5, 400)) for entry in low)
    exact: CutEllipse[Any] = CutEllipse(0.8, 0.5, cuts)
    enclosed: CutEllipse[Any] = CutEllipse(*(Intervals.of(x) for x in (0.8, 0.5, cuts)))
    with np.errstate(all="ignore"):
        bounds = [*enclosed.gradient(r, s), enclosed.bend(r, s)]
        for _ in range(50):
            inside = [entry.low + rng.random(400) * (entry.high - entry.low) for entry in (r, s)]
            (along, across), bend = exact.gradient(*inside), exact.bend(*inside)
            for bound, value in zip(bounds, (along, across, bend), strict=True):
                assert ((bound.low <= value) & (value <= bound.high)).all()
    # where a wheel may stick, or rollers turn while the rim may not slip, no number bounds the bend
    sticks = np.where(cuts == 1, r.holds_zero & s.holds_zero, r.holds_zero)
    assert not np.isfinite(bounds[2].high)[sticks].any()
    whole = (cuts == 1) & r.holds_zero & ~s.holds_zero
    assert whole.any()
    assert np.isfinite(bounds[2].high)[whole].all()


def test_rings_of_a_slow_spiral_are_shown_to_rise(tmp_path: Path) -> None:
    """It turns forty times as fast as it grows: forces that balance a pull show nothing of that."""
    table = MeasuredTable.symmetric(6, "ellipse")
    scene = measured(tmp_path, table)
    rest, forces, body = enclosed_rest(scene), BalancedForces(scene), SmallSteps(table)
    assert rest is not None
    slope = np.array([float(entry) for entry in rest.slope.entries()]).reshape(2, 2)
    shape = next(_rising(slope))
    assert isinstance(shape, SectorFunction)
    levels = short_levels(float(scene.accuracy) / 8 * np.array([1.0, 0.9]), 16)
    pieces = shape.pieces(levels[1:], levels[:1]).turned
    (rate,) = refined_rates(forces, pieces)
    rises = (-pieces.middle_slopes * body.velocity(pieces.middles)).sum(axis=1)
    assert 0 < rate <= rises.min() * 1.001


@thorough  # the small one: the ring before
def test_a_slow_spiral_carries_bodies_out_of_the_disc_of_the_accuracy(tmp_path: Path) -> None:
    table = MeasuredTable.symmetric(6, "ellipse")
    scene = measured(tmp_path, table)
    assert is_carried_away(scene, scene.accuracy, Fraction(1, 10**9))
    accuracy = float(scene.accuracy)
    assert SmallSteps(table).end(np.array([0.9 * accuracy, 0.0]), 60.0, accuracy)[1] > accuracy


def test_rings_fall_in_small_pieces_where_twists_turn_round_over_an_edge(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    table = MeasuredTable.symmetric(19, "roller")
    scene = measured(tmp_path, table)
    accuracy, forces, velocity = float(scene.accuracy), BalancedForces(scene), velocity_of(scene)
    assert velocity is not None
    _, coarse = field_beside(velocity, np.zeros(2), COARSE * accuracy)
    shape = list(shapes_about(coarse))[1]
    outer = accuracy * 0.9
    levels = short_levels(np.geomspace(outer, 0.8 * outer, FINEST[0] + 1))[:2]
    pieces = shape.pieces(levels[1:], levels[:1], FINEST[0])
    rate = least_rate(forces, pieces)
    falls = -(pieces.middle_slopes * SmallSteps(table).velocity(pieces.middles)).sum(axis=1)
    assert 0 < rate <= falls.min() * 1.001
    sizes: list[int] = []

    def counted(forces: BalancedForces, pieces: RingPieces, *args: Any, more: bool) -> Any:
        sizes.append(len(pieces.corners))
        return piece_rates(forces, pieces, *args, more=more)

    monkeypatch.setattr(touching_rings, "piece_rates", counted)
    assert least_rate(forces, shape.pieces(levels[1:], levels[:1], FINER[-1])) == 0
    assert sizes == [FIRST_PIECES[0]], "where the slowest fail, the others need no look"
