"""Paths of fields that divide by norms: where one is zero they slide with the equivalent control, cross, or leave.

The path comes to such a place in finite time, turning ever faster, and keeps to it for as long as a vector u of at most
unit length can (:mod:`nonsmooth.analysis.fields.norm_zeros`).  Then it leaves with the unit vector with which solutions
begin, until the norm s is a millionth of the states' size: nearer u lags behind that by about s, and turns too fast for
floats.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial

import numpy as np

from nonsmooth.analysis.fields.norm_zeros import HeldVelocity, NormField, NormZero
from nonsmooth.analysis.fields.switched_field import Face, FacedField, NoVelocityError, length, span
from nonsmooth.analysis.trajectories.faces import SMALLEST_SPEED, FaceChoice, FaceMotion
from nonsmooth.analysis.trajectories.follow import Mode, Path
from nonsmooth.analysis.trajectories.guards import GUARD_SLACK, Guard, by_difference
from nonsmooth.analysis.trajectories.result import EndReason, EventKind, LyapunovWatch
from nonsmooth.analysis.trajectories.smooth_path import FaceMode, FilippovFaces
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from nonsmooth.symbolic.numbers.work_limit import WorkMeter

ARRIVES = 2.0**-34  # of the size of the states: as near to the zeros of a norm a path is on its last, straight way
BESIDE = 1e-6  # of the size: as far a path follows the unit vector with which it leaves them
FULL = 1e-6  # the least singular value of unit normals that count as independent, and what entries of matrices err by


class FacesAndZeros(FilippovFaces):
    """The solutions of a field with zeros of norms, face after face.

    Attributes:
        held: the numbers of the norms that are kept at zero.
        left: that of the norm whose zeros the path is about to leave; None elsewhere.
    """

    def __init__(self, field: FacedField, watch: LyapunovWatch | None, meter: WorkMeter, max_events: int) -> None:
        if not isinstance(field, NormField):
            raise ValueError("required a field that divides by norms")
        self._whole, self._zeros, self._near = field, field.zeros, ARRIVES * field.size
        self.held: tuple[int, ...] = ()
        self.left: int | None = None
        super().__init__(field.keeping((), 0.0), watch, meter, max_events)

    def next_mode(self, path: Path) -> Mode | EndReason:
        """As without zeros; a path may begin on some."""
        if not path.stretches:
            for k, zero in enumerate(self._zeros):
                ended = self._hold(path, k) if length(zero.sigma(path.state)) <= self._near else None
                if ended is not None:
                    raise NoVelocityError(path.note)
        mode = super().next_mode(path)
        if self.held and path.unique and isinstance(mode, FaceMode) and mode.motion.face.keep:
            path.unique = None  # controls and mixtures of sides may trade with each other
        return mode

    def further_guards(self, choice: FaceChoice) -> Sequence[Guard]:
        """The distances from the zeros of all other norms, then what ends that the path keeps to zeros, or leaves."""
        found = [self._away_from(k, self._near) for k in self._others]
        if self.left is not None:
            found.append(self._away_from(self.left, -BESIDE * self.field.size))
        elif self.held:
            value = partial(_margin, choice.motion)
            found.append(Guard(value, GUARD_SLACK, by_difference(value, self.field.size)))
        return found

    @property
    def _others(self) -> list[int]:
        """The norms that are not zero."""
        return [k for k in range(len(self._zeros)) if k not in (*self.held, self.left)]

    def _away_from(self, k: int, nearest: float) -> Guard:
        """That a norm is larger than some number; smaller than its size, if it is negative."""
        zero, side = self._zeros[k], math.copysign(1.0, nearest)

        def value(t: float, x: Floats) -> float:
            return side * length(zero.sigma(x)) - nearest

        def slope(t: float, x: Floats, velocity: Floats) -> float:
            sigma = zero.sigma(x)
            return side * float(sigma @ zero.rows @ velocity) / (length(sigma) or 1.0)

        return Guard(value, GUARD_SLACK * self.field.size, slope)

    def arrive(self, path: Path, mode: Mode, met: int | None) -> EndReason | None:
        """Onto the zeros that were met, or away from those that can be kept to no longer."""
        ended = super().arrive(path, mode, met)
        further = mode.further_met(met) if isinstance(mode, FaceMode) else None
        if ended is not None or further is None or not isinstance(mode, FaceMode):
            return ended
        if further < len(self._others):
            return self._hold(path, self._others[further], mode.motion(path.time, path.state))
        if self.left is None:
            return self._leave(path, _velocities(mode.motion.face), EventKind.LEAVE)
        self._go_on(path, self.held)
        return None

    def _hold(self, path: Path, k: int, velocity: Floats | None = None) -> EndReason | None:
        """Go straight on to the zeros of a norm, and keep to them, or cross.

        Where they meet surfaces, or other zeros that are kept to, all normals must be independent: else F holds less
        than every control there with every mixture of the sides.
        """
        zero = self._zeros[k]
        if velocity is not None:
            sigma = zero.sigma(path.state)
            later = float(sigma @ sigma) / max(-float(sigma @ zero.rows @ velocity), SMALLEST_SPEED)
            path.time, path.state = path.time + later, path.state + later * velocity
        held = (*self.held, k)
        path.state = _on_zeros([self._zeros[j] for j in held], path.state)
        try:
            faces = self._whole.keeping(held, 0.0).faces_at(path.state)
        except NoVelocityError as error:
            path.note = str(error)
            return EndReason.UNPROVED
        normals = [*_normals(self._zeros, held), *(surface.normal(path.state) for surface in faces[0].keep)]
        if span(np.array(normals).T).shape[1] < len(normals):
            path.note = "switching surfaces, or zeros of other norms, hold those of the norm that was met"
            return EndReason.UNPROVED
        self._go_on(path, held)
        velocities = _velocities(faces[0])
        self._doubt(path, velocities, keeps=True)
        if len(velocities) == 1 and velocities[0].margin(path.state) < 0:
            return self._leave(path, velocities, EventKind.CROSS)
        path.tell(EventKind.SLIDE, f"{zero.name} = 0")
        return None

    def _leave(self, path: Path, velocities: Sequence[HeldVelocity], kind: EventKind) -> EndReason | None:
        """Leave the zeros that cannot be kept to."""
        lengths = min(velocities, key=lambda velocity: velocity.margin(path.state)).lengths(path.state)
        if len(lengths) > 1 and not all(map(math.isfinite, lengths)):
            path.note = "no control keeps to the zeros of all norms, and it is not known which of them are left"
            return EndReason.UNPROVED
        k = self.held[lengths.index(max(lengths))]
        self._doubt(path, velocities, keeps=False)
        path.tell(kind, f"{self._zeros[k].name} = 0")
        self._go_on(path, tuple(j for j in self.held if j != k), k)
        return None

    def _doubt(self, path: Path, velocities: Sequence[HeldVelocity], *, keeps: bool) -> None:
        """Note where other solutions are not excluded."""
        if path.unique and not (len(velocities) == 1 and self._is_only(velocities[0], path.state, keeps=keeps)):
            path.unique = None

    def _is_only(self, velocity: HeldVelocity, x: Floats, *, keeps: bool) -> bool:
        """Whether W B is symmetric and negative definite: then ``sigma' = ... + W B sigma/abs(sigma)`` is monotone.

        In the metric of its inverse any two solutions come closer, but for what is smooth, so that there is one from
        each start.  So there is where all directions beside one place lead back to it.
        """
        matrix = velocity.input_matrix(x)
        if np.allclose(matrix, matrix.T, rtol=FULL) and float(np.linalg.eigvalsh(matrix).max()) < 0:
            return True
        return keeps and len(self.held) == 1 and velocity.outward_speed(x) < 0

    def _go_on(self, path: Path, held: tuple[int, ...], left: int | None = None) -> None:
        """With the field that keeps to some zeros, and that of what leaves one."""
        field = self._whole.keeping(held, 0.0) if left is None else self._whole.leaving((*held, left), left)
        self.held, self.left, self.field, self.before = held, left, field, None
        self.faces = self.field.faces_at(path.state)
        self._forget()


def _velocities(face: Face) -> list[HeldVelocity]:
    """Those of the members of a face."""
    return [member.velocity for member in face.members if isinstance(member.velocity, HeldVelocity)]


def _margin(motion: FaceMotion, t: float, x: Floats) -> float:
    """How much shorter than one the equivalent control of every member is."""
    return min(velocity.margin(x) for velocity in _velocities(motion.face))


def _on_zeros(zeros: Sequence[NormZero], x: Floats) -> Floats:
    """The nearest state on all of some places."""
    rows, sigma = np.vstack([zero.rows for zero in zeros]), np.concatenate([zero.sigma(x) for zero in zeros])
    return np.asarray(x - np.linalg.lstsq(rows, sigma, rcond=FULL)[0])


def _normals(zeros: Sequence[NormZero], held: Sequence[int]) -> list[Floats]:
    """Unit vectors across places."""
    return [row / length(row) for k in held for row in zeros[k].rows]
