// SPDX-License-Identifier: Apache-2.0
// Hours of machine time: an operator cuts part after part, bad luck disturbs him at random, and the
// judge of the fuzzing looks at every tick. Whatever happened, the next part must be possible.
//
//     hours TICK_HZ HOURS SEED [FIRST]   prints one JSON object; ends by abort() with what was
//                                        broken
//     hours RECORD                       short sessions, whose summed digest is compared with the
//                                        line "hours" of a record
// Sessions are numbered; with FIRST they begin there, so that one that broke is played again alone.
#include "cam_machine.h" // cam_machine_manual, cam_machine_hold
#include "fuzz_expect.h" // FUZZ_EXPECT
#include "fuzz_orders.h" // fuzz_disturb
#include "fuzz_rig.h"
#include "hal_host.h"
#include "sim_random.h"
#include <inttypes.h> // PRIu64
#include <stdio.h>    // printf

enum { patience_s = 60, poll_hz = 125 };
/// Bad luck that lasts until it is mended, or comes once with a number; and that of the axes.
enum { n_until_off = 7, n_of_fuzz = 9, n_bad_luck = 12 };

static const char *const bad_luck_names[n_bad_luck] = {
    "estop",        "drive",          "bus",
    "late_tick",    "encoder_stuck",  "index_dead",
    "spindle_held", "encoder_jump",   "spindle_wrong",
    "u_held",       "measured_wrong", "swing_and_x_held",
};

static sim_random_t dice;
static uint32_t session_s = 900;
static uint64_t n_left; // [ticks] of this session
static uint64_t digests;
static struct {
    uint64_t n_ticks, n_sessions, n_parts, n_stopped, n_manual, n_faults;
    uint64_t n_injected[n_bad_luck];
    uint64_t n_latched[cam_n_faults];
} sum;

static uint32_t any(uint32_t n)
{
    return (uint32_t)((sim_random_next(&dice) >> 32) % n);
}

static void note(cam_state_t before)
{
    const cam_state_t now = fuzz_rig_state();
    if (now != before && now == cam_state_fault) {
        sum.n_faults++;
        for (uint32_t i = 0; i < (uint32_t)cam_n_faults; i++) {
            sum.n_latched[i] += fuzz_rig.judge.faults >> i & 1u;
        }
    }
}

static void pass(void)
{
    const cam_state_t before = fuzz_rig_state();
    const uint32_t every = fuzz_rig.judge.tick_hz / (uint32_t)poll_hz + 1u;
    if (hal_host.n_ticks % every == 0u) {
        cam_machine_poll(&fuzz_rig.machine);
    }
    fuzz_rig_tick();
    note(before);
    sum.n_ticks++;
    n_left -= n_left > 0u ? 1u : 0u;
}

static void pass_ms(uint32_t ms)
{
    for (uint32_t i = 0; i < fuzz_rig.judge.tick_hz / 1000u * ms; i++) {
        pass();
    }
}

/// A feed of nothing would never end the cut. Asked again, since what comes too soon is refused.
static void set_right(void)
{
    fuzz_try(cam_machine_set_param(&fuzz_rig.machine, cam_param_feed_override_ppm, 1000000));
    fuzz_try(cam_machine_set_param(&fuzz_rig.machine, cam_param_spindle_override_ppm, 1000000));
    fuzz_try(cam_machine_set_param(&fuzz_rig.machine, cam_param_amplitude_ppm, 1000000));
}

/// Let pass until a state is reached, or the fault. An operator does not forget that he holds, and
/// a command that came too soon behind another is given again. @return whether it was reached
static bool wait_for(cam_state_t state)
{
    const uint32_t most = fuzz_rig.judge.tick_hz * (uint32_t)patience_s;
    uint32_t n = 0;
    while (fuzz_rig_state() != state && fuzz_rig_state() != cam_state_fault && n < most) {
        if (n % 64u == 63u) {
            set_right();
            fuzz_try(cam_machine_resume(&fuzz_rig.machine));
        }
        pass();
        n++;
    }
    FUZZ_EXPECT(n < most, "%s is not reached from %s in %d s", cam_state_name(state),
                cam_state_name(fuzz_rig_state()), (int)patience_s);
    return fuzz_rig_state() == state;
}

/// What of bad_luck_names fuzz_disturb() does; the others are the axes' own.
static const uint8_t disturbances[n_of_fuzz] = {
    fuzz_disturb_estop, fuzz_disturb_drive,  fuzz_disturb_bus,
    fuzz_disturb_late,  fuzz_disturb_stuck,  fuzz_disturb_no_index,
    fuzz_disturb_held,  fuzz_disturb_counts, fuzz_disturb_speed,
};

