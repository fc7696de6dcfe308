// SPDX-License-Identifier: Apache-2.0
/// lcn_port: port for a HAL thread of LinuxCNC, independent of LinuxCNC's headers.
///
/// The component (camturn.comp) copies its pins to lcn_in_t, calls lcn_port_tick() and copies
/// lcn_out_t to its pins. Only the component includes LinuxCNC's headers, and it includes none of
/// the firmware: both have a hal.h and a function hal_init().
#ifndef LCN_PORT_H
#define LCN_PORT_H

#include "lcn_index.h" // lcn_counters_t
#include <stdbool.h>   // bool
#include <stdint.h>    // int32_t, int64_t, uint32_t

/// Axes, as in hal/hal.h.
enum { lcn_u, lcn_x, lcn_z, lcn_n_axes };

/// Load parameters of the component, constant.
typedef struct {
    uint32_t tick_hz;             ///< [Hz] rate of the thread, 500 .. 100 000
    bool is_measured[lcn_n_axes]; ///< the axis has feedback; false: its position is the set-point
    uint32_t force_quantum_un;    ///< [uN] smallest change of U's force; 0: U takes positions
    uint32_t force_latency_ns;    ///< [ns] from the latch of U's scale to the change of the force
    bool is_waived;               ///< the pin acknowledge is not needed
    bool is_nominal;              ///< time is counted in ticks (simulation)
} lcn_setup_t;

/// Inputs of a tick.
typedef struct {
    int64_t now_ns;                ///< [ns] clock at the start of the tick; not used if is_nominal
    int32_t period_ns;             ///< [ns] nominal period of the thread
    lcn_counters_t spindle;        ///< encoder
    int32_t actual_nm[lcn_n_axes]; ///< [nm] feedback
    bool is_estop;                 ///< the emergency-stop chain is open
    bool is_drive_ready;           ///< all drives can follow
    bool is_acknowledged;          ///< the acknowledge button is pressed
    bool is_u_on_home;             ///< U is on its home switch
    bool is_u_on_index;            ///< U is on the index mark of its scale
    bool is_u_at_low;              ///< U is on the limit switch of its lower end
    bool is_u_at_high;             ///< U is on the limit switch of its upper end
} lcn_in_t;

/// Outputs of a tick.
typedef struct {
    int32_t pos_nm[lcn_n_axes];  ///< [nm] set-points
    int32_t vel_q10[lcn_n_axes]; ///< [nm / 1024 per tick] their velocities, without feed-forward
    int32_t acc_q10[lcn_n_axes]; ///< [nm / 1024 per tick^2] their accelerations; X and Z: 0
    int32_t force_q6;            ///< [mN / 64] force of U; 0 while not enabled
    int32_t spindle_mrpm;        ///< [r/min / 1000] signed
    bool is_enabled;             ///< the drives are enabled and hold their axes
    bool is_fault;               ///< a fault is latched
    bool is_in_cut;              ///< the tool cuts at full amplitude
    bool arms_index;             ///< set index-enable
} lcn_out_t;

/// Initialise. Call once, before any other function here.
void lcn_port_init(const lcn_setup_t *setup);

/// Start the ticks. Before that the drives are disabled and set-points follow the feedback. Started
/// by the first round of the slow thread, after the HAL file has set the parameters.
void lcn_port_run(void);

/// One tick: sense, cam_isr(), actuate. Context: fast thread.
/// @param turn_counts  [counts] per turn of the encoder, > 0
void lcn_port_tick(const lcn_in_t *in, int32_t turn_counts, lcn_out_t *out);

/// @return whether the thread's period matches tick_hz within 1 %, or time is nominal. If not, the
///         tick reports an open emergency stop. True before the first tick.
bool lcn_port_is_on_rate(void);

/// @return [ns] period of the thread, 0 before the first tick
int32_t lcn_port_period_ns(void);

/// Prints lines of text and the reason of a halt. Set by the component.
extern void (*lcn_port_print)(const char *line);

#endif
