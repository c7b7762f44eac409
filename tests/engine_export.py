"""An exported MJCF file in the engine, as anybody would run it: loaded from text, stepped, velocities read."""

from __future__ import annotations

import re

import mujoco
import numpy as np

from nonsmooth.reports.simulations.mjcf import SETTLING
from nonsmooth.symbolic.numbers.plane_arrays import Floats

NUMBER = r"[-+0-9.e]+"


def engine_twist(text: str, seconds: float = SETTLING) -> Floats:
    """``(v_x, v_y, omega)`` of the free joint after settling; its frame has moved by a hundred-thousandth by then."""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    for _ in range(round(seconds / model.opt.timestep)):
        mujoco.mj_step(model, data)
    assert data.ncon == 2 * (model.ngeom - 1)
    return np.array([data.qvel[0], data.qvel[1], data.qvel[5]])


def predicted_twist(text: str) -> Floats:
    """What the file's comment says."""
    (found,) = re.findall(rf"predicted twist \(v_x, v_y, omega\): ({NUMBER}) ({NUMBER}) ({NUMBER})\n", text)
    return np.array([float(value) for value in found])


def error(text: str) -> float:
    """Of the prediction, relative to its largest entry."""
    predicted = predicted_twist(text)
    return float(np.abs(engine_twist(text) - predicted).max() / np.abs(predicted).max())
