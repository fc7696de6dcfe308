// SPDX-License-Identifier: Apache-2.0
/// Most instructions of sense, angle, play, guard, actuate, publish, by session; written by the
/// target record_stages (test_stages.c).
#ifndef STAGES_LIMITS_H
#define STAGES_LIMITS_H

#define STAGES_UNIFORM 50, 175, 335, 130, 70, 15
#define STAGES_MODULATED 50, 175, 335, 130, 70, 15
#define STAGES_FAULTS 50, 180, 335, 320, 70, 15

#endif
