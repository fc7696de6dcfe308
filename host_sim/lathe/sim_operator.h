// SPDX-License-Identifier: Apache-2.0
/// sim_operator: a simulated operator, who presses the button acknowledge when it is needed, or is
/// absent.
///
/// 0.3 s after the emergency-stop chain is closed and the fault is reset, the operator presses for
/// 0.2 s, and again if that did not help. The operator turns the key switch for each new commander.
#ifndef SIM_OPERATOR_H
#define SIM_OPERATOR_H

#include <stdbool.h> // bool
#include <stdint.h>  // uint32_t

typedef struct {
    bool is_present;
    bool is_waiting; ///< the button is needed since since_s
    double since_s;
    double until_s;   ///< end of a press requested on stdin
    bool is_key_on;   ///< the key switch
    bool turns_key;   ///< off and on again for each new session
    uint32_t session; ///< at the last call
} sim_operator_t;

/// Press the button at once.
/// @param press_s  [s] duration
void sim_operator_press(sim_operator_t *o, double time_s, double press_s);

/// @param is_needed  the controller wants the button, the chain is closed, and no fault is latched
/// @param time_s     [s] rises from call to call
/// @return           whether the button is pressed
bool sim_operator_step(sim_operator_t *o, bool is_needed, double time_s);

/// @param session  of the commander, 0: nobody
/// @return         whether the key switch is on; it is off for one tick where a session is new
bool sim_operator_key(sim_operator_t *o, uint32_t session);

#endif
