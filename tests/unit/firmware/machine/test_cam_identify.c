// SPDX-License-Identifier: Apache-2.0
// Excitation of U by the commands of the slow side, and every end of it; the download of its wave
// into the memory of the recorder. A wave of force, of a machine that follows its set-points,
// whatever the force: what reaches the output, how it ends, and what is refused.
#define OWN_SET_UP
#include "cam_machine_inner.h"
#include "rig_bench.h"
#include <math.h> // sin

enum { tick_hz = 20000, n = 200, n_periods = 3, fade = 100, place_nm = -300000 };
enum { largest_mn = 10000, patience = 40000 };

static cam_machine_t *const m = &rig.machine;
static int32_t wave[n];     ///< [nm], or [mN] of forces
static uint32_t fade_ticks; ///< in which the wave rises, and falls

static int32_t field(uint32_t which)
{
    int32_t value = 0;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_scope_get(m, which, &value));
    return value;
}

static void set_field(uint32_t which, int32_t value)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_scope_set(m, which, value));
}

static cam_err_t load(uint32_t crc_error)
{
    const uint8_t *bytes = (const uint8_t *)wave;
    cam_err_t err = cam_machine_wave_begin(m, sizeof wave);
    if (err == cam_ok) {
        err = cam_machine_wave_block(m, 0, bytes, sizeof wave);
    }
    return err != cam_ok ? err
                         : cam_machine_wave_end(m, cam_crc32(0, bytes, sizeof wave) ^ crc_error);
}

void setUp(void)
{
    part = fixture_part_short();
    fade_ticks = fade;
    fixture_rig_init(&rig, &part, tick_hz);
    hal_host.in.axis_nm[hal_axis_x] = 60000000; // clear of the part
    fixture_rig_tick(&rig);
    for (int i = 0; i < n; i++) {
        wave[i] = (int32_t)(20000.0 * sin(6.283185307179586 * i / n));
    }
    set_field(cam_scope_field_place_nm, place_nm);
    // The recording of a wave begins with it, whatever its last one waited for.
    set_field(cam_scope_field_before, 5);
    set_field(cam_scope_field_trigger, cam_trigger_time);
    set_field(cam_scope_field_level, 1000000000);
}

/// Ticks with the main loop between them, with signs of life or without.
static void go_on(uint32_t ticks, bool is_alive)
{
    for (uint32_t i = 0; i < ticks; i++) {
        fixture_rig_tick(&rig);
        cam_machine_poll(m);
        if (is_alive) {
            cam_machine_keep_alive(m);
        }
    }
}

/// In ready, with the wave.
static void to_ready(void)
{
    TEST_ASSERT_TRUE(fixture_rig_bring(&rig, cam_state_ready));
    TEST_ASSERT_EQUAL_INT(cam_ok, load(0));
}

static void begin(void)
{
    to_ready();
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_excite(m, n_periods, fade_ticks).err);
    go_on(3, true);
    TEST_ASSERT_EQUAL_INT(cam_state_identifying, fixture_rig_state());
    TEST_ASSERT_EQUAL_UINT32(0, m->scope.plan.before);
    TEST_ASSERT_EQUAL_INT32(place_nm, field(cam_scope_field_place_nm));
}

/// Until the machine has its usual configuration again.
static void expect_end(cam_excited_t excited, cam_state_t wanted)
{
    for (uint32_t i = 0; i < 20000u && m->identify.phase != cam_identify_none; i++) {
        go_on(1, true);
    }
    go_on(2, true);
    TEST_ASSERT_EQUAL_INT(excited, field(cam_scope_field_excited));
    TEST_ASSERT_EQUAL_INT(wanted, fixture_rig_state());
    const cam_config_t *cfg = atomic_load(&m->core->config.in_use);
    TEST_ASSERT_EQUAL_UINT32(0, cfg->play.excite.n);
    TEST_ASSERT_EQUAL_INT32(m->identify.following_nm, cfg->guard.following_nm);
}

