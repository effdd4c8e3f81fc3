/*
 * The port and a joint's node on this machine, at the modelled chip, in time that only what they do
 * takes. INT interrupts them wherever they speak with the chip. What the chip sends is printed, then
 * the counters.
 */
#include <stdio.h>
#include <stdlib.h>

#include "bus.h"
#include "can_mcp2515.h"
#include "port_joint.h"

#define BYTE_NS 1000u    /* of SPI, with what a processor does about it */
#define LOOP_NS 5000u    /* of an empty round of the main loop */
#define STEP_NS 5000u    /* in which an interrupt is seen */

static bus_t *bus;
static uint64_t now_ns;
static bool going = true, low, exchanging, interrupted, with_interrupt;
static can_mcp2515_t can;
static port_node_t node;
static uint32_t ran_nested; /* interrupts that came while the main loop spoke with the chip */

static uint32_t start_us;

static uint32_t time_us(void) {
    return (uint32_t)(now_ns / 1000u) + start_us;
}

static void step(const uint64_t ns) {
    now_ns += ns;
    going = bus_advance(bus, now_ns);
    const bool was_low = low;
    low = chip_interrupts(bus_chip(bus));
    if (low && !was_low && with_interrupt && !interrupted && !bus_is_deaf(bus)) {
        interrupted = true;
        ran_nested += exchanging;
        can_mcp2515_receive(&can, time_us());
        interrupted = false;
    }
}

static void pass(uint64_t ns) {
    for (; ns > STEP_NS; ns -= STEP_NS) {
        step(STEP_NS);
    }
    step(ns);
}

static void exchange(void *context, uint8_t *bytes, uint8_t number) {
    (void)context;
    if (exchanging) {
        fprintf(stderr, "the chip is spoken to by two at a time\n");
        exit(3);
    }
    if (number > CAN_MCP2515_EXCHANGE_MAX) {
        fprintf(stderr, "an exchange of %u bytes\n", number);
        exit(3);
    }
    exchanging = true;
    chip_select(bus_chip(bus));
    for (uint8_t i = 0; i < number; ++i) {
        pass(BYTE_NS);
        bytes[i] = chip_exchange(bus_chip(bus), bytes[i]);
    }
    chip_deselect(bus_chip(bus));
    exchanging = false;
    pass(BYTE_NS);
}

static bool waits(void *context) {
    (void)context;
    return chip_interrupts(bus_chip(bus));
}

static void send_due(void) {
    ccgen_frame_t frame;
    while (port_node_transmit(&node, time_us(), &frame) == 1) {
        if (can_mcp2515_transmit(&can, &frame, time_us()) != 1) {
            (void)port_node_unsent(&node);
            return;
        }
    }
}

static void run(const uint64_t estimate_ns) {
    while (going) {
        ccgen_frame_t frame;
        uint32_t at_us;
        pass(LOOP_NS);
        can_mcp2515_service(&can, time_us());
        while (ccgen_queue_get(&can.arrivals, &frame, &at_us)) {
            if (port_node_receive(&node, &frame, at_us) == 1) {
                pass(estimate_ns);
            }
            send_due();
        }
        send_due();
    }
}

static uint32_t number(const char *text) {
    return (uint32_t)strtoul(text, NULL, 10);
}

int main(int argc, char **argv) {
    static can_port_filter_t filters[8];
    static can_mcp2515_board_t board = {NULL, exchange, waits};
    static can_port_config_t config;
    can_port_counters_t counters;
    if (argc < 9) {
        fprintf(stderr, "usage: host OSCILLATOR BIT_RATE CHIPS_RATE INTERRUPT(0: none; 2: and no "
                        "level) ESTIMATE_US START_US EXTENDED FD ID:MASK ...\n");
        return 2;
    }
    bus = bus_new(number(argv[1]), number(argv[2]));
    with_interrupt = number(argv[4]) > 0;
    board.waits = number(argv[4]) < 2 ? waits : NULL;
    start_us = number(argv[6]);
    config.clock_hz = number(argv[1]);
    config.bitrate = number(argv[3]);
    config.cycle_us = PORT_CYCLE_US;
    config.extended = number(argv[7]) != 0;
    config.fd = number(argv[8]) != 0;
    config.filters = filters;
    for (int i = 9; i < argc && i < 17; ++i) {
        unsigned id, mask;
        if (sscanf(argv[i], "%x:%x", &id, &mask) == 2) {
            filters[config.filter_count++] = (can_port_filter_t){id, mask};
        }
    }
    (void)port_node_init(&node);
    const int started = can_mcp2515_start(&can, &board, &config);
    if (started == CAN_PORT_OK) {
        run(1000u * (uint64_t)number(argv[5]));
    }
    can_mcp2515_counters(&can, &counters);
    printf("started %d nested %u clocks %u\n", started, (unsigned)ran_nested,
           chip_bit_clocks(bus_chip(bus)));
    printf("counters %u %u %u %u %u %u\n", (unsigned)counters.received,
           (unsigned)counters.dropped, (unsigned)counters.sent, (unsigned)counters.aborted,
           (unsigned)counters.bus_off, (unsigned)counters.errors);
    bus_end(bus);
    return 0;
}
