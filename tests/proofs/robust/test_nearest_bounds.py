"""Bounds for every array of a box under rules with cells, against arrays drawn from it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from flint import arb, fmpq
from numpy.typing import NDArray

from nonsmooth.analysis.cells.polygon import HalfPlane
from nonsmooth.analysis.fields.contact_model import ContactModel
from nonsmooth.analysis.minimizers.box_minimizers import BoxHighs
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.proofs.findings import Certainty
from nonsmooth.proofs.robust import nearest, rings
from nonsmooth.proofs.robust.box import BoxRingProof, box_wheels
from nonsmooth.proofs.robust.decide import Robust, binding_entry, decide_robust, largest_factor
from nonsmooth.proofs.robust.level_sets import AnnulusPiece, polygon_about, ring
from nonsmooth.proofs.robust.nearest import RobustUltimateBound, is_bounded, ultimate_bound
from nonsmooth.proofs.robust.rings import PARTS, TouchingRings, _last_slow, is_slow, root_above
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.contact_set import standing
from nonsmooth.symbolic.mechanics.load_model import UnknownLoads
from nonsmooth.symbolic.mechanics.scene import Scene, Tolerance, Wheel
from nonsmooth.symbolic.numbers.plane import between
from tests.conftest import Arrays as Builders
from tests.oracles.floats import Floats
from tests.oracles.wheels_in_floats import places_of
from tests.proofs.robust.drawn_arrays import drawn_model, small_box
from tests.thorough import few, keep, thorough

# ---- Bounds for every array of a box, against arrays drawn from it: corners of the box, and paths of bodies.
#
# The motion of an array is written anew here, in floats: the two nearest wheels, their rows, a linear system.


TABLE = """
friction = { mu_roll = 1, mu_side = "1/2" }
wheel = [
  { position = ["1/10", "1/10"], speed = "1/10" }, { position = ["-1/10", "1/10"], speed = "1/10" },
  { position = ["-1/10", "-1/10"], speed = "1/10" }, { position = ["1/10", "-1/10"], speed = "1/10" },
]
[tolerance]
position = "1/1000"
heading = "1 deg"
speed = "1/50"
mu_roll = "1/5"
mu_side = "1/5"
"""
BOX = '\n[tolerance]\nposition = "1/50"\nheading = "1 deg"\nspeed = "1/50"\nmu_roll = "1/5"\nmu_side = "1/5"\n'
SCENES = ("four-wheel", "ring-5", "ring-6", "rectangle")
ROUNDING = 1e-9


class Arrays(NamedTuple):
    """Arrays of n wheels each: places (m, n, 2), rims (m, n, 2), speeds (m, n), whether the rim row counts (m, n)."""

    places: Floats
    rims: Floats
    speeds: Floats
    along: NDArray[np.bool_]


def drawn(scene: Scene, count: int, seed: int, factor: float = 1.0) -> Arrays:
    """Arrays of the box: half of them corners of it, the others anywhere inside."""
    box, rng = scene.tolerances, np.random.default_rng(seed)
    assert box is not None
    n = len(scene.wheels)

    def shifts(shape: tuple[int, ...]) -> Floats:
        inside = rng.uniform(-1, 1, shape)
        inside[: count // 2] = rng.choice([-1.0, 1.0], (count // 2, *shape[1:]))
        return factor * inside

    places = places_of(scene)
    angles = np.array([np.arctan2(float(y), float(x)) for x, y in (wheel.unit_direction for wheel in scene.wheels)])
    angles = angles + shifts((count, n)) * np.pi * float(box.heading)
    speeds = np.array([float(wheel.speed) for wheel in scene.wheels]) * (1 + float(box.speed) * shifts((count, n)))
    roll = np.array([float(wheel.friction.roll) for wheel in scene.wheels]) * (
        1 + float(box.mu_roll) * shifts((count, n))
    )
    side = np.array([float(wheel.friction.side) for wheel in scene.wheels]) * (
        1 + float(box.mu_side) * shifts((count, n))
    )
    rims = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    return Arrays(places + float(box.position) * shifts((count, n, 2)), rims, speeds, roll > side)


def velocities(arrays: Arrays, points: Floats) -> Floats:
    """``c' = v + omega J c`` of every array at a point of its own (m, 2): the rows of its two nearest wheels."""
    order = np.argsort(((arrays.places - points[:, None]) ** 2).sum(axis=2), axis=1)[:, :2]
    at = np.arange(len(points))
    i, j = order.T
    (p, q), (d, e) = ((array[at, i], array[at, j]) for array in (arrays.places, arrays.rims))
    along = arrays.along[at, j]
    third = np.where(along[:, None], e, np.stack([-e[:, 1], e[:, 0]], axis=1))
    third_speed = np.where(along, arrays.speeds[at, j], 0.0)
    rows = [(d, p), (np.stack([-d[:, 1], d[:, 0]], axis=1), p), (third, q)]
    matrix = np.stack([np.column_stack([m, m[:, 1] * r[:, 0] - m[:, 0] * r[:, 1]]) for m, r in rows], axis=1)
    right = np.stack([arrays.speeds[at, i], np.zeros(len(at)), third_speed], axis=1)
    twist = np.linalg.solve(matrix, right[..., None])[..., 0]
    return twist[:, :2] + twist[:, 2:] * np.stack([-points[:, 1], points[:, 0]], axis=1)