/// The first period in full begins with the first sample, however many periods it takes to rise.
static void expect_wave_is_played(uint32_t ticks)
{
    setUp();
    fade_ticks = ticks;
    begin();
    expect_end(cam_excited_done, cam_state_ready);
    TEST_ASSERT_EQUAL_INT32(cam_scope_state_left, field(cam_scope_field_end));
    const int32_t n_fall = field(cam_scope_field_n_fall);
    const int32_t first = field(cam_scope_field_n_rows) - n_fall - n_periods * n;
    TEST_ASSERT_GREATER_THAN_INT32(0, first);
    const int32_t *words = &m->scope.words[m->scope.at];
    for (int32_t i = 0; i < n_periods * n; i++) {
        const int32_t at = (first + i) * 3;
        TEST_ASSERT_EQUAL_INT32((place_nm + wave[i % n]) * 64, words[at]); // u_set_q6
        TEST_ASSERT_EQUAL_INT32(place_nm + wave[i % n], words[at + 1]);    // no feed-forward
    }
}

static void test_a_wave_is_played_recorded_and_left(void)
{
    expect_wave_is_played(7 * n + 30);
    expect_wave_is_played(fade);
    go_on(2000, false);
    TEST_ASSERT_EQUAL_INT32(m->params.u_retract_nm, hal_host.in.axis_nm[hal_axis_u]);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_start(m)); // a cut follows as ever
}

static void test_the_way_to_the_place_is_without_the_wave(void)
{
    begin();
    const cam_axis_motion_t *u = &m->core->motion.axis[hal_axis_u];
    for (; u->pos_q10 != (int64_t)place_nm * 1024; go_on(1, true)) {
        TEST_ASSERT_EQUAL_INT32(u->pos_q10 >> 4, fixture_rig_status(&rig).u_set_q6);
    }
}

/// A disable ends it in off, a stop in ready, however often a stop is asked for after it; the
/// enable stays meanwhile.
static void test_stop_and_disable_let_it_fade(void)
{
    for (int i = 1; i >= 0; i--) {
        begin();
        go_on(400, true);
        TEST_ASSERT_EQUAL_INT(cam_ok, i == 0 ? cam_machine_stop(m) : cam_machine_disable(m));
        TEST_ASSERT_EQUAL_INT(cam_err_busy, cam_machine_stop(m));
        go_on(1, true);
        TEST_ASSERT_EQUAL_INT(cam_state_identifying, fixture_rig_state());
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_stop(m));
        expect_end(cam_excited_stopped, i == 0 ? cam_state_ready : cam_state_off);
        TEST_ASSERT_EQUAL_UINT32(0, fixture_rig_status(&rig).faults);
    }
}

/// Hand a wave over, up to where the interrupt has still to obey the request to play it.
static void request(uint32_t n_asked)
{
    to_ready();
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_excite(m, n_asked, fade).err);
    cam_machine_poll(m);
    TEST_ASSERT_EQUAL_INT(cam_identify_offered, m->identify.phase);
    fixture_rig_tick(&rig);
    cam_machine_poll(m);
    TEST_ASSERT_EQUAL_INT(cam_identify_requested, m->identify.phase);
}

/// Between the begin and the slow side's look at it nothing can be stopped: what stops it waits. A
/// begin that was missed is known by its end.
static void test_a_begin_that_was_not_seen_is_not_stopped(void)
{
    request(n_periods);
    cam_machine_poll(m); // waits for the interrupt
    fixture_rig_tick(&rig);
    TEST_ASSERT_EQUAL_INT(cam_state_identifying, fixture_rig_state());
    TEST_ASSERT_EQUAL_INT(cam_err_busy, cam_machine_stop(m));
    TEST_ASSERT_EQUAL_INT(cam_excited_runs, field(cam_scope_field_excited));
    expect_end(cam_excited_done, cam_state_ready);
    setUp();
    request(1);
    fixture_rig_ticks(&rig, 4000);
    TEST_ASSERT_EQUAL_INT(cam_state_ready, fixture_rig_state());
    expect_end(cam_excited_done, cam_state_ready);
    setUp();
    request(1);
    hal_host_fault_estop(true);
    fixture_rig_tick(&rig);
    expect_end(cam_excited_fault, cam_state_fault);
}

