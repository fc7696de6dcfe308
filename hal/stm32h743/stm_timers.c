// SPDX-License-Identifier: Apache-2.0
#include "stm_port.h"
#include "hal/hal.h"
#include "stm_convert.h" // stm_extend

volatile uint32_t stm_faults;

/// Times in counts of the timers.
enum {
    tick_counts = stm_timer_hz / BOARD_TICK_HZ,
    update_counts = stm_timer_hz / 1000000 * BOARD_UPDATE_NS / 1000,
    send_counts = stm_timer_hz / 1000000 * BOARD_SEND_NS / 1000,
};
_Static_assert(stm_timer_hz % BOARD_TICK_HZ == 0, "the tick rate is exact");
_Static_assert(tick_counts <= 65536, "TIM4 has 16 bits");
_Static_assert(send_counts < update_counts && update_counts < tick_counts,
               "sending ends before the step, and that before the tick");

/// Counters extended to 32 bits, and the last index edge.
static struct {
    int32_t u_counts, z_counts;
    uint32_t index_counts, n_index;
} position;

/// The spindle's counter, and the times of the last edges of A and B.
typedef struct {
    uint32_t counts;
    uint32_t a_clock, b_clock; ///< [1 / stm_timer_hz]
} edges_t;

/// As read by the last tick.
static edges_t last;

/// Set a timer up as an encoder interface: both edges of both tracks count. All inputs
/// have the same filter and so the same delay.
static void init_encoder(stm_tim_t *tim, uint32_t top)
{
    tim->ARR = top;
    tim->CCMR1 = TIM_CCMR1_IC1_TI1 | TIM_CCMR1_IC1F_8 | TIM_CCMR1_IC2_TI2 | TIM_CCMR1_IC2F_8;
    tim->SMCR = TIM_SMCR_SMS_ENCODER3;
}

/// Set the tick's timer up. Channel 3 is active from update_counts to the end of the period: /LDAC
/// is low and OC3REF high.
static void init_tick(void)
{
    TIM4->CR1 = TIM_CR1_URS; // no update flag from UG
    TIM4->CR2 = TIM_CR2_MMS_OC3REF;
    TIM4->ARR = tick_counts - 1;
    TIM4->CCR3 = update_counts;
    TIM4->CCMR2 = TIM_CCMR2_OC3M_PWM2;
    TIM4->CCER = TIM_CCER_CC3E | TIM_CCER_CC3P;
    TIM4->EGR = TIM_EGR_UG;
    TIM4->SR = 0;
    TIM4->DIER = TIM_DIER_UIE;
}

void stm_timers_init(void)
{
    RCC_APB2ENR |= RCC_APB2ENR_TIM1;
    RCC_APB1LENR |= RCC_APB1LENR_TIM2 | RCC_APB1LENR_TIM3 | RCC_APB1LENR_TIM4 | RCC_APB1LENR_TIM5;
    (void)RCC_APB1LENR;
    init_encoder(TIM1, UINT16_MAX);
    init_encoder(TIM2, UINT32_MAX);
    init_encoder(TIM3, UINT16_MAX);
    // Two captures of the index input: channel 3 at its rising edge, channel 4 at its falling one.
    TIM2->CCMR2 = TIM_CCMR2_IC3_TI3 | TIM_CCMR2_IC3F_8 | TIM_CCMR2_IC4_TI3;
    TIM2->CCER = TIM_CCER_CC3E | TIM_CCER_CC4E | TIM_CCER_CC4P;
    init_tick();
    TIM5->ARR = UINT32_MAX;
    // Every edge of A and B, with the counter's filter, so both delay an edge equally.
    TIM5->CCMR1 = TIM_CCMR1_IC1_TI1 | TIM_CCMR1_IC1F_8;
    TIM5->CCMR2 = TIM_CCMR2_IC4_TI4 | TIM_CCMR2_IC4F_8;
    TIM5->CCER = TIM_CCER_IC1_BOTH | TIM_CCER_IC4_BOTH;
    TIM1->CR1 = TIM_CR1_CEN;
    TIM2->CR1 = TIM_CR1_CEN;
    TIM3->CR1 = TIM_CR1_CEN;
    TIM5->CR1 = TIM_CR1_CEN;
}

