// SPDX-License-Identifier: Apache-2.0
/// Most instructions of sense, angle, play, guard, actuate, publish, by session; written by the
/// target record_stages (test_stages.c).
#ifndef STAGES_LIMITS_H
#define STAGES_LIMITS_H

#define STAGES_UNIFORM 50, 170, 345, 135, 60, 15
#define STAGES_MODULATED 50, 170, 345, 135, 60, 15
#define STAGES_FAULTS 50, 180, 345, 315, 60, 15

#endif