/// While the interrupt has not taken the last configuration, nothing begins, and the end waits.
static void test_begin_and_end_need_room(void)
{
    to_ready();
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_set_param(m, cam_param_phase_udeg, 5));
    TEST_ASSERT_EQUAL_INT(cam_err_busy, cam_machine_excite(m, 1, fade).err);
    TEST_ASSERT_FALSE(cam_scope_is_on(&m->scope));
    TEST_ASSERT_EQUAL_INT(cam_identify_none, m->identify.phase);
    fixture_rig_tick(&rig);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_excite(m, 1, fade).err);
    for (uint32_t i = 0; i < 20000u && m->identify.phase != cam_identify_ends; i++) {
        go_on(1, true);
    }
    TEST_ASSERT_EQUAL_INT(cam_state_ready, fixture_rig_state());
    (void)cam_config_copy(&m->core->config); // somebody else hands a configuration over
    cam_machine_offer_copy(m);
    cam_machine_poll(m);
    TEST_ASSERT_EQUAL_INT(cam_identify_ends, m->identify.phase);
    expect_end(cam_excited_done, cam_state_ready);
}

/// A black box that nobody has read, a memory without room for rows of three signals after the
/// wave, and a command that is not obeyed yet. A box that only waits for a fault gives way.
static void test_what_is_in_the_way_of_a_begin(void)
{
    to_ready();
    m->scope.use = cam_scope_box;
    m->scope.phase = cam_scope_done;
    TEST_ASSERT_EQUAL_INT(cam_err_scope_unread, cam_machine_excite(m, 1, fade).err);
    m->scope.phase = cam_scope_armed;
    const uint32_t n_words = m->scope.n_words, generation = m->generation;
    m->scope.n_words = n + 2u;
    TEST_ASSERT_EQUAL_INT(cam_err_scope_memory, cam_machine_excite(m, 1, fade).err);
    TEST_ASSERT_EQUAL_UINT32(generation, m->generation);
    TEST_ASSERT_EQUAL_INT(cam_identify_none, m->identify.phase);
    m->scope.n_words = n_words;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_excite(m, 1, fade).err);
    setUp();
    to_ready();
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_disable(m));
    TEST_ASSERT_EQUAL_INT(cam_err_busy, cam_machine_excite(m, 1, fade).err);
    fixture_rig_ticks(&rig, 20);
    TEST_ASSERT_EQUAL_INT(cam_err_state, cam_machine_excite(m, 1, fade).err);
}

/// So does a stop on the way to the place, at once.
static void test_silence_ends_it(void)
{
    set(cam_param_phase_udeg, 0);
    begin();
    const int32_t longest = tick_hz / 1000 * cam_identify_patience_ms;
    int32_t ticks = 0;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_stop(m));
    go_on(5, true);
    TEST_ASSERT_EQUAL_INT(cam_state_ready, fixture_rig_state());
    expect_end(cam_excited_stopped, cam_state_ready);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_excite(m, 100, fade).err);
    while (field(cam_scope_field_excited) == cam_excited_runs && ticks < 2 * longest) {
        go_on(1, false);
        ticks++;
    }
    TEST_ASSERT_INT32_WITHIN(4, longest, ticks);
    expect_end(cam_excited_silent, cam_state_ready);
}

/// The limit is the usual one and the largest sample: a drive that answers the wave by its
/// opposite is accepted, one that is further off is not.
static void test_following_error_has_the_room_of_the_larger_side(void)
{
    for (int sign = -1; sign <= 1; sign += 2) {
        setUp();
        for (int i = 0; i < n; i++) {
            const bool is_large = sign * wave[i] > 0;
            wave[i] = is_large ? wave[i] : wave[i] / 2;
        }
        begin();
        const cam_config_t *cfg = atomic_load(&m->core->config.in_use);
        TEST_ASSERT_EQUAL_INT32(m->identify.following_nm + 20000, cfg->guard.following_nm);
    }
}

