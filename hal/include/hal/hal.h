// SPDX-License-Identifier: Apache-2.0
/// hal: everything that the firmware requires of a machine, and the one function that a machine
/// calls in it.
///
/// A port is a folder hal/<name> that implements the functions under "Port provides". It is chosen
/// at link time and calls cam_isr() at a constant rate. Functions with the suffix `_isr` are called
/// from the interrupt only; they must neither block nor fail, and their longest time is given for a
/// 480 MHz Cortex-M7. All other functions belong to the slow side and are called from main() only.
/// "Simulator" says what the host port does instead. hal/template and hal/PORTING.md say function
/// by function what a port must guarantee.
#ifndef HAL_HAL_H
#define HAL_HAL_H

#include <stdbool.h> // bool
#include <stdint.h>  // int32_t, uint32_t

/// Axes with a position set-point. Positions are signed nanometres:
/// U rises towards the spindle axis and is 0 where the tool tip is on the long axis. X is the
/// radius that the tool tip would turn at U = 0, and rises away from the axis. Z is the height of
/// the drawing.
typedef enum { hal_axis_u, hal_axis_x, hal_axis_z, hal_n_axes } hal_axis_t;

/// Bits of hal_inputs_read_isr().
enum {
    hal_in_estop = 1u << 0,       ///< 1: the emergency-stop chain is open
    hal_in_drive_ready = 1u << 1, ///< 1: all drives are able to follow
    hal_in_bus_lost = 1u << 2,    ///< 1: a node on a field bus went silent or frames were lost. The
                                  ///< port keeps it while hal_out_fault is written. If the node is
                                  ///< a drive, hal_in_drive_ready is 0 too. Always 0 without a bus
    hal_in_home_u = 1u << 3,      ///< 1: U is on its home switch. The switches of the three axes
    hal_in_home_x = 1u << 4,      ///< and their indices follow one another in the order of
    hal_in_home_z = 1u << 5,      ///< hal_axis_t; what is not there is always 0
    hal_in_index_u = 1u << 6, ///< 1: an index mark of U's scale or encoder passed within the last
    hal_in_index_x = 1u << 7, ///< 0.4 ms, or since the last reading where that is longer. A port
    hal_in_index_z = 0x100u,  ///< may hand a longer pulse through as it is
    hal_in_acknowledge = 0x200u, ///< 1: the button is pressed by which somebody at the machine lets
                                 ///< it move again (cam_acknowledge.h)
    hal_in_key = 0x400u, ///< 1: the key switch allows changes of limits, constants and tables
                         ///< (cam_rights.h)
};

/// Bits of hal_outputs_write_isr().
enum {
    hal_out_enable = 1u << 0,  ///< 1: the drives are enabled and hold their axes
    hal_out_fault = 1u << 1,   ///< 1: a fault is latched
    hal_out_in_cut = 1u << 2,  ///< 1: the tool cuts at full amplitude
    hal_out_switch_1 = 0x100u, ///< 1: the first position switch is on; those of the other seven
                               ///< follow it. A port without pins for them leaves them out
};

/// One reading of the spindle encoder. All members are of the same instant. Counts may rise in
/// either sense: the parameter encoder_sign says whether they rise with M3, in which the drawing's
/// angle before the tool rises (tools/README.md, "The drawing's angle").
typedef struct {
    uint32_t counts;       ///< [counts] free-running, four edges per line, wraps by design
    uint32_t index_counts; ///< [counts] position of the last index edge. Both senses of rotation
                           ///< use the same edge, so the number is the same modulo a turn
    uint32_t n_index;      ///< number of index edges since the start, wraps
    uint32_t edge_clock; ///< [1 / hal_clock_hz()] time of the last edge that counted, on the clock
                         ///< of hal_clock_isr(): the edge that made `counts` what it is. Anything
                         ///< where hal_has_edge_time() is false
} hal_encoder_t;

/// Set-point of one axis. The derivatives are per tick; a port that needs SI units multiplies by
/// hal_tick_hz(). A drive that takes a position only ignores them. Example: 10 mm/s at 20 kHz are
/// 500 nm per tick, vel_q10 = 512 000.
typedef struct {
    int32_t pos_nm;  ///< [nm] position, with the feed-forward added
    int32_t vel_q10; ///< [nm / 1024 per tick] velocity without feed-forward (CiA 402: 60B1h)
    int32_t acc_q10; ///< [nm / 1024 per tick^2] acceleration without it (CiA 402: 60B2h)
} hal_setpoint_t;

