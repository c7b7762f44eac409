"""Switched systems ``x' = f(x)`` in any number of states, and what is to be checked of them.

The right-hand sides are formulas with ``sign``, ``Abs``, ``Max``, ``Min``: polynomials on each cell that the switching
surfaces cut.  On the surfaces the values of f are ignored (Filippov 1988, sec. 4).  Solutions are followed in any
number of states, and stability is decided and derived in any number; cells are drawn in two (:func:`require_plane`).
Verdicts are about the displacement from the checked point.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from enum import StrEnum
from fractions import Fraction
from itertools import product
from math import ceil, floor, frexp, prod
from typing import TYPE_CHECKING, Any, ClassVar, Literal

from nonsmooth.symbolic.formulas.enclosed_functions import INVERSE, NORM, UNIT, Wave
from nonsmooth.symbolic.formulas.expression import formula_refused
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression, SignOf, no_sign, parse_piecewise
from nonsmooth.symbolic.formulas.signed_roots import SignedRoots, orders_in
from nonsmooth.symbolic.formulas.surfaces import switching_factors
from nonsmooth.symbolic.formulas.trees import multiplied, number, quotient, replaced, tidied, with_names, written
from nonsmooth.symbolic.messages.notebook import ShortRepr
from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact
from nonsmooth.symbolic.messages.scene_kind import SceneKind
from nonsmooth.symbolic.numbers.enclosures import rational_above, rational_below
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.polynomial import Polynomial

if TYPE_CHECKING:
    from nonsmooth.symbolic.formulas.norms import Bounded

PLANE = ("x", "y")  # the displacement of two states
ONE_SIDE = "one right-hand side (under arbitrary switching only stability is decided)"
MOST_ORDER = 2  # further terms of sines and cosines, and how often bounds of norms get closer
MAX_PATTERNS = 4_096  # sign patterns of one switching part of a right-hand side: twelve surfaces that cross


class Enclosed(StrEnum):
    """What has rational bounds, or bounds without roots, in place of itself in right-hand sides."""

    NORMS = "roots of sums of squares lie between formulas without any"
    UNITS = "unit vectors lie between constants on sectors"
    NUMBERS = "irrational numbers lie between rational ones"

    @property
    def kind(self) -> str:
        """The kind of the names that stand for it in formulas; empty for numbers."""
        return {Enclosed.NORMS: NORM, Enclosed.UNITS: UNIT}.get(self, "")


class UnknownSign(Exception):
    """A surface whose sign is asked for and not given."""

    def __init__(self, surface: Polynomial) -> None:
        super().__init__(surface)
        self.surface = surface


@dataclass(frozen=True)
class CheckedCube:
    """What is checked: the equilibrium ``x*``, and the cube ``|x_k - x*_k| <= radius`` about it.

    ``lyapunov`` is V in the displacement from ``x*``, written with the states' names; ``is_default`` where the scene
    names none, so that it is the sum of their squares.  Where it names a quotient, that is kept as numerator and
    denominator, and ``lyapunov`` is the sum of squares, too.
    """

    equilibrium: tuple[Number, ...]
    radius: Number
    lyapunov: PiecewiseExpression
    is_default: bool = False
    quotient: tuple[PiecewiseExpression, PiecewiseExpression] | None = None

    @property
    def place(self) -> tuple[float, ...]:
        """The checked point in floats."""
        return tuple(map(float, self.equilibrium))

    @property
    def half_width(self) -> float:
        """The radius in floats."""
        return float(self.radius)

    @property
    def named_lyapunov(self) -> str | None:
        """The V that the scene names, but a quotient."""
        return None if self.is_default else self.lyapunov.text


@dataclass(frozen=True)
class SeenByRoots:
    """What a system in signed roots of states stands for (:mod:`nonsmooth.symbolic.formulas.signed_roots`).

    Attributes:
        roots: which states they are.
        extended: the stated system with the size of each root as a further state, whose right-hand side is no field.
        unscaled: the stated right-hand sides in the roots, in the stated time: rates of x, not of its root.
    """

    roots: SignedRoots
    extended: SwitchedSystem
    unscaled: SwitchedSystem


@dataclass(frozen=True)
class Rewriting:
    """What was done to the stated formulas until they were polynomials on cells; nothing where all is empty.

    Attributes:
        written: the formulas as they were stated, where the right-hand sides are not these but scaled (fractions) or
            enclose them (sines, cosines and norms of states).
        waves: the sines and the like that are enclosed; the right-hand sides are the values at all ends of its weights.
        denominators: formulas in the states and in names of norms that must be positive on the checked square, but
            perhaps at the checked point.
        scale: the positive factor by which the stated fields were multiplied, likewise; None without fractions.
        named_rhs: the one field that is enclosed, in the states and in names of its norms, sines and cosines.
        names: what these names mean.
        norms: what the names of norms and of entries of unit vectors mean.
        order: how many further terms of sines and cosines are taken
            (:mod:`nonsmooth.symbolic.formulas.enclosed_functions`), and how often bounds of norms get closer.
        encloses: what the right-hand sides have bounds of, beside waves.
    """

    written: tuple[tuple[str, ...], ...] = ()
    waves: tuple[Wave, ...] = ()
    denominators: tuple[PiecewiseExpression, ...] = ()
    scale: PiecewiseExpression | None = None
    named_rhs: tuple[PiecewiseExpression, ...] = ()
    names: tuple[Wave, ...] = ()
    norms: tuple[Bounded, ...] = ()
    order: int = 0
    encloses: tuple[Enclosed, ...] = ()

    @property
    def divides_by_norms(self) -> bool:
        """Whether stated formulas jump without a sign: where a norm that they divide by is zero beside the point."""
        return any(norm.kind == UNIT for norm in self.norms)

    @property
    def names_roots(self) -> bool:
        """Whether some of the names are of roots of sums of squares."""
        return any(wave.kind in (NORM, INVERSE) for wave in self.names)

    def stated_text(self, formula: PiecewiseExpression) -> str:
        """A formula of the states and of norms as people read it."""
        from nonsmooth.symbolic.formulas.norms import restored

        return written(tidied(restored(formula.tree, self.norms)))


@dataclass(frozen=True, repr=False)
class SwitchedSystem(ShortRepr):
    """A switched system with everything a check needs; numbers live in one field.

    Attributes:
        name: of the scene.
        field: the number field.
        states: their names.
        rhs: one right-hand side per state.
        check: what is checked.
        source: where it came from (a file or a built-in name).
        others: further right-hand sides; the field is any of them, or any mixture, at any time (arbitrary switching).
        rewriting: what was done to the stated formulas.
        by_roots: what the system stands for where its states are signed roots of the stated ones; None otherwise.
        intervals: names of the parameters that were stated as intervals; the right-hand sides are those at their ends.
        overlaps: whether tables of regions may overlap; each right-hand side takes another one of them first.
    """

    kind: ClassVar[Literal[SceneKind.SYSTEM]] = SceneKind.SYSTEM

    name: str
    field: NumberField
    states: tuple[str, ...]
    rhs: tuple[PiecewiseExpression, ...]
    check: CheckedCube
    source: str = ""
    others: tuple[tuple[PiecewiseExpression, ...], ...] = ()
    rewriting: Rewriting = Rewriting()
    by_roots: SeenByRoots | None = None
    intervals: tuple[str, ...] = ()
    overlaps: bool = False

    @property
    def members(self) -> tuple[SwitchedSystem, ...]:
        """One system for each right-hand side."""
        rewriting = replace(self.rewriting, waves=(), named_rhs=(), names=())
        return tuple(replace(self, rhs=rhs, others=(), rewriting=rewriting) for rhs in (self.rhs, *self.others))

    @property
    def stated_lists(self) -> tuple[tuple[str, ...], ...]:
        """The formulas of each right-hand side as they were stated."""
        return self.rewriting.written or tuple(tuple(side.text for side in rhs) for rhs in (self.rhs, *self.others))

    @property
    def has_one_field(self) -> bool:
        """Whether the system as it was stated has one right-hand side: several may enclose it."""
        return not self.others or (self.only_encloses and len(self.rewriting.written) == 1)

    @property
    def only_encloses(self) -> bool:
        """Whether the right-hand sides only enclose the stated field: what one of them allows, that need not."""
        return bool(self.rewriting.waves or self.rewriting.encloses)

    @property
    def hangs_on_order(self) -> bool:
        """Whether further terms, or closer bounds, enclose the stated field more closely.

        Closer bounds of norms switch on more lines; those of several, and planes in space, cut too many cells.
        """
        norms = self.rewriting.norms if Enclosed.NORMS in self.rewriting.encloses else ()
        return bool(self.rewriting.waves) or (len(norms) == 1 and self.is_planar)

    @property
    def stated_states(self) -> tuple[str, ...]:
        """The names of the states as they were stated: without roots of states."""
        return self.states if self.by_roots is None else self.by_roots.roots.states

    @property
    def stated_point(self) -> tuple[Number, ...]:
        """The checked point in the states as they were stated."""
        point = self.check.equilibrium
        if self.by_roots is None:
            return point
        return tuple(map(self.by_roots.roots.stated, self.stated_states, point))

    @property
    def origin(self) -> str:
        """Where the scene came from, for messages: its file or built-in name, else its own name."""
        return self.source or self.name

    @property
    def vanishing(self) -> tuple[PiecewiseExpression, ...]:
        """The denominators that are zero at the checked point: the stated field has no value there."""
        return tuple(filter(self.is_zero_at_point, self.rewriting.denominators))

    def is_zero_at_point(self, formula: PiecewiseExpression) -> bool:
        """Whether a formula of the states and of norms is zero at the checked point."""
        point = [Polynomial.constant(self.field, self.states, coordinate) for coordinate in self.check.equilibrium]
        return not any(end.polynomial(self.named(point), no_sign) for end in self.between_norms(formula))

    def between_norms(self, formula: PiecewiseExpression) -> tuple[PiecewiseExpression, ...]:
        """Formulas of the states whose hull holds one that is affine in norms, too: itself where it holds none."""
        if not self.rewriting.norms:
            return (formula,)
        from nonsmooth.symbolic.formulas.norms import at_ends

        ends = at_ends([formula.text], self.rewriting.norms, self.states, self.rewriting.order)
        return tuple(parse_piecewise(text, self.states) for (text,) in ends)

    @property
    def is_planar(self) -> bool:
        """Whether it has two states."""
        return len(self.states) == len(PLANE)

    def coordinates(self) -> tuple[Polynomial, ...]:
        """The states as polynomials in themselves."""
        return Polynomial.coordinates(self.field, self.states)

    def named(self, values: Sequence[Any] | None = None) -> dict[str, Any]:
        """Values of the states by their names; the states as polynomials in themselves unless given."""
        return dict(zip(self.states, self.coordinates() if values is None else values, strict=True))

    def argument_of(
        self, wave: Wave, states: Sequence[Polynomial] | None = None, sign_of: SignOf = no_sign
    ) -> Polynomial:
        """What a sine or cosine is of, as a polynomial.

        Args:
            wave: one of the system's.
            states: the states as polynomials; :meth:`coordinates` unless given.
            sign_of: signs of what its argument switches by; unless given it may not switch.

        Raises:
            ExpressionError: where it is none.
        """
        return parse_piecewise(wave.argument, self.states).polynomial(self.named(states), sign_of)

    def displaced(self, names: Sequence[str]) -> tuple[Polynomial, ...]:
        """The states as polynomials in the displacement from the checked point, whose entries have these names."""
        variables = Polynomial.coordinates(self.field, names)
        return tuple(v + centre for v, centre in zip(variables, self.check.equilibrium, strict=True))

    def velocity(self, sign_of: SignOf, states: Sequence[Polynomial] | None = None) -> tuple[Polynomial, ...]:
        """The smooth field of the first right-hand sides for the given signs of the inner expressions.

        Args:
            sign_of: sign of an inner expression.
            states: the states as polynomials; :meth:`coordinates` unless given.

        Raises:
            SceneError: where a piece is no polynomial.
        """
        values = self.coordinates() if states is None else states
        return tuple(self._piece(k, sign_of, values) for k in range(len(self.rhs)))

    def surfaces(self, states: Sequence[Polynomial] | None = None) -> tuple[Polynomial, ...]:
        """Every surface on which some right-hand side may switch, each once, with leading coefficient 1.

        Every outermost switching part of a right-hand side is asked with every answer of the signs it asks for.
        Answers are not tested for being possible together, so a surface may be listed that switches nothing: the
        field is the same on both sides.

        Args:
            states: as for :meth:`velocity`.

        Raises:
            SceneError: for too many patterns of signs, or where no piece is a polynomial.
        """
        values = self.coordinates() if states is None else states
        surfaces: dict[Polynomial, None] = {}
        for member in self.members if self.others else (self,):
            for k in range(len(self.rhs)):
                surfaces.update(dict.fromkeys(member._surfaces_of(k, values)))
        return tuple(surfaces)

    def _surfaces_of(self, k: int, values: Sequence[Polynomial]) -> list[Polynomial]:
        parts = (self._asked(k, part, values) for part in self.rhs[k].switching_parts)
        return list(dict.fromkeys(surface for part in parts for surface in part))

    def _asked(self, k: int, part: PiecewiseExpression, values: Sequence[Polynomial]) -> list[Polynomial]:
        """The surfaces of which a part of a formula asks the signs."""
        surfaces: dict[Polynomial, None] = {}
        waiting: list[dict[Polynomial, int]] = [{}]
        ended, refusal = 0, None
        while waiting:
            signs = waiting.pop()
            try:
                self._value(k, part, signs_by_factors(signs), values)
            except UnknownSign as unknown:
                surfaces[unknown.surface] = None
                waiting += [{**signs, unknown.surface: -1}, {**signs, unknown.surface: 1}]
                if len(waiting) + ended > MAX_PATTERNS:
                    key, expected = f"system.rhs[{k + 1}]", "a formula with fewer switching surfaces"
                    received = StatedFact(f"over {MAX_PATTERNS} sign patterns")
                    raise SceneError(self.origin, key, expected, received) from None
                continue
            except SceneError as error:  # perhaps of a pattern that no state has
                refusal = error
                continue
            ended += 1
        if not ended and refusal is not None:
            raise refusal
        return list(surfaces)

    def _piece(self, k: int, sign_of: SignOf, values: Sequence[Polynomial]) -> Polynomial:
        return self._value(k, self.rhs[k], sign_of, values)

    def _value(self, k: int, formula: PiecewiseExpression, sign_of: SignOf, values: Sequence[Polynomial]) -> Polynomial:
        with formula_refused(self.origin, f"system.rhs[{k + 1}]", self.rhs[k].text):
            return formula.polynomial(self.named(values), sign_of)


def require_plane(system: SwitchedSystem) -> None:
    """Refuse a system in another number of states than two.

    Raises:
        SceneError: for such a system.
    """
    if not system.is_planar:
        raise SceneError(system.origin, "system.states", "two states", list(system.stated_states))


def require_stated(system: SwitchedSystem) -> None:
    """Refuse square roots of states.

    Raises:
        SceneError: for a system that is seen by signed roots.
    """
    if system.by_roots is None:
        return
    roots = system.by_roots.roots
    example = roots.root_text(roots.rooted[0])
    may = "with it stability is decided, and paths are followed"
    expected = f"formulas without {example} ({may})"
    for k, side in enumerate(system.rewriting.written, 1):
        for j, formula in enumerate(side, 1):
            if orders_in(formula, roots.states, {}):
                key = f"system.rhs[{k}][{j}]" if len(system.rewriting.written) > 1 else f"system.rhs[{j}]"
                raise SceneError(system.origin, key, expected, formula)
    raise SceneError(system.origin, "check.lyapunov", expected, StatedFact(example))


def require_one_field(system: SwitchedSystem) -> None:
    """Refuse arbitrary switching, and square roots of states; sines and cosines of states are enclosed, one field.

    Raises:
        SceneError: for a system that was stated with several right-hand sides, or with such roots.
    """
    require_stated(system)
    if not system.has_one_field:
        raise _several(system)


def require_single(system: SwitchedSystem) -> None:
    """Refuse arbitrary switching, norms, sines and cosines of states, which are enclosed, and square roots of states.

    Raises:
        SceneError: for a system with several right-hand sides, or with such roots.
    """
    require_stated(system)
    if not system.has_one_field:
        raise _several(system)
    if system.others:
        if not {Enclosed.NORMS, Enclosed.UNITS}.isdisjoint(system.rewriting.encloses):
            received = StatedFact(f"sqrt({system.rewriting.norms[0].argument})")
            raise SceneError(system.origin, "system.rhs", "formulas without roots of sums of squares", received)
        expected = "formulas without sin and cos of states" if system.rewriting.waves else ONE_SIDE
        raise SceneError(system.origin, "system.rhs", expected, StatedFact(f"{1 + len(system.others)}"))


def _several(system: SwitchedSystem) -> SceneError:
    """That one right-hand side is required, by the key that says that there are several."""
    if system.intervals:
        key, expected = (
            f"system.parameters.{system.intervals[0]}",
            "a number (with an interval only stability is decided)",
        )
        return SceneError(system.origin, key, expected, StatedFact("an interval"))
    if system.overlaps:
        expected = "false (where tables overlap only stability is decided)"
        return SceneError(system.origin, "system.overlap", expected, StatedFact("true"))
    count = len(system.rewriting.written) or 1 + len(system.others)
    return SceneError(system.origin, "system.rhs", ONE_SIDE, StatedFact(f"{count}"))


def sign_by_factors(expression: Polynomial, sign_of_factor: Callable[[Polynomial], int]) -> int:
    """Sign of an inner expression from the signs of the surfaces that are its factors."""
    if not expression:
        return 0
    total, factors = switching_factors(expression)
    return total * prod(map(sign_of_factor, factors))


def signs_by_factors(signs: Mapping[Polynomial, int]) -> SignOf:
    """The sign of any inner expression for given signs of the surfaces; it raises UnknownSign for another surface."""

    def known(surface: Polynomial) -> int:
        if surface not in signs:
            raise UnknownSign(surface)
        return signs[surface]

    return lambda expression: sign_by_factors(expression, known)


# ---- plain systems that behave like a given one --------------------------------------------------
#
# *scaled* by s, ``x' = s f(x/s)``, or *sped up* by k, ``x' = k f(x)``.
#
# All changes are exact, and the verdict is the same.


def scaled_system(
    system: SwitchedSystem, length: Fraction = Fraction(1), speed: Fraction = Fraction(1)
) -> SwitchedSystem:
    """``x' = k s f(x/s)`` for a length s and a speed k.

    Raises:
        SceneError: for arbitrary switching.
    """
    require_single(system)
    shrunk = {name: quotient(ast.Name(name), number(length)) for name in system.states}
    sides = [multiplied(number(speed * length), with_names(f.tree, shrunk)) for f in system.rhs]
    check = replace(
        system.check,
        equilibrium=tuple(x * length for x in system.check.equilibrium),
        radius=system.check.radius * length,
        lyapunov=_of_tree(with_names(system.check.lyapunov.tree, shrunk), system.states),
        quotient=None,
    )
    return replace(system, rhs=tuple(_of_tree(side, system.states) for side in sides), check=check)


def with_rate_ratio(system: SwitchedSystem, ratio: Fraction) -> SwitchedSystem:
    """The first rate as it is, the others times r.

    Raises:
        SceneError: for arbitrary switching.
    """
    require_single(system)
    first, *others = system.rhs
    rhs = (first, *(_of_tree(multiplied(number(ratio), other.tree), system.states) for other in others))
    return replace(system, rhs=rhs)


def _of_tree(tree: ast.expr, states: tuple[str, ...]) -> PiecewiseExpression:
    return parse_piecewise(written(tree), states)


# ---- irrational numbers between rational ones ----------------------------------------------------
#
# Systems with irrational numbers between systems with rational ones, for proofs that hold rational numbers alone.
#
# Every irrational number that a right-hand side names, such as ``sqrt(2)/2``, is replaced by a rational one below it
# and by one above it, each place by itself, in all combinations.  A right-hand side is affine in the number at each
# place, so the stated field is a mixture of those with the bounds: what holds for solutions of all of these, in any
# mixture, holds for those of the stated system.  A number inside a switching function or a power has no such place:
# between two surfaces lies more than both, and a power is not affine.


BITS = 30  # of the bounds
PRECISION = 64  # bits of the ball that is rounded outward
MOST_PLACES = 5  # of irrational numbers in one right-hand side: two to this power others


class NoEnclosureError(ValueError):
    """A system that lies between no systems with rational numbers, or between too many."""


def with_known_numbers(system: SwitchedSystem) -> SwitchedSystem:
    """The system between rational bounds of its irrational numbers; itself where there are no such bounds."""
    with suppress(NoEnclosureError):
        return enclose_numbers(system)
    return system


def enclose_numbers(system: SwitchedSystem) -> SwitchedSystem:
    """A system in rational numbers that encloses another one; the same where all its numbers are rational.

    Raises:
        NoEnclosureError: for irrational numbers inside switching functions and powers, for too many of them, and in
            systems that are seen by roots of states.
    """
    sides = [_between(member) for member in system.members]
    if all(len(member_sides) == 1 for member_sides in sides):
        return system
    if system.by_roots is not None:
        raise NoEnclosureError("irrational numbers beside roots of states")
    first, *others = (side for member_sides in sides for side in member_sides)
    encloses = (*system.rewriting.encloses, Enclosed.NUMBERS)
    rewriting = replace(system.rewriting, written=system.stated_lists, encloses=encloses)
    return replace(system, rhs=first, others=tuple(others), rewriting=rewriting)


def _between(system: SwitchedSystem) -> list[tuple[PiecewiseExpression, ...]]:
    """The right-hand sides with bounds for the irrational numbers of one; itself where it has none."""
    places = [list(_places(side.tree, side, system)) for side in system.rhs]
    count = sum(map(len, places))
    if not count:
        return [system.rhs]
    if count > MOST_PLACES:
        raise NoEnclosureError(f"over {MOST_PLACES} irrational numbers in a right-hand side")
    lists = []
    for chosen in product((0, 1), repeat=count):
        ends = iter(chosen)
        at = [{node: bounds[next(ends)] for node, bounds in listed} for listed in places]
        sides = [_with_bounds(side.tree, bounds) for side, bounds in zip(system.rhs, at, strict=True)]
        lists.append(tuple(_of_tree(side, system.states) for side in sides))
    return lists


def _with_bounds(tree: ast.expr, bounds: Mapping[ast.expr, Fraction]) -> ast.expr:
    return replaced(tree, lambda node: number(bounds[node]) if node in bounds else None)


def _places(
    node: ast.expr, whole: PiecewiseExpression, system: SwitchedSystem
) -> Iterator[tuple[ast.expr, tuple[Fraction, Fraction]]]:
    """The irrational numbers of a part of a formula, from the left to the right, with rational ones beside."""
    if node in whole.numbers:
        value = whole.numbers[node].value(system.field)
        if value.as_rational() is None:
            yield node, bounds_of(value)
        return
    match node:
        case ast.UnaryOp():
            yield from _places(node.operand, whole, system)
        case ast.BinOp(op=ast.Add() | ast.Sub() | ast.Mult() | ast.Div()):
            yield from _places(node.left, whole, system)
            yield from _places(node.right, whole, system)
        case _:
            inner = (part for part in ast.walk(node) if isinstance(part, ast.expr) and part in whole.numbers)
            if any(whole.numbers[part].value(system.field).as_rational() is None for part in inner):
                raise NoEnclosureError("irrational numbers inside switching functions or powers")


def bounds_of(number: Number) -> tuple[Fraction, Fraction]:
    """Rational numbers of few digits below and above an irrational one."""
    ball, (_, exponent) = number.accurate_ball(PRECISION), frexp(float(number))
    scale = Fraction(2) ** (BITS - exponent)
    return floor(rational_below(ball) * scale) / scale, ceil(rational_above(ball) * scale) / scale
