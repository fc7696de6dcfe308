# SPDX-License-Identifier: Apache-2.0
"""The token that lets a visitor command: random at each start, compared in constant time.

>>> from camtools.panel.visitor import Visitor
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
from collections import deque

from camtools.panel.visitor import Visitor

TOKEN_BYTES = 24
MOST_TRIES, TRIES_S = 10, 60.0
_MOST_CHARS = 200


def new_token() -> str:
    """Return a random token that fits into a URL."""
    return secrets.token_urlsafe(TOKEN_BYTES)


class TokenGuard:
    """Compares what visitors show; after `MOST_TRIES` wrong ones in a minute nobody is heard.

    Parameters
    ----------
    token : str
        the right one
    """

    def __init__(self, token: str) -> None:
        self._token = token.encode()
        self._wrong_s: deque[float] = deque(maxlen=MOST_TRIES)

    def shown(self, visitor: Visitor, text: object) -> str:
        """Let a visitor in who shows the token; return why not, "" when it is right."""
        now_s = time.monotonic()
        if len(self._wrong_s) == MOST_TRIES and now_s - self._wrong_s[0] < TRIES_S:
            return "too many wrong tokens; wait a minute"
        is_text = isinstance(text, str) and len(text) <= _MOST_CHARS
        if not hmac.compare_digest(str(text).strip().encode() if is_text else b"", self._token):
            self._wrong_s.append(now_s)
            return "the token is wrong"
        visitor.has_token = True
        return ""