/// Set-point of the swing axis: the angle of the tool about the centre of the swing. It is 0 along
/// the line of centres and positive where the tool is turned against the drawing's angle, which is
/// clockwise seen from the headstock, with M3 and M4 alike (TABLE_FORMAT.md, "Lobes").
typedef struct {
    int32_t pos_q32; ///< [turn / 2^32] angle at the tick in which it is written
    int32_t vel_q32; ///< [turn / 2^32 per tick] velocity until the next set-point
} hal_swing_t;

/// What the output and the measurement of an axis resolve. A member that is 0 says nothing: the
/// port does not know it, or there is no such thing.
typedef struct {
    uint32_t command_pm;   ///< [pm] smallest change of a set-point that reaches the drive: a code
                           ///< of a converter, a step, a unit of a drive on a bus
    uint32_t measured_pm;  ///< [pm] quantum of the measured position
    int32_t most_um_per_s; ///< highest speed that the output passes on; the parameters x_speed and
                           ///< z_speed are limited to it
} hal_axis_scale_t;

/// Memory for the recorder and the excitation of U. main() writes it; while U is excited the
/// interrupt reads one word of it per tick.
typedef struct {
    int32_t *words;   ///< aligned to 4 bytes; its content is anything at the start
    uint32_t n_words; ///< [words] that may be read and written; 0: there is none
    uint32_t n_kept;  ///< [words] at its begin that hal_scope_keep() has kept; 0: none
} hal_memory_t;

/// Why the processor started. When several reasons apply, the later one in this list counts.
typedef enum {
    hal_reset_power_on,  ///< the supply was switched on
    hal_reset_pin,       ///< reset button, debugger
    hal_reset_software,  ///< reset by software, but not by hal_halt()
    hal_reset_halt,      ///< hal_halt(); hal_start_t holds its text
    hal_reset_watchdog,  ///< the firmware stood still
    hal_reset_brown_out, ///< the supply dropped below its limit
} hal_reset_t;

/// What the port knows about the start.
typedef struct {
    hal_reset_t reset;
    const char *why; ///< text of the hal_halt() that led to this start, else ""; static
} hal_start_t;

/// What the machine has for the people at it. A port whose builder has said nothing returns
/// all zero: then nothing may move, and nothing that is locked may change.
typedef struct {
    bool has_acknowledge;       ///< hal_in_acknowledge is wired
    bool is_acknowledge_waived; ///< the builder answers for a machine that moves without
    bool has_key;               ///< hal_in_key is wired
    const uint8_t *secret;      ///< of the challenge that unlocks instead of the key; static
    uint32_t n_secret;          ///< [bytes] of it, 16 .. 64; 0: there is none
    uint32_t nonce;             ///< another number at each start, 0 where the port has no noise
} hal_operator_t;

/// A place in which a table image is kept.
typedef struct {
    const void *bytes; ///< aligned to 4 bytes
    uint32_t size;     ///< [bytes] that may be read; 0: the port keeps no table
} hal_image_t;

/// [bytes] that a flash memory programs at once; pieces of a download are multiples of it.
enum { hal_table_grain = 32 };

/// [bytes] behind an image that a port empties with it, as far as the place reaches: a signature of
/// the image that lay there before would otherwise follow an image of the same size without one.
enum { hal_table_behind = 128 };

/// Whose tables the port takes. The keys are public, and yet what protects them is all that
/// protects the machine from tables of others: who can change them can change this.
typedef struct {
    const uint8_t *keys; ///< n_keys times the 32 bytes of a public key of Ed25519 (RFC 8032)
    uint32_t n_keys;     ///< 0: signatures are not checked
    bool is_required;    ///< a table without a signature of one of the keys is refused
} hal_trust_t;

/// [bytes] of parameters that a port keeps at most.
enum { hal_params_most_bytes = 16384 };

/// The parameters that a port keeps over a restart.
typedef struct {
    const char *bytes; ///< text, as given to hal_params_keep(); no character ends it
    uint32_t size;     ///< [bytes] that may be read; 0: there are none
    bool is_damaged;   ///< something newer than these is there, but not whole; or there is
                       ///< something, and none of it is whole
} hal_params_t;

/// Duration of the interrupt without its entry and exit.
typedef struct {
    uint32_t last_cycles; ///< of the last tick
    uint32_t max_cycles;  ///< the longest since the start
    uint32_t cycles_hz;   ///< [Hz] rate of the cycles; 0: the port does not measure
} hal_load_t;

