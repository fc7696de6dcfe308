// SPDX-License-Identifier: Apache-2.0
/// canopen: constants of CiA 301.
#ifndef CANOPEN_H
#define CANOPEN_H

/// Frame identifiers (COB-ID); for frames of a node add its node number.
enum {
    canopen_id_nmt = 0x000,
    canopen_id_sync = 0x080,
    canopen_id_emcy = 0x080,
    canopen_id_tpdo1 = 0x180,
    canopen_id_rpdo1 = 0x200,
    canopen_id_rpdo2 = 0x300,
    canopen_id_heartbeat = 0x700,
};

/// Node states in the heartbeat.
enum {
    canopen_boot_up = 0x00,
    canopen_stopped = 0x04,
    canopen_operational = 0x05,
    canopen_pre_operational = 0x7F,
};

/// Commands of the network master, CiA 301, table "NMT protocol".
enum {
    canopen_start = 0x01,
    canopen_stop = 0x02,
    canopen_enter_pre_operational = 0x80,
    canopen_reset = 0x81,
    canopen_reset_communication = 0x82,
};

#endif
