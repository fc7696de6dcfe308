"""Axes by hand: jog while a button is held, steps, homes, zero, tool.

A held button is watched by jog.js in the browser, which tells begin, hold ten times a second, and
end; the service lets a press die that was silent, whatever comes late.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable

from nicegui import ui
from nicegui.events import GenericEventArguments

from camtools.panel.operate.order_buttons import Orders
from camtools.panel.orders.order import Order
from camtools.panel.orders.snapshot import Snapshot
from camtools.panel.pieces import card

_JOG = ("jog_begin", "jog_hold", "jog_end")
_AXES = {"u": ("in", "out"), "x": ("out", "in"), "z": ("up", "down")}
_SPEEDS_MM_S = {0.1: "0.1", 0.5: "0.5", 1.0: "1", 2.0: "2", 5.0: "5", 10.0: "10"}
_STEPS_MM = {0.001: "0.001", 0.01: "0.01", 0.1: "0.1", 1.0: "1", 10.0: "10"}
_TOOLS = {0: "none", 1: "1", 2: "2", 3: "3", 4: "4"}


class HandCard:
    """What moves axes without the spindle."""

    def __init__(self, orders: Orders) -> None:
        self._orders = orders
        with card("By hand", "hand"):
            with ui.element("div").classes("op-row"):
                self._speed = ui.select(_SPEEDS_MM_S, value=1.0, label="Jog speed, mm/s")
                self._speed.classes("op-input").props("data-testid=jog-speed")
                self._step = ui.select(_STEPS_MM, value=0.01, label="Step, mm")
                self._step.classes("op-input").props("data-testid=step-size")
            for axis, senses in _AXES.items():
                self._draw_axis(axis, senses)
            self._draw_places()
            ui.label(
                "Hold a jog button with the pointer, or with the space bar while it has the focus; "
                "the axis stops when you release it or leave the button or the page."
            ).classes("op-notes")
        ui.on("jog", self._jog)

    def _draw_axis(self, axis: str, senses: tuple[str, str]) -> None:
        name = axis.upper()
        with ui.element("div").classes("op-axis").props(f'role=group aria-label="Axis {name}"'):
            ui.label(name).classes("op-axis-name")
            for sign, sense in (("+", senses[0]), ("-", senses[1])):
                one = ui.button(f"{name} {sign}", color=None).classes("op-jog")
                said = f"Jog {name} {sign}, {sense}: hold the button"
                one.props(f'no-caps unelevated data-jog="{axis}{sign}" aria-label="{said}"')
                one.props(f"data-testid=jog-{axis}{'plus' if sign == '+' else 'minus'}")
                self._orders.guard(one, "jog")
            for sign in ("+", "-"):
                one = ui.button(f"step {sign}", on_click=self._stepped(axis, sign))
                one.props(f'no-caps outline aria-label="Step {name} {sign}"')
                one.props(f"data-testid=step-{axis}{'plus' if sign == '+' else 'minus'}")
                self._orders.guard(one, "step")
            one = ui.button(f"Home {name}", on_click=self._homed(axis))
            one.props(f"no-caps outline data-testid=home-{axis}")
            self._orders.guard(one, "home_axis")

    def _draw_places(self) -> None:
        with ui.element("div").classes("op-row"):
            self._diameter = ui.number("The tip touches diameter", suffix="mm", step=0.001)
            self._diameter.classes("op-input").props("data-testid=zero-x-value")
            one = ui.button("Zero X", on_click=lambda: self._zero("x", self._diameter.value))
            self._orders.guard(one.props("no-caps outline data-testid=zero-x"), "zero")
        with ui.element("div").classes("op-row"):
            self._height = ui.number("The tip is at height", suffix="mm", step=0.001)
            self._height.classes("op-input").props("data-testid=zero-z-value")
            one = ui.button("Zero Z", on_click=lambda: self._zero("z", self._height.value))
            self._orders.guard(one.props("no-caps outline data-testid=zero-z"), "zero")
        with ui.element("div").classes("op-row"):
            self._tool = ui.select(_TOOLS, value=0, label="Tool")
            self._tool.classes("op-input").props("data-testid=tool-number")
            one = ui.button("Use tool", on_click=self._use_tool)
            self._orders.guard(one.props("no-caps outline data-testid=do-tool"), "tool")

    async def _jog(self, event: GenericEventArguments) -> None:
        """Hand an event of jog.js on; only what is new is shown, a hold is not."""
        told = event.args if isinstance(event.args, dict) else {}
        name, where = f"jog_{told.get('phase')}", str(told.get("where", ""))
        sent_ms = told.get("sent_ms", 0.0)
        if name not in _JOG or not isinstance(told.get("press"), int):
            return
        if not isinstance(sent_ms, int | float):
            return
        press = {"press": told["press"]}
        sent = {"sent_ms": float(sent_ms)} if name != "jog_end" else {}
        if name != "jog_begin":
            await self._orders.context.service.do(Order(name, press | sent), self._orders.visitor)
            return
        if where[:1] not in _AXES or where[1:] not in ("+", "-"):
            return
        speed = float(self._speed.value or 1.0)
        await self._orders.give(
            name,
            f"jog {where[0].upper()} {where[1]} at {speed:g} mm/s",
            axis=where[0],
            mm_per_s=-speed if where[1] == "-" else speed,
            **press,
            **sent,
        )

    def _stepped(self, axis: str, sign: str) -> Callable[[], Awaitable[None]]:
        async def press() -> None:
            mm = float(self._step.value or 0.01) * (-1 if sign == "-" else 1)
            await self._orders.give("step", f"step {axis.upper()} {mm:+g} mm", axis=axis, mm=mm)

        return press

    def _homed(self, axis: str) -> Callable[[], Awaitable[None]]:
        async def press() -> None:
            await self._orders.give("home", f"home {axis.upper()}", axis=axis)

        return press

    async def _zero(self, axis: str, value: float | None) -> None:
        if value is None:
            self._orders.refuse(f"zero {axis.upper()}", "give the value first")
            return
        what = "diameter" if axis == "x" else "height"
        words = f"zero {axis.upper()}: {what} {value:g} mm"
        await self._orders.give("zero", words, axis=axis, mm=float(value))

    async def _use_tool(self) -> None:
        number = int(self._tool.value or 0)
        await self._orders.give("tool", f"tool {number or 'none'}", number=number)

    def show(self, snapshot: Snapshot) -> None:
        """Nothing here follows the status by itself: the buttons are guarded."""