void stm_timers_start_tick(void)
{
    NVIC_ISER(stm_irq_tim4) = 1u << stm_irq_tim4 % 32u;
    TIM4->CR1 |= TIM_CR1_CEN;
}

void stm_timers_tick_begin_isr(void)
{
    TIM4->SR = ~TIM_SR_UIF;
}

bool stm_timers_is_overrun_isr(void)
{
    return (TIM4->SR & TIM_SR_UIF) != 0u;
}

bool stm_timers_is_late_isr(void)
{
    return TIM4->CNT > update_counts - send_counts;
}

/// Channel 3 is active from the count in CCR3 on; without preload a change acts at once.
void stm_timers_ldac_isr(bool is_low)
{
    TIM4->CCR3 = is_low ? 0u : update_counts;
}

int32_t stm_timers_u_counts_isr(void)
{
    position.u_counts = stm_extend(position.u_counts, TIM1->CNT);
    return position.u_counts;
}

int32_t stm_timers_z_counts_isr(void)
{
    position.z_counts = stm_extend(position.z_counts, TIM3->CNT);
    return position.z_counts;
}

uint32_t hal_tick_hz(void)
{
    return BOARD_TICK_HZ;
}

uint32_t hal_clock_hz(void)
{
    return stm_timer_hz;
}

uint32_t hal_clock_isr(void)
{
    return TIM5->CNT;
}

bool hal_has_edge_time(void)
{
    return BOARD_HAS_EDGE_TIME != 0;
}

/// Read a consistent set of counter and captures. Edges are 2 us apart at 10 000 counts and 3000
/// r/min, and three reads take a tenth of that: the second try succeeds, the third allows for
/// noise.
static edges_t read_edges(void)
{
    enum { most_tries = 3 };
    edges_t e = {.counts = TIM2->CNT};
    for (int i = 0; BOARD_HAS_EDGE_TIME != 0 && i < most_tries; i++) {
        e.a_clock = TIM5->CCR1;
        e.b_clock = TIM5->CCR4;
        const uint32_t counts = TIM2->CNT;
        if (counts == e.counts) {
            break;
        }
        e.counts = counts;
    }
    return e;
}

/// Four counts contain edges of both tracks; a track without a capture is not wired.
static void judge_edges(const edges_t *now)
{
    const uint32_t moved = now->counts - last.counts + 3u;
    const bool is_both = moved > 6u;
    if (is_both && (now->a_clock == last.a_clock || now->b_clock == last.b_clock)) {
        stm_faults |= stm_fault_edges;
    }
    last = *now;
}

/// @return [1 / stm_timer_hz] the later of the two edges
static uint32_t last_edge(const edges_t *e)
{
    const uint32_t now = TIM5->CNT;
    return now - e->a_clock < now - e->b_clock ? e->a_clock : e->b_clock;
}

void hal_encoder_read_isr(hal_encoder_t *reading)
{
    // The flags are read before the counter: an index edge in between is reported by the next tick.
    const uint32_t flags = TIM2->SR;
    const bool is_falling = (TIM2->CR1 & TIM_CR1_DIR) != 0u;
    const uint32_t wanted = is_falling ? TIM_SR_CC4IF : TIM_SR_CC3IF;
    if ((flags & wanted) != 0u) {
        position.index_counts =
            is_falling ? TIM2->CCR4 + (uint32_t)BOARD_INDEX_FALLING_COUNTS : TIM2->CCR3;
        position.n_index++;
    }
    TIM2->SR = ~(flags & (TIM_SR_CC3IF | TIM_SR_CC4IF | TIM_SR_CC3OF | TIM_SR_CC4OF));
    const edges_t edges = read_edges();
    *reading = (hal_encoder_t){
        .counts = edges.counts, .index_counts = position.index_counts, .n_index = position.n_index};
    if (BOARD_HAS_EDGE_TIME != 0) {
        reading->edge_clock = last_edge(&edges);
        judge_edges(&edges);
    }
}
