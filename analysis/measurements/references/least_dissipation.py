"""The least dissipation at 100 digits: a smoothed functional, Newton's method, and smoothing that goes to nothing.

Every norm ``|w|`` in D becomes ``sqrt(|w|^2 + delta^2)``; for delta > 0 the sum is smooth and strictly convex, and
damped Newton steps find its minimum.  Delta falls from the size of D by a factor of four at a time, each minimum
starting the next, until it is ``10**-SMOOTHED`` of D; the least value is then off by at most n times that.  Slow and
independent of all minimizers: it knows no linear program, no cone and no face.  Its data are the floats as they are.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from flint import arb, arb_mat, ctx

from nonsmooth.analysis.fields.contact_model import ContactRows, Floats
from nonsmooth.analysis.minimizers.dissipation import Functional

BITS = 420  # 126 digits: the Hessian's condition grows like 1/delta
SMOOTHED = 30  # decimal digits of D that smoothing leaves alone
FALL = 4  # factor from one delta to the next
NEWTON = 60  # steps per delta; five are usual
HALVINGS = 200  # of a step: where minimizers are many the first ones are long
DECREMENT = 1e-60  # squared Newton decrement, relative to D_delta: beside a kink a larger one says little

Group = tuple[Any, list[Any], Any]  # weight, row, target


class LeastDissipation:
    """The minimization of D for one vector of loads, at 100 digits.

    Args:
        functional: box or ellipse.
        model: the contact rows.
        loads: normal forces, shape (n,).
    """

    def __init__(self, functional: Functional, model: ContactRows, loads: Floats) -> None:
        self.functional = functional
        self._length = float(np.abs(model.rows[:, 2]).max()) or 1.0
        weights = model.limits(loads).reshape(-1)
        self._rows: list[Group] = [
            (arb(float(w)), [arb(float(a)), arb(float(b)), arb(float(m)) / self._length], arb(float(t)))
            for w, (a, b, m), t in zip(weights, model.rows, model.targets, strict=True)
        ]
        size = 1 if functional is Functional.BOX else 2
        self._groups = [self._rows[k : k + size] for k in range(0, len(self._rows), size)]

    def at(self, twist: Floats) -> Any:
        """``D`` at a twist of floats."""
        before, ctx.prec = ctx.prec, BITS
        try:
            vx, vy, omega = (arb(float(x)) for x in twist)
            return self._value([vx, vy, omega * self._length], arb(0))
        finally:
            ctx.prec = before

    def least(self) -> Any:
        """The least ``D``."""
        before, ctx.prec = ctx.prec, BITS
        try:
            x = [arb(0)] * 3
            scale = self._value(x, arb(0))
            if not float(scale.mid()):
                return scale
            delta = scale / len(self._groups)
            while float((delta / scale).mid()) > 10.0**-SMOOTHED:
                x = self._newton(x, delta)
                delta = (delta / FALL).mid()
            return self._value(x, arb(0))
        finally:
            ctx.prec = before

    def _slips(self, group: list[Group], x: list[Any]) -> list[Any]:
        return [w * (a[0] * x[0] + a[1] * x[1] + a[2] * x[2] - b) for w, a, b in group]

    def _value(self, x: list[Any], delta: Any) -> Any:
        """``D_delta``, without its ball."""
        total = arb(0)
        for group in self._groups:
            total += sum((s * s for s in self._slips(group, x)), delta * delta).mid().sqrt()
        return total.mid()

    def _derivatives(self, x: list[Any], delta: Any) -> tuple[list[Any], list[list[Any]]]:
        """Gradient and Hessian of ``D_delta``."""
        gradient, hessian = [arb(0)] * 3, [[arb(0)] * 3 for _ in range(3)]
        for group in self._groups:
            slips = self._slips(group, x)
            length = sum((s * s for s in slips), delta * delta).mid().sqrt()
            rows = [[w * entry for entry in a] for w, a, _ in group]
            pull = [sum((s * row[k] for s, row in zip(slips, rows, strict=True)), arb(0)) / length for k in range(3)]
            for k in range(3):
                gradient[k] = (gradient[k] + pull[k]).mid()
                for j in range(3):
                    product = sum((row[k] * row[j] for row in rows), arb(0))
                    hessian[k][j] = (hessian[k][j] + (product - pull[k] * pull[j]) / length).mid()
        return gradient, hessian

    def _newton(self, x: list[Any], delta: Any) -> list[Any]:
        """Damped Newton steps to the minimum of ``D_delta``."""
        value = self._value(x, delta)
        for _ in range(NEWTON):
            gradient, hessian = self._derivatives(x, delta)
            solved = arb_mat(hessian).solve(arb_mat([[-g] for g in gradient]))
            step = [solved[k, 0].mid() for k in range(3)]
            decrement = -float(sum((g * s for g, s in zip(gradient, step, strict=True)), arb(0)).mid() / value)
            if decrement <= DECREMENT:
                break
            share = arb(1)
            for _ in range(HALVINGS):
                tried = [(a + share * s).mid() for a, s in zip(x, step, strict=True)]
                following = self._value(tried, delta)
                if following < value:
                    break
                share = share / 2
            else:
                break  # nothing falls any more
            x, value = tried, following
        return x
