# SPDX-License-Identifier: Apache-2.0
"""What a part is cut with on the simulator, and the command line that says so.

>>> RunOptions(rpm=2000.0, seed=3, learns=False).words("part.toml")[:4]
['part.toml', '-o', '.', '--rpm']
>>> RunOptions(machine="real").text()
'machine real, speed and feed of the part, seed 1'
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields
from math import isfinite
from typing import Any

from camtools.base.errors import CamtoolsError

OF_THE_PART = ""  # a machine with the limits of the part file
_MAX_SEED = 2**31 - 1
_MAX_RPM, _MAX_FEED_MM = 60_000.0, 10.0


@dataclass(frozen=True)
class RunOptions:
    """What a cut is done with.

    Attributes
    ----------
    machine : str
        A name of host_sim/machines, the name of a machine file of one's own, or "": a machine with
        the limits of the part.
    rpm, feed_mm : float or None
        None: those of the part.
    learns : bool
        The controller may learn, where it measures U; else it learns nothing.
    seed : int
        Of the encoder's noise.
    """

    machine: str = OF_THE_PART
    rpm: float | None = None
    feed_mm: float | None = None
    learns: bool = True
    seed: int = 1

    def checked(self) -> RunOptions:
        """Return the options, or refuse what no cut can be done with.

        Raises
        ------
        CamtoolsError
            With the range.
        """
        _check("speed", self.rpm, _MAX_RPM, "r/min")
        _check("feed", self.feed_mm, _MAX_FEED_MM, "mm per turn")
        if not 0 <= self.seed <= _MAX_SEED:
            raise CamtoolsError([f"seed {self.seed}: give a whole number of 0 .. {_MAX_SEED}"])
        return self

    def words(self, part: str, machine: str | None = None) -> list[str]:
        """Return the words of tools/run, results in the working folder.

        Parameters
        ----------
        machine : str, optional
            Path that the machine is given by, instead of its name.
        """
        found = [part, "-o", "."]
        if self.rpm is not None:
            found += ["--rpm", repr(self.rpm)]
        if self.feed_mm is not None:
            found += ["--feed", repr(self.feed_mm)]
        if self.machine != OF_THE_PART:
            found += ["--machine", machine or self.machine]
        return [*found, "--", "--seed", str(self.seed), *([] if self.learns else ["--no-learning"])]

    def text(self) -> str:
        """Return them in a line for people."""
        machine = f"machine {self.machine}" if self.machine else "machine of the part"
        found = [machine]
        if self.rpm is None and self.feed_mm is None:
            found.append("speed and feed of the part")
        else:
            found.append("speed of the part" if self.rpm is None else f"{self.rpm:g} r/min")
            found.append("feed of the part" if self.feed_mm is None else f"{self.feed_mm:g} mm")
        found += [] if self.learns else ["learning off"]
        return ", ".join([*found, f"seed {self.seed}"])

    def told(self) -> dict[str, Any]:
        """Return them for JSON."""
        return asdict(self)

    @classmethod
    def of(cls, told: dict[str, Any]) -> RunOptions:
        """Return what `told` gave; keys of another version are left out."""
        names = {one.name for one in fields(cls)}
        return cls(**{name: value for name, value in told.items() if name in names})


def _check(name: str, value: float | None, most: float, unit: str) -> None:
    if value is None:
        return
    if not isfinite(value) or not 0 < value <= most:
        problem = f"{name} {value:g}: must be above 0 and at most {most:g}"
        raise CamtoolsError([f"{problem}; give {unit}, or leave it empty for the part's own"])
