# SPDX-License-Identifier: Apache-2.0
"""Whether the black box of a fault waits, and how to read it.

>>> box_text({"recorder_use": 2.0, "recorder_phase": 3.0, "recorder_faults": 1.0})[:59]
'The black box holds the recording from before the fault est'
>>> box_text({})
''
"""

from __future__ import annotations

from collections.abc import Mapping

from camtools.link.messages import NUMBERS
from camtools.link.signals import faults_in

READ_IT = "tools/camctl blackbox fault.csv --plot fault.png"
_BOX, _DONE = NUMBERS["recorder_use"]["box"], NUMBERS["recorder_phase"]["done"]


def box_text(signals: Mapping[str, float]) -> str:
    """Return a sentence where a black box has not been read; "" otherwise."""
    is_waiting = signals.get("recorder_use") == _BOX and signals.get("recorder_phase") == _DONE
    if not is_waiting:
        return ""
    names = ", ".join(faults_in(int(signals.get("recorder_faults", 0.0))))
    return (
        f"The black box holds the recording from before the fault {names} and keeps it through "
        "reset and enable. To read it:"
    )