/// Data bytes of the longest CAN FD frame.
enum { hal_can_max_bytes = 64 };

/// A CAN frame, classic (n <= 8) or FD.
typedef struct {
    uint32_t id; ///< identifier of 11 bits
    uint32_t n;  ///< [bytes] 0 .. 8, and with FD 12, 16, 20, 24, 32, 48, 64
    uint8_t data[hal_can_max_bytes];
} hal_can_frame_t;

// Port provides: slow side

/// Bring up clocks, pins and peripherals with all outputs safe (enable low). The tick does not run
/// yet.
/// @return 0, or a negative number of the port's own when the machine cannot be used
/// Context: main(), once; may block up to a second. Simulator: resets its state.
int hal_init(void);

/// @return [Hz] rate at which cam_isr() is called, 500 .. 100 000, constant after hal_init()
uint32_t hal_tick_hz(void);

/// @return whether the machine has an axis for the swing of the tool. Without one the two functions
/// of the swing are called all the same and do nothing, and tables with a swing are refused.
/// Constant after hal_init(). Simulator: true unless the machine file says otherwise.
bool hal_has_swing(void);

/// @return whether hardware stamps the edges of the spindle encoder, so that hal_encoder_t's
/// edge_clock holds. Constant after hal_init(). Simulator: as the test or the machine file says.
bool hal_has_edge_time(void);

/// @return whether hal_axis_read_nm_isr(hal_axis_u) is a measurement, not the last set-point.
/// Without one nothing can be learned of the drive. Constant after hal_init(). Simulator: as the
/// test or the machine file says.
bool hal_measures_u(void);

/// @return what the output and the measurement of an axis resolve, constant after hal_init(). The
/// controller says at its start what form error follows, and refuses speeds that the output does
/// not pass on. Simulator: as the test says, else 0.
hal_axis_scale_t hal_axis_scale(hal_axis_t axis);

/// @return what the machine has for the people at it, constant after hal_init(). Simulator: as the
/// test says, else the button is waived and there is a key switch.
hal_operator_t hal_operator(void);

/// @return the memory for the recorder and the excitation, constant after hal_init(). The firmware
/// runs without it, but records nothing and excites nothing. Simulator: 1 MiB.
hal_memory_t hal_scope_memory(void);

/// Keep words of that memory beyond a restart, in place of those that were kept before. A port that
/// has no room for them does nothing. Simulator: they stay where they are.
/// @param words  in hal_scope_memory()
/// @param n      [words] 0: forget what was kept
/// Context: main(), seldom: behind a fault. May block as long as hal_table_write().
void hal_scope_keep(const int32_t *words, uint32_t n);

/// @return [Hz] rate of hal_clock_isr(), at least ten times hal_tick_hz(); constant
uint32_t hal_clock_hz(void);

/// Start calling cam_isr() at hal_tick_hz(). Simulator: nothing; its caller ticks by
/// hal_host_tick().
void hal_tick_start(void);

/// Let time pass: sleep until any interrupt comes. Simulator: one tick of virtual time.
void hal_idle(void);

/// Stop after a broken invariant: make the outputs safe, keep `why` beyond the restart, restart.
/// @param why  string with static lifetime
/// Context: any. Does not return. Simulator: prints and aborts.
_Noreturn void hal_halt(const char *why);

/// @return the reason of the last start, constant after hal_init(). Simulator: as set by the test.
hal_start_t hal_start(void);

/// @return the place in use of the table image. Its content may be anything; the caller checks it.
/// Simulator: none unless the test sets it.
hal_image_t hal_table_image(void);

/// @return whose tables are taken, constant after hal_init(). What a builder sets, not a commander:
/// no command changes it. Simulator: as the test or the options say, else no keys and not required.
hal_trust_t hal_trust(void);

// A second place of the same kind takes a new table while the first is in use. The next four
// functions are called in the states off and ready only, when no tick reads a table. They may
// block, but cam_isr() and the watchdog's supervision of main() must go on meanwhile.

/// Empty the place that is not in use, for an image and hal_table_behind. What it held is lost,
/// including the pieces of an unfinished download. The place in use is not touched.
/// @param size  [bytes] of the image
/// @return      false when the image is larger than the place, or the place cannot be emptied
/// Context: main(); with flash up to some seconds.
bool hal_table_begin(uint32_t size);

