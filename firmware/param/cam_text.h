// SPDX-License-Identifier: Apache-2.0
/// cam_text: numbers as text. Context: slow side.
#ifndef CAM_TEXT_H
#define CAM_TEXT_H

#include <stdint.h> // int64_t

enum { cam_text_number_bytes = 21 }; ///< [bytes] longest number with sign and end

/// @param buffer  of cam_text_number_bytes
/// @return        the number in decimal, in the buffer
const char *cam_text_number(char *buffer, int64_t value);

#endif
