"""The motion of a body on each set of wheels that may carry it, and the regime in which it is smooth.

Between changes of the contact set the motion still has kinks: where a spring comes free or a contact begins or ends to
stick.  Beside them it is analytic, and each of its pieces goes on analytically beyond the kink.  So a regime (which
wheels are loaded, which contacts stick) can be held while an integrator makes its step: its unknowns, the twist and
forces, follow their derivatives (:meth:`SetMotion.slope`) beside the pose, and :meth:`SetMotion.validities` says
afterwards where the regime ended.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from nonsmooth.analysis.bodies.newton_euler import MovingLoads
from nonsmooth.analysis.cells.contact_rule import SmoothRule
from nonsmooth.analysis.cells.loads import LoadError
from nonsmooth.analysis.fields.contact_model import ContactModel, ContactRows, contacts_under
from nonsmooth.analysis.minimizers.ellipse_minimizer import WarmMinimizer
from nonsmooth.analysis.minimizers.many_twists import MotionsOnSets
from nonsmooth.analysis.minimizers.minimum import may_jump, resists_every_motion
from nonsmooth.analysis.minimizers.smooth_newton import NOBODY, CutNewton, SmoothNewton
from nonsmooth.analysis.trajectories.result import TrajectoryError
from nonsmooth.symbolic.mechanics.friction_set import CutEllipse
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.number_text import place_text
from nonsmooth.symbolic.numbers.plane import XY, in_floats, pose_in_floats
from nonsmooth.symbolic.numbers.plane_arrays import Floats, are_finite, max_norm, norms, spread, turned

Wheels = frozenset[int]  # places in the scene's list of wheels

# Evaluations that take as long as a minimizer that is found from nothing, and one beside drag that Newton's method
# leaves to multipliers.
COLD, BESIDE_DRAG = 100, 8
NEAR_BORDER = 1e-7  # of the size of the set: so near to the border of its support two wheels carry all the weight


class SetMotion:
    """Pose rates ``(c', theta')`` on one set of wheels.

    Attributes:
        model: the contacts of these wheels.
        drags: whether a little drag stands in for jumps of the twist.
    """

    def __init__(self, model: ContactModel, pose: Floats) -> None:
        """For the contacts of the set, and a pose at which they carry the body.

        Raises:
            nonsmooth.analysis.cells.loads.LoadError: where they do not.
        """
        self.model, self._loads = model, MovingLoads(model, pose[:2])
        self.drags = may_jump(model)
        self._minimizer = DraggedMinimizer(model) if self.drags else WarmMinimizer(model)
        self._quick = SmoothNewton(model) if model.has_whole_ellipses and not self.drags else None
        dragged = self._minimizer.dragged if isinstance(self._minimizer, DraggedMinimizer) else None
        self._cut = None if dragged is None or dragged.shape is not CutEllipse else CutNewton(dragged)
        self._regime = NOBODY
        self._resisted: dict[bytes, bool] = {}
        self._beside_drag = 0  # minimizers that multipliers found with drag
        self._near_border = NEAR_BORDER * spread(model.positions)
        self._proved: Floats | None = None  # the last twist

    @property
    def work(self) -> int:
        """What minimizers took so far beyond Newton steps from the last one, in evaluations by these."""
        return COLD * self._minimizer.cold + BESIDE_DRAG * self._beside_drag

    def margins(self, poses: Floats) -> Floats:
        """Distance of the centre of mass from the border of the support polygon, negative outside; poses (m, 3)."""
        return self._loads.margins(poses[:, :2])

    def guess(self, twist: Floats) -> None:
        """Begin Newton's method at a twist, the first time."""
        if self._quick is not None and self._quick.last is None:
            self._quick.start_from(twist)

    def rate(self, pose: Floats) -> Floats:
        """``(c', theta')`` with exact kinematics; a little beyond the support polygon it is continued.

        On the border of the polygon, where the path ends, minimizers may have no limit: steps that look there and
        beyond go on with the last twist that is proved.

        Raises:
            TrajectoryError: where the minimizer is not proved to be the motion.
        """
        loads = self._loads.at(pose[:2])[0]
        try:
            self._proved = self._proved_twist(loads, pose)
        except TrajectoryError:
            if self._proved is None or self.margins(pose[None])[0] > self._near_border:
                raise
        return with_kinematics(self._proved, pose)

    def _proved_twist(self, loads: Floats, pose: Floats) -> Floats:
        """The minimizer of D: by Newton steps from the last one, else by multipliers.

        Raises:
            TrajectoryError: where the minimizer is not proved to be the motion.
        """
        found = None
        if self._quick is not None:
            found = self._quick.minimize(loads)
        elif self._cut is not None:
            found = self._cut.minimize(with_drag(loads))
        if found is not None:
            return found
        self._beside_drag += self._quick is None
        twist = self._minimizer.minimize(loads)
        if twist is None and self._cut is not None:  # beside a kink Newton's method goes on where multipliers end
            self._cut.start_from(self._minimizer.nearest)
            twist = self._cut.minimize(with_drag(loads))
        if twist is None or not self._resists_every_motion(loads):
            place = place_text(in_floats(pose))
            raise TrajectoryError(f"required a certified motion, received a minimum without proof at {place}")
        if self._quick is not None:
            self._quick.start_from(twist)
            self._quick.minimize(loads)  # finds the regime, if it can
        elif self._cut is not None:
            self._cut.start_from(twist)
        return twist

    def _resists_every_motion(self, loads: Floats) -> bool:
        """The same for all loads that press the same wheels."""
        pattern = (loads > 0).tobytes()
        if pattern not in self._resisted:
            self._resisted[pattern] = bool(resists_every_motion(self.model, loads[None])[0])
        return self._resisted[pattern]

    @property
    def _newton(self) -> SmoothNewton:
        """What holds regimes."""
        if self._quick is None:
            raise ValueError("required whole friction ellipses, received some that are cut")
        return self._quick

    # ---- regimes ---------------------------------------------------------------------------------

    def hold(self, ahead: Floats, pose: Floats) -> Floats | None:
        """Hold the regime of a pose a little ahead; its unknowns at the pose itself, None where it has none."""
        self.rate(ahead)
        if self._quick is None or self._quick.last is None or self.margins(ahead[None])[0] <= 0:
            return None
        self._regime, unknowns = self._quick.last
        return self.settled(pose, unknowns)

    def settled(self, pose: Floats, unknowns: Floats) -> Floats | None:
        """The unknowns at a pose, proved to be those of the only minimizer while the regime holds; None without."""
        return self._newton.settled(self._regime, unknowns, self._loads.continued(pose[:2])[0])

    def slope(self, pose: Floats, rate: Floats, unknowns: Floats) -> Floats:
        """How fast the unknowns change while the pose does; not a number where they cannot be continued."""
        loads, slopes = self._loads.continued(pose[:2])
        return self._newton.slope(self._regime, unknowns, loads, slopes @ rate[:2])

    def jacobian(self, pose: Floats) -> Floats | None:
        """Slopes of :meth:`rate` by the pose (3 x 3); None where the pose has no regime, or that cannot be continued.

        Differences would not do: beside a place where the slip of a wheel vanishes, slopes change within distances at
        which differences are lost in rounding.
        """
        self.rate(pose)
        if self._quick is None or self._quick.last is None:
            return None
        self._regime, unknowns = self._quick.last
        columns = []
        for step in np.eye(3):
            twist = self.slope(pose, step, unknowns)[:3]
            columns.append(with_kinematics(twist, pose) + unknowns[2] * turning(step))
        found = np.column_stack(columns)
        return found if are_finite(found) else None

    def is_near_rest(self, pose: Floats, unknowns: Floats) -> bool:
        """Whether a contact nearly sticks by now that the regime does not know."""
        return self._newton.is_near_rest(self._regime, unknowns, self._loads.continued(pose[:2])[0])

    def validities(self, poses: Floats, unknowns: Floats) -> Floats:
        """Negative where the regime held has ended, at poses (m, 3) with unknowns (m, k); shape (m,)."""
        lacks = self._regime.lacks(unknowns).min(axis=1, initial=np.inf)
        return np.minimum(lacks, self._loads.validities(poses[:, :2]))