/// Half of the bad luck is that of U, if it takes forces.
static void strike(void)
{
    const bool is_of_u = fuzz_rig.lathe.mass_kg > 0.0 && any(2) == 0u;
    const uint32_t what = is_of_u ? n_of_fuzz + any(2) : any(n_bad_luck);
    sum.n_injected[what]++;
    if (what < (uint32_t)n_until_off) {
        fuzz_disturb(disturbances[what], (uint16_t)(0x8000u + any(0x8000u)));
    } else if (what < (uint32_t)n_of_fuzz) {
        const uint32_t most = disturbances[what] == fuzz_disturb_counts ? 4000 : 1747; // 4000 r/min
        fuzz_disturb(disturbances[what], (uint16_t)(any(2 * most) - most));
    } else if (what == (uint32_t)n_of_fuzz) {
        fuzz_rig.lathe.is_held[hal_axis_u] = true;
    } else if (what == (uint32_t)n_of_fuzz + 1u) {
        const uint32_t axis = is_of_u ? (uint32_t)hal_axis_u : any(hal_n_axes);
        fuzz_rig.lathe.error_nm[axis] = (int32_t)any(2000000) - 1000000;
    } else {
        fuzz_rig.lathe.is_swing_held = true;
        fuzz_rig.lathe.is_held[hal_axis_x] = true;
    }
}

static void mend(void)
{
    fuzz_disturb(fuzz_disturb_mend, 0);
}

/// An operator finds out what is wrong, has it mended and resets.
static void recover(void)
{
    const uint32_t most = fuzz_rig.judge.tick_hz * (uint32_t)patience_s;
    mend();
    pass_ms(100);
    for (uint32_t n = 0; fuzz_rig_state() == cam_state_fault; n++) {
        FUZZ_EXPECT(n < most, "faults %x are not reset", (unsigned)fuzz_rig.judge.faults);
        if (n % 64u == 0u) {
            fuzz_try(cam_machine_reset(&fuzz_rig.machine));
        }
        pass();
    }
}

/// A press of the button, as it is meant.
static void press(void)
{
    pass_ms(125);
    hal_host_press(true);
    pass_ms(80 + any(400));
    hal_host_press(false);
    pass_ms(125);
}

/// Corrections between and in cuts; what the firmware refuses stays as it was.
static void correct(void)
{
    static const struct {
        cam_param_id_t id;
        int32_t least;
        uint32_t range;
    } changes[] = {
        {cam_param_x_trim_nm, -20000, 40000},
        {cam_param_feed_override_ppm, 0, 1500000},
        {cam_param_spindle_override_ppm, 700000, 400000},
        {cam_param_phase_udeg, -2000000, 4000000},
        {cam_param_amplitude_ppm, 900000, 150000},
    };
    const uint32_t i = any(sizeof changes / sizeof changes[0]);
    const int32_t value = changes[i].least + (int32_t)any(changes[i].range);
    fuzz_try(cam_machine_set_param(&fuzz_rig.machine, changes[i].id, value));
}

/// One part, with what an operator does meanwhile, and in one of three cuts bad luck.
static void cut(void)
{
    cam_machine_t *m = &fuzz_rig.machine;
    if (cam_machine_start(m) != cam_ok) {
        set_right();
        pass_ms(20);
        return;
    }
    const uint32_t events = any(4);
    const bool is_struck = any(3) == 0u;
    bool is_stopped = false;
    for (uint32_t i = 0; i < events; i++) {
        pass_ms(any(200));
        if (any(4) != 0u) {
            correct();
        } else if (any(2) == 0u) {
            fuzz_try(cam_machine_hold(m));
            pass_ms(any(300));
            fuzz_try(cam_machine_resume(m));
        } else {
            is_stopped = true;
            fuzz_try(cam_machine_stop(m));
        }
    }
    if (is_struck) {
        pass_ms(any(400));
        strike();
        pass_ms(any(300));
        mend(); // unseen, or the fault is latched
    }
    set_right();
    if (wait_for(cam_state_ready)) {
        sum.n_stopped += is_stopped ? 1u : 0u;
        sum.n_parts += is_stopped ? 0u : 1u;
    }
}

/// Some minutes by hand.
static void by_hand(void)
{
    cam_machine_t *m = &fuzz_rig.machine;
    if (cam_machine_manual(m) != cam_ok) {
        return;
    }
    pass_ms(10);
    for (uint32_t i = any(6); i > 0u && fuzz_rig_state() == cam_state_manual; i--) {
        (void)cam_machine_jog(m, (hal_axis_t)any(hal_n_axes), (int32_t)any(2000) - 1000);
        fuzz_rig.judge.n_alone = 0;
        for (uint32_t k = any(8); k > 0u; k--) {
            cam_machine_keep_alive(m);
            fuzz_rig.judge.n_alone = 0;
            pass_ms(20);
        }
    }
    sum.n_manual++;
    if (any(8) == 0u) {
        strike();
        pass_ms(200);
    }
    mend();
    fuzz_try(cam_machine_disable(m));
    (void)wait_for(cam_state_off);
}

