/**
 * \file startup.c
 * \brief From reset to main() on any Cortex-M: vector table, FPU, data, faults.
 *
 * The sixteen vectors of the core stand here. The vectors of the chip follow them in the section
 * `.vectors.chip`, which the board's file fills.
 */
#include <stdint.h>

#include "board.h"

typedef void (*vector_t)(void);

/** What the processor reads at address 0. */
typedef struct {
    const void *stack;
    vector_t reset;
    vector_t nmi;
    vector_t hard_fault;
    vector_t memory_fault;
    vector_t bus_fault;
    vector_t usage_fault;
    vector_t reserved_7[4];
    vector_t supervisor_call;
    vector_t debug_monitor;
    vector_t reserved_13;
    vector_t pending_service;
    vector_t systick;
} core_vectors_t;

/*
 * Of the linker script. Arrays, so that a pointer may run on beyond one word; ends are compared
 * with <, since compilers may take two objects' addresses for never equal, empty sections or not.
 */
extern uint32_t stack_top[], data_load[], data_start[], data_end[], bss_start[], bss_end[];

int main(void);
void reset_handler(void);
void systick_handler(void);

/** Every exception that nobody handles: a fault, an interrupt that was not asked for. */
static void fault_handler(void) {
    board_end(BOARD_FAULT);
}

/** A board without SysTick leaves this out. */
__attribute__((weak)) void systick_handler(void) {
    fault_handler();
}

__attribute__((section(".vectors.core"), used)) static const core_vectors_t core_vectors = {
    .stack = stack_top,
    .reset = reset_handler,
    .nmi = fault_handler,
    .hard_fault = fault_handler,
    .memory_fault = fault_handler,
    .bus_fault = fault_handler,
    .usage_fault = fault_handler,
    .supervisor_call = fault_handler,
    .debug_monitor = fault_handler,
    .pending_service = fault_handler,
    .systick = systick_handler,
};

#if defined(__ARM_FP)
/** Grants access to the floating-point unit; before it, a float instruction is a fault. */
static void enable_fpu(void) {
    volatile uint32_t *const cpacr = (volatile uint32_t *)0xE000ED88u;
    *cpacr |= 0xFu << 20; /* CP10 and CP11: full access */
    __asm volatile("dsb\n\tisb" ::: "memory");
}
#endif

/** Copies initialised data from flash to RAM and clears the rest, then runs the program. */
void reset_handler(void) {
#if defined(__ARM_FP)
    enable_fpu();
#endif
    const uint32_t *from = data_load;
    for (uint32_t *to = data_start; to < data_end; ++to) {
        *to = *from;
        ++from;
    }
    for (uint32_t *to = bss_start; to < bss_end; ++to) {
        *to = 0;
    }
    board_end(main());
}
