"""What is known about a table, as JSON for programs.

>>> from camtools.skirt.generate import generate
>>> from camtools.skirt.part import example_part
>>> sorted(make_summary(generate(example_part())))[:4]
['channels', 'continuity', 'design', 'error']
"""

from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np
from scipy.interpolate import PPoly

from camtools.cut.feasibility import given_of, needed_of
from camtools.skirt.accuracy import Accuracy
from camtools.skirt.corner import Corner
from camtools.skirt.generate import Generated, peaks_of_table
from camtools.skirt.geometry import NM_PER_MM, Geometry, dense_heights_mm, omega_rad_s
from camtools.skirt.poly_surface import PolySurface
from camtools.skirt.speed import summary_of
from camtools.table.evaluate import Continuity, jumps, knot_interval
from camtools.table.image import CRC_OFFSET, KIND_U, KIND_X, Channel, pack

_PEAK_ANGLES = 1440
_PEAK_HEIGHTS_PER_PIECE = 16

Json = dict[str, Any]


def _piecewise(spline: PPoly) -> Json:
    return {"breaks_mm": spline.x.tolist(), "coefficients": spline.c.T.tolist()}


def design_of(result: Generated) -> Json:
    """Return the exact geometry, independent of the table: what a gauge compares with."""
    section, surface = result.part.piston.section, result.geometry.surface
    if isinstance(surface, PolySurface):
        radius = _piecewise(result.geometry.radius)
        return {"shape": "surface", "radius_mm": radius, "surface": surface.document()}
    return {
        "shape": section.shape,
        "beta": float(section.beta),
        "radius_mm": _piecewise(result.geometry.radius),
        "ovality_mm": _piecewise(result.geometry.ovality),
    }


def motion_peaks(geometry: Geometry, spindle_rpm: float, feed_mm: float) -> Json:
    """Return the peaks of U of the exact geometry at a spindle speed."""
    z_mm = dense_heights_mm(geometry, _PEAK_HEIGHTS_PER_PIECE)
    phi_rad = 2 * np.pi * np.arange(_PEAK_ANGLES) / _PEAK_ANGLES
    u, omega = geometry.delta(phi_rad, z_mm[:, None]), omega_rad_s(spindle_rpm)
    rise = np.diff(u.delta, axis=0) / np.diff(z_mm)[:, None]
    return {
        "stroke_mm": float(np.ptp(u.delta)),
        "velocity_mm_s": float(np.abs(u.d1).max()) * omega,
        "acceleration_mm_s2": float(np.abs(u.d2).max()) * omega**2,
        "jerk_mm_s3": float(np.abs(u.d3).max()) * omega**3,
        "velocity_from_feed_mm_s": float(np.abs(rise).max()) * feed_mm * spindle_rpm / 60,
    }


def describe_channel(channel: Channel) -> Json:
    """Return the size of a channel and the bounds of its knots."""
    interval = knot_interval(channel)
    return {
        "bytes": channel.size,
        "n_slices": channel.n_slices,
        "knots_per_pattern": int(channel.knots.shape[1]),
        "patterns_per_turn": 1 << channel.log2_repeat,
        "frac_bits": channel.frac_bits,
        "lsb_nm": channel.lsb_nm,
        "knot_interval": interval / NM_PER_MM if channel.kind == KIND_X else np.degrees(interval),
        "knot_interval_unit": "mm" if channel.kind == KIND_X else "degrees",
        "spacing_mm": (channel.z_last_nm - channel.z_first_nm) / (channel.n_slices - 1) / NM_PER_MM,
        "bounds": {name: getattr(channel, name) for name in ("p_min", "p_max", "v_max", "a_max")},
    }


def _error(accuracy: Accuracy, per: str) -> Json:
    return {
        "value_nm": accuracy.value_nm,
        f"first_nm_per_{per}": accuracy.first,
        f"second_nm_per_{per}2": accuracy.second,
        "first_share_of_peak": accuracy.first_share,
        "second_share_of_peak": accuracy.second_share,
    }


def _jumps(channel: Channel) -> Json:
    names = Continuity._fields
    knots, wrap = jumps(channel)
    return {
        "at_knots": dict(zip(names, knots, strict=True)),
        "at_wrap": dict(zip(names, wrap, strict=True)),
    }


def _process(result: Generated) -> Json:
    process, magnify = result.part.process, result.part.magnify
    return {
        "spindle_rpm": float(process.spindle_rpm),
        "feed_mm": float(process.feed_mm),
        "depth_mm": float(process.depth_mm),
        "direction": process.direction,
        "magnify": float(magnify.factor) if magnify else 1.0,
    }


def _feasibility(result: Generated) -> Json:
    limits = result.part.machine.limits
    peaks, given = peaks_of_table(result.table, result.speed), given_of(limits)
    needed = needed_of(peaks, limits, omega_rad_s(result.part.process.spindle_rpm))
    return {
        "limits": given,
        "needed": {name: needed[name] for name in given},
        "highest_spindle_rpm": result.highest_speed.rpm,
        "decided_by": result.highest_speed.decides,
    }


def _refit(corner: Corner) -> Json:
    """Return what a refit came to, and what all deletions would come to at the part's speed."""
    recipe, at = corner.recipe, corner.joint(corner.worst_mm)
    assert recipe is not None
    arc = at.arc()
    return {
        "recipe": recipe._asdict(),
        "height_mm": corner.worst_mm,
        "joint_deg": float(np.degrees(at.joint_rad)),
        "eccentricity_mm": float(arc.eccentricity_mm),
        "radius_mm": float(arc.radius_mm),
        "corner_mm_per_rad": float(at.corner_mm_rad()),
        "candidates": [one._asdict() for one in corner.candidates],
    }


def _extras(result: Generated) -> Json:
    """Return what only some parts have: a corner, measured points, a modulated spindle."""
    extras: Json = {}
    if result.geometry.corner is not None:
        extras["refit"] = _refit(result.geometry.corner)
    if result.geometry.off_points_um is not None:
        extras["scan"] = {"off_points_um": result.geometry.off_points_um}
    if result.speed is not None:
        extras["equal_volume"] = summary_of(result.speed, result.part, result.geometry)
    return extras


def make_summary(result: Generated) -> Json:
    """Return everything that is known about a table, ready for JSON; no dates, no paths."""
    table, image = result.table, pack(result.table)
    u, x = table.channel(KIND_U), table.channel(KIND_X)
    process = result.part.process
    return _extras(result) | {
        "part": {"name": table.part_name, "source": result.part.part.source},
        "process": _process(result),
        "table_bytes": len(image),
        "table_crc32": struct.unpack_from("<I", image, CRC_OFFSET)[0],
        "tolerance_nm": float(result.tolerance_nm),
        "height_range_mm": [table.z_first_nm / NM_PER_MM, table.z_last_nm / NM_PER_MM],
        "channels": {"u": describe_channel(u), "x": describe_channel(x)},
        "error": {"u": _error(result.accuracy_u, "rad"), "x": _error(result.accuracy_x, "mm")},
        "continuity": {"u": _jumps(u), "x": _jumps(x)},
        "guaranteed": vars(table.bounds),
        "motion": motion_peaks(result.geometry, process.spindle_rpm, process.feed_mm),
        "feasibility": _feasibility(result),
        "design": design_of(result),
    }


def emit_json(summary: Json) -> str:
    """Return a summary as JSON text: sorted keys, full double precision, deterministic."""
    return json.dumps(summary, indent=1, sort_keys=True, allow_nan=False) + "\n"
