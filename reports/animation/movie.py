"""A film as a .gif file: Matplotlib draws every frame, and its writer puts them together."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.analysis.motion.frames import WheelContact
from nonsmooth.reports.animation.film import RATE, Film
from nonsmooth.reports.figures.path import MARKERS, PATH, marked
from nonsmooth.reports.figures.style import (
    INK,
    INKED,
    LABEL,
    POINTS_PER_INCH,
    length_label,
    line_entry,
    mark_entry,
    wrapped,
)
from nonsmooth.reports.figures.wheels import AXIS_COLOR, draw_axis, nearest_gap, placed, wheel_labels
from nonsmooth.symbolic.numbers.plane import in_floats
from nonsmooth.symbolic.numbers.plane_arrays import unit_vectors

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SIZE, DPI = (5.0, 5.6), 100  # inches, and pixels for each
PLANE = 0.13, 0.25, 0.84, 0.66  # left, low, width and height of the plane, in parts of the picture
SLIP, STICK, QUIET = "#D55E00", "#009E73", "0.65"  # of Okabe and Ito's palette, as in all figures
RING = 2.4  # radius of the mark of a wheel that carries, in half-lengths of the rim
HEADING = 7.0  # length of the heading's line in half-lengths of the rim
FAINT = 0.3  # opacity of the slip of a wheel that carries nothing
SLIPPING: Any = {"linewidth": 1.4, "linestyle": (0, (3, 2))}  # the ring of a wheel that carries and slips
WIDTH = 0.0035  # of an arrow's shaft, of the view's width


def gif_bytes(film: Film) -> bytes:
    """The film as the bytes of a .gif file."""
    import matplotlib as mpl
    from matplotlib.animation import PillowWriter

    with tempfile.TemporaryDirectory() as folder, mpl.rc_context({"font.size": LABEL} | INKED):
        file, writer = Path(folder) / "film.gif", PillowWriter(fps=RATE)
        stage = Stage.build(film)
        with writer.saving(stage.figure, str(file), DPI):
            for k in range(len(film.frames)):
                stage.show(k)
                writer.grab_frame()
        return file.read_bytes()


@dataclass(frozen=True, eq=False)
class Stage:
    """The figure of a film, with the pieces that move."""

    film: Film
    figure: Figure
    pieces: dict[str, Any]

    @classmethod
    def build(cls, film: Film) -> Stage:
        """The still pieces as an image, and the moving ones over it as the first frame has them.

        Drawing axes and legend takes a hundred times as long as the pieces that move, so it is done once.
        """
        from matplotlib.figure import Figure

        figure = Figure(figsize=SIZE, dpi=DPI)
        figure.figimage(_still_picture(film), zorder=-1)
        axes = _plane(figure, film)
        axes.set_axis_off()
        places = film.places[film.shown]
        arrows: Any = {"angles": "xy", "scale_units": "xy", "scale": 1, "units": "width", "width": WIDTH}
        zeros = np.zeros(len(places))
        ring: Any = {"facecolor": "none", "zorder": 3}
        pieces = {
            "sticking": axes.scatter([], [], edgecolor=STICK, linewidth=2, **ring),
            "slipping": axes.scatter([], [], edgecolor=SLIP, **SLIPPING, **ring),
            "speeds": axes.quiver(*places.T, zeros, zeros, color=INK, zorder=5, **arrows),
            "slips": axes.quiver(*places.T, zeros, zeros, color=SLIP, zorder=6, **arrows),
            "idle": axes.quiver(*places.T, zeros, zeros, color=SLIP, alpha=FAINT, zorder=3, **arrows),
            "body": axes.fill([0, 0, 0], [0, 0, 0], facecolor=PATH, alpha=0.15, edgecolor=PATH, zorder=2)[0],
            "heading": axes.plot([], [], color=PATH, linewidth=2.2, zorder=7)[0],
            "point": axes.plot([], [], marker="o", color=PATH, markersize=6, zorder=7)[0],
            "time": figure.text(0.13, 0.155, "", ha="left", va="center", fontsize="large"),
            "done": _time_axes(figure, film).plot([], [], color=PATH, linewidth=3)[0],
        }
        stage = cls(film, figure, pieces)
        stage.show(0)
        return stage

    def show(self, k: int) -> None:
        """Move everything to frame k."""
        film, pieces = self.film, self.pieces
        pose, contacts = film.frames.poses[k], film.frames.contacts[k][film.shown]
        places = film.places[film.shown]
        size = self._points(RING * film.rim) ** 2
        for name, kind in (("sticking", WheelContact.STICKS), ("slipping", WheelContact.SLIPS)):
            pieces[name].set_offsets(places[contacts == kind].reshape(-1, 2))
            pieces[name].set_sizes([size])
        slips, idle = film.slip_arrows(k)[film.shown], (contacts == WheelContact.FREE)[:, None]
        arrows = {"speeds": film.speed_arrows(k)[film.shown], "slips": slips * ~idle, "idle": slips * idle}
        for name, vectors in arrows.items():
            pieces[name].set_UVC(*np.nan_to_num(vectors).T)
        tip = pose[:2] + HEADING * film.rim * unit_vectors(pose[2])
        pieces["heading"].set_data([pose[0], tip[0]], [pose[1], tip[1]])
        pieces["point"].set_data([pose[0]], [pose[1]])
        if film.outline is not None:
            pieces["body"].set_xy(placed(film.outline, pose))
        time = float(film.frames.times[k])
        pieces["time"].set_text(f"t = {time:#.4g}{film.scene.units.after_time}")
        pieces["done"].set_data([0, time], [0, 0])

    def _points(self, length: float) -> float:
        """A length of the plane in points of the figure, as a diameter."""
        return 2 * length * _scale(self.film) * POINTS_PER_INCH


def _scale(film: Film) -> float:
    """Inches of the figure for each unit of length of the plane."""
    left, right, low, high = film.view
    return min(PLANE[2] * SIZE[0] / (right - left), PLANE[3] * SIZE[1] / (high - low))


def _plane(figure: Figure, film: Film) -> Any:
    """Axes of the plane, at the same place in every figure."""
    axes = figure.add_axes(PLANE)
    left, right, low, high = film.view
    axes.set(xlim=(left, right), ylim=(low, high), aspect="equal")
    return axes


def _time_axes(figure: Figure, film: Film) -> Any:
    axes = figure.add_axes((0.37, 0.13, 0.6, 0.05))
    axes.set(xlim=(0, film.duration or 1.0), ylim=(-1, 1))
    axes.set_axis_off()
    return axes


def _still_picture(film: Film) -> Any:
    """What does not move, as an image (rows, columns, 4)."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=SIZE, dpi=DPI)
    axes, units = _plane(figure, film), film.scene.units
    axes.set(xlabel=length_label("x", units), ylabel=length_label("y", units))
    figure.text(0.5, 0.985, wrapped(film.title), ha="center", va="top", fontsize="medium", parse_math=False)
    for k in film.shown:
        (x, y), (dx, dy), half = film.places[k], film.rims[k], film.rim
        axes.plot([x - half * dx, x + half * dx], [y - half * dy, y + half * dy], color=INK, linewidth=4, zorder=4)
        if film.scene.wheels[k].axis is not None:
            draw_axis(axes, (x, y), in_floats(film.axes[k]), half)
    _name_wheels(axes, film)
    axes.plot(*film.scene.check.place, marker="+", color=INK, markersize=11, markeredgewidth=1.6)
    axes.plot(*film.trail.T, color=PATH, linewidth=0.8, alpha=0.6, zorder=2)
    _draw_time_line(figure, film)
    _explain(figure, film)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())


