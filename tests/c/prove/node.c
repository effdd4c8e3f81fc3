/**
 * \file node.c
 * \brief Proof driver: the node of a joint that obeys commands meets any frames, readings of
 * its own and times, in any order, without a fault.
 *
 * Nodes with a capture that goes on are followed apart from those without: the last command is BUSY
 * in the former alone, which is shown after each step.
 */
#include "capture_any.h"
#include "ccgen/layout_inline.h"
#include "joint_any.h"

int main(void);

static uint32_t any_word(void) {
    uint32_t word;
    Frama_C_make_unknown((char *)&word, sizeof word);
    return word;
}

static uint32_t any_identifier(const uint32_t first, const uint32_t last) {
    return (uint32_t)Frama_C_unsigned_long_interval(first, last);
}

/** Takes any frame that is neither LENGTHS nor COMMAND, below, between or above these. */
static void receive_other(port_node_t *const node) {
    const uint32_t first = LAYOUT.base_id;
    const uint32_t command = first + ccgen_layout_command_index(&LAYOUT);
    ccgen_frame_t frame;
    any_frame(&frame);
    if (either()) {
        frame.id = any_identifier(0, first - 1u);
    } else if (either()) {
        frame.id = any_identifier(first + LAYOUT.lengths_frames, command - 1u);
    } else {
        frame.id = any_identifier(command + 1u, UINT32_MAX);
    }
    (void)port_node_receive(node, &frame, any_word());
}

/** Takes any frame with an identifier of LENGTHS. */
static void receive_lengths(port_node_t *const node) {
    ccgen_frame_t frame;
    any_frame(&frame);
    frame.id = any_identifier(LAYOUT.base_id, LAYOUT.base_id + LAYOUT.lengths_frames - 1u);
    //@ split frame.id;
    (void)port_node_receive(node, &frame, any_word());
    //@ merge frame.id;
}

/** Takes any COMMAND: captures and others, with and without snapshots, apart. */
static void receive_command(port_node_t *const node) {
    ccgen_frame_t frame;
    any_frame(&frame);
    frame.id = LAYOUT.base_id + ccgen_layout_command_index(&LAYOUT);
    const uint8_t *const payload = &frame.data[ccgen_layout_header(&LAYOUT)];
    //@ split payload[0] < 0x10;
    //@ split payload[0] < 0x20;
    //@ split payload[1] > 0;
    (void)port_node_receive(node, &frame, any_word());
    //@ merge payload[0] < 0x10;
    //@ merge payload[0] < 0x20;
    //@ merge payload[1] > 0;
}

/** Takes any readings of the chip's own converter. */
static void read_own(port_node_t *const node) {
    port_counts_t counts;
    Frama_C_make_unknown((char *)&counts, sizeof counts);
    (void)OF_JOINT(node_estimate)(node, &counts, any_word());
}

static void look(const port_node_t *const node) {
    port_angles_t angles;
    uint8_t age_ms;
    (void)OF_JOINT(node_angles)(node, any_word(), &angles, &age_ms);
    (void)OF_JOINT(node_axes)(node);
}

/** Fetches a frame, and may take it back at once. */
static void transmit(port_node_t *const node) {
    ccgen_frame_t frame;
    //@ split node->node.next;
    (void)port_node_transmit(node, any_word(), &frame);
    if (either()) {
        (void)port_node_unsent(node);
    }
    //@ merge node->node.next;
}

int main(void) {
    port_node_t node;
    (void)port_node_init(&node);
    any_joint(&node.joint);
    while (either()) {
        //@ split capture_goes_on;
        switch (Frama_C_interval(0, 6)) {
            case 0:
                receive_other(&node);
                break;
            case 1:
                receive_lengths(&node);
                break;
            case 2:
                receive_command(&node);
                break;
            case 3:
                read_own(&node);
                break;
            case 4:
                look(&node);
                break;
            case 5:
                transmit(&node);
                break;
            default:
                (void)port_node_set_window(&node, any_word());
                break;
        }
        //@ assert node.node.health.result == CCGEN_RESULT_BUSY ==> capture_goes_on;
    }
    return 0;
}
