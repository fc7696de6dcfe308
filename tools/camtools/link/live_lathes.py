"""Live lathes of this user: announced in files, found by others, joined to a bus.

The file lies in a folder that nobody else can read. It holds number and start time of the process
that made it, so that a stale file is recognised and removed.

>>> import tempfile
>>> folder = Path(tempfile.mkdtemp())
>>> with announced(folder, "demo", {"bus": {"interface": "virtual"}, "node": 64}) as lathe:
...     [found.name for found in live_lathes(folder)], lathe.bus
(['demo'], {'interface': 'virtual'})
>>> live_lathes(folder)
[]

>>> unpacked(packed(can.Message(arbitration_id=0x640, data=b"12", is_extended_id=False))).data
bytearray(b'12')
"""

from __future__ import annotations

import json
import os
import stat
import struct
import tempfile
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import can

from camtools.base.errors import CamtoolsError
from camtools.link.bus import remedy_for

_START_FIELD = 19  # of /proc/PID/stat, behind the name in brackets: when it was started


@dataclass(frozen=True)
class LiveLathe:
    """What a live lathe announces."""

    name: str  # by which camctl --live finds it
    bus: dict[str, Any]  # arguments of can.Bus
    node: int  # of the controller
    facts: dict[str, Any]  # all of it, with `pid` and `start` of the process


def runtime_folder() -> Path:
    """Return the folder of the announcements, made when missing; others must not write there."""
    given = os.environ.get("XDG_RUNTIME_DIR")
    own = Path(tempfile.gettempdir()) / f"camturn-{os.getuid()}"
    folder = Path(given) / "camturn" if given and Path(given).is_dir() else own
    try:
        folder.mkdir(mode=0o700, exist_ok=True)
        facts = folder.lstat()
    except OSError as error:
        raise CamtoolsError([f"{folder}: {error.strerror}; set XDG_RUNTIME_DIR"]) from error
    is_private = facts.st_uid == os.getuid() and not facts.st_mode & 0o077
    if not stat.S_ISDIR(facts.st_mode) or not is_private:
        problem = "not a folder that only you can access (mode 0700)"
        raise CamtoolsError([f"{folder}: {problem}; remove it, or set XDG_RUNTIME_DIR"])
    return folder


def start_of(pid: int) -> str:
    """Return when a process was started, in the kernel's time; nothing when there is none."""
    try:
        text = Path(f"/proc/{pid}/stat").read_text("utf-8")
    except OSError:
        return ""
    return text.rpartition(")")[2].split()[_START_FIELD]


def _read(path: Path) -> LiveLathe | None:
    """Return an announcement whose process lives; one that is stale is removed."""
    try:
        facts = json.loads(path.read_text("utf-8"))
        is_alive = start_of(int(facts["pid"])) == facts["start"]
        lathe = LiveLathe(path.stem, dict(facts["bus"]), int(facts["node"]), facts)
    except FileNotFoundError:
        return None
    except (OSError, ValueError, KeyError, TypeError):
        is_alive, lathe = False, None
    if not is_alive:
        with suppress(OSError):
            path.unlink()
        return None
    return lathe


def live_lathes(folder: Path | None = None) -> list[LiveLathe]:
    """Return the live lathes of this user, by their names."""
    paths = sorted((folder or runtime_folder()).glob("*.json"))
    return [lathe for lathe in map(_read, paths) if lathe is not None]


def only_lathe(name: str | None) -> LiveLathe | None:
    """Return the live lathe of a name, or the only one there is; several need a name."""
    found = live_lathes()
    names = ", ".join(lathe.name for lathe in found)
    if name is not None:
        named = next((lathe for lathe in found if lathe.name == name), None)
        if named is None:
            there = f"there is {names}" if found else "start tools/live"
            raise CamtoolsError([f"--live {name}: no such live lathe; {there}"])
        return named
    if len(found) > 1:
        problem = f"{len(found)} live lathes are running: {names}"
        raise CamtoolsError([f"{problem}; give --live NAME"])
    return found[0] if found else None


