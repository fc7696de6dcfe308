"""Which orders make sense in a state, and what is missing before the next one can be given.

>>> why_not("start", "off", {})
'only in ready'
>>> why_not("start", "ready", {})
''

What the controller refuses stands in firmware/machine/cam_machine.c; the list names what can be
seen from its status and its parameters. A speed that is not feasible is told by the refusal itself.

>>> way = way_on("off", {"is_estop": 1.0, "is_drive_ready": 1.0, "table_size": 3456.0}, {})
>>> [item.key for item in way.missing], way.order
(['estop'], 'enable')
>>> way.sentence
'Release the emergency stop.'
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from camtools.link.status_text import name_of

_IDLE = ("off", "ready")
_BY_HAND = ("off", "manual", "ready")
_AT_REST = ("off", "ready", "manual", "fault", "homing")
_RAMPED = ("off", "ready", "rehearsing", "engaging", "cutting", "disengaging", "holding")
_ANY = (
    *("off", "homing", "ready", "engaging", "cutting", "disengaging", "fault", "rehearsing"),
    *("identifying", "manual", "holding"),
)
_STOPS = {
    "rehearsing": "stop",
    "engaging": "stop",
    "cutting": "stop",
    "holding": "stop",
    "manual": "stop",
    "identifying": "stop",
    "homing": "disable",
    "ready": "disable",
}


@dataclass(frozen=True)
class Rule:
    """When an order is accepted."""

    states: tuple[str, ...]
    otherwise: str


RULES = {
    "enable": Rule(("off",), "only in off"),
    "disable": Rule(("homing", "ready", "manual"), "only in homing, ready and by hand"),
    "start": Rule(("ready",), "only in ready"),
    "hold": Rule(("rehearsing", "engaging", "cutting"), "only during a cut"),
    "resume": Rule(("rehearsing", "engaging", "cutting", "holding"), "only while the feed is held"),
    "reset": Rule(("fault",), "only after a fault"),
    "home": Rule(("off", "ready"), "only in off and ready"),
    "manual": Rule(("off",), "only in off"),
    "jog": Rule(("manual",), "only by hand; press By hand first"),
    "step": Rule(("manual",), "only by hand; press By hand first"),
    "home_axis": Rule(("manual",), "only by hand; press By hand first"),
    "zero": Rule(_BY_HAND, "only in off, ready and by hand"),
    "tool": Rule(_BY_HAND, "only in off, ready and by hand"),
    "feed": Rule(_RAMPED, "not in this state"),
    "spindle": Rule(_RAMPED, "not in this state"),
    "trim": Rule(_RAMPED, "not in this state"),
    "parts": Rule(_ANY, ""),
    "table": Rule(_IDLE, "only in off and ready"),
    "params": Rule(_ANY, ""),
    "keep": Rule(("off",), "only in off"),
    "revert": Rule(_IDLE, "only in off and ready"),
    "defaults": Rule(_IDLE, "only in off and ready"),
    "push_u": Rule(("ready",), "only in ready"),
    "measure_loop": Rule(("ready",), "only in ready"),
    "apply_loop": Rule(("ready",), "only in ready"),
    "unlock": Rule(_AT_REST, "only while the machine is at rest"),
    "lock": Rule(_ANY, ""),
}


def why_not(order: str, state: str, signals: Mapping[str, float]) -> str:
    """Return why an order would be refused now, a clause; "" when it makes sense."""
    rule = RULES[order]
    if state not in rule.states:
        return rule.otherwise
    is_held = bool(signals.get("is_held", 0.0))
    if order == "hold" and is_held:
        return "the feed is held already"
    if order == "resume" and not is_held:
        return "only while the feed is held"
    is_unlocked = bool(signals.get("level", 0.0))
    if order == "unlock" and is_unlocked:
        return "already unlocked"
    if order == "lock" and not is_unlocked:
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
_NM_PER_MM = 1e6
_M_PER_UNIT = 1000.0


@dataclass(frozen=True)
class Missing:
    """Something to be done by a person."""

    key: str  # stable name
    text: str  # what to do, a sentence


@dataclass(frozen=True)
class Way:
    """How it goes on from here."""

    missing: tuple[Missing, ...]  # the first is to be done first; empty: the order will be accepted
    order: str  # that leads on; "" where the controller goes on by itself
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
    return stroke_nm is not None and abs(s.get("u_actual", 0.0)) * _NM_PER_MM > stroke_nm / 2


def _lacks_home(axis: str) -> Look:
    """Whether a home is demanded that was not found; a Z that others lead needs none."""

    def look(s: Signals, p: Values) -> bool:
        is_led = axis == "z" and bool(p.get("z_is_measured", 0))
        is_wanted = bool(p.get("homing_required", 0)) and bool(p.get(f"{axis}_home", 0))
        return is_wanted and not is_led and not s.get(f"homed_{axis}", 0.0)

    return look


def _has_stopped(s: Signals, p: Values) -> bool:
    return abs(s.get("speed", 0.0)) * _M_PER_UNIT <= p.get("stopped_mrpm", _STOPPED_MRPM)


def _is_reversed(s: Signals, p: Values) -> bool:
    return s.get("speed", 0.0) * _M_PER_UNIT < -p.get("stopped_mrpm", _STOPPED_MRPM)


_ESTOP = (_is("is_estop"), Missing("estop", "Release the emergency stop."))
_DRIVES = (
    _lacks("is_drive_ready"),
    Missing("drive", "Get the drives ready: switch on their power and clear their own faults."),
)
_BUS = (_is("is_bus_lost"), Missing("bus", "Reconnect the silent node of the field bus."))
_BUTTON = (
    _says("acknowledge", "needed"),
    Missing(
        "acknowledge",
        "Press acknowledge at the machine for half a second, then Enable within 60 s.",
    ),
)
_NO_BUTTON = (
    _says("acknowledge", "none"),
    Missing(
        "no_button",
        "This controller has no acknowledge button, so its drives stay off: wire one, or waive it "
        "in the port's settings.",
    ),
)
_TABLE = (_lacks("table_size"), Missing("table", "Load a table in the Table box below."))
_U_PLACE = (_is_u_outside, Missing("u_place", "Move U back into its stroke by hand."))
_HOMES = tuple(
    (
        _lacks_home(axis),
        Missing(f"home_{axis}", f"Home {axis.upper()}: press By hand, then Home {axis.upper()}."),
    )
    for axis in "uxz"
)
_TURN = (_has_stopped, Missing("turn", "The spindle does not turn: check its drive."))
_SENSE = (
    _is_reversed,
    Missing("sense", "The spindle turns against the cutting direction: reverse it."),
)
_INDEX = (_lacks("is_synced"), Missing("index", "Wait for the spindle index: none seen yet."))
_STEADY = (
    _says("start_wait", "waits"),
    Missing("steady", "Wait until the spindle turns steadily."),
)
_UNSTEADY = (
    _says("start_wait", "unsteady"),
    Missing(
        "unsteady",
        "The spindle did not turn steadily, so the last start was ended: check its drive.",
    ),
)
_RETRACT = (_lacks("is_retracted"), Missing("retract", "Wait until the tool has left the work."))
_HELD_BY_FEED = (
    lambda s, p: not s.get("is_held", 0.0) and s.get("override_of_feed", 100.0) < 1.0,
    Missing("feed", "Raise the feed override: below 1 %, Z does not move."),
)
# A reset would be accepted while a cause is still there, and the next enable refused.
_CAUSES = (_ESTOP, _DRIVES, _BUS)
_ENABLES = (*_CAUSES, _TABLE, _U_PLACE, *_HOMES, _NO_BUTTON, _BUTTON)
_STEPS: dict[str, tuple[tuple[tuple[Look, Missing], ...], str, str]] = {
    "off": (_ENABLES, "enable", "Press Enable to switch the drives on and find the spindle index."),
    "homing": ((_TURN, _SENSE, _INDEX), "", "Wait: the machine will be ready in a moment."),
    "ready": ((_TABLE, *_HOMES, _UNSTEADY), "start", "Press Start to cut the part."),
    "rehearsing": (
        (_STEADY,),
        "",
        "The tool moves clear of the work, to learn; the cut follows automatically.",
    ),
    "engaging": ((_STEADY,), "", "The tool enters the work; STOP retracts it."),
    "cutting": ((), "", "Cutting. Hold pauses Z, STOP retracts the tool."),
    "holding": ((_HELD_BY_FEED,), "resume", "Press Resume to continue, or STOP."),
    "disengaging": ((), "", "The tool leaves the work; wait until it is ready."),
    "fault": ((*_CAUSES, _RETRACT), "reset", "Press Reset when the cause is gone."),
    "identifying": ((), "", "U is being measured; wait for the end, or press STOP."),
    "manual": ((), "disable", "Move the axes; press Disable when you are done."),
}
_SILENT = (
    Missing(
        "connection", "Reconnect the controller: check its power, the bus and its terminators."
    ),
    Missing("program", "For a simulated lathe, start tools/live."),
)


def way_on(state: str, signals: Signals, values: Values, *, is_connected: bool = True) -> Way:
    """Return what is missing, the order that it is missing for, and what to do then.

    Parameters
    ----------
    signals : Mapping
        of the status, by their names in the DBC, in their units
    values : Mapping
        parameters that are known; may be empty
    """
    if not is_connected:
        return Way(_SILENT, "", "Then this page continues automatically.")
    if state not in _STEPS:
        first = Missing("status", "Wait for the controller's first status.")
        return Way((first,), "", "Then this box shows what is missing.")
    steps, order, then = _STEPS[state]
    missing = tuple(item for is_so, item in steps if is_so(signals, values))
    if state == "holding" and missing:
        order = ""
    return Way(missing, order, then)
