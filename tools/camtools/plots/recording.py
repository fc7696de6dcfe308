"""Pictures of a recording: signals over time, and turns of the spindle over each other.

>>> turns_of(np.array([350.0, 355.0, 0.0, 90.0, 200.0, 359.0, 1.0])).tolist()
[0, 0, 1, 1, 1, 1, 2]
"""

from collections.abc import Mapping
from math import floor, log10

import matplotlib as mpl
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.projections.polar import PolarAxes
from matplotlib.ticker import MaxNLocator

from camtools.base.quantities import UM_PER_MM, Floats
from camtools.plots import style

Columns = Mapping[str, Floats]
ANGLE = "angle_deg"
_RATES = {"mm_per_s": "mm/s", "m_per_s2": "m/s²"}
_UNITS = _RATES | {"um": "µm", "mm": "mm", "deg": "degrees", "rpm": "r/min", "n": "N"}
_COLOURS = (style.BLUE, style.ORANGE, style.GREEN, style.PURPLE, style.SKY, style.RED)
_NOT_DRAWN = ("tick", "config")
_LONG_AXES = ("x_", "z_")  # they travel millimetres, U micrometres
_WIDTH_IN, _PANEL_IN, _MOST_POLAR = 11.0, 1.5, 4
_DUE, _ACTUAL, _ERROR = "u_due_um", "u_actual_um", "following error_um"


def _split(name: str) -> tuple[str, str]:
    """Return a column's name in words, without its unit, and the unit."""
    end = next((unit for unit in _UNITS if name.endswith(f"_{unit}")), "")
    return name.removesuffix(f"_{end}").replace("_", " "), _UNITS.get(end, "")


def _label_of(name: str) -> str:
    return "\n".join(_split(name)).rstrip()


def _panels(columns: Columns) -> list[list[str]]:
    """Return the columns of each panel: those of one axis and one unit share it."""
    panels: dict[tuple[str, str], list[str]] = {}
    for name in columns:
        if name not in _NOT_DRAWN:
            unit = _split(name)[1]
            panels.setdefault((name[0] if unit else name, unit), []).append(name)
    return list(panels.values())


def _with_error(columns: Columns) -> dict[str, Floats]:
    """Add the following error, behind U, where both of its parts are there."""
    if _DUE not in columns or _ACTUAL not in columns:
        return dict(columns)
    ahead = max(i for i, name in enumerate(columns) if name.startswith("u_")) + 1
    items = list(columns.items())
    return dict([*items[:ahead], (_ERROR, columns[_ACTUAL] - columns[_DUE]), *items[ahead:]])


def _in_mm(columns: Columns) -> dict[str, Floats]:
    """Return the columns with those of the long axes in mm."""
    found: dict[str, Floats] = {}
    for name, values in columns.items():
        is_long = name.startswith(_LONG_AXES) and name.endswith("_um")
        found |= {f"{name[:-3]}_mm": values / UM_PER_MM} if is_long else {name: values}
    return found


def set_spans(values: Floats, bit: int) -> list[tuple[int, int]]:
    """Return first and last row of each stretch in which a bit is set."""
    is_set = np.concatenate([[0], values.astype(np.int64) >> bit & 1, [0]])
    edges = np.flatnonzero(np.diff(is_set))
    return [(int(a), int(b) - 1) for a, b in edges.reshape(-1, 2)]


def _draw_bits(axes: Axes, t_ms: Floats, values: Floats, names: Mapping[int, str]) -> None:
    """Draw a bar for every stretch in which a bit is set, a row for every bit that ever is."""
    spans = {bit: set_spans(values, bit) for bit in names}
    rows = [bit for bit in names if spans[bit]]
    step_ms = float(np.diff(t_ms).min()) if t_ms.size > 1 else 1.0
    for row, bit in enumerate(rows):
        bars = [(t_ms[first], t_ms[last] - t_ms[first] + step_ms) for first, last in spans[bit]]
        axes.broken_barh(bars, (row - 0.35, 0.7), color=_COLOURS[row % len(_COLOURS)], lw=0)
    axes.set_yticks(range(max(1, len(rows))), [names[bit] for bit in rows] or ["none"])
    axes.set_ylim(max(1, len(rows)) - 0.5, -0.5)
    axes.axvline(0, color=style.RED, lw=0.8)
    axes.margins(x=0)


def _draw_over_time(axes: Axes, t_ms: Floats, columns: Columns, names: list[str]) -> None:
    is_number = not _split(names[0])[1]
    for name, colour in zip(names, _COLOURS * len(names), strict=False):
        look = "steps-post" if is_number else "default"
        axes.plot(t_ms, columns[name], color=colour, lw=0.9, label=_split(name)[0], drawstyle=look)
    axes.axvline(0, color=style.RED, lw=0.8)
    axes.set_ylabel(_label_of(names[0]) if len(names) == 1 else _split(names[0])[1])
    axes.margins(x=0)
    if is_number:
        axes.yaxis.set_major_locator(MaxNLocator(4, integer=True, min_n_ticks=1))
    if len(names) > 1:
        axes.legend(
            loc="lower left", bbox_to_anchor=(0, 0.95), borderaxespad=0,
            ncols=len(names), fontsize=8, frameon=False,
        )  # fmt: skip


