// SPDX-License-Identifier: Apache-2.0
/// stm_reg: the registers and bits of the STM32H743 and its core that this port uses, and no
/// others.
///
/// Names are those of the reference manual RM0433 (revision 8), with the chapter above each
/// group; addresses: chapter 2, "Memory organization". The core's registers are at the end.
#ifndef STM_REG_H
#define STM_REG_H

#include <stddef.h> // offsetof
#include <stdint.h> // uint32_t

#define STM_REG(address) (*(volatile uint32_t *)(address))

// Chapter 3, RAM ECC monitoring. Monitors of domain 1: 1 AXI SRAM, 2 ITCM, 3 and 4 DTCM, 5 ETM

#define RAMECC1_CR(monitor) STM_REG(0x52009000u + 0x20u * (monitor))
#define RAMECC_CR_ECCDEIE (1u << 3)   // interrupt of a double error in a read
#define RAMECC_CR_ECCDEBWIE (1u << 4) // and in a partial write of a word
#define RAMECC_CR_ECCELEN (1u << 5)   // FAR keeps the address of an error
#define RAMECC1_SR(monitor) STM_REG(0x52009004u + 0x20u * (monitor)) // a flag is cleared by a 0
#define RAMECC_SR_SEDCF (1u << 0)
#define RAMECC_SR_DEDF (1u << 1)
#define RAMECC_SR_DEBWDF (1u << 2)
#define RAMECC_SR_FLAGS 7u
#define RAMECC1_FAR(monitor) STM_REG(0x52009008u + 0x20u * (monitor))

// Chapter 4, embedded flash memory

#define FLASH_ACR STM_REG(0x52002000u)
#define FLASH_ACR_LATENCY_4WS (4u << 0)       // VOS0, AXI clock up to 240 MHz
#define FLASH_ACR_WRHIGHFREQ_240MHZ (2u << 4) // same row of the table

/// Registers of a bank, 0 (bank 1) or 1 (bank 2).
#define FLASH_OPTSR_CUR STM_REG(0x5200201Cu)
#define FLASH_OPTSR_RDP(optsr) ((optsr) >> 8 & 0xFFu)  // 0xAA level 0, 0xCC level 2, all others 1
#define FLASH_OPTSR_BOR_LEV(optsr) ((optsr) >> 2 & 3u) // 3: 2.7 V, 0: off
#define FLASH_WPSN_CUR1 STM_REG(0x52002038u) // bit i is 0: sector i of bank 1 is protected
#define FLASH_KEYR(bank) STM_REG(0x52002004u + 0x100u * (bank))
#define FLASH_KEYR_FIRST 0x45670123u
#define FLASH_KEYR_SECOND 0xCDEF89ABu
#define FLASH_CR(bank) STM_REG(0x5200200Cu + 0x100u * (bank))
#define FLASH_CR_LOCK (1u << 0)
#define FLASH_CR_PG (1u << 1)
#define FLASH_CR_SER (1u << 2)
#define FLASH_CR_PSIZE_64 (3u << 4) // supply above 2.7 V
#define FLASH_CR_START (1u << 7)
#define FLASH_CR_SNB(sector) ((uint32_t)(sector) << 8)
#define FLASH_SR(bank) STM_REG(0x52002010u + 0x100u * (bank))
#define FLASH_SR_QW (1u << 2)
#define FLASH_SR_SNECCERR (1u << 25) // a single error was corrected
#define FLASH_SR_DBECCERR (1u << 26) // a double error was detected
#define FLASH_SR_ERRORS 0x006E0000u  // WRPERR, PGSERR, STRBERR, INCERR, OPERR: of erase and program
#define FLASH_SR_FLAGS 0x05EF0000u   // these, EOP and read flags, but not SNECCERR
#define FLASH_CCR(bank) STM_REG(0x52002014u + 0x100u * (bank))
#define FLASH_ECC_FA(bank) STM_REG(0x52002060u + 0x100u * (bank)) // flash word of the bank

// Chapter 6, power control

