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

from camtools.errors import CamtoolsError
from camtools.part import Part, is_cam, parse_part, read_part_file, read_tree, validated
from camtools.part_cam import CamPart

__all__ = ["CamtoolsError", "load_any", "parse_any"]


def parse_any(data: bytes, file: str, folder: Path = Path()) -> Part | CamPart:
    """Return the piston or the cam that the bytes of a TOML file describe.

    Parameters and errors as `camtools.part.parse_part`.
    """
    tree = read_tree(data, file)
    return (
        validated(CamPart, tree, file, folder) if is_cam(tree) else parse_part(data, file, folder)
    )


def load_any(path: Path) -> Part | CamPart:
    """Return the piston or the cam described by a TOML file.

    Raises
    ------
    CamtoolsError
        The file cannot be read, or its fields are wrong.
    """
    return parse_any(read_part_file(path), str(path), path.parent)
