"""Certificates of systems in one state: a function V of the displacement, on the intervals between switchings.

The point attracts with ``V = (x/a)^2`` left and ``(x/b)^2`` right of it, below the level 1 on ``(-a, b)``; it is
stable with ``V = x^2``; a solution leaves it where V falls and is negative, or along one field that leads away.  The
signs of the fields beside the point say which of these to write, and the checker shows it.  All is about the
displacement from the point, or about that of the signed root where the state has one.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from math import prod
from typing import Any, TypeAlias

from flint import arb, fmpq, fmpq_poly

from nonsmooth.proofs.checker.cells import Domain, System, pattern
from nonsmooth.proofs.checker.formulas import SignOf
from nonsmooth.proofs.checker.polynomials import Polynomial
from nonsmooth.proofs.checker.theorems import ASYMPTOTICALLY_STABLE, STABLE
from nonsmooth.proofs.checker.work import RejectedError
from nonsmooth.proofs.kernel.cells import BeyondReachError
from nonsmooth.proofs.kernel.search import stability_hypotheses
from nonsmooth.proofs.kernel.subject import NoCertificateError
from nonsmooth.proofs.kernel.written import terms_of
from nonsmooth.proofs.systems.findings import DecidedSystem
from nonsmooth.proofs.verdicts import Equilibrium, Translation
from nonsmooth.symbolic.numbers.coefficients import as_fraction
from nonsmooth.symbolic.numbers.number import Number

FINE = 1 << 20  # an end with roots is certified up to this part of its distance
WIDEST = Fraction(1)  # half the interval on which local verdicts are certified, at most

Pattern: TypeAlias = tuple[int, ...]
Theorem: TypeAlias = tuple[str, dict[str, Any]]  # its name, and its hypotheses


def scalar_theorem(result: DecidedSystem, system: System) -> Theorem:
    """The theorem that shows a verdict in one state, with its hypotheses.

    Args:
        result: of a check, not undecided.
        system: of the certificate.

    Raises:
        NoCertificateError: for formulas and points that no certificate can hold, and for a solution that leaves where
            right-hand sides only enclose the field.
    """
    try:
        if result.verdict is Translation.ASYMPTOTICALLY_STABLE:
            return _attraction(result, system)
        if result.verdict is Translation.STABLE:
            return _rest(system)
        found = _departure(system) if result.equilibrium is Equilibrium.FAILS else _leaving(system)
        if found[0] == "escape" and result.scene.only_encloses:
            raise NoCertificateError("one solution of fields that are only enclosed says nothing of the stated one")
        return found
    except RejectedError as error:
        raise NoCertificateError(f"a certificate requires {error}") from None


# ---- theorems and their functions V ------------------------------------------------------------


def _attraction(result: DecidedSystem, system: System) -> Theorem:
    """``V < 1`` exactly on the interval of starts that reach the point."""
    (name,) = system.coordinates
    sides = result.deciding.proofs
    right, left = (within(side.reach) for side in (sides.right, sides.left) if side.reach is not None)
    function = f"relu({name})**2/({right**2}) + relu(-{name})**2/({left**2})"
    if left == right:
        function = f"{name}**2/({right**2})"
    cells = stated_intervals(system, max(left, right))
    return "lyapunov", {**stability_hypotheses(cells, function, ASYMPTOTICALLY_STABLE), "level": "1", "below": True}


def _rest(system: System) -> Theorem:
    """``V = x^2``, near the point."""
    cells = stated_intervals(system, clear_radius(system))
    return "lyapunov", stability_hypotheses(cells, f"{system.coordinates[0]}**2", STABLE)


def _departure(system: System) -> Theorem:
    """All velocities at the point have one sign."""
    sides = fields_beside(system)
    upward = max(field.at_origin for fields in sides for field in fields) > 0
    cells = stated_intervals(system, clear_radius(system))
    return "departure", {"cells": cells, "direction": ["1" if upward else "-1"]}


def _leaving(system: System) -> Theorem:
    """Every solution that starts on one side leaves, or one solution does.

    Where all fields of each side have one sign, V is the distance on a side where they lead back, and minus it where
    they lead away: that holds for all that several right-hand sides may enclose.  Else one of them is followed.
    """
    (name,) = system.coordinates
    radius = clear_radius(system)
    cells = stated_intervals(system, radius)
    left, right = (
        [turn * _sign_beside(field, turn) for field in fields]
        for turn, fields in zip((-1, 1), fields_beside(system), strict=True)
    )
    turn, outward = (1, right) if max(right) > 0 else (-1, left)
    if abs(sum(left)) == len(left) and abs(sum(right)) == len(right):
        function = f"-{name}" if sum(left) < sum(right) else name if sum(left) > sum(right) else f"-Abs({name})"
        return "instability", {"cells": cells, "function": function, "second": None, "direction": [str(turn)]}
    signs = pattern(_sign(surface, turn * radius / 2) for surface in build_intervals(system, radius).surfaces)
    field = [signs, outward.index(max(outward)), "1", [str(turn)]]
    start = {"within": str(radius), "surfaces": cells["surfaces"], "signs": signs, "direction": [str(turn)]}
    rising = name if turn > 0 else f"-{name}"
    return "escape", {**start, "along": [], "mixture": [field], "barriers": [], "function": rising}


def within(reach: Number | Fraction) -> Fraction:
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


# ---- intervals ---------------------------------------------------------------------------------


@dataclass(frozen=True)
class SmoothIntervals:
    """The displacements between which nothing switches.

    Attributes:
        surfaces: irreducible polynomials of which all switching expressions are products; the displacement is first.
        places: a displacement in each interval, ascending.
        fields: the right-hand sides there.
    """

    surfaces: tuple[fmpq_poly, ...]
    places: tuple[Fraction, ...]
    fields: tuple[tuple[Polynomial, ...], ...]


def build_intervals(system: System, radius: Fraction) -> SmoothIntervals:
    """The intervals of a system within a distance from the point.

    The formulas are read at a place of each interval; where they ask for the sign of a polynomial with factors that
    are not known yet, the intervals are cut at the roots of these, and read again.
    """
    formulas = [formula for (formula,) in system.fields(Domain(system, None).place)]
    surfaces = [fmpq_poly([0, 1])]
    while True:
        known = tuple(surfaces)
        places = tuple(_places_between(known, radius))
        fields = tuple(tuple(formula.on(_signs_at(place, surfaces)) for formula in formulas) for place in places)
        if len(surfaces) == len(known):
            return SmoothIntervals(known, places, fields)


def _signs_at(place: Fraction, surfaces: list[fmpq_poly]) -> SignOf:
    """The sign of a switching expression at a place; its factors are added to the surfaces."""

    def sign_of(value: Polynomial) -> int:
        own = _dense(value)
        for factor, _ in own.numer().factor()[1]:
            if fmpq_poly(factor) not in surfaces:
                surfaces.append(fmpq_poly(factor))
        return _sign(own, place) or 1

    return sign_of


def _dense(value: Polynomial) -> fmpq_poly:
    """A polynomial, or a positive multiple of it that has rational coefficients.

    Raises:
        BeyondReachError: where there is none.
    """
    terms = terms_of(value)
    if any(isinstance(c, Number) for c in terms.values()):
        lead = abs(terms[max(terms)])
        shares = {e: _rational(c / lead) for e, c in terms.items()}
        if None in shares.values():
            raise BeyondReachError("numbers with roots in one state")
        terms = shares
    return fmpq_poly([terms.get((k,), fmpq(0)) for k in range(value.degree + 1)])


def _rational(value: Number | fmpq) -> fmpq | None:
    return value.as_rational() if isinstance(value, Number) else value


def _sign(polynomial: fmpq_poly, place: Fraction) -> int:
    found = polynomial(fmpq(place.numerator, place.denominator))
    return int(found > 0) - int(found < 0)


def _sign_beside(field: Polynomial, turn: int) -> int:
    """The sign of a polynomial at small displacements to the left (-1) or the right (1)."""
    lowest = min(field.terms, default=None)
    if lowest is None:
        return 0
    return (1 if field.terms[lowest] > 0 else -1) * turn ** lowest[0]


def _places_between(polynomials: Sequence[fmpq_poly], radius: Fraction) -> Iterator[Fraction]:
    """Between each two neighbouring roots of some polynomials within a distance from zero, a rational number."""
    end = fmpq(radius.numerator, radius.denominator)
    total = prod(polynomials, start=fmpq_poly([-end * end, 0, 1]))
    roots = _real_roots(total)
    for left, right in pairwise(roots):
        middle = ((left.upper() + right.lower()) / 2).mid().fmpq()
        if -end < middle < end:
            yield as_fraction(middle)


def _real_roots(polynomial: fmpq_poly) -> list[arb]:
    """Disjoint enclosures of the real roots, ascending."""
    pairs: Any = polynomial.numer().complex_roots()  # real ones have the imaginary part zero exactly
    return sorted((root.real for root, _ in pairs if root.imag == 0), key=lambda own: own.mid())


def fields_beside(system: System) -> tuple[tuple[Polynomial, ...], tuple[Polynomial, ...]]:
    """The right-hand sides on the interval left of the point, and right of it."""
    intervals = build_intervals(system, WIDEST)
    first_right = next(k for k, place in enumerate(intervals.places) if place > 0)
    return intervals.fields[first_right - 1], intervals.fields[first_right]


def clear_radius(system: System) -> Fraction:
    """A distance within which nothing switches, and no field beside the point vanishes, but at the point."""
    known = build_intervals(system, WIDEST)
    beside = [_dense(field) for side in fields_beside(system) for field in side if field]
    total = prod((*known.surfaces, *beside), start=fmpq_poly([1]))
    distances = [abs(root).lower() for root in _real_roots(total) if root != 0]
    radius = WIDEST
    while not all(own > float(radius) for own in distances):
        radius /= 2
    return radius


def stated_intervals(system: System, radius: Fraction) -> dict[str, Any]:
    """The cells of a system as a theorem is told of them: on the cube ``|x| <= radius``."""
    known = build_intervals(system, radius)
    occurring = [tuple(_sign(surface, place) for surface in known.surfaces) for place in known.places]
    (name,) = system.coordinates
    texts = [_text(surface, name) for surface in known.surfaces]
    return {"within": str(radius), "surfaces": texts, "empty": list(_empty_patterns(occurring))}


def _text(surface: fmpq_poly, name: str) -> str:
    """A polynomial as a formula."""
    powers = [str(surface[0]), f"{surface[1]}*{name}"]
    powers += [f"{surface[k]}*{name}**{k}" for k in range(2, surface.degree() + 1)]
    return " + ".join(own for k, own in enumerate(powers) if surface[k])


def _empty_patterns(occurring: Sequence[Pattern]) -> Iterator[str]:
    """Patterns of signs that occur nowhere, of which every other pattern that does not occur holds one."""
    size, listed = len(occurring[0]), list[dict[int, int]]()
    for beginning in dict.fromkeys(signs[:k] for k in range(size) for signs in occurring):
        for sign in (-1, 1):
            longer = dict(enumerate((*beginning, sign)))
            if not _occurs(longer, occurring) and not any(own.items() <= longer.items() for own in listed):
                listed.append(_contradiction(longer, occurring))
    return (pattern(own.get(j) for j in range(size)) for own in listed)


def _contradiction(signs: dict[int, int], occurring: Sequence[Pattern]) -> dict[int, int]:
    """As few as possible of some signs that occur nowhere together."""
    for j in list(signs):
        fewer = {k: sign for k, sign in signs.items() if k != j}
        if fewer and not _occurs(fewer, occurring):
            signs = fewer
    return signs


def _occurs(signs: dict[int, int], occurring: Sequence[Pattern]) -> bool:
    return any(all(own[j] == sign for j, sign in signs.items()) for own in occurring)
