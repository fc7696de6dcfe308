// SPDX-License-Identifier: Apache-2.0
/// cam_param_store: parameters as the text that a port stores.
///
///     # camturn parameters, kept by the controller; tools/camctl params changes them
///     version = 12
///     counts_per_turn = 10000
///     ...
///     crc32 = 2774812345
///
/// Parameters are found by name, so an image with other parameters, or in another order, reads the
/// text too. The CRC-32 covers all bytes before its line. The text is TOML, as in files of
/// tools/camctl. Context: slow side.
#ifndef CAM_PARAM_STORE_H
#define CAM_PARAM_STORE_H

#include "cam_err.h"   // cam_err_t
#include "cam_param.h" // cam_params_t
#include "hal/hal.h"   // hal_params_t
#include <stdbool.h>   // bool
#include <stdint.h>    // uint32_t

enum {
    cam_param_store_name_bytes = 40, ///< [bytes] of the longest name of a parameter, with its end
    cam_param_store_line_bytes = 64, ///< [bytes] of the longest line
    cam_param_store_most_bytes =
        (cam_n_params + 4) * cam_param_store_line_bytes, ///< [bytes] of the whole text
};

/// Result of reading a text.
typedef struct {
    cam_err_t err;          ///< cam_ok, cam_err_params_none or cam_err_params_damaged
    bool is_torn;           ///< a later save is incomplete
    uint32_t version;       ///< of the parameters
    uint32_t n_retired;     ///< lines with retired parameters
    uint32_t n_unknown;     ///< lines with other parameters unknown to this image
    uint32_t n_unfit;       ///< values out of their range
    uint32_t n_missing;     ///< parameters of this image without a line
    cam_param_id_t unfit;   ///< the first one out of range; cam_n_params: none
    cam_param_id_t missing; ///< the first one missing; cam_n_params: none
    char unknown[cam_param_store_name_bytes]; ///< name of the first unknown one, cut off
} cam_param_store_found_t;

/// @return CRC-32 of the lines `name = value` in the order of CAM_PARAMS, the same in a controller
///         and in a file of tools/camctl
uint32_t cam_param_store_checksum(const cam_params_t *params);

/// Write parameters as text.
/// @param text  buffer of cam_param_store_most_bytes
/// @return      [bytes] of the text
uint32_t cam_param_store_write(char *text, const cam_params_t *params, uint32_t version);

/// Read parameters from a text.
/// @param kept    from the port
/// @param params  parameters without a valid line keep their value, all of them if it is damaged
cam_param_store_found_t cam_param_store_read(const hal_params_t *kept, cam_params_t *params);

#endif
