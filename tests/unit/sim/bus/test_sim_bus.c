// SPDX-License-Identifier: Apache-2.0
#include "canopen.h" // common_get_u32
#include "sim_config.h"
#include "sim_bus.h"
#include "sim_units.h" // sim_abs
#include "unity.h"

#define X_NM 60e6
#define Z_NM (-2e6)
#define U_BRAKE_NM_PER_S2 250e9

static sim_bus_t bus;
static sim_bus_config_t config;

void setUp(void)
{
    config = (sim_bus_config_t){
        .lathe = sim_config_defaults().lathe, .guard_s = 0.02, .heartbeat_s = 0.05, .seed = 1};
    config.lathe.tick_hz = 1000.0;
    config.lathe.spindle.ripple = 0.0;
    sim_bus_init(&bus, &config, X_NM, Z_NM);
}

static void send(uint32_t id, uint32_t control_word, int32_t target)
{
    sim_frame_t frame = {.id = id};
    sim_frame_put(&frame, control_word, 2);
    sim_frame_put(&frame, (uint32_t)target, 4);
    sim_bus_receive(&bus, &frame);
}

/// Run one tick of a controller that commands positions of the axes and a speed.
static void tick(uint32_t control_word, int32_t u_nm, int32_t spindle_mrpm)
{
    send(0x202, control_word, u_nm);
    send(0x203, control_word, (int32_t)X_NM);
    send(0x204, control_word, (int32_t)Z_NM);
    send(0x205, control_word, spindle_mrpm);
    sim_bus_receive(&bus, &(sim_frame_t){.id = 0x080});
    sim_bus_step(&bus);
}

static void enable(void)
{
    sim_bus_receive(&bus, &(sim_frame_t){.n = 2, .data = {1, 0}}); // start all nodes
    sim_bus_step(&bus);
    tick(0x06, 0, 0);
    tick(0x07, 0, 0);
    tick(0x0F, 0, 0);
}

static const sim_frame_t *said(uint32_t id)
{
    for (uint32_t i = 0; i < bus.out.n; i++) {
        if (bus.out.frame[i].id == id) {
            return &bus.out.frame[i];
        }
    }
    return NULL;
}

static void test_axis_moves_as_in_a_run_with_the_same_commands(void)
{
    sim_drive_t reference;
    sim_drive_init(&reference, &config.lathe.drive[0], 0.0, 1e-3);
    enable();
    for (int i = 0; i < 50; i++) { // commands of the tick act from the SYNC on
        const int32_t target = i < 20 ? 20000 : -30000;
        tick(0x0F, target, 0);
        TEST_ASSERT_DOUBLE_WITHIN(1.0, reference.pos_micro, bus.sample.u_nm);
        sim_drive_step(&reference, target, true);
    }
}

/// Run ticks of a spindle at 300 r/min.
static void turn(int n)
{
    for (int i = 0; i < n; i++) {
        tick(0x0F, 0, 300000);
    }
}

/// It speaks of the middle between two ticks.
static void test_encoder_counts_and_wraps_at_its_modulus(void)
{
    enable();
    turn(2000);
    const double middle = bus.sample.turn + 5.0 * 0.5e-3;
    const uint32_t counts =
        (uint32_t)(uint64_t)(config.lathe.encoder.start_counts + middle * 10000.0);
    TEST_ASSERT_INT32_WITHIN(1, counts, common_get_u32(said(0x181)->data));
    config.encoder_modulus = 10000;
    sim_bus_init(&bus, &config, X_NM, Z_NM);
    enable();
    uint32_t largest = 0;
    for (int i = 0; i < 1500; i++) {
        turn(1);
        const uint32_t now = common_get_u32(said(0x181)->data);
        largest = now > largest ? now : largest;
    }
    TEST_ASSERT_GREATER_THAN_UINT32(9900, largest);
    TEST_ASSERT_LESS_THAN_UINT32(10000, largest);
}

static void test_index_is_foreseen_once_per_turn_at_its_place(void)
{
    int n = 0;
    enable();
    turn(1000);
    for (int i = 0; i < 3000; i++) {
        turn(1);
        if (bus.index_s >= 0.0) {
            const double at = bus.lathe.spindle.turn + bus.index_s * 5.0;
            const double place = sim_fraction(at - config.lathe.encoder.index_turn + 0.5) - 0.5;
            TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.0, place);
            n++;
        }
    }
    TEST_ASSERT_INT_WITHIN(1, 15, n);
}

