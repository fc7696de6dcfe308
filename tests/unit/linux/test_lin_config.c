// SPDX-License-Identifier: Apache-2.0
// The Linux port's configuration file: the example, and everything that is refused.
#define CONFIG_PATH "test_lin_config.toml"
#include "config_bench.h"
#include "lin_setup.h" // lin_check_load, lin_check_warn
#include <stddef.h>    // offsetof

static lin_config_t config;

void setUp(void)
{
    config = lin_config_defaults();
}

static bool read_config(void)
{
    config = lin_config_defaults();
    return lin_check_load(&config, CONFIG_PATH, &error);
}

static void load_port_file(const char *file_path)
{
    TEST_ASSERT_TRUE_MESSAGE(lin_check_load(&config, file_path, &error), error.text);
}

#define SPAN(first, last)                                                                          \
    offsetof(lin_config_t, first), offsetof(lin_config_t, last) + sizeof config.last

/// The members of a configuration, without the padding between them.
static const struct {
    size_t begin, end;
} spans[] = {{SPAN(thread, can.is_fd)},
             {SPAN(can.data_bitrate, encoder.index)},
             {SPAN(encoder.index_counts, table_file)},
             {SPAN(table_max_bytes, has_retired)}};

/// The example must name every field: loaded over zeros it gives the defaults, and loaded over
/// other values those that are 0, too.
static void test_example_file_names_every_default(void)
{
    lin_config_t expected = lin_config_defaults();
    (void)strcpy(expected.can.remote, "can0");
    memset(&config, 0, sizeof config);
    load_port_file(HAL_LINUX_DIR "/camturn.toml");
    for (size_t i = 0; i < sizeof spans / sizeof spans[0]; i++) {
        const size_t begin = spans[i].begin;
        TEST_ASSERT_EQUAL_MEMORY((const char *)&expected + begin, (const char *)&config + begin,
                                 spans[i].end - begin);
    }
    memset(&config, 0x5a, sizeof config);
    load_port_file(HAL_LINUX_DIR "/camturn.toml");
    TEST_ASSERT_TRUE(config.can.is_fd == expected.can.is_fd);
    TEST_ASSERT_EQUAL_STRING(expected.can.remote, config.can.remote);
    TEST_ASSERT_EQUAL_INT64(0, config.encoder.modulus_counts);
    TEST_ASSERT_EQUAL_UINT32(lin_index_line, config.encoder.index);
    TEST_ASSERT_EQUAL_INT64(0, config.encoder.index_counts);
    TEST_ASSERT_EQUAL_INT64(0, config.encoder.delay_ns);
    TEST_ASSERT_EQUAL_INT64(0, config.encoder.max_age_us);
    for (int i = 0; i < lin_n_lines; i++) {
        TEST_ASSERT_TRUE(config.line[i].is_active_low == expected.line[i].is_active_low);
    }
}

static void test_desk_file_is_right(void)
{
    load_port_file(HAL_LINUX_DIR "/desk.toml");
    for (int i = 0; i < lin_n_lines; i++) {
        TEST_ASSERT_FALSE(lin_line_is_there(&config, (lin_line_t)i));
    }
}

static void test_values_of_every_kind_arrive(void)
{
    taken("[thread]\n  tick_hz = 1300 # fast\n"
          "[can]\nfd = true\nremote = \"can1\"\n"
          "[encoder]\nindex = \"position\"\nindex_counts = 9999\n"
          "[drive.z]\nnode = 0\ncounts = 4096\nnm = -5000000\n"
          "[gpio]\nestop = \"gpiochip1:7\"\nestop_active_low = true\n"
          "index = \"none\"\n"
          "[table]\nfile = \"a#b.camtab\" # with a hash\n");
    TEST_ASSERT_EQUAL_INT64(1300, config.thread.tick_hz);
    TEST_ASSERT_TRUE(config.can.is_fd);
    TEST_ASSERT_EQUAL_STRING("can0", config.can.interface);
    TEST_ASSERT_EQUAL_STRING("can1", config.can.remote);
    TEST_ASSERT_EQUAL_UINT32(lin_index_position, config.encoder.index);
    TEST_ASSERT_EQUAL_INT64(0, config.drive[hal_axis_z].node);
    TEST_ASSERT_EQUAL_INT64(4096, config.drive[hal_axis_z].counts);
    TEST_ASSERT_EQUAL_INT64(-5000000, config.drive[hal_axis_z].nm);
    TEST_ASSERT_EQUAL_STRING("gpiochip1:7", config.line[lin_line_estop].place);
    TEST_ASSERT_TRUE(config.line[lin_line_estop].is_active_low);
    TEST_ASSERT_FALSE(lin_line_is_there(&config, lin_line_index));
    TEST_ASSERT_TRUE(lin_line_is_there(&config, lin_line_ready));
    TEST_ASSERT_EQUAL_STRING("a#b.camtab", config.table_file);
}