#define PWR_CSR1 STM_REG(0x58024804u)
#define PWR_CSR1_ACTVOSRDY (1u << 13)
#define PWR_CR3 STM_REG(0x5802480Cu)
#define PWR_CR3_BYPASS (1u << 0)
#define PWR_CR3_LDOEN (1u << 1)
#define PWR_CR3_SCUEN (1u << 2)
#define PWR_D3CR STM_REG(0x58024818u)
#define PWR_D3CR_VOSRDY (1u << 13)
#define PWR_D3CR_VOS_SCALE1 (3u << 14)

// Chapter 8, reset and clock control

#define RCC_CR STM_REG(0x58024400u)
#define RCC_CR_HSEON (1u << 16)
#define RCC_CR_HSERDY (1u << 17)
#define RCC_CR_HSEBYP (1u << 18)
#define RCC_CR_CSSHSEON (1u << 19)
#define RCC_CR_PLL1ON (1u << 24)
#define RCC_CR_PLL1RDY (1u << 25)
#define RCC_CFGR STM_REG(0x58024410u)
#define RCC_CFGR_SW_PLL1 (3u << 0)
#define RCC_CFGR_SW_MASK (7u << 0)
#define RCC_CFGR_SWS_PLL1 (3u << 3)
#define RCC_CFGR_SWS_MASK (7u << 3)
#define RCC_D1CFGR STM_REG(0x58024418u)
#define RCC_D1CFGR_HPRE_DIV2 (8u << 0)
#define RCC_D1CFGR_D1PPRE_DIV2 (4u << 4)
#define RCC_D2CFGR STM_REG(0x5802441Cu)
#define RCC_D2CFGR_D2PPRE1_DIV2 (4u << 4)
#define RCC_D2CFGR_D2PPRE2_DIV2 (4u << 8)
#define RCC_D3CFGR STM_REG(0x58024420u)
#define RCC_D3CFGR_D3PPRE_DIV2 (4u << 4)
#define RCC_PLLCKSELR STM_REG(0x58024428u)
#define RCC_PLLCKSELR_HSI (0u << 0)
#define RCC_PLLCKSELR_HSE (2u << 0)
#define RCC_PLLCKSELR_DIVM1(m) ((uint32_t)(m) << 4)
#define RCC_PLLCFGR STM_REG(0x5802442Cu)
#define RCC_PLLCFGR_PLL1RGE_8_16MHZ (3u << 2)
#define RCC_PLLCFGR_DIVP1EN (1u << 16)
#define RCC_PLLCFGR_DIVQ1EN (1u << 17)
#define RCC_PLL1DIVR STM_REG(0x58024430u)
#define RCC_PLL1DIVR_N1(n) (((uint32_t)(n)-1u) << 0)
#define RCC_PLL1DIVR_P1(p) (((uint32_t)(p)-1u) << 9)
#define RCC_PLL1DIVR_Q1(q) (((uint32_t)(q)-1u) << 16)
#define RCC_PLL1DIVR_R1(r) (((uint32_t)(r)-1u) << 24)
#define RCC_D2CCIP1R STM_REG(0x58024450u)
#define RCC_D2CCIP1R_SPI123_PLL1Q (0u << 12)
#define RCC_D2CCIP1R_SPI123_MASK (7u << 12)
#define RCC_D2CCIP1R_FDCAN_PLL1Q (1u << 28)
#define RCC_D2CCIP1R_FDCAN_MASK (3u << 28)
#define RCC_CICR STM_REG(0x58024468u)
#define RCC_CICR_HSECSSC (1u << 10)
#define RCC_CIFR STM_REG(0x58024464u)
#define RCC_CIFR_HSECSSF (1u << 10)
#define RCC_GCR STM_REG(0x580244A0u)
#define RCC_GCR_WW1RSC (1u << 0)
#define RCC_RSR STM_REG(0x580244D0u)
#define RCC_RSR_RMVF (1u << 16)
#define RCC_RSR_BORRSTF (1u << 21)
#define RCC_RSR_PINRSTF (1u << 22)
#define RCC_RSR_PORRSTF (1u << 23)
#define RCC_RSR_SFTRSTF (1u << 24)
#define RCC_RSR_IWDG1RSTF (1u << 26)
#define RCC_RSR_WWDG1RSTF (1u << 28)
#define RCC_AHB4ENR STM_REG(0x580244E0u)
#define RCC_AHB4ENR_GPIOA_TO_E (0x1Fu << 0)
#define RCC_AHB4ENR_GPIOB (1u << 1)
#define RCC_AHB4ENR_GPIOE (1u << 4)
#define RCC_APB3ENR STM_REG(0x580244E4u)
#define RCC_APB3ENR_WWDG1 (1u << 6)
#define RCC_APB1LENR STM_REG(0x580244E8u)
#define RCC_APB1LENR_TIM2 (1u << 0)
#define RCC_APB1LENR_TIM3 (1u << 1)
#define RCC_APB1LENR_TIM4 (1u << 2)
#define RCC_APB1LENR_TIM5 (1u << 3)
#define RCC_APB1LENR_SPI3 (1u << 15)
#define RCC_APB1LENR_USART3 (1u << 18)
#define RCC_APB1LENR_DAC12 (1u << 29)
#define RCC_APB1HENR STM_REG(0x580244ECu)
#define RCC_APB1HENR_FDCAN (1u << 8)
#define RCC_APB2ENR STM_REG(0x580244F0u)
#define RCC_APB2ENR_TIM1 (1u << 0)
#define RCC_APB2ENR_TIM8 (1u << 1)
#define RCC_APB2ENR_TIM16 (1u << 17)
#define RCC_APB2ENR_TIM17 (1u << 18)
#define RCC_APB4ENR STM_REG(0x580244F4u)
#define RCC_APB4ENR_SYSCFG (1u << 1)

