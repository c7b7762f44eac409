"""Whether the open part of a cell with curved sides is empty, decided exactly by a planar decomposition.

A guard such as ``x**2*y - x**4 - y**2`` is positive nowhere, yet it vanishes at the origin, where no bound on
coefficients shows that: two curves may touch there, or a factor may vanish at one point alone.  So the plane is cut
into columns, as in a cylindrical algebraic decomposition (Collins 1975).

Let the curves be the distinct irreducible factors over Q of all guards and the sides of the convex part.  Between
neighbouring real zeros of their discriminants, of their leading coefficients in y, of the resultants of two of them,
and of those factors that do not hold y, the real roots y of the curves move continuously with x and never meet.  So
each open piece of the plane off the curves lies over such a column between neighbouring roots, and all guards have one
sign on it: the sign at one rational point.  An open cell is a union of such pieces and of parts of curves, and if it is
not empty it holds one of the points.

The degrees of the guards and the length of their coefficients are limited; beyond that, and with irrational
coefficients, nothing is said.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache
from itertools import combinations, pairwise
from typing import Any, TypeAlias

from flint import Ordering, ctx, fmpq, fmpq_mpoly, fmpq_mpoly_ctx, fmpq_poly

from nonsmooth.analysis.cells.region import Region
from nonsmooth.proofs.inequalities.forms import simplest
from nonsmooth.symbolic.numbers.lazy import evaluated

MOST_WORK = 400_000  # bits of the longest coefficient times (sum of squared degrees)^2: a second or two
FIRST_PRECISION = 64  # bits with which roots are enclosed; doubled until the enclosures are disjoint

CONTEXT = fmpq_mpoly_ctx.get(("x", "y"), Ordering.lex)

Bounds: TypeAlias = tuple[fmpq, fmpq]
Side: TypeAlias = tuple[fmpq, fmpq, fmpq]
Terms: TypeAlias = tuple[tuple[tuple[int, ...], fmpq], ...]


def is_empty(region: Region) -> bool | None:
    """Whether no point strictly inside the convex part makes all guards positive; None where that is not decided."""
    sides = tuple(tuple(map(_rational, side)) for side in region.sides)
    guards = tuple(
        tuple((e, _rational(c)) for e, c in sorted(guard.terms.items())) for guard in region.guards if guard.terms
    )
    if any(c is None for side in sides for c in side) or any(c is None for guard in guards for _, c in guard):
        return None
    return len(guards) < len(region.guards) or _decided(sides, guards)


def _rational(value: Any) -> fmpq | None:
    plain = simplest(evaluated(value))
    return fmpq(plain) if isinstance(plain, int | fmpq) else None


@lru_cache(maxsize=4096)
def _decided(sides: tuple[Side, ...], guards: tuple[Terms, ...]) -> bool | None:
    """The same for rational coefficients."""
    lines = [CONTEXT.from_dict({(1, 0): a, (0, 1): b, (0, 0): c}) for a, b, c in sides]
    asked = [CONTEXT.from_dict(dict(guard)) for guard in guards]
    curves = _factors(asked)
    critical = sum(curve.total_degree() ** 2 for curve in curves)  # about as many critical values are there
    bits = max((_bits(c) for guard in guards for _, c in guard), default=1)
    if bits * critical**2 > MOST_WORK:
        return None
    curves += [factor for factor in _factors(lines) if factor not in curves]
    for x in _samples(_critical_values(curves)):
        columns = [_in_y(curve, x) for curve in curves]
        for y in _samples(column for column in columns if column.degree() > 0):
            if all(polynomial(x, y) > 0 for polynomial in (*lines, *asked)):
                return False
    return True


def _bits(value: fmpq) -> int:
    return int(value.p).bit_length() + int(value.q).bit_length()


def _factors(polynomials: Sequence[fmpq_mpoly]) -> list[fmpq_mpoly]:
    """The distinct irreducible factors that are no numbers."""
    found: dict[str, fmpq_mpoly] = {}
    for polynomial in polynomials:
        for factor, _ in polynomial.factor()[1]:
            found[str(factor)] = factor
    return list(found.values())


def _critical_values(curves: Sequence[fmpq_mpoly]) -> Iterator[fmpq_poly]:
    """Polynomials in x between whose real zeros the roots y of the curves neither appear, nor vanish, nor meet."""
    upright = [curve for curve in curves if not curve.degrees()[1]]
    others = [curve for curve in curves if curve.degrees()[1]]
    yield from map(_in_x, upright)
    for curve in others:
        yield _in_x(_leading(curve))
        if curve.degrees()[1] > 1:
            yield _in_x(curve.discriminant("y"))
    for first, second in combinations(others, 2):
        yield _in_x(first.resultant(second, "y"))


def _leading(curve: fmpq_mpoly) -> fmpq_mpoly:
    """The coefficient of the highest power of y."""
    top = curve.degrees()[1]
    return CONTEXT.from_dict({(e[0], 0): c for e, c in curve.to_dict().items() if e[1] == top})


def _in_x(polynomial: fmpq_mpoly) -> fmpq_poly:
    """A polynomial without y, dense."""
    terms = {int(e[0]): c for e, c in polynomial.to_dict().items()}
    return fmpq_poly([terms.get(k, 0) for k in range(max(terms, default=-1) + 1)])


def _in_y(curve: fmpq_mpoly, x: fmpq) -> fmpq_poly:
    """``curve(x, y)`` at a value of x, dense in y."""
    terms: dict[int, fmpq] = {}
    for (power, degree), c in curve.to_dict().items():
        terms[int(degree)] = terms.get(int(degree), fmpq(0)) + c * x ** int(power)
    return fmpq_poly([terms.get(k, 0) for k in range(max(terms) + 1)])


def _samples(polynomials: Any) -> Iterator[fmpq]:
    """Rational numbers, one below, one above and one between all neighbouring real roots of some polynomials."""
    roots = _separated_roots([polynomial for polynomial in polynomials if polynomial.degree() > 0])
    if not roots:
        yield fmpq(0)
        return
    yield fmpq(roots[0][0].floor() - 1)
    for (_, low), (high, _) in pairwise(roots):
        yield _short_between(low, high)
    yield fmpq(roots[-1][1].ceil() + 1)


def _separated_roots(polynomials: Sequence[fmpq_poly]) -> list[Bounds]:
    """Disjoint bounds of the distinct real roots, ascending."""
    irreducible = {str(factor): factor for polynomial in polynomials for factor, _ in polynomial.factor()[1]}
    precision = FIRST_PRECISION
    while True:
        with ctx.workprec(precision):
            found: Any = [root.real for part in irreducible.values() for root, _ in _roots(part) if root.imag == 0]
            enclosures = sorted((root.lower().fmpq(), root.upper().fmpq()) for root in found)
        if all(before[1] < after[0] for before, after in pairwise(enclosures)):
            return enclosures
        precision *= 2


def _roots(polynomial: fmpq_poly) -> Any:
    """Complex roots with multiplicities; real ones have the imaginary part zero exactly."""
    return polynomial.complex_roots()


def _short_between(low: fmpq, high: fmpq) -> fmpq:
    """A number with few digits in an open interval."""
    scale = fmpq(1)
    while True:
        inner = ((low * scale).floor() + 1) / scale
        if inner < high:
            return fmpq(inner)
        scale *= 2
