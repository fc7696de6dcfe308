# SPDX-License-Identifier: Apache-2.0
"""Sheets as data: sheets.json, which has the numbers of the sheets in full.

>>> sorted(_feature(Feature("RONq", "radius", "µm", None, 0.5, None, None, "good")))[:2]
['actual', 'deviation']
"""

from __future__ import annotations

import json

from camtools.base.json_text import Json, emit_json
from camtools.report.sheet import Feature, LineSheet, SectionSheet, Sheets
from camtools.roundness.circles import Circle, Roundness
from camtools.roundness.waves import RoundWave

_UM_PER_MM = 1000.0


def _feature(one: Feature) -> Json:
    return one._asdict()


def _circle(one: Circle) -> Json:
    return {"diameter_mm": 2 * one.radius_mm, "x_mm": one.x_mm, "y_mm": one.y_mm}


def _roundness(one: Roundness, zone_mm: float) -> Json:
    return {
        "RONt_LS_um": one.total_mm * _UM_PER_MM,
        "RONp_LS_um": one.peak_mm * _UM_PER_MM,
        "RONv_LS_um": one.valley_mm * _UM_PER_MM,
        "RONq_LS_um": one.q_mm * _UM_PER_MM,
        "RONt_MZ_um": zone_mm * _UM_PER_MM,
    }


def _waves(waves: list[RoundWave]) -> list[Json]:
    return [
        {"order": one.order, "amplitude_um": one.amplitude * _UM_PER_MM, "phase_deg": one.phase_deg}
        for one in waves
    ]


def _section(one: SectionSheet, *, is_oval: bool) -> Json:
    found, more = one.section, {}
    if is_oval:
        more = {
            "section": _roundness(found.whole, found.whole_zone.width_mm),
            "LS_circle": _circle(found.whole.circle),
            "MC_circle": _circle(found.circumscribed),
            "MI_circle": _circle(found.inscribed),
            "harmonics_of_section": _waves(found.whole_waves),
        }
    return more | {
        "name": one.name,
        "z_mm": one.z_mm,
        "features": [_feature(line) for line in one.features],
        "deviation": _roundness(found.off, found.off_zone.width_mm),
        "largest_deviation_um": found.largest_mm * _UM_PER_MM,
        "largest_deviation_deg": found.largest_deg,
        "harmonics_of_deviation": _waves(found.off_waves),
    }


def _line(one: LineSheet) -> Json:
    return {
        "angle_deg": one.angle_deg,
        "from_mm": float(one.z_mm[0]),
        "to_mm": float(one.z_mm[-1]),
        "points": int(one.z_mm.size),
        "features": [_feature(line) for line in one.features],
    }


def out_of_tolerance(document: bytes | None) -> list[str]:
    """Return what the sheets found out of tolerance, from sheets.json; nothing without sheets."""
    return [] if document is None else list(json.loads(document)["out_of_tolerance"])


def sheets_json(sheets: Sheets) -> bytes:
    """Return all sheets as JSON text; lengths of harmonics and RON are along the radius."""
    document = {
        "head": {row.name: row.value for row in sheets.head},
        "cutoff_upr": sheets.upr,
        "left_out": sheets.subject.left_out,
        "not_cut": sheets.missing,
        "out_of_tolerance": sheets.out,
        "sections": [_section(one, is_oval=sheets.subject.is_oval) for one in sheets.sections],
        "profiles": [_line(one) for one in sheets.lines],
        "tapers": [_feature(one) for one in sheets.tapers],
    }
    return emit_json(document).encode("ascii")
