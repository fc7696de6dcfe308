// SPDX-License-Identifier: Apache-2.0
// The lines of text for people, word for word, and when each of them is written.
#include "cam_log_text.h"
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

/// @return the line that says of n lines at once which one it was, counted from the newest
static const char *line_before(uint32_t n)
{
    return hal_host.lines[(hal_host.n_lines - 1u - n) % hal_host_lines];
}

static const char *changed(void)
{
    cam_log_text_change(&lines, &store, &status);
    return line();
}

static void test_start_is_told_with_its_reason(void)
{
    static const char *const reasons[] = {"power on", "reset pin",      "software reset",
                                          "halt",     "watchdog reset", "brown-out reset"};
    char due[80];
    for (uint32_t i = 0; i < 6u; i++) {
        const hal_start_t start = {.reset = (hal_reset_t)i, .why = ""};
        cam_log_text_start(&start);
        strcpy(due, "start: ");
        TEST_ASSERT_EQUAL_STRING(strcat(due, reasons[i]), line());
    }
    const hal_start_t halted = {.reset = hal_reset_halt, .why = "two plays"};
    cam_log_text_start(&halted);
    TEST_ASSERT_EQUAL_STRING("start: halt: two plays", line());
    const hal_start_t bitten = {.reset = hal_reset_watchdog, .why = "it broke before"};
    cam_log_text_start(&bitten);
    TEST_ASSERT_EQUAL_STRING("start: watchdog reset: it broke before", line());
    const hal_start_t other = {.reset = (hal_reset_t)6, .why = ""};
    cam_log_text_start(&other);
    TEST_ASSERT_EQUAL_STRING("start: unknown reset", line());
}

static void test_parameters_are_told_as_they_were_found(void)
{
    machine.kept = (cam_param_store_found_t){.version = 4294967295u};
    cam_log_text_params(&machine);
    TEST_ASSERT_EQUAL_STRING("params: version 4294967295 in use", line());
    machine.kept = (cam_param_store_found_t){.version = 0, .is_torn = true};
    cam_log_text_params(&machine);
    TEST_ASSERT_EQUAL_STRING("params: version 0 in use, what was to be saved after it is not whole",
                             line());
    machine.kept.err = cam_err_params_none;
    cam_log_text_params(&machine);
    TEST_ASSERT_NOT_NULL(strstr(line_before(0), " - defaults in use"));
    TEST_ASSERT_EQUAL_INT(0, strncmp("params: ", line(), 8));
}

/// What of the kept ones is not used as it is has a line for each kind, and only where there is
/// one.
static void test_parameters_that_are_not_used_are_told(void)
{
    machine.kept = (cam_param_store_found_t){.version = 12,
                                             .n_unknown = 1,
                                             .n_unfit = 20,
                                             .n_missing = 300,
                                             .unfit = cam_param_feed_nm,
                                             .missing = cam_param_k1_ns,
                                             .unknown = "colour"};
    cam_log_text_params(&machine);
    TEST_ASSERT_EQUAL_UINT32(4, hal_host.n_lines);
    TEST_ASSERT_EQUAL_STRING("params: version 12 in use", line_before(3));
    TEST_ASSERT_EQUAL_STRING("params: 1 unknown to this firmware and left out, first colour",
                             line_before(2));
    TEST_ASSERT_EQUAL_STRING("params: 20 out of range and left at default, first feed_nm",
                             line_before(1));
    TEST_ASSERT_EQUAL_STRING("params: 300 not among those kept, at default, first k1_ns",
                             line_before(0));
    machine.kept.n_unknown = 0;
    machine.kept.n_missing = 1;
    machine.kept.missing = cam_n_params; // which has no name
    cam_log_text_params(&machine);
    TEST_ASSERT_EQUAL_UINT32(7, hal_host.n_lines);
    TEST_ASSERT_EQUAL_STRING("params: 1 not among those kept, at default, first ", line_before(0));
}