def with_kinematics(twist: Floats, pose: Floats) -> Floats:
    """``(c', theta')`` of a spatial twist."""
    return twist + twist[2] * turning(pose)


def turning(pose: Floats) -> Floats:
    """``(J c, 0)``: how a pose moves as the body turns about the origin, apart from its heading."""
    return np.array([-pose[1], pose[0], 0.0])


# ---- one set after the other -----------------------------------------------------------------------


class TippedError(Exception):
    """No loads balance the weight: the centre of mass is not over the hull of the wheels."""


class ContactSets:
    """Pose rates ``(c', theta')`` by set of carrying wheels."""

    def __init__(self, model: ContactModel) -> None:
        """For the contacts of all wheels, with their friction sets."""
        self._model = model
        self._motions: dict[Wheels, SetMotion] = {}
        self.evaluations = 0  # of rates so far
        self._last = np.zeros(3)  # twist of any set: where Newton's method begins on a new one

    @property
    def is_stiff(self) -> bool:
        """Whether a little drag stands in for jumps of the twist, which makes the field very stiff."""
        return may_jump(self._model)

    @property
    def work(self) -> int:
        """What all rates so far cost, in evaluations by Newton steps from the last minimizer."""
        return self.evaluations + sum(motion.work for motion in self._motions.values())

    def rate(self, wheels: Wheels, pose: Floats) -> Floats:
        """:meth:`nonsmooth.analysis.bodies.set_motion.SetMotion.rate` of a set.

        Raises:
            TippedError: for wheels that carried the body nowhere yet, and do not here.
            TrajectoryError: where the minimizer is not proved to be the motion.
        """
        self.evaluations += 1
        motion = self.motion(wheels, pose)
        if self._last.any():
            motion.guess(self._last)
        rate = motion.rate(pose)
        self._last = rate - rate[2] * turning(pose)
        return rate

    def carries(self, wheels: Wheels, pose: Floats) -> bool:
        """Whether the body stands on the wheels there."""
        try:
            return self.margin(wheels, pose) > 0
        except TippedError:
            return False

    def margin(self, wheels: Wheels, pose: Floats) -> float:
        """Distance of the centre of mass from the border of the support polygon, negative outside.

        Raises:
            TippedError: for wheels that carried the body nowhere yet, and do not here.
        """
        return float(self.motion(wheels, pose).margins(pose[None])[0])

    def motion(self, wheels: Wheels, pose: Floats) -> SetMotion:
        """The motion on a set, built where the body first stands on it.

        Raises:
            TippedError: for wheels that carried the body nowhere yet, and do not here.
        """
        if wheels not in self._motions:
            if len(wheels) < min(3, self._model.wheels):
                raise TippedError
            try:
                self._motions[wheels] = SetMotion(self._model.on(sorted(wheels)), pose)
            except LoadError as error:
                raise TippedError from error
        return self._motions[wheels]


