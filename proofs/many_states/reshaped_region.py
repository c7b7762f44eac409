"""A region of attraction in many states whose V is reshaped: the V-s iteration with sums of squares.

A start with ``V < 1`` reaches the point where V is positive, ``V' < 0`` where ``0 < V <= 1``, and the level set is
bounded.  With a square s (S-procedure) that is asked of all of space at once,

    -V' - s (1 - V)  a sum of squares,    s = z' S z,  S positive semidefinite,

which is bilinear in V and s.  So the two are searched in turn (Jarvis-Wloszek 2003; Topcu, Packard and Seiler 2008):
for V the largest level and an s that shows it; for s a V that is as small as it can be on the border of the region
before, in the mean, which for a quadratic form is the first order of the volume of its ellipsoid.  A V counts as better
where its region reaches farther in the mean over directions.

Everything up to here is a proposal in floats.  V is then rounded, and the claims of theorem ``lyapunov`` with ``below``
are shown on a cube around the region: V is positive and falls where ``V <= level``, and ``V >= level`` on its border.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np
from flint import fmpq

from nonsmooth.proofs.findings import Translation
from nonsmooth.proofs.kernel.bases import PiecewiseFunction, formula_text, functions_on, monomial
from nonsmooth.proofs.kernel.cells import BeyondReachError, rational, rational_terms, stated_cells, without_signs
from nonsmooth.proofs.kernel.search import DeferredClaims, stability_hypotheses
from nonsmooth.proofs.kernel.squares import find
from nonsmooth.proofs.kernel.written import hessian
from nonsmooth.proofs.many_states.lyapunov_search import about_sum
from nonsmooth.proofs.sums_of_squares.ansatz import Blocks, Condition, build_blocks, monomials_between
from nonsmooth.proofs.sums_of_squares.conic_program import Solution, nearest, solve
from nonsmooth.proofs.sums_of_squares.prove import Effort
from nonsmooth.proofs.systems.basin_mesh import Announce
from nonsmooth.proofs.systems.domain import ReshapedRegion, SublevelRegion
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression, parse_piecewise
from nonsmooth.symbolic.numbers.plane_arrays import Floats, max_norm, max_norms, row_norms
from nonsmooth.symbolic.numbers.polynomial import Exponents, Terms, add_terms, float_values, multiply_terms
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

DIRECTIONS, PLACES, FARTHEST = 3_000, 240, 64.0  # rays, places on each up to a multiple of the half-width
LEVELS = (0.999, 0.99, 0.96, 0.9, 0.75, 0.5, 0.25, 1 / 16, 1 / 64, 1 / 1024)  # of what samples allow, in turn
INSIDE = 0.995  # of the largest level: where s is taken, so that it leaves room for another V
MARGIN = 2.0**-12  # of the Gram matrices while V is made small
BETTER = 0.0015  # of the logarithm of the mean distance
MOST_UNKNOWNS = 14_000  # entries of Gram matrices in one program
FINE, FLOATS = 1 << 16, 1 << 40  # denominators of coefficients against the largest, and of proposals
SHARES = tuple(Fraction(k, 256) for k in (255, 252, 248, 240, 224, 192, 128, 64))  # of the largest level, in turn
CUBES = (1.05, 1.5)  # of the extent of the region: half-widths of the cube on which it is shown
TINY, HALVINGS = 2.0**-40, 30


@dataclass(frozen=True)
class SearchEffort:
    """What a search may cost.

    Attributes:
        degrees: of V, one after the other.
        rounds: of the iteration for each.
        work: of all rounds of the first degree together, in units of :meth:`_Iteration.work`; None is without a bound.
        further: likewise of each further degree.
    """

    degrees: tuple[int, ...]
    rounds: int
    work: int | None = None
    further: int = 0

    def affordable(self, works: Sequence[int]) -> list[int]:
        """How many rounds of each degree may be done after the first level.

        Args:
            works: that of one round of each degree.

        Raises:
            TooMuchWorkError: for none of the first one.
        """
        counts = []
        for one, most in zip(works, [self.work, *[self.further] * (len(works) - 1)], strict=True):
            rounds = self.rounds if most is None else min(self.rounds, most // max(one, 1) - 1)
            counts.append(max(rounds, 0))
        if counts[0] < 1:
            raise TooMuchWorkError(f"required {2 * works[0]} units of work, allowed {self.work}")
        return counts


class TooMuchWorkError(Exception):
    """The programs of a search are so large that it is not begun."""


EFFORTS = {  # some 5 s; a minute, for V of degree 2 in eight states more
    "fast": SearchEffort((2,), 16, 800_000_000),
    "best": SearchEffort((2, 4), 25, further=10_000_000_000),
}


@dataclass(frozen=True)
class _Shape:
    """A polynomial V in the displacement over the half-width, in floats, with its level one."""

    exponents: tuple[Exponents, ...]
    values: Floats

    @property
    def terms(self) -> Terms:
        """By exponents, rounded as floats are."""
        return {e: nearest(value, FLOATS) for e, value in zip(self.exponents, self.values, strict=True)}

    def times(self, factor: float) -> _Shape:
        """A multiple."""
        return replace(self, values=self.values * factor)

    @property
    def hessian(self) -> Floats:
        """P of the quadratic part ``x' P x``."""
        return hessian(dict(zip(self.exponents, self.values, strict=True)), len(self.exponents[0])) / 2


