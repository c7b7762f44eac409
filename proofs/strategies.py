"""The registry of strategies that decide the stability of a plain system's checked point, in the order of their trial.

A strategy asks one theorem.  It is a function from the checked point and what is known to a finding, and a line of
:data:`STRATEGIES`, which says for how many states it speaks.  What it finds it has confirmed exactly, or in balls.  The
last finding decides, as a strategy is asked only for more than is known; a V that does not increase decides only where
there is no other.
"""

from __future__ import annotations

from nonsmooth.proofs.many_states import decision as space
from nonsmooth.proofs.systems import scalar_stability as line
from nonsmooth.proofs.systems import system_stability as plane
from nonsmooth.proofs.systems.findings import Strategy

ONE, TWO, MORE = range(1, 2), range(2, 3), range(3, 9)  # states

STRATEGIES = [
    Strategy("signs on either side", ONE, line.show_by_signs),
    Strategy("no equilibrium", TWO, plane.show_departure),
    Strategy("no equilibrium", MORE, space.show_departure),
    Strategy("uncovered axes of roots", TWO, plane.leave_uncovered),
    Strategy("solution that leaves", MORE, space.show_escape),
    Strategy("relative degree of a relay", MORE, space.show_relay),
    Strategy("linearization", MORE, space.show_linearization),
    Strategy("stated V", TWO, plane.show_by_given),
    Strategy("stated V", MORE, space.show_by_given),
    Strategy("invariance principle, beside curves", TWO, plane.show_stated_attraction),
    Strategy("fan of cones", TWO, plane.show_by_fan),
    Strategy("leading terms", TWO, plane.show_by_leading_terms),
    Strategy("ray of escape", TWO, plane.show_ray),
    Strategy("searched V", TWO, plane.search_function),
    Strategy("searched V", MORE, space.search_function),
    Strategy("sum of squares of the states", MORE, space.show_by_default),
    Strategy("function that shows instability", MORE, space.search_growth),
    Strategy("invariance principle", TWO, plane.search_attraction),
    Strategy("invariance principle", MORE, space.show_attraction),
]
