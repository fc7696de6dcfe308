// SPDX-License-Identifier: Apache-2.0
/// rights_bench: a whole controller on a bus whose commander has the level unlocked by the key, and
/// the commands by their numbers.
#ifndef RIGHTS_BENCH_H
#define RIGHTS_BENCH_H

#include "cam_machine_rights.h" // cam_rights_t
#include "expect_can.h"         // expect_answer
#include "fixture_can.h"        // fixture_can_t
#include "hal_host.h"
#include "unity.h"

enum { enable = 1, disable, start, stop, reset, set, get, table_anew };
enum { home = 15, begin_download, end_download, set_learned = 29, manual, jog };
enum { begin_params = 50, stage, commit, save, defaults, revert };
enum { take = 60, release, beat, get_challenge, unlock, lock, last_command = lock };
enum { me = 1, other = 9, n_ms = 20 };

static fixture_can_t f;
static fixture_part_t part;
static uint8_t session;

static inline void begin(void)
{
    fixture_can_init(&f, &part, 20000);
}

static inline void run(void)
{
    fixture_can_start(&f);
    session = f.rig.machine.rights.session;
}

/// Called by Unity before each test.
void setUp(void)
{
    part = fixture_part_short();
    begin();
    run();
}

/// Called by Unity after each test.
void tearDown(void) {}

static inline fixture_answer_t by(uint8_t sender, uint8_t its_session, uint8_t command,
                                  int32_t value)
{
    return fixture_can_command_from(&f, command, 0, value, sender, its_session);
}

static inline void loop_until(cam_state_t wanted)
{
    expect_state_within(&f, wanted, 100000);
}

static inline void to_cutting(void)
{
    expect_answer(&f, cam_ok, 0, enable, 0, 0);
    loop_until(cam_state_ready);
    fixture_can_loop(&f, 2400); // the spindle runs up
    expect_answer(&f, cam_ok, 0, start, 0, 0);
    loop_until(cam_state_cutting);
}

#endif
