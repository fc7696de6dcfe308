// SPDX-License-Identifier: Apache-2.0
#include "stm_port.h"

/// Words for the AD5754R: the register in bits 19 and up, the channel in bits 16 .. 18.
enum {
    frame_read = 1 << 23,
    frame_range_all = 1 << 19 | 4 << 16,
    frame_power = 2 << 19,
    frame_control = 3 << 19 | 1 << 16,
    frame_nothing = 3 << 19,
    frame_load_all = 3 << 19 | 5 << 16,
    range_10v = 4,
    power_all = 0x1F,                  ///< channels A to D and the reference
    control_protect = 1 << 3 | 1 << 2, ///< thermal shutdown, current clamp
};

/// The four frames that the next transfer sends, one for each output.
static uint32_t frame[stm_n_dacs];

/// What came back when the power register was read.
static uint32_t answer;

/// [1 / stm_timer_hz] a period of SCK: of set-points, and of the answer that is read at the start.
enum { sck_counts = stm_timer_hz / 20000000, slow_sck_counts = 4 * sck_counts };

static void wait_counts(uint32_t counts)
{
    const uint32_t begin = TIM5->CNT;
    while (TIM5->CNT - begin <= counts) {
    }
}

/// Switch SPI3 off. Just after EOT the last clock pulse may still be on the line, and clearing SPE
/// would cut it off: wait for a period of SCK. ES0392, SPI, "Truncation of SPI output signals after
/// EOT event".
static void switch_off(uint32_t counts)
{
    wait_counts(counts);
    SPI3_CR1 = 0;
}

/// Start a transfer while SPI3 is off. A transfer is configured while SPE is low; the FIFO then
/// takes the frames, and CSTART starts it. SPE goes low and high again before each transfer, as the
/// manual advises. RM0433 50.4.
static void start_isr(const uint32_t *words, uint32_t n)
{
    SPI3_IFCR = SPI_IFCR_EOTC | SPI_IFCR_TXTFC;
    SPI3_CR2 = n;
    SPI3_CR1 = SPI_CR1_SPE;
    for (uint32_t i = 0; i < n; i++) {
        SPI3_TXDR = words[i];
    }
    SPI3_CR1 = SPI_CR1_SPE | SPI_CR1_CSTART;
}

/// Start a transfer of four frames, behind another one.
static void send_isr(const uint32_t words[stm_n_dacs])
{
    switch_off(sck_counts);
    start_isr(words, stm_n_dacs);
}

/// Wait for the end of a transfer, outside the tick.
/// @return false on timeout
static bool wait_for_end(void)
{
    for (uint32_t i = 0; i < 100000u; i++) { // some hundred times the duration of a transfer
        if ((SPI3_SR & SPI_SR_EOT) != 0u) {
            return true;
        }
    }
    return false;
}

/// Set rate and direction of SPI3, which must be off meanwhile.
static void configure(uint32_t rate, uint32_t direction)
{
    switch_off(slow_sck_counts);
    SPI3_CFG1 = SPI_CFG1_DSIZE_24 | rate;
    SPI3_CFG2 = SPI_CFG2_MSSI(1) | SPI_CFG2_MIDI(8) | direction | SPI_CFG2_MASTER | SPI_CFG2_CPHA |
                SPI_CFG2_SSOE | SPI_CFG2_SSOM | SPI_CFG2_AFCNTR;
}

/// Set SPI3 up for 20 MHz. Data change on the rising edge. Frames are eight clocks apart, and /SYNC
/// is high for seven of them: 350 ns; the converter requires 100 ns (RM0433 50.4.8, SSOM;
/// data sheet, timing characteristics). The four frames take 6.6 us.
static void init_spi(void)
{
    RCC_APB1LENR |= RCC_APB1LENR_SPI3;
    (void)RCC_APB1LENR;
    configure(SPI_CFG1_MBR_DIV4, SPI_CFG2_COMM_TX_ONLY);
}

