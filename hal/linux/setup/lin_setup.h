// SPDX-License-Identifier: Apache-2.0
/// lin_setup: the configuration, its checks, and the files that the port keeps across a restart:
/// table, parameters, black box, reason of a halt. README.md explains every key of the
/// configuration; camturn.toml lists all keys with their defaults. Context: main(), if not stated.
#ifndef LIN_SETUP_H
#define LIN_SETUP_H

#include "common_error.h" // common_error_t
#include "hal/hal.h" // hal_n_axes, hal_operator_t, hal_image_t, hal_params_t, hal_memory_t, hal_start_t
#include <stdbool.h>   // bool
#include <stdint.h>    // int64_t, uint32_t, uint8_t, int32_t
#include <sys/types.h> // ssize_t

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

// Checks the consistency of a configuration. Only the file is checked, not the machine.

/// Read a file into *config (missing keys keep their values) and check that its values are
/// consistent.
/// @return false and *e on the first error: field, value, remedy
bool lin_check_load(lin_config_t *config, const char *path, common_error_t *e);

/// Prints a line.
typedef void lin_check_report_t(const char *line);

/// Report doubtful values, one line each, beginning with "warning: ".
void lin_check_warn(const lin_config_t *config, lin_check_report_t *report);

// Worst-case bus load of a configuration. Frames have the greatest number of stuff bits; encoder
// and drives send one frame per tick, each node two heartbeats per node_timeout_ms. Retransmissions
// and frames of other nodes are not counted. Pure. Source: ISO 11898-1, frame formats; a stuff bit
// after five equal bits.

typedef struct {
    int64_t tick_ns;   ///< bus time of the frames of one tick
    int64_t second_ns; ///< bus time of heartbeats and status in a second
    int64_t n_queued;  ///< [frames] most that this computer sends in one tick
} lin_load_t;

lin_load_t lin_load_of(const lin_config_t *config);

/// @return [%] bus load, rounded up
int64_t lin_load_percent(const lin_load_t *load, int64_t tick_hz);

/// @return [Hz] highest tick rate possible, 0: none
int64_t lin_load_most_hz(const lin_load_t *load);

// Location of a GPIO line: CHIP:OFFSET, or a name.

typedef struct {
    char chip[lin_name_max + 16]; ///< path
    unsigned offset;
    const char *name; ///< NULL: given by offset
} lin_place_t;

/// @param chip   chip for a name: gpiochip0 or a path
/// @param place  name or CHIP:OFFSET; static
/// @return       false and *e if the offset is not a number
bool lin_place_parse(lin_place_t *p, const char *chip, const char *place, common_error_t *e);

/// @return whether both are the same line; a name and an offset are never equal
bool lin_place_is_same(const lin_place_t *a, const lin_place_t *b);

/// Format the error for a line that cannot be requested. @return false
/// @param err  errno
/// @param who  program that uses the line, "" if not known
bool lin_place_refuse(const lin_place_t *p, int err, const char *who, common_error_t *e);

// Section [operator] of the configuration: button, key switch.

/// @return the result of hal_operator(), with another nonce each time
hal_operator_t lin_operator(const lin_config_t *config);

// Reads and atomically replaces whole files: new content is written to a second file, flushed to
// disk and renamed over the old one, so that a power failure leaves the old or the new content.

/// Read the rest of a file.
/// @return [bytes] number of bytes read, at most `room`; -1 and errno on error
ssize_t lin_file_read(int fd, uint8_t *bytes, uint32_t room);

/// Replace a file and wait for the disk. The rename makes the new content valid, even if flushing
/// the directory fails.
/// @param e  error, text "" if none
/// @return   false and *e: the file cannot be written and the old one remains. True and *e: a power
///           failure may restore the old one
bool lin_file_replace(const char *path, const uint8_t *bytes, uint32_t n, common_error_t *e);

// The table in use and memory for the next one, both locked, and the file of the table, which is
// replaced atomically (lin_file_replace()). The functions implement hal.h.

/// Allocate the memory and read the file if it exists.
/// @param path       static
/// @param max_bytes  largest table
/// @return           false and *e: out of memory, file unreadable or too large
bool lin_table_open(const char *path, int64_t max_bytes, common_error_t *e);

/// @return the table in use; size 0: none
hal_image_t lin_table_image(void);

/// Begin a download. @return false if larger than max_bytes
bool lin_table_begin(uint32_t size);

/// Write a piece. @return false if outside the table, or no download was begun
bool lin_table_write(uint32_t offset, const void *bytes, uint32_t n);

/// @return the table of the download; size 0: none
hal_image_t lin_table_staged(void);

/// Replace the table in use and its file by the downloaded table. If this fails, it may be
/// repeated.
/// @param e  error, text "" if none
/// @return   false and *e: nothing was begun, or the file cannot be written; the old table remains.
///           True and *e: in use, but a power failure may restore the old one
bool lin_table_commit(common_error_t *e);

// The file of stored parameters. If it cannot be read, the program still starts: it reports the
// parameters as damaged and the firmware uses its defaults. The functions implement hal.h.

/// Read the file if it exists.
/// @param path  static; "": parameters are not stored
/// @param e     error (the file cannot be read now, or replaced later), text "" if none
void lin_params_open(const char *path, common_error_t *e);

/// @return content of the file
hal_params_t lin_params_kept(void);

/// Replace the file (lin_file_replace()).
/// @param e  error, text "" if none
/// @return   false and *e: the file cannot be written and the old one remains
bool lin_params_keep(const void *bytes, uint32_t size, common_error_t *e);

// Memory of the recorder, and the file that stores a black box across a restart. The firmware
// checks the content. A file of the wrong size is reported and stays until the next fault replaces
// it. The functions implement hal.h.

enum { lin_blackbox_words = 1 << 20 }; ///< 4 MiB

/// Read the file, if it exists, to the start of the memory.
/// @param table_file  path of the table; ".blackbox" is appended
/// @param e           error, text "" if none
void lin_blackbox_open(const char *table_file, common_error_t *e);

/// @return the memory, and the number of words read from the file
hal_memory_t lin_blackbox_memory(void);

/// Replace the file (lin_file_replace()), or remove it.
/// @param n  [words] 0: remove it
/// @param e  error, text "" if none
void lin_blackbox_keep(const int32_t *words, uint32_t n, common_error_t *e);

// Stores the reason of a hal_halt() in a file for the next start.

enum { lin_halt_text_bytes = 100 }; ///< a longer reason is cut off

/// Read and remove the reason of the last run.
/// @param table_file  path of the table; ".halt" is appended
hal_start_t lin_halt_text_start(const char *table_file);

/// Store a reason for the next start; not if the file is a symbolic link. Context: any.
void lin_halt_text_halt(const char *why);

#endif
