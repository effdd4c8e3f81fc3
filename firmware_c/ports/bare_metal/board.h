/**
 * \file board.h
 * \brief What a board gives to the bare-metal programs: bytes, a clock, rest, and an end.
 *
 * One implementation a board: cortex_m/board_mps2.c, cortex_m/board_microbit.c,
 * riscv_virt/board_virt.c, avr/board_atmega1284p.c. To bring up a board of your own, copy the
 * nearest one and fill in these six functions; node.c and batch.c stay as they are.
 */
#ifndef BOARD_H
#define BOARD_H

#include <stdint.h>

#if defined(__GNUC__)
#define BOARD_NO_RETURN __attribute__((noreturn))
#else
#define BOARD_NO_RETURN
#endif

/** What board_end() reports. */
enum {
    BOARD_DONE = 0,  /**< the program has done its work */
    BOARD_WRONG = 1, /**< the program found something wrong */
    BOARD_FAULT = 3  /**< the processor took an exception that nobody handles */
};

/** Starts clock, receiver and transmitter, and enables interrupts. Call once, first. */
void board_init(void);

/**
 * Call from the main loop, at least once a second.
 * \return microseconds since the start, never stepping back, wrapping at 2^32
 */
uint32_t board_time_us(void);

/** \return the oldest received byte that was not read yet, -1 if there is none */
int board_read(void);

/** Sends a byte; waits while the transmitter is busy. */
void board_write(uint8_t byte);

/** Sleeps until a byte is there to be read, and for about a millisecond at most. */
void board_rest(void);

/**
 * Ends the program for good. An emulator exits with the status; a real board stops.
 * \param[in] status  BOARD_DONE, BOARD_WRONG or BOARD_FAULT
 */
BOARD_NO_RETURN void board_end(int status);

#endif /* BOARD_H */
