# SPDX-License-Identifier: Apache-2.0
"""The token that lets a visitor command: random at each start, compared in constant time.

>>> from camtools.panel.access.visitor import Visitor
>>> guard = TokenGuard("right")
>>> visitor = Visitor("v1", "127.0.0.1")
>>> guard.shown(visitor, "wrong"), visitor.has_token
('the token is wrong', False)
>>> guard.shown(visitor, "right"), visitor.has_token
('', True)
"""

from __future__ import annotations

import hmac
import secrets
import time
from collections import OrderedDict, deque
from collections.abc import Callable

from camtools.panel.access.visitor import Visitor

TOKEN_BYTES = 24
LEAST_CHARS, MOST_CHARS = 16, 200
MOST_TRIES, TRIES_S = 10, 60.0
_MOST_ADDRESSES = 1000


def new_token() -> str:
    """Return a random token that fits into a URL."""
    return secrets.token_urlsafe(TOKEN_BYTES)


class TokenGuard:
    """Compares what visitors show.

    After `MOST_TRIES` wrong ones within `TRIES_S` an address is not heard, not even with the right
    one, until the oldest of them is that old.
    """

    def __init__(self, token: str, clock: Callable[[], float] = time.monotonic) -> None:
        self._token, self._clock = token.encode(), clock
        self._wrong_s: OrderedDict[str, deque[float]] = OrderedDict()

    def shown(self, visitor: Visitor, text: object) -> str:
        """Let a visitor in who shows the token; return why not, "" when it is right."""
        now_s = self._clock()
        wrong_s = self._wrong_s.setdefault(visitor.address, deque(maxlen=MOST_TRIES))
        self._wrong_s.move_to_end(visitor.address)
        while len(self._wrong_s) > _MOST_ADDRESSES:
            self._wrong_s.popitem(last=False)
        if len(wrong_s) == MOST_TRIES and now_s - wrong_s[0] < TRIES_S:
            return "too many wrong tokens; wait a minute"
        is_text = isinstance(text, str) and len(text) <= MOST_CHARS
        shown = str(text).strip().encode("utf-8", "replace") if is_text else b""
        if not hmac.compare_digest(shown, self._token):
            wrong_s.append(now_s)
            return "the token is wrong"
        visitor.has_token = True
        return ""
