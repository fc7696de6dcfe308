// SPDX-License-Identifier: Apache-2.0
/// lin_can: a non-blocking raw CAN socket.
///
/// The kernel's time stamps of arrival are converted to CLOCK_MONOTONIC. Frames longer than 8 bytes
/// are CAN FD. Source: Linux, Documentation/networking/can.rst; linux/can/error.h.
#ifndef LIN_CAN_H
#define LIN_CAN_H

#include "hal/hal.h"      // hal_can_frame_t
#include "common_error.h" // common_error_t
#include "lin_node.h"     // lin_loss_t
#include <stdatomic.h>    // is_gone
#include <stdbool.h>      // bool
#include <stdint.h>       // int64_t, uint32_t

enum { lin_can_max_filters = 32 };

/// Filter of received frames.
typedef struct {
    uint32_t id, mask; ///< of 11-bit data frames
} lin_can_filter_t;

/// A socket. One thread (the tick or main()) receives and sends; main() may also call
/// lin_can_rebind().
typedef struct {
    int fd; ///< -1: not open; fd to n_filters are constant after lin_can_open()
    char interface[16];
    uint32_t n_room; ///< [frames] length of the interface's queue (txqueuelen); 0: no queue
    lin_can_filter_t filters[lin_can_max_filters];
    uint32_t n_filters;
    uint32_t n_overflow;  ///< received frames dropped by the kernel so far
    lin_loss_t link;      ///< none, bus_off or interface_down
    lin_loss_t event;     ///< overflow or send since lin_can_take_event()
    _Atomic bool is_gone; ///< the interface was removed; set by the thread that receives and
                          ///< sends, cleared by lin_can_rebind()
} lin_can_t;

/// @param n       1 .. lin_can_max_filters
/// @param is_fd   the interface must support CAN FD
/// @return        false and *e: no CAN in the kernel, no such interface, it is down or without FD
/// Context: main(), before the tick.
bool lin_can_open(lin_can_t *can, const char *interface, const lin_can_filter_t *filters,
                  uint32_t n, bool is_fd, common_error_t *e);

/// Receives the frames of lin_can_receive().
typedef void lin_can_handler_t(void *user, const hal_can_frame_t *frame, int64_t ns);

/// Receive up to 128 frames, with at most six system calls; the rest stays for the next tick.
void lin_can_receive(lin_can_t *can, lin_can_handler_t *take, void *user);

/// Receive one frame, with one or a few system calls. @return false if there is none
bool lin_can_receive_one(lin_can_t *can, hal_can_frame_t *frame);

/// Queue frames with one system call, n <= 32.
/// @return number of frames queued; if less than n, `link` and `event` give the cause
uint32_t lin_can_send(lin_can_t *can, const hal_can_frame_t *frames, uint32_t n);

/// @return event since the last call: none, overflow or send
lin_loss_t lin_can_take_event(lin_can_t *can);

/// Rebind to an interface that was removed and has returned. Context: main(), concurrently with any
/// other function of this module in the tick.
void lin_can_rebind(lin_can_t *can);

#endif
