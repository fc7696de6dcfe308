"""What a report says of the tool: nose, wear, and the clearance that its flank has left.

>>> tool_row({}, Tool(nose_radius_mm=0.8), Heel(0.188, 45.0, 62.0)).value
'nose of 0.8 mm; clearance 7 degrees, the sections need 0.19 at 45 degrees, height 62 mm'
"""

from __future__ import annotations

from camtools.base.json_text import Json
from camtools.part.tool import Tool
from camtools.report.text import ReportRow
from camtools.skirt.heel import Heel


def _nose_text(nose_mm: float) -> str:
    return f"nose of {nose_mm:g} mm" if nose_mm else "point"


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
        words += f", the table is made for a {_nose_text(tool.nose_radius_mm)}"
    if used.get("wear_um", 0):
        words += f", worn by {used['wear_um']:g} um"
    rubs = ": it rubs" if heel.needed_deg >= tool.clearance_deg else ""
    return ReportRow(
        "tool",
        f"{words}; clearance {tool.clearance_deg:g} degrees, the sections need "
        f"{heel.needed_deg:.2f} at {heel.angle_deg:g} degrees, height {heel.z_mm:g} mm{rubs}",
    )
