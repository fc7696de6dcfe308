"""Temporary files and folders that tell whether their maker still lives.

A process that is killed outright (SIGKILL, loss of power) cannot remove what it has begun. Each
temporary name is therefore locked as long as its maker lives, and whoever writes into the same
folder next removes those that nobody holds.

>>> import tempfile
>>> with tempfile.TemporaryDirectory() as name:
...     folder = Path(tempfile.mkdtemp(suffix=SUFFIX, prefix=".run.", dir=name))
...     with held(folder):
...         sweep(Path(name), ".run.")
...     folder.exists()
True
"""

from __future__ import annotations

import fcntl
import os
import shutil
import stat
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

SUFFIX = ".tmp"
_NEW_S = 1.0  # between a name's making and its lock another process must not take it as left over


@contextmanager
def held(path: Path) -> Iterator[None]:
    """Lock a file or folder as alive, until the end of the block or of the process.

    Some network file systems know no locks; what is left there stays.
    """
    handle = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_CLOEXEC)
    try:
        with suppress(OSError):
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        yield
    finally:
        os.close(handle)


def _is_abandoned(path: Path) -> bool:
    """Return whether a file or folder is one's own and nobody holds it."""
    try:
        handle = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
    except OSError:
        return False
    try:
        about = os.fstat(handle)
        is_usual = stat.S_ISDIR(about.st_mode) or stat.S_ISREG(about.st_mode)
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        is_old = abs(time.time() - about.st_ctime) > _NEW_S
        return is_usual and is_old and about.st_uid == os.geteuid()
    except OSError:
        return False
    finally:
        os.close(handle)


def sweep(folder: Path, prefix: str) -> None:
    """Remove what earlier runs left in a folder under a prefix; what resists stays."""
    with suppress(OSError):
        for path in sorted(folder.iterdir()):
            if not (path.name.startswith(prefix) and path.name.endswith(SUFFIX)):
                continue
            if not _is_abandoned(path):
                continue
            if path.is_dir():
                shutil.rmtree(path, ignore_errors=True)
            else:
                path.unlink(missing_ok=True)
