"""Rules without cells over boxes of parameters, against arrays drawn from them and solved in floats."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from flint import arb
from scipy.optimize import root

from nonsmooth.analysis.fields.contact_model import ContactModel
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseMinimizer
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.proofs.answers.answers import robust_facts
from nonsmooth.proofs.boxes.balanced_forces import load_box
from nonsmooth.proofs.boxes.intervals import Intervals, cosine
from nonsmooth.proofs.findings import Certainty
from nonsmooth.proofs.robust.decide import Robust, SmoothProof, decide_robust
from nonsmooth.proofs.robust.level_sets import AnnulusPiece
from nonsmooth.proofs.robust.nearest import inner_radius
from nonsmooth.proofs.robust.plane_minimum import PlaneMinima
from nonsmooth.proofs.robust.rings import RingProof, TouchingRings
from nonsmooth.proofs.robust.smooth_rules import PieceForces, SmoothDisc, ellipse_force, equilibrium_box, roller_force
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.contact_set import standing
from nonsmooth.symbolic.mechanics.load_model import UnknownLoads
from nonsmooth.symbolic.mechanics.scene import Scene, Tolerance
from tests.conftest import Arrays
from tests.four_wheel import CORNERS
from tests.oracles.floats import Floats
from tests.outlined import on, polygon_of
from tests.proofs.robust.drawn_arrays import drawn_model, small_box
from tests.thorough import few, keep, thorough

# ---- Equilibria of every array of a box under rules without cells, against arrays drawn from it and solved in
# floats.


SLACK = 1e-6  # of the wheels' distance: a zero of a field of numerical minimizers


def velocity(model: ContactModel, c: Floats) -> Floats:
    vx, vy, omega = EllipseMinimizer().minimize(model, loads_at(model, c[None])).twists[0]
    return np.array([vx - omega * c[1], vy + omega * c[0]])


def mixed(name: str) -> Scene:
    """A built-in array in which every second wheel has rollers."""
    scene = load_scene(name, rule="ellipse")
    kinds = ("ellipse", "roller")
    wheels = [
        replace(wheel, friction=replace(wheel.friction, rule=kinds[k % 2])) for k, wheel in enumerate(scene.wheels)
    ]
    return replace(scene, wheels=tuple(wheels), contact=replace(scene.contact, rule="mixed"))


def divide_little(patch: pytest.MonkeyPatch) -> None:
    """Neither quadrangles nor rings are divided."""
    patch.setattr(SmoothDisc, "depth", 0)
    patch.setattr(SmoothDisc, "halvings", 0)


@few(1)
@pytest.mark.parametrize("rule", ["ellipse", "roller"])
@pytest.mark.parametrize("name", keep(2, ["four-wheel", "elliptic", "ring-6", "grid-4x4"]))
@pytest.mark.parametrize("count", keep(1, [4, 12]))
def test_every_array_has_its_equilibrium_in_the_disc_and_it_attracts(name: str, rule: str, count: int) -> None:
    assert_each_attracts(standing(load_scene(name, rule=rule)).recentred(), count)


@pytest.mark.parametrize("name", keep(1, ["four-wheel", "ring-6"]))
def test_every_array_of_mixed_wheels_has_its_equilibrium_in_the_disc_and_it_attracts(name: str) -> None:
    scene = mixed(name).recentred()
    assert_each_attracts(scene, 6, small_box(scene).times(Fraction(1, 10)))


@thorough  # of wheels of one kind: test_what_is_said; mixed ones: the test above
def test_tolerances_of_mixed_wheels_are_followed() -> None:
    scene = mixed("four-wheel")
    found = SmoothProof(scene.recentred()).all_that_is_shown(small_box(scene))
    assert found is not None
    assert found.verdict is Certainty.CERTIFIED
    assert found.start is not None


def assert_each_attracts(scene: Scene, count: int, tolerances: Tolerance | None = None) -> None:
    """Every array that is drawn rests in the disc that is proved, and near it the body comes to that place."""
    box = tolerances or small_box(scene)
    disc = equilibrium_box(scene, box)
    assert disc is not None
    reach, rng = float(disc.squared) ** 0.5, np.random.default_rng(2)
    for k in range(count):
        model = drawn_model(scene, box, rng, corner=k % 2 == 0)
        solved = root(lambda c, model=model: velocity(model, c), np.zeros(2), tol=1e-10)
        place = solved.x
        assert np.hypot(*velocity(model, place)) < 1e-5
        assert np.hypot(*place) <= reach + SLACK
        step = 1e-4
        columns = [velocity(model, place + step * e) - velocity(model, place - step * e) for e in np.eye(2)]
        assert np.linalg.eigvals(np.column_stack(columns) / (2 * step)).real.max() < 0
        omega = EllipseMinimizer().minimize(model, loads_at(model, place[None])).twists[0, 2]
        assert abs(omega) <= float(abs(disc.spin).upper()) + 1e-5


@thorough  # the small one: test_every_array_has_its_equilibrium_in_the_disc_and_it_attracts
def test_the_bound_is_not_far_from_what_arrays_do() -> None:
    """To first order it is the sum of the sizes of all shifts: one corner of the box comes near it."""
    scene = load_scene("four-wheel", rule="ellipse")
    box = replace(small_box(scene).times(Fraction(1, 10)), position=scene.field(0), heading=Fraction(0))
    disc = equilibrium_box(scene, box)
    assert disc is not None
    rng, farthest = np.random.default_rng(4), 0.0
    for _ in range(60):
        model = drawn_model(scene, box, rng, corner=True)
        farthest = max(farthest, float(np.hypot(*root(lambda c, model=model: velocity(model, c), np.zeros(2)).x)))
    assert 0.4 * float(disc.squared) ** 0.5 < farthest <= float(disc.squared) ** 0.5 + SLACK


@pytest.mark.parametrize("radius", keep(1, ["1/5", None]))
def test_what_is_said_of_equilibria(radius: str | None, monkeypatch: pytest.MonkeyPatch) -> None:
    """On a small square with few quadrangles and rings, which is quick; and on the whole one."""
    if radius is not None:
        divide_little(monkeypatch)
        monkeypatch.setattr(SmoothDisc, "sectors", 16)
    scene = load_scene("four-wheel", rule="ellipse", radius=radius)
    found = decide_robust(replace(scene, tolerances=small_box(scene)))
    assert found is not None
    assert found.verdict is Certainty.CERTIFIED
    # beside the equilibrium, where bodies from how far end, and after how long
    assert found.start is not None
    assert found.within is not None
    assert found.radius is not None
    assert found.equilibrium is not None
    assert found.radius < found.start
    assert found.within > 0
    assert found.factor is not None
    assert found.factor >= 1
    assert found.binding in ("mu_roll", "mu_side", "position", "heading")


@pytest.mark.parametrize("name", keep(1, ["conveyor-3", "outward", "spiral-30"]))
def test_what_is_not_followed_is_undecided(name: str) -> None:
    scene = load_scene(name, rule="roller")
    found = decide_robust(replace(scene, tolerances=small_box(scene)))
    assert found is not None
    assert (found.verdict, found.factor) == (Certainty.UNDECIDED, Fraction(0))


def test_loads_that_are_not_known_are_not_followed() -> None:
    scene = load_scene("four-wheel", rule="ellipse")
    unknown = replace(scene, contact=replace(scene.contact, loads=UnknownLoads()), tolerances=small_box(scene))
    found = decide_robust(unknown)
    assert found is not None
    assert found.reason == "the loads are not known"


def test_a_body_keeps_its_wheels() -> None:
    """A carton whose nearest wheel is at its edge: the disc must stay within the margin."""
    scene = standing(load_scene("carton-on-6x6", rule="ellipse"))
    near = decide_robust(replace(scene, tolerances=small_box(scene)))
    assert near is not None
    assert near.verdict is Certainty.CERTIFIED
    assert near.radius is not None
    assert near.radius < Fraction(1, 5)
    assert near.factor is not None
    assert near.radius * near.factor < Fraction(1, 2)


def test_the_statement_about_a_body_that_turns_says_for_which_wheels() -> None:
    bare = load_scene("off-center", rule="ellipse")
    outlined = on(bare, polygon_of(bare, [(-9, -9), (9, -9), (9, 9), (-9, 9)]))
    kept = "while they are turned so little that the same wheels carry them"
    for scene, drift, said in ((bare, 1, False), (outlined, 1, True), (outlined, 0, False)):
        found = Robust(Certainty.CERTIFIED, equilibrium=Fraction(1, 10), drift=Fraction(drift))
        words = " ".join(fact.words for fact in robust_facts(scene, found))
        assert (kept in words) == said


# ---- Discs in which bodies end under rules without cells, against arrays drawn from the box and solved in floats.

DRAWN, PLACES = 12, 24
QUARTER = Fraction(1, 4)  # of the tolerances
NEAR = Fraction(1, 16)  # the same, for an array of which several rings are shown in a second


CASES = [("four-wheel", "ellipse"), ("four-wheel", "roller"), ("ring-6", "ellipse"), ("elliptic", "roller")]

LAWS = {"ellipse": ellipse_force, "roller": roller_force}


def box_of(scene: Scene, share: Fraction) -> Tolerance:
    """A share of five millimetres on a metre, one degree, 2 % of speeds and 20 % of friction."""

    def number(value: Fraction) -> object:
        return scene.field(value * share)

    fifth = number(Fraction(1, 5))
    whole = number(Fraction(1, 200)), Fraction(1, 180) * share, number(Fraction(1, 50)), fifth, fifth, scene.field(0)
    return Tolerance(*whole)  # type: ignore[arg-type]


@cache
def disc_of(name: str, rule: str, share: Fraction) -> tuple[Scene, TouchingRings | None]:
    """A scene about its point, and the rings on which bodies come nearer."""
    scene = standing(load_scene(name, rule=rule)).recentred()
    return scene, SmoothDisc(scene).disc(box_of(scene, share), Fraction(str(inner_radius(scene))))


@pytest.fixture(scope="module")
def nearby() -> tuple[Scene, TouchingRings, Robust]:
    """An array with a small square, its rings, and what is said where the proof divides little.

    The disc is then larger than it need be, and found in a second.
    """
    with pytest.MonkeyPatch.context() as patch:
        divide_little(patch)
        scene = load_scene("four-wheel", rule="ellipse", radius="1/10")
        about = standing(scene).recentred()
        proof = SmoothProof(about)
        assert proof.rings is not None
        disc = proof.rings.disc(box_of(about, NEAR), Fraction(str(inner_radius(about))))
        patch.setattr(proof.rings, "disc", lambda *_: disc)  # not to look for it twice
        said = proof.all_that_is_shown(box_of(about, NEAR))
    assert disc is not None
    assert said is not None
    return about, disc, said


def test_every_array_comes_nearer_outside_a_disc_nearby(nearby: tuple[Scene, TouchingRings, Robust]) -> None:
    scene, disc, said = nearby
    assert (said.radius, said.start, said.within) == (disc.radius, disc.start, disc.time_to(disc.radius))
    assert_nearer_outside(scene, disc, NEAR)


def test_the_disc_is_the_same_in_millimetres(nearby: tuple[Scene, TouchingRings, Robust], arrays: Arrays) -> None:
    """Directions are compared by lengths that mean the same in every unit; the disc came out a quarter wider."""
    wheels = arrays.inward([(1000 * x, 1000 * y) for x, y in CORNERS], speed=1000)
    scene = standing(arrays.scene(wheels, radius=100).under("ellipse")).recentred()
    with pytest.MonkeyPatch.context() as patch:
        divide_little(patch)
        box = box_of(scene, NEAR)
        box = replace(box, position=box.position * 1000)
        disc = SmoothDisc(scene).disc(box, Fraction(str(inner_radius(scene))))
    assert disc is not None
    _, metres, _ = nearby
    assert (disc.start, disc.radius) == (1000 * metres.start, 1000 * metres.radius)
    assert [float(rate) for rate in disc.rates] == pytest.approx([1000 * float(rate) for rate in metres.rates])


def test_loads_are_enclosed_as_tightly_in_millimetres(arrays: Arrays) -> None:
    """In millimetres elimination took rows in another order, and what it lost made loads a hundred times as wide."""

    def widths(unit: int) -> list[float]:
        places = [(Fraction(x * unit, 10), Fraction(y * unit, 10)) for x, y in ((-3, 7), (-6, -9), (8, 3))]
        loads = load_box(arrays.scene(arrays.inward(places)), arb(unit) / 1000)
        assert loads is not None
        return [
            float(part.rad()) * size for form in loads.forms for part, size in zip(form, (1, unit, unit), strict=True)
        ]

    assert widths(1000) == pytest.approx(widths(1), rel=1e-3)
    assert 0 < max(widths(1)) < 0.02


def test_bodies_are_there_in_the_sum_of_the_times_of_the_rings(nearby: tuple[Scene, TouchingRings, Robust]) -> None:
    """Small steps from the border of the disc of starts; one rate for all rings would ask for more time."""
    scene, disc, _ = nearby
    assert disc.time_to(disc.radius) < (disc.start - disc.radius) / min(disc.rates)
    rng, step = np.random.default_rng(6), float(disc.time_to(disc.radius)) / 40
    for corner in (True, False):
        model = drawn_model(scene, box_of(scene, NEAR), rng, corner=corner)
        angles = rng.uniform(0, 2 * np.pi, 8)
        places = float(disc.start) * np.column_stack([np.cos(angles), np.sin(angles)])
        for _ in range(40):
            twists = EllipseMinimizer().minimize(model, loads_at(model, places)).twists
            turned = np.column_stack([-places[:, 1], places[:, 0]])
            places = places + step * (twists[:, :2] + twists[:, 2:] * turned)
        assert np.hypot(*places.T).max() <= float(disc.radius) * (1 + 1e-3)


@thorough  # the small one: test_every_array_comes_nearer_outside_a_disc_nearby
@pytest.mark.parametrize(("name", "rule"), CASES)
def test_every_array_comes_nearer_outside_the_disc(name: str, rule: str) -> None:
    scene, disc = disc_of(name, rule, QUARTER)
    assert disc is not None
    assert_nearer_outside(scene, disc, QUARTER)


def assert_nearer_outside(scene: Scene, disc: TouchingRings, share: Fraction) -> None:
    """At places on the disc's border and beyond it, for corners of the box and arrays inside it, ring by ring."""
    rng = np.random.default_rng(5)
    for k in range(DRAWN):
        model = drawn_model(scene, box_of(scene, share), rng, corner=k % 3 != 0)
        radii = np.r_[float(disc.radius), rng.uniform(float(disc.radius), float(disc.start), PLACES - 1)]
        angles = rng.uniform(0, 2 * np.pi, PLACES)
        places = radii[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
        twists = EllipseMinimizer().minimize(model, loads_at(model, places)).twists
        rates = (places * twists[:, :2]).sum(axis=1) / radii
        assert (rates <= -kappas(disc, radii) + SLACK).all()


def kappas(disc: TouchingRings, radii: Floats) -> Floats:
    """The rate of the ring of each radius."""
    ring = (radii[:, None] < np.array([float(inner) for inner in disc.inner])).sum(axis=1)
    return np.array([float(rate) for rate in disc.rates])[np.minimum(ring, len(disc.rates) - 1)]


class LastSectorFails(RingProof[Tolerance]):
    depth = 0
    asked = 0

    def over(self, box: Tolerance) -> Tolerance:
        return box

    def rates(self, bound: Tolerance, pieces: Sequence[AnnulusPiece], *, at_any: bool) -> list[arb | None]:
        self.asked += len(pieces)
        return [None if piece.start + piece.width == 1 else arb(1) for piece in pieces]


def test_a_box_fails_first_where_another_one_failed() -> None:
    box, proof = box_of(load_scene("four-wheel", rule="ellipse"), NEAR), LastSectorFails()
    assert not proof.comes_nearer(box, Fraction(1))
    proof.asked = 0
    assert not proof.comes_nearer(box.times(Fraction(2)), Fraction(1))
    assert proof.asked == len(proof.starts)


@thorough
def test_the_disc_shrinks_in_proportion_to_the_tolerances() -> None:
    radii = []
    for share in (Fraction(1, 8), Fraction(1, 32)):
        _, disc = disc_of("four-wheel", "ellipse", share)
        assert disc is not None
        radii.append(float(disc.radius / share))
    assert max(radii) < 1.5 * min(radii)


@thorough
def test_the_disc_reaches_further_than_the_equilibrium() -> None:
    """Ten times the box on which Krawczyk's operator shows one equilibrium of every array; not what arrays refute."""
    scene, disc = disc_of("four-wheel", "ellipse", Fraction(1, 2))
    box = box_of(scene, Fraction(1, 2))
    assert disc is not None
    assert equilibrium_box(scene, box) is None
    rng, farthest = np.random.default_rng(8), 0.0
    for _ in range(DRAWN):
        model = drawn_model(scene, box, rng, corner=True)
        angles = rng.uniform(0, 2 * np.pi, PLACES)
        for radius in (0.05, 0.08):
            places = radius * np.column_stack([np.cos(angles), np.sin(angles)])
            twists = EllipseMinimizer().minimize(model, loads_at(model, places)).twists
            if ((places * twists[:, :2]).sum(axis=1) > 0).any():
                farthest = max(farthest, radius)
    assert 0 < farthest <= float(disc.radius)


def test_what_is_said(nearby: tuple[Scene, TouchingRings, Robust]) -> None:
    scene = load_scene("four-wheel", rule="ellipse")
    large = replace(scene, tolerances=box_of(scene, QUARTER))
    small = replace(scene, tolerances=box_of(scene, Fraction(1, 32)))
    *_, wide = nearby
    found = replace(wide, equilibrium=Fraction(1, 50), drift=Fraction(0))
    assert wide.verdict is Certainty.CERTIFIED
    assert wide.start is not None
    assert wide.equilibrium is not None
    wide = replace(wide, equilibrium=None, drift=None)
    words = " ".join(fact.words for fact in robust_facts(small, found))
    assert "the body ends within" in words
    assert "has one equilibrium within" in words
    assert "equilibrium within" not in " ".join(fact.words for fact in robust_facts(large, wide))


def test_outward_arrays_have_no_disc() -> None:
    _, disc = disc_of("outward", "ellipse", Fraction(1, 32))
    assert disc is None


# ---- intervals -----------------------------------------------------------------------------------


def within(value: Fraction, low: float, high: float) -> bool:
    return Fraction(low) <= value <= Fraction(high)


def test_intervals_hold_exact_results() -> None:
    rng = np.random.default_rng(3)
    sizes = 10.0 ** rng.integers(-12, 12, (400, 4))
    for a, b, c, d in (rng.normal(size=(400, 4)) * sizes).tolist():
        x, y = Intervals.of(min(a, b)), Intervals.of(max(a, b))
        first = Intervals(x.low, y.high)
        second = Intervals(np.array(min(c, d)), np.array(max(c, d)))
        for p in (a, b):
            for q in (c, d):
                for enclosure, exact in (
                    (first + second, Fraction(p) + Fraction(q)),
                    (first - second, Fraction(p) - Fraction(q)),
                    (first * second, Fraction(p) * Fraction(q)),
                    (first.square, Fraction(p) ** 2),
                    (abs(first), abs(Fraction(p))),
                ):
                    assert within(exact, float(enclosure.low), float(enclosure.high))
        root = abs(first).sqrt()
        assert within(Fraction(float(root.low)) ** 2, 0.0, abs(a) * (1 + 1e-9)) or a == 0
        assert Fraction(float(root.high)) ** 2 >= max(abs(Fraction(a)), abs(Fraction(b)))


def test_unit_vectors_stay_inside() -> None:
    rng = np.random.default_rng(4)
    low, width = rng.uniform(-1, 1, (2, 500)), rng.uniform(0, 1, (2, 500)) * rng.choice([0.0, 0.1, 1.0], (2, 500))
    first, second = (Intervals(low[k], low[k] + width[k]) for k in range(2))
    enclosure = cosine(first, second)
    for share in rng.uniform(0, 1, (40, 2)):
        a, b = low[0] + share[0] * width[0], low[1] + share[1] * width[1]
        assert (np.abs(np.clip(a / np.hypot(a, b), enclosure.low, enclosure.high) - a / np.hypot(a, b)) < 1e-15).all()


@pytest.mark.parametrize("rule", ["ellipse", "roller"])
def test_forces_are_slopes_of_the_support_function(rule: str) -> None:
    """``sigma(t) >= sigma(s) + f . (t - s)`` for every subgradient f, at single slips; wider boxes hold them."""
    rng = np.random.default_rng(6)

    def support(slips: np.ndarray) -> np.ndarray:
        r, s = slips
        if rule == "ellipse":
            return np.asarray(np.hypot(roll * r, side * s))
        stands = np.abs(s) * np.sqrt(np.maximum(roll**2 - side**2, 0)) <= side * np.abs(r)
        turning = np.sqrt(np.maximum(roll**2 - side**2, 0)) * np.abs(r) + side * np.abs(s)
        return np.where(stands | (side >= roll), roll * np.hypot(r, s), turning)

    roll, side = 1.0, rng.uniform(0.1, 1.3, 300)
    at = rng.normal(size=(2, 300)) * 10.0 ** rng.integers(-6, 1, 300)
    point = [Intervals.of(entry) for entry in (np.full(300, roll), side, *at)]
    force = LAWS[rule]
    along, across = force(*point)
    for _ in range(40):
        other = rng.normal(size=(2, 300))
        step = other - at
        gain = along.middle * step[0] + across.middle * step[1]
        assert (support(other) - support(at) - gain > -1e-9).all()
    reach = rng.uniform(0, 0.3, (2, 300))
    wide = force(point[0], point[1], *(Intervals(x - d, x + d) for x, d in zip(at, reach, strict=True)))
    for narrow, whole in zip((along, across), wide, strict=True):
        assert (whole.low <= narrow.high).all()
        assert (narrow.low <= whole.high).all()


def test_a_slip_that_may_vanish_leaves_the_whole_friction_set() -> None:
    about = Intervals(np.array([-0.1]), np.array([0.1]))
    for rule, most in (("ellipse", 0.5), ("roller", 0.5)):
        along, across = LAWS[rule](Intervals.of(np.ones(1)), Intervals.of(np.full(1, most)), about, about)
        assert along.low[0] <= -1 <= 1 <= along.high[0]
        assert across.low[0] <= -most <= most <= across.high[0]


def test_balls_become_intervals() -> None:
    intervals = Intervals.about([arb(1) / 3, arb(2, 0.5)])
    assert within(Fraction(1, 3), float(intervals.low[0]), float(intervals.high[0]))
    assert intervals.low[1] <= 1.5
    assert intervals.high[1] >= 2.5


def test_a_sum_of_intervals_holds_the_sum_of_their_ends() -> None:
    ends = np.sort(np.random.default_rng(7).normal(size=(2, 50, 30)) * 10.0 ** np.arange(-15, 15), axis=0)
    total = Intervals(*ends).sum(axis=1)
    low, high = ([sum(Fraction(entry) for entry in row) for row in part] for part in ends)
    assert all(a <= b for a, b in zip(total.low, low, strict=True))
    assert all(a >= b for a, b in zip(total.high, high, strict=True))


def test_no_minimum_is_guessed_where_the_last_step_ends_without_curvature(tmp_path: Path) -> None:
    (tmp_path / "wheels.csv").write_text(
        "x,y,heading,speed,mu_side\n229.1,-10.4,-170,143.3,0.2\n2.7,221.7,-40,200,0.9\n-277.9,-3.8,16,200,0.2\n"
        "-166.4,-193.3,-67.1,200,0.2\n203.3,-185.9,-159.8,224.8,0.2\n"
    )
    (tmp_path / "five.toml").write_text(
        "units = { length = 'mm' }\nfriction = { mu_roll = 0.8 }\ncontact = { rule = 'roller' }\n"
        "wheels = { file = 'wheels.csv' }\n"
    )
    piece = AnnulusPiece(Fraction(75, 2), Fraction(40), Fraction(1, 32), Fraction(1, 32))
    assert PlaneMinima(load_scene(str(tmp_path / "five.toml"))).on_plane(piece, 0.05) is None


# ---- Forces on a quadrangle, against those of arrays drawn from the box at places drawn from it.


@pytest.mark.parametrize("name", ["four-wheel-side", "ring-5"])
def test_powers_and_wrenches_of_drawn_arrays_lie_in_those_of_the_box(name: str) -> None:
    """With the same twist and the ellipse's force ``mu^2 s / |mu s|``, written anew."""
    scene, rng = standing(load_scene(name, rule="ellipse")).recentred(), np.random.default_rng(1)
    for width in (Fraction(1, 64), Fraction(1, 8)) * 15:
        box = small_box(scene).times(1 / (64 * width))  # small where the quadrangle is large
        bound = SmoothDisc(scene).over(box)
        assert bound is not None
        piece = AnnulusPiece(Fraction(1, 5) - width, Fraction(1, 4), Fraction(int(rng.integers(64)), 64), width)
        middle = 2 * np.pi * float(piece.start + piece.width / 2)
        frame = np.array([[np.cos(middle), np.sin(middle)], [-np.sin(middle), np.cos(middle)]])
        twist = rng.normal(size=3)  # along the frame
        components = [Intervals.of(np.array([[value]])) for value in twist]
        pieces = PieceForces.of(bound, [piece])
        forces = pieces.forces((components[0], components[1], components[2]))
        enclosed = (pieces.power(forces, (components[0], components[1], components[2])), *pieces.wrench(forces))
        for _ in range(20):
            model = drawn_model(scene, box, rng, corner=bool(rng.integers(2)))
            angle = 2 * np.pi * (float(piece.start) + rng.uniform(0, float(width)))
            place = rng.uniform(float(piece.inner), 0.25) * np.array([np.cos(angle), np.sin(angle)])
            rows, mu = model.rows.reshape(-1, 2, 3), model.friction.reshape(-1, 2)
            moved = rows @ np.array([*(twist[:2] @ frame), twist[2]])
            slips = moved - model.targets.reshape(-1, 2)
            force = loads_at(model, place[None])[0][:, None] * mu**2 * slips
            force /= np.linalg.norm(mu * slips, axis=1)[:, None]
            wrench = np.einsum("kj,kji->i", force, rows)
            values = ((force * moved).sum(), *(frame @ wrench[:2]), wrench[2])
            for interval, value in zip(enclosed, values, strict=True):
                assert interval.low[0, 0] - 1e-9 <= value <= interval.high[0, 0] + 1e-9
