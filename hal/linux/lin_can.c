// SPDX-License-Identifier: Apache-2.0
#include "lin_port.h"
#include <errno.h>           // errno
#include <linux/can.h>       // canfd_frame
#include <linux/can/error.h> // CAN_ERR_*
#include <linux/can/raw.h>   // CAN_RAW_FILTER
#include <net/if.h>          // if_nametoindex
#include <stdio.h>           // snprintf
#include <string.h>          // memcpy, strerror
#include <sys/ioctl.h>       // SIOCGIFFLAGS, SIOCGIFTXQLEN
#include <sys/socket.h>      // recvmmsg
#include <unistd.h>          // close

enum { batch = 32, max_batches = 4, control_bytes = 128 };

/// Time stamps outside these limits are ignored: the clock was set.
enum { oldest_ns = 1000000000, newest_ns = 10000000 };

static bool refuse(lin_can_t *can, const char *what, common_error_t *e)
{
    const int err = errno;
    if (can->fd >= 0) {
        (void)close(can->fd);
        can->fd = -1;
    }
    return common_error(e, "%s: %s: %s", can->interface, what, strerror(err));
}

static bool set_filters(const lin_can_t *can)
{
    struct can_filter list[lin_can_max_filters];
    const lin_can_filter_t *filters = can->filters;
    for (uint32_t i = 0; i < can->n_filters; i++) {
        list[i] = (struct can_filter){.can_id = filters[i].id,
                                      .can_mask = filters[i].mask | CAN_EFF_FLAG | CAN_RTR_FLAG};
    }
    const can_err_mask_t errors =
        CAN_ERR_BUSOFF | CAN_ERR_RESTARTED | CAN_ERR_CRTL | CAN_ERR_TX_TIMEOUT;
    return setsockopt(can->fd, SOL_CAN_RAW, CAN_RAW_FILTER, list,
                      (socklen_t)(can->n_filters * sizeof list[0])) == 0 &&
           setsockopt(can->fd, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &errors, sizeof errors) == 0;
}

static bool bind_to(lin_can_t *can)
{
    struct sockaddr_can address = {.can_family = AF_CAN,
                                   .can_ifindex = (int)if_nametoindex(can->interface)};
    return address.can_ifindex != 0 &&
           bind(can->fd, (struct sockaddr *)&address, sizeof address) == 0;
}

/// Check that the interface is up and, if needed, supports FD.
static bool check_interface(lin_can_t *can, bool is_fd, common_error_t *e)
{
    struct ifreq request;
    memset(&request, 0, sizeof request);
    (void)snprintf(request.ifr_name, sizeof request.ifr_name, "%s", can->interface);
    if (ioctl(can->fd, SIOCGIFFLAGS, &request) != 0) {
        return refuse(can, "no such CAN interface; `ip link` lists them", e);
    }
    if ((request.ifr_flags & IFF_UP) == 0) {
        errno = ENETDOWN;
        return refuse(
            can, "bring the interface up: ip link set NAME up, with the bit rate of the bus", e);
    }
    if (ioctl(can->fd, SIOCGIFMTU, &request) == 0 && is_fd && request.ifr_mtu != (int)CANFD_MTU) {
        errno = EMSGSIZE;
        return refuse(can,
                      "can.fd = true needs an interface with CAN FD: `fd on` when it is set up, or "
                      "a vcan with mtu 72",
                      e);
    }
    can->n_room = ioctl(can->fd, SIOCGIFTXQLEN, &request) == 0 ? (uint32_t)request.ifr_qlen : 0u;
    return true;
}

