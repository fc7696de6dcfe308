// SPDX-License-Identifier: Apache-2.0
/// cam_sha512: SHA-512, the hash of Ed25519.
///
/// The pinned package of Monocypher (tools/cmake/Monocypher.cmake) lacks its optional SHA-512.
/// Input is not secret: tables and public keys. Context of all functions: slow side. Source: FIPS
/// 180-4, sections 4.1.3, 5.1.2 and 6.4.
#ifndef CAM_SHA512_H
#define CAM_SHA512_H

#include <stddef.h> // size_t
#include <stdint.h> // uint64_t

enum { cam_sha512_block = 128, cam_sha512_bytes = 64 };

/// A hash in progress: begin, add bytes in any number of pieces, end.
typedef struct {
    uint64_t h[8];
    uint64_t n;                        ///< [bytes] added so far
    uint8_t pending[cam_sha512_block]; ///< n % 128 of them, not yet hashed
} cam_sha512_t;

void cam_sha512_begin(cam_sha512_t *s);

void cam_sha512_add(cam_sha512_t *s, const void *bytes, size_t n);

void cam_sha512_end(cam_sha512_t *s, uint8_t hash[cam_sha512_bytes]);

#endif