// Chapter 11, general-purpose I/Os

typedef struct {
    volatile uint32_t MODER, OTYPER, OSPEEDR, PUPDR, IDR, ODR, BSRR, LCKR, AFR[2];
} stm_gpio_t;
_Static_assert(offsetof(stm_gpio_t, AFR) == 0x20, "as in the manual");

#define GPIOA ((stm_gpio_t *)0x58020000u)
#define GPIOB ((stm_gpio_t *)0x58020400u)
#define GPIOC ((stm_gpio_t *)0x58020800u)
#define GPIOD ((stm_gpio_t *)0x58020C00u)
#define GPIOE ((stm_gpio_t *)0x58021000u)

// Chapter 12, system configuration controller

#define SYSCFG_PWRCR STM_REG(0x5800042Cu)
#define SYSCFG_PWRCR_ODEN (1u << 0)

// Chapter 26, digital-to-analog converter

#define DAC_CR STM_REG(0x40007400u)
#define DAC_CR_EN1 (1u << 0)
#define DAC_CR_TEN1 (1u << 1)
#define DAC_CR_TSEL1_TIM4 (3u << 2)
#define DAC_DHR12R1 STM_REG(0x40007408u)
#define DAC_DOR1 STM_REG(0x4000742Cu)

// Chapters 38 (TIM1, TIM8), 39 (TIM2 to TIM5) and 41 (TIM16, TIM17), timers

typedef struct {
    volatile uint32_t CR1, CR2, SMCR, DIER, SR, EGR, CCMR1, CCMR2, CCER, CNT, PSC, ARR, RCR;
    volatile uint32_t CCR1, CCR2, CCR3, CCR4, BDTR, DCR, DMAR;
} stm_tim_t;
_Static_assert(offsetof(stm_tim_t, CCR4) == 0x40, "as in the manual");

