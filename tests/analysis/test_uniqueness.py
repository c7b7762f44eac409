"""Paths are called unique only where nothing else was left open."""

from __future__ import annotations

from pathlib import Path

import pytest

from nonsmooth.analysis.fields.system_field import system_field
from nonsmooth.analysis.trajectories.result import Trajectory
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.symbolic.files.system_file import load_system


def follow(tmp_path: Path, rhs: list[str], start: list[float]) -> Trajectory:
    file = tmp_path / "my.toml"
    states = ["x", "y", "z"][: len(rhs)]
    file.write_text(f"[system]\nstates = {states}\nrhs = {rhs}\n", encoding="utf-8")
    return simulate(system_field(load_system(file), start), start, 1.0)


def squeezed(first: str, second: str) -> list[str]:
    """(1, 3 x) between two curves, of which y = 3 x^2/2 is a solution; (0, -1) outside."""
    inside = f"(1 - sign({first})*sign({second}))/2"
    return [inside, f"3*x*{inside} - (1 - {inside})"]


def test_a_cell_squeezed_between_tangent_curves_may_be_entered(tmp_path: Path) -> None:
    """From the origin both (0, -t) and (t, 3 t^2/2) are solutions; no tangent cone shows the second cell."""
    path = follow(tmp_path, squeezed("y - x**2", "y - 2*x**2"), [0.0, 0.0])
    assert path.unique is None
    assert any("touch here" in event.note for event in path.events)


@pytest.mark.parametrize(
    ("rhs", "start"),
    [
        (["-sign(y - x**2)", "-1"], [0.25, 1.0]),  # one curve is crossed
        (["-sign(x + y) - sign(x - y)", "-sign(x + y) + sign(x - y)"], [0.0, 0.0]),  # lines through one point
        (["-sign(x)", "-sign(y - x**2)"], [0.0, 0.0]),  # transversal, one of them curved
        (["-sign(x)", "-sign(y)", "-sign(z)"], [0.1, 0.2, 0.1]),
        (squeezed("y - x**2", "y - 2*x**2"), [0.5, 0.375]),  # inside the narrow cell, away from the contact
    ],
)
def test_transversal_surfaces_leave_no_doubt(tmp_path: Path, rhs: list[str], start: list[float]) -> None:
    assert follow(tmp_path, rhs, start).unique
