# SPDX-License-Identifier: Apache-2.0
"""How a state is shown: a word, a colour and a shape, so that none of them is needed alone.

>>> look("cutting", is_connected=True).word
'CUTTING'
>>> look("cutting", is_connected=False).word
'NO CONNECTION'
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Look:
    """Of a state.

    Attributes
    ----------
    word : str
        in big letters
    tone : str
        names the colour: a class of the style sheet, `tone-` in front
    icon : str
        shape, a name of the Material icons that NiceGUI brings along
    meaning : str
        what goes on, a sentence
    """

    word: str
    tone: str
    icon: str
    meaning: str


LOOKS = {
    "off": Look("OFF", "off", "radio_button_unchecked", "The drives are off."),
    "homing": Look(
        "HOMING", "moves", "my_location", "The drives are on; the spindle's index is searched."
    ),
    "ready": Look("READY", "ready", "check_circle", "The drives are on and the angle is known."),
    "rehearsing": Look(
        "REHEARSING", "moves", "replay", "The first height is played clear of the work, to learn."
    ),
    "engaging": Look("ENGAGING", "cuts", "login", "The tool enters the work."),
    "cutting": Look("CUTTING", "cuts", "play_circle", "The part is being cut."),
    "holding": Look("HOLDING", "held", "pause_circle", "Z stands and U goes on; the tool cuts."),
    "disengaging": Look("LEAVING", "cuts", "logout", "The tool leaves the work."),
    "fault": Look("FAULT", "fault", "report", "The tool has left the work, or is on its way."),
    "identifying": Look(
        "MEASURING", "moves", "graphic_eq", "U plays a wave, to measure its drive."
    ),
    "manual": Look("BY HAND", "hand", "pan_tool", "Axes are moved by hand; the spindle stands."),
}
SILENT = Look(
    "NO CONNECTION", "silent", "link_off", "The controller is silent: all values here are old."
)
UNKNOWN = Look("WAITING", "silent", "hourglass_empty", "The first status has not come yet.")
IN_WORK = ("rehearsing", "engaging", "cutting", "holding", "disengaging")


def look(state: str, *, is_connected: bool) -> Look:
    """Return how a state is shown.

    Parameters
    ----------
    is_connected : bool
        whether the controller's status comes
    """
    return LOOKS.get(state, UNKNOWN) if is_connected else SILENT
