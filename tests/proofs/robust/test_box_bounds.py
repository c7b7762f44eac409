"""Rule ``box`` over boxes of parameters, against arrays drawn from them: minimizers by a linear program, and paths."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import TypeAlias

import numpy as np
import pytest
from numpy.typing import NDArray

from nonsmooth.analysis.fields.contact_model import ContactModel
from nonsmooth.analysis.minimizers.box_minimizers import BoxHighs
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.proofs.findings.verdicts import Certainty
from nonsmooth.proofs.robust import rings
from nonsmooth.proofs.robust.box import BoxRingProof
from nonsmooth.proofs.robust.decide import decide_robust
from nonsmooth.proofs.robust.level_sets import AnnulusPiece, polygon_about, ring
from nonsmooth.proofs.robust.rings import EndDisc
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.contact_set import standing
from nonsmooth.symbolic.mechanics.scene import Scene, Tolerance
from nonsmooth.symbolic.mechanics.unknown_loads import UnknownLoads
from tests.thorough import few, keep, thorough

Floats: TypeAlias = NDArray[np.float64]

ROUNDING = 1e-7


def small_box(scene: Scene, factor: Fraction = Fraction(1)) -> Tolerance:
    def share(top: int, bottom: int) -> object:
        return scene.field(Fraction(top, bottom))

    own = Tolerance(share(1, 1000), Fraction(1, 1800), share(1, 500), share(1, 100), share(1, 100), share(0, 1))  # type: ignore[arg-type]
    return own.times(factor)


def drawn(scene: Scene, within: Tolerance, rng: np.random.Generator, *, corner: bool) -> ContactModel:
    """One array of the box, a corner of it or one inside, written anew in floats."""

    def shift(*size: int) -> Floats:
        return rng.choice([-1.0, 1.0], size) if corner else rng.uniform(-1, 1, size)

    n = len(scene.wheels)
    places = np.array([[float(x) for x in wheel.position] for wheel in scene.wheels])
    directions = [[float(x) for x in wheel.unit_direction] for wheel in scene.wheels]
    angles = np.array([np.arctan2(b, a) for a, b in directions]) + np.pi * float(within.heading) * shift(n)
    speeds = np.array([float(wheel.speed) for wheel in scene.wheels]) * (1 + float(within.speed) * shift(n))
    roll = np.array([float(wheel.friction.roll) for wheel in scene.wheels]) * (1 + float(within.mu_roll) * shift(n))
    side = np.array([float(wheel.friction.side) for wheel in scene.wheels]) * (1 + float(within.mu_side) * shift(n))
    rims = np.column_stack([np.cos(angles), np.sin(angles)])
    places = places + float(within.position) * shift(n, 2)
    return ContactModel.build(places, rims, speeds, np.column_stack([roll, side]))


def twists(model: ContactModel, points: Floats) -> Floats:
    return BoxHighs().minimize(model, loads_at(model, points)).twists


def disc_of(name: str, radius: str, monkeypatch: pytest.MonkeyPatch) -> tuple[Scene, EndDisc]:
    """A disc that is found in a few rings."""
    monkeypatch.setattr(rings, "RINGS", 8)
    monkeypatch.setattr(BoxRingProof, "halvings", 0)
    scene = load_scene(name, rule="box", radius=radius).recentred()
    found = BoxRingProof(scene).disc(small_box(scene), Fraction(radius))
    assert found is not None
    return scene, found


@few(1)
@pytest.mark.parametrize(("name", "radius"), [("four-wheel", "13/20"), ("ring-5", "9/20"), ("ring-6", "9/20")])
def test_no_array_of_the_box_breaks_the_rate(name: str, radius: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Corners of the box and arrays inside it, each at points between the disc and the starts."""
    scene, found = disc_of(name, radius, monkeypatch)
    within, rng = small_box(scene), np.random.default_rng(1)
    for k in range(24):
        model = drawn(scene, within, rng, corner=k % 2 == 0)
        sizes = rng.uniform(float(found.radius), float(found.start), 6)
        angles = rng.uniform(0, 2 * np.pi, 6)
        points = sizes[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
        falling = (points * twists(model, points)[:, :2]).sum(axis=1)
        assert (falling <= -float(found.kappa) * sizes + ROUNDING).all()


@thorough  # the small one: test_no_array_of_the_box_breaks_the_rate
def test_paths_end_in_the_disc_in_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """Euler's steps; a path may be outside by a step, for it slides along borders of cells."""
    scene, found = disc_of("four-wheel", "7/10", monkeypatch)
    within, rng = small_box(scene), np.random.default_rng(2)
    time = float(found.within)
    for k in range(3):
        model = drawn(scene, within, rng, corner=k < 2)
        angles = rng.uniform(0, 2 * np.pi, 4)
        points = float(found.start) * np.column_stack([np.cos(angles), np.sin(angles)])
        step = time / 60
        for _ in range(60):
            moved = twists(model, points)
            points = points + step * (moved[:, :2] + moved[:, 2:] * np.column_stack([-points[:, 1], points[:, 0]]))
        assert np.hypot(*points.T).max() <= float(found.radius) + 2 * step


@pytest.mark.parametrize("name", keep(2, ["four-wheel", "rectangle", "ring-6", "grid-4x4"]))
def test_every_body_within_the_rest_disc_stays_where_it_is(name: str) -> None:
    scene = load_scene(name, rule="box").recentred()
    within, rng = small_box(scene), np.random.default_rng(3)
    radius = BoxRingProof(scene).rest_radius(within, Fraction(1, 2))
    assert radius > Fraction(1, 5)
    for k in range(12):
        model = drawn(scene, within, rng, corner=k % 2 == 0)
        angles = rng.uniform(0, 2 * np.pi, 4)
        points = float(radius) * np.column_stack([np.cos(angles), np.sin(angles)])
        assert np.abs(twists(model, points)).max() < 1e-8


def test_without_tolerances_the_rest_disc_is_that_of_the_closed_form() -> None:
    """The four-wheel array rests where ``|x| + |y| <= mu_S/mu_R``: a disc of radius ``sqrt(1/8)``."""
    scene = load_scene("four-wheel", rule="box").recentred()
    rule, none = BoxRingProof(scene), small_box(scene, Fraction(0))
    exact = 8**-0.5
    assert exact * 0.95 < float(rule.rest_radius(none, Fraction(1, 2))) <= exact
    assert rule.rest_radius(none, Fraction(1, 5)) == Fraction(1, 5)


def test_a_larger_box_breaks_what_is_said() -> None:
    """At the rest disc's edge some corner of a box twenty times as large moves."""
    scene = load_scene("four-wheel", rule="box").recentred()
    radius = float(BoxRingProof(scene).rest_radius(small_box(scene), Fraction(1, 2)))
    rng, angles = np.random.default_rng(4), np.pi / 4 * np.arange(8)
    points = radius * np.column_stack([np.cos(angles), np.sin(angles)])
    models = [drawn(scene, small_box(scene, Fraction(20)), rng, corner=True) for _ in range(20)]
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
    assert all(x * x + y * y > Fraction(1, 4) for x, y in polygon_about(Fraction(1, 2), 16))


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


def test_what_is_not_followed_is_undecided() -> None:
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
