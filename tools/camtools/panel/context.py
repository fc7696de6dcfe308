"""What all pages of one panel share.

>>> AppContext.runs.relative_to(AppContext.parts.parent).as_posix()
'runs'
"""

from dataclasses import dataclass
from pathlib import Path

from camtools.base.project import RESULTS
from camtools.panel.orders.commander import Commander, CommandLog
from camtools.panel.orders.controller_service import ControllerService


@dataclass(frozen=True)
class AppContext:
    """The controller of a panel, who commands it, and where parts and runs are."""

    service: ControllerService
    commander: Commander  # who commands
    log: CommandLog  # of commands, also of edits and runs of the design page
    parts: Path = RESULTS / "panel" / "parts"  # a page reads and writes no part elsewhere
    runs: Path = RESULTS / "panel" / "runs"  # folder of the runs that are kept
