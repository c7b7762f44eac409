"""What a large table of wheels costs: no formula is parsed for a plain number, and few wheels are looked at twice."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.cells.equilibria import find_equilibria
from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.proofs import theorem4
from nonsmooth.symbolic.files import scene_values
from nonsmooth.symbolic.files.wheel_csv import parse_wheels
from nonsmooth.symbolic.mechanics.constraints import Triple, independent
from nonsmooth.symbolic.mechanics.scene import Scene
from tests.conftest import Arrays


def test_plain_directions_never_reach_the_formula_parser(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*arguments: object) -> None:
        raise AssertionError(f"required no formula, received {arguments}")

    monkeypatch.setattr(scene_values, "parse", refuse)
    table = parse_wheels('x,y,heading,speed\n0.1,0.2,"[0.6, 0.8]",1.5\n0.3,0.4,"[ -1 ,0 ]",2\n', "w.csv", "my.toml")
    assert len(table.rows) == 2


def test_equilibria_are_judged_among_few_wheels(arrays: Arrays, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each of them built a partition of the whole array before."""
    scene = arrays.grid(20, 20, radius=2).recentred()
    found = find_equilibria(build_nearest_partition(scene))
    assert found
    sizes: list[int] = []
    build = build_partition

    def counted(own: Scene, **options: bool) -> Partition:
        sizes.append(len(own.wheels))
        return build(own, **options)

    monkeypatch.setattr(theorem4, "build_partition", counted)
    theorem4.judge_equilibria(scene, found)
    assert sizes
    assert max(sizes) < 30


def test_rows_are_looked_at_until_three_are_independent(arrays: Arrays) -> None:
    looked_at: list[int] = []

    def rows() -> Iterator[Triple]:
        one, zero = scene.field.one, scene.field.zero
        for k, row in enumerate([(zero, zero, zero), (one, zero, zero), (one + one, zero, zero), (zero, one, zero)]):
            looked_at.append(k)
            yield row
        for k in range(4, 100):
            looked_at.append(k)
            yield (one, one, one)

    scene = arrays.four_wheel()
    assert independent(rows()) == (1, 3, 4)
    assert looked_at == [0, 1, 2, 3, 4]
