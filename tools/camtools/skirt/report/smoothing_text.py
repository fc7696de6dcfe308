# SPDX-License-Identifier: Apache-2.0
"""What smoothing did to the points of profile and ovality, for programs and for people.

>>> from camtools.skirt.part.part_file import example_part
>>> smoothing_facts(example_part().piston)
{}
"""

from __future__ import annotations

import numpy as np

from camtools.base.json_text import Json
from camtools.part.smoothing import differences
from camtools.skirt.geometry.profile import listed_mm, smoothed_mm
from camtools.skirt.part.part_file import Piston
from camtools.skirt.part.profile_keys import Ovality, Profile

_UM_PER_MM = 1000.0


def smoothed_curves(piston: Piston) -> dict[str, Profile | Ovality]:
    """Return the curves over the height whose points are smoothed, by name."""
    drawn = {"profile": piston.profile, "ovality": piston.ovality}
    return {
        name: one
        for name, one in drawn.items()
        if isinstance(one, Profile | Ovality) and one.smooth_um is not None
    }


def _facts(drawn: Profile | Ovality) -> Json:
    z_mm = np.asarray(drawn.height_mm, dtype=np.float64)
    before, after = listed_mm(drawn), smoothed_mm(drawn)
    off_um = (after - before) * _UM_PER_MM
    worst = int(np.abs(off_um).argmax())
    matrix = differences(z_mm, 2)
    bends = (float(np.abs(matrix @ one).max(initial=0.0)) for one in (before, after))
    return {
        "smooth_um": drawn.smooth_um,
        "height_mm": z_mm.tolist(),
        "off_um": off_um.tolist(),
        "largest_um": abs(float(off_um[worst])),
        "largest_at_mm": float(z_mm[worst]),
        "rms_um": float(np.sqrt(np.mean(off_um**2))),
        "bend_per_mm": dict(zip(("before", "after"), bends, strict=True)),
    }


def smoothing_facts(piston: Piston) -> Json:
    """Return residuals and largest second derivatives of smoothed points, nothing of others.

    Diameters and ovalities, not radii; the second derivative is that of three neighbours.
    """
    return {name: _facts(one) for name, one in smoothed_curves(piston).items()}


def smoothing_texts(found: Json) -> list[str]:
    """Return what `smoothing_facts` found as lines for people."""
    return [
        f"{name} smoothed within {one['smooth_um']:g} um: largest residual {one['largest_um']:.3g} "
        f"um at height {one['largest_at_mm']:g} mm, rms {one['rms_um']:.3g} um; largest second "
        f"derivative from {one['bend_per_mm']['before']:.3g} to {one['bend_per_mm']['after']:.3g} "
        "per mm"
        for name, one in found.items()
    ]
