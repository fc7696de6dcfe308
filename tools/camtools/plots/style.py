"""What all pictures share: size, colours, units, panels, PNG bytes without a date.

>>> nice_limit(0.031), nice_limit(7.0), nice_limit(0.0)
(0.05, 10.0, 1.0)
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from io import BytesIO
from math import floor, log10
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter, NullLocator, ScalarFormatter
from mpl_toolkits.mplot3d.axes3d import Axes3D  # type: ignore[import-untyped]
from PIL import Image

from camtools.base.quantities import Floats

# Okabe and Ito, "Color Universal Design" (2008): distinct for every kind of colour vision.
_HEX = "#0072B2 #E69F00 #009E73 #D55E00 #56B4E9 #CC79A7"
BLUE, ORANGE, GREEN, RED, SKY, PURPLE = _HEX.split()
GREY, PALE = "#666666", "#dddddd"
_SERIES, _STROKES = (BLUE, ORANGE, GREEN, RED, SKY, PURPLE), ("-", "--", ":", "-.")

_DPI, _TITLED_DPI = 100, 120
_MANY_DECADES = {"x": 1e3, "y": 1e4}  # ratio of the ends beyond which numbers stand too close
_FONT: dict[Any, Any] = {
    "font.size": 10,
    "axes.titlesize": 10.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "path.simplify_threshold": 0.5,
}


def stroke_of(i: int) -> dict[str, Any]:
    """Return colour and stroke of the ith of many lines; those of one colour differ in stroke."""
    rounds, place = divmod(i, len(_SERIES))
    return {"color": _SERIES[place], "ls": _STROKES[rounds % len(_STROKES)]}


def new_figure(width_in: float, height_in: float) -> Figure:
    """Return an empty figure that arranges itself."""
    return Figure(figsize=(width_in, height_in), dpi=_DPI, layout="constrained")


def titled_figure(width_in: float, height_in: float, title: str) -> Figure:
    """Return an empty figure of its own, with a title; the pictures of a table are such."""
    figure = Figure(figsize=(width_in, height_in), dpi=_TITLED_DPI, layout="constrained")
    figure.suptitle(title, fontsize=13)
    return figure


def plain_numbers(figure: Figure) -> None:
    """Write every number of every axis in full: no offset and no power of ten beside the axis."""
    for axes in figure.axes:
        for name in ("xaxis", "yaxis", "zaxis"):
            formatter = getattr(axes, name).get_major_formatter() if hasattr(axes, name) else None
            if isinstance(formatter, ScalarFormatter):
                formatter.set_useOffset(False)
                formatter.set_scientific(False)


def _with_palette(image: Image.Image) -> Image.Image:
    """Return a picture of lines with 256 colours, its ground as it was: a third of the bytes."""
    few = image.quantize(256, method=Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)
    palette, ground = few.getpalette() or [], few.getpixel((0, 0))
    assert isinstance(ground, int)
    palette[3 * ground : 3 * ground + 3] = image.getpixel((0, 0))
    few.putpalette(palette)
    return few


def png_of(figure: Figure) -> bytes:
    """Return a figure as PNG; the same figure gives the same bytes."""
    plain_numbers(figure)
    canvas, stream = FigureCanvasAgg(figure), BytesIO()
    # Figure.savefig would arrange the figure twice, with the same result.
    canvas.draw()  # type: ignore[no-untyped-call]
    pixels = np.asarray(canvas.buffer_rgba())  # type: ignore[no-untyped-call]
    image = Image.fromarray(pixels).convert("RGB")
    has_shades = any(axes.images or hasattr(axes, "zaxis") for axes in figure.axes)
    shown = image if has_shades else _with_palette(image)
    shown.save(stream, "png", dpi=(figure.dpi, figure.dpi))
    return stream.getvalue()


def drawing() -> AbstractContextManager[None]:
    """Return the context in which figures are made."""
    return rc_context(_FONT)


def nice_limit(value: float) -> float:
    """Return the smallest 1, 2 or 5 times a power of ten that is not below value; 1 for 0."""
    if value <= 0:
        return 1.0
    power = floor(log10(value))
    steps = (float(f"{step}e{power}") for step in (1, 2, 5, 10))
    return next(step for step in steps if step >= value * (1 - 1e-9))


def nice_floor(value: float) -> float:
    """Return the largest 1, 2 or 5 times a power of ten that is not above a value above 0."""
    power = floor(log10(value))
    steps = (float(f"{step}e{power}") for step in (5, 2, 1))
    return next((step for step in steps if step <= value), float(f"1e{power}"))


def log_axis(axes: Axes, name: str, low: float, high: float) -> None:
    """Make an axis logarithmic, with 1, 2 and 5 written out, of many decades 1 alone."""
    axes.set(**{f"{name}scale": "log", f"{name}lim": (low, high)})
    axis = axes.xaxis if name == "x" else axes.yaxis
    subs = (1.0, 2.0, 5.0) if high / low < _MANY_DECADES[name] else (1.0,)
    axis.set_major_locator(LogLocator(base=10, subs=subs, numticks=40))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_locator(NullLocator())
    axis.set_minor_formatter(NullFormatter())


def angle_axis(axes: Axes, angle: str = "spindle angle from the long axis") -> None:
    """Make x an angle over one turn, in degrees."""
    axes.set(xlim=(0, 360), xticks=range(0, 361, 45), xlabel=f"{angle}, degrees")


Drawers = Mapping[str, Callable[[], Figure]]
"""What draws each picture, by its name."""


def pictures(drawers: Drawers) -> dict[str, bytes]:
    """Return pictures as PNG by their names."""
    with drawing():
        return {name: png_of(draw()) for name, draw in drawers.items()}


def stacked(figure: Figure, names: Sequence[str]) -> list[Axes]:
    """Return panels below each other that share x, each with the name of its y and a grid."""
    panels: list[Axes] = list(figure.subplots(len(names), 1, sharex=True, squeeze=False)[:, 0])
    for axes, name in zip(panels, names, strict=True):
        axes.set_ylabel(name)
        axes.grid(alpha=0.3)
    figure.align_ylabels(panels)
    return panels


def side_by_side(n: int, title: str, size_in: tuple[float, float]) -> tuple[Figure, list[Axes]]:
    """Return a figure with a title and panels beside each other."""
    figure = new_figure(*size_in)
    figure.suptitle(title)
    panels: list[Axes] = list(figure.subplots(1, n, squeeze=False)[0])
    for axes in panels:
        axes.grid(alpha=0.3)
    return figure, panels


def legend_below(figure: Figure, axes: Axes, n_columns: int) -> None:
    """Explain the lines of a panel once for all, below the panels."""
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=n_columns, frameon=False)


def plane(axes: Axes) -> None:
    """Make a panel a plane of equal scales without a frame."""
    axes.set_aspect("equal")
    axes.axis("off")


def space(figure: Figure, place: int, aspect: float) -> Axes3D:
    """Return a panel in space; `place` as of `add_subplot`, aspect: height to width."""
    axes = figure.add_subplot(place, projection="3d")
    assert isinstance(axes, Axes3D)
    axes.set_box_aspect((1, 1, aspect), zoom=0.85)
    axes.view_init(elev=22, azim=-58)
    axes.set(xlabel="x, mm", ylabel="y, mm", zlabel="height, mm")
    return axes


def around(radius: Floats, phi_rad: Floats) -> tuple[Floats, Floats]:
    """Return the plane coordinates of polar ones."""
    return radius * np.cos(phi_rad), radius * np.sin(phi_rad)
