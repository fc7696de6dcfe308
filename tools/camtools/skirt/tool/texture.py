"""What feed and nose radius leave on a surface: scallops and mean roughness, MATHS.md (239).

>>> nose = 0.8
>>> f"{scallop_um(0.2, nose):.3f} um, Ra {roughness_um(0.2, nose):.3f} um"
'6.275 um, Ra 1.604 um'
>>> f"{feed_for_scallop_mm(scallop_um(0.2, nose), nose):.6f}"
'0.200000'
"""

from itertools import pairwise
from math import floor, sqrt
from typing import NamedTuple

import numpy as np

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import UM_PER_MM
from camtools.part.areas import Zone
from camtools.part.common import SectionTolerances
from camtools.skirt.part.part_file import SkirtPart

_RA = 18 * sqrt(3)  # feed^2 / (18 sqrt(3) radius): mean distance of a parabola from its mean line
_BLEND_MM = 1.0  # of a proposed law, within the zone that accepts more
_DECIMALS = 1e4  # of a proposed feed [1/mm]


def scallop_um(feed_mm: float, nose_mm: float) -> float:
    """Return the height of the ridges between tracks, peak to valley."""
    return UM_PER_MM * (nose_mm - sqrt(nose_mm**2 - feed_mm**2 / 4))


def roughness_um(feed_mm: float, nose_mm: float) -> float:
    """Return the mean roughness Ra of the tracks; relative error below (feed / radius)^2 / 16."""
    return UM_PER_MM * feed_mm**2 / (_RA * nose_mm)


def feed_for_scallop_mm(um: float, nose_mm: float) -> float:
    """Return the feed that leaves ridges of a height; above the radius the widest, its diameter."""
    mm = min(um / UM_PER_MM, nose_mm)
    return 2 * sqrt(mm * (2 * nose_mm - mm))


def feed_for_roughness_mm(um: float, nose_mm: float) -> float:
    """Return the feed that leaves a mean roughness Ra."""
    return sqrt(um / UM_PER_MM * _RA * nose_mm)


class Stretch(NamedTuple):
    """Heights with a limit of their own."""

    from_mm: float
    to_mm: float
    zone: Zone | None
    most_mm: float | None  # the largest feed; nothing where none is stated


def largest_feed_mm(stated: SectionTolerances, nose_mm: float) -> float | None:
    """Return the largest feed that keeps the limits of scallop and roughness, if there are any."""
    found = []
    if stated.scallop_um is not None:
        found.append(feed_for_scallop_mm(stated.scallop_um, nose_mm))
    if stated.roughness_um is not None:
        found.append(feed_for_roughness_mm(stated.roughness_um, nose_mm))
    return min(found, default=None)


def stretches(part: SkirtPart) -> list[Stretch]:
    """Return the part from its first height to its last by zones that hold all round."""
    heights_mm, nose_mm = part.piston.profile.height_mm, part.tool.nose_radius_mm
    low_mm, high_mm = heights_mm[0], heights_mm[-1]
    ends = {
        end for z in part.tolerances.zones for end in (z.from_mm, z.to_mm) if z.width_deg == 360
    }
    breaks = [low_mm, *sorted(end for end in ends if low_mm < end < high_mm), high_mm]
    found = []
    for from_mm, to_mm in pairwise(breaks):
        middle_mm = (from_mm + to_mm) / 2
        stated = part.tolerances.stated_at(middle_mm)
        zone, most_mm = part.tolerances.zone_at(middle_mm), largest_feed_mm(stated, nose_mm)
        found.append(Stretch(from_mm, to_mm, zone, most_mm))
    return found


def check_texture(part: SkirtPart) -> None:
    """Refuse a feed that leaves more than a zone accepts; part: the last pass."""
    limits = [*part.tolerances.zones, part.tolerances]
    if all(of.scallop_um is None and of.roughness_um is None for of in limits):
        return
    if not part.tool.is_round:
        problem = "is missing: limits of scallop_um and roughness_um need it"
        raise CamtoolsError([f"tool.nose_radius_mm: {problem}; add it, or remove the limits"])
    lines = [line for stretch in stretches(part) if (line := _refusal(part, stretch))]
    if lines:
        raise CamtoolsError(lines)


def _refusal(part: SkirtPart, stretch: Stretch) -> str:
    """Return why the feed of a stretch is too large, nothing where it is not."""
    process, nose_mm = part.process, part.tool.nose_radius_mm
    law, feed_mm = process.feed_law, process.feed_mm
    if law is not None:
        inside = [z for z in law.height_mm if stretch.from_mm < z < stretch.to_mm]
        feed_mm = float(law.at_mm(np.array([stretch.from_mm, *inside, stretch.to_mm])).max())
    if stretch.most_mm is None or feed_mm <= stretch.most_mm:
        return ""
    where = f"zone {stretch.zone.name}" if stretch.zone else "the part"
    ridge_um, ra_um = scallop_um(feed_mm, nose_mm), roughness_um(feed_mm, nose_mm)
    found = f"scallops of {ridge_um:.3g} um and Ra {ra_um:.3g} um"
    key = "process.feed_mm" if law is None else "process.feed_law"
    heights = f"{stretch.from_mm:g} .. {stretch.to_mm:g} mm"
    limit = floor(stretch.most_mm * _DECIMALS) / _DECIMALS
    problem = f"leaves {found} in {where}, heights {heights}, more than [tolerances] accept"
    return (
        f"{key} = {feed_mm:.4g}: {problem}; feed at most {limit:g} mm there, or use a larger nose; "
        "mktables --propose-feed shows a law"
    )


def proposed_law(part: SkirtPart) -> str:
    """Return [process.feed_law] with the largest feed of each stretch, as text for a part file.

    Raises CamtoolsError: no nose radius, or no stretch has a limit.
    """
    found = stretches(part)
    limited = [stretch.most_mm for stretch in found if stretch.most_mm is not None]
    if not limited or not part.tool.is_round:
        problem = "needs tool.nose_radius_mm, and scallop_um or roughness_um in [tolerances]"
        raise CamtoolsError([f"--propose-feed: {problem}; add them to the part file"])
    feeds = [floor((s.most_mm or max(limited)) * _DECIMALS) / _DECIMALS for s in found]
    points = [(found[0].from_mm, feeds[0])]
    for (below, above), (feed, next_feed) in zip(pairwise(found), pairwise(feeds), strict=True):
        blend_mm = min(
            _BLEND_MM, (below.to_mm - below.from_mm) / 2, (above.to_mm - above.from_mm) / 2
        )
        begin_mm = below.to_mm - (blend_mm if feed > next_feed else 0)
        points += [(begin_mm, feed), (begin_mm + blend_mm, next_feed)] if feed != next_feed else []
    points.append((found[-1].to_mm, feeds[-1]))
    heights, values = (
        ", ".join(f"{value:g}" for value in column) for column in zip(*points, strict=True)
    )
    return f"[process.feed_law]\nheight_mm = [{heights}]\nfeed_mm = [{values}]\n"
