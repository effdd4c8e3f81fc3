/**
 * \file core.h
 * \brief The few registers and instructions of the Cortex-M core that the boards use.
 */
#ifndef CORE_H
#define CORE_H

#include <stdint.h>

/** The register at an address. */
#define REGISTER(address) (*(volatile uint32_t *)(address))

#define SYSTICK_CTRL REGISTER(0xE000E010u) /* bit 0 on, bit 1 interrupt, bit 2 core's clock */
#define SYSTICK_LOAD REGISTER(0xE000E014u)
#define SYSTICK_VAL REGISTER(0xE000E018u)
#define ICSR REGISTER(0xE000ED04u)
#define ICSR_PENDSTSET (1u << 26) /* a SysTick interrupt waits */

/** Lets an interrupt of the chip (0 to 31) through. */
static inline void irq_enable(const uint32_t number) {
    REGISTER(0xE000E100u) = 1u << number;
}

/** Holds an interrupt of the chip (0 to 31) back; it stays pending. */
static inline void irq_disable(const uint32_t number) {
    REGISTER(0xE000E180u) = 1u << number;
    __asm volatile("dsb\n\tisb" ::: "memory");
}

/** Holds all interrupts back. */
static inline void interrupts_off(void) {
    __asm volatile("cpsid i" ::: "memory");
}

/** Lets interrupts through again. */
static inline void interrupts_on(void) {
    __asm volatile("cpsie i" ::: "memory");
}

/** Sleeps until an interrupt is pending, even one that is held back by interrupts_off(). */
static inline void wait_for_interrupt(void) {
    __asm volatile("dsb\n\twfi" ::: "memory");
}

#endif /* CORE_H */
