// SPDX-License-Identifier: Apache-2.0
#define _GNU_SOURCE // NOLINT(bugprone-reserved-identifier): recvmmsg, ppoll
#include "sim_link.h"
#include <errno.h>         // errno
#include <fcntl.h>         // open
#include <linux/can.h>     // struct canfd_frame
#include <linux/can/raw.h> // CAN_RAW_FD_FRAMES
#include <linux/gpio.h>    // GPIO_V2_GET_LINEINFO_IOCTL
#include <net/if.h>        // if_nametoindex
#include <poll.h>          // ppoll
#include <sched.h>         // sched_setscheduler
#include <signal.h>        // sigaction
#include <stdio.h>         // snprintf
#include <string.h>        // memcpy, strerror
#include <sys/ioctl.h>     // ioctl
#include <sys/prctl.h>     // prctl
#include <sys/socket.h>    // socket
#include <time.h>          // clock_nanosleep
#include <unistd.h>        // close

enum { line_estop, line_ready, line_index };
enum { line_enable, line_fault, line_in_cut };
enum { batch = 32, priority = 30, n_line_paths = 128 };
#define NS_PER_S INT64_C(1000000000)
#define UNLOCK_S 0.1

static volatile sig_atomic_t is_stopped;

static int64_t now_ns(void)
{
    struct timespec t;
    (void)clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec * NS_PER_S + t.tv_nsec;
}

static struct timespec timespec_of(int64_t ns)
{
    return (struct timespec){.tv_sec = ns / NS_PER_S, .tv_nsec = ns % NS_PER_S};
}

static bool open_can(sim_link_t *l, const char *interface, common_error_t *e)
{
    const int on = 1;
    struct sockaddr_can address = {.can_family = AF_CAN};
    address.can_ifindex = (int)if_nametoindex(interface);
    if (address.can_ifindex == 0) {
        return common_error(e, "--can %.40s: no such interface; see ip link", interface);
    }
    l->can = socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW);
    if (l->can < 0) {
        return common_error(e, "--can %.40s: no CAN sockets: %s; load the kernel's module can_raw",
                            interface, strerror(errno));
    }
    if (setsockopt(l->can, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, &on, sizeof on) != 0 ||
        bind(l->can, (const struct sockaddr *)&address, sizeof address) != 0) {
        return common_error(e, "--can %.40s: cannot be used: %s; it must be a CAN interface",
                            interface, strerror(errno));
    }
    int pending = 0; // bind() accepts an interface that is down
    socklen_t n = sizeof pending;
    if (getsockopt(l->can, SOL_SOCKET, SO_ERROR, &pending, &n) == 0 && pending != 0) {
        return common_error(e, "--can %.40s: %s; bring the interface up: ip link set %.40s up",
                            interface, strerror(pending), interface);
    }
    return true;
}

/// @return line number, below 0 when the chip has no line of that name
static int find_line(int chip, const char *name)
{
    struct gpiochip_info info = {0};
    if (ioctl(chip, GPIO_GET_CHIPINFO_IOCTL, &info) != 0) {
        return -1;
    }
    for (uint32_t i = 0; i < info.lines; i++) {
        struct gpio_v2_line_info line = {.offset = i};
        if (ioctl(chip, GPIO_V2_GET_LINEINFO_IOCTL, &line) == 0 && strcmp(line.name, name) == 0) {
            return (int)i;
        }
    }
    return -1;
}

static bool open_line(int *file, int chip, const char *chip_name, const char *line,
                      const char *what, int flags, common_error_t *e)
{
    char path[n_line_paths];
    const int number = find_line(chip, line);
    if (number < 0) {
        return common_error(e,
                            "--gpiochip %.40s: no line named %s; tools/linux_kernel/machine lists "
                            "the lines",
                            chip_name, line);
    }
    (void)snprintf(path, sizeof path, "/sys/bus/gpio/devices/%.40s/sim_gpio%d/%s", chip_name,
                   number, what);
    *file = open(path, flags | O_CLOEXEC);
    return *file >= 0 ||
           common_error(e, "%s: cannot be opened: %s; --gpiochip must name a chip of gpio-sim",
                        path, strerror(errno));
}

