// SPDX-License-Identifier: Apache-2.0
#include "lin_port.h"
#include <stddef.h>     // offsetof
#include <stdlib.h>     // getenv, strtoll
#include <string.h>     // strlen
#include <sys/socket.h> // sendto
#include <sys/un.h>     // sockaddr_un

static int fd = -1;
static struct sockaddr_un address;
static socklen_t address_bytes;
static int64_t interval_ns, last_ns;

static void notify(const char *words)
{
    if (fd >= 0) {
        (void)sendto(fd, words, strlen(words), MSG_DONTWAIT | MSG_NOSIGNAL,
                     (struct sockaddr *)&address, address_bytes);
    }
}

void lin_notify_ready(void)
{
    const char *path = getenv("NOTIFY_SOCKET");
    const char *usec = getenv("WATCHDOG_USEC");
    if (path == NULL || strlen(path) >= sizeof address.sun_path) {
        return;
    }
    address.sun_family = AF_UNIX;
    memcpy(address.sun_path, path, strlen(path));
    address_bytes = (socklen_t)(offsetof(struct sockaddr_un, sun_path) + strlen(path));
    if (path[0] == '@') { // abstract socket, not a file
        address.sun_path[0] = '\0';
    }
    interval_ns = usec != NULL ? strtoll(usec, NULL, 10) * 1000 / 4 : 0;
    fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    notify("READY=1");
}

void lin_notify_alive(int64_t now_ns)
{
    if (interval_ns > 0 && now_ns - last_ns >= interval_ns) {
        last_ns = now_ns;
        notify("WATCHDOG=1");
    }
}
