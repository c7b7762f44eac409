"""Labels of axes with the units of a scene (where it states none, with the kind of quantity), and long titles."""

from __future__ import annotations

import textwrap

from nonsmooth.symbolic.units import Units

TITLE = 64  # characters of a line of a title over one picture
WIDE_TITLE = 100  # over several side by side


def length_label(name: str, units: Units) -> str:
    """``x [mm]``."""
    return f"{name} [{units.length or 'length'}]"


def time_label(name: str, units: Units) -> str:
    """``t [s]``."""
    return f"{name} [{units.time or 'time'}]"


def pose_labels(units: Units) -> tuple[str, str, str]:
    """Of the position and the heading of a body."""
    return length_label("x", units), length_label("y", units), "theta [rad]"


def centre_labels(units: Units) -> dict[str, str]:
    """Of the plane in which the centre of mass lies: keywords of ``Axes.set``."""
    names = {"xlabel": "x of the centre of mass", "ylabel": "y of the centre of mass"}
    return {key: length_label(name, units) for key, name in names.items()}


def wrapped(title: str, width: int = TITLE) -> str:
    """A title on as many lines as it needs."""
    return "\n".join(textwrap.fill(line, width) for line in title.splitlines())
