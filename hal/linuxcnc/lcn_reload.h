// SPDX-License-Identifier: Apache-2.0
/// lcn_reload: reads the table file, and reads it again while LinuxCNC runs, in a thread of its
/// own, so that no HAL thread waits for a disk. The thread also writes recordings (lcn_record.h).
#ifndef LCN_RELOAD_H
#define LCN_RELOAD_H

#include <stdbool.h> // bool
#include <stddef.h>  // size_t

enum { lcn_table_most_bytes = 1 << 26, lcn_table_error_bytes = 256 };

typedef struct {
    void *bytes; ///< aligned for any type, of malloc()
    size_t size; ///< [bytes]
    char error[lcn_table_error_bytes];
} lcn_table_t;

/// @return false and table->error if the file cannot be read completely
bool lcn_table_read(const char *path, lcn_table_t *table);

typedef enum {
    lcn_reload_idle,
    lcn_reload_asked,  ///< the thread reads
    lcn_reload_read,   ///< *lcn_reload_table() is complete
    lcn_reload_failed, ///< ... has the error
} lcn_reload_phase_t;

/// Start the thread. Context: while the component is loaded.
/// @param path  .camtab file, valid until lcn_reload_end()
/// @return      false if there is no thread
bool lcn_reload_begin(const char *path);

/// End the thread. Context: while the component is unloaded.
void lcn_reload_end(void);

/// Read the file. Context: slow thread, phase idle.
void lcn_reload_ask(void);

/// @return what the thread does. Context: slow thread
lcn_reload_phase_t lcn_reload_phase(void);

/// @return what was read. Context: slow thread, phases read and failed
const lcn_table_t *lcn_reload_table(void);

/// Return to idle. Memory of a table that was not kept is freed with the next reading, that of one
/// that was kept when the one after it is kept: the interrupt may still read it until then.
/// Context: slow thread, phases read and failed.
/// @param is_kept  the table is in use
void lcn_reload_settle(bool is_kept);

#endif
