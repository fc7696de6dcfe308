r"""A U that plays excitations: of a controller over CAN, and of the simulator.

>>> not_ready("cutting")
'the state is cutting, U is excited in ready only; stop and wait for ready'
"""

import subprocess
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Floats
from camtools.base.signals import signals_held
from camtools.identify.configured_drive import PARAMETERS, Believed
from camtools.identify.excitation_plan import Play
from camtools.link.controller import Link
from camtools.link.excitation import HEADINGS, excite
from camtools.link.kept_values import set_all
from camtools.link.messages import NUMBERS, Refused
from camtools.sim.live import camsim_path

_OFF_S = 10.0
_ORDERS = {
    "off": "enable and home",
    "homing": "wait for ready",
    "fault": "see status, then reset, enable and home",
}


def not_ready(state: str) -> str:
    """Return why U cannot be excited in a state, and what to do."""
    remedy = _ORDERS.get(state, "stop and wait for ready")
    return f"the state is {state}, U is excited in ready only; {remedy}"


class ConnectedU:
    """U of a controller; `keeps_command`: the link's owner sends heartbeats on."""

    def __init__(
        self,
        link: Link,
        *,
        keeps_command: bool = False,
        progress: Callable[[int, int], None] | None = None,
    ) -> None:
        self.link, self._keeps_command, self._progress = link, keeps_command, progress

    def _give_back(self) -> None:
        """Give command back: what follows takes longer than command lasts unheard."""
        if not self._keeps_command:
            self.link.rights.release()

    def believed(self) -> Believed:
        """Return what the controller is configured with; refuse any state but ready."""
        status = self.link.listen()
        if status.state != "ready":
            raise Refused(f"{self.link.where}: {not_ready(status.state)}")
        return Believed.of(status.signals["tick_rate"], self.values(PARAMETERS))

    def values(self, names: Iterable[str]) -> dict[str, int]:
        """Return parameters in force. Raises `Refused`: the controller does not know one."""
        found = {}
        for name in names:
            answer = self.link.ask("get_parameter", parameter=NUMBERS["parameter"][name])
            if answer.result != "done":
                raise Refused(f"{self.link.where}: {name}: {answer.result.replace('_', ' ')}")
            found[name] = int(answer.value)
        return found

    def played(self, play: Play, signals: Sequence[str]) -> Floats:
        """Let U play a wave; return tick and signals of its periods, a row each.

        The controller itself sees to the state, to the clearance of the tool and to the limits of
        U. However this ends, U comes to rest.
        `signals`: of the recorder, in the order of firmware/recorder/cam_recorder.h. Raises
        `Refused`: it refuses, the excitation was cut short, or the record has a gap.
        """
        try:
            recording = excite(
                *(self.link, play.samples, play.n_periods),
                **{name: getattr(play, name) for name in ("unit", "fade_ticks", "place_nm")},
                signals=signals,
                progress=self._progress,
            )
        except Refused as refused:
            faults = ", ".join(self.link.listen().faults)
            more = f": {faults}; {_ORDERS['fault']}" if faults else ""
            raise Refused(f"{refused}{more}") from refused
        finally:
            self._give_back()
        if not recording.is_whole:
            raise Refused(f"{self.link.where}: the record has a gap; excite again")
        played = recording.played()
        rows = slice(-play.n_periods * play.samples.size, None)
        columns = [played.tick, *(played[name] for name in signals)]
        return np.array([column[rows] for column in columns], np.float64)

    def apply(self, settings: Mapping[str, int]) -> None:
        """Disable the drives, set all parameters or none, read them back; or refuse."""
        answer = self.link.ask("disable")
        if answer.result != "done":
            raise Refused(f"{self.link.where}: disable: {answer.result.replace('_', ' ')}")
        self.link.wait(lambda: False, 0.05)  # the state of before is in the status until then
        if not self.link.wait(lambda: self.link.status.state == "off", _OFF_S):
            state = self.link.status.state
            raise Refused(f"{self.link.where}: still {state}, nothing is set; try again")
        with signals_held():
            try:
                set_all(self.link, settings)
            except Refused as refused:
                raise Refused(f"{self.link.where}: nothing is set: {refused}") from refused
            finally:
                self._give_back()
            found = self.values(settings)
        for name in (name for name, value in settings.items() if found[name] != value):
            problem = f"{name} = {settings[name]}: reads {found[name]}"
            raise Refused(f"{self.link.where}: {problem}; somebody else sets it; apply again")


_WAVE, _RECORD, _TABLE, _MACHINE = "wave.csv", "record.csv", "part.camtab", "machine.toml"


class CutShortError(Exception):
    """The excitation did not come to its end; the text is one line for people."""


def parameters_of(text: str) -> dict[str, int]:
    """Return the tick rate and the parameters that `camsim params` prints, the plan left out."""
    rows = (line.split(",") for line in text.splitlines()[1:])
    return {name: int(value) for name, value in rows if not name.startswith("planned_")}


class SimulatedU:
    """U of a machine file, known by a name, with a table; `options`: of `camsim identify`."""

    def __init__(
        self, folder: Path, machine: bytes, name: str, image: bytes, options: Sequence[str] = ()
    ) -> None:
        self._options = options
        self._folder, self._name = folder, name
        (folder / _MACHINE).write_bytes(machine)
        (folder / _TABLE).write_bytes(image)

    def _camsim(self, command: str, words: Sequence[str]) -> str:
        program = camsim_path()
        line = [str(program), command, _TABLE, "--machine", _MACHINE, *words]
        try:
            done = subprocess.run(
                line, cwd=self._folder, capture_output=True, text=True, check=False
            )
        except OSError as error:
            problem = f"{program}: cannot be started: {error.strerror}"
            raise CamtoolsError([f"{problem}; start tools/identify, which builds it"]) from error
        message = done.stderr.strip().removeprefix("camsim: ").replace(_MACHINE, self._name)
        if done.returncode == 1:
            raise CutShortError(message or "the excitation was cut short")
        if done.returncode != 0:
            raise CamtoolsError((message or f"camsim ended with {done.returncode}").splitlines())
        return done.stdout

    def believed(self) -> Believed:
        """Return what the simulated controller has; refuse a wrong machine or part."""
        parameters = parameters_of(self._camsim("params", []))
        return Believed.of(parameters["tick_hz"], parameters)

    def values(self, names: Iterable[str]) -> dict[str, int]:
        """Return parameters of the simulated controller; errors as of `believed`."""
        parameters = parameters_of(self._camsim("params", []))
        return {name: parameters[name] for name in names}

    def played(self, play: Play, signals: Sequence[str]) -> Floats:
        """Let U play a wave; return tick and signals of its periods, a row each.

        `signals`: of the recorder, in the order of firmware/recorder/cam_recorder.h. Raises
        `CamtoolsError`: the controller refuses; `CutShortError`: it began and did not end.
        """
        text = "\n".join([HEADINGS[play.unit], *(str(sample) for sample in play.samples.tolist())])
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
