// SPDX-License-Identifier: Apache-2.0
#include "lin_port.h"
#include "lin_tick.h"  // lin_period_next
#include <errno.h>     // errno
#include <pthread.h>   // pthread_create
#include <sched.h>     // SCHED_FIFO, CPU_SET
#include <semaphore.h> // sem_t
#include <stdarg.h>    // va_list
#include <stdatomic.h> // the counters
#include <stdio.h>     // snprintf
#include <string.h>    // strerror
#include <sys/mman.h>  // mlockall

enum { stack_bytes = 256 * 1024 };

static struct {
    int64_t tick_hz;
    lin_thread_tick_t *tick;
    sem_t ended;
    _Atomic bool is_over;
    _Atomic uint32_t n_overruns, last_ns, max_ns;
} thread;

/// Format and print a warning.
__attribute__((format(printf, 1, 2))) static void warn(const char *format, ...)
{
    common_error_t line;
    va_list args;
    va_start(args, format);
    (void)vsnprintf(line.text, sizeof line.text, format, args);
    va_end(args);
    hal_text(line.text);
}

static int last_allowed_cpu(void)
{
    cpu_set_t allowed;
    int last = 0;
    if (sched_getaffinity(0, sizeof allowed, &allowed) == 0) {
        for (size_t i = 0; i < CPU_SETSIZE; i++) {
            last = CPU_ISSET(i, &allowed) ? (int)i : last;
        }
    }
    return last;
}

bool lin_thread_prepare(const lin_thread_config_t *config, common_error_t *e)
{
    const int cpu = config->cpu >= 0 ? (int)config->cpu : last_allowed_cpu();
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET((unsigned)cpu, &one);
    if (sched_setaffinity(0, sizeof one, &one) != 0) {
        return common_error(e, "thread.cpu = %d: %s; give a CPU of this machine", cpu,
                            strerror(errno));
    }
    if (mlockall(MCL_CURRENT | MCL_FUTURE) != 0) {
        warn("warning: memory is not locked (%s): a page fault may delay a tick; raise "
             "LimitMEMLOCK",
             strerror(errno));
    }
    return true;
}

static void *run(void *unused)
{
    (void)unused;
    int64_t due_ns = lin_period_next(lin_clock_now(), thread.tick_hz);
    for (bool is_running = true; is_running;) {
        const struct timespec at = {.tv_sec = due_ns / lin_ns_per_s,
                                    .tv_nsec = due_ns % lin_ns_per_s};
        while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, NULL) == EINTR) {
        }
        const int64_t begin_ns = lin_clock_now();
        is_running = thread.tick(begin_ns);
        const int64_t took_ns = lin_clock_now() - begin_ns;
        const uint32_t shown_ns = took_ns > UINT32_MAX ? UINT32_MAX : (uint32_t)took_ns;
        atomic_store(&thread.last_ns, shown_ns);
        if (shown_ns > atomic_load(&thread.max_ns)) {
            atomic_store(&thread.max_ns, shown_ns);
        }
        atomic_store(&thread.is_over, !is_running);
        (void)sem_post(&thread.ended);
        const int64_t last_ns = due_ns;
        due_ns = lin_period_next(lin_clock_now(), thread.tick_hz);
        atomic_fetch_add(&thread.n_overruns, lin_period_missed(last_ns, due_ns, thread.tick_hz));
    }
    return NULL;
}

/// @return error number
static int create(const pthread_attr_t *attributes)
{
    pthread_t id;
    const int err = pthread_create(&id, attributes, run, NULL);
    return err != 0 ? err : pthread_detach(id);
}

bool lin_thread_start(const lin_thread_config_t *config, lin_thread_tick_t *tick, common_error_t *e)
{
    const struct sched_param priority = {.sched_priority = (int)config->priority};
    pthread_attr_t attributes;
    thread.tick_hz = config->tick_hz;
    thread.tick = tick;
    if (sem_init(&thread.ended, 0, 0) != 0 || pthread_attr_init(&attributes) != 0) {
        return common_error(e, "the tick cannot start: %s", strerror(errno));
    }
    (void)pthread_attr_setstacksize(&attributes, stack_bytes);
    int err = EPERM;
    if (config->priority > 0) {
        (void)pthread_attr_setinheritsched(&attributes, PTHREAD_EXPLICIT_SCHED);
        (void)pthread_attr_setschedpolicy(&attributes, SCHED_FIFO);
        (void)pthread_attr_setschedparam(&attributes, &priority);
        err = create(&attributes);
    }
    if (err == EPERM) {
        warn(
            config->priority > 0
                ? "warning: SCHED_FIFO is not permitted: any busy program delays ticks, and a late "
                  "tick ends a cut; raise LimitRTPRIO"
                : "warning: thread.priority = 0: any busy program delays ticks, and a late tick "
                  "ends a cut");
        (void)pthread_attr_setinheritsched(&attributes, PTHREAD_INHERIT_SCHED);
        err = create(&attributes);
    }
    if (err == EAGAIN) { // the stack exceeds the limit of locked memory
        (void)munlockall();
        warn("warning: memory is not locked: the limit is too low; raise LimitMEMLOCK");
        err = create(&attributes);
    }
    (void)pthread_attr_destroy(&attributes);
    return err == 0 || common_error(e, "the tick cannot start: %s", strerror(err));
}

bool lin_thread_wait(void)
{
    while (sem_wait(&thread.ended) != 0 && errno == EINTR) {
    }
    while (sem_trywait(&thread.ended) == 0) { // ticks that ended while main() was busy
    }
    return !atomic_load(&thread.is_over);
}

hal_load_t lin_thread_load(void)
{
    return (hal_load_t){.last_cycles = atomic_load(&thread.last_ns),
                        .max_cycles = atomic_load(&thread.max_ns),
                        .cycles_hz = lin_ns_per_s};
}

uint32_t lin_thread_overruns(void)
{
    return atomic_load(&thread.n_overruns);
}
