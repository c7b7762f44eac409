"""What is proved of a periodic orbit that floats have found: that there is one, where, and whether it attracts.

Rigorous for planar systems: an orbit that crosses surfaces by its return map
(:mod:`nonsmooth.proofs.orbits.return_map`), one that slides by its last slide, which ends in one point whatever came
before (:mod:`nonsmooth.proofs.orbits.slide_map`).  Everything else is computed, not proved, and the reason is said.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from flint import arb

from nonsmooth.analysis.fields.sign_field import SignField
from nonsmooth.analysis.orbits.orbit import Orbit
from nonsmooth.analysis.trajectories.legs import Leg
from nonsmooth.proofs.orbits.ball_cell import BallCell
from nonsmooth.proofs.orbits.ball_steps import UnprovedError, precision
from nonsmooth.proofs.orbits.return_map import CrossedLeg, ReturnMap, proved_map
from nonsmooth.symbolic.switched_system import PLANE, SwitchedSystem


@dataclass(frozen=True)
class OrbitProof:
    """What is proved.

    Attributes:
        proved: whether an orbit is.
        attracts: whether it attracts (True) or repels (False) its neighbours; None where nothing is proved.
        reason: in one sentence.
        map: the return map of an orbit that crosses; None for others.
    """

    proved: bool
    attracts: bool | None
    reason: str
    map: ReturnMap | None = None
