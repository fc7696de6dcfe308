# SPDX-License-Identifier: Apache-2.0
"""Numbers of spindle, U, X and Z, the angle as a dial, homes and the tool."""

from __future__ import annotations

from nicegui import ui

from camtools.panel.operate.card import Figure, card
from camtools.panel.orders.snapshot import Snapshot
from camtools.panel.views import numbers
from camtools.panel.views.numbers import Field

_BIG = (numbers.SPEED, numbers.FOLLOWING)
_ROWS = (numbers.ANGLE, *numbers.AXES)


class Dial:
    """The drawing's angle before the tool: counter-clockwise from the right, as the drawing has it.

    The needle is turned by its style alone.
    """

    def __init__(self) -> None:
        with ui.element("div").classes("op-dial").props("role=img") as self._dial:
            for name in ("0°", "90°", "180°", "270°"):
                ui.label(name).classes(f"op-dial-mark op-dial-{name[:-1]}")
            self._needle = ui.element("div").classes("op-needle")
        self._dial.props('aria-label="Angle of the drawing before the tool"')

    def show(self, angle_deg: float | None) -> None:
        """Turn the needle; without an angle there is none."""
        if angle_deg is None:
            self._needle.style("visibility: hidden")
        else:
            self._needle.style(f"transform: rotate({-angle_deg:.1f}deg); visibility: visible")


class FiguresCard:
    """What moves, in numbers."""

    def __init__(self) -> None:
        self._figures: list[tuple[Field, Figure]] = []
        with card("Spindle and axes", "figures", is_live=True):
            with ui.element("div").classes("op-big-row"):
                for one in _BIG:
                    self._add(one, "big")
                self._dial = Dial()
            with ui.element("div").classes("op-figures"):
                for one in _ROWS:
                    self._add(one, "middle")
            self._notes = ui.label("").classes("op-notes").props("data-testid=notes")

    def _add(self, one: Field, size: str) -> None:
        self._figures.append((one, Figure(one.label, one.unit, one.key, size=size)))

    def show(self, snapshot: Snapshot) -> None:
        """Show the numbers."""
        s = snapshot.signals
        for one, figure in self._figures:
            figure.show(one.text(s))
        self._dial.show(s.get("angle") if s.get("is_synced") else None)
        tool = f"tool {int(s['tool'])}" if s.get("tool") else "no tool chosen"
        parts = [numbers.homed_text(s), tool, numbers.pass_text(s)]
        self._notes.set_text("; ".join(part for part in parts if part) + ". X at U = 0.")
