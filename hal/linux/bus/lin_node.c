// SPDX-License-Identifier: Apache-2.0
#include "lin_bus.h"
#include "canopen.h" // common_get_u16

enum { start_interval_ns = 100000000 };

const char *lin_loss_text(lin_loss_t loss)
{
    static const char *const texts[] = {
        [lin_loss_none] = "all nodes are heard",
        [lin_loss_bus_off] = "bus-off",
        [lin_loss_interface_down] = "the interface is down; bring it up: ip link set .. up",
        [lin_loss_overflow] = "received frames were lost",
        [lin_loss_send] = "a frame could not be sent",
        [lin_loss_other_controller] = "another controller sends on this bus",
        [lin_loss_listening] = "listening for another controller before the first frame",
        [lin_loss_heartbeat] = "no heartbeat",
        [lin_loss_restarted] = "restarted",
        [lin_loss_not_operational] = "not operational",
        [lin_loss_pdo] = "no measured values",
        [lin_loss_emcy] = "reports an error",
        [lin_loss_spindle] = "the spindle drive does not follow",
    };
    return texts[loss];
}

bool lin_node_receive(lin_node_t *n, const hal_can_frame_t *frame, int64_t ns)
{
    if (n->id == 0u) {
        return false;
    }
    if (frame->id == canopen_id_heartbeat + n->id && frame->n == 1u) {
        n->nmt = frame->data[0] & 0x7Fu; // bit 7 toggles with node guarding
        n->is_restarted = n->is_restarted || (n->is_heard && n->nmt == canopen_boot_up);
        n->is_heard = true;
        n->heard_ns = ns;
        return true;
    }
    if (frame->id == canopen_id_emcy + n->id && frame->n == 8u) {
        n->emcy = common_get_u16(frame->data);
        return true;
    }
    return false;
}

lin_loss_t lin_node_judge(lin_node_t *n, int64_t now_ns, int64_t timeout_ns)
{
    const bool is_restarted = n->is_restarted;
    n->is_restarted = false;
    if (!n->is_heard || now_ns - n->heard_ns > timeout_ns) {
        return lin_loss_heartbeat;
    }
    if (is_restarted) {
        return lin_loss_restarted;
    }
    return n->nmt == canopen_operational ? lin_loss_none : lin_loss_not_operational;
}

bool lin_node_start(lin_node_t *n, int64_t now_ns, hal_can_frame_t *frame)
{
    if (n->id == 0u || !n->is_heard || n->nmt == canopen_operational ||
        now_ns - n->start_ns < start_interval_ns) {
        return false;
    }
    n->start_ns = now_ns;
    *frame =
        (hal_can_frame_t){.id = canopen_id_nmt, .n = 2, .data = {canopen_start, (uint8_t)n->id}};
    return true;
}
