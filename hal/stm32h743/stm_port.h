// SPDX-License-Identifier: Apache-2.0
/// stm_port: the peripherals of the port: clocks, pins, step outputs, timers, converters,
/// watchdogs, the tick around cam_isr(), CAN, self-test. Memories: memory/stm_memory.h.
#ifndef STM_PORT_H
#define STM_PORT_H

#include "board_config.h" // BOARD_TICK_HZ, BOARD_STEP_HIGH_NS
#include "stm_reg.h"      // GPIOE, RCC_AHB4ENR
#include <stdbool.h>      // bool
#include <stdint.h>       // int32_t, uint32_t

// 480 MHz from the HSE, or from the HSI when the HSE does not start.

/// Source of the clocks.
typedef enum {
    stm_clock_hse,  ///< crystal accuracy
    stm_clock_hsi,  ///< the same frequencies within about 1 %: for diagnosis, not for cutting
    stm_clock_fail, ///< supply or PLL not ready: still 64 MHz as after reset
} stm_clock_t;

/// [Hz] frequencies once stm_clock_init() has succeeded.
enum {
    stm_cpu_hz = 480000000,
    stm_timer_hz = 240000000, ///< of all timers
    stm_pll1q_hz = 80000000,  ///< kernel clock of SPI3 and FDCAN1
    stm_apb_hz = 120000000,
};

/// Raise supply and clocks from their state after reset, and let the clock security system
/// supervise the HSE.
/// @return source of the clocks
/// Context: slow side, once; blocks up to 0.2 s. Source: RM0433 6.6 (voltage scaling,
/// VOS0), 8.5 (PLLs, CSS), 4.3 (wait states).
stm_clock_t stm_clock_init(void);

// The function of each pin, and the safe state of the outputs.
//
// This is the wiring table of README.md in code. Source of the alternate functions: datasheet
// DS12110, tables "Port x alternate functions".

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

// Set-points of U, X and Z as step and direction, by TIM8, TIM16 and TIM17.
//
// A set-point is a whole number of steps. Each tick sends the difference between the set-point and
// the steps sent so far as a train of equal periods: the timer runs in one-pulse mode, and its
// repetition counter stops it after the last pulse. Steps that do not fit in a tick follow later,
// so the sum of all pulses always reaches the set-point:
//
//     tick        |___________________________|___________________________|
//     step        ____,--,__,--,__,--,_____________,---,____,---,__________
//                     <---- 3/4 of a tick --->
//     direction   constant from a whole tick before the first step of a train to its end
//
// - A train has at most stm_steps_most steps; the rest follow in the next ticks.
// - A train still running when the next one is due continues, and the next tick sends the rest.
// - A tick that reverses the direction sends only the new direction.
// - While enable is low no steps are sent, and set-points count as sent: a disabled drive does not
//   count steps and must not move when it is enabled.
// Source: RM0433 38.3, 41.3 (repetition counter, one-pulse mode), 41.4 (registers); ST AN4776,
// "N-pulse waveform generation".

/// Axes with step outputs.
enum { stm_step_x, stm_step_z, stm_step_u, stm_n_steppers };

/// [1 / stm_timer_hz] length of a train, high time of a step, shortest period.
enum {
    stm_steps_train = stm_timer_hz / BOARD_TICK_HZ * 3 / 4,
    stm_steps_high = stm_timer_hz / 1000000 * BOARD_STEP_HIGH_NS / 1000,
    stm_steps_period = stm_timer_hz / 1000000 * (BOARD_STEP_HIGH_NS + BOARD_STEP_LOW_NS) / 1000,
};

/// Steps that fit in a train.
enum { stm_steps_most = stm_steps_train / stm_steps_period };

/// @return [um/s] highest speed of an output. Rounding to whole steps takes one step per tick in
/// addition to those of the motion.
/// @param step_pm  [pm] of a step
static inline int32_t stm_steps_um_per_s(int32_t step_pm)
{
    const int64_t pm_per_s = (int64_t)step_pm * (stm_steps_most - 1) * BOARD_TICK_HZ;
    return (int32_t)(pm_per_s / 1000000 < INT32_MAX ? pm_per_s / 1000000 : INT32_MAX);
}

/// Set the timers up with their outputs low. Context: slow side, once, before the pins.
void stm_steps_init(void);

/// Set the set-point of an axis. Context: ISR.
/// @param stepper  stm_step_x, stm_step_z, stm_step_u
/// @param steps    [steps] any
void stm_steps_set_isr(uint32_t stepper, int32_t steps);

/// @return [steps] commanded position: steps sent, or set-points while off. Context: ISR.
int32_t stm_steps_sent_isr(uint32_t stepper);

/// Set whether the drives are enabled. Context: ISR.
void stm_steps_enable_isr(bool is_enabled);

/// Start the trains of this tick. Context: ISR, after the last set-point.
void stm_steps_send_isr(void);

// Tick, encoders and clock: TIM1 to TIM5.
//
// Hardware latches the spindle's counter at both edges of the index pulse. The port uses the
// position at which positive rotation enters the pulse: its rising edge. Negative rotation leaves
// the pulse at the same position, so the falling edge is used. The counter's direction bit, as
// read in the tick, selects the edge.
//
// TIM5 is the timestamp clock. Its channels 1 and 4 capture it at every edge of A and B, so the
// later capture is the time of the last counted edge.

