"""What an axis needs between two lobes, in the controller's integers: firmware/feasible/cam_lobe_transition.c.

>>> largest = AxisPeaks(8_000_000, 12_000_000, 40_000_000)
>>> GapSums(least_change_nm=0, ratio_max_q20=1 << 20, spindle_ppm=0).first(largest, 100_000)
12000000
"""

from __future__ import annotations

from typing import NamedTuple

_PLACES, _BETWEEN_PPM, _MOST_X_PPM = 20, 1_010_000, 1 << 25
_PER_TURN_PPB = 159_154_944  # 10^9 / 2 pi


class AxisPeaks(NamedTuple):
    """Largest magnitudes over the angle, at the speed ratio of the table."""

    f: int
    f1: int
    f2: int


def _part(a: int, ppm: int) -> int:
    return (a * ppm + 999_999) // 1_000_000


def _step(i: int) -> tuple[int, int, int]:
    """Return the smooth step and the magnitudes of its derivatives at i twentieths, in 1e-6."""
    left = _PLACES - i
    return (
        i**3 * (4000 - 300 * i + 6 * i * i) * 5 // 16,
        30 * i * i * left * left * 25 // 4,
        60 * i * left * abs(left - i) * 125,
    )


class GapSums(NamedTuple):
    """The shortest change between two lobes of a table, and its modulation, MATHS.md (88)."""

    least_change_nm: int  # 0: no lobes between which there is one
    ratio_max_q20: int
    spindle_ppm: int

    def _x_ppm(self, feed_nm: int) -> int:
        per_turn_ppb = feed_nm * _PER_TURN_PPB // self.least_change_nm + 1
        return min(((per_turn_ppb * self.ratio_max_q20) >> 20) // 1000 + 1, _MOST_X_PPM)

    def first(self, peaks: AxisPeaks, feed_nm: int) -> int:
        """Return the bound of the speed over the mean speed: cam_lobe_transition_first()."""
        most, before = peaks.f1, 0
        if self.least_change_nm == 0:
            return most
        f_x = _part(peaks.f, self._x_ppm(feed_nm))
        for i in range(1, _PLACES + 1):
            e, e1, _ = _step(i)
            more = _part(f_x, e1)
            most = max(most, _part(peaks.f1, e) + _part(max(before, more), _BETWEEN_PPM))
            before = more
        return most

    def second(self, peaks: AxisPeaks, feed_nm: int, n_set_points: int) -> int:
        """Return the bound of the acceleration over its square: cam_lobe_transition_second()."""
        most, before = peaks.f2, 0
        if self.least_change_nm == 0:
            return most
        x = self._x_ppm(feed_nm)
        f_x, f1_x = _part(peaks.f, x), _part(peaks.f1, x)
        f_xx, f_xs = _part(f_x, x) * n_set_points, _part(f_x, self.spindle_ppm)
        for i in range(1, _PLACES + 1):
            e, e1, e2 = _step(i)
            more = _part(2 * f1_x + f_xs, e1) + _part(f_xx, e2)
            most = max(most, _part(peaks.f2, e) + _part(max(before, more), _BETWEEN_PPM))
            before = more
        return most
