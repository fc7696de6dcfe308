"""A report read as a browser reads it: its elements, and the numbers that it holds."""

import json
from base64 import b64decode
from html.parser import HTMLParser
from typing import Any, NamedTuple

import numpy as np

from camtools.base.quantities import Floats

_EMPTY = {"meta", "img", "input", "br", "hr", "link"}


class Element(NamedTuple):
    """An element of a page."""

    tag: str
    attributes: dict[str, str]
    text: list[str]  # of the element itself, not of those in it


class PageReader(HTMLParser):
    """Collects the elements of a page and complains of those that are not closed."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[Element] = []
        self._open: list[Element] = []
        self.feed(text)
        self.close()
        assert not self._open, [one.tag for one in self._open]

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """See HTMLParser."""
        element = Element(tag, {name: value or "" for name, value in attrs}, [])
        self.elements.append(element)
        if tag not in _EMPTY:
            self._open.append(element)

    def handle_endtag(self, tag: str) -> None:
        """See HTMLParser."""
        assert self._open and self._open[-1].tag == tag, tag
        self._open.pop()

    def handle_data(self, data: str) -> None:
        """See HTMLParser."""
        if self._open:
            self._open[-1].text.append(data)

    def all(self, tag: str) -> list[Element]:
        """Return the elements of a tag, in their order."""
        return [one for one in self.elements if one.tag == tag]

    def by_id(self, name: str) -> Element:
        """Return the one element with an id."""
        [found] = [one for one in self.elements if one.attributes.get("id") == name]
        return found

    def data(self, name: str) -> Any:  # noqa: ANN401
        """Return what a script element of JSON holds."""
        return json.loads("".join(self.by_id(name).text))


class Held(NamedTuple):
    """The map that a page holds, each of shape (rows, columns); NaN where nothing was cut."""

    error_um: Floats
    radius_mm: Floats
    turn: Floats


def map_of(part: dict[str, Any]) -> Held:
    """Return the map of a page's data."""
    shape = part["rows"], part["columns"]

    def numbers(name: str, kind: str) -> Floats:
        return np.frombuffer(b64decode(part[name]), kind).reshape(shape).astype(np.float64)

    steps = numbers("error", "<i2")
    error_um = np.where(steps == -32768, np.nan, steps * part["error_step_um"])
    turn = (np.arange(shape[1]) + numbers("turn", "<u2") / 65536) / shape[1]
    return Held(error_um, numbers("radius", "<f4"), turn)
