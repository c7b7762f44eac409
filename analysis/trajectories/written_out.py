"""DOP853 for few states, written out: each stage of each state is one sum, without the coefficients that are zero.

The two functions for n states are written from SciPy's coefficients, and compiled once.  Of one state x0 with rates
k0_0, k1_0, ... at the stages the first begins::

    k1_0, = rates(x0 + h * (0.05260015195876773*k0_0), )
    k2_0, = rates(x0 + h * (0.0197250569845379*k0_0 + 0.0591751709536137*k1_0), )
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from typing import NamedTuple

from nonsmooth.analysis.fields.float_code import Numbers, compiled, listed, names, weighted

MOST_STATES = 4  # of which steps are written out: the text grows with them, and what is gained shrinks


class WrittenOut(NamedTuple):
    """Two functions of a field's rates, of a length h, and of states and rates one by one.

    Attributes:
        trial: from h, the tolerances, the state and its rates: the state at the end of a step, the rates at all stages,
            the last at that end, and the squares of the errors of third and of fifth order, in tolerances over h.
        inner: from h, the state, its rates at all stages and the state at the end: eight coefficients for each state,
            of the polynomial ``x + s (a + r (b + s (c + r (d + s (e + r (f + s g))))))`` in the passed share s of the
            step, and the share r = 1 - s that is left.
    """

    trial: Callable[..., tuple[Numbers, tuple[Numbers, ...], float, float]]
    inner: Callable[..., tuple[Numbers, ...]]


@cache
def written_out(count: int) -> WrittenOut:
    """Both functions for so many states."""
    from scipy.integrate import DOP853

    end, states = len(DOP853.B), range(count)  # the stage at the end of the step
    x, y = listed(names("x", count)), listed(names("y", count))
    k = [listed(names(f"k{stage}_", count)) for stage in range(end + 1 + len(DOP853.A_EXTRA))]
    stages = "".join(f"({own}), " for own in k[: end + 1])

    trial = [f"{k[stage]}= rates({_moved(DOP853.A[stage], count)})" for stage in range(1, end)]
    trial += [f"{y}= {_moved(DOP853.B, count)}", f"{k[end]}= rates({y})"]
    for s in states:
        trial += [f"scale = atol + rtol * max(abs(y{s}), abs(x{s}))"]
        trial += [f"third{s}, fifth{s} = ({_sum(DOP853.E3, s)}) / scale, ({_sum(DOP853.E5, s)}) / scale"]
    squares = (" + ".join(f"{error}{s} * {error}{s}" for s in states) for error in ("third", "fifth"))
    trial += [f"return ({y}), ({stages}), {', '.join(squares)}"]

    inner = [f"{own}= rates({_moved(row, count)})" for own, row in zip(k[end + 1 :], DOP853.A_EXTRA, strict=True)]
    for s in states:
        inner += [f"a{s} = y{s} - x{s}", f"b{s} = h * k0_{s} - a{s}", f"c{s} = 2 * a{s} - h * (k{end}_{s} + k0_{s})"]
    highest = [listed(f"h * ({_sum(row, s)})" for row in DOP853.D) for s in states]
    inner += [f"return {listed(f'(x{s}, a{s}, b{s}, c{s}, {highest[s]})' for s in states)}"]
    return WrittenOut(
        compiled(f"rates, h, rtol, atol, {x}{k[0]}", *trial),
        compiled(f"rates, h, {x}{''.join(k[: end + 1])}{y}", *inner),
    )


def _moved(weights: Sequence[float], count: int) -> str:
    """The states after a step along weighted rates."""
    return listed(f"x{s} + h * ({_sum(weights, s)})" for s in range(count))


def _sum(weights: Sequence[float], state: int) -> str:
    """The weighted sum of the rates of a state at the stages."""
    return weighted((weight, [f"k{stage}_{state}"]) for stage, weight in enumerate(weights))