def find_reshaped_region(
    system: SwitchedSystem,
    start: PiecewiseExpression,
    budget: str,
    announce: Announce,
    *,
    limit: Fraction | None = None,
) -> ReshapedRegion | None:
    """The widest region that the iteration finds and exact arithmetic shows; None where none is shown.

    Args:
        system: in rational numbers.
        start: a V that falls near the point, a polynomial of the displacement.
        budget: how much may be done for it, of EFFORTS.
        announce: told what is done, how much of it, and of how much.
        limit: half the side of a cube that the region may not leave; None without one.

    Raises:
        BeyondReachError: for a V that bends, and for a system that is not decided here.
        TooMuchWorkError: where what is asked allows no round.
    """
    effort, search = EFFORTS[budget], _Iteration(system, start, limit)
    shape = search.given()
    if shape is None:
        return None
    rounds = effort.affordable([search.work(shape), *map(search.work_of, effort.degrees[1:])])
    announce("shapes of V", 0, 1 + sum(rounds))
    best = search.level(shape)
    if best is None:
        return None
    for k, degree in enumerate(effort.degrees):
        for done in range(rounds[k]):
            announce("shapes of V", 1 + sum(rounds[:k]) + done, 1 + sum(rounds))
            best = search.rescaled(best)
            further = search.improved(best, degree)
            if further is None:
                break
            best = further
    return search.shown(search.rescaled(best))


@dataclass(frozen=True)
class _Level:
    """A V whose level one is the largest that floats show, with its multipliers and how far it reaches.

    Attributes:
        shape: V.
        squares: s of each condition.
        border: places with ``V = 1``, one on each ray.
        reach: the logarithm of their distances, in the mean, in the units of the system.
    """

    shape: _Shape
    squares: tuple[Terms, ...]
    border: Floats
    reach: float


