"""An a-priori lemma: inward rims on one circle never move the centre of mass away from its middle.

Let all wheels lie on a circle of radius R about the equilibrium, rims radial and inward, ``u_i > 0``, one mu_R, and
let the loads balance moments, ``sum N_i p_i = W c``.  Rules ``box`` and ``ellipse`` minimize D, so
``D(xi*) <= D(0)``; D is convex, hence along the rims the minimizer does not fall behind rest::

    mu_R sum_i N_i (|d_i . v(p_i) - u_i| - |u_i|) <= D(xi*) - D(0) <= 0   implies   sum_i N_i d_i . v(p_i) >= 0.

With ``d_i = -p_i/R`` and ``p_i . J p_i = 0`` the last sum is ``-(W/R) c . v``: so ``V* = 2 c . v <= 0`` for every mu_S,
every number of wheels and every such load model, wherever the body does not tip.  No cell and no solver is needed.
"""

from __future__ import annotations

from typing import NamedTuple

from nonsmooth.analysis.cells.contact_rule import LimitedForces, rule_of
from nonsmooth.symbolic.mechanics.scene import LoadTable, Scene
from nonsmooth.symbolic.numbers.plane import cross, dot


class CocircularArray(NamedTuple):
    """A centred array that meets the lemma's hypotheses.

    Attributes:
        scene: the array, centred at its equilibrium.
    """

    scene: Scene


def cocircular_array(scene: Scene) -> CocircularArray | None:
    """The lemma's certificate for a centred array, or None where a hypothesis fails."""
    if failed_hypotheses(scene):
        return None
    return CocircularArray(scene)


def failed_hypotheses(scene: Scene) -> list[str]:
    """The hypotheses of the lemma that a centred array does not meet, in words."""
    wheels, failed = scene.wheels, list[str]()
    squares = {dot(w.position, w.position) for w in wheels}
    if not isinstance(rule_of(scene), LimitedForces):
        failed.append(f"rule {scene.contact.rule} does not minimize D")
    if len(squares) > 1 or not all(squares):
        failed.append("the wheels do not lie on one circle about the equilibrium")
    if any(cross(w.direction, w.position) or dot(w.direction, w.position).sign() >= 0 for w in wheels):
        failed.append("not every rim points inward")
    if any(w.axis is not None for w in wheels):
        failed.append("not every friction axis is the rim")
    if any(w.given_speed is not None and w.given_speed.sign() <= 0 for w in wheels):
        failed.append("not every speed is positive")
    if len({w.friction.roll for w in wheels}) > 1 or not wheels[0].friction.roll:
        failed.append("mu_roll is not one positive number")
    if not _loads_balance(scene):
        failed.append("the load table does not balance moments")
    return failed


def _loads_balance(scene: Scene) -> bool:
    """``sum N_i p_i = (sum N_i) c`` identically; elastic loads and all admissible ones do by construction."""
    table = scene.contact.loads
    if not isinstance(table, LoadTable):
        return True
    zero = scene.field.zero
    totals = [sum((row[k] for row in table.rows), zero) for k in range(3)]
    for axis in range(2):
        moment = [
            sum((row[k] * w.position[axis] for row, w in zip(table.rows, scene.wheels, strict=True)), zero)
            for k in range(3)
        ]
        expected = [zero, zero, zero]
        expected[1 + axis] = totals[0]
        if totals[1] or totals[2] or moment != expected:
            return False
    return True
