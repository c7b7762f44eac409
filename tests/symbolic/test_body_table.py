"""``[body]``: footprints from their centroid, and what is refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.body import Disc, Footprint, PolygonShape
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.scene_error import SceneError

HEAD = '[friction]\nmu_roll = 1\nmu_side = "1/2"\n[ring]\ncount = 4\n[body]\n'


def footprint(folder: Path, text: str) -> Footprint:
    file = folder / "my.toml"
    file.write_text(HEAD + text)
    body = load_scene(file).body
    assert body is not None
    return body.outline


def texts(shape: Footprint) -> list[tuple[str, str]]:
    assert isinstance(shape, PolygonShape)
    return [(str(x), str(y)) for x, y in shape.vertices]


def test_discs_and_rectangles(tmp_path: Path) -> None:
    disc = footprint(tmp_path, 'shape = "disc"\nradius = "sqrt(2)/2"\n')
    assert isinstance(disc, Disc)
    assert str(disc.radius) == "sqrt(2)/2"
    box = footprint(tmp_path, 'shape = "rectangle"\nwidth = "sin(pi/5)"\nheight = 0.5\n')
    assert [y for _, y in texts(box)] == ["-1/4", "-1/4", "1/4", "1/4"]
    assert isinstance(box, PolygonShape)
    assert box.is_centrally_symmetric


@pytest.mark.parametrize("vertices", ["[[0, 0], [3, 0], [0, 3]]", "[[0, 3], [3, 0], [0, 0]]"])
def test_polygons_are_turned_counterclockwise_about_their_centroid(vertices: str, tmp_path: Path) -> None:
    found = footprint(tmp_path, f'shape = "polygon"\nvertices = {vertices}\n')
    assert set(texts(found)) == {("-1", "-1"), ("2", "-1"), ("-1", "2")}
    assert isinstance(found, PolygonShape)
    (a, b), (c, d), (e, f) = found.vertices
    assert ((c - a) * (f - b) - (d - b) * (e - a)).sign() > 0
    assert not found.is_centrally_symmetric


def test_corners_of_half_a_turn_are_allowed(tmp_path: Path) -> None:
    found = footprint(tmp_path, 'shape = "polygon"\nvertices = [[0,0],[1,0],[2,0],[2,2],[1,2],[0,2]]\n')
    assert isinstance(found, PolygonShape)
    assert found.is_centrally_symmetric
    assert len(found.vertices) == 6


CROSSED = "[[0, 0], [1, 1], [1, 0], [0, 1]]"
TOUCHING = "[[0, 0], [2, 0], [2, 2], [1, 0], [0, 2]]"
FOLDED = "[[0, 0], [2, 0], [1, 0], [1, 1]]"
OVERLAPPING = "[[0, 0], [3, 0], [3, 1], [2, 1], [2, 0], [1, 0], [1, 1], [0, 1]]"
REPEATED = "[[0, 0], [0, 0], [1, 0], [1, 1]]"
FLAT = "[[0, 0], [1, 0], [2, 0]]"


@pytest.mark.parametrize(
    ("text", "key"),
    [
        ('shape = "disc"\n', "body.radius"),
        ('shape = "disc"\nradius = 0\n', "body.radius"),
        ('shape = "disc"\nradius = 1\nwidth = 1\n', "body.width"),
        ('shape = "rectangle"\nwidth = 1\n', "body.height"),
        ('shape = "rectangle"\nwidth = 1\nheight = -1\n', "body.height"),
        ('shape = "star"\n', "body.shape"),
        ("radius = 1\n", "body.shape"),
        ('shape = "disc"\nradios = 1\n', "body.radios"),
        ('shape = "polygon"\nvertices = [[0, 0], [1, 0]]\n', "body.vertices"),
        ('shape = "polygon"\nvertices = [[0, 0], [1, 0], [0, "x"]]\n', "body.vertices"),
        *(
            (f'shape = "polygon"\nvertices = {bad}\n', "body.vertices")
            for bad in (CROSSED, TOUCHING, FOLDED, OVERLAPPING, REPEATED, FLAT)
        ),
    ],
)
def test_bad_objects_are_refused(text: str, key: str, tmp_path: Path) -> None:
    with pytest.raises(SceneError) as caught:
        footprint(tmp_path, text)
    assert caught.value.key == key
    assert "\n" not in str(caught.value)


MILLIMETRES = '[units]\nlength = "mm"\n'


def heavy(folder: Path, text: str, units: str = MILLIMETRES) -> Scene:
    file = folder / "heavy.toml"
    wheels = '[ring]\ncount = 4\n[friction]\nmu_roll = "1/2"\nmu_side = "1/4"\n[contact]\nrule = "ellipse"\n'
    file.write_text(f"{units}{wheels}{text and '[body]'}\n{text}")
    return load_scene(file)


def test_gravity_is_known_where_a_unit_of_length_is_stated(tmp_path: Path) -> None:
    known = heavy(tmp_path, "").inertia
    assert known is not None
    assert (float(known.gravity), known.squared_radius, known.is_stated) == (9806.65, None, False)
    assert heavy(tmp_path, "", units="").inertia is None
    on_the_moon = heavy(tmp_path, "gravity = 1620").inertia
    assert on_the_moon is not None
    assert float(on_the_moon.gravity) == 1620


def test_mass_cancels_and_inertia_counts_by_its_share(tmp_path: Path) -> None:
    light, heavier = (heavy(tmp_path, f"mass = {mass}\ninertia = {mass * 300}") for mass in (1, 7))
    for scene in (light, heavier):
        assert scene.inertia is not None
        assert scene.inertia.squared_radius == 300
    assert light.body is None
    plain = heavy(tmp_path, "mass = 3").inertia
    assert plain is not None
    assert plain.squared_radius is None


@pytest.mark.parametrize(
    ("text", "units", "key", "received"),
    [
        ("mass = 0", MILLIMETRES, "body.mass", "0"),
        ("gravity = -1", MILLIMETRES, "body.gravity", "-1"),
        ("mass = 1\ninertia = -2", MILLIMETRES, "body.inertia", "-2"),
        ("inertia = 2", MILLIMETRES, "body.inertia", "no mass"),
        ("centre_height = -1", MILLIMETRES, "body.centre_height", "-1"),
        ("centre_height = 1", "", "body.centre_height", "no unit of length"),
        ("mass = 2", "", "body.mass", "no unit of length"),
        ("gravity = 9", "", "body.gravity", "no unit of length"),
        ("mass = 2\nheading = 3", MILLIMETRES, "body.shape", "none, beside heading"),
    ],
)
def test_numbers_that_say_nothing_of_inertia_are_refused(
    text: str, units: str, key: str, received: str, tmp_path: Path
) -> None:
    with pytest.raises(SceneError) as caught:
        heavy(tmp_path, text, units)
    assert caught.value.key == key
    assert str(caught.value).endswith(f"received {received}")
    assert "\n" not in str(caught.value)
