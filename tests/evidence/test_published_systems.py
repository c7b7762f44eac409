"""The study of published systems, small: its measure against areas that are known, its table, and one region."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from nonsmooth.proofs.systems.basin import EFFORTS
from nonsmooth.proofs.systems.basin_mesh import BasinEffort
from nonsmooth.proofs.systems.basin_rings import RingGrowth
from nonsmooth.symbolic.files.system_builder import build_system
from tests.evidence import published_systems as study
from tests.thorough import thorough

IN_DISC = next(known for known in study.systems() if known.name == "inside the unit circle")


@pytest.fixture
def few_starts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(study, "SAMPLED", 400)


@pytest.mark.usefixtures("few_starts")
def test_a_share_near_the_point_is_that_of_areas() -> None:
    """Of the unit disc, which is the basin, a disc of half the radius is a quarter."""
    document = {"system": {"states": list(IN_DISC.states), "rhs": list(IN_DISC.rhs)}, "check": {"radius": "1/2"}}
    scene = build_system(document, IN_DISC.name, Path("published.toml"))
    share = study.share_near(scene, lambda x: np.asarray(np.linalg.norm(x, axis=1) < 0.5), np.ones(2))
    assert share == pytest.approx(0.25, abs=0.04)


def examined(starts: int, share: float) -> dict[str, Any]:
    """The system as the table shows it, with that share of the basin at least."""
    own: dict[str, Any] = study.examined(IN_DISC, "best", starts)
    assert own["verdict"] == IN_DISC.truth
    assert own["astray"] == 0
    assert min(own["share"], own["near"]) >= share
    return own


@thorough  # the test below searches less
def test_a_region_with_more_effort_is_large() -> None:
    examined(300, 0.95)


@pytest.mark.usefixtures("few_starts")
def test_a_region_with_more_effort_is_in_the_second_table(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(EFFORTS, "best", BasinEffort(RingGrowth(0.2, 0.1, 0.08), 11))
    own = examined(100, 0.6)
    page = tmp_path / "page.md"
    page.write_text("<!-- systems -->\nkept\n<!-- end -->\n<!-- best -->\n<!-- end -->\n", encoding="utf-8")
    study.write(page, [(IN_DISC, own)], "best")
    written = page.read_text(encoding="utf-8")
    assert written.startswith("<!-- systems -->\nkept\n<!-- end -->\n<!-- best -->\n1 systems: 0 wrong")
    assert "| inside the unit circle |" in written


def test_the_choice_is_of_known_systems() -> None:
    assert set(study.BEST) <= {known.name for known in study.systems()}
