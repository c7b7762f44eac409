"""Scene files of plain systems with ``sqrt(Abs(x))``, rewritten as files without (:mod:`symbolic.signed_roots`)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from fractions import Fraction
from typing import Any

from nonsmooth.symbolic.expression import ExpressionError, parse
from nonsmooth.symbolic.files.right_hand_sides import float_point
from nonsmooth.symbolic.files.scene_values import Exact
from nonsmooth.symbolic.files.system_document import SystemDocument
from nonsmooth.symbolic.scene_error import SceneError, requirement
from nonsmooth.symbolic.signed_roots import SignedRoots

Rewrite = Callable[[object, int], object]  # of the right-hand side of a state


def formulas_of(document: SystemDocument) -> Iterator[object]:
    """Every formula of the states in a document."""
    yield document.check.lyapunov
    for side in document.system.rhs or ():
        yield from side if isinstance(side, list) else (side,)
    for region in document.region:
        yield from (*region.where, *region.rhs)


def rooted_documents(
    document: SystemDocument, roots: SignedRoots, file: str
) -> tuple[SystemDocument, SystemDocument, SystemDocument]:
    """The document in signed roots and scaled time, in signed roots alone, and with each root as a further state.

    Raises:
        SceneError: for an equilibrium whose roots have no names.
    """
    seen = _in_roots(document, roots, roots.seen_field, file)
    unscaled = _in_roots(document, roots, lambda formula, place: roots.seen(formula), file)
    return seen, unscaled, _extended(document, roots, file)


def _in_roots(document: SystemDocument, roots: SignedRoots, rewrite: Rewrite, file: str) -> SystemDocument:
    check = document.check
    point = _signed_roots(document, roots, file)
    changed = {"lyapunov": roots.seen(check.lyapunov), "radius": _radius(document, roots)}
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
        sizes = tuple(_root(value, file, signed=False) for value in _of_rooted(point, roots))
        changed["equilibrium"] = (*point, *sizes)
    return _rewritten(document, names, rewrite, roots.extended).model_copy(
        update={"check": check.model_copy(update=changed)}
    )


def _rewritten(
    document: SystemDocument, states: tuple[str, ...], rewrite: Rewrite, guard: Callable[[object], object]
) -> SystemDocument:
    more = ("0",) * (len(states) - len(document.system.states))

    def fields(side: Any) -> tuple[object, ...]:
        known = (*(rewrite(formula, k) for k, formula in enumerate(side)),)
        return (*known, *more) if len(known) == len(document.system.states) else known

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


def _of_rooted(point: tuple[Exact, ...], roots: SignedRoots) -> list[Exact]:
    return [value for name, value in zip(roots.states, point, strict=False) if name in roots.rooted]


def _signed_roots(document: SystemDocument, roots: SignedRoots, file: str) -> tuple[Exact, ...] | None:
    """The checked point in the roots."""
    point = document.check.equilibrium
    if point is None:
        return None
    named = zip(roots.states, point, strict=False)
    known = tuple(_root(value, file, signed=True) if name in roots.rooted else value for name, value in named)
    return (*known, *point[len(known) :])


def _root(value: Exact, file: str, *, signed: bool) -> Exact:
    """``sgn(a) sqrt(abs(a))``, or without the sign, as a formula."""
    text = str(value) if isinstance(value, Fraction) else value.text
    try:
        negative = float_point(("a",), (value,))["a"] < 0
        root = f"sqrt(-({text}))" if negative else f"sqrt({text})"
        return parse(f"-{root}" if negative and signed else root)
    except ExpressionError as error:
        raise SceneError(file, "check.equilibrium", requirement(error), text) from None


def _radius(document: SystemDocument, roots: SignedRoots) -> Exact:
    """The half-width in the roots: at most one, so that it holds no more of the states, and off zeros of roots.

    Floats choose between widths; whatever they choose, the domain of a proof is named with it.
    """
    radius = document.check.radius
    point = float_point(roots.states, document.check.equilibrium)
    sizes = [abs(point[name]) ** 0.5 for name in roots.rooted]
    most = min([1.0, *(size / 2 for size in sizes if size)])
    return radius if float_point(("r",), (radius,))["r"] <= most else Fraction(most).limit_denominator(64)
