"""Whether what a check says holds for every array within the tolerances of its scene, and for how much larger ones.

For each contact rule a class on :class:`BoxProof` says what is proved; to follow another rule, write one and list it.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import Any

from nonsmooth.proofs.findings import Certainty
from nonsmooth.proofs.robust.box import BoxRingProof
from nonsmooth.proofs.robust.nearest import inner_radius, is_bounded, ultimate_bound, why_not_nearest
from nonsmooth.proofs.robust.plane_minimum import MAX_WHEELS
from nonsmooth.proofs.robust.rings import RingProof, root_above
from nonsmooth.proofs.robust.smooth_rules import SmoothDisc, equilibrium_box
from nonsmooth.symbolic.mechanics.contact_set import contact_set
from nonsmooth.symbolic.mechanics.rule import MIXED
from nonsmooth.symbolic.mechanics.scene import Scene, Tolerance
from nonsmooth.symbolic.messages.under_way import part_of, tell
from nonsmooth.symbolic.numbers.coefficients import as_fraction
from nonsmooth.symbolic.numbers.enclosures import rational_above
from nonsmooth.symbolic.numbers.number_text import float_text

MAX_SMOOTH = 16  # wheels: with more, rings under rules ellipse and roller take minutes
DOUBLINGS = 10  # of the factor: a thousand times the tolerances is as good as all
SMALLEST = Fraction(1, 2 ** (DOUBLINGS - 1))  # factor that is tried
HALVINGS = 6  # of the interval in which the largest factor lies
COARSE = 3  # the same where factors are only compared
LARGEST_SHARE = Fraction(99, 100)
LARGEST_TURN = Fraction(49, 100)  # of pi


@dataclass(frozen=True)
class Robust:
    """What holds for every array within the tolerances.

    Attributes:
        verdict: whether a bound is proved.
        reason: why not, else empty.
        radius: of the disc about the point in which every body ends, or else in which every equilibrium is (length).
        start: radius of the disc of starts (length); None where only starts close by are meant.
        within: time after which every body is in the disc and stays there (time); None where none is known.
        turning: bound of the rotation on the way, in radian; None where it is not bounded.
        equilibrium: radius of a disc in which every array has one equilibrium that attracts (length); None where that
            is not shown.
        drift: bound of the rotation rate at the equilibrium (1/time); None where it is not bounded.
        rests: radius of a disc in which every body stays where it is (length); None where none is looked for.
        factor: a multiple of the tolerances for which a bound is proved too, nearly the largest one.
        binding: the tolerance without which that multiple would grow most.
    """

    verdict: Certainty
    reason: str = ""
    radius: Fraction | None = None
    start: Fraction | None = None
    within: Fraction | None = None
    turning: Fraction | None = None
    equilibrium: Fraction | None = None
    drift: Fraction | None = None
    rests: Fraction | None = None
    factor: Fraction | None = None
    binding: str | None = None


def decide_robust(scene: Scene) -> Robust | None:
    """Decide for every array within the scene's tolerances; None for a scene without."""
    if scene.tolerances is None:
        return None
    proof = _proof(scene)
    if isinstance(proof, str):
        return Robust(Certainty.UNDECIDED, proof)
    statement = proof.all_that_is_shown(scene.tolerances)
    factor = largest_factor(proof.holds, scene.tolerances)
    binding = binding_entry(proof.holds, scene.tolerances, factor)
    return replace(statement or Robust(Certainty.UNDECIDED, proof.no_proof), factor=factor, binding=binding)


def decided_statement(scene: Scene) -> Robust:
    """The same for a scene with tolerances, without the factor and what binds."""
    proof = _proof(scene)
    if isinstance(proof, str) or scene.tolerances is None:
        return Robust(Certainty.UNDECIDED, proof if isinstance(proof, str) else "the scene states no tolerances")
    return proof.statement(scene.tolerances) or Robust(Certainty.UNDECIDED, proof.no_proof)


def certified_factor(scene: Scene) -> Fraction | None:
    """The multiple of the scene's tolerances alone; None without tolerances, and where none is followed."""
    proof = None if scene.tolerances is None else _proof(scene)
    if scene.tolerances is None or proof is None or isinstance(proof, str):
        return None
    return largest_factor(proof.holds, scene.tolerances)


def _proof(scene: Scene) -> BoxProof | str:
    """What proves something about boxes of a scene; or why nothing does."""
    if scene.contact.rule not in PROOFS:
        return f"tolerances are followed under the rules {', '.join(PROOFS)}, not under {scene.contact.rule}"
    proof = PROOFS[scene.contact.rule](scene.recentred())
    return proof.why_not() or proof


# ---- what is proved under each rule ------------------------------------------------------------


