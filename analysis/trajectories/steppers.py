"""Steppers: methods that solve one mode of a path, in steps with dense output.

:class:`Integrator` is any method of SciPy's.  :class:`StiffAware` takes DOP853 while accuracy rules its step, and Radau
once stability does: where a motion decays fast towards a slow one (feedback of high gain), the step of an explicit
method is held at the border of its region of stability, however little happens, and the number of steps grows with the
gain.  So every :data:`PROBED` steps the fastest decay is measured, ``rate = -min Re eig(df/dx)`` by forward
differences.  If it holds the step (``h rate >= HELD``; DOP853 is stable up to about 6) and many more such steps lie
ahead, the rest is integrated by Radau IIA of order 5, which is implicit and damps at every step (Hairer & Wanner 1996,
sec. IV.2 and IV.8).  Oscillations without decay never count as stiff: an implicit method would not gain there.

Fields of few states that are given in single floats are followed in them (:class:`ScalarDop853`): a step takes a fifth
of the time.  Of affine ones the explicit method is their Taylor series (:class:`TaylorSteps`).

Another method is a class with ``steps``, as in ``tests/rehearsals/midpoint.py``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from functools import cache, cached_property, partial
from itertools import chain, cycle
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from nonsmooth.analysis.fields.float_code import Numbers, compiled, listed, names, weighted
from nonsmooth.analysis.fields.switched_field import AffineVelocity, DifferentiatedVelocity, ScalarVelocity, differences
from nonsmooth.analysis.trajectories.follow import DenseStep, Interpolant, PolynomialInterpolant, Rate
from nonsmooth.analysis.trajectories.result import TrajectoryError
from nonsmooth.symbolic.numbers.plane_arrays import Floats, are_finite, max_norm

# ---- Taylor series of affine motions -------------------------------------------------------------
#
# Taylor series of affine motions, ``x' = A x + b``: steps of two radians, and nothing but rounding errs.
#
# With ``s = rho (t - t_0)`` and rho a bound on the eigenvalues of A, or one where all are zero, the coefficients of
# ``x = c_0 + c_1 s + c_2 s^2 + ...`` are::
#
#     c_0 = x(t_0),   c_1 = (A x(t_0) + b)/rho,   c_k = A c_(k-1)/(k rho)
#
# A step is as long as the last two of them are rounding beside the states (Jorba and Zou 2005, Exp. Math. 14); it has
# no limit where the motion is a polynomial.


DEGREE = 24
LEFT_OUT = 1e-17  # the last coefficients of a step, relative to the first
LONGEST = 2.0  # step, in units of 1/rho: a state that turns has one extremum at most within it
EASY = 0.5  # the same, from which on more than two states may have several
DRAWN, OF_A_POLYNOMIAL = 0.25, 4  # radians within which a path has a sample, and parts of a polynomial
WORK = 12  # evaluations of a field that cost as much as a step


class SeriesCode(NamedTuple):
    """Functions of single floats, one by one.

    Attributes:
        series: from A and b over rho, row by row, and the states where a step begins: the coefficients of each state,
            and the largest of the first two, of those before the last and of the last.
        value: from s and coefficients.
    """

    series: Callable[..., tuple[tuple[Numbers, ...], float, float, float]]
    value: Callable[..., Any]


@cache
def series_code(count: int) -> SeriesCode:
    """The functions for so many states."""
    states, degrees = range(count), range(DEGREE + 1)
    a, b, c = [names(f"a{i}_", count) for i in states], names("b", count), [names(f"c{k}_", count) for k in degrees]
    lines = []
    for k in degrees[1:]:
        for i in states:
            products = " + ".join(f"{a[i][j]}*{c[k - 1][j]}" for j in states)
            lines.append(f"{c[k][i]} = {products} + {b[i]}" if k == 1 else f"{c[k][i]} = ({products})*{1 / k!r}")
    sizes = [
        ", ".join(f"abs({name})" for k in chosen for name in c[k]) for chosen in ((0, 1), (DEGREE - 1,), (DEGREE,))
    ]
    series = listed(f"({listed(coefficients[i] for coefficients in c)})" for i in states)
    lines.append(f"return ({series}), {', '.join(f'max({size}, 0.0)' for size in sizes)}")
    powers = names("c", DEGREE + 1)
    value = "".join(f"{name} + s*(" for name in powers[:-1]) + powers[-1] + ")" * DEGREE
    begun = "".join(map(listed, (*a, b, c[0])))
    return SeriesCode(compiled(begun, *lines), compiled("s, " + listed(powers), f"return {value}"))


class TaylorSteps:
    """Steps of an affine motion; of other rates see :class:`nonsmooth.analysis.trajectories.steppers.Dop853`.

    Args:
        rate: ``A x + b``.
        t: time.
        y: state (n,).
        until: last time.

    Attributes:
        t, y, slope: where it is, and the rate there.
        step_size: length of the last step.
    """

    step_size: float

    def __init__(self, rate: AffineVelocity, t: float, y: Floats, until: float) -> None:
        self._rate, self._until = rate, until
        self.t, self.y, self.slope = t, y, rate(t, y)
        self._code = series_code(len(y))

    def step(self) -> DenseStep:
        """The next step.

        Raises:
            TrajectoryError: where floats do not hold it.
        """
        start, rho = self.t, self._rate.size
        states, *sizes = self._code.series(*self._rate.scaled, *self.y.tolist())
        end = min(start + _reach(*sizes) / rho, self._until) if rho else self._until
        if not end > start:
            raise TrajectoryError(f"the integrator stopped at t = {start:.6g}: floats do not hold its next step")
        between = PolynomialInterpolant(start, 1 / (rho or 1.0), states, self._code.value)
        last = between(end)
        slope = self._rate(end, last)
        easy = len(self.y) > 2 and (not rho or (end - start) * rho > EASY)
        ends, slopes = ((start, self.y), (end, last)), (self.slope, slope)
        step = DenseStep(*ends, lambda: between, slopes=slopes, parts=self._parts, easy=easy, work=WORK)
        self.step_size, self.t, self.y, self.slope = end - start, end, last, slope
        return step

    def _parts(self, length: float) -> int:
        """Parts of a stretch at whose ends a path has samples."""
        if self._rate.size:
            return max(math.ceil(self._rate.size * length / DRAWN), 1)
        return OF_A_POLYNOMIAL if any(self._rate.scaled[: len(self.y) ** 2]) else 1


def _reach(scale: float, before: float, last: float) -> float:
    """How far series go on, in their own variable, by the sizes of their coefficients."""
    scale, reach = LEFT_OUT * scale, LONGEST
    if last * reach**DEGREE > scale:
        reach = (scale / last) ** (1 / DEGREE)
    if before * reach ** (DEGREE - 1) > scale:
        reach = (scale / before) ** (1 / (DEGREE - 1))
    return reach


# ---- DOP853 for few states -----------------------------------------------------------------------
#
# Each stage of each state is one sum, without the coefficients that are zero.
#
# The two functions for n states are written from SciPy's coefficients, and compiled once.  Of one state x0 with rates
# k0_0, k1_0, ... at the stages the first begins::
#
#     k1_0, = rates(x0 + h * (0.05260015195876773*k0_0), )
#     k2_0, = rates(x0 + h * (0.0197250569845379*k0_0 + 0.0591751709536137*k1_0), )


MOST_STATES = 4  # of which steps are written out: the text grows with them, and what is gained shrinks


class GeneratedFunctions(NamedTuple):
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
def written_out(count: int) -> GeneratedFunctions:
    """Both functions for so many states."""
    from scipy.integrate import DOP853

    end, states = len(DOP853.B), range(count)  # the stage at the end of the step
    x, y = listed(names("x", count)), listed(names("y", count))
    k = [listed(names(f"k{stage}_", count)) for stage in range(end + 1 + len(DOP853.A_EXTRA))]
    stages = "".join(f"({name}), " for name in k[: end + 1])

    trial = [f"{k[stage]}= rates({_moved(DOP853.A[stage], count)})" for stage in range(1, end)]
    trial += [f"{y}= {_moved(DOP853.B, count)}", f"{k[end]}= rates({y})"]
    for s in states:
        trial += [f"scale = atol + rtol * max(abs(y{s}), abs(x{s}))"]
        trial += [f"third{s}, fifth{s} = ({_sum(DOP853.E3, s)}) / scale, ({_sum(DOP853.E5, s)}) / scale"]
    squares = (" + ".join(f"{error}{s} * {error}{s}" for s in states) for error in ("third", "fifth"))
    trial += [f"return ({y}), ({stages}), {', '.join(squares)}"]

    inner = [f"{name}= rates({_moved(row, count)})" for name, row in zip(k[end + 1 :], DOP853.A_EXTRA, strict=True)]
    for s in states:
        inner += [f"a{s} = y{s} - x{s}", f"b{s} = h * k0_{s} - a{s}", f"c{s} = 2 * a{s} - h * (k{end}_{s} + k0_{s})"]
    highest = [listed(f"h * ({_sum(row, s)})" for row in DOP853.D) for s in states]
    inner += [f"return {listed(f'(x{s}, a{s}, b{s}, c{s}, {highest[s]})' for s in states)}"]
    return GeneratedFunctions(
        compiled(f"rates, h, rtol, atol, {x}{k[0]}", *trial),
        compiled(f"rates, h, {x}{''.join(k[: end + 1])}{y}", *inner),
    )


def _moved(weights: Sequence[float], count: int) -> str:
    """The states after a step along weighted rates."""
    return listed(f"x{s} + h * ({_sum(weights, s)})" for s in range(count))


def _sum(weights: Sequence[float], state: int) -> str:
    """The weighted sum of the rates of a state at the stages."""
    return weighted((weight, [f"k{stage}_{state}"]) for stage, weight in enumerate(weights))


# ---- steppers ------------------------------------------------------------------------------------


STAGES = 12  # of DOP853, without the rate at the end of the step
# Of DOP853's steps: a part of what the error allows, within these bounds.
SAFETY, LEAST_GROWTH, MOST_GROWTH = 0.9, 0.2, 10.0
# Growth of the step that DOP853 proposes: its error was some (0.9/4)^8 of the tolerance, a millionth.
EASY_GROWTH = 4.0
IMPLICIT_STEP = 120  # evaluations of all fields that cost as much as an implicit step
PROBED = 50  # steps from one measurement to the next: four evaluations each, against 12 per step of DOP853
# Step times rate: what is stable is 6, but two may cost steps that the fast motion spoils; at 1e-12 accuracy alone
# keeps it well below.
HELD = 1.5
MANY = 500  # steps still to go at the present size: fewer are cheaper than an implicit method
DIFFERENCE = 1e-8  # step of the differences, relative to the states: half the digits, plenty for a rate
# Step of the differences for Radau, relative to the size of the states, however small a state is: SciPy's own shrinks
# with each state, and finds but rounding once one of them is zero and others are not.
JACOBIAN_STEP = 1e-11

Start: TypeAlias = tuple[float, Floats, Floats]  # of a step: the time, the state and the rate there
# A step that may be too long: the state at its end, the rate there, the error of the state in tolerances, and what
# makes its dense output.
Trial: TypeAlias = tuple[Floats, Floats, float, Callable[[], Interpolant]]


def stepped(solver: Any, *, easy: bool = False) -> DenseStep:
    """The next step of one of SciPy's solvers, whose dense output costs no evaluations.

    Raises:
        TrajectoryError: where the solver gives up.
    """
    before, evaluations = (solver.t, solver.y), solver.nfev
    message = solver.step()
    if solver.status == "failed":
        raise TrajectoryError(f"the integrator stopped at t = {solver.t:.6g}: {message}")
    work, between = solver.nfev - evaluations, solver.dense_output()
    return DenseStep(before, (float(solver.t), solver.y), lambda: between, easy=easy, work=work)


class Integrator:
    """One of SciPy's methods for ordinary differential equations.

    Args:
        method: its name in :mod:`scipy.integrate`.
        rtol, atol: tolerances per step, relative and absolute.
        exact_slopes: whether an implicit method takes the ``jacobian`` of a rate that has one; else differences.
    """

    def __init__(self, method: str, rtol: float, atol: float | Floats, *, exact_slopes: bool = True) -> None:
        self._method, self._tolerances, self._exact_slopes = method, {"rtol": rtol, "atol": atol}, exact_slopes

    def steps(self, rate: Any, t: float, x: Floats, until: float) -> Iterator[DenseStep]:
        """Steps up to the last time."""
        from scipy import integrate

        jacobian = getattr(rate, "jacobian", None) if self._exact_slopes else None
        options = {} if jacobian is None else {"jac": jacobian}
        solver = getattr(integrate, self._method)(rate, t, x, until, **self._tolerances, **options)
        begun = solver.nfev
        while solver.status == "running":
            step = stepped(solver)
            step.work, begun = step.work + begun, 0
            yield step


class FixedSteps:
    """The classical Runge-Kutta method of fourth order, with steps of one size, and straight lines between."""

    def __init__(self, size: float) -> None:
        self._size = size

    def steps(self, rate: Rate, t: float, x: Floats, until: float) -> Iterator[DenseStep]:
        """Steps up to the last time; the last one is shorter."""
        while t < until:
            h = min(self._size, until - t)
            k1 = rate(t, x)
            k2 = rate(t + h / 2, x + h / 2 * k1)
            k3 = rate(t + h / 2, x + h / 2 * k2)
            k4 = rate(t + h, x + h * k3)
            mean = (k1 + 2 * k2 + 2 * k3 + k4) / 6
            yield DenseStep((t, x), (t + h, x + h * mean), partial(_straight, t, x, mean))
            t, x = t + h, x + h * mean


def _straight(start: float, x: Floats, rate: Floats) -> Interpolant:
    return lambda t: (x + np.multiply.outer(t - start, rate)).T


class Dop853:
    """The Runge-Kutta method of order 8 by Dormand and Prince (Hairer, Norsett & Wanner 1993, sec. II.10).

    Coefficients and control of steps are SciPy's.  Its own solver takes as long again for what surrounds the stages,
    and forgets these with the next step, so that dense output would have to be made whether it is asked for or not.

    Args:
        rate: ``x' = rate(t, x)``.
        t: time.
        y: state (n,).
        until: last time.
        first_step: length of the first step; None to choose it.
        rtol, atol: tolerances per step.

    Attributes:
        t, y, slope: where it is, and the rate there.
        step_size, following: lengths of the last step and of the next.
    """

    step_size: float

    def __init__(
        self, rate: Rate, t: float, y: Floats, until: float, first_step: float | None, rtol: float, atol: float | Floats
    ) -> None:
        from scipy.integrate import DOP853

        self._method, self._rate, self._until, self._tolerances = DOP853, rate, until, (rtol, atol)
        self.t, self.y = t, y
        if first_step is None:
            chosen = DOP853(rate, t, y, until, rtol=rtol, atol=atol)
            self.slope, first_step = chosen.f, float(chosen.h_abs)
        else:
            self.slope = rate(t, y)
        self.following = first_step

    def step(self) -> DenseStep:
        """The next step that meets the tolerances.

        Raises:
            TrajectoryError: where that is shorter than ten units in the last place of the time.
        """
        start = self.t, self.y, self.slope
        shortest = 10 * (math.nextafter(self.t, math.inf) - self.t)
        length, most, trials = max(self.following, shortest), MOST_GROWTH, 0
        while True:
            if not length >= shortest:
                raise TrajectoryError(f"the integrator stopped at t = {self.t:.6g}: {self._method.TOO_SMALL_STEP}")
            end, trials = min(self.t + length, self._until), trials + 1
            h = end - self.t
            last, slope, error, between = self._trial(start, end)
            growth = SAFETY * error**-0.125 if error else MOST_GROWTH
            if error < 1:
                break
            length, most = h * max(LEAST_GROWTH, growth), 1.0
        step = DenseStep((self.t, self.y), (end, last), between, slopes=(self.slope, slope))
        step.again = partial(self._as_far_as, start)
        self.step_size, self.following = h, h * min(most, growth)
        step.easy, step.work = self.following >= EASY_GROWTH * h, STAGES * trials
        self.t, self.y, self.slope = end, last, slope
        return step

    def _as_far_as(self, start: Start, end: float) -> DenseStep:
        """A step that was taken, once more, to a time within it."""
        last, slope, _, between = self._trial(start, end)
        return DenseStep(start[:2], (end, last), between, slopes=(start[2], slope), work=STAGES)

    def _trial(self, start: Start, end: float) -> Trial:
        """What a step to a time comes to."""
        method, (rtol, atol), (stages, tableau) = self._method, self._tolerances, self._prepared
        (t, y, stages[0]), h = start, end - start[0]
        for k, before, row, share in tableau:
            stages[k] = self._rate(t + share * h, y + before.dot(row) * h)
        last = y + h * stages[:STAGES].T.dot(method.B)
        stages[STAGES] = self._rate(end, last)
        scale = atol + np.maximum(np.abs(y), np.abs(last)) * rtol
        third, fifth = (stages.T.dot(weights) / scale for weights in (method.E3, method.E5))
        of_third, of_fifth = (math.sqrt(error.dot(error)) ** 2 for error in (third, fifth))
        kept = stages.copy()
        between = partial(_dop853_between, self._rate, t, y, h, last, kept)
        return last, kept[STAGES], _error(h, of_third, of_fifth, len(y)), between

    @cached_property
    def _prepared(self) -> tuple[Floats, list[tuple[int, Floats, Floats, float]]]:
        """Room for the rates at all stages; and each stage's number, the rates before, and what it takes of them and
        of the step.
        """
        stages, method = np.empty((STAGES + 1, len(self.y))), self._method
        rows = ((k, stages[:k].T, method.A[k, :k], float(method.C[k])) for k in range(1, STAGES))
        return stages, list(rows)


class ScalarDop853(Dop853):
    """The same method for a rate of few states in single floats, in code that is written out for so many.

    Its sums are rounded in another order, which is all that differs.
    """

    def __init__(self, rate: ScalarVelocity, t: float, y: Floats, *others: Any, **named: Any) -> None:
        super().__init__(rate, t, y, *others, **named)
        self._rates, self._code = rate.rates, written_out(len(y))

    def _trial(self, start: Start, end: float) -> Trial:
        t, x, h = start[0], start[1].tolist(), end - start[0]
        last, stages, third, fifth = self._code.trial(self._rates, h, *self._tolerances, *x, *start[2].tolist())
        between = partial(self._between, t, h, x, stages, last)
        return np.array(last), np.array(stages[STAGES]), _error(h, third, fifth, len(x)), between

    def _between(self, t: float, h: float, x: Sequence[float], stages: Sequence[Numbers], last: Numbers) -> Interpolant:
        states = self._code.inner(self._rates, h, *x, *chain.from_iterable(stages), *last)
        return PolynomialInterpolant(t, h, states, _value)


def _value(s: Any, *coefficients: float) -> Any:
    """The polynomial of a step where a share s of it is passed, in the order of SciPy's."""
    x, a, b, c, d, e, f, g = coefficients
    r = 1 - s
    return x + s * (a + r * (b + s * (c + r * (d + s * (e + r * (f + s * g))))))


