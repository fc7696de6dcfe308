"""Why a controller refused a command or stopped with a fault, and what to do.

Cause and remedy have one source, the table of firmware/FAULTS.md; the title is the comment of the
fault's signal in the DBC.

>>> FAULTS["estop"].title, FAULTS["estop"].cause
('Emergency stop', 'The emergency-stop chain is open.')
"""

from __future__ import annotations

import re
from typing import NamedTuple

from camtools.base.controller_limits import LIMITS, TEXTS, needs_text
from camtools.base.project import ROOT
from camtools.link import messages
from camtools.link.controller import Link
from camtools.link.messages import Answer, Refused
from camtools.link.rights import sender_text

REMEDIES = {
    "command": messages.OLDER,
    "param_state": "only phase, amplitude, trim and the overrides change while cutting, most "
    "others in ready, all in off",
    "override_rings": "hold it instead, or set feed and speed before the cut",
    "override_measured": "change the feed at the machine that moves Z",
    "table_sense": "disable, then select",
    "estop": "release the emergency stop",
    "acknowledge": "press acknowledge at the machine for half a second, with the emergency stop "
    "released and faults reset; give the order again within 60 s",
    "acknowledge_none": "the port has no such button; wire one and name it in the port's settings, "
    "or waive it there",
    "locked": "turn the key switch at the machine off and on; for a command line, while camctl "
    "unlock runs",
    "lock_none": "this port cannot be unlocked; add a key switch to its settings",
    "hard_limit": "the firmware image fixes this limit; it cannot be changed over the bus",
    "drive": "see that all drives are ready",
    "no_table": "download a table and select it",
    "u_place": "move U into its stroke",
    "download_room": "make the table with a larger --tolerance-nm",
    "download_crc": "download again",
    "download_store": "its memory failed and the old table stays active; try again",
    "busy": "try again",
    "cam_amplitude": "set the amplitude to 100 % or more",
    "turns": "set a larger feed; another speed does not help",
    "u_retract": "set u_retract_nm nearer to 0, or to its default, which fits every stroke",
    "hand_axis": "give u, x or z; a measured z is moved by another controller",
    "hand_moves": "wait until the axis has stopped, or stop it",
    "home_none": "set u_home, x_home or z_home: 1 present position, 2 switch, 3 switch and index; "
    "only a U that takes forces: 4 stop, 5 stop and index",
    "not_homed": "in manual, home every axis that has a homing method: home u, home x, home z",
    "travel": "check x_low_nm, x_high_nm, z_low_nm, z_high_nm, the datum and the tool",
    "servo_none": "design the loop with tools/tune, and load the parameters that it proposes",
    "servo": "keep servo_pole_hz within a fifth and servo_notch_hz within a quarter of the tick "
    "rate, servo_crossover_hz within the pole, servo_integral_mHz within the crossover, "
    "servo_force_limit_mn within 15 times servo_continuous_mn, and servo_mass_g at 32 or more at "
    "tick rates below 900 Hz; tools/tune proposes such a loop",
    "servo_force": "raise servo_force_limit_mn, where motor and amplifier allow it, or lower "
    "u_acceleration_mm_per_s2 or u_speed_um_per_s",
    "params_stale": "another tool set a parameter meanwhile; try again",
    "params_none": "`params keep` stores the current ones",
    "params_damaged": "`params keep` stores the current ones instead",
    "params_keep": "its memory failed or is read-only; what was kept before stays; see its log",
}
_AT_MOST = ("param_tick", "param_output", "gain")
_BY_PARAMETER = ("param_state", "servo", "jerk", *_AT_MOST)
_OFF, _READY, _MANUAL = "off", "ready", "manual"
_NEEDED_STATE = {  # of commands that one state takes only
    **dict.fromkeys(("enable", "manual"), _OFF),
    **dict.fromkeys(("start", "identify"), _READY),
    **dict.fromkeys(("jog", "step", "home_axis", "zero_x", "zero_z"), _MANUAL),
    "reset": "fault",
}
_FROM_OFF = {_READY: "home first", _MANUAL: "give manual first"}
_TO_OFF = {  # before what is given from off
    _READY: "disable",
    _MANUAL: "disable",
    "homing": "wait until it is homed, or disable",
    "fault": "reset",
}
_STATE_S = 1.0
_NO_CUT = {  # after "nothing is being cut"
    "stop": "",
    "hold": "; start first",
    "resume": ", so nothing is on hold",
}


