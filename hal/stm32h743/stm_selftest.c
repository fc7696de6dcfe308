// SPDX-License-Identifier: Apache-2.0
#include "stm_port.h"
#include "hal/hal.h"
#include "hal/version.h" // CAMTURN_VERSION
#include "stm_memory.h"

extern uint64_t stm_axi_start[], stm_itcm_top[], stm_dtcm_base[], stm_dtcm_top[];
extern uint32_t stm_itcm_start;
extern const uint8_t stm_other_start[], stm_table_start[];

enum { ms_counts = stm_timer_hz / 1000 };

static struct {
    char text[121];
    uint32_t n;
    uint32_t n_failed;
} report;

static void put(const char *text)
{
    for (; *text != '\0' && report.n < sizeof report.text - 1u; text++) {
        report.text[report.n++] = *text;
    }
}

/// @param base  10 or 16
static void put_number(uint32_t value, uint32_t base)
{
    char digits[11];
    uint32_t at = sizeof digits - 1u;
    digits[at] = '\0';
    do {
        digits[--at] = "0123456789ABCDEF"[value % base];
        value /= base;
    } while (value != 0u);
    put(base == 16u ? "0x" : "");
    put(&digits[at]);
}

/// Put a number and the text that follows it.
static void put_count(uint32_t value, const char *text)
{
    put_number(value, 10);
    put(text);
}

static void end_line(void)
{
    report.text[report.n] = '\0';
    report.n = 0;
    hal_text(report.text);
    stm_watch_feed();
}

/// Begin the line of a part.
static void judge(const char *part, bool is_good)
{
    put(part);
    put(is_good ? ": ok, " : ": FAILED, ");
    report.n_failed += is_good ? 0u : 1u;
}

/// @return the letter of a revision, by DBGMCU_IDC. RM0433 60.5.
static const char *revision_of(uint32_t idc)
{
    switch (idc >> 16) {
    case 0x1001u:
        return "Z";
    case 0x1003u:
        return "Y";
    case 0x2001u:
        return "X";
    case 0x2003u:
        return "V";
    default:
        return "unknown";
    }
}

static void report_device(void)
{
    put("self-test: camturn " CAMTURN_VERSION ", device ");
    put_number(DBGMCU_IDC, 16);
    put(", revision ");
    put(revision_of(DBGMCU_IDC));
    put(", option bytes ");
    put_number(FLASH_OPTSR_CUR, 16);
    end_line();
}

/// The core's cycles in a time of TIM5. An interrupt between two reads adds up to one percent.
static void test_clocks(void)
{
    const uint32_t begin = TIM5->CNT;
    const uint32_t first = DWT_CYCCNT;
    while (TIM5->CNT - begin < ms_counts) {
    }
    const uint32_t cycles = DWT_CYCCNT - first;
    const bool has_hse = (RCC_PLLCKSELR & 3u) == RCC_PLLCKSELR_HSE;
    const bool is_near = cycles - stm_cpu_hz / 100000 * 99 < stm_cpu_hz / 100000 * 3;
    judge("clocks", has_hse && is_near);
    put(has_hse ? "HSE, " : "HSI: OSC_IN has no 8 MHz, ");
    put_count(cycles, " core cycles in 1 ms of TIM5");
    end_line();
}

/// Invert each word of the recorder's memory and restore it.
/// @return number of words that did not hold a value
static uint32_t n_wrong_words(volatile int32_t *words, uint32_t n)
{
    uint32_t n_wrong = 0;
    for (uint32_t i = 0; i < n; i++) {
        const int32_t value = words[i];
        words[i] = ~value;
        n_wrong += words[i] != ~value ? 1u : 0u;
        words[i] = value;
        n_wrong += words[i] != value ? 1u : 0u;
    }
    return n_wrong;
}

/// Read every word, so that the error-correction code checks it; a double error halts.
/// @return [bytes] read
static uint32_t read_all(const volatile uint64_t *from, const volatile uint64_t *end)
{
    for (const volatile uint64_t *at = from; at < end; at++) {
        (void)*at;
    }
    return (uint32_t)(end - from) * sizeof *from;
}

static void test_ram(void)
{
    const hal_memory_t scope = hal_scope_memory();
    const uint32_t n_wrong = n_wrong_words(scope.words, scope.n_words);
    uint32_t n_bytes = read_all((const volatile uint64_t *)&stm_itcm_start, stm_itcm_top);
    n_bytes += read_all(stm_dtcm_base, stm_dtcm_top);
    n_bytes += read_all(stm_axi_start, (const volatile uint64_t *)scope.words);
    stm_ecc_poll();
    judge("RAM", n_wrong == 0u);
    put_count(n_bytes, " bytes read, ");
    put_count(4u * scope.n_words, " written, ");
    put_count(n_wrong, " wrong words, ");
    put_count(stm_ecc_corrected(), " corrected errors");
    end_line();
}

