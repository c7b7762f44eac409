"""Theorems about stability: what each needs to know, what it asks, and what it then states."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any, TypeAlias

from .cells import Cell, Inclusion, System, no_switching
from .formulas import Formula
from .invariance import MAX_OTHERS, Chain
from .lyapunov import Lyapunov
from .polynomials import Polynomial, constant
from .positivity import Proofs
from .roots import in_roots
from .work import items, rational, require, take, whole

Statement: TypeAlias = dict[str, Any]

ASYMPTOTICALLY_STABLE, STABLE, UNSTABLE = "asymptotically stable", "stable", "unstable"

OPTIONAL = "gain proper growth denominator logarithm roots arrival"  # hypotheses of theorem ``lyapunov``
RATES = {"finite": 0, "exponential": 1, "algebraic": 2}  # p in V' <= -kappa V^p


def show_stability(system: System, hypotheses: Any, proofs: Proofs) -> list[Statement]:
    """V is positive and does not rise: stable; it falls: asymptotically stable.

    A V that does not rise is enough for attraction where nothing else stays on one level of it, which further functions
    W_1, ..., W_k show (LaSalle 1960; Matrosov 1962; Ryan 1998): along every velocity off the point the first of
    ``-V', W_1', ..., W_k'`` that is not zero is positive.  *Proof.*  V falls to a limit along a bounded solution, so
    this tends to a compact set L_0 that is weakly invariant, with V constant.  Let V, W_1, ..., W_(j-1) be constant on
    such a set.  Along a solution in it W_j does not fall, and tends to a limit; what the solution tends to is such a
    set on which W_j is constant too.  In the last one a solution has no rate that is not zero: it is at the point.
    There V is zero, so it is zero on L_0, which is the point.

    With ``everywhere``, every solution tends to the point: V and the field are forms on cones; or all is shown in the
    whole space, and ``V + 1 >= proper |x|^2``, or ``V + 1 >= growth |x_k|`` for every k, so that level sets are
    bounded.  With ``level``, every start of the cube with ``V < level`` stays there and tends to the point; with
    ``below``, nothing is asked of points with ``V >= level`` but on the border of the cube.  With ``rate``, V falls
    that fast; with ``gain`` beside it, of solutions of ``x' in F(x) + d`` it falls that fast less ``gain |d|``, in the
    Euclidean norm.  With ``denominator`` V is a quotient, with ``logarithm`` it holds a logarithm, with ``roots`` it is
    about roots of states (:mod:`.lyapunov`); with ``arrival`` all solutions are at the point after a time.
    """
    needed = "cells function second verdict everywhere level below rate"
    cells, function, second, verdict, everywhere, level, below, rate, *others = take(hypotheses, needed, OPTIONAL)
    gain, proper, growth, denominator, inside, roots, arrival = others
    require(verdict in (ASYMPTOTICALLY_STABLE, STABLE), "a verdict")
    require(type(everywhere) is bool and type(below) is bool, "everywhere and below as true or false")
    attracts = verdict == ASYMPTOTICALLY_STABLE
    require(attracts or second is None, "further functions where the point attracts")
    require(everywhere is True or proper is growth is None, "a proper V for all starts")
    if roots is not None:
        require(second is level is rate is denominator is inside is None, "a verdict and a time of arrival in roots")
        system = in_roots(system, roots)
    require(arrival is None or (attracts and everywhere is True and roots is not None), "a time of arrival in roots")
    sizes = [] if arrival is None else [size_text(system, arrival)]
    lyapunov = read_functions(system, cells, function, second, proofs, sizes)
    if lyapunov.inclusion.domain.gradients is not None:
        require(level is rate is denominator is None and everywhere is False, "a verdict alone in a frame")
    if denominator is not None:
        require(second is None and rate is None, "a quotient without further functions and rates")
        lyapunov.divide_by(Formula(denominator, lyapunov.inclusion.domain.displacement).on(no_switching))
    if inside is not None:
        require(second is level is rate is denominator is None, "a logarithm with a verdict alone")
        lyapunov.add_logarithm(Formula(inside, lyapunov.inclusion.domain.displacement).on(no_switching))
    if below is True:
        lyapunov.require_below(rational(level))
    lyapunov.show_zero()
    lyapunov.show_positive()
    show_falling(lyapunov, strict=attracts)
    conclusions: list[Statement] = [{"stability": verdict}]
    about = {"function": function, "within": cells["within"]}
    if denominator is not None:
        about["denominator"] = denominator
    if type(function) is not str:
        about["surfaces"] = cells["surfaces"]  # to whose signs the pieces of V refer
    if system.coordinates != system.states:
        about["in"] = list(system.coordinates)
    if arrival is not None:
        conclusions.append({"arrives": show_arrival(lyapunov, arrival)})
    if everywhere is True:
        require(attracts and below is not True, "an attracting point")
        if proper is growth is None:
            lyapunov.require_all_of_space()
        if proper is not None:
            lyapunov.show_proper(rational(proper))
        if growth is not None:
            lyapunov.show_growth(rational(growth))
        conclusions.append({"attracts": "everywhere"})
    if level is not None:
        require(attracts and lyapunov.bounded and rational(level) > 0, "a positive level around a point that attracts")
        lyapunov.show_border(rational(level))
        conclusions.append({"attracts": {**about, "below": level}})
    if rate is not None:
        require(system.coordinates == system.states, "rates in the time of the states")
        show_rate(lyapunov, rate, gain)
        conclusions.append({"rate": {**about, **rate, **({"below": level} if below is True else {})}})
        conclusions += [{"gain": {**conclusions[-1]["rate"], "gamma": gain}}] if gain is not None else []
    return conclusions


def show_rate(lyapunov: Lyapunov, rate: Any, gain: Any = None) -> None:
    """``V' <= -kappa V^p`` off the point, on the domain; less ``gain |d|``.  p is the number in RATES.

    The derivative is taken here in units of the half-width of the cube.  Let ``x' = v + d`` with v in F(x).  At almost
    all times at which V bends on one surface g it has the derivative ``q . (v + d)`` for every
    ``q = grad P + mu grad g``.  Each field f beside the face allows an interval of mu for which ``q . f`` is at most
    that of the rate.  These intervals have a point in common, and each holds an end of the interval of the gradients
    between those of V on both sides; so all have a common point (Helly), and there ``q . d`` is at most ``gain |d|``.
    """
    kind, kappa = take(rate, "kind kappa")
    speed = rational(kappa) * lyapunov.inclusion.domain.radius
    known = type(kind) is str and kind in RATES
    require(speed > 0 and known, "a positive rate, finite, exponential or algebraic")

    def shift(cell: Cell) -> Polynomial:
        value = constant(lyapunov.count, speed)
        for _ in range(RATES[kind]):
            value *= lyapunov.potential(cell)
        return value

    lyapunov.show_falls("rate ", shift, strict=False)
    if gain is not None:
        require(rational(gain) > 0, "a positive gain")
        lyapunov.show_gradient(rational(gain) * lyapunov.inclusion.domain.radius)


def show_arrival(lyapunov: Lyapunov, data: Any) -> Statement:
    """Every solution is at the point after at most ``T S^e``, S the size ``sum_k c_k Abs(x_k)**(1/q_k)`` of its start.

    Let all pieces of V be forms of degree p.  If ``V <= above S^p`` and ``V' <= -speed S^(p - e)``, then
    ``V' <= -speed (V/above)^((p - e)/p)``, so that ``V^(e/p)`` falls at least as fast as
    ``(e/p) speed above^(-(p - e)/p)``, and is zero after ``p above S^e/(e speed)`` at the latest.  These are claims
    about forms in the whole space, as all others are.

    Returns:
        The factor T, the numbers c, the orders q, 1 where the state itself stands, and the power e.
    """
    size, above, speed, power = take(data, "size above speed power")
    bound, fall = rational(above), rational(speed)
    require(min(bound, fall) > 0, "a time of arrival of positive numbers")
    system = lyapunov.inclusion.domain.system
    at_zero = all(not value for value, q in zip(system.origin, system.orders, strict=True) if q > 1)
    require(at_zero, "roots that are zero at the point")
    degrees = {sum(e) for cell in lyapunov.inclusion.cells for e in lyapunov.potential(cell).terms}
    require(len(degrees) == 1, "a V of forms of one degree")
    (degree,) = degrees
    e = whole(power, degree)
    require(e > 0, "a time of arrival with a positive power")
    speed_there = fall * lyapunov.inclusion.domain.radius
    for name, signs, cell in lyapunov.inclusion.pieces():
        lyapunov.show_below(name, signs, cell, cell.functions[-1].power(degree).times(bound))
    lyapunov.show_falls("arrival ", lambda cell: cell.functions[-1].power(degree - e).times(speed_there), strict=False)
    factor = degree * bound / (e * fall)
    return {"factor": str(factor), "size": size, "orders": list(system.orders), "power": e}


def size_text(system: System, data: Any) -> str:
    """``sum_k c_k Abs(w_k)`` as a function beside V, so that pieces and faces tell the signs of all coordinates."""
    size, *_ = take(data, "size above speed power")
    weights = [rational(value) for value in items(size, system.count)]
    require(min(weights) > 0, "a time of arrival of positive numbers")
    return " + ".join(f"({weight})*Abs({name})" for weight, name in zip(weights, system.coordinates, strict=True))


def show_instability(system: System, hypotheses: Any, proofs: Proofs) -> list[Statement]:
    """V falls where it is not positive, and is negative at all small distances in one direction, inside a cell.

    From there V falls, so it stays negative and the solution away from the point, where V is zero; away from it V falls
    at a speed that is bounded from below, and is bounded on the cube: the solution leaves it.  A V that does not rise
    is enough with further functions, as for stability: a solution that stayed in the cube would tend to the point,
    where V is zero.  And so is ``V' <= -speed V^2``, with a positive number: V falls below all bounds (Chetaev 1934).
    """
    cells, function, second, direction, speed, roots = take(
        hypotheses, "cells function second direction", "speed roots"
    )
    require(roots is None or second is speed is None, "a verdict alone in roots")
    lyapunov = read_functions(system if roots is None else in_roots(system, roots), cells, function, second, proofs)
    require(lyapunov.bounded, "a cube")
    lyapunov.below = Fraction(0)
    lyapunov.show_zero()
    if speed is None:
        show_falling(lyapunov, strict=True)
    else:
        require(second is None and rational(speed) > 0, "a positive speed, and no further functions")
        lyapunov.show_falls_by_square(rational(speed))
    ray = [rational(value) for value in items(direction, lyapunov.count)]
    require(lyapunov.is_negative_along(ray), "a V that is negative in the direction")
    return [{"stability": UNSTABLE}]


def show_departure(system: System, hypotheses: Any, proofs: Proofs) -> list[Statement]:
    """All velocities at the point have a positive product with one direction, so 0 is not in F there.

    F is upper semicontinuous, so near the point all products stay above a positive number: every solution leaves.
    """
    cells, data = take(hypotheses, "cells direction")
    inclusion = Inclusion(system.stated, cells, ["0"], proofs)
    direction = [rational(value) for value in items(data, system.count)]
    for cell in inclusion.around():
        for _, field in cell.fields:
            product = sum(n * part.at_origin for n, part in zip(direction, field, strict=True))
            require(product > 0, "a direction in which all velocities at the point lead")
    return [{"stability": UNSTABLE}, {"equilibrium": False}]


def read_functions(
    system: System, cells: Any, function: Any, second: Any, proofs: Proofs, beside: Sequence[str] = ()
) -> Lyapunov:
    """V, with further functions where the hypotheses name some, or others that only stand beside it."""
    if second is None:
        return Lyapunov(Inclusion(system, cells, [function, *beside], proofs, framed=True), proofs)
    others, zeros = take(second, "functions zeros")
    functions = [function, *items(others, most=MAX_OTHERS)]
    return Chain(Inclusion(system, cells, functions, proofs), proofs, zeros)


def show_falling(lyapunov: Lyapunov, *, strict: bool) -> None:
    """V falls off the point, or does not rise; where there are further functions, these rise one after the other."""
    if isinstance(lyapunov, Chain):
        lyapunov.show_chain()
    else:
        lyapunov.show_falls("", lyapunov.zero, strict=strict)
