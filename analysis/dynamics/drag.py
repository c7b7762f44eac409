"""A little drag, so that the motion of a rule whose twist jumps becomes a continuous field.

Where rollers turn D is linear in pieces, as under rule ``box``: at some loads its minimizers are a whole face, and
beyond them the twist is another one.  Solutions slide along such places (Filippov), which no integrator of smooth
fields can follow.  So drag is added, ``sum_k epsilon sqrt(x_k^2 + g^2)`` over the entries x of ``(v_x, v_y, L omega)``:
smooth, strictly convex, least at rest.  The twist then passes from one to the other while the slope of D along the face
changes by the drag's.  It moves a twist that does not jump by the order of epsilon.  The result is proved as ever: as
the minimizer of D plus drag, whose value is within ``epsilon (|x|_1 + 3 g)`` of the least D.
"""

from __future__ import annotations

import numpy as np

from nonsmooth.analysis.fields.contact_model import ContactModel, ContactRows, Floats

DRAG = 1e-6  # of the friction of the whole weight


def needs_drag(model: ContactModel) -> bool:
    """Whether D is linear in pieces somewhere: a friction set has corners."""
    return bool((model.cuts < 1).any())


def with_drag(model: ContactModel) -> ContactRows:
    """The contacts and three more: along x, along y and around, each with a slip g across that never vanishes."""
    size = float(np.hypot(*(model.positions - model.positions.mean(axis=0)).T).max())
    speed = float(np.abs(model.targets).max()) or 1.0
    rows = np.zeros((6, 3))
    rows[[0, 2, 4], [0, 1, 2]] = 1.0, 1.0, size
    targets = np.tile([0.0, speed], 3)
    return ContactRows(
        np.concatenate([model.rows, rows]),
        np.concatenate([model.targets, targets]),
        np.concatenate([model.friction, np.full(6, model.friction.max())]),
        cuts=np.concatenate([model.cuts, np.ones(3)]),
    )


def loads_with_drag(loads: Floats) -> Floats:
    """The loads (n,), and those of the three more."""
    return np.concatenate([loads, np.full(3, DRAG * loads.sum())])
