// SPDX-License-Identifier: Apache-2.0
// The lines of text for people, word for word, and when each of them is written.
#include "cam_remote_inner.h" // cam_log_text_t, cam_log_text_change, cam_log_text_params
#include "hal_host.h"
#include "unity.h"
#include <string.h> // memcpy

static cam_machine_t machine;
static cam_table_store_t store;
static cam_log_text_t lines;
static cam_status_t status;
static uint32_t n_seen; ///< lines

void setUp(void)
{
    hal_host_reset(20000);
    memset(&machine, 0, sizeof machine);
    machine.params = cam_param_defaults();
    machine.tick_hz = 20000;
    store = (cam_table_store_t){.machine = &machine};
    lines = (cam_log_text_t){.refused_ticks = 20000};
    status = (cam_status_t){0};
    n_seen = 0;
}

/// @return the newest line that was not yet asked for, "" for none; there must be no other one
static const char *line(void)
{
    const uint32_t n_new = hal_host.n_lines - n_seen;
    n_seen = hal_host.n_lines;
    TEST_ASSERT_LESS_OR_EQUAL_UINT32(1, n_new);
    return n_new == 1u ? hal_host.lines[(n_seen - 1u) % hal_host_lines] : "";
}

/// @return one of the last lines; 0 is the newest
static const char *line_before(uint32_t n)
{
    return hal_host.lines[(hal_host.n_lines - 1u - n) % hal_host_lines];
}

static const char *changed(void)
{
    cam_log_text_change(&lines, &store, &status);
    return line();
}

/// What has changed gives a line once.
static void expect_once(const char *text)
{
    TEST_ASSERT_EQUAL_STRING(text, changed());
    TEST_ASSERT_EQUAL_STRING("", changed());
}

static void test_start_has_its_reason(void)
{
    static const struct {
        hal_start_t start;
        const char *line;
    } cases[] = {
        {{.reset = hal_reset_power_on, .why = ""}, "start: power on"},
        {{.reset = (hal_reset_t)1, .why = ""}, "start: reset pin"},
        {{.reset = (hal_reset_t)2, .why = ""}, "start: software reset"},
        {{.reset = hal_reset_halt, .why = ""}, "start: halt"},
        {{.reset = hal_reset_watchdog, .why = ""}, "start: watchdog reset"},
        {{.reset = hal_reset_brown_out, .why = ""}, "start: brown-out reset"},
        {{.reset = hal_reset_halt, .why = "two plays"}, "start: halt: two plays"},
        {{.reset = hal_reset_watchdog, .why = "it broke before"},
         "start: watchdog reset: it broke before"},
        {{.reset = (hal_reset_t)6, .why = ""}, "start: unknown reset"},
    };
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        TEST_ASSERT_TRUE(i >= 6u || cases[i].start.reset == (hal_reset_t)i);
        cam_log_text_start(&cases[i].start);
        TEST_ASSERT_EQUAL_STRING(cases[i].line, line());
    }
}

/// As they were found, and one for each kind of kept ones that are not used.
static void test_parameters_have_their_lines(void)
{
    static const struct {
        cam_param_store_found_t kept;
        const char *lines[6]; // the newest first
    } cases[] = {
        {{.version = 4294967295u}, {"params: version 4294967295 in use"}},
        {{.version = 0, .is_torn = true},
         {"params: version 0 in use, what was to be saved after it is not whole"}},
        {{.version = 12,
          .n_retired = 64,
          .n_unknown = 1,
          .n_unfit = 20,
          .n_missing = 300,
          .unfit = cam_param_feed_nm,
          .missing = cam_param_k1_ns,
          .unknown = "colour"},
         {"params: 300 not among those kept, at default, first k1_ns",
          "params: 20 out of range and left at default, first feed_nm",
          "params: 1 unknown to this firmware and left out, first colour",
          "params: 64 retired and ignored", "params: version 12 in use"}},
        {{.version = 7, .n_missing = 1, .missing = cam_n_params}, // which has no name
         {"params: 1 not among those kept, at default, first ", "params: version 7 in use"}},
    };
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const uint32_t n_before = hal_host.n_lines;
        uint32_t n = 0;
        machine.kept = cases[i].kept;
        cam_log_text_params(&machine);
        for (; cases[i].lines[n] != NULL; n++) {
            TEST_ASSERT_EQUAL_STRING(cases[i].lines[n], line_before(n));
        }
        TEST_ASSERT_EQUAL_UINT32(n_before + n, hal_host.n_lines);
    }
    n_seen = hal_host.n_lines;
    machine.kept.err = cam_err_params_none;
    cam_log_text_params(&machine);
    TEST_ASSERT_NOT_NULL(strstr(line_before(0), " - defaults in use"));
    TEST_ASSERT_EQUAL_INT(0, strncmp("params: ", line(), 8));
}

