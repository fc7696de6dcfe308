// SPDX-License-Identifier: Apache-2.0
#include "lin_port.h"
#include "hal/version.h" // CAMTURN_VERSION
#include <fcntl.h>       // open
#include <stdio.h>       // snprintf
#include <stdlib.h>      // getenv
#include <string.h>      // strcmp
#include <unistd.h>      // read

static const char usage[] =
    "usage: camturn-linux --config FILE [--check] | --version\n"
    "\n"
    "The camturn controller with CAN drives and GPIO lines.\n"
    "\n"
    "  --config FILE  configuration of the machine; default: environment variable CAMTURN_CONFIG\n"
    "  --check        check the configuration and exit\n"
    "\n"
    "SIGTERM or SIGINT: retract the tool, then disable the drives; a second signal disables them\n"
    "at once.\n"
    "Exit status: 0 ended by a signal, 1 internal fault, 2 wrong usage, configuration or "
    "machine.\n";

/// Read the command line, each word terminated by 0. @return [bytes]
static size_t read_words(char *words, size_t size)
{
    const int fd = open("/proc/self/cmdline", O_RDONLY | O_CLOEXEC);
    const ssize_t n = fd >= 0 ? read(fd, words, size - 1u) : -1;
    if (fd >= 0) {
        (void)close(fd);
    }
    words[n > 0 ? (size_t)n : 0u] = '\0';
    return n > 0 ? (size_t)n : 0u;
}

static bool take_path(lin_options_t *o, const char *path, common_error_t *e)
{
    return (path[0] != '\0' &&
            (size_t)snprintf(o->config, sizeof o->config, "%s", path) < sizeof o->config) ||
           common_error(e, "--config %.40s: not a path; write --config FILE", path);
}

bool lin_options_read(lin_options_t *o, common_error_t *e)
{
    char words[2048];
    const size_t size = read_words(words, sizeof words);
    *o = (lin_options_t){.print = NULL};
    const char *end = words + size;
    for (const char *word = words + strlen(words) + 1u; word < end; word += strlen(word) + 1u) {
        if (strcmp(word, "--help") == 0 || strcmp(word, "-h") == 0) {
            o->print = usage;
        } else if (strcmp(word, "--check") == 0) {
            o->is_check = true;
        } else if (strcmp(word, "--version") == 0) {
            o->print = "camturn-linux " CAMTURN_VERSION "\n";
        } else if (strcmp(word, "--config") == 0) {
            word += strlen(word) + 1u;
            if (!take_path(o, word < end ? word : "", e)) {
                return false;
            }
        } else if (strncmp(word, "--config=", 9) == 0) {
            if (!take_path(o, word + 9, e)) {
                return false;
            }
        } else {
            return common_error(e, "%.60s: unknown option; see --help", word);
        }
    }
    const char *path = getenv("CAMTURN_CONFIG");
    if (o->config[0] == '\0' && path != NULL && !take_path(o, path, e)) {
        return false;
    }
    return o->print != NULL || o->config[0] != '\0' ||
           common_error(e, "no configuration; write --config FILE (hal/linux/camturn.toml is an "
                           "example)");
}