def _last_refusal(link: Link) -> dict[str, int]:
    """Return the numbers of the controller's last refusal; empty: it has none."""
    found = {}
    for index, name in enumerate(messages.REFUSALS):
        answer = link.ask("get_refusal", parameter=index)
        if answer.result != "done":
            return {}
        found[name] = int(answer.value)
    return found


def _source(link: Link, answer: Answer, limit: int) -> str:
    """Return what gives the limit: the parameter, or the table if it allows less; "" if neither."""
    name = LIMITS[answer.result].parameter
    if name == "none":
        return ""
    index = messages.NUMBERS["parameter"][name]
    is_set = answer.command == "set_parameter" and answer.parameter == index
    value = int(link.ask("get_parameter", parameter=index).value)
    is_parameter = is_set or limit in (value, value // 2)  # half of a stroke
    return f" ({name})" if is_parameter else " (the table's)"


def _speed_text(refusal: dict[str, int]) -> str:
    highest = refusal["highest_mrpm"] / 1000
    in_pass = f" in pass {refusal['pass']}" if refusal["pass"] else ""
    if highest:
        return f"{in_pass}; the highest feasible speed is {highest:.9g} r/min"
    return f"{in_pass}; no speed is feasible"


def _by_numbers(link: Link, answer: Answer) -> str:
    """Return why the last command was refused, from its numbers; "" where there are none."""
    refusal = _last_refusal(link)
    if not refusal or messages.NAMES["result"].get(refusal["result"]) != answer.result:
        return ""
    name = messages.NAMES["parameter"].get(refusal["parameter"], "")
    needed, limit = refusal["needed"], refusal["limit"]
    if answer.result == "param_state":
        return f"{name} cannot change in this state; {REMEDIES['param_state']}"
    if answer.result in _AT_MOST:
        return f"{name} = {needed}: {TEXTS[answer.result]}; give at most {limit}"
    if answer.result == "jerk":
        return f"{name} = {needed}: {TEXTS[answer.result]}; give at least {limit}"
    if answer.result == "servo":
        return f"{name} = {needed} does not fit the others; {REMEDIES['servo']}"
    numbers = needs_text(answer.result, needed, limit)
    text = f"{TEXTS[answer.result]}: {numbers}{_source(link, answer, limit)}"
    if answer.result in REMEDIES:
        return f"{text}; {REMEDIES[answer.result]}"
    return text if answer.result == "trim_limit" else text + _speed_text(refusal)


def _by_hand(answer: Answer) -> str:
    """Return the limit in the answer to a refused order by hand; "" where it has none."""
    if answer.command == "jog" and answer.result == "hand_speed":
        return f"; by hand this axis moves at most {answer.value:.9g} mm/s"
    if answer.command == "step" and answer.result == "travel":
        return f"; its travel ends at {answer.value:.9g} mm"
    return ""


def state_remedy(command: str, state: str) -> str:
    """Return what to do before a command that the state does not take.

    >>> state_remedy("jog", "off"), state_remedy("jog", "fault")
    ('give manual first', 'reset, then give manual first')
    >>> state_remedy("start", "cutting")
    'wait for the end of the cut, or stop it'
    >>> state_remedy("resume", "ready"), state_remedy("resume", "cutting")
    ('nothing is being cut, so nothing is on hold', 'it is not on hold')
    """
    needed = _NEEDED_STATE.get(command)
    if command in _NO_CUT:
        return _cut_remedy(command, state)
    if state not in (_OFF, *_TO_OFF):
        return "wait for the end of the cut, or stop it"
    if needed == "fault":
        return "there is no fault to reset"
    if needed is None:
        return "see the states in firmware/README.md"
    if needed == _OFF:
        return f"{_TO_OFF[state]} first" if state in _TO_OFF else "give it again"
    remedy = _FROM_OFF[needed]
    return remedy if state == _OFF else f"{_TO_OFF[state]}, then {remedy}"


def _cut_remedy(command: str, state: str) -> str:
    if state in (_OFF, _MANUAL, *_TO_OFF):
        return f"nothing is being cut{_NO_CUT[command]}"
    if state == "disengaging":
        return "the cut is ending already"
    if command == "resume":
        return "it is not on hold"
    return "it is on hold already" if state == "holding" else "wait until it cuts"


def _datum(link: Link, answer: Answer) -> str:
    """Return why a datum is out of range: it is what an axis' place makes of a value in range."""
    axis = answer.command.removeprefix("zero_")
    index = messages.NUMBERS["parameter"][f"{axis}_datum_nm"]
    low, high = (link.ask(f"get_{end}", parameter=index).value for end in ("minimum", "maximum"))
    span = f"{low * 1e-6:.9g} .. {high * 1e-6:.9g} mm"
    return f"refused: {axis}_datum would leave {span}; move {axis} nearer to its home"


def explain(link: Link, answer: Answer) -> str:
    """Return why a command was refused and what to do."""
    if answer.result == "param_range" and answer.command in ("zero_x", "zero_z"):
        return _datum(link, answer)
    if answer.result == messages.NOT_COMMANDER:
        holder = int(answer.value)
        if not holder:
            return "refused: nobody commands; take command first"
        who = sender_text(holder)
        return f"refused: {who} commands; wait until he gives it back, or take over"
    if answer.result == "state":
        link.await_anew("state", _STATE_S)
        state = link.status.state
        return f"refused: state {state}; {state_remedy(answer.command, state)}"
    what = answer.result.replace("_", " ")
    if by_hand := _by_hand(answer):
        return f"refused: {what}{by_hand}"
    if answer.limits is not None:
        low, high = answer.limits
        name = messages.NAMES["parameter"].get(answer.parameter, str(answer.parameter))
        return f"out of range; {name} is {low:.9g} .. {high:.9g}"
    is_numbered = answer.result in (*LIMITS, *_BY_PARAMETER)
    remedy = REMEDIES.get(answer.result)
    text = _by_numbers(link, answer) if is_numbered else ""
    return f"refused: {text or what}" + (f"; {remedy}" if remedy and not text else "")


def require(link: Link, answer: Answer, what: str) -> Answer:
    """Return an answer that accepts a command; a refusal names `what` and why, with the numbers."""
    if answer.result != "done":
        raise Refused(f"{what}: {explain(link, answer)}")
    return answer


def ask_done(
    link: Link, command: str, parameter: int = 0, timeout_s: float = 1.0, **value: float
) -> Answer:
    """Send a command that must be accepted; return its answer. A refusal has the numbers."""
    answer = link.ask(command, timeout_s=timeout_s, parameter=parameter, **value)
    values = "".join(f" = {number:.9g}" for number in value.values())
    return require(link, answer, command.replace("_", " ") + values)


FAULTS_MD = ROOT / "firmware" / "FAULTS.md"
_ROW = re.compile(r"\| `(\w+)` \| ([^|]+) \| [^|]+ \| [^|]+ \| ([^|]+) \|")
_LINK = re.compile(r"\[([^]]*)\]\([^)]*\)")


class FaultText(NamedTuple):
    """A fault for people."""

    title: str
    cause: str
    remedy: str


def _sentence(cell: str) -> str:
    """Return a cell of a table in Markdown as a plain sentence."""
    plain = _LINK.sub(r"\1", cell).replace("`", "").strip()
    return f"{plain[:1].upper()}{plain[1:]}."


def texts_of(markdown: str) -> dict[str, FaultText]:
    """Return the faults of the table in FAULTS.md, by their names and in their order."""
    return {
        name: FaultText(
            messages.FAULT_TEXTS.get(name, name).rstrip("."),
            _sentence(cause),
            _sentence(remedy),
        )
        for name, cause, remedy in _ROW.findall(markdown)
    }


FAULTS = texts_of(FAULTS_MD.read_text("utf-8"))
