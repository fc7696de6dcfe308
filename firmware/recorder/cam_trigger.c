// SPDX-License-Identifier: Apache-2.0
#include "cam_trigger.h"

/// @return whether values rise to the level
static bool reaches(int32_t level, int32_t last, int32_t now)
{
    return last < level && now >= level;
}

/// @return a - b, for angles and tick numbers, which wrap
static int32_t wrapped(int32_t a, int32_t b)
{
    return (int32_t)((uint32_t)a - (uint32_t)b);
}

/// @return whether an angle reaches or crosses the level. A step is less than half a turn, so the
///         opposite side of the turn is crossed in the other sense.
static bool passes(const cam_trigger_t *t, int32_t last, int32_t now)
{
    const int32_t before = wrapped(last, t->level);
    const int32_t here = wrapped(now, t->level);
    const int32_t step = wrapped(now, last);
    return t->falls ? step < 0 && before > 0 && here <= 0 : step > 0 && before < 0 && here >= 0;
}

bool cam_trigger_fires(const cam_trigger_t *t, cam_trigger_last_t last, int32_t now)
{
    if (t->kind == cam_trigger_now || t->kind == cam_trigger_time) {
        return t->kind == cam_trigger_now || wrapped(now, t->level) >= 0;
    }
    if (!last.is_there) {
        return false;
    }
    switch (t->kind) {
    case cam_trigger_level:
        return t->falls ? reaches(-1 - t->level, -1 - last.value, -1 - now)
                        : reaches(t->level, last.value, now);
    case cam_trigger_angle:
        return passes(t, last.value, now);
    case cam_trigger_state:
        return now == t->level && last.value != t->level;
    default: // a new fault bit
        return ((uint32_t)now & ~(uint32_t)last.value &
                (t->level != 0 ? (uint32_t)t->level : UINT32_MAX)) != 0u;
    }
}
