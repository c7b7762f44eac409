"""Cells where floats are of little use: coordinates of 1e-300 and 1e300, wheels on one circle but for 1e-300, ties.

Their oracle is a change of units: exact arithmetic does not know how long a length is, so a scaled array has the same
contact states in the same number of cells, and cells add up to the whole square exactly.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

import pytest

from nonsmooth.analysis.cells.box import build_box_partition
from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.lazy import Lazy
from nonsmooth.symbolic.numbers.number_field import NumberField
from tests.conftest import Arrays, WheelData
from tests.four_wheel import CORNERS

TEN = Fraction(10)
BUILDERS: dict[str, Callable[[Scene], Partition]] = {"box": build_box_partition, "nearest": build_nearest_partition}


def four_wheel(
    arrays: Arrays,
    *,
    scale: Fraction = Fraction(1),
    speed: Fraction = Fraction(1),
    off: Fraction = Fraction(0),
    side: Fraction = Fraction(1, 5),
) -> Scene:
    """The four wheels in other units, the first a little off its corner."""
    wheels = [
        WheelData((x * scale + (off if k == 0 else 0), y * scale), (-x, -y), speed) for k, (x, y) in enumerate(CORNERS)
    ]
    return arrays.scene(wheels, (1, side), radius=scale / 2)


def signature(partition: Partition) -> list[tuple[str, ...]]:
    assert partition.tiles
    return sorted(tuple(sorted(state.name for state in cell.states)) for cell in partition.cells)


@pytest.mark.parametrize("build", BUILDERS.values(), ids=BUILDERS)
@pytest.mark.parametrize(("length", "speed"), [(-300, 0), (-160, 160), (160, -160), (300, 0), (0, 300), (0, -300)])
def test_units_do_not_matter(arrays: Arrays, build: Callable[[Scene], Partition], length: int, speed: int) -> None:
    scaled = build(four_wheel(arrays, scale=TEN**length, speed=TEN**speed))
    assert signature(scaled) == signature(build(four_wheel(arrays)))


@pytest.mark.parametrize("side", [Fraction(1, 5), Fraction(1)], ids=["one fifth", "one"])
@pytest.mark.parametrize("exponent", [-300, -17])
def test_a_wheel_that_is_hardly_off_the_circle(arrays: Arrays, exponent: int, side: Fraction) -> None:
    """What no float tells from a tie is told apart: the cells are those of an offset that floats see."""
    for build in BUILDERS.values():
        near = build(four_wheel(arrays, off=TEN**exponent, side=side))
        assert signature(near) == signature(build(four_wheel(arrays, off=TEN**-9, side=side)))


def test_quotients_of_numbers_beyond_floats() -> None:
    field = NumberField()
    small, large = field(TEN**-400), field(TEN**400)
    for numerator, denominator in ((small, small * 3), (large, large * 3)):
        lazy = Lazy.of(numerator) / Lazy.of(denominator)
        assert float(lazy) == 1 / 3
    root = field.sqrt(field(2))
    difference = Lazy(field, (Lazy.of(root) - Lazy.of(root)).ball, lambda: (small * root, large * 0 + small * 2))
    assert float(difference) == pytest.approx(2**0.5 / 2, rel=1e-15)


@pytest.mark.parametrize("length", ["1e-300", "1e150"])
def test_whole_checks(length: str, tmp_path: Path) -> None:
    """Every number of a check under rule ``box`` can be printed."""
    from nonsmooth.reports.checks.check import check_scene

    corners = ((1, 1), (-1, 1), (-1, -1), (1, -1))
    places = [[f"{'-' * (a < 0)}{length}" for a in corner] for corner in corners]
    wheels = "\n".join(f'[[wheel]]\nposition = {place}\nheading = "inward"'.replace("'", '"') for place in places)
    path = tmp_path / "far.toml"
    path.write_text(f'{wheels}\n[friction]\nmu_roll = 1\nmu_side = "1/5"\n[contact]\nrule = "box"\n', encoding="utf-8")
    result, usual = check_scene(load_scene(path)), check_scene(load_scene("four-wheel", rule="box"))
    assert result.evidence.partition is not None
    assert {k: str(v.verdict) for k, v in result.evidence.results.items()} == {
        k: str(v.verdict) for k, v in usual.evidence.results.items()
    }
    assert result.views()