# ---- minimizers along a path ---------------------------------------------------------------------
#
# ``c' = v + omega J c, theta' = omega`` with ``xi = (v, omega)`` the minimizer at the current loads.
# Newton steps from the last minimizer take a tenth of a millisecond, with drag three.  Where they do not prove that
# theirs is the only minimizer, that of the method of multipliers is taken, which costs a millisecond or more.
#
# Where friction sets have corners (rule ``roller``), or all rims are parallel, D is linear in pieces, as under rule
# ``box``: at some loads its minimizers are a whole face, and beyond them the twist is another one.  Solutions slide
# along such places (Filippov), which no integrator of smooth fields can follow.  So a little drag is added,
# ``sum_k epsilon sqrt(x_k^2 + g^2)`` over the entries x of ``(v_x, v_y, L omega)``: smooth, strictly convex, least at
# rest.  The twist then passes from one to the other while the slope of D along the face changes by the drag's.  It
# moves a twist that does not jump by the order of epsilon.  The result is proved as ever: as the minimizer of D plus
# drag, whose value is within ``epsilon (|x|_1 + 3 g)`` of the least D.  The field is so stiff that backward
# differentiation formulas follow it from the start.


DRAG = 1e-6  # of the friction of the whole weight


class DraggedMinimizer(WarmMinimizer):
    """The minimizer of D plus drag, one after the other along a path.

    Attributes:
        dragged: the contacts with three more, which are the drag.
    """

    def __init__(self, model: ContactModel) -> None:
        """For contacts of which a strip cuts some friction sets."""
        # three contacts more: along x, along y and around, each with a slip g across that never vanishes, at the mean
        # of the wheels, as for any origin of coordinates
        middle = model.positions.mean(axis=0)
        size = float(norms(model.positions - middle).max())
        speed = max_norm(model.targets) or 1.0
        rows = np.zeros((6, 3))
        rows[[0, 2, 4], [0, 1, 2]] = 1.0, 1.0, size
        rows[[0, 2], 2] = turned(middle)
        self.dragged = ContactRows(
            np.concatenate([model.rows, rows]),
            np.concatenate([model.targets, np.tile([0.0, speed], 3)]),
            np.concatenate([model.friction, np.full(6, model.friction.max())]),
            cuts=np.concatenate([model.cuts, np.ones(3)]),
            shape=model.shape,
        )
        super().__init__(self.dragged)

    def minimize(self, loads: Floats) -> Floats | None:
        """At loads (n,) of the wheels."""
        return super().minimize(with_drag(loads))