/// Axes of which the port knows nothing are left out; where it knows none there is no line.
static void test_scales_have_lines_as_far_as_they_are_known(void)
{
    cam_log_text_scales(&machine);
    TEST_ASSERT_EQUAL_UINT32(0, hal_host.n_lines);
    hal_host.slow.scale[hal_axis_u] =
        (hal_axis_scale_t){.command_pm = 30590, .measured_pm = 100000};
    hal_host.slow.scale[hal_axis_z] =
        (hal_axis_scale_t){.command_pm = 50049, .most_um_per_s = 36000};
    cam_log_text_scales(&machine);
    TEST_ASSERT_EQUAL_UINT32(2, hal_host.n_lines);
    TEST_ASSERT_EQUAL_STRING("scales: U 30.5 nm, read to 100.0 nm; Z 50.0 nm up to 36000 um/s",
                             line_before(1));
    TEST_ASSERT_EQUAL_STRING("form error by the steps of the outputs: 0.015 um", line_before(0));
}

/// Half a step of U and X, in micrometres with three places; and of a table what a count costs.
static void test_form_error_is_in_micrometres(void)
{
    static const struct {
        uint32_t command_pm;
        const char *line;
    } cases[] = {{2000, "form error by the steps of the outputs: 0.001 um"},
                 {18000, "form error by the steps of the outputs: 0.009 um"},
                 {20000, "form error by the steps of the outputs: 0.010 um"},
                 {198000, "form error by the steps of the outputs: 0.099 um"},
                 {200000, "form error by the steps of the outputs: 0.100 um"},
                 {2000000, "form error by the steps of the outputs: 1.000 um"},
                 {24690000, "form error by the steps of the outputs: 12.345 um"}};
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        hal_host.slow.scale[hal_axis_x].command_pm = cases[i].command_pm;
        cam_log_text_scales(&machine);
        TEST_ASSERT_EQUAL_STRING(cases[i].line, line_before(0));
    }
    machine.has_table = true;
    machine.params.counts_per_turn = 10000;
    machine.table.u1_peak_nm_per_rad = 150000; // times 2 pi / 10000: 94.2 nm
    cam_log_text_scales(&machine);
    TEST_ASSERT_EQUAL_STRING("form error by the steps of the outputs: 12.345 um; a count of the "
                             "encoder is 94.2 nm of U",
                             line_before(0));
}

static void test_speed_at_which_counts_do_not_average_has_a_line(void)
{
    machine.params.observer_bandwidth_mHz = 100000;
    machine.table.spindle_mrpm = 3000000;
    cam_log_text_table(&lines, &store);
    TEST_ASSERT_EQUAL_UINT32(2, hal_host.n_lines);
    TEST_ASSERT_EQUAL_STRING(
        "counts: whole ones per tick at 3000 r/min do not average, better 2990 r/min",
        line_before(0));
    machine.params.spindle_mrpm = 2990000;
    cam_log_text_table(&lines, &store);
    TEST_ASSERT_EQUAL_UINT32(3, hal_host.n_lines);
}