/// Set the internal DAC up: it starts at mid-scale and later steps on the trigger of TIM4. Its
/// buffer is on, the reset value of DAC_MCR. Without the trigger a value reaches the output at
/// once; the manual does not say whether this holds while the channel is off, so the value is
/// stored both before and after EN1 is set. The trigger is selected first, since it must not change
/// while the channel is on. RM0433 chapter 26, DAC_CR, DAC_DOR1.
static void init_internal(void)
{
    enum { middle = 2048, most_polls = 1000 };
    RCC_APB1LENR |= RCC_APB1LENR_DAC12;
    (void)RCC_APB1LENR;
    DAC_CR = DAC_CR_TSEL1_TIM4;
    stm_dac_set_internal_isr(middle);
    DAC_CR = DAC_CR_TSEL1_TIM4 | DAC_CR_EN1;
    stm_dac_set_internal_isr(middle);
    for (uint32_t i = 0; i < most_polls && DAC_DOR1 != middle; i++) {
    }
    DAC_CR = DAC_CR_TSEL1_TIM4 | DAC_CR_EN1 | DAC_CR_TEN1;
}

/// Read the power register; the answer comes with the second frame. SDO follows SCLK late, so at a
/// quarter of the rate.
static bool read_back(void)
{
    static const uint32_t ask[stm_n_dacs] = {frame_read | frame_power, frame_nothing, frame_nothing,
                                             frame_nothing};
    configure(SPI_CFG1_MBR_DIV16, SPI_CFG2_COMM_BOTH);
    send_isr(ask);
    const bool is_good = wait_for_end();
    (void)SPI3_RXDR;
    answer = is_good ? SPI3_RXDR : 0u;
    configure(SPI_CFG1_MBR_DIV4, SPI_CFG2_COMM_TX_ONLY);
    return is_good;
}

bool stm_dac_init(void)
{
    static const uint32_t setup[stm_n_dacs] = {frame_range_all | range_10v, frame_power | power_all,
                                               frame_control | control_protect, frame_nothing};
    static const uint32_t load[stm_n_dacs] = {frame_load_all, frame_nothing, frame_nothing,
                                              frame_nothing};
    // First ranges, power and protection, then 0 V for all outputs, finally the load command.
    for (uint32_t i = 0; i < stm_n_dacs; i++) {
        stm_dac_set_isr(i, 0);
    }
    init_internal();
    init_spi();
    send_isr(setup);
    bool is_good = wait_for_end();
    // The reference needs 10 us to power up (data sheet, "Power control register"): wait 100 us.
    wait_counts(stm_timer_hz / 1000000 * 100);
    is_good = read_back() && is_good;
    send_isr(frame);
    is_good = wait_for_end() && is_good;
    send_isr(load);
    return wait_for_end() && is_good; // EOT stays for the first tick
}

uint32_t stm_dac_answer(void)
{
    return answer;
}

void stm_dac_set_isr(uint32_t dac, int32_t code)
{
    frame[dac] = dac << 16 | ((uint32_t)code & 0xFFFFu);
}

void stm_dac_set_internal_isr(uint32_t code)
{
    DAC_DHR12R1 = code;
}

/// The last transfer ended most of a tick ago, so SPI3 can be switched off without waiting.
void stm_dac_send_u_isr(int32_t code)
{
    stm_dac_set_isr(stm_dac_u, code);
    stm_timers_ldac_isr(true);
    SPI3_CR1 = 0;
    start_isr(frame, 1);
}

/// Wait for the end of U's transfer, which began early in this tick and takes 1.3 us.
/// @return false on timeout
static bool wait_for_u_isr(void)
{
    const uint32_t begin = TIM5->CNT;
    while ((SPI3_SR & SPI_SR_EOT) == 0u) {
        if (TIM5->CNT - begin > stm_timer_hz / 1000000 * 2) {
            return false;
        }
    }
    return true;
}

/// @return whether the frame of U has been sent, with /LDAC high again and the others on their way
static bool send_behind_u_isr(void)
{
    const bool is_sent = wait_for_u_isr();
    switch_off(sck_counts);
    stm_timers_ldac_isr(false);
    start_isr(frame + 1, stm_n_dacs - 1);
    return is_sent;
}

bool stm_dac_send_isr(void)
{
    if (BOARD_U_FORCE_MN != 0) {
        return send_behind_u_isr();
    }
    const bool is_sent = (SPI3_SR & SPI_SR_EOT) != 0u;
    send_isr(frame);
    return is_sent;
}
