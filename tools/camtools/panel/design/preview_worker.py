"""The process that computes previews: curves first, then what the table costs.

It is kept ready with everything imported. SIGUSR1 drops what it computes, for a newer change;
what was made on the way is remembered. It can write no file, and has a limit of memory.

>>> request = {"id": 1, "do": "preview", "text": "[part]", "folder": "."}
>>> [answer["stage"] for answer in answers_to(request, Memory(8))]
['form', 'problems']
"""

import json
import os
import resource
import signal
import sys
from collections.abc import Iterator
from math import floor, log10
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np

from camtools.base.cache import Memory, file_state, recall, remembering
from camtools.base.command import no_warnings
from camtools.base.errors import CamtoolsError
from camtools.base.quantities import MM_PER_M, UM_PER_MM, Floats, omega_rad_s
from camtools.cut.verdict import margins_of, refused_of
from camtools.panel.design.document import edited, problems_of
from camtools.part.common import MachineLimits
from camtools.part.model import MAX_FILE_BYTES, files_named, read_tree
from camtools.pipeline.kind import Exact, ExactTurn, SpeedRatio
from camtools.pipeline.load import Loaded, kind_of, kinds, parse
from camtools.table.channel import (
    KIND_CONTACT,
    KIND_SPEED,
    KIND_SWING,
    KIND_U,
    KIND_WAY,
    KIND_X,
    Channel,
    in_sense,
)
from camtools.table.image import pack
from camtools.table.summary import describe_channel

N_ANGLES = 1440
_DIGITS = 7
_CHANNELS = {
    KIND_U: "U",
    KIND_X: "X",
    KIND_SPEED: "speed",
    KIND_SWING: "swing",
    KIND_CONTACT: "contact",
    KIND_WAY: "way of Z",
}

Shown = dict[str, Any]


def rounded(values: Floats) -> list[float]:
    """Return numbers with as many digits as a picture needs."""
    largest = float(np.abs(values).max(initial=0.0)) or 1.0
    found: list[float] = np.round(values, _DIGITS - 1 - floor(log10(largest))).tolist()
    return found


def motion_of(turn: ExactTurn, rpm: float, ratio: SpeedRatio | None = None) -> dict[str, Floats]:
    """Return U over a turn and its derivatives by the time, MATHS.md (25).

    The spindle has a mean speed [r/min], and a modulated one its ratio to that.
    """
    omega = omega_rad_s(rpm)
    ones = np.ones_like(turn.u_mm)
    r, r1, r2 = (ones, 0 * ones, 0 * ones) if ratio is None else ratio
    velocity = turn.d1 * r
    acceleration = turn.d2 * r**2 + turn.d1 * r * r1
    jerk = turn.d3 * r**3 + 3 * turn.d2 * r**2 * r1 + turn.d1 * r * (r1**2 + r * r2)
    return {
        "u_um": turn.u_mm * UM_PER_MM,
        "velocity_mm_s": velocity * omega,
        "acceleration_m_s2": acceleration * (omega**2 / MM_PER_M),
        "jerk_km_s3": jerk * (omega**3 / MM_PER_M**2),
    }


def curves_of(exact: Exact, rpm: float, z_mm: float | None, speed: Channel | None = None) -> Shown:
    """Return section, profile and motion at a height, in the middle where none is given."""
    low, high = exact.heights_mm
    z_mm = exact.nearest_mm((low + high) / 2 if z_mm is None else z_mm)
    turn, profile = exact.turn_at(z_mm, N_ANGLES), exact.profile()
    ratio = None if speed is None else exact.ratio_at(speed, turn.phi_rad, z_mm)
    motion = motion_of(turn, rpm, ratio)
    return {
        "heights_mm": [low, high],
        "height_mm": z_mm,
        "rpm": rpm,
        "is_modulated": speed is not None,
        "nominal_mm": turn.nominal_mm,
        "deviation_um": rounded((turn.radius_mm - turn.nominal_mm) * UM_PER_MM),
        "motion": {name: rounded(values) for name, values in motion.items()},
        "peaks": {name: float(np.abs(values).max()) for name, values in motion.items()},
        "stroke_um": float(np.ptp(motion["u_um"])),
        "profile": {
            "z_mm": rounded(profile.z_mm),
            "curves": {curve.name: rounded(2 * curve.radius_mm) for curve in profile.curves},
        },
    }


class Judged:
    """A table that was made, and what the controller's rule says of it.

    Raises CamtoolsError where there is none: the shape or the tolerance is impossible.
    """

    def __init__(self, loaded: Loaded) -> None:
        self.lines: list[str] = []
        self.tolerance_nm: float | None = None
        self.asked_rpm: float = loaded.part.process.spindle_rpm
        try:
            made = loaded.kind.make(loaded.part, None)
        except CamtoolsError as error:
            refused = refused_of(error)
            if refused is None:
                raise
            self.table, self.best, self.lines = refused.table, refused.best, error.lines
            return
        self.table, self.best = made.table, made.highest_speed
        self.tolerance_nm = made.tolerance_nm

    @property
    def speed(self) -> Channel | None:
        """Return the law of a modulated spindle over the drawing's angle."""
        law = self.table.speed
        return None if law is None else in_sense(law, self.table.direction)

    @property
    def rpm(self) -> float:
        """Return the mean speed of the table [r/min]."""
        return self.table.spindle_mrpm / 1000


