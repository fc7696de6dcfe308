# SPDX-License-Identifier: Apache-2.0
"""[tolerances] of a part file: what the drawing states beside the form error; for the sheets.

>>> Tolerances(ovality_um=2.0).ovality_um, Tolerances().roundness_um is None
(2.0, True)
"""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from camtools.part.model import TomlTable

LengthUm = Annotated[float, Field(ge=0.001, le=1000)]


class FormTolerances(TomlTable):
    """Tolerances of any turned section, all of the radius; none is stated by default.

    Attributes
    ----------
    roundness_um : float or None
        RONt of the deviation from the drawing, minimum zone.
    straightness_um : float or None
        STRt of the deviation from the drawn profile, minimum zone.
    """

    roundness_um: LengthUm | None = None
    straightness_um: LengthUm | None = None


class Tolerances(FormTolerances):
    """Tolerances of an oval section as well.

    Attributes
    ----------
    diameter_um : float or None
        Of long and short axis, up and down, of the diameter.
    ovality_um : float or None
        Of the ovality, up and down, a difference of diameters.
    phase_deg : float or None
        Of the direction of the long axis, to both sides.
    taper_um : float or None
        Of the taper off the drawing over the part, up and down, of the diameter.
    """

    diameter_um: LengthUm | None = None
    ovality_um: LengthUm | None = None
    phase_deg: Annotated[float, Field(gt=0, le=45)] | None = None
    taper_um: LengthUm | None = None
