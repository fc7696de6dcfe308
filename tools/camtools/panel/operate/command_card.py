"""The orders of every day: enable, start, hold, resume, reset; and overrides, trim, parts."""

from collections.abc import Callable
from functools import partial

from nicegui import ui
from nicegui.events import GenericEventArguments

from camtools.base.quantities import UM_PER_MM
from camtools.panel.operate.order_buttons import Orders, Press
from camtools.panel.orders.snapshot import Snapshot
from camtools.panel.pieces import asks, card, confirmed, outlined
from camtools.panel.views.availability import why_not

_FEED_DETENTS = (0, 50, 80, 100, 120, 150)
_SPINDLE_DETENTS = (50, 80, 90, 100, 110, 120)
_CHANGED = "table, state or commander have changed meanwhile; check, and start again"
# Order, label, icon, words of its outcome, key.
_ORDERS = (
    ("enable", "Enable", "power_settings_new", "", "E"),
    ("start", "Start", "play_arrow", "", "S"),
    ("hold", "Hold", "pause", "", "H"),
    ("resume", "Resume", "play_circle", "", "R"),
    ("disable", "Disable", "power_off", "", "D"),
    ("reset", "Reset", "restart_alt", "", "T"),
    ("home", "Find index", "my_location", "find the index", ""),
    ("manual", "By hand", "pan_tool", "by hand", "M"),
)


class CommandCard:
    """Buttons of the sequence; their orders are those of the keyboard, too."""

    def __init__(self, orders: Orders) -> None:
        self._orders = orders
        self._presses: dict[str, Press] = {}  # by key
        self.on_keys: Callable[[], None] = lambda: None
        with card("Commands", "commands"):
            orders.why_all_are_off()
            with ui.element("div").classes("op-buttons"):
                for order, label, icon, words, key in _ORDERS:
                    is_start = order == "start"
                    press = self.start if is_start else partial(orders.give, order, words)
                    tone = "op-go" if is_start else "op-do"
                    orders.button(label, order, icon, press, key=key, tone=tone)
                    if key:
                        self._presses[key.lower()] = press
            orders.last_order()
            asks("start", self.start)
            outlined("Keys", "help-open", lambda: self.on_keys(), icon="keyboard")

    async def by_key(self, key: str) -> None:
        """Do what a key means, where it makes sense."""
        if (press := self._presses.get(key.lower())) is not None:
            await press()

    async def start(self) -> None:
        """Cut a part, after a question; nothing starts unasked, however new the state is."""
        newest = self._orders.context.service.snapshot()
        why = self._orders.why_no_rights or why_not("start", newest.state, newest.signals)
        if why:
            self._orders.refuse("start", why)
            return
        text = f"Spindle and axes will move to cut {newest.table_name}. Is the door shut?"
        asked = self._what_starts(newest)
        if not await confirmed("Start the cut?", text, "Start", "start"):
            return
        if self._what_starts(self._orders.context.service.snapshot()) != asked:
            self._orders.refuse("start", _CHANGED)
            return
        await self._orders.give("start")

    def _what_starts(self, now: Snapshot) -> tuple[object, ...]:
        """Return what an answer to the question holds for: table, state, and who commands."""
        commander = self._orders.context.commander
        is_mine = commander.holder is self._orders.visitor
        return now.table_name, now.signals.get("table_crc"), now.state, is_mine, commander.since_s


class Override:
    """A slider with detents and a button of 100 %; it orders what a person sets, never by itself.

    It follows the controller while nobody moves it.
    """

    def __init__(
        self, orders: Orders, label: str, order: str, signal: str, detents: tuple[int, ...]
    ) -> None:
        self._orders, self._order, self._signal = orders, order, signal
        self._label, self._detents = label, detents
        self._is_moved = False
        with ui.element("div").classes("op-override"):
            ui.label(f"{label} override").classes("op-label")
            self._value = ui.label("").classes("op-number").props(f"data-testid=override-{order}")
            self._slider = ui.slider(min=detents[0], max=detents[-1], step=1, value=100)
            self._slider.props(
                f'label snap markers="10" aria-label="{label} override in percent" '
                f"data-testid=slider-{order}"
            )
            self._slider.on("pan", self._pan, ["args"])
            self._slider.on("change", self._set)
            orders.guard(self._slider, order)
            with ui.element("div").classes("op-detents"):
                for percent in detents:
                    name, press = f"{order}-{percent}", partial(self._give, percent)
                    button = orders.small_button(f"{percent} %", name, order, press)
                    button.classes("op-detent op-hundred" if percent == 100 else "op-detent")

    def _pan(self, event: GenericEventArguments) -> None:
        self._is_moved = event.args == "start"

    async def _set(self) -> None:
        self._is_moved = False
        value = float(self._slider.value)
        near = min(self._detents, key=lambda detent: abs(detent - value))
        await self._give(near if abs(near - value) <= 2 else round(value))

    async def _give(self, percent: float) -> None:
        words = f"{self._label.lower()} override {percent:.0f} %"
        await self._orders.give(self._order, words, percent=float(percent))

    def show(self, snapshot: Snapshot) -> None:
        """Show what the controller has."""
        percent = snapshot.signals.get(self._signal)
        if percent is None:
            return
        self._value.set_text(f"{percent:.0f} %")
        if not self._is_moved and self._slider.value != round(percent):
            self._slider.set_value(round(percent))


class AdjustCard:
    """What may be changed while a part is cut."""

    def __init__(self, orders: Orders) -> None:
        self._orders = orders
        with card("Adjust the cut", "adjust", is_live=True):
            self._overrides = (
                Override(orders, "Feed", "feed", "override_of_feed", _FEED_DETENTS),
                Override(orders, "Spindle", "spindle", "override_of_spindle", _SPINDLE_DETENTS),
            )
            with ui.element("div").classes("op-row"):
                self._trim = ui.number("Trim of the diameter", value=0.0, step=1.0, suffix="µm")
                self._trim.classes("op-input").props("data-testid=trim")
                orders.small_button("Set trim", "do-trim", "trim", self._set_trim)
                self._trim_now = ui.label("").classes("op-note").props("data-testid=trim-now")
            with ui.element("div").classes("op-row"):
                self._parts = ui.number("Parts cut", value=0, step=1, min=0, precision=0)
                self._parts.classes("op-input").props("data-testid=parts-new")
                orders.small_button("Count from here", "do-parts", "parts", self._set_parts)
                self._parts_now = ui.label("").classes("op-note").props("data-testid=parts-now")

    async def _set_trim(self) -> None:
        um = float(self._trim.value or 0.0)
        words = f"trim of the diameter {um:g} µm"
        await self._orders.give("trim", words, measure="diameter", mm=um / UM_PER_MM)

    async def _set_parts(self) -> None:
        number = int(self._parts.value or 0)
        await self._orders.give("parts", f"parts = {number}", number=number)

    def show(self, snapshot: Snapshot) -> None:
        """Show what the controller has."""
        for override in self._overrides:
            override.show(snapshot)
        s = snapshot.signals
        trim_um = s.get("trim_of_x", 0.0) * UM_PER_MM
        self._trim_now.set_text(
            f"now {2 * trim_um:+.1f} µm on the diameter, {trim_um:+.1f} µm on the radius"
        )
        self._parts_now.set_text(f"now {s.get('parts_cut', 0.0):.0f} parts")
