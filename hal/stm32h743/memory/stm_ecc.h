// SPDX-License-Identifier: Apache-2.0
/// stm_ecc: counts memory errors corrected by hardware and halts on uncorrectable ones.
///
/// Flash and every RAM have an error-correction code: a single flipped bit in a word is corrected,
/// two are detected. Start-up first writes all RAM in use (stm_start.c), because the code is
/// random after power-on. Source: RM0433 chapter 3 (RAMECC), 4.3.12 (flash).
#ifndef STM_ECC_H
#define STM_ECC_H

#include <stdint.h> // uint32_t

/// Enable the monitors of ITCM, DTCM and AXI SRAM, and the interrupt of double errors.
/// Context: slow side, once, after stm_keep_start().
void stm_ecc_init(void);

/// Handler of the double errors of RAM: halt with the address. Context: ISR.
void stm_ecc_isr(void);

/// A double error of flash raises a bus fault, and so may one of RAM.
/// @param exception  reason of a halt without a double error
/// @return           text with the address of a double error, else `exception`; static
/// Context: any, before a halt.
const char *stm_ecc_why(const char *exception);

/// Count corrected errors. A cell that stays flipped counts once, until its memory shows an error
/// at another address. Context: slow side.
void stm_ecc_poll(void);

/// @return number of corrected errors since the start. Context: slow side.
uint32_t stm_ecc_corrected(void);

#endif
