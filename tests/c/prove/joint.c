/**
 * \file joint.c
 * \brief Proof driver: an exported joint meets any frames, at any times, in any order, with any
 * zero offsets, without a fault; so does its estimator with any counts.
 */
#include "anything.h"
#include "port_joint.h"

int main(void);

static void estimate_anything(void) {
    port_joint_t joint;
    port_counts_t counts;
    port_angles_t angles;
    float jacobian[6][PORT_VALUES];
    Frama_C_make_unknown((char *)&joint, sizeof joint);
    Frama_C_make_unknown((char *)&counts, sizeof counts);
    (void)port_estimate(&joint, &counts, &angles);
    (void)port_capture_zero(&joint, &counts);
    Frama_C_make_unknown((char *)&angles, sizeof angles);
    (void)port_tip_jacobian(&angles, jacobian);
}

static void serve_anything(void) {
    port_node_t node;
    ccgen_frame_t frame;
    uint32_t word;
    (void)port_node_init(&node);
    Frama_C_make_unknown((char *)&node.joint, sizeof node.joint);
    while (either()) {
        Frama_C_make_unknown((char *)&word, sizeof word);
        switch (Frama_C_interval(0, 2)) {
            case 0:
                any_frame(&frame);
                (void)port_node_receive(&node, &frame, word);
                break;
            case 1:
                //@ split node.node.next;
                (void)port_node_transmit(&node, word, &frame);
                //@ merge node.node.next;
                break;
            default:
                (void)port_node_set_window(&node, word);
                break;
        }
    }
}

int main(void) {
    estimate_anything();
    serve_anything();
    return 0;
}
