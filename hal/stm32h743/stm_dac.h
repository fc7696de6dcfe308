// SPDX-License-Identifier: Apache-2.0
/// stm_dac: outputs set-points as voltages: an AD5754R on SPI3, and for U also the internal DAC.
///
/// Four frames of 24 bits are sent at the end of a tick. The outputs do not change until TIM4 pulls
/// /LDAC low and triggers the internal DAC, so all of them step together, always BOARD_UPDATE_NS
/// after the start of the tick. The AD5754R is strapped to two's complement (BIN/2sCOMP low). Its
/// /CLR is the enable line PE13: while that is low, by the program or by its resistor in a reset,
/// the outputs are at 0 V. Control register bit 1, clear select, stays 0: clear to 0 V.
///
/// A force of U does not wait for that: stm_dac_send_u_isr() sends its frame alone, with /LDAC low,
/// so that the output changes when /SYNC rises. The other three are sent at the end of the tick.
/// Source: AD5754R data sheet, "Serial interface", "Input shift register"; RM0433 chapters 26, 50.
#ifndef STM_DAC_H
#define STM_DAC_H

#include <stdbool.h> // bool
#include <stdint.h>  // int32_t, uint32_t

/// Outputs of the AD5754R.
enum { stm_dac_u, stm_dac_x, stm_dac_z, stm_dac_spindle, stm_n_dacs };

/// Bring up both converters with all outputs at 0 V.
/// @return false if SPI3 does not work; a missing AD5754R cannot be detected
/// Context: slow side, once, while TIM5 runs; blocks for less than a millisecond if SPI3 works.
bool stm_dac_init(void);

/// @return the frame with the AD5754R's power register that came over SDO in stm_dac_init(): 001Fh
///         in its low 16 bits if all channels and the reference are on; 0 without a wire.
/// Context: slow side.
uint32_t stm_dac_answer(void);

/// Set the code that the next stm_dac_send_isr() sends for an output. Context: ISR.
/// @param dac   stm_dac_u .. stm_dac_spindle
/// @param code  -32 768 .. 32 767; 0 is 0 V
void stm_dac_set_isr(uint32_t dac, int32_t code);

/// Set the code that the internal DAC outputs at the next step of the outputs. Context: ISR.
/// @param code  0 .. 4095; 2048 is the middle
void stm_dac_set_internal_isr(uint32_t code);

/// Output a force of U at once: send its frame with /LDAC low. Context: ISR, at the start of a
/// tick; only if BOARD_U_FORCE_MN is not 0.
/// @param code  as of stm_dac_set_isr()
void stm_dac_send_u_isr(int32_t code);

/// Start the transfer of the four codes; without that of U if it is a force, whose own transfer
/// ends first. Context: ISR, at the end of a tick.
/// @return false if the previous transfer had not ended; it is then aborted
bool stm_dac_send_isr(void);

#endif
