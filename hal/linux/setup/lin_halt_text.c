// SPDX-License-Identifier: Apache-2.0
#include "lin_setup.h"
#include <fcntl.h>  // open
#include <stdio.h>  // snprintf
#include <string.h> // strlen
#include <unistd.h> // read, unlink

static char path[256];

hal_start_t lin_halt_text_start(const char *table_file)
{
    static char why[lin_halt_text_bytes + 1];
    (void)snprintf(path, sizeof path, "%s.halt", table_file);
    const int fd = open(path, O_RDONLY | O_CLOEXEC);
    if (fd < 0) {
        return (hal_start_t){.reset = hal_reset_power_on, .why = ""};
    }
    const ssize_t n = read(fd, why, sizeof why - 1u);
    why[n > 0 ? n : 0] = '\0';
    (void)close(fd);
    (void)unlink(path);
    return (hal_start_t){.reset = hal_reset_halt, .why = why};
}

void lin_halt_text_halt(const char *why)
{
    const int flags = O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC;
    const int fd = path[0] != '\0' ? open(path, flags, 0644) : -1;
    if (fd >= 0) {
        (void)!write(fd, why, strlen(why));
        (void)close(fd);
    }
}
