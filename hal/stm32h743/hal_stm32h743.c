// SPDX-License-Identifier: Apache-2.0
/// hal_stm32h743: the port for the NUCLEO-H743ZI2: start, halt, axes, lines, text.
#include "hal/hal.h"
#include "stm_port.h"
#include "stm_convert.h"
#include "stm_memory.h"

#if defined(BOARD_TRUST_N_KEYS) && BOARD_TRUST_N_KEYS > 0
#error "tables are no longer signed: remove BOARD_TRUST_* from board_config.h"
#endif

/// Results of hal_init() when the machine cannot be used.
enum { no_revision = -1, no_clock = -2, no_dac = -3, no_can = -4 };

static hal_start_t start;
static int32_t last_nm[hal_n_axes];

/// Devices of revisions Z and Y are limited to 400 MHz. RM0433 60.5, DBGMCU_IDC.
static bool is_fast_revision(void)
{
    const uint32_t revision = DBGMCU_IDC >> 16;
    return revision != 0x1001u && revision != 0x1003u;
}

/// Set up the serial line: 115 200 bit/s; 8 data bits, no parity and one stop bit are the values
/// after reset. Its kernel clock is that of APB1. RM0433 48.5.
static void init_text(void)
{
    RCC_APB1LENR |= RCC_APB1LENR_USART3;
    (void)RCC_APB1LENR;
    USART3_BRR = (stm_apb_hz + 115200 / 2) / 115200;
    USART3_CR1 = USART_CR1_FIFOEN | USART_CR1_RE | USART_CR1_TE | USART_CR1_UE;
}

/// Report why the port cannot be used; main() only gets the number.
static int refuse(int reason, const char *why)
{
    hal_text(why);
    return reason;
}

int hal_init(void)
{
    start = stm_keep_start();
    stm_ecc_init();
    stm_table_init();
    stm_params_init();
    if (!is_fast_revision()) {
        return no_revision;
    }
    const stm_clock_t clock = stm_clock_init();
    if (clock == stm_clock_fail) {
        return no_clock;
    }
    stm_faults |= clock == stm_clock_hsi ? stm_fault_clock : 0u;
    stm_timers_init(); // before the pins, so that /LDAC is high from the start
    stm_steps_init();  // and the steps low
    stm_pins_init();
    init_text();
    stm_tick_init();
    if (!stm_dac_init()) {
        return refuse(no_dac, "port: SPI3 does not work");
    }
    return stm_can_init() ? 0 : refuse(no_can, "port: FDCAN1 does not work");
}

/// Report the option bytes that protect firmware and supply (UPDATE.md). Missing protection refuses
/// nothing, because a machine being set up is unprotected; the line shows it at every start.
static void report_protection(void)
{
    char line[] = "port: read-out protection level 0, write protection of the firmware 0, "
                  "brown-out level 0 (UPDATE.md)";
    enum { at_level = 32, at_answer = 68, at_brown_out = 87 };
    const uint32_t optsr = FLASH_OPTSR_CUR;
    const uint32_t rdp = FLASH_OPTSR_RDP(optsr);
    line[at_brown_out] = (char)('0' + FLASH_OPTSR_BOR_LEV(optsr));
    line[at_level] = rdp == 0xAAu ? '0' : rdp == 0xCCu ? '2' : '1';
    if ((FLASH_WPSN_CUR1 & 3u) == 0u) { // both sectors with code
        line[at_answer] = '1';
    }
    hal_text(line);
}

void hal_tick_start(void)
{
    report_protection();
    if (stm_table_is_lost()) {
        hal_text(
            "port: an older firmware kept the table where code is now: download or flash it again");
    }
    stm_timers_start_tick();
    stm_watch_start();
}

/// Write a line of text for each new fault of the port.
static void report_new_faults(void)
{
    static const char *const texts[] = {
        "port: no HSE clock, runs from the HSI; drives reported as not ready",
        "port: a tick overran; drives reported as not ready",
        "port: set-points came too late for the outputs' step; drives reported as not ready",
        "port: a transfer to the DAC did not end; drives reported as not ready",
        "port: spindle edges without a time: wire A to PA0, B to PA3; drives reported as not ready",
    };
    static uint32_t reported;
    const uint32_t new_faults = stm_faults & ~reported;
    for (uint32_t i = 0; i < sizeof texts / sizeof texts[0]; i++) {
        if ((new_faults & 1u << i) != 0u) {
            hal_text(texts[i]);
        }
    }
    reported |= new_faults;
}

/// Feed the watchdog only if there was a tick since the last call, so that it supervises both the
/// tick and the main loop.
void hal_idle(void)
{
    static uint32_t last_count;
    report_new_faults();
    stm_ecc_poll();
    const uint32_t count = stm_tick_count();
    if (count != last_count) {
        stm_watch_feed();
    }
    last_count = count;
    stm_selftest_poll();
    __asm volatile("wfi");
}

