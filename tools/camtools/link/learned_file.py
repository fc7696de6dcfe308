# SPDX-License-Identifier: Apache-2.0
"""What a controller has learned, kept in a file and brought back.

>>> text = learned_text([0] * N_VALUES, "a part")
>>> learned_values(text.encode(), "kept.toml") == [0] * N_VALUES
True
"""

from __future__ import annotations

from collections.abc import Sequence

from camtools.base.errors import CamtoolsError
from camtools.base.toml_text import toml_tree
from camtools.link.controller import Link, Status
from camtools.link.messages import NAMES, Answer, Refused
from camtools.link.refusal_text import REMEDIES

# Values of firmware/learning/cam_learning.h, in their order. The last word of a name is the unit:
# turn / 2^32 per tick, ticks / 2^16, ticks^2 / 2^16, turn / 2^32, nm / 64, 1 / 4096,
# turn / 2^23, 2^-32.
LAYOUT = {
    "speed_q32": 1,
    "k1_q16": 1,
    "k2_q16": 1,
    "masked_bits": 1,
    "phase_q32": 1,
    "correction_q6": 34,
    "gain_q12": 34,
    "ripple_q23": 32,
    "friction_q6": 1,
    "chip_q32": 1,
    "chip_mean_q32": 1,
}
N_VALUES = sum(LAYOUT.values())
_HEAD = """\
# What a camturn controller has learned; camctl learned load FILE brings it back.
# Harmonics 0 .. 16 (ripple: 1 .. 16) as pairs of real and imaginary part.
part = "{part}"
"""


def learned_text(values: Sequence[int], part: str) -> str:
    """Return the values as a TOML file.

    Parameters
    ----------
    part : str
        name of the table that was in use
    """
    name = "".join(c if c.isprintable() and c not in '"\\' else "?" for c in part)
    lines, at = [_HEAD.format(part=name)], 0
    for key, n in LAYOUT.items():
        here, at = list(values[at : at + n]), at + n
        lines.append(f"{key} = {here[0] if n == 1 else here}\n")
    return "".join(lines)


def learned_values(data: bytes, name: str) -> list[int]:
    """Return the values of such a file.

    Raises
    ------
    CamtoolsError
        It is none: the line names the file, the key and the remedy.
    """
    try:
        told = toml_tree(data.decode("utf-8"))
    except ValueError as error:
        text = f"{name}: no learned values: {error}; give a file of camctl learned save"
        raise CamtoolsError([text]) from error
    for key in ("friction_q6", "chip_q32", "chip_mean_q32"):
        told.setdefault(key, 0)  # files of version 1.0.0 have none
    values: list[int] = []
    for key, n in LAYOUT.items():
        found = told.get(key)
        here = [found] if n == 1 else found
        if not isinstance(here, list) or len(here) != n or not all(map(_is_word, here)):
            what = f"{n} whole numbers" if n > 1 else "a whole number"
            raise CamtoolsError(
                [f"{name}: {key}: not {what} of 32 bits; give a file of camctl learned save"]
            )
        values += here
    if extra := sorted(told.keys() - LAYOUT.keys() - {"part"}):
        raise CamtoolsError(
            [f"{name}: {extra[0]}: unknown key; give a file of camctl learned save"]
        )
    return values


def _is_word(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and -(2**31) <= value < 2**31


def _say_no(index: int, answer: Answer) -> Refused:
    result = answer.result.replace("_", " ")
    otherwise = REMEDIES.get(answer.result, "nothing is changed")
    remedy = "the state must be off or ready" if "state" in answer.result else otherwise
    return Refused(f"learned value {index}: refused: {result}; {remedy}")


def get_learned(link: Link) -> list[int]:
    """Return all learned values."""
    values = []
    for index in range(N_VALUES):
        answer = link.ask("get_learned", parameter=index)
        if answer.result != "done":
            raise _say_no(index, answer)
        values.append(int(answer.value))
    return values


def set_learned(link: Link, values: Sequence[int]) -> None:
    """Bring learned values back; when one is refused, those of before come back.

    Raises
    ------
    Refused
        One is refused, or the bus is lost.
    """
    before = get_learned(link)
    for index, value in enumerate(values):
        answer = link.ask("set_learned", parameter=index, value=value)
        if answer.result != "done":
            for back in range(index):
                link.ask("set_learned", parameter=back, value=before[back])
            raise _say_no(index, answer)


def learning_report(status: Status) -> list[str]:
    """Return what the status tells of learning, a line each."""
    s = status.signals
    phase = NAMES["learn_phase"].get(int(s["learn_phase"]), "unknown")
    reason = NAMES["learn_reason"].get(int(s["learn_reason"]), "unknown")
    masked = [str(k) for k in range(17) if int(s["learn_masked"]) >> k & 1]
    why = "" if reason == "all" else f", {reason.replace('_', ' ')}"
    return [
        f"learning          {phase}{why}; {s['learn_turns']:.0f} turns, harmonics 0 .. "
        f"{s['learn_harmonics']:.0f}, masked: {', '.join(masked) or 'none'}",
        f"  error of U      {s['learn_error']:.3f} um rms, at first {s['learn_begin_error']:.3f}",
        f"  added           k1 {s['learn_k1']:+.3f} us, k2 {s['learn_k2']:+.0f} us2, "
        f"correction {s['learn_correction']:.3f} um",
        f"  spindle         ripple {s['learn_ripple']:.3f} uturn; "
        f"learned at {s['learn_speed']:.1f} r/min",
    ]
