"""The frame of every page: navigation, who commands, STOP, theme, visitor, the connection.

The operator's page has a larger STOP beside the state. Escape does the same (static/panel.js) for
who commands, since he may look at any page when something goes wrong. For others it does not: who
closes a menu while he draws a part must not end somebody else's cut.

Classes of elements are those of Quasar and of static/panel.css; Tailwind is off, since it watches
every change of the page in the browser. What a page adds is a file in static/, by a relative
address, since the address of a page begins with the token. All text of strangers goes through
ui.label or props, never through ui.html or ui.markdown.
"""

import asyncio
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from fastapi.dependencies import models
from nicegui import Client, events, ui
from nicegui.outbox import deleted

from camtools.link.rights import sender_text
from camtools.link.status_text import IN_CUT
from camtools.panel.context import AppContext
from camtools.panel.orders.commander import Commander, Visitor, new_visitor
from camtools.panel.orders.order import Order
from camtools.panel.pieces import ask_again, confirmed, withdraw
from camtools.panel.views.availability import stop_order
from camtools.panel.views.wording import other_sender


def forget_routes() -> None:
    """Forget functions of routes, so that pages which are gone can be freed.

    Each ui.upload has a route of its own, whose function FastAPI remembers, and with it its page:
    0.7 MB for each operator's page. Nothing but speed is lost.
    """
    for cached in vars(models).values():
        clear = getattr(cached, "cache_clear", None)
        if callable(clear):
            clear()


def repeat_newest(client: Client) -> None:
    """Send elements of repeated updates as they are now; to be called as the page connects.

    NiceGUI repeats what the lost connection swallowed after the updates that have waited meanwhile:
    an old state would replace a newer one, and an open question vanish.
    """
    outbox = client.outbox
    repeated = list(outbox.messages)
    outbox.messages.clear()
    for target, kind, data in repeated:
        if kind == "load_js_components":
            outbox._loaded_components.clear()  # they go with the updates
        elif kind != "update":
            outbox.messages.append((target, kind, data))
        else:
            for i in set(data) - {"_id"}:
                outbox.updates[i] = client.elements.get(i, deleted)


class FrameStop:
    """The machine's state and its STOP."""

    def __init__(self, context: AppContext, visitor: Visitor) -> None:
        self._context, self._visitor = context, visitor
        self._machine = ui.label().props("data-testid=machine")
        self._button = ui.button("STOP", on_click=self.stop, color=None).classes("panel-stop")
        self._button.props('no-caps unelevated aria-label="STOP: stops all motion"')
        self._button.props("data-testid=stop")
        ui.on("stop", self._stop_by_key)

    async def _stop_by_key(self) -> None:
        if self._context.commander.holder is self._visitor:
            await self.stop()

    async def stop(self) -> None:
        """Stop all motion without a question, and show the outcome."""
        withdraw(self._button.client)
        order = stop_order(self._context.service.snapshot().state)
        outcome = await self._context.service.do(Order(order, {}), self._visitor)
        with self._button:
            words = f"STOP of the machine: {outcome.text}"
            ui.notify(words, type="positive" if outcome.is_done else "negative")

    def show(self) -> None:
        """Show what the machine does now."""
        snapshot = self._context.service.snapshot()
        state = snapshot.state if snapshot.is_connected else "no connection"
        self._machine.text = f"machine: {state}"


OPERATE = "/"
PAGES = {OPERATE: "Operate", "/design": "Design", "/runs": "Runs"}
STATIC, STATIC_FOLDER = "panel", Path(__file__).parent / "static"
_PRIMARY = "#1a5a96"  # white on it has a contrast of 7, where 4.5 is needed (WCAG 2.2, 1.4.3)
_POSITIVE = "#1b7a37"  # 5.4
_HEAD = f'<link rel="stylesheet" href="{STATIC}/panel.css">'
_BODY = f'<script src="{STATIC}/panel.js"></script>'
_SHOW_S = 0.25
_COMMAND_S = 10.0  # for which the page of the commander may be away
_ENDS = "Then nobody has command, and the cut ends as with STOP."
_visitors: dict[str, Visitor] = {}  # by the identifier of their page, while it is there


