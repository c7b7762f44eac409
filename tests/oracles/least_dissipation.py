"""The least dissipation at 100 digits: a smoothed functional, Newton's method, and smoothing that goes to nothing.

Every norm ``|w|`` in D becomes ``sqrt(|w|^2 + delta^2)``; for delta > 0 the sum is smooth and strictly convex, and
damped Newton steps find its minimum.  Delta falls from the size of D by a factor of four at a time, each minimum
starting the next, until it is ``10**-SMOOTHED`` of D; the least value is then off by at most n times that.  Slow and
independent of all minimizers: it knows no linear program, no cone and no face.  Its data are the floats as they are.

Each group g of weighted contact rows in ``D(xi) = sum_g |A_g xi - b_g|`` is one wheel (ellipse) or one row (box).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from flint import arb, arb_mat, ctx

from nonsmooth.analysis.fields.contact_model import ContactRows
from nonsmooth.analysis.minimizers.minimum import Functional
from nonsmooth.symbolic.numbers.plane_arrays import Floats

Group: TypeAlias = tuple[arb_mat, arb_mat]  # A (m, 3) and b (m, 1)

BITS = 420  # 126 digits: the Hessian's condition grows like 1/delta
SMOOTHED = 30  # decimal digits of D that smoothing leaves alone
FALL = 4  # factor from one delta to the next
NEWTON = 60  # steps per delta; five are usual
HALVINGS = 200  # of a step: where minimizers are many the first ones are long
DECREMENT = 1e-60  # squared Newton decrement, relative to D_delta: beside a kink a larger one says little


def slip_size(group: Group, twist: arb_mat, delta: arb) -> tuple[arb_mat, arb]:
    """``w = A xi - b`` and its smoothed length."""
    w = group[0] * twist - group[1]
    squared = sum((entry * entry for entry in w.entries()), delta * delta)
    # the ball of a slip that vanishes holds zero, so that of its square may reach below
    return w, squared.nonnegative_part().sqrt()


def value(groups: Sequence[Group], twist: arb_mat, delta: arb) -> arb:
    """``D_delta``."""
    return sum((slip_size(group, twist, delta)[1] for group in groups), arb(0))


def derivatives(groups: Sequence[Group], twist: arb_mat, delta: arb) -> tuple[arb_mat, arb_mat]:
    """Gradient ``sum A^T u`` and Hessian ``sum A^T (1 - u u^T) A/|w|`` with ``u = w/|w|``."""
    gradient, hessian = arb_mat(3, 1), arb_mat(3, 3)
    for group in groups:
        w, size = slip_size(group, twist, delta)
        unit, matrix = w * (1 / size), group[0]
        one = arb_mat([[int(j == k) for k in range(w.nrows())] for j in range(w.nrows())])
        gradient += matrix.transpose() * unit
        hessian += matrix.transpose() * (one - unit * unit.transpose()) * matrix * (1 / size)
    return gradient, hessian


class ReferenceMinimization:
    """The minimization of D for one vector of loads, at 100 digits.

    Args:
        functional: box or ellipse.
        model: the contact rows.
        loads: normal forces, shape (n,).
    """

    def __init__(self, functional: Functional, model: ContactRows, loads: Floats) -> None:
        self._length = arb(float(np.abs(model.rows[:, 2]).max()) or 1.0)
        weights = [arb(float(w)) for w in model.limits(loads).reshape(-1)]
        size = 1 if functional is Functional.BOX else 2
        with ctx.workprec(BITS):
            rows = [
                [w * float(a), w * float(b), w * float(m) / self._length]
                for w, (a, b, m) in zip(weights, model.rows, strict=True)
            ]
            right = [[w * float(target)] for w, target in zip(weights, model.targets, strict=True)]
            starts = range(0, len(rows), size)
            self._groups = [(arb_mat(rows[k : k + size]), arb_mat(right[k : k + size])) for k in starts]

    def at(self, twist: Floats) -> arb:
        """``D`` at a twist of floats."""
        with ctx.workprec(BITS):
            vx, vy, omega = (arb(float(x)) for x in twist)
            return self._value(arb_mat([[vx], [vy], [omega * self._length]]), arb(0))

    def least(self) -> arb:
        """The least ``D``."""
        with ctx.workprec(BITS):
            twist = arb_mat(3, 1)
            scale = self._value(twist, arb(0))
            if not float(scale.mid()):
                return scale
            delta = scale / len(self._groups)
            while float((delta / scale).mid()) > 10.0**-SMOOTHED:
                twist = self._newton(twist, delta)
                delta = (delta / FALL).mid()
            return self._value(twist, arb(0))

    def _value(self, twist: arb_mat, delta: arb) -> arb:
        """``D_delta``, without its ball."""
        return value(self._groups, twist, delta).mid()

    def _newton(self, twist: arb_mat, delta: arb) -> arb_mat:
        """Damped Newton steps to the minimum of ``D_delta``."""
        here = self._value(twist, delta)
        for _ in range(NEWTON):
            gradient, hessian = derivatives(self._groups, twist, delta)
            step = hessian.solve(gradient)
            decrement = (gradient.transpose() * step)[0, 0]
            if float(decrement.mid() / here) <= DECREMENT:
                break
            for halvings in range(HALVINGS):
                tried = arb_mat([[x.mid()] for x in (twist - step * arb(2) ** -halvings).entries()])
                following = self._value(tried, delta)
                if following < here:
                    break
            else:
                break  # nothing falls any more
            twist, here = tried, following
        return twist
