# SPDX-License-Identifier: Apache-2.0
"""A bus of python-can, opened; what it lacks is told in one line with the remedy.

>>> bus, where = open_bus({"interface": "virtual", "channel": "demo"})
>>> bus.shutdown()
>>> where
'virtual demo'
>>> open_bus({"interface": "slcn"})
Traceback (most recent call last):
camtools.base.errors.CamtoolsError: interface slcn: unknown to python-can; did you mean slcan?
"""

from __future__ import annotations

import difflib
import errno
import importlib
import inspect
import logging
from collections.abc import Mapping
from typing import Any

import can
import can.util
from can.interfaces import BACKENDS

from camtools.base.errors import CamtoolsError

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
    errno.ENETDOWN: "the network interface is down; bring it up by ip link set .. up",
    errno.EPERM: "this user has no permission; check that of the device",
    errno.EACCES: "this user has no permission; check that of the device",
}


def configured(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return what is given, completed by the environment and the configuration file."""
    return {**can.util.load_file_config(), **can.util.load_environment_config(), **given}


def _wanted(interface: str) -> list[str]:
    """Return the arguments that a driver cannot do without."""
    module, name = BACKENDS[interface]
    driver = getattr(importlib.import_module(module), name)
    arguments = inspect.signature(driver).parameters.values()
    return [
        one.name
        for one in arguments
        if one.default is one.empty and one.kind is one.POSITIONAL_OR_KEYWORD
    ]


def _option(name: str) -> str:
    return f"--{name} .." if name in ("channel", "bitrate") else f"--option {name}=.."


def _lacking(interface: str, given: Mapping[str, Any], error: Exception) -> str:
    """Return why a driver does not open, and the remedy."""
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
    number = getattr(error, "errno", None)
    cause = getattr(error.__cause__, "errno", None)
    remedy = _ERRNO.get(number or cause or 0, "see its options in the manual of python-can")
    return f"{error}; {remedy}"


def _is_loopback(asked: Mapping[str, Any]) -> bool:
    """Return whether frames shall stay on this computer."""
    is_here = asked.get("interface") == "udp_multicast" and str(asked.get("hop_limit")) == "0"
    return is_here and "channel" in asked and "port" in asked and ":" not in str(asked["channel"])


def _opened(asked: Mapping[str, Any], given: Mapping[str, Any]) -> can.BusABC:
    if not _is_loopback(asked):
        return can.Bus(**given)
    from camtools.link.loopback import LoopbackBus  # it alone wants msgpack

    return LoopbackBus(str(asked["channel"]), int(asked["port"]))


def open_bus(given: Mapping[str, Any]) -> tuple[can.BusABC, str]:
    """Return an open bus, and how to call it in messages.

    Parameters
    ----------
    given : Mapping
        arguments of can.Bus; what is missing comes from the environment or python-can's file

    Raises
    ------
    CamtoolsError
        It cannot be opened.
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
    logging.getLogger("can").setLevel(logging.CRITICAL)  # drivers tell there what is told here
    try:
        return _opened(asked, given), place
    except Exception as error:  # a driver of strangers raises what it likes
        raise CamtoolsError([f"{place}: {_lacking(str(interface), asked, error)}"]) from error
