// SPDX-License-Identifier: Apache-2.0
#include "stm_port.h"

_Static_assert(stm_steps_train <= UINT16_MAX, "the timers have 16 bits");
_Static_assert(stm_steps_most >= 2 && stm_steps_most <= 256, "the repetition counter has 8 bits");
_Static_assert(stm_steps_high > 0 && stm_steps_high < stm_steps_period, "a step has both levels");

typedef struct {
    stm_tim_t *tim;
    volatile uint32_t *mode, *compare; ///< CCMRx and CCRx of its channel
    uint32_t enable;                   ///< bit of CCER
    stm_gpio_t *port;                  ///< of the direction
    uint32_t direction_pin;
} output_t;

/// PWM mode 2 has the same bits for channels 1 and 3.
static const output_t outputs[stm_n_steppers] = {
    [stm_step_x] = {TIM16, &TIM16->CCMR1, &TIM16->CCR1, TIM_CCER_CC1E, GPIOB, stm_pin_x_direction},
    [stm_step_z] = {TIM17, &TIM17->CCMR1, &TIM17->CCR1, TIM_CCER_CC1E, GPIOB, stm_pin_z_direction},
    [stm_step_u] = {TIM8, &TIM8->CCMR2, &TIM8->CCR3, TIM_CCER_CC3E, GPIOC, stm_pin_u_direction},
};
_Static_assert(TIM_CCMR1_OC1M_PWM2 == TIM_CCMR2_OC3M_PWM2, "one mode for all outputs");

/// Each axis in steps; the pins are low after init_output(), which means falling.
static struct {
    int32_t wanted, sent;
    bool is_rising;
} axis[stm_n_steppers];

static bool is_enabled;

/// [1 / stm_timer_hz] period of a train by its number of steps; avoids a division in the interrupt.
static uint16_t period[stm_steps_most + 1];

/// Prepare trains. In PWM mode 2 the output is high from CCRx to the end of a period. The counter
/// rests at 0, so the output rests low if CCRx is above 0, which must hold before it is enabled.
static void init_output(const output_t *to)
{
    to->tim->CR1 = TIM_CR1_URS | TIM_CR1_OPM;
    *to->compare = UINT16_MAX;
    *to->mode = TIM_CCMR1_OC1M_PWM2;
    to->tim->CCER = to->enable;
    to->tim->BDTR = TIM_BDTR_MOE;
}

void stm_steps_init(void)
{
    RCC_APB2ENR |= RCC_APB2ENR_TIM8 | RCC_APB2ENR_TIM16 | RCC_APB2ENR_TIM17;
    (void)RCC_APB2ENR;
    for (uint32_t i = 1; i <= stm_steps_most; i++) {
        period[i] = (uint16_t)(stm_steps_train / i);
    }
    for (uint32_t i = 0; i < stm_n_steppers; i++) {
        init_output(&outputs[i]);
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
static void start_train(const output_t *to, uint32_t n)
{
    stm_tim_t *const tim = to->tim;
    tim->RCR = n - 1u;
    tim->ARR = period[n] - 1u;
    *to->compare = period[n] - (uint32_t)stm_steps_high;
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
        outputs[i].port->BSRR = STM_BSRR(outputs[i].direction_pin, is_rising);
        return;
    }
    axis[i].sent = (int32_t)((uint32_t)axis[i].sent + (is_rising ? n : 0u - n));
    start_train(&outputs[i], n);
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