def _error(h: float, of_third: float, of_fifth: float, count: int) -> float:
    """The error of a step in tolerances, by the squares of both estimates over h, summed over so many states."""
    denominator = of_fifth + 0.01 * of_third
    return h * of_fifth / math.sqrt(denominator * count) if denominator else 0.0


def _dop853_between(rate: Rate, t: float, y: Floats, h: float, last: Floats, known: Floats) -> Interpolant:
    """The polynomial of degree 7 through a step, which takes three more rates (the same, sec. II.6)."""
    from scipy.integrate import DOP853

    stages = [*known]
    for row, share in zip(DOP853.A_EXTRA, DOP853.C_EXTRA, strict=True):
        stages.append(rate(t + share * h, y + np.array(stages).T.dot(row[: len(stages)]) * h))
    change, first, final = last - y, known[0], known[STAGES]
    parts = [change, h * first - change, 2 * change - h * (final + first), *(h * DOP853.D.dot(np.array(stages)))]

    def at(times: Any) -> Floats:
        share = (times - t) / h
        share = share[:, None] if np.ndim(share) else share
        found: Any = 0.0
        for part, factor in zip(reversed(parts), cycle((share, 1 - share)), strict=False):
            found = (found + part) * factor
        return (found + y).T

    return at


class StiffAware:
    """DOP853, until a stretch turns out stiff; Radau from there on, and rest where nothing moves any more.

    Args:
        rtol, atol: tolerances per step, relative and absolute.
        size: the unit of the states.

    Attributes:
        was_stiff: whether any stretch so far was.
    """

    def __init__(self, rtol: float, atol: float, size: float) -> None:
        self._tolerances, self._size = {"rtol": rtol, "atol": atol}, size
        self._step: float | None = None  # of the last stretch, to begin the next one with
        self.was_stiff = False

    def steps(self, rate: Any, t: float, x: Floats, until: float) -> Iterator[DenseStep]:
        """Steps up to the last time."""
        solver, taken = self._explicit(rate, t, x, until), 1
        while solver.t < until and (taken % PROBED or not holds_the_step(rate, solver, until, self._size)):
            step = solver.step()
            self._step = step.end - step.start
            yield step
            taken += 1
        if solver.t < until:
            self.was_stiff = True
            yield from self._implicit_steps(rate, solver, until)

    def _explicit(self, rate: Any, t: float, x: Floats, until: float) -> Dop853 | TaylorSteps:
        """The explicit method that a rate allows."""
        few = len(x) <= MOST_STATES
        if few and isinstance(rate, AffineVelocity):
            return TaylorSteps(rate, t, x, until)
        first = None if self._step is None else min(self._step, until - t)
        method = ScalarDop853 if few and isinstance(rate, ScalarVelocity) else Dop853
        return method(rate, t, x, until, first, **self._tolerances)

    def _implicit_steps(self, rate: Rate, explicit: Dop853 | TaylorSteps, until: float) -> Iterator[DenseStep]:
        """Radau, from where an explicit solver is."""
        from scipy.integrate import Radau

        jacobian, atol = jacobian_of(rate, self._size), self._tolerances["atol"]
        first = explicit.step_size
        solver = Radau(rate, explicit.t, explicit.y, until, jac=jacobian, first_step=first, **self._tolerances)
        while solver.status == "running":
            slope = solver.f
            step = stepped(solver, easy=True)
            self._step, step.work, step.slopes = step.end - step.start, IMPLICIT_STEP, (slope, solver.f)
            yield step
            if solver.status == "running" and comes_to_rest(rate, solver, until, self._size, atol):
                yield _resting(step, until)
                return