bool lin_can_open(lin_can_t *can, const char *interface, const lin_can_filter_t *filters,
                  uint32_t n, bool is_fd, common_error_t *e)
{
    *can = (lin_can_t){.fd = socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW),
                       .n_filters = n};
    memcpy(can->filters, filters, n * sizeof *filters);
    (void)snprintf(can->interface, sizeof can->interface, "%s", interface);
    if (can->fd < 0) {
        return refuse(can, "no CAN sockets in this kernel; load the modules can and can-raw", e);
    }
    if (!check_interface(can, is_fd, e)) {
        return false;
    }
    const int on = 1;
    if (setsockopt(can->fd, SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on) != 0 ||
        setsockopt(can->fd, SOL_SOCKET, SO_RXQ_OVFL, &on, sizeof on) != 0 ||
        (is_fd && setsockopt(can->fd, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, &on, sizeof on) != 0) ||
        !set_filters(can)) {
        return refuse(can, "the kernel refuses an option of the socket", e);
    }
    return bind_to(can) || refuse(can, "not a CAN interface; give another one", e);
}

static void note_errno(lin_can_t *can, int err)
{
    switch (err) {
    case EAGAIN: // no frame, or the socket buffer is full
    case ENOBUFS:
    case EINTR:
        break;
    case ENODEV:
    case ENXIO:
        atomic_store(&can->is_gone, true);
        can->link = lin_loss_interface_down;
        break;
    default: // ENETDOWN and others
        can->link = lin_loss_interface_down;
        break;
    }
}

/// Process an error frame: bus-off, restart, overflow of the CAN controller.
static void note_error(lin_can_t *can, const struct canfd_frame *frame)
{
    if ((frame->can_id & CAN_ERR_BUSOFF) != 0u) {
        can->link = lin_loss_bus_off;
    }
    if ((frame->can_id & CAN_ERR_RESTARTED) != 0u) {
        can->link = lin_loss_none;
    }
    if ((frame->can_id & CAN_ERR_CRTL) != 0u && (frame->data[1] & CAN_ERR_CRTL_RX_OVERFLOW) != 0) {
        can->event = lin_loss_overflow;
    }
}

/// Read the control messages: time stamp and overflow count.
/// @return arrival in CLOCK_REALTIME, 0: unknown
static int64_t read_control(lin_can_t *can, struct msghdr *header)
{
    int64_t ns = 0;
    for (struct cmsghdr *c = CMSG_FIRSTHDR(header); c != NULL; c = CMSG_NXTHDR(header, c)) {
        if (c->cmsg_level != SOL_SOCKET) {
            continue;
        }
        if (c->cmsg_type == SO_TIMESTAMPNS) {
            struct timespec stamp;
            memcpy(&stamp, CMSG_DATA(c), sizeof stamp);
            ns = lin_clock_of(&stamp);
        } else if (c->cmsg_type == SO_RXQ_OVFL) {
            uint32_t n;
            memcpy(&n, CMSG_DATA(c), sizeof n);
            can->event = n != can->n_overflow ? lin_loss_overflow : can->event;
            can->n_overflow = n;
        }
    }
    return ns;
}

typedef struct {
    struct mmsghdr headers[batch];
    struct iovec vectors[batch];
    struct canfd_frame frames[batch];
    _Alignas(struct cmsghdr) char control[batch][control_bytes];
} batch_t;

static int receive_batch(lin_can_t *can, batch_t *b, unsigned n)
{
    for (unsigned i = 0; i < n; i++) {
        b->vectors[i] = (struct iovec){&b->frames[i], sizeof b->frames[i]};
        b->headers[i].msg_hdr = (struct msghdr){.msg_iov = &b->vectors[i],
                                                .msg_iovlen = 1,
                                                .msg_control = b->control[i],
                                                .msg_controllen = control_bytes};
    }
    const int got = recvmmsg(can->fd, b->headers, n, MSG_DONTWAIT, NULL);
    if (got < 0) {
        note_errno(can, errno);
    }
    return got < 0 ? 0 : got;
}

static bool to_frame(const struct canfd_frame *from, hal_can_frame_t *frame)
{
    if (from->len > hal_can_max_bytes) {
        return false;
    }
    *frame = (hal_can_frame_t){.id = from->can_id & CAN_SFF_MASK, .n = from->len};
    memcpy(frame->data, from->data, from->len);
    return true;
}

