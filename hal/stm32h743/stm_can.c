// SPDX-License-Identifier: Apache-2.0
#include "stm_port.h"
#include "hal/hal.h"
#include <string.h> // memcmp

/// Layout of the message RAM in words. An element has two words of header and 64 bytes of data.
enum {
    element_words = 18,
    n_received = 32,
    n_to_send = 16,
    receive_at = 0,
    send_at = receive_at + n_received * element_words,
    used_words = send_at + n_to_send * element_words,
};
_Static_assert(used_words <= 2560, "the message RAM has 10 KiB");

/// Fields in the header of an element: RM0433 chapter 56, Rx and Tx buffer elements.
enum { at_id = 18, at_length = 16, with_rate = 1 << 20, is_fd = 1 << 21 };

/// [bytes] of each length code.
static const uint8_t length[16] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64};

/// Time segments of a bit in periods of 80 MHz. The registers take each of them less one.
enum {
    nominal_before = 127, // 1 + 127 + 32 = 160: 500 kbit/s
    nominal_after = 32,
    data_before = 29, // 1 + 29 + 10 = 40: 2 Mbit/s
    data_after = 10,
};

/// Enter or leave the initialisation state. Even on a busy bus this takes at most a frame: 0.5 ms.
static bool set_init(uint32_t wanted)
{
    FDCAN1_CCCR = wanted;
    for (uint32_t i = 0; i < 100000u; i++) {
        if ((FDCAN1_CCCR & FDCAN_CCCR_INIT) == wanted) {
            return true;
        }
    }
    return false;
}

/// Set the bit times of the arbitration and of the data of FD frames.
static void set_timing(void)
{
    FDCAN1_NBTP = (nominal_after - 1u) << 25 | (nominal_before - 1u) << 8 | (nominal_after - 1u);
    FDCAN1_DBTP =
        FDCAN_DBTP_TDC | (data_before - 1u) << 8 | (data_after - 1u) << 4 | (data_after - 1u);
    FDCAN1_TDCR = (data_before + 1u) << 8; // secondary sample point as deep in the bit as the first
}

/// Clear the message RAM, because after power-on its words are random and invalid for the error
/// correction, and divide it into the two queues.
static void set_memory(void)
{
    for (uint32_t i = 0; i < used_words; i++) {
        FDCAN_RAM[i] = 0;
    }
    FDCAN1_SIDFC = 0; // no filters: frames that match none are accepted
    FDCAN1_XIDFC = 0;
    FDCAN1_GFC = FDCAN_GFC_ANFS_FIFO0 | FDCAN_GFC_ANFE_REJECT | FDCAN_GFC_RRFE | FDCAN_GFC_RRFS;
    FDCAN1_RXF0C = FDCAN_RXF0C_F0S(n_received) | receive_at * 4u;
    FDCAN1_RXESC = FDCAN_RXESC_F0DS_64;
    FDCAN1_TXBC = FDCAN_TXBC_TFQS(n_to_send) | send_at * 4u;
    FDCAN1_TXESC = FDCAN_TXESC_TBDS_64;
}

/// Bypass the clock calibration unit, which would derive time quanta from bus messages, without
/// division; this needs INIT and CCE. RM0433 56.4.8 (CCU), FDCAN_CCU_CCFG.
/// @param modes  bits of CCCR; TEST and MON: internal loop-back
static bool join(uint32_t modes)
{
    RCC_APB1HENR |= RCC_APB1HENR_FDCAN;
    (void)RCC_APB1HENR;
    if (!set_init(FDCAN_CCCR_INIT)) {
        return false;
    }
    FDCAN1_CCCR = FDCAN_CCCR_INIT | FDCAN_CCCR_CCE;
    FDCAN1_CCCR = FDCAN_CCCR_INIT | FDCAN_CCCR_CCE | FDCAN_CCCR_FDOE | FDCAN_CCCR_BRSE | modes;
    if (modes != 0u) {
        FDCAN1_TEST = FDCAN_TEST_LBCK;
    }
    FDCAN_CCU_CCFG = FDCAN_CCU_CCFG_BCC;
    set_timing();
    set_memory();
    FDCAN1_CCCR = FDCAN_CCCR_FDOE | FDCAN_CCCR_BRSE | modes;
    return true;
}

