"""What a ``[system]`` table of a scene file says: a switched system in any number of states.

Structure is checked by pydantic, formulas by :mod:`nonsmooth.symbolic.formulas.piecewise`.  Whatever is wrong ends in
one :class:`SceneError`, as for wheel arrays.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import lru_cache
from itertools import chain
from math import lcm
from pathlib import Path
from typing import Any

from nonsmooth.symbolic.files.right_hand_sides import (
    float_point,
    has_norms,
    intervals_in,
    rational_point,
    read_right_hand_sides,
    split_intervals,
)
from nonsmooth.symbolic.files.scene_values import Exact, Numbers, angles, field_of, validate
from nonsmooth.symbolic.files.system_document import (
    RESERVED,
    SystemCheckTable,
    SystemDocument,
    compared,
    parameter_texts,
    regions_as_formulas,
    with_parameters,
)
from nonsmooth.symbolic.formulas.cleared_fractions import FractionClearing
from nonsmooth.symbolic.formulas.enclosed_functions import LISTED, TURNING, has_waves
from nonsmooth.symbolic.formulas.expression import formula_refused, parse
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression, parse_piecewise
from nonsmooth.symbolic.formulas.signed_roots import SignedRoots, orders_in, signed_root
from nonsmooth.symbolic.formulas.trees import ExpressionError, readable_tree, written
from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact, requirement
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_field import FirstRemark
from nonsmooth.symbolic.numbers.number_text import short_text
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.systems.switched_system import CheckedCube, Enclosed, Rewriting, SeenByRoots, SwitchedSystem

# Said of a system with a state V: to rename it would change what the user wrote.
TWO_MEANINGS = (
    "V is a state here, and the Lyapunov function too: before =, < and in V' it is the function, in its formula and in "
    "abs(V) the state"
)
MOST_PARTS = 64  # that are kept
LARGEST_RADIUS = 10**150  # squares of such numbers are floats
SQUARE = 2  # the order of a square root


# What right-hand sides take beside what V takes.
IN_RIGHT_HAND_SIDES = (
    f"{LISTED} of polynomials in the states",
    "sqrt and rational powers of Abs of a state",
    "sqrt of sums of squares",
)


def parse_lyapunov(
    text: object, states: tuple[str, ...], file: str, key: str, beside: Sequence[str] = ()
) -> PiecewiseExpression:
    """V, or a right-hand side, which may hold some functions beside, as a formula of the states.

    Raises:
        SceneError: for anything else.
    """
    with formula_refused(file, key, text):
        return parse_piecewise(text, states, beside)


def build_system(data: dict[str, Any], file: str, path: Path, *, order: int = 0) -> SwitchedSystem:
    """The system of a document, by the parts that ``read_document`` returns.

    Args:
        data: the document.
        file: for messages.
        path: whose stem is the name of a scene that states none.
        order: further terms of sines and cosines that are enclosed.

    Raises:
        SceneError: for whatever cannot be used.
    """
    document = validate(SystemDocument, data, file)
    roots = _signed_roots(document, file)
    if roots is None:
        system = _plain_system(document, file, path, order)
    else:
        system = _seen_by_roots(document, roots, file, path)
    if "V" in system.stated_states:
        system.field.remarks += (FirstRemark(TWO_MEANINGS),)
    return system


def with_order(system: SwitchedSystem, order: int) -> SwitchedSystem:
    """A system whose sines and cosines are enclosed with further terms.

    Raises:
        SceneError: for formulas of too high a degree.
    """
    return _of_lists(system, system.rewriting.written, order)


def with_roots(system: SwitchedSystem, orders: Sequence[int]) -> SwitchedSystem:
    """A system in the signed roots of its states, which is checked at the origin.

    Args:
        system: whose own V is left aside.
        orders: of the root of each state, a multiple of those that formulas ask for; 1 where it stays itself.

    Raises:
        SceneError: for formulas of too high a degree, and where the name of a root is taken.
    """
    stated = {"states": list(system.stated_states), "rhs": list(map(list, system.stated_lists))}
    radius = {"radius": str(system.check.radius)}
    document = validate(SystemDocument, {"name": system.name, "system": stated, "check": radius}, system.source)
    rooted = {name: order for name, order in zip(system.stated_states, orders, strict=True) if order > 1}
    roots = SignedRoots(system.stated_states, tuple(rooted), tuple(rooted.values()))
    rooted_system = _seen_by_roots(document, roots, system.source, Path(system.name))
    return replace(rooted_system, intervals=system.intervals, overlaps=system.overlaps)


def without_waves(system: SwitchedSystem) -> SwitchedSystem | None:
    """The system of those right-hand sides without sines and cosines of states; None where there are none.

    Raises:
        SceneError: for formulas that cannot be used.
    """
    lists = [formulas for formulas in system.rewriting.written if not any(map(has_waves, formulas))]
    return _of_lists(system, lists, 0) if lists and system.by_roots is None else None


def part_of(system: SwitchedSystem, chosen: Sequence[str], texts: Mapping[str, str]) -> SwitchedSystem:
    """The system of some states, with the others replaced by formulas; one under a square root by its value.

    Raises:
        SceneError: for formulas that cannot be used.
    """
    numbers = [system.stated_states.index(name) for name in chosen]
    lists = dict.fromkeys(tuple(_replaced(system, side[k], texts) for k in numbers) for side in system.stated_lists)
    at, radius = tuple(str(system.stated_point[k]) for k in numbers), str(system.check.radius)
    return _built_part(tuple(chosen), tuple(lists), at, radius, system.source, Path(system.name))


@lru_cache(maxsize=MOST_PARTS)
def _built_part(
    states: tuple[str, ...], lists: tuple[tuple[str, ...], ...], at: tuple[str, ...], radius: str, *origin: Any
) -> SwitchedSystem:
    """One object for equal parts, which are met again as parts of parts: what is decided of one is known of all."""
    stated = {"states": list(states), "rhs": list(map(list, lists))}
    return build_system({"system": stated, "check": {"equilibrium": list(at), "radius": radius}}, *origin)


def _replaced(system: SwitchedSystem, formula: str, texts: Mapping[str, str]) -> str:
    if system.by_roots is None:
        return str(with_parameters(formula, texts))
    roots = system.by_roots.roots
    at = dict(zip(system.stated_states, system.check.equilibrium, strict=True))
    values = {root: f"({abs(at[name])})" for name, root in roots.names.items() if name in texts}
    return roots.restored(str(with_parameters(roots.extended(formula), {**texts, **values})))


def _of_lists(system: SwitchedSystem, lists: Sequence[Sequence[str]], order: int) -> SwitchedSystem:
    """The system with these lists of formulas."""
    check = system.check
    lyapunov = {} if check.is_default else {"lyapunov": check.lyapunov.text}
    point = {"equilibrium": list(map(str, check.equilibrium)), "radius": str(check.radius)}
    stated = {"states": list(system.states), "rhs": list(map(list, lists))}
    document = {"name": system.name, "system": stated, "check": {**point, **lyapunov}}
    rebuilt = build_system(document, system.source, Path(system.name), order=order)
    quotient = replace(rebuilt.check, quotient=check.quotient)
    return replace(rebuilt, check=quotient, intervals=system.intervals, overlaps=system.overlaps)


def _plain_system(
    document: SystemDocument, file: str, path: Path, order: int = 0, sizes: Iterable[str] = ()
) -> SwitchedSystem:
    """The system of a document without square roots of states, of which some may be sizes."""
    states, check = document.system.states, document.check
    single, intervals = split_intervals(document.system.parameters, file)
    texts = parameter_texts(single, {*states, *RESERVED}, file)
    ends = parameter_texts({name: pair[0] for name, pair in intervals.items()}, {*states, *RESERVED}, file)
    stated = _stated(_whole(document, {**texts, **ends}, intervals, file), states, file)
    intervals = intervals_in(chain(*stated.values()), intervals)
    point = _float_point(states, check.equilibrium, file)
    clearing = FractionClearing(frozenset(states), point, frozenset(sizes))
    exact = rational_point(states, check.equilibrium)
    sides = read_right_hand_sides(stated, texts, intervals, clearing, file, point=exact, order=order)
    rhs, *others = (_parsed(side, states, file, key) for key, side in sides.sides)
    with_norms = (*states, *(norm.name for norm in sides.norms))
    default = " + ".join(f"{name}**2" for name in states)
    chosen = default if check.lyapunov is None else with_parameters(check.lyapunov, texts)
    quotient = _quotient(chosen, states, file)
    lyapunov = parse_lyapunov(default if quotient else chosen, states, file, "check.lyapunov")
    formulas = [formula for side in (rhs, *others) for formula in side]
    turns = [turn for formula in (*formulas, lyapunov) for turn in formula.turns()]
    numbers = Numbers(file, field_of([*turns, *angles(check)]))
    checked = CheckedCube(
        _equilibrium(check, states, numbers),
        _radius(check.radius, numbers),
        lyapunov,
        check.lyapunov is None or quotient is not None,
        quotient,
    )
    rewriting = Rewriting(
        written=sides.written,
        waves=sides.waves,
        denominators=_parsed(sides.denominators, with_norms, file, "system.rhs"),
        scale=_parsed((sides.scale,), with_norms, file, "system.rhs")[0] if sides.scale else None,
        named_rhs=_parsed(sides.named, (*states, *(wave.name for wave in sides.names)), file, "system.rhs"),
        names=sides.names,
        norms=sides.norms,
        order=order,
        encloses=tuple(enclosed for enclosed in Enclosed if enclosed.kind in sides.bounded),
    )
    system = SwitchedSystem(
        name=document.name or path.stem,
        field=numbers.field,
        states=states,
        rhs=rhs,
        check=checked,
        source=file,
        others=tuple(others),
        rewriting=rewriting,
        intervals=tuple(intervals),
        overlaps=document.system.overlap,
    )
    _require_zero_arguments(system)
    for member in system.members:
        for side in (1, -1):
            _try_pieces(member, side)
    return system


def _quotient(
    formula: object, states: tuple[str, ...], file: str
) -> tuple[PiecewiseExpression, PiecewiseExpression] | None:
    """The numerator and the denominator of a V that divides by states; None for any other.

    Raises:
        SceneError: for parts that are no formulas of the states.
    """
    tree = readable_tree(formula)
    if not isinstance(tree, ast.BinOp) or not isinstance(tree.op, ast.Div) or len(states) == 1:
        return None
    top, bottom = (parse_lyapunov(written(part), states, file, "check.lyapunov") for part in (tree.left, tree.right))
    if top.is_constant(top.tree) or bottom.is_constant(bottom.tree):
        return None
    if bottom.switching_parts:
        raise SceneError(file, "check.lyapunov", "a denominator without sign, Abs, Max and Min", formula)
    return top, bottom


def _radius(value: Exact, numbers: Numbers) -> Number:
    """Half the side of the checked square or cube.

    Raises:
        SceneError: where it is not positive, or beyond what floats can search.
    """
    radius = numbers.positive(value, "check.radius")
    if radius > LARGEST_RADIUS:
        raise SceneError(numbers.file, "check.radius", "a number of at most 10**150", StatedFact(short_text(radius)))
    return radius


def _signed_roots(document: SystemDocument, file: str) -> SignedRoots | None:
    """The states that stand under roots; None without any.

    Raises:
        SceneError: for roots of anything else, and where the name of a root means something else.
    """
    states, orders = document.system.states, dict[str, int]()
    single, _ = split_intervals(document.system.parameters, file)
    texts = parameter_texts(single, {*states, *RESERVED}, file)
    for key, formula in _keyed_formulas(document):
        guard = compared(formula)
        with formula_refused(file, key, formula):
            for side in (formula,) if guard is None else guard[::2]:
                for name, order in orders_in(side, states, texts).items():
                    orders[name] = lcm(orders.get(name, 1), order)
    rooted = tuple(name for name in states if name in orders)
    roots = SignedRoots(states, rooted, tuple(orders[name] for name in rooted), tuple(texts.items()))
    for name in {*states, *document.system.parameters} & set(roots.names.values()):
        raise SceneError(file, "system.states", "a name that is not that of a square root", name)
    return roots if rooted else None


def _seen_by_roots(document: SystemDocument, roots: SignedRoots, file: str, path: Path) -> SwitchedSystem:
    """The system in the signed roots of its states, with what it stands for.

    Raises:
        SceneError: as of a system without roots; it names the formulas and states of the file, and no roots.
    """
    try:
        in_roots, in_time_of_states, with_sizes = rooted_documents(document, roots, file)
        scaled, unscaled = (_plain_system(part, file, path) for part in (in_roots, in_time_of_states))
        extended = _plain_system(with_sizes, file, path, sizes=roots.names.values())
    except SceneError as error:
        stated, expected = dict(_keyed_formulas(document)), error.expected
        for name, root in roots.names.items():
            expected = expected.replace(root, name)
        received = stated.get(error.key, error.value)
        if any(root in str(received) for root in roots.names.values()):
            received = StatedFact(f"{received} with {', '.join(roots.meanings)}")
        raise SceneError(error.file, error.key, expected, received) from None
    written = tuple(tuple(map(roots.restored, part[: len(roots.states)])) for part in extended.stated_lists)
    unscaled = replace(scaled, rhs=unscaled.rhs, others=unscaled.others)  # over the same number field
    rewriting = replace(scaled.rewriting, written=written)
    return replace(scaled, rewriting=rewriting, by_roots=SeenByRoots(roots, extended, unscaled))


def _whole(
    document: SystemDocument, texts: Mapping[str, str], intervals: Mapping[str, Any], file: str
) -> tuple[object, ...]:
    """The right-hand sides, or what the region tables say.

    Raises:
        SceneError: for neither, for both, and for tables that cannot be used.
    """
    states, rhs, overlap = document.system.states, document.system.rhs, document.system.overlap
    if overlap and not document.region:
        raise SceneError(file, "system.overlap", "[[region]] tables that may overlap", StatedFact("none"))
    if (rhs is None) is not bool(document.region):
        received = StatedFact("both" if document.region else "neither")
        raise SceneError(file, "system.rhs", "formulas, or [[region]] tables", received)
    if rhs is not None:
        return rhs

    def check(formula: object, key: str) -> None:
        complete = with_parameters(formula, texts)
        if ".where[" in key and (has_waves(complete) or intervals_in((formula,), intervals)):
            raise SceneError(file, key, "a guard without interval parameters and sines of states", formula)
        if not has_waves(complete) and (".where[" in key or not has_norms((complete,), states)):
            parse_lyapunov(complete, states, file, key)

    return regions_as_formulas(document.region, states, check, file, overlap=overlap)


def _stated(value: tuple[object, ...], states: tuple[str, ...], file: str) -> dict[str, tuple[object, ...]]:
    """One list of formulas, or several of them, by key."""
    nested = bool(value) and all(isinstance(part, list) for part in value)
    sides = {}
    for k, side in enumerate(value if nested else (value,), 1):
        key = f"system.rhs[{k}]" if nested else "system.rhs"
        sides[key] = tuple(side) if isinstance(side, list | tuple) else ()
        _require_one_each(states, sides[key], file, key, "formulas")
    return sides


def _parsed(
    formulas: Sequence[object], states: tuple[str, ...], file: str, key: str
) -> tuple[PiecewiseExpression, ...]:
    return tuple(
        parse_lyapunov(text, states, file, f"{key}[{j}]", IN_RIGHT_HAND_SIDES) for j, text in enumerate(formulas, 1)
    )


def _float_point(states: tuple[str, ...], values: Sequence[Exact] | None, file: str) -> dict[str, float]:
    with formula_refused(file, "check.equilibrium", StatedFact("another")):
        return float_point(states, values)


def _require_zero_arguments(system: SwitchedSystem) -> None:
    """Refuse sines and the like of what does not vanish at the checked point.

    Raises:
        SceneError: for such an argument.
    """
    states = system.displaced(system.states)
    for wave in system.rewriting.waves:
        try:
            arguments = [system.argument_of(wave, states, lambda _, side=side: side) for side in (1, -1)]  # type: ignore[misc]
        except ExpressionError:
            expected = f"{LISTED} of polynomials in the states, and of what switches between them"
            raise SceneError(system.source, "system.rhs", expected, wave.argument) from None
        if any((0,) * len(system.states) in argument.terms for argument in arguments):
            expected = f"{wave.kind} of what is zero at the checked point"
            if wave.kind in TURNING:
                expected = "sin and cos of what is zero at the checked point, up to a multiple of pi"
            raise SceneError(system.source, "system.rhs", expected, str(system.argument_of(wave, sign_of=lambda _: 1)))


def _equilibrium(check: SystemCheckTable, states: tuple[str, ...], numbers: Numbers) -> tuple[Number, ...]:
    """The checked point, the origin unless the file names one."""
    key = "check.equilibrium"
    values = (Fraction(0),) * len(states) if check.equilibrium is None else check.equilibrium
    _require_one_each(states, values, numbers.file, key, "numbers")
    return tuple(numbers(value, key) for value in values)


def _require_one_each(states: tuple[str, ...], values: tuple[object, ...], file: str, key: str, kind: str) -> None:
    if len(values) != len(states):
        raise SceneError(file, key, f"{len(states)} {kind}, one for each state", StatedFact(f"{len(values)}"))


def _try_pieces(system: SwitchedSystem, side: int) -> None:
    """Refuse formulas that are no polynomials at one state; the other pieces are looked at where they are used."""
    state = [Fraction(side * (k * k + 1), k + 2) for k in range(1, len(system.states) + 1)]

    def sign_of(expression: Polynomial) -> int:
        return expression(state).sign() or side

    system.velocity(sign_of)
    for lyapunov in system.check.quotient or (system.check.lyapunov,):
        with formula_refused(system.source, "check.lyapunov", lyapunov.text):
            lyapunov.polynomial(dict(zip(system.states, system.coordinates(), strict=True)), sign_of)
    if system.check.quotient is not None:
        _require_denominator(system, system.check.quotient[1])


def _require_denominator(system: SwitchedSystem, bottom: PiecewiseExpression) -> None:
    """Refuse a denominator of V that is seen not to be positive off the point.

    Raises:
        SceneError: for one that is negative at the point, or zero there and no form of an even degree.
    """
    polynomial = bottom.polynomial(dict(zip(system.states, system.coordinates(), strict=True)), lambda _: 1)
    at_point = polynomial.terms.get((0,) * len(system.states))
    fits = polynomial.is_homogeneous and polynomial.degree % 2 == 0 if at_point is None else at_point.sign() > 0
    if not fits:
        expected = "polynomials, or one over a polynomial that is positive off the point such as x**2 + y**2"
        raise SceneError(system.source, "check.lyapunov", expected, bottom.text)


# ---- roots of states -----------------------------------------------------------------------------


Rewrite = Callable[[object, int], object]  # of the right-hand side of a state


def _keyed_formulas(document: SystemDocument) -> Iterator[tuple[str, object]]:
    """Every formula of the states in a document, with its key."""
    yield "check.lyapunov", document.check.lyapunov
    for k, side in enumerate(document.system.rhs or (), 1):
        if isinstance(side, list):
            yield from ((f"system.rhs[{k}][{j}]", formula) for j, formula in enumerate(side, 1))
        else:
            yield f"system.rhs[{k}]", side
    for k, region in enumerate(document.region, 1):
        yield from ((f"region[{k}].where[{j}]", guard) for j, guard in enumerate(region.where, 1))
        yield from ((f"region[{k}].rhs[{j}]", formula) for j, formula in enumerate(region.rhs, 1))


def rooted_documents(
    document: SystemDocument, roots: SignedRoots, file: str
) -> tuple[SystemDocument, SystemDocument, SystemDocument]:
    """The document in signed roots and scaled time, in signed roots alone, and with each root as a further state.

    Raises:
        SceneError: for an equilibrium whose roots have no names.
    """
    scaled = _in_roots(document, roots, roots.seen_field, file)
    unscaled = _in_roots(document, roots, lambda formula, place: roots.seen(formula), file)
    return scaled, unscaled, _extended(document, roots, file)


def _in_roots(document: SystemDocument, roots: SignedRoots, rewrite: Rewrite, file: str) -> SystemDocument:
    check = document.check
    point = _rooted_point(document, roots, file)
    changed = {"lyapunov": roots.seen(check.lyapunov), "radius": _rooted_radius(document, roots)}
    if point is not None:
        changed["equilibrium"] = point
    return _rewritten(document, roots.seen_states, rewrite, roots.seen).model_copy(
        update={"check": check.model_copy(update=changed)}
    )


def _extended(document: SystemDocument, roots: SignedRoots, file: str) -> SystemDocument:
    """Its right-hand side of a root is zero: what becomes of the root follows from the state."""

    def rewrite(formula: object, place: int) -> object:
        return roots.extended(formula)

    names = (*roots.states, *roots.names.values())
    check = document.check
    changed: dict[str, Any] = {"lyapunov": None}
    point = check.equilibrium
    if point is not None:
        named = dict(zip(roots.states, point, strict=False))
        sizes = tuple(_root(named[name], q, file, signed=False) for name, q in roots.order.items() if name in named)
        changed["equilibrium"] = (*point, *sizes)
    return _rewritten(document, names, rewrite, roots.extended).model_copy(
        update={"check": check.model_copy(update=changed)}
    )


def _rewritten(
    document: SystemDocument, states: tuple[str, ...], rewrite: Rewrite, in_guards: Callable[[object], object]
) -> SystemDocument:
    def guard(value: object) -> object:
        parts = compared(value)
        return value if parts is None else f"{in_guards(parts[0])} {parts[1]} {in_guards(parts[2])}"

    more = ("0",) * (len(states) - len(document.system.states))

    def fields(side: Any) -> tuple[object, ...]:
        formulas = (*(rewrite(formula, k) for k, formula in enumerate(side)),)
        return (*formulas, *more) if len(formulas) == len(document.system.states) else formulas

    rhs = document.system.rhs
    if rhs is not None:
        nested = bool(rhs) and all(isinstance(side, list) for side in rhs)
        rhs = tuple(list(fields(side)) for side in rhs) if nested else fields(rhs)
    regions = tuple(
        region.model_copy(update={"where": tuple(map(guard, region.where)), "rhs": fields(region.rhs)})
        for region in document.region
    )
    system = document.system.model_copy(update={"states": states, "rhs": rhs})
    return document.model_copy(update={"system": system, "region": regions})


def _rooted_point(document: SystemDocument, roots: SignedRoots, file: str) -> tuple[Exact, ...] | None:
    """The checked point in the roots."""
    point = document.check.equilibrium
    if point is None:
        return None
    named, order = zip(roots.states, point, strict=False), roots.order
    coordinates = tuple(
        _root(value, order[name], file, signed=True) if name in order else value for name, value in named
    )
    return (*coordinates, *point[len(coordinates) :])


def _root(value: Exact, order: int, file: str, *, signed: bool) -> Exact:
    """``sgn(a) abs(a)**(1/q)``, or without the sign, as a formula; of another order than two it must be rational."""
    text = str(value) if isinstance(value, Fraction) else value.text
    try:
        if order != SQUARE:
            rational = signed_root(Fraction(text), order)
            return rational if signed else abs(rational)
        negative = float_point(("a",), (value,))["a"] < 0
        root = f"sqrt(-({text}))" if negative else f"sqrt({text})"
        return parse(f"-{root}" if negative and signed else root)
    except ExpressionError as error:
        raise SceneError(file, "check.equilibrium", requirement(error), text) from None
    except ValueError:
        expected = f"a fraction with a rational root of order {order}, as this state stands under one"
        raise SceneError(file, "check.equilibrium", expected, text) from None


def _rooted_radius(document: SystemDocument, roots: SignedRoots) -> Exact:
    """The half-width in the roots: at most one, so that it holds no more of the states, and off zeros of roots.

    Floats choose between widths; whatever they choose, the domain of a proof is named with it.
    """
    radius = document.check.radius
    point = float_point(roots.states, document.check.equilibrium)
    sizes = [abs(point[name]) ** (1 / order) for name, order in roots.order.items()]
    most = min([1.0, *(size / 2 for size in sizes if size)])
    return radius if float_point(("r",), (radius,))["r"] <= most else Fraction(most).limit_denominator(64)
