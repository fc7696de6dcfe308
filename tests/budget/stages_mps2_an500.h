// SPDX-License-Identifier: Apache-2.0
/// Most instructions of sense, angle, play, guard, actuate, publish, by session; written by the
/// target record_stages (test_stages.c).
#ifndef STAGES_LIMITS_H
#define STAGES_LIMITS_H

#define STAGES_UNIFORM 40, 170, 295, 135, 65, 15
#define STAGES_MODULATED 40, 170, 295, 135, 65, 15
#define STAGES_FAULTS 40, 170, 295, 340, 65, 15

#endif
