/**
 * \file bus.c
 * \brief See bus.h.
 */
#include "bus.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "must.h"

#define STEP_US 100u

const can_port_counters_t *bus_counters;

static struct {
    uint32_t us;
    uint32_t stepped_us;
    bool inside; /* a step: an interrupt asks for the time */
    bool read; /* a line's time */
    long due_ms;
} bus;

uint32_t bus_time_us(void) {
    return bus.us;
}

static bool span(const char *const name, long *const from, long *const to) {
    const char *const text = getenv(name);
    return (text != NULL) && (sscanf(text, "%ld-%ld", from, to) == 2);
}

bool bus_within(const char *const name) {
    long from = 0;
    long to = 0;
    const long now = (long)(bus.us / 1000u);
    return span(name, &from, &to) && (now >= from) && (now < to);
}

uint8_t bus_bytes(const uint8_t dlc) {
    static const uint8_t bytes[16] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64};
    return bytes[dlc & 15u];
}

static void read_data(const char *const text, uint8_t data[64]) {
    memset(data, 0, 64);
    for (size_t i = 0; (i < 64u) && (2u * i + 1u < strlen(text)); ++i) {
        unsigned byte = 0;
        CHECK(sscanf(&text[2u * i], "%2x", &byte) == 1);
        data[i] = (uint8_t)byte;
    }
}

bool bus_next(bus_frame_t *const frame) {
    char data[129];
    unsigned id = 0;
    unsigned flags = 0;
    unsigned dlc = 0;
    if (!bus.read) {
        bus.read = scanf("%ld", &bus.due_ms) == 1;
    }
    if (!bus.read || (bus.due_ms > (long)(bus.us / 1000u))) {
        return false;
    }
    CHECK(scanf("%x %x %u %128s", &id, &flags, &dlc, data) == 4);
    bus.read = false;
    frame->id = id;
    frame->flags = (uint8_t)flags;
    frame->dlc = (uint8_t)dlc;
    read_data(data, frame->data);
    return !bus_within("FAKE_OFF");
}

bus_result_t bus_send(const bus_frame_t *const frame) {
    if (bus_within("FAKE_OFF")) {
        return BUS_DESTROYED;
    }
    if (bus_within("FAKE_ALONE")) {
        return BUS_ALONE;
    }
    (void)printf("%lu %lx %x %u ", (unsigned long)(bus.us / 1000u), (unsigned long)frame->id,
                 (unsigned)frame->flags, (unsigned)frame->dlc);
    for (unsigned i = 0; i < bus_bytes(frame->dlc); ++i) {
        (void)printf("%02x", (unsigned)frame->data[i]);
    }
    (void)printf("\n");
    return BUS_SENT;
}

static void end(void) {
    const can_port_counters_t *const all = bus_counters;
    (void)printf("# %lu %lu %lu %lu %lu %lu\n", (unsigned long)all->received,
                 (unsigned long)all->dropped, (unsigned long)all->sent,
                 (unsigned long)all->aborted, (unsigned long)all->bus_off,
                 (unsigned long)all->errors);
    exit(0);
}

static void step(void) {
    bus.inside = true;
    bus.stepped_us += STEP_US;
    fake_step();
    bus.inside = false;
    if ((long)(bus.us / 1000u) > strtol(getenv("FAKE_END"), NULL, 10)) {
        end();
    }
}

void bus_pass(const uint32_t us) {
    if (bus.inside) {
        return;
    }
    bus.us += us;
    while (bus_within("FAKE_BUSY")) {
        bus.us += STEP_US;
        step();
    }
    while (bus.us - bus.stepped_us >= STEP_US) {
        step();
    }
}
