"""Files of the user: read whole and within bounds, written complete or not at all.

>>> try:
...     read_limited(Path("."), 10)
... except OSError as error:
...     print(error.strerror)
Is a directory

>>> with tempfile.TemporaryDirectory() as name:
...     write_all(Path(name), {"a.txt": b"1", "b.txt": iter([b"2", b"3"])})
...     with staged(Path(name)) as stage:
...         _ = (stage.folder / "c.txt").write_text("4")
...         stage.publish()
...     sorted(path.name for path in Path(name).iterdir())
['a.txt', 'b.txt', 'c.txt']
"""

import errno
import fcntl
import os
import shutil
import stat
import tempfile
import time
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import NamedTuple, TextIO

from camtools.base.errors import CamtoolsError, InputError
from camtools.base.signals import signals_held


def read_limited(path: Path, most_bytes: int) -> bytes:
    """Return the content of a file.

    Raises OSError: it cannot be read, is no regular file (a pipe would be waited for, a device may
    never end), or is larger; `strerror` says which.
    """
    mode = path.stat().st_mode
    if stat.S_ISDIR(mode):
        raise OSError(errno.EISDIR, os.strerror(errno.EISDIR))
    if not stat.S_ISREG(mode):
        raise OSError(errno.EINVAL, "not a file")
    with path.open("rb") as stream:
        data = stream.read(most_bytes + 1)
    if len(data) > most_bytes:
        raise OSError(errno.EFBIG, f"larger than {most_bytes} bytes")
    return data


@contextmanager
def path_errors(name: object) -> Iterator[None]:
    """Report what the system refuses about a path, named as the user gave it, in one line."""
    try:
        yield
    except OSError as error:
        raise CamtoolsError([f"{name}: {error.strerror}; check the path"]) from error


def read_private(path: Path, option: str) -> bytes:
    """Return what the small file of an option holds, which only its owner can read."""
    with path_errors(f"{option} {path}"):
        data = read_limited(path, 1024)
        is_private = not path.stat().st_mode & 0o077
    if not is_private:
        raise CamtoolsError([f"{option} {path}: others may read it; chmod 600 {path}"])
    return data


_UTF16_MARKS = (b"\xff\xfe", b"\xfe\xff")


def utf8_text(data: bytes, file: str) -> str:
    """Return UTF-8 text without the byte-order mark that Windows writes, or refuse it."""
    remedy = "save the file as UTF-8"
    is_latin16 = data[:2].count(0) == 1 and len(data) % 2 == 0  # its first letter has a byte of 0
    if data.startswith(_UTF16_MARKS) or is_latin16:
        raise InputError(file, "", None, "not UTF-8 text but UTF-16", remedy)
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        problem = f"not UTF-8 text (byte {error.start})"
        raise InputError(file, "", None, problem, remedy) from error


def read_text(path: Path, most_bytes: int) -> str:
    """Return the text of a file that a part file names; a mark of spreadsheets is left out.

    Raises InputError: it cannot be read, is no file or too large (`read_limited`), or is not UTF-8.
    """
    try:
        data = read_limited(path, most_bytes)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or "its path has a NUL"
        remedy = "give a text file, with its path relative to the part file"
        raise InputError(path.name, "", None, f"cannot be read: {reason}", remedy) from error
    return utf8_text(data, path.name)


_PREFIX, _SUFFIX = ".run.", ".tmp"
_NEW_S = 1.0  # between making and locking a hidden folder nobody else may remove it
_MOST_LINKS = 40  # as the kernel


def cannot_write(place: Path, error: OSError) -> CamtoolsError:
    """Return the error of a place that cannot be written, in one line."""
    reason = error.strerror or str(error)
    remedy = "give a folder that can be written and has room"
    return CamtoolsError([f"{place}: cannot write: {reason}; {remedy}"])


def _followed(path: Path) -> Path:
    """Return the target of a path whose last part may be a symbolic link of a trusted owner.

    In a folder that others can write to, a link that one of them planted under the name of a result
    would overwrite a file of ours. Only our own links and those of root are followed; links among
    the parent folders are left to the system (`fs.protected_symlinks`).
    """
    place = path
    for _ in range(_MOST_LINKS):
        if not place.is_symlink():
            return place
        if place.lstat().st_uid not in (os.geteuid(), 0):
            problem = "is a link of another user, which is not followed"
            raise CamtoolsError([f"{place}: {problem}; remove it, or give another folder"])
        place = place.parent / place.readlink()
    raise OSError(errno.ELOOP, os.strerror(errno.ELOOP))


def _target(path: Path) -> Path:
    """Return the regular file, existing or not, that a path stands for; a link stays a link."""
    place = _followed(path)
    with suppress(FileNotFoundError):
        mode = place.stat().st_mode
        if not stat.S_ISREG(mode):  # renaming a file over it would destroy it
            what = "Is a directory" if stat.S_ISDIR(mode) else "not a regular file"
            raise CamtoolsError([f"{path}: cannot write: {what}; give the name of a file"])
    return Path(os.path.realpath(place))


