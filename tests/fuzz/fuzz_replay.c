// SPDX-License-Identifier: Apache-2.0
// Runs a target without libFuzzer: on single files, or on folders of inputs with variants of each,
// whose summed digest is compared with a record.
//
//     fuzz_TARGET FILE ..                           run these, and print the digest of each
//     fuzz_TARGET RECORD NAME N_VARIANTS FOLDER ..  compare with the line NAME of a record
#include "fuzz_digest.h"
#include "fuzz_expect.h"
#include "fuzz_mutate.h"
#include <dirent.h>  // opendir
#include <stdbool.h> // bool
#include <stdint.h>
#include <stdio.h>
#include <string.h>

enum { most_bytes = 1 << 20, most_variant = 8192, most_path = 4096, n_changes = 4 };

typedef struct {
    uint8_t bytes[most_bytes];
    size_t n;
} input_t;

/// Sum of all digests: independent of the order of files.
static uint64_t total;
static uint32_t n_inputs;

/// Overwrite up to n_changes bytes, chosen by the content and a seed.
static size_t change(uint8_t *data, size_t size, uint32_t seed)
{
    uint32_t dice = seed;
    for (size_t i = 0; i < size; i++) {
        dice = dice * 1664525u + 1013904223u + data[i];
    }
    for (uint32_t i = 0; i < (uint32_t)n_changes && size > 0u; i++) {
        dice = dice * 1664525u + 1013904223u;
        data[(dice >> 8) % size] = (uint8_t)(dice >> 24);
    }
    return size;
}

size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t max_size)
{
    (void)max_size;
    return change(data, size, 1);
}

__attribute__((weak)) size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size,
                                                     unsigned seed)
{
    (void)max_size;
    return change(data, size, seed);
}

static bool is_read(input_t *input, const char *path)
{
    FILE *file = fopen(path, "rb");
    if (file == NULL) {
        (void)printf("%s: cannot be opened; give files or folders of inputs\n", path);
        return false;
    }
    input->n = fread(input->bytes, 1, sizeof input->bytes, file);
    (void)fclose(file);
    return true;
}

/// Run an input in a copy of its own length, so that a sanitizer sees what reads beyond it.
static uint64_t run(const input_t *input)
{
    uint8_t *const copy = malloc(input->n > 0u ? input->n : 1u);
    FUZZ_EXPECT(copy != NULL, "no memory");
    memcpy(copy, input->bytes, input->n);
    fuzz_digest_begin();
    (void)LLVMFuzzerTestOneInput(copy, input->n);
    free(copy);
    n_inputs++;
    total += fuzz_digest();
    return fuzz_digest();
}

/// Run n variants of an input of at most most_variant bytes, each mutated one to four times.
static void run_variants(const input_t *input, uint32_t n)
{
    static input_t variant;
    for (uint32_t i = 0; i < n && input->n <= (size_t)most_variant; i++) {
        variant.n = input->n;
        memcpy(variant.bytes, input->bytes, input->n);
        for (uint32_t seed = 4u * i; seed <= 4u * i + i % 4u; seed++) {
            variant.n = LLVMFuzzerCustomMutator(variant.bytes, variant.n, most_variant, seed);
        }
        (void)run(&variant);
    }
}

/// Run all inputs of a folder. @return whether there are any
static bool run_folder(const char *path, uint32_t n_variants)
{
    static input_t input;
    DIR *folder = opendir(path);
    const uint32_t n_before = n_inputs;
    struct dirent *entry = NULL;
    while (folder != NULL && (entry = readdir(folder)) != NULL) {
        char inner[most_path];
        (void)snprintf(inner, sizeof inner, "%s/%s", path, entry->d_name);
        if (entry->d_name[0] != '.' && is_read(&input, inner)) {
            (void)printf("%s\n", inner); // before it is run: a crash is that of the last line
            (void)fflush(stdout);
            const uint64_t before = total;
            (void)run(&input);
            run_variants(&input, n_variants);
            (void)printf("    %016llx\n", (unsigned long long)(total - before));
        }
    }
    return folder != NULL && closedir(folder) == 0 && n_inputs > n_before;
}

int main(int argc, char **argv)
{
    static input_t input;
    char *end = NULL;
    const unsigned long n_variants = argc > 4 ? strtoul(argv[3], &end, 10) : 0u;
    if (end != NULL && *end == '\0') {
        for (int i = 4; i < argc; i++) {
            if (!run_folder(argv[i], (uint32_t)n_variants)) {
                (void)printf("%s: no folder of inputs\n", argv[i]);
                return 2;
            }
        }
        (void)printf("%u inputs\n", (unsigned)n_inputs);
        return fuzz_digest_is_recorded(argv[1], argv[2], total) ? 0 : 1;
    }
    for (int i = 1; i < argc; i++) {
        if (!is_read(&input, argv[i])) {
            return 2;
        }
        (void)printf("%s: %016llx\n", argv[i], (unsigned long long)run(&input));
    }
    return argc > 1 ? 0 : 2;
}
