// SPDX-License-Identifier: Apache-2.0
/// pil_wire: protocol between camsim and the firmware on a target, processor in the loop.
///
/// The target sends a greeting. Then camsim sends requests, some followed by bytes, and the target
/// answers each; one exchange is one tick or one call of the slow side. Structures are sent as in
/// memory: both ends are little-endian, 64-bit numbers are aligned to 8 and enumerations are 32
/// bits wide. The greeting shows whether the structures match.
#ifndef PIL_WIRE_H
#define PIL_WIRE_H

#include "cam_machine.h" // cam_status_t, cam_feasibility_t
#include "cam_trace.h"   // cam_tick_record_t
#include "hal/hal.h"     // hal_encoder_t, hal_setpoint_t
#include <stddef.h>      // offsetof
#include <stdint.h>      // int32_t, uint32_t

/// Descriptors of the two pipes in the emulator's process, far from those it opens itself.
enum { pil_request_fd = 198, pil_answer_fd = 199 };
#define PIL_REQUEST_PATH "/dev/fd/198"
#define PIL_ANSWER_PATH "/dev/fd/199"

enum { pil_magic = 0x314C4950 }; ///< "PIL1"

/// Most bytes after a request: both together fit into one write to a pipe.
enum { pil_chunk_bytes = 2048 };

/// Greeting of the target.
typedef struct {
    uint32_t magic;
    uint32_t headers;       ///< PIL_HEADERS: fingerprint of the headers it was compiled with
    uint32_t request_bytes; ///< sizes of the two structures
    uint32_t answer_bytes;
    uint32_t table_bytes; ///< room for a table image
} pil_hello_t;

/// Operations; a and b are members of the request.
typedef enum {
    pil_op_init, ///< hal_init(), cam_machine_init(); a: [Hz] tick, b: [Hz] clock; port: pil_port_*
    pil_op_tick, ///< cam_isr() with the inputs
    pil_op_get_param,    ///< a: cam_param_id_t; the answer's value: the parameter
    pil_op_set_param,    ///< a: cam_param_id_t, b: value
    pil_op_table_bytes,  ///< a: offset in the table image, b: number of bytes that follow
    pil_op_table_flip,   ///< a: offset in the table image of a byte whose lowest bit flips
    pil_op_select_table, ///< a: [bytes] of the image
    pil_op_feasibility,  ///< for the speed that start would use
    pil_op_enable,
    pil_op_start,
    pil_op_stop,
    pil_op_hold,     ///< a: 1 cam_machine_hold(), 0 cam_machine_resume()
    pil_op_poll,     ///< cam_machine_poll()
    pil_op_learning, ///< a: number of a harmonic; the answer has learning and harmonic
} pil_op_t;

/// Bits of pil_request_t.port: abilities of camsim's port.
enum {
    pil_port_has_edge_time = 1u << 0, ///< hal_has_edge_time()
    pil_port_measures_u = 1u << 1,    ///< hal_measures_u()
};

typedef struct {
    uint32_t op; ///< pil_op_t
    uint32_t a;
    int32_t b;
    uint32_t port;     ///< pil_port_*, of pil_op_init
    hal_force_t force; ///< likewise
    uint32_t clock;    ///< [1 / clock_hz] from here on: inputs of the tick
    hal_encoder_t encoder;
    int32_t axis_nm[hal_n_axes];
    uint32_t inputs;
    int32_t swing_q32;
} pil_request_t;

typedef struct {
    int32_t err;        ///< cam_err_t of a slow call
    int32_t value;      ///< value of a parameter
    uint32_t n_records; ///< 1: `record` is valid
    uint32_t outputs;   ///< from here on: outputs of the tick
    int32_t force_q6;
    int32_t spindle_mrpm;
    hal_setpoint_t axis[hal_n_axes];
    hal_swing_t swing;
    uint32_t n_swing; ///< set-points of the swing since pil_op_init
    cam_status_t status;
    cam_tick_record_t record;
    cam_feasibility_t feasibility;
    cam_ilc_status_t learning;
    cam_ilc_harmonic_t harmonic;
} pil_answer_t;

_Static_assert(sizeof(cam_state_t) == 4 && sizeof(cam_err_t) == 4, "enumerations of 32 bits");
_Static_assert(_Alignof(int64_t) == 8, "64-bit numbers aligned to 8");
_Static_assert(sizeof(pil_request_t) + pil_chunk_bytes <= 4096, "at once into a pipe");

#endif
