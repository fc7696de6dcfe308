// SPDX-License-Identifier: Apache-2.0
/// stm_can: FDCAN1, polled. All frames with 11-bit identifiers go into receive FIFO 0.
///
/// The bus runs at 500 kbit/s with the sample point at 80 %, the data of FD frames at 2 Mbit/s and
/// 75 %. Frames of more than 8 bytes are sent as FD frames with the higher rate. After bus-off the
/// next call of hal_can_read() or hal_can_write() starts the return to the bus.
#ifndef STM_CAN_H
#define STM_CAN_H

#include <stdbool.h> // bool

/// Set FDCAN1 up.
/// @return false when the peripheral does not enter its configuration state
/// Context: slow side, once. Source: RM0433 chapter 56 (operating modes, message RAM).
bool stm_can_init(void);

/// Send a frame of 64 bytes to oneself by the internal loop-back, off the bus, then join it again.
/// Frames that wait to be read or sent are lost.
/// @return whether the frame came back within 2 ms
/// Context: slow side. Source: RM0433 chapter 56, test modes; FDCAN_TEST, FDCAN_CCCR.
bool stm_can_loop_back(void);

#endif
