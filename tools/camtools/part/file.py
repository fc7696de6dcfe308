r"""A part file of either kind: the skirt of a piston, or a cam.

>>> text = b'[part]\nname = "a"\nkind = "cam"\nsource = "b"\n'
>>> try:
...     parse_any(text, "a.toml")
... except CamtoolsError as error:
...     print(error.lines[0])
a.toml: cam: is missing; add it
"""

from __future__ import annotations

from pathlib import Path

from camtools.base.errors import CamtoolsError
from camtools.lobe.part import CamPart
from camtools.skirt.part import Part, is_cam, parse_part, read_part_file, read_tree, validated

__all__ = ["CamtoolsError", "height_mm", "is_feed_within", "load_any", "parse_any"]

_NM_PER_MM = 1_000_000


def parse_any(data: bytes, file: str, folder: Path = Path()) -> Part | CamPart:
    """Return the piston or the cam that the bytes of a TOML file describe.

    Parameters and errors as `camtools.skirt.part.parse_part`.
    """
    tree = read_tree(data, file)
    return (
        validated(CamPart, tree, file, folder) if is_cam(tree) else parse_part(data, file, folder)
    )


def height_mm(part: Part | CamPart) -> float:
    """Return how high a part is [mm], of a cam from its first lobe to its last."""
    if isinstance(part, CamPart):
        return part.cam.lobe[-1].z_mm[1] - part.cam.lobe[0].z_mm[0]
    heights_mm = part.piston.profile.height_mm
    return heights_mm[-1] - heights_mm[0]


def is_feed_within(part: Part | CamPart, feed_mm: float) -> bool:
    """Tell whether a part is cut in a turn at least, to the nanometre as the firmware asks it."""
    return round(feed_mm * _NM_PER_MM) <= round(height_mm(part) * _NM_PER_MM)


def load_any(path: Path) -> Part | CamPart:
    """Return the piston or the cam described by a TOML file.

    Raises
    ------
    CamtoolsError
        The file cannot be read, or its fields are wrong.
    """
    return parse_any(read_part_file(path), str(path), path.parent)
