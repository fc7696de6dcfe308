// SPDX-License-Identifier: Apache-2.0
/// lin_notify: reports to systemd that the program is ready and alive; without systemd it does
/// nothing. Source: sd_notify(3), "Notes": one datagram to the socket NOTIFY_SOCKET.
#ifndef LIN_NOTIFY_H
#define LIN_NOTIFY_H

#include <stdint.h> // int64_t

/// The tick runs. Context: main(), once.
void lin_notify_ready(void);

/// A tick has ended and main() came round. Sent four times per WATCHDOG_USEC at most: without it
/// systemd ends the program by SIGABRT, which lets the drives go. Context: main().
void lin_notify_alive(int64_t now_ns);

#endif