/// Write a piece of the image, after hal_table_begin().
/// @param offset  [bytes] where the last piece ended, first 0; a multiple of hal_table_grain
/// @param n       [bytes] a multiple of hal_table_grain except for the last piece
/// @return        false when the piece does not read back as written; the download must begin anew
/// Context: main(); with flash about a millisecond per 100 bytes.
bool hal_table_write(uint32_t offset, const void *bytes, uint32_t n);

/// @return the place of the download, to be checked; size 0 when none was begun since the start
hal_image_t hal_table_staged(void);

/// Make the place of the download the one that hal_table_image() returns, from now on and after
/// every restart. The change is atomic: if the supply fails, the next start finds either the old or
/// the new table, complete.
/// @return false when no download was begun or it cannot be kept; the old table stays in force
bool hal_table_commit(void);

/// @return the parameters that were kept last. Their content may be anything; the caller checks it.
/// The bytes stay as they are until hal_params_keep(). Simulator: none until some are kept.
hal_params_t hal_params_kept(void);

/// Keep parameters instead of those of before, from now on and after every restart. The change is
/// atomic: if the supply fails, the next start finds either the old or the new ones, complete.
/// Called in state off only, when no tick reads a table. It may block, but cam_isr() and the
/// watchdog's supervision of main() must go on meanwhile.
/// @param size  [bytes] 1 .. hal_params_most_bytes
/// @return      false when they cannot be kept; then those of before are
/// Context: main(); with flash some milliseconds, now and then some seconds.
bool hal_params_keep(const void *bytes, uint32_t size);

/// @return how long cam_isr() took, in cycles. Simulator: as set by the test.
hal_load_t hal_load(void);

/// Write a line of text for people to a serial line or stderr.
/// @param line  at most 120 characters without a line end; more are cut off
void hal_text(const char *line);

/// Take the oldest received frame. @return false when there is none. Must not block.
bool hal_can_read(hal_can_frame_t *frame);

/// Queue a frame for transmission. Must not block.
/// @return false when the queue is full or the bus is off; the frame is then dropped
bool hal_can_write(const hal_can_frame_t *frame);

// Port provides: interrupt, reads (only at the start of a tick)

/// @return [1 / hal_clock_hz()] free-running time stamp, wraps at 2^32; <= 10 cycles. Simulator:
/// virtual time.
uint32_t hal_clock_isr(void);

/// Take a consistent reading of the encoder; <= 40 cycles. Simulator: the reading of hal_host_t
/// with the faults that the test has set.
/// @param reading  result, all members
void hal_encoder_read_isr(hal_encoder_t *reading);

/// @return [nm] newest measured position of an axis, within +-2^30 nm: beyond that the controller
/// treats the drive as not ready; <= 30 cycles. A port without a measurement returns the last
/// set-point and says so in its README. The following error is then computed from the command,
/// feed-forward included, and says nothing about the drive.
int32_t hal_axis_read_nm_isr(hal_axis_t axis);

/// @return [turn / 2^32] newest measured swing of the tool; <= 10 cycles. 0 without the axis.
int32_t hal_swing_read_q32_isr(void);

/// @return bits hal_in_*, debounced where the wiring needs it; <= 20 cycles
uint32_t hal_inputs_read_isr(void);

// Port provides: interrupt, writes (only at the end of a tick)

/// Give an axis its set-point for the next period; <= 60 cycles. While enable is low the port may
/// ignore it. Simulator: keeps it for the machine models.
void hal_axis_write_isr(hal_axis_t axis, const hal_setpoint_t *setpoint);

/// Give the swing its set-point, valid from this tick; <= 60 cycles. In state off it is called
/// every 0.4 ms, or in every tick where that is longer, with the measured angle. With a table that
/// swings the tool it is then called at the same rate, as over a field bus; with other tables it is
/// not called again, and the drive must hold its place. While enable is low the port may ignore it.
/// Simulator: counts the set-points and keeps the last one for the machine models.
void hal_swing_write_isr(const hal_swing_t *setpoint);

/// Give the spindle its speed set-point; <= 30 cycles.
/// @param speed_mrpm  [r/min / 1000] signed: positive in the spindle's own positive sense (M3)
void hal_spindle_write_isr(int32_t speed_mrpm);

/// Write the bits hal_out_*; <= 20 cycles. Enable low must take effect at once.
void hal_outputs_write_isr(uint32_t bits);

// Firmware provides

/// One tick of the controller. The port calls it at hal_tick_hz() from its interrupt of the highest
/// priority, never nested, and not before hal_tick_start().
void cam_isr(void);

#endif
