// SPDX-License-Identifier: Apache-2.0
/// common_number: decimal numbers that a user writes in a file or on a command line.
#ifndef COMMON_NUMBER_H
#define COMMON_NUMBER_H

#include <stdbool.h> // bool

/// Read a decimal number: the whole text, finite, no hexadecimal, no "inf" or "nan".
/// @return false when the text is no such number; *value is untouched then
bool common_number_parse(const char *text, double *value);

#endif
