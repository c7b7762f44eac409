"""The contacts of an array as arrays of floats: what every numerical minimizer works on.

Row ``2i`` is the roll row of wheel i, row ``2i + 1`` its side row, acting on the spatial twist
``xi = (v, omega)``::

    a_2i   = (d_i, d_i . J p_i)      b_2i   = u_i      friction mu_R
    a_2i+1 = (n_i, n_i . J p_i)      b_2i+1 = 0        friction mu_S        n_i = J d_i

(a wheel with a friction axis apart from its rim has the axis and its normal for ``d_i`` and ``n_i``, and the parts of
``u_i d_i`` along these two for ``u_i`` and 0).
The slip of a row is ``a_k . xi - b_k``.  :class:`ContactRows` is that much and no more, so that general
surface velocities (two targets per wheel) and other weighted fits can be minimized too;
:class:`ContactModel` adds the geometry of the wheels, from which normal forces follow.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NoReturn

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.analysis.cells.contact_rule import Rule, SmoothRule
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.symbolic.mechanics.friction_set import CutEllipse, FrictionSet, float_sets
from nonsmooth.symbolic.mechanics.load_model import LoadModel, UnknownLoads
from nonsmooth.symbolic.mechanics.scene import LoadTable, Scene
from nonsmooth.symbolic.mechanics.springs import EqualSprings, load_model
from nonsmooth.symbolic.messages.notebook import ShortRepr
from nonsmooth.symbolic.numbers.plane_arrays import Floats, are_finite, float_points, norms, row_products, turned


@dataclass(frozen=True, eq=False)
class ContactRows:
    """Constraint rows of n contacts.

    Attributes:
        rows: ``a_k``, shape (2n, 3); the third column has the unit of length.
        targets: ``b_k``, shape (2n,), velocity; or (m, 2n) where each of m points has its own speeds.
        friction: Coulomb coefficient of each row, shape (2n,), at least 0: half-axes of the friction ellipses.
        cuts: share of the half-axis across the rim at which a strip cuts the ellipse of each wheel
            (:class:`nonsmooth.symbolic.mechanics.friction_set.FrictionSet`), shape (n,), above 0 and at most 1; all 1
            unless given.
        shape: of the friction sets, ellipses that a strip may cut unless given.
    """

    rows: Floats
    targets: Floats
    friction: Floats
    cuts: Floats = field(default_factory=lambda: np.ones(0), kw_only=True)
    shape: type[CutEllipse[Any]] = field(default=CutEllipse, kw_only=True)

    def __post_init__(self) -> None:
        for name in ("rows", "targets", "friction", "cuts"):  # own copies, so that nobody else can change them
            array = np.array(getattr(self, name), float)
            if name == "cuts" and not array.size:
                array = np.ones(len(self.rows) // 2)
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        count = len(self.rows)
        if self.rows.shape != (count, 3) or count % 2 or not count:
            raise ValueError(f"required rows of shape (2n, 3), received {self.rows.shape}")
        if self.targets.shape[-1:] != (count,) or self.targets.ndim > 2 or self.friction.shape != (count,):
            shapes = f"{self.targets.shape} and {self.friction.shape}"
            raise ValueError(f"required {count} targets and friction coefficients, received shapes {shapes}")
        if not all(are_finite(a) for a in (self.rows, self.targets, self.friction)):
            raise ValueError("required finite rows, targets and friction, received nan or infinity")
        if (self.friction < 0).any():
            raise ValueError(f"required friction >= 0, received {self.friction.min()}")
        if self.cuts.shape != (count // 2,) or not ((self.cuts > 0) & (self.cuts <= 1)).all():
            raise ValueError(f"required {count // 2} cuts above 0 and at most 1, received {self.cuts.tolist()}")

    @property
    def wheels(self) -> int:
        """Number n of contacts."""
        return len(self.rows) // 2

    @property
    def sets(self) -> CutEllipse[Floats]:
        """The friction sets of all contacts, per unit of load."""
        return self.shape(self.friction[::2], self.friction[1::2], self.cuts)

    @property
    def has_whole_ellipses(self) -> bool:
        """Whether no strip cuts a friction set, and none has another shape."""
        return self.shape is CutEllipse and self.sets.is_whole

    def require_ellipses(self) -> None:
        """Refuse friction sets that a method does not know.

        Raises:
            ValueError: for sets of another shape than ellipses, cut or whole.
        """
        if self.shape is not CutEllipse:
            raise ValueError(f"required friction ellipses, cut or whole, received {self.shape.__name__}")

    def at_point(self, k: int) -> ContactRows:
        """The rows with the speeds of one point."""
        return self if self.targets.ndim == 1 else self.with_targets(self.targets[k])

    def with_targets(self, targets: Floats) -> ContactRows:
        """The same contacts, without their geometry, with other speeds."""
        return ContactRows(self.rows, targets, self.friction, cuts=self.cuts, shape=self.shape)

    def slips(self, twists: ArrayLike) -> Floats:
        """``a_k . xi - b_k`` for twists of shape (..., 3); shape (..., n, 2): (along, across) the axis."""
        slips = np.asarray(twists, float) @ self.rows.T - self.targets
        return slips.reshape(*slips.shape[:-1], self.wheels, 2)

    def checked_loads(self, loads: ArrayLike) -> Floats:
        """Normal forces as an array of shape (m, n).

        Raises:
            ValueError: for another number of wheels, negative loads, nan or infinity.
        """
        checked = np.atleast_2d(np.asarray(loads, float))
        if checked.ndim != 2 or checked.shape[1] != self.wheels:
            raise ValueError(f"required loads of shape (m, {self.wheels}), received {np.shape(loads)}")
        if not (np.isfinite(checked) & (checked >= 0)).all():
            raise ValueError(f"required finite loads >= 0, received {checked.min()}")
        return checked

    def limits(self, loads: ArrayLike) -> Floats:
        """Largest friction forces ``(mu_R N_i, mu_S N_i)`` for loads (..., n); shape (..., n, 2)."""
        return np.asarray(loads, float)[..., None] * self.friction.reshape(-1, 2)


@dataclass(frozen=True, eq=False, repr=False)
class ContactModel(ShortRepr, ContactRows):
    """The rows of an array of wheels together with its geometry.

    Attributes:
        positions: ``p_i``, shape (n, 2), length.
        rims: unit vectors ``d_i``, shape (n, 2).
        load_table: rows ``r_i`` of affine loads ``N_i = r_i . (1, c)``, shape (n, 3); None for other laws.
        heads: ``d_i`` in the frame of the friction axis and its normal, shape (n, 2); (1, 0) where the axis is the rim.
        law: of the loads, if no table says them.
        unknown_loads: which loads are meant where the scene leaves them open; empty where they are known.
    """

    positions: Floats
    rims: Floats
    load_table: Floats | None = None
    unknown_loads: str = ""
    law: LoadModel = field(default_factory=EqualSprings)
    heads: Floats = field(default_factory=lambda: np.ones(0), kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.heads.size:
            object.__setattr__(self, "heads", np.tile([1.0, 0.0], (self.wheels, 1)))

    def on(self, wheels: Sequence[int]) -> ContactModel:
        """The contacts of the wheels at some places, with their loads; a table stays only with all of its wheels.

        Raises:
            ValueError: for a law that does not say what these carry without the others.
        """
        chosen, table, law = list(wheels), self.load_table, self.law.on(wheels)
        if law is None:
            raise ValueError(f"required loads of some wheels without the others, received {self.law.words}")
        rows = np.array([[2 * k, 2 * k + 1] for k in chosen]).ravel()
        return replace(
            self,
            rows=self.rows[rows],
            targets=self.targets[rows],
            friction=self.friction[rows],
            cuts=self.cuts[chosen],
            positions=self.positions[chosen],
            rims=self.rims[chosen],
            heads=self.heads[chosen],
            load_table=table if table is None or len(table) != self.wheels else table[chosen],
            law=law,
        )

    @classmethod
    def build(
        cls,
        positions: ArrayLike,
        rims: ArrayLike,
        surface: ArrayLike,
        friction: ArrayLike,
        load_table: ArrayLike | None = None,
        axes: Sequence[ArrayLike | None] | None = None,
    ) -> ContactModel:
        """Rows from geometry.

        Args:
            positions: ``p_i``, shape (n, 2).
            rims: rim directions of any nonzero length, shape (n, 2).
            surface: surface velocity: speeds ``u_i`` along the rims, shape (n,), or components
                along and across the friction axis, shape (n, 2).
            friction: ``(mu_R, mu_S)`` for all wheels or per wheel, shape (2,) or (n, 2).
            load_table: see the class.
            axes: friction axes of any nonzero length, None for the rim; None for the rims of all wheels.

        Raises:
            ValueError: for shapes that do not fit, values that are not finite, or a rim without direction.
        """
        p, d, u = (np.array(a, float) for a in (positions, rims, surface))
        lengths = norms(d)
        if not (lengths > 0).all():
            raise ValueError(f"required rims of nonzero length, received {d[~(lengths > 0)][0]}")
        with np.errstate(invalid="ignore"):  # of numbers that are not finite, which the class refuses
            d = d / lengths[:, None]
            a, heads = _friction_axes(d, axes)
            frames = np.stack([a, turned(a)], axis=1)
            moments = frames @ turned(p)[..., None]
            targets = u[:, None] * heads if u.ndim == 1 else u
        return cls(
            rows=np.concatenate([frames, moments], axis=2).reshape(-1, 3),
            targets=targets.reshape(-1),
            friction=np.broadcast_to(np.asarray(friction, float), (len(p), 2)).reshape(-1),
            positions=p,
            rims=d,
            load_table=None if load_table is None else np.array(load_table, float),
            heads=heads,
        )

    @property
    def axes(self) -> Floats:
        """Unit vectors along the friction axes, shape (n, 2)."""
        return self.rows[::2, :2]

    @property
    def sides(self) -> Floats:
        """``J d_i``, shape (n, 2)."""
        return turned(self.rims)

    @property
    def speeds(self) -> Floats:
        """Surface speeds ``u_i`` along the rims, shape (n,)."""
        return row_products(self.targets.reshape(-1, 2), self.heads)

    def targets_of(self, speeds: ArrayLike) -> Floats:
        """Right sides ``b_k`` for other speeds along the rims: (..., n) to (..., 2n).

        A speed that no law states (nan) leaves the rows across the rim at zero.
        """
        targets = np.where(self.heads == 0, 0.0, np.asarray(speeds, float)[..., None] * self.heads)
        return targets.reshape(*targets.shape[:-2], -1)

    @property
    def mu_roll(self) -> Floats:
        """Friction along the friction axes, shape (n,)."""
        return self.friction[::2]

    @property
    def mu_side(self) -> Floats:
        """Friction across the friction axes, shape (n,)."""
        return self.friction[1::2] * self.cuts


def _friction_axes(rims: Floats, axes: Sequence[ArrayLike | None] | None) -> tuple[Floats, Floats]:
    """Unit vectors of the friction axes, and the rims in their frames."""
    units, heads = rims.copy(), np.tile([1.0, 0.0], (len(rims), 1))
    for k, axis in enumerate(axes or ()):
        if axis is not None:
            units[k] = np.asarray(axis, float) / np.hypot(*np.asarray(axis, float))
            heads[k] = units[k] @ rims[k], turned(units[k]) @ rims[k]
    return units, heads


def contact_model(scene: Scene) -> ContactModel:
    """The scene in floats, each exact number rounded once."""
    loads = scene.contact.loads
    if isinstance(loads, LoadModel):
        loads = load_model(scene)
    table = loads.rows if isinstance(loads, LoadTable) else None
    directions = float_points(wheel.direction for wheel in scene.wheels)
    speeds = [
        np.hypot(*direction) if wheel.given_speed is None else float(wheel.given_speed)
        for wheel, direction in zip(scene.wheels, directions, strict=True)
    ]
    model = ContactModel.build(
        positions=[[float(x) for x in wheel.position] for wheel in scene.wheels],
        rims=directions,
        surface=speeds,
        friction=[[float(wheel.friction.roll), float(wheel.friction.side)] for wheel in scene.wheels],
        load_table=None if table is None else [[float(x) for x in row] for row in table],
        axes=[None if wheel.axis is None else [float(x) for x in wheel.axis] for wheel in scene.wheels],
    )
    if isinstance(loads, UnknownLoads):
        return replace(model, unknown_loads=loads.words)
    return replace(model, law=loads) if isinstance(loads, LoadModel) and table is None else model


def contacts_under(rule: Rule, scene: Scene) -> ContactModel:
    """The scene in floats; under a rule without cells with the friction sets of that rule, whatever the scene names."""
    model = contact_model(scene)
    if not isinstance(rule, SmoothRule):
        return model
    return with_friction_sets(model, [rule.friction_set(wheel.friction) for wheel in scene.wheels])


def with_friction_sets(model: ContactModel, sets: Sequence[FrictionSet]) -> ContactModel:
    """The contacts with the friction forces that a contact rule allows them."""
    rounded = float_sets(sets)
    friction = np.column_stack([rounded.along, rounded.across]).reshape(-1)
    return replace(model, friction=friction, cuts=rounded.cut, shape=type(rounded))


# ---- friction sets that floats alone know --------------------------------------------------------


class FloatShape(CutEllipse[Any]):
    """A shape that floats alone know: bodies are followed, and whatever proves something refuses it.

    A shape on it writes ``searched``, ``support``, ``gauge``, ``excess``, ``nearest``, ``slip_cone``, ``room``,
    ``rounded_gradient`` and ``rounded_hessian``.  Slips r and s, and what ``support``, ``nearest``, ``excess`` and the
    rounded methods give, are about minus the force; ``gauge``, ``slip_cone`` and ``room`` are about the force.  Zero
    lies inside every set.
    """

    def refuse(self, *asked: Any, **named: Any) -> NoReturn:
        """Say that nothing is proved.

        Raises:
            RefusalError: always.
        """
        shape = type(self).__name__
        raise RefusalError(f"required friction sets with exact forces, received {shape}: nothing is proved of it")

    piece = gradient = bend = holds_strictly = refuse  # what proofs ask for