void hal_halt(const char *why)
{
    __asm volatile("cpsid i" ::: "memory");
    stm_outputs_safe();
    stm_keep_text(why);
    SCB_AIRCR = SCB_AIRCR_SYSRESETREQ;
    stm_barrier();
    for (;;) {
    }
}

hal_start_t hal_start(void)
{
    return start;
}

/// Sending a character takes 87 us. It is dropped if there is no room within a millisecond.
static void put_char(char c)
{
    const uint32_t begin = TIM5->CNT;
    while ((USART3_ISR & USART_ISR_TXFNF) == 0u) {
        if (TIM5->CNT - begin > stm_timer_hz / 1000) {
            return;
        }
    }
    USART3_TDR = (uint8_t)c;
}

void hal_text(const char *line)
{
    for (uint32_t i = 0; i < 120u && line[i] != '\0'; i++) {
        put_char(line[i]);
    }
    put_char('\r');
    put_char('\n');
}

int32_t hal_axis_read_nm_isr(hal_axis_t axis)
{
    if (axis == hal_axis_u && BOARD_HAS_U_SCALE != 0) {
        return stm_counts_nm(stm_timers_u_counts_isr(), BOARD_NM_Q16(BOARD_U_COUNT_PM));
    }
    if (axis == hal_axis_z && BOARD_HAS_Z_SCALE != 0) {
        return stm_counts_nm(stm_timers_z_counts_isr(), BOARD_NM_Q16(BOARD_Z_COUNT_PM));
    }
    if (axis == hal_axis_u && BOARD_U_STEP_PM != 0) {
        return stm_counts_nm(stm_steps_sent_isr(stm_step_u), BOARD_NM_Q16(BOARD_U_STEP_PM));
    }
    if (axis == hal_axis_x && BOARD_X_STEP_PM != 0) {
        return stm_counts_nm(stm_steps_sent_isr(stm_step_x), BOARD_NM_Q16(BOARD_X_STEP_PM));
    }
    if (axis == hal_axis_z && BOARD_Z_STEP_PM != 0) {
        return stm_counts_nm(stm_steps_sent_isr(stm_step_z), BOARD_NM_Q16(BOARD_Z_STEP_PM));
    }
    return last_nm[axis];
}

/// Steps limit the resolution and speed of an axis; without steps, its channel of the DAC does.
static hal_axis_scale_t scale_of(int32_t full_nm, int32_t step_pm, uint32_t measured_pm)
{
    hal_axis_scale_t scale = {.command_pm = BOARD_CODE_PM(full_nm), .measured_pm = measured_pm};
    if (step_pm != 0) {
        scale.command_pm = (uint32_t)step_pm;
        scale.most_um_per_s = stm_steps_um_per_s(step_pm);
    }
    return scale;
}

_Static_assert(BOARD_U_FORCE_MN == 0 || (BOARD_U_FORCE_MN > 1024 && BOARD_U_FORCE_MN <= 33000000),
               "BOARD_U_FORCE_MN: give 1025 to 33000000, or 0");
_Static_assert(BOARD_U_FORCE_MN == 0 || (BOARD_HAS_U_SCALE != 0 && BOARD_U_STEP_PM == 0),
               "BOARD_U_FORCE_MN needs BOARD_HAS_U_SCALE 1 and BOARD_U_STEP_PM 0");

hal_force_t hal_force(void)
{
    return (hal_force_t){.quantum_un = BOARD_CODE_PM(BOARD_U_FORCE_MN),
                         .latency_ns = BOARD_FORCE_NS};
}

hal_operator_t hal_operator(void)
{
    return (hal_operator_t){
        .has_acknowledge = BOARD_HAS_ACKNOWLEDGE != 0,
        .is_acknowledge_waived = BOARD_ACKNOWLEDGE_IS_WAIVED != 0,
        .has_key = BOARD_HAS_KEY != 0,
    };
}

hal_axis_scale_t hal_axis_scale(hal_axis_t axis)
{
    switch (axis) {
    case hal_axis_u:
        return scale_of(BOARD_U_FORCE_MN != 0 ? 0 : BOARD_U_FULL_NM, BOARD_U_STEP_PM,
                        BOARD_HAS_U_SCALE != 0 ? BOARD_U_COUNT_PM : 0);
    case hal_axis_x:
        return scale_of(BOARD_X_FULL_NM, BOARD_X_STEP_PM, 0);
    default:
        return scale_of(BOARD_Z_FULL_NM, BOARD_Z_STEP_PM,
                        BOARD_HAS_Z_SCALE != 0 ? BOARD_Z_COUNT_PM : 0);
    }
}

