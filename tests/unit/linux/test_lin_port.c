// SPDX-License-Identifier: Apache-2.0
// Small parts of the Linux port: due times, places of lines, the phases of the end, the reason of a
// halt.
#include "hal/hal.h"
#include "lin_disk_bench.h"
#include "lin_setup.h"
#include "lin_tick.h"
#include <errno.h> // EBUSY

void setUp(void)
{
    disk_begin();
}

static void test_due_times_do_not_drift(void)
{
    static const int64_t rates[] = {500, 1000, 3000, 3333, 4000};
    for (uint32_t i = 0; i < sizeof rates / sizeof rates[0]; i++) {
        int64_t at = INT64_C(86400000000000); // a day
        for (int64_t k = 1; k <= 2 * rates[i]; k++) {
            const int64_t next = lin_period_next(at, rates[i]);
            TEST_ASSERT_TRUE(next > at);
            TEST_ASSERT_EQUAL_INT64(INT64_C(86400000000000) + k * INT64_C(1000000000) / rates[i],
                                    next);
            TEST_ASSERT_EQUAL_UINT32(0, lin_period_missed(at, next, rates[i]));
            at = next;
        }
    }
}

static void test_missed_ticks_are_counted(void)
{
    const int64_t at = INT64_C(1000000000);
    TEST_ASSERT_EQUAL_INT64(at + 1000000, lin_period_next(at, 1000));
    TEST_ASSERT_EQUAL_INT64(at + 1000000, lin_period_next(at + 999999, 1000));
    TEST_ASSERT_EQUAL_UINT32(2, lin_period_missed(at, at + 3000000, 1000));
    TEST_ASSERT_EQUAL_UINT32(3, lin_period_missed(at + 333333, at + 1666666, 3000));
    TEST_ASSERT_EQUAL_UINT32(9999, lin_period_missed(at, 11 * at, 1000));
}

static void test_place_is_a_name_or_chip_and_offset(void)
{
    lin_place_t p;
    TEST_ASSERT_TRUE(lin_place_parse(&p, "gpiochip0", "ESTOP", &error));
    TEST_ASSERT_EQUAL_STRING("/dev/gpiochip0", p.chip);
    TEST_ASSERT_EQUAL_STRING("ESTOP", p.name);
    TEST_ASSERT_TRUE(lin_place_parse(&p, "gpiochip0", "/dev/gpiochip3:17", &error));
    TEST_ASSERT_EQUAL_STRING("/dev/gpiochip3", p.chip);
    TEST_ASSERT_EQUAL_UINT(17, p.offset);
    TEST_ASSERT_NULL(p.name);
    static const char *const wrong[] = {"gpiochip0:", "gpiochip0:x", ":3",
                                        "a:3x",       "a:70000",     "a:-1"};
    for (uint32_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        TEST_ASSERT_FALSE_MESSAGE(lin_place_parse(&p, "c", wrong[i], &error), wrong[i]);
        expect_error("CHIP:OFFSET");
    }
}

static void test_unavailable_line_is_reported_with_a_remedy(void)
{
    static const struct {
        int err;
        const char *who, *words;
    } rows[] = {
        {0, "", "/dev/gpiochip0 has no line ESTOP; gpioinfo"},
        {EBUSY, "gpioset", "line ESTOP of /dev/gpiochip0 is in use by gpioset; end that"},
        {EBUSY, "", "is in use; end that"},
        {ENOENT, "", "/dev/gpiochip0: no such GPIO chip; gpiodetect"},
        {EACCES, "", "not permitted; join its group"},
        {EIO, "", "line ESTOP of /dev/gpiochip0: Input/output error"},
    };
    lin_place_t p;
    TEST_ASSERT_TRUE(lin_place_parse(&p, "gpiochip0", "ESTOP", &error));
    for (uint32_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        TEST_ASSERT_FALSE(lin_place_refuse(&p, rows[i].err, rows[i].who, &error));
        TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error.text, rows[i].words), error.text);
    }
}

