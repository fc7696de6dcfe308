"""Every interface of python-can opens, or one line says what is missing."""

import errno
import io
import socket
from types import SimpleNamespace

import can
import pytest

from camtools.base.errors import CamtoolsError
from camtools.cli.camctl import main
from camtools.link import bus as module
from camtools.link.bus import open_bus
from camtools.link.controller import Link
from camtools.link.messages import Refused

pytestmark = pytest.mark.usefixtures("no_bus")

OPENS = {"virtual", "udp_multicast"}
UNKNOWN = "see its options in the manual"


@pytest.mark.parametrize("interface", sorted(can.VALID_INTERFACES - OPENS - {"socketcan"}))
@pytest.mark.parametrize("channel", [None, "can0"])
def test_an_interface_without_its_device_says_what_is_missing(
    interface: str, channel: str | None, capsys: pytest.CaptureFixture[str]
) -> None:
    """No traceback, one line with a remedy, status 2."""
    words = ["-i", interface, *(["-c", channel] if channel else [])]
    assert main([*words, "status"], io.StringIO()) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"camctl: {interface}") and "; " in line
    assert UNKNOWN not in line or interface == "kvaser"  # whose channel is a number


def test_socketcan_without_its_interface_says_so() -> None:
    """Whether the kernel has CAN or not."""
    with pytest.raises(CamtoolsError, match=r"^socketcan nocan0: .*; |: .* no CAN; "):
        open_bus({"interface": "socketcan", "channel": "nocan0"})


BRING_UP = "Network is down.*; bring the interface up: ip link set {} up"


class _Down(socket.socket):
    """A socket that reports, as one of SocketCAN when bound, that its interface is down."""

    def getsockopt(self, *_: object) -> int:  # type: ignore[override]
        return errno.ENETDOWN


def test_an_interface_that_is_down_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """With cause and remedy, when it is opened; python-can does not look."""
    closed: list[bool] = []
    with _Down() as raw:
        bus = SimpleNamespace(socket=raw, shutdown=lambda: closed.append(True))
        monkeypatch.setattr(can, "Bus", lambda **_: bus)
        with pytest.raises(CamtoolsError, match=f"^socketcan can0: .*{BRING_UP.format('can0')}"):
            open_bus({"interface": "socketcan", "channel": "can0"})
    assert closed


@pytest.mark.parametrize("name", ["recv", "send"])
def test_an_interface_that_goes_down_is_named(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """By python-can's error, with or without the number of the system's."""

    def fails(*_: object, **__: object) -> None:
        raise can.CanOperationError("Failed: Network is down", errno.ENETDOWN)

    bus, where = open_bus({"interface": "virtual", "channel": name})
    monkeypatch.setattr(bus, name, fails)
    link = Link(bus, where)
    with pytest.raises(Refused, match=f"^virtual {name}: .*{BRING_UP.format(name)}"):
        link.pump(0.1) if name == "recv" else link.send_frame(1, b"")
    bus.shutdown()


def test_the_arguments_that_an_interface_lacks_are_named() -> None:
    """With the options that give them."""
    with pytest.raises(CamtoolsError) as raised:
        open_bus({"interface": "socketcand", "channel": "can0"})
    assert str(raised.value) == (
        "socketcand can0: needs host, port; give --option host=.. --option port=.."
    )


def test_a_package_that_is_missing_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    """udp_multicast wants msgpack, which is in the lock file; here it is not."""
    monkeypatch.setattr("can.interfaces.udp_multicast.utils.msgpack", None)
    for own in ({}, {"hop_limit": 0}):
        asked = {"interface": "udp_multicast", "channel": "239.74.163.2", "port": 43113, **own}
        with pytest.raises(CamtoolsError, match="needs the Python package msgpack; install it: "):
            open_bus(asked)


def test_frames_of_the_loopback_reach_other_programs_of_python_can() -> None:
    """Both ways, though one end has joined the group on the default route."""
    group, port = "239.74.163.2", 43999
    asked = {"interface": "udp_multicast", "channel": group, "port": port, "hop_limit": 0}
    ours, _ = open_bus(asked)
    try:
        theirs = can.Bus(interface="udp_multicast", channel=group, port=port)
    except can.CanError:
        ours.shutdown()
        pytest.skip("this computer has no route for python-can's own socket")
    for speaker, listener in ((ours, theirs), (theirs, ours)):
        speaker.send(can.Message(arbitration_id=7, is_extended_id=False, data=b"\x01"))
        frame = listener.recv(1.0)
        while frame is not None and listener.recv(0) is not None:
            pass
        assert frame is not None and frame.arbitration_id == 7
    ours.shutdown()
    theirs.shutdown()


def test_every_name_of_the_tables_is_one_of_python_can() -> None:
    """A driver that python-can renames or drops must not be forgotten here."""
    named = {*module._PACKAGES, *module._DRIVERS, *module._WINDOWS}
    assert named <= can.VALID_INTERFACES
