// SPDX-License-Identifier: Apache-2.0
/// stm_can: FDCAN1, polled: all frames with 11-bit identifiers into receive FIFO 0.
///
/// 500 kbit/s, sample point 80 %; data of FD frames 2 Mbit/s, 75 %. Frames of more than 8 bytes are
/// sent as FD frames with the higher rate. After bus-off the next call of either function asks to
/// return.
#ifndef STM_CAN_H
#define STM_CAN_H

#include <stdbool.h> // bool

/// @return false when the peripheral does not leave or enter its configuration state
/// Context: slow side, once. Source: RM0433 chapter 56 (operating modes, message RAM).
bool stm_can_init(void);

#endif
