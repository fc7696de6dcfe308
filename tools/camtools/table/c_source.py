"""The table image as C: the same bytes as a constant array.

>>> identifier("16V240-ZJ")
'part_16V240_ZJ'
"""

from __future__ import annotations

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