/// Axes of which the port knows nothing are left out; where it knows none there is no line.
static void test_scales_are_told_as_far_as_they_are_known(void)
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
static void test_form_error_is_told_in_micrometres(void)
{
    static const struct {
        uint32_t command_pm;
        const char *text;
    } cases[] = {{2000, "0.001 um"},     {18000, "0.009 um"},  {20000, "0.010 um"},
                 {198000, "0.099 um"},   {200000, "0.100 um"}, {2000000, "1.000 um"},
                 {24690000, "12.345 um"}};
    char due[100];
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        hal_host.slow.scale[hal_axis_x].command_pm = cases[i].command_pm;
        cam_log_text_scales(&machine);
        strcpy(due, "form error by the steps of the outputs: ");
        TEST_ASSERT_EQUAL_STRING(strcat(due, cases[i].text), line_before(0));
    }
    machine.has_table = true;
    machine.params.counts_per_turn = 10000;
    machine.table.u1_peak_nm_per_rad = 150000; // times 2 pi / 10000: 94.2 nm
    cam_log_text_scales(&machine);
    TEST_ASSERT_EQUAL_STRING("form error by the steps of the outputs: 12.345 um; a count of the "
                             "encoder is 94.2 nm of U",
                             line_before(0));
}

static void test_table_is_told_with_whose_it_is(void)
{
    static const uint8_t key[32];
    static const uint8_t id[8] = {0x01, 0x23, 0x45, 0x67, 0x89, 0xAB, 0xCD, 0xEF};
    machine.has_table = true;
    strcpy(machine.table.name, "perkins240");
    cam_log_text_table(&lines, &store);
    TEST_ASSERT_EQUAL_STRING("table: perkins240 in use", line());
    TEST_ASSERT_TRUE(lines.has_table);
    hal_host.slow.trust = (hal_trust_t){.keys = key, .n_keys = 1};
    cam_log_text_table(&lines, &store);
    TEST_ASSERT_EQUAL_STRING("table: perkins240 in use, not signed", line());
    memcpy(machine.signature.key_id, id, sizeof id);
    machine.signature.kind = cam_signature_check_signed;
    cam_log_text_table(&lines, &store);
    TEST_ASSERT_EQUAL_STRING("table: perkins240 in use, signed by key 0123456789abcdef", line());
    machine.signature.kind = cam_signature_check_unchecked;
    cam_log_text_table(&lines, &store);
    TEST_ASSERT_EQUAL_STRING(
        "table: perkins240 in use, signature not checked, it names key 0123456789abcdef", line());
}

/// A table that is refused is told with its error, and with what follows where there is no other.
static void test_speed_at_which_counts_do_not_average_is_told(void)
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

static void test_refused_table_is_told(void)
{
    char due[120] = "table: ";
    store.err = cam_err_image_crc;
    strcat(due, cam_err_text(cam_err_image_crc));
    machine.has_table = true;
    cam_log_text_table(&lines, &store);
    TEST_ASSERT_EQUAL_STRING(due, line());
    machine.has_table = false;
    cam_log_text_table(&lines, &store);
    TEST_ASSERT_EQUAL_STRING(strcat(due, " - home refused until a table is written"), line());
    TEST_ASSERT_FALSE(lines.has_table);
}

/// A table that the background check has found damaged is told once, and the store knows it.
static void test_damaged_table_is_told_once(void)
{
    lines.has_table = true;
    TEST_ASSERT_NOT_NULL(strstr(changed(), "home refused until a table is written"));
    TEST_ASSERT_EQUAL_INT(cam_err_image_crc, store.err);
    TEST_ASSERT_EQUAL_STRING("", changed());
    lines.has_table = true;
    store.err = cam_err_image_size;
    TEST_ASSERT_NOT_NULL(strstr(changed(), cam_err_text(cam_err_image_size)));
    TEST_ASSERT_EQUAL_INT(cam_err_image_size, store.err);
}

/// One line at a time: the state, then each fault once, as long as it lasts.
static void test_state_and_faults_are_told_one_at_a_time(void)
{
    char due[120] = "fault estop: ";
    status.state = cam_state_fault;
    status.faults = CAM_FAULT_BIT(estop) | CAM_FAULT_BIT(bus);
    TEST_ASSERT_EQUAL_STRING("state fault", changed());
    const bool is_estop_first = cam_fault_estop < cam_fault_bus;
    const cam_fault_t order[] = {is_estop_first ? cam_fault_estop : cam_fault_bus,
                                 is_estop_first ? cam_fault_bus : cam_fault_estop};
    for (int i = 0; i < 2; i++) {
        strcpy(due, "fault ");
        strcat(strcat(due, cam_fault_name(order[i])), ": ");
        TEST_ASSERT_EQUAL_STRING(strcat(due, cam_fault_text(order[i])), changed());
    }
    TEST_ASSERT_EQUAL_STRING("", changed());
    status.faults = 0;
    TEST_ASSERT_EQUAL_STRING("", changed());
    status.faults = CAM_FAULT_BIT(bus);
    TEST_ASSERT_EQUAL_INT(0, strncmp("fault bus: ", changed(), 11));
    TEST_ASSERT_EQUAL_STRING("", changed());
}