#define TIM1 ((stm_tim_t *)0x40010000u)
#define TIM2 ((stm_tim_t *)0x40000000u)
#define TIM3 ((stm_tim_t *)0x40000400u)
#define TIM4 ((stm_tim_t *)0x40000800u)
#define TIM5 ((stm_tim_t *)0x40000C00u)
#define TIM8 ((stm_tim_t *)0x40010400u)
#define TIM16 ((stm_tim_t *)0x40014400u)
#define TIM17 ((stm_tim_t *)0x40014800u)
#define TIM_CR1_CEN (1u << 0)
#define TIM_CR1_URS (1u << 2)
#define TIM_CR1_OPM (1u << 3) // the counter stops at the next update event
#define TIM_CR1_DIR (1u << 4) // 1: the counter falls
#define TIM_CR2_MMS_OC3REF (6u << 4)
#define TIM_SMCR_SMS_ENCODER3 (3u << 0)
#define TIM_DIER_UIE (1u << 0)
#define TIM_SR_UIF (1u << 0)
#define TIM_SR_CC3IF (1u << 3)
#define TIM_SR_CC4IF (1u << 4)
#define TIM_SR_CC3OF (1u << 11)
#define TIM_SR_CC4OF (1u << 12)
#define TIM_EGR_UG (1u << 0)
#define TIM_CCMR1_IC1_TI1 (1u << 0)
#define TIM_CCMR1_IC1F_8 (3u << 4) // eight equal samples at the timer's clock: 33 ns
#define TIM_CCMR1_IC2_TI2 (1u << 8)
#define TIM_CCMR1_IC2F_8 (3u << 12)
#define TIM_CCMR1_OC1M_PWM2 (7u << 4)
#define TIM_CCMR2_IC3_TI3 (1u << 0)
#define TIM_CCMR2_IC3F_8 (3u << 4)
#define TIM_CCMR2_IC4_TI3 (2u << 8)
#define TIM_CCMR2_IC4_TI4 (1u << 8)
#define TIM_CCMR2_IC4F_8 (3u << 12)
#define TIM_CCMR2_OC3M_PWM2 (7u << 4)
#define TIM_CCER_IC1_BOTH (0xBu << 0) // CC1E, CC1P, CC1NP: both edges
#define TIM_CCER_IC4_BOTH (0xBu << 12)
#define TIM_CCER_CC1E (1u << 0)
#define TIM_CCER_CC3E (1u << 8)
#define TIM_CCER_CC3P (1u << 9)
#define TIM_CCER_CC4E (1u << 12)
#define TIM_CCER_CC4P (1u << 13)
#define TIM_BDTR_MOE (1u << 15)

enum { stm_irq_tim4 = 30, stm_irq_ecc = 145, stm_n_irqs = 150 }; // chapter 19, vector table

// Chapter 44, window watchdog

#define WWDG_CR STM_REG(0x50003000u)
#define WWDG_CR_WDGA (1u << 7)
#define WWDG_CFR STM_REG(0x50003004u)

// Chapter 45, independent watchdog

#define IWDG_KR STM_REG(0x58004800u)
#define IWDG_KR_RELOAD 0xAAAAu
#define IWDG_KR_UNLOCK 0x5555u
#define IWDG_KR_START 0xCCCCu
#define IWDG_PR STM_REG(0x58004804u)
#define IWDG_PR_DIV8 1u
#define IWDG_RLR STM_REG(0x58004808u)

// Chapter 48, USART

#define USART3_CR1 STM_REG(0x40004800u)
#define USART_CR1_UE (1u << 0)
#define USART_CR1_RE (1u << 2)
#define USART_CR1_TE (1u << 3)
#define USART_CR1_FIFOEN (1u << 29)
#define USART3_BRR STM_REG(0x4000480Cu)
#define USART3_ISR STM_REG(0x4000481Cu)
#define USART_ISR_RXFNE (1u << 5)
#define USART_ISR_TXFNF (1u << 7)
#define USART3_RDR STM_REG(0x40004824u)
#define USART3_TDR STM_REG(0x40004828u)

// Chapter 50, serial peripheral interface

