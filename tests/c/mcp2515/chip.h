/*
 * A model of the MCP2515 as a processor and a bus see it: registers, instructions on SPI, filters,
 * two receive buffers with rollover, three transmit buffers, error counters and INT. After
 * Microchip's data sheet DS20001801; where that leaves something open, what is harder to serve.
 */
#ifndef MODEL_CHIP_H
#define MODEL_CHIP_H

#include <stdbool.h>
#include <stdint.h>

#define CHIP_NONE (-1)

typedef struct {
    uint32_t id;
    bool extended, remote;
    uint8_t code; /* DLC */
    uint8_t data[8];
} chip_frame_t;

typedef struct {
    uint8_t registers[128];
    uint8_t instruction, address, mask;
    unsigned position;  /* bytes since the chip was selected */
    int flying;         /* transmit buffer on the bus, or CHIP_NONE */
    bool abort_flying;  /* it is not to be tried again */
    unsigned tec, rec;
    bool off, dead;     /* bus-off; without supply */
    uint32_t overruns;  /* frames that found both buffers full */
    uint32_t violations; /* of the data sheet by the processor */
    const char *violation; /* the first */
} chip_t;

void chip_reset(chip_t *chip);

/* SPI: select, then one byte each way at a time, then deselect. */
void chip_select(chip_t *chip);
uint8_t chip_exchange(chip_t *chip, uint8_t in);
void chip_deselect(chip_t *chip);

/* Whether INT is low. */
bool chip_interrupts(const chip_t *chip);

/* In normal mode and not bus-off. */
bool chip_on_bus(const chip_t *chip);

/* Clocks of the oscillator in a bit; 0: not set up. */
unsigned chip_bit_clocks(const chip_t *chip);

/* The transmit buffer that is next, or CHIP_NONE; its frame; how its transmission ended. */
int chip_pending(const chip_t *chip);
void chip_frame(const chip_t *chip, int buffer, chip_frame_t *frame);
void chip_begin(chip_t *chip, int buffer);
void chip_succeed(chip_t *chip);
void chip_fail(chip_t *chip, bool unacknowledged);

/* A frame came by. */
void chip_hear(chip_t *chip, const chip_frame_t *frame);
void chip_hear_error(chip_t *chip);

/* 128 times 11 recessive bits after bus-off. */
void chip_recover(chip_t *chip);

#endif
