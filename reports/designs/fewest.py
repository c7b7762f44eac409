"""How few wheels of an array suffice: all choices of its wheels that keep its symmetry, the smallest first.

Every choice is an exact scene that is checked, so that where all smaller ones are refuted none of them suffices.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import Any

from nonsmooth.reports.designs.objective import OBJECTIVES, Evaluation, evaluate
from nonsmooth.reports.designs.search import Design, Fewest, Told, Wish
from nonsmooth.reports.designs.symmetry import Orbits, orbits_of
from nonsmooth.symbolic.contact_set import standing
from nonsmooth.symbolic.files.one_by_one import one_by_one
from nonsmooth.symbolic.files.scene_file import build_scene
from nonsmooth.symbolic.scene import Scene

LEAST = 2  # wheels: under no rule a body stands on fewer


def find_fewest(base: Mapping[str, Any], folder: Path, scene: Scene, order: int, wish: Wish, told: Told) -> Design:
    """The smallest choice of the wheels under the body that meets what is required; of that size the best.

    Args:
        base: the document of the given scene.
        folder: where its files lie.
        scene: the same, read.
        order: of the symmetry that choices keep.
        wish: what is asked for.
        told: called with the choices checked and allowed.
    """
    under = standing(scene)
    own = evaluate(scene, wish.required, OBJECTIVES[wish.maximize])
    orbits = orbits_of(under, order) or tuple((k,) for k in range(len(under.wheels)))
    best: tuple[Evaluation, dict[str, Any], Scene] | None = None
    checks = undecided = 0
    for chosen in _choices(orbits):
        if best is not None and len(chosen) > len(best[2].wheels):
            break
        if checks >= wish.checks:
            break
        document = _document(base, under, chosen)
        candidate = build_scene(document, scene.name, folder / f"{scene.name}.toml")
        found = evaluate(candidate, wish.required, OBJECTIVES[wish.maximize])
        checks += 1
        told(checks, wish.checks)
        undecided += bool(found.unmet) and not found.is_refuted
        if not found.unmet and (best is None or found.cost < best[0].cost):
            best = found, document, candidate
    count = None if best is None else len(best[2].wheels)
    fewest = Fewest(count, undecided, checks < wish.checks or best is not None, len(orbits[0]))
    if best is None:
        return Design(dict(base), scene, own, own, checks, fewest=fewest)
    return Design(best[1], best[2], best[0], own, checks, fewest=fewest)


def _choices(orbits: Orbits) -> Iterator[tuple[int, ...]]:
    """Sets of wheels made of whole orbits, which have one size, by their number."""
    for count in range(1, len(orbits) + 1):
        for some in combinations(orbits, count):
            chosen = sorted(wheel for orbit in some for wheel in orbit)
            if len(chosen) >= LEAST:
                yield tuple(chosen)


def _document(base: Mapping[str, Any], scene: Scene, chosen: tuple[int, ...]) -> dict[str, Any]:
    return one_by_one(base, replace(scene, wheels=tuple(scene.wheels[place] for place in chosen)))
