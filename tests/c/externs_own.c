/**
 * \file externs_own.c
 * \brief Inline functions of boards with a converter of their own, as externs.c has the others.
 */
#define ccgen_put_counts16 inlined_put_counts16
#define ccgen_put_counts32 inlined_put_counts32
#define ccgen_snapshot_own inlined_snapshot_own
#define ccgen_snapshot_is_stale inlined_snapshot_is_stale
#define ccgen_node_own inlined_node_own
#define ccgen_node_worth inlined_node_worth
#define ccgen_node_forgets inlined_node_forgets
#define ccgen_sending_init inlined_sending_init
#define ccgen_sending_resume inlined_sending_resume
#define ccgen_sending_set_window inlined_sending_set_window
#define ccgen_sending_begin inlined_sending_begin
#define ccgen_sending_transmit inlined_sending_transmit
#define ccgen_sending_unsent inlined_sending_unsent

#include "ccgen/node_inline.h"
#include "ccgen/sending_inline.h"

#undef ccgen_put_counts16
#undef ccgen_put_counts32
#undef ccgen_snapshot_own
#undef ccgen_snapshot_is_stale
#undef ccgen_node_own
#undef ccgen_node_worth
#undef ccgen_node_forgets
#undef ccgen_sending_init
#undef ccgen_sending_resume
#undef ccgen_sending_set_window
#undef ccgen_sending_begin
#undef ccgen_sending_transmit
#undef ccgen_sending_unsent

int ccgen_put_counts16(int32_t *all, uint8_t first, uint8_t sensors, const int16_t *counts);
int ccgen_put_counts16(int32_t *const all, uint8_t const first, uint8_t const sensors, const int16_t *const counts) {
    return inlined_put_counts16(all, first, sensors, counts);
}

int ccgen_put_counts32(int32_t *all, uint8_t first, uint8_t sensors, const int32_t *counts);
int ccgen_put_counts32(int32_t *const all, uint8_t const first, uint8_t const sensors, const int32_t *const counts) {
    return inlined_put_counts32(all, first, sensors, counts);
}

int ccgen_snapshot_own(const ccgen_layout_t *layout, ccgen_snapshot_t *snapshot, uint32_t now_us);
int ccgen_snapshot_own(const ccgen_layout_t *const layout, ccgen_snapshot_t *const snapshot, uint32_t const now_us) {
    return inlined_snapshot_own(layout, snapshot, now_us);
}

bool ccgen_snapshot_is_stale(const ccgen_snapshot_t *snapshot, uint32_t now_us);
bool ccgen_snapshot_is_stale(const ccgen_snapshot_t *const snapshot, uint32_t const now_us) {
    return inlined_snapshot_is_stale(snapshot, now_us);
}

int ccgen_node_own(const ccgen_layout_t *layout, ccgen_node_t *node, uint32_t now_us);
int ccgen_node_own(const ccgen_layout_t *const layout, ccgen_node_t *const node, uint32_t const now_us) {
    return inlined_node_own(layout, node, now_us);
}

int ccgen_node_worth(const ccgen_node_t *node, uint32_t now_us);
int ccgen_node_worth(const ccgen_node_t *const node, uint32_t const now_us) {
    return inlined_node_worth(node, now_us);
}

bool ccgen_node_forgets(const ccgen_layout_t *layout, ccgen_node_t *node);
bool ccgen_node_forgets(const ccgen_layout_t *const layout, ccgen_node_t *const node) {
    return inlined_node_forgets(layout, node);
}

int ccgen_sending_init(const ccgen_layout_t *layout, ccgen_sending_t *sending);
int ccgen_sending_init(const ccgen_layout_t *const layout, ccgen_sending_t *const sending) {
    return inlined_sending_init(layout, sending);
}

int ccgen_sending_resume(const ccgen_layout_t *layout, ccgen_sending_t *sending, uint8_t number);
int ccgen_sending_resume(const ccgen_layout_t *const layout, ccgen_sending_t *const sending, uint8_t const number) {
    return inlined_sending_resume(layout, sending, number);
}

int ccgen_sending_set_window(ccgen_sending_t *sending, uint32_t window_us);
int ccgen_sending_set_window(ccgen_sending_t *const sending, uint32_t const window_us) {
    return inlined_sending_set_window(sending, window_us);
}

int ccgen_sending_begin(const ccgen_layout_t *layout, ccgen_sending_t *sending, uint32_t now_us);
int ccgen_sending_begin(const ccgen_layout_t *const layout, ccgen_sending_t *const sending, uint32_t const now_us) {
    return inlined_sending_begin(layout, sending, now_us);
}

int ccgen_sending_transmit(const ccgen_layout_t *layout, ccgen_sending_t *sending, ccgen_frame_t *frame);
int ccgen_sending_transmit(const ccgen_layout_t *const layout, ccgen_sending_t *const sending, ccgen_frame_t *const frame) {
    return inlined_sending_transmit(layout, sending, frame);
}

int ccgen_sending_unsent(ccgen_sending_t *sending);
int ccgen_sending_unsent(ccgen_sending_t *const sending) {
    return inlined_sending_unsent(sending);
}
