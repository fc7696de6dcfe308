// SPDX-License-Identifier: Apache-2.0
// Frames arrive, in any order and of any content, while the tick runs: commands, parameters, blocks
// of a download. Every frame of the controller's own is a message of the DBC; every tick is judged.
#include "cam_remote.h"
#include "cam_param.h"
#include "fuzz_bytes.h"
#include "fuzz_expect.h"
#include "fuzz_mutate.h"
#include "fuzz_rig.h"
#include "hal_host.h"

enum { head_bytes = 4, order_bytes = 12, most_ticks = 1500, gap_ticks = 12 };
enum { command_id = 0x640, answer_id = 0x5C0, block_id = 0x6C0 };

static uint32_t n_left;  // [ticks] that this input may still take
static uint32_t n_heard; // frames that have been looked at

/// Parameters of the machine itself are limits that change under the judge, and what was learned
/// moves U beyond its set-point.
static bool is_judged(const hal_can_frame_t *f)
{
    static const cam_param_id_t others[] = {
        cam_param_u_speed_um_per_s, cam_param_u_acceleration_mm_per_s2,
        cam_param_x_speed_um_per_s, cam_param_x_acceleration_mm_per_s2,
        cam_param_z_speed_um_per_s, cam_param_z_acceleration_mm_per_s2,
        cam_param_counts_per_turn,  cam_param_encoder_sign,
    };
    static const cam_param_id_t wild[] = {cam_param_k1_ns, cam_param_k2_us2, cam_param_xz_lag_ns,
                                          cam_param_learn_harmonics};
    const bool is_set = f->data[0] == 6u || f->data[0] == 51u;
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++) {
        if (is_set && f->data[1] == (uint8_t)others[i]) {
            return false;
        }
    }
    for (size_t i = 0; i < sizeof wild / sizeof wild[0]; i++) {
        if (is_set && f->data[1] == (uint8_t)wild[i]) {
            return fuzz_rig.judge.is_wild;
        }
    }
    return f->data[0] != 29u || fuzz_rig.judge.is_wild; // set_learned
}

static void hear(void)
{
    static const uint32_t ids[] = {0x5C0, 0x1C0, 0x2C0, 0x3C0, 0x4C0, 0x440, 0x340, 0x540};
    for (; n_heard != hal_host.slow.n_sent; n_heard++) {
        const hal_can_frame_t *f = &hal_host.slow.sent[n_heard % hal_host_can_frames];
        fuzz_note(f->id);
        for (uint32_t i = 0; i < f->n; i++) {
            fuzz_note(f->data[i]);
        }
        bool is_ours = false;
        for (size_t i = 0; i < sizeof ids / sizeof ids[0]; i++) {
            is_ours = is_ours || f->id == ids[i];
        }
        FUZZ_EXPECT(is_ours, "a frame with the id %x", (unsigned)f->id);
        FUZZ_EXPECT(f->n <= (f->id == 0x340u ? 64u : 8u), "%u bytes", (unsigned)f->n);
    }
}

static void let_pass(uint32_t n)
{
    const uint32_t now = n < n_left ? n : n_left;
    for (uint32_t i = 0; i < now; i++) {
        if (i < 4u || i % 16u == 0u) { // the answer comes at once
            cam_machine_poll(&fuzz_rig.machine);
            cam_can_poll(&fuzz_rig.can);
        }
        fuzz_rig_tick();
        hear();
    }
    n_left -= now;
}

/// What an order does besides sending its frame.
static void happen(uint8_t what)
{
    switch (what % 16u) {
    case 0:
        hal_host.slow.n_room = what / 16u;
        break;
    case 1:
        hal_host.slow.is_bus_off = what >= 128u;
        break;
    case 2:
        hal_host_fault_estop(what >= 128u);
        break;
    case 3:
        hal_host_fault_drive(what >= 128u);
        break;
    case 5:
        hal_host_turn_key(what >= 128u);
        break;
    case 4:
        hal_host.slow.n_store = what / 32u;
        break;
    default:
        hal_host.slow.n_room = UINT32_MAX;
        hal_host.slow.n_store = UINT32_MAX;
        break;
    }
}

/// What a frame of somebody who has no command may not change.
static void expect_ignored(const hal_can_frame_t *f)
{
    enum { stop = 4, take_command = 60 };
    const cam_machine_t *m = &fuzz_rig.machine;
    const bool is_own = cam_rights_is_commander(&m->rights, f->data[2], f->data[3]);
    const bool is_next = hal_host.slow.n_received - hal_host.slow.n_read == 1u;
    if (f->id != command_id || f->n != 8u || is_own || !is_next || f->data[0] == stop ||
        f->data[0] == take_command) {
        return;
    }
    const uint32_t version = m->version;
    const uint32_t n_requests = m->n_requests;
    const uint32_t n_losses = m->rights.n_losses;
    cam_can_poll(&fuzz_rig.can);
    if (m->rights.n_losses == n_losses) { // a loss of command ends the cut by itself
        FUZZ_EXPECT(m->version == version, "command %u of a stranger changes a parameter",
                    (unsigned)f->data[0]);
        FUZZ_EXPECT(m->n_requests == n_requests, "command %u of a stranger is carried out",
                    (unsigned)f->data[0]);
    }
}

static void carry_out(fuzz_bytes_t *b)
{
    const uint8_t what = fuzz_u8(b);
    const uint8_t kind = fuzz_u8(b);
    const uint16_t pause = fuzz_u16(b);
    hal_can_frame_t f = {.id = command_id, .n = 8};
    for (uint32_t i = 0; i < 8u; i++) {
        f.data[i] = fuzz_u8(b);
    }
    if (kind % 4u == 1u) {
        f.id = block_id;
    } else if (kind % 16u == 2u) {
        f.id = (uint32_t)pause & 0x7FFu;
        f.n = kind / 16u % 9u;
    } else {
        // Nobody, anybody, or the one who has command.
        const cam_rights_t *rights = &fuzz_rig.machine.rights;
        const bool is_any = kind % 16u == 3u;
        const bool is_commander = kind % 16u >= 8u;
        f.data[2] = is_any ? f.data[2] : is_commander ? rights->commander : 0u;
        f.data[3] = is_any ? f.data[3] : is_commander ? rights->session : 0u;
    }
    happen(what);
    if (is_judged(&f)) {
        (void)hal_host_can_receive(&f);
        fuzz_rig.judge.n_alone = 0;
        expect_ignored(&f);
    }
    let_pass(pause % (kind >= 240u ? 300u : (uint32_t)gap_ticks) + 1u);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz_bytes_t b = {.at = data, .n = size};
    if (size < (size_t)head_bytes) {
        return -1;
    }
    fuzz_start_t from = fuzz_rig_start_of(fuzz_u8(&b));
    const uint8_t part = fuzz_u8(&b);
    (void)fuzz_u16(&b);
    from.has_button = part >= 128u;
    from.part = part % 64u % fuzz_rig_n_parts;
    fuzz_rig_start(from);
    fuzz_rig.judge.is_wild = (part & 64u) != 0u;
    fuzz_try(cam_rights_take(&fuzz_rig.machine.rights, 7, true, fuzz_rig_record()->tick));
    n_heard = hal_host.slow.n_sent;
    n_left = most_ticks;
    while (b.n > 0u && n_left > 0u) {
        carry_out(&b);
    }
    let_pass(4);
    return 0;
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned seed)
{
    return fuzz_mutate_orders(data, size, max_size, seed, head_bytes, order_bytes);
}
