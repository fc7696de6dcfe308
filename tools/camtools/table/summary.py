"""What the summary of every table holds, and the files that every table has.

>>> identifier("16V240-ZJ")
'part_16V240_ZJ'
"""

import numpy as np

from camtools.base.quantities import NM_PER_MM
from camtools.base.text import Json, emit_json
from camtools.table.channel import OVER_HEIGHT, Channel
from camtools.table.evaluate import knot_interval
from camtools.table.image import Table, crc32_of, pack

_PER_LINE = 16

_HEADER = """\
// SPDX-License-Identifier: Apache-2.0
/// {name}: a cam table made by tools/mktables; firmware/table/TABLE_FORMAT.md describes every byte.
#ifndef {guard}
#define {guard}

#include <stdint.h> // uint8_t

#define {macro}_SIZE {size}u

/// The image, aligned to 32 bytes; offer it to cam_table_check() before use.
extern const uint8_t {ident}_table[{macro}_SIZE];
/// Bytes in the image.
extern const uint32_t {ident}_table_size;

#endif
"""

_SOURCE = """\
// SPDX-License-Identifier: Apache-2.0
#include "{name}_table.h"

#include <stdalign.h> // alignas

alignas(32) const uint8_t {ident}_table[{macro}_SIZE] = {{
{rows}
}};

const uint32_t {ident}_table_size = {macro}_SIZE;
"""


def identifier(part_name: str) -> str:
    """Return a C identifier for a part's name: letters, digits and underscores."""
    plain = part_name.replace("-", "_")
    return f"part_{plain}" if plain[0].isdigit() else plain


def _names(part_name: str) -> dict[str, str]:
    ident = identifier(part_name)
    macro = f"{ident.upper()}_TABLE"
    return {"name": part_name, "ident": ident, "macro": macro, "guard": f"{macro}_H"}


def emit_header(part_name: str, size: int) -> str:
    """Return the text of NAME_table.h for an image of `size` bytes."""
    return _HEADER.format(size=size, **_names(part_name))


def emit_source(part_name: str, image: bytes) -> str:
    """Return the text of NAME_table.c for an image."""
    lines = [image[i : i + _PER_LINE] for i in range(0, len(image), _PER_LINE)]
    rows = "\n".join("    " + " ".join(f"0x{byte:02x}," for byte in line) for line in lines)
    return _SOURCE.format(rows=rows, **_names(part_name))


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
