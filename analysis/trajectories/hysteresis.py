"""Comparison methods as fields: hysteresis, as the paper simulates, and smoothed signs.

Murphey & Burdick (sec. 5) integrate with hysteresis "to avoid the numerical difficulties of approaching a switching
boundary": a mode is kept until the state is ``width`` beyond its border.  Sliding then becomes a zigzag of that width,
and the error of a path is of the order of the width while the number of switches grows like its inverse.  Smoothing
replaces sign by ``clip(h/width, -1, 1)``; the error is of the same order and the system becomes stiff like 1/width.
Both follow one solution without noticing where others branch off: ``unique`` is None.  The event-driven method
(:mod:`nonsmooth.analysis.trajectories.trajectory`) has neither error nor cost of this kind.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np

from nonsmooth.analysis.fields import switched_field
from nonsmooth.analysis.fields.norm_zeros import NormField
from nonsmooth.analysis.fields.switched_field import NoVelocityError, SwitchedField, Velocity
from nonsmooth.analysis.trajectories.follow import Guards, HybridField, Mode, Path, Stepper, follow
from nonsmooth.analysis.trajectories.result import EndReason, EventKind, Trajectory
from nonsmooth.analysis.trajectories.steppers import FixedSteps, Integrator
from nonsmooth.symbolic.numbers.plane_arrays import Floats

TOLERANCES = 1e-9, 1e-12  # relative and absolute, within a mode: far below the error of any usable width
MAX_SWITCHES = 1_000_000  # a width of 1e-6 over a path of unit length
MAX_EVALUATIONS = 100_000  # of the smoothed field: some seconds; a layer thinner than the tolerance is never crossed
MAX_RELAY_EVALUATIONS = 300_000  # of the fields with hysteresis: some ten seconds
NO_VELOCITY = "within the width the field has no value, near a point where a denominator is zero"
LOCATED = 0.5  # of the width: a switch farther off is not resolved by floats, and the zigzag would stand still


def simulate_hysteresis(
    field: SwitchedField, start: Sequence[float], until: float, width: float, step: float | None = None
) -> Trajectory:
    """Relay with hysteresis: a mode is left ``width`` beyond its border.

    Args:
        field: any switched field.
        start: initial state.
        until: last time.
        width: distance by which switches are late (units of the state).
        step: fixed step of the classical Runge-Kutta scheme, with switches between steps only; None integrates
            adaptively (SciPy's RK45) with located switches.

    Raises:
        ValueError: for a width, last time or step that is not positive, a start outside the domain, or a width so
            small that floats do not resolve its switches, or that the integrator does not get through them.
        TrajectoryError: where the integrator gives up.
    """
    if not width > 0 or not 0 < until < math.inf or (step is not None and not step > 0):
        raise ValueError(f"required a positive width, last time and step, received {width}, {until} and {step}")
    stepper: Stepper = Integrator("RK45", *TOLERANCES) if step is None else FixedSteps(step)
    relay = _Relay(field, width, MAX_RELAY_EVALUATIONS, locates=step is None)
    return _simulated(relay, start, until, stepper, "hysteresis")


def simulate_smoothed(field: SwitchedField, start: Sequence[float], until: float, width: float) -> Trajectory:
    """Signs smoothed over ``width`` to either side of a surface, by SciPy's LSODA (which turns implicit where stiff).

    Where a norm that is divided by is smaller than the width, that stands for it.

    Raises:
        ValueError: for a width or last time that is not positive, a start outside the domain, or a width so small
            that the integrator does not get through the layer.
        TrajectoryError: where the integrator gives up.
    """
    if not width > 0 or not 0 < until < math.inf:
        raise ValueError(f"required a positive width and last time, received {width} and {until}")
    if isinstance(field, NormField):
        field = field.keeping((), width)
    layer = _Layer(field, width, MAX_EVALUATIONS)
    return _simulated(layer, start, until, Integrator("LSODA", *TOLERANCES), "smoothed")


class _Widened(HybridField):
    """A switched field whose surfaces have a width; samples are kept only.

    Args:
        field: the field.
        width: of its surfaces.
        most: evaluations after which the width is refused.
    """

    dense = False

    def __init__(self, field: SwitchedField, width: float, most: int) -> None:
        self.field, self.width, self._most = field, width, most
        self._evaluations = itertools.count(1)

    def counted(self, velocity: Velocity) -> Velocity:
        """A field whose evaluations are counted.

        Raises:
            ValueError: for more evaluations than are allowed.
        """

        def rate(t: float, x: Floats) -> Floats:
            if next(self._evaluations) > self._most:
                raise ValueError(
                    f"required a width that {self._most} evaluations resolve, received {self.width:g} at t = {t:.6g}"
                )
            return velocity(t, x)

        return rate


def _simulated(widened: _Widened, start: Sequence[float], until: float, stepper: Stepper, method: str) -> Trajectory:
    """The path of samples."""
    x, field = np.array(start, float), widened.field
    if field.mode_at(x) is None:
        raise ValueError(f"required a start inside the domain of the cells, received {x.tolist()}")
    path = follow(widened, (0.0, x), until, stepper)
    path.unique = None
    return path.trajectory(str(field.kinematics), method)


# ---- hysteresis ----------------------------------------------------------------------------------


class _RelayMode(Mode):
    """A mode of the field, until the state is the width beyond its border."""

    place, cells = "", ()

    def __init__(self, relay: _Relay, mode: switched_field.Mode) -> None:
        self.mode, self.rate, self.guards = mode, relay.counted(relay.defined(mode)), _Margin(relay, mode)
        self._relay = relay

    def is_outlived(self, state: Floats) -> bool:
        """Beyond the border, as near a point at which a denominator is zero."""
        return self._relay.field.margin(self.mode, state) < 0


class _Margin(Guards):
    """How far a state is from the place where a mode is left."""

    def __init__(self, relay: _Relay, mode: switched_field.Mode) -> None:
        self._relay, self._mode, self.located = relay, mode, relay.locates

    def at(self, t: float, x: Floats) -> Sequence[float]:
        """The margin of the mode, and the width."""
        return (self._relay.field.margin(self._mode, x) + self._relay.width,)


class _Relay(_Widened):
    """Modes with hysteresis."""

    def __init__(self, field: SwitchedField, width: float, most: int, *, locates: bool) -> None:
        super().__init__(field, width, most)
        self.locates = locates
        self._mode: switched_field.Mode | None = None

    def defined(self, mode: switched_field.Mode) -> Velocity:
        """The field of a mode; a denominator that is zero at a point alone may vanish beyond its border, near that."""
        velocity = self.field.velocity(mode)

        def rate(t: float, x: Floats) -> Floats:
            """The same.

            Raises:
                NoVelocityError: where it has no value, though the mode is kept there.
            """
            rates = velocity(t, x)
            if not np.isfinite(rates).all() and self.field.margin(mode, x) >= -self.width:
                raise NoVelocityError(NO_VELOCITY)
            return rates

        return rate

    def next_mode(self, path: Path) -> Mode | EndReason:
        """The mode that the state is in, or has come to."""
        if not path.stretches:
            self._mode = self.field.mode_at(path.state)
        if self._mode is None:
            return EndReason.OUTSIDE
        return EndReason.EVENTS if len(path.events) >= MAX_SWITCHES else _RelayMode(self, self._mode)

    def arrive(self, path: Path, mode: Mode, met: int | None) -> EndReason | None:
        """The switch to another mode.

        Raises:
            ValueError: where floats do not resolve the width.
        """
        if met is None or not isinstance(mode, _RelayMode):
            return None
        if self.locates and abs(self.field.margin(mode.mode, path.state) + self.width) > LOCATED * self.width:
            raise ValueError(
                f"required a width whose switches floats resolve, received {self.width:g} at t = {path.time:.6g}"
            )
        self._mode = self.field.following(mode.mode, path.state, self.width)
        if self._mode is not None:
            path.tell(EventKind.CROSS, f"{self.field.mode_name(mode.mode)} | {self.field.mode_name(self._mode)}")
        return None


# ---- smoothing -----------------------------------------------------------------------------------


class _Layer(_Widened, Mode):
    """One mode everywhere: the fields of the modes nearby with weights that vary over the width."""

    place, cells = "", ()

    def next_mode(self, path: Path) -> Mode | EndReason:
        """Itself."""
        self.rate = self.counted(self._mixed)
        return self

    def _mixed(self, t: float, x: Floats) -> Floats:
        """The sum; none where a formula of a mode nearby has no value.

        Raises:
            NoVelocityError: there: the method of the integrator would go on from what is no number.
        """
        rates = np.asarray(sum(weight * velocity(t, x) for velocity, weight in self.field.blend(x, self.width)))
        if not np.isfinite(rates).all():
            raise NoVelocityError(NO_VELOCITY)
        return rates
