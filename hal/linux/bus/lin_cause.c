// SPDX-License-Identifier: Apache-2.0
#include "lin_bus.h"
#include <stdio.h> // snprintf

uint32_t lin_cause_pack(lin_cause_t cause)
{
    return (uint32_t)cause.loss << 24 | (cause.node & 0xFFu) << 16 | cause.detail;
}

lin_cause_t lin_cause_unpack(uint32_t word)
{
    return (lin_cause_t){.loss = (lin_loss_t)(word >> 24),
                         .node = word >> 16 & 0xFFu,
                         .detail = (uint16_t)(word & 0xFFFFu)};
}

static const char *role(uint32_t node, const lin_config_t *config)
{
    static const char *const drives[hal_n_axes] = {"drive u", "drive x", "drive z"};
    for (int i = 0; i < hal_n_axes; i++) {
        if (node == config->drive[i].node) {
            return drives[i];
        }
    }
    return node == config->spindle_node ? "spindle" : "encoder";
}

static void put_code(uint16_t code, char *text, size_t size)
{
    text[0] = '\0';
    if (code != 0u) {
        (void)snprintf(text, size, ": error code %04Xh", code);
    }
}

void lin_cause_bus_text(lin_cause_t cause, const lin_config_t *config, char *line, size_t size)
{
    char code[24];
    put_code(cause.detail, code, sizeof code);
    if (cause.node == 0u) {
        (void)snprintf(line, size, "bus: %s", lin_loss_text(cause.loss));
    } else {
        (void)snprintf(line, size, "bus: node %u (%s): %s%s", cause.node, role(cause.node, config),
                       lin_loss_text(cause.loss), code);
    }
}

void lin_cause_drives_text(lin_cause_t cause, const lin_config_t *config, char *line, size_t size)
{
    char code[24];
    put_code(cause.detail, code, sizeof code);
    if (cause.node == 0u) {
        (void)snprintf(line, size, "drives: ready");
    } else {
        const bool is_lost = cause.loss != lin_loss_none;
        (void)snprintf(line, size, "drives: node %u (%s) is not ready%s%s%s", cause.node,
                       role(cause.node, config), is_lost ? ": " : "",
                       is_lost ? lin_loss_text(cause.loss) : "", code);
    }
}
