# SPDX-License-Identifier: Apache-2.0
"""What a page shows: the newest status of the controller, frozen.

>>> SILENT.is_connected, SILENT.state, SILENT.faults
(False, 'unknown', ())
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

from camtools.link.controller import Status
from camtools.link.strobe import Samples


@dataclass(frozen=True)
class Snapshot:
    """The newest status; every page may read the same one.

    Attributes
    ----------
    is_connected : bool
        whether every message of the status has come, and the newest within half a second
    where : str
        how to call bus and controller
    signals : Mapping
        signals of the DBC by name, in its units; empty before the first status. A signal that a
        controller of another version does not send is missing: use `signals.get`
    state : str
        name of the state; "unknown" when not connected
    faults : tuple of str
        names of latched faults; controller.FAULT_TEXTS has their texts
    table_name : str
        of the part whose table is in use; text of strangers, show it as text
    at_s : float
        [s] of time.monotonic when the newest message came
    problem : str
        why there is no connection and what to do; "" when there is one
    work : str
        what the service is busy with, for example "download, 40 %"; "" when it is free
    has_command : bool
        whether the panel commands the controller; signals["commander"] tells who else does
    """

    is_connected: bool = False
    where: str = ""
    signals: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    state: str = "unknown"
    faults: tuple[str, ...] = ()
    table_name: str = ""
    at_s: float = -1e9
    problem: str = "no controller yet"
    work: str = ""
    has_command: bool = False


SILENT = Snapshot()
_NONE = np.zeros(0, np.int64)
NO_SAMPLES = Samples(_NONE, _NONE, np.zeros(0), np.zeros(0), _NONE, _NONE > 0, _NONE > 0, 0)


def snapshot_of(status: Status, where: str, work: str, *, has_command: bool) -> Snapshot:
    """Return what a whole status shows."""
    return Snapshot(
        is_connected=True,
        where=where,
        signals=MappingProxyType(dict(status.signals)),
        state=status.state,
        faults=tuple(status.faults),
        table_name=status.table_name,
        at_s=status.at_s,
        problem="",
        work=work,
        has_command=has_command,
    )
