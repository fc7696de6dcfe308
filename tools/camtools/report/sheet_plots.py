"""Pictures of a sheet: polar pictures, harmonics, profiles along the axis.

>>> enlarged_text(46.0, 0.0001), enlarged_text(46.0, 0.05)
('140 000-fold', '280-fold')
"""

from math import log10

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle as Disc

from camtools.base.quantities import UM_PER_MM, Floats, length_text, length_unit
from camtools.plots import style
from camtools.report.sheet import LineSheet, SectionSheet, Sheets
from camtools.roundness.section import Circle, RoundWave

_TURN = np.linspace(0, 1, 721)
_ROOM = 0.3  # share of the radius in which deviations are drawn, to both sides
_EDGE, _NAMES = 1.62, 1.48
_LEAST_FLOOR_UM = 1e-5
_DECADES = 3.0
_LIMITS_DEG = 67.5
_RED: dict[str, object] = {"color": style.RED}
_CENTRED = {"ha": "center", "va": "center", "color": style.GREY}
_CIRCLE_STYLE: dict[str, object] = {"color": "black", "lw": 1.2, "ls": "--", "zorder": 5}
_ZONE_STYLE: dict[str, object] = {"color": style.GREY, "lw": 0.9, "ls": ":"}
_RAW_STYLE: dict[str, object] = {"color": style.RED, "lw": 0.6, "alpha": 0.6}
_DRAWN_STYLE: dict[str, object] = {"color": style.BLUE, "lw": 2.4, "alpha": 0.45}


def enlarged_text(radius_mm: float, limit_mm: float) -> str:
    """Return by how much deviations are drawn larger than the radius."""
    factor = int(float(f"{_ROOM * radius_mm / limit_mm:.2g}"))
    return f"{factor:,}-fold".replace(",", " ")


def _text(value_mm: float) -> str:
    return length_text(value_mm * UM_PER_MM)


def _limit_mm(off_mm: Floats) -> float:
    """Return the round deviation that the outer ring stands for [mm]."""
    return style.nice_limit(float(np.nanmax(np.abs(off_mm))) * UM_PER_MM) / UM_PER_MM


def _ring(axes: Axes, turn: Floats, radius: Floats | float, **look: object) -> None:
    """Draw a closed curve by its radii over the turn."""
    phi, radii = 2 * np.pi * turn, np.broadcast_to(radius, turn.shape)
    axes.plot(radii * np.cos(phi), radii * np.sin(phi), **look)  # type: ignore[arg-type]


def _profile(axes: Axes, off_mm: Floats, limit_mm: float, **look: object) -> None:
    turn = np.arange(off_mm.size + 1) / off_mm.size
    _ring(axes, turn, 1 + _ROOM * np.append(off_mm, off_mm[:1]) / limit_mm, **look)


def _polar(axes: Axes, title: str, limit_mm: float, middle: str) -> None:
    """Prepare a polar picture whose rings are apart by half of the limit, and number them."""
    axes.set(aspect="equal", xlim=(-_EDGE, _EDGE), ylim=(-_EDGE, _EDGE), title=title)
    axes.axis("off")
    for share in (-1.0, -0.5, 0.5, 1.0):
        axes.add_patch(Disc((0, 0), 1 + _ROOM * share, fill=False, color=style.PALE, lw=0.7))
    spoke = np.array([1 - _ROOM, 1 + _ROOM])
    for deg in range(0, 360, 45):
        x, y = np.cos(np.radians(deg)), np.sin(np.radians(deg))
        axes.plot(spoke * x, spoke * y, color=style.PALE, lw=0.7)
        axes.text(_NAMES * x, _NAMES * y, f"{deg}°", fontsize=8, **_CENTRED)  # type: ignore[arg-type]
    for share in (-1.13, 1.13):
        at = 1 + _ROOM * share * (1.07 if share < 0 else 1)
        x, y = at * np.cos(np.radians(_LIMITS_DEG)), at * np.sin(np.radians(_LIMITS_DEG))
        sign = "+" if share > 0 else "\N{MINUS SIGN}"
        axes.text(x, y, f"{sign}{_text(limit_mm)}", fontsize=7, **_CENTRED)  # type: ignore[arg-type]
    axes.text(0, 0, middle, fontsize=8, **_CENTRED)  # type: ignore[arg-type]