/// What an operator does next in this state.
static void go_on(void)
{
    switch (fuzz_rig_state()) {
    case cam_state_fault:
        recover();
        break;
    case cam_state_off:
        mend();
        hal_host.in.axis_nm[hal_axis_u] = 0; // outside of its stroke it is pushed back by hand
        fuzz_rig.lathe.u_nm = 0.0;
        press();
        if (any(12) == 0u) {
            by_hand();
            break;
        }
        if (cam_machine_enable(&fuzz_rig.machine) == cam_ok) {
            pass_ms(10);
            (void)wait_for(cam_state_ready);
            pass_ms(700); // the spindle runs up
        }
        break;
    case cam_state_ready:
        if (any(40) == 0u) {
            strike();
            pass_ms(100);
            mend(); // a spindle that somebody turns slowly is seen by nobody, and a cut would last
        } else if (any(60) == 0u) {
            fuzz_try(cam_machine_disable(&fuzz_rig.machine));
            (void)wait_for(cam_state_off);
        } else {
            cut();
        }
        break;
    default:
        (void)wait_for(cam_state_ready);
        break;
    }
}

/// Set a parameter, and let the interrupt take it. @return the answer
static cam_err_t set(cam_param_id_t id, int32_t value)
{
    const cam_err_t err = cam_machine_set_param(&fuzz_rig.machine, id, value);
    fuzz_try(err);
    pass_ms(1);
    return err;
}

static void set_surely(cam_param_id_t id, int32_t value)
{
    const cam_err_t err = set(id, value);
    FUZZ_EXPECT(err == cam_ok, "%s: %s", cam_param_info(id)->name, cam_err_text(err));
}

/// A voice coil with a moving mass, whose force acts without a delay but the hold of a tick; the
/// loop's corners are those of 20 kHz, in proportion.
static void take_forces(uint32_t hz)
{
    set_surely(cam_param_servo_runaway_nm, 0);
    set_surely(cam_param_servo_force_delay_ns, (int32_t)(500000000u / hz));
    set_surely(cam_param_servo_pole_hz, (int32_t)(hz / 5u));
    set_surely(cam_param_servo_crossover_hz, (int32_t)(hz / 47u));
    set_surely(cam_param_servo_integral_mHz, (int32_t)(hz * 2u));
    fuzz_rig.lathe.mass_kg = fuzz_rig.machine.params.servo_mass_g / 1e3;
}

/// A drive of U that lags otherwise than the parameters state, of which a rehearsal learns.
static void learn(void)
{
    static cam_params_t drive;
    hal_host.slow.measures_u = true;
    set_surely(cam_param_learn_harmonics, 1 + (int32_t)any(12));
    set_surely(cam_param_ripple_turns, (int32_t)any(6));
    set_surely(cam_param_rehearse_turns, 2 + (int32_t)any(40));
    drive = fuzz_rig.machine.params;
    drive.k1_ns += (int32_t)any(100000);
    drive.k2_us2 += (int32_t)any(2000);
    fuzz_rig.lathe.lags_as = &drive;
    fuzz_rig.judge.is_wild = true;
}

/// What differs from builder to builder; what cannot be cut stays as it was.
static void set_up(void)
{
    static const struct {
        cam_param_id_t id;
        int32_t least, most;
    } ranges[] = {{cam_param_engage_turns, 1, 9},
                  {cam_param_disengage_turns, 1, 9},
                  {cam_param_feed_ramp_turns, 1, 9},
                  {cam_param_x_clearance_nm, 200000, 2000000},
                  {cam_param_observer_bandwidth_mHz, 40000, 400000},
                  {cam_param_phase_rate_udeg_per_s, 100000, 9000000},
                  {cam_param_amplitude_rate_ppm_per_s, 20000, 900000},
                  {cam_param_x_trim_rate_nm_per_s, 10000, 900000},
                  {cam_param_feed_nm, 80000, 160000}};
    cam_machine_t *m = &fuzz_rig.machine;
    for (uint32_t n = any(4); n > 0u; n--) {
        const uint32_t i = any(sizeof ranges / sizeof ranges[0]);
        const int32_t before = cam_param_get(&m->params, ranges[i].id);
        const int32_t value =
            ranges[i].least + (int32_t)any((uint32_t)(ranges[i].most - ranges[i].least));
        (void)set(ranges[i].id, value);
        if (cam_machine_feasibility(m).err != cam_ok) {
            set_surely(ranges[i].id, before);
        }
    }
}

