"""Plain switched systems as a fixture, ``load``, from the text of their right-hand sides; and ``strict_search``."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TypeAlias

import pytest

from nonsmooth.symbolic.files.scene_file import load_system
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.thorough import keep

Load: TypeAlias = Callable[..., SwitchedSystem]


@pytest.fixture
def load(tmp_path: Path) -> Load:
    """A system from its right-hand sides; further keys of [check] as TOML values."""

    def load_system_text(first: str, second: str, **check: str) -> SwitchedSystem:
        keys = "".join(f"{key} = {value}\n" for key, value in check.items())
        text = f'[system]\nstates = ["x", "y"]\nrhs = ["{first}", "{second}"]\n[check]\n{keys}'
        (tmp_path / "my.toml").write_text(text, encoding="utf-8")
        return load_system(tmp_path / "my.toml")

    return load_system_text


@pytest.fixture
def reach_at_large(request: pytest.FixtureRequest) -> None:
    """Verdicts without their reach; further cases of a check, which ``make bench`` runs, have it and verify it."""
    if request.node.get_closest_marker("thorough") is None:
        request.getfixturevalue("without_reach")


@pytest.fixture
def without_far_starts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Reach of verdicts without a search of whether every start comes to the point: for regions, rates and gains."""
    monkeypatch.setattr("nonsmooth.proofs.kernel.whole_space.find_global_attraction", lambda *_: None)


STRICT_SEARCHES = (
    "nonsmooth.proofs.systems.lyapunov_search.find_lyapunov",
    "nonsmooth.proofs.many_states.decision.find_lyapunov",
)


@pytest.fixture(params=keep(1, [False, True]), ids=["at once", "after the search"])
def strict_search(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """For systems of which no V is found that falls strictly: without searching it, and in ``make bench`` after that.

    What comes after is decided alike: the long search of a check finds nothing. That whole checks come to it too is
    shown by test_a_named_energy_decides_with_its_region and test_the_check_asks_the_named_v_after_its_searches.
    """
    if not request.param:
        for search in STRICT_SEARCHES:
            monkeypatch.setattr(search, lambda *_, **__: None)