#define SPI3_CR1 STM_REG(0x40003C00u)
#define SPI_CR1_SPE (1u << 0)
#define SPI_CR1_CSTART (1u << 9)
#define SPI3_CR2 STM_REG(0x40003C04u) // number of frames of a transfer
#define SPI3_CFG1 STM_REG(0x40003C08u)
#define SPI_CFG1_DSIZE_24 (23u << 0)
#define SPI_CFG1_MBR_DIV4 (1u << 28)
#define SPI_CFG1_MBR_DIV16 (3u << 28)
#define SPI3_CFG2 STM_REG(0x40003C0Cu)
#define SPI_CFG2_MSSI(clocks) ((uint32_t)(clocks) << 0)
#define SPI_CFG2_MIDI(clocks) ((uint32_t)(clocks) << 4)
#define SPI_CFG2_COMM_BOTH (0u << 17)
#define SPI_CFG2_COMM_TX_ONLY (1u << 17)
#define SPI_CFG2_MASTER (1u << 22)
#define SPI_CFG2_CPHA (1u << 24)
#define SPI_CFG2_SSOE (1u << 29)
#define SPI_CFG2_SSOM (1u << 30)
#define SPI_CFG2_AFCNTR (1u << 31)
#define SPI3_SR STM_REG(0x40003C14u)
#define SPI_SR_EOT (1u << 3)
#define SPI3_IFCR STM_REG(0x40003C18u)
#define SPI_IFCR_EOTC (1u << 3)
#define SPI_IFCR_TXTFC (1u << 4)
#define SPI3_TXDR STM_REG(0x40003C20u)
#define SPI3_RXDR STM_REG(0x40003C30u)

// Chapter 56, FD controller area network

#define FDCAN1_DBTP STM_REG(0x4000A00Cu)
#define FDCAN_DBTP_TDC (1u << 23)
#define FDCAN1_TEST STM_REG(0x4000A010u)
#define FDCAN_TEST_LBCK (1u << 4)
#define FDCAN1_CCCR STM_REG(0x4000A018u)
#define FDCAN_CCCR_INIT (1u << 0)
#define FDCAN_CCCR_CCE (1u << 1)
#define FDCAN_CCCR_MON (1u << 5)
#define FDCAN_CCCR_TEST (1u << 7)
#define FDCAN_CCCR_FDOE (1u << 8)
#define FDCAN_CCCR_BRSE (1u << 9)
#define FDCAN1_NBTP STM_REG(0x4000A01Cu)
#define FDCAN1_PSR STM_REG(0x4000A044u)
#define FDCAN_PSR_BO (1u << 7)
#define FDCAN1_TDCR STM_REG(0x4000A048u)
#define FDCAN1_GFC STM_REG(0x4000A080u)
#define FDCAN_GFC_RRFE (1u << 0)
#define FDCAN_GFC_RRFS (1u << 1)
#define FDCAN_GFC_ANFE_REJECT (2u << 2)
#define FDCAN_GFC_ANFS_FIFO0 (0u << 4)
#define FDCAN1_SIDFC STM_REG(0x4000A084u)
#define FDCAN1_XIDFC STM_REG(0x4000A088u)
#define FDCAN1_RXF0C STM_REG(0x4000A0A0u)
#define FDCAN_RXF0C_F0S(elements) ((uint32_t)(elements) << 16)
#define FDCAN1_RXF0S STM_REG(0x4000A0A4u)
#define FDCAN_RXF0S_F0FL (0x7Fu << 0)
#define FDCAN1_RXF0A STM_REG(0x4000A0A8u)
#define FDCAN1_RXESC STM_REG(0x4000A0BCu)
#define FDCAN_RXESC_F0DS_64 (7u << 0)
#define FDCAN1_TXBC STM_REG(0x4000A0C0u)
#define FDCAN_TXBC_TFQS(elements) ((uint32_t)(elements) << 24)
#define FDCAN1_TXFQS STM_REG(0x4000A0C4u)
#define FDCAN_TXFQS_TFQF (1u << 21)
#define FDCAN1_TXESC STM_REG(0x4000A0C8u)
#define FDCAN_TXESC_TBDS_64 (7u << 0)
#define FDCAN1_TXBAR STM_REG(0x4000A0D0u)
#define FDCAN_CCU_CCFG STM_REG(0x4000A804u)
#define FDCAN_CCU_CCFG_BCC (1u << 6)
#define FDCAN_RAM ((volatile uint32_t *)0x4000AC00u)

// Chapter 60, debug infrastructure

