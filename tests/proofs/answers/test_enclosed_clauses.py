"""Clauses 1 to 3 at a place of rest that is the point within rounding, against forces in forty digits.

The oracle knows nothing of boxes: it takes the headings as they are stated, or moved by less than they were rounded,
finds the place where forces balance by Newton's method, and differentiates the motion beside it.
"""

from __future__ import annotations

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

from nonsmooth.proofs.answers.answers import answers_of
from nonsmooth.proofs.answers.best_point import best_point
from nonsmooth.proofs.boxes.enclosed_rest import EnclosedRest, enclosed_rest
from nonsmooth.proofs.robust.rest_points import DISCS, attracting_disc
from nonsmooth.proofs.theorem4 import check_smooth
from nonsmooth.proofs.theorem4_result import SmoothCheck
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.edge_headings import ball_of
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.rounded import plain, rounded
from tests.oracles.measured_tables import MeasuredTable, SmallSteps
from tests.thorough import few, keep

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
        found = tuple(mpmath.findroot(equations, start, tol=1e-60, maxsteps=60))
        equations(*found)
        assert all(self.are_held)
        return found

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
    with TemporaryDirectory() as folder:
        file = Path(folder) / "table.toml"
        file.write_text(table.toml, encoding="utf-8")
        scene = load_scene(str(file))
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


@pytest.mark.parametrize(("seed", "rule"), keep(3, [(s, r) for s in range(20) for r in ("ellipse", "roller")]))
def test_clauses_of_symmetric_tables_are_those_of_forces_in_forty_digits(seed: int, rule: str) -> None:
    table = MeasuredTable.symmetric(seed, rule)
    check = checked(table, at_best=False)
    if check.equilibrium.point.rest is None:
        assert check.equilibrium.verdict != "holds"
        return
    with mpmath.workdps(DIGITS + 40):
        confirm(table, check)


@pytest.mark.parametrize(("seed", "rule"), keep(2, [(s, r) for s in (3, 0, 7, 9) for r in ("ellipse", "roller")]))
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
        assert not check.with_results(equilibrium=result).check()
        moved = replace(check.translation, point=replace(point, rest=forged))
        assert not check.with_results(translation=moved).check()


def test_a_point_that_is_only_near_is_no_equilibrium() -> None:
    table = MeasuredTable.random(3, "ellipse", off=3.0)
    check = checked(table, at_best=True)
    x, y = check.scene.check.equilibrium
    scene = check.scene
    near = scene.checked_at((plain(x) + scene.accuracy / 10**9, plain(y)), scene.check.radius)
    assert check_smooth(near).equilibrium.verdict == "fails"


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


def test_a_disc_that_attracts_falls_at_its_rate() -> None:
    table = MeasuredTable.symmetric(3, "ellipse")
    scene = checked(table, at_best=False).scene.recentred()
    rest = enclosed_rest(scene)
    assert rest is not None
    disc = attracting_disc(scene, rest, [scene.accuracy / 64])
    assert disc is not None
    near, body = disc.radius / 16, SmallSteps(table)
    start = float(disc.radius) * np.array([[math.cos(angle), math.sin(angle)] for angle in np.arange(6.0)])
    ends, _ = body.paths(start, [float(disc.time_to(near, disc.radius))], float(near))
    assert np.hypot(*ends[0].T).max() <= float(near) * 1.01


def test_no_disc_attracts_to_a_place_that_repels() -> None:
    """Forged as one that attracts."""
    scene = checked(MeasuredTable.symmetric(4, "ellipse"), at_best=False).scene.recentred()
    rest = enclosed_rest(scene)
    assert rest is not None
    assert rest.stability == "unstable"
    forged = replace(rest, slope=rest.slope - arb_mat([[100, 0], [0, 100]]))
    assert forged.stability == "asymptotically stable"
    assert attracting_disc(scene, forged, [scene.accuracy * share for share in DISCS]) is None
