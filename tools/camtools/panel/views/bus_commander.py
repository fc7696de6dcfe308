# SPDX-License-Identifier: Apache-2.0
"""Who commands the controller, as far as that is not this panel: one sender of the bus at most.

>>> from dataclasses import replace
>>> from camtools.panel.orders.snapshot import SILENT
>>> other = replace(SILENT, is_connected=True, signals={"commander": 0.0})
>>> other_sender(other), other_sender(replace(other, signals={"commander": 300.0}))
(0, 300)
>>> held_text(replace(other, signals={"commander": 300.0}))
'sender 300 commands the controller; take over, top right'
"""

from __future__ import annotations

from camtools.link.rights import sender_text
from camtools.panel.orders.snapshot import Snapshot


def other_sender(snapshot: Snapshot) -> int:
    """Return who else commands the controller; 0: nobody does, or this panel."""
    if snapshot.has_command or not snapshot.is_connected:
        return 0
    return int(snapshot.signals.get("commander", 0.0))


def held_text(snapshot: Snapshot) -> str:
    """Return why orders are off while another sender commands the controller; "" otherwise."""
    sender = other_sender(snapshot)
    return f"{sender_text(sender)} commands the controller; take over, top right" if sender else ""