static void test_it_begins_in_ready_only_and_with_a_whole_wave(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, load(0));
    TEST_ASSERT_EQUAL_INT(cam_err_state, cam_machine_excite(m, 1, fade).err);
    TEST_ASSERT_TRUE(fixture_rig_bring(&rig, cam_state_ready));
    TEST_ASSERT_EQUAL_INT(cam_err_download_crc, load(1));
    TEST_ASSERT_EQUAL_INT(cam_err_wave_none, cam_machine_excite(m, 1, fade).err);
    TEST_ASSERT_EQUAL_INT(cam_ok, load(0));

    hal_host.in.axis_nm[hal_axis_x] = 0; // seen by the next tick
    rig.lathe.is_held[hal_axis_z] = true;
    m->core->motion.axis[hal_axis_x].pos_q10 = 0;
    fixture_rig_ticks(&rig, 2);
    const cam_verdict_t v = cam_machine_excite(m, 1, fade);
    TEST_ASSERT_EQUAL_INT(cam_err_wave_clear, v.err);
    TEST_ASSERT_GREATER_THAN_INT32(0, v.value);
    TEST_ASSERT_EQUAL_INT(cam_state_ready, fixture_rig_state());
}

/// While it plays, and between the command and the tick that obeys it.
static void test_nothing_else_is_accepted_meanwhile(void)
{
    for (int is_pending = 0; is_pending < 2; is_pending++) {
        const cam_err_t err = is_pending == 0 ? cam_err_state : cam_err_busy;
        setUp();
        if (is_pending == 0) {
            begin();
            go_on(100, true);
            TEST_ASSERT_EQUAL_INT(err, cam_machine_enable(m));
            TEST_ASSERT_EQUAL_INT(err, cam_machine_scope_start(m));
            TEST_ASSERT_EQUAL_INT(err,
                                  cam_machine_select_table(m, rig.image.bytes, rig.image.size));
        } else {
            to_ready();
            TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_excite(m, 1, fade).err);
            TEST_ASSERT_EQUAL_INT(err, cam_machine_disable(m));
        }
        TEST_ASSERT_EQUAL_INT(err, cam_machine_start(m));
        TEST_ASSERT_EQUAL_INT(err, cam_machine_excite(m, 1, fade).err);
        TEST_ASSERT_EQUAL_INT(err, cam_machine_wave_begin(m, 64));
        cam_machine_stage_begin(m); // a commit that changes nothing
        TEST_ASSERT_EQUAL_INT(cam_err_busy, cam_machine_stage_commit(m));
        TEST_ASSERT_EQUAL_INT(is_pending == 0 ? cam_err_param_state : cam_err_busy,
                              cam_machine_set_param(m, cam_param_amplitude_ppm, 900000));
        go_on(3, true);
        expect_end(cam_excited_done, cam_state_ready);
    }
}

// Download

static void test_downloads_out_of_order_are_refused(void)
{
    static const struct {
        uint32_t offset, at, n;
        cam_err_t err;
    } blocks[] = {
        {4, 0, 4, cam_err_download_order},
        {0, 0, 3, cam_err_download_order},
        {0, 0, 0, cam_err_download_order},
        {0, 0, 400, cam_ok},
        {0, 0, 400, cam_ok}, // its answer was lost
        {0, 4, 400, cam_err_download_order},
        {400, 0, 404, cam_err_download_room},
        {4000, 0, 4, cam_err_download_room},
    };
    const uint8_t *bytes = (const uint8_t *)wave;
    TEST_ASSERT_EQUAL_INT(cam_err_download_order, cam_machine_wave_block(m, 0, bytes, 4));
    TEST_ASSERT_EQUAL_INT(cam_err_wave_length, cam_machine_wave_begin(m, 60));
    TEST_ASSERT_EQUAL_INT(cam_err_wave_length, cam_machine_wave_begin(m, 66));
    TEST_ASSERT_EQUAL_INT(cam_err_scope_memory, cam_machine_wave_begin(m, UINT32_MAX - 3u));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_wave_begin(m, sizeof wave));
    for (uint32_t i = 0; i < sizeof blocks / sizeof blocks[0]; i++) {
        TEST_ASSERT_EQUAL_INT(
            blocks[i].err,
            cam_machine_wave_block(m, blocks[i].offset, bytes + blocks[i].at, blocks[i].n));
    }
    TEST_ASSERT_EQUAL_INT(cam_err_download_short, cam_machine_wave_end(m, 0));
    TEST_ASSERT_EQUAL_UINT32(400, m->identify.received);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_wave_block(m, 400, bytes + 400, 400));
    const uint32_t crc = cam_crc32(0, bytes, sizeof wave);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_wave_end(m, crc));
    TEST_ASSERT_EQUAL_INT(cam_err_download_order, cam_machine_wave_end(m, crc));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_scope_start(m));
    TEST_ASSERT_EQUAL_INT(cam_err_scope_on, cam_machine_wave_begin(m, 64));
}

