// SPDX-License-Identifier: Apache-2.0
// A table that the check accepts is cut: the input is a head, what the spindle does, and an image.
// Every tick is judged.
#include "cam_machine.h"
#include "fuzz_bytes.h"
#include "fuzz_expect.h"
#include "fuzz_image.h"
#include "fuzz_mutate.h"
#include "fuzz_orders.h"
#include "fuzz_rig.h"
#include "hal_host.h"
#include <string.h>

/// Three things that happen to the spindle, four bytes each, and how the rig starts.
enum { n_events = 3, head_bytes = 4 + 4 * n_events, most_bytes = 8192 };
enum { ready_ticks = 700, cut_ticks = 150 };

static _Alignas(32) uint8_t image[most_bytes];

static void until_ready(void)
{
    for (uint32_t i = 0; i < (uint32_t)ready_ticks && fuzz_rig_state() == cam_state_homing;
         i += 8u) {
        fuzz_ticks(8);
    }
}

static void disturb(fuzz_bytes_t *b)
{
    const uint8_t what = fuzz_u8(b);
    const uint8_t pause = fuzz_u8(b);
    const int16_t value = (int16_t)fuzz_u16(b);
    fuzz_ticks(pause);
    switch (what % 8u) {
    case 0:
        fuzz_disturb(fuzz_disturb_counts, (uint16_t)value);
        break;
    case 1:
        fuzz_disturb(fuzz_disturb_speed, (uint16_t)value);
        break;
    case 2:
        fuzz_rig.lathe.is_spindle_held = false;
        break;
    case 3:
        hal_host_fault_late((uint32_t)(uint16_t)value % 200u);
        break;
    case 4:
        fuzz_try(cam_machine_set_param(&fuzz_rig.machine, cam_param_amplitude_ppm, value * 40));
        break;
    case 5:
        fuzz_try(cam_machine_set_param(&fuzz_rig.machine, cam_param_phase_udeg, value * 4000));
        break;
    case 6:
        fuzz_try(cam_machine_stop(&fuzz_rig.machine));
        break;
    default:
        fuzz_try(cam_machine_start(&fuzz_rig.machine));
        break;
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (size < (size_t)head_bytes || size > (size_t)(head_bytes + most_bytes)) {
        return -1;
    }
    fuzz_bytes_t b = {.at = data, .n = head_bytes};
    const uint8_t rate = fuzz_u8(&b) % 3u;
    static const uint32_t rates[] = {1000, 2000, 5000};
    fuzz_rig_start((fuzz_start_t){.tick_hz = rates[rate], .part = 0, .state = cam_state_off});
    const size_t n_image = size - (size_t)head_bytes;
    memcpy(image, data + head_bytes, n_image);
    cam_machine_t *m = &fuzz_rig.machine;
    if (fuzz_rig_select(image, n_image) != cam_ok) {
        return 0;
    }
    fuzz_ticks(1);
    const int32_t mrpm = fuzz_u8(&b) * 10000;
    fuzz_try(cam_machine_set_param(m, cam_param_spindle_mrpm, mrpm));
    fuzz_ticks(1);
    (void)fuzz_u16(&b);
    if (cam_machine_enable(m) != cam_ok) {
        return 0;
    }
    fuzz_ticks(8);
    until_ready();
    fuzz_try(cam_machine_start(m));
    for (uint32_t i = 0; i < (uint32_t)n_events; i++) {
        disturb(&b);
    }
    fuzz_ticks(cut_ticks);
    return 0;
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned seed)
{
    if (seed % 8u == 0u && size >= (size_t)head_bytes) { // what happens, the image as it is
        uint8_t head[head_bytes];
        memcpy(head, data, sizeof head);
        (void)LLVMFuzzerMutate(head, sizeof head, sizeof head);
        memcpy(data, head, sizeof head);
        return size;
    }
    return fuzz_image_mutate(data, size, max_size, seed, head_bytes);
}
