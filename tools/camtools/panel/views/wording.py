"""How pages put things: numbers with units, states, who commands, what waits.

>>> plain(0.5, 4, "+"), plain(-0.00001, 4, "+"), plain(None, 1) == NOTHING
('+0.5000', '+0.0000', True)
>>> clock(3725.4), clock(59.6), share_of("download, 40 %")
('1:02:05', '1:00', 0.4)

>>> box_text({"recorder_use": 2.0, "recorder_phase": 3.0, "recorder_faults": 1.0})[:59]
'The black box holds the recording from before the fault est'
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite

from camtools.base.quantities import UM_PER_MM
from camtools.link.messages import NUMBERS
from camtools.link.rights import sender_text
from camtools.link.signals import faults_in
from camtools.link.status_text import duration_text
from camtools.panel.orders.snapshot import Snapshot

NOTHING = "\N{EN DASH}"
_MINUS = "\N{MINUS SIGN}"  # as wide as a plus, unlike the hyphen


def plain(value: float | None, decimals: int, plus: str = "") -> str:
    """Return a number; a minus stands before what is below 0 as it is shown, not before zeros.

    plus: what stands before the others, a plus where the width shall not depend on the sign.
    """
    if value is None or not isfinite(value):
        return NOTHING
    digits = f"{abs(value):.{decimals}f}"
    return f"{_MINUS if value < 0 and float(digits) > 0 else plus}{digits}"


def clock(seconds: float | None) -> str:
    """Return a time as minutes and seconds, with hours where there are any."""
    if seconds is None or not isfinite(seconds):
        return NOTHING
    return duration_text(max(0, round(seconds)))


@dataclass(frozen=True)
class Field:
    """A number of the status."""

    key: str  # stable name, also of the test
    label: str
    unit: str  # for people
    signal: str  # of the DBC
    decimals: int
    factor: float = 1.0  # that unit per unit of the signal
    is_signed: bool = False  # a plus stands in front of what is not negative

    def text(self, signals: Mapping[str, float]) -> str:
        """Return the number as it is shown."""
        value = signals.get(self.signal)
        scaled = None if value is None else value * self.factor
        return plain(scaled, self.decimals, "+" if self.is_signed else "")


SPEED = Field("speed", "Spindle speed", "r/min", "speed", 1)
ANGLE = Field("angle", "Angle of the drawing", "°", "angle", 1)
U_SET = Field("u-set", "U set", "mm", "u_set", 4, is_signed=True)
U_ACTUAL = Field("u-actual", "U actual", "mm", "u_actual", 4, is_signed=True)
_FOLLOWING = ("following", "Following error", "µm", "following_error")
FOLLOWING = Field(*_FOLLOWING, 2, UM_PER_MM, is_signed=True)
X_RADIUS = Field("x-radius", "X radius", "mm", "x", 4)
X_DIAMETER = Field("x-diameter", "X diameter ⌀", "mm", "x", 4, 2.0)
Z_HEIGHT = Field("z", "Z height", "mm", "z", 3, is_signed=True)
PARTS = Field("parts", "Parts cut", "parts", "parts_cut", 0)
LATE_TICKS = Field("tick-late", "Late ticks", "ticks", "late_ticks", 0)
AXES = (U_SET, U_ACTUAL, Z_HEIGHT, X_RADIUS, X_DIAMETER)


def homed_text(signals: Mapping[str, float]) -> str:
    """Return which axes have their home.

    >>> homed_text({"homed_x": 1.0, "homed_z": 0.0})
    'U not homed, X homed, Z not homed'
    """
    marks = ((axis.upper(), signals.get(f"homed_{axis}", 0.0)) for axis in "uxz")
    return ", ".join(f"{axis} {'homed' if is_so else 'not homed'}" for axis, is_so in marks)


def pass_text(signals: Mapping[str, float]) -> str:
    """Return the pass that is cut, or that the next start cuts; "" for a table of one.

    >>> pass_text({"pass": 2.0, "passes": 3.0})
    'pass 2 of 3'
    """
    n = int(signals.get("passes", 0.0))
    return f"pass {int(signals.get('pass', 0.0))} of {n}" if n else ""


_PERCENT = re.compile(r"(\d{1,3}) ?%")


def share_of(work: str) -> float:
    """Return the percentage in a text as a share, 0 .. 1; 0 where it has none."""
    found = _PERCENT.search(work)
    return min(int(found[1]), 100) / 100 if found else 0.0


@dataclass(frozen=True)
class Look:
    """Of a state."""

    word: str  # in big letters
    tone: str  # names the colour: a class of the style sheet, `tone-` in front
    icon: str  # shape, a name of the Material icons that NiceGUI brings along
    meaning: str  # what goes on, a sentence


LOOKS = {
    "off": Look("OFF", "off", "radio_button_unchecked", "The drives are off."),
    "homing": Look(
        "HOMING", "moves", "my_location", "The drives are on; searching for the spindle index."
    ),
    "ready": Look(
        "READY", "ready", "check_circle", "The drives are on and the spindle angle is known."
    ),
    "rehearsing": Look(
        "REHEARSING", "moves", "replay", "The tool moves clear of the work, to learn."
    ),
    "engaging": Look("ENGAGING", "cuts", "login", "The tool enters the work."),
    "cutting": Look("CUTTING", "cuts", "play_circle", "The part is being cut."),
    "holding": Look(
        "HOLDING", "held", "pause_circle", "Z is paused and U continues; the tool is cutting."
    ),
    "disengaging": Look("LEAVING", "cuts", "logout", "The tool leaves the work."),
    "fault": Look("FAULT", "fault", "report", "The tool has left the work, or is on its way."),
    "identifying": Look(
        "MEASURING", "moves", "graphic_eq", "U moves along a wave, to measure its drive."
    ),
    "manual": Look(
        "BY HAND", "hand", "pan_tool", "Axes are moved by hand; the spindle is stopped."
    ),
}
_LOST = "The controller does not answer: all values here are old."
SILENT = Look("NO CONNECTION", "silent", "link_off", _LOST)
UNKNOWN = Look("WAITING", "silent", "hourglass_empty", "No status received yet.")


def look(state: str, *, is_connected: bool) -> Look:
    """Return how a state is shown, as long as the controller's status comes."""
    return LOOKS.get(state, UNKNOWN) if is_connected else SILENT


def other_sender(snapshot: Snapshot) -> int:
    """Return who else commands the controller; 0: nobody does, or this panel."""
    if snapshot.has_command or not snapshot.is_connected:
        return 0
    return int(snapshot.signals.get("commander", 0.0))


def held_text(snapshot: Snapshot) -> str:
    """Return why orders are off while another sender commands the controller; "" otherwise."""
    sender = other_sender(snapshot)
    return f"{sender_text(sender)} commands the controller; take over, top right" if sender else ""


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
