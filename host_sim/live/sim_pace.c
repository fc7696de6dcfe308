// SPDX-License-Identifier: Apache-2.0
#define _POSIX_C_SOURCE 200809L // NOLINT(bugprone-reserved-identifier): clock_nanosleep
#include "sim_live.h"
#include <time.h> // clock_gettime, clock_nanosleep

#define BURST_NS 1e6
#define MOST_LATE_NS 1e8

static double now_ns(void)
{
    struct timespec t;
    (void)clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec * 1e9 + (double)t.tv_nsec;
}

void sim_pace_init(sim_pace_t *p, double tick_hz, double speed_up)
{
    *p = (sim_pace_t){.tick_ns = 1e9 / (tick_hz * speed_up), .due_ns = now_ns()};
}

void sim_pace_tick(sim_pace_t *p)
{
    p->due_ns += p->tick_ns;
    const double early_ns = p->due_ns - now_ns();
    if (early_ns > BURST_NS) {
        const struct timespec t = {.tv_sec = (time_t)(early_ns / 1e9),
                                   .tv_nsec =
                                       (long)(early_ns - (double)(int64_t)(early_ns / 1e9) * 1e9)};
        (void)clock_nanosleep(CLOCK_MONOTONIC, 0, &t, NULL);
    } else if (early_ns < -MOST_LATE_NS) {
        p->lost_ns -= early_ns;
        p->due_ns -= early_ns;
    }
}
