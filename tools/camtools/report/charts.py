"""Interactive charts for plotly.js: those of the board without their numbers, and those of U.

>>> figure = following_chart(np.array([[1.0, 359.0], [-2.0, 0.0], [2.0, 3.0], [0.0, 1.0]]))
>>> [trace["name"] for trace in figure["data"]]
['smallest of all turns', 'largest of all turns', 'mean of all turns']
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from camtools.base.quantities import Floats, length_text, length_unit
from camtools.base.text import Json
from camtools.plots.style import BLUE, GREEN, ORANGE, RED, nice_limit
from camtools.report.board import GRID, Board, array, colour_scale, layout, space_figure

_BAND = "rgba(0,158,115,0.25)"  # green, the colour of what is allowed
_NOT_CUT = "rgba(128,128,128,0.3)"


class ChartPanel(NamedTuple):
    """One panel of a chart over the angle: what shall be and, where measured, what was."""

    name: str  # with its unit
    wanted: Floats  # at the angles of the chart
    measured: Floats | None = None  # at the measured angles


class TurnOfU(NamedTuple):
    """U over one turn."""

    title: str
    degrees: Floats
    curves: Sequence[ChartPanel]
    wanted_name: str = "drawing"
    measured_degrees: Floats | None = None
    angle: str = "spindle angle from the long axis"


def slope_of(values: Floats, t_s: Floats, n_ticks: int) -> Floats:
    """Return the slope of values over so many ticks to both sides; NaN at the ends."""
    slope = np.full(values.size, np.nan)
    if values.size > 2 * n_ticks:
        rise, run = (series[2 * n_ticks :] - series[: -2 * n_ticks] for series in (values, t_s))
        slope[n_ticks:-n_ticks] = rise / run
    return slope


def _angle_axis(text: str, **more: Any) -> Json:  # noqa: ANN401
    axis = {"range": [0, 360], "dtick": 45, "gridcolor": GRID, "zeroline": False}
    return axis | {"title": {"text": f"{text}, degrees"}} | more


def _axis(text: str, **more: Any) -> Json:  # noqa: ANN401
    return {"title": {"text": text}, "gridcolor": GRID, "zerolinecolor": GRID} | more


def _across(direction: str, at: float) -> Json:
    """Return a line through the whole chart at a place in a direction."""
    other = "y" if direction == "x" else "x"
    whole = {f"{other}ref": "paper", f"{other}0": 0, f"{other}1": 1}
    return whole | {f"{direction}0": at, f"{direction}1": at}


def map_chart(board: Board, angle: str) -> Json:
    """Return the error map without its numbers."""
    factor, unit = length_unit(board.largest_um)
    limit, n = nice_limit(board.largest_um) * factor, board.cells.turn.shape[1]
    heat = {
        "type": "heatmap",
        "x0": 180 / n,
        "dx": 360 / n,
        "y": np.round(board.cells.z_mm, 4).tolist(),
        "zmin": -limit,
        "zmax": limit,
        "colorscale": colour_scale(),
        "colorbar": {"title": {"text": f"error, {unit}"}},
        "hovertemplate": "angle %{x:.1f}°<br>height %{y:.2f} mm<br>radius %{customdata:.6f} mm<br>"
        f"error %{{z:.4g}} {unit}<extra></extra>",
        "hoverongaps": False,
    }
    axes = {"xaxis": _angle_axis(angle), "yaxis": _axis("height, mm", zeroline=False)}
    margin = {"l": 70, "r": 20, "t": 15, "b": 55}
    mark = {"type": "line", "line": {"width": 1.5, "dash": "dash", "color": "#000"}}
    marks = [mark | _across(direction, 0) for direction in "yx"]  # page.js moves them
    shown = layout(height=390, margin=margin, **axes, shapes=marks)
    return {"data": [heat], "layout": shown | {"plot_bgcolor": _NOT_CUT}}


def section_chart(board: Board) -> Json:
    """Return the section without its numbers: tolerance, drawing, cut."""
    _, unit = length_unit(board.largest_um)

    def line(name: str, colour: str, **more: Any) -> Json:  # noqa: ANN401
        style = {"color": colour, "width": 1.6}
        return {"type": "scatterpolar", "mode": "lines", "name": name, "line": style} | more

    band = {"color": GREEN, "width": 0.5}
    hover = "angle %{theta:.1f}°<br>radius %{customdata[0]:.6f} mm<br>error %{customdata[1]:.4g} "
    hover += unit
    data = [
        line("tolerance", GREEN, showlegend=False, hoverinfo="skip") | {"line": band},
        line("tolerance", GREEN, fill="tonext", fillcolor=_BAND, hoverinfo="skip") | {"line": band},
        line("drawing", BLUE, hoverinfo="skip"),
        line("cut", RED, hovertemplate=hover),
    ]
    radial = {"showticklabels": False, "ticks": "", "gridcolor": GRID, "range": [0, 1.3]}
    round_it = {"radialaxis": radial | {"tickvals": [1], "showline": False}}
    round_it["angularaxis"] = {"gridcolor": GRID, "dtick": 45}
    legend = {"orientation": "h", "y": 1.1, "yanchor": "bottom", "x": 0}
    polar = round_it | {"bgcolor": "rgba(0,0,0,0)"}
    return {"data": data, "layout": layout(height=480, polar=polar) | {"legend": legend}}


def _limits(tolerance: float, direction: str) -> list[Json]:
    """Return lines at both ends of the tolerance, which do not stretch the axis."""
    style = {"type": "line", "line": {"width": 1.5, "dash": "dot", "color": GREEN}}
    at = {f"{direction}ref": "x2" if direction == "x" else "y"}
    return [style | at | _across(direction, side) for side in (-tolerance, tolerance)]


def unrolled_chart(board: Board, angle: str) -> Json:
    """Return the error of a section over the angle without its numbers."""
    factor, unit = length_unit(board.largest_um)
    limit = nice_limit(board.largest_um) * factor
    cut = {"type": "scatter", "mode": "lines", "name": "cut", "line": {"color": RED, "width": 1.4}}
    cut["hovertemplate"] = f"angle %{{x:.1f}}°<br>error %{{y:.4g}} {unit}"
    axes = {"xaxis": _angle_axis(angle), "yaxis": _axis(f"error, {unit}", range=[-limit, limit])}
    lines = _limits(board.tolerance_um * factor, "y")
    return {"data": [cut], "layout": layout(height=340, **axes, shapes=lines)}


def profile_chart(board: Board) -> Json:
    """Return radius and error over the height without their numbers."""
    factor, unit = length_unit(board.largest_um)
    limit = nice_limit(board.largest_um) * factor
    common = {"type": "scatter", "mode": "lines"}
    data = [
        common | {"name": "radius of the drawing", "line": {"color": BLUE}, "xaxis": "x"},
        common | {"name": "error of the cut", "line": {"color": RED, "width": 1.4}, "xaxis": "x2"},
    ]
    data[0]["hovertemplate"] = "height %{y:.2f} mm<br>radius %{x:.6f} mm"
    data[1]["hovertemplate"] = f"height %{{y:.2f}} mm<br>error %{{x:.4g}} {unit}"
    axes = {
        "xaxis": _axis("radius, mm", domain=[0, 0.44], nticks=4, tickangle=0),
        "xaxis2": _axis(f"error, {unit}", domain=[0.56, 1], range=[-limit, limit]),
        "yaxis": _axis("height, mm", zeroline=False),
    }
    lines = _limits(board.tolerance_um * factor, "x")
    return {"data": data, "layout": layout(height=380, **axes, shapes=lines)}


def board_charts(board: Board, angle: str) -> dict[str, Json]:
    """Return the charts of the board by their places in the page."""
    return {
        "error-map": map_chart(board, angle),
        "section": section_chart(board),
        "unrolled": unrolled_chart(board, angle),
        "profile": profile_chart(board),
        "space": space_figure(board),
    }


def following_chart(by_angle: Floats) -> Json:
    """Return the following error over the angle, as of `motion.following_by_angle`."""
    degrees, least, most, mean = by_angle
    factor, unit = length_unit(float(np.abs([least, most]).max(initial=0.0)))
    common = {"type": "scatter", "mode": "lines", "x": array(degrees)}
    common["hovertemplate"] = f"%{{x:.1f}}°: %{{y:.4g}} {unit}"
    thin = common | {"line": {"color": ORANGE, "width": 1}}
    data = [
        thin | {"name": "smallest of all turns", "y": array(least * factor)},
        thin | {"name": "largest of all turns", "y": array(most * factor), "fill": "tonexty"},
        common | {"name": "mean of all turns", "y": array(mean * factor)},
    ]
    data[1]["fillcolor"] = "rgba(230,159,0,0.3)"
    data[2]["line"] = {"color": BLUE, "dash": "dash"}
    axes = {"xaxis": _angle_axis("spindle angle"), "yaxis": _axis(f"following error of U, {unit}")}
    return {"data": data, "layout": layout(height=360, **axes)}


def motion_chart(motion: TurnOfU) -> Json:
    """Return U and what follows from it over one turn, a panel each."""
    n = len(motion.curves)
    data: list[Json] = []
    panels: dict[str, Json] = {}
    for i, curve in enumerate(motion.curves):
        axis = "" if i == 0 else str(i + 1)
        top = 1 - i / n
        panels[f"yaxis{axis}"] = _axis(curve.name, domain=[top - 0.88 / n, top])
        common = {"type": "scatter", "yaxis": f"y{axis}", "showlegend": i == 0}
        style = {"mode": "lines", "line": {"color": BLUE, "width": 1.6}}
        points = {"x": array(motion.degrees), "y": array(curve.wanted)}
        data.append(common | style | points | {"name": motion.wanted_name})
        if curve.measured is not None and motion.measured_degrees is not None:
            marker = {"color": RED, "size": 5, "symbol": "circle-open"}
            style = {"mode": "markers", "marker": marker}
            points = {"x": array(motion.measured_degrees), "y": array(curve.measured)}
            data.append(common | style | points | {"name": "measured on U"})
    last = "y" if n == 1 else f"y{n}"
    axes = {"xaxis": _angle_axis(motion.angle, anchor=last)} | panels
    return {"data": data, "layout": layout(height=180 + 180 * n, **axes)}


def following_sentence(by_angle: Floats) -> str:
    """Return the following error in words."""
    degrees, least, most, _ = by_angle
    size = np.maximum(-least, most)
    at = int(np.argmax(size))
    return (
        f"Following error of U over the spindle angle: {length_text(float(least.min()))} to "
        f"{length_text(float(most.max()))}, the largest at {degrees[at]:.0f}°."
    )


def motion_sentence(motion: TurnOfU) -> str:
    """Return the motion of U in words."""
    peaks = (f"{name}: at most {np.abs(curve).max():.4g}" for name, curve, _ in motion.curves)
    return f"U over one turn, {motion.title}. " + "; ".join(peaks) + "."
