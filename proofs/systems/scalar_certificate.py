"""Certificates of plain systems in one state: the verdict and the starts that reach the point.

The stand-alone checker (:mod:`nonsmooth.proofs.system_checker`) reads the formulas and finds the signs of all fields
on either side of the point itself, so a certificate holds the statement alone.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from nonsmooth.proofs.system_checker import SCALAR_SCHEMA, check_certificate
from nonsmooth.proofs.systems.scalar_stability import ScalarResult
from nonsmooth.proofs.systems.system_certificate import (
    NoCertificateError,
    about,
    accepted,
    exact_text,
    notes,
    require_no_roots,
)
from nonsmooth.proofs.verdicts import Translation
from nonsmooth.symbolic.numbers.number import Number

FINE = 1 << 20  # an end with roots is certified up to this part of its distance


def build_scalar_certificate(result: ScalarResult) -> dict[str, Any]:
    """The certificate of a verdict in one state, accepted by the stand-alone checker.

    Args:
        result: of a check.

    Raises:
        NoCertificateError: for an undecided verdict, for numbers with roots, and where the checker does not show all
            of it within its limits.
    """
    require_no_roots(result.scene)
    if result.verdict is Translation.UNDECIDED:
        raise NoCertificateError("a certificate needs a verdict, received undecided")
    system = result.scene
    certificate = {
        "schema": SCALAR_SCHEMA,
        **about(system),
        "verdict": str(result.verdict),
        "starts": _starts(result),
        "notes": notes(system),
    }
    return accepted(certificate, check_certificate)


def _starts(result: ScalarResult) -> list[str] | None:
    """The ends of the interval of starts that reach the point."""
    right, left = result.right.reach, result.left.reach
    if result.verdict is not Translation.ASYMPTOTICALLY_STABLE or right is None or left is None:
        return None
    at = Fraction(exact_text(result.scene.check.equilibrium[0]))
    return [str(at - _within(left)), str(at + _within(right))]


def _within(reach: Number | Fraction) -> Fraction:
    """A rational distance: the same, or where it has roots one a little smaller."""
    known = reach if isinstance(reach, Fraction) else reach.as_rational()
    if known is not None:
        return Fraction(int(known.numerator), int(known.denominator))
    unit = Fraction(1)
    while not reach > unit * FINE:
        unit /= 2
    while reach > unit * FINE * 2:
        unit *= 2
    below, above = FINE, 2 * FINE  # reach > unit * below
    while above - below > 1:
        middle = (below + above) // 2
        below, above = (middle, above) if reach > unit * middle else (below, middle)
    return unit * below
