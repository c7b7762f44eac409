"""The contacts of some of the wheels of an array."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from nonsmooth.analysis.fields.contact_model import ContactModel


def contacts_of(model: ContactModel, wheels: Sequence[int]) -> ContactModel:
    """The contacts of the wheels at some places in a model; a table of loads stays only with all of its wheels."""
    chosen = list(wheels)
    rows = np.array([[2 * k, 2 * k + 1] for k in chosen]).ravel()
    table = model.load_table
    return replace(
        model,
        rows=model.rows[rows],
        targets=model.targets[rows],
        friction=model.friction[rows],
        cuts=model.cuts[chosen],
        positions=model.positions[chosen],
        rims=model.rims[chosen],
        heads=model.heads[chosen],
        load_table=table if table is None or len(table) != model.wheels else table[chosen],
    )
