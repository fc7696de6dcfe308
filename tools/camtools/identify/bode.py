"""The picture of a frequency response: measured, fitted, believed.

>>> unwrapped_deg(np.array([1j, -1j])).tolist()
[90.0, -90.0]
"""

from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes

from camtools.base.quantities import Floats
from camtools.identify.fit import FRICTION, second_order, slide_of
from camtools.identify.identified import Identified
from camtools.identify.recording import Complexes
from camtools.plots import style

_DB = 8.685889638
_CURVE_POINTS = 400
_Curve = tuple[str, str, str, Complexes]  # colour, stroke, name, response


def unwrapped_deg(response: Complexes) -> Floats:
    """Return phases without jumps [degrees]."""
    return np.asarray(np.degrees(np.unwrap(np.angle(response))))


def measured_response(found: Identified) -> tuple[Complexes, Floats]:
    """Return the response at the lines, friction taken out, and its standard deviation."""
    spectra, values = found.spectra, found.plain.values
    free = spectra.y + values[FRICTION] * spectra.friction / slide_of(spectra.s, values)
    return free / spectra.u, spectra.noise_nm / np.abs(spectra.u)


def left_by_fit(found: Identified) -> Floats:
    """Return how far the fit is from each line, as a share of it, comparable with its noise."""
    slide = slide_of(found.spectra.s, found.plain.values)
    return np.asarray(np.abs(found.plain.residual / slide))


def _curves(found: Identified, believed: Floats, s: Complexes) -> Iterator[_Curve]:
    yield style.ORANGE, ":", "believed", second_order(s, believed)
    yield style.BLUE, "-", "fit", found.plain.response(s)
    if found.with_mode is not None and found.has_mode:
        yield style.RED, "--", "fit with a mode", found.with_mode.response(s)


def _residual(axes: Axes, found: Identified) -> None:
    spectra = found.spectra
    left, noise = 100 * left_by_fit(found), 100 * spectra.noise_nm / np.abs(spectra.y)
    axes.loglog(spectra.frequency_hz, left, ".", color=style.BLUE, label="left by the fit")
    axes.loglog(spectra.frequency_hz, noise, "-", color=style.GREY, label="noise")
    axes.set(xlabel="frequency, Hz", ylabel="share of the line, %")
    axes.legend(loc="upper left", frameon=False)


def bode_png(found: Identified, believed: Floats, title: str) -> bytes:
    """Return amplitude, phase and what the fit leaves as PNG, the believed constants with it."""
    measured, sigma = measured_response(found)
    hz = found.spectra.frequency_hz
    curve_hz = np.geomspace(hz[0], hz[-1] * 1.1, _CURVE_POINTS)
    with style.drawing():
        figure = style.titled_figure(8.0, 8.5, title)
        amplitude, phase, residual = figure.subplots(3, 1, sharex=True, height_ratios=(3, 3, 2))
        for colour, stroke, label, response in _curves(found, believed, 2j * np.pi * curve_hz):
            look = {"color": colour, "linestyle": stroke, "label": label}
            amplitude.semilogx(curve_hz, _DB * np.log(np.abs(response)), **look)
            phase.semilogx(curve_hz, unwrapped_deg(response), **look)
        share = sigma / np.abs(measured)
        marks = {"fmt": ".", "color": "black", "markersize": 4, "elinewidth": 0.8, "zorder": 0}
        level, name = _DB * np.log(np.abs(measured)), "measured, without friction"
        amplitude.errorbar(hz, level, _DB * share, label=name, **marks)
        phase.errorbar(hz, unwrapped_deg(measured), np.degrees(share), **marks)
        amplitude.set_ylabel("amplitude, dB")
        phase.set_ylabel("phase, degrees")
        amplitude.legend(loc="lower left", frameon=False)
        _residual(residual, found)
        style.log_axis(residual, "x", 0.9 * hz[0], curve_hz[-1])
        for axes in (amplitude, phase, residual):
            axes.grid(color="#dddddd", linewidth=0.6)
        return style.png_of(figure)
