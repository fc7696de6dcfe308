"""Which symbolic links are followed where results are written.

In a folder that others can write to, a link that one of them planted under the name of a result
would let a run overwrite any file of whoever starts it. Only a link that its owner is trusted with
is followed: one's own, or one of the administrator's.

>>> followed(Path("no such file"))
PosixPath('no such file')
"""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path

from camtools.base.errors import CamtoolsError

_MOST_LINKS = 40  # as the kernel


def followed(path: Path) -> Path:
    """Return what a path stands for, its last part followed where it is a link that may be.

    The folders before the last part are left to the system, which follows no planted link in the
    shared folders for temporary files (`fs.protected_symlinks`).

    Raises
    ------
    CamtoolsError
        A link on the way belongs to somebody else.
    OSError
        The links lead round in a circle.
    """
    place = path
    for _ in range(_MOST_LINKS):
        try:
            about = place.lstat()
        except FileNotFoundError:
            return place
        if not stat.S_ISLNK(about.st_mode):
            return place
        if about.st_uid not in (os.geteuid(), 0):
            problem = "is a link of another user, which is not followed"
            raise CamtoolsError([f"{place}: {problem}; remove it, or give another folder"])
        place = place.parent / place.readlink()
    raise OSError(errno.ELOOP, os.strerror(errno.ELOOP))