class BoxProof(ABC):
    """What is proved about all arrays of a box under one contact rule."""

    no_proof: str

    def __init__(self, scene: Scene) -> None:
        """For a centred scene."""
        self.scene = scene

    @abstractmethod
    def why_not(self) -> str:
        """Why the scene is not followed; empty where it is."""

    @abstractmethod
    def holds(self, box: Tolerance) -> bool:
        """Whether the statement is proved for a box."""

    @abstractmethod
    def statement(self, box: Tolerance) -> Robust | None:
        """The statement with its numbers; None where it is not proved."""

    def all_that_is_shown(self, box: Tolerance) -> Robust | None:
        """The same with what takes longer to show, and is asked for the scene's own tolerances only."""
        return self.statement(box)


class NearestProof(BoxProof):
    """Rule ``nearest``: a disc in which every body ends."""

    no_proof = "no distance below the half-width of the square is found to which every body comes"

    def why_not(self) -> str:
        """Bodies with an outline, and rows that are missing."""
        if self.scene.body is not None:
            return "within the tolerances other wheels may come under the outline of the body"
        return why_not_nearest(self.scene)

    def holds(self, box: Tolerance) -> bool:
        """At some rate."""
        return (not box.centre_of_mass and is_bounded(self.scene, box)) or self.statement(box) is not None

    def statement(self, box: Tolerance) -> Robust | None:
        """The disc, and how far the body turns on its way."""
        bound = ultimate_bound(self.scene, box)
        if bound is None:
            return None
        radius, start = root_above(as_fraction(bound.squared)), as_fraction(inner_radius(self.scene))
        result = _ends(box, radius, start, (start - radius) / as_fraction(bound.kappa))
        if result is None or result.within is None or bound.turning is None:
            return result
        return replace(result, turning=as_fraction(bound.turning) * result.within)


class DiscProof(BoxProof):
    """Rules with loads: a disc in which every body ends, by rings on which every body comes nearer.

    Attributes:
        rings: what shows that bodies come nearer; None where that would take too long.
    """

    rings: RingProof[Any] | None = None

    def why_not(self) -> str:
        """Loads that nobody knows."""
        return "the loads are not known" if self.scene.contact.loads_are_unknown else ""

    def _comes_nearer(self, box: Tolerance) -> bool:
        """Whether bodies come nearer on some ring; where the centre of mass may be beside the point, on wide ones."""
        if box.centre_of_mass or not self._follows(box) or self.rings is None:
            return self._disc(box) is not None
        return self.rings.comes_nearer(box, self._most(box))

    def _disc(self, box: Tolerance) -> Robust | None:
        disc = self.rings.disc(box, self._most(box)) if self.rings is not None and self._follows(box) else None
        return None if disc is None else _ends(box, disc.radius, disc.start, disc.time_to(disc.radius))

    def _follows(self, box: Tolerance) -> bool:
        """Whether a body that turns on its way keeps its wheels, as one without an outline does."""
        return self.scene.body is None and self._most(box) > 0

    def _most(self, box: Tolerance) -> Fraction:
        """Up to where the body stays in the square and on the same wheels."""
        most, margin = as_fraction(inner_radius(self.scene)), contact_set(self.scene).margin
        return most if margin is None else min(most, margin - _displaced(box))


class SmoothProof(DiscProof):
    """Rules with friction sets: one equilibrium of every array nearby, which attracts; else a disc of ends."""

    no_proof = (
        "it is not shown that every array has one equilibrium nearby that attracts, nor that every body comes nearer "
        "on some ring about the point"
    )

    def __init__(self, scene: Scene) -> None:
        """For a centred scene."""
        super().__init__(scene)
        if not self.why_not() and len(scene.wheels) <= MAX_SMOOTH:
            self.rings = SmoothDisc(scene)

    def holds(self, box: Tolerance) -> bool:
        """By equilibria alone where they are shown for the scene, which is quick; else by a ring too."""
        if self._equilibrium(box) is not None:
            return True
        return not self._has_equilibrium and self._comes_nearer(box)

    def statement(self, box: Tolerance) -> Robust | None:
        """The equilibrium, else the disc."""
        return self._equilibrium(box) or self._disc(box)

    def all_that_is_shown(self, box: Tolerance) -> Robust | None:
        """The equilibrium, and the disc from which bodies come near it."""
        equilibrium, disc = self._equilibrium(box), self._disc(box)
        if equilibrium is None or disc is None:
            return equilibrium or disc
        return replace(disc, equilibrium=equilibrium.equilibrium, drift=equilibrium.drift)

    @cached_property
    def _has_equilibrium(self) -> bool:
        return self.scene.tolerances is not None and self._equilibrium(self.scene.tolerances) is not None

    def _equilibrium(self, box: Tolerance) -> Robust | None:
        """While no wheel comes under the body or leaves it."""
        rest = equilibrium_box(self.scene, box)
        if rest is None:
            return None
        radius = root_above(rest.squared) + beside(box)
        margin = contact_set(self.scene).margin
        if margin is not None and radius + _displaced(box) >= margin:
            return None
        return Robust(Certainty.CERTIFIED, radius=radius, equilibrium=radius, drift=rational_above(abs(rest.spin)))


