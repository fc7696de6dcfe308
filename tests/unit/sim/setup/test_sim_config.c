// SPDX-License-Identifier: Apache-2.0
#define CONFIG_PATH "test_sim_config.toml"
#include "config_bench.h"
#include "sim_config.h"

static sim_config_t config;

void setUp(void)
{
    config = sim_config_defaults();
}

static bool read_config(void)
{
    config = sim_config_defaults();
    return sim_config_load(&config, CONFIG_PATH, &error);
}

/// The file and the code must agree on the default of every key.
static void test_default_file_is_the_built_in_machine(void)
{
    memset(&config.lathe, 0, sizeof config.lathe); // every key must come from the file
    config.name[0] = '\0';
    TEST_ASSERT_TRUE_MESSAGE(
        sim_config_load(&config, HOST_SIM_DIR "/machines/default.toml", &error), error.text);
    const sim_config_t built_in = sim_config_defaults();
    TEST_ASSERT_EQUAL_MEMORY(&built_in.lathe, &config.lathe, sizeof config.lathe);
    TEST_ASSERT_EQUAL_STRING(built_in.name, config.name);
}

static void test_load_takes_comments_blanks_and_indentation(void)
{
    taken("# top\n\n[machine]\n  name = \"a # b\"   # behind\n\ttick_hz=10000# x\n"
          "[u]\ndelay_us = 1.5e1\n");
    TEST_ASSERT_EQUAL_STRING("a # b", config.name);
    TEST_ASSERT_TRUE(config.lathe.tick_hz == 10000.0);
    TEST_ASSERT_TRUE(config.lathe.drive[0].delay_us == 15.0);
}

static void test_what_is_believed_is_the_truth_but_for_its_keys(void)
{
    taken("[believed.u]\nbandwidth_hz = 270\n[u]\ndamping = 0.5\n"
          "bandwidth_hz = 310\nmass_kg = 2\n");
    const sim_lathe_config_t *believed = sim_config_believed(&config);
    TEST_ASSERT_TRUE(config.has_belief);
    TEST_ASSERT_TRUE(believed->drive[0].bandwidth_hz == 270.0);
    TEST_ASSERT_TRUE(believed->drive[0].damping == 0.5);
    TEST_ASSERT_TRUE(config.lathe.drive[0].bandwidth_hz == 310.0);
    taken("[believed.u]\n[u]\nkind = \"force\"\n"); // nothing is believed without a key
    TEST_ASSERT_FALSE(config.has_belief);
    TEST_ASSERT_EQUAL_PTR(&config.lathe, sim_config_believed(&config));
    TEST_ASSERT_EQUAL_UINT32(sim_drive_force, config.lathe.drive[0].kind);
}

/// One value just outside of each range, and that in the table of beliefs, too.
static void test_ranges_of_the_effects_are_kept(void)
{
    static const struct {
        const char *section, *keys;
    } wrong[] = {
        {"u", "friction_m_per_s2 = -1;friction_m_per_s2 = 1001;mass_kg = 0;"
              "viscous_n_s_per_m = -1;stiffness_n_per_m = -1;force_limit_n = 0;"
              "force_quantum_n = 0;amplifier_hz = 9;command_quantum_nm = -1;"
              "mode_hz = -1;mode_damping = 0;mode_share = 2.1;mode_on_scale = 0.5;"
              "mode_2_hz = 20001;mode_2_damping = 2.1;mode_2_share = -2.1;"
              "mode_2_on_scale = 2;scale_latency_us = 1001;scale_error_nm = -1;"
              "scale_period_um = 0;"},
        {"x", "command_quantum_nm = -1;"},
        {"z", "command_quantum_nm = 100001;"},
        {"cut", "kc_n_per_mm2 = -1;radial_share = 11;tool_stiffness_n_per_um = -1;"},
        {"chuck", "jaws = 1;jaws = 13;jaws = 2.5;jaw_deg = 361;spring_um = 1001;"
                  "jaw_height_mm = -2001;round_height_mm = 2001;"},
        {"spindle", "ripple_2 = 0.6;ripple_per_turn_2 = 0;runout_um = -1;runout_2_um = 1001;"},
        {"encoder", "time_stamps = 2;"}};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        for (const char *at = wrong[i].keys; *at != '\0'; at += strcspn(at, ";") + 1u) {
            char text[80];
            const int n = (int)strcspn(at, ";");
            (void)snprintf(text, sizeof text, "[%s]\n%.*s\n", wrong[i].section, n, at);
            refused(text, "out of range; give a");
            (void)snprintf(text, sizeof text, "[believed.%s]\n%.*s\n", wrong[i].section, n, at);
            refused(text, "out of range; give a");
        }
    }
    refused("[u]\nmode_hz = 9\n", "u.mode_hz = 9: too slow; give 0 for none, or 10 .. 20000");
    refused("[u]\nmode_2_hz = 0.1\n", "u.mode_2_hz = 0.1: too slow");
}

static void test_load_takes_firmware_parameters(void)
{
    taken("[controller]\nk1_ns = 0\nz_is_measured = true\n");
    TEST_ASSERT_TRUE(config.controller.is_given[cam_param_k1_ns]);
    TEST_ASSERT_EQUAL_INT32(0, config.controller.value[cam_param_k1_ns]);
    TEST_ASSERT_EQUAL_INT32(1, config.controller.value[cam_param_z_is_measured]);
    TEST_ASSERT_FALSE(config.controller.is_given[cam_param_k2_us2]);
    // A file of an older version still loads.
    taken("[controller]\nswitch_8_z_low_nm = -3\nswitch_1_sense = 1\nk1_ns = 7\n");
    TEST_ASSERT_EQUAL_INT32(7, config.controller.value[cam_param_k1_ns]);
}

