// SPDX-License-Identifier: Apache-2.0
// The Linux port's CAN socket: binding anew, while the tick goes on with it. The kernel is the
// test's own.
#include "lin_port.h"
#include "unity.h"
#include <errno.h>      // ENODEV
#include <net/if.h>     // if_nametoindex
#include <sys/socket.h> // bind, setsockopt

static lin_can_t can;
static bool is_there, is_removed_again;
static uint32_t n_binds;

// These functions stand in front of those of the library.

unsigned if_nametoindex(const char *name)
{
    (void)name;
    return is_there ? 1u : 0u;
}

int setsockopt(int fd, int level, int name, const void *value, socklen_t size)
{
    (void)fd;
    (void)level;
    (void)name;
    (void)value;
    (void)size;
    return 0;
}

/// The tick may report a removal at any time, here in the middle of the binding.
int bind(int fd, __CONST_SOCKADDR_ARG address, socklen_t size)
{
    (void)fd;
    (void)address;
    (void)size;
    n_binds++;
    if (is_removed_again) {
        atomic_store(&can.is_gone, true);
    }
    errno = ENODEV;
    return is_there ? 0 : -1;
}

void setUp(void)
{
    can = (lin_can_t){.fd = -1, .interface = "vcan7", .n_filters = 1};
    is_there = true;
    is_removed_again = false;
    n_binds = 0;
}

/// Bind three times: the last two find it as the first left it.
static void expect_binding(bool is_gone, uint32_t n)
{
    n_binds = 0;
    for (int i = 0; i < 3; i++) {
        lin_can_rebind(&can);
        TEST_ASSERT_EQUAL(is_gone, atomic_load(&can.is_gone));
    }
    TEST_ASSERT_EQUAL_UINT32(n, n_binds);
}

static void test_interface_that_was_removed_is_bound_once_it_is_back(void)
{
    expect_binding(false, 0); // it is there
    atomic_store(&can.is_gone, true);
    is_there = false;
    expect_binding(true, 0);
    is_there = true;
    expect_binding(false, 1);
}

static void test_removal_in_the_middle_of_the_binding_is_not_forgotten(void)
{
    atomic_store(&can.is_gone, true);
    is_removed_again = true;
    expect_binding(true, 3);
    is_removed_again = false;
    expect_binding(false, 1);
}