/// A minute at 20 kHz, its fades included, has 1 200 000 ticks. A release forgets the wave.
static void test_length_of_an_excitation_is_limited(void)
{
    static const struct {
        uint32_t n_periods, fade_ticks;
        bool is_good;
    } cases[] = {{1, 16, true},       {0, 16, false},      {1, 15, false},
                 {1, 65535, true},    {1, 65536, false},   {5990, 1000, true},
                 {5990, 1001, false}, {5991, 1000, false}, {UINT32_MAX, 16, false}};
    wave[1] = 1000000; // a step that no axis could follow
    to_ready();
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const cam_verdict_t found = cam_machine_excite(m, cases[i].n_periods, cases[i].fade_ticks);
        TEST_ASSERT_NOT_EQUAL_INT(cam_ok, found.err);
        TEST_ASSERT_EQUAL_INT(!cases[i].is_good, found.err == cam_err_wave_length);
        TEST_ASSERT_TRUE(cases[i].is_good || found.value == 1200000);
    }
    TEST_ASSERT_NOT_EQUAL_INT(cam_err_wave_none, cam_machine_excite(m, 1, 16).err);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_release(m));
    TEST_ASSERT_EQUAL_INT(cam_err_wave_none, cam_machine_excite(m, 1, 16).err);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_wave_begin(m, sizeof wave));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_release(m));
    TEST_ASSERT_EQUAL_INT(cam_err_download_order,
                          cam_machine_wave_block(m, 0, (const uint8_t *)wave, 4));
}

// Waves of force

static cam_err_t set_unit(int32_t unit)
{
    return cam_machine_scope_set(m, cam_scope_field_wave_unit, unit);
}

static void load_force(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, load(0));
    TEST_ASSERT_EQUAL_INT(cam_ok, set_unit(1));
}

/// A loop of 1 Hz without an integral, and a parameter: at rest where it should be, U gets no force
/// of it.
static void to_force_with(cam_param_id_t id, int32_t value)
{
    hal_host.slow.force.quantum_un = 20000;
    set_field(cam_scope_field_place_nm, 0);
    set(cam_param_servo_integral_mHz, 0);
    set(cam_param_servo_crossover_hz, 1);
    set(id, value);
    TEST_ASSERT_TRUE(fixture_rig_bring(&rig, cam_state_ready));
    for (int32_t i = 0; i < n; i++) {
        wave[i] = i % 2 == 0 ? largest_mn - 20 * i : 10 * i - largest_mn;
    }
    load_force();
}

static void to_force(void)
{
    to_force_with(cam_param_servo_mass_g, 1500);
}

/// @return [mN / 64] force of a tick at the position of the wave
static int32_t next_q6(bool is_alive)
{
    go_on(1, is_alive);
    TEST_ASSERT_EQUAL_INT32(0, fixture_rig_status(&rig).u_set_q6);
    TEST_ASSERT_EQUAL_INT32(rig.last.force_q6, hal_host.out.force_q6);
    return rig.last.force_q6;
}

