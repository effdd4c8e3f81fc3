/**
 * \file node.c
 * \brief The joint's node on a microcontroller, speaking SLCAN over its UART.
 *
 * A board with a CAN controller needs less: hand its frames to port_node_receive() and send what
 * port_node_transmit() gives, as the loop below does without the text in between.
 *
 * The program opens with an empty line, which says that its receiver listens.
 */
#include "board.h"
#include "ccgen/slcan.h"
#include "port_joint.h"

/*
 * Time within which a snapshot's frames must arrive, 0 for the layout's own, at most
 * PORT_WINDOW_MAX_US. A UART is slower than a CAN bus, and an emulator may be held up by its host:
 * both want a wider window.
 */
#ifndef PORT_WINDOW_US
#define PORT_WINDOW_US 0u
#endif

/*
 * 1 for tests in an emulator, which must not depend on how busy its host is: the widest window, and
 * a clock in which a cycle lasts a tenth of the board's second at least.
 */
#ifndef PORT_PATIENT
#define PORT_PATIENT 0
#endif

#if PORT_PATIENT
#define WINDOW_US PORT_WINDOW_MAX_US
#define SLOW ((100000u + PORT_CYCLE_US - 1u) / PORT_CYCLE_US)
#else
#define WINDOW_US PORT_WINDOW_US
#define SLOW 1u
#endif

static port_node_t node;
static ccgen_slcan_t slcan;
static uint32_t board_us;
static uint32_t rest_us;
static uint32_t node_us;

/** \return the node's time: microseconds that wrap at 2^32, however slow they pass. */
static uint32_t time_us(void) {
    const uint32_t now_us = board_time_us();
    rest_us += now_us - board_us;
    board_us = now_us;
    node_us += rest_us / SLOW;
    rest_us %= SLOW;
    return node_us;
}

static void write_bytes(const uint8_t *const bytes, const uint8_t length) {
    for (uint8_t i = 0; i < length; ++i) {
        board_write(bytes[i]);
    }
}

/** Sends every frame that is due; into the void while nobody has opened the channel. */
static void send_due(void) {
    ccgen_frame_t frame;
    uint8_t line[CCGEN_SLCAN_ENCODED_MAX];
    while (port_node_transmit(&node, time_us(), &frame) == 1) {
        const int length = slcan.open ? ccgen_slcan_encode(&frame, line, sizeof line) : 0;
        if (length > 0) {
            write_bytes(line, (uint8_t)length);
        }
    }
}

/** Takes a byte of the line. What is wrong with a frame, the node counts and its status tells. */
static void take(const uint8_t byte) {
    ccgen_frame_t frame;
    const int result = ccgen_slcan_feed(&slcan, byte, &frame);
    if (slcan.reply_length > 0u) {
        write_bytes(slcan.reply, slcan.reply_length);
    }
    if (result == 1) {
        (void)port_node_receive(&node, &frame, time_us());
        send_due(); /* an estimate goes out before the next frame may replace it */
    }
}

int main(void) {
    board_init();
    if ((ccgen_slcan_init(&slcan) != CCGEN_OK) || (port_node_init(&node) != CCGEN_OK) ||
        ((WINDOW_US > 0u) && (port_node_set_window(&node, WINDOW_US) != CCGEN_OK))) {
        board_end(BOARD_WRONG);
    }
    board_write('\r');
    for (;;) {
        const int byte = board_read();
        if (byte >= 0) {
            take((uint8_t)byte);
        } else {
            send_due();
            board_rest();
        }
    }
}