/// Faults of the port. With any of them hal_inputs_read_isr() reports the drives as not ready until
/// the next reset, so the controller retracts and does not restart.
enum {
    stm_fault_clock = 1u << 0,   ///< the HSE did not start: rates are within 1 % only
    stm_fault_overrun = 1u << 1, ///< a tick had not ended when the next one was due
    stm_fault_late = 1u << 2,    ///< set-points were not yet sent when the outputs stepped
    stm_fault_dac = 1u << 3,     ///< a transfer to the AD5754R did not end within a period
    stm_fault_edges = 1u << 4,   ///< edges of the spindle were counted, but not stamped
};

/// All faults since the start. Written by the tick, and by the slow side before the tick runs.
extern volatile uint32_t stm_faults;

/// Set all five timers up. Encoders and clock run afterwards, the tick does not.
/// Context: slow side, once.
/// Source: RM0433 38.3, 39.3 (encoder interface, input capture, PWM), 39.4 (registers).
void stm_timers_init(void);

/// Start TIM4 and its interrupt. Context: slow side.
void stm_timers_start_tick(void);

/// Acknowledge the tick. Context: ISR, at its start.
void stm_timers_tick_begin_isr(void);

/// @return whether the next tick is already due. Context: ISR, at its end.
bool stm_timers_is_overrun_isr(void);

/// @return whether a transfer started now would end after the outputs step. Context: ISR.
bool stm_timers_is_late_isr(void);

/// Pull /LDAC low at once instead of BOARD_UPDATE_NS after the start of the tick, or undo that.
/// Context: ISR, before that time.
void stm_timers_ldac_isr(bool is_low);

/// @return [counts] position of the U scale since start. Context: ISR, every tick.
int32_t stm_timers_u_counts_isr(void);

/// @return [counts] position of the Z scale since start. Context: ISR, every tick.
int32_t stm_timers_z_counts_isr(void);

// Outputs set-points as voltages: an AD5754R on SPI3, and for U also the internal DAC.
//
// Four frames of 24 bits are sent at the end of a tick. The outputs do not change until TIM4 pulls
// /LDAC low and triggers the internal DAC, so all of them step together, always BOARD_UPDATE_NS
// after the start of the tick. The AD5754R is strapped to two's complement (BIN/2sCOMP low). Its
// /CLR is the enable line PE13: while that is low, by the program or by its resistor in a reset,
// the outputs are at 0 V. Control register bit 1, clear select, stays 0: clear to 0 V.
//
// A force of U does not wait for that: stm_dac_send_u_isr() sends its frame alone, with /LDAC low,
// so that the output changes when /SYNC rises. The other three are sent at the end of the tick.
// Source: AD5754R data sheet, "Serial interface", "Input shift register"; RM0433 chapters 26, 50.

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

// Two watchdogs, which reset the device and so release the outputs.
//
// The independent watchdog, IWDG1, has its own clock and resets after a second without a feed. It
// supervises the main loop, and through it the tick. The window watchdog, WWDG1, is fed at the
// start of each tick, above 25 kHz of every second. It resets if ticks stop, at 20 kHz after 171
// to 205 us, or if they come so fast that a feed falls into the closed steps of 34 us: motion is
// computed per tick, so a tick timer that runs fast would move the axes beyond their speed limits.

/// Start both when the tick starts. Only a reset, or a debugger that halts the core, stops them.
/// Source: RM0433 44.3, 44.4 (WWDG), 45.3 (IWDG), 60.5 (freeze). Context: slow side, once.
void stm_watch_start(void);

/// Report that the main loop is running. Context: slow side.
void stm_watch_feed(void);

/// Feed the window watchdog at the start of a tick. Context: ISR.
/// @param is_behind  the last tick overran: this one may start before the window opens and does
///                   not feed the watchdog
void stm_watch_tick_isr(bool is_behind);

// The interrupt around cam_isr(), and its duration.

/// The tick: handler of TIM4's interrupt. Context: ISR.
void stm_tick_isr(void);

/// Start the cycle counter. Context: slow side, once. Source: ARMv7-M ARM C1.8.
void stm_tick_init(void);

/// @return number of ticks since the start, wraps. Context: slow side.
uint32_t stm_tick_count(void);

// FDCAN1, polled. All frames with 11-bit identifiers go into receive FIFO 0.
//
// The bus runs at 500 kbit/s with the sample point at 80 %, the data of FD frames at 2 Mbit/s and
// 75 %. Frames of more than 8 bytes are sent as FD frames with the higher rate. After bus-off the
// next call of hal_can_read() or hal_can_write() starts the return to the bus.

/// Set FDCAN1 up.
/// @return false when the peripheral does not enter its configuration state
/// Context: slow side, once. Source: RM0433 chapter 56 (operating modes, message RAM).
bool stm_can_init(void);

/// Send a frame of 64 bytes to oneself by the internal loop-back, off the bus, then join it again.
/// Frames that wait to be read or sent are lost.
/// @return whether the frame came back within 2 ms
/// Context: slow side. Source: RM0433 chapter 56, test modes; FDCAN_TEST, FDCAN_CCCR.
bool stm_can_loop_back(void);

// A report on the board over the serial line, for boards that nobody here has.
//
// The letter t from the terminal starts it, while the drives are disabled. Each line of the report
// names a part, `ok` or `FAILED`, and what was measured. It ends with a reset by the independent
// watchdog, which is its last check.

/// Run the self-test if the terminal has asked for it. While the drives are enabled or flash is
/// being written, one line refuses it. Context: slow side, at every wake-up of the main loop.
/// Does not return from a self-test: half a second of report, then the reset.
void stm_selftest_poll(void);

#endif
