"""[tool] of a part file: the nose along the axis, the flank below the edge, the wear.

>>> Tool().is_round, Tool(nose_radius_mm=0.8).is_round
(False, True)
"""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, field_validator

from camtools.base.errors import CamtoolsError
from camtools.part.model import TomlTable, wrong

MIN_NOSE_MM = 0.01

ClearanceDeg = Annotated[float, Field(ge=0.1, le=45)]


class Tool(TomlTable):
    """The tool that turns sections: its nose is a circle in the plane of axis and edge, or a point.

    Attributes
    ----------
    nose_radius_mm : float
        Radius of the circle, 0 for a point.
    clearance_deg : float
        Angle between the flank and the direction of cutting, in the plane of a section.
    wear_um : float
        By so much the tip stands back, MATHS.md (112). The table does not depend on it.
    """

    nose_radius_mm: Annotated[float, Field(ge=0, le=100)] = 0.0
    clearance_deg: ClearanceDeg = 7.0
    wear_um: Annotated[float, Field(ge=0, le=1000)] = 0.0

    @field_validator("nose_radius_mm")
    @classmethod
    def _check_nose(cls, value: float) -> float:
        if 0 < value < MIN_NOSE_MM:
            problem = f"must be 0 or at least {MIN_NOSE_MM:g} mm"
            raise wrong("nose", problem, "give 0 for a tool with a point")
        return value

    @property
    def is_round(self) -> bool:
        """Whether the nose is a circle."""
        return self.nose_radius_mm > 0


def check_tracks(tool: Tool, feed_mm: float) -> None:
    """Refuse a feed at which metal stays between the tracks of a round nose.

    Parameters
    ----------
    feed_mm : float
        Distance of neighbouring tracks [mm].

    Raises
    ------
    CamtoolsError
        With the feed below which the tracks meet.
    """
    widest_mm = 2 * tool.nose_radius_mm
    if tool.is_round and feed_mm >= widest_mm:
        problem = f"tracks of a nose of {tool.nose_radius_mm:g} mm do not meet, metal stays"
        raise CamtoolsError([f"feed of {feed_mm:g} mm: {problem}; feed less than {widest_mm:g} mm"])


class SwungTool(TomlTable):
    """The tool that turns lobes: it swings with the normal of the contact.

    Attributes
    ----------
    clearance_deg : float
        Angle between the flank and the profile at the contact.
    heel_mm : float
        Length of the flank; what lies behind its end is ground away further.
    """

    clearance_deg: ClearanceDeg = 7.0
    heel_mm: Annotated[float, Field(ge=0, le=100)] = 5.0
