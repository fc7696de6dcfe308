// SPDX-License-Identifier: Apache-2.0
/// hal: the interface between the firmware and a machine.
///
/// A port is a folder hal/<name> that implements the functions under "Port provides". It is chosen
/// at link time and calls cam_isr() at a constant rate. Functions with the suffix `_isr` are called
/// from the interrupt only; they must neither block nor fail, and their time limits apply to a
/// 480 MHz Cortex-M7. All other functions belong to the slow side and are called from main() only.
/// A port may leave out a function that states a "Default" (hal/defaults); without any other the
/// linker names what is missing. "Simulator" describes the host port. What a port must guarantee:
/// hal/template, hal/PORTING.md.
#ifndef HAL_HAL_H
#define HAL_HAL_H

#include <stdbool.h> // bool
#include <stdint.h>  // int32_t, uint32_t

/// Axes with a position set-point, in signed nanometres.
/// U increases towards the spindle axis and is 0 with the tool tip on the long axis of the part.
/// X is the radius that the tool tip turns at U = 0; it increases away from the spindle axis.
/// Z is the height in the drawing.
typedef enum { hal_axis_u, hal_axis_x, hal_axis_z, hal_n_axes } hal_axis_t;

/// Bits of hal_inputs_read_isr().
enum {
    hal_in_estop = 1u << 0,       ///< 1: the emergency-stop chain is open
    hal_in_drive_ready = 1u << 1, ///< 1: all drives can follow their set-points
    hal_in_bus_lost = 1u << 2,    ///< 1: a field-bus node is silent or frames were lost. Stays set
                                  ///< while hal_out_fault is written. If the node is a drive,
                                  ///< hal_in_drive_ready is 0 too. Always 0 without a bus
    hal_in_home_u = 1u << 3,      ///< 1: U is on its home switch. The home switches and the index
    hal_in_home_x = 1u << 4,      ///< marks are in the order of hal_axis_t; a missing one reads 0
    hal_in_home_z = 1u << 5,
    hal_in_index_u = 1u << 6, ///< 1: an index mark of U's scale or encoder passed within the last
    hal_in_index_x = 1u << 7, ///< 0.4 ms, or since the previous reading if that is longer ago. A
    hal_in_index_z = 0x100u,  ///< port may pass on a longer pulse unchanged
    hal_in_acknowledge = 0x200u, ///< 1: the acknowledge button at the machine is pressed; motion
                                 ///< needs it (cam_plan.h)
    hal_in_key = 0x400u, ///< 1: the key switch allows changes of limits, constants and tables
                         ///< (cam_param.h)
    hal_in_limit_u_low = 0x800u,   ///< 1: U stands at the limit switch of its lower end; only
    hal_in_limit_u_high = 0x1000u, ///< 1: .. upper end; where U takes forces
};

/// Bits of hal_outputs_write_isr().
enum {
    hal_out_enable = 1u << 0, ///< 1: the drives are enabled and hold their axes
    hal_out_fault = 1u << 1,  ///< 1: a fault is latched
    hal_out_in_cut = 1u << 2, ///< 1: the tool cuts at full amplitude
};

/// One reading of the spindle encoder; all members are sampled at the same instant. The counter may
/// count either way; the parameter encoder_sign is +1 if it counts up with M3, the rotation in
/// which the drawing's angle at the tool increases (PARTFILE.md, "The drawing's angle").
typedef struct {
    uint32_t counts;       ///< [counts] free-running, four edges per line, wraps by design
    uint32_t index_counts; ///< [counts] counter at the last index edge. Both directions of rotation
                           ///< latch the same edge, so the value is the same modulo a turn
    uint32_t n_index;      ///< number of index edges since the start, wraps
    uint32_t edge_clock;   ///< [1 / hal_clock_hz()] time of the edge that produced `counts`, on the
                           ///< clock of hal_clock_isr(). Undefined if hal_has_edge_time() is false
} hal_encoder_t;

/// Set-point of one axis. The derivatives are per tick; multiply by hal_tick_hz() for SI units.
/// Ports for position-only drives ignore them. Example: 10 mm/s at 20 kHz is 500 nm per tick,
/// vel_q10 = 512 000.
typedef struct {
    int32_t pos_nm;  ///< [nm] position, feed-forward included
    int32_t vel_q10; ///< [nm / 1024 per tick] velocity without feed-forward (CiA 402: 60B1h)
    int32_t acc_q10; ///< [nm / 1024 per tick^2] acceleration, likewise (CiA 402: 60B2h)
} hal_setpoint_t;

