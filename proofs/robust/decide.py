"""Whether what a check says holds for every array within the tolerances of its scene, and for how much larger ones.

For each contact rule a class on :class:`BoxProof` says what is proved; to follow another rule, write one and list it.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import replace
from fractions import Fraction
from functools import cached_property
from typing import Any

from flint import fmpq

from nonsmooth.proofs.robust.box import BoxRingProof
from nonsmooth.proofs.robust.box_corners import MAX_WHEELS
from nonsmooth.proofs.robust.factor import binding_entry, largest_factor
from nonsmooth.proofs.robust.nearest import inner_radius, is_bounded, ultimate_bound, why_not_nearest
from nonsmooth.proofs.robust.rings import RingProof
from nonsmooth.proofs.robust.robust import Robust, above, beside
from nonsmooth.proofs.robust.smooth_disc import SmoothDisc
from nonsmooth.proofs.robust.smooth_rules import equilibrium_box
from nonsmooth.proofs.robust.ultimate_bound import root_above
from nonsmooth.proofs.verdicts import Certainty
from nonsmooth.symbolic.contact_set import contact_set
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.tolerances import Tolerance
from nonsmooth.symbolic.unknown_loads import UnknownLoads

MAX_SMOOTH = 16  # wheels: with more, rings under rules ellipse and roller take minutes


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
        """About the nominal centre of mass of the body, which may be beside the true one."""
        bound = ultimate_bound(self.scene, box)
        if bound is None:
            return None
        radius, start, off = root_above(_fraction(bound.squared)), _fraction(inner_radius(self.scene)), beside(box)
        if start <= radius + 2 * off:
            return None
        within = (start - radius) / _fraction(bound.kappa)
        turning = None if bound.turning is None else _fraction(bound.turning) * within
        return Robust(Certainty.CERTIFIED, "", radius + off, start - off, within, turning)


class DiscProof(BoxProof):
    """Rules without cells: a disc in which every body ends, by rings on which every body comes nearer."""

    def __init__(self, scene: Scene) -> None:
        """For a centred scene."""
        super().__init__(scene)
        self._rings = None if self.why_not() else self._ring_proof()

    @abstractmethod
    def _ring_proof(self) -> RingProof[Any] | None:
        """What shows that bodies come nearer; None where that would take too long."""

    def why_not(self) -> str:
        """Loads that nobody knows."""
        return "the loads are not known" if isinstance(self.scene.contact.loads, UnknownLoads) else ""

    def _comes_nearer(self, box: Tolerance) -> bool:
        """Whether bodies come nearer on some ring; where the centre of mass may be beside the point, on wide ones."""
        most = self._most(box)
        if self._rings is None or not self._can_turn or most <= 0:
            return False
        return self._disc(box) is not None if box.centre_of_mass else self._rings.comes_nearer(box, most)

    def _disc(self, box: Tolerance) -> Robust | None:
        """About the nominal centre of mass of the body, which may be beside the true one."""
        most, off = self._most(box), beside(box)
        if self._rings is None or not self._can_turn or most <= 0:
            return None
        disc = self._rings.disc(box, most)
        if disc is None or disc.start <= disc.radius + 2 * off:
            return None
        within = (disc.start - disc.radius) / disc.kappa
        return Robust(Certainty.CERTIFIED, "", disc.radius + off, disc.start - off, within)

    @property
    def _can_turn(self) -> bool:
        """Whether a body that turns on its way keeps its wheels: one without an outline."""
        return self.scene.body is None

    def _most(self, box: Tolerance) -> Fraction:
        """Up to where the body stays in the square and on the same wheels."""
        most, margin = _fraction(inner_radius(self.scene)), contact_set(self.scene).margin
        return most if margin is None else min(most, margin - _displaced(box))


class SmoothProof(DiscProof):
    """Rules ``ellipse`` and ``roller``: one equilibrium of every array nearby, which attracts; else a disc of ends."""

    no_proof = (
        "it is not shown that every array has one equilibrium nearby that attracts, nor that every body comes nearer "
        "on some ring about the point"
    )

    def _ring_proof(self) -> RingProof[Any] | None:
        return SmoothDisc(self.scene) if len(self.scene.wheels) <= MAX_SMOOTH else None

    def holds(self, box: Tolerance) -> bool:
        """By equilibria alone where they are shown for the scene, which is quick; else by a ring too."""
        if self._equilibrium(box) is not None:
            return True
        return not self._has_equilibrium and self._comes_nearer(box)

    def statement(self, box: Tolerance) -> Robust | None:
        """The equilibrium, else the disc."""
        return self._equilibrium(box) or self._disc(box)

    @cached_property
    def _has_equilibrium(self) -> bool:
        return self.scene.tolerances is not None and self._equilibrium(self.scene.tolerances) is not None

    def _equilibrium(self, box: Tolerance) -> Robust | None:
        """While no wheel comes under the body or leaves it."""
        found = equilibrium_box(self.scene, box)
        if found is None:
            return None
        radius = root_above(found.squared) + beside(box)
        margin = contact_set(self.scene).margin
        if margin is not None and radius + _displaced(box) >= margin:
            return None
        return Robust(Certainty.CERTIFIED, radius=radius, equilibrium=radius, drift=found.drift)


class BoxRuleProof(DiscProof):
    """Rule ``box``: a disc in which every body ends, and one in which every body stays at rest."""

    no_proof = "no ring about the point is found on which every body comes nearer"

    def why_not(self) -> str:
        """Loads that nobody knows, large arrays, and motions that no friction resists."""
        if len(self.scene.wheels) > MAX_WHEELS:
            return f"under rule box arrays of up to {MAX_WHEELS} wheels are followed"
        return super().why_not()

    def _ring_proof(self) -> BoxRingProof:
        return BoxRingProof(self.scene)

    def holds(self, box: Tolerance) -> bool:
        """Whether bodies come nearer on some ring."""
        return self._comes_nearer(box)

    def statement(self, box: Tolerance) -> Robust | None:
        """The disc of ends, and the disc of rest about the nominal centre of mass."""
        most, off = self._most(box), beside(box)
        if not isinstance(self._rings, BoxRingProof) or most <= 0:
            return None
        rests = max(self._rings.rest_radius(box, most) - off, Fraction(0))
        if not self._can_turn:
            return Robust(
                Certainty.UNDECIDED, "on its way a body may turn, and other wheels come under it", rests=rests
            )
        return replace(self._disc(box) or Robust(Certainty.UNDECIDED, self.no_proof), rests=rests)


def _displaced(box: Tolerance) -> Fraction:
    """How far a wheel may be from its place under the body."""
    return root_above(2 * above((box.position + box.centre_of_mass).ball()) ** 2)


PROOFS: dict[str, type[BoxProof]] = {
    "nearest": NearestProof,
    "box": BoxRuleProof,
    "ellipse": SmoothProof,
    "roller": SmoothProof,
}


def decide_robust(scene: Scene) -> Robust | None:
    """Decide for every array within the scene's tolerances; None for a scene without."""
    if scene.tolerances is None:
        return None
    proof = _proof(scene)
    if isinstance(proof, Robust):
        return proof
    found = proof.statement(scene.tolerances)
    factor = largest_factor(proof.holds, scene.tolerances)
    binding = binding_entry(proof.holds, scene.tolerances, factor)
    return replace(found or Robust(Certainty.UNDECIDED, proof.no_proof), factor=factor, binding=binding)