static void test_silence_brakes_within_the_limits_and_ends_in_fault(void)
{
    enable();
    for (int i = 0; i < 5; i++) {
        tick(0x0F, 20000 * i, 0);
    }
    double last = bus.lathe.drive[0].vel_micro_per_s;
    TEST_ASSERT_TRUE(last > 1e6);
    int n = 0;
    while (bus.node[sim_bus_u].power.state != cia402_fault) {
        sim_bus_step(&bus);
        if (bus.node[sim_bus_u].power.state != cia402_operation_enabled) {
            const double change = sim_abs(bus.lathe.drive[0].vel_micro_per_s - last);
            TEST_ASSERT_TRUE(change <= U_BRAKE_NM_PER_S2 * 1e-3 * 1.0001);
        }
        last = bus.lathe.drive[0].vel_micro_per_s;
        TEST_ASSERT_LESS_THAN_INT(25, ++n);
    }
    TEST_ASSERT_GREATER_THAN_INT(19, n);
    TEST_ASSERT_FALSE(bus.inputs.is_ready);
    TEST_ASSERT_TRUE(sim_bus_is_at_rest(&bus));
}

static void test_foreign_drive_is_followed_by_its_own_word(void)
{
    config.is_foreign[sim_bus_u] = true;
    sim_bus_init(&bus, &config, X_NM, Z_NM);
    enable();
    send(0x182, 0x1237, 4711);
    tick(0x0F, 0, 0);
    TEST_ASSERT_EQUAL_DOUBLE(4711.0, bus.sample.u_nm);
    TEST_ASSERT_NULL(said(0x182));
    TEST_ASSERT_TRUE(bus.inputs.is_ready);
}

static void inject(const char *text)
{
    sim_inject_t what;
    common_error_t e;
    TEST_ASSERT_TRUE_MESSAGE(sim_inject_parse(&what, text, sim_inject_on_bus, &e), e.text);
    sim_bus_inject(&bus, &what, 1);
    tick(0x0F, 0, 0);
}

static void test_failed_drive_reports_by_emergency_status_and_line(void)
{
    enable();
    inject("node-fault@0:3");
    TEST_ASSERT_EQUAL_HEX32(sim_emcy_internal, common_get_u16(said(0x083)->data));
    TEST_ASSERT_FALSE(bus.inputs.is_ready);
    tick(0x0F, 0, 0);
    TEST_ASSERT_EQUAL_HEX32(0x08, common_get_u16(said(0x183)->data) & 0x4Fu);
}

/// One tick after each injection.
static void test_injections_reach_their_part(void)
{
    static const struct {
        const char *text;
        sim_disturb_kind_t kind;
        uint32_t n_left;
        double late_s;
    } rows[] = {{"encoder-missing@0:3", sim_disturb_missing, 2, 0.0},
                {"encoder-repeated@0:3", sim_disturb_repeated, 2, 0.0},
                {"encoder-swapped@0:3", sim_disturb_swapped, 3, 0.0}, // no pair yet
                {"encoder-late@0:300", sim_disturb_late, 0, 300e-6}};
    for (uint32_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        setUp();
        enable();
        inject(rows[i].text);
        TEST_ASSERT_EQUAL_INT_MESSAGE(rows[i].kind, bus.disturb.kind, rows[i].text);
        TEST_ASSERT_EQUAL_UINT32_MESSAGE(rows[i].n_left, bus.disturb.n_left, rows[i].text);
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, rows[i].late_s, bus.disturb.late_s);
        TEST_ASSERT_EQUAL(rows[i].kind == sim_disturb_repeated, said(0x181) != NULL);
    }
    TEST_ASSERT_TRUE(bus.inputs.is_ready && !bus.inputs.is_estop);
    inject("drive@0");
    inject("estop@0");
    TEST_ASSERT_TRUE(!bus.inputs.is_ready && bus.inputs.is_estop);
    inject("heartbeat-lost@0:4");
    inject("node-dead@0:5");
    TEST_ASSERT_TRUE(bus.node[3].is_heartbeat_broken && !bus.node[3].is_dead);
    TEST_ASSERT_TRUE(bus.node[4].is_dead && !bus.node[4].is_heartbeat_broken);
}

static void test_status_of_the_controller_is_remembered(void)
{
    const sim_frame_t status = {.id = 0x1C0, .n = 8, .data = {3, 0, 0, 0, 0x10}};
    sim_bus_receive(&bus, &status);
    TEST_ASSERT_EQUAL_UINT32(3, bus.reported_state);
    TEST_ASSERT_EQUAL_HEX32(0x10, bus.reported_faults);
}
