// SPDX-License-Identifier: Apache-2.0
/// hal: everything that the firmware asks of a machine, and the one thing that a machine asks of
/// it.
///
/// A port is a folder hal/<name> that implements "port provides"; it is chosen at link time
/// and calls cam_isr() at a constant rate. Functions with the suffix `_isr` are called from the
/// interrupt only: they never block and never fail; their longest time is given for a 480 MHz
/// Cortex-M7. The others belong to the slow side and are called from main() only.
/// hal/template tells a porter function by function what to guarantee.
#ifndef HAL_HAL_H
#define HAL_HAL_H

#include <stdbool.h> // bool
#include <stdint.h>  // int32_t, uint32_t

/// Axes with a position set-point. Positions are signed nanometres:
/// U rises towards the spindle axis (0: tool tip on the long axis), X is the radius that the tool
/// tip would turn at U = 0 and rises away from the axis, Z is the skirt height of the drawing.
typedef enum { hal_axis_u, hal_axis_x, hal_axis_z, hal_n_axes } hal_axis_t;

/// Bits of hal_inputs_read_isr().
enum {
    hal_in_estop = 1u << 0,       ///< 1: the emergency-stop chain is open
    hal_in_drive_ready = 1u << 1, ///< 1: all drives are able to follow
    hal_in_bus_lost = 1u << 2, ///< 1: a node on a field bus went silent or frames were lost; kept
                               ///< while hal_out_fault is written. Not ready as well when it
                               ///< takes a drive along; 0 of a port without a field bus
};

/// Bits of hal_outputs_write_isr().
enum {
    hal_out_enable = 1u << 0, ///< 1: the drives hold their axes
    hal_out_fault = 1u << 1,  ///< 1: a fault is latched
    hal_out_in_cut = 1u << 2, ///< 1: the tool cuts at full amplitude
};

/// One reading of the spindle encoder, all members of the same instant.
typedef struct {
    uint32_t counts;       ///< [counts] free-running, four edges per line, wraps by design
    uint32_t index_counts; ///< [counts] position of the last index edge: the same edge, hence the
                           ///< same number (modulo a turn), for both senses of rotation
    uint32_t n_index;      ///< index edges seen since start, wraps
} hal_encoder_t;

/// Set-point of one axis, derivatives per tick: a port that needs SI multiplies by hal_tick_hz().
/// Drives that take a position only ignore the rest.
typedef struct {
    int32_t pos_nm;  ///< [nm] with the feed-forward added
    int32_t vel_q10; ///< [nm / 1024 per tick] velocity of the wanted motion (CiA 402: 60B1h)
    int32_t acc_q10; ///< [nm / 1024 per tick^2] its acceleration (CiA 402: 60B2h)
} hal_setpoint_t;

/// Set-point of the swing axis: the tool's angle about the swing's centre, 0 along the line of
/// centres, rising in the sense in which the follower runs round the cam (TABLE_FORMAT.md,
/// "Lobes").
typedef struct {
    int32_t pos_q32; ///< [turn / 2^32] at the tick in which it is written
    int32_t vel_q32; ///< [turn / 2^32 per tick] the drive goes on at this until the next set-point
} hal_swing_t;

/// Why the processor started. Of several reasons at once the later one in this list counts.
typedef enum {
    hal_reset_power_on,
    hal_reset_pin,       ///< reset button, debugger
    hal_reset_software,  ///< asked for, without hal_halt()
    hal_reset_halt,      ///< hal_halt(): hal_start_t tells why
    hal_reset_watchdog,  ///< the firmware stood still
    hal_reset_brown_out, ///< the supply fell
} hal_reset_t;

/// What the port knows of the start.
typedef struct {
    hal_reset_t reset;
    const char *why; ///< text of the hal_halt() before this start, "" without one; static
} hal_start_t;

/// Bytes of the place where a table image is kept.
typedef struct {
    const void *bytes;
    uint32_t size; ///< [bytes] that may be read; 0: the port keeps no table
} hal_image_t;

enum { hal_table_grain = 32 }; ///< [bytes] that a flash memory programs at once

/// Duration of the interrupt, its entry not counted.
typedef struct {
    uint32_t last_cycles;
    uint32_t max_cycles; ///< since start
    uint32_t cycles_hz;  ///< [Hz] of the cycles; 0: the port does not measure
} hal_load_t;

enum { hal_can_max_bytes = 64 };

/// A CAN frame, classic (n <= 8) or FD.
typedef struct {
    uint32_t id; ///< 11 bits
    uint32_t n;  ///< [bytes] 0 .. 8, and for FD 12, 16, 20, 24, 32, 48, 64
    uint8_t data[hal_can_max_bytes];
} hal_can_frame_t;

// Port provides: slow side

/// Bring up clocks, pins and peripherals with all outputs safe (enable low); the tick does not run.
/// @return 0, or a negative number of the port's own when the machine cannot be used
/// Context: main(), once, may block up to a second. Simulator: resets its state.
int hal_init(void);

/// @return [Hz] rate at which cam_isr() is called, 500 .. 100 000, constant after hal_init()
uint32_t hal_tick_hz(void);

