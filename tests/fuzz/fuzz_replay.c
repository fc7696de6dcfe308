// SPDX-License-Identifier: Apache-2.0
// Runs a target on files, without libFuzzer: every normal build keeps what was found this way.
#include "fuzz_expect.h"
#include "fuzz_mutate.h"
#include <dirent.h> // opendir
#include <stdint.h>
#include <stdio.h>
#include <string.h>

enum { most_bytes = 1 << 20, most_path = 4096 };

size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t max_size)
{
    (void)data;
    (void)max_size;
    return size;
}

static int run_file(const char *path)
{
    static uint8_t bytes[most_bytes];
    FILE *file = fopen(path, "rb");
    if (file == NULL) {
        (void)printf("%s: cannot be opened; give files or folders of inputs\n", path);
        return -1;
    }
    const size_t n = fread(bytes, 1, sizeof bytes, file);
    (void)fclose(file);
    (void)printf("%s\n", path); // before it is run: a crash is that of the last line
    (void)fflush(stdout);
    // A copy of its own length, so that a sanitizer sees what reads beyond it.
    uint8_t *const copy = malloc(n > 0u ? n : 1u);
    if (copy == NULL) {
        return -1;
    }
    memcpy(copy, bytes, n);
    (void)LLVMFuzzerTestOneInput(copy, n);
    free(copy);
    return 1;
}

/// @return number of inputs that were run, or -1
static int run(const char *path)
{
    DIR *folder = opendir(path);
    if (folder == NULL) {
        return run_file(path);
    }
    int n = 0;
    for (struct dirent *entry = readdir(folder); entry != NULL && n >= 0; entry = readdir(folder)) {
        char inner[most_path];
        (void)snprintf(inner, sizeof inner, "%s/%s", path, entry->d_name);
        const int done = entry->d_name[0] == '.' ? 0 : run_file(inner);
        n = done < 0 ? -1 : n + done;
    }
    (void)closedir(folder);
    return n;
}

int main(int argc, char **argv)
{
    int n = 0;
    for (int i = 1; i < argc; i++) {
        const int done = run(argv[i]);
        if (done < 0) {
            return 2;
        }
        n += done;
    }
    (void)printf("%d inputs\n", n);
    return n > 0 ? 0 : 2;
}