def decided_statement(scene: Scene) -> Robust:
    """The same for a scene with tolerances, without the factor and what binds."""
    proof = _proof(scene)
    if isinstance(proof, Robust) or scene.tolerances is None:
        return proof if isinstance(proof, Robust) else Robust(Certainty.UNDECIDED, "the scene states no tolerances")
    return proof.statement(scene.tolerances) or Robust(Certainty.UNDECIDED, proof.no_proof)


def _proof(scene: Scene) -> BoxProof | Robust:
    """What proves something about boxes of a scene; or why nothing does."""
    if scene.contact.rule not in PROOFS:
        rules = ", ".join(PROOFS)
        reason = f"tolerances are followed under the rules {rules}, not under {scene.contact.rule}"
        return Robust(Certainty.UNDECIDED, reason)
    proof = PROOFS[scene.contact.rule](scene.recentred())
    reason = proof.why_not()
    return Robust(Certainty.UNDECIDED, reason) if reason else proof


def certified_factor(scene: Scene) -> Fraction | None:
    """The multiple of the scene's tolerances alone; None without tolerances, and where none is followed."""
    if scene.tolerances is None or scene.contact.rule not in PROOFS:
        return None
    proof = PROOFS[scene.contact.rule](scene.recentred())
    return None if proof.why_not() else largest_factor(proof.holds, scene.tolerances)


def _fraction(value: fmpq) -> Fraction:
    return Fraction(int(value.p), int(value.q))
