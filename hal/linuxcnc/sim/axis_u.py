# SPDX-License-Identifier: Apache-2.0
"""Shows U of camturn below Z in the DRO of AXIS: USER_COMMAND_FILE in lathe.ini.

AXIS executes this file among its own names: `hal`, and `o`, which draws the preview and the DRO.
"""
# ruff: noqa: F821

from typing import Any

hal: Any
o: Any
axis_dro_format, axis_icon_index = o.dro_format, o.idx_for_home_or_limit_icon


def camturn_u() -> tuple[str, bool]:
    """Return the line of U in the unit and format of the other axes, and whether U is homed."""
    u_mm = hal.get_value("camturn.u")
    number = o.dro_mm % u_mm if o.get_show_metric() else o.dro_in % (u_mm / 25.4)
    return f"     U:{number}", hal.get_value("camturn.homed")


o.camturn_shown = camturn_u()  # without camturn AXIS shows the error and ignores the rest


def camturn_dro_format(*status: object) -> tuple[list[int], list[int], list[str], list[str]]:
    """Add U to AXIS's lines, after the axes of LinuxCNC, and to its marks of limit and home."""
    limit, homed, lines, lines_with_offsets = axis_dro_format(*status)
    o.camturn_shown = line, is_homed = camturn_u()
    n_axes = lines_with_offsets.index("")
    lines.insert(n_axes, line)
    lines_with_offsets.insert(n_axes, " " + line)
    return [*limit, 0], [*homed, is_homed], lines, lines_with_offsets


def camturn_icon_index(line: str) -> int:
    """Return the index of a line's marks, -1 for none. AXIS would look for U among its joints."""
    if line.split(":")[0].strip() == "U":
        return len(o.stat.homed) if o.camturn_shown[1] else -1
    return int(axis_icon_index(line))


def user_live_update() -> None:
    """Draw when U has changed. AXIS calls this in each cycle; it draws when its own axes move."""
    if camturn_u() != o.camturn_shown:
        o.redraw_soon()


o.dro_format, o.idx_for_home_or_limit_icon = camturn_dro_format, camturn_icon_index
