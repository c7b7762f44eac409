"""Plain systems of formulas, as a file of them would be read, and what the checker says of certificates about them."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import nonsmooth as ns
from nonsmooth.proofs.checker.statements import refusal
from nonsmooth.proofs.system_decision import StabilityResult, decide_system
from nonsmooth.symbolic.files.system_builder import build_system
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem


def built(
    rhs: Sequence[Any], parameters: Mapping[str, Any] | None = None, states: Sequence[str] = "xyzuvw", **check: Any
) -> SwitchedSystem:
    """A system.

    Args:
        rhs: a formula for each state, or such a list for each side that may act.
        parameters: numbers and intervals by their names.
        states: the names of the states; of more than there are formulas the first ones are taken.
        check: what stands under ``[check]``.
    """
    count = len(rhs) if isinstance(rhs[0], str) else len(rhs[0])
    system: dict[str, Any] = {"states": list(states[:count]), "rhs": list(rhs)}
    if parameters:
        system["parameters"] = dict(parameters)
    return build_system({"system": system, "check": check}, "t", Path("t.toml"))


def decided(rhs: Sequence[Any], **check: Any) -> StabilityResult:
    """What the whole search finds of a system."""
    return decide_system(built(rhs, **check))


def refused(record: Any) -> str:
    """Why the checker rejects a certificate that was written and read; empty where it does not."""
    text = json.dumps(record)
    return refusal(json.loads(text), len(text))


def stated(text: str, **options: Any) -> ns.System:
    """A system of Python in x, y and z: its formulas, with semicolons between them."""
    rhs = [side.strip() for side in text.split(";")]
    return ns.System(list("xyz"[: len(rhs)]), rhs, **options)


def decided_with_certificate(system: ns.System, verdict: str) -> ns.SystemCheckResult:
    """The check of a system, of which the verdict is this one, and stated by a certificate that the checker accepts."""
    result = system.check()
    assert result.verdict == verdict
    certificate = result.certificate()
    assert {"stability": verdict} in certificate["statement"]["claims"]
    assert not refused(certificate)
    return result