def bound_of(scene: Scene) -> tuple[Scene, RobustUltimateBound]:
    centred = scene.recentred()
    assert centred.tolerances is not None
    bound = ultimate_bound(centred, centred.tolerances)
    assert bound is not None
    return centred, bound


def with_box(name: str, folder: Path) -> Scene:
    """A built-in scene within tolerances."""
    file = folder / f"{name}.toml"
    built_in = Path(__file__).parents[3] / "symbolic" / "scenes" / f"{name}.toml"
    file.write_text(built_in.read_text(encoding="utf-8") + BOX, encoding="utf-8")
    return load_scene(file, rule="nearest")


def table(folder: Path) -> Scene:
    file = folder / "table.toml"
    file.write_text(TABLE, encoding="utf-8")
    return load_scene(file)


@few(3)
@pytest.mark.parametrize("name", ["table", *SCENES])
def test_no_array_of_the_box_breaks_the_bound(name: str, tmp_path: Path) -> None:
    """Ten thousand arrays, each at a point of its own outside the disc, most of them close to it."""
    scene, bound = bound_of(table(tmp_path) if name == "table" else with_box(name, tmp_path))
    inner, outer = float(bound.squared) ** 0.5, float(scene.check.radius)
    rng = np.random.default_rng(1)
    sizes = inner + (outer - inner) * rng.random(10_000) ** 3
    angles = rng.uniform(0, 2 * np.pi, len(sizes))
    points = sizes[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
    moved = velocities(drawn(scene, len(sizes), 2), points)
    assert ((points * moved).sum(axis=1) <= -float(bound.kappa) * sizes * (1 - ROUNDING)).all()


@thorough  # the small one: test_no_array_of_the_box_breaks_the_bound
def test_paths_end_in_the_disc_in_time_and_stay(tmp_path: Path) -> None:
    """Euler's steps of 100 arrays from 32 starts each: no path is outside after the time, but for one step."""
    scene = table(tmp_path)
    found = decide_robust(scene)
    assert found is not None
    assert found.radius is not None
    assert found.within is not None
    arrays = drawn(scene, 100, 3)
    chosen = np.repeat(np.arange(100), 32)
    spread = Arrays(arrays.places[chosen], arrays.rims[chosen], arrays.speeds[chosen], arrays.along[chosen])
    angles = np.tile(np.arange(32) * np.pi / 16, 100)
    points = float(scene.check.radius) * 0.999 * np.column_stack([np.cos(angles), np.sin(angles)])
    step = float(found.within) / 600
    fastest = 0.0
    for k in range(900):
        moved = velocities(spread, points)
        # Where two rows are dependent the motion is as fast as one likes: inside the disc nothing is said of it.
        sizes = np.hypot(*moved.T)
        fastest = max(fastest, float(sizes[np.hypot(*points.T) > float(found.radius)].max(initial=0.0)))
        points = points + step * moved * np.minimum(1, 0.3 / np.maximum(sizes, 1e-30))[:, None]
        if k >= 600:
            assert np.hypot(*points.T).max() <= float(found.radius) + 0.3 * step
    assert fastest < 0.3


def test_a_larger_box_breaks_what_the_factor_says(tmp_path: Path) -> None:
    """Beyond the factor mu_roll and mu_side may change places, which the nominal bound does not survive."""
    scene = table(tmp_path)
    found = decide_robust(scene)
    assert found is not None
    assert found.factor is not None
    assert found.radius is not None
    assert found.binding in ("mu_roll", "mu_side")
    assert not is_bounded(scene, scene.tolerances.times(found.factor * Fraction(11, 10)))  # type: ignore[union-attr]
    beyond = drawn(scene, 4_000, 5, factor=float(found.factor) * 1.1)
    rng = np.random.default_rng(6)
    points = rng.uniform(-1, 1, (4_000, 2)) * float(scene.check.radius)
    outward = (points * velocities(beyond, points)).sum(axis=1) > 0
    assert np.hypot(*points[outward].T).max() > 5 * float(found.radius)


def test_the_radius_goes_to_zero_with_the_tolerances(tmp_path: Path) -> None:
    """In proportion: the ratio at a hundredth and at a thousandth is the same but for the rate that is chosen."""
    scene = table(tmp_path)
    assert scene.tolerances is not None
    ratios = []
    for parts in (100, 1000):
        bound = ultimate_bound(scene, scene.tolerances.times(Fraction(1, parts)))
        assert bound is not None
        ratios.append(float(bound.squared) ** 0.5 * parts)
    assert ratios[0] == pytest.approx(ratios[1], rel=0.05)


def test_cells_of_many_wheels_ask_their_neighbours_alone(arrays: Builders, monkeypatch: pytest.MonkeyPatch) -> None:
    """Not every wheel for every other one: of a hundred thousand some hundreds lie near."""
    wheels, asked = arrays.grid(12, 12).recentred().wheels, 0

    def counted(near: Wheel, far: Wheel, step: arb, signs: tuple[int, int]) -> HalfPlane:
        nonlocal asked
        asked += 1
        return nearer(near, far, step, signs)

    nearer = nearest._nearer
    monkeypatch.setattr(nearest, "_nearer", counted)
    cells = list(nearest.outer_cells(wheels, fmpq(3), arb(0)))
    assert sum(cell.polygon.area for cell in cells) == 6 * 6
    assert asked < len(wheels) ** 2


@pytest.mark.parametrize("length", [fmpq(1), fmpq(1, 10**16)])
def test_the_last_slow_part_of_a_side_is_exact(length: fmpq) -> None:
    """Also of a side so short that its ends are one place in floats."""
    w, kappa = (fmpq(-1), fmpq(0)), fmpq(1, 3)  # slow where |y| >= sqrt(8) x
    slow, fast = (fmpq(1), fmpq(2_828_427_124_746_190_098, 10**18)), (fmpq(1), fmpq(2))
    fast = between(slow, fast, length)
    slow = between(slow, fast, fmpq(-1, 11))
    last = _last_slow(slow, fast, w, kappa)
    part = (last[1] - slow[1]) / (fast[1] - slow[1]) * PARTS
    assert part.q == 1
    assert not is_slow(last, w, kappa)
    assert is_slow(between(slow, fast, (part - 1) / PARTS), w, kappa)


def test_what_is_not_followed_is_undecided(tmp_path: Path) -> None:
    scene = table(tmp_path)
    for changed in (replace(scene, contact=replace(scene.contact, rule="box")), load_scene("omni-3", rule="nearest")):
        found = decide_robust(replace(changed, tolerances=scene.tolerances))
        assert isinstance(found, Robust)
        assert found.verdict is Certainty.UNDECIDED
        assert found.reason
    assert decide_robust(load_scene("four-wheel")) is None


@pytest.mark.parametrize(
    "weights", [(1, 2, 3, 40, 5), (40, 1, 1, 1, 1), (5, 4, 3, 2, 1), (1, 1, 1, 1, 0.9), (1e4,) * 5]
)
def test_the_entry_that_binds_is_that_without_which_the_factor_grows_most(
    weights: tuple[float, ...], tmp_path: Path
) -> None:
    """Of a statement that holds below a weighted sum the largest share binds, which few boxes tell."""
    box, asked = table(tmp_path).tolerances, 0
    assert box is not None
    sizes = {name: float(getattr(box, name)) for name in box.names}

    def holds(other: Tolerance) -> bool:
        nonlocal asked
        asked += 1
        shares = (float(getattr(other, name)) / sizes[name] for name in sizes)
        return sum(weight * share for weight, share in zip(weights, shares, strict=True)) <= 10

    factor = largest_factor(holds, box)
    assert float(factor) == pytest.approx(10 / sum(weights), rel=0.02) or (factor == 0 and weights[0] == 1e4)
    asked = 0
    binding = binding_entry(holds, box, factor)
    assert binding == (None if not factor else max(sizes, key=lambda name: weights[list(sizes).index(name)]))
    assert asked <= 4 * len(sizes)


# ---- Rule ``box`` over boxes of parameters, against arrays drawn from them: minimizers by a linear program, and
# paths.

PROGRAM_ROUNDING = 1e-7


def twists(model: ContactModel, points: Floats) -> Floats:
    return BoxHighs().minimize(model, loads_at(model, points)).twists


def disc_of(name: str, radius: str, monkeypatch: pytest.MonkeyPatch) -> tuple[Scene, TouchingRings]:
    """A disc that is found in a few rings."""
    monkeypatch.setattr(rings, "RINGS", 8)
    monkeypatch.setattr(BoxRingProof, "halvings", 0)
    scene = load_scene(name, rule="box", radius=radius).recentred()
    disc = BoxRingProof(scene).disc(small_box(scene), Fraction(radius))
    assert disc is not None
    return scene, disc


@few(1)
@pytest.mark.parametrize(("name", "radius"), [("four-wheel", "13/20"), ("ring-5", "9/20"), ("ring-6", "9/20")])
def test_no_array_of_the_box_breaks_the_rate(name: str, radius: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Corners of the box and arrays inside it, each at points between the disc and the starts."""
    scene, disc = disc_of(name, radius, monkeypatch)
    within, rng = small_box(scene), np.random.default_rng(1)
    for k in range(24):
        model = drawn_model(scene, within, rng, corner=k % 2 == 0)
        sizes = rng.uniform(float(disc.radius), float(disc.start), 6)
        angles = rng.uniform(0, 2 * np.pi, 6)
        points = sizes[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
        falling = (points * twists(model, points)[:, :2]).sum(axis=1)
        assert (falling <= -float(min(disc.rates)) * sizes + PROGRAM_ROUNDING).all()


@thorough  # the small one: test_no_array_of_the_box_breaks_the_rate
def test_paths_end_in_the_disc_in_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """Euler's steps; a path may be outside by a step, for it slides along borders of cells."""
    scene, disc = disc_of("four-wheel", "7/10", monkeypatch)
    within, rng = small_box(scene), np.random.default_rng(2)
    time = float(disc.time_to(disc.radius))
    for k in range(3):
        model = drawn_model(scene, within, rng, corner=k < 2)
        angles = rng.uniform(0, 2 * np.pi, 4)
        points = float(disc.start) * np.column_stack([np.cos(angles), np.sin(angles)])
        step = time / 60
        for _ in range(60):
            moved = twists(model, points)
            points = points + step * (moved[:, :2] + moved[:, 2:] * np.column_stack([-points[:, 1], points[:, 0]]))
        assert np.hypot(*points.T).max() <= float(disc.radius) + 2 * step


@pytest.mark.parametrize("name", keep(2, ["four-wheel", "rectangle", "ring-6", "grid-4x4"]))
def test_every_body_within_the_rest_disc_stays_where_it_is(name: str) -> None:
    scene = load_scene(name, rule="box").recentred()
    within, rng = small_box(scene), np.random.default_rng(3)
    radius = BoxRingProof(scene).rest_radius(within, Fraction(1, 2))
    assert radius > Fraction(1, 5)
    for k in range(12):
        model = drawn_model(scene, within, rng, corner=k % 2 == 0)
        angles = rng.uniform(0, 2 * np.pi, 4)
        points = float(radius) * np.column_stack([np.cos(angles), np.sin(angles)])
        assert np.abs(twists(model, points)).max() < 1e-8


def test_without_tolerances_the_rest_disc_is_that_of_the_closed_form() -> None:
    """The four-wheel array rests where ``|x| + |y| <= mu_S/mu_R``: a disc of radius ``sqrt(1/8)``."""
    scene = load_scene("four-wheel", rule="box").recentred()
    rule, none = BoxRingProof(scene), small_box(scene).times(Fraction(0))
    exact = 8**-0.5
    assert exact * 0.95 < float(rule.rest_radius(none, Fraction(1, 2))) <= exact
    assert rule.rest_radius(none, Fraction(1, 5)) == Fraction(1, 5)


def test_a_larger_box_breaks_what_is_said() -> None:
    """At the rest disc's edge some corner of a box twenty times as large moves."""
    scene = load_scene("four-wheel", rule="box").recentred()
    radius = float(BoxRingProof(scene).rest_radius(small_box(scene), Fraction(1, 2)))
    rng, angles = np.random.default_rng(4), np.pi / 4 * np.arange(8)
    points = radius * np.column_stack([np.cos(angles), np.sin(angles)])
    models = [drawn_model(scene, small_box(scene).times(Fraction(20)), rng, corner=True) for _ in range(20)]
    assert max(np.abs(twists(model, points)).max() for model in models) > 1e-3


def test_quadrangles_cover_their_ring() -> None:
    """Random points of the ring lie left of every side of one piece, and so do those of a divided piece in a part."""
    rng = np.random.default_rng(5)
    pieces = list(ring(Fraction(1, 3), Fraction(1, 2), 16))
    whole = [corners_of(piece) for piece in pieces]
    divided = [corners_of(part) for piece in pieces for part in piece.parts]
    for _ in range(100):
        size, angle = rng.uniform(1 / 3, 1 / 2), rng.uniform(0, 2 * np.pi)
        point = size * np.array([np.cos(angle), np.sin(angle)])
        assert any(holds(corners, point) for corners in whole)
        assert any(holds(corners, point) for corners in divided)
    assert all(x * x + y * y > Fraction(1, 4) for x, y in polygon_about(Fraction(1, 2)))


def corners_of(piece: AnnulusPiece) -> Floats:
    return np.array([[float(x) for x in corner] for corner in piece.corners])


def holds(corners: Floats, point: Floats) -> bool:
    sides, away = np.roll(corners, -1, axis=0) - corners, point - corners
    return bool((sides[:, 0] * away[:, 1] - sides[:, 1] * away[:, 0] >= 0).all())


def test_what_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rings, "RINGS", 8)
    monkeypatch.setattr(BoxRingProof, "halvings", 0)
    scene = load_scene("four-wheel", rule="box", radius="13/20")
    one = replace(small_box(scene).times(Fraction(0)), mu_side=scene.field(Fraction(1, 400)))
    found = decide_robust(replace(scene, tolerances=one))
    assert found is not None
    assert found.verdict is Certainty.CERTIFIED
    assert found.radius is not None
    assert found.rests is not None
    assert Fraction(1, 2) < found.radius < Fraction(13, 20)
    assert Fraction(3, 10) < found.rests < Fraction(36, 100)
    assert found.factor is not None
    assert found.factor > 1
    assert found.binding == "mu_side"


def test_what_is_not_followed_under_rule_box_is_undecided() -> None:
    scene = load_scene("four-wheel", rule="box")
    unknown = replace(scene, contact=replace(scene.contact, loads=UnknownLoads()), tolerances=small_box(scene))
    found = decide_robust(unknown)
    assert found is not None
    assert (found.verdict, found.reason) == (Certainty.UNDECIDED, "the loads are not known")
    away = load_scene("outward", rule="box")
    found = decide_robust(replace(away, tolerances=small_box(away)))
    assert found is not None
    assert found.verdict is Certainty.UNDECIDED


def test_a_body_that_may_turn_is_known_to_rest_only() -> None:
    """Other wheels come under an outline that turns; at rest it does not turn, and the margin keeps its wheels."""
    scene = standing(load_scene("carton-on-6x6", rule="box"))
    found = decide_robust(replace(scene, tolerances=small_box(scene)))
    assert found is not None
    assert (found.verdict, found.radius, found.factor) == (Certainty.UNDECIDED, None, Fraction(0))
    assert found.rests is not None
    assert Fraction(1, 10) < found.rests <= Fraction(1, 5)


@pytest.mark.parametrize("root", [Fraction(0), Fraction(3, 7), Fraction(1, 10**200), Fraction(10**200)])
def test_a_root_from_above_is_close_and_above_beyond_floats_too(root: Fraction) -> None:
    """A tolerance of 1e-160 was followed for ever, one of 1e160 ended in an OverflowError."""
    found = root_above(root * root)
    assert root <= found <= root * (1 + Fraction(1, 2**38))


@pytest.mark.parametrize("name", ["four-wheel-side", "ring-5"])
def test_slips_and_powers_of_drawn_wheels_lie_in_those_of_the_box(name: str) -> None:
    """Each number of a wheel counts: places, headings, speeds, and both frictions."""
    scene, rng = standing(load_scene(name, rule="box")), np.random.default_rng(4)
    box = small_box(scene).times(Fraction(40))
    wheels = box_wheels(scene, box)
    for _ in range(300):
        model, twist = drawn_model(scene, box, rng, corner=True), rng.normal(size=3)
        moved, forces = (model.rows @ twist).reshape(-1, 2), rng.normal(size=(len(wheels), 2))
        slips, frictions = moved - model.targets.reshape(-1, 2), model.friction.reshape(-1, 2)
        for k, wheel in enumerate(wheels):
            balls = tuple(map(arb, twist.tolist()))
            roll, side = map(arb, forces[k].tolist())
            assert_in(wheel.slips(balls), slips[k])
            assert_in([wheel.power((roll, side), balls)], forces[k : k + 1] @ moved[k])
            assert_in([a * b for a, b in zip(wheel.shares, wheel.nominal, strict=True)], frictions[k])


def assert_in(balls: Sequence[arb], values: Floats) -> None:
    """Whether balls hold numbers, but for the rounding of these."""
    for ball, value in zip(balls, values.tolist(), strict=True):
        assert (ball + arb(0, ROUNDING)).contains(arb(value))


WIDE: dict[str, Any] = {
    "position": 1,
    "heading": Fraction(49, 100),
    "speed": Fraction(99, 100),
    "mu_roll": Fraction(9, 10),
}


@pytest.mark.parametrize("entry", WIDE)
def test_each_tolerance_alone_may_be_too_wide_for_a_disc(entry: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Rims that point almost anywhere, stand almost still, or hardly grip, and wheels at other places."""
    scene, _ = disc_of("four-wheel", "13/20", monkeypatch)
    wide: Any = WIDE[entry] if entry == "heading" else scene.field(WIDE[entry])
    box = replace(small_box(scene).times(Fraction(0)), **{entry: wide})
    assert BoxRingProof(scene).disc(box, Fraction(13, 20)) is None
