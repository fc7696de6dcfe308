"""The simulated machine of a lobe: the default machine with a swing and the encoder of a C axis.

>>> from camtools.part.common import SwingLimits
>>> lobe_machine_text(SwingLimits()).splitlines()[-1]
'range_deg = 30.0'
"""

from __future__ import annotations

from camtools.part.common import SwingLimits
from camtools.sim.camsim import machine_text

_CAM_MACHINE = """\
[encoder]
counts_per_turn = 1000000
[swing]
speed_deg_per_s = {speed!r}
acceleration_deg_per_s2 = {acceleration!r}
range_deg = {range!r}
"""


def lobe_machine_text(limits: SwingLimits) -> str:
    """Return a machine file for lobes: their lift over the angle needs the encoder of a C axis."""
    return machine_text(limits) + _CAM_MACHINE.format(
        speed=min(limits.swing_speed_deg_s, 1e5),
        acceleration=min(max(limits.swing_acceleration_deg_s2, 10.0), 1e8),
        range=limits.swing_deg,
    )
