"""Which answers of a minimizer are proved to be the motion, and how to say in words that some are not.

A float minimizer proves its answer by forces (:meth:`nonsmooth.analysis.minimizers.minimum.Minima.check`).  That the
answer is the motion takes more: the loaded rows with friction must be of rank three, else D is constant along a motion
and its minimizers are a whole line.  What is not proved is never shown as a number.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.fields.contact_model import ContactRows, Floats
from nonsmooth.analysis.minimizers.minimum import Minima
from nonsmooth.symbolic.mechanics.free_motions import free_text, free_twists
from nonsmooth.symbolic.mechanics.scene import Scene

DEPENDENT = 1e-9  # singular value, relative to the largest, of rows that leave a motion free


def proved(minima: Minima) -> NDArray[np.bool_]:
    """Points (m,) at which all minimizers are known: twist and face proved, and every motion resisted."""
    found = minima.check() & resists_every_motion(minima.model, minima.loads)
    for k in minima.faces:
        found[k] &= minima[k].check()
    return found


def resists_every_motion(model: ContactRows, loads: Floats) -> NDArray[np.bool_]:
    """Whether the loaded rows with friction are of rank three, at loads (m, n); shape (m,)."""
    limited = (model.limits(loads) > 0).reshape(len(loads), -1)
    _, first, which = np.unique(np.packbits(limited, axis=1), axis=0, return_index=True, return_inverse=True)
    sizes = np.abs(model.rows).max(axis=0)
    units = model.rows / np.where(sizes > 0, sizes, 1.0)
    full = [np.linalg.matrix_rank(units[rows], rtol=DEPENDENT) == 3 if rows.any() else False for rows in limited[first]]
    return np.array(full, dtype=bool)[which.reshape(-1)]


def minima_without_proof(found: NDArray[np.bool_]) -> str:
    """In words, how many of so many minima are not proved; empty where all are."""
    missing = int(np.count_nonzero(~found))
    return f"{missing} of {len(found)} minima without proof" if missing else ""


def free_motions(scene: Scene) -> str:
    """In words, the motions that no row with friction resists; empty where there are none."""
    return free_text(free_twists(scene))
