"""Normal forces in floats, for many centres of mass at once (total weight 1).

Elastic loads exist inside the support polygon, its border included; outside none exist, and for collinear wheels they
are undetermined.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.analysis.cells.loads import UNKNOWN, LoadError, TipsThereError
from nonsmooth.analysis.fields.contact_model import ContactModel
from nonsmooth.analysis.loads.spring_loads import spring_loads
from nonsmooth.symbolic.mechanics.body import outer_positions, support_polygon
from nonsmooth.symbolic.mechanics.load_model import Arithmetic, carried_loads
from nonsmooth.symbolic.mechanics.springs import EqualSprings
from nonsmooth.symbolic.numbers.plane_arrays import Floats, Indices, Mask, finite_rows, norms, polygon_sides

ON_HULL = 1e-12  # for orthonormal columns: a point closer to the support polygon counts as on it
THIN = 1e-10  # ratio of the array's two widths below which wheels count as collinear
HULLS = 16  # arrays whose support polygons are remembered
DEPENDENT = 1e-12  # relative eigenvalue below which loaded wheels lie on one line
NO_LOAD = 1e-14  # of the weight: what is rounding of zero
BELOW_ZERO = -1e-12  # table loads down to here are rounding of 0; relative to the table's largest entry


def loads_at(model: ContactModel, points: ArrayLike) -> Floats:
    """Normal forces of the model's load rule at centres of mass (m, 2); shape (m, n).

    Raises:
        LoadError: where the scene leaves the loads open; see also :func:`elastic_loads` and :func:`table_loads`.
    """
    if model.unknown_loads:
        raise LoadError(UNKNOWN.format(model.unknown_loads))
    if model.load_table is not None:
        return table_loads(model, points)
    return elastic_loads(model, points) if model.law == EqualSprings() else loads_of_law(model, points)


def table_loads(model: ContactModel, points: ArrayLike) -> Floats:
    """``N_i = r_i . (1, c)`` at centres of mass (m, 2); shape (m, n).

    Raises:
        LoadError: if there is no table or a load is negative.
    """
    if model.load_table is None:
        raise LoadError("required a load table, received elastic loads")
    centres = np.atleast_2d(np.asarray(points, float))
    loads = _affine(centres) @ model.load_table.T
    scale = np.abs(_affine(centres)) @ np.abs(model.load_table).T
    negative = np.argwhere(loads < BELOW_ZERO * scale)
    if len(negative):
        row, wheel = negative[0]
        x, y = centres[row]
        raise LoadError(f"required loads >= 0, received {loads[row, wheel]:.6g} of wheel {wheel + 1} at ({x:g}, {y:g})")
    return np.maximum(loads, 0.0)


def affine_loads(model: ContactModel, carrying: Indices) -> Floats:
    """The forms (n, 3) of the loads of all wheels by (1, c), while the wheels at some places carry.

    Raises:
        LoadError: for wheels that do not fix the loads, as two do.
    """
    middle, radius = _frame(model)
    to_middle = np.array([[1, 0, 0], [-middle[0] / radius, 1 / radius, 0], [-middle[1] / radius, 0, 1 / radius]])
    moments = _affine((model.positions - middle) / radius).tolist()
    forms = model.law.forms(list(map(tuple, moments)), carrying.tolist(), FLOATS)
    if forms is None:
        raise LoadError(f"required three wheels that carry and are not collinear, received {len(carrying)}")
    return np.array(forms) @ to_middle


def loads_of_law(model: ContactModel, points: ArrayLike) -> Floats:
    """Loads of any law that lets wheels lift off, at centres of mass (m, 2), one after the other; shape (m, n).

    Raises:
        LoadError: outside the support polygon, and where no wheels are found that carry.
    """
    elastic = elastic_loads(model, points)  # refuses what any springs do
    (middle, radius), found = _frame(model), []
    moments = [tuple(m) for m in _affine((model.positions - middle) / radius).tolist()]
    for centre, start in zip((np.atleast_2d(np.asarray(points, float)) - middle) / radius, elastic, strict=True):
        loads = carried_loads(
            model.law, moments, frozenset(np.flatnonzero(start > 0).tolist()), centre.tolist(), FLOATS
        )
        if loads is None:
            raise LoadError(f"required loads at all centres of mass, received none at {centre * radius + middle}")
        found.append([value if k in loads[0] else 0.0 for k, value in enumerate(loads[1])])
    return np.maximum(found, 0.0)


def elastic_loads(model: ContactModel, points: ArrayLike) -> Floats:
    """The unique minimizer of ``|N|^2`` at centres of mass (m, 2); shape (m, n).

    Raises:
        LoadError: if a point lies outside the support polygon or the wheels are collinear; names the point.
    """
    centres = np.atleast_2d(np.asarray(points, float))
    middle, radius = _frame(model)
    # orthonormal columns: thin arrays are as well posed as round ones
    moments, triangle = np.linalg.qr(_affine((model.positions - middle) / radius))
    widths = np.abs(np.diag(triangle))[1:]
    if model.wheels < 3 or widths.min() < THIN * widths.max():
        raise LoadError(
            f"required three wheels that are not collinear, received {model.wheels} wheels on one line: "
            "elastic loads are undetermined"
        )
    finite = finite_rows(centres)
    goals = np.linalg.solve(triangle.T, _affine((np.where(finite[:, None], centres, middle) - middle) / radius).T).T
    tips = ~finite | _outside(moments[:, 1:], goals[:, 1:])
    if tips.any():
        x, y = centres[int(tips.argmax())]
        raise TipsThereError(
            f"required centres of mass inside the support polygon, received ({x:g}, {y:g}): the body tips there"
        )
    loads, solved = spring_loads(moments, goals, goals)
    if not solved.all():  # no array is known that does this
        raise LoadError(f"required loads at all centres of mass, found none at {np.count_nonzero(~solved)}")
    return loads


def _inverse(*rows: tuple[float, float, float]) -> list[tuple[float, float, float]]:
    """Where loaded wheels lie on one line (a centre on the border) the least one."""
    columns = np.linalg.pinv(np.array(rows), rcond=DEPENDENT, hermitian=True).T.tolist()
    return [(x, y, z) for x, y, z in columns]


def _sign(load: float) -> int:
    return 0 if abs(load) <= NO_LOAD else 1 if load > 0 else -1


FLOATS: Arithmetic[float] = Arithmetic(float, _inverse, _sign)


def _frame(model: ContactModel) -> tuple[Floats, float]:
    """The middle of the wheels, and how far they are from it."""
    middle = model.positions.mean(axis=0)
    return middle, float(norms(model.positions - middle).max()) or 1.0


def _affine(points: Floats) -> Floats:
    """``(1, x, y)``."""
    return np.column_stack([np.ones(len(points)), points])


def _outside(corners: Floats, points: Floats) -> Mask:
    """Whether points (m, 2) lie outside the convex hull of the corners (n, 2)."""
    sides = hull_sides(corners)
    return np.asarray((points @ sides[:, :2].T + sides[:, 2] > ON_HULL).any(axis=1))


def hull_sides(corners: Floats) -> Floats:
    """Rows ``(n_x, n_y, offset)`` with ``n . p + offset <= 0`` in the hull of corners (n, 2), not all on a line.

    SciPy's hull would take a third of a whole check to import.
    """
    return _hull_sides(np.ascontiguousarray(corners).tobytes())


@lru_cache(maxsize=HULLS)  # a path asks for the loads of one array at thousands of places
def _hull_sides(corners: bytes) -> Floats:
    """The same, of doubles."""
    places = [(x, y) for x, y in np.frombuffer(corners).reshape(-1, 2).tolist()]
    return polygon_sides(np.array(support_polygon(outer_positions(places))))
