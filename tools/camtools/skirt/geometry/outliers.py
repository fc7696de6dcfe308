"""Points of measured sections that are off their neighbours: dust, a slipped probe, a wrong digit.

>>> angle = np.arange(0.0, 360, 10)
>>> values = 0.1 * np.sin(np.radians(angle)) ** 2 + 0.5 * (angle == 40)
>>> [found] = outliers(Sections(np.zeros(1), (angle,), (values,)))
>>> found.words
'the point at 40 degrees, height 0 mm, is 500 um off its neighbours'
"""

from typing import NamedTuple

import numpy as np

from camtools.base.quantities import DEG_PER_TURN, UM_PER_MM, Floats
from camtools.skirt.geometry.section_file import Sections

_LEAST_UM = 1.0  # what is less off is not looked at
_USUAL = 25.0  # an outlier is off by so many medians of its section ..
_SHARE, _USUAL_NEAR = 0.1, 4.0  # .. and without it its neighbours fit within this; at a kink: 1/6
_AROUND = (-2, -1, 1, 2)  # the neighbours of a point

REMEDY_OF_OUTLIERS = "measure this point again, or remove its line"


class Outlier(NamedTuple):
    """A point that a cubic through its four neighbours does not meet."""

    z_mm: float
    angle_deg: float
    off_um: float  # value less that of the cubic

    @property
    def words(self) -> str:
        """Return which point is off, and by how much."""
        place = f"at {self.angle_deg:g} degrees, height {self.z_mm:g} mm"
        return f"the point {place}, is {abs(self.off_um):.4g} um off its neighbours"


def _off(angle_deg: Floats, values: Floats) -> Floats:
    """Return how far each point of a closed section is off the cubic through its neighbours."""
    steps = np.stack([np.mod(np.roll(angle_deg, -k) - angle_deg, DEG_PER_TURN) for k in _AROUND])
    steps -= DEG_PER_TURN * (np.array(_AROUND) < 0)[:, None]
    expected = np.zeros(values.size)
    for i, k in enumerate(_AROUND):
        others = np.delete(steps, i, axis=0)
        weight = np.prod(others / (others - steps[i]), axis=0)
        expected += weight * np.roll(values, -k)
    return values - expected


def _left(angle_deg: Floats, values: Floats, off: float, i: int) -> float:
    """Return how far the points about a point are off when that one is made to fit."""
    without = values.copy()
    without[i] -= off
    about = [(i + k) % values.size for k in _AROUND]
    return float(np.abs(_off(angle_deg, without)[about]).max())


def _outlier(z_mm: float, angle_deg: Floats, values: Floats) -> Outlier | None:
    """Return a section's worst point if it alone is off, else nothing."""
    off = _off(angle_deg, values)
    worst, usual = int(np.abs(off).argmax()), float(np.median(np.abs(off)))
    least = max(_LEAST_UM / UM_PER_MM, _USUAL * usual)
    if abs(off[worst]) <= least:
        return None
    # between uneven angles a neighbour may be off further than the point that is wrong
    near = [(worst + k) % off.size for k in (0, *_AROUND)]
    left = {i: _left(angle_deg, values, float(off[i]), i) for i in near}
    i = min(left, key=lambda place: left[place])
    if abs(off[i]) <= least or left[i] > max(_SHARE * abs(off[i]), _USUAL_NEAR * usual):
        return None
    return Outlier(z_mm, float(angle_deg[i]), float(off[i]) * UM_PER_MM)


def outliers(sections: Sections) -> list[Outlier]:
    """Return the point of each height that is off its neighbours, if any; the worst first."""
    found = [
        outlier
        for z_mm, angle_deg, values in zip(*sections[:3], strict=True)
        if (outlier := _outlier(float(z_mm), angle_deg, values)) is not None
    ]
    return sorted(found, key=lambda outlier: -abs(outlier.off_um))
