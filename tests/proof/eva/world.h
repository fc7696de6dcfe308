// SPDX-License-Identifier: Apache-2.0
/// world: any controller within ranges_config.h and ranges_state.h, on any checked table, for Eva.
#ifndef PROOF_WORLD_H
#define PROOF_WORLD_H

#include "cam_tick.h" // cam_t
#include <stddef.h>   // size_t
#include <stdint.h>   // int64_t

/// Provided by Eva.
long long Frama_C_long_long_interval(long long low, long long high);
void Frama_C_make_unknown(char *bytes, size_t n);

/// Report that a member may leave its range, and that the end of a driver is reached: prove.py
/// reads both.
void Frama_C_show_each_leaves(const char *name, long long value);
void Frama_C_show_each_end(void);

/// @return any number of a range
static inline int64_t any(int64_t low, int64_t high)
{
    return Frama_C_long_long_interval(low, high);
}

extern cam_t c;
extern cam_config_t *cfg;

/// Fill in all of them anew.
void make_world(void);

#endif
