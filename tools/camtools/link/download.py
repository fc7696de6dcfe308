"""Brings a table image or a wave to a controller: blocks over ISO-TP, each acknowledged.

firmware/remote/can/README.md describes the protocol. A block whose acknowledgement names another
place is repeated from there, as often as blocks may get lost.
"""

from __future__ import annotations

import time
import zlib
from collections.abc import Callable

import isotp

from camtools.base.errors import CamtoolsError
from camtools.link.controller import BLOCK_ID, FLOW_ID, Link
from camtools.link.messages import Refused
from camtools.link.refusal_text import require

BLOCK_BYTES = 4096
BEGIN_S = 60.0  # erasing flash: up to 4 s for each 128 KiB
CHECK_S = 10.0
BLOCK_S = 5.0
MOST_REPEATS = 5
_HEADER_BYTES = 128


def send_block(link: Link, block: bytes) -> None:
    """Send one message by ISO 15765-2, with the flow control of the controller."""
    problems: list[Exception] = []

    def receive(timeout_s: float) -> isotp.CanMessage | None:
        link.wait(lambda: bool(link.flows), timeout_s)
        if not link.flows:
            return None
        frame = link.flows.popleft()
        return isotp.CanMessage(frame.arbitration_id, frame.dlc, bytes(frame.data))

    layer = isotp.TransportLayerLogic(
        receive,
        lambda frame: link.send_frame(frame.arbitration_id, bytes(frame.data)),
        isotp.Address(isotp.AddressingMode.Normal_11bits, txid=BLOCK_ID, rxid=FLOW_ID),
        error_handler=problems.append,
    )
    link.flows.clear()
    layer.send(block)
    while layer.transmitting() and not problems:
        layer.process(rx_timeout=0.001 if layer.is_tx_transmitting_cf() else 0.01)
    if problems:
        layer.stop_sending()
        raise Refused(f"{link.where}: block not sent: {problems[0]}")


def _give(link: Link, image: bytes, at: int, remedy: str) -> int:
    """Send a block; return where the next one begins."""
    for _ in range(MOST_REPEATS):
        part = image[at : at + BLOCK_BYTES]
        try:
            send_block(link, at.to_bytes(4, "little") + part)
            answer = link.next_answer("download_block", BLOCK_S)
        except Refused as error:
            problem = str(error)
            link.wait(lambda: False, 1.2)  # the controller gives the rest of the block up
            continue
        if answer.result == "done":
            return at + len(part)
        problem = f"{link.where}: block at {at}: {answer.result}"
        if answer.result != "download_order" or answer.value > at:
            break
        at = int(answer.value)
    raise Refused(f"{problem}; {remedy}")


def bring(link: Link, data: bytes, remedy: str, progress: Callable[[int, float], None]) -> None:
    """Bring bytes to the controller, where a download was begun.

    remedy: what to do if that fails; progress: called with [bytes] that are stored and [s] since
    the begin. Raises Refused: the controller refuses, or the bus loses too much.
    """
    start_s, at = time.monotonic(), 0
    while at < len(data):
        at = _give(link, data, at, remedy)
        progress(at, time.monotonic() - start_s)


def check_image(image: bytes, name: str) -> None:
    """Refuse bytes that are no table image, by length and first letters."""
    if len(image) < _HEADER_BYTES or not image.startswith(b"CAMTAB"):
        raise CamtoolsError([f"{name}: not a cam table; make one by tools/mktables"])


def download(link: Link, image: bytes, progress: Callable[[int, float], None]) -> None:
    """Bring an image into the place that is not in use, and have it checked there.

    progress: as that of bring(). Raises Refused: the controller refuses, or the bus loses too much.
    The old table stays in force.
    """
    begin = link.ask("begin_download", timeout_s=BEGIN_S, size=len(image))
    require(link, begin, "begin download")
    bring(link, image, "the old table stays in force, download again", progress)
    end = link.ask("end_download", timeout_s=CHECK_S, crc=zlib.crc32(image))
    require(link, end, "end download")


def select_table(link: Link) -> None:
    """Take the downloaded table into use, or check that in its place anew; else the old stays."""
    require(link, link.ask("select_table", timeout_s=CHECK_S), "select table")
    link.status.signals.clear()
    link.listen()
