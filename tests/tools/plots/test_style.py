# SPDX-License-Identifier: Apache-2.0
"""What all pictures share: numbers written in full, and none over another."""

from itertools import pairwise

import numpy as np
import pytest

from camtools.plots.style import drawing, log_axis, new_figure, png_of


@pytest.mark.parametrize(
    ("low", "high"), [(45.99998, 46.00002), (0.0, 3e7), (-1e6, 1e6), (1e-6, 2e-6), (9e5, 9.00001e5)]
)
def test_axes_have_no_offset_beside_them(low: float, high: float) -> None:
    """Numbers stand at their ticks in full, whatever the range, in both directions."""
    figure = new_figure(4, 3)
    axes = figure.add_subplot()
    values = np.linspace(low, high, 5)
    axes.plot(values, values)
    assert png_of(figure)[1:4] == b"PNG"
    for axis in (axes.xaxis, axes.yaxis):
        assert axis.get_offset_text().get_text() == ""
        shown = [float(text.get_text().replace("\u2212", "-")) for text in axis.get_ticklabels()]
        assert shown == pytest.approx(axis.get_ticklocs(), rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("high", [0.1, 0.4, 5.0, 49.0, 1e4])
def test_numbers_of_a_logarithmic_axis_stand_apart(high: float) -> None:
    """Across a picture no wider than a forecast's, no number touches its neighbour."""
    with drawing():
        figure = new_figure(5.5, 3.7)
        axes = figure.add_subplot()
        log_axis(axes, "x", 0.05, high)
        png_of(figure)
    boxes = [one.get_window_extent() for one in axes.get_xticklabels(which="both")]
    shown = sorted((box.x0, box.x1) for box in boxes if box.width > 1)
    assert len(shown) >= 2
    assert all(end < begin for (_, end), (begin, _) in pairwise(shown))
