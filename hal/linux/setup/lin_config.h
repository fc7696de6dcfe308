// SPDX-License-Identifier: Apache-2.0
/// lin_config: the configuration file. README.md explains every key; camturn.toml lists all keys
/// with their defaults.
#ifndef LIN_CONFIG_H
#define LIN_CONFIG_H

#include "hal/hal.h"      // hal_n_axes
#include "common_error.h" // common_error_t
#include <stdbool.h>      // bool
#include <stdint.h>       // int64_t, uint32_t

enum { lin_name_max = 63, lin_path_max = 199, lin_interface_max = 15 };

/// Lines, inputs first; enable is the first output.
typedef enum {
    lin_line_estop,
    lin_line_ready,
    lin_line_index,
    lin_line_home_u, ///< home switches, then axis indices, in the order of hal_in_home_u
    lin_line_index_z = lin_line_home_u + 5,
    lin_line_acknowledge, ///< button; its place may be "waived"
    lin_line_key,
    lin_line_enable,
    lin_line_fault,
    lin_line_in_cut,
    lin_n_lines
} lin_line_t;

typedef enum { lin_index_line, lin_index_position } lin_index_t;

typedef struct {
    int64_t tick_hz;
    int64_t priority; ///< of SCHED_FIFO; 0: ordinary scheduling
    int64_t cpu;      ///< -1: the last CPU allowed
} lin_thread_config_t;

typedef struct {
    char interface[lin_interface_max + 1];
    char remote[lin_interface_max + 1]; ///< never empty after loading
    int64_t node;
    int64_t bitrate; ///< [bit/s] of the interface, for the bus load only
    bool is_fd;
    int64_t data_bitrate; ///< [bit/s] likewise, in the data phase of FD frames
    int64_t heartbeat_ms, node_timeout_ms, pdo_timeout_ms, enable_ms;
} lin_can_config_t;

typedef struct {
    int64_t node;
    int64_t modulus_counts; ///< 0: 2^32
    int64_t counts_per_turn;
    uint32_t index; ///< lin_index_t
    int64_t index_counts;
    int64_t delay_ns;
    int64_t max_age_us; ///< 0: three ticks
} lin_encoder_config_t;

typedef struct {
    int64_t node;       ///< 0: none
    int64_t counts, nm; ///< drive counts = nm * counts / nm
} lin_drive_config_t;

typedef struct {
    char place[lin_name_max + 1]; ///< line name, CHIP:OFFSET or "none"
    bool is_active_low;
} lin_line_config_t;

typedef struct {
    lin_thread_config_t thread;
    lin_can_config_t can;
    lin_encoder_config_t encoder;
    lin_drive_config_t drive[hal_n_axes];
    int64_t spindle_node; ///< 0: none
    char chip[lin_name_max + 1];
    lin_line_config_t line[lin_n_lines];
    char secret_file[lin_path_max + 1]; ///< "": none
    char table_file[lin_path_max + 1];
    int64_t table_max_bytes;
    char params_file[lin_path_max + 1]; ///< "": parameters are not stored
    bool has_retired;                   ///< the file has retired keys, which are ignored
} lin_config_t;

/// @return the default values
lin_config_t lin_config_defaults(void);

/// Read a file into *config; missing keys keep their values. lin_check_load() also checks
/// consistency.
/// @return false and *e on the first error
bool lin_config_read(lin_config_t *config, const char *path, common_error_t *e);

/// @return [us] greatest age of an encoder position: max_age_us, or three ticks if that is 0
int64_t lin_config_age_us(const lin_encoder_config_t *config, int64_t tick_hz);

/// @return whether the machine builder has waived the acknowledge button
bool lin_config_is_waived(const lin_config_t *config);

/// @return section and key of a line, static
const char *lin_line_name(lin_line_t line);

/// @return whether a line is wired
bool lin_line_is_there(const lin_config_t *config, lin_line_t line);

#endif
