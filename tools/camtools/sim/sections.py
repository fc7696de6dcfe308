r"""What camsim wrote of sections and of lines along the height, as arrays.

>>> import tempfile
>>> with tempfile.TemporaryDirectory() as name:
...     path = Path(name) / "sections.csv"
...     _ = path.write_text(
...         "section,turn,z_mm,radius_mm,deviation_nm\n1,0,5,46,-30\n0,0.25,7,45.9,20\n"
...     )
...     found = read_sections(path)
>>> found.sections[0].deviation_mm.tolist(), found.lines[0].angle_deg
([-3e-05], 90.0)
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from camtools.base.quantities import NM_PER_MM
from camtools.sim.results import GaugedLine, GaugedSection, GaugedSections, read_named

_COLUMNS = ("section", "turn", "z_mm", "radius_mm", "deviation_nm")
_DEG_PER_TURN = 360


def read_sections(path: Path) -> GaugedSections:
    """Return the sections of a CSV file of camsim; without one when nothing was cut."""
    number, turn, z_mm, radius_mm, deviation_nm = read_named(path, _COLUMNS)
    deviation_mm = deviation_nm / NM_PER_MM
    sections = []
    for one in np.unique(number[number > 0]):
        at = number == one
        place = float(z_mm[at][0])
        sections.append(GaugedSection(int(one), place, turn[at], radius_mm[at], deviation_mm[at]))
    lines = []
    for one in np.unique(turn[number == 0]):
        at = (number == 0) & (turn == one)
        angle_deg = float(one) * _DEG_PER_TURN
        lines.append(GaugedLine(angle_deg, z_mm[at], radius_mm[at], deviation_mm[at]))
    return GaugedSections(tuple(sections), tuple(lines))
