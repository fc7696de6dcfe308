# SPDX-License-Identifier: Apache-2.0
"""Joins a bus to a controller that speaks over two pipes: frames as hal_can_frame_t lies in memory.

>>> unpacked(packed(can.Message(arbitration_id=0x640, data=b"12", is_extended_id=False))).data
bytearray(b'12')
"""

from __future__ import annotations

import os
import struct
import threading

import can

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

    A frame with an identifier that the controller sends itself is not carried to it: a bus may
    hand everybody his own frames.

    Parameters
    ----------
    bus : can.BusABC
        open
    to_controller, from_controller : int
        descriptors of the pipes; they stay open

    Attributes
    ----------
    spoke : threading.Event
        the controller has sent its first frame
    problem : str
        why frames are carried no more; "" while they are, and when the controller has ended
    """

    def __init__(self, bus: can.BusABC, to_controller: int, from_controller: int) -> None:
        self.spoke, self.problem = threading.Event(), ""
        self._bus, self._to, self._from = bus, to_controller, from_controller
        self._own: set[int] = set()
        self._is_over = False
        self._threads = [threading.Thread(target=one) for one in (self._forth, self._back)]
        for thread in self._threads:
            thread.start()

    def _forth(self) -> None:
        try:
            while not self._is_over:
                frame = self._bus.recv(_WAIT_S)
                if frame is not None and self._is_for_controller(frame):
                    os.write(self._to, packed(frame))
        except BrokenPipeError:
            return  # the controller has ended
        except (can.CanError, OSError) as error:
            self.problem = f"the bus is gone: {error}"

    def _is_for_controller(self, frame: can.Message) -> bool:
        is_foreign = frame.is_error_frame or frame.is_remote_frame or frame.is_extended_id
        return not is_foreign and frame.arbitration_id not in self._own

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
            self.problem = f"a frame cannot be sent: {error}"

    def stop(self) -> None:
        """Carry nothing to the controller any more, so that its pipe can be closed."""
        self._is_over = True
        self._threads[0].join(_STOP_S)  # longer only where the controller reads nothing

    def close(self) -> None:
        """Wait for both threads; the controller must have ended."""
        self._is_over = True
        for thread in self._threads:
            thread.join()
