"""Which orders make sense in a state, and what is missing before the next one can be given.

What the controller refuses stands in firmware/machine/cam_machine.c; the list names what can be
seen from its status and its parameters. A speed that is not feasible shows in the refusal itself.

>>> why_not("start", "off", {})
'only in ready'
>>> next_steps("off", {"is_estop": 1.0, "is_drive_ready": 1.0, "table_size": 3456.0}, {}).sentence
'Release the emergency stop.'
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from camtools.base.quantities import NM_PER_MM
from camtools.link.messages import NAMES
from camtools.link.status_text import name_of

_ANY = tuple(NAMES["state"].values())
_STOPS = {"homing": "disable", "ready": "disable"}
_ONLY_BY_HAND = (("manual",), "only by hand; press By hand first")
_WITH_PLACES = (("off", "manual", "ready"), "only in off, ready and by hand")
_WITH_RAMPS = (
    ("off", "ready", "rehearsing", "engaging", "cutting", "disengaging", "holding"),
    "not in this state",
)
_WHILE_IDLE = (("off", "ready"), "only in off and ready")
_IN_OFF, _IN_READY = (("off",), "only in off"), (("ready",), "only in ready")
_ALWAYS = (_ANY, "")
# The states in which an order is accepted, and why not in others.
RULES: dict[str, tuple[tuple[str, ...], str]] = {
    **dict.fromkeys(("enable", "manual", "keep"), _IN_OFF),
    **dict.fromkeys(("start", "push_u", "measure_loop", "apply_loop"), _IN_READY),
    **dict.fromkeys(("home", "table", "revert", "defaults"), _WHILE_IDLE),
    **dict.fromkeys(("jog", "step", "home_axis"), _ONLY_BY_HAND),
    **dict.fromkeys(("zero", "tool"), _WITH_PLACES),
    **dict.fromkeys(("feed", "spindle", "trim"), _WITH_RAMPS),
    **dict.fromkeys(("parts", "params", "lock"), _ALWAYS),
    "disable": (("homing", "ready", "manual"), "only in homing, ready and by hand"),
    "hold": (("rehearsing", "engaging", "cutting"), "only during a cut"),
    "resume": (("rehearsing", "engaging", "cutting", "holding"), "only while the feed is held"),
    "reset": (("fault",), "only after a fault"),
}


def why_not(order: str, state: str, signals: Mapping[str, float]) -> str:
    """Return why an order would be refused now, a clause; "" when it makes sense."""
    states, otherwise = RULES[order]
    if state not in states:
        return otherwise
    is_held = bool(signals.get("is_held", 0.0))
    if order == "hold" and is_held:
        return "the feed is held already"
    if order == "resume" and not is_held:
        return "only while the feed is held"
    if order == "lock" and not signals.get("level", 0.0):
        return "already locked"
    if order == "reset" and not signals.get("is_retracted", 1.0):
        return "the tool is still leaving the work; wait a moment"
    return ""


def stop_order(state: str) -> str:
    """Return what the one big button orders: to end what moves, in the mildest way that does.

    In the work the tool leaves it and the spindle goes on; in homing and ready the drives go off;
    by hand the axis brakes. Elsewhere nothing moves, and stop is ordered all the same: whoever
    presses it gets an answer.
    """
    return _STOPS.get(state, "stop")


Signals = Mapping[str, float]
Values = Mapping[str, int]
_STOPPED_MRPM = 5000  # default of the parameter
_M_PER_UNIT = 1000.0


@dataclass(frozen=True)
class Missing:
    """Something to be done by a person."""

    key: str  # stable name
    text: str  # what to do, a sentence


@dataclass(frozen=True)
class NextSteps:
    """What is to be done from here on."""

    missing: tuple[Missing, ...]  # the first is to be done first; empty: the order will be accepted
    order: str  # to give next; "" where the controller continues by itself
    then: str  # what to do or to wait for when nothing is missing, a sentence

    @property
    def sentence(self) -> str:
        """What is to be done first."""
        return self.missing[0].text if self.missing else self.then

    @property
    def sentences(self) -> list[str]:
        """Everything, in its order."""
        return [*(item.text for item in self.missing), self.then]


Look = Callable[[Signals, Values], bool]


def _is(name: str) -> Look:
    return lambda s, p: bool(s.get(name, 0.0))


def _lacks(name: str) -> Look:
    """Whether something that was reported is not there; what was never reported is not missed."""
    return lambda s, p: name in s and not s[name]


def _says(signal: str, word: str) -> Look:
    """Whether a signal with words has one of them."""
    return lambda s, p: name_of(s, signal) == word


def _is_u_outside(s: Signals, p: Values) -> bool:
    """U stands outside of its stroke, by which enable is refused (u_place)."""
    stroke_nm = p.get("u_stroke_nm")
    return stroke_nm is not None and abs(s.get("u_actual", 0.0)) * NM_PER_MM > stroke_nm / 2


def _lacks_home(axis: str) -> Look:
    """Whether a home is demanded that was not found; a Z moved by another controller needs none."""

    def look(s: Signals, p: Values) -> bool:
        is_led = axis == "z" and bool(p.get("z_is_measured", 0))
        is_wanted = bool(p.get("homing_required", 0)) and bool(p.get(f"{axis}_home", 0))
        return is_wanted and not is_led and not s.get(f"homed_{axis}", 0.0)

    return look


def _has_stopped(s: Signals, p: Values) -> bool:
    return abs(s.get("speed", 0.0)) * _M_PER_UNIT <= p.get("stopped_mrpm", _STOPPED_MRPM)


def _is_reversed(s: Signals, p: Values) -> bool:
    return s.get("speed", 0.0) * _M_PER_UNIT < -p.get("stopped_mrpm", _STOPPED_MRPM)


# What may be missing, by stable names: by what it is known, and what is to be done.
_ITEMS: dict[str, tuple[Look, str]] = {
    "estop": (_is("is_estop"), "Release the emergency stop."),
    "drive": (
        _lacks("is_drive_ready"),
        "Get the drives ready: switch on their power and clear their own faults.",
    ),
    "bus": (_is("is_bus_lost"), "Reconnect the silent node of the field bus."),
    "acknowledge": (
        _says("acknowledge", "needed"),
        "Press acknowledge at the machine for half a second, then Enable within 60 s.",
    ),
    "no_button": (
        _says("acknowledge", "none"),
        "This controller has no acknowledge button, so its drives stay off: wire one, or waive it "
        "in the port's settings.",
    ),
    "table": (_lacks("table_size"), "Load a table in the Table box below."),
    "u_place": (_is_u_outside, "Move U back into its stroke by hand."),
    **{
        f"home_{axis}": (
            _lacks_home(axis),
            f"Home {axis.upper()}: press By hand, then Home {axis.upper()}.",
        )
        for axis in "uxz"
    },
    "turn": (_has_stopped, "The spindle does not turn: check its drive."),
    "sense": (
        _is_reversed,
        "The spindle turns against the cutting direction: reverse its drive, or change "
        "encoder_sign if it turns rightly.",
    ),
    "index": (_lacks("is_synced"), "Wait for the spindle index: none seen yet."),
    "steady": (_says("start_wait", "waits"), "Wait until the spindle turns steadily."),
    "unsteady": (
        _says("start_wait", "unsteady"),
        "The spindle did not turn steadily, so the last start was ended: check its drive.",
    ),
    "retract": (_lacks("is_retracted"), "Wait until the tool has left the work."),
    "feed": (
        lambda s, p: not s.get("is_held", 0.0) and s.get("override_of_feed", 100.0) < 1.0,
        "Raise the feed override: below 1 %, Z does not move.",
    ),
}
# A reset would be accepted while a cause is still there, and the next enable refused.
_CAUSES = "estop drive bus"
_HOMES = "home_u home_x home_z"
# By state: what may be missing, in the order of doing; the order to give next; and what to do.
_STEPS = {
    "off": (
        f"{_CAUSES} table u_place {_HOMES} no_button acknowledge",
        *("enable", "Press Enable to switch the drives on and find the spindle index."),
    ),
    "homing": ("turn sense index", "", "Wait: the machine will be ready in a moment."),
    "ready": (f"table {_HOMES} unsteady", "start", "Press Start to cut the part."),
    "rehearsing": (
        "steady",
        *("", "The tool moves clear of the work, to learn; the cut follows automatically."),
    ),
    "engaging": ("steady", "", "The tool enters the work; STOP retracts it."),
    "cutting": ("", "", "Cutting. Hold pauses Z, STOP retracts the tool."),
    "holding": ("feed", "resume", "Press Resume to continue, or STOP."),
    "disengaging": ("", "", "The tool leaves the work; wait until it is ready."),
    "fault": (f"{_CAUSES} retract", "reset", "Press Reset when the cause is gone."),
    "identifying": ("", "", "U is being measured; wait for the end, or press STOP."),
    "manual": ("", "disable", "Move the axes; press Disable when you are done."),
}
_SILENT = (
    Missing(
        "connection", "Reconnect the controller: check its power, the bus and its terminators."
    ),
    Missing("program", "For a simulated lathe, start tools/live."),
)


def next_steps(
    state: str, signals: Signals, values: Values, *, is_connected: bool = True
) -> NextSteps:
    """Return what is missing, the order that it is missing for, and what to do then.

    `signals`: of the status, by their names in the DBC, in their units. `values`: parameters that
    are known; may be empty.
    """
    if not is_connected:
        return NextSteps(_SILENT, "", "Then this page continues automatically.")
    if state not in _STEPS:
        first = Missing("status", "Wait for the controller's first status.")
        return NextSteps((first,), "", "Then this box shows what is missing.")
    keys, order, then = _STEPS[state]
    items = ((key, *_ITEMS[key]) for key in keys.split())
    missing = tuple(Missing(key, text) for key, is_so, text in items if is_so(signals, values))
    if state == "holding" and missing:
        order = ""
    return NextSteps(missing, order, then)
