# SPDX-License-Identifier: Apache-2.0
"""The text that somebody works on, with its way back: undo and redo.

>>> draft = Draft("a")
>>> draft.change("ab", at_s=0.0); draft.change("abc", at_s=0.1); draft.change("x", at_s=5.0)
>>> draft.undo(), draft.undo(), draft.redo()
('abc', 'a', 'abc')
"""

from __future__ import annotations

_TOGETHER_S = 0.8  # what is typed without a rest is undone together
_MOST_STEPS = 200


class Draft:
    """A text with its history."""

    def __init__(self, text: str) -> None:
        self.text = text
        self._before: list[str] = []
        self._behind: list[str] = []
        self._changed_s = -1e9

    def change(self, text: str, at_s: float, *, is_step: bool = False) -> None:
        """Take a changed text.

        Parameters
        ----------
        at_s : float
            When, on a clock that does not jump [s].
        is_step : bool
            It is a step of its own, however quickly it follows.
        """
        if text == self.text:
            return
        if is_step or not self._before or at_s - self._changed_s > _TOGETHER_S:
            self._before.append(self.text)
            del self._before[:-_MOST_STEPS]
        self._changed_s = -1e9 if is_step else at_s
        self._behind.clear()
        self.text = text

    def undo(self) -> str:
        """Return the text before the last change."""
        if self._before:
            self._behind.append(self.text)
            self.text = self._before.pop()
            self._changed_s = -1e9
        return self.text

    def redo(self) -> str:
        """Return the text that was undone last."""
        if self._behind:
            self._before.append(self.text)
            self.text = self._behind.pop()
            self._changed_s = -1e9
        return self.text
