"""[tolerances] of a part file: what the drawing states beside the form error; for the sheets.

>>> Tolerances(ovality_um=2.0).ovality_um, Tolerances().roundness_um is None
(2.0, True)
"""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from camtools.part.model import TomlTable

LengthUm = Annotated[float, Field(ge=0.001, le=1000)]
_DIAMETER = "plus and minus: long and short axis; ovality (diametral)"


class FormTolerances(TomlTable):
    """[tolerances]: in addition to `form_error_um`; [sheets](REPORT.md#sheets) use them."""

    roundness_um: LengthUm | None = Field(
        None, description="RONt of the deviation from the drawing, of the radius, minimum zone"
    )
    straightness_um: LengthUm | None = Field(
        None, description="STRt likewise, from the drawn profile"
    )


class Tolerances(FormTolerances):
    """[tolerances]: in addition to `form_error_um`; [sheets](REPORT.md#sheets) use them."""

    diameter_um: LengthUm | None = Field(None, description=_DIAMETER)
    ovality_um: LengthUm | None = Field(None, description=_DIAMETER)
    phase_deg: Annotated[float, Field(gt=0, le=45)] | None = Field(
        None, description="plus and minus: direction of the long axis"
    )
    taper_um: LengthUm | None = Field(
        None, description="plus and minus: taper deviation over the part (diametral)"
    )