def _name_wheels(axes: Any, film: Film) -> None:
    """The names or numbers of the wheels outside of their rings, as their distances allow."""
    from matplotlib.patheffects import withStroke

    (left, right, *_), shown = film.view, [film.scene.wheels[k] for k in film.shown]
    size, labels = wheel_labels(
        shown, nearest_gap(film.places[film.shown], right - left) * (_scale(film) * POINTS_PER_INCH)
    )
    for wheel, label in zip(shown, labels, strict=False):
        x, y = in_floats(wheel.position)
        away = (RING + 0.3) * film.rim
        style: Any = {"ha": "center", "va": "top", "fontsize": size, "fontweight": "bold", "color": INK, "zorder": 8}
        axes.text(x, y - away, label, path_effects=[withStroke(linewidth=2, foreground="white")], **style)


def _draw_time_line(figure: Figure, film: Film) -> None:
    """The line of time with its events, below the picture."""
    axes = _time_axes(figure, film)
    axes.plot([0, film.duration], [0, 0], color=QUIET, linewidth=1.5)
    for event in marked(film.events):
        axes.plot([float(event.t)], [0], marker=MARKERS[event.kind], color=INK, markersize=6, fillstyle="none")
    words = f"{film.pace_text}{'; marks: events' * bool(film.events)}"
    figure.text(0.97, 0.105, words, ha="right", va="center", fontsize="small")


def _explain(figure: Figure, film: Film) -> None:
    """The legend."""
    ring: Any = {"marker": "o", "linestyle": "none", "markerfacecolor": "none", "markersize": 9}
    slips = figure.axes[0].scatter([], [], s=81, edgecolor=SLIP, facecolor="none", label="carries, slips", **SLIPPING)
    entries = [
        line_entry("carries, sticks", markeredgecolor=STICK, markeredgewidth=2, **ring),
        slips,
        mark_entry(r"$\rightarrow$", "slip", color=SLIP, markersize=10),
        mark_entry(r"$\rightarrow$", "speed of the rim", markersize=10),
        mark_entry("+", "checked point", markersize=9),
        line_entry("body and heading", color=PATH, marker="o", linewidth=2),
    ]
    if any(film.scene.wheels[k].axis is not None for k in film.shown):
        entries.append(line_entry("friction axis", color=AXIS_COLOR, linewidth=1.2))
    if len(film.shown) < len(film.places):
        entries.append(line_entry(f"{len(film.shown)} of {len(film.places)} wheels", linestyle="none"))
    figure.legend(handles=entries, loc="lower center", ncols=3, frameon=False, fontsize="small")
