/**
 * \file board_atmega1284p.c
 * \brief ATmega1284P at 16 MHz: USART 0 at 1 Mbit/s, timer 1.
 *
 * On an AVR constants are copied to RAM before main() (avr-libc does it). The 1284P has the most of
 * its family, 16 KB, and takes the largest joint; see ram.ld for a smaller one.
 */
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>

#include "board.h"
#include "ring.h"

#define TICK_US 1000u
#define COUNTS_PER_US 2u /* 16 MHz / 8 */

static ring_t received;
static volatile uint32_t ticks_us;

ISR(TIMER1_COMPA_vect) {
    ticks_us += TICK_US;
}

/*
 * With the ring full the byte stays in the USART and its interrupt is off until there is room: an
 * emulator's line waits then. On a real line the third byte from there on would be lost.
 */
ISR(USART0_RX_vect) {
    if (ring_full(&received)) {
        UCSR0B = (uint8_t)(UCSR0B & (uint8_t)~_BV(RXCIE0));
    } else {
        ring_put(&received, UDR0);
    }
}

/** Every interrupt that nobody asked for. */
ISR(BADISR_vect) {
    board_end(BOARD_FAULT);
}

void board_init(void) {
    OCR1A = TICK_US * COUNTS_PER_US - 1u;
    TCCR1B = _BV(WGM12) | _BV(CS11); /* from 0 to OCR1A, clock / 8 */
    TIMSK1 = _BV(OCIE1A);
    UCSR0A = _BV(U2X0);
    UBRR0 = 1; /* 16 MHz / 8 / (1 + 1) */
    UCSR0C = _BV(UCSZ01) | _BV(UCSZ00);
    UCSR0B = _BV(RXEN0) | _BV(TXEN0) | _BV(RXCIE0);
    sei();
}

/* A tick that waits for its interrupt counts if the timer has begun anew. */
uint32_t board_time_us(void) {
    cli();
    const uint16_t count = TCNT1;
    const bool pending = ((TIFR1 & _BV(OCF1A)) != 0) && (count < (TICK_US * COUNTS_PER_US / 2u));
    const uint32_t ticks = ticks_us;
    sei();
    return ticks + (pending ? TICK_US : 0u) + count / COUNTS_PER_US;
}

int board_read(void) {
    const int byte = ring_get(&received);
    if (ring_used(&received) == (RING_PLACES / 2u)) {
        UCSR0B = _BV(RXEN0) | _BV(TXEN0) | _BV(RXCIE0); /* in case its interrupt was off */
    }
    return byte;
}

void board_write(const uint8_t byte) {
    while ((UCSR0A & _BV(UDRE0)) == 0) {
    }
    UDR0 = byte;
}

/* sei() lets one more instruction pass: no byte slips in between the look and the sleep. */
void board_rest(void) {
    cli();
    if (ring_used(&received) == 0u) {
        SMCR = _BV(SE); /* idle: timer and USART go on */
        sei();
        sleep_cpu();
        SMCR = 0;
    }
    sei();
}

/* Sleeping with interrupts off ends the emulator, which takes its status from GPIOR0. */
BOARD_NO_RETURN void board_end(const int status) {
    while ((UCSR0A & _BV(UDRE0)) == 0) {
    }
    cli();
    GPIOR0 = (uint8_t)status;
    SMCR = _BV(SM1) | _BV(SE); /* power down */
    for (;;) {
        sleep_cpu();
    }
}