@contextmanager
def _made(folder: Path) -> Iterator[None]:
    """Make a folder and its missing parents; at the end remove those that stayed empty."""
    missing = [path for path in (folder, *folder.parents) if not path.exists()]  # innermost first
    try:
        _followed(folder).mkdir(parents=True, exist_ok=True)
        yield
    finally:
        for path in missing:
            with suppress(OSError):
                path.rmdir()


@contextmanager
def _opened(folder: Path) -> Iterator[int]:
    handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    try:
        yield handle
    finally:
        os.close(handle)


def _sweep(folder: Path) -> None:
    """Remove our own hidden folders whose process was killed: they are no longer locked."""
    for left in folder.glob(f"{_PREFIX}*{_SUFFIX}"):
        with suppress(OSError), _opened(left) as handle:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            about = os.fstat(handle)
            is_old = abs(time.time() - about.st_ctime) > _NEW_S
            if is_old and about.st_uid == os.geteuid():
                shutil.rmtree(left, ignore_errors=True)


@contextmanager
def _hidden(folder: Path) -> Iterator[Path]:
    """Make a hidden folder for unfinished files, absolute and locked while it is in use."""
    _sweep(folder)
    place = Path(tempfile.mkdtemp(prefix=_PREFIX, suffix=_SUFFIX, dir=folder)).resolve()
    try:
        with _opened(place) as handle:
            with suppress(OSError):  # some network file systems know no locks
                fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            yield place
    finally:
        with signals_held():
            shutil.rmtree(place, ignore_errors=True)


def _begun(stack: ExitStack, output: Path) -> Path:
    """Make a folder and a hidden one in it, again where another run removes the empty one."""
    while True:
        stack.enter_context(_made(output))
        with suppress(FileNotFoundError):
            return stack.enter_context(_hidden(output))


def _rename(finished: Mapping[Path, Path]) -> None:
    """Give every finished file its name, or none of them."""
    targets = {path: _target(name) for path, name in finished.items()}
    for path, target in targets.items():
        # Of folders: in stacked file systems a file has another device number than its folder.
        if path.parent.stat().st_dev != target.parent.stat().st_dev:
            raise OSError(errno.EXDEV, f"{os.strerror(errno.EXDEV)}: {target.name}")
        with path.open("rb") as stream:
            os.fsync(stream.fileno())
    with signals_held():
        for path, target in targets.items():
            path.replace(target)


def write_all(folder: Path, files: Mapping[str, bytes | Iterable[bytes]]) -> None:
    """Write files into a folder so that either all get their names or none does.

    A name that is a symbolic link stays one: the file that it points to is replaced. Content may
    come in pieces, asked for one by one, so that a file may be larger than the memory. Raises
    CamtoolsError: the system refuses, a name belongs to what is no regular file, or a link to
    another user; older files are as they were.
    """
    finished: dict[Path, Path] = {}
    try:
        with _made(folder), ExitStack() as stack:
            targets = {name: _target(folder / name) for name in files}
            parents = {target.parent for target in targets.values()}
            hidden = {parent: stack.enter_context(_hidden(parent)) for parent in parents}
            for name, data in files.items():
                path = hidden[targets[name].parent] / targets[name].name
                with path.open("wb") as stream:
                    stream.writelines([data] if isinstance(data, bytes) else data)
                finished[path] = targets[name]
            _rename(finished)
    except OSError as error:
        raise cannot_write(folder, error) from error


class Stage(NamedTuple):
    """A hidden folder inside an output folder."""

    output: Path
    folder: Path  # absolute; write everything here

    def publish(self) -> None:
        """Move every file into the output folder, over those of earlier runs."""
        files = sorted(path for path in self.folder.iterdir() if path.is_file())
        try:
            _rename({path: self.output / path.name for path in files})
        except OSError as error:
            raise cannot_write(self.output, error) from error


@contextmanager
def staged(output: Path) -> Iterator[Stage]:
    """Give a hidden folder for the results of a run, gone at the end.

    The output folder is made when missing, and removed again when nothing is published. Raises
    CamtoolsError: on entering and publishing: the output folder cannot be written.
    """
    with ExitStack() as stack:
        try:
            with signals_held():
                folder = _begun(stack, output)
        except OSError as error:
            raise cannot_write(output, error) from error
        yield Stage(output, folder)


@contextmanager
def growing(path: Path) -> Iterator[TextIO]:
    """Write a text file bit by bit; it gets its name at the end, whatever the end is.

    Until then an older file stays; also when nothing was written. What is no ordinary file, such as
    a pipe, is written directly; a symbolic link stays one. Raises OSError: the file cannot be made.
    """
    if path.exists() and not path.is_file():
        with path.open("w", newline="", encoding="utf-8") as stream:
            yield stream
        return
    target = _target(path)
    with _hidden(target.parent) as folder:
        part = folder / target.name
        part.touch()
        try:
            with part.open("w", newline="", encoding="utf-8") as stream:
                yield stream
        finally:
            if part.stat().st_size > 0:
                with signals_held():
                    part.replace(target)