/// Set-point of the swing axis: the angle of the tool about the swing centre. It is 0 along the
/// line of centres and positive against the drawing's angle, i.e. clockwise seen from the
/// headstock, with M3 and M4 alike (TABLE_FORMAT.md, "Lobes").
typedef struct {
    int32_t pos_q32; ///< [turn / 2^32] angle at the tick in which it is written
    int32_t vel_q32; ///< [turn / 2^32 per tick] velocity until the next set-point
} hal_swing_t;

/// Resolution and speed limit of an axis interface. 0: unknown or not applicable.
typedef struct {
    uint32_t command_pm;   ///< [pm] smallest change of the set-point that reaches the drive: a DAC
                           ///< code, a step, a unit of a bus drive
    uint32_t measured_pm;  ///< [pm] quantum of the measured position
    int32_t most_um_per_s; ///< [um/s] highest speed that the output can transmit; limits the
                           ///< parameters x_speed and z_speed
} hal_axis_scale_t;

/// Output of U's force: a torque or current amplifier.
typedef struct {
    uint32_t quantum_un; ///< [uN] smallest change of the force; 0: U takes positions
    uint32_t latency_ns; ///< [ns] from the latch of U's scale to the change of the output
} hal_force_t;

/// Memory for the recorder and the excitation of U. main() writes it; during an excitation the
/// interrupt reads one word per tick.
typedef struct {
    int32_t *words;   ///< aligned to 4 bytes; undefined after the start, except n_kept words
    uint32_t n_words; ///< [words] size; 0: none
    uint32_t n_kept;  ///< [words] at the start of it restored from hal_scope_keep(); 0: none
} hal_memory_t;

/// Cause of the reset. If several apply, report the last of them in this list.
typedef enum {
    hal_reset_power_on,  ///< supply switched on
    hal_reset_pin,       ///< reset button, debugger
    hal_reset_software,  ///< software reset other than hal_halt()
    hal_reset_halt,      ///< hal_halt(); its text is in hal_start_t
    hal_reset_watchdog,  ///< watchdog timeout
    hal_reset_brown_out, ///< supply voltage below its limit
} hal_reset_t;

/// Cause of the last start.
typedef struct {
    hal_reset_t reset;
    const char *why; ///< text of the hal_halt() that caused this start, else ""; static
} hal_start_t;

/// Operator controls of the machine. All zero is the safe default: no motion is allowed and nothing
/// locked can be changed.
typedef struct {
    bool has_acknowledge;       ///< hal_in_acknowledge is wired
    bool is_acknowledge_waived; ///< motion needs no acknowledge; the machine builder is responsible
    bool has_key;               ///< hal_in_key is wired
    uint32_t nonce;             ///< differs at each start; 0 if the port has no source of noise
} hal_operator_t;

/// A slot that holds a table image.
typedef struct {
    const void *bytes; ///< aligned to 4 bytes
    uint32_t size;     ///< [bytes] that may be read; 0: no table
} hal_image_t;

/// [bytes] Programming unit of the flash; pieces of a download are multiples of it.
enum { hal_table_grain = 32 };

/// [bytes] Largest set of parameters that a port must store.
enum { hal_params_most_bytes = 16384 };

/// Stored parameters.
typedef struct {
    const char *bytes; ///< text, as given to hal_params_keep(); not terminated
    uint32_t size;     ///< [bytes] that may be read; 0: none
    bool is_damaged;   ///< a newer set exists but is incomplete, or no set is complete
} hal_params_t;

/// Duration of the interrupt, without entry and exit, and memory errors.
typedef struct {
    uint32_t last_cycles; ///< last tick
    uint32_t max_cycles;  ///< longest tick since the start
    uint32_t cycles_hz;   ///< [Hz] rate of the cycles; 0: not measured
    uint32_t n_corrected; ///< memory errors since the start that the hardware corrected; 0: none,
                          ///< or not measured
} hal_load_t;

/// [bytes] Data of the longest CAN FD frame.
enum { hal_can_max_bytes = 64 };

/// A CAN frame, classic (n <= 8) or FD.
typedef struct {
    uint32_t id; ///< 11-bit identifier
    uint32_t n;  ///< [bytes] 0 .. 8; FD also 12, 16, 20, 24, 32, 48, 64
    uint8_t data[hal_can_max_bytes];
} hal_can_frame_t;

// Port provides: slow side

/// Initialise clocks, pins and peripherals with all outputs safe (enable low), without starting the
/// tick.
/// @return 0, or a negative port-specific error if the machine cannot be used
/// Context: main(), once; may block for up to 1 s. Simulator: resets its state.
int hal_init(void);

