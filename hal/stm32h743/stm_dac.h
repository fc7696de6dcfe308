// SPDX-License-Identifier: Apache-2.0
/// stm_dac: set-points as voltages: an AD5754R on SPI3 and, for U once more, the internal DAC.
///
/// Four frames of 24 bits go out at the end of a tick. Nothing changes until TIM4 lets /LDAC fall
/// and triggers the internal DAC, so all outputs step together, always BOARD_UPDATE_NS after the
/// start of the tick. The AD5754R is strapped to two's complement (BIN/2sCOMP low).
/// Source: AD5754R data sheet, "Serial interface", "Input shift register"; RM0433 chapters 26, 50.
#ifndef STM_DAC_H
#define STM_DAC_H

#include <stdbool.h> // bool
#include <stdint.h>  // int32_t, uint32_t

/// Outputs of the AD5754R.
enum { stm_dac_u, stm_dac_x, stm_dac_z, stm_dac_spindle, stm_n_dacs };

/// Bring up both converters with all outputs at 0 V.
/// @return false when SPI3 does not work; whether an AD5754R listens cannot be told
/// Context: slow side, once, while TIM5 runs; blocks below a millisecond when SPI3 works.
bool stm_dac_init(void);

/// Choose what stm_dac_send_isr() will send. Context: ISR.
/// @param code  -32 768 .. 32 767, 0: 0 V
void stm_dac_set_isr(uint32_t dac, int32_t code);

/// Choose the next value of the internal DAC. Context: ISR.
/// @param code  0 .. 4095, 2048: middle
void stm_dac_set_internal_isr(uint32_t code);

/// Start to send the four codes.
/// @return false when the transfer before has not ended; it is abandoned. Context: ISR.
bool stm_dac_send_isr(void);

#endif