/// A lag of 1 / (pi 100 Hz), a dead time of 100 us and half a tick.
static void test_controller_is_derived_from_the_machine(void)
{
    static const sim_wishes_t none;
    cam_params_t params;
    sim_lathe_config_t *m = &config.lathe;
    m->encoder.counts_per_turn = 12000.0;
    m->drive[sim_lathe_swing].speed_units_per_s = 250.0;
    for (int i = 0; i < sim_lathe_n_drives; i++) {
        m->drive[i].delay_us = 100.0;
        m->drive[i].damping = 2.0;
        m->drive[i].bandwidth_hz = 200.0;
    }
    TEST_ASSERT_TRUE_MESSAGE(sim_controller_params(&params, m, false, &none, &error), error.text);
    TEST_ASSERT_EQUAL_INT32(12000, params.counts_per_turn);
    TEST_ASSERT_EQUAL_INT32(250000, params.swing_speed_mdeg_per_s);
    TEST_ASSERT_INT32_WITHIN(1, 3183099 + 125000, params.xz_lag_ns);
    TEST_ASSERT_INT32_WITHIN(1, 3183099 + 125000, params.swing_lag_ns);
    TEST_ASSERT_INT32_WITHIN(1, 3183099, params.k1_ns);
    TEST_ASSERT_EQUAL_INT32(125000, params.lead_ns);
}

static void test_load_refuses_what_is_wrong(void)
{
    refused("[u]\nbandwith_hz = 300\n", "u.bandwith_hz: unknown");
    refused("[v]\ndamping = 1\n", "v.damping");
    refused("damping = 1\n", "unknown");
    refused("[u]\ndamping = nan\n", "u.damping = nan: not a finite number");
    refused("[u]\ndamping = inf\n", "not a finite number");
    refused("[u]\ndamping = 0x10\n", "not a finite number");
    refused("[u]\ndamping = 1 2\n", "not a finite number");
    refused("[u]\ndamping = \"1\"\n", "not a finite number");
    refused("[u]\ndamping =\n", "not a finite number");
    refused("[u]\ndamping = 0\n", "out of range");
    refused("[u]\ndamping = -1\n", "line 2: u.damping = -1: out of range");
    refused("[u]\ndamping = 1\ndamping = 1\n", "given twice");
    refused("[machine]\ntick_hz = 20000.5\n", "whole");
    refused("[machine]\ntick_hz = 1e30\n", "out of range; give a whole number");
    refused("[encoder]\nstart_counts = -9.3e18\n", "out of range; give a whole number");
    refused("[encoder]\nsign = 1e300\n", "out of range; give a whole number");
    refused("[encoder]\nsign = 0\n", "not 0");
    refused("[encoder]\nsign = 0.5\n", "whole");
    refused("[machine]\nname = default\n", "machine.name");
    refused("[machine]\nname = \"a\"\nname = \"b\"\n", "machine.name");
    refused("[u\n", "not [section] or key = value");
    refused("[u]\ndamping\n", "line 2");
    refused("[controller]\nk1_ns = 1e12\n", "out of range");
    refused("[controller]\nk1_ns = 1.5\n", "whole");
    refused("[controller]\nk9 = 1\n", "no such parameter");
    refused("[controller]\nswitch = 1\n", "no such parameter");
    refused("[believed.u]\nbandwidth = 1\n", "line 2: believed.u.bandwidth = 1: not allowed");
    refused("[believed.machine]\ntick_hz = 1000\n", "line 2: believed.machine.tick_hz");
    refused("[believed.controller]\nk1_ns = 0\n", "line 2: believed.controller.k1_ns");
    refused("[believed.u]\ndelay_us = -1\n", "line 2: believed.u.delay_us = -1: out of range");
    refused("[believed.u]\ndelay_us = 1\ndelay_us = 1\n", "line 3: believed.u.delay_us = 1: given");
    refused("[u]\nkind = \"speed\"\n", "line 2: u.kind = \"speed\": give one of \"position\"");
    refused("[controller]\nk1_ns = 1\nk1_ns = 1\n", "given twice");
}

static void test_load_takes_a_last_line_without_an_end(void)
{
    taken("");
    taken("[u]\r\n\ndelay_us = 15");
    TEST_ASSERT_TRUE(config.lathe.drive[0].delay_us == 15.0);
}

static void refused_bytes(const char *bytes, size_t size, const char *why)
{
    TEST_ASSERT_FALSE(load_bytes(bytes, size));
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error.text, why), error.text);
}

static void test_load_refuses_what_is_no_text(void)
{
    enum { most = 1 << 20 };
    static char bytes[most + 1];
    static const char head[] = "\0\0garbage";
    static const char middle[] = "[u]\ndelay_us = 15\0garbage\n";
    refused_bytes(head, sizeof head - 1u, "line 1: contains a NUL byte");
    refused_bytes(middle, sizeof middle - 1u, "line 2: contains a NUL byte");
    memset(bytes, '\n', sizeof bytes);
    TEST_ASSERT_TRUE_MESSAGE(load_bytes(bytes, most), error.text);
    refused_bytes(bytes, most + 1, "larger than 1048576 bytes");
    memset(bytes, '#', 300);
    refused_bytes(bytes, 300, "longer than");
    TEST_ASSERT_FALSE(sim_config_load(&config, "nowhere/none.toml", &error));
    TEST_ASSERT_NOT_NULL(strstr(error.text, "nowhere/none.toml: cannot be opened"));
}
