"""Sample times of closed-form pieces: ends only where a piece is straight, enough for a drawing where it bends."""

from __future__ import annotations

import math
from typing import Any

from nonsmooth.analysis.trajectories.cell_motion import Free, Rest
from nonsmooth.analysis.trajectories.slides import Slide
from nonsmooth.analysis.trajectories.turns import CornerSpiral

ARC_STEP = math.pi / 36  # turn between samples (radian): a drawn chord leaves its arc by less than 0.1 % of the radius
SLIDE_SAMPLES = 33  # along a slide whose speed varies
SPIRAL_SAMPLES = 129  # over a spiral whose turns accumulate; the first few turns are what can be seen


def sample_times(motion: Free | Slide | Rest | CornerSpiral, span: Any | None) -> tuple[Any, ...]:
    """Times since the start of a piece at which it is sampled, first zero, last ``span`` where that is finite."""
    if isinstance(motion, Slide) and span is None:
        return _approach(motion)
    if span is None:
        return (_zero(motion),)
    zero = span * 0
    if isinstance(motion, Free) and motion.flow.turn:
        return _even(span, max(1, math.ceil(abs(motion.flow.turn) * span / ARC_STEP)))
    bends = isinstance(motion, Slide) and (motion.coefficients[1] or motion.coefficients[3])
    if bends:
        return _even(span, SLIDE_SAMPLES - 1)
    if isinstance(motion, CornerSpiral) and isinstance(span, float):
        return _even(span, SPIRAL_SAMPLES - 1)
    return (zero, span) if span > zero else (zero,)


def _even(span: float, steps: int) -> tuple[float, ...]:
    return (*(span * k / steps for k in range(steps)), span)


def _approach(slide: Slide) -> tuple[float, ...]:
    """Times at which a slide has covered all but 2^-k of the way to the equilibrium it approaches."""
    if slide.stop is None:
        return (0.0,)
    return tuple(slide.time_to(slide.stop * (1 - 2.0**-k)) for k in range(SLIDE_SAMPLES))


def _zero(motion: Free | Rest | Slide | CornerSpiral) -> Any:
    return motion.theta * 0
