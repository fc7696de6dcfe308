"""Cuts on the simulator in this process, or by camsim where it is built with sanitizers."""

from pathlib import Path
from typing import Any

import numpy as np

from camtools.base.errors import CamtoolsError
from camtools.sim.binding import Rows, SimSession
from tests.tools.cases.camsim_cases import CAMSIM, camsim


class Outcome:
    """What `camsim run` gives for some words.

    Attributes
    ----------
    status, message : int, str
        The exit status and the words on stderr.
    trace, summary : ndarray, dict
        Empty when the cut was refused, the trace also unless it is wanted; with sanitizers always.
    """

    def __init__(self, table: Path, *words: str | Path, is_traced: bool = False) -> None:
        self.trace: Rows = np.empty(0)
        self.summary: dict[str, Any] = {}
        if "host-asan" in CAMSIM.parts:  # whose library Python cannot load
            done = camsim("run", table, *words)
            self.status, self.message = done.returncode, done.stderr
            return
        with SimSession() as session:
            try:
                traced = ("--trace", "trace") if is_traced else ()
                session.begin([str(table), *map(str, words), *traced])
            except CamtoolsError as error:
                self.status, self.message = 2, str(error)
                return
            while session.run(1 << 20):
                pass
            ending = session.finish(0.0)
            self.trace = session.take("trace").rows()
        self.status, self.message, self.summary = ending.status, ending.message, ending.summary
