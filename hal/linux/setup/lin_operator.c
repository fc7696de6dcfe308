// SPDX-License-Identifier: Apache-2.0
#include "lin_setup.h"
#include <errno.h>      // errno
#include <fcntl.h>      // open
#include <string.h>     // strcmp, strerror
#include <sys/random.h> // getrandom
#include <sys/stat.h>   // fstat
#include <unistd.h>     // close

enum { least_bytes = 16, most_bytes = 64, room_bytes = 80, for_others = 077 };

static uint8_t secret[room_bytes];
static uint32_t n_secret, nonce;

/// Check the file's type and mode and read it. @return false and *e on error
static bool read_secret(int fd, const char *path, common_error_t *e)
{
    struct stat about;
    if (fstat(fd, &about) != 0 || !S_ISREG(about.st_mode)) {
        return common_error(e, "operator.secret: %s: not a regular file; give another", path);
    }
    if ((about.st_mode & (mode_t)for_others) != 0u) {
        return common_error(
            e, "operator.secret: %s: mode %04o lets other users access it; chmod 600 %s", path,
            (unsigned)(about.st_mode & 07777u), path);
    }
    ssize_t n = lin_file_read(fd, secret, sizeof secret);
    while (n > 0 && (secret[n - 1] == '\n' || secret[n - 1] == '\r')) {
        n--;
    }
    if (n < least_bytes || n > most_bytes) {
        return common_error(e, "operator.secret: %s: give %d .. %d bytes", path, (int)least_bytes,
                            (int)most_bytes);
    }
    n_secret = (uint32_t)n;
    return true;
}

bool lin_operator_open(const lin_config_t *config, common_error_t *e)
{
    const char *path = config->secret_file;
    n_secret = 0;
    if (getrandom(&nonce, sizeof nonce, GRND_NONBLOCK) != (ssize_t)sizeof nonce) {
        nonce = 0;
    }
    if (path[0] == '\0') {
        return true;
    }
    const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
    if (fd < 0) {
        return common_error(e, "operator.secret: %s: %s; give a file owned by this user", path,
                            strerror(errno));
    }
    const bool is_good = read_secret(fd, path, e);
    (void)close(fd);
    return is_good;
}

hal_operator_t lin_operator(const lin_config_t *config)
{
    return (hal_operator_t){
        .has_acknowledge = lin_line_is_there(config, lin_line_acknowledge),
        .is_acknowledge_waived = lin_config_is_waived(config),
        .has_key = lin_line_is_there(config, lin_line_key),
        .secret = secret,
        .n_secret = n_secret,
        .nonce = nonce,
    };
}
