"""[piston.datum]: the axis and the direction to which a drawing refers run-out and phase.

>>> datum = Datum(offset_um=[3, 0], tilt_um_per_mm=[0, 0.1])
>>> datum.centre_mm(20.0)
(0.003, 0.002)
"""

from typing import Annotated

from pydantic import Field

from camtools.base.quantities import UM_PER_MM
from camtools.part.model import TomlTable

_OffsetUm = Annotated[float, Field(ge=-1000, le=1000)]
_TiltUm = Annotated[float, Field(ge=-100, le=100)]


class Datum(TomlTable):
    """[piston.datum]: an axis beside that of the turned skirt, [for sheets](REPORT.md#sheets)."""

    offset_um: Annotated[list[_OffsetUm], Field(min_length=2, max_length=2)] = Field(
        [0.0, 0.0],
        description="where it crosses height 0, towards 0 and towards 90 degrees: the blank's "
        "offset in its fixture",
    )
    tilt_um_per_mm: Annotated[list[_TiltUm], Field(min_length=2, max_length=2)] = Field(
        [0.0, 0.0],
        description="how far it leans with rising height, towards 0 and towards 90 degrees",
    )
    bore_off_deg: Annotated[float, Field(ge=-45, le=45)] = Field(
        0.0,
        description="by how much the pin bore was found turned from its drawn direction; phases "
        "are referred to the bore",
    )

    def centre_mm(self, z_mm: float) -> tuple[float, float]:
        """Return where the axis crosses a height, against the axis of the turned skirt [mm]."""
        pairs = zip(self.offset_um, self.tilt_um_per_mm, strict=True)
        x_mm, y_mm = ((offset + tilt * z_mm) / UM_PER_MM for offset, tilt in pairs)
        return x_mm, y_mm
