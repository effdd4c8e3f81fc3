/**
 * \file board_microbit.c
 * \brief BBC micro:bit, Cortex-M0: UART and timer of the nRF51822.
 */
#include "board.h"
#include "core.h"
#include "ring.h"

#define TICK_US 1000u

#define CLOCK_START_CRYSTAL REGISTER(0x40000000u)
#define CLOCK_CRYSTAL_RUNS REGISTER(0x40000100u)
#define PINS_SET REGISTER(0x50000508u)
#define PINS_OUTPUT REGISTER(0x50000518u)

#define UART_STARTRX REGISTER(0x40002000u)
#define UART_STARTTX REGISTER(0x40002008u)
#define UART_RXDRDY REGISTER(0x40002108u)
#define UART_TXDRDY REGISTER(0x4000211Cu)
#define UART_INTENSET REGISTER(0x40002304u)
#define UART_ENABLE REGISTER(0x40002500u)
#define UART_PSELTXD REGISTER(0x4000250Cu)
#define UART_PSELRXD REGISTER(0x40002514u)
#define UART_RXD REGISTER(0x40002518u)
#define UART_TXD REGISTER(0x4000251Cu)
#define UART_BAUDRATE REGISTER(0x40002524u)

#define UART_ENABLED 4u
#define UART_RXDRDY_INTERRUPT (1u << 2)
#define UART_1_MBAUD 0x10000000u
#define PIN_TXD 24u
#define PIN_RXD 25u

#define TIMER_START REGISTER(0x40008000u)
#define TIMER_CAPTURE_0 REGISTER(0x40008040u)
#define TIMER_COMPARE_1 REGISTER(0x40008144u)
#define TIMER_INTENSET REGISTER(0x40008304u)
#define TIMER_BITMODE REGISTER(0x40008508u)
#define TIMER_PRESCALER REGISTER(0x40008510u)
#define TIMER_CC_0 REGISTER(0x40008540u)
#define TIMER_CC_1 REGISTER(0x40008544u)

#define TIMER_32_BITS 3u
#define TIMER_1_MHZ 4u /* 16 MHz / 2^4 */
#define TIMER_COMPARE_1_INTERRUPT (1u << 17)

#define UART_IRQ 2u
#define TIMER_IRQ 8u

static ring_t received;

/* A full ring holds the interrupt back, and the UART's own queue fills: see board_mps2.c. */
static void uart_handler(void) {
    while (UART_RXDRDY != 0u) {
        if (ring_full(&received)) {
            irq_disable(UART_IRQ);
            return;
        }
        UART_RXDRDY = 0; /* before the byte is taken: the next one sets it again */
        ring_put(&received, (uint8_t)UART_RXD);
    }
}

/** Wakes the processor once a tick. */
static void timer_handler(void) {
    TIMER_COMPARE_1 = 0;
    TIMER_CC_1 = board_time_us() + TICK_US;
}

static void unused_handler(void) {
    board_end(BOARD_FAULT);
}

__attribute__((section(".vectors.chip"), used)) static void (*const chip_vectors[])(void) = {
    unused_handler, /* 0: power, clock */
    unused_handler, /* 1: radio */
    uart_handler,   /* 2 */
    unused_handler, /* 3: SPI, TWI 0 */
    unused_handler, /* 4: SPI, TWI 1 */
    unused_handler, /* 5 */
    unused_handler, /* 6: pins */
    unused_handler, /* 7: analogue */
    timer_handler,  /* 8: timer 0 */
};

/** UART and timer want a clock more exact than the oscillator that the chip starts with. */
static void start_crystal(void) {
    CLOCK_START_CRYSTAL = 1;
    while (CLOCK_CRYSTAL_RUNS == 0u) {
    }
}

static void start_timer(void) {
    TIMER_BITMODE = TIMER_32_BITS;
    TIMER_PRESCALER = TIMER_1_MHZ;
    TIMER_CC_1 = TICK_US;
    TIMER_INTENSET = TIMER_COMPARE_1_INTERRUPT;
    TIMER_START = 1;
    irq_enable(TIMER_IRQ);
}

static void start_uart(void) {
    PINS_SET = 1u << PIN_TXD; /* an idle line is high */
    PINS_OUTPUT = 1u << PIN_TXD;
    UART_PSELTXD = PIN_TXD;
    UART_PSELRXD = PIN_RXD;
    UART_BAUDRATE = UART_1_MBAUD;
    UART_ENABLE = UART_ENABLED;
    UART_INTENSET = UART_RXDRDY_INTERRUPT;
    UART_STARTTX = 1;
    UART_STARTRX = 1;
    irq_enable(UART_IRQ);
}

void board_init(void) {
    start_crystal();
    start_timer();
    start_uart();
}

/* The timer runs freely at 1 MHz in 32 bits: a capture is the time. */
uint32_t board_time_us(void) {
    TIMER_CAPTURE_0 = 1;
    return TIMER_CC_0;
}

int board_read(void) {
    const int byte = ring_get(&received);
    if (ring_used(&received) == (RING_PLACES / 2u)) {
        irq_enable(UART_IRQ); /* in case it was held back */
    }
    return byte;
}

void board_write(const uint8_t byte) {
    UART_TXD = byte;
    while (UART_TXDRDY == 0u) {
    }
    UART_TXDRDY = 0;
}

/* With interrupts off no byte slips in between the look at the ring and the sleep. */
void board_rest(void) {
    interrupts_off();
    if (ring_used(&received) == 0u) {
        wait_for_interrupt();
    }
    interrupts_on();
}