def with_drag(loads: Floats) -> Floats:
    """Loads (n,) of the wheels, and those of the three contacts that stand for drag."""
    return np.concatenate([loads, np.full(3, DRAG * loads.sum())])


# ---- what a body does on one set of wheels at one centre of mass ---------------------------------
#
# In floats: a guess for ball arithmetic to prove.


STICKS, STICKS_BESIDE_ROLLERS = 1e-4, 1e-2  # slip, of the fastest wheel's speed, below which a wheel may stick


@dataclass(frozen=True)
class SetGuess:
    """A motion.

    Attributes:
        twist: spatial twist ``(v, omega)``.
        loaded: which of the wheels are pressed.
        stuck: which of them seem not to slip.
    """

    twist: tuple[float, float, float]
    loaded: tuple[bool, ...]
    stuck: tuple[bool, ...]


class SetGuesses:
    """Guesses for one array."""

    def __init__(self, scene: Scene, rule: SmoothRule) -> None:
        """For all wheels of a scene; its body is not looked at."""
        self.model: ContactModel = contacts_under(rule, scene)
        self._size = spread(self.model.positions) or 1.0
        self._motions = MotionsOnSets(self.model, self._size)

    def of(self, wheels: Sequence[int], place: XY) -> SetGuess | None:
        """On some wheels, by their places in the list; None where the body tips or no motion is found."""
        carrying = np.zeros((1, self.model.wheels), bool)
        carrying[0, list(wheels)] = True
        found = self._motions.at(carrying, np.array([place]))
        if not found.known[0]:
            return None
        (vx, vy, turning), (x, y) = found.rates[0], place
        omega = turning / self._size
        twist = np.array([vx + omega * y, vy - omega * x, omega])
        loaded = tuple(bool(found.loads[0, k] > 0) for k in wheels)
        return SetGuess(pose_in_floats(twist), loaded, _nearly_stuck(self.model, twist, wheels))


def _nearly_stuck(model: ContactModel, twist: Floats, wheels: Sequence[int]) -> tuple[bool, ...]:
    """Which wheels hardly slip."""
    fastest = max_norm(model.speeds) or 1.0
    slips = np.abs(model.slips(twist)).max(axis=-1)[list(wheels)]
    limit = STICKS_BESIDE_ROLLERS if (model.cuts < 1).any() else STICKS
    return tuple(bool(slip <= limit * fastest) for slip in slips)
