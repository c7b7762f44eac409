"""A film as one page: no server, no network, a play button and a slider; with scripts off it shows the start.

The picture is an SVG whose still pieces are written here; the page's script moves the others frame by frame.  All
coordinates are those of the picture, in units of its view box.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence

import numpy as np

from nonsmooth.analysis.motion.frames import WheelContact
from nonsmooth.proofs.findings import Record
from nonsmooth.reports.animation.film import LONGEST_ARROW, Film
from nonsmooth.reports.figures.path import marked
from nonsmooth.reports.figures.style import length_label
from nonsmooth.reports.figures.wheels import AXIS
from nonsmooth.reports.formats.html import script_hash, template_part
from nonsmooth.symbolic.numbers.number_text import float_text
from nonsmooth.symbolic.numbers.plane_arrays import Floats, are_finite

WIDE = 1000.0  # width of the frame in the view box
LEFT, BELOW, BEYOND = 90, 50, 20  # beside it for the numbers at its edges, and on the other sides
ROUNDING = 1e-6  # of the fastest rim: slips below are those of a wheel that sticks
DIGITS = 1  # decimals of a coordinate in the picture
MOST_ROWS = 24  # wheels up to which their numbers stand in a table
RING, HEADING, BODY = 2.4, 7.0, 0.7  # radius of a ring, length of the heading's line, radius of the point, in rims
CLASSES = ("", "slips", "sticks")  # of the ring of a wheel, by its contact
CONTACTS = {WheelContact.FREE: "carries nothing", WheelContact.SLIPS: "slips", WheelContact.STICKS: "sticks"}


def film_page(film: Film, said: Sequence[str] = ()) -> str:
    """The page, ending in a newline.

    Args:
        film: what is shown.
        said: sentences that stand beside it: where the body ends.
    """
    from jinja2 import Environment, StrictUndefined
    from markupsafe import Markup

    picture = _Picture(film)
    script = template_part("film.js")
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    return (
        environment.from_string(template_part("film.html.j2")).render(
            film=film,
            said=said,
            picture=picture,
            style=Markup(template_part("film.css")),
            script=Markup(script),
            script_hash=script_hash(script),
            data=Markup(json.dumps(picture.record(), separators=(",", ":")).replace("<", "\\u003c")),
        )
        + "\n"
    )


class _Picture:
    """What the page draws, in the picture's coordinates."""

    def __init__(self, film: Film) -> None:
        self.film = film
        self.left, right, low, self.high = film.view
        self.scale = WIDE / (right - self.left)
        self.height = round((self.high - low) * self.scale, DIGITS)
        self.rim = film.rim * self.scale
        self.has_table = len(film.shown) <= MOST_ROWS
        self.size = f"{float_text(right - self.left, 3)} wide"
        self.label = length_label("x, y", film.scene.units)
        self.rounding = ROUNDING * float(np.nan_to_num(np.abs(film.frames.speeds)).max(initial=0.0))
        self.speed_unit = f" [{film.scene.units.speed}]" if film.scene.units.speed else ""

    @property
    def _names(self) -> list[str]:
        return [str(wheel.index) for wheel in self.film.scene.wheels]

    @property
    def view_box(self) -> str:
        """The frame, and room for the numbers at its edges."""
        return f"{-LEFT} {-BEYOND} {LEFT + WIDE + BEYOND:g} {BEYOND + self.height + BELOW:g}"

    @property
    def frame(self) -> str:
        """Around what is drawn."""
        return f"M0 0H{WIDE:g}V{self.height:g}H0Z"

    @property
    def ticks(self) -> dict[str, list[Record]]:
        """Along both edges round coordinates, and where they are in the picture."""
        most = WIDE / self.scale / 4
        power = 10.0 ** math.floor(math.log10(most))
        step = max(factor * power for factor in (1, 2, 5) if factor * power <= most)
        low, right = self.high - self.height / self.scale, self.left + WIDE / self.scale
        return {"x": self._marks(self.left, right, step, 0), "y": self._marks(low, self.high, step, 1)}

    def _marks(self, first: float, last: float, step: float, axis: int) -> list[Record]:
        values = step * np.arange(math.ceil(first / step), math.floor(last / step) + 1)
        return [{"at": self._point(np.array([value, value]))[axis], "text": float_text(value, 6)} for value in values]

    @property
    def goal(self) -> list[float]:
        """The checked point."""
        return self._point(np.array(self.film.scene.check.place))

    @property
    def radii(self) -> dict[str, float]:
        """Sizes of marks."""
        return {name: round(size * self.rim, DIGITS) for name, size in (("ring", RING), ("body", BODY))}

    @property
    def wheels(self) -> list[Record]:
        """Place, ends of the rim and of a friction axis of its own, number, and where that is written."""
        rows = []
        for k in self.film.shown:
            place, rim = self._point(self.film.places[k]), self._vector(self.film.rims[k] * self.film.rim)
            side = (place[0] - 3.4 * rim[1], place[1] + 3.4 * rim[0])
            axis = self._vector(AXIS * self.film.rim * self.film.axes[k])
            has_axis = self.film.scene.wheels[k].axis is not None
            contact = CLASSES[self.film.frames.contacts[0, k]]
            rows.append(
                {
                    "index": self._names[k],
                    "contact": contact,
                    "place": place,
                    "ends": _line(place, rim),
                    "axis": _line(place, axis) if has_axis else None,
                    "name": [round(v, DIGITS) for v in side],
                }
            )
        return rows

    @property
    def start(self) -> str:
        """Where the body is at the start, as a transformation."""
        x, y, theta = self.film.frames.poses[0]
        across, down = self._point(np.array([x, y]))
        return f"translate({across} {down}) rotate({round(math.degrees(-theta), 2)})"

    @property
    def trail(self) -> str:
        """The path as points of a line."""
        return " ".join(",".join(map(str, self._point(point))) for point in self.film.trail)

    @property
    def outline(self) -> str:
        """The body's outline about its reference point."""
        corners = self.film.outline
        return "" if corners is None else " ".join(",".join(map(str, self._vector(corner))) for corner in corners)

    @property
    def heading(self) -> float:
        """Length of the heading's line."""
        return round(HEADING * self.rim, DIGITS)

    @property
    def events(self) -> list[Record]:
        """The events that are marked: when, as part of the duration, and what."""
        duration = self.film.duration or 1.0
        return [
            {
                "share": round(float(event.t) / duration, 5),
                "t": float_text(float(event.t), 4),
                "kind": str(event.kind),
                "what": event.surface,
            }
            for event in marked(self.film.events)
        ]

    def record(self) -> Record:
        """What the script needs: everything that moves."""
        film, frames, shown = self.film, self.film.frames, self.film.shown
        return {
            "seconds": film.seconds,
            "unit": film.scene.units.time,
            "times": [float(f"{t:.6g}") for t in frames.times],
            "poses": [[*self._point(pose[:2]), round(math.degrees(-pose[2]), 2)] for pose in frames.poses],
            "contacts": frames.contacts[:, shown].tolist(),
            "words": [CONTACTS[kind] for kind in WheelContact],
            "wheels": [self._names[k] for k in shown],
            "slips": [self._vectors(film.slip_arrows(k)[shown]) for k in range(len(frames))],
            "speeds": self._speeds(),
            "values": [self._values(k) for k in range(len(frames))] if self.has_table else [],
            "events": [event["share"] for event in self.events],
            "head": round(0.9 * self.rim, DIGITS),
            "longest": round(LONGEST_ARROW * self.rim, DIGITS),
        }

    def _speeds(self) -> list[list[list[float] | None]]:
        """Arrows of the rims' speeds, frame by frame; one frame for all where they never change."""
        count = len(self.film.frames) if self.film.is_closed else 1
        return [self._vectors(self.film.speed_arrows(k)[self.film.shown]) for k in range(count)]

    def _values(self, k: int) -> list[list[str]]:
        """Speed, slip along and slip across of every wheel, as the table shows them."""
        frames, shown = self.film.frames, self.film.shown
        rows = np.column_stack([frames.speeds[k][shown], frames.slips[k][shown]])
        return [[_number(value, self.rounding) for value in row] for row in rows]

    def _point(self, point: Floats) -> list[float]:
        x, y = (point[0] - self.left) * self.scale, (self.high - point[1]) * self.scale
        return [round(float(x), DIGITS), round(float(y), DIGITS)]

    def _vector(self, vector: Floats) -> list[float]:
        return [round(float(vector[0]) * self.scale, DIGITS), round(-float(vector[1]) * self.scale, DIGITS)]

    def _vectors(self, vectors: Floats) -> list[list[float] | None]:
        return [self._vector(vector) if are_finite(vector) else None for vector in vectors]


def _line(place: Sequence[float], half: Sequence[float]) -> list[float]:
    """Both ends of a line through a place."""
    (x, y), (dx, dy) = place, half
    return [round(value, DIGITS) for value in (x - dx, y - dy, x + dx, y + dy)]


def _number(value: float, rounding: float) -> str:
    """Three digits; an en dash where there is none, zero for what is rounding."""
    if not math.isfinite(value):
        return "\N{EN DASH}"
    return float_text(value, 3) if abs(value) > rounding else "0"