def _resting(step: DenseStep, until: float) -> DenseStep:
    """A step in which the last state stays."""
    last = step.last

    def still(t: Any) -> Floats:
        return last if np.ndim(t) == 0 else np.repeat(last[:, None], len(t), axis=1)

    return DenseStep((step.end, last), (until, last), lambda: still)


# ---- stiffness -----------------------------------------------------------------------------------


def holds_the_step(rate: Rate, solver: Any, until: float, size: float) -> bool:
    """Whether stability, not accuracy, rules the step of an explicit solver, with many steps to go."""
    step = float(solver.step_size)
    if until - solver.t <= MANY * step:
        return False
    return decay_rate(rate, float(solver.t), solver.y, size) * step >= HELD


def decay_rate(rate: Rate, t: float, x: Floats, size: float) -> float:
    """``-min Re eig(df/dx)``, 1/time; ``size`` is the unit of the states.

    Zero where nothing decays or the field is not finite beside the state.
    """
    return max(0.0, -float(_eigenvalues(rate, t, x, DIFFERENCE * np.maximum(np.abs(x), DIFFERENCE * size)).min()))


def comes_to_rest(rate: Rate, solver: Any, until: float, size: float, atol: float) -> bool:
    """Whether what is left moves the state by less than the tolerance, and nothing beside it grows until the end.

    Below the tolerance the field is rounding, on which an implicit method would take tiny steps for ever.
    """
    left = until - float(solver.t)
    if max_norm(rate(float(solver.t), solver.y)) * left > atol:
        return False
    growth = _eigenvalues(rate, float(solver.t), solver.y, np.full(len(solver.y), DIFFERENCE * size))
    return float(growth.max()) * left <= 1


def jacobian_of(rate: Rate, size: float) -> Callable[[float, Floats], Floats]:
    """``df/dx`` for an implicit solver, as a function of time and state."""

    def jacobian(t: float, x: Floats) -> Floats:
        return _differences(rate, t, x, JACOBIAN_STEP * np.maximum(np.abs(x), size))

    return jacobian


def _eigenvalues(rate: Rate, t: float, x: Floats, steps: Floats) -> Floats:
    """Real parts of the eigenvalues of ``df/dx`` by forward differences; zeros where the field is not finite."""
    jacobian = _differences(rate, t, x, steps)
    if not are_finite(jacobian):
        return np.zeros(len(x))
    return np.asarray(np.linalg.eigvals(jacobian).real)


def _differences(rate: Rate, t: float, x: Floats, steps: Floats) -> Floats:
    """``df/dx`` by forward differences, or as the rate itself knows it."""
    if isinstance(rate, DifferentiatedVelocity):
        return rate.derivatives(x, steps)
    return differences(partial(rate, t), x, steps)
