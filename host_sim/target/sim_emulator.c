// SPDX-License-Identifier: Apache-2.0
#define _GNU_SOURCE // NOLINT(bugprone-reserved-identifier): pipe2, sched_setaffinity
#include "sim_emulator.h"
#include "pil_wire.h"  // pil_request_fd
#include <errno.h>     // errno
#include <fcntl.h>     // O_CLOEXEC
#include <poll.h>      // poll
#include <sched.h>     // sched_setaffinity
#include <signal.h>    // kill
#include <string.h>    // strcspn, strerror
#include <stdio.h>     // snprintf
#include <sys/mman.h>  // memfd_create
#include <sys/prctl.h> // PR_SET_PDEATHSIG
#include <sys/wait.h>  // waitpid
#include <unistd.h>    // fork, execvp

#define EMULATOR "qemu-system-arm"

enum { patience_ms = 20000 };

/// CPUs of this process before it was pinned.
static cpu_set_t all_cpus;

/// Failure is harmless: the exchange is only slower.
static void pin(void)
{
    cpu_set_t one;
    const int cpu = sched_getcpu();
    CPU_ZERO(&one);
    if (sched_getaffinity(0, sizeof all_cpus, &all_cpus) == 0 && cpu >= 0) {
        CPU_SET((size_t)cpu, &one);
        (void)sched_setaffinity(0, sizeof one, &one);
    }
}

static void unpin(void)
{
    if (CPU_COUNT(&all_cpus) > 0) {
        (void)sched_setaffinity(0, sizeof all_cpus, &all_cpus);
    }
}

/// Pipes of a start; `report` carries the reason of a failed start, `words` the output.
typedef struct {
    int request[2], answer[2], report[2];
    int words;
} pipes_t;

static void close_all(const pipes_t *p)
{
    const int fd[] = {p->request[0], p->request[1], p->answer[0], p->answer[1],
                      p->report[0],  p->report[1],  p->words};
    for (size_t i = 0; i < sizeof fd / sizeof fd[0]; i++) {
        if (fd[i] >= 0) {
            (void)close(fd[i]);
        }
    }
}

static bool open_pipes(pipes_t *p)
{
    *p = (pipes_t){{-1, -1}, {-1, -1}, {-1, -1}, memfd_create("words", MFD_CLOEXEC)};
    if (p->words >= 0 && pipe2(p->request, O_CLOEXEC) == 0 && pipe2(p->answer, O_CLOEXEC) == 0 &&
        pipe2(p->report, O_CLOEXEC) == 0) {
        return true;
    }
    const int number = errno;
    close_all(p);
    errno = number;
    return false;
}