bool stm_can_init(void)
{
    return join(0);
}

/// In bus-off the peripheral has set INIT. Clearing it starts the return to the bus, which takes
/// 128 idle sequences.
static bool is_off_bus(void)
{
    const bool is_off = (FDCAN1_PSR & FDCAN_PSR_BO) != 0u;
    if (is_off && (FDCAN1_CCCR & FDCAN_CCCR_INIT) != 0u) {
        FDCAN1_CCCR &= ~FDCAN_CCCR_INIT;
    }
    return is_off;
}

bool hal_can_read(hal_can_frame_t *frame)
{
    (void)is_off_bus(); // returns to the bus even if the firmware only waits for a frame
    const uint32_t state = FDCAN1_RXF0S;
    if ((state & FDCAN_RXF0S_F0FL) == 0u) {
        return false;
    }
    const uint32_t place = state >> 8 & 0x3Fu;
    const volatile uint32_t *element = FDCAN_RAM + receive_at + place * element_words;
    const bool is_fd_frame = (element[1] & is_fd) != 0u;
    const uint32_t n = length[element[1] >> at_length & 0xFu];
    frame->id = element[0] >> at_id & 0x7FFu;
    frame->n = is_fd_frame || n <= 8u ? n : 8u; // a classic frame may carry codes 9 .. 15
    for (uint32_t i = 0; i < frame->n; i++) {
        frame->data[i] = (uint8_t)(element[2u + i / 4u] >> 8u * (i % 4u));
    }
    FDCAN1_RXF0A = place;
    return true;
}

/// @return the code of a length in bytes, 16 when there is none
static uint32_t length_code(uint32_t n)
{
    uint32_t code = 0;
    while (code < 16u && length[code] != n) {
        code++;
    }
    return code;
}

/// Write the data of a frame to the message RAM, which takes whole words only.
static void copy_out(volatile uint32_t *data, const hal_can_frame_t *frame)
{
    for (uint32_t i = 0; i < frame->n; i += 4u) {
        uint32_t word = 0;
        for (uint32_t j = 0; j < 4u && i + j < frame->n; j++) {
            word |= (uint32_t)frame->data[i + j] << 8u * j;
        }
        data[i / 4u] = word;
    }
}

bool hal_can_write(const hal_can_frame_t *frame)
{
    if (is_off_bus()) {
        return false;
    }
    const uint32_t state = FDCAN1_TXFQS;
    const uint32_t code = length_code(frame->n);
    if ((state & FDCAN_TXFQS_TFQF) != 0u || code > 15u) {
        return false;
    }
    const uint32_t place = state >> 16 & 0x1Fu;
    volatile uint32_t *element = FDCAN_RAM + send_at + place * element_words;
    element[0] = (frame->id & 0x7FFu) << at_id;
    element[1] = code << at_length | (frame->n > 8u ? is_fd | with_rate : 0u);
    copy_out(element + 2, frame);
    FDCAN1_TXBAR = 1u << place;
    return true;
}

/// Wait up to 2 ms for a frame.
static bool wait_for_frame(hal_can_frame_t *frame)
{
    const uint32_t begin = TIM5->CNT;
    while (TIM5->CNT - begin < stm_timer_hz / 1000 * 2) {
        if (hal_can_read(frame)) {
            return true;
        }
    }
    return false;
}

bool stm_can_loop_back(void)
{
    hal_can_frame_t sent = {.id = 0x555, .n = hal_can_max_bytes};
    hal_can_frame_t back = {.n = 0};
    for (uint32_t i = 0; i < sent.n; i++) {
        sent.data[i] = (uint8_t)(i * 37u);
    }
    const bool is_back = join(FDCAN_CCCR_TEST | FDCAN_CCCR_MON) && hal_can_write(&sent) &&
                         wait_for_frame(&back) && back.id == sent.id && back.n == sent.n &&
                         memcmp(back.data, sent.data, sent.n) == 0;
    return join(0) && is_back;
}
