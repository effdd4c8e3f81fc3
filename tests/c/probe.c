/**
 * \file probe.c
 * \brief Plain C access to the runtime's state for tests through ctypes.
 *
 * Includes the sample joint's source to reach its models.
 */
#include "ccgen/integer.h"
#include "ccgen/sending.h"
#include "ccgen/slcan.h"
#include "ccgen/snapshot.h"
#include "ccgen/tip.h"
#include "sample.c"
#include "sample_can.h"

const ccgen_axis16_t *probe_axis(int v);
const ccgen_sensors16_t *probe_sensors(int v);
size_t probe_size(int which);
void probe_snapshot(const ccgen_snapshot_t *snapshot, uint32_t counters[9]);
uint8_t probe_take_faults(ccgen_snapshot_t *snapshot);
const ccgen_layout_t *probe_sample_layout(void);
uint32_t probe_overruns(const ccgen_node_t *node);
uint8_t *probe_axes(ccgen_node_t *node);
int64_t probe_signed(int bits, uint64_t word);

const ccgen_axis16_t *probe_axis(const int v) {
    return (v != 0) ? &v_axis : &u_axis;
}

const ccgen_sensors16_t *probe_sensors(const int v) {
    return (v != 0) ? &v_sensors : &u_sensors;
}

size_t probe_size(const int which) {
    const size_t sizes[] = {sizeof(ccgen_frame_t), sizeof(ccgen_layout_t), sizeof(ccgen_axis16_t),
                            sizeof(ccgen_snapshot_t), sizeof(ccgen_slcan_t), sizeof(ccgen_node_t),
                            sizeof(ccgen_sending_t)};
    return sizes[which];
}

void probe_snapshot(const ccgen_snapshot_t *const snapshot, uint32_t counters[9]) {
    const uint32_t values[9] = {snapshot->snapshots, snapshot->corrupted, snapshot->malformed,
                                snapshot->repeated,  snapshot->reordered, snapshot->lost,
                                snapshot->late,      snapshot->number,   snapshot->faults};
    for (int i = 0; i < 9; ++i) {
        counters[i] = values[i];
    }
}

/** Clears the faults as a status frame does. */
uint8_t probe_take_faults(ccgen_snapshot_t *const snapshot) {
    const uint8_t faults = snapshot->faults;
    snapshot->faults = 0;
    snapshot->recent = 0;
    return faults;
}

const ccgen_layout_t *probe_sample_layout(void) {
    return &sample_layout;
}

uint32_t probe_overruns(const ccgen_node_t *const node) {
    return node->overruns;
}

uint8_t *probe_axes(ccgen_node_t *const node) {
    return &node->health.axes;
}

/** A word as a signed number of 16, 32 or 64 bits; 1 and 2: the lower and upper half of 32 bits. */
int64_t probe_signed(const int bits, const uint64_t word) {
    switch (bits) {
        case 1:
            return ccgen_low16((uint32_t)word);
        case 2:
            return ccgen_high16((uint32_t)word);
        case 16:
            return ccgen_signed16((uint16_t)word);
        case 32:
            return ccgen_signed32((uint32_t)word);
        default:
            return ccgen_signed64(word);
    }
}
