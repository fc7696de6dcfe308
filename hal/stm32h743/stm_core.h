// SPDX-License-Identifier: Apache-2.0
/// stm_core: the registers of the Cortex-M7 that this port uses.
///
/// Source: ARMv7-M Architecture Reference Manual (DDI 0403), section above each group.
#ifndef STM_CORE_H
#define STM_CORE_H

#include "stm_reg.h" // STM_REG

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
#define FPU_FPCCR_LAZY (3u << 30) // save registers only for an exception that uses the unit

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