/// A terminal that is closed and its shell send a signal each, some milliseconds apart: only a
/// later one hurries. Retract takes 2 s at most, release 1 s.
static void test_end_waits_for_the_retract_and_for_the_drives(void)
{
    enum { on = hal_out_enable };
    static const struct {
        uint32_t n_signals, outputs;
        bool is_at_rest;
        int64_t ms;
        lin_stop_phase_t phase;
    } steps[] = {{0, on, false, 0, lin_stop_run}, // a row without a signal begins anew
                 {1, on, false, 0, lin_stop_retract},
                 {1, on, false, 2000, lin_stop_retract},
                 {1, hal_out_fault, false, 2000, lin_stop_release},
                 {1, 0, false, 2001, lin_stop_release},
                 {1, 0, false, 3000, lin_stop_release},
                 {1, 0, true, 3000, lin_stop_over},
                 {9, 0, false, 3001, lin_stop_over},
                 {0, 0, true, 0, lin_stop_run}, // off: the drives are commanded three times
                 {1, 0, true, 0, lin_stop_release},
                 {1, 0, true, 1, lin_stop_release},
                 {1, 0, true, 2, lin_stop_release},
                 {1, 0, true, 3, lin_stop_over},
                 {0, on, false, 0, lin_stop_run}, // neither retract nor drives end
                 {1, on, false, 0, lin_stop_retract},
                 {1, on, false, 2001, lin_stop_release},
                 {1, 0, false, 3001, lin_stop_release},
                 {1, 0, false, 3002, lin_stop_over},
                 {0, on, false, 0, lin_stop_run}, // a signal after 999 ms hurries
                 {2, on, false, 7, lin_stop_retract},
                 {3, on, false, 306, lin_stop_retract},
                 {3, on, false, 999, lin_stop_retract},
                 {4, on, false, 999, lin_stop_release},
                 {0, on, false, 0, lin_stop_run}, // and one after 300 ms
                 {1, on, false, 7, lin_stop_retract},
                 {2, on, false, 307, lin_stop_release}};
    lin_stop_t s = {.phase = lin_stop_run};
    for (uint32_t i = 0; i < sizeof steps / sizeof steps[0]; i++) {
        if (steps[i].n_signals == 0u) {
            s = (lin_stop_t){.phase = lin_stop_run};
        }
        const lin_stop_phase_t phase = lin_stop_step(&s, steps[i].n_signals, steps[i].outputs,
                                                     steps[i].is_at_rest, steps[i].ms * 1000000);
        TEST_ASSERT_EQUAL_INT(steps[i].phase, phase);
    }
}

static void test_reason_of_a_halt_is_reported_at_the_next_start_once(void)
{
    char longest[2 * lin_halt_text_bytes];
    hal_start_t start = lin_halt_text_start(path);
    TEST_ASSERT_EQUAL_INT(hal_reset_power_on, start.reset);
    TEST_ASSERT_EQUAL_STRING("", start.why);
    lin_halt_text_halt("broken");
    start = lin_halt_text_start(path);
    TEST_ASSERT_EQUAL_INT(hal_reset_halt, start.reset);
    TEST_ASSERT_EQUAL_STRING("broken", start.why);
    TEST_ASSERT_EQUAL_INT(hal_reset_power_on, lin_halt_text_start(path).reset);
    memset(longest, 'x', sizeof longest);
    longest[sizeof longest - 1u] = '\0';
    lin_halt_text_halt(longest);
    TEST_ASSERT_EQUAL_size_t(lin_halt_text_bytes, strlen(lin_halt_text_start(path).why));
}

/// Who may write into the folder may not have a file of somebody else overwritten.
static void test_reason_of_a_halt_follows_no_link(void)
{
    char kept[110];
    (void)lin_halt_text_start(path);
    (void)snprintf(kept, sizeof kept, "%s.halt", path);
    TEST_ASSERT_EQUAL_INT(0, symlink(path, kept));
    lin_halt_text_halt("broken");
    TEST_ASSERT_NOT_EQUAL_INT(0, access(path, F_OK));
    TEST_ASSERT_EQUAL_INT(0, unlink(kept));
}
