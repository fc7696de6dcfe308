# SPDX-License-Identifier: Apache-2.0
"""The bus udp_multicast of python-can, where its frames shall stay on this computer.

python-can joins a group on the interface of the default route; a computer that is connected to
nothing has none. Here the group is joined on the loopback, which is always there. Other programs of
python-can on the same computer take part as ever. The kernel hands everybody his own frames, too:
they are known by the socket that sent them and dropped unread, so that many of them cannot crowd
out those of others.

>>> one, other = (LoopbackBus("239.74.163.2", port=43113) for _ in range(2))
>>> one.send(can.Message(arbitration_id=1, is_extended_id=False))
>>> frame = other.recv(1.0)
>>> frame.arbitration_id, one.recv(0.01)
(1, None)
>>> one.shutdown(), other.shutdown()
(None, None)
"""

from __future__ import annotations

import socket

import can
from can.interfaces.udp_multicast.bus import (
    SO_TIMESTAMPNS,
    GeneralPurposeUdpMulticastBus,
    UdpMulticastBus,
)
from can.interfaces.udp_multicast.utils import is_msgpack_installed, unpack_message

# As much as the kernel gives: a reader that waits for its turn on a busy computer loses nothing.
_BUFFER_BYTES = 4 << 20
_LOOPBACK = socket.inet_aton("127.0.0.1")


class _Socket(GeneralPurposeUdpMulticastBus):
    """Listens on the port of the group, and speaks from a port of its own."""

    def __init__(self, group: str, port: int) -> None:
        super().__init__(group, port, hop_limit=0)
        self._speaker = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._speaker.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, _LOOPBACK)
        self._speaker.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
        self._speaker.bind(("127.0.0.1", 0))
        self.own = self._speaker.getsockname()

    def send(self, data: bytes, timeout: float | None = None) -> None:
        try:
            self._speaker.sendto(data, (self.group, self.port))
        except OSError as error:
            raise can.CanOperationError(f"failed to send: {error.strerror}") from error

    def shutdown(self) -> None:
        super().shutdown()
        self._speaker.close()

    def _create_socket(self, address_family: socket.AddressFamily) -> socket.socket:
        sock = socket.socket(address_family, socket.SOCK_DGRAM)
        try:
            sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
            sock.setsockopt(socket.SOL_SOCKET, SO_TIMESTAMPNS, 1)
            sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _BUFFER_BYTES)
            sock.bind(("", self.port))
            member = socket.inet_aton(self.group) + _LOOPBACK
            sock.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, member)
        except OSError:
            sock.close()
            raise
        self.timestamp_nanosecond = True
        return sock


class LoopbackBus(UdpMulticastBus):
    """Frames in UDP packets that never leave this computer.

    Parameters
    ----------
    channel : str
        group, an IPv4 address 224.0.0.0/4
    port : int
        of UDP, which tells one bus from another
    """

    def __init__(self, channel: str, port: int) -> None:
        is_msgpack_installed()
        can.BusABC.__init__(self, channel)
        both = _Socket(channel, port)
        self._multicast, self._own = both, both.own
        self._can_protocol = can.CanProtocol.CAN_FD
        self.channel_info = f"udp_multicast {channel} {port}"

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        got = self._multicast.recv(timeout)
        while got is not None and got[1] == self._own:
            got = self._multicast.recv(0)
        if got is None:
            return None, False
        return unpack_message(got[0], replace={"timestamp": got[2]}), False
