# SPDX-License-Identifier: Apache-2.0
"""Why a controller refused a command, with the numbers and what to do.

>>> DEMANDS["u_acceleration"].text(275_000, 250_000, "u_acceleration")
'U acceleration 275 m/s2 exceeds u_acceleration 250 m/s2'
"""

from __future__ import annotations

from dataclasses import dataclass

from camtools.link.controller import Link
from camtools.link.messages import NAMES, NOT_COMMANDER, NUMBERS, OLDER, REFUSALS, Answer, Refused
from camtools.link.rights import sender_text

REMEDIES = {
    "command": OLDER,
    "param_state": "only phase, amplitude, trim and the overrides change while cutting, most "
    "others in ready, all in off",
    "override_rings": "hold it instead, or set feed and speed before the cut",
    "override_measured": "change the feed at the machine that moves Z",
    "table_sense": "disable, then select",
    "param_tick": "observer_bandwidth_mHz is at most 80 x the tick rate in Hz, lead_ns 61 ticks",
    "estop": "release the emergency stop",
    "acknowledge": "press acknowledge at the machine for half a second, with the emergency stop "
    "released and faults reset; give the order again within 60 s",
    "acknowledge_none": "the port has no such button; wire one and name it in the port's settings, "
    "or waive it there",
    "locked": "turn the key switch at the machine off and on during camctl unlock, or unlock with "
    "the secret (camctl unlock --secret FILE)",
    "lock_none": "this port cannot be unlocked; add a key switch or a secret to its settings",
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
_BY_PARAMETER = ("param_state", "param_tick", "trim_limit", "servo", "servo_force")
_OFF, _READY, _MANUAL = "off", "ready", "manual"
_NEEDED_STATE = {  # of commands that one state takes only
    **dict.fromkeys(("enable", "manual"), _OFF),
    **dict.fromkeys(("start", "identify"), _READY),
    **dict.fromkeys(("jog", "step", "home_axis", "zero_x", "zero_z"), _MANUAL),
    "reset": "fault",
}
_FROM_OFF = {
    _READY: "home first",
    _MANUAL: "give manual first",
}
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


@dataclass(frozen=True)
class Excess:
    """What a cut demands too much of, and how that is shown."""

    what: str  # of what
    unit: str  # for people
    scale: float  # that unit per unit of the controller
    parameter: str  # that limits it; "" where none does
    label: str  # what the limit is called: the parameter without its unit, or what else sets it
    share: int = 1  # the limit is that part of the parameter: 1 / share

    def text(self, needed: int, limit: int, label: str) -> str:
        """Return the comparison, in the unit for people."""
        numbers = [f"{value * self.scale:.9g} {self.unit}" for value in (needed, limit)]
        return f"{self.what} {numbers[0]} exceeds {label} {numbers[1]}"


DEMANDS = {
    "spindle_speed": Excess("spindle speed", "r/min", 1e-3, "spindle_limit_mrpm", "spindle_limit"),
    "u_speed": Excess("U speed", "mm/s", 1e-3, "u_speed_um_per_s", "u_speed"),
    "u_acceleration": Excess(
        "U acceleration", "m/s2", 1e-3, "u_acceleration_mm_per_s2", "u_acceleration"
    ),
    "u_stroke": Excess("U travel", "mm", 1e-6, "u_stroke_nm", "half of u_stroke", 2),
    "u_retract": Excess("U retract", "mm", 1e-6, "u_stroke_nm", "half of u_stroke", 2),
    "u_command": Excess(
        "U command with its feed-forward", "mm", 1e-6, "u_stroke_nm", "half of u_stroke", 2
    ),
    "u_command_speed": Excess(
        "speed of U's command", "mm/s", 1e-3, "", "the limit from speed, acceleration and gains,"
    ),
    "u_command_acceleration": Excess(
        "acceleration of U's command", "m/s2", 1e-3, "", "the limit from acceleration and gains,"
    ),
    "servo_continuous": Excess(
        "rms of U's force, without that of the cut,",
        "N",
        1e-3,
        "servo_continuous_mn",
        "servo_continuous",
    ),
    "z_speed": Excess("Z speed", "mm/s", 1e-3, "z_speed_um_per_s", "z_speed"),
    "z_acceleration": Excess(
        "Z acceleration", "m/s2", 1e-3, "z_acceleration_mm_per_s2", "z_acceleration"
    ),
    "feed": Excess("feed", "mm", 1e-6, "", "the height of the part"),
    "turns": Excess("feed of", "turns", 1, "", "what the controller can count,"),
    "tick_rate": Excess("spindle speed", "r/min", 1e-3, "", "what the tick can follow,"),
    "spindle_acceleration": Excess(
        *("spindle acceleration", "rad/s2", 1e-3),
        *("spindle_acceleration_mrad_per_s2", "spindle_acceleration"),
    ),
    "spindle_loop": Excess("fall of the spindle speed", "1/s", 1e-3, "", "1 / spindle_lag"),
    "spindle_set_point": Excess(
        "spindle set-point", "r/min", 1e-3, "spindle_limit_mrpm", "spindle_limit"
    ),
    "x_speed": Excess("X speed", "mm/s", 1e-3, "x_speed_um_per_s", "x_speed"),
    "x_acceleration": Excess(
        "X acceleration", "m/s2", 1e-3, "x_acceleration_mm_per_s2", "x_acceleration"
    ),
    "swing_range": Excess("swing", "deg", 1e-3, "swing_range_mdeg", "swing_range"),
    "swing_speed": Excess("swing speed", "deg/s", 1e-3, "swing_speed_mdeg_per_s", "swing_speed"),
    "swing_acceleration": Excess(
        "swing acceleration", "deg/s2", 1, "swing_acceleration_deg_per_s2", "swing_acceleration"
    ),
}
_FORCE = Excess("force of U at its limits", "N", 1e-3, "servo_force_limit_mn", "servo_force_limit")
_TRIM = Excess("trim of the radius", "mm", 1e-6, "x_trim_limit_nm", "x_trim_limit")


def _last_refusal(link: Link) -> dict[str, int]:
    """Return what the controller tells of its last refusal by numbers; empty: nothing."""
    found = {}
    for index, name in enumerate(REFUSALS):
        answer = link.ask("get_refusal", parameter=index)
        if answer.result != "done":
            return {}
        found[name] = int(answer.value)
    return found


def _label(link: Link, answer: Answer, demand: Excess, limit: int) -> str:
    """Return what the limit is: the parameter, or the table where that allows less."""
    if not demand.parameter:
        return demand.label
    index = NUMBERS["parameter"][demand.parameter]
    is_set = answer.command == "set_parameter" and answer.parameter == index
    value = int(link.ask("get_parameter", parameter=index).value)
    return demand.label if is_set or value // demand.share == limit else "the table's limit"


def _speed_text(refusal: dict[str, int]) -> str:
    highest = refusal["highest_mrpm"] / 1000
    in_pass = f" in pass {refusal['pass']}" if refusal["pass"] else ""
    if highest:
        return f"{in_pass}; the highest feasible speed is {highest:.9g} r/min"
    return f"{in_pass}; no speed is feasible"


def _by_numbers(link: Link, answer: Answer) -> str:
    """Return why the last command was refused, from its numbers; "" where there are none."""
    refusal = _last_refusal(link)
    if not refusal or NAMES["result"].get(refusal["result"]) != answer.result:
        return ""
    name = NAMES["parameter"].get(refusal["parameter"], "")
    needed, limit = refusal["needed"], refusal["limit"]
    if answer.result == "param_state":
        return f"{name} cannot change in this state; {REMEDIES['param_state']}"
    if answer.result == "param_tick":
        return f"{name} {needed} exceeds {limit}, the most at this tick rate"
    if answer.result == "servo":
        return f"{name} = {needed} does not fit the others; {REMEDIES['servo']}"
    if answer.result == "servo_force":
        return f"{_FORCE.text(needed, limit, _FORCE.label)}; {REMEDIES['servo_force']}"
    if answer.result == "trim_limit":
        return _TRIM.text(needed, limit, _TRIM.label)
    if answer.result in DEMANDS:
        demand = DEMANDS[answer.result]
        label = _label(link, answer, demand, limit)
        numbers = demand.text(needed, limit, label)
        if answer.result == "turns":
            return f"{numbers}; {REMEDIES['turns']}"
        return numbers + _speed_text(refusal)
    return ""


def _by_hand(answer: Answer) -> str:
    """Return the limit that the answer to a refused order by hand tells; "" where it has none."""
    if answer.command == "jog" and answer.result == "hand_speed":
        return f"; by hand this axis moves at most {answer.value:.9g} mm/s"
    if answer.command == "step" and answer.result == "travel":
        return f"; its travel ends at {answer.value:.9g} mm"
    return ""


def state_remedy(command: str, state: str) -> str:
    """Return what to do before a command that the state does not take.

    >>> state_remedy("manual", "ready"), state_remedy("jog", "fault")
    ('disable first', 'reset, then give manual first')
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
    way = _FROM_OFF[needed]
    return way if state == _OFF else f"{_TO_OFF[state]}, then {way}"


def _cut_remedy(command: str, state: str) -> str:
    """Return why stop, hold or resume is refused."""
    if state in (_OFF, _MANUAL, *_TO_OFF):
        return f"nothing is being cut{_NO_CUT[command]}"
    if state == "disengaging":
        return "the cut is ending already"
    if command == "resume":
        return "it is not on hold"
    return "it is on hold already" if state == "holding" else "wait until it cuts"


def state_of(link: Link) -> str:
    """Return the state of a status message that is yet to come."""
    link.status.signals.pop("state", None)
    link.wait(lambda: "state" in link.status.signals, _STATE_S)
    return link.status.state


def _datum(link: Link, answer: Answer) -> str:
    """Return why a datum is out of range: it is what an axis' place makes of a value in range."""
    axis = answer.command.removeprefix("zero_")
    index = NUMBERS["parameter"][f"{axis}_datum_nm"]
    low, high = (link.ask(f"get_{end}", parameter=index).value for end in ("minimum", "maximum"))
    span = f"{low * 1e-6:.9g} .. {high * 1e-6:.9g} mm"
    return f"refused: {axis}_datum would leave {span}; move {axis} nearer to its home"


def _not_commander(holder: int) -> str:
    """Return why somebody who does not command was refused, and what to do."""
    if not holder:
        return "nobody commands; take command first"
    return f"{sender_text(holder)} commands; wait until he gives it back, or take over"


def explain(link: Link, answer: Answer) -> str:
    """Return why a command was refused and what to do."""
    if answer.result == "param_range" and answer.command in ("zero_x", "zero_z"):
        return _datum(link, answer)
    if answer.result == NOT_COMMANDER:
        return f"refused: {_not_commander(int(answer.value))}"
    if answer.result == "state":
        state = state_of(link)
        return f"refused: state {state}; {state_remedy(answer.command, state)}"
    what = answer.result.replace("_", " ")
    if by_hand := _by_hand(answer):
        return f"refused: {what}{by_hand}"
    if answer.limits is not None:
        low, high = answer.limits
        name = NAMES["parameter"].get(answer.parameter, str(answer.parameter))
        return f"out of range; {name} is {low:.9g} .. {high:.9g}"
    is_numbered = answer.result in (*DEMANDS, *_BY_PARAMETER)
    remedy = REMEDIES.get(answer.result)
    text = _by_numbers(link, answer) if is_numbered else ""
    return f"refused: {text or what}" + (f"; {remedy}" if remedy and not text else "")


def require(link: Link, answer: Answer, values: str = "") -> Answer:
    """Return an answer that accepts a command.

    Parameters
    ----------
    values : str
        told behind the command, where it was refused

    Raises
    ------
    Refused
        It is refused; the text tells why, with the numbers.
    """
    if answer.result != "done":
        raise Refused(f"{answer.command.replace('_', ' ')}{values}: {explain(link, answer)}")
    return answer


def ask_done(
    link: Link, command: str, parameter: int = 0, timeout_s: float = 1.0, **value: float
) -> Answer:
    """Send a command that must be accepted, and return its answer.

    Raises
    ------
    Refused
        It is not; the text tells why, with the numbers.
    CamtoolsError
        The value is outside the range of its signal.
    """
    answer = link.ask(command, timeout_s=timeout_s, parameter=parameter, **value)
    return require(link, answer, "".join(f" = {number:.9g}" for number in value.values()))
