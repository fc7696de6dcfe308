// SPDX-License-Identifier: Apache-2.0
// The receiver of ISO 15765-2: lengths in both forms, sequence, flow control, time-out, and every
// frame that must be ignored.
#include "cam_remote_inner.h" // cam_isotp_t, cam_isotp_block_size, cam_isotp_broken
#include "unity.h"
#include <string.h> // memset

enum { capacity = 5000, timeout_ticks = 1000 };

static uint8_t bytes[capacity];
static cam_isotp_t t;
static uint32_t now;

void setUp(void)
{
    memset(bytes, 0, sizeof bytes);
    t = (cam_isotp_t){.bytes = bytes, .capacity = capacity, .timeout_ticks = timeout_ticks};
    now = UINT32_MAX - 3u; // time wraps during each test
}

static uint8_t pattern(uint32_t i)
{
    return (uint8_t)(i * 7u + i / 256u);
}

static cam_isotp_event_t give(uint32_t n, const uint8_t *data)
{
    hal_can_frame_t frame = {.id = 0x6C0, .n = n};
    memcpy(frame.data, data, n);
    now += 1u;
    return cam_isotp_receive(&t, &frame, now);
}

static cam_isotp_event_t give_first(uint32_t length)
{
    uint8_t data[8] = {(uint8_t)(0x10u | length >> 8), (uint8_t)length};
    uint32_t header = 2;
    if (length > 4095u) {
        data[0] = 0x10;
        data[1] = 0;
        for (uint32_t i = 0; i < 4u; i++) {
            data[2 + i] = (uint8_t)(length >> (24u - 8u * i));
        }
        header = 6;
    }
    for (uint32_t i = header; i < 8u; i++) {
        data[i] = pattern(i - header);
    }
    return give(8, data);
}

static cam_isotp_event_t give_next(uint32_t sequence, uint32_t at, uint32_t n)
{
    uint8_t data[8] = {(uint8_t)(0x20u | sequence % 16u)};
    for (uint32_t i = 0; i < n; i++) {
        data[1 + i] = pattern(at + i);
    }
    return give(1u + n, data);
}

/// The message goes on.
static void begin(uint32_t length)
{
    TEST_ASSERT_EQUAL_INT(cam_isotp_nothing, give_first(length));
}

static void expect_flow(uint8_t status, uint8_t block_size)
{
    hal_can_frame_t frame;
    TEST_ASSERT_TRUE(cam_isotp_flow(&t, &frame));
    TEST_ASSERT_EQUAL_UINT32(3, frame.n);
    TEST_ASSERT_EQUAL_HEX8(status, frame.data[0]);
    TEST_ASSERT_EQUAL_UINT8(block_size, frame.data[1]);
    TEST_ASSERT_EQUAL_UINT8(0, frame.data[2]);
    t.has_flow = false;
    TEST_ASSERT_FALSE(cam_isotp_flow(&t, &frame));
}

/// Nobody waits for a message, or is asked for one.
static void expect_idle(void)
{
    hal_can_frame_t frame;
    TEST_ASSERT_FALSE(cam_isotp_flow(&t, &frame));
    TEST_ASSERT_EQUAL_INT(cam_isotp_nothing, cam_isotp_wait(&t, now + 10u * timeout_ticks));
    TEST_ASSERT_EQUAL_INT(cam_isotp_nothing, give_next(1, 6, 7));
}

static void expect_bytes(uint32_t n)
{
    TEST_ASSERT_EQUAL_UINT32(n, t.length);
    for (uint32_t i = 0; i < n; i++) {
        TEST_ASSERT_EQUAL_UINT8(pattern(i), bytes[i]);
    }
}

/// Send a message as a sender that follows the standard does.
static void send_whole(uint32_t length)
{
    begin(length);
    uint32_t at = length > 4095u ? 2 : 6;
    for (uint32_t i = 1; at < length; i++) {
        if (i % cam_isotp_block_size == 1u) {
            expect_flow(0x30, 8);
        }
        const uint32_t n = length - at < 7u ? length - at : 7u;
        const cam_isotp_event_t event = give_next(i, at, n);
        at += n;
        TEST_ASSERT_EQUAL_INT(at == length ? cam_isotp_message : cam_isotp_nothing, event);
    }
    expect_bytes(length);
}

/// Up to the room; as short as they may be and padded to eight bytes.
static void test_single_frames(void)
{
    for (uint32_t n = 1; n <= 7u; n++) {
        uint8_t data[8] = {(uint8_t)n};
        for (uint32_t i = 0; i < n; i++) {
            data[1 + i] = pattern(i);
        }
        t.capacity = n;
        TEST_ASSERT_EQUAL_INT(cam_isotp_message, give(1u + n, data));
        expect_bytes(n);
        TEST_ASSERT_EQUAL_INT(cam_isotp_message, give(8, data));
        expect_bytes(n);
        t.capacity = n - 1u;
        TEST_ASSERT_EQUAL_INT(cam_isotp_nothing, give(1u + n, data));
    }
}

static void test_long_messages_of_every_form(void)
{
    static const uint32_t lengths[] = {8,   13,   14,   20,   62,   63,  117,
                                       118, 4094, 4095, 4096, 4100, 5000};
    for (uint32_t i = 0; i < sizeof lengths / sizeof lengths[0]; i++) {
        send_whole(lengths[i]);
        expect_idle();
    }
    memset(bytes, 0, sizeof bytes);
    begin(8);
    TEST_ASSERT_EQUAL_INT(cam_isotp_message, give_next(1, 6, 7)); // the last frame is padded
    expect_bytes(8);
    TEST_ASSERT_EQUAL_UINT8(0, bytes[8]);
}

