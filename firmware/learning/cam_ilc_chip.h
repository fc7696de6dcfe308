// SPDX-License-Identifier: Apache-2.0
/// cam_ilc_chip: feed-forward of the chip's radial force, learned in the cut.
///
///     added to U's command = feed (A (u - m) + B (D + m))
///
/// On a cylindrical blank the depth of cut is D + u: u is U's set-point, m its mean, D the depth
/// where it is 0. The rehearsal has no chip, so what differs in the cut is the chip's. Where U is a
/// spring, A and B are the same; a position loop with an integral leaves less of the mean, so B is
/// limited to 0 .. A.
/// Source: MATHS.md (149). Context of all functions: slow side.
#ifndef CAM_ILC_CHIP_H
#define CAM_ILC_CHIP_H

#include "cam_ilc.h" // cam_ilc_t

/// @return whether the turn being processed has a chip to learn from: it is cut after a rehearsal,
///         with a feed of at least 1.5 um that does not fall
bool cam_ilc_chip_is_cut(const cam_ilc_t *t);

/// Learn A. @param share_q32  [1] the error of the turn as a share of the set-point
void cam_ilc_chip_step(cam_ilc_t *t, int32_t share_q32, int32_t gain_q16);

/// Learn B.
/// @param error_q6  [nm / 64] mean error of the turn
/// @param depth_nm  [nm] D
void cam_ilc_chip_step_mean(cam_ilc_t *t, int32_t error_q6, int32_t depth_nm, int32_t gain_q16);

/// Notice gaps in the material, once per turn that is learned from: in the cut an error that
/// doubles in a turn, which learning cannot do, is not the drive's. Layer 1 pauses until layer 2
/// has removed it.
void cam_ilc_chip_follow_gap(cam_ilc_t *t);

/// Take the present feed from the interrupt.
void cam_ilc_chip_follow(cam_ilc_t *t, cam_state_t state, const cam_turn_bins_t *bins);

/// @return whether the feed differs from that for which A and B are in force
bool cam_ilc_chip_is_due(const cam_ilc_t *t);

/// Move the values in force towards those of the present feed.
/// @param depth_nm  [nm] D
/// @param most_nm   largest change of U's command
/// @return          whether they have reached them
bool cam_ilc_chip_blend(cam_ilc_t *t, int32_t depth_nm, int32_t most_nm, cam_learned_t *in);

#endif