def _circle_line(
    axes: Axes, circle: Circle, mean_mm: float, limit_mm: float, **look: object
) -> None:
    """Draw a circle that is eccentric by a little: enlarged it is a limacon."""
    phi, off_mm = 2 * np.pi * _TURN, circle.radius_mm - mean_mm
    from_middle = off_mm + circle.x_mm * np.cos(phi) + circle.y_mm * np.sin(phi)
    _ring(axes, _TURN, 1 + _ROOM * from_middle / limit_mm, **look)


def _draw_whole(axes: Axes, sheet: SectionSheet) -> None:
    found = sheet.section
    circle = found.whole.circle
    off_mm = np.where(found.is_measured, found.cut_mm - circle.radius_mm, np.nan)
    limit_mm = _limit_mm(off_mm)
    middle = (
        f"LS circle Ø {2 * circle.radius_mm:.4f} mm\n"
        f"RONt {_text(found.whole.total_mm)} LS\n"
        f"RONt {_text(found.whole_zone.width_mm)} MZ\n"
        f"enlarged {enlarged_text(circle.radius_mm, limit_mm)}"
    )
    _polar(axes, "section as it is", limit_mm, middle)
    _profile(axes, found.drawn_mm - circle.radius_mm, limit_mm, **_DRAWN_STYLE)
    _profile(axes, off_mm, limit_mm, color=style.RED, lw=1.0)
    _circle_line(axes, circle, circle.radius_mm, limit_mm, **_CIRCLE_STYLE)


def _draw_off(axes: Axes, sheet: SectionSheet, upr: int, along: str) -> None:
    found = sheet.section
    raw_mm, filtered_mm = (
        np.where(found.is_measured, values, np.nan) for values in (found.raw_mm, found.filtered_mm)
    )
    limit_mm, mean_mm = _limit_mm(raw_mm), float(found.drawn_mm.mean())
    circle, zone = found.off.circle, found.off_zone
    middle = (
        f"Gauss 1\N{EN DASH}{upr} UPR\n"
        f"RONt {_text(found.off.total_mm)} LS\n"
        f"RONt {_text(zone.width_mm)} MZ\n"
        f"enlarged {enlarged_text(mean_mm, limit_mm)}"
    )
    _polar(axes, f"deviation from the drawing, {along}", limit_mm, middle)
    _ring(axes, _TURN, 1.0, **(_DRAWN_STYLE | {"lw": 1.6}))
    _profile(axes, raw_mm, limit_mm, **_RAW_STYLE)
    _profile(axes, filtered_mm, limit_mm, color=style.RED, lw=1.2)
    _circle_line(axes, circle, mean_mm, limit_mm, **_CIRCLE_STYLE)
    for side in (-0.5, 0.5):
        edge = zone.circle._replace(radius_mm=zone.circle.radius_mm + side * zone.width_mm)
        _circle_line(axes, edge, mean_mm, limit_mm, **_ZONE_STYLE)


def floor_um(waves: list[RoundWave]) -> float:
    """Return where the axis of the amplitudes begins [um]: three decades below the largest."""
    largest_um = max(wave.amplitude for wave in waves) * UM_PER_MM
    power = round(log10(max(largest_um, _LEAST_FLOOR_UM)) - _DECADES)
    return max(_LEAST_FLOOR_UM, float(f"1e{power}"))


def _amplitudes_um(waves: list[RoundWave]) -> Floats:
    return np.array([wave.amplitude for wave in waves]) * UM_PER_MM


def _draw_waves(axes: Axes, sheet: SectionSheet, *, is_oval: bool) -> None:
    """Draw the amplitudes of all waves over a floor that the axis names."""
    waves = sheet.section.off_waves
    amplitude_um, orders = _amplitudes_um(waves), np.array([wave.order for wave in waves])
    factor, unit = length_unit(float(amplitude_um.max()))
    low = floor_um(waves) * factor
    shown = np.maximum(amplitude_um * factor, low)
    axes.bar(orders, shown - low, bottom=low, width=0.7, color=style.BLUE, label="deviation")
    high = max(float(shown.max()), 10 * low)
    if is_oval:
        whole = _amplitudes_um(sheet.section.whole_waves) * factor
        some, look = whole > low, {"ls": "", "marker": "o", "ms": 4, "mfc": "none"}
        axes.plot(orders[some], whole[some], color=style.RED, label="section as it is", **look)  # type: ignore[arg-type]
        high = max(high, float(whole.max()))
    style.log_axis(axes, "y", low, high * 2)
    axes.set_xlim(0.2, orders[-1] + 0.8)
    axes.set_xticks([1, *range(5, int(orders[-1]) + 1, 5)])
    axes.set_xlabel(f"waves per turn (UPR), unfiltered; no bar: below the floor of {low:g} {unit}")
    of_what = "amplitude of\nthe radius, " if is_oval else "amplitude, "
    axes.set_ylabel(of_what + unit)
    axes.legend(frameon=False, loc="lower right", bbox_to_anchor=(1, 1.0), ncols=2)


