// SPDX-License-Identifier: Apache-2.0
/// sim_turns: the error of every turn in rehearsal and cut, which shows how learning converges.
///
/// In the cut it is the largest |form error| of the turn; the last turn may be incomplete. In a
/// rehearsal the tool is clear of the work, and the true position of U is compared with the drawing
/// at the true angle: the error is half the difference between the largest and the smallest
/// deviation in the turn, which a constant offset does not change. Turns with rising or falling
/// amplitude are left out: they are found by number, counted from the first turn in which U moves
/// and back from the end of the rehearsal.
///
/// Memory is bounded: when it is full, neighbours of the same kind merge into one entry with the
/// larger error.
#ifndef SIM_TURNS_H
#define SIM_TURNS_H

#include <stdbool.h> // bool
#include <stdint.h>  // uint32_t

enum { sim_turns_most = 4096 };

typedef enum { sim_turns_rehearsed, sim_turns_cut } sim_turns_kind_t;

/// One turn, or several merged.
typedef struct {
    double turn; ///< [turn] where it began, counted from the first sample
    double um;
    sim_turns_kind_t kind;
} sim_turn_t;

/// Zero-initialised: no turn.
typedef struct {
    double rise_turns, fall_turns; ///< of the amplitude in a rehearsal
    double kept_turns;             ///< [turn] turns of a rehearsal at full amplitude
    // the present run of turns
    bool has_begun;
    double zero_turn;  ///< angle of the very first sample
    double begin_turn; ///< ... of the present run
    double full_turn;  ///< where the amplitude begins to rise, from zero_turn; below 0: not yet
    uint32_t run_from; ///< first entry of the run
    bool is_running;
    sim_turns_kind_t kind;
    // the present turn
    double n_whole; ///< whole turns of the run before this one
    double least_um, most_um;
    double least_u_um, most_u_um, least_drawn_um, most_drawn_um;
    uint32_t n;
    sim_turn_t entry[sim_turns_most];
} sim_turns_t;

/// @param rise_turns, kept_turns, fall_turns  of a rehearsal: amplitude rises, stays, falls
void sim_turns_init(sim_turns_t *t, double rise_turns, double kept_turns, double fall_turns);

/// Take a sample of a rehearsal.
/// @param turn      [turn] true angle, not wrapped; it may fall
/// @param u_um      true position of U's tip, positive towards the axis
/// @param drawn_um  radius of the drawing there
void sim_turns_rehearse(sim_turns_t *t, double turn, double u_um, double drawn_um);

/// Take a sample of the cut. @param error_um  above 0: metal left
void sim_turns_touch(sim_turns_t *t, double turn, double error_um);

/// Take a sample of any other state, which ends a run.
/// @param is_engaging  the rehearsal was completed; otherwise it was aborted
void sim_turns_rest(sim_turns_t *t, double turn, bool is_engaging);

#endif
