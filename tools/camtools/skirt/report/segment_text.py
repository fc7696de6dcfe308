r"""Segments of a drawing with all numbers that were worked out, for the report and for people.

>>> segments_text({"profile": [{"to_mm": 2.0, "value_mm": 91.95, "radius_mm": None}]})
'  profile: line to 2 mm, 91.95 mm\n'
"""

from __future__ import annotations

from math import isinf

from camtools.base.json_text import Json
from camtools.skirt.geometry.profile import ovality_pieces, profile_pieces
from camtools.skirt.part.part_file import Piston
from camtools.skirt.part.profile_keys import Ovality, Profile
from camtools.skirt.part.segments import Piece


def _told(piece: Piece, scale: int) -> Json:
    return {
        "to_mm": piece.to_mm,
        "value_mm": scale * piece.value_mm,
        "radius_mm": None if isinf(piece.radius_mm) else piece.radius_mm,
        "kink_deg": piece.kink_deg,
    }


def segment_facts(piston: Piston) -> Json:
    """Return lines and arcs of profile and ovality, nothing of other curves.

    Values are diameters and ovalities at the ends; a line has no radius; kink_deg is the turn
    against the segment before.
    """
    found: Json = {}
    if isinstance(piston.profile, Profile) and piston.profile.segment:
        found["profile"] = [_told(one, 2) for one in profile_pieces(piston.profile)]
    if isinstance(piston.ovality, Ovality) and piston.ovality.segment:
        found["ovality"] = [_told(one, 1) for one in ovality_pieces(piston.ovality)]
    return found


def _words(segment: Json) -> str:
    radius = segment["radius_mm"]
    kind = "line" if radius is None else f"arc of {radius:.6g} mm"
    return f"{kind} to {segment['to_mm']:g} mm, {segment['value_mm']:.6g} mm"


def segments_text(told: Json) -> str:
    """Return the segments as lines for the terminal, nothing without any."""
    return "".join(
        f"  {name}: {'; '.join(_words(one) for one in segments)}\n"
        for name, segments in told.items()
    )
