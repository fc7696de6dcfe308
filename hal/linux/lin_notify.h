// SPDX-License-Identifier: Apache-2.0
/// lin_notify: reports to systemd that the program is ready and alive; without systemd it does
/// nothing. Source: sd_notify(3), "Notes": one datagram to the socket NOTIFY_SOCKET.
#ifndef LIN_NOTIFY_H
#define LIN_NOTIFY_H

#include <stdint.h> // int64_t

/// Report that the tick runs. Context: main(), once.
void lin_notify_ready(void);

/// Report that a tick has ended and main() works, at most four times per WATCHDOG_USEC. Without it
/// systemd ends the program by SIGABRT, which disables the drives. Context: main().
void lin_notify_alive(int64_t now_ns);

#endif
