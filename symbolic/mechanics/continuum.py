"""The continuous idealization of an array: a force field under the whole object instead of a wheel here and there.

Each point p of the object's footprint is pushed by a force per area along ``A (p - p_0)``, of constant size (speed
given) or as large as that vector (speed None).  The kinds ``radial``, ``elliptic``, ``saddle`` and ``spiral`` of a
scene's ``[field]`` are of this form; for others ``matrix`` is None.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

from nonsmooth.symbolic.numbers.number import Number

if TYPE_CHECKING:
    from nonsmooth.symbolic.numbers.plane import Vector


@dataclass(frozen=True)
class Disc:
    """A disc about the centroid (length)."""

    radius: Number


@dataclass(frozen=True)
class PolygonShape:
    """A simple polygon: vertices counterclockwise, measured from the centroid; at heading zero, as given."""

    vertices: tuple[Vector, ...]
    name: str = "polygon"

    @property
    def is_centrally_symmetric(self) -> bool:
        """Whether half a turn maps it onto itself."""
        half, odd = divmod(len(self.vertices), 2)
        pairs = zip(self.vertices[:half], self.vertices[half:], strict=False)
        return not odd and all(a == -c and b == -d for (a, b), (c, d) in pairs)


Footprint: TypeAlias = Disc | PolygonShape


@dataclass(frozen=True)
class ContinuousField:
    """What an array is an approximation of.

    Attributes:
        kind: of the velocity field, as the scene names it.
        matrix: rows of A; None where the field is not linear in the position.
        speed: constant size of the field; None for ``|A (p - p_0)|``.
        centre: ``p_0`` (length).
    """

    kind: str
    matrix: tuple[Vector, Vector] | None
    speed: Number | None
    centre: Vector