def _explain(figure: Figure, looks: dict[str, dict[str, object]]) -> None:
    """Explain the lines of the panels once for all, above them."""
    handles = [Line2D([], [], label=name, **look) for name, look in looks.items()]  # type: ignore[arg-type]
    figure.legend(handles=handles, loc="outside upper center", ncols=len(looks), frameon=False)


def draw_section(sheet: SectionSheet, sheets: Sheets) -> Figure:
    """Return the pictures of a section: polar ones above, harmonics below."""
    is_oval = sheets.subject.is_oval
    normal = "along the normal,\nover the direction of the roller"
    along = "radially" if sheets.subject.has_radius else normal
    layout = [["whole", "off"], ["waves", "waves"]] if is_oval else [["off"], ["waves"]]
    figure = style.new_figure(10, 7.6)
    panels = figure.subplot_mosaic(layout, height_ratios=[2.5, 1])  # type: ignore[arg-type]
    if is_oval:
        _draw_whole(panels["whole"], sheet)
    _draw_off(panels["off"], sheet, sheets.upr, along)
    _draw_waves(panels["waves"], sheet, is_oval=is_oval)
    looks = {"drawing": _DRAWN_STYLE, "cut, filtered": _RED, "cut, unfiltered": _RAW_STYLE}
    _explain(figure, looks | {"LS circle": _CIRCLE_STYLE, "MZ circles": _ZONE_STYLE})
    return figure


def _draw_line(axes: Axes, line: LineSheet, limit_um: float) -> None:
    factor, unit = length_unit(limit_um)
    fit_mm = line.off.middle_mm + line.off.slope * (line.z_mm - line.z_mm.mean())
    axes.axvline(0, **_DRAWN_STYLE)  # type: ignore[arg-type]
    axes.plot(line.deviation_mm * UM_PER_MM * factor, line.z_mm, color=style.RED, lw=0.8)
    axes.plot(fit_mm * UM_PER_MM * factor, line.z_mm, **_CIRCLE_STYLE)  # type: ignore[arg-type]
    found = f"STRt {_text(line.off.total_mm)} LS\n{_text(line.off.zone_mm)} MZ"
    axes.set(xlim=(-limit_um * factor, limit_um * factor), title=f"{line.angle_deg:g}°\n{found}")
    axes.set_xlabel(f"off the drawing\n(radius), {unit}")
    axes.grid(alpha=0.3)


def draw_lines(sheets: Sheets) -> Figure:
    """Return the profiles: the cut as it is on the left, deviations from the drawing beside."""
    lines = sheets.lines
    figure = style.new_figure(10, 5.6)
    figure.set_layout_engine("constrained", w_pad=0.12)  # numbers of neighbours keep apart
    widths = [1.4] + [1.0] * len(lines)
    panels = figure.subplots(1, len(widths), sharey=True, width_ratios=widths)
    colours = style.RED, style.GREY, style.SKY, style.ORANGE
    looks = zip(lines, colours, ("-", "-", "--", "--"), strict=False)
    for line, colour, dashes in looks:
        name = f"{line.angle_deg:g}°"
        panels[0].plot(2 * line.radius_mm, line.z_mm, color=colour, lw=1.4, ls=dashes, label=name)
    panels[0].set(xlabel="twice the radius, mm", ylabel="height, mm", title="as it is")
    panels[0].legend(frameon=False, fontsize=8, title="angle")
    panels[0].grid(alpha=0.3)
    worst_um = max(float(np.abs(line.deviation_mm).max()) for line in lines) * UM_PER_MM
    for axes, line in zip(panels[1:], lines, strict=True):
        _draw_line(axes, line, style.nice_limit(worst_um))
    _explain(figure, {"cut, unfiltered": _RED, "drawing": _DRAWN_STYLE, "LS line": _CIRCLE_STYLE})
    return figure
