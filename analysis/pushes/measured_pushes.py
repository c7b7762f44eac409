"""The measured pushes: what moved how, and which force did it.

The table is ``data/pushes.csv`` beside this file; its README says where it is from.  Motions are
``(dx, dy, rho dtheta)`` and wrenches ``(f_x, f_y, m/rho)``, so that both have one unit and their product is the power.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from nonsmooth.analysis.fields.contact_model import Floats
from nonsmooth.analysis.pushes.supports import RHO

FILE = Path(__file__).parent / "data" / "pushes.csv"
SOURCE = "Zhou, Paolini, Bagnell and Mason 2016 (arXiv 1602.06056), robinzhoucmu/Pushing, Apache-2.0"


@dataclass(frozen=True, eq=False)
class PushLog:
    """The pushes of the block on one set of supports, on one surface.

    Attributes:
        surface: ``plywood`` or ``hardboard``.
        support_set: 1 to 4.
        motions: of the block, shape (n, 3).
        wrenches: of the pusher on the block, shape (n, 3), newton.
    """

    surface: str
    support_set: int
    motions: Floats
    wrenches: Floats

    @property
    def name(self) -> str:
        """Such as ``plywood 1``."""
        return f"{self.surface} {self.support_set}"

    def __len__(self) -> int:
        return len(self.motions)


@cache
def load_pushes() -> tuple[PushLog, ...]:
    """The eight logs, in the order of the table."""
    with FILE.open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    keys = dict.fromkeys((row["surface"], int(row["support_set"])) for row in rows)
    return tuple(_log(surface, number, rows) for surface, number in keys)


def _log(surface: str, support_set: int, rows: list[dict[str, str]]) -> PushLog:
    own = [row for row in rows if (row["surface"], int(row["support_set"])) == (surface, support_set)]
    motions = np.array([[float(row[key]) for key in ("dx_m", "dy_m", "dtheta_rad")] for row in own])
    wrenches = np.array([[float(row[key]) for key in ("fx_N", "fy_N", "moment_over_rho_N")] for row in own])
    return PushLog(surface, support_set, motions * [1.0, 1.0, RHO], wrenches)


def angles(first: Floats, second: Floats) -> Floats:
    """Angles between vectors (n, 3), degrees; of a vector without direction 90."""
    sizes = np.linalg.norm(first, axis=1) * np.linalg.norm(second, axis=1)
    products = (first * second).sum(axis=1)
    cosines = np.divide(products, sizes, out=np.zeros(len(sizes)), where=sizes > 0)
    return np.asarray(np.degrees(np.arccos(np.clip(cosines, -1, 1))))
