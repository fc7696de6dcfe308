# SPDX-License-Identifier: Apache-2.0
"""What the steps of a skirt's table follow from, so that an open memory recalls them.

>>> from camtools.skirt.part.part_file import example_part
>>> part = example_part()
>>> slower = part.process.model_copy(update={"spindle_rpm": 500.0})
>>> shape_key(part) == shape_key(part.model_copy(update={"process": slower}))
True
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator

from camtools.base.cache import file_state, recall
from camtools.skirt.geometry.skirt_geometry import Geometry, make_geometry
from camtools.skirt.geometry.smooth_points import smoothed_curves
from camtools.skirt.part.part_file import SkirtPart


def _files_of(part: SkirtPart) -> Iterator[str]:
    section = part.piston.section
    if section.csv is not None:
        yield section.csv
    for one in section.files or []:
        yield one.csv


def shape_key(part: SkirtPart) -> Hashable:
    """Return what the geometry of a part follows from; of a refit the speed is part of it."""
    magnify = None if part.magnify is None else part.magnify.model_dump_json()
    files = tuple(file_state(name) for name in _files_of(part))
    refit = f"{part.process.form_error_um!r}" if smoothed_curves(part.piston) else ""
    if part.piston.section.shape == "ellipse-arc":
        refit = f"{part.process.spindle_rpm!r} {part.process.form_error_um!r}"
    return part.piston.model_dump_json(), magnify, files, refit


def way_key(part: SkirtPart, tolerance_nm: float | None) -> Hashable:
    """Return what the channels of u and x follow from."""
    process = part.process
    runs = process.run_in_mm, process.run_out_mm, process.form_error_um
    return shape_key(part), runs, part.tool.nose_radius_mm, tolerance_nm


def law_key(part: SkirtPart, tolerance_nm: float | None) -> Hashable:
    """Return what the law of the spindle's speed follows from."""
    machine = part.machine.limits.model_dump_json()
    return way_key(part, tolerance_nm), part.process.model_dump_json(), machine


def geometry_of(part: SkirtPart) -> Geometry:
    """Return `make_geometry` of a part, recalled where a memory is open."""
    return recall(("skirt geometry", shape_key(part)), lambda: make_geometry(part))
