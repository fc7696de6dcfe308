// SPDX-License-Identifier: Apache-2.0
/// cam_scrub: the slow side looks again and again whether the configuration is what it was when it
/// was handed over.
///
/// The interrupt reads it in every tick, writes nothing of it, and cannot afford to look itself. A
/// round takes some fifteen polls, so a bit that flips is found within thirty of them, which is
/// some milliseconds; what it does until then is bounded by the guard, which judges what every axis
/// is told in the very tick (cam_guard.h). Context: slow side.
#ifndef CAM_SCRUB_H
#define CAM_SCRUB_H

#include "cam_config.h" // cam_config_bank_t
#include <stdbool.h>    // bool
#include <stdint.h>     // uint32_t

enum { cam_scrub_words = 64 }; ///< that one step looks at

/// State; zero-initialised begins a round.
typedef struct {
    const cam_config_t *config; ///< that is looked at
    uint32_t generation;        ///< and its number
    uint32_t at;                ///< [words] done
    uint32_t sum;               ///< over them
} cam_scrub_t;

/// One step: some 200 instructions.
/// @return false when a round ended, and the configuration that was handed over last has been
///         changed since
bool cam_scrub_step(cam_scrub_t *s, const cam_config_bank_t *bank);

#endif
