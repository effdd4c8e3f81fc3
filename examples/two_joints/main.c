/*
 * Two joints in one program, on one bus: SLCAN over the board's UART. Every frame is offered to
 * both nodes, each takes its own; what either has to say goes out on the same line.
 *
 * The program opens with an empty line, which says that its receiver listens.
 */
#include "board.h"
#include "ccgen/slcan.h"
#include "shoulder_can.h"
#include "wrist_can.h"

static shoulder_node_t shoulder;
static wrist_node_t wrist;
static ccgen_slcan_t slcan;

static void write_bytes(const uint8_t *bytes, uint8_t length) {
    for (uint8_t i = 0; i < length; ++i) {
        board_write(bytes[i]);
    }
}

static void send(const ccgen_frame_t *frame) {
    uint8_t line[CCGEN_SLCAN_ENCODED_MAX];
    const int length = slcan.open ? ccgen_slcan_encode(frame, line, sizeof line) : 0;
    if (length > 0) {
        write_bytes(line, (uint8_t)length);
    }
}

static void send_due(void) {
    ccgen_frame_t frame;
    while (shoulder_node_transmit(&shoulder, board_time_us(), &frame) == 1) {
        send(&frame);
    }
    while (wrist_node_transmit(&wrist, board_time_us(), &frame) == 1) {
        send(&frame);
    }
}

static void take(uint8_t byte) {
    ccgen_frame_t frame;
    const int result = ccgen_slcan_feed(&slcan, byte, &frame);
    write_bytes(slcan.reply, slcan.reply_length);
    if (result == 1) {
        (void)shoulder_node_receive(&shoulder, &frame, board_time_us());
        (void)wrist_node_receive(&wrist, &frame, board_time_us());
        send_due(); /* an estimate goes out before the next frame may replace it */
    }
}

/**
 * Widens the time within which a snapshot's frames must arrive. A UART is slower than a CAN bus,
 * and an emulator may be held up by its host; on a CAN bus leave the windows of the layouts.
 */
static bool widen(void) {
    return shoulder_node_set_window(&shoulder, SHOULDER_WINDOW_MAX_US) == CCGEN_OK &&
           wrist_node_set_window(&wrist, WRIST_WINDOW_MAX_US) == CCGEN_OK;
}

static bool start(void) {
    return ccgen_slcan_init(&slcan) == CCGEN_OK && shoulder_node_init(&shoulder) == CCGEN_OK &&
           wrist_node_init(&wrist) == CCGEN_OK && widen();
}

int main(void) {
    board_init();
    if (!start()) {
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
