// SPDX-License-Identifier: Apache-2.0
#include "unit_run.h"
#include "unity.h"
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

static void (*set_up_of_file)(void);
static void (*tear_down_of_file)(void);

void setUp(void);
void tearDown(void);

void setUp(void)
{
    if (set_up_of_file) {
        set_up_of_file();
    }
}

void tearDown(void)
{
    if (tear_down_of_file) {
        tear_down_of_file();
    }
}

void unit_begin(const char *path, void (*set_up)(void), void (*tear_down)(void),
                void (*suite_set_up)(void))
{
    Unity.TestFile = path;
    set_up_of_file = set_up;
    tear_down_of_file = tear_down;
    if (suite_set_up) {
        suite_set_up();
    }
}

int unit_end(int (*suite_tear_down)(int n_failures))
{
    return suite_tear_down ? suite_tear_down(0) : 0;
}

static int run_files(const char *const *names, int n_names)
{
    int n_failures = 0;
    for (const unit_file_t *file = unit_files; file->name; file++) {
        bool is_wanted = n_names == 0;
        for (int i = 0; i < n_names; i++) {
            is_wanted = is_wanted || strcmp(names[i], file->name) == 0;
        }
        n_failures += is_wanted ? file->run() : 0;
    }
    return n_failures;
}

#ifdef __ARM_ARCH // a board passes no arguments
int main(void)
{
    const int n_names = 0;
    const char *const *const names = NULL;
#else
int main(int argc, char *argv[])
{
    const int n_names = argc - 1;
    const char *const *const names = (const char *const *)argv + 1;
#endif
    UnityBegin("");
    const int n_others = run_files(names, n_names);
    const bool is_empty = Unity.NumberOfTests == 0;
    if (is_empty) {
        (void)puts("no such file of tests: give names such as test_cam_guard");
    }
    return UnityEnd() + n_others + (is_empty ? 1 : 0);
}