bool hal_measures_u(void)
{
    return BOARD_HAS_U_SCALE != 0;
}

hal_memory_t hal_scope_memory(void)
{
    const uint32_t n_doubles = (uint32_t)(stm_scope_end - stm_scope_start);
    return (hal_memory_t){.words = (int32_t *)stm_scope_start, .n_words = 2u * n_doubles};
}

/// Limit switches of a U that takes forces; normally closed, as the home switches.
static uint32_t limits(uint32_t pins)
{
    return BOARD_U_FORCE_MN == 0 ? 0u
                                 : (~pins >> stm_pin_limit_u_low & 1u) * hal_in_limit_u_low |
                                       (~pins >> stm_pin_limit_u_high & 1u) * hal_in_limit_u_high;
}

/// Inputs of port D. Home switches are normally closed, so a broken wire reads as reached.
static uint32_t port_d(void)
{
    enum { shift = 1, indices = 7u << stm_pin_index_u };
    const uint32_t wired = (uint32_t)BOARD_HOME_SWITCHES << stm_pin_home_u;
    const uint32_t pins = GPIOD->IDR;
    uint32_t people = BOARD_HAS_KEY != 0 ? (pins >> stm_pin_key & 1u) * hal_in_key : 0u;
    if (BOARD_HAS_ACKNOWLEDGE != 0) {
        people |= (pins >> stm_pin_acknowledge & 1u) * hal_in_acknowledge;
    }
    return ((~pins & wired) | (pins & (uint32_t)indices)) << shift | people | limits(pins);
}
_Static_assert(hal_in_home_u == 1u << (stm_pin_home_u + 1), "pins and bits differ by one shift");
_Static_assert(hal_in_index_u == 1u << (stm_pin_index_u + 1), "likewise");

uint32_t hal_inputs_read_isr(void)
{
    const uint32_t pins = GPIOE->IDR;
    uint32_t bits = (pins & 1u << stm_pin_estop) != 0u ? 0u : hal_in_estop;
    if ((pins & 1u << stm_pin_ready) != 0u && stm_faults == 0u) {
        bits |= hal_in_drive_ready;
    }
    return bits | port_d();
}

void hal_axis_write_isr(hal_axis_t axis, const hal_setpoint_t *setpoint)
{
    static const int32_t codes_q32[hal_n_axes] = {
        [hal_axis_u] = BOARD_CODES_Q32(BOARD_U_FULL_NM),
        [hal_axis_x] = BOARD_CODES_Q32(BOARD_X_FULL_NM),
        [hal_axis_z] = BOARD_CODES_Q32(BOARD_Z_FULL_NM),
    };
    if (axis == hal_axis_u && BOARD_U_FORCE_MN != 0) {
        return; // its channel outputs the force
    }
    last_nm[axis] = setpoint->pos_nm;
    stm_dac_set_isr(axis, stm_code16(setpoint->pos_nm, codes_q32[axis]));
    if (axis == hal_axis_u) {
        stm_dac_set_internal_isr(stm_code12(setpoint->pos_nm, codes_q32[axis]));
        stm_steps_set_isr(stm_step_u,
                          stm_steps(setpoint->pos_nm, BOARD_STEPS_Q32(BOARD_U_STEP_PM)));
    } else if (axis == hal_axis_x) {
        stm_steps_set_isr(stm_step_x,
                          stm_steps(setpoint->pos_nm, BOARD_STEPS_Q32(BOARD_X_STEP_PM)));
    } else {
        stm_steps_set_isr(stm_step_z,
                          stm_steps(setpoint->pos_nm, BOARD_STEPS_Q32(BOARD_Z_STEP_PM)));
    }
}

void hal_force_write_isr(int32_t force_q6)
{
    if (BOARD_U_FORCE_MN != 0) {
        stm_dac_send_u_isr(stm_code16(force_q6, BOARD_CODES_Q32(BOARD_U_FORCE_Q6)));
    }
}

void hal_spindle_write_isr(int32_t speed_mrpm)
{
    stm_dac_set_isr(stm_dac_spindle,
                    stm_code16(speed_mrpm, BOARD_CODES_Q32(BOARD_SPINDLE_FULL_MRPM)));
}

void hal_outputs_write_isr(uint32_t bits)
{
    GPIOE->BSRR = STM_BSRR(stm_pin_enable, (bits & hal_out_enable) != 0u) |
                  STM_BSRR(stm_pin_fault, (bits & hal_out_fault) != 0u) |
                  STM_BSRR(stm_pin_in_cut, (bits & hal_out_in_cut) != 0u);
    stm_steps_enable_isr((bits & hal_out_enable) != 0u);
}