/// @return [Hz] rate at which cam_isr() is called, 500 .. 100 000, constant after hal_init()
uint32_t hal_tick_hz(void);

/// @return whether the machine has an axis that swings the tool, constant after hal_init(). Without
/// one, tables with a swing are refused and the swing functions, still called, do nothing.
/// A port defines all three functions of the swing or none; otherwise it does not link.
/// Default: false. Simulator: true unless the machine file says otherwise.
bool hal_has_swing(void);

/// @return whether hardware time-stamps the edges of the spindle encoder, i.e. edge_clock of
/// hal_encoder_t is valid. Constant after hal_init(). Default: false; the observer takes the counts
/// as of the tick. Simulator: set by the test or machine file.
bool hal_has_edge_time(void);

/// @return whether hal_axis_read_nm_isr(hal_axis_u) is a measurement rather than the last
/// set-point. Learning needs a measurement. Constant after hal_init(). Default: false. Simulator:
/// set by the test or machine file.
bool hal_measures_u(void);

/// @return resolution and speed limit of an axis, constant after hal_init(). At start the
/// controller reports the resulting form error; it refuses speeds above the limit. Default: 0;
/// neither is done. Simulator: set by the test, else 0.
hal_axis_scale_t hal_axis_scale(hal_axis_t axis);

/// @return the output of U's force, constant after hal_init(). If it has one, the firmware closes
/// U's position loop (cam_servo.h); its scale must be measured. Default: 0, U takes positions.
/// Simulator: set by the test or machine file.
hal_force_t hal_force(void);

/// @return whether U takes forces, not positions
static inline bool hal_takes_force(void)
{
    return hal_force().quantum_un > 0u;
}

/// @return the operator controls, constant after hal_init(). Simulator: set by the test, else the
/// acknowledge is waived and there is a key switch.
hal_operator_t hal_operator(void);

/// @return the memory for recorder and excitation, constant after hal_init(). Default: none; the
/// firmware runs but neither records nor excites. Simulator: 1 MiB.
hal_memory_t hal_scope_memory(void);

/// Store words of that memory across a restart, replacing those stored before. Default: nothing;
/// the black box of a fault is lost with the restart. Simulator: leaves them in place.
/// @param words  in hal_scope_memory()
/// @param n      [words] 0: discard the stored words
/// Context: main(), rarely, after a fault. May block as long as hal_table_write().
void hal_scope_keep(const int32_t *words, uint32_t n);

/// @return [Hz] rate of hal_clock_isr(), at least ten times hal_tick_hz(); constant
uint32_t hal_clock_hz(void);

/// Start calling cam_isr() at hal_tick_hz(). Simulator: nothing; the caller runs hal_host_tick().
void hal_tick_start(void);

/// Sleep until the next interrupt. Simulator: one tick of virtual time.
void hal_idle(void);

/// Stop after a broken invariant: make the outputs safe, store `why` across the restart, restart.
/// @param why  string with static lifetime
/// Context: any. Does not return. Simulator: prints and aborts.
_Noreturn void hal_halt(const char *why);

/// @return the cause of the last start, constant after hal_init(). Default: power-on, no text,
/// whatever the cause: a port with a watchdog must define it, otherwise a reset by the watchdog is
/// reported as power-on. Simulator: set by the test.
hal_start_t hal_start(void);

/// @return the slot in use, unchecked: the caller validates the content. Default: none; enable is
/// refused until a table is selected. Simulator: none unless set by the test.
hal_image_t hal_table_image(void);

// A download goes to a second slot while the first is in use. The next four functions are called
// only in the states off and ready, in which no tick reads a table. They may block, but cam_isr()
// and the watchdog's supervision of main() must continue. Default: there is no second slot; a
// download is refused.

/// Erase the slot that is not in use, for an image. An unfinished download is lost; the slot in use
/// is not touched.
/// @param size  [bytes] of the image
/// @return      false if the image does not fit or the slot cannot be erased
/// Context: main(); with flash up to several seconds.
bool hal_table_begin(uint32_t size);

/// Write a piece of the image, after hal_table_begin().
/// @param offset  [bytes] end of the previous piece, first 0; a multiple of hal_table_grain
/// @param n       [bytes] a multiple of hal_table_grain except for the last piece
/// @return        false if the piece does not read back as written; restart the download
/// Context: main(); with flash about 1 ms per 100 bytes.
bool hal_table_write(uint32_t offset, const void *bytes, uint32_t n);

/// @return the slot of the download, for checking; size 0 if none was begun since the start
hal_image_t hal_table_staged(void);

