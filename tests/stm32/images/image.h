// SPDX-License-Identifier: Apache-2.0
/// image: start-up and registers of the little images that test the emulator's models.
///
/// Addresses and bits are written from RM0433 and the ARMv7-M manual once more, and only those that
/// the images need. The answers lie in `answer`, where the test reads them.
#ifndef IMAGE_H
#define IMAGE_H

#include <stdint.h> // uint32_t

#define REG(address) (*(volatile uint32_t *)(address))
#define RCC(offset) REG(0x58024400u + (offset))
#define TIM4(offset) REG(0x40000800u + (offset))

enum { image_n_answers = 16 };
extern volatile uint32_t answer[image_n_answers];

/// What runs behind the start-up; returns never or to a loop without end.
void image_main(void);

/// Interrupt 30, TIM4.
void image_tim4(void);

/// Non-maskable interrupt.
void image_nmi(void);

#endif
