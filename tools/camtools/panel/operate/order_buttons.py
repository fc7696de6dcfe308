"""How a page gives orders: buttons that state why they are off; the last order and its outcome."""

from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field

from nicegui import ui
from nicegui.elements.mixins.disableable_element import DisableableElement

from camtools.panel.context import AppContext
from camtools.panel.orders.commander import Visitor
from camtools.panel.orders.order import Order, Outcome
from camtools.panel.orders.snapshot import Snapshot
from camtools.panel.pieces import outlined
from camtools.panel.views.availability import why_not
from camtools.panel.views.wording import held_text

Press = Callable[[], Awaitable[object]]
Why = Callable[[], str]


@dataclass
class _Guarded:
    """A control that is on while its order makes sense."""

    control: DisableableElement
    reason: ui.label | None
    order: str
    own_why: Why
    why: str | None = None

    def show(self, of_all: str, own: str) -> None:
        """Switch the control, and show why it is off: for a reason of all, or for its own."""
        why = of_all or own
        if self.reason is not None:
            self.reason.set_text("" if of_all else own)
        if self.why == why:
            return
        self.why = why
        self.control.props(f'title="{why}"' if why else "", remove="" if why else "title")
        self.control.set_enabled(not why)


@dataclass
class Orders:
    """The orders of one page."""

    context: AppContext
    visitor: Visitor
    _guarded: list[_Guarded] = field(default_factory=list)
    _last: ui.label | None = None
    _of_all: ui.label | None = None

    @property
    def why_no_rights(self) -> str:
        """Why this visitor may give no orders now; "" when he may."""
        is_commander = self.context.commander.holder is self.visitor
        return "" if is_commander else "take the command, top right"

    async def give(self, name: str, words: str = "", /, **arguments: object) -> Outcome:
        """Give an order, and show what came of it."""
        words = words or name.replace("_", " ")
        self._tell(f"{words} ..", "busy")
        outcome = await self.context.service.do(Order(name, arguments), self.visitor)
        self.tell(words, outcome)
        return outcome

    def tell(self, words: str, outcome: Outcome) -> None:
        """Show what came of an order."""
        mark = "done" if outcome.is_done else "not done"
        self._tell(f"{words}: {mark} - {outcome.text}", "done" if outcome.is_done else "refused")

    def refuse(self, words: str, why: str) -> None:
        """Show why an order was not even given."""
        self.tell(words, Outcome(False, why))

    def _tell(self, text: str, tone: str) -> None:
        if self._last is not None:
            self._last.set_text(text)
            self._last.classes(replace=f"op-last op-last-{tone}")

    def why_all_are_off(self) -> None:
        """Draw the line that shows why this visitor may give no orders."""
        self._of_all = ui.label("").classes("op-rights").props("role=status data-testid=rights")

    def last_order(self) -> None:
        """Draw the line that shows the last order and its outcome."""
        self._last = ui.label("No order yet.").classes("op-last")
        self._last.props("role=status aria-live=polite data-testid=last-order").mark("last-order")

    def guard(
        self,
        control: DisableableElement,
        order: str,
        reason: ui.label | None = None,
        own_why: Why = lambda: "",
    ) -> None:
        """Keep a control switched off while its order makes no sense or the right is missing.

        `own_why` returns a reason that the status does not show; "": it is on.
        """
        self._guarded.append(_Guarded(control, reason, order, own_why))

    def button(
        self, label: str, order: str, icon: str, press: Press, *, key: str, tone: str
    ) -> None:
        """Draw a large button with its key; the reason is below where it is off."""
        with ui.element("div").classes("op-cell"):
            large = ui.button(label, icon=icon, on_click=press, color=None)
            large.classes(f"op-button {tone}")
            large.props(f'no-caps unelevated data-testid="do-{order}"').mark(f"do-{order}")
            if key:
                with large:
                    ui.label(key).classes("op-key").props("aria-hidden=true")
            reason = ui.label("").classes("op-why")
        self.guard(large, order, reason)

    def small_button(
        self, label: str, name: str, order: str, press: Press, own_why: Why = lambda: ""
    ) -> ui.button:
        """Draw a button of a row; `name` is its mark, `order` that by which it is guarded."""
        small = outlined(label, name, press)
        self.guard(small, order, own_why=own_why)
        return small

    def show(self, snapshot: Snapshot) -> None:
        """Switch all guarded controls by what is so now.

        A reason that holds for all of them is shown once, not below every button.
        """
        lost = "" if snapshot.is_connected else "no connection to the controller"
        of_all = lost or self.why_no_rights or held_text(snapshot)
        if self._of_all is not None:
            self._of_all.set_text(f"Orders are off: {of_all}." if of_all else "")
        for guarded in self._guarded:
            why = why_not(guarded.order, snapshot.state, snapshot.signals)
            guarded.show(of_all, why or guarded.own_why())
