"""Files appear complete or not at all.

>>> import tempfile
>>> with tempfile.TemporaryDirectory() as name:
...     write_all(Path(name), {"a.txt": b"1", "b.txt": iter([b"2", b"3"])})
...     sorted(path.name for path in Path(name).iterdir())
['a.txt', 'b.txt']
"""

from __future__ import annotations

import os
import signal
import stat
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import TextIO

from camtools.base.errors import CamtoolsError
from camtools.base.leftovers import SUFFIX, held, sweep
from camtools.base.links import followed

_SIGNALS = {signal.SIGINT, signal.SIGTERM, signal.SIGHUP}


def file_target(path: Path) -> Path:
    """Return the file that a path stands for, symbolic links followed: they stay links.

    Raises
    ------
    CamtoolsError
        There is something that is no regular file: a name put in its place would destroy it; or a
        link of somebody else (camtools.base.links).
    OSError
        A folder on the way cannot be read.
    """
    place = followed(path)
    with suppress(FileNotFoundError):
        mode = place.stat().st_mode
        if not stat.S_ISREG(mode):
            what = "Is a directory" if stat.S_ISDIR(mode) else "not a regular file"
            raise CamtoolsError([f"{path}: cannot write: {what}; give the name of a file"])
    return Path(os.path.realpath(place))


def _write_temporary(
    target: Path, chunks: Iterable[bytes], made: list[Path], alive: ExitStack
) -> Path:
    prefix = f".{target.name}."
    sweep(target.parent, prefix)
    handle, path = tempfile.mkstemp(prefix=prefix, suffix=SUFFIX, dir=target.parent)
    made.append(Path(path))
    alive.enter_context(held(Path(path)))
    with os.fdopen(handle, "wb") as stream:
        os.fchmod(handle, 0o666 & ~_umask())
        stream.writelines(chunks)
        stream.flush()
        os.fsync(handle)
    return Path(path)


def _umask() -> int:
    mask = os.umask(0o022)
    os.umask(mask)
    return mask


@contextmanager
def signals_held() -> Iterator[None]:
    """Hold interrupts back while the finished files get their names."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, _SIGNALS)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def write_all(folder: Path, files: Mapping[str, bytes | Iterable[bytes]]) -> None:
    """Write files into a folder so that either all get their names or none does.

    Everything is written to temporary files and synchronised first; only then are they
    renamed, with interrupts held back. A name that is a symbolic link stays one: the file that it
    points to is replaced.

    Parameters
    ----------
    files : Mapping
        Content by name: whole, or in pieces that are asked for one by one, so that a file may
        be larger than the memory.

    Raises
    ------
    CamtoolsError
        The system refuses, or a name belongs to what is no regular file; nothing new is left
        behind, older files are as they were.
    """
    made: list[Path] = []
    alive = ExitStack()
    folders: list[Path] = []
    done = False
    try:
        missing = [path for path in (folder, *folder.parents) if not path.exists()]
        followed(folder).mkdir(parents=True, exist_ok=True)
        folders = missing  # innermost first
        targets = {name: file_target(folder / name) for name in files}
        finals = {
            targets[name]: _write_temporary(
                targets[name], [data] if isinstance(data, bytes) else data, made, alive
            )
            for name, data in files.items()
        }
        for target in finals:
            file_target(target)  # again: writing may have taken long
        with signals_held():
            for target, path in finals.items():
                path.replace(target)
        done = True
    except OSError as error:
        remedy = "give a folder that can be written and has room"
        reason = error.strerror or str(error)
        raise CamtoolsError([f"{folder}: cannot write: {reason}; {remedy}"]) from error
    finally:
        alive.close()
        if not done:
            for path in made:
                with suppress(OSError):
                    path.unlink()
            for path in folders:
                with suppress(OSError):
                    path.rmdir()


@contextmanager
def growing(path: Path) -> Iterator[TextIO]:
    """Write a text file bit by bit; it gets its name at the end, whatever the end is.

    Until then an older file stays; also when nothing was written. What is no ordinary file, such
    as a pipe, is written directly; a symbolic link stays one.

    Raises
    ------
    OSError
        The file cannot be made.
    """
    if path.exists() and not path.is_file():
        with path.open("w", newline="", encoding="utf-8") as stream:
            yield stream
        return
    path = Path(os.path.realpath(followed(path)))
    sweep(path.parent, f".{path.name}.")
    handle, name = tempfile.mkstemp(prefix=f".{path.name}.", suffix=SUFFIX, dir=path.parent)
    try:
        with held(Path(name)), os.fdopen(handle, "w", newline="", encoding="utf-8") as stream:
            os.fchmod(handle, 0o666 & ~_umask())
            yield stream
    finally:
        with signals_held():
            if Path(name).stat().st_size > 0:
                Path(name).replace(path)
            else:
                Path(name).unlink()
