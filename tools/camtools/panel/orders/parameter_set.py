# SPDX-License-Identifier: Apache-2.0
"""All parameters of a controller as they were read, for pages: as a file, and beside a file.

>>> from camtools.link.parameters import INFOS
>>> values = {name: info.default for name, info in INFOS.items()}
>>> read = ParameterSet(values, 3, "kept")
>>> read.differences(b"lead_ns = 17", "a.toml")
{'lead_ns': (17, 100000)}
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from camtools.link.controller import Status
from camtools.link.parameters import checksum, parse, text_of
from camtools.link.status_text import kept_text


@dataclass(frozen=True)
class ParameterSet:
    """Values in force; link.parameters.INFOS has their ranges and meanings."""

    values: Mapping[str, int]  # by name, in the controller's order
    version: int  # that the controller reports
    kept: str  # whether the controller keeps them over a restart, in words
    checksum: int = field(init=False)  # of the values, as the status reports it

    def __post_init__(self) -> None:
        object.__setattr__(self, "checksum", checksum(self.values))

    def is_of(self, signals: Mapping[str, float]) -> bool:
        """Return whether the status still tells the same of them."""
        told = (int(signals["params_version"]), kept_text(signals))
        return told == (self.version, self.kept)

    def text(self) -> str:
        """Return them as a TOML file, which `params_load` and camctl take."""
        origin = f"version {self.version}, checksum {self.checksum:08x}"
        return text_of(self.values, origin)

    def differences(self, data: bytes, name: str) -> dict[str, tuple[int, int]]:
        """Return the values in a file and here, where they differ.

        Raises
        ------
        CamtoolsError
            The file has no parameters, or wrong ones.
        """
        there = parse(data, name)
        return {key: (v, self.values[key]) for key, v in there.items() if v != self.values[key]}


def parameter_set(values: Mapping[str, int], status: Status) -> ParameterSet | None:
    """Return what was read, if the status tells the same checksum; else a value has changed."""
    signals = status.signals
    if int(signals["params_checksum"]) != checksum(values):
        return None
    return ParameterSet(dict(values), int(signals["params_version"]), kept_text(signals))
