// SPDX-License-Identifier: Apache-2.0
#include "stm_steps.h"
#include "stm_pins.h" // GPIOB, STM_BSRR
#include "stm_reg.h"

_Static_assert(stm_steps_train <= UINT16_MAX, "TIM16 and TIM17 have 16 bits");
_Static_assert(stm_steps_most >= 2 && stm_steps_most <= 256, "the repetition counter has 8 bits");
_Static_assert(stm_steps_high > 0 && stm_steps_high < stm_steps_period, "a step has both levels");

typedef struct {
    stm_tim_t *tim;
    uint32_t direction_pin;
} output_t;

static const output_t outputs[stm_n_steppers] = {
    [stm_step_x] = {TIM16, stm_pin_x_direction},
    [stm_step_z] = {TIM17, stm_pin_z_direction},
};

/// Each axis in steps; the pins are low after init_output(), which means falling.
static struct {
    int32_t wanted, sent;
    bool is_rising;
} axis[stm_n_steppers];

static bool is_enabled;

/// [1 / stm_timer_hz] period of a train by its number of steps; avoids a division in the interrupt.
static uint16_t period[stm_steps_most + 1];

/// Prepare trains. In PWM mode 2 the output is high from CCR1 to the end of a period. The counter
/// rests at 0, so the output rests low if CCR1 is above 0, which must hold before it is enabled.
static void init_output(stm_tim_t *tim)
{
    tim->CR1 = TIM_CR1_URS | TIM_CR1_OPM;
    tim->CCR1 = UINT16_MAX;
    tim->CCMR1 = TIM_CCMR1_OC1M_PWM2;
    tim->CCER = TIM_CCER_CC1E;
    tim->BDTR = TIM_BDTR_MOE;
}

void stm_steps_init(void)
{
    RCC_APB2ENR |= RCC_APB2ENR_TIM16 | RCC_APB2ENR_TIM17;
    (void)RCC_APB2ENR;
    for (uint32_t i = 1; i <= stm_steps_most; i++) {
        period[i] = (uint16_t)(stm_steps_train / i);
    }
    for (uint32_t i = 0; i < stm_n_steppers; i++) {
        init_output(outputs[i].tim);
    }
}

void stm_steps_set_isr(uint32_t stepper, int32_t steps)
{
    axis[stepper].wanted = steps;
}

int32_t stm_steps_sent_isr(uint32_t stepper)
{
    return axis[stepper].sent;
}

void stm_steps_enable_isr(bool is_on)
{
    is_enabled = is_on;
}

/// Start a train. The forced update event loads the repetition counter; it does not end a train,
/// because the counter is stopped.
static void start_train(stm_tim_t *tim, uint32_t n)
{
    tim->RCR = n - 1u;
    tim->ARR = period[n] - 1u;
    tim->CCR1 = period[n] - (uint32_t)stm_steps_high;
    tim->EGR = TIM_EGR_UG;
    tim->CR1 = TIM_CR1_URS | TIM_CR1_OPM | TIM_CR1_CEN;
}

/// Send the missing steps of an axis, as many as fit in this tick.
static void send(uint32_t i)
{
    const uint32_t missing = (uint32_t)axis[i].wanted - (uint32_t)axis[i].sent;
    const bool is_rising = missing < 0x80000000u;
    const uint32_t n_missing = is_rising ? missing : 0u - missing;
    const uint32_t n = n_missing < stm_steps_most ? n_missing : (uint32_t)stm_steps_most;
    if (n == 0u || (outputs[i].tim->CR1 & TIM_CR1_CEN) != 0u) {
        return;
    }
    if (is_rising != axis[i].is_rising) {
        axis[i].is_rising = is_rising;
        GPIOB->BSRR = STM_BSRR(outputs[i].direction_pin, is_rising);
        return;
    }
    axis[i].sent = (int32_t)((uint32_t)axis[i].sent + (is_rising ? n : 0u - n));
    start_train(outputs[i].tim, n);
}

void stm_steps_send_isr(void)
{
    for (uint32_t i = 0; i < stm_n_steppers; i++) {
        if (is_enabled) {
            send(i);
        } else {
            axis[i].sent = axis[i].wanted;
        }
    }
}
