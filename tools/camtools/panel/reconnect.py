# SPDX-License-Identifier: Apache-2.0
"""What a page gets when its connection returns.

NiceGUI repeats the messages that the lost connection swallowed, but after the updates that have
waited meanwhile, so that an old state of an element replaces a newer one: an open question
vanishes, and a number stays old until it changes again.

>>> from types import SimpleNamespace
>>> outbox = SimpleNamespace(messages=[("page", "update", {7: "old", "_id": 3})], updates={})
>>> repeat_newest(SimpleNamespace(outbox=outbox, elements={7: "new"}))
>>> outbox.updates, outbox.messages
({7: 'new'}, [])
"""

from __future__ import annotations

from nicegui import Client
from nicegui.outbox import deleted


def repeat_newest(client: Client) -> None:
    """Send elements of repeated updates as they are now; to be called as the page connects."""
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
