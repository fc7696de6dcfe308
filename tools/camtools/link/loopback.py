# SPDX-License-Identifier: Apache-2.0
"""The bus udp_multicast of python-can, where its frames shall stay on this computer.

python-can joins a group on the interface of the default route; a computer that is connected to
nothing has none. Here the group is joined on the loopback, which is always there. Other programs of
python-can on the same computer take part as ever.

>>> bus = LoopbackBus("239.74.163.2", port=43113)
>>> bus.send(can.Message(arbitration_id=1, is_extended_id=False))
>>> frame = bus.recv(1.0)
>>> bus.shutdown()
>>> frame.arbitration_id
1
"""

from __future__ import annotations

import socket

import can
from can.interfaces.udp_multicast.bus import (
    SO_TIMESTAMPNS,
    GeneralPurposeUdpMulticastBus,
    UdpMulticastBus,
)
from can.interfaces.udp_multicast.utils import is_msgpack_installed

_LOOPBACK = socket.inet_aton("127.0.0.1")


class _Socket(GeneralPurposeUdpMulticastBus):
    def _create_socket(self, address_family: socket.AddressFamily) -> socket.socket:
        sock = socket.socket(address_family, socket.SOCK_DGRAM)
        try:
            sock.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, _LOOPBACK)
            sock.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, self.hop_limit)
            sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
            sock.setsockopt(socket.SOL_SOCKET, SO_TIMESTAMPNS, 1)
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
        self._multicast = _Socket(channel, port, hop_limit=0)
        self._can_protocol = can.CanProtocol.CAN_FD
        self.channel_info = f"udp_multicast {channel} {port}"
