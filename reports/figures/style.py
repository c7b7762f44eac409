"""The style of all pictures, stated once: colors, sizes, words with units, titles, legends, views, and their bytes.

A picture is a function that builds a Matplotlib figure from what it shows; those that draw on axes take the axes first.
Matplotlib is imported by the call that needs it.
"""

from __future__ import annotations

import io
import textwrap
import warnings
from collections.abc import Callable, Sequence
from decimal import Decimal
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.mechanics.units import Units
from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact
from nonsmooth.symbolic.numbers.number_text import decimal_text
from nonsmooth.symbolic.numbers.plane import XY
from nonsmooth.symbolic.numbers.plane_arrays import Floats

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.backend_bases import FigureCanvasBase
    from matplotlib.colorbar import Colorbar
    from matplotlib.figure import Figure, SubFigure
    from matplotlib.image import AxesImage
    from matplotlib.lines import Line2D


# ---- colors and sizes ----------------------------------------------------------------------------

INK = "#222222"
# Okabe and Ito's palette (safe for color-blind readers), drawn lightly; white gaps part equal neighbours.
PALETTE = ("#56B4E9", "#E69F00", "#009E73", "#F0E442", "#CC79A7", "#0072B2", "#D55E00", "#999999")
LINES = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#222222", "#999999")  # for thin lines
TINT = 0.45  # opacity of an area
TOLD_APART = PALETTE[:-1]  # grey is for what is not told apart
TIMES = "cividis"  # map of colors of times, safe for color-blind readers
INKED: Any = dict.fromkeys(
    ("text.color", "axes.edgecolor", "axes.labelcolor", "axes.titlecolor", "xtick.color", "ytick.color"),
    INK,
)
PICTURE = 5.2  # inches, both ways: readable in a column of a page and on a phone
LEGEND_LINE = 0.22  # inches for each line of a legend in two columns
LEGEND_ROW = 0.2  # inches that a row of the legend needs below the picture
POINTS_PER_INCH = 72
ROOM = 6  # points above and below: what is laid out before it is drawn is some points off
DOTS = 150  # to an inch, of a picture of dots
LABEL = 9  # points, the size of a label
LARGEST, RESOLUTION = 1e100, 1e-9  # what Matplotlib draws faithfully with floats
TITLE = 48  # characters of a line of a title over one picture
WIDE_TITLE = 100  # over several side by side

TO_SHOW = np.array([1.0, 1.0, 180 / np.pi])  # from poses to what pictures show: headings in degrees

# ---- words ---------------------------------------------------------------------------------------


def start_labels(units: Units) -> dict[str, str]:
    """Of the plane of starts: keywords of ``Axes.set``."""
    return {"xlabel": length_label("x at the start", units), "ylabel": length_label("y at the start", units)}


def length_label(name: str, units: Units) -> str:
    """``x [mm]``; where the scene states no unit, the kind of quantity."""
    return f"{name} [{units.length or 'length'}]"


def time_label(name: str, units: Units) -> str:
    """``t [s]``."""
    return f"{name} [{units.time or 'time'}]"


def square_rate_label(name: str, units: Units) -> str:
    """``V* [mm²/s]``."""
    return f"{name} [{units.length or 'length'}²/{units.time or 'time'}]"


def pose_labels(units: Units) -> tuple[str, str, str]:
    """Of the position and the heading of a body: see :data:`TO_SHOW`."""
    return length_label("x", units), length_label("y", units), "theta [deg]"


def centre_labels(units: Units) -> dict[str, str]:
    """Of the plane in which the centre of mass lies: keywords of ``Axes.set``."""
    names = {"xlabel": "x of the centre of mass", "ylabel": "y of the centre of mass"}
    return {key: length_label(name, units) for key, name in names.items()}


def wrapped(title: str, width: int = TITLE) -> str:
    """A title on as many lines as it needs."""
    return "\n".join(textwrap.fill(line, width) for line in title.splitlines())


# ---- figures, titles and legends -----------------------------------------------------------------


def new_figure(width: float, height: float) -> Figure:
    """An empty figure of a size in inches."""
    from matplotlib.figure import Figure
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    return Figure(figsize=(width, height), layout=ConstrainedLayoutEngine(h_pad=ROOM / POINTS_PER_INCH))


def title_axes(axes: Axes, title: str) -> None:
    """A title over one picture, which may hold any name of a scene."""
    axes.set_title(wrapped(title), parse_math=False, wrap=True)


def title_figure(figure: Figure, title: str, width: int = WIDE_TITLE) -> None:
    """A title over several pictures side by side."""
    figure.suptitle(wrapped(title, width), fontsize="medium", parse_math=False)


def legend_below(figure: Figure, entries: Sequence[Artist] | None = None, columns: int = 2, **style: Any) -> None:
    """A legend below all axes, of these entries or of what the axes name themselves; none where that is nothing."""
    if entries is None and not any(axes.get_legend_handles_labels()[1] for axes in figure.axes):
        return
    handles = {} if entries is None else {"handles": entries}
    figure.legend(loc="outside lower center", ncols=columns, frameon=False, **handles, **style)


def figure_with_legend(draw: Callable[[Axes], None], size: XY = (6.4, 6.0)) -> Figure:
    """One picture with a legend below it, of a size in inches."""
    figure = new_figure(*size)
    draw(figure.add_subplot())
    legend_below(figure)
    return figure


def mark_entry(marker: str, label: str, **style: Any) -> Line2D:
    """An entry of a legend for a mark."""
    from matplotlib.lines import Line2D

    return Line2D([], [], **{"linestyle": "none", "color": INK, "marker": marker, "label": label, **style})