/// With its name, or its error and what follows where there is no other. A table that the
/// background check has found damaged has a line once, and the store knows it.
static void test_table_has_a_line(void)
{
    char due[120] = "table: ";
    machine.has_table = true;
    strcpy(machine.table.name, "perkins240");
    cam_log_text_table(&lines, &store);
    TEST_ASSERT_EQUAL_STRING("table: perkins240 in use", line());
    TEST_ASSERT_TRUE(lines.has_table);
    store.err = cam_err_image_crc;
    strcat(due, cam_err_text(cam_err_image_crc));
    cam_log_text_table(&lines, &store);
    TEST_ASSERT_EQUAL_STRING(due, line());
    machine.has_table = false;
    cam_log_text_table(&lines, &store);
    TEST_ASSERT_EQUAL_STRING(strcat(due, " - home refused until a table is written"), line());
    TEST_ASSERT_FALSE(lines.has_table);
    store.err = cam_ok;
    lines.has_table = true;
    TEST_ASSERT_NOT_NULL(strstr(changed(), "home refused until a table is written"));
    TEST_ASSERT_EQUAL_INT(cam_err_image_crc, store.err);
    TEST_ASSERT_EQUAL_STRING("", changed());
    lines.has_table = true;
    store.err = cam_err_image_size;
    TEST_ASSERT_NOT_NULL(strstr(changed(), cam_err_text(cam_err_image_size)));
    TEST_ASSERT_EQUAL_INT(cam_err_image_size, store.err);
}

/// One line at a time: the state, then each fault once, as long as it lasts, the lowest bit first.
static void test_state_and_faults_have_lines_one_at_a_time(void)
{
    static const struct {
        cam_state_t state;
        uint32_t faults;
        const char *line;
    } steps[] = {
        {cam_state_fault, CAM_FAULT_BIT(estop) | CAM_FAULT_BIT(drive), "state fault"},
        {cam_state_fault, CAM_FAULT_BIT(estop) | CAM_FAULT_BIT(drive),
         "fault estop: emergency stop"},
        {cam_state_fault, CAM_FAULT_BIT(estop) | CAM_FAULT_BIT(drive),
         "fault drive: a drive is not ready"},
        {cam_state_fault, CAM_FAULT_BIT(estop) | CAM_FAULT_BIT(drive),
         "level: unlocked by the key switch"},
        {cam_state_fault, 0, ""},
        {cam_state_fault, CAM_FAULT_BIT(drive), "fault drive: a drive is not ready"},
        {cam_state_fault, CAM_FAULT_BIT(drive), ""},
        {cam_state_off, 0, "state off"},
    };
    machine.rights.level = cam_level_key; // waits for what is more urgent
    for (uint32_t i = 0; i < sizeof steps / sizeof steps[0]; i++) {
        status.state = steps[i].state;
        status.faults = steps[i].faults;
        TEST_ASSERT_EQUAL_STRING(steps[i].line, changed());
    }
}

/// What the index finds beside what is set, once in a fault of the encoder, at any edge after it.
static void test_counts_of_a_turn_explain_a_fault_of_the_encoder(void)
{
    static const struct {
        uint32_t faults;
        int32_t distance;
        const char *line;
    } steps[] = {
        {0, 4000, ""},
        {CAM_FAULT_BIT(lost_counts), 0, "fault lost_counts: "},
        {CAM_FAULT_BIT(lost_counts), 0, ""},
        {CAM_FAULT_BIT(lost_counts), 4096, ""},
        {CAM_FAULT_BIT(lost_counts), -4000,
         "encoder: 4000 counts between two index edges, "
         "counts_per_turn is 4096"},
        {CAM_FAULT_BIT(lost_counts), 4001, ""},
        {0, 4001, ""},
        {CAM_FAULT_BIT(index_missing), 1024, "fault index_missing: "},
        {CAM_FAULT_BIT(index_missing), 1024,
         "encoder: 1024 counts between two index edges, "
         "counts_per_turn is 4096"},
        {CAM_FAULT_BIT(estop), 1024, "fault estop: emergency stop"},
        {CAM_FAULT_BIT(estop), 1024, ""},
    };
    machine.params.counts_per_turn = 4096;
    for (uint32_t i = 0; i < sizeof steps / sizeof steps[0]; i++) {
        status.faults = steps[i].faults;
        status.edge_distance = steps[i].distance;
        const char *said = changed();
        const size_t n = strlen(steps[i].line);
        TEST_ASSERT_EQUAL_INT(0, strncmp(steps[i].line, said, n > 0u ? n : 1u));
    }
}

