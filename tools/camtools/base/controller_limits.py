"""Texts and units of the controller's refusals, as firmware/base/cam_err.h lists them.

>>> TEXTS["u_speed"]
'U would have to move faster than it can'
>>> needs_text("u_acceleration", 275_000, 250_000)
'needs 275000 mm/s2, limit 250000 mm/s2'
"""

import re
from typing import NamedTuple

from camtools.base.project import ROOT

_ERRORS, _LIMITS = (
    (ROOT / "firmware" / "base" / "cam_err.h").read_text("utf-8").split("#define CAM_ERR_LIMITS(X)")
)
TEXTS: dict[str, str] = dict(re.findall(r'X\((\w+), +-\d+, +"([^"]*)"', _ERRORS))


class Limit(NamedTuple):
    """How a limit of the controller is shown."""

    unit: str
    per_unit: int  # units of the controller
    parameter: str  # that gives the limit; "none"

    def shown(self, value: float) -> str:
        """Return a value of the controller with the unit for people."""
        return f"{value / self.per_unit:.9g} {self.unit}"


LIMITS = {
    name: Limit(unit, int(per_unit), parameter)
    for name, unit, per_unit, parameter in re.findall(
        r'X\((\w+), +"([^"]*)", +(\d+), +(\w+)\)', _LIMITS
    )
}


def needs_text(name: str, needed: float, limit: float) -> str:
    """Return demand and limit of a refusal, in units of the controller, for people."""
    quantity = LIMITS[name]
    return f"needs {quantity.shown(needed)}, limit {quantity.shown(limit)}"
