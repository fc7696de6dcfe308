// SPDX-License-Identifier: Apache-2.0
#include "stm_port.h"
#include <stddef.h> // size_t

// RM0433 11.4, fields of GPIOx_MODER and GPIOx_PUPDR
enum { mode_input = 0, mode_output = 1, mode_alternate = 2, mode_analogue = 3 };
enum { pull_none = 0, pull_up = 1, pull_down = 2 };

/// A pin with its function.
typedef struct {
    stm_gpio_t *port;
    uint8_t pin;
    uint8_t mode;
    uint8_t pull; ///< pulls an input with a cut wire to its rest level
    uint8_t alternate;
} pin_t;

/// Without the outputs of port E, which stm_outputs_safe() has set up.
static const pin_t pins[] = {
    {GPIOA, 4, mode_analogue, pull_none, 0},   // internal DAC
    {GPIOA, 5, mode_alternate, pull_down, 1},  // TIM2 channel 1: spindle A
    {GPIOB, 3, mode_alternate, pull_down, 1},  // TIM2 channel 2: spindle B
    {GPIOB, 10, mode_alternate, pull_down, 1}, // TIM2 channel 3: spindle index
    {GPIOA, 0, mode_alternate, pull_down, 2},  // TIM5 channel 1: spindle A, for its time
    {GPIOA, 3, mode_alternate, pull_down, 2},  // TIM5 channel 4: spindle B, for its time
    {GPIOC, 6, mode_alternate, pull_down, 2},  // TIM3 channel 1: Z scale A
    {GPIOC, 7, mode_alternate, pull_down, 2},  // TIM3 channel 2: Z scale B
    {GPIOE, 9, mode_alternate, pull_down, 1},  // TIM1 channel 1: U scale A
    {GPIOE, 11, mode_alternate, pull_down, 1}, // TIM1 channel 2: U scale B
    {GPIOD, 14, mode_alternate, pull_none, 2}, // TIM4 channel 3: /LDAC
    {GPIOB, 8, mode_alternate, pull_none, 1},  // TIM16 channel 1: steps of X
    {GPIOB, 9, mode_alternate, pull_none, 1},  // TIM17 channel 1: steps of Z
    {GPIOC, 8, mode_alternate, pull_none, 3},  // TIM8 channel 3: steps of U
    {GPIOC, stm_pin_u_direction, mode_output, pull_none, 0},
    {GPIOB, stm_pin_x_direction, mode_output, pull_none, 0},
    {GPIOB, stm_pin_z_direction, mode_output, pull_none, 0},
    {GPIOC, 10, mode_alternate, pull_none, 6}, // SPI3 SCK
    {GPIOC, 12, mode_alternate, pull_none, 6}, // SPI3 MOSI: SDIN
    {GPIOC, 11, mode_alternate, pull_down, 6}, // SPI3 MISO: SDO
    {GPIOA, 15, mode_alternate, pull_none, 6}, // SPI3 NSS: /SYNC
    {GPIOD, 0, mode_alternate, pull_up, 9},    // FDCAN1 RX
    {GPIOD, 1, mode_alternate, pull_none, 9},  // FDCAN1 TX
    {GPIOD, 8, mode_alternate, pull_none, 7},  // USART3 TX
    {GPIOD, 9, mode_alternate, pull_up, 7},    // USART3 RX
    {GPIOD, stm_pin_home_u, mode_input, pull_down, 0},
    {GPIOD, stm_pin_home_u + 1, mode_input, pull_down, 0},
    {GPIOD, stm_pin_home_u + 2, mode_input, pull_down, 0},
    {GPIOD, stm_pin_index_u, mode_input, pull_down, 0},
    {GPIOD, stm_pin_index_u + 1, mode_input, pull_down, 0},
    {GPIOD, stm_pin_index_u + 2, mode_input, pull_down, 0},
    {GPIOD, stm_pin_acknowledge, mode_input, pull_down, 0},
    {GPIOD, stm_pin_key, mode_input, pull_down, 0},
    {GPIOD, stm_pin_limit_u_low, mode_input, pull_down, 0},
    {GPIOD, stm_pin_limit_u_high, mode_input, pull_down, 0},
    {GPIOE, stm_pin_estop, mode_input, pull_down, 0},
    {GPIOE, stm_pin_ready, mode_input, pull_down, 0},
};

/// Overwrite a field of a register.
static void set_field(volatile uint32_t *reg, uint32_t at, uint32_t width, uint32_t value)
{
    *reg = (*reg & ~(((1u << width) - 1u) << at)) | value << at;
}

/// Set speed and alternate function before the mode, so that the pin never drives anything else.
static void set_pin(const pin_t *p)
{
    enum { high_speed = 2 }; // clean edges at the 20 MHz of SPI3
    set_field(&p->port->AFR[p->pin / 8u], p->pin % 8u * 4u, 4, p->alternate);
    set_field(&p->port->OSPEEDR, p->pin * 2u, 2, high_speed);
    set_field(&p->port->PUPDR, p->pin * 2u, 2, p->pull);
    set_field(&p->port->MODER, p->pin * 2u, 2, p->mode);
}

void stm_pins_init(void)
{
    RCC_AHB4ENR |= RCC_AHB4ENR_GPIOA_TO_E;
    (void)RCC_AHB4ENR;
    for (size_t i = 0; i < sizeof pins / sizeof pins[0]; i++) {
        set_pin(&pins[i]);
    }
}
