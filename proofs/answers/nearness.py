"""Where bodies near the checked point end, where no clause says that they come home: to the accuracy of the scene.

A clause speaks of the point itself, and the rest point of a table that was measured never is at the point itself.  So
the question is asked with a length a, the accuracy:

- *comes near*: every body from within R is within r of the point after a time T, with ``r <= a`` and ``R >= 2 max(r,
  a)``.  Without that inequality it would say little: a body that stays where it is put ends within a of the point too.
- *leaves*: as near to the point as one likes there are starts whose bodies end, or are carried, farther away than a.
  That the point itself is no place of rest does not suffice.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache

from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.proofs.robust.drift import driven_out
from nonsmooth.proofs.robust.ends import Ends, decide_ends, why_not_followed
from nonsmooth.proofs.verdicts import Equilibrium, Translation
from nonsmooth.symbolic.numbers.rounded import either_way
from nonsmooth.symbolic.scene import Scene, Wheel


@dataclass(frozen=True)
class Nearness:
    """What is shown about the ends of bodies from near the point.

    Attributes:
        ends: the disc or the place in which they end; None where none is shown.
        out_after: the time after which every body has left the disc of the accuracy; None where that is not shown.
        is_thrown_out: whether bodies from as near as one likes are carried out of that disc.
        why_not: why nothing was looked for; empty where something was.
    """

    ends: Ends | None = None
    out_after: Fraction | None = None
    is_thrown_out: bool = False
    why_not: str = ""

    @property
    def comes_near(self) -> bool:
        """Whether bodies end within the accuracy."""
        return self.ends is not None and self.ends.is_near

    @property
    def leaves(self) -> bool:
        """Whether some end, or are carried, farther away."""
        ends_away = self.ends is not None and not self.ends.is_near
        return ends_away or self.out_after is not None or self.is_thrown_out


@dataclass(frozen=True, eq=False)
class _Asked:
    """A question, the same where it is about the same object: to compare scenes number by number takes longer."""

    scene: Scene
    equilibrium: Equilibrium
    translation: Translation

    def __hash__(self) -> int:
        return hash((id(self.scene), self.equilibrium, self.translation))

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, _Asked)
            and self.scene is other.scene
            and (self.equilibrium, self.translation) == (other.equilibrium, other.translation)
        )


def nearness(scene: Scene, equilibrium: Equilibrium, translation: Translation) -> Nearness:
    """Where bodies near the checked point end; what the clauses say of it may spare the search.

    Args:
        scene: the array.
        equilibrium: whether the point is a place of rest.
        translation: what bodies beside it do.
    """
    return _decided(_Asked(scene, equilibrium, translation))


@lru_cache(maxsize=16)  # an answer is asked for several times
def _decided(asked: _Asked) -> Nearness:
    scene, accuracy = asked.scene, asked.scene.accuracy
    centred = scene.recentred()
    why_not = why_not_followed(centred)
    if why_not:
        return Nearness(why_not=why_not)
    holds = asked.equilibrium is Equilibrium.HOLDS
    with either_way(scene.field):  # what is shown holds for every member of what was rounded
        ends = decide_ends(centred, accuracy, rests=holds and asked.translation is Translation.STABLE)
        if ends is not None or (holds and asked.translation is Translation.STABLE):
            return Nearness(ends)
        if holds:
            return Nearness(is_thrown_out=_is_thrown_out(scene, accuracy))
        return Nearness(out_after=driven_out(centred, accuracy))


def _is_thrown_out(scene: Scene, accuracy: Fraction) -> bool:
    """Whether, with all rims reversed, every body from within the accuracy comes home to the point.

    D does not change where all speeds and the twist change their signs: motions of the reversed array are those of the
    array, run backward.  So some body from as near as one likes is carried out of the disc.
    """
    from nonsmooth.proofs.clauses import registry
    from nonsmooth.proofs.clauses.workspace import Workspace

    backward = replace(scene, wheels=tuple(_reversed(wheel) for wheel in scene.wheels))
    work = Workspace(backward, sample=False)
    try:
        for clause in registry.CLAUSES:
            if clause.name in {"equilibrium", "translation"}:
                work.earlier[clause.name] = work.decided(clause)
    except RefusalError:
        return False
    found = work.earlier["translation"]
    home = getattr(found, "home_radius", None)
    attracts = found.verdict is Translation.ASYMPTOTICALLY_STABLE
    return bool(attracts and home is not None and home >= accuracy)


def _reversed(wheel: Wheel) -> Wheel:
    return replace(wheel, given_speed=-wheel.speed)
