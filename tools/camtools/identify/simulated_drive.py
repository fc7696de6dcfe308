# SPDX-License-Identifier: Apache-2.0
r"""U of the simulator: its parameters, and an excitation that is played and recorded there.

>>> parameters_of("name,value\ntick_hz,20000\nk1_ns,742723\n")
{'tick_hz': 20000, 'k1_ns': 742723}
"""

from __future__ import annotations

import subprocess
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Floats
from camtools.identify.configured_drive import Believed
from camtools.identify.excitation_plan import Play
from camtools.link.excitation import HEADINGS
from camtools.sim.live import camsim_path

_WAVE, _RECORD, _TABLE, _MACHINE = "wave.csv", "record.csv", "part.camtab", "machine.toml"


class CutShortError(Exception):
    """The excitation did not come to its end; the text is one line for people."""


def parameters_of(text: str) -> dict[str, int]:
    """Return the tick rate and the parameters that `camsim params` prints, the plan left out."""
    rows = (line.split(",") for line in text.splitlines()[1:])
    return {name: int(value) for name, value in rows if not name.startswith("planned_")}


class SimulatedU:
    """U of a machine of the simulator.

    Parameters
    ----------
    folder : Path
        for files in between; it exists
    machine : bytes
        of the machine file
    name : str
        by which the user knows the machine file
    image : bytes
        of a table that is made for the machine
    options : sequence of str
        of `camsim identify`, beside those of the excitation
    """

    def __init__(
        self, folder: Path, machine: bytes, name: str, image: bytes, options: Sequence[str] = ()
    ) -> None:
        self._options = options
        self._folder, self._name = folder, name
        (folder / _MACHINE).write_bytes(machine)
        (folder / _TABLE).write_bytes(image)

    def _camsim(self, command: str, words: Sequence[str]) -> str:
        """Run a command of camsim; return what it printed."""
        program = camsim_path()
        line = [str(program), command, _TABLE, "--machine", _MACHINE, *words]
        try:
            done = subprocess.run(
                line, cwd=self._folder, capture_output=True, text=True, check=False
            )
        except OSError as error:
            problem = f"{program}: cannot be started: {error.strerror}"
            raise CamtoolsError([f"{problem}; start tools/identify, which builds it"]) from error
        said = done.stderr.strip().removeprefix("camsim: ").replace(_MACHINE, self._name)
        if done.returncode == 1:
            raise CutShortError(said or "the excitation was cut short")
        if done.returncode != 0:
            raise CamtoolsError((said or f"camsim ended with {done.returncode}").splitlines())
        return done.stdout

    def believed(self) -> Believed:
        """Return what the simulated controller is configured with.

        Raises
        ------
        CamtoolsError
            The machine file is wrong, or the part cannot be cut on the machine.
        """
        parameters = parameters_of(self._camsim("params", []))
        return Believed.of(parameters["tick_hz"], parameters)

    def values(self, names: Iterable[str]) -> dict[str, int]:
        """Return parameters of the simulated controller; errors as of `believed`."""
        parameters = parameters_of(self._camsim("params", []))
        return {name: parameters[name] for name in names}

    def played(self, play: Play, signals: Sequence[str]) -> Floats:
        """Let U play a wave; return tick and signals of its periods, a row each.

        Parameters
        ----------
        play : Play
        signals : sequence of str
            of the recorder, in the order of firmware/recorder/cam_recorder.h

        Raises
        ------
        CamtoolsError
            The controller refuses.
        CutShortError
            It began and did not end.
        """
        text = "\n".join([HEADINGS[play.unit], *(str(one) for one in play.samples.tolist())])
        (self._folder / _WAVE).write_text(f"{text}\n", "ascii")
        words = {
            "--wave": _WAVE,
            "--record": _RECORD,
            "--periods": play.n_periods,
            "--fade-ticks": play.fade_ticks,
            "--place-nm": play.place_nm,
            "--signals": ",".join(signals),
        }
        given = [f"{name}={value}" for name, value in words.items()]
        self._camsim("identify", [*given, *self._options])
        rows = np.loadtxt(self._folder / _RECORD, delimiter=",", skiprows=1)
        names = (self._folder / _RECORD).read_text("ascii").split("\n", 1)[0].split(",")
        columns = [names.index(name) for name in ("tick", *signals)]
        return np.asarray(rows[-play.n_periods * play.samples.size :, columns].T)
