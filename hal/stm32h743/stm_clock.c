// SPDX-License-Identifier: Apache-2.0
#include "stm_port.h"

/// Polls of a flag before giving up: about 50 ms at the 64 MHz after reset.
enum { max_polls = 400000 };

/// Poll a register until the bits of a mask have the wanted values.
/// @return false on timeout
static bool wait_for(volatile uint32_t *reg, uint32_t mask, uint32_t wanted)
{
    for (uint32_t i = 0; i < max_polls; i++) {
        if ((*reg & mask) == wanted) {
            return true;
        }
    }
    return false;
}

/// Raise the core voltage to scale 1, then by overdrive to scale 0, the highest. Start-up has
/// selected the LDO.
static bool raise_supply(void)
{
    PWR_D3CR |= PWR_D3CR_VOS_SCALE1;
    (void)PWR_D3CR; // so that the flag below is that of the new scale; same after ODEN
    if (!wait_for(&PWR_D3CR, PWR_D3CR_VOSRDY, PWR_D3CR_VOSRDY)) {
        return false;
    }
    RCC_APB4ENR |= RCC_APB4ENR_SYSCFG;
    (void)RCC_APB4ENR;
    SYSCFG_PWRCR |= SYSCFG_PWRCR_ODEN;
    (void)SYSCFG_PWRCR;
    return wait_for(&PWR_D3CR, PWR_D3CR_VOSRDY, PWR_D3CR_VOSRDY);
}

/// Start the HSE, in bypass mode unless a crystal is fitted.
static bool start_hse(void)
{
    if (BOARD_HSE_IS_CRYSTAL == 0) {
        RCC_CR |= RCC_CR_HSEBYP;
    }
    RCC_CR |= RCC_CR_HSEON;
    return wait_for(&RCC_CR, RCC_CR_HSERDY, RCC_CR_HSERDY);
}

/// Start PLL1 with 8 MHz from either source; multiplied by 120, the VCO runs at 960 MHz.
static bool start_pll(bool has_hse)
{
    RCC_PLLCKSELR = has_hse ? RCC_PLLCKSELR_HSE | RCC_PLLCKSELR_DIVM1(1)
                            : RCC_PLLCKSELR_HSI | RCC_PLLCKSELR_DIVM1(8);
    RCC_PLLCFGR = RCC_PLLCFGR_PLL1RGE_8_16MHZ | RCC_PLLCFGR_DIVP1EN | RCC_PLLCFGR_DIVQ1EN;
    RCC_PLL1DIVR =
        RCC_PLL1DIVR_N1(120) | RCC_PLL1DIVR_P1(2) | RCC_PLL1DIVR_Q1(12) | RCC_PLL1DIVR_R1(2);
    RCC_CR |= RCC_CR_PLL1ON;
    return wait_for(&RCC_CR, RCC_CR_PLL1RDY, RCC_CR_PLL1RDY);
}

/// Set wait states and dividers first, then raise the frequency.
static bool switch_to_pll(void)
{
    FLASH_ACR = FLASH_ACR_LATENCY_4WS | FLASH_ACR_WRHIGHFREQ_240MHZ;
    (void)FLASH_ACR;
    RCC_D1CFGR = RCC_D1CFGR_HPRE_DIV2 | RCC_D1CFGR_D1PPRE_DIV2;
    RCC_D2CFGR = RCC_D2CFGR_D2PPRE1_DIV2 | RCC_D2CFGR_D2PPRE2_DIV2;
    RCC_D3CFGR = RCC_D3CFGR_D3PPRE_DIV2;
    RCC_CFGR = (RCC_CFGR & ~RCC_CFGR_SW_MASK) | RCC_CFGR_SW_PLL1;
    return wait_for(&RCC_CFGR, RCC_CFGR_SWS_MASK, RCC_CFGR_SWS_PLL1);
}

stm_clock_t stm_clock_init(void)
{
    if (!raise_supply()) {
        return stm_clock_fail;
    }
    const bool has_hse = start_hse();
    if (!start_pll(has_hse) || !switch_to_pll()) {
        return stm_clock_fail;
    }
    RCC_D2CCIP1R = (RCC_D2CCIP1R & ~(RCC_D2CCIP1R_SPI123_MASK | RCC_D2CCIP1R_FDCAN_MASK)) |
                   RCC_D2CCIP1R_SPI123_PLL1Q | RCC_D2CCIP1R_FDCAN_PLL1Q;
    if (has_hse) {
        RCC_CR |= RCC_CR_CSSHSEON;
    }
    return has_hse ? stm_clock_hse : stm_clock_hsi;
}
