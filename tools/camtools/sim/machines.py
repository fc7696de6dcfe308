"""Machines of the simulator by their names or their files.

>>> "real" in names()
True
>>> machine_path("real").name
'real.toml'
"""

from __future__ import annotations

from pathlib import Path

from camtools.base.errors import CamtoolsError
from camtools.base.project_paths import ROOT

MACHINES = ROOT / "host_sim" / "machines"


def names() -> list[str]:
    """Return the names of all machines that come with the simulator."""
    return sorted(path.stem for path in MACHINES.glob("*.toml"))


def machine_path(word: str) -> Path:
    """Return the file of a machine.

    Parameters
    ----------
    word : str
        The name of a file of host_sim/machines without its suffix, or the path of any file.

    Raises
    ------
    CamtoolsError
        There is neither a machine of that name nor such a file.
    """
    if word in names():
        return MACHINES / f"{word}.toml"
    path = Path(word)
    if word and path.is_file():
        return path
    known = ", ".join(names())
    raise CamtoolsError([f"--machine {word}: no such machine; give one of {known}, or a file"])


def machine_bytes(word: str) -> bytes:
    """Return what the file of a machine holds, for `machine_path`'s word.

    Raises
    ------
    CamtoolsError
        There is no such machine, or its file cannot be read.
    """
    path = machine_path(word)
    try:
        return path.read_bytes()
    except OSError as error:
        problem = f"--machine {word}: cannot be read: {error.strerror}"
        raise CamtoolsError([f"{problem}; give a readable file"]) from error
