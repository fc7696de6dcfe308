// SPDX-License-Identifier: Apache-2.0
// A height or a pattern lies between two slices that the channel has, with any height, pattern,
// span and reciprocal: the 64 least and the 64 largest numbers of slices, each by itself.
#include "cam_eval.h"
#include "world.h"

void main(void)
{
    //@ loop unroll 128;
    for (uint32_t i = 0; i < 128; i++) {
        const uint32_t n = i < 64 ? 2 + i : cam_table_max_slices - 127 + i;
        cam_channel_t ch = {.n_slices = n};
        ch.z_first_nm = any(INT32_MIN, INT32_MAX);
        ch.span_nm = any(0, UINT32_MAX);
        ch.slices_per_nm_q48 = any(0, UINT32_MAX);
        (void)cam_eval_height(&ch, any(INT32_MIN, INT32_MAX));
        (void)cam_lobes_slice(n, any(0, UINT32_MAX));
    }
    Frama_C_show_each_end();
}