/// Make the slot of the download the one that hal_table_image() returns, now and after every
/// restart. Atomic: after a power failure the next start finds the complete old or new table.
/// @return false if no download was begun or it cannot be stored; the old table stays in use
bool hal_table_commit(void);

/// @return the stored parameters, unchecked: the caller validates the content. The bytes do not
/// change until hal_params_keep(). Default: none; every start has the defaults of the parameters.
/// Simulator: none until some are stored.
hal_params_t hal_params_kept(void);

/// Replace the stored parameters, now and after every restart. Atomic: after a power failure the
/// next start finds the complete old or new set. Called only in state off, in which no tick reads a
/// table. May block, but cam_isr() and the watchdog's supervision of main() must continue.
/// Default: refused.
/// @param size  [bytes] 1 .. hal_params_most_bytes
/// @return      false if they cannot be stored; the old set remains
/// Context: main(); with flash a few milliseconds, occasionally several seconds.
bool hal_params_keep(const void *bytes, uint32_t size);

/// @return the duration of cam_isr() in cycles, and memory errors. Default: not measured.
/// Simulator: set by the test.
hal_load_t hal_load(void);

/// Write a line of text to a serial line or stderr.
/// @param line  at most 120 characters without a line end; the rest is cut off
void hal_text(const char *line);

/// Take the oldest received frame. @return false if there is none. Must not block. Default: no bus,
/// nothing is received.
bool hal_can_read(hal_can_frame_t *frame);

/// Queue a frame for transmission. Must not block.
/// @return false if the queue is full or the bus is off; the frame is then dropped. Default: false
bool hal_can_write(const hal_can_frame_t *frame);

// Port provides: interrupt, reads (only at the start of a tick)

/// @return [1 / hal_clock_hz()] free-running time stamp, wraps at 2^32; <= 10 cycles. Simulator:
/// virtual time.
uint32_t hal_clock_isr(void);

/// Read the encoder consistently; <= 40 cycles. Simulator: the reading of hal_host_t, distorted by
/// the injected faults.
/// @param reading  result, all members
void hal_encoder_read_isr(hal_encoder_t *reading);

/// @return [nm] newest measured position of an axis, within +-2^30 nm: beyond that the controller
/// treats the drive as not ready; <= 30 cycles. A port without a measurement returns the last
/// set-point and documents that in its README; the following error is then computed from the
/// command, feed-forward included, and contains no information about the drive.
int32_t hal_axis_read_nm_isr(hal_axis_t axis);

/// @return [turn / 2^32] newest measured swing of the tool; <= 10 cycles. Default: 0
int32_t hal_swing_read_q32_isr(void);

/// @return bits hal_in_*, debounced if the wiring needs it; <= 20 cycles
uint32_t hal_inputs_read_isr(void);

// Port provides: interrupt, writes (at the end of a tick, except the force)

/// Write the force of U, positive where it drives U up; <= 30 cycles. It is called right after the
/// reads, only where hal_force() states a quantum, and in every tick: 0 while the drives are not
/// enabled. The output must be 0 V after every reset and while enable is low, by hardware: a force
/// that is held for 10 ms moves U by many millimetres. Default: halts, as it is called only if
/// hal_force() states a quantum. Simulator: stores it for the machine models.
/// @param force_q6  [mN / 64] the port rounds it to its quantum
void hal_force_write_isr(int32_t force_q6);

/// Write the set-point of an axis for the next period; <= 60 cycles. The port may ignore it while
/// enable is low. Simulator: stores it for the machine models.
void hal_axis_write_isr(hal_axis_t axis, const hal_setpoint_t *setpoint);

/// Write the set-point of the swing, valid from this tick; <= 60 cycles. In state off it is called
/// every 0.4 ms (every tick if the period is longer) with the measured angle. In the other states
/// it is called at the same rate if the table swings the tool; otherwise it is not called and the
/// drive must hold its position. The port may ignore it while enable is low. Default: nothing.
/// Simulator: counts the set-points and stores the last one for the machine models.
void hal_swing_write_isr(const hal_swing_t *setpoint);

/// Write the speed set-point of the spindle; <= 30 cycles.
/// @param speed_mrpm  [r/min / 1000] positive: M3
void hal_spindle_write_isr(int32_t speed_mrpm);

/// Write the bits hal_out_*; <= 20 cycles. Enable low must take effect immediately.
void hal_outputs_write_isr(uint32_t bits);

// Firmware provides

/// One tick of the controller. The port calls it at hal_tick_hz() from its highest-priority
/// interrupt, never nested, and not before hal_tick_start().
void cam_isr(void);

#endif