@contextmanager
def announced(folder: Path, name: str, facts: Mapping[str, Any]) -> Iterator[LiveLathe]:
    """Announce a live lathe of this process, by a free name that begins like the given one.

    facts: `bus`, arguments of can.Bus; `node`, number of the controller; anything else.
    Raises CamtoolsError: the folder cannot be written.
    """
    whole = dict(facts) | {"pid": os.getpid(), "start": start_of(os.getpid())}
    taken = {lathe.name for lathe in live_lathes(folder)}
    names = (name, *(f"{name}-{i}" for i in range(2, len(taken) + 3)))
    path = None
    try:
        handle, hidden = tempfile.mkstemp(prefix=".live.", dir=folder)
        try:
            with os.fdopen(handle, "w", encoding="utf-8") as stream:
                stream.write(json.dumps(whole, indent=1) + "\n")
            path = _first_free(folder, hidden, names)
        finally:
            Path(hidden).unlink()
        yield LiveLathe(path.stem, dict(whole["bus"]), int(whole["node"]), whole)
    except OSError as error:
        raise CamtoolsError([f"{folder}: {error.strerror}; set XDG_RUNTIME_DIR"]) from error
    finally:
        if path is not None:
            path.unlink(missing_ok=True)


def _first_free(folder: Path, hidden: str, names: tuple[str, ...]) -> Path:
    """Give a file the first of some names that nobody has."""
    for name in names:
        with suppress(FileExistsError):
            os.link(hidden, folder / f"{name}.json")
            return folder / f"{name}.json"
    raise CamtoolsError([f"{folder}: every name is taken; give --name"])


_FRAME = struct.Struct("=II64s")
_CLASSIC_BYTES = 8
_WAIT_S = 0.05
_STOP_S = 1.0


def packed(frame: can.Message) -> bytes:
    """Return a frame for the controller."""
    return _FRAME.pack(frame.arbitration_id, len(frame.data), bytes(frame.data))


def unpacked(record: bytes) -> can.Message:
    """Return a frame of the controller."""
    identifier, n, data = _FRAME.unpack(record)
    is_fd = n > _CLASSIC_BYTES
    return can.Message(
        arbitration_id=identifier, data=data[:n], is_extended_id=False, is_fd=is_fd, check=True
    )


class Bridge:
    """Two threads that carry frames until the controller or the bus is gone.

    A frame with an identifier that the controller sends itself is not carried to it: a bus may hand
    everybody his own frames. to_controller, from_controller: pipes, which stay open. spoke: set by
    the first frame of the controller. problem: why frames are carried no more; "" while they are,
    and when the controller has ended. where: what `open_bus` calls the bus.
    """

    def __init__(
        self, bus: can.BusABC, where: str, to_controller: int, from_controller: int
    ) -> None:
        self.spoke, self.problem = threading.Event(), ""
        self._bus, self._where = bus, where
        self._to, self._from = to_controller, from_controller
        self._own: set[int] = set()
        self._is_over = False
        self._threads = [threading.Thread(target=carry) for carry in (self._forth, self._back)]
        for thread in self._threads:
            thread.start()

    def _forth(self) -> None:
        try:
            while not self._is_over:
                frame = self._bus.recv(_WAIT_S)
                if frame is None or frame.arbitration_id in self._own:
                    continue
                if not (frame.is_error_frame or frame.is_remote_frame or frame.is_extended_id):
                    os.write(self._to, packed(frame))
        except BrokenPipeError:
            return  # the controller has ended
        except (can.CanError, OSError) as error:
            remedy = remedy_for(error, self._where)
            self.problem = f"the connection to the bus is lost: {error}; {remedy}"

    def _back(self) -> None:
        rest = b""
        while data := os.read(self._from, 1 << 16):
            rest += data
            n_whole = len(rest) // _FRAME.size * _FRAME.size
            for at in range(0, n_whole, _FRAME.size):
                self._say(unpacked(rest[at : at + _FRAME.size]))
            rest = rest[n_whole:]

    def _say(self, frame: can.Message) -> None:
        self._own.add(frame.arbitration_id)
        self.spoke.set()
        try:
            self._bus.send(frame)
        except (can.CanError, OSError) as error:
            self.problem = f"a frame cannot be sent: {error}; {remedy_for(error, self._where)}"

    def stop(self) -> None:
        """Carry nothing to the controller any more, so that its pipe can be closed."""
        self._is_over = True
        self._threads[0].join(_STOP_S)  # longer only where the controller reads nothing

    def close(self) -> None:
        """Wait for both threads; the controller must have ended."""
        self._is_over = True
        for thread in self._threads:
            thread.join()
