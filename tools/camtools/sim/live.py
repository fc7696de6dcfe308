r"""Controller and lathe as two processes of the simulator, in the time of the clock.

host_sim/live/sim_live.h tells what they do, and what each does when the other is gone.

>>> died(-9), died(2)
('was ended by signal 9', 'ended with status 2')
>>> read_machine(with_home_switches("[z]\nspeed_mm_per_s = 200.0\n", 62.0), "")["z"]
{'speed_mm_per_s': 200.0, 'home_mm': 102.0, 'home_side': 1}
"""

import socket
import subprocess
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from camtools.base.errors import CamtoolsError
from camtools.base.project import build_folder
from camtools.base.quantities import NM_PER_MM
from camtools.sim.machine_file import emit_machine, read_machine

_X_HOME_MM, _Z_BEYOND_MM = 150.0, 40.0  # clear of any part, and of its end
_HERE, _BY_SWITCH = 1, 2  # methods of homing: the present position, a switch
_SEARCH_UM_PER_S = 50_000
_END_S = 2.0  # after which a process that was asked to end is killed


def camsim_path() -> Path:
    """Return where the program is built."""
    return build_folder() / "camsim"


def died(status: int) -> str:
    """Return how a process ended, in words."""
    return f"was ended by signal {-status}" if status < 0 else f"ended with status {status}"


def with_home_switches(text: str, z_last_mm: float) -> str:
    """Return a machine file whose X and Z home by a switch beyond the last height, U at rest."""
    tree = read_machine(text, "machine file")
    places_mm = {"x": _X_HOME_MM, "z": z_last_mm + _Z_BEYOND_MM}
    controller = {"u_home": _HERE} | tree.get("controller", {})
    for axis, place_mm in places_mm.items():
        tree[axis] = {**tree.get(axis, {}), "home_mm": place_mm, "home_side": 1}
        controller |= {
            f"{axis}_home": _BY_SWITCH,
            f"{axis}_home_nm": round(place_mm * NM_PER_MM),
            f"{axis}_home_um_per_s": _SEARCH_UM_PER_S,
        }
    return emit_machine(tree | {"controller": controller})


def refuses(program: Path, folder: Path, words: Sequence[str]) -> bool:
    """Return whether camsim refuses table and options; it has said why, once and not twice."""
    command = [str(program), "params", *words]
    try:
        done = subprocess.run(command, cwd=folder, stdout=subprocess.DEVNULL, check=False)
    except OSError as error:
        raise _cannot_start(program, error) from error
    return done.returncode != 0


def _cannot_start(program: Path, error: OSError) -> CamtoolsError:
    problem = f"{program}: cannot be started: {error.strerror}"
    return CamtoolsError([f"{problem}; start tools/live, which builds it"])


def _end(process: subprocess.Popen[bytes]) -> None:
    """Close what a process reads, which ends it; kill it where that does not help."""
    assert process.stdin is not None
    with suppress(OSError):
        process.stdin.close()
    try:
        process.wait(_END_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


class LivePair:
    """The two processes, joined by a pair of sockets; both end when this object is closed.

    Their pipes carry CAN frames, and words. Raises CamtoolsError: they cannot be started.
    """

    def __init__(self, program: Path, folder: Path, words: Sequence[str]) -> None:
        ends = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._begun: list[subprocess.Popen[bytes]] = []
        try:
            for role, end in zip(("lathe", "controller"), ends, strict=True):
                wire = str(end.fileno())
                command = [str(program), "live", *words, "--role", role, "--wire", wire]
                self._begun.append(
                    subprocess.Popen(
                        command,
                        stdin=subprocess.PIPE,
                        stdout=subprocess.PIPE,
                        cwd=folder,
                        pass_fds=[end.fileno()],
                        process_group=0,  # control-C is for the one that started them
                    )
                )
        except OSError as error:
            self.close()
            raise _cannot_start(program, error) from error
        finally:
            for end in ends:
                end.close()
        self.lathe, self.controller = self._begun

    def close(self) -> None:
        """End both, and wait for them; the controller first, so that it has no fault to report."""
        for process in reversed(self._begun):
            _end(process)

    def close_pipes(self) -> None:
        """Close what they said, when nobody reads it any more."""
        for process in self._begun:
            assert process.stdout is not None
            process.stdout.close()
