r"""Outlines of sections: points in Cartesian coordinates, in the order in which they were drawn.

Their x points to the drawing's angle 0, y to 90 degrees. Seen from the centre an outline runs round
once, in either sense, and never turns back: then each angle has one radius.

>>> corners = (40, 0), (40, 30), (0, 30), (-40, 30), (-40, 0), (-40, -30), (0, -30), (40, -30)
>>> rows = "".join(f"{x + 5},{y}\n" for x, y in (*corners, corners[0]))
>>> found, rows = polar_points(NumberTable("x_mm,y_mm\n" + rows, "a.csv", 9), (5.0, 0.0))
>>> found[0].round(2).tolist()
[0.0, 36.87, 90.0, 143.13, 180.0, 216.87, 270.0, 323.13]
>>> found[2].round(9).tolist(), rows.size
([40.0, 50.0, 30.0, 50.0, 40.0, 50.0, 30.0, 50.0], 8)
"""

from itertools import pairwise

import numpy as np

from camtools.base.number_table import Column, NumberTable
from camtools.base.quantities import DEG_PER_TURN, Floats, Ints
from camtools.table.points import MM_PER_INCH, check_apart, most_step_deg

_SAME_MM = 1e-6  # of the first and the last point of a closed outline
_KINDS = {axis: {f"{axis}_mm": 1.0, f"{axis}_inch": MM_PER_INCH} for axis in "xy"}
_NAMES = {name for units in _KINDS.values() for name in units}


def is_outline(table: NumberTable) -> bool:
    """Return whether a header names Cartesian coordinates."""
    return not _NAMES.isdisjoint(table.names)


@np.errstate(over="ignore")  # a point may be beyond all radii
def polar_points(table: NumberTable, centre_mm: tuple[float, float]) -> tuple[Floats, Ints]:
    """Return angle [deg], height and radius [mm] of outlines, (3, n), and the row of each point.

    Without a column `z_mm` there is one outline, at height 0. Raises InputError with the line: not
    closed, not round the centre, turning back as seen from it, or a height in two places.
    """
    columns = table.columns(_KINDS, "x_mm,y_mm,z_mm")
    if "z_mm" in table.names:
        columns.append(Column(table.names.index("z_mm")))
    x, y, *more = table.values(columns)
    z = more[0] if more else np.zeros(x.size)
    check_apart(z, table.file)
    off = x - centre_mm[0], y - centre_mm[1]
    polar = np.stack([np.mod(np.degrees(np.arctan2(*off[::-1])), DEG_PER_TURN), z, np.hypot(*off)])
    edges = np.flatnonzero(np.diff(z)) + 1
    listed, kept = set[float](), np.ones(z.size, dtype=bool)
    for low, high in pairwise([0, *edges.tolist(), z.size] if z.size else []):
        if z[low] in listed:
            remedy = "list all points of a height together"
            raise table.refusal(low, f"height {z[low]:g} mm appears again", remedy)
        listed.add(float(z[low]))
        ends_mm = np.hypot(x[high - 1] - x[low], y[high - 1] - y[low])
        kept[high - 1] = high - low == 1 or ends_mm > _SAME_MM
        rows = np.arange(low, high)[kept[low:high]]
        _check(table, polar[:, rows], rows, centre_mm)
    return polar[:, kept], np.flatnonzero(kept)


def _check(table: NumberTable, polar: Floats, rows: Ints, centre_mm: tuple[float, float]) -> None:
    """Refuse an outline that is not closed or not star-shaped as seen from the centre."""
    angle_deg, radius_mm = polar[0], polar[2]
    seen = f"seen from the centre ({centre_mm[0]:g}, {centre_mm[1]:g})"
    steps = np.mod(np.diff(angle_deg, append=angle_deg[0]) + 180, DEG_PER_TURN) - 180
    turns = round(float(steps.sum()) / DEG_PER_TURN)
    forward = steps if turns >= 0 else -steps
    remedy = "give the points of one outline in order, each once, or set piston.section.centre_mm"
    if abs(turns) != 1 or not radius_mm.min() > 0:
        problem = f"{seen} the outline that ends here does not run round it once"
        raise table.refusal(int(rows[-1]), problem, remedy)
    back = np.flatnonzero(forward[:-1] <= 0)
    if back.size:
        i = int(back[0]) + 1
        problem = f"{seen} the outline turns back at this point, so it is not star-shaped"
        raise table.refusal(int(rows[i]), problem, remedy)
    if not 0 < forward[-1] <= most_step_deg(rows.size):
        problem = (
            f"the outline is not closed: {seen} it ends at {angle_deg[-1]:.6g} degrees, and began "
            f"at {angle_deg[0]:.6g}"
        )
        raise table.refusal(int(rows[-1]), problem, "give points all around, or repeat the first")
