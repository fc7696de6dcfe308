// SPDX-License-Identifier: Apache-2.0
/// pil_time: time of an image with ticks over the wire: set by the requests.
#ifndef PIL_TIME_H
#define PIL_TIME_H

#include <stdint.h> // uint32_t

typedef struct {
    uint32_t tick_hz, clock_hz; ///< [Hz] set before hal_init()
    uint32_t clock;             ///< [1 / clock_hz] set before cam_isr()
} pil_time_t;

extern pil_time_t pil_time;

#endif
