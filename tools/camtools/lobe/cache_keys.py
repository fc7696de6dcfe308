# SPDX-License-Identifier: Apache-2.0
"""What the steps of a camshaft's table follow from, so that an open memory recalls them.

>>> from camtools.lobe.motion import example_lobe
>>> part = example_lobe()
>>> faster = part.process.model_copy(update={"spindle_rpm": 90.0})
>>> lobes_key(part) == lobes_key(part.model_copy(update={"process": faster}))
True
"""

from __future__ import annotations

from collections.abc import Hashable

from camtools.base.cache import file_state, recall
from camtools.lobe.motion import ShaftLobe, make_lobes
from camtools.lobe.part import LobePart


def lobes_key(part: LobePart) -> Hashable:
    """Return what the lobes of a part follow from."""
    files = tuple(file_state(lobe.csv) for lobe in part.cam.lobe if lobe.csv is not None)
    process, is_smoothed = part.process, any(lobe.smooth_um for lobe in part.cam.lobe)
    allowed_um = process.form_error_um if is_smoothed else None  # it limits smoothing
    return part.cam.model_dump_json(), process.operation, part.follower_radius_mm, files, allowed_um


def channels_key(part: LobePart, tolerance_nm: float) -> Hashable:
    """Return what the channels over the angle follow from; a plunge cut has its plan in them."""
    process = part.model_dump_json() if part.process.is_plunge else ""
    return lobes_key(part), process, tolerance_nm


def lobes_of(part: LobePart) -> list[ShaftLobe]:
    """Return `make_lobes` of a part, recalled where a memory is open."""
    return recall(("lobes", lobes_key(part)), lambda: make_lobes(part))
