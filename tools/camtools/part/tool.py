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
    """[tool]: [the tool](PISTONS.md#the-tool) that turns sections."""

    nose_radius_mm: float = Field(
        0.0,
        ge=0,
        le=100,
        description=f"radius of the nose in the plane of the axis, at least {MIN_NOSE_MM:g}; "
        "0 is a point",
    )
    clearance_deg: ClearanceDeg = Field(
        7.0,
        description="of the flank below the edge, in the plane of a section; a tool whose heel "
        "rubs is refused with the clearance that it needs",
    )
    wear_um: float = Field(
        0.0,
        ge=0,
        le=1000,
        description="sets the simulated tip back and offsets X by as much, MATHS.md (112); the "
        "table does not change",
    )

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
    """[tool]: turns lobes and swings with the normal of the contact."""

    clearance_deg: ClearanceDeg = Field(
        7.0, description="between the flank of the tool and the profile at the contact"
    )
    heel_mm: float = Field(
        5.0, ge=0, le=100, description="length of that flank; beyond it, it is ground away"
    )
