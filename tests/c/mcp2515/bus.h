/*
 * A bus with the modelled chip and a script of what others send and what goes wrong, in the time of
 * the processor at the chip. Lines of the script, times in microseconds:
 *
 *     frame AT ID FLAGS DLC HEX    FLAGS: 1 extended, 2 remote; by AT, ascending
 *     alone FROM TO                nobody acknowledges, nobody sends
 *     broken FROM TO               every frame is destroyed
 *     deaf FROM TO                 edges of INT are lost
 *     reset AT                     the chip's supply breaks down for a moment
 *     dead FROM TO                 the chip does not answer
 *     end AT
 *
 * What the chip sends is printed as a line of the same form, without its first word.
 */
#ifndef MODEL_BUS_H
#define MODEL_BUS_H

#include "chip.h"

typedef struct bus bus_t;

/* Reads the script from standard input. */
bus_t *bus_new(uint32_t oscillator_hz, uint32_t bit_rate);
chip_t *bus_chip(bus_t *bus);
/* Lets time pass; \return whether the script has not ended */
bool bus_advance(bus_t *bus, uint64_t now_ns);
/* Whether edges of INT are lost at this time. */
bool bus_is_deaf(const bus_t *bus);
/* Prints what the chip saw: its overruns, violations, and the first of these. */
void bus_end(const bus_t *bus);

#endif