static _Noreturn void become_emulator(const pipes_t *p, char *const *command, int parent)
{
    (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
    const int nothing = open("/dev/null", O_RDONLY | O_CLOEXEC);
    if (getppid() == parent && dup2(nothing, STDIN_FILENO) >= 0 &&
        dup2(p->words, STDOUT_FILENO) >= 0 && dup2(p->words, STDERR_FILENO) >= 0 &&
        dup2(p->request[0], pil_request_fd) >= 0 && dup2(p->answer[1], pil_answer_fd) >= 0) {
        (void)execvp(command[0], command);
    }
    const int number = errno;
    (void)!write(p->report[1], &number, sizeof number);
    _exit(127);
}

static bool has_started(sim_emulator_t *m, pipes_t *p, common_error_t *e)
{
    int number = 0;
    (void)close(p->report[1]);
    p->report[1] = -1;
    while (read(p->report[0], &number, sizeof number) < 0 && errno == EINTR) {
    }
    (void)close(p->report[0]);
    (void)close(p->answer[1]); // only the emulator keeps it open now
    if (number == 0) {
        return true;
    }
    sim_emulator_stop(m);
    return common_error(e,
                        EMULATOR ": cannot be run: %s; install the Debian package qemu-system-arm",
                        strerror(number));
}

bool sim_emulator_start(sim_emulator_t *m, const char *board, const char *image, common_error_t *e)
{
    const char *const command[] = {
        EMULATOR,  "-M",      board,  "-nographic",          "-monitor",
        "none",    "-serial", "none", "-semihosting-config", "enable=on,target=native",
        "-kernel", image,     NULL};
    pipes_t p;
    if (!open_pipes(&p)) {
        return common_error(e, EMULATOR ": no pipes to it: %s; free some files", strerror(errno));
    }
    pin();
    const int parent = getpid();
    m->pid = fork();
    if (m->pid == 0) {
        become_emulator(&p, (char *const *)command, parent);
    }
    if (m->pid < 0) {
        const int number = errno;
        close_all(&p);
        unpin();
        return common_error(e, EMULATOR ": no process for it: %s; end some", strerror(number));
    }
    m->request_fd = p.request[1];
    m->spare_fd = p.request[0];
    m->answer_fd = p.answer[0];
    m->words_fd = p.words;
    return has_started(m, &p, e);
}

bool sim_emulator_send(sim_emulator_t *m, const void *bytes, size_t n, common_error_t *e)
{
    ssize_t written;
    do {
        written = write(m->request_fd, bytes, n);
    } while (written < 0 && errno == EINTR);
    return written == (ssize_t)n ||
           common_error(e, EMULATOR ": the pipe to it broke: %s; run it again",
                        written < 0 ? strerror(errno) : "full");
}

/// First line of output of the emulator or its program.
static void first_words(const sim_emulator_t *m, char *line, size_t size)
{
    const ssize_t n = pread(m->words_fd, line, size - 1u, 0);
    line[n > 0 ? n : 0] = '\0';
    line[strcspn(line, "\r\n")] = '\0';
}

/// The emulator closed its pipe: report how it ended.
static bool has_ended(sim_emulator_t *m, common_error_t *e)
{
    char words[200];
    char how[60];
    int status = 0;
    const bool is_reaped = waitpid(m->pid, &status, 0) == m->pid;
    m->pid = -1;
    first_words(m, words, sizeof words);
    if (is_reaped && WIFSIGNALED(status)) {
        (void)snprintf(how, sizeof how, "killed by signal %d", WTERMSIG(status));
    } else {
        (void)snprintf(how, sizeof how, "exit status %d", is_reaped ? WEXITSTATUS(status) : -1);
    }
    return common_error(e,
                        EMULATOR ": ended before the cut did: %s%s%s; hal/mps2/README.md lists why",
                        how, words[0] != '\0' ? ": " : "", words);
}

bool sim_emulator_receive(sim_emulator_t *m, void *bytes, size_t n, common_error_t *e)
{
    uint8_t *to = (uint8_t *)bytes;
    while (n > 0u) {
        struct pollfd answer = {.fd = m->answer_fd, .events = POLLIN};
        const int n_ready = poll(&answer, 1, patience_ms);
        const ssize_t n_read = n_ready > 0 ? read(m->answer_fd, to, n) : -1;
        if (n_ready == 0) {
            return common_error(e, EMULATOR ": silent for %d s; is the image the right one?",
                                patience_ms / 1000);
        }
        if (n_read == 0) {
            return has_ended(m, e);
        }
        if (n_read < 0 && errno != EINTR) {
            return common_error(e, EMULATOR ": the pipe from it broke: %s; run it again",
                                strerror(errno));
        }
        to += n_read > 0 ? n_read : 0;
        n -= n_read > 0 ? (size_t)n_read : 0u;
    }
    return true;
}

/// Kill it: it has nothing to save, and may be stuck anywhere.
void sim_emulator_stop(sim_emulator_t *m)
{
    (void)close(m->request_fd);
    (void)close(m->spare_fd);
    (void)close(m->answer_fd);
    (void)close(m->words_fd);
    if (m->pid > 0) {
        (void)kill(m->pid, SIGKILL);
        (void)waitpid(m->pid, NULL, 0);
        m->pid = -1;
    }
    unpin();
}
