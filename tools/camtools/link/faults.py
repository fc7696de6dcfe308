# SPDX-License-Identifier: Apache-2.0
"""What each fault means, and what to do about it, in plain words.

Cause and remedy have one source, the table of firmware/FAULTS.md; the title is the comment of the
fault's signal in the DBC.

>>> FAULTS["estop"].title, FAULTS["estop"].cause
('Emergency stop', 'The emergency-stop chain is open.')
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from camtools.base.project_paths import ROOT
from camtools.link.messages import FAULT_TEXTS

FAULTS_MD = ROOT / "firmware" / "FAULTS.md"
_ROW = re.compile(r"\| `(\w+)` \| ([^|]+) \| [^|]+ \| [^|]+ \| ([^|]+) \|")
_LINK = re.compile(r"\[([^]]*)\]\([^)]*\)")


@dataclass(frozen=True)
class FaultText:
    """A fault for people."""

    name: str
    title: str
    cause: str
    remedy: str


def _sentence(cell: str) -> str:
    """Return a cell of a table in Markdown as a plain sentence."""
    plain = _LINK.sub(r"\1", cell).replace("`", "").strip()
    return f"{plain[:1].upper()}{plain[1:]}."


def texts_of(markdown: str) -> dict[str, FaultText]:
    """Return the faults of the table in FAULTS.md, by their names and in their order."""
    return {
        name: FaultText(
            name, FAULT_TEXTS.get(name, name).rstrip("."), _sentence(cause), _sentence(remedy)
        )
        for name, cause, remedy in _ROW.findall(markdown)
    }


FAULTS = texts_of(FAULTS_MD.read_text("utf-8"))
