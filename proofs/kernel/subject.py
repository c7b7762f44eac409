"""The subject of a certificate of a plain system, and the numbers that certificates can hold."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.scene_error import one_line
from nonsmooth.symbolic.switched_system import SwitchedSystem


class NoCertificateError(ValueError):
    """A verdict that has no certificate, in one line."""


def about(system: SwitchedSystem) -> dict[str, Any]:
    """What a certificate is about; where roots of states stand for these, what was stated, and of which states.

    Raises:
        NoCertificateError: for a point that no certificate can name.
    """
    at = system.check.equilibrium
    if system.by_roots is not None:
        names, rooted = system.by_roots.roots.states, system.by_roots.roots.rooted
        stated = [z * abs(z) if name in rooted else z for name, z in zip(names, at, strict=True)]
        rhs = [[one_line(formula) for formula in member] for member in system.written]
        return {"states": list(names), "rhs": rhs, "at": list(map(exact_text, stated)), "roots": list(rooted)}
    return {
        "states": list(system.states),
        "rhs": [[one_line(side.text) for side in member.rhs] for member in system.members],
        "at": [exact_text(value) for value in at],
    }


def exact_text(value: Number | Fraction) -> str:
    """A rational number as certificates write it.

    Raises:
        NoCertificateError: for a number with roots.
    """
    text = str(value)
    if not set(text) <= set("-0123456789/"):
        raise NoCertificateError(f"a certificate of a plain system needs rational numbers, received {text[:60]}")
    return text
