"""A vehicle on its own wheels, as a script or a notebook holds it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nonsmooth.reports.checks.vehicles import VehicleResult
from nonsmooth.reports.interface.array import Wheel, wheel_tables
from nonsmooth.reports.output.entries import table

if TYPE_CHECKING:
    from nonsmooth.symbolic.mechanics.vehicles import Vehicle as ExactVehicle


@dataclass(frozen=True, init=False, repr=False)
class Vehicle:
    """A vehicle on its own wheels: x forward, y to the left, ground at rest.

    Immutable.  Numbers may be int, float (its shortest decimal: 0.1 is one tenth), Fraction, Decimal, SymPy numbers, or
    formulas as text.

    Args:
        wheels: wheels with headings and friction axes of their own, beside or in place of the two sides.
        track: distance of the two sides.
        wheel_base: distance of the first and the last wheel of a side.
        rows: wheels of a side.
        centre_of_mass: in the vehicle's frame.
        left: speed of the wheels of the left side.
        right: speed of the wheels of the right side.
        mu_roll: friction along the rims.
        mu_side: friction across them.
        rule: contact rule; ``ellipse`` unless given.
        **more: other keys of ``[vehicle]``, such as ``measured`` and ``wheel_radius``, and ``name``.

    Attributes:
        document: the tables of a scene file.

    Raises:
        SceneError: for whatever cannot be used, naming key, requirement and what was received.
    """

    document: Mapping[str, Any]

    def __init__(
        self,
        wheels: Sequence[Wheel] = (),
        *,
        mu_roll: Any = 1,
        mu_side: Any = 1,
        rule: str | None = None,
        name: str = "vehicle",
        **more: Any,
    ) -> None:
        document = {
            "name": name,
            "vehicle": table(more),
            "friction": table({"mu_roll": mu_roll, "mu_side": mu_side}),
            "wheel": wheel_tables(wheels, name),
            "contact": table({"rule": rule}),
        }
        self._set(document)

    def _set(self, document: Mapping[str, Any]) -> None:
        object.__setattr__(self, "document", document)
        _ = self.exact  # refuse what cannot be used at once

    @classmethod
    def load(cls, source: str | Path) -> Vehicle:
        """A vehicle from a scene file or a built-in name.

        Raises:
            SceneError: for whatever cannot be used.
        """
        from nonsmooth.symbolic.files.documents import read_document

        document, _, path = read_document(source)
        vehicle = cls.__new__(cls)
        vehicle._set({"name": path.stem, **document})
        return vehicle

    @cached_property
    def exact(self) -> ExactVehicle:
        """The exact vehicle: all numbers in one field."""
        from nonsmooth.symbolic.files.documents import deep_nesting_refused
        from nonsmooth.symbolic.files.vehicle_file import build_vehicle

        name = str(self.document["name"])
        with deep_nesting_refused(name):
            return build_vehicle(dict(self.document), name, Path(f"{name}.toml"))

    def motion(self, *, spin: float | None = None) -> VehicleResult:
        """How it moves under every contact rule.

        Args:
            spin: measured rate of turn at these wheel speeds, from which mu_S/mu_R follows.

        Raises:
            RefusalError: where the motion is not determined.
        """
        result = VehicleResult(self.exact, spin)
        _ = result.own
        return result

    def __repr__(self) -> str:
        return f"Vehicle {self.exact.name!r}: {len(self.exact.scene.wheels)} wheels"