/// Play, up to the tick before the force of the first sample of the first period in full.
static void begin_force(uint32_t periods)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_excite(m, periods, fade).err);
    int32_t left = patience;
    const cam_axis_motion_t *u = &g_cam.motion.axis[hal_axis_u];
    while (left-- > 0 && (fixture_rig_state() != cam_state_identifying || u->pos_q10 != 0)) {
        go_on(1, true);
        TEST_ASSERT_EQUAL_INT32(0, g_cam.motion.u_push_q6);
    }
    do {
        (void)next_q6(true);
    } while (left-- > 0 && g_cam.play.excite.n_left >= periods * n);
    TEST_ASSERT_GREATER_THAN_INT32(0, left);
}

/// Sample by sample in the tick after the one that plays it, then nothing from one tick to the
/// next, though the last sample is large.
static void test_force_is_the_samples_and_ends_at_once(void)
{
    to_force();
    begin_force(n_periods);
    for (int32_t i = 0; i < n_periods * n; i++) {
        TEST_ASSERT_EQUAL_INT(cam_state_identifying, fixture_rig_state());
        TEST_ASSERT_EQUAL_INT32(64 * wave[i % n], next_q6(true));
    }
    TEST_ASSERT_EQUAL_INT(cam_state_ready, fixture_rig_state());
    TEST_ASSERT_EQUAL_INT32(0, g_cam.motion.u_push_q6);
    go_on(1, true);
    TEST_ASSERT_INT32_WITHIN(2, 0, rig.last.force_q6);
    expect_end(cam_excited_done, cam_state_ready);
    TEST_ASSERT_EQUAL_UINT32(0, m->identify.n_fall);
    TEST_ASSERT_EQUAL_UINT32(0, fixture_rig_status(&rig).faults);
}

/// U retracts to where it plays the wave, so its own force is none.
static void test_every_end_takes_the_force_away_at_once(void)
{
    static const struct {
        cam_excited_t excited;
        cam_state_t at_once, state;
    } ends[] = {{cam_excited_stopped, cam_state_ready, cam_state_ready},
                {cam_excited_stopped, cam_state_ready, cam_state_off},
                {cam_excited_silent, cam_state_ready, cam_state_ready},
                {cam_excited_fault, cam_state_fault, cam_state_fault}};
    for (int i = 0; i < 4; i++) {
        setUp();
        to_force();
        set(cam_param_u_retract_nm, 0);
        begin_force(1000);
        if (ends[i].excited == cam_excited_silent) {
            for (int k = 0; k < patience && fixture_rig_state() == cam_state_identifying; k++) {
                go_on(1, false);
            }
        } else {
            if (ends[i].excited == cam_excited_stopped) {
                TEST_ASSERT_EQUAL_INT(cam_ok,
                                      i == 0 ? cam_machine_stop(m) : cam_machine_disable(m));
            }
            hal_host_fault_estop(ends[i].excited == cam_excited_fault);
            (void)next_q6(true); // the tick that obeys still writes the force of the last one
        }
        TEST_ASSERT_EQUAL_INT(ends[i].at_once, fixture_rig_state());
        go_on(1, true);
        TEST_ASSERT_INT32_WITHIN(2, 0, rig.last.force_q6);
        expect_end(ends[i].excited, ends[i].state);
    }
}

/// The force that is set at a fault must not act when the next excitation begins.
static void test_force_of_a_fault_is_forgotten(void)
{
    to_force();
    g_cam.motion.u_push_q6 = 64 * largest_mn;
    g_cam.motion.dwell_ticks = patience; // the wave does not play yet
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_excite(m, 1, fade).err);
    for (int i = 0; i < 10; i++) {
        go_on(1, true);
        TEST_ASSERT_INT32_WITHIN(2, 0, rig.last.force_q6);
    }
    TEST_ASSERT_EQUAL_INT(cam_state_identifying, fixture_rig_state());
}

/// The force limit is that of the samples: a loop that pushes as well is cut at it.
static void test_force_limit_acts_on_the_sum(void)
{
    to_force_with(cam_param_servo_runaway_nm, 10000000);
    const int32_t limit_mn = m->params.servo_force_limit_mn;
    wave[0] = limit_mn;
    load_force();
    begin_force(2);
    rig.lathe.error_nm[hal_axis_u] = -20000; // the loop pushes towards plus
    TEST_ASSERT_EQUAL_INT32(64 * limit_mn, next_q6(true));
    TEST_ASSERT_TRUE(g_cam.force.servo.is_limited);
}

