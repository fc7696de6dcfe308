"""What the summary of every table holds, and the files that every table has.

>>> from camtools.skirt.table.generate import generate
>>> from camtools.skirt.part.part_file import example_part
>>> about_image(generate(example_part()).table, 1.0)["table_bytes"]
3456
"""

from __future__ import annotations

import numpy as np

from camtools.base.json_text import Json, emit_json
from camtools.base.quantities import NM_PER_MM
from camtools.table.c_source import emit_header, emit_source
from camtools.table.channel import OVER_HEIGHT, Channel
from camtools.table.evaluate import knot_interval
from camtools.table.image import Table, crc32_of, pack


def describe_channel(channel: Channel) -> Json:
    """Return the size of a channel and the bounds of its knots."""
    interval, is_length = knot_interval(channel), channel.kind in OVER_HEIGHT
    return {
        "bytes": channel.size,
        "n_slices": channel.n_slices,
        "knots_per_pattern": int(channel.knots.shape[1]),
        "patterns_per_turn": 1 << channel.log2_repeat,
        "frac_bits": channel.frac_bits,
        "lsb_nm": channel.lsb,
        "knot_interval": interval / NM_PER_MM if is_length else np.degrees(interval),
        "knot_interval_unit": "mm" if is_length else "degrees",
        "spacing_mm": (channel.z_last_nm - channel.z_first_nm) / (channel.n_slices - 1) / NM_PER_MM,
        "bounds": {name: getattr(channel, name) for name in ("p_min", "p_max", "v_max", "a_max")},
    }


# Bounds that reports call otherwise than the image does: programs that read reports rely on it.
_REPORTED = {"spindle_peak_ppm_per_rad": "spindle_peak_ppm"}


def about_image(table: Table, tolerance_nm: float) -> Json:
    """Return what the summary of every table says of its image."""
    image = pack(table)
    return {
        "table_bytes": len(image),
        "table_crc32": crc32_of(image),
        "tolerance_nm": float(tolerance_nm),
        "height_range_mm": [table.z_first_nm / NM_PER_MM, table.z_last_nm / NM_PER_MM],
        "guaranteed": {_REPORTED.get(k, k): v for k, v in vars(table.bounds).items()},
    }


def table_files(table: Table, summary: Json) -> dict[str, bytes]:
    """Return the files of every table by their names: image, C source, summary."""
    name, image = table.part_name, pack(table)
    return {
        f"{name}.camtab": image,
        f"{name}_table.h": emit_header(name, len(image)).encode("ascii"),
        f"{name}_table.c": emit_source(name, image).encode("ascii"),
        f"{name}.json": emit_json(summary).encode("ascii"),
    }
