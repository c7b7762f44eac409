"""Why no static feedback stabilizes: every motion that inputs give near the equilibrium keeps to a plane of twists.

Let ``m . xi = 0`` for all of them, m nonzero.  Whatever the feedback, the Filippov set at a pose near the equilibrium
is a part of that plane, turned into pose rates: ``c' = v + omega J c``, ``theta' = omega``.  The planes of poses near
the equilibrium differ little, so all velocities together miss the small multiples of m.  Brockett's condition asks that
they fill a neighbourhood of zero; it is necessary for the asymptotic stability of upper semicontinuous inclusions with
convex values too (Ryan, SIAM J. Control Optim. 32, 1994), hence for discontinuous feedback in the sense of Filippov.
Feedback that depends on time (Coron 1992) or acts on samples (Clarke, Ledyaev, Sontag and Subbotin 1997) is another
matter: a unicycle can be parked.

For ``m = (0, 0, 1)`` the plane is ``omega = 0``: theta is a constant of every motion.
"""

from __future__ import annotations

from collections.abc import Sequence

from nonsmooth.symbolic.mechanics.constraints import Triple, cross_product, independent, leading_one
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.number_text import brief_text


def common_normal(twists: Sequence[Triple], field: NumberField) -> Triple | None:
    """A nonzero vector orthogonal to all twists; None where they span."""
    zero, one = field.zero, field.one
    basis = [twists[k] for k in independent(twists)]
    if len(basis) == 3:
        return None
    span = [*basis, (zero, zero, one), (one, zero, zero), (zero, one, zero)]
    first, second = (span[k] for k in independent(span)[:2])
    return leading_one(cross_product(first, second))


def obstruction_text(normal: Triple) -> str:
    """One sentence for people."""
    if any(normal[:2]):
        entries = ", ".join(brief_text(entry) for entry in normal)
        plane = f"m . xi = 0 with m = ({entries})"
    else:
        plane = "omega = 0"
    return f"no static feedback stabilizes (Brockett's condition): every motion that inputs give near c* obeys {plane}"