/// 1 N per ms are 50 mN per tick.
static void test_rate_of_the_force_acts(void)
{
    to_force_with(cam_param_servo_force_rate_n_per_ms, 1);
    begin_force(2);
    for (int32_t i = 0; i < 50; i++) { // samples of either sign in turn, far beyond it
        const int32_t last_q6 = rig.last.force_q6;
        TEST_ASSERT_EQUAL_INT32(50 * 64 * (i % 2 == 0 ? 1 : -1), next_q6(true) - last_q6);
    }
}

static void expect_refused(cam_err_t err, int32_t value)
{
    const cam_verdict_t v = cam_machine_excite(m, 1, fade);
    TEST_ASSERT_EQUAL_INT(err, v.err);
    TEST_ASSERT_EQUAL_INT32(value, v.value);
}

/// The unit is one of two, and a force needs its port.
static void test_wave_beyond_the_force_limit_or_out_of_the_stroke_is_refused(void)
{
    to_force();
    TEST_ASSERT_EQUAL_INT(cam_err_scope_range, set_unit(2));
    TEST_ASSERT_EQUAL_INT(cam_err_scope_range, set_unit(-1));
    TEST_ASSERT_EQUAL_INT32(1, field(cam_scope_field_wave_unit));
    TEST_ASSERT_EQUAL_INT(cam_ok, set_unit(0));
    hal_host.slow.force.quantum_un = 0;
    TEST_ASSERT_EQUAL_INT(cam_err_wave_unit, set_unit(1));
    TEST_ASSERT_EQUAL_INT(cam_ok, set_unit(0));
    TEST_ASSERT_EQUAL_INT32(0, field(cam_scope_field_wave_unit));
    hal_host.slow.force.quantum_un = 20000;
    TEST_ASSERT_EQUAL_INT(cam_ok, set_unit(1));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_wave_begin(m, sizeof wave)); // of an older tool
    TEST_ASSERT_EQUAL_INT32(0, field(cam_scope_field_wave_unit));
    const int32_t limit_mn = m->params.servo_force_limit_mn;
    wave[5] = -limit_mn - 1;
    load_force();
    expect_refused(cam_err_wave_force, limit_mn + 1);
    wave[5] = -limit_mn;
    load_force();
    const int32_t end_nm = m->params.u_stroke_nm / 2;
    set_field(cam_scope_field_place_nm, -end_nm - 1);
    expect_refused(cam_err_wave_stroke, -end_nm - 1);
    set_field(cam_scope_field_place_nm, -end_nm);
    expect_refused(cam_ok, 0); // whatever its speed and acceleration would be as nanometres
}

/// Half the clearance of X at the end of U's travel, wherever the wave plays; U may be as far off.
static void test_x_must_be_clear_of_all_of_us_travel(void)
{
    to_force();
    const cam_config_t *cfg = g_cam.config.in_use;
    const int32_t clear_nm = (int32_t)(cfg->play.x_clear_q10 / 1024) - m->params.x_clearance_nm / 2;
    const int32_t travel_nm = m->params.u_stroke_nm / 2 + cfg->guard.approach_nm;
    set_field(cam_scope_field_place_nm, -300000);
    g_cam.motion.axis[hal_axis_x].pos_q10 = (int64_t)(clear_nm + travel_nm - 1) * 1024;
    fixture_rig_ticks(&rig, 2);
    expect_refused(cam_err_wave_clear, clear_nm + travel_nm);
    g_cam.motion.axis[hal_axis_x].pos_q10 = (int64_t)(clear_nm + travel_nm) * 1024;
    fixture_rig_ticks(&rig, 2);
    expect_refused(cam_ok, 0);
    go_on(1, true);
    TEST_ASSERT_EQUAL_INT32(2 * travel_nm, g_cam.config.in_use->guard.following_nm);
}
