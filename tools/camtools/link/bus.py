"""A bus of python-can, opened; an error names the cause and the remedy in one line.

python-can joins a group on the interface of the default route; a computer that is connected to
nothing has none. Here the group is joined on the loopback, which is always there. Other programs of
python-can on the same computer take part as ever. The kernel hands everybody his own frames, too:
they are known by the socket that sent them and dropped unread, so that many of them cannot crowd
out those of others.

>>> sender, receiver = (LoopbackBus("239.74.163.2", port=43113) for _ in range(2))
>>> sender.send(can.Message(arbitration_id=1, is_extended_id=False))
>>> frame = receiver.recv(1.0)
>>> frame.arbitration_id, sender.recv(0.01)
(1, None)
>>> sender.shutdown(), receiver.shutdown()
(None, None)

>>> bus, where = open_bus({"interface": "virtual", "channel": "demo"})
>>> bus.shutdown()
>>> where
'virtual demo'
"""

from __future__ import annotations

import difflib
import errno
import importlib
import inspect
import logging
import os
import socket
from collections.abc import Mapping
from typing import Any

import can
import can.util
from can.interfaces import BACKENDS
from can.interfaces.udp_multicast.bus import (
    SO_TIMESTAMPNS,
    GeneralPurposeUdpMulticastBus,
    UdpMulticastBus,
)
from can.interfaces.udp_multicast.utils import is_msgpack_installed, unpack_message

from camtools.base.errors import CamtoolsError

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
            for option in (socket.SO_REUSEADDR, socket.SO_REUSEPORT, SO_TIMESTAMPNS):
                sock.setsockopt(socket.SOL_SOCKET, option, 1)
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
    """Frames in UDP packets to a group (an IPv4 address) that never leave this computer."""

    def __init__(self, channel: str, port: int) -> None:
        is_msgpack_installed()
        can.BusABC.__init__(self, channel)
        sock = _Socket(channel, port)
        self._multicast, self._own = sock, sock.own
        self._can_protocol = can.CanProtocol.CAN_FD
        self.channel_info = f"udp_multicast {channel} {port}"

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        got = self._multicast.recv(timeout)
        while got is not None and got[1] == self._own:
            got = self._multicast.recv(0)
        if got is None:
            return None, False
        return unpack_message(got[0], replace={"timestamp": got[2]}), False


NO_BUS = "give --interface and --channel, or set CAN_INTERFACE and CAN_CHANNEL, or start tools/live"
_PIP = "install it: build/venv/bin/uv pip install "
# Python packages that a driver of python-can needs besides.
_PACKAGES = {
    "canalystii": "canalystii",
    "cantact": "cantact",
    "gs_usb": "gs-usb",
    "neovi": "python-ics",
    "robotell": "pyserial",
    "seeedstudio": "pyserial",
    "serial": "pyserial",
    "slcan": "pyserial",
    "udp_multicast": "msgpack",
}
_DRIVERS = {
    "kvaser": "needs Kvaser's CANlib; install linuxcan of kvaser.com",
    "neousys": "needs Neousys' library WDT_DIO; install it from the maker's medium",
    "pcan": "needs PEAK's PCAN-Basic; install it from peak-system.com, or use the kernel's driver "
    "by --interface socketcan",
}
_WINDOWS = ("etas", "iscan", "ixxat", "nican", "nixnet", "systec", "usb2can", "vector")
_ERRNO = {
    errno.EAFNOSUPPORT: "this kernel has no CAN; load can and can-raw, or use tools/live",
    errno.ENODEV: "no such network interface; ip link lists them",
    errno.ENETDOWN: "bring the interface up: ip link set {channel} up, with the bus's bit rate",
    errno.EPERM: "this user has no permission; check that of the device",
    errno.EACCES: "this user has no permission; check that of the device",
}


