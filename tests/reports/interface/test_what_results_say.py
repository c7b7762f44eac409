"""What results and scenes say of themselves when they are printed, and show of themselves in a notebook."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

import nonsmooth as ns

FEW_LINES, WIDEST = 12, 240


def array(name: str) -> ns.Array:
    found = ns.load(name)
    assert isinstance(found, ns.Array)
    return found


def relays() -> ns.System:
    return ns.System(["x", "y"], ["-x - sign(y)/2", "sign(x) - y"])


SAID: dict[str, Callable[[], Any]] = {
    "an array": lambda: array("four-wheel"),
    "a vehicle": lambda: ns.Vehicle.load("husky-a200"),
    "a check": lambda: relays().check(),
    "a map of a system": lambda: relays().map(3, until=2),
    "an orbit": lambda: ns.System(["x", "y"], ["y", "-x + y/10 - sign(y)/10"]).orbit((1.3, 0), until=12),
    "a design": lambda: array("ring-5").design(checks=1),
}


@pytest.mark.parametrize("name", SAID)
def test_it_prints_in_a_few_lines(name: str) -> None:
    lines = repr(SAID[name]()).splitlines()
    assert 0 < len(lines) <= FEW_LINES
    assert max(map(len, lines)) <= WIDEST
    assert " object at 0x" not in lines[0]


def test_an_array_and_a_region_show_themselves_in_a_notebook() -> None:
    assert array("four-wheel")._repr_html_().count("<svg") == 1
    region = ns.System(["x", "y"], ["-x + y**3/4", "-y - x*y"]).larger_region(2)
    assert region is not None
    assert "certified region" in region._repr_html_()
    assert region.formula.text in region._repr_html_()
