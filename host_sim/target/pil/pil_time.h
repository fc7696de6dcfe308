// SPDX-License-Identifier: Apache-2.0
/// pil_time: the time of an image whose ticks come over the wire: what the requests say it is.
#ifndef PIL_TIME_H
#define PIL_TIME_H

#include <stdint.h> // uint32_t

typedef struct {
    uint32_t tick_hz, clock_hz; ///< [Hz] set before hal_init()
    uint32_t clock;             ///< [1 / clock_hz] set before cam_isr()
} pil_time_t;

extern pil_time_t pil_time;

#endif
