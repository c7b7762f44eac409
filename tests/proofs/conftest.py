"""Plain switched systems as a fixture: ``load`` reads one from the text of its right-hand sides."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TypeAlias

import pytest

from nonsmooth.symbolic.files.system_file import load_system
from nonsmooth.symbolic.switched_system import SwitchedSystem

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