/// A reason names line, field, value and remedy.
static void test_what_is_wrong_is_refused(void)
{
    refused("[thread]\ntick_hz = 4001\n",
            ":2: thread.tick_hz = 4001: give a whole number, 500 .. 4000");
    refused("[thread]\ntick_hz = 1e3\n", "give a whole number");
    refused("[thread]\ntick_hz =\n", "give a whole number");
    refused("[thread]\ntick_hz = 99999999999999999999\n", "give a whole number");
    refused("[thread]\ntick_hz = 1000\ntick_hz = 1000\n", ":3: thread.tick_hz = 1000: given twice");
    refused("[thread]\nrate = 1\n", "unknown key");
    refused("[threads]\ntick_hz = 1000\n", "unknown section");
    refused("tick_hz = 1000\n", "unknown key");
    refused("[thread]\ntick_hz\n", ":2: not [section] or key = value");
    refused("[can]\nfd = 1\n", "give true or false");
    refused("[can]\ninterface = can0\n", "give one \"text\"");
    refused("[can]\ninterface = \"can0\" \"can1\"\n", "give one \"text\"");
    refused("[can]\ninterface = \"a_name_too_long_\"\n", "at most 15 characters");
    refused("[can]\ninterface = \"\"\n", "is empty");
    refused("[gpio]\nfault = \"\"\n", "gpio.fault is empty");
    refused("[encoder]\nindex = \"pos\"\n", "give one of \"line\" \"position\"");
    refused("[table]\nfile = \"c:\\\\x\"\n", "give one \"text\"");
    refused("[trust]\nkey_1 = \"\"\n", ":1: [trust]: unknown section; correct or remove it");
}

/// Also values that a reader of keys alone would accept, although no machine can work by them.
static void test_values_that_do_not_fit_one_another_are_refused(void)
{
    refused("[drive.x]\nnode = 2\n", "drive.x.node = 2: also used by drive.u.node");
    refused("[can]\nnode = 5\n", "spindle.node = 5: also used by can.node");
    refused("[encoder]\nindex_counts = 10000\n", "give less than counts_per_turn");
    refused("[encoder]\nmodulus_counts = 65536\n", "not a multiple of counts_per_turn");
    refused("[gpio]\nindex = \"none\"\n", "use \"position\"");
    refused("[drive.u]\nnm = 0\n", "drive.u.nm = 0");
    taken("[drive.x]\nnode = 0\n[drive.z]\nnode = 0\n[spindle]\nnode = 0\n");
    refused("[gpio]\nestop = \"gpiochip0:x\"\n", "gpio.estop = gpiochip0:x: no number after");
    refused("[gpio]\nready = \"gpiochip0:3\"\nfault = \"/dev/gpiochip0:3\"\n",
            "gpio.fault = \"/dev/gpiochip0:3\": also used by gpio.ready");
    refused("[gpio]\nin_cut = \"FAULT\"\n", "gpio.in_cut = \"FAULT\": also used by gpio.fault");
    refused("[encoder]\nmax_age_us = 1\n", "encoder.max_age_us = 1: with delay_ns = 0 every frame");
    refused("[encoder]\nmax_age_us = 2099\ndelay_ns = 100000\n", "give at least 2100");
    refused("[encoder]\ndelay_ns = 4000001\n", "encoder.max_age_us = 0: with delay_ns = 4000001");
    refused("[can]\npdo_timeout_ms = 3\n", "can.pdo_timeout_ms = 3: shorter than two ticks of "
                                           "thread.tick_hz = 500; give at least 4");
    refused("[drive.u]\nnode = 0\n", "drive.u.node = 0: give a whole number, 1 .. 127");
    taken("[encoder]\nmax_age_us = 2100\ndelay_ns = 100000\n");
    taken("[can]\npdo_timeout_ms = 4\n");
    taken("[gpio]\nready = \"gpiochip0:3\"\nfault = \"gpiochip1:3\"\n");
}

static void test_what_is_no_toml_is_refused_with_its_line(void)
{
    refused("[thread]\n[canal]\n[can]\n", ":2: [canal]: unknown section");
    refused("[can\nnode = 3\n", ":1: [can: not a section");
    refused("[can] node = 3\n", ":1: [can: not a section");
    refused("[can]\nnode: 3\n", ":2: not [section] or key = value");
    refused("[can]\n; node = 3\n", ":2: not [section] or key = value");
    refused("[can]\nnode = 3 ; three\n", ":2: \";\" after the value; begin comments with #");
    taken("\r\n  # a comment: so; or so\n[can] # this\n\tnode = 9 # nine;\n");
    TEST_ASSERT_EQUAL_INT64(9, config.can.node);
}

