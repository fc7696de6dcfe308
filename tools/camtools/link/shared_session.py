# SPDX-License-Identifier: Apache-2.0
"""A session of command that the programs of one sender share, told in a file of this user alone.

While one camctl cuts a part, a second one of the same user may hold the feed: it is the same
sender, so it gives its orders in the same session. Another user, or another --sender, is another.

>>> import tempfile
>>> folder = Path(tempfile.mkdtemp())
>>> one = SharedSession("virtual demo", 64, 12, folder)
>>> one.tell(7), one.read(), SharedSession("virtual demo", 64, 13, folder).read()
(None, 7, 0)
>>> one.tell(0), one.read()
(None, 0)
"""

from __future__ import annotations

import json
import os
import zlib
from contextlib import suppress
from pathlib import Path

from camtools.link.live_lathes import runtime_folder, start_of


class SharedSession:
    """The file of the session of a sender at a controller.

    Parameters
    ----------
    where : str
        how the bus is called in messages
    node, sender : int
        of the controller, and of who commands it
    folder : Path, optional
        of this user alone; default: that of the live lathes
    """

    def __init__(self, where: str, node: int, sender: int, folder: Path | None = None) -> None:
        bus = zlib.crc32(where.encode())
        home = runtime_folder() if folder is None else folder
        self._path = home / f"command-{bus:08x}-{node}-{sender}.session"

    def tell(self, session: int) -> None:
        """Write the session of this process; 0 removes what this process wrote."""
        own = {"session": session, "pid": os.getpid(), "start": start_of(os.getpid())}
        with suppress(OSError):  # without the file the others take command themselves
            if session:
                hidden = self._path.with_suffix(f".{os.getpid()}")
                hidden.write_text(json.dumps(own), "utf-8")
                hidden.replace(self._path)
            elif self._read().get("pid") == os.getpid():
                self._path.unlink()

    def read(self) -> int:
        """Return the session that a process which lives has told; 0: there is none."""
        facts = self._read()
        pid, session = facts.get("pid"), facts.get("session")
        if not isinstance(pid, int) or not isinstance(session, int):
            return 0
        if not facts.get("start") or start_of(pid) != facts["start"]:
            with suppress(OSError):
                self._path.unlink()  # its process was killed
            return 0
        return session if 0 < session < 256 else 0

    def _read(self) -> dict[str, object]:
        try:
            facts = json.loads(self._path.read_text("utf-8"))
        except (OSError, ValueError):
            return {}
        return facts if isinstance(facts, dict) else {}
