"""The table of a part that is cut with M4: every channel over angle, mirrored.

The drawing's angle phi counts the same way round whatever the spindle does (PARTFILE.md, "The
drawing's angle"). The angle of a table counts in the sense of cutting: phi with M3, -phi with M4.
Generators make channels over the drawing's angle, and `table_of` hands all of them to `in_sense`
for `process.direction = -1`, so a kind of part has nothing else to do. What a table says about
angles beside its channels, such as the phase of a pattern, goes through `angle_in_sense`.

Values keep their signs, the swing's and the contact's too: tool and follower stand still in the
machine, and at the same angle phi the same part lies before them in the same place, so the normal
at the contact has the same direction in space. Only derivatives by the angle change their signs.

>>> import numpy as np
>>> from camtools.table.channel import KIND_U
>>> knots = np.array([[[0, 5, 1], [10, 6, 2], [20, 7, 3], [30, 8, 4]]], dtype=np.int32)
>>> channel = Channel(KIND_U, knots, 0, 0, 0, 1_000_000, 0, 0, 30, 8, 4)
>>> in_sense(channel, -1).knots[0].tolist()
[[0, -5, 1], [30, -8, 4], [20, -7, 3], [10, -6, 2]]
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from camtools.table.channel import OVER_HEIGHT, Channel


def in_sense(channel: Channel, direction: int) -> Channel:
    """Return a channel over the drawing's angle in the sense of cutting, or the other way round.

    Knot k becomes knot -k of the pattern: (p, v, a) -> (p, -v, a), exactly, so the mirror of the
    mirror is the same channel. Bounds stay, and so does the size. A channel over height alone
    stays as it is. `quantise` makes no channel whose mirror would overflow.

    Parameters
    ----------
    direction : int
        `process.direction`: 1 (M3) changes nothing, -1 (M4) mirrors.
    """
    if direction == 1 or channel.kind in OVER_HEIGHT:
        return channel
    turned = np.roll(channel.knots[:, ::-1], 1, axis=1) * np.array([1, -1, 1], dtype=np.int32)
    return replace(channel, knots=turned)


def angle_in_sense(angle: float, direction: int) -> float:
    """Return a drawing's angle in the sense of cutting, or the other way round, in any unit."""
    return angle if direction == 1 else -angle