static bool open_lines(sim_link_t *l, const char *chip_name, common_error_t *e)
{
    static const char *const in[sim_link_inputs] = {"ESTOP", "READY", "INDEX"};
    static const char *const out[sim_link_outputs] = {"ENABLE", "FAULT", "INCUT"};
    char path[n_line_paths];
    (void)snprintf(path, sizeof path, "/dev/%.40s", chip_name);
    const int chip = open(path, O_RDWR | O_CLOEXEC);
    if (chip < 0) {
        return common_error(e, "--gpiochip %.40s: %s: %s; see gpiodetect", chip_name, path,
                            strerror(errno));
    }
    bool is_good = true;
    for (int i = 0; i < sim_link_inputs && is_good; i++) {
        is_good = open_line(&l->pull[i], chip, chip_name, in[i], "pull", O_WRONLY, e);
    }
    for (int i = 0; i < sim_link_outputs && is_good; i++) {
        is_good = open_line(&l->value[i], chip, chip_name, out[i], "value", O_RDONLY, e);
    }
    (void)close(chip);
    return is_good;
}

static void pull(sim_link_t *l, int line, bool is_high)
{
    if (l->has_lines && l->is_high[line] != is_high) {
        const char *word = is_high ? "pull-up" : "pull-down";
        l->is_high[line] = is_high;
        l->n_unsent += pwrite(l->pull[line], word, strlen(word), 0) < 0 ? 1u : 0u;
    }
}

bool sim_link_open(sim_link_t *l, const char *interface, const char *chip, double period_s,
                   common_error_t *e)
{
    *l = sim_link_closed();
    l->period_ns = (int64_t)(period_s * 1e9 + 0.5);
    l->has_lines = chip != NULL;
    if (!open_can(l, interface, e) || (chip != NULL && !open_lines(l, chip, e))) {
        sim_link_close(l);
        return false;
    }
    for (int i = 0; i < sim_link_inputs; i++) {
        l->is_high[i] = true;
        pull(l, i, false);
    }
    // Without permission for real-time priority the nodes are sometimes a little late.
    const struct sched_param fifo = {.sched_priority = priority};
    (void)sched_setscheduler(0, SCHED_FIFO, &fifo);
    (void)prctl(PR_SET_TIMERSLACK, 1ul, 0ul, 0ul, 0ul);
    l->wake_ns = now_ns();
    return true;
}

void sim_link_close(sim_link_t *l)
{
    for (int i = 0; i < sim_link_inputs; i++) {
        if (l->pull[i] >= 0) {
            pull(l, i, false);
            (void)close(l->pull[i]);
        }
    }
    for (int i = 0; i < sim_link_outputs; i++) {
        if (l->value[i] >= 0) {
            (void)close(l->value[i]);
        }
    }
    if (l->can >= 0) {
        (void)close(l->can);
    }
    *l = sim_link_closed();
}

/// Hand the received frames to the nodes. @return true when a SYNC was among them
static bool receive(const sim_link_t *l, sim_bus_t *bus)
{
    struct canfd_frame raw[batch];
    struct iovec part[batch];
    struct mmsghdr message[batch];
    bool is_sync = false;
    int n = batch;
    memset(message, 0, sizeof message);
    for (int i = 0; i < batch; i++) {
        part[i] = (struct iovec){.iov_base = &raw[i], .iov_len = sizeof raw[i]};
        message[i].msg_hdr.msg_iov = &part[i];
        message[i].msg_hdr.msg_iovlen = 1;
    }
    while (n == batch) {
        n = recvmmsg(l->can, message, batch, 0, NULL);
        for (int i = 0; i < n; i++) {
            sim_frame_t frame = {.id = raw[i].can_id & CAN_SFF_MASK, .n = raw[i].len};
            const uint32_t foreign = CAN_EFF_FLAG | CAN_RTR_FLAG | CAN_ERR_FLAG;
            if ((raw[i].can_id & foreign) == 0u && frame.n <= sim_frame_max_bytes) {
                memcpy(frame.data, raw[i].data, frame.n);
                is_sync = is_sync || frame.id == canopen_id_sync;
                sim_bus_receive(bus, &frame);
            }
        }
    }
    return is_sync;
}

