// SPDX-License-Identifier: Apache-2.0
// Reads the address that the test has put into peek_at.
#include "image.h"

volatile uint32_t peek_at;

void image_nmi(void) {}

void image_tim4(void) {}

void image_main(void)
{
    answer[0] = *(volatile uint32_t *)peek_at;
}
