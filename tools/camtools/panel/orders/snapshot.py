"""What pages show: the newest status of the controller and its parameters, frozen.

>>> SILENT.is_connected, SILENT.state, SILENT.faults
(False, 'unknown', ())
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType

from camtools.link.controller import Status
from camtools.link.kept_values import checksum, parse, text_of
from camtools.link.status_text import kept_text


@dataclass(frozen=True)
class Snapshot:
    """The newest status; every page may read the same one."""

    is_connected: bool = False  # every message has come, and the newest within half a second
    where: str = ""  # how to call bus and controller
    # By name, in the units of the DBC. A controller of another version may not send all: use get.
    signals: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    state: str = "unknown"  # also when not connected
    faults: tuple[str, ...] = ()  # names of latched faults
    table_name: str = ""  # of the part whose table is in use; text of strangers
    at_s: float = -1e9  # when the newest message came [s of time.monotonic]
    problem: str = "no controller yet"  # why there is no connection, and what to do
    work: str = ""  # what the service is busy with, as "download, 40 %"
    has_command: bool = False  # the panel commands; signals["commander"] tells who else does


SILENT = Snapshot()


@dataclass(frozen=True)
class ParameterSet:
    """Values in force; link.parameters.INFOS has their ranges and meanings."""

    values: Mapping[str, int]  # by name, in the controller's order
    version: int  # that the controller reports
    kept: str  # whether the controller keeps them over a restart, in words

    @cached_property
    def checksum(self) -> int:
        """Of the values, as the status reports it."""
        return checksum(self.values)

    def is_of(self, signals: Mapping[str, float]) -> bool:
        """Return whether version and kept are still those of the status."""
        reported = (int(signals["params_version"]), kept_text(signals))
        return reported == (self.version, self.kept)

    def text(self) -> str:
        """Return them as a TOML file, which `params_load` and camctl take."""
        origin = f"version {self.version}, checksum {self.checksum:08x}"
        return text_of(self.values, origin)

    def differences(self, data: bytes, name: str) -> dict[str, tuple[int, int]]:
        """Return the values in a file and here, where they differ.

        Raises CamtoolsError: the file has no parameters, or wrong ones.
        """
        there = parse(data, name)
        return {key: (v, self.values[key]) for key, v in there.items() if v != self.values[key]}


def parameter_set(values: Mapping[str, int], status: Status) -> ParameterSet | None:
    """Return what was read; None where the status has another checksum: a value has changed."""
    signals = status.signals
    if int(signals["params_checksum"]) != checksum(values):
        return None
    return ParameterSet(dict(values), int(signals["params_version"]), kept_text(signals))
