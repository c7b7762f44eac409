"""Whether what a check says holds for every array within the tolerances of its scene, and for how much larger ones."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

from flint import fmpq

from nonsmooth.proofs.robust.nearest import UltimateBound, inner_radius, is_bounded, ultimate_bound, why_not_nearest
from nonsmooth.proofs.robust.ultimate_bound import root_above
from nonsmooth.proofs.verdicts import Certainty
from nonsmooth.symbolic.numbers.enclosures import rational_below
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.tolerances import Tolerance

DOUBLINGS = 10  # of the factor: a thousand times the tolerances is as good as all
HALVINGS = 6  # of the interval in which the largest factor lies
LARGEST_SHARE = Fraction(99, 100)
LARGEST_TURN = Fraction(49, 100)  # of pi


@dataclass(frozen=True)
class Robust:
    """What holds for every array within the tolerances.

    Attributes:
        verdict: whether a bound is proved.
        reason: why not, else empty.
        radius: of the disc about the point in which every body ends (length).
        start: radius of the disc of starts (length).
        within: time after which every body is in the disc and stays there (time).
        turning: bound of the rotation on the way, in radian; None where it is not bounded.
        factor: a multiple of the tolerances for which a bound is proved too, nearly the largest one.
        binding: the tolerance without which that multiple would grow most.
    """

    verdict: Certainty
    reason: str = ""
    radius: Fraction | None = None
    start: Fraction | None = None
    within: Fraction | None = None
    turning: Fraction | None = None
    factor: Fraction | None = None
    binding: str | None = None


def decide_robust(scene: Scene) -> Robust | None:
    """Decide for every array within the scene's tolerances; None for a scene without."""
    if scene.tolerances is None:
        return None
    reason = _why_not(scene)
    if reason:
        return Robust(Certainty.UNDECIDED, reason)
    centred = scene.recentred()
    bound = ultimate_bound(centred, scene.tolerances)
    largest = largest_factor(lambda box: is_bounded(centred, box), scene.tolerances)
    binding = _binding(centred, scene.tolerances, largest)
    if bound is None:
        reason = "no distance below the half-width of the square is found to which every body comes"
        return Robust(Certainty.UNDECIDED, reason, factor=largest, binding=binding)
    return _certified(centred, scene.tolerances, bound, largest, binding)


def _why_not(scene: Scene) -> str:
    if scene.contact.rule != "nearest":
        return f"tolerances are followed under rule nearest, not under {scene.contact.rule}"
    if scene.body is not None:
        return "within the tolerances other wheels may come under the outline of the body"
    return why_not_nearest(scene)


def _certified(scene: Scene, box: Tolerance, bound: UltimateBound, factor: Fraction, binding: str | None) -> Robust:
    """The statement about the body's nominal centre of mass, which may be beside the true one."""
    radius, kappa = root_above(_fraction(bound.squared)), _fraction(bound.kappa)
    start = _fraction(inner_radius(scene))
    beside = root_above(2 * (-rational_below(-box.centre_of_mass.ball())) ** 2)
    within = (start - radius) / kappa
    if start <= radius + 2 * beside:
        reason = "the centre of mass is not known well enough"
        return Robust(Certainty.UNDECIDED, reason, factor=factor, binding="centre_of_mass")
    turning = None if bound.turning is None else _fraction(bound.turning) * within
    return Robust(Certainty.CERTIFIED, "", radius + beside, start - beside, within, turning, factor, binding)


def _fraction(value: fmpq) -> Fraction:
    return Fraction(int(value.p), int(value.q))


def largest_factor(holds: Callable[[Tolerance], bool], box: Tolerance) -> Fraction:
    """Nearly the largest multiple of a box for which a statement is proved; 0 where none is.

    A statement about a box holds for every box inside it, so that any multiple found serves all smaller ones.
    """
    most = _largest_multiple(box)

    def proved(factor: Fraction) -> bool:
        return factor <= most and holds(box.times(factor))

    low, high = Fraction(0), Fraction(1)
    for _ in range(DOUBLINGS):
        if proved(high):
            low, high = high, 2 * high
        elif not low and high > Fraction(1, 2**DOUBLINGS):
            high /= 2
        else:
            break
    for _ in range(HALVINGS if low else 0):
        middle = (low + high) / 2
        low, high = (middle, high) if proved(middle) else (low, middle)
    return low


def _largest_multiple(box: Tolerance) -> Fraction:
    """Up to which shares stay below one and rims have a direction."""
    bounds = [Fraction(2**DOUBLINGS)]
    if box.heading:
        bounds.append(LARGEST_TURN / box.heading)
    for share in (box.speed, box.mu_roll, box.mu_side):
        if share:
            bounds.append(LARGEST_SHARE / -rational_below(-share.ball()))
    return min(bounds)


def _binding(scene: Scene, box: Tolerance, factor: Fraction) -> str | None:
    """The entry without which the factor grows most; None where none matters."""
    grown: dict[str, Fraction] = {}
    for name in box.names:
        others = box.without(name)
        grown[name] = largest_factor(lambda box: is_bounded(scene, box), others)
    if not grown or max(grown.values()) <= factor:
        return None
    return max(grown, key=lambda name: grown[name])
