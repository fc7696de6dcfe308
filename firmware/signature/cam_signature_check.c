// SPDX-License-Identifier: Apache-2.0
#include "cam_signature_check.h"
#include "cam_sha512.h"
#include "hal/hal.h"    // hal_trust
#include "monocypher.h" // crypto_eddsa_check_equation
#include <string.h>     // memcmp, memcpy

/// The field's prime is 2^255 - 19, so a coordinate beyond it is all ones but for its lowest bits.
static bool is_beyond_prime(const uint8_t *key)
{
    bool are_ones = (key[cam_signature_check_key_size - 1] & 0x7Fu) == 0x7Fu && key[0] >= 0xEDu;
    for (uint32_t i = 1; i < (uint32_t)cam_signature_check_key_size - 1u; i++) {
        are_ones = are_ones && key[i] == UINT8_MAX;
    }
    return are_ones;
}

bool cam_signature_check_is_weak(const uint8_t *key)
{
    // R = 0, s = 0: 0 B = R + 8 A holds only for the eight points A with 8 A = 0.
    uint8_t signature[64] = {0};
    uint8_t eight[32] = {0};
    signature[0] = 1;
    eight[0] = 8;
    return is_beyond_prime(key) || crypto_eddsa_check_equation(signature, key, eight) == 0;
}

/// @return the trusted key with this id; NULL: none
static const uint8_t *key_of(const hal_trust_t *trust, const uint8_t *id)
{
    for (uint32_t i = 0; i < trust->n_keys; i++) {
        const uint8_t *key = &trust->keys[(size_t)i * cam_signature_check_key_size];
        uint8_t hash[cam_sha512_bytes];
        cam_sha512_t s;
        cam_sha512_begin(&s);
        cam_sha512_add(&s, key, cam_signature_check_key_size);
        cam_sha512_end(&s, hash);
        if (memcmp(hash, id, cam_signature_block_id_size) == 0 &&
            !cam_signature_check_is_weak(key)) {
            return key;
        }
    }
    return NULL;
}

bool cam_signature_check_is_signed_by(const uint8_t *key, const void *bytes, size_t n,
                                      const uint8_t *signature)
{
    uint8_t hash[cam_sha512_bytes];
    uint8_t h_ram[32]; // the hash of R, the key and the message
    cam_sha512_t s;
    cam_sha512_begin(&s);
    cam_sha512_add(&s, signature, 32); // R
    cam_sha512_add(&s, key, cam_signature_check_key_size);
    cam_sha512_add(&s, bytes, n);
    cam_sha512_end(&s, hash);
    crypto_eddsa_reduce(h_ram, hash);
    return crypto_eddsa_check_equation(signature, key, h_ram) == 0;
}

/// Check the signature block that follows an image.
static cam_err_t check_block(const hal_trust_t *trust, const uint8_t *image, size_t image_size)
{
    const uint8_t *block = &image[image_size];
    if (!cam_signature_block_is_sound(block, image_size)) {
        return cam_err_sign_block;
    }
    if (trust->n_keys == 0u) {
        return cam_ok;
    }
    const uint8_t *key = key_of(trust, &block[cam_signature_block_at_id]);
    if (key == NULL) {
        return cam_err_sign_key;
    }
    return cam_signature_check_is_signed_by(key, image,
                                            image_size + (size_t)cam_signature_block_signed_size,
                                            &block[cam_signature_block_at_signature])
               ? cam_ok
               : cam_err_sign_wrong;
}

cam_err_t cam_signature_check_table(const void *image, size_t size, cam_table_t *table,
                                    cam_signature_check_t *verdict)
{
    const hal_trust_t trust = hal_trust();
    *verdict = (cam_signature_check_t){.kind = cam_signature_check_unsigned};
    cam_err_t err = cam_table_check(image, size, table);
    if (err != cam_ok) {
        return err;
    }
    const bool has_block = size > table->image_size;
    if (trust.is_required && (!has_block || trust.n_keys == 0u)) {
        err = trust.n_keys == 0u ? cam_err_sign_no_keys : cam_err_sign_none;
    } else if (has_block) {
        err = check_block(&trust, image, table->image_size);
    } else {
        return cam_ok;
    }
    if (err != cam_ok) {
        *table = (cam_table_t){0};
        return err;
    }
    const uint8_t *bytes = image;
    verdict->kind = trust.n_keys == 0u ? cam_signature_check_unchecked : cam_signature_check_signed;
    (void)memcpy(verdict->key_id, &bytes[table->image_size + (uint32_t)cam_signature_block_at_id],
                 sizeof verdict->key_id);
    return cam_ok;
}