def _admit(context: AppContext, client: Client) -> Visitor:
    """Return the visitor of a page, who is known until the page goes."""
    visitor = new_visitor()
    _visitors[client.id] = visitor

    def on_connect() -> None:
        context.service.page_connected(visitor)
        repeat_newest(client)
        client.run_javascript("panelHello()")

    def on_disconnect() -> None:
        if not client.has_socket_connection:  # a new one may stand before the old one is given up
            context.service.page_lost(visitor)
            loop = asyncio.get_running_loop()
            loop.call_later(_COMMAND_S, lose_if_away, visitor.n_losses)

    def lose_if_away(n_losses: int) -> None:
        if not visitor.is_here and visitor.n_losses == n_losses:
            context.commander.lose(visitor, f"the page was away for {_COMMAND_S:.0f} s")

    def on_delete() -> None:
        _visitors.pop(client.id, None)
        context.service.page_lost(visitor)
        context.commander.lose(visitor)
        forget_routes()

    client.on_connect(on_connect)
    client.on_disconnect(on_disconnect)
    client.on_delete(on_delete)
    return visitor


@contextmanager
def framed(context: AppContext, path: str) -> Iterator[Visitor]:
    """Make the frame of a page, of whose visitor what is made within the block may give orders."""
    visitor = _admit(context, ui.context.client)
    ui.colors(primary=_PRIMARY, positive=_POSITIVE)
    ui.add_head_html(_HEAD)
    ui.add_body_html(_BODY)
    with ui.header().classes("row items-center q-gutter-md"):
        for target, name in PAGES.items():
            ui.link(name, target).classes("text-white" + (" text-bold" if target == path else ""))
        ui.space()
        _CommandBar(context, visitor)
        if path != OPERATE:  # that page has a larger one, beside the state
            stop = FrameStop(context, visitor)
            ui.timer(_SHOW_S, stop.show)
        _theme_button()
    with ui.column().classes("full-width q-pa-md"):
        yield visitor


def _theme_button() -> None:
    """Draw a button that goes from the system's colours to dark, light and back."""
    mode, order = ui.dark_mode(None), {None: True, True: False, False: None}
    names = {None: "as the system", True: "dark", False: "light"}

    def press() -> None:
        mode.set_value(order[mode.value])
        button.props(f'aria-label="Colours: {names[mode.value]}"')

    button = ui.button(icon="contrast", on_click=press).props("flat color=white data-testid=theme")
    button.props(f'aria-label="Colours: {names[None]}"')


class _CommandBar:
    """Who commands, and how to: take, take over, give back."""

    def __init__(self, context: AppContext, visitor: Visitor) -> None:
        self._context, self._visitor = context, visitor
        self._who = ui.label().props('role="status"').mark("commander")
        self._take = ui.button("Take command", on_click=self._on_take).props("color=white outline")
        self._news = ""
        ui.on("panel_hello", self._on_hello)
        ui.timer(_SHOW_S, self.show)
        self.show()

    def show(self) -> None:
        """Bring the bar up to date."""
        commander, visitor = self._context.commander, self._visitor
        holder, sender = commander.holder, other_sender(self._context.service.snapshot())
        self._who.text = _who(commander, visitor, sender)
        is_free = holder is None and not sender
        is_mine = holder is visitor and not sender
        mine = "Give command back" if is_mine else "Take over"
        self._take.text = "Take command" if is_free else mine
        news = commander.news(visitor)
        if news and news != self._news:
            ui.notify(news, type="warning", timeout=0, close_button="Close")
        self._news = news

    async def _on_hello(self, event: events.GenericEventArguments) -> None:
        """Take the clock of a page that has connected, and what it continues."""
        hello = event.args if isinstance(event.args, dict) else {}
        sent_ms = hello.get("sent_ms")
        if isinstance(sent_ms, int | float):
            self._context.service.page_clock(self._visitor, float(sent_ms))
        before = _visitors.get(str(hello.get("before")))
        if before is not None and before is not self._visitor:
            self._context.commander.pass_on(before, self._visitor)
            self.show()
            await ask_again(event.client, str(hello.get("asks")))

    async def _on_take(self) -> None:
        commander, visitor, service = self._context.commander, self._visitor, self._context.service
        newest = service.snapshot()
        holder, sender = commander.holder, other_sender(newest)
        if holder is visitor and not sender:
            if newest.state in IN_CUT and not await confirmed("Give back?", _ENDS, "Give back"):
                return
            outcome = commander.release(visitor)
        elif holder is None and not sender:
            outcome = commander.take(visitor)
        elif await confirmed("Take the command over?", _warning(holder, sender), "Take over"):
            outcome = await service.take_over(visitor)
        else:
            return
        ui.notify(outcome.text, type="positive" if outcome.is_done else "negative")
        self.show()


def _warning(holder: Visitor | None, sender: int) -> str:
    who = sender_text(sender) if sender else str(holder)
    return f"{who} has command now and will be notified. Running motion continues."


def _who(commander: Commander, visitor: Visitor, sender: int) -> str:
    if sender:
        return f"{sender_text(sender)} commands the controller"
    holder = commander.holder
    return "you command" if holder is visitor else f"{holder or 'nobody'} commands"
