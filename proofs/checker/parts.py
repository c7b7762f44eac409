"""Stability by parts: of cascades, where some states drive others, and of solutions that slide on a surface.

Both theorems ask about systems in fewer states, in which the other states are what they are at the point, or on the
surface.  Formulas must be continuous in what is replaced so: it may stand in the argument of no ``sign``.  Then the
velocities of the states that are left, beside a place where the others are so, tend to those of the smaller system
there, and to no others; and what tends to a place of a set that is closed and convex at each place, and upper
semicontinuous, is in it.  A part of a cascade may also *jump* with what is replaced, where this leaves of the arguments
of all its jumps forms of first degree whose gradients are independent: then any signs of those that vanish at a place
are met beside it in the smaller system, too, so that velocities tend to no others.  Beside that the arguments may hold
whatever is continuous in what is replaced, and is a number where that is at the point: roots, ``Abs``, ``sat``.

*Cascade.*  The states are listed in parts, and the right-hand sides of each hold no states of later ones.  Each part is
judged with the earlier ones at the point.  If all are asymptotically stable so is the whole; it is stable if each part
is that, or is stable and holds no states of others; and unstable if one is that holds no states of others, or holds
those of stable ones, where there is one right-hand side.  *Proof.* By induction over the parts: let x be the states of
those before and y those of the next one, asymptotically stable for ``x = 0``.  There is a smooth W that is positive and
falls off ``y = 0`` there (Clarke, Ledyaev and Stern 1998).  By upper semicontinuity, for every ``0 < d < c`` that are
small enough, there is an r with ``W' < 0`` where ``d <= W(y) <= c`` and ``|x| <= r``.  If x stays within r, no solution
leaves ``W <= c``; if x tends to 0 then W falls below every d.  A part that is stable and holds no others stays near by
itself.  Solutions of a part that holds no others are those of the first components of solutions of the whole, so one
that leaves is enough.  Stable parts x may stay at the point: 0 is a mixture of the velocities there of each, with the
earlier ones at the point.  These jump with x alone, and what those of y jump with takes any signs beside each place of
x, so that each of the former goes with each of the latter, and y may leave meanwhile.  (Vidyasagar 1980; Seibert and
Florio 1995.) Velocities with roots of ``Abs(x)`` are continuous in x as well, and W belongs to the inclusion of the
states y: whether a part is judged in its states or in roots of these (:mod:`.roots`) makes no difference to its
verdict.

A part y that is *carried* may be only stable, by a W that does not rise and does not bend where fields jump, where each
part x that drives it holds no states of others and has a V with ``V' <= -kappa V`` or ``V' <= -kappa``.  *Proof.*
Velocities of y are continuous in x and polynomials on pieces, so those at x are within ``L |x|`` of those with x at the
point, and ``W' <= L' |x|``.  V is one polynomial on each cell, and positive off the point: so ``|x|^m <= C V`` for an m
(Łojasiewicz 1959), and the integral of ``|x|`` over all times tends to 0 with the start of x.  So W rises by as little
as one likes.  (Total stability: Hahn 1967.)

*Sliding.*  A surface ``s = a x_k + q = 0``, with q in the other states, goes through the point, and s' has at the point
the sign of -s on all cells around it.  Then the verdict on the other states on the surface is that on the point.
*Proof.*  Near the point ``|s|' <= -h`` off the surface, with ``h > 0``, so every solution comes to it in a time of
``|s|/h``, in which it moves by a multiple of ``|s|``, and stays on it as long as it is near the point.  There the other
states are solutions of their system, and x_k is ``-q/a``.  And every solution of that system is one on the surface: a
mixture of its velocities belongs to the same mixture of fields above the surface, where s falls, and of fields below,
where it rises, as x_k can be changed alone; so to a mixture of both that keeps s.  (Filippov 1988; Utkin 1992.)
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

from .cells import Inclusion, System, no_switching, require_formulas
from .centres import show_integral, show_reversible
from .choice import show_choice
from .escape import show_escape
from .formulas import Formula, WaveAt, parsed, series
from .homogeneous import show_homogeneous
from .polynomials import Coefficient, Polynomial, constant, lie_derivative, solve, variable
from .positivity import Proofs
from .roots import RootedFormula, RootedSystem, read_roots
from .theorems import (
    ASYMPTOTICALLY_STABLE,
    STABLE,
    UNSTABLE,
    Statement,
    show_departure,
    show_instability,
    show_stability,
)
from .work import items, require, take, text, whole

Place: TypeAlias = Mapping[str, Polynomial]

CONTINUOUS = "continuous"  # of a part that jumps with formulas that are no polynomials in the states of others
OF_FIRST_DEGREE = "jumps with forms of first degree in the states of a part"


@dataclass(frozen=True)
class ReplacedState:
    """A state that is at the point, or on a surface.

    Attributes:
        name: of the state.
        at: the point, by the names of all states.
        surface: s, a formula in the displacement; None at the point.
        slope: the derivative of s by the state, a number.
    """

    name: str
    at: Mapping[str, Coefficient]
    surface: str | None = None
    slope: Coefficient | None = None

    def value(self, place: Place) -> Polynomial:
        """The state in terms of the others."""
        count = next(iter(place.values())).count
        centre = constant(count, self.at[self.name])
        if self.surface is None or self.slope is None:
            return centre
        away = {name: polynomial - constant(count, self.at.get(name, 0)) for name, polynomial in place.items()}
        rest = Formula(self.surface, {**away, self.name: constant(count, 0)}).on(no_switching)
        return centre - rest.times(1 / self.slope)

    def expanded(self, names: set[str]) -> set[str]:
        """The states on which something depends that holds these."""
        if self.name not in names:
            return names
        more = set() if self.surface is None else names_in(parsed(self.surface))
        return (names | more) - {self.name}


@dataclass(frozen=True)
class Part(System):
    """Some states of a system, with the others replaced; those that were replaced first come first."""

    replaced: tuple[ReplacedState, ...] = ()

    def fields(self, place: Place, wave: WaveAt | None = None) -> Sequence[Sequence[Formula]]:
        """The formulas of the velocities at a place, for each right-hand side."""
        return super().fields(self.whole(place), wave)

    def whole(self, place: Place) -> dict[str, Polynomial]:
        """A place with the states that are replaced."""
        whole_place = dict(place)
        for state in reversed(self.replaced):
            whole_place[state.name] = state.value(whole_place)
        return whole_place


@dataclass(frozen=True)
class RootedPart(Part, RootedSystem):
    """A part of a system with roots of states: in the roots of some of its own, which may be none."""


def part_of(
    system: System, chosen: Sequence[str], replaced: Sequence[ReplacedState], roots: Mapping[str, int] | None = None
) -> Part:
    """The system of some states, in the roots of some of these, with others replaced."""
    numbers = [system.states.index(name) for name in chosen]
    rhs = tuple(tuple(side[k] for k in numbers) for side in system.rhs)
    place = tuple(system.at[k] for k in numbers)
    before = system.replaced if isinstance(system, Part) else ()
    part = Part(tuple(chosen), rhs, place, system.numbers, system.order, (*before, *replaced))
    if isinstance(system, RootedSystem):
        part = RootedPart(**vars(part), roots=roots or {})
    return part


def require_continuous(system: System, part: Part, replaced: set[str]) -> None:
    """The formulas of a part of a system jump with none of the states that are replaced."""
    for tree in trees(part):
        for call in jumps(tree):
            require(not depends_on(system, call) & replaced, "formulas that are continuous in what is replaced")


def require_crossing(part: Part, *, continuous: bool) -> None:
    """What the formulas of a part jump with is of first degree in its states, with independent gradients.

    Args:
        part: with the states of others as numbers.
        continuous: whether arguments may switch between formulas of such numbers, and hold roots of these; else they
            are polynomials.
    """
    count = part.count
    pairs = zip(part.states, part.at, strict=True)
    numbers = {name: constant(count, number) for name, number in part.numbers.items()}
    place = {name: variable(count, k) + constant(count, at) for k, (name, at) in enumerate(pairs)}
    whole_place = part.whole(place | numbers)
    calls = {ast.unparse(call.args[0]) for tree in trees(part) for call in jumps(tree)}
    forms = [
        RootedFormula(argument, whole_place, (), series, {}, ()).on(sign_of_number)
        if continuous
        else Formula(argument, whole_place).on(no_switching)
        for argument in sorted(calls)
    ]
    require(all(form.degree == 1 for form in forms), OF_FIRST_DEGREE)
    common = solve([form - constant(count, form.at_origin) for form in forms], count) or ()
    require(len(forms) == count - common[0].count, "jumps with forms whose gradients are independent")


def sign_of_number(value: Polynomial) -> int:
    """The sign of a polynomial that is a number other than zero."""
    require(not value.degree, OF_FIRST_DEGREE)
    return 1 if value.at_origin > 0 else -1


def trees(system: System) -> Iterator[ast.expr]:
    """The right-hand sides."""
    return (parsed(formula) for side in system.rhs for formula in side)


def jumps(node: ast.AST) -> Iterator[ast.Call]:
    """The calls of ``sign`` at which a formula jumps: those without a factor that vanishes where they do.

    Those in arguments of others are among them: ``y + sign(x)`` is y where x is zero, and nowhere beside.
    """
    if isinstance(node, ast.Call) and is_sign(node):
        yield node
        yield from jumps(node.args[0])
        return
    factors = factors_of(node)
    for factor in factors:
        argument = ast.unparse(factor.args[0]) if isinstance(factor, ast.Call) and is_sign(factor) else None
        if argument is None or all(base_of(other) != argument for other in factors):
            for part in [factor] if len(factors) > 1 else ast.iter_child_nodes(factor):
                yield from jumps(part)


def is_sign(node: ast.Call) -> bool:
    """Whether it is a call of ``sign`` of one argument."""
    return ast.unparse(node.func) in ("sign", "sgn") and len(node.args) == 1


def factors_of(node: ast.AST) -> list[ast.AST]:
    """The factors of a product; of anything else itself."""
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult):
        return [*factors_of(node.left), *factors_of(node.right)]
    return [node]


def base_of(node: ast.AST) -> str:
    """What a factor vanishes with: v in v, -v, v/2, v**2, Abs(v), sqrt(Abs(v)) and Abs(v)**(2/3)."""
    match node:
        case ast.BinOp(ast.Call(ast.Name("Abs"), [inner]), ast.Pow(), ast.BinOp(ast.Constant(), ast.Div())):
            return base_of(inner)
        case ast.UnaryOp(operand=inner) | ast.BinOp(op=ast.Div(), left=inner):
            return base_of(inner)
        case ast.BinOp(op=ast.Pow(), left=inner, right=ast.Constant(value=int(power))) if power > 0:
            return base_of(inner)
        case ast.Call(func=ast.Name(id="Abs" | "sqrt"), args=[inner]):
            return base_of(inner)
    return ast.unparse(node)


def names_in(tree: ast.AST) -> set[str]:
    """The names that a formula holds."""
    return {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}


def depends_on(system: System, tree: ast.AST) -> set[str]:
    """The states that a formula of a system holds, also where one stands for others."""
    names = names_in(tree)
    for state in system.replaced if isinstance(system, Part) else ():
        names = state.expanded(names)
    return names & set(system.states)


def show_cascade(system: System, hypotheses: Any, proofs: Proofs) -> list[Statement]:
    """The verdict by parts; see the head of this file.

    Hypotheses: ``parts``, each with its ``states`` and the ``entry`` of a theorem about it, and perhaps ``carried``,
    ``leaves`` or ``jumps``; of a subject with roots also ``roots`` and ``orders``, in which the entry is.
    """
    (listed,) = take(hypotheses, "parts")
    require_formulas(system)
    at = dict(zip(system.states, system.at, strict=True))
    earlier: list[str] = []
    fading = set[str]()  # states of parts that come to the point so fast that what they carry hardly moves
    verdicts, pushed = set(), False  # whether others drive a part that only rests without them
    ordered = items(listed, most=system.count)
    for one in ordered:
        names, entry, *more = take(one, "states entry", "carried leaves jumps roots orders")
        carried, leaves, jumping, listed_roots, orders = more
        chosen = [text(name) for name in items(names, most=system.count)]
        require(chosen and set(chosen) <= set(system.states) - set(earlier), "states of parts that are no others'")
        require(len(set(chosen)) == len(chosen), "different states")
        roots = roots_of_part(system, chosen, listed_roots, orders)
        part = part_of(system, chosen, [ReplacedState(name, at) for name in earlier], roots)
        if jumping is None:
            require_continuous(system, part, set(earlier))
        else:
            known_word = jumping is True or jumping == CONTINUOUS
            require(known_word and carried is None, "parts that jump with others, and are not carried")
            require_crossing(part, continuous=jumping == CONTINUOUS)
        drivers = set[str]().union(*(depends_on(system, tree) for tree in trees(part))) & set(earlier)
        alone, conclusions = not drivers, shown_of(part, entry, proofs)
        verdict = stability_in(conclusions)
        if verdict == UNSTABLE:
            driven = leaves is True and len(system.rhs) == 1
            require(alone or driven, "an unstable part by itself, or that leaves with one right-hand side")
            require(one is ordered[-1], "an unstable part that ends the list")
            return [{"stability": UNSTABLE}]
        require(leaves is None, "parts that leave are unstable")
        if carried is None:
            pushed |= verdict != ASYMPTOTICALLY_STABLE and not alone
        else:
            require(carried is True and drivers <= fading, "a part that is carried by what comes fast to the point")
            require(not roots_of(system), "carried parts without roots of states")
            require_smooth(entry)
        if alone and any(
            "rate" in conclusion and conclusion["rate"]["kind"] != "algebraic" for conclusion in conclusions
        ):
            fading |= set(chosen)
        verdicts.add(verdict)
        earlier += chosen
    require(len(earlier) == system.count, "parts with all states")
    require(not pushed, "parts that attract, or hold no states of others")
    return [{"stability": STABLE if STABLE in verdicts else ASYMPTOTICALLY_STABLE}]


def roots_of_part(system: System, chosen: Sequence[str], listed: Any, orders: Any) -> Mapping[str, int]:
    """The states of a part that it is judged in roots of, with their orders.

    No root has the name of a state: a number that stands for this state would stand for the root, too.
    """
    require((listed is None) != bool(roots_of(system)), "roots of parts just where the subject has roots")
    roots = {} if listed in (None, []) else read_roots(listed, orders, chosen)
    require(roots or orders is None, "orders of roots")
    require(set(roots) <= set(roots_of(system)), "roots of states of which the subject has roots")
    require(
        not {f"root_{name}" for name in roots} & set(system.states), "names of roots that are no states of any part"
    )
    return roots


def roots_of(system: System) -> Mapping[str, int]:
    """The states of a system that it has roots of, with their orders."""
    return system.roots if isinstance(system, RootedSystem) else {}


def require_smooth(entry: Any) -> None:
    """A theorem is ``lyapunov``, and no claim is about faces: for each velocity V falls by its own polynomial.

    So it does beside a face, too: there V is smooth, or all cells have the same fields.
    """
    theorem, hypotheses, data = take(entry, "theorem hypotheses proofs")
    smooth = theorem == "lyapunov" and not any(name.startswith("face") for name in data)
    plain = hypotheses.get("denominator") is hypotheses.get("roots") is None
    require(smooth and plain, "a carried part with a V that bends nowhere, no quotient")


def show_sliding(system: System, hypotheses: Any, proofs: Proofs) -> list[Statement]:
    """The verdict on a surface on which solutions slide; see the head of this file.

    Hypotheses: ``cells`` (those of theorem ``departure``), ``surface`` (its number), ``state`` (x_k), and the ``entry``
    of a theorem about the other states.
    """
    cells, number, name, entry = take(hypotheses, "cells surface state entry")
    require(system.coordinates == system.states, "a surface without roots of states")
    inclusion = Inclusion(system, cells, ["0"], proofs)
    j = whole(number, len(inclusion.surfaces.listed) - 1)
    require(name in system.states and system.count > 1, "a state beside others")
    surface, k = inclusion.surfaces.listed[j], system.states.index(name)
    across = surface.derivative(k)
    require(across and not across.degree and not surface.at_origin, "a surface through the point that gives the state")
    for cell in inclusion.around():
        for _, velocity in cell.fields:
            require(lie_derivative(surface, velocity).at_origin * cell.signs[j] < 0, "a surface that all cells lead to")
    at = dict(zip(system.states, system.at, strict=True))
    slope = across.at_origin / inclusion.domain.radius
    others = [state for state in system.states if state != name]
    part = part_of(system, others, [ReplacedState(name, at, items(cells["surfaces"])[j], slope)])
    require_continuous(system, part, {name})
    return [{"stability": verdict_of(part, entry, proofs)}]


def show_scaled(system: System, hypotheses: Any, proofs: Proofs) -> list[Statement]:
    """What follows for a homogeneous inclusion (:mod:`.homogeneous`) from the verdict of another theorem.

    Hypotheses: ``cells`` (of the whole space), ``weights`` of the coordinates, and the ``entry`` of the theorem.
    """
    cells, weights, entry = take(hypotheses, "cells weights entry")
    return show_homogeneous(system, cells, weights, proofs, verdict_of(system, entry, proofs))


ABOUT_PARTS: dict[str, Callable[[Any, Any, Proofs], list[Statement]]] = {
    "lyapunov": show_stability,
    "instability": show_instability,
    "departure": show_departure,
    "escape": show_escape,
    "choice": show_choice,
    "reversible": show_reversible,
    "integral": show_integral,
    "cascade": show_cascade,
    "sliding": show_sliding,
}


def verdict_of(part: System, entry: Any, beside: Proofs) -> str:
    """What a theorem shows of the stability of a part, or of all."""
    return stability_in(shown_of(part, entry, beside))


def stability_in(conclusions: Sequence[Statement]) -> str:
    """The verdict among what is shown."""
    return str(next(conclusion["stability"] for conclusion in conclusions if "stability" in conclusion))


def shown_of(part: System, entry: Any, beside: Proofs) -> list[Statement]:
    """What a theorem shows of a part, or of all."""
    theorem, hypotheses, data = take(entry, "theorem hypotheses proofs")
    require(type(theorem) is str and theorem in ABOUT_PARTS, "a theorem about parts")
    proofs = beside.of_part(data)
    conclusions = ABOUT_PARTS[theorem](part, hypotheses, proofs)
    proofs.require_used()
    return conclusions
