"""The operator's page, "/", and its keys."""

from contextlib import suppress

from nicegui import ui
from nicegui.events import GenericEventArguments, KeyEventArguments

from camtools.panel.context import AppContext
from camtools.panel.operate.command_card import AdjustCard, CommandCard
from camtools.panel.operate.hand_card import HandCard
from camtools.panel.operate.order_buttons import Orders
from camtools.panel.operate.params_card import ForceDriveCard, ParamsCard
from camtools.panel.operate.status_cards import (
    FiguresCard,
    GuideCard,
    LearningCard,
    LogCard,
    ProgressCard,
    StateBar,
)
from camtools.panel.operate.table_card import TableCard
from camtools.panel.orders.commander import Visitor
from camtools.panel.page_frame import STATIC, framed
from camtools.panel.pieces import titled_dialog
from camtools.panel.views.availability import next_steps

KEYS = {
    "Esc": "STOP: stops all motion, anywhere on the page",
    "E": "Enable: switches the drives on and finds the index",
    "S": "Start, after a confirmation",
    "H": "Hold: pauses Z after a whole turn",
    "R": "Resume",
    "D": "Disable: switches the drives off",
    "T": "Reset after a fault",
    "M": "By hand",
    "Space": "on a jog button: the axis moves while the key is held",
    "?": "this list",
}


class Help:
    """A dialog; STOP works while it is open."""

    def __init__(self) -> None:
        with titled_dialog("Keys", "help") as self._dialog:
            with ui.element("dl").classes("op-keys"):
                for key, meaning in KEYS.items():
                    with ui.element("dt"):
                        ui.label(key).classes("op-key-name")
                    with ui.element("dd"):
                        ui.label(meaning)
            self.are_keys_on = ui.switch("Letter keys give orders", value=True)
            self.are_keys_on.props("data-testid=keys-on")
            ui.label(
                "STOP is not the emergency stop, the red button at the machine that works without "
                "this page."
            )
            close = ui.button("Close", on_click=self._dialog.close)
            close.props("no-caps outline autofocus data-testid=help-close")

    def toggle(self) -> None:
        """Open the dialog, or close it."""
        self._dialog.set_value(not self._dialog.value)


_LOST = "The server of the panel does not answer: all values here are old."
FAST_S, SLOW_S = 0.08, 0.5  # between two updates of numbers, and of the rest
UNSEEN_S = 2.0  # of a page whose tab is hidden
_TAKEN_S = 5.0  # longest wait for a page to confirm an update


class OperatePage:
    """All pieces of one visitor's page, and the timers that show the newest snapshot in them."""

    def __init__(self, context: AppContext, visitor: Visitor) -> None:
        self._context = context
        self._is_seen = True
        self._beat = False
        with ui.element("div").classes("op-page op-beat-a") as self._page:
            ui.label(_LOST).classes("op-lost").props("aria-hidden=true")
            self._orders = Orders(context, visitor)
            self._state = StateBar(self._orders)
            self._draw_first()
            self._draw_second()
            self._help = Help()
            self._commands.on_keys = self._help.toggle
        self._listen()
        self._fast = ui.timer(FAST_S, self._show_fast)
        self._slow = ui.timer(SLOW_S, self._show_slow)

    def _draw_first(self) -> None:
        """Draw what is looked at while a part is cut; on a screen of 1920 x 1080 all in sight."""
        with ui.element("div").classes("op-columns"):
            with ui.element("div").classes("op-column"):
                self._guide = GuideCard()
                self._commands = CommandCard(self._orders)
            with ui.element("div").classes("op-column"):
                self._figures = FiguresCard()
                self._progress = ProgressCard()
            with ui.element("div").classes("op-column"):
                self._adjust = AdjustCard(self._orders)
                self._learning = LearningCard()

    def _draw_second(self) -> None:
        with ui.element("div").classes("op-columns op-below"):
            with ui.element("div").classes("op-column"):
                HandCard(self._orders)
            with ui.element("div").classes("op-column"):
                self._table = TableCard(self._orders)
            with ui.element("div").classes("op-column"):
                self._log = LogCard(self._context.log)
        with ui.element("div").classes("op-below op-column"):
            self._drive = ForceDriveCard(self._orders)
            self._params = ParamsCard(self._orders)

    def _listen(self) -> None:
        # Escape counts everywhere (panel.js), letters not while somebody types.
        ui.on("stop", self._state.stop)
        ui.keyboard(self._key, ignore=["input", "select", "textarea"], repeating=False)
        ui.on("seen", self._seen)

    async def _key(self, event: KeyEventArguments) -> None:
        is_plain = not (event.modifiers.ctrl or event.modifiers.alt or event.modifiers.meta)
        if not event.action.keydown or not is_plain:
            return
        if event.key == "?":
            self._help.toggle()
        elif self._help.are_keys_on.value:
            await self._commands.by_key(str(event.key))

    def _seen(self, event: GenericEventArguments) -> None:
        """Update a hidden tab rarely."""
        self._is_seen = not isinstance(event.args, dict) or event.args.get("is_seen") is not False
        self._fast.interval = FAST_S if self._is_seen else UNSEEN_S

    async def _show_fast(self) -> None:
        """Show the newest values and wait for the page to confirm.

        A slow browser gets fewer updates instead of a growing queue of old ones.
        """
        snapshot = self._context.service.snapshot()
        read = self._context.service.parameters()
        values = read.values if read is not None else {}
        steps = next_steps(
            snapshot.state, snapshot.signals, values, is_connected=snapshot.is_connected
        )
        self._state.show(snapshot, steps)
        self._guide.show(snapshot, steps)
        self._orders.show(snapshot)
        if not self._is_seen:
            return
        self._figures.show(snapshot)
        self._progress.show(snapshot)
        with suppress(TimeoutError):
            await ui.run_javascript("0", timeout=_TAKEN_S)

    def _show_slow(self) -> None:
        snapshot = self._context.service.snapshot()
        # A page that gets no beat turns grey by its style sheet (operate.css).
        self._beat = not self._beat
        lost = "" if snapshot.is_connected else " op-silent"
        self._page.classes(replace=f"op-page op-beat-{'a' if self._beat else 'b'}{lost}")
        self._adjust.show(snapshot)
        self._table.show(snapshot)
        self._learning.show(snapshot, self._context.service.lessons())
        read = self._context.service.parameters()
        self._drive.show(snapshot, read)
        self._params.show(snapshot.signals, read)
        self._log.show()


def add(context: AppContext) -> None:
    """Register the page."""

    @ui.page("/", title="camturn: operate")
    def operate() -> None:
        ui.add_head_html(f'<link rel="stylesheet" href="{STATIC}/operate.css">')
        ui.add_body_html(f'<script defer src="{STATIC}/jog.js"></script>')
        with framed(context, "/") as visitor:
            OperatePage(context, visitor)