static void test_bus_that_cannot_bear_the_ticks_is_refused_with_the_rate(void)
{
    refused(
        "[thread]\ntick_hz = 1000\n",
        "thread.tick_hz = 1000: takes up to 144 % of a bus with can.bitrate = 1000000: 1355 us a "
        "tick and 75 ms a second for heartbeats and status; the highest possible rate is 682;");
    taken("[thread]\ntick_hz = 682\n");
    refused("[thread]\ntick_hz = 683\n", "takes up to 101 %");
    refused("[can]\nbitrate = 500000\n", "no rate of 500 or more is possible");
    refused("[thread]\ntick_hz = 1010\n[can]\nfd = true\n", "(FD): 916 us a tick");
    taken("[thread]\ntick_hz = 1000\n[can]\nfd = true\n");
    taken("[thread]\ntick_hz = 732\n[can]\nremote = \"can1\"\n"); // no status
    taken("[thread]\ntick_hz = 4000\n[can]\ninterface = \"vcan0\"\n");
}

static char warnings[1000];

static void note(const char *line)
{
    const size_t n = strlen(warnings);
    (void)snprintf(warnings + n, sizeof warnings - n, "%s\n", line);
}

/// The begins of the lines must be the warnings of a file.
static void expect_warnings(const char *text, const char *const *begins)
{
    taken(text);
    warnings[0] = '\0';
    lin_check_warn(&config, note);
    const char *line = warnings;
    for (; *begins != NULL; begins++) {
        TEST_ASSERT_EQUAL_STRING_LEN(*begins, line, strlen(*begins));
        line = strchr(line, '\n') + 1;
    }
    TEST_ASSERT_EQUAL_STRING("", line);
}

/// A file of an older version still loads; one line names what is retired. Other keys are refused.
static void test_doubtful_and_retired_values_are_reported(void)
{
    expect_warnings("[operator]\nacknowledge = \"ACK\"\n", (const char *const[]){NULL});
    expect_warnings(
        "[operator]\nacknowledge = \"waived\"\n",
        (const char *const[]){
            "warning: operator.acknowledge = \"waived\": anyone on the bus can start the machine",
            NULL});
    expect_warnings(
        "[thread]\ntick_hz = 1000\n[can]\ninterface = \"vcan0\"\n"
        "[gpio]\nestop = \"none\"\nenable = \"none\"\n",
        (const char *const[]){"warning: gpio.estop = \"none\"", "warning: gpio.enable = \"none\"",
                              "warning: thread.tick_hz = 1000: takes up to 144 %",
                              "warning: operator.acknowledge = \"none\": nothing", NULL});
    expect_warnings("[operator]\nacknowledge = \"ACK\"\n[gpio]\n"
                    "switch_1 = \"none\"\nswitch_8_active_low = true\n",
                    (const char *const[]){"warning: gpio.switch_1 .. switch_8: retired", NULL});
    refused("[can]\nswitch_1 = 3\n", "can.switch_1: unknown key");
}

static void test_file_that_is_not_there_or_no_text_is_refused(void)
{
    TEST_ASSERT_FALSE(lin_check_load(&config, "/nowhere/camturn.toml", &error));
    TEST_ASSERT_NOT_NULL(strstr(error.text, "/nowhere/camturn.toml: cannot be opened: No such"));
    TEST_ASSERT_FALSE(lin_check_load(&config, "/tmp", &error));
    TEST_ASSERT_NOT_NULL(strstr(error.text, "cannot be read"));
    char line[600];
    memset(line, 'x', sizeof line);
    line[sizeof line - 1u] = '\0';
    refused(line, ":1: longer than");
    TEST_ASSERT_FALSE(load("[can]\nremote = \"a\x01\n"));
    TEST_ASSERT_NULL(strchr(error.text, '\x01'));
    static const char nul[] = "[can]\nnode = 9\0 and more\n";
    TEST_ASSERT_FALSE(load_bytes(nul, sizeof nul - 1u));
    TEST_ASSERT_NOT_NULL(strstr(error.text, ":2: contains a NUL byte; give a text file"));
}

static void test_wrong_settings_of_the_operator_are_refused(void)
{
    refused("[operator]\nacknowledge = \"\"\n", "operator.acknowledge is empty");
    refused("[operator]\nacknowledge = \"gpiochip0:x\"\n",
            "operator.acknowledge = gpiochip0:x: no number after");
    refused("[operator]\nacknowledge = true\n", "give one \"text\"");
    refused("[operator]\nacknowledge = \"ESTOP\"\n",
            "operator.acknowledge = \"ESTOP\": also used by");
    refused("[operator]\nkey = \"\"\n", "operator.key is empty");
    refused("[operator]\nacknowledge = \"ACK\"\nkey = \"ACK\"\n",
            "operator.key = \"ACK\": also used by operator.acknowledge");
    refused("[operator]\nacknowledge_active_low = 1\n", "give true or false");
    refused("[operator]\nkey_active_low = \"no\"\n", "give true or false");
    refused("[operator]\nwaived = true\n", "unknown key");
    taken("[operator]\nkey = \"waived\"\n"); // only a button can be waived
    TEST_ASSERT_TRUE(lin_line_is_there(&config, lin_line_key));
    taken("[gpio]\nestop = \"waived\"\n");
    TEST_ASSERT_TRUE(lin_line_is_there(&config, lin_line_estop));
}
