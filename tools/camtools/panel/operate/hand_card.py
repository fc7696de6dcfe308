"""Axes by hand: jog while a button is held, steps, homes, zero, tool.

A held button is watched by jog.js in the browser, which tells begin, hold ten times a second, and
end; the service lets a press die that was silent, whatever comes late.
"""

from functools import partial

from nicegui import ui
from nicegui.events import GenericEventArguments

from camtools.panel.operate.order_buttons import Orders
from camtools.panel.orders.order import Order
from camtools.panel.pieces import card

_JOG = ("jog_begin", "jog_hold", "jog_end")
_AXES = {"u": ("in", "out"), "x": ("out", "in"), "z": ("up", "down")}
_SIGNS = {"+": ("plus", 1), "-": ("minus", -1)}
_SPEEDS_MM_S = {0.1: "0.1", 0.5: "0.5", 1.0: "1", 2.0: "2", 5.0: "5", 10.0: "10"}
_STEPS_MM = {0.001: "0.001", 0.01: "0.01", 0.1: "0.1", 1.0: "1", 10.0: "10"}
_TOOLS = {0: "none", 1: "1", 2: "2", 3: "3", 4: "4"}
_PLACES = {
    "x": ("diameter", "The tip touches diameter"),
    "z": ("height", "The tip is at height"),
}


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
            self._places = {axis: self._draw_place(axis) for axis in _PLACES}
            with ui.element("div").classes("op-row"):
                self._tool = ui.select(_TOOLS, value=0, label="Tool")
                self._tool.classes("op-input").props("data-testid=tool-number")
                orders.small_button("Use tool", "do-tool", "tool", self._use_tool)
            ui.label(
                "Hold a jog button with the pointer, or with the space bar while it has the focus; "
                "the axis stops when you release it or leave the button or the page."
            ).classes("op-notes")
        ui.on("jog", self._jog)

    def _draw_axis(self, axis: str, senses: tuple[str, str]) -> None:
        name, orders = axis.upper(), self._orders
        with ui.element("div").classes("op-axis").props(f'role=group aria-label="Axis {name}"'):
            ui.label(name).classes("op-axis-name")
            for (sign, (word, _)), sense in zip(_SIGNS.items(), senses, strict=True):
                jog = ui.button(f"{name} {sign}", color=None).classes("op-jog")
                label = f"Jog {name} {sign}, {sense}: hold the button"
                jog.props(f'no-caps unelevated data-jog="{axis}{sign}" aria-label="{label}"')
                orders.guard(jog.props(f"data-testid=jog-{axis}{word}"), "jog")
            for sign, (word, sense_of_1) in _SIGNS.items():
                press = partial(self._give_step, axis, sense_of_1)
                step = orders.small_button(f"step {sign}", f"step-{axis}{word}", "step", press)
                step.props(f'aria-label="Step {name} {sign}"')
            home = partial(orders.give, "home", f"home {name}", axis=axis)
            orders.small_button(f"Home {name}", f"home-{axis}", "home_axis", home)

    def _draw_place(self, axis: str) -> ui.number:
        with ui.element("div").classes("op-row"):
            place = ui.number(_PLACES[axis][1], suffix="mm", step=0.001)
            place.classes("op-input").props(f"data-testid=zero-{axis}-value")
            press = partial(self._zero, axis)
            self._orders.small_button(f"Zero {axis.upper()}", f"zero-{axis}", "zero", press)
        return place

    async def _jog(self, event: GenericEventArguments) -> None:
        """Hand an event of jog.js on; only what is new is shown, a hold is not."""
        message = event.args if isinstance(event.args, dict) else {}
        name, where = f"jog_{message.get('phase')}", str(message.get("where", ""))
        sent_ms = message.get("sent_ms", 0.0)
        if name not in _JOG or not isinstance(message.get("press"), int):
            return
        if not isinstance(sent_ms, int | float):
            return
        press = {"press": message["press"]}
        sent = {"sent_ms": float(sent_ms)} if name != "jog_end" else {}
        if name != "jog_begin":
            await self._orders.context.service.do(Order(name, press | sent), self._orders.visitor)
            return
        if where[:1] not in _AXES or where[1:] not in _SIGNS:
            return
        speed = float(self._speed.value or 1.0)
        await self._orders.give(
            name,
            f"jog {where[0].upper()} {where[1]} at {speed:g} mm/s",
            axis=where[0],
            mm_per_s=_SIGNS[where[1]][1] * speed,
            **press,
            **sent,
        )

    async def _give_step(self, axis: str, sense: int) -> None:
        mm = sense * float(self._step.value or 0.01)
        await self._orders.give("step", f"step {axis.upper()} {mm:+g} mm", axis=axis, mm=mm)

    async def _zero(self, axis: str) -> None:
        value = self._places[axis].value
        if value is None:
            self._orders.refuse(f"zero {axis.upper()}", "give the value first")
            return
        words = f"zero {axis.upper()}: {_PLACES[axis][0]} {value:g} mm"
        await self._orders.give("zero", words, axis=axis, mm=float(value))

    async def _use_tool(self) -> None:
        number = int(self._tool.value or 0)
        await self._orders.give("tool", f"tool {number or 'none'}", number=number)
