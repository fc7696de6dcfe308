"""The picture of a frequency response: measured, fitted, believed.

>>> unwrapped_deg(np.array([1j, -1j])).tolist()
[90.0, -90.0]
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes

from camtools.base.quantities import Floats
from camtools.identify.fit import FRICTION, K1, K2, LEAD, second_order
from camtools.identify.identified import Identified
from camtools.identify.multisine import Complexes
from camtools.plots.style import BLUE, GREY, ORANGE, RED, drawing, log_axis, png_of, titled_figure

_DB = 8.685889638
_CURVE_POINTS = 400


class _Line(NamedTuple):
    label: str
    colour: str
    style: str
    response: Complexes


def unwrapped_deg(response: Complexes) -> Floats:
    """Return phases without jumps [degrees]."""
    return np.asarray(np.degrees(np.unwrap(np.angle(response))))


def _slide(found: Identified) -> Complexes:
    """Return what the equation of the fit multiplies the place of U by, at the lines."""
    one, values = found.spectra, found.plain.values
    return np.asarray(1 + values[K1] * one.s + values[K2] * one.s**2, np.complex128)


def measured_response(found: Identified) -> tuple[Complexes, Floats]:
    """Return the response at the lines, friction taken out, and its standard deviation."""
    one = found.spectra
    free = one.y + found.plain.values[FRICTION] * one.friction / _slide(found)
    return free / one.u, one.noise_nm / np.abs(one.u)


def left_by_fit(found: Identified) -> Floats:
    """Return how far the fit is from each line, as a share of it: comparable with its noise.

    What the equation of the fit leaves is larger, by what it multiplies the place of U by.
    """
    return np.asarray(np.abs(found.plain.residual / _slide(found)))


def _curves(found: Identified, believed: Floats, s: Complexes) -> list[_Line]:
    lines = [
        _Line("believed", ORANGE, ":", second_order(s, *believed[[K1, K2, LEAD]])),
        _Line("fit", BLUE, "-", found.plain.response(s)),
    ]
    if found.with_mode is not None and found.has_mode:
        lines.append(_Line("fit with a mode", RED, "--", found.with_mode.response(s)))
    return lines


def _residual(axes: Axes, found: Identified) -> None:
    one = found.spectra
    axes.loglog(
        one.frequency_hz, 100 * left_by_fit(found), ".", color=BLUE, label="left by the fit"
    )
    noise = one.noise_nm / np.abs(one.y)
    axes.loglog(one.frequency_hz, 100 * noise, "-", color=GREY, label="noise")
    axes.set_ylabel("share of the line, %")
    axes.set_xlabel("frequency, Hz")
    axes.legend(loc="upper left", frameon=False)


def bode_png(found: Identified, believed: Floats, title: str) -> bytes:
    """Return the picture as PNG: amplitude, phase, and what the fit leaves.

    `believed`, shape (4,): constants that the controller has, the scale's latency added to its
    lead.
    """
    measured, sigma = measured_response(found)
    hz = found.spectra.frequency_hz
    curve_hz = np.geomspace(hz[0], hz[-1] * 1.1, _CURVE_POINTS)
    with drawing():
        figure = titled_figure(8.0, 8.5, title)
        amplitude, phase, residual = figure.subplots(3, 1, sharex=True, height_ratios=(3, 3, 2))
        for line in _curves(found, believed, 2j * np.pi * curve_hz):
            style = {"color": line.colour, "linestyle": line.style, "label": line.label}
            amplitude.semilogx(curve_hz, _DB * np.log(np.abs(line.response)), **style)
            phase.semilogx(curve_hz, unwrapped_deg(line.response), **style)
        share = sigma / np.abs(measured)
        marks = {"fmt": ".", "color": "black", "markersize": 4, "elinewidth": 0.8, "zorder": 0}
        amplitude.errorbar(
            hz,
            _DB * np.log(np.abs(measured)),
            _DB * share,
            label="measured, without friction",
            **marks,
        )
        phase.errorbar(hz, unwrapped_deg(measured), np.degrees(share), **marks)
        amplitude.set_ylabel("amplitude, dB")
        phase.set_ylabel("phase, degrees")
        amplitude.legend(loc="lower left", frameon=False)
        _residual(residual, found)
        log_axis(residual, "x", 0.9 * hz[0], curve_hz[-1])
        for axes in (amplitude, phase, residual):
            axes.grid(color="#dddddd", linewidth=0.6)
        return png_of(figure)
