/**
 * \file bus.h
 * \brief A CAN bus for models of controllers: time, frames of others, disturbances.
 *
 * Time goes on in steps of 100 us, each of which has room for one frame. Frames of others come from
 * standard input, a line each: when (ms), identifier, flags (1 extended, 2 remote, 4 FD, 8 bit-rate
 * switch), DLC, data. What the controller sends goes to standard output in the same form. Spans of
 * time come from the environment, FROM-TO in milliseconds: FAKE_ALONE, nobody acknowledges;
 * FAKE_OFF, every frame is destroyed; FAKE_DEAF, interrupts are lost; FAKE_BUSY, the program is held
 * up from the first to the last; FAKE_END: when it ends.
 */
#ifndef BUS_H
#define BUS_H

#include <stdbool.h>
#include <stdint.h>

#include "can_port.h"

typedef struct {
    uint32_t id;
    uint8_t flags;
    uint8_t dlc;
    uint8_t data[64];
} bus_frame_t;

enum { BUS_EXTENDED = 1, BUS_REMOTE = 2, BUS_FD = 4, BUS_SWITCH = 8 };

typedef enum { BUS_SENT, BUS_ALONE, BUS_DESTROYED } bus_result_t;

uint32_t bus_time_us(void);

/** Whether the time lies in a span of the environment. */
bool bus_within(const char *name);

/** A frame of others that is due, as a controller hears it. */
bool bus_next(bus_frame_t *frame);

/** What becomes of a frame that the controller puts on the bus. */
bus_result_t bus_send(const bus_frame_t *frame);

/** Lets time pass: steps, and the controller's part in each; not within a step. */
void bus_pass(uint32_t us);

uint8_t bus_bytes(uint8_t dlc);

/** What is printed at the end. */
extern const can_port_counters_t *bus_counters;

/** The controller's: what it does in a step. */
void fake_step(void);

#endif /* BUS_H */
