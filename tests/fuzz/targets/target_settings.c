// SPDX-License-Identifier: Apache-2.0
// The files and words of people: machine files of the simulator, the configuration of the Linux
// port, faults to inject, options of `camsim run`, numbers. Each is read or refused with one line.
// The first byte says which reader takes the rest.
#include "camsim.h"
#include "common_number.h"
#include "fuzz_digest.h"
#include "fuzz_expect.h"
#include "fuzz_file.h"
#include "lin_setup.h"
#include "sim_config.h"
#include "sim_inject.h"
#include <math.h>
#include <string.h>

enum { most_text = 4096, most_words = 24 };

static common_error_t error;

/// A refusal says something, in one line of printable characters.
static void expect_reported(bool is_good)
{
    fuzz_note(is_good);
    if (is_good) {
        return;
    }
    FUZZ_EXPECT(memchr(error.text, 0, sizeof error.text) != NULL, "a line without an end");
    const size_t n = strlen(error.text);
    FUZZ_EXPECT(n > 0u, "refused without a word");
    for (size_t i = 0; i < n; i++) {
        const unsigned char c = (unsigned char)error.text[i];
        FUZZ_EXPECT(c >= 0x20u && c != 0x7Fu, "character %u in \"%s\"", (unsigned)c, error.text);
    }
}

static void read_machine(const uint8_t *data, size_t size)
{
    static sim_config_t config;
    config = sim_config_defaults();
    const bool is_good = sim_config_read(&config, (const char *)data, size, "m.toml", &error);
    expect_reported(is_good);
    if (is_good) {
        const double hz = (double)config.lathe.tick_hz;
        FUZZ_EXPECT(hz >= 500.0 && hz <= 100000.0, "tick_hz %g", hz);
        FUZZ_EXPECT(memchr(config.name, 0, sizeof config.name) != NULL, "name without an end");
    }
}

static void read_port(const uint8_t *data, size_t size)
{
    static lin_config_t config;
    config = lin_config_defaults();
    const bool is_good = lin_check_load(&config, fuzz_file(data, size), &error);
    expect_reported(is_good);
    if (is_good) {
        const lin_load_t load = lin_load_of(&config);
        const int64_t percent = lin_load_percent(&load, config.thread.tick_hz);
        const bool is_virtual = strncmp(config.can.interface, "vcan", 4) == 0;
        FUZZ_EXPECT(percent >= 0 && (percent <= 100 || is_virtual), "a bus loaded by %lld %%",
                    (long long)percent);
    }
}

static void read_fault(const char *text)
{
    sim_inject_t inject;
    const bool is_good = sim_inject_parse(&inject, text, sim_inject_in_run, &error);
    expect_reported(is_good);
    if (is_good) {
        FUZZ_EXPECT(isfinite(inject.at_s) && isfinite(inject.value), "no number");
        FUZZ_EXPECT(sim_inject_name(inject.kind)[0] != '\0', "no name");
    }
}

/// Words are separated by line ends; none names a file elsewhere.
static void read_options(char *text)
{
    static camsim_options_t options;
    char *words[most_words + 2] = {"run"};
    int n = 1;
    for (char *at = text; at != NULL && n <= most_words;) {
        words[n++] = at;
        at = strchr(at, '\n');
        if (at != NULL) {
            *at++ = '\0';
        }
    }
    expect_reported(camsim_options_read(&options, n, words, &error));
}

static void read_number(const char *text)
{
    double value = 1.5;
    if (common_number_parse(text, &value)) {
        FUZZ_EXPECT(isfinite(value), "%g", value);
    } else {
        FUZZ_EXPECT(value == 1.5, "%g of what is refused", value);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char text[most_text + 1];
    if (size < 1u || size > (size_t)most_text) {
        return -1;
    }
    memcpy(text, data + 1, size - 1u);
    text[size - 1u] = '\0';
    error.text[0] = '\0';
    switch (data[0]) {
    case 'L':
        read_port(data + 1, size - 1u);
        break;
    case 'I':
        read_fault(text);
        break;
    case 'O':
        for (char *c = text; *c != '\0'; c++) {
            *c = (char)(*c == '/' ? '_' : *c);
        }
        read_options(text);
        break;
    case 'N':
        read_number(text);
        break;
    default:
        read_machine(data + 1, size - 1u);
        break;
    }
    return 0;
}
