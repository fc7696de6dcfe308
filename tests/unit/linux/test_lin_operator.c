// SPDX-License-Identifier: Apache-2.0
// The Linux port's button, key and secret: what the configuration says, and whom the file lets in.
#include "lin_setup.h"
#include "lin_disk_bench.h"

static lin_config_t config;
void setUp(void)
{
    config = lin_config_defaults();
    error.text[0] = '\0';
}

static void write_secret(const char *text, mode_t mode)
{
    (void)snprintf(config.secret_file, sizeof config.secret_file, "%s", path);
    (void)unlink(config.secret_file); // one that may only be read would stay
    put_file(config.secret_file, text);
    TEST_ASSERT_EQUAL_INT(0, chmod(config.secret_file, mode));
}

static void refused(const char *part)
{
    TEST_ASSERT_FALSE(lin_operator_open(&config, &error));
    expect_error(part);
    TEST_ASSERT_EQUAL_UINT32(0, lin_operator(&config).n_secret);
}

static void test_by_default_nothing_is_allowed(void)
{
    TEST_ASSERT_TRUE(lin_operator_open(&config, &error));
    const hal_operator_t people = lin_operator(&config);
    TEST_ASSERT_FALSE(people.has_acknowledge);
    TEST_ASSERT_FALSE(people.is_acknowledge_waived);
    TEST_ASSERT_FALSE(people.has_key);
    TEST_ASSERT_EQUAL_UINT32(0, people.n_secret);
}

static void test_lines_are_there_and_a_waiver_is_no_line(void)
{
    (void)snprintf(config.line[lin_line_key].place, lin_name_max, "KEY");
    (void)snprintf(config.line[lin_line_acknowledge].place, lin_name_max, "gpiochip0:3");
    TEST_ASSERT_TRUE(lin_operator(&config).has_key);
    TEST_ASSERT_TRUE(lin_operator(&config).has_acknowledge);
    TEST_ASSERT_FALSE(lin_operator(&config).is_acknowledge_waived);
    (void)snprintf(config.line[lin_line_acknowledge].place, lin_name_max, "waived");
    TEST_ASSERT_FALSE(lin_operator(&config).has_acknowledge);
    TEST_ASSERT_TRUE(lin_operator(&config).is_acknowledge_waived);
}

static void test_a_secret_is_read_without_its_line_end(void)
{
    write_secret("0123456789abcdef\n", 0600);
    TEST_ASSERT_TRUE_MESSAGE(lin_operator_open(&config, &error), error.text);
    const hal_operator_t people = lin_operator(&config);
    TEST_ASSERT_EQUAL_UINT32(16, people.n_secret);
    TEST_ASSERT_EQUAL_MEMORY("0123456789abcdef", people.secret, 16);
    write_secret("0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef", 0400);
    TEST_ASSERT_TRUE_MESSAGE(lin_operator_open(&config, &error), error.text);
    TEST_ASSERT_EQUAL_UINT32(64, lin_operator(&config).n_secret);
}

/// Others may neither read nor write it.
static void test_a_secret_of_wrong_size_or_rights_is_refused(void)
{
    static const mode_t modes[] = {0640, 0604, 0620, 0602, 0660, 0644};
    for (size_t i = 0; i < sizeof modes / sizeof modes[0]; i++) {
        write_secret("0123456789abcdef", modes[i]);
        refused("chmod 600");
    }
    write_secret("0123456789abcde\n", 0600);
    refused("give 16 .. 64 bytes");
    write_secret("0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef!", 0600);
    refused("give 16 .. 64 bytes");
}

static void test_what_is_no_file_of_its_own_is_refused(void)
{
    char link[sizeof config.secret_file];
    write_secret("0123456789abcdef", 0600);
    (void)snprintf(link, sizeof link, "%s/link", folder);
    TEST_ASSERT_EQUAL_INT(0, symlink(path, link));
    memcpy(config.secret_file, link, sizeof link);
    refused("link: ");
    (void)unlink(link);
    (void)snprintf(config.secret_file, sizeof config.secret_file, "%s", folder);
    refused("not a regular file");
    (void)snprintf(config.secret_file, sizeof config.secret_file, "%s/nowhere", folder);
    refused("No such file");
}