class BoxRuleProof(DiscProof):
    """Rule ``box``: a disc in which every body ends, and one in which every body stays at rest."""

    rings: BoxRingProof | None

    no_proof = "no ring about the point is found on which every body comes nearer"

    def why_not(self) -> str:
        """Loads that nobody knows, large arrays, and motions that no friction resists."""
        if len(self.scene.wheels) > MAX_WHEELS:
            return f"under rule box arrays of up to {MAX_WHEELS} wheels are followed"
        return super().why_not()

    def __init__(self, scene: Scene) -> None:
        """For a centred scene."""
        super().__init__(scene)
        self.rings = None if self.why_not() else BoxRingProof(scene)

    def holds(self, box: Tolerance) -> bool:
        """Whether bodies come nearer on some ring."""
        return self._comes_nearer(box)

    def statement(self, box: Tolerance) -> Robust | None:
        """The disc of ends, and the disc of rest about the nominal centre of mass."""
        most = self._most(box)
        if most <= 0 or self.rings is None:
            return None
        rests = max(self.rings.rest_radius(box, most) - beside(box), Fraction(0))
        no_proof = self.no_proof
        if self.scene.body is not None:
            no_proof = "on its way a body may turn, and other wheels come under it"
        return replace(self._disc(box) or Robust(Certainty.UNDECIDED, no_proof), rests=rests)


PROOFS: dict[str, type[BoxProof]] = {
    "nearest": NearestProof,
    "box": BoxRuleProof,
    "ellipse": SmoothProof,
    "roller": SmoothProof,
    MIXED: SmoothProof,
}


def _ends(box: Tolerance, radius: Fraction, start: Fraction, within: Fraction) -> Robust | None:
    """A disc in which bodies end, about the nominal centre of mass of the body, which may be beside the true one."""
    off = beside(box)
    if start <= radius + 2 * off:
        return None
    return Robust(Certainty.CERTIFIED, "", radius + off, start - off, within)


def beside(box: Tolerance) -> Fraction:
    """How far the true centre of mass may be from the nominal one."""
    return root_above(2 * rational_above(box.centre_of_mass.ball()) ** 2)


def _displaced(box: Tolerance) -> Fraction:
    """How far a wheel may be from its place under the body."""
    return root_above(2 * rational_above((box.position + box.centre_of_mass).ball()) ** 2)


# ---- how much larger the tolerances may be -----------------------------------------------------


def largest_factor(holds: Callable[[Tolerance], bool], box: Tolerance) -> Fraction:
    """Nearly the largest multiple of a box for which a statement is proved; 0 where none is.

    A statement about a box holds for every box inside it, so that any multiple found serves all smaller ones.

    Args:
        holds: whether the statement is proved for a box.
        box: the tolerances.
    """
    most = _largest_multiple(box)

    def proved(factor: Fraction) -> bool:
        tell(f"arrays within {float_text(factor, 3)} times the tolerances")
        return factor <= most and holds(box.times(factor))

    low, high = Fraction(0), Fraction(1)
    for _ in range(DOUBLINGS):
        if proved(high):
            low, high = high, 2 * high
        elif low:
            break
        elif high == 1 and not proved(SMALLEST):
            return Fraction(0)  # nor is any larger one
        else:
            high /= 2
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
            bounds.append(LARGEST_SHARE / rational_above(share.ball()))
    return min(bounds)


def binding_entry(holds: Callable[[Tolerance], bool], box: Tolerance, factor: Fraction) -> str | None:
    """The entry without which the factor grows most; None where none matters.

    Boxes without one entry are compared at one multiple after the other, and only those are followed that may still
    serve for the largest.
    """
    candidates = box.names

    def proved(multiple: Fraction) -> bool:
        """Whether some of those left serve for a multiple; then only these are left."""
        nonlocal candidates
        serving = []
        for k, name in enumerate(candidates):
            with part_of(k, len(candidates), f"tolerances, without that of {name}"):
                other = box.without(name)
                if multiple <= _largest_multiple(other) and holds(other.times(multiple)):
                    serving.append(name)
        candidates = tuple(serving) or candidates
        return bool(serving)

    low = factor
    if not factor:
        if not proved(SMALLEST):
            return None
        low = SMALLEST
    high = 2 * low
    while (low == factor or len(candidates) > 1) and proved(high):
        low, high = high, 2 * high
    for _ in range(COARSE):
        if low > factor and len(candidates) == 1:
            break
        middle = (low + high) / 2
        low, high = (middle, high) if proved(middle) else (low, middle)
    return candidates[0] if low > factor else None
