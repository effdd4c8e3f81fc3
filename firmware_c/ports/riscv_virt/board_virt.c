/**
 * \file board_virt.c
 * \brief QEMU's RISC-V board `virt`: 16550 UART, machine timer, interrupt controller, exit device.
 */
#include "board.h"
#include "ring.h"

/* Newer assemblers ask for the instructions on control registers by name. */
__asm(".option arch, +zicsr");

#define REGISTER8(address) (*(volatile uint8_t *)(address))
#define REGISTER(address) (*(volatile uint32_t *)(address))

#define UART_DATA REGISTER8(0x10000000u)
#define UART_INTERRUPTS REGISTER8(0x10000001u)
#define UART_FIFO REGISTER8(0x10000002u)
#define UART_STATE REGISTER8(0x10000005u)
#define INTERRUPT_RECEIVE 1u
#define FIFO_ON 1u
#define STATE_RECEIVED 0x01u
#define STATE_TRANSMIT_EMPTY 0x20u

/* The platform's interrupt controller, as the machine mode of processor 0 sees it. */
#define PLIC_UART_PRIORITY REGISTER(0x0C000028u)
#define PLIC_ENABLE REGISTER(0x0C002000u)
#define PLIC_CLAIM REGISTER(0x0C200004u)
#define PLIC_UART 10u

/* The machine timer runs freely in 64 bits; its interrupt is due while it is past TIMER_COMPARE. */
#define TIMER_LOW REGISTER(0x0200BFF8u)
#define TIMER_HIGH REGISTER(0x0200BFFCu)
#define TIMER_COMPARE_LOW REGISTER(0x02004000u)
#define TIMER_COMPARE_HIGH REGISTER(0x02004004u)
#define TIMER_MHZ 10u
#define TICK_US 1000u

#define EXIT REGISTER(0x00100000u)
#define EXIT_PASS 0x5555u
#define EXIT_FAIL 0x3333u

#define MSTATUS_INTERRUPTS (1u << 3)
#define MIE_TIMER (1u << 7)
#define MIE_EXTERNAL (1u << 11)
#define MCAUSE_TIMER 0x80000007u
#define MCAUSE_EXTERNAL 0x8000000Bu

static ring_t received;

/** Sets the next tick; the compare register passes no value below both the old and the new one. */
static void set_tick(void) {
    uint32_t high;
    uint32_t low;
    do {
        high = TIMER_HIGH;
        low = TIMER_LOW;
    } while (high != TIMER_HIGH);
    const uint32_t due = low + TIMER_MHZ * TICK_US;
    TIMER_COMPARE_LOW = UINT32_MAX;
    TIMER_COMPARE_HIGH = high + ((due < low) ? 1u : 0u);
    TIMER_COMPARE_LOW = due;
}

/* With the ring full the bytes stay in the UART, which is silenced until there is room. */
static void receive(void) {
    while ((UART_STATE & STATE_RECEIVED) != 0u) {
        if (ring_full(&received)) {
            UART_INTERRUPTS = 0;
            return;
        }
        ring_put(&received, UART_DATA);
    }
}

static void external_interrupt(void) {
    const uint32_t source = PLIC_CLAIM;
    if (source == PLIC_UART) {
        receive();
    }
    PLIC_CLAIM = source; /* done with it */
}

void trap_handler(void);

/** Every interrupt and every exception. */
__attribute__((interrupt("machine"), aligned(4))) void trap_handler(void) {
    uint32_t cause;
    __asm volatile("csrr %0, mcause" : "=r"(cause));
    if (cause == MCAUSE_EXTERNAL) {
        external_interrupt();
    } else if (cause == MCAUSE_TIMER) {
        set_tick();
    } else {
        board_end(BOARD_FAULT);
    }
}

static void interrupts_off(void) {
    __asm volatile("csrc mstatus, %0" ::"r"(MSTATUS_INTERRUPTS) : "memory");
}

static void interrupts_on(void) {
    __asm volatile("csrs mstatus, %0" ::"r"(MSTATUS_INTERRUPTS) : "memory");
}

void board_init(void) {
    UART_FIFO = FIFO_ON;
    UART_INTERRUPTS = INTERRUPT_RECEIVE;
    PLIC_UART_PRIORITY = 1;
    PLIC_ENABLE = 1u << PLIC_UART;
    set_tick();
    __asm volatile("csrs mie, %0" ::"r"(MIE_TIMER | MIE_EXTERNAL) : "memory");
    interrupts_on();
}

/* Adds up what the timer has run since the last call: no division of 64 bits. */
uint32_t board_time_us(void) {
    static uint32_t now_us;
    static uint32_t counted;
    const uint32_t passed_us = (TIMER_LOW - counted) / TIMER_MHZ;
    counted += passed_us * TIMER_MHZ;
    now_us += passed_us;
    return now_us;
}

int board_read(void) {
    const int byte = ring_get(&received);
    if (ring_used(&received) == (RING_PLACES / 2u)) {
        UART_INTERRUPTS = INTERRUPT_RECEIVE; /* in case it was silenced */
    }
    return byte;
}

void board_write(const uint8_t byte) {
    while ((UART_STATE & STATE_TRANSMIT_EMPTY) == 0u) {
    }
    UART_DATA = byte;
}

/* With interrupts off no byte slips in between the look at the ring and the sleep. */
void board_rest(void) {
    interrupts_off();
    if (ring_used(&received) == 0u) {
        __asm volatile("wfi" ::: "memory");
    }
    interrupts_on();
}

BOARD_NO_RETURN void board_end(const int status) {
    EXIT = (status == BOARD_DONE) ? EXIT_PASS : (EXIT_FAIL | ((uint32_t)status << 16));
    for (;;) {
    }
}
