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
from pydantic import ValidationError

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import NM_PER_MM, UM_PER_MM
from camtools.part.areas import Zone
from camtools.part.common import MAX_FEED_MM, FeedLaw, SectionTolerances
from camtools.skirt.part.land import Band
from camtools.skirt.part.part_file import SkirtPart
from camtools.skirt.tool.turning import way_channel

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
    nose_mm, (low_mm, high_mm) = part.tool.nose_radius_mm, part.piston.ends_mm
    ends = {
        end for z in part.tolerances.zones for end in (z.from_mm, z.to_mm) if z.width_deg == 360
    }
    ends |= {end for band in part.bands for end in (band.low_mm, band.high_mm)}
    breaks = [low_mm, *sorted(end for end in ends if low_mm < end < high_mm), high_mm]
    found = []
    for from_mm, to_mm in pairwise(breaks):
        middle_mm = (from_mm + to_mm) / 2
        stated = part.tolerances.stated_at(middle_mm)
        zone, most_mm = part.tolerances.zone_at(middle_mm), largest_feed_mm(stated, nose_mm)
        found.append(Stretch(from_mm, to_mm, zone, most_mm))
    return found


def check_texture(part: SkirtPart, feed_mm: float | None = None) -> None:
    """Refuse a feed that leaves more than a zone accepts.

    The part is that of the last pass; `feed_mm` replaces its feed, of a law the mean. Raises
    CamtoolsError, with the largest feed of each zone, or since the nose has no radius.
    """
    limits = [*part.tolerances.zones, part.tolerances]
    if all(of.scallop_um is None and of.roughness_um is None for of in limits):
        return
    if not part.tool.is_round:
        problem = "is missing: limits of scallop_um and roughness_um need it"
        raise CamtoolsError([f"tool.nose_radius_mm: {problem}; add it, or remove the limits"])
    own_mm, law = part.process.feed_mm, part.process.feed_law
    key = "process.feed_mm" if law is None else "process.feed_law"
    key = "feed_mm of the last process.pass" if part.process.passes else key
    key = "feed_mm of a band" if part.bands else key
    key = "--feed" if feed_mm else key
    share = (feed_mm or own_mm) / own_mm
    lines = [line for stretch in stretches(part) if (line := _refusal(part, stretch, share))]
    if lines:
        raise CamtoolsError([f"{key} = {line}" for line in lines])


def _meet(band: Band, stretch: Stretch) -> bool:
    return band.low_mm < stretch.to_mm and band.high_mm > stretch.from_mm


def _feed_mm(part: SkirtPart, stretch: Stretch) -> float:
    """Return the largest feed of a stretch, by the law or without one."""
    law = part.process.feed_law
    if part.bands:  # in a groove nothing is turned
        return max((b.passes[-1].feed_mm for b in part.bands if _meet(b, stretch)), default=0.0)
    if law is None:
        return part.process.feed_mm
    inside = [z for z in law.height_mm if stretch.from_mm < z < stretch.to_mm]
    return float(law.at_mm(np.array([stretch.from_mm, *inside, stretch.to_mm])).max())


def _refusal(part: SkirtPart, stretch: Stretch, share: float) -> str:
    """Return the feed of a stretch and why it is too large, nothing where it is not."""
    feed_mm, nose_mm = share * _feed_mm(part, stretch), part.tool.nose_radius_mm
    if stretch.most_mm is None or feed_mm <= stretch.most_mm:
        return ""
    found = "metal between the tracks"
    if feed_mm < 2 * nose_mm:
        ridge_um, ra_um = scallop_um(feed_mm, nose_mm), roughness_um(feed_mm, nose_mm)
        found = f"scallops of {ridge_um:.3g} um and Ra {ra_um:.3g} um"
    where = f"zone {stretch.zone.name}" if stretch.zone else "the part"
    heights = f"{stretch.from_mm:g} .. {stretch.to_mm:g} mm"
    problem = f"leaves {found} in {where}, heights {heights}, more than [tolerances] accept"
    return (
        f"{feed_mm:.4g}: {problem}; feed at most {_shown(stretch.most_mm):g} mm there, or "
        f"use a larger nose{'' if part.bands else '; mktables --propose-feed shows a law'}"
    )


def _shown(feed_mm: float) -> float:
    """Return a feed with the decimals of a part file, never larger."""
    return floor(feed_mm * _DECIMALS) / _DECIMALS


def proposed_law(part: SkirtPart) -> str:
    """Return the largest feed of each stretch as text for a part file.

    A law where Z can follow it, else the feed that all stretches accept. Raises CamtoolsError: no
    nose radius, or no stretch has a limit.
    """
    if part.bands:
        problem = "proposes one law, a part with [[piston.land]] has a feed for each band"
        raise CamtoolsError([f"--propose-feed: {problem}; the refusal of a feed has the largest"])
    found = stretches(part)
    limited = [stretch.most_mm for stretch in found if stretch.most_mm is not None]
    if not limited or not part.tool.is_round:
        problem = "needs tool.nose_radius_mm, and scallop_um or roughness_um in [tolerances]"
        raise CamtoolsError([f"--propose-feed: {problem}; add them to the part file"])
    feeds = [min(_shown(s.most_mm or max(limited)), part.height_mm, MAX_FEED_MM) for s in found]
    points = _law_points(found, feeds)
    columns = [list(column) for column in zip(*points, strict=True)]
    if len(set(feeds)) == 1 or part.process.path != "helix" or not _is_law(*columns):
        return f"[process]\nfeed_mm = {min(feeds):g}\n"
    heights, values = (", ".join(f"{value:g}" for value in column) for column in columns)
    return f"[process.feed_law]\nheight_mm = [{heights}]\nfeed_mm = [{values}]\n"


def _law_points(found: list[Stretch], feeds: list[float]) -> list[tuple[float, float]]:
    """Return heights and feeds; the feed changes within the stretch that accepts more."""
    points = [(found[0].from_mm, feeds[0])]
    for (below, above), (feed, next_feed) in zip(pairwise(found), pairwise(feeds), strict=True):
        blend_mm = min(_BLEND_MM, *((s.to_mm - s.from_mm) / 3 for s in (below, above)))
        begin_mm = below.to_mm - (blend_mm if feed > next_feed else 0)
        points += [(begin_mm, feed), (begin_mm + blend_mm, next_feed)] if feed != next_feed else []
    return [*points, (found[-1].to_mm, feeds[-1])]


def _is_law(height_mm: list[float], feed_mm: list[float]) -> bool:
    """Return whether a table can have a law."""
    try:
        law = FeedLaw(height_mm=height_mm, feed_mm=feed_mm)
        ends_nm = round(height_mm[0] * NM_PER_MM), round(height_mm[-1] * NM_PER_MM)
        way_channel(law, ends_nm)
    except (ValidationError, CamtoolsError):
        return False
    return True