def remedy_for(error: BaseException, where: str, otherwise: str = "see its cable and power") -> str:
    """Return the remedy of an error of a bus by its number, or of its cause's.

    `where` is what `open_bus` calls the bus.
    """
    numbers = (
        getattr(raised, name, None)
        for raised in (error, error.__cause__)
        for name in ("errno", "error_code")
    )
    remedy = next((_ERRNO[number] for number in numbers if number in _ERRNO), otherwise)
    return remedy.replace("{channel}", [*where.split(), ".."][1])


def configured(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return what is given, completed by the environment and the configuration file."""
    return {**can.util.load_file_config(), **can.util.load_environment_config(), **given}


def _wanted(interface: str) -> list[str]:
    """Return the arguments that a driver cannot do without."""
    module, name = BACKENDS[interface]
    driver = getattr(importlib.import_module(module), name)
    arguments = inspect.signature(driver).parameters.values()
    return [
        parameter.name
        for parameter in arguments
        if parameter.default is parameter.empty
        and parameter.kind is parameter.POSITIONAL_OR_KEYWORD
    ]


def _option(name: str) -> str:
    return f"--{name} .." if name in ("channel", "bitrate") else f"--option {name}=.."


def _lacking(where: str, given: Mapping[str, Any], error: Exception) -> str:
    """Return why a driver does not open, and the remedy."""
    interface = str(given["interface"])
    if isinstance(error, TypeError):
        missing = [name for name in _wanted(interface) if name not in given]
        if missing:
            return f"needs {', '.join(missing)}; give {' '.join(map(_option, missing))}"
    if interface in _WINDOWS:
        return "python-can drives it on Windows only; use another interface"
    is_missing = isinstance(error, ImportError | NotImplementedError)
    if is_missing and interface in _PACKAGES:
        package = _PACKAGES[interface]
        return f"needs the Python package {package}; {_PIP}{package}"
    if interface in _DRIVERS and (is_missing or isinstance(error, OSError)):
        return _DRIVERS[interface]
    if interface == "socketcand":
        return f"{error}; start the daemon there, or correct host and port"
    return f"{error}; {remedy_for(error, where, 'see its options in the manual of python-can')}"


def _is_loopback(asked: Mapping[str, Any]) -> bool:
    """Return whether frames shall stay on this computer."""
    is_here = asked.get("interface") == "udp_multicast" and str(asked.get("hop_limit")) == "0"
    return is_here and "channel" in asked and "port" in asked and ":" not in str(asked["channel"])


def _checked(bus: can.BusABC) -> can.BusABC:
    """Return a bus, or raise what its socket has to report, as that its interface is down."""
    raw = getattr(bus, "socket", None)
    number = raw.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR) if raw is not None else 0
    if number:
        bus.shutdown()
        raise OSError(number, os.strerror(number))
    return bus


def open_bus(given: Mapping[str, Any]) -> tuple[can.BusABC, str]:
    """Return an open bus, and how to call it in messages.

    given: arguments of can.Bus; what is missing comes from the environment or python-can's file.
    Raises CamtoolsError: it cannot be opened.
    """
    asked = configured(given)
    interface = asked.get("interface")
    if interface is None:
        raise CamtoolsError([f"no bus: {NO_BUS}"])
    if interface not in BACKENDS and interface not in can.VALID_INTERFACES:
        near = difflib.get_close_matches(str(interface), can.VALID_INTERFACES, 1)
        known = f"did you mean {near[0]}?" if near else f"it has {', '.join(sorted(BACKENDS))}"
        raise CamtoolsError([f"interface {interface}: unknown to python-can; {known}"])
    place = " ".join([str(interface), *(str(asked[n]) for n in ("channel", "port") if n in asked)])
    logging.getLogger("can").setLevel(logging.CRITICAL)  # drivers log what the error below reports
    try:
        if _is_loopback(asked):
            return LoopbackBus(str(asked["channel"]), int(asked["port"])), place
        return _checked(can.Bus(**given)), place
    except Exception as error:  # a driver of strangers raises what it likes
        raise CamtoolsError([f"{place}: {_lacking(place, asked, error)}"]) from error