/// Kinds of sessions; forces only where a loop is fast enough for the cut.
enum { as_configured, learning, by_force, n_kinds };
static const char *const kinds[n_kinds] = {"", ", learning", ", forces"};

static void session(uint32_t hz, uint32_t number, uint64_t seed)
{
    const uint32_t part = number % (uint32_t)fuzz_rig_n_parts;
    const uint32_t drawn = number / (uint32_t)fuzz_rig_n_parts % (uint32_t)n_kinds;
    const uint32_t kind = drawn == (uint32_t)by_force && hz < 5000u ? as_configured : drawn;
    (void)printf("session %" PRIu64 ": %u Hz, part %u, seed %" PRIu64 "%s\n", sum.n_sessions,
                 (unsigned)hz, (unsigned)part, seed, kinds[kind]);
    (void)fflush(stdout);
    dice = sim_random_seeded(seed);
    fuzz_rig_start((fuzz_start_t){.tick_hz = hz,
                                  .part = part,
                                  .has_button = true,
                                  .takes_force = kind == (uint32_t)by_force,
                                  .state = cam_state_off});
    set_up();
    if (kind == (uint32_t)by_force) {
        take_forces(hz);
    } else if (kind == (uint32_t)learning) {
        learn();
    }
    if (part != 1u) { // what the default machine's spindle can do
        fuzz_rig.lathe.ramp_rpm = 4000.0 / hz;
    }
    const uint64_t parts_before = sum.n_parts;
    n_left = (uint64_t)hz * session_s;
    while (n_left > 0u) {
        const uint64_t before = sum.n_ticks;
        go_on();
        if (sum.n_ticks == before) {
            pass();
        }
    }
    FUZZ_EXPECT(session_s < patience_s || sum.n_parts > parts_before, "no part was cut in %u s",
                (unsigned)session_s);
    for (uint32_t k = 0; k < cam_ilc_n_values; k++) {
        fuzz_note(cam_ilc_get(&fuzz_rig.machine.ilc, k));
    }
    digests += fuzz_digest();
    (void)printf("    %016" PRIx64 "\n", fuzz_digest());
    sum.n_sessions++;
}

static void report(uint32_t hz)
{
    (void)printf("{\"ticks\": %" PRIu64 ", \"hours\": %.3f, \"sessions\": %" PRIu64
                 ", \"parts\": %" PRIu64 ", \"stopped\": %" PRIu64 ", \"by_hand\": %" PRIu64
                 ", \"faults\": %" PRIu64,
                 sum.n_ticks, (double)sum.n_ticks / hz / 3600.0, sum.n_sessions, sum.n_parts,
                 sum.n_stopped, sum.n_manual, sum.n_faults);
    for (uint32_t i = 0; i < (uint32_t)n_bad_luck; i++) {
        (void)printf(", \"injected_%s\": %" PRIu64, bad_luck_names[i], sum.n_injected[i]);
    }
    for (uint32_t i = 0; i < (uint32_t)cam_n_faults; i++) {
        (void)printf(", \"latched_%s\": %" PRIu64, cam_fault_name((cam_fault_t)i),
                     sum.n_latched[i]);
    }
    (void)printf("}\n");
}

static void play(uint32_t hz, double hours, uint64_t seed, uint32_t first)
{
    const uint64_t n_ticks = sum.n_ticks + (uint64_t)(hours * 3600.0 * hz);
    for (uint32_t i = first; sum.n_ticks < n_ticks; i++) {
        session(hz, i, seed * 1000u + i);
    }
}

/// Short sessions of all kinds. @return whether they are as recorded
static bool are_recorded(const char *path)
{
    session_s = 8;
    play(1000, 0.2, 1, 0);
    play(5000, 0.2, 1, 0);
    play(20000, 0.02, 1, 0);
    return fuzz_digest_is_recorded(path, "hours", digests);
}

int main(int argc, char **argv)
{
    unsigned hz;
    double hours;
    uint64_t seed;
    uint32_t first = 0;
    if (argc == 2) {
        return are_recorded(argv[1]) ? 0 : 1;
    }
    if ((argc != 4 && (argc != 5 || sscanf(argv[4], "%" SCNu32, &first) != 1)) ||
        sscanf(argv[1], "%u", &hz) != 1 || sscanf(argv[2], "%lf", &hours) != 1 ||
        sscanf(argv[3], "%" SCNu64, &seed) != 1 ||
        (hz != 1000u && hz != 2000u && hz != 5000u && hz != 20000u)) {
        (void)fprintf(stderr, "usage: hours 1000|2000|5000|20000 HOURS SEED [FIRST SESSION]\n"
                              "       hours RECORD\n");
        return 2;
    }
    play(hz, hours, seed, first);
    report(hz);
    return 0;
}
