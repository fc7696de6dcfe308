"""How a skirt fits its bore, cold, coated and hot, for programs and for people.

>>> from camtools.skirt.part.part_file import example_part
>>> from camtools.skirt.geometry.skirt_geometry import make_geometry
>>> fit_facts(example_part().piston, make_geometry(example_part()))
{}
"""

import numpy as np

from camtools.base.quantities import UM_PER_MM, Floats
from camtools.base.text import Json
from camtools.part.areas import in_any
from camtools.skirt.geometry.growth import State, states_of
from camtools.skirt.geometry.sections import ALL_AROUND_RAD
from camtools.skirt.geometry.skirt_geometry import Geometry
from camtools.skirt.part.part_file import Piston

_N_HEIGHTS = 201
_DECIMALS = 6  # of a micrometre, within which angles are alike


def heights_of(geometry: Geometry) -> Floats:
    """Return heights of the skirt, those with a break of its shape included, rising."""
    breaks = geometry.breaks_mm()
    inside = (breaks > geometry.skirt_mm[0]) & (breaks < geometry.skirt_mm[1])
    return np.union1d(np.linspace(*geometry.skirt_mm, _N_HEIGHTS), breaks[inside])


def states_at(
    piston: Piston, geometry: Geometry, phi_rad: Floats, z_mm: Floats
) -> dict[str, State]:
    """Return `states_of` of what is turned, at angles [rad] and heights [mm]."""
    return states_of(piston, geometry.drawn_mm(phi_rad, z_mm[:, None]), phi_rad, z_mm)


def fit_facts(piston: Piston, geometry: Geometry) -> Json:
    """Return least radial clearances and how much less than drawn is turned, {} without a fit."""
    if not piston.has_fit:
        return {}
    growth, coating = piston.growth, piston.coating
    z_mm = heights_of(geometry)
    states = states_at(piston, geometry, ALL_AROUND_RAD, z_mm)
    drawn_mm = states["cold"].radius_mm
    if coating is not None and coating.drawn == "coated":
        drawn_mm = states["coated"].radius_mm
    if growth is not None and growth.drawn == "hot":
        drawn_mm = states["hot"].radius_mm
        if coating is not None and coating.drawn == "bare":
            bare = piston.model_copy(update={"coating": None})
            drawn_mm = states_at(bare, geometry, ALL_AROUND_RAD, z_mm)["hot"].radius_mm
    less_um = (drawn_mm - states["cold"].radius_mm) * UM_PER_MM
    found: Json = {"less_than_drawn_um": [float(less_um.min()), float(less_um.max())]}
    if piston.bore is not None:
        least = {name: _least(piston, state, z_mm) for name, state in states.items()}
        found["clearance"] = least
    return found


def on_metal_um(piston: Piston, state: State, phi_rad: Floats, z_mm: Floats) -> Floats:
    """Return the clearance over heights and angles, NaN in windows of the skirt."""
    turn, heights = np.broadcast_arrays(phi_rad / (2 * np.pi), z_mm[:, None])
    windows = [area._replace(margin_mm=0.0) for area in piston.window_areas]
    is_open = in_any(windows, turn, heights, state.radius_mm)
    return np.where(is_open, np.nan, state.clearance_um)


def _least(piston: Piston, state: State, z_mm: Floats) -> Json:
    clearance = on_metal_um(piston, state, ALL_AROUND_RAD, z_mm)
    clearance = np.where(np.isnan(clearance), np.inf, clearance)
    i, j = np.unravel_index(int(clearance.round(_DECIMALS).argmin()), clearance.shape)
    deg = round(float(np.degrees(ALL_AROUND_RAD[j])), 1)
    return {"um": float(clearance[i, j]), "angle_deg": deg, "z_mm": round(float(z_mm[i]), 3)}


def _place(name: str, least: Json) -> str:
    at = f"{least['angle_deg']:g} degrees, height {least['z_mm']:g} mm"
    return f"{name} {least['um']:.1f} um (at {at})"


def fit_text(found: Json) -> str:
    """Return these facts as lines for people, a caution where there is no clearance."""
    if not found:
        return ""
    low_um, high_um = found["less_than_drawn_um"]
    text = f"  turned radius {low_um:.1f} .. {high_um:.1f} um less than drawn\n" if high_um else ""
    clearance = found.get("clearance", {})
    if clearance:
        least = ", ".join(_place(name, at) for name, at in clearance.items())
        text += f"  least radial clearance to the bore: {least}\n"
    tight = [_place(name, at) for name, at in clearance.items() if at["um"] < 0]
    if tight:
        text += f"  caution: the skirt is larger than the bore: {', '.join(tight)}\n"
    return text
