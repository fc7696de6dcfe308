// SPDX-License-Identifier: Apache-2.0
/// lin_notify: notifies systemd that the program is ready and alive; does nothing without systemd.
/// Source: sd_notify(3), "Notes": one datagram to the socket NOTIFY_SOCKET.
#ifndef LIN_NOTIFY_H
#define LIN_NOTIFY_H

#include <stdint.h> // int64_t

/// Notify that the tick runs. Context: main(), once.
void lin_notify_ready(void);

/// Notify that tick and main() are alive, at most four times per WATCHDOG_USEC. If notifications
/// stop, systemd ends the program with SIGABRT, which disables the drives. Context: main().
void lin_notify_alive(int64_t now_ns);

#endif