def line_entry(label: str, **style: Any) -> Line2D:
    """An entry of a legend for a line."""
    from matplotlib.lines import Line2D

    return Line2D([], [], label=label, **style)


# ---- views ---------------------------------------------------------------------------------------


def view_square(axes: Axes, middle: XY, half: float) -> None:
    """Equal axes in a square of this half-width."""
    x, y = middle
    axes.set(xlim=(x - half, x + half), ylim=(y - half, y + half), aspect="equal")


def view_centre(axes: Axes, scene: Scene, half: float) -> None:
    """Equal axes for the centre of mass, in a square of this half-width about the checked point."""
    view_square(axes, scene.check.place, half)
    axes.set(**centre_labels(scene.units))


def draw_checked_point(axes: Axes, scene: Scene) -> None:
    """A cross."""
    axes.plot(*scene.check.place, marker="+", color=INK, markersize=11, markeredgewidth=1.6, zorder=5)


def plain_number(value: float, place: int | None = None) -> str:
    """A tick of a scale: three digits, four where it is no small number, written out, and no offset of its own."""
    text = f"{value:.3g}" if abs(value) < 10 else f"{value:.4g}"
    if "e" in text and 1e-5 <= abs(value) < 1e7:
        text = f"{Decimal(text):f}"
    return text


def draw_bar(figure: Figure | SubFigure, shown: Any, label: str, **where: Any) -> Colorbar:
    """A scale of colors with few ticks in plain numbers; ``where`` is as for Matplotlib's colorbar."""
    from matplotlib.ticker import FuncFormatter, MaxNLocator

    ticks = where.pop("ticks", None)
    bar = figure.colorbar(shown, format=FuncFormatter(plain_number), ticks=ticks or MaxNLocator(6), **where)
    bar.set_label(label)
    return bar


def grid_extent(starts: Floats) -> tuple[float, float, float, float]:
    """Left, right, low and high of the image of a square grid of points (m, 2): half a step beyond the outermost."""
    count = grid_side(starts)
    (left, low), (right, high) = starts.min(axis=0), starts.max(axis=0)
    dx, dy = (right - left) / (count - 1) / 2, (high - low) / (count - 1) / 2
    return float(left - dx), float(right + dx), float(low - dy), float(high + dy)


def grid_side(starts: Floats) -> int:
    """How many points of a square grid are in a row."""
    return round(len(starts) ** 0.5)


def draw_grid(axes: Axes, starts: Floats, values: Any, **colors: Any) -> AxesImage:
    """An image with a pixel for each point of a square grid; ``values`` are numbers (m) or colors (m, 3 or 4)."""
    count = grid_side(starts)
    pixels = values.reshape(count, count, *values.shape[1:])
    return axes.imshow(pixels, origin="lower", extent=grid_extent(starts), interpolation="nearest", **colors)


def require_drawable(scene: Scene) -> None:
    """Refuse squares that floats cannot draw faithfully.

    Raises:
        SceneError: where the square is too large, too small or too far away.
    """
    radius, far = abs(scene.check.half_width), max(map(abs, scene.check.place))
    if not (1 / LARGEST <= radius <= LARGEST and far * RESOLUTION <= radius):
        expected = f"for a picture, a radius of {1 / LARGEST:g} to {LARGEST:g}, and {RESOLUTION:g} of the coordinates"
        raise SceneError(scene.origin, "check.radius", expected, StatedFact(decimal_text(scene.check.radius, 6)))


# ---- bytes ---------------------------------------------------------------------------------------


def drawn(build: Callable[..., Figure], *shown: Any) -> Callable[[str], bytes]:
    """What draws a picture of something as the bytes of a file, by the ending of its name."""
    return lambda suffix: figure_bytes(lambda: build(*shown), suffix)


def figure_bytes(build: Callable[[], Figure], suffix: str) -> bytes:
    """A figure as the bytes of a file; ``suffix`` is one of PICTURES.  Equal input gives equal bytes."""
    import matplotlib as mpl

    stamps = {".svg": {"Date": None}, ".png": {"Software": None}, ".pdf": {"CreationDate": None}}
    stream = io.BytesIO()
    with mpl.rc_context({"svg.hashsalt": "nonsmooth", "font.size": LABEL} | INKED), warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing")  # a scene's name may use any script
        figure = build()
        lay_out(figure, suffix)
        figure.savefig(stream, format=suffix[1:], dpi=DOTS, metadata=stamps[suffix])
    return stream.getvalue()


def lay_out(figure: Figure, suffix: str) -> None:
    """Give axes and legends their room, as they will be in such a file, and keep it.

    Matplotlib does so as it saves, and to do it draws the whole figure once more: a quarter of the time.
    """
    engine = figure.get_layout_engine()
    if engine is None:
        return
    _canvas(suffix)(figure)
    figure.set_dpi(DOTS if suffix == ".png" else POINTS_PER_INCH)
    engine.execute(figure)
    if any(axes.title.get_window_extent().y1 > figure.bbox.y1 + 1 for axes in figure.axes):
        engine.execute(figure)  # the first time an axes of fixed shape may come out too large for its title
    figure.set_layout_engine(None)


def _canvas(suffix: str) -> type[FigureCanvasBase]:
    """What measures text as it is drawn in such a file."""
    if suffix == ".pdf":
        from matplotlib.backends.backend_pdf import FigureCanvasPdf

        return FigureCanvasPdf
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    return FigureCanvasAgg if suffix == ".png" else FigureCanvasSVG