class _Iteration:
    """The conditions on V of a basis of monomials, on the cells of a cube, and what is searched with them."""

    def __init__(self, system: SwitchedSystem, start: PiecewiseExpression, limit: Fraction | None) -> None:
        self.system, self.limit, self.count = system, limit, len(system.states)
        values = system.named()
        polynomial = start.polynomial(values, without_signs)
        self.start = rational_terms(polynomial)
        self._falls: dict[int, list[Condition]] = {}
        self.radius = rational(system.check.radius)

    # -- conditions in floats

    def monomials(self, exponents: Sequence[Exponents]) -> list[PiecewiseFunction]:
        """Monomials as functions."""
        return [monomial(self.system.states, powers) for powers in exponents]

    def falls(self, degree: int) -> list[Condition]:
        """``-V' > 0`` cell by cell and field by field, affine in the coefficients of V, without the cube."""
        if degree not in self._falls:
            monomials = monomials_between(self.count, 2, degree)
            texts = [function.text for function in self.monomials(monomials)]
            stated = stated_cells(self.system, self.system.field(self.radius))
            functions = functions_on(self.system, stated, texts)
            by_function = [functions.claims(k, positive=False) for k in range(len(texts))]
            sizes = [self.radius ** sum(exponents) for exponents in monomials]
            conditions = (
                condition for claims in zip(*by_function, strict=True) for condition in about_sum(claims, sizes)
            )
            self._falls[degree] = [replace(condition, bounds=()) for condition in conditions]
        return self._falls[degree]

    def falling(self, shape: _Shape) -> list[Condition]:
        """The same of one V."""
        degree = max(map(sum, shape.exponents))
        conditions = []
        for condition in self.falls(degree):
            total: Terms = {}
            for k, value in enumerate(shape.terms.values()):
                if k in condition.slopes and value:
                    total = add_terms(total, {e: c * value for e, c in condition.slopes[k].items()})
            conditions.append(replace(condition, constant={e: c for e, c in total.items() if c}, slopes={}))
        return conditions

    # -- one step each

    def given(self) -> _Shape | None:
        """The V that is given; None for one of odd degree or with linear terms."""
        scaled = {e: c * self.radius ** sum(e) for e, c in self.start.items()}
        degree = max(map(sum, scaled))
        if degree % 2 or min(map(sum, scaled)) < 2:
            return None
        exponents = monomials_between(self.count, 2, degree)
        size = max(abs(float(c)) for c in scaled.values())
        values = np.array([float(scaled.get(e, 0)) / size for e in exponents])
        return _Shape(exponents, values)

    def work(self, shape: _Shape) -> int:
        """What one program of each condition takes: the cubes of the numbers of unknowns, as in linear algebra."""
        programs = self._below(shape, self.falling(shape), 1.0)
        return sum(_unknowns(build_blocks(program)) ** 3 for program in programs)

    def work_of(self, degree: int) -> int:
        """That of a V with all monomials up to a degree."""
        exponents = monomials_between(self.count, 2, degree)
        return self.work(_Shape(exponents, np.ones(len(exponents))))

    def level(self, shape: _Shape) -> _Level | None:
        """The largest level of a V that squares show, as level one."""
        conditions = self.falling(shape)
        most = self._allowed(shape, conditions)
        for share in LEVELS:
            if self._squares(shape, conditions, most * share) is not None:
                break
        else:
            return None
        squares = self._squares(shape, conditions, most * share * INSIDE)
        scaled_shape = shape.times(1 / (most * share))
        border = _border(scaled_shape)
        if border is None:
            return None
        distances = row_norms(border)
        reach = float(np.log(distances).mean()) + float(np.log(float(self.radius)))
        # -V' - s (level - V) >= 0 says of V / level the same, with the same s
        return None if squares is None else _Level(scaled_shape, squares, border, reach)

    def _allowed(self, shape: _Shape, conditions: Sequence[Condition]) -> float:
        """The least V at which it is seen not to fall, and that the cube of the limit allows."""
        rays, least = _rays(shape), np.inf
        along = _along(shape.terms, rays)
        rates = [_along(condition.constant, rays) for condition in conditions]
        guards = [[_along(guard, rays) for guard in condition.guards] for condition in conditions]
        widest = max_norms(rays) * float(self.radius)
        for length in np.geomspace(1 / FARTHEST, FARTHEST, PLACES):
            value = _at(along, length)
            bad = value <= 0
            for rate, condition_guards in zip(rates, guards, strict=True):
                inside = np.ones(len(rays), dtype=bool)
                for guard in condition_guards:
                    inside &= _at(guard, length) >= 0
                bad |= inside & (_at(rate, length) <= 0)
            if self.limit is not None:
                bad |= widest * length >= float(self.limit)
            if bad.any():
                least = min(least, float(np.where(bad, value, np.inf).min()))
        return least if np.isfinite(least) else float(_at(along, FARTHEST).min())

    def _squares(self, shape: _Shape, conditions: Sequence[Condition], level: float) -> tuple[Terms, ...] | None:
        """The multiplier s of each condition at a level; None where none is found."""
        squares = []
        for condition, program in zip(conditions, self._below(shape, conditions, level), strict=True):
            blocks = build_blocks(program)
            if _unknowns(blocks) > MOST_UNKNOWNS:
                return None
            solved = solve([(program, blocks)], 0, inner=0.0, bounded=False)
            if solved is None:
                return None
            squares.append(_square(blocks, solved, len(condition.guards)))
        return tuple(squares)

    def _below(self, shape: _Shape, conditions: Sequence[Condition], level: float) -> list[Condition]:
        """Conditions where V is below a level."""
        zero = (0,) * self.count
        below = add_terms({zero: nearest(level, FLOATS)}, {e: -c for e, c in shape.terms.items()})
        return [replace(condition, guards=(*condition.guards, below)) for condition in conditions]

    def rescaled(self, before: _Level) -> _Level:
        """The same V in units in which its region has a half-width between one half and one."""
        extent = max_norm(before.border)
        if 0.5 < extent <= 1:
            return before
        factor = Fraction(2) ** int(np.ceil(np.log2(extent)))
        sizes = [float(factor) ** sum(e) for e in before.shape.exponents]
        previous = self.radius, self._falls
        self.radius, self._falls = self.radius * fmpq(factor.numerator, factor.denominator), {}
        level = self.level(replace(before.shape, values=before.shape.values * np.array(sizes)))
        if level is None:
            self.radius, self._falls = previous
        return level or before

    def improved(self, before: _Level, degree: int) -> _Level | None:
        """A V of a degree that reaches farther; None where none is found."""
        degree = max(degree, *map(sum, before.shape.exponents))
        exponents = monomials_between(self.count, 2, degree)
        problems: list[tuple[Condition, Blocks]] = []
        for condition, square in zip(self.falls(degree), before.squares, strict=True):
            slopes = dict(condition.slopes)
            for k, exponent in enumerate(exponents):
                product = multiply_terms(square, {exponent: fmpq(1)})
                slopes[k] = add_terms(slopes.get(k, {}), product)
            program = replace(condition, constant={e: -c for e, c in square.items()}, slopes=slopes)
            problems.append((program, build_blocks(program)))
        positive = Condition({}, {k: {e: fmpq(1)} for k, e in enumerate(exponents)}, (), (), self.count)
        problems.append((positive, build_blocks(positive)))
        if sum(_unknowns(blocks) for _, blocks in problems) > MOST_UNKNOWNS:
            return None
        price = np.array([float_values({e: fmpq(1)}, before.border).mean() for e in exponents])
        solved = solve(problems, len(exponents), inner=0.0, bounded=False, strict=False, price=price, least=MARGIN)
        level = None if solved is None else self.level(_Shape(exponents, solved.parameters))
        return level if level is not None and level.reach > before.reach + BETTER else None

    # -- exact

    def shown(self, best: _Level) -> ReshapedRegion | None:
        """The region of a rounded V, by evidence that the checker takes."""
        shape = best.shape
        size = max_norm(shape.values)
        unscaled = []
        for exponents, value in zip(shape.exponents, shape.values, strict=True):
            unscaled.append(nearest(value / size, FINE) / self.radius ** sum(exponents))
        top = 1 / size  # the level of the rounded V, in floats
        formula = parse_piecewise(formula_text(self.monomials(shape.exponents), unscaled), self.system.states)
        for cube in CUBES:
            extent = max_norm(best.border) * float(self.radius) * cube
            within = _short_above(extent)
            if self.limit is not None:
                within = min(within, self.limit)
            for share in SHARES:
                level = _short_below(top * float(share))
                region = self._shown_at(formula, level, within)
                if region is not None:
                    return region
        return None

    def _shown_at(self, formula: PiecewiseExpression, level: Fraction, within: Fraction) -> ReshapedRegion | None:
        """The claims of theorem ``lyapunov`` below a level."""
        radius = self.system.field(within)
        try:
            stated = stated_cells(self.system, radius)
            functions = functions_on(self.system, stated, [formula.text])
        except BeyondReachError:
            return None
        functions.require_below(level)
        claims = functions.claims()
        functions.proofs = border = DeferredClaims()
        functions.show_border(level)
        proofs = dict(stated.proofs)
        for claim in (*claims, *border.claims):
            proof = find(claim, Effort.HASTY)
            if proof is None:
                return None
            proofs[claim.name] = proof.evidence
        verdict = str(Translation.ASYMPTOTICALLY_STABLE)
        stability = stability_hypotheses(stated.record, formula.text, verdict)
        hypotheses = {**stability, "below": True, "level": str(level)}
        region = SublevelRegion(level, None, None, within, False, proofs)
        return ReshapedRegion(formula, region, hypotheses)


