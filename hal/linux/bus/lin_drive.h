// SPDX-License-Identifier: Apache-2.0
/// lin_drive: one CiA 402 drive: process data and state.
///
///     TPDO1  6041h status word u16, measured i32 (6064h position or 606Ch velocity)
///     RPDO1  6040h control word u16, target i32 (607Ah position or 60FFh velocity)
///     RPDO2  60B1h velocity offset i32; with FD it follows the position in RPDO1
///
/// Pure. Source: CiA 402-2, 402-3; the mapping is specific to this port (README.md).
#ifndef LIN_DRIVE_H
#define LIN_DRIVE_H

#include "lin_cia402.h" // cia402_state_t
#include "hal/hal.h"    // hal_can_frame_t
#include "lin_node.h"   // lin_node_t
#include <stdbool.h>    // bool
#include <stdint.h>     // int32_t, int64_t

/// Timeouts of the configuration.
typedef struct {
    int64_t node_ns, pdo_ns, enable_ns;
} lin_timeouts_t;

typedef struct {
    lin_node_t node;
    int64_t counts, nm; ///< drive units = nm * counts / nm
    bool has_status;
    int64_t status_ns;
    cia402_state_t state;
    int32_t actual; ///< [drive units]
    lin_loss_t loss;
    bool is_ready;         ///< can follow its set-point; false if lost
    bool is_enabled;       ///< commanded
    int64_t enabled_ns;    ///< time of the enable command
    bool has_followed;     ///< has reached operation enabled since then
    int64_t reset_ns;      ///< time of the last fault reset
    int64_t quick_stop_ns; ///< start of quick stop, 0: not active
} lin_drive_t;

/// @param node  0: no drive; it is then always ready and never lost
void lin_drive_init(lin_drive_t *d, int64_t node, int64_t counts, int64_t nm);

/// @return whether the frame is from this drive
bool lin_drive_receive(lin_drive_t *d, const hal_can_frame_t *frame, int64_t ns);

/// Update `loss` and `is_ready`. A drive is ready if it is not lost and has no error, fault or "not
/// ready to switch on"; an enabled drive must also reach operation enabled within enable_ns.
void lin_drive_judge(lin_drive_t *d, int64_t now_ns, const lin_timeouts_t *timeouts);

/// Command the drive to be enabled or disabled.
void lin_drive_enable(lin_drive_t *d, bool is_enabled, int64_t now_ns);

/// Clear reported errors, on the operator's reset.
void lin_drive_forget(lin_drive_t *d);

/// @return the control word of this tick
/// @param may_reset    send a fault reset once a second while the drive is in fault
/// @param is_stopping  remove voltage for good
uint16_t lin_drive_control(lin_drive_t *d, int64_t now_ns, bool may_reset, bool is_stopping);

/// @return [drive units] position or velocity, rounded to nearest, clamped
/// @param nm  [nm] or [nm/s]
int32_t lin_drive_units(const lin_drive_t *d, int64_t nm);

/// @return [nm] measured position, rounded to nearest, clamped
int32_t lin_drive_actual_nm(const lin_drive_t *d);

/// @return [pm] one drive unit, rounded to nearest; 0 without a drive
uint32_t lin_drive_unit_pm(const lin_drive_t *d);

#endif
