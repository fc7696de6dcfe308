// SPDX-License-Identifier: Apache-2.0
/// cam_param_store: parameters as the text that a port keeps over a restart.
///
///     # camturn parameters, kept by the controller; tools/camctl params changes them
///     version = 12
///     counts_per_turn = 10000
///     ...
///     crc32 = 2774812345
///
/// Every parameter has a line `name = value`, so an image with other parameters, or with the same
/// ones in another order, reads it too. The CRC-32 is that of all bytes in front of its line. The
/// text is TOML, and a file of tools/camctl may hold it. Context: slow side.
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

/// What was found in a text.
typedef struct {
    cam_err_t err;          ///< cam_ok, cam_err_params_none or cam_err_params_damaged
    bool is_torn;           ///< what was to be kept later than this is not whole
    uint32_t version;       ///< of the parameters
    uint32_t n_unknown;     ///< lines of parameters that this image has not
    uint32_t n_unfit;       ///< values out of the range that the parameter has here
    uint32_t n_missing;     ///< parameters of this image that the text has not
    cam_param_id_t unfit;   ///< the first of those; cam_n_params: none
    cam_param_id_t missing; ///< likewise
    char unknown[cam_param_store_name_bytes]; ///< name of the first of those, cut off
} cam_param_store_found_t;

/// @return CRC-32 of the lines `name = value`, in the order of CAM_PARAMS: equal parameters have
///         equal checksums, in a controller and in a file of tools/camctl
uint32_t cam_param_store_checksum(const cam_params_t *params);

/// Write parameters as text.
/// @param text  cam_param_store_most_bytes of them
/// @return      [bytes] of the text
uint32_t cam_param_store_write(char *text, const cam_params_t *params, uint32_t version);

/// Read parameters from a text.
/// @param kept    as the port gives it
/// @param params  what the text does not say stays, as does everything when it is damaged
cam_param_store_found_t cam_param_store_read(const hal_params_t *kept, cam_params_t *params);

#endif
