// SPDX-License-Identifier: Apache-2.0
/// stm_pins: the function of each pin, and the safe state of the outputs.
///
/// This is the wiring table of README.md in code. Source of the alternate functions: datasheet
/// DS12110, tables "Port x alternate functions".
#ifndef STM_PINS_H
#define STM_PINS_H

#include "stm_reg.h" // GPIOE, RCC_AHB4ENR

/// Lines on port E.
enum {
    stm_pin_estop = 10,  ///< PE10 in, 1: the chain is closed
    stm_pin_ready = 12,  ///< PE12 in, 1: all drives ready
    stm_pin_enable = 13, ///< PE13 out, 1: the drives hold their axes; 0 clears the AD5754R to 0 V
    stm_pin_fault = 14,  ///< PE14 out, 1: fault
    stm_pin_in_cut = 15, ///< PE15 out, 1: in cut
};

/// Lines on port D.
enum {
    stm_pin_home_u = 2,  ///< PD2 .. PD4 in, 0: U, X, Z on its home switch, whose contact is open
    stm_pin_index_u = 5, ///< PD5 .. PD7 in, 1: U, X, Z at an index mark
    stm_pin_key = 11,    ///< PD11 in, 1: the key switch is on
    stm_pin_acknowledge = 12,  ///< PD12 in, 1: the button is pressed
    stm_pin_limit_u_low = 13,  ///< PD13 in, 0: U is on the limit switch of its lower end ..
    stm_pin_limit_u_high = 15, ///< PD15 in, .. upper end; their contacts are open then
};

/// Lines on port C.
enum { stm_pin_u_direction = 9 }; ///< PC9 out, 1: U rises

/// Lines on port B.
enum {
    stm_pin_x_direction = 6, ///< PB6 out, 1: X rises
    stm_pin_z_direction = 7, ///< PB7 out, 1: Z rises
};

/// The bit of register BSRR that sets or resets a pin.
#define STM_BSRR(pin, is_set) (1u << ((is_set) ? (uint32_t)(pin) : (uint32_t)(pin) + 16u))

/// Safe levels, for BSRR: enable low, fault high, all others low; and the bits of MODER that make
/// these pins outputs. Source: RM0433 11.4.
#define STM_SAFE_LEVELS                                                                            \
    (STM_BSRR(stm_pin_enable, 0) | STM_BSRR(stm_pin_fault, 1) | STM_BSRR(stm_pin_in_cut, 0))
#define STM_OUTPUT_MODES_MASK 0xFC000000u // pins 13 .. 15
#define STM_OUTPUT_MODES 0x54000000u

/// Bits of port B's MODER that make PB3 an input when cleared. After a reset PB3 is the output of
/// the debug unit's trace, while the receiver of spindle B drives it. RM0433 11.3.1, 60.4.
#define STM_TRACE_MODE_MASK (3u << 2 * 3)

/// Make the outputs safe: enable low, fault high, all others low. The levels are set before the
/// pins become outputs.
/// Context: any, even before memory is set up: it is inlined and reads no constants from memory.
/// Start-up does the same from its own table.
/// Source: RM0433 11.4, GPIOx_BSRR, GPIOx_MODER; 8.7, RCC_AHB4ENR.
__attribute__((always_inline)) static inline void stm_outputs_safe(void)
{
    RCC_AHB4ENR |= RCC_AHB4ENR_GPIOE;
    (void)RCC_AHB4ENR; // the clock runs two cycles after the write has arrived
    GPIOE->BSRR = STM_SAFE_LEVELS;
    GPIOE->MODER = (GPIOE->MODER & ~STM_OUTPUT_MODES_MASK) | STM_OUTPUT_MODES;
}

/// Configure all pins. Context: slow side, once.
void stm_pins_init(void);

#endif
