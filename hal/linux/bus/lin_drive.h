// SPDX-License-Identifier: Apache-2.0
/// lin_drive: one CiA 402 drive: what its process data mean, and what is sent to it.
///
///     TPDO1  6041h status word u16, measured i32 (6064h position or 606Ch velocity)
///     RPDO1  6040h control word u16, target i32 (607Ah position or 60FFh velocity)
///     RPDO2  60B1h velocity offset i32; with FD behind the position in RPDO1
///
/// Pure. Source: CiA 402-2, 402-3; the mapping is the port's own (README.md).
#ifndef LIN_DRIVE_H
#define LIN_DRIVE_H

#include "lin_cia402.h" // cia402_state_t
#include "hal/hal.h"    // hal_can_frame_t
#include "lin_node.h"   // lin_node_t
#include <stdbool.h>    // bool
#include <stdint.h>     // int32_t, int64_t

/// Limits of time from the configuration.
typedef struct {
    int64_t node_ns, pdo_ns, enable_ns;
} lin_patience_t;

typedef struct {
    lin_node_t node;
    int64_t counts, nm; ///< drive units = nm * counts / nm
    bool has_status;
    int64_t status_ns;
    cia402_state_t state;
    int32_t actual; ///< [drive units]
    lin_loss_t loss;
    bool is_ready;         ///< able to follow; false when lost
    bool is_enabled;       ///< commanded
    int64_t enabled_ns;    ///< when enabling was commanded
    bool has_followed;     ///< it reached operation enabled since then
    int64_t reset_ns;      ///< last fault reset
    int64_t quick_stop_ns; ///< quick stop is active since then, 0: it is not
} lin_drive_t;

/// @param node  0: there is none; it is then ready and never lost
void lin_drive_init(lin_drive_t *d, int64_t node, int64_t counts, int64_t nm);

/// @return whether the frame was this drive's
bool lin_drive_take(lin_drive_t *d, const hal_can_frame_t *frame, int64_t ns);

/// Make `loss` and `is_ready`. A drive is ready when it is heard and has no error; a disabled drive
/// must also be in a state other than not ready to switch on and fault, an enabled one in operation
/// enabled, which it may reach within enable_ns.
void lin_drive_judge(lin_drive_t *d, int64_t now_ns, const lin_patience_t *patience);

/// Command the drive to be enabled or disabled from now on.
void lin_drive_enable(lin_drive_t *d, bool is_enabled, int64_t now_ns);

/// The operator's reset: errors that the drive reported are forgotten.
void lin_drive_forget(lin_drive_t *d);

/// Make the control word of this tick.
/// @param may_reset    a drive in fault gets a fault reset, once a second
/// @param is_stopping  the drive goes to the state without voltage and stays there
uint16_t lin_drive_control(lin_drive_t *d, int64_t now_ns, bool may_reset, bool is_stopping);

/// @return [drive units] of a length or a length per second in nm, nearest, clamped
int32_t lin_drive_units(const lin_drive_t *d, int64_t nm);

/// @return [nm] measured, nearest, clamped
int32_t lin_drive_actual_nm(const lin_drive_t *d);

/// @return [pm] of a unit of the drive, nearest; 0 without a drive
uint32_t lin_drive_unit_pm(const lin_drive_t *d);

#endif
