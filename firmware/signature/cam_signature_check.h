// SPDX-License-Identifier: Apache-2.0
/// cam_signature_check: acceptance of tables by the signature that follows their image.
///
/// The port names its trusted public keys and whether a signature is required (hal_trust()). A
/// table is checked at the end of a download, when it is selected, and at the start.
///
///     signature         required           optional, with keys   no keys
///     none              refused            unsigned              unsigned
///     of a trusted key  signed             signed                unchecked
///     of another key    refused            refused               unchecked
///     wrong             refused            refused               unchecked
///
/// If signatures are required but no keys are named, every table is refused. A weak key, for which
/// anybody can sign, is never trusted, even if the port names it. Ed25519 (RFC 8032) by Monocypher.
/// Context of all functions: slow side.
#ifndef CAM_SIGNATURE_CHECK_H
#define CAM_SIGNATURE_CHECK_H

#include "cam_err.h"   // cam_err_t
#include "cam_table.h" // cam_table_t, cam_signature_block_id_size
#include <stdbool.h>   // bool
#include <stddef.h>    // size_t
#include <stdint.h>    // uint8_t

enum { cam_signature_check_key_size = 32 }; ///< [bytes] of a public key

/// Signature state of an accepted table.
typedef enum {
    cam_signature_check_unsigned,  ///< it has no signature
    cam_signature_check_unchecked, ///< it has one, but the port names no keys to check it against
    cam_signature_check_signed,    ///< a trusted key signed exactly these bytes
} cam_signature_check_kind_t;

/// Verdict on an accepted table.
typedef struct {
    cam_signature_check_kind_t kind;
    uint8_t key_id[cam_signature_block_id_size]; ///< of the key that the block names; 0: unsigned
} cam_signature_check_t;

/// @param key        32 bytes, a public key of Ed25519
/// @param bytes      n bytes that were signed
/// @param signature  64 bytes
/// @return           whether the signature is valid for this key and these bytes. RFC 8032, 5.1.7
bool cam_signature_check_is_signed_by(const uint8_t *key, const void *bytes, size_t n,
                                      const uint8_t *signature);

/// @param key  32 bytes, any
/// @return     whether it is a point of small order, such as the key of zeros, for which signatures
///             can be forged, or has a coordinate beyond the field's prime
/// Source: RFC 8032, 5.1.3.
bool cam_signature_check_is_weak(const uint8_t *key);

/// Check an image and the signature that follows it: cam_table_check() and, with a signature to
/// check, a hash of all bytes and one verification (TABLE_FORMAT.md, "Signature", gives times).
/// @param image    `size` bytes of any content
/// @param table    as of cam_table_check()
/// @param verdict  filled on success, zeroed otherwise
/// @return         cam_ok, an error of cam_table_check(), or cam_err_sign_*
CAM_MUST_USE cam_err_t cam_signature_check_table(const void *image, size_t size, cam_table_t *table,
                                                 cam_signature_check_t *verdict);

#endif