#define DBGMCU_IDC STM_REG(0x5C001000u)
#define DBGMCU_APB3FZ1 STM_REG(0x5C001034u)
#define DBGMCU_APB3FZ1_WWDG1 (1u << 6)
#define DBGMCU_APB4FZ1 STM_REG(0x5C001054u)
#define DBGMCU_APB4FZ1_WDGLSD1 (1u << 18)

// The core, a Cortex-M7. Source: ARMv7-M Architecture Reference Manual (DDI 0403), section above
// each group.

// B3.2, system control block

#define SCB_VTOR STM_REG(0xE000ED08u)
#define SCB_AIRCR STM_REG(0xE000ED0Cu)
#define SCB_AIRCR_SYSRESETREQ (0x05FA0000u | 1u << 2) // with the key
#define SCB_CCR STM_REG(0xE000ED14u)
#define SCB_CCR_DIV_0_TRP (1u << 4)
#define SCB_CCR_BFHFNMIGN (1u << 8) // no exception for unreadable data while FAULTMASK is set
#define SCB_CCR_DC (1u << 16)
#define SCB_CCR_IC (1u << 17)
#define SCB_SHCSR STM_REG(0xE000ED24u)
#define SCB_SHCSR_FAULTS (7u << 16) // memory, bus and usage faults have their own handlers

// B3.2.20, B3.2.21, floating-point unit

#define SCB_CPACR STM_REG(0xE000ED88u)
#define SCB_CPACR_FPU (0xFu << 20)
#define FPU_FPCCR STM_REG(0xE000EF34u)
#define FPU_FPCCR_SAVES (3u << 30) // exceptions save the registers of the unit

// B3.4, nested vectored interrupt controller: priorities are 0 after reset, the highest

#define NVIC_ISER(irq) STM_REG(0xE000E100u + 4u * ((irq) / 32u))

// B3.5, memory protection unit

#define MPU_CTRL STM_REG(0xE000ED94u)
#define MPU_CTRL_ENABLE (1u << 0)
#define MPU_CTRL_PRIVDEFENA (1u << 2)
#define MPU_RBAR STM_REG(0xE000ED9Cu)
#define MPU_RBAR_VALID (1u << 4)
#define MPU_RASR STM_REG(0xE000EDA0u)
#define MPU_RASR_ENABLE (1u << 0)
#define MPU_RASR_SIZE(log2_bytes) (((uint32_t)(log2_bytes)-1u) << 1)
#define MPU_RASR_WITHOUT(eighth) (1u << (8u + (eighth)))
#define MPU_RASR_DEVICE (1u << 16) // no speculative reads
#define MPU_RASR_WRITE_THROUGH (1u << 17)
#define MPU_RASR_UNCACHED (1u << 19)
#define MPU_RASR_NO_ACCESS (0u << 24)
#define MPU_RASR_READ_WRITE (3u << 24)
#define MPU_RASR_READ_ONLY (6u << 24)
#define MPU_RASR_XN (1u << 28)

// B2.2, B4.8, caches

#define SCB_CCSIDR STM_REG(0xE000ED80u)
#define SCB_CSSELR STM_REG(0xE000ED84u)
#define SCB_ICIALLU STM_REG(0xE000EF50u)
#define SCB_DCISW STM_REG(0xE000EF60u)

// C1.6, C1.8, debug: cycle counter

#define DCB_DEMCR STM_REG(0xE000EDFCu)
#define DCB_DEMCR_TRCENA (1u << 24)
#define DWT_CTRL STM_REG(0xE0001000u)
#define DWT_CTRL_CYCCNTENA (1u << 0)
#define DWT_CYCCNT STM_REG(0xE0001004u)
#define DWT_LAR STM_REG(0xE0001FB0u)
#define DWT_LAR_KEY 0xC5ACCE55u

/// Barrier: completes all earlier memory accesses before any later instruction runs. Always
/// inlined, because start-up in flash calls it before code has been copied to RAM.
__attribute__((always_inline)) static inline void stm_barrier(void)
{
    __asm volatile("dsb\n isb" ::: "memory");
}

#endif