/// @return whether the machine has an axis for the tool's swing; without one the two functions of
/// the swing are called and ignored, and tables with a swing are refused. Constant after
/// hal_init(). Simulator: true unless the machine file says otherwise.
bool hal_has_swing(void);

/// @return [Hz] rate of hal_clock_isr(), at least ten times hal_tick_hz()
uint32_t hal_clock_hz(void);

/// Start calling cam_isr() at hal_tick_hz(). Simulator: nothing; the caller of the host port ticks.
void hal_tick_start(void);

/// Let time pass: sleep until any interrupt. Simulator: one tick of virtual time.
void hal_idle(void);

/// A broken invariant: make the outputs safe, keep `why` for after the restart, restart.
/// @param why  string with static lifetime
/// Context: any; does not return. Simulator: prints and aborts.
_Noreturn void hal_halt(const char *why);

/// @return reason of the last start, constant after hal_init(). Simulator: as set by the test.
hal_start_t hal_start(void);

/// @return place of the table image, any content: the caller checks it. Simulator: none unless set.
hal_image_t hal_table_image(void);

// A second place of the same kind takes a new table while the first is in use. In state off only,
// when no tick reads a table; a call may block, cam_isr() and what watches over main() go on.

/// Empty the place that is not in use for an image. What was in it is lost, also of an earlier
/// begin; the place in use stays as it is.
/// @param size  [bytes] of the image
/// @return      false: larger than the place, or it cannot be emptied
/// Context: main(); flash: up to seconds.
bool hal_table_begin(uint32_t size);

/// Write a piece of the image behind hal_table_begin().
/// @param offset  [bytes] where the last piece ended, 0 at first: a multiple of hal_table_grain
/// @param n       [bytes] a multiple of hal_table_grain but for the last piece
/// @return        false: it does not read as it was written; begin again
/// Context: main(); flash: about a millisecond per 100 bytes.
bool hal_table_write(uint32_t offset, const void *bytes, uint32_t n);

/// @return place of what was begun, to be checked; size 0: nothing was begun since the start
hal_image_t hal_table_staged(void);

/// Make what was begun the place that hal_table_image() gives, from now on and after every restart.
/// At once: when the supply falls, the next start finds the old or the new one, whole.
/// @return false: nothing was begun, or it cannot be kept; the old one stays in force
bool hal_table_commit(void);

/// @return how long cam_isr() took, in cycles. Simulator: as set by the test.
hal_load_t hal_load(void);

/// Write a line for people, without line end, at most 120 characters: a serial line, stderr.
void hal_text(const char *line);

/// Take the oldest received frame. @return false when there is none
bool hal_can_read(hal_can_frame_t *frame);

/// Queue a frame. @return false when the queue is full or the bus is off; the frame is dropped
bool hal_can_write(const hal_can_frame_t *frame);

// Port provides: interrupt, reads (only at the start of a tick)

/// @return [1 / hal_clock_hz()] free-running time stamp, wraps; <= 10 cycles. Simulator: virtual
/// time.
uint32_t hal_clock_isr(void);

/// Take a consistent encoder reading; <= 40 cycles. Simulator: what hal_host_t holds, with its
/// faults.
/// @param reading  result, all members
void hal_encoder_read_isr(hal_encoder_t *reading);

/// @return [nm] measured position of an axis; <= 30 cycles. A port without a measurement returns
/// the last set-point and says so in its README: the following error is then that of the command,
/// feed-forward included, and tells nothing of the drive.
int32_t hal_axis_read_nm_isr(hal_axis_t axis);

/// @return [turn / 2^32] measured swing of the tool, the last value that is known; <= 10 cycles.
/// 0 of a port without the axis.
int32_t hal_swing_read_q32_isr(void);

/// @return bits hal_in_*, debounced where the wiring needs it; <= 20 cycles
uint32_t hal_inputs_read_isr(void);

// Port provides: interrupt, writes (only at the end of a tick)

/// Give an axis its set-point for the next period; <= 60 cycles. While enable is low the port may
/// ignore it. Simulator: kept for the machine models.
void hal_axis_write_isr(hal_axis_t axis, const hal_setpoint_t *setpoint);

/// Give the swing its set-point, valid from this tick; <= 60 cycles. While off in every tick, where
/// the tool is. With a table that swings the tool every 8 ticks, in the cut of a modulated spindle
/// every 10, as a bus of 1 .. 4 kHz would; with other tables not again: the drive holds its place.
/// While enable is low the port may ignore it. Simulator: counted, kept for the models.
void hal_swing_write_isr(const hal_swing_t *setpoint);

/// Give the spindle its speed set-point; <= 30 cycles.
/// @param speed_mrpm  [r/min / 1000] signed: positive in the spindle's own positive sense (M3)
void hal_spindle_write_isr(int32_t speed_mrpm);

/// Write bits hal_out_*; <= 20 cycles. Enable low takes effect at once.
void hal_outputs_write_isr(uint32_t bits);

// Firmware provides

/// One tick. The port calls it at hal_tick_hz() from its highest-priority interrupt, never nested.
void cam_isr(void);

#endif