def time_picture(
    t_s: Floats,
    columns: Columns,
    states: Mapping[int, str],
    trigger: str = "",
    bits: Mapping[str, Mapping[int, str]] | None = None,
) -> bytes:
    """Return signals over time from the trigger on as PNG.

    The name of a column ends with its unit. `states` names the numbers in the column state, `bits`
    the bits of each column that is a sum of bits.
    """
    all_of, named = _in_mm(_with_error(columns)), bits or {}
    panels = _panels(all_of)
    with style.drawing():
        figure = style.new_figure(_WIDTH_IN, max(3.0, _PANEL_IN * len(panels) + 0.6))
        grid = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
        for axes, names in zip(grid, panels, strict=True):
            if names[0] in named:
                _draw_bits(axes, t_s * 1e3, all_of[names[0]], named[names[0]])
                axes.set_ylabel(names[0])
                continue
            _draw_over_time(axes, t_s * 1e3, all_of, names)
            if names == ["state"] and states:
                axes.set_yticks(sorted(states), [states[number] for number in sorted(states)])
                axes.set_ylim(min(states) - 0.5, max(states) + 0.5)
        figure.align_ylabels(grid)
        if trigger:
            grid[0].set_title(trigger.replace("_", " "), color=style.RED, loc="right")
        grid[-1].set_xlabel("time from the trigger, ms")
        return style.png_of(figure)


def turns_of(angle_deg: Floats) -> npt.NDArray[np.int64]:
    """Return for each row which turn of the spindle it is of, the first 0."""
    steps = (np.diff(angle_deg) + 180) % 360 - 180
    whole = np.concatenate([angle_deg[:1], angle_deg[:1] + np.cumsum(steps)])
    numbers = np.floor(np.round(whole, 6) / 360).astype(np.int64)
    return numbers - (numbers.min() if len(numbers) else 0)


def _draw_turns(unrolled: Axes, polar: PolarAxes, columns: Columns, name: str) -> None:
    angle, values = columns[ANGLE], columns[name]
    turns = turns_of(angle)
    colours = mpl.colormaps["viridis"](np.linspace(0, 0.9, max(int(turns.max()) + 1, 2)))
    for turn in np.unique(turns):
        of_turn = turns == turn
        here = (angle[of_turn], values[of_turn])
        unrolled.plot(*here, color=colours[turn], lw=0.6, alpha=0.8)
        polar.plot(np.radians(here[0]), here[1], color=colours[turn], lw=0.6, alpha=0.8)
    low, high = float(values.min()), float(values.max())
    room = (high - low) or 1.0
    polar.set_rlim(low - 1.2 * room, high + 0.05 * room)
    digits = max(0, 2 - floor(log10(room)))
    polar.set_rticks([low, high], [])
    # The disc within the inner ring is empty: numbers at the rings would lie over the curves.
    low_text, high_text = f"{low:.{digits}f}", f"{high:.{digits}f}"
    text = high_text if low_text == high_text else f"outer {high_text}\ninner {low_text}"
    paper = {"facecolor": "white", "lw": 0, "pad": 1}
    look = {"ha": "center", "va": "center", "bbox": paper}
    polar.text(0.5, 0.5, text, transform=polar.transAxes, **look)  # type: ignore[arg-type]
    polar.set_xticks(np.radians(range(0, 360, 45)))
    unrolled.set(ylabel=_label_of(name), xlim=(0, 360), xticks=range(0, 361, 45))


def angle_picture(columns: Columns) -> bytes:
    """Return signals over the spindle's angle as PNG, unrolled and polar, turn over turn."""
    all_of = _in_mm(_with_error(columns))
    left_out = {ANGLE, _DUE} if _ERROR in all_of else {ANGLE}  # the error tells more
    names = [n for n in all_of if _split(n)[1] and n not in left_out][:_MOST_POLAR]
    n_turns = int(turns_of(all_of[ANGLE]).max()) + 1
    with style.drawing():
        title = f"{n_turns} turns, from dark to light"
        figure = style.titled_figure(_WIDTH_IN, 3.0 * len(names) + 0.7, title)
        places = figure.add_gridspec(len(names), 2, width_ratios=(2.6, 1))
        for row, name in enumerate(names):
            unrolled = figure.add_subplot(places[row, 0])
            polar = figure.add_subplot(places[row, 1], projection="polar")
            assert isinstance(polar, PolarAxes)
            _draw_turns(unrolled, polar, all_of, name)
        unrolled.set_xlabel("spindle angle in the sense of cutting, degrees")
        return style.png_of(figure)
