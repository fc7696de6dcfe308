// SPDX-License-Identifier: Apache-2.0
/// Most instructions of sense, angle, play, guard, actuate, publish, by session; written by the
/// target record_stages (test_stages.c).
#ifndef STAGES_LIMITS_H
#define STAGES_LIMITS_H

#define STAGES_UNIFORM 40, 180, 295, 100, 90, 10
#define STAGES_MODULATED 40, 180, 295, 100, 90, 10
#define STAGES_FAULTS 40, 180, 290, 240, 90, 10

#endif