/// Before the first cut a loop that nobody measured is named.
static void test_loop_that_was_not_measured_has_a_line(void)
{
    static const struct {
        uint32_t quantum_un;
        int32_t is_measured;
        bool is_named;
    } cases[] = {{0, 0, false}, {20000, 1, false}, {20000, 0, true}};
    for (size_t i = 0; i < 3u; i++) {
        hal_host.slow.force.quantum_un = cases[i].quantum_un;
        machine.params.servo_measured = cases[i].is_measured;
        status.state = cam_state_off;
        (void)changed();
        TEST_ASSERT_EQUAL_STRING("", changed());
        status.state = cam_state_ready;
        TEST_ASSERT_EQUAL_STRING("state ready", changed());
        const bool is_named = strstr(changed(), "tools/tune --bus --apply") != NULL;
        TEST_ASSERT_EQUAL(cases[i].is_named, is_named);
        TEST_ASSERT_EQUAL_STRING("", changed());
    }
}

static void test_level_and_spindle_have_a_line_once(void)
{
    machine.rights.level = cam_level_key;
    expect_once("level: unlocked by the key switch");
    machine.rights.level = cam_level_locked;
    expect_once("level: locked");
    for (int i = 0; i < 2; i++) {
        machine.is_unsteady = true;
        expect_once("start ended: the spindle does not turn steadily, check its drive");
        machine.is_unsteady = false;
        TEST_ASSERT_EQUAL_STRING("", changed());
    }
}

/// A sender takes command, takes it over, gives it up, or is no longer heard.
static void test_command_has_a_line_once(void)
{
    static const struct {
        uint8_t commander;
        uint32_t n_take_overs, n_losses;
        const char *line;
    } steps[] = {
        {17, 0, 0, "command: taken by 17"},
        {250, 1, 0, "command: taken by 250 over from 17"},
        {0, 1, 0, "command: given up by 250"},
        {9, 1, 0, "command: taken by 9"},
        {0, 1, 1, "command: lost, nothing was heard of 9"},
        {9, 1, 1, "command: taken by 9"},
        {9, 2, 1, "command: taken by 9 over from 9"},
    };
    cam_rights_t *r = &machine.rights;
    for (uint32_t i = 0; i < sizeof steps / sizeof steps[0]; i++) {
        r->commander = steps[i].commander;
        r->n_take_overs = steps[i].n_take_overs;
        r->n_losses = steps[i].n_losses;
        expect_once(steps[i].line);
    }
    r->n_losses++; // and the same takes command at once
    TEST_ASSERT_EQUAL_STRING("command: lost, nothing was heard of 9", changed());
    expect_once("command: taken by 9");
    r->n_losses++; // or another does
    r->commander = 10;
    TEST_ASSERT_EQUAL_STRING("command: lost, nothing was heard of 9", changed());
    expect_once("command: taken by 10");
}

/// A sender that is refused again and again does not fill the text: one line in a second.
static void test_refused_senders_have_a_line_once_a_second(void)
{
    static const struct {
        uint32_t after_ticks;
        bool has_line;
    } cases[] = {{0, true}, {1, false}, {19999, false}, {20000, true}, {39999, false}};
    char due[120] = "refused: command 12 of 34: ";
    strcat(due, cam_err_text(cam_err_not_commander));
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const uint32_t now = UINT32_MAX - 100u + cases[i].after_ticks; // the ticks wrap
        cam_log_text_refused(&lines, 34, 12, cam_err_not_commander, now);
        TEST_ASSERT_EQUAL_STRING(cases[i].has_line ? due : "", line());
        TEST_ASSERT_EQUAL_UINT32(i + 1u, lines.n_refused);
    }
}