/// @param stamp_ns  CLOCK_REALTIME, 0: none
/// @return          the same instant in CLOCK_MONOTONIC
static int64_t arrival(int64_t stamp_ns, int64_t epoch_ns, int64_t now_ns)
{
    const int64_t age_ns = now_ns - (stamp_ns - epoch_ns);
    const bool is_good = stamp_ns != 0 && age_ns < oldest_ns && age_ns > -newest_ns;
    return is_good ? now_ns - age_ns : now_ns;
}

void lin_can_receive(lin_can_t *can, lin_can_handler_t *take, void *user)
{
    static batch_t b; // used by the tick only
    const int64_t now_ns = lin_clock_now();
    const int64_t epoch_ns = lin_clock_read(CLOCK_REALTIME) - now_ns;
    for (int round = 0, got = batch; round < max_batches && got == batch; round++) {
        got = receive_batch(can, &b, batch);
        for (int i = 0; i < got; i++) {
            const int64_t stamp_ns = read_control(can, &b.headers[i].msg_hdr);
            hal_can_frame_t frame;
            if ((b.frames[i].can_id & CAN_ERR_FLAG) != 0u) {
                note_error(can, &b.frames[i]);
            } else if (to_frame(&b.frames[i], &frame)) {
                take(user, &frame, arrival(stamp_ns, epoch_ns, now_ns));
            }
        }
    }
}

bool lin_can_receive_one(lin_can_t *can, hal_can_frame_t *frame)
{
    static batch_t b; // used by main() only
    while (receive_batch(can, &b, 1) == 1) {
        (void)read_control(can, &b.headers[0].msg_hdr);
        if ((b.frames[0].can_id & CAN_ERR_FLAG) != 0u) {
            note_error(can, &b.frames[0]);
        } else if (to_frame(&b.frames[0], frame)) {
            return true;
        }
    }
    return false;
}

uint32_t lin_can_send(lin_can_t *can, const hal_can_frame_t *frames, uint32_t n)
{
    struct mmsghdr headers[batch];
    struct iovec vectors[batch];
    struct canfd_frame out[batch];
    memset(headers, 0, sizeof headers);
    for (uint32_t i = 0; i < n && i < batch; i++) {
        out[i] = (struct canfd_frame){
            .can_id = frames[i].id, .len = (uint8_t)frames[i].n, .flags = CANFD_BRS};
        memcpy(out[i].data, frames[i].data, frames[i].n);
        vectors[i] = (struct iovec){&out[i], frames[i].n > CAN_MAX_DLEN ? CANFD_MTU : CAN_MTU};
        out[i].flags = frames[i].n > CAN_MAX_DLEN ? CANFD_BRS : 0;
        headers[i].msg_hdr = (struct msghdr){.msg_iov = &vectors[i], .msg_iovlen = 1};
    }
    const int sent = sendmmsg(can->fd, headers, n, MSG_DONTWAIT);
    if (sent == (int)n) {
        can->link = can->link == lin_loss_interface_down ? lin_loss_none : can->link;
        return n;
    }
    if (sent >= 0) { // the next call returns the error
        can->event = lin_loss_send;
        return (uint32_t)sent;
    }
    can->event = lin_loss_send;
    note_errno(can, errno);
    return 0;
}

lin_loss_t lin_can_take_event(lin_can_t *can)
{
    const lin_loss_t event = can->event;
    can->event = lin_loss_none;
    return event;
}

void lin_can_rebind(lin_can_t *can)
{
    // Clear the flag first, so that a removal reported by the tick meanwhile is not lost. The
    // kernel dropped the filters together with the interface.
    if (atomic_exchange(&can->is_gone, false) && !(set_filters(can) && bind_to(can))) {
        atomic_store(&can->is_gone, true);
    }
}
