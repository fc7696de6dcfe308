// SPDX-License-Identifier: Apache-2.0
/// board_config: what a user of this port adapts to the machine: scales, rates, wiring.
#ifndef BOARD_CONFIG_H
#define BOARD_CONFIG_H

#include <stdint.h> // INT64_C

/// [Hz] rate of cam_isr(); 240 MHz divided by it is a whole number below 65 536.
#define BOARD_TICK_HZ 20000u

/// [ns] from the start of a tick to the step of all outputs (/LDAC). It is the same in every tick
/// and a part of the parameter lead_ns. It must be longer than the longest interrupt plus
/// BOARD_SEND_NS.
#define BOARD_UPDATE_NS 30000u

/// [ns] that the four frames to the AD5754R take at 20 MHz, gaps included, rounded up.
#define BOARD_SEND_NS 7000u

/// What feeds 8 MHz into OSC_IN. 0: the ST-LINK, or an oscillator of its own. 1: a crystal, fitted
/// as X3. FIRST_POWER.md says how accurate it must be, and how that is measured.
#define BOARD_HSE_IS_CRYSTAL 0

/// Set-points at which the four outputs reach +10 V, in [nm] and for the spindle in [r/min / 1000].
/// At least 65 537, so that a code per unit fits BOARD_CODES_Q32().
#define BOARD_U_FULL_NM 1000000
#define BOARD_X_FULL_NM 200000000
#define BOARD_Z_FULL_NM 500000000
#define BOARD_SPINDLE_FULL_MRPM 5000000

/// [pm] that X and Z move by a step of their step-and-direction outputs: at least 4000; 0: the
/// drive takes the voltage of its channel instead, whose code is a 32 768th of the numbers above. A
/// step of X is twice the form error that it leaves; one of Z counts by the slope of the part only.
#define BOARD_X_STEP_PM 50000
#define BOARD_Z_STEP_PM 500000

/// [ns] shortest time for which the step outputs are high, and low. 500 fits line drivers
/// (RS-422); inputs with optocouplers need 2500 or what the drive's data sheet says.
#define BOARD_STEP_HIGH_NS 500u
#define BOARD_STEP_LOW_NS 500u

/// [pm] per count (four edges per line) of the linear scales of U and Z. A position is 0 where the
/// axis stands when hal_init() runs.
#define BOARD_U_COUNT_PM 100000
#define BOARD_Z_COUNT_PM 1000000

/// [counts] added to the index position that is latched in the negative sense. It is 0 when the
/// index pulse begins between two counts. Encoders that gate the pulse with A and B begin it where
/// the counter moves, and the two senses may then differ by one count. To find out, turn the
/// spindle by hand in both senses, and enter the difference.
#define BOARD_INDEX_FALLING_COUNTS 0

/// 1: A and B of the spindle's encoder are wired to PA0 and PA3 as well, where TIM5 stamps each of
/// their edges. 0: they are not, and edges have no time. Edges that come without a time although it
/// is 1 are a fault of the port.
#define BOARD_HAS_EDGE_TIME 1

/// 1: U has a scale. 0: it has none. The last set-point is then returned as its position, so that
/// the following error is computed from the command and says nothing about the drive.
#define BOARD_HAS_U_SCALE 1

/// 1: Z has a scale. 0: it has none, and its position is the last set-point, in whole steps.
#define BOARD_HAS_Z_SCALE 1

/// Axes with a home switch at PD2, PD3, PD4: 1 U, 2 X, 4 Z, summed. The switch opens where it is
/// reached. What is not wired must not be in the sum: it would read as reached for ever.
#define BOARD_HOME_SWITCHES 0

/// Public keys whose tables are taken, as `tools/keys show --c` prints them, and how many: at
/// most 4. TABLE_FORMAT.md, "Signature", tells who holds the private ones.
#define BOARD_TRUST_N_KEYS 0
#define BOARD_TRUST_KEYS                                                                           \
    {                                                                                              \
        0                                                                                          \
    }

/// 1: a table without a signature of one of these keys is refused. 0: it is taken, but a wrong
/// signature is refused all the same. What UPDATE.md says of read-out protection belongs to it: who
/// can write the flash can write this, too.
#define BOARD_TRUST_REQUIRED 0

/// 1: a button of the machine is wired to PD10, by which somebody at it lets it move again behind
/// power-on, the emergency stop and faults; it closes to +3.3 V. Without a wire, or with 0, nothing
/// is ever enabled.
#define BOARD_HAS_ACKNOWLEDGE 1

/// 1: nothing is asked of anybody at the machine, so that whoever is on the CAN bus starts it. For
/// a bench without a machine, or where another control decides over the power of the drives.
#ifndef BOARD_ACKNOWLEDGE_IS_WAIVED
#define BOARD_ACKNOWLEDGE_IS_WAIVED 0
#endif

/// 1: a key switch is wired to PD11; +3.3 V allows changes of limits, constants and tables.
#define BOARD_HAS_KEY 1

/// What remote tools must know to do what the key does: 16 to 64 characters; "": nothing does. It
/// lies in the flash memory, where a debugger reads it.
#define BOARD_SECRET ""

/// Codes of a 16-bit converter per unit, in 2^-32, where 2^15 codes stand for the value at +10 V.
#define BOARD_CODES_Q32(full) ((int32_t)(((INT64_C(1) << 47) + (full) / 2) / (full)))

/// Steps per nanometre, in 2^-32; 0 without steps.
#define BOARD_STEPS_Q32(step_pm)                                                                   \
    ((int32_t)((step_pm) == 0                                                                      \
                   ? 0                                                                             \
                   : ((INT64_C(1000) << 32) + (step_pm) / 2) / ((step_pm) + ((step_pm) == 0))))

/// [pm] of a code of a 16-bit converter.
#define BOARD_CODE_PM(full) ((uint32_t)(INT64_C(1000) * (full) / 32768))

/// Nanometres per count, in 2^-16.
#define BOARD_NM_Q16(count_pm) ((int32_t)(((int64_t)(count_pm)*65536 + 500) / 1000))

#endif