/// Who takes command, from whom, who gives it up and who is no longer heard, each once.
static void test_start_without_a_steady_spindle_is_told_once(void)
{
    for (int i = 0; i < 2; i++) {
        machine.is_unsteady = true;
        TEST_ASSERT_EQUAL_STRING("start ended: the spindle does not turn steadily, check its drive",
                                 changed());
        TEST_ASSERT_EQUAL_STRING("", changed());
        machine.is_unsteady = false;
        TEST_ASSERT_EQUAL_STRING("", changed());
    }
}

static void test_command_is_told(void)
{
    cam_rights_t *r = &machine.rights;
    r->commander = 17;
    TEST_ASSERT_EQUAL_STRING("command: taken by 17", changed());
    TEST_ASSERT_EQUAL_STRING("", changed());
    r->commander = 250;
    r->n_take_overs++;
    TEST_ASSERT_EQUAL_STRING("command: taken by 250 over from 17", changed());
    TEST_ASSERT_EQUAL_STRING("", changed());
    r->commander = 0;
    TEST_ASSERT_EQUAL_STRING("command: given up by 250", changed());
    TEST_ASSERT_EQUAL_STRING("", changed());
    r->commander = 9;
    (void)changed();
    r->commander = 0;
    r->n_losses++;
    TEST_ASSERT_EQUAL_STRING("command: lost, nothing was heard of 9", changed());
    TEST_ASSERT_EQUAL_STRING("", changed());
}

/// Who takes it right after a loss, before the loss is told, is told in a line of his own.
static void test_commander_behind_a_loss_is_told_next(void)
{
    cam_rights_t *r = &machine.rights;
    r->commander = 9;
    (void)changed();
    r->n_losses++;
    r->commander = 10;
    TEST_ASSERT_EQUAL_STRING("command: lost, nothing was heard of 9", changed());
    TEST_ASSERT_EQUAL_STRING("command: taken by 10", changed());
    TEST_ASSERT_EQUAL_STRING("", changed());
    r->n_take_overs++; // by the same one
    TEST_ASSERT_EQUAL_STRING("command: taken by 10 over from 10", changed());
    TEST_ASSERT_EQUAL_STRING("", changed());
}

static void test_level_is_told_once(void)
{
    static const char *const texts[] = {"level: unlocked by the key switch",
                                        "level: unlocked by the secret", "level: locked"};
    static const cam_level_t levels[] = {cam_level_key, cam_level_challenge, cam_level_locked};
    for (int i = 0; i < 3; i++) {
        machine.rights.level = levels[i];
        TEST_ASSERT_EQUAL_STRING(texts[i], changed());
        TEST_ASSERT_EQUAL_STRING("", changed());
    }
}

/// A sender that is refused again and again does not fill the text: one line in a second.
static void test_refused_senders_are_told_once_a_second(void)
{
    char due[120] = "refused: command 12 of 34: ";
    strcat(due, cam_err_text(cam_err_not_commander));
    const uint32_t begin = UINT32_MAX - 100u; // the ticks wrap
    cam_log_text_refused(&lines, 34, 12, cam_err_not_commander, begin);
    TEST_ASSERT_EQUAL_STRING(due, line());
    cam_log_text_refused(&lines, 34, 12, cam_err_not_commander, begin + 1u);
    cam_log_text_refused(&lines, 34, 12, cam_err_not_commander, begin + 19999u);
    TEST_ASSERT_EQUAL_STRING("", line());
    TEST_ASSERT_EQUAL_UINT32(3, lines.n_refused);
    cam_log_text_refused(&lines, 34, 12, cam_err_not_commander, begin + 20000u);
    TEST_ASSERT_EQUAL_STRING(due, line());
    cam_log_text_refused(&lines, 34, 12, cam_err_not_commander, begin + 39999u);
    TEST_ASSERT_EQUAL_STRING("", line());
}
