"""Whether what a check says holds for every array within the tolerances of its scene, and for how much larger ones.

For each contact rule a class on :class:`BoxProof` says what is proved; to follow another rule, write one and list it.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import replace
from fractions import Fraction

from flint import fmpq

from nonsmooth.proofs.robust.box import BoxRule
from nonsmooth.proofs.robust.box_corners import MAX_WHEELS
from nonsmooth.proofs.robust.factor import binding_entry, largest_factor
from nonsmooth.proofs.robust.nearest import inner_radius, is_bounded, ultimate_bound, why_not_nearest
from nonsmooth.proofs.robust.robust import Robust, above, beside
from nonsmooth.proofs.robust.smooth import equilibrium_box
from nonsmooth.proofs.robust.ultimate_bound import root_above
from nonsmooth.proofs.verdicts import Certainty
from nonsmooth.symbolic.contact_set import contact_set
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.tolerances import Tolerance
from nonsmooth.symbolic.unknown_loads import UnknownLoads


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


class SmoothProof(BoxProof):
    """Rules ``ellipse`` and ``roller``: one equilibrium of every array nearby, which attracts exponentially."""

    no_proof = "it is not shown that every array has one equilibrium nearby that attracts"

    def why_not(self) -> str:
        """Loads that nobody knows."""
        return "the loads are not known" if isinstance(self.scene.contact.loads, UnknownLoads) else ""

    def holds(self, box: Tolerance) -> bool:
        """The same as the statement."""
        return self.statement(box) is not None

    def statement(self, box: Tolerance) -> Robust | None:
        """While no wheel comes under the body or leaves it."""
        found = equilibrium_box(self.scene, box)
        if found is None:
            return None
        radius = root_above(found.squared) + beside(box)
        margin = contact_set(self.scene).margin
        if margin is not None and radius + _displaced(box) >= margin:
            return None
        return Robust(Certainty.CERTIFIED, radius=radius, drift=found.drift)


class BoxRuleProof(BoxProof):
    """Rule ``box``: a disc in which every body ends, and one in which every body stays at rest."""

    no_proof = "no ring about the point is found on which every body comes nearer"

    def __init__(self, scene: Scene) -> None:
        """For a centred scene."""
        super().__init__(scene)
        self._rule = BoxRule(scene) if not self.why_not() else None

    def why_not(self) -> str:
        """Loads that nobody knows, large arrays, and motions that no friction resists."""
        if isinstance(self.scene.contact.loads, UnknownLoads):
            return "the loads are not known"
        if len(self.scene.wheels) > MAX_WHEELS:
            return f"under rule box arrays of up to {MAX_WHEELS} wheels are followed"
        return ""

    def holds(self, box: Tolerance) -> bool:
        """Whether bodies come nearer on some ring; where the centre of mass may be beside the point, on wide ones."""
        if box.centre_of_mass:
            found = self.statement(box)
            return found is not None and found.verdict is Certainty.CERTIFIED
        most = self._most(box)
        return self._can_turn and self._rule is not None and most > 0 and self._rule.comes_nearer(box, most)

    @property
    def _can_turn(self) -> bool:
        """Whether a body that turns on its way keeps its wheels: one without an outline."""
        return self.scene.body is None

    def statement(self, box: Tolerance) -> Robust | None:
        """About the nominal centre of mass of the body, which may be beside the true one."""
        most, off = self._most(box), beside(box)
        if self._rule is None or most <= 0:
            return None
        rests = max(self._rule.rest_radius(box, most) - off, Fraction(0))
        if not self._can_turn:
            return Robust(
                Certainty.UNDECIDED, "on its way a body may turn, and other wheels come under it", rests=rests
            )
        disc = self._rule.disc(box, most)
        if disc is None or disc.start <= disc.radius + 2 * off:
            return Robust(Certainty.UNDECIDED, self.no_proof, rests=rests)
        within = (disc.start - disc.radius) / disc.kappa
        return Robust(Certainty.CERTIFIED, "", disc.radius + off, disc.start - off, within, rests=rests)

    def _most(self, box: Tolerance) -> Fraction:
        """Up to where the body stays in the square and on the same wheels."""
        most, margin = _fraction(inner_radius(self.scene)), contact_set(self.scene).margin
        return most if margin is None else min(most, margin - _displaced(box))


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
