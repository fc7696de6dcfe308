// SPDX-License-Identifier: Apache-2.0
/// Most instructions of sense, angle, play, guard, actuate, publish, by session; written by the
/// target record_stages (test_stages.c).
#ifndef STAGES_LIMITS_H
#define STAGES_LIMITS_H

#define STAGES_UNIFORM 45, 180, 295, 105, 90, 10
#define STAGES_MODULATED 45, 180, 295, 105, 90, 10
#define STAGES_FAULTS 45, 180, 290, 245, 90, 10

#endif