def verdict_of_table(judged: Judged, limits: MachineLimits) -> Shown:
    """Return size, margins and verdict of a table, with knots and slices of its channels."""
    table, margins = judged.table, margins_of(judged.table, limits)
    channels = [(_CHANNELS[one.kind], describe_channel(one)) for one in table.channels]
    return {
        "table": {
            "bytes": len(pack(table)),
            "channels": [
                {"name": name} | {key: about[key] for key in _CHANNEL_KEYS}
                for name, about in channels
            ],
            "tolerance_nm": judged.tolerance_nm,
        },
        "is_feasible": not judged.lines,
        "highest_rpm": judged.best.rpm,
        "decided_by": judged.best.decides,
        "asked_rpm": judged.asked_rpm,
        "margins": [{key: getattr(margin, key) for key in _MARGIN_KEYS} for margin in margins],
    }


_CHANNEL_KEYS = ("bytes", "n_slices", "knots_per_pattern", "patterns_per_turn")
_MARGIN_KEYS = ("name", "field", "needed", "limit", "unit", "left_percent")
FILE = "part.toml"  # what messages call the text; it is left out where they are shown
_REMEMBERED = 64


class SupersededError(BaseException):
    """A newer change makes this one idle; no `except Exception` may stop it."""


class _Switch:
    """Whether a signal may break off what goes on."""

    is_on = False


def _problems(lines: list[str], text: str, stage: str = "problems") -> Shown:
    found = [problem._asdict() for problem in problems_of(lines, text, FILE)]
    return {"stage": stage, "problems": found}


def _loaded(text: str, folder: str) -> Loaded:
    data = text.encode("utf-8", "surrogatepass")
    if len(data) > MAX_FILE_BYTES:
        problem = f"has {len(data)} bytes, at most {MAX_FILE_BYTES} are read"
        raise CamtoolsError([f"{problem}; put long lists into a CSV file"])
    return parse(data, FILE, Path(folder), is_confined=True)


def _preview(request: Shown) -> Iterator[Shown]:
    text, folder = str(request["text"]), str(request["folder"])
    z_mm = request.get("height_mm")
    try:
        tree = read_tree(text.encode("utf-8", "replace")[:MAX_FILE_BYTES], FILE)
        yield {"stage": "form", "kind": kind_of(tree).name, "tree": tree}
        loaded = _loaded(text, folder)
        files = tuple(file_state(str(Path(folder, name))) for name in files_named(tree))
        key = loaded.kind.name, loaded.part.model_dump_json(), files
        exact = loaded.kind.exact(loaded.part)
        limits = loaded.part.machine.limits
        asked_rpm = loaded.part.process.spindle_rpm
        shown = {
            "velocity_mm_s": limits.u_speed_mm_s,
            "acceleration_m_s2": limits.u_acceleration_mm_s2 / MM_PER_M,
        }
        drawn = {"stage": "curves", "limits": shown, "kind": loaded.kind.name}
        yield drawn | curves_of(exact, asked_rpm, z_mm)
        judged = recall(("judged", key), lambda: Judged(loaded))
        if judged.speed is not None or judged.rpm != asked_rpm:
            yield drawn | curves_of(exact, judged.rpm, z_mm, judged.speed)
        yield _problems(judged.lines, text, "table") | verdict_of_table(judged, limits)
    except CamtoolsError as error:
        yield _problems(error.lines, text)


def _edit(request: Shown) -> Iterator[Shown]:
    text = str(request["text"])
    try:
        yield {"stage": "text", "text": edited(text, tuple(request["path"]), request["value"])}
    except CamtoolsError as error:
        yield _problems(error.lines, text)


_ACTIONS = {"preview": _preview, "edit": _edit}


def answers_to(request: Shown, memory: Memory) -> Iterator[Shown]:
    """Yield the answers to one request, the cheap ones first."""
    with remembering(memory):
        yield from _ACTIONS[request["do"]](request)


def _tell(answer: Shown) -> None:
    print(json.dumps(answer, default=str), flush=True)  # dates of TOML


def _carry_out(request: Shown, memory: Memory) -> None:
    """Answer a request; the last answer always has the stage `done`."""
    is_dropped = False
    answers = answers_to(request, memory)

    def tell(answer: Shown) -> None:
        _tell({"id": request["id"]} | answer)

    try:
        while True:
            _Switch.is_on = True
            answer = next(answers, None)
            _Switch.is_on = False
            if answer is None:
                break
            tell(answer)
    except SupersededError:
        is_dropped = True
    except MemoryError:
        problem = "takes more memory than a preview may; give fewer points or lobes"
        tell(_problems([problem], ""))
    finally:
        _Switch.is_on = False
    tell({"stage": "done", "is_dropped": is_dropped})


def _drop(_number: int, _frame: FrameType | None) -> None:
    if _Switch.is_on:
        _Switch.is_on = False
        raise SupersededError


def main(memory_mb: int) -> None:
    """Answer requests until standard input ends."""
    no_warnings()
    signal.signal(signal.SIGUSR1, _drop)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # control-C ends the panel, which ends this
    kinds()
    resource.setrlimit(resource.RLIMIT_AS, (memory_mb << 20, memory_mb << 20))
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    os.nice(5)  # a cut that is watched comes first
    memory = Memory(_REMEMBERED)
    _tell({"id": 0, "stage": "ready"})
    for line in sys.stdin:
        _carry_out(json.loads(line), memory)


if __name__ == "__main__":
    main(int(sys.argv[1]))