/// Also where not even its first bytes would fit.
static void test_a_message_that_is_too_long_touches_no_memory(void)
{
    static const uint8_t empty[8];
    t.capacity = 4;
    TEST_ASSERT_EQUAL_INT(cam_isotp_nothing, give_first(9));
    TEST_ASSERT_EQUAL_UINT8_ARRAY(empty, bytes, sizeof empty);
}

static void test_wrong_sequence_breaks(void)
{
    for (uint32_t wrong = 0; wrong < 16u; wrong++) {
        begin(300);
        TEST_ASSERT_EQUAL_INT(cam_isotp_nothing, give_next(1, 6, 7));
        const cam_isotp_event_t event = give_next(wrong, 13, 7);
        TEST_ASSERT_EQUAL_INT(wrong == 2u ? cam_isotp_nothing : cam_isotp_broken, event);
        if (wrong != 2u) { // the message has ended, and nobody waits for the rest of it
            TEST_ASSERT_EQUAL_INT(cam_isotp_nothing, cam_isotp_wait(&t, now + 10u * timeout_ticks));
            TEST_ASSERT_EQUAL_INT(cam_isotp_nothing, give_next(2, 13, 7));
        }
    }
}

/// A new message takes the place of the old.
static void test_a_late_frame_breaks(void)
{
    begin(300);
    const uint32_t since = now;
    TEST_ASSERT_EQUAL_INT(cam_isotp_nothing, cam_isotp_wait(&t, since + timeout_ticks));
    TEST_ASSERT_EQUAL_INT(cam_isotp_broken, cam_isotp_wait(&t, since + timeout_ticks + 1u));
    TEST_ASSERT_EQUAL_INT(cam_isotp_nothing, cam_isotp_wait(&t, since + timeout_ticks + 2u));
    expect_idle();
    send_whole(300);
    static const uint8_t one[] = {1, 0};
    begin(300);
    TEST_ASSERT_EQUAL_INT(cam_isotp_nothing, give_next(1, 6, 7));
    send_whole(80);
    begin(300);
    TEST_ASSERT_EQUAL_INT(cam_isotp_message, give(2, one));
    expect_bytes(1);
    expect_idle();
}

/// Nor do they disturb a message.
static void test_frames_without_a_place_are_passed_over(void)
{
    static const struct {
        uint32_t n;
        uint8_t data[12];
    } frames[] = {
        {0, {0}},
        {1, {0x00}},                      // single frame without a byte
        {8, {0x00, 9}},                   // the long form of CAN FD
        {8, {0x08}},                      // more than a frame holds
        {3, {0x03, 1, 2}},                // cut off
        {8, {0x21, 1}},                   // consecutive frame without a message
        {7, {0x10, 20, 1, 2, 3, 4}},      // first frame, cut off
        {8, {0x10, 7}},                   // would have fitted one frame
        {8, {0x10, 0, 0, 0, 0x0F, 0xFF}}, // would have fitted twelve bits
        {8, {0x10, 0, 0, 0, 0, 0}},
        {3, {0x30, 8, 0}}, // flow control, which only the receiver sends
        {8, {0x40}},
        {8, {0xF0}},
        {12, {0x05, 1, 2, 3, 4, 5}},
        {12, {0x10, 20, 1, 2, 3, 4}}, // first frame of CAN FD
    };
    for (uint32_t i = 0; i < sizeof frames / sizeof frames[0]; i++) {
        TEST_ASSERT_EQUAL_INT(cam_isotp_nothing, give(frames[i].n, frames[i].data));
        TEST_ASSERT_FALSE(t.is_receiving || t.has_flow);
    }
    begin(15);
    expect_flow(0x30, 8);
    static const uint8_t foreign[] = {0x30, 0, 0};
    TEST_ASSERT_EQUAL_INT(cam_isotp_nothing, give(3, foreign));
    TEST_ASSERT_EQUAL_INT(cam_isotp_nothing, give_next(1, 6, 6)); // too short for its place
    TEST_ASSERT_EQUAL_INT(cam_isotp_nothing, give_next(1, 6, 7));
    TEST_ASSERT_EQUAL_INT(cam_isotp_message, give_next(2, 13, 2));
    expect_bytes(15);
}

/// A length of 32 bits counts in all of them; what is longer than the memory is refused, and not
/// received.
static void test_each_byte_of_a_length_counts(void)
{
    static const uint32_t lengths[] = {4097,    0x1200,    capacity,   capacity + 1,
                                       0x31000, 0x4001000, 0xF0001000, UINT32_MAX};
    for (uint32_t i = 0; i < sizeof lengths / sizeof lengths[0]; i++) {
        const bool is_too_long = lengths[i] > capacity;
        bytes[2] = 0;
        begin(lengths[i]);
        TEST_ASSERT_EQUAL_HEX32(lengths[i], t.length);
        TEST_ASSERT_EQUAL(is_too_long, t.is_too_long);
        expect_flow(is_too_long ? 0x32 : 0x30, is_too_long ? 0 : 8);
        TEST_ASSERT_EQUAL_INT(cam_isotp_nothing, give_next(1, 2, 7));
        TEST_ASSERT_EQUAL_UINT8(is_too_long ? 0 : pattern(2), bytes[2]);
    }
    send_whole(100);
}
