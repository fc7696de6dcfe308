// SPDX-License-Identifier: Apache-2.0
// A bad command bus in the cut: full load, a babbling node, frames with our identifiers, bus off.
// The same cut is played again and again; the commands to its axes are compared with those on a
// quiet bus, tick by tick, and the judge of the fuzzing checks each tick.
//
//     bus        prints a JSON object for each case; exits 1 where one ends otherwise than expected
#include "fixture_can.h" // fixture_can_receive_from
#include "fuzz_expect.h" // FUZZ_EXPECT
#include "fuzz_rig.h"
#include "hal_host.h"
#include "sim_random.h"
#include <stdio.h>  // printf
#include <string.h> // memset

enum { tick_hz = 20000, ms = tick_hz / 1000, sender = 9, most_ticks = 12 * tick_hz };
enum { commands_id = 0x640, blocks_id = 0x6C0 };
enum { get_parameter = 7, stop = 4, heartbeat = 62, take_command = 60 };
/// A frame of eight bytes takes at least 111 bits: so many fill a millisecond of 1 Mbit/s.
enum { full_load = 9 };

typedef enum {
    quiet,
    foreign,
    wrong_session,
    wrong_length,
    blocks,
    any_command,
    babble,
    bus_off,
    deaf,
    n_cases
} case_t;

static const struct {
    const char *name;
    bool is_commander_heard; ///< arbitration leaves the commander's frames through
    bool is_cut_whole;       ///< and each axis is commanded the same as on a quiet bus
} cases[n_cases] = {
    [quiet] = {"quiet", true, true},
    [foreign] = {"foreign_identifiers_at_full_load", true, true},
    [wrong_session] = {"our_identifier_wrong_session_at_full_load", true, true},
    [wrong_length] = {"our_identifier_wrong_length_at_full_load", true, true},
    [blocks] = {"blocks_of_a_download_at_full_load", true, true},
    [any_command] = {"any_command_but_stop_without_session_at_full_load", true, true},
    [babble] = {"highest_priority_babbles_nothing_else_gets_through", false, false},
    [bus_off] = {"bus_off_nothing_can_be_sent", false, false},
    [deaf] = {"error_frames_nothing_gets_through", false, false},
};

static sim_random_t dice;
static struct {
    int32_t nm[hal_n_axes];
} commanded[most_ticks];

static uint32_t any(uint32_t n)
{
    return (uint32_t)((sim_random_next(&dice) >> 32) % n);
}

static void send_any(case_t which)
{
    hal_can_frame_t f = {.id = commands_id, .n = 8};
    for (uint32_t i = 0; i < 8u; i++) {
        f.data[i] = (uint8_t)any(256);
    }
    switch (which) {
    case foreign:
        f.id = any(0x640);
        break;
    case wrong_session:
        f.data[2] = sender;
        f.data[3] = (uint8_t)(fuzz_rig.machine.rights.session + 1u + any(254));
        break;
    case wrong_length:
        f.n = any(8);
        break;
    case blocks:
        f.id = blocks_id;
        break;
    case babble:
        f.id = 0;
        break;
    default:
        f.data[2] = 0;
        f.data[3] = 0;
        break;
    }
    // Everybody may stop, always, and may take a command that nobody lost: not what is asked here.
    const bool may_act = f.id == commands_id && (f.data[0] == stop || f.data[0] == take_command);
    f.data[0] = may_act ? heartbeat : f.data[0];
    (void)hal_host_can_receive(&f);
}

/// What the bus carries in a millisecond, spread over it.
static void carry(case_t which, uint32_t tick)
{
    const bool is_heard = cases[which].is_commander_heard;
    const uint32_t now = tick % (uint32_t)ms;
    if (which != quiet && which != bus_off && which != deaf && now % 2u == 0u &&
        now / 2u < (uint32_t)full_load) {
        send_any(which);
    }
    if (is_heard && tick % (100u * ms) == 19u) {
        fixture_can_receive_from(commands_id, 8, heartbeat, 0, 0, sender,
                                 fuzz_rig.machine.rights.session);
    }
    hal_host.slow.is_bus_off = which == bus_off || which == deaf;
}

static void begin(void)
{
    fuzz_rig_start((fuzz_start_t){.tick_hz = tick_hz, .part = 0, .state = cam_state_ready});
    hal_host.slow.n_room = UINT32_MAX;
    dice = sim_random_seeded(1);
    fixture_can_receive_from(commands_id, 8, take_command, 0, 0, sender, 0);
    fuzz_rig_loop(4);
    const cam_err_t fed = cam_machine_set_param(&fuzz_rig.machine, cam_param_feed_nm, 5000);
    fuzz_rig_loop(4);
    const cam_err_t started = cam_machine_start(&fuzz_rig.machine);
    FUZZ_EXPECT(fed == cam_ok && started == cam_ok && fuzz_rig.machine.rights.commander == sender,
                "begin: %d, %d", (int)fed, (int)started);
}

/// @return whether the case ended as it has to
static bool play(case_t which)
{
    uint32_t n_different = 0;
    uint32_t n_until_end = 0;
    uint32_t n_ticks = 0;
    uint32_t n_work = 0;
    begin();
    do {
        carry(which, n_ticks);
        fuzz_rig_loop(1);
        for (uint32_t i = 0; i < (uint32_t)hal_n_axes; i++) {
            const int32_t nm = hal_host.out.axis[i].pos_nm;
            n_different += which != quiet && commanded[n_ticks].nm[i] != nm ? 1u : 0u;
            commanded[n_ticks].nm[i] = which == quiet ? nm : commanded[n_ticks].nm[i];
        }
        n_ticks++;
        const bool is_ending = fuzz_rig_state() == cam_state_disengaging;
        n_until_end = n_until_end == 0u && is_ending ? n_ticks : n_until_end;
        n_work += fuzz_rig_state() == cam_state_cutting ? 1u : 0u;
    } while (n_ticks < (uint32_t)most_ticks &&
             (fuzz_rig_state() != cam_state_ready || n_work == 0u) &&
             fuzz_rig_state() != cam_state_fault);
    const bool is_ready = fuzz_rig_state() == cam_state_ready;
    const uint32_t n_losses = fuzz_rig.machine.rights.n_losses;
    const uint32_t end_ms = n_until_end / ms;
    (void)printf(
        "{\"case\": \"%s\", \"ticks\": %u, \"in_the_work\": %u, \"commanded_otherwise\": %u, "
        "\"losses_of_command\": %u, \"ms_to_disengaging\": %u, \"state\": \"%s\"}\n",
        cases[which].name, n_ticks, n_work, n_different, n_losses, end_ms,
        cam_state_name(fuzz_rig_state()));
    if (cases[which].is_cut_whole) {
        return is_ready && n_different == 0u && n_losses == 0u && n_work > 2u * tick_hz;
    }
    // The commander was heard last at 0; a second later its loss ends the cut as by stop.
    return is_ready && n_losses == 1u && end_ms >= 1000u && end_ms <= 1100u;
}

int main(void)
{
    bool is_good = true;
    for (int i = 0; i < (int)n_cases; i++) {
        is_good = play((case_t)i) && is_good;
    }
    return is_good ? 0 : 1;
}
