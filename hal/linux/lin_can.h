// SPDX-License-Identifier: Apache-2.0
/// lin_can: a raw CAN socket that never waits.
///
/// Frames are stamped by the kernel when they arrive; the stamps are brought to CLOCK_MONOTONIC.
/// Frames of more than 8 bytes are CAN FD. Source: Linux, Documentation/networking/can.rst;
/// linux/can/error.h.
#ifndef LIN_CAN_H
#define LIN_CAN_H

#include "hal/hal.h"      // hal_can_frame_t
#include "common_error.h" // common_error_t
#include "lin_node.h"     // lin_loss_t
#include <stdatomic.h>    // is_gone
#include <stdbool.h>      // bool
#include <stdint.h>       // int64_t, uint32_t

enum { lin_can_max_filters = 32 };

/// Frames that a socket receives.
typedef struct {
    uint32_t id, mask; ///< of 11-bit data frames
} lin_can_filter_t;

/// A socket. One thread receives and sends: the tick or main(). Besides, main() may call
/// lin_can_rebind().
typedef struct {
    int fd; ///< -1: not open; from here to n_filters nothing changes after lin_can_open()
    char interface[16];
    uint32_t n_room; ///< [frames] that the interface's queue takes (txqueuelen); 0: it has none
    lin_can_filter_t filters[lin_can_max_filters];
    uint32_t n_filters;
    uint32_t n_overflow;  ///< received frames that the kernel threw away, so far
    lin_loss_t link;      ///< none, bus_off or interface_down; none again when frames flow
    lin_loss_t event;     ///< overflow or send since lin_can_take_event()
    _Atomic bool is_gone; ///< the interface was removed: set by the thread that receives and
                          ///< sends, taken by lin_can_rebind()
} lin_can_t;

/// @param n       1 .. lin_can_max_filters
/// @param is_fd   the interface must be able to carry CAN FD
/// @return        false and *e: no such interface, it is down, cannot carry CAN FD, no CAN at all
/// Context: main(), before the tick.
bool lin_can_open(lin_can_t *can, const char *interface, const lin_can_filter_t *filters,
                  uint32_t n, bool is_fd, common_error_t *e);

/// A function that takes the frames of lin_can_receive().
typedef void lin_can_taker_t(void *user, const hal_can_frame_t *frame, int64_t ns);

/// Take the frames that have arrived, at most 128; the rest waits for the next tick. It makes at
/// most six system calls.
void lin_can_receive(lin_can_t *can, lin_can_taker_t *take, void *user);

/// Take one frame, by one system call or a few. @return false: there is none
bool lin_can_receive_one(lin_can_t *can, hal_can_frame_t *frame);

/// Queue frames by one system call, n <= 32.
/// @return number of frames queued; `link` and `event` say why it is less than n
uint32_t lin_can_send(lin_can_t *can, const hal_can_frame_t *frames, uint32_t n);

/// @return what happened since the last call: none, overflow or send
lin_loss_t lin_can_take_event(lin_can_t *can);

/// Use an interface that was removed and is there again. Context: main(); the tick may be in any
/// other function of this module.
void lin_can_rebind(lin_can_t *can);

#endif
