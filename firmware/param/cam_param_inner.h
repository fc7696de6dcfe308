// SPDX-License-Identifier: Apache-2.0
/// cam_param_inner: keyed hash of a short message, for the challenge of cam_rights.c, private to
/// this room.
///
/// BLAKE2b-512 (RFC 7693) of a message of one block. Context: slow side.
#ifndef CAM_PARAM_INNER_H
#define CAM_PARAM_INNER_H

#include <stdint.h> // uint8_t, uint32_t

/// @param key    n_key bytes, 1 .. 64
/// @param bytes  n bytes, 1 .. 128
/// @return       first four bytes of the hash, the lowest first
uint32_t cam_blake2b_keyed(const uint8_t *key, uint32_t n_key, const uint8_t *bytes, uint32_t n);

#endif