static void send_frames(sim_link_t *l, const sim_frame_t *frames, uint32_t n)
{
    struct canfd_frame raw[sim_frame_queue];
    struct iovec part[sim_frame_queue];
    struct mmsghdr message[sim_frame_queue];
    memset(message, 0, sizeof message);
    for (uint32_t i = 0; i < n; i++) {
        raw[i] = (struct canfd_frame){.can_id = frames[i].id, .len = (uint8_t)frames[i].n};
        memcpy(raw[i].data, frames[i].data, frames[i].n);
        part[i] = (struct iovec){.iov_base = &raw[i],
                                 .iov_len = frames[i].n > CAN_MAX_DLEN ? CANFD_MTU : CAN_MTU};
        message[i].msg_hdr.msg_iov = &part[i];
        message[i].msg_hdr.msg_iovlen = 1;
    }
    const int n_sent = n > 0u ? sendmmsg(l->can, message, n, 0) : 0;
    l->n_unsent += n - (uint32_t)(n_sent > 0 ? n_sent : 0);
}

static void sleep_until(int64_t ns)
{
    const struct timespec t = timespec_of(ns);
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, NULL) == EINTR && !is_stopped) {
    }
}

/// Do what is due before the next step, in order of time: index edge, late frame.
static void do_timed(sim_link_t *l)
{
    for (;;) {
        const bool is_index = l->index_ns != 0 && (l->late_ns == 0 || l->index_ns <= l->late_ns);
        const int64_t due_ns = is_index ? l->index_ns : l->late_ns;
        if (due_ns == 0 || due_ns >= l->wake_ns) {
            return;
        }
        sleep_until(due_ns);
        if (is_index) {
            pull(l, line_index, true);
            l->drop_ns = l->wake_ns + l->period_ns;
            l->index_ns = 0;
        } else {
            send_frames(l, &l->late, 1);
            l->late_ns = 0;
        }
    }
}

/// Until the phase is locked, look for a SYNC up to the next step; it sets the phase.
static void look_out(sim_link_t *l, sim_bus_t *bus)
{
    while (!l->is_locked && !is_stopped) {
        const int64_t left_ns = l->wake_ns - now_ns();
        if (left_ns <= 0) {
            return;
        }
        struct pollfd can = {.fd = l->can, .events = POLLIN};
        const struct timespec t = timespec_of(left_ns);
        if (ppoll(&can, 1, &t, NULL) > 0 && (can.revents & POLLIN) == 0) {
            return; // the interface is down
        }
        if (receive(l, bus)) {
            l->is_locked = true;
            l->wake_ns = now_ns() + l->period_ns / 2;
        }
    }
}

void sim_link_wait(sim_link_t *l, sim_bus_t *bus)
{
    l->wake_ns += l->period_ns;
    l->is_locked = l->is_locked && bus->time_s - bus->sync_s < UNLOCK_S;
    do_timed(l);
    look_out(l, bus);
    sleep_until(l->wake_ns);
    (void)receive(l, bus);
    if (l->drop_ns != 0 && l->wake_ns >= l->drop_ns) {
        pull(l, line_index, false);
        l->drop_ns = 0;
    }
}

static bool is_line_high(const sim_link_t *l, int line)
{
    char c = '0';
    return l->has_lines && pread(l->value[line], &c, 1, 0) == 1 && c == '1';
}

sim_bus_outputs_t sim_link_read(const sim_link_t *l)
{
    return (sim_bus_outputs_t){
        .is_enabled = is_line_high(l, line_enable),
        .is_fault = is_line_high(l, line_fault),
        .is_in_cut = is_line_high(l, line_in_cut),
    };
}

void sim_link_send(sim_link_t *l, sim_bus_t *bus)
{
    double late_s;
    send_frames(l, bus->out.frame, bus->out.n);
    pull(l, line_estop, !bus->inputs.is_estop);
    pull(l, line_ready, bus->inputs.is_ready);
    if (bus->index_s >= 0.0) {
        l->index_ns = l->wake_ns + (int64_t)(bus->index_s * 1e9);
    }
    if (sim_disturb_due(&bus->disturb, bus->time_s + bus->period_s, &l->late, &late_s)) {
        l->late_ns = l->wake_ns + (int64_t)((late_s - bus->time_s) * 1e9);
    }
}

static void on_signal(int number)
{
    (void)number;
    is_stopped = 1;
}

void sim_link_watch_signals(void)
{
    struct sigaction action = {.sa_handler = on_signal};
    (void)sigaction(SIGINT, &action, NULL);
    (void)sigaction(SIGTERM, &action, NULL);
}

bool sim_link_is_stopped(void)
{
    return is_stopped != 0;
}
