"""What a report says of the tool: nose, wear, and the clearance that its flank has left.

>>> tool_row({}, Tool(nose_radius_mm=0.8), Heel(0.188, 45.0, 62.0)).value
'nose radius 0.8 mm; clearance angle 7 degrees, required 0.19 (at 45 degrees, height 62 mm)'
"""

from __future__ import annotations

from math import sqrt

from camtools.base.json_text import Json
from camtools.base.quantities import length_text
from camtools.part.tool import Tool
from camtools.report.text import ReportRow
from camtools.skirt.tool.heel import Heel

_BETWEEN = "ridges between tracks"


def _nose_text(nose_mm: float) -> str:
    return f"nose radius {nose_mm:g} mm" if nose_mm else "pointed, without nose radius"


def clearance_text(clearance_deg: float, heel: Heel) -> str:
    """Return the clearance angle of a tool, and what the part requires where.

    >>> clearance_text(7.0, Heel(0.188, 45.0, 62.0))
    'clearance angle 7 degrees, required 0.19 (at 45 degrees, height 62 mm)'
    """
    place = f"{heel.angle_deg:g} degrees, height {heel.z_mm:g} mm"
    return f"clearance angle {clearance_deg:g} degrees, required {heel.needed_deg:.2f} (at {place})"


def tool_row(summary: Json, tool: Tool, heel: Heel) -> ReportRow:
    """Return the line of a report that tells of the tool.

    Parameters
    ----------
    summary : dict
        Of the cut: which tool the simulator had. Where it does not say, that of the table.
    """
    used = summary.get("tool", {})
    nose_mm = used.get("nose_mm", tool.nose_radius_mm)
    words = _nose_text(nose_mm)
    if nose_mm != tool.nose_radius_mm:
        words += f", but the table is made for: {_nose_text(tool.nose_radius_mm)}"
    if used.get("wear_um", 0):
        words += f", worn by {used['wear_um']:g} um"
    return ReportRow(
        "tool",
        f"{words}; {clearance_text(tool.clearance_deg, heel)}",
    )


def track_row(summary: Json, tool: Tool, peak: float = 1.0) -> ReportRow:
    """Return the line of a report that tells what stays between the tracks of the tool.

    The form error is that of the tool's path: ridges do not count in it.

    Parameters
    ----------
    summary : dict
        Of the cut: its feed, and which tool the simulator had.
    peak : float
        The largest feed over the height as a multiple of the mean.

    >>> track_row({"cut": {"feed_mm": 0.1}}, Tool(nose_radius_mm=0.8)).value
    '1.56 µm in theory (nose radius 0.8 mm, feed 0.1 mm); not part of the form error'
    """
    nose_mm = summary.get("tool", {}).get("nose_mm", tool.nose_radius_mm)
    feed_mm = summary["cut"]["feed_mm"] * peak
    if not nose_mm:
        told = "not judged: the tool has no nose radius; give tool.nose_radius_mm"
        return ReportRow(_BETWEEN, told)
    why = f"(nose radius {nose_mm:g} mm, feed {feed_mm:.4g} mm)"
    if feed_mm >= 2 * nose_mm:
        return ReportRow(
            _BETWEEN, f"the tracks do not meet, so metal remains {why}; reduce the feed"
        )
    ridge_um = 1000 * (nose_mm - sqrt(nose_mm**2 - feed_mm**2 / 4))
    told = f"{length_text(ridge_um)} in theory {why}; not part of the form error"
    return ReportRow(_BETWEEN, told)
