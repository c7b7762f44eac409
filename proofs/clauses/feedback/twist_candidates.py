"""The twists that are looked at for a law of imposed twists: all pairs of wheels, or the most promising of many."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from math import comb

from nonsmooth.analysis.cells.loads import LoadRegion
from nonsmooth.analysis.contact_rule import CellRule, rule_of
from nonsmooth.proofs.clauses.feedback.box_twists import BoxTwist, Drives, candidate_twists
from nonsmooth.proofs.clauses.feedback.driven_law import ImposedTwist, rank_of
from nonsmooth.proofs.clauses.feedback.ellipse_twists import balance_twist, exclude_twist
from nonsmooth.proofs.clauses.feedback.promising import PromisingTwists
from nonsmooth.symbolic.constraints import Triple
from nonsmooth.symbolic.scene import Scene

ENOUGH = 60  # candidates beyond which three independent unique minimizers end the search: a better rate is not sought
LOOKED_AT = 20_000  # wheels times candidates that are looked at: a minute or so under rule ellipse
TIES = 16  # candidates that seem to balance exactly, of which a law by directions of c is made
FEW_OF = 6  # part of them beyond which the search may end
TRIED = 100  # candidates of which it is tried to prove that no speeds impose them


def candidates_of(scene: Scene, region: LoadRegion, enough: int = ENOUGH) -> tuple[list[ImposedTwist], bool]:
    """The candidates, and whether these are all; of many only the most promising.

    The more wheels, the longer each takes, and the fewer are looked at.  The search may end after ``enough``.
    """
    most = LOOKED_AT // len(scene.wheels)
    impose = imposer(scene, region)
    if comb(len(scene.wheels), 2) > most:
        return _promising_candidates(scene, region, impose, most), False
    found: list[ImposedTwist] = []
    for twist in candidate_twists(scene):
        if len(found) >= most:
            return found, False
        found.append(impose(twist))
        may_end = len(found) > min(enough, most // FEW_OF)
        if may_end and found[-1].is_unique and rank_of([entry for entry in found if entry.is_unique]) == 3:
            return found, False
    return found, True


def imposer(scene: Scene, region: LoadRegion) -> Callable[[Triple], ImposedTwist]:
    """What imposes a twist under the rule of the scene."""
    if isinstance(rule_of(scene), CellRule):
        return Drives(scene, region).examine
    return partial(balance_twist, scene, region)


def _promising_candidates(
    scene: Scene, region: LoadRegion, impose: Callable[[Triple], ImposedTwist], most: int
) -> list[ImposedTwist]:
    """Candidates off the span of the unique minimizers found so far, until there are three; then those that may tie."""
    proposals = PromisingTwists(scene, region)
    found: list[ImposedTwist] = []
    unique: list[ImposedTwist] = []
    while len(unique) < 3 and len(found) < most // 2:
        twist = proposals.next([imposed.twist for imposed in unique])
        if twist is None:
            break
        found.append(impose(twist))
        unique += [found[-1]] if found[-1].is_unique else []
    if len(unique) < 3:
        found += [impose(twist) for twist in proposals.ties([imposed.twist for imposed in unique], TIES)]
    return found


def with_exclusions(candidates: Sequence[ImposedTwist]) -> list[ImposedTwist]:
    """The candidates with the proof, where it is sought apart, that no speeds impose them; no more than matters."""
    judged: list[ImposedTwist] = []
    tried = 0
    for candidate in candidates:
        open_ones = [entry for entry in judged if not entry.is_excluded]
        if isinstance(candidate, BoxTwist) or candidate.is_unique or rank_of(open_ones) == 3 or tried == TRIED:
            judged.append(candidate)
        else:
            tried += 1
            judged.append(exclude_twist(candidate))
    return judged
