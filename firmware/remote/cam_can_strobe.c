// SPDX-License-Identifier: Apache-2.0
#include "cam_can_inner.h"
#include "cam_fix.h"           // cam_clamp_i32, cam_is_within
#include "cam_machine_scope.h" // cam_machine_strobe
#include <stddef.h>            // NULL

/// [Hz] messages while a piece of a recording is sent, which itself takes more than half of the
/// bus.
enum { during_reading_hz = 125 };

bool cam_can_strobe(cam_can_t *r, const struct camturn_command_t *m)
{
    cam_machine_t *machine = r->machine;
    if (m->command != CAMTURN_COMMAND_COMMAND_STROBE_CHOICE) {
        return false;
    }
    const cam_err_t err = cam_machine_strobe(machine, m->every);
    const cam_outcome_t outcome = {.err = err, .value = (int32_t)machine->strobe.every};
    const cam_outcome_t least = {.value = (int32_t)cam_strobe_least(machine->tick_hz)};
    const cam_outcome_t most = {.value = (int32_t)machine->tick_hz};
    cam_can_answer(r, m->command, m->parameter, outcome);
    if (err == cam_err_param_range) {
        cam_can_answer(r, CAMTURN_ANSWER_COMMAND_GET_MINIMUM_CHOICE, m->parameter, least);
        cam_can_answer(r, CAMTURN_ANSWER_COMMAND_GET_MAXIMUM_CHOICE, m->parameter, most);
    }
    return true;
}

/// @return whether the rate allows another message
static bool is_due(const cam_can_t *r, uint32_t tick)
{
    const uint32_t rate_hz =
        r->reading.is_on ? (uint32_t)during_reading_hz : (uint32_t)cam_strobe_hz;
    return (uint64_t)(tick - r->strobe_tick) * rate_hz >= r->machine->tick_hz;
}

void cam_can_send_sample(cam_can_t *r, uint32_t tick)
{
    enum { most_nm = (1 << 23) - 1, angle_bits = 16 };
    cam_strobe_t *strobe = &r->machine->strobe;
    const cam_strobe_sample_t *s = cam_strobe_oldest(strobe);
    if (s == NULL || !is_due(r, tick)) {
        return;
    }
    const struct camturn_strobe_t m = {
        .number = (uint8_t)(s->number & 0xFFu),
        .angle = (uint16_t)(s->pos_q16 & 0xFFFFu),
        .turn = (uint8_t)(s->pos_q16 >> angle_bits & 0xFFu),
        .error = cam_clamp_i32(s->following_nm, -most_nm - 1, most_nm),
        .state = (uint8_t)s->state,
        .is_synced = s->is_synced ? 1u : 0u,
        .is_saturated = s->following_nm > most_nm || s->following_nm < -most_nm - 1 ? 1u : 0u,
    };
    hal_can_frame_t frame = {.id = CAMTURN_STROBE_FRAME_ID};
    frame.n = (uint32_t)camturn_strobe_pack(frame.data, &m, sizeof frame.data);
    if (hal_can_write(&frame)) {
        cam_strobe_drop(strobe);
        r->strobe_tick = tick;
    }
}
