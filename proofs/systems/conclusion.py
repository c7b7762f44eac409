"""What follows from the evidence on a plain system: verdict, reason, and what decided.

The order is that of strength: no equilibrium, a V that falls, LaSalle's principle, the fan, a ray of escape, a V that
grows, leading terms, and last a V that merely does not increase.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum

from nonsmooth.proofs.systems.derivatives import Decrease, LyapunovResult
from nonsmooth.proofs.systems.invariance import Staying
from nonsmooth.proofs.systems.leading_terms import LeadingTerms
from nonsmooth.proofs.systems.ray_moves import ConstantFan, RayKind, RayMove
from nonsmooth.proofs.systems.stability_result import UNDECIDED_BY
from nonsmooth.proofs.verdicts import Equilibrium, Translation


class Method(StrEnum):
    """What decided."""

    EQUILIBRIUM = "no equilibrium"
    LYAPUNOV = "Lyapunov function"
    INVARIANCE = "invariance principle"
    FAN = "fan of cones"
    RAY = "ray of escape"
    GROWTH = "function that grows"
    LEADING = "leading terms"
    NONE = UNDECIDED_BY


UNCOVERED = "not every solution crosses where the root of a state is zero: what is proved of the roots says nothing"


def conclude(
    equilibrium: Equilibrium,
    certificate: LyapunovResult | None,
    growth: LyapunovResult | None,
    fan: ConstantFan | None,
    rays: Sequence[RayMove],
    leading: LeadingTerms | None,
    staying: Staying | None = None,
) -> tuple[Translation, str, Method]:
    """Verdict, reason and what decided, from the evidence."""
    if equilibrium is Equilibrium.FAILS:
        more = f"; {fan.reason}" if fan is not None and fan.verdict is Translation.UNSTABLE else ""
        return Translation.UNSTABLE, f"0 is not in F there, so every solution leaves it{more}", Method.EQUILIBRIUM
    if certificate is not None and certificate.verdict is Decrease.STRICT:
        return Translation.ASYMPTOTICALLY_STABLE, certificate.reason, Method.LYAPUNOV
    if certificate is not None and certificate.verdict is Decrease.WEAK and staying is Staying.NONE:
        return Translation.ASYMPTOTICALLY_STABLE, f"{certificate.reason}, and {staying}", Method.INVARIANCE
    if fan is not None and fan.verdict is not Translation.UNDECIDED:
        return fan.verdict, fan.reason, Method.FAN
    for escape in _of_kind(rays, RayKind.ESCAPE):
        return Translation.UNSTABLE, str(escape), Method.RAY
    if growth is not None and growth.verdict is Decrease.STRICT:
        return Translation.UNSTABLE, "a positive V grows along every solution", Method.GROWTH
    if leading is not None:
        return leading.verdict, leading.reason, Method.LEADING
    return _by_weak_evidence(equilibrium, certificate, rays)


def conclude_uncovered(equilibrium: Equilibrium) -> tuple[Translation, str, Method]:
    """What follows where what is proved of roots of states says nothing about the states."""
    if equilibrium is Equilibrium.FAILS:
        return conclude(equilibrium, None, None, None, (), None)
    return Translation.UNDECIDED, UNCOVERED, Method.NONE


def _by_weak_evidence(
    equilibrium: Equilibrium, certificate: LyapunovResult | None, rays: Sequence[RayMove]
) -> tuple[Translation, str, Method]:
    """What is said where nothing decides whether solutions attract."""
    if certificate is not None:
        rests = _of_kind(rays, RayKind.REST)
        why = f"not asymptotically: {rests[0]}" if rests else "whether the equilibrium attracts is not decided by it"
        return Translation.STABLE, f"{certificate.reason}; {why}", Method.LYAPUNOV
    if equilibrium is Equilibrium.UNDECIDED:
        return Translation.UNDECIDED, "whether 0 is in F there hangs on a cell whose germ is not decided", Method.NONE
    return Translation.UNDECIDED, "no Lyapunov function was found, and no solution that leaves", Method.NONE


def _of_kind(rays: Sequence[RayMove], kind: RayKind) -> list[RayMove]:
    return [ray for ray in rays if ray.kind is kind]
