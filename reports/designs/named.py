"""Any search for a design, by what may change, and the name of what it finds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from nonsmooth.reports.designs.fewest import find_fewest
from nonsmooth.reports.designs.freedom import WHEELS, Freedom
from nonsmooth.reports.designs.search import Design, Told, Wish, find_design
from nonsmooth.symbolic.scene import Scene


def find_named(base: Mapping[str, Any], folder: Path, scene: Scene, freedom: Freedom, wish: Wish, told: Told) -> Design:
    """What :func:`nonsmooth.reports.designs.search.find_design` or ``find_fewest`` finds, with a name and a source."""
    if freedom.kinds == (WHEELS,):
        design = find_fewest(base, folder, scene, freedom.order, wish, told)
    else:
        design = find_design(base, folder, scene, freedom, wish, told)
    how = f"designed from {scene.name}: {', '.join(wish.required)} required, {wish.maximize} maximized"
    rest = {key: value for key, value in design.document.items() if key not in ("name", "description")}
    return replace(design, document={"name": f"{scene.name}-designed", "description": how, **rest})
