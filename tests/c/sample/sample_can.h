/**
 * \file sample_can.h
 * \brief The sample joint's node on the bus.
 */
#ifndef SAMPLE_CAN_H
#define SAMPLE_CAN_H

#include "ccgen/node.h"
#include "sample.h"
#include "sample_kinematics.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SAMPLE_TIP_FRACTION_BITS 16
#define SAMPLE_CYCLE_US 10000u
#define SAMPLE_WINDOW_MAX_US 1000000u

/** Compile with SAMPLE_FD 1 for the same joint on CAN FD. */
#if !defined(SAMPLE_FD)
#define SAMPLE_FD 0
#endif

typedef struct {
    sample_t joint;
    sample_angles_t angles;
    ccgen_node_t node;
} sample_node_t;

extern const ccgen_layout_t sample_layout;

int sample_node_init(sample_node_t *node);
int sample_node_receive(sample_node_t *node, const ccgen_frame_t *frame, uint32_t now_us);
int sample_node_transmit(sample_node_t *node, uint32_t now_us, ccgen_frame_t *frame);
int sample_node_unsent(sample_node_t *node);
int sample_node_set_window(sample_node_t *node, uint32_t window_us);

#ifdef __cplusplus
}
#endif

#endif /* SAMPLE_CAN_H */