static void test_flash(void)
{
    enum { other_bytes = 6 * stm_flash_sector_bytes, bank_bytes = 8 * stm_flash_sector_bytes };
    const uint32_t n_bytes = stm_flash_readable((uint32_t)stm_other_start, other_bytes) +
                             stm_flash_readable((uint32_t)stm_table_start, bank_bytes);
    stm_ecc_poll();
    judge("flash", n_bytes == (uint32_t)(other_bytes + bank_bytes));
    put_count(n_bytes, " of ");
    put_count(other_bytes + bank_bytes, " bytes readable, ");
    put_count(stm_ecc_corrected(), " corrected errors");
    end_line();
}

static void test_timers(void)
{
    enum { n_ms = 20, due = BOARD_TICK_HZ * n_ms / 1000 };
    const uint32_t begin = TIM5->CNT;
    const uint32_t first = stm_tick_count();
    while (TIM5->CNT - begin < n_ms * ms_counts) {
        __asm volatile("wfi");
    }
    const uint32_t n_ticks = stm_tick_count() - first;
    judge("timers", n_ticks - (due - 1u) <= 2u);
    put_count(n_ticks, " ticks in 20 ms; counters: spindle ");
    put_count(TIM2->CNT, ", U ");
    put_count(TIM1->CNT, ", Z ");
    put_count(TIM3->CNT, "");
    end_line();
}

/// The cycle counter measures a tick; a fault of the port fails this line.
static void test_tick(void)
{
    const hal_load_t load = hal_load();
    judge("tick", stm_faults == 0u);
    put_count(load.last_cycles, " cycles, longest ");
    put_count(load.max_cycles, " of ");
    put_count(stm_cpu_hz / BOARD_TICK_HZ, ", faults of the port ");
    put_number(stm_faults, 16);
    end_line();
}

/// Channels A to D and the reference are on; other bits report overload (data sheet, "Power control
/// register"). Without a wire at SDO, or without the converter, the answer is 0.
static void test_dac(void)
{
    const uint32_t answer = stm_dac_answer();
    if (answer == 0u) {
        put("AD5754R: no answer by SDO: not wired to PC11, or no supply");
    } else {
        judge("AD5754R", (answer & 0xFFFFu) == 0x1Fu);
        put("answer by SDO ");
        put_number(answer, 16);
    }
    end_line();
}

static void test_can(void)
{
    judge("FDCAN1", stm_can_loop_back());
    put("a frame of 64 bytes by internal loop-back");
    end_line();
}

/// The window watchdog is fed by the tick meanwhile.
static void test_window(void)
{
    const uint32_t begin = TIM5->CNT;
    uint32_t low = UINT32_MAX;
    uint32_t high = 0;
    while (TIM5->CNT - begin < ms_counts) {
        const uint32_t count = WWDG_CR;
        low = count < low ? count : low;
        high = count > high ? count : high;
    }
    judge("window watchdog", (low & WWDG_CR_WDGA) != 0u && low < high);
    put("WWDG_CR between ");
    put_number(low, 16);
    put(" and ");
    put_number(high, 16);
    end_line();
}

/// Wait for the reset by the independent watchdog, which takes 0.9 to 1.2 s.
static _Noreturn void test_watchdog(void)
{
    put("self-test: ");
    put(report.n_failed == 0u ? "passed" : "FAILED");
    put("; now the watchdog resets: expect start: watchdog reset within 1.2 s");
    end_line();
    const uint32_t begin = TIM5->CNT;
    while (TIM5->CNT - begin < 2000u * ms_counts) {
        __asm volatile("wfi");
    }
    hal_halt("self-test: the independent watchdog did not reset within 2 s");
}

/// @return why there is no self-test now, NULL when there is one
static const char *obstacle(void)
{
    if ((GPIOE->ODR & 1u << stm_pin_enable) != 0u) {
        return "self-test: refused while the drives are enabled: disable them";
    }
    if (((FLASH_SR(0) | FLASH_SR(1)) & FLASH_SR_QW) != 0u) {
        return "self-test: refused while flash is written: ask again";
    }
    return NULL;
}

void stm_selftest_poll(void)
{
    if ((USART3_ISR & USART_ISR_RXFNE) == 0u || (USART3_RDR & 0xFFu) != 't') {
        return;
    }
    const char *const why_not = obstacle();
    if (why_not != NULL) {
        hal_text(why_not);
        return;
    }
    report_device();
    test_clocks();
    test_ram();
    test_flash();
    test_timers();
    test_dac();
    test_can();
    test_window();
    test_tick();
    test_watchdog();
}
