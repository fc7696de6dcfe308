// SPDX-License-Identifier: Apache-2.0
/// unit_run: the program of a folder of tests runs all of its files, or those named as arguments.
/// unity_run.cmake writes the function that runs a file, CMakeLists.txt the list of these
/// functions.
#ifndef UNIT_RUN_H
#define UNIT_RUN_H

typedef struct {
    const char *name; ///< of the file, without folder and ending; 0 at the end of the list
    int (*run)(void); ///< returns a count of failures that Unity has not counted
} unit_file_t;

extern const unit_file_t unit_files[];

/// Start the tests of a file. A function that the file does not define is 0.
/// @param path            of the file, printed with each result
/// @param set_up          called before each test
/// @param tear_down       called after each test
/// @param suite_set_up    called now
void unit_begin(const char *path, void (*set_up)(void), void (*tear_down)(void),
                void (*suite_set_up)(void));

/// End the tests of a file.
/// @param suite_tear_down  called now, with no failures; 0: the file does not define it
/// @return                 its result
int unit_end(int (*suite_tear_down)(int n_failures));

#endif
