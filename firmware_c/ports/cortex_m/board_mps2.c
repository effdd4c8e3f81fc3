/**
 * \file board_mps2.c
 * \brief Arm's MPS2 boards with Cortex-M3 (AN385), M4 (AN386) and M7 (AN500): CMSDK UART, SysTick.
 */
#include "board.h"
#include "core.h"
#include "ring.h"

#define CLOCK_MHZ 25u
#define TICK_US 1000u

#define UART_DATA REGISTER(0x40004000u)
#define UART_STATE REGISTER(0x40004004u)
#define UART_CTRL REGISTER(0x40004008u)
#define UART_INTCLEAR REGISTER(0x4000400Cu)
#define UART_BAUDDIV REGISTER(0x40004010u)

#define STATE_TRANSMIT_FULL 1u
#define STATE_RECEIVE_FULL 2u
#define CTRL_TRANSMIT 1u
#define CTRL_RECEIVE 2u
#define CTRL_RECEIVE_INTERRUPT 8u
#define INTERRUPT_RECEIVE 2u

#define UART_RECEIVE_IRQ 0u

static ring_t received;
static volatile uint32_t ticks_us;

void systick_handler(void);

void systick_handler(void) {
    ticks_us += TICK_US;
}

/*
 * With the ring full the byte stays in the UART and its interrupt is held back until there is room:
 * an emulator's line waits then. On a real line the next byte would be lost, and with it one frame,
 * which the end-to-end protection notices.
 */
static void receive_handler(void) {
    while ((UART_STATE & STATE_RECEIVE_FULL) != 0u) {
        if (ring_full(&received)) {
            irq_disable(UART_RECEIVE_IRQ);
            return;
        }
        UART_INTCLEAR = INTERRUPT_RECEIVE; /* before the byte is taken: the next one may follow */
        ring_put(&received, (uint8_t)UART_DATA);
    }
}

__attribute__((section(".vectors.chip"), used)) static void (*const chip_vectors[])(void) = {
    receive_handler, /* 0: UART 0 receives */
};

void board_init(void) {
    SYSTICK_LOAD = CLOCK_MHZ * TICK_US - 1u;
    SYSTICK_VAL = 0;
    SYSTICK_CTRL = 7u;
    UART_BAUDDIV = 16u; /* the smallest divider that the UART takes */
    UART_CTRL = CTRL_TRANSMIT | CTRL_RECEIVE | CTRL_RECEIVE_INTERRUPT;
    (void)UART_DATA; /* lets QEMU hand over what came in before */
    irq_enable(UART_RECEIVE_IRQ);
}

/*
 * The counter may wrap between reading it and reading the ticks, and at 0 its tick may have been
 * counted or not: read until they agree, so that the clock never steps back.
 */
uint32_t board_time_us(void) {
    uint32_t before;
    uint32_t counter;
    do {
        before = ticks_us;
        counter = SYSTICK_VAL;
    } while ((counter == 0u) || (before != ticks_us) || ((ICSR & ICSR_PENDSTSET) != 0u));
    return before + (TICK_US - 1u) - counter / CLOCK_MHZ;
}

int board_read(void) {
    const int byte = ring_get(&received);
    if (ring_used(&received) == (RING_PLACES / 2u)) {
        irq_enable(UART_RECEIVE_IRQ); /* in case it was held back */
    }
    return byte;
}

void board_write(const uint8_t byte) {
    while ((UART_STATE & STATE_TRANSMIT_FULL) != 0u) {
    }
    UART_DATA = byte;
}

/* With interrupts off no byte slips in between the look at the ring and the sleep. */
void board_rest(void) {
    interrupts_off();
    if (ring_used(&received) == 0u) {
        wait_for_interrupt();
    }
    interrupts_on();
}
