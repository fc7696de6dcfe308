# SPDX-License-Identifier: Apache-2.0
"""A controller on a CAN bus that tools/camctl reaches over a socket, without a kernel's CAN.

The program can_bench is the firmware with an ideal machine; frames come and go on its standard
input and output, 16 bytes each. camctl reaches it through python-can's interface `socketcand`, a
text protocol; this is the server.
"""

from __future__ import annotations

import contextlib
import json
import socket
import struct
import subprocess
import threading
from pathlib import Path
from types import TracebackType
from typing import Self

from cantools.database.can import Database

FRAME = struct.Struct("<IB3x8s")
STATUS = ("State", "Spindle", "AxisU", "Detail")  # sent all the time
BLOCKS = ("Block", "BlockFlow")  # their number depends on the time that frames take

# What camctl is asked to do, one after the other. The numbers in the output of those in MASKED are
# measured ones.
MASKED = ("status", "record", "watch")
NOISE = "! Got incomplete message"  # of python-can, when a frame comes in two pieces
EXACT = ("speed", "feed", "amplitude", "phase")
LINES = """
status
list
get lead_ns counts_per_turn k1_ns
set engage_turns 7
set engage_turns 101
set engage_turn 5
list x?x
start
reset
speed 1500.5
feed 0.15
amplitude 50.5
amplitude 126
phase -12.25
get spindle_mrpm feed_nm amplitude_ppm phase_udeg
speed 3500
enable
speed 1500
home
status
start --wait
record x.csv --seconds 0.3
record folder --seconds 0.3
watch --seconds 0.3 --every 1
disable
status
table info
table download none.camtab
table download older
table download flipped.camtab
table download perkins240.camtab
table info
select
table info
table download perkins240.camtab --select
home
disable
-n 65 status
""".strip().splitlines()


class Controller:
    """The bench, its frames offered to one client at a time.

    Attributes
    ----------
    config : str
        what CAN_CONFIG must be for a client
    """

    def __init__(self, bench: Path, dbc: Path) -> None:
        database = Database()
        database.add_dbc_file(dbc)
        self._names = {message.frame_id: message.name for message in database.messages}
        self._process = subprocess.Popen(
            [str(bench)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
        )
        self._server = socket.create_server(("127.0.0.1", 0))
        self.config = json.dumps({"host": "127.0.0.1", "port": self._server.getsockname()[1]})
        self._client: socket.socket | None = None
        self._lock = threading.Lock()
        self._log: list[str] = []
        self._blocks: set[str] = set()
        self._status: set[str] = set()

    def __enter__(self) -> Self:
        """Start to serve."""
        for work in (self._serve, self._forward):
            threading.Thread(target=work, daemon=True).start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        value: BaseException | None,
        at: TracebackType | None,
    ) -> None:
        """End the bench."""
        self._server.close()
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait(10)

    def _note(self, mark: str, identifier: int, data: bytes) -> None:
        name = self._names.get(identifier, f"{identifier:03X}")
        with self._lock:
            if name in STATUS:
                self._status.add(f"{name} {identifier:03X}, {len(data)} bytes")
            elif name in BLOCKS:
                self._blocks.add(f"-- {name} {identifier:03X}")
            else:
                self._log.append(f"{mark} {name} {identifier:03X} {data.hex(' ')}")

    def _serve(self) -> None:
        with contextlib.suppress(OSError):
            while True:
                client, _ = self._server.accept()
                with contextlib.suppress(OSError), client:
                    self._talk(client)
                self._client = None

    def _talk(self, client: socket.socket) -> None:
        client.sendall(b"< hi >")
        text = ""
        while more := client.recv(4096).decode("ascii"):
            text += more
            while ">" in text:
                one, _, text = text.partition(">")
                self._take(client, one.strip("< ").split())

    def _take(self, client: socket.socket, words: list[str]) -> None:
        if words[0] in ("open", "rawmode"):
            client.sendall(b"< ok >")
            if words[0] == "rawmode":
                self._client = client
        elif words[0] == "send":
            identifier, data = int(words[1], 16), bytes(int(byte, 16) for byte in words[3:])
            self._note("->", identifier, data)
            assert self._process.stdin is not None
            self._process.stdin.write(FRAME.pack(identifier, len(data), data))
            self._process.stdin.flush()

    def _forward(self) -> None:
        assert self._process.stdout is not None
        while len(record := self._process.stdout.read(FRAME.size)) == FRAME.size:
            identifier, n, data = FRAME.unpack(record)
            self._note("<-", identifier, data[:n])
            client = self._client
            if client is not None:
                with contextlib.suppress(OSError):
                    client.sendall(f"< frame {identifier:03X} 0.0 {data[:n].hex()} >".encode())

    def frames(self) -> list[str]:
        """Return the frames since the last call, apart from the status.

        Of a command that was sent again, to a controller that was busy, the last answer counts.
        """
        with self._lock:
            told: list[str] = []
            for line in self._log:
                if line.startswith("->") and line in told:
                    del told[told.index(line) :]
                told.append(line)
            told += sorted(self._blocks)
            self._log, self._blocks = [], set()
        return told

    def periodic(self) -> list[str]:
        """Return the messages of the status with identifier and length."""
        return sorted(self._status)
