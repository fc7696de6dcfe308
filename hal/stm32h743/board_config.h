// SPDX-License-Identifier: Apache-2.0
/// board_config: what a user of this port adapts to the machine: scales, rates, wiring.
#ifndef BOARD_CONFIG_H
#define BOARD_CONFIG_H

#include <stdint.h> // INT64_C

/// [Hz] rate of cam_isr(), 5000 .. 50 000, such that 240 MHz divided by it is a whole number.
#ifndef BOARD_TICK_HZ
#define BOARD_TICK_HZ 20000u
#endif

/// [ns] from the start of a tick to the step of all outputs (/LDAC). It is the same in every tick
/// and a part of the parameter lead_ns. It must be longer than the longest interrupt plus
/// BOARD_SEND_NS, so above 30 kHz it is nine tenths of a tick.
#define BOARD_UPDATE_NS (BOARD_TICK_HZ > 30000u ? 900000000u / BOARD_TICK_HZ : 30000u)

/// [ns] from the end of the interrupt until the four frames have reached the AD5754R at 20 MHz,
/// gaps included, rounded up.
#define BOARD_SEND_NS 7500u

/// Source of the 8 MHz at OSC_IN. 0: the ST-LINK or an external oscillator. 1: a crystal, fitted as
/// X3. FIRST_POWER.md gives the required accuracy and how to measure it.
#define BOARD_HSE_IS_CRYSTAL 0

/// Set-points at which the four outputs reach +10 V, in [nm] and for the spindle in [r/min / 1000].
/// At least 65 537, so that a code per unit fits BOARD_CODES_Q32().
#define BOARD_U_FULL_NM 1000000
#define BOARD_X_FULL_NM 200000000
#define BOARD_Z_FULL_NM 500000000
#define BOARD_SPINDLE_FULL_MRPM 5000000

/// [mN] force of U at +10 V of its channel, 1025 .. 33 000 000, for a current amplifier whose motor
/// drives U up with a positive voltage. The controller then closes U's position loop: U needs its
/// scale and the limit switches at PD13 and PD15. 0: the channel outputs positions.
#ifndef BOARD_U_FORCE_MN
#define BOARD_U_FORCE_MN 0
#endif

/// [ns] from the latch of U's scale to the new voltage of U's channel: README.md, "Force of U".
#define BOARD_FORCE_NS 2500u

/// [pm] travel of U, X and Z per step of their step-and-direction outputs: at least 4000. 0: the
/// drive uses the voltage of its channel instead, with 32 768 codes for the ranges above. A step of
/// U or X leaves a form error of half its size; for Z that is multiplied by the slope of the part.
#ifndef BOARD_U_STEP_PM
#define BOARD_U_STEP_PM 0
#endif
#define BOARD_X_STEP_PM 50000
#define BOARD_Z_STEP_PM 500000

/// [ns] minimum high and low time of the step outputs. 500 suits line drivers (RS-422);
/// optocoupler inputs need 2500 or the value in the drive's data sheet.
#define BOARD_STEP_HIGH_NS 500u
#define BOARD_STEP_LOW_NS 500u

/// [pm] per count (four edges per line) of the linear scales of U and Z. The position
/// at hal_init() becomes 0.
#define BOARD_U_COUNT_PM 100000
#define BOARD_Z_COUNT_PM 1000000

/// [counts] added to the index position latched in negative rotation; 0 if the index pulse starts
/// between two counts. Encoders that gate the pulse with A and B start it on a count, so the two
/// directions may differ by one count. To find out, turn the spindle by hand in both directions and
/// enter the difference.
#define BOARD_INDEX_FALLING_COUNTS 0

/// 1: A and B of the spindle encoder are also wired to PA0 and PA3, where TIM5 timestamps every
/// edge. 0: not wired, so edges have no timestamp. If it is 1, edges without a timestamp are a
/// fault of the port.
#define BOARD_HAS_EDGE_TIME 1

/// 1: U has a scale. 0: its last set-point, in whole steps if it has any, is returned as its
/// position, so the following error is computed from the command and shows nothing about the drive.
#define BOARD_HAS_U_SCALE 1

/// 1: Z has a scale. 0: its position is the last set-point, in whole steps.
#define BOARD_HAS_Z_SCALE 1

/// Axes with a home switch at PD2, PD3, PD4: 1 U, 2 X, 4 Z, summed. A switch opens when
/// reached. Leave out axes without a switch: they would always read as reached.
#define BOARD_HOME_SWITCHES 0

/// 1: an acknowledge button on the machine is wired to PD12 and closes to +3.3 V. It must be
/// pressed before the machine can move after power-on, an emergency stop or a fault. Without a
/// wire, or with 0, nothing can be enabled.
#define BOARD_HAS_ACKNOWLEDGE 1

/// 1: no acknowledgement is required, so any node on the CAN bus can start the machine. For a bench
/// without a machine, or where another control switches the drives' power.
#ifndef BOARD_ACKNOWLEDGE_IS_WAIVED
#define BOARD_ACKNOWLEDGE_IS_WAIVED 0
#endif

/// 1: a key switch is wired to PD11; +3.3 V permits changes to limits, constants and tables.
#define BOARD_HAS_KEY 1

/// Codes of a 16-bit converter per unit, in 2^-32, where 2^15 codes stand for the value at +10 V.
#define BOARD_CODES_Q32(full) ((int32_t)(((INT64_C(1) << 47) + (full) / 2) / (full)))

/// Steps per nanometre, in 2^-32; 0 without steps.
#define BOARD_STEPS_Q32(step_pm)                                                                   \
    ((int32_t)((step_pm) == 0                                                                      \
                   ? 0                                                                             \
                   : ((INT64_C(1000) << 32) + (step_pm) / 2) / ((step_pm) + ((step_pm) == 0))))

/// Force at +10 V, in [mN / 64]; any number where U takes positions.
#define BOARD_U_FORCE_Q6 (BOARD_U_FORCE_MN == 0 ? 1 << 17 : BOARD_U_FORCE_MN * 64)

/// [pm] of a code of a 16-bit converter; [uN] if `full` is in mN.
#define BOARD_CODE_PM(full) ((uint32_t)(INT64_C(1000) * (full) / 32768))

/// Nanometres per count, in 2^-16.
#define BOARD_NM_Q16(count_pm) ((int32_t)(((int64_t)(count_pm)*65536 + 500) / 1000))

#endif
