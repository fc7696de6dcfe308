// SPDX-License-Identifier: Apache-2.0
// The two halves of the smooth step, any share of it and any lag: the share is split, since it
// occurs several times in each product.
#include "cam_envelope.c" // NOLINT: its functions are static
#include "world.h"

enum { shares = 256 };

void main(void)
{
    //@ loop unroll 256;
    for (int64_t i = 0; i < shares; i++) {
        const int64_t low = i << 23;
        const int32_t s_q31 = any(low, low + (1 << 23) - 1);
        (void)cam_envelope_smooth_q30(s_q31);
        (void)inverse_q30(s_q31, any(0, (1 << 28) - 1));
    }
    Frama_C_show_each_end();
}