def _unknowns(blocks: Blocks) -> int:
    return sum(len(block.monomials) * (len(block.monomials) + 1) // 2 for block in blocks)


def _square(blocks: Blocks, solved: Solution, guard: int) -> Terms:
    """The polynomial ``z' S z`` beside a guard."""
    total: Terms = {}
    for block, gram in zip(blocks, solved.grams[0], strict=True):
        if block.factors != (guard,):
            continue
        for i, a in enumerate(block.monomials):
            for j, b in enumerate(block.monomials):
                term = {tuple(map(int.__add__, a, b)): nearest(float(gram[i, j]), FLOATS)}
                total = add_terms(total, term)
    return total


def _rays(shape: _Shape) -> Floats:
    """Directions, as many to each side of the ellipsoid of the quadratic part, scaled to its border."""
    source = np.random.default_rng(0)
    count = len(shape.exponents[0])
    units = source.normal(size=(DIRECTIONS, count))
    units /= np.linalg.norm(units, axis=1, keepdims=True)
    values, vectors = np.linalg.eigh(shape.hessian)
    axes = vectors / np.sqrt(np.maximum(values, TINY * max(values.max(), TINY)))
    along = np.vstack([np.eye(count), -np.eye(count)])
    return np.vstack([units, along]) @ axes.T


def _along(terms: Mapping[Exponents, Any], rays: Floats) -> dict[int, Floats]:
    """A polynomial along rays from the origin: its coefficient of each power of the length, ray by ray."""
    by_degree: dict[int, Terms] = {}
    for exponents, value in terms.items():
        by_degree.setdefault(sum(exponents), {})[exponents] = value
    return {degree: float_values(form, rays) for degree, form in by_degree.items()}


def _at(along: dict[int, Floats], length: float | Floats) -> Floats:
    """Its values at one length on all rays, or at one on each."""
    return sum((coefficient * length**degree for degree, coefficient in along.items()), np.zeros(1))


def _border(shape: _Shape) -> Floats | None:
    """The first place with ``V = 1`` on each ray; None where V stays below on one."""
    rays = _rays(shape)
    along = _along(shape.terms, rays)
    low, high = np.zeros(len(rays)), np.full(len(rays), np.inf)
    for length in np.geomspace(1 / FARTHEST, FARTHEST, PLACES):
        high[(_at(along, length) >= 1) & np.isinf(high)] = length
        low[np.isinf(high)] = length
    if np.isinf(high).any():
        return None
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        over = _at(along, middle) >= 1
        high, low = np.where(over, middle, high), np.where(over, low, middle)
    return rays * low[:, None]


def _short_above(value: float) -> Fraction:
    """A short fraction above a number."""
    return -_short_below(-value)


def _short_below(value: float) -> Fraction:
    """A short fraction below a number."""
    power = Fraction(1)
    while abs(value) * power < 128:
        power *= 2
    while abs(value) * power >= 256:
        power /= 2
    return Fraction(int(np.floor(value * float(power)))) / power
