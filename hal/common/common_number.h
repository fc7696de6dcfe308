// SPDX-License-Identifier: Apache-2.0
/// common_number: decimal numbers from a file or command line.
#ifndef COMMON_NUMBER_H
#define COMMON_NUMBER_H

#include <stdbool.h> // bool

/// Convert a whole text to a finite number; hexadecimal, "inf" and "nan" are refused.
/// @return false if the text is not a number; *value is then unchanged
bool common_number_parse(const char *text, double *value);

#endif
