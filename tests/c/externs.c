/**
 * \file externs.c
 * \brief The runtime's inline functions as a library has them, for tests through ctypes.
 */
#define ccgen_e2e_key inlined_e2e_key
#define ccgen_e2e_check inlined_e2e_check
#define ccgen_e2e_protect inlined_e2e_protect
#define ccgen_e2e_counter_modulus inlined_e2e_counter_modulus
#define ccgen_layout_valid inlined_layout_valid
#define ccgen_layout_window_max_us inlined_layout_window_max_us
#define ccgen_layout_publishes inlined_layout_publishes
#define ccgen_layout_kind inlined_layout_kind
#define ccgen_layout_frame_length inlined_layout_frame_length
#define ccgen_layout_begin inlined_layout_begin
#define ccgen_layout_protect inlined_layout_protect
#define ccgen_layout_check inlined_layout_check
#define ccgen_put16 inlined_put16
#define ccgen_put32 inlined_put32
#define ccgen_put_signed inlined_put_signed
#define ccgen_get_count inlined_get_count
#define ccgen_health_all_lost inlined_health_all_lost
#define ccgen_command_is inlined_command_is
#define ccgen_snapshot_init inlined_snapshot_init
#define ccgen_snapshot_set_window inlined_snapshot_set_window
#define ccgen_snapshot_receive inlined_snapshot_receive
#define ccgen_snapshot_tick inlined_snapshot_tick
#define ccgen_snapshot_age_ms inlined_snapshot_age_ms
#define ccgen_tip_signal inlined_tip_signal
#define ccgen_node_init inlined_node_init
#define ccgen_node_receive inlined_node_receive
#define ccgen_node_counts16 inlined_node_counts16
#define ccgen_node_counts32 inlined_node_counts32
#define ccgen_node_publish inlined_node_publish
#define ccgen_node_transmit16 inlined_node_transmit16
#define ccgen_node_transmit32 inlined_node_transmit32
#define ccgen_node_unsent inlined_node_unsent

#include "ccgen/command_inline.h"
#include "ccgen/node_inline.h"
#include "ccgen/tip.h"

#undef ccgen_e2e_key
#undef ccgen_e2e_check
#undef ccgen_e2e_protect
#undef ccgen_e2e_counter_modulus
#undef ccgen_layout_valid
#undef ccgen_layout_window_max_us
#undef ccgen_layout_publishes
#undef ccgen_layout_kind
#undef ccgen_layout_frame_length
#undef ccgen_layout_begin
#undef ccgen_layout_protect
#undef ccgen_layout_check
#undef ccgen_put16
#undef ccgen_put32
#undef ccgen_put_signed
#undef ccgen_get_count
#undef ccgen_health_all_lost
#undef ccgen_command_is
#undef ccgen_snapshot_init
#undef ccgen_snapshot_set_window
#undef ccgen_snapshot_receive
#undef ccgen_snapshot_tick
#undef ccgen_snapshot_age_ms
#undef ccgen_tip_signal
#undef ccgen_node_init
#undef ccgen_node_receive
#undef ccgen_node_counts16
#undef ccgen_node_counts32
#undef ccgen_node_publish
#undef ccgen_node_transmit16
#undef ccgen_node_transmit32
#undef ccgen_node_unsent

int16_t ccgen_tip_signal(int32_t position, uint8_t shift);
int16_t ccgen_tip_signal(const int32_t position, const uint8_t shift) {
    return inlined_tip_signal(position, shift);
}

uint16_t ccgen_e2e_key(ccgen_e2e_profile_t profile, uint16_t data_id);
uint16_t ccgen_e2e_key(const ccgen_e2e_profile_t profile, const uint16_t data_id) {
    return inlined_e2e_key(profile, data_id);
}

int ccgen_e2e_check(ccgen_e2e_profile_t profile, uint16_t key, const uint8_t *data, size_t length);
int ccgen_e2e_check(const ccgen_e2e_profile_t profile, const uint16_t key,
                    const uint8_t *const data, const size_t length) {
    return inlined_e2e_check(profile, key, data, length);
}

int ccgen_e2e_protect(ccgen_e2e_profile_t profile, uint16_t key, uint8_t counter, uint8_t *data,
                      size_t length);
int ccgen_e2e_protect(const ccgen_e2e_profile_t profile, const uint16_t key, const uint8_t counter,
                      uint8_t *const data, const size_t length) {
    return inlined_e2e_protect(profile, key, counter, data, length);
}

uint16_t ccgen_e2e_counter_modulus(ccgen_e2e_profile_t profile);
uint16_t ccgen_e2e_counter_modulus(const ccgen_e2e_profile_t profile) {
    return inlined_e2e_counter_modulus(profile);
}

bool ccgen_layout_valid(const ccgen_layout_t *layout);
bool ccgen_layout_valid(const ccgen_layout_t *const layout) {
    return inlined_layout_valid(layout);
}

uint32_t ccgen_layout_window_max_us(const ccgen_layout_t *layout);
uint32_t ccgen_layout_window_max_us(const ccgen_layout_t *const layout) {
    return inlined_layout_window_max_us(layout);
}

bool ccgen_layout_publishes(const ccgen_layout_t *layout, uint16_t index);
bool ccgen_layout_publishes(const ccgen_layout_t *const layout, const uint16_t index) {
    return inlined_layout_publishes(layout, index);
}

ccgen_frame_kind_t ccgen_layout_kind(const ccgen_layout_t *layout, const ccgen_frame_t *frame,
                                     uint16_t *slot);
ccgen_frame_kind_t ccgen_layout_kind(const ccgen_layout_t *const layout,
                                     const ccgen_frame_t *const frame, uint16_t *const slot) {
    return inlined_layout_kind(layout, frame, slot);
}

uint8_t ccgen_layout_frame_length(const ccgen_layout_t *layout, uint16_t index);
uint8_t ccgen_layout_frame_length(const ccgen_layout_t *const layout, const uint16_t index) {
    return inlined_layout_frame_length(layout, index);
}

void ccgen_layout_begin(const ccgen_layout_t *layout, uint16_t index, ccgen_frame_t *frame);
void ccgen_layout_begin(const ccgen_layout_t *const layout, const uint16_t index,
                        ccgen_frame_t *const frame) {
    inlined_layout_begin(layout, index, frame);
}

int ccgen_layout_protect(const ccgen_layout_t *layout, uint8_t number, ccgen_frame_t *frame);
int ccgen_layout_protect(const ccgen_layout_t *const layout, const uint8_t number,
                         ccgen_frame_t *const frame) {
    return inlined_layout_protect(layout, number, frame);
}

int ccgen_layout_check(const ccgen_layout_t *layout, const ccgen_frame_t *frame);
int ccgen_layout_check(const ccgen_layout_t *const layout, const ccgen_frame_t *const frame) {
    return inlined_layout_check(layout, frame);
}

void ccgen_put16(uint8_t *data, int16_t value);
void ccgen_put16(uint8_t *const data, const int16_t value) {
    inlined_put16(data, value);
}

void ccgen_put32(uint8_t *data, int32_t value);
void ccgen_put32(uint8_t *const data, const int32_t value) {
    inlined_put32(data, value);
}

void ccgen_put_signed(uint8_t *data, uint8_t bytes, int32_t value);
void ccgen_put_signed(uint8_t *const data, const uint8_t bytes, const int32_t value) {
    inlined_put_signed(data, bytes, value);
}

int32_t ccgen_get_count(const uint8_t *data, uint8_t bytes);
int32_t ccgen_get_count(const uint8_t *const data, const uint8_t bytes) {
    return inlined_get_count(data, bytes);
}

uint8_t ccgen_health_all_lost(const ccgen_layout_t *layout);
uint8_t ccgen_health_all_lost(const ccgen_layout_t *const layout) {
    return inlined_health_all_lost(layout);
}

bool ccgen_command_is(const ccgen_layout_t *layout, const ccgen_frame_t *frame);
bool ccgen_command_is(const ccgen_layout_t *const layout, const ccgen_frame_t *const frame) {
    return inlined_command_is(layout, frame);
}

int ccgen_snapshot_init(const ccgen_layout_t *layout, ccgen_snapshot_t *snapshot);
int ccgen_snapshot_init(const ccgen_layout_t *const layout, ccgen_snapshot_t *const snapshot) {
    return inlined_snapshot_init(layout, snapshot);
}

int ccgen_snapshot_set_window(ccgen_snapshot_t *snapshot, uint32_t window_us);
int ccgen_snapshot_set_window(ccgen_snapshot_t *const snapshot, const uint32_t window_us) {
    return inlined_snapshot_set_window(snapshot, window_us);
}

int ccgen_snapshot_receive(const ccgen_layout_t *layout, ccgen_snapshot_t *snapshot,
                           const ccgen_frame_t *frame, uint32_t now_us);
int ccgen_snapshot_receive(const ccgen_layout_t *const layout, ccgen_snapshot_t *const snapshot,
                           const ccgen_frame_t *const frame, const uint32_t now_us) {
    return inlined_snapshot_receive(layout, snapshot, frame, now_us);
}

int ccgen_snapshot_tick(const ccgen_layout_t *layout, ccgen_snapshot_t *snapshot, uint32_t now_us);
int ccgen_snapshot_tick(const ccgen_layout_t *const layout, ccgen_snapshot_t *const snapshot,
                        const uint32_t now_us) {
    return inlined_snapshot_tick(layout, snapshot, now_us);
}

uint8_t ccgen_snapshot_age_ms(const ccgen_snapshot_t *snapshot, uint32_t now_us);
uint8_t ccgen_snapshot_age_ms(const ccgen_snapshot_t *const snapshot, const uint32_t now_us) {
    return inlined_snapshot_age_ms(snapshot, now_us);
}

int ccgen_node_init(const ccgen_layout_t *layout, ccgen_node_t *node);
int ccgen_node_init(const ccgen_layout_t *const layout, ccgen_node_t *const node) {
    return inlined_node_init(layout, node);
}

int ccgen_node_receive(const ccgen_layout_t *layout, ccgen_node_t *node, const ccgen_frame_t *frame,
                       uint32_t now_us);
int ccgen_node_receive(const ccgen_layout_t *const layout, ccgen_node_t *const node,
                       const ccgen_frame_t *const frame, const uint32_t now_us) {
    return inlined_node_receive(layout, node, frame, now_us);
}

int ccgen_node_counts16(const ccgen_node_t *node, uint8_t first, uint8_t sensors, int16_t *counts);
int ccgen_node_counts16(const ccgen_node_t *const node, const uint8_t first, const uint8_t sensors,
                        int16_t *const counts) {
    return inlined_node_counts16(node, first, sensors, counts);
}

int ccgen_node_counts32(const ccgen_node_t *node, uint8_t first, uint8_t sensors, int32_t *counts);
int ccgen_node_counts32(const ccgen_node_t *const node, const uint8_t first, const uint8_t sensors,
                        int32_t *const counts) {
    return inlined_node_counts32(node, first, sensors, counts);
}

int ccgen_node_publish(const ccgen_layout_t *layout, ccgen_node_t *node, int result,
                       int32_t missing, const int16_t *tip);
int ccgen_node_publish(const ccgen_layout_t *const layout, ccgen_node_t *const node,
                       const int result, const int32_t missing, const int16_t *const tip) {
    return inlined_node_publish(layout, node, result, missing, tip);
}

int ccgen_node_transmit16(const ccgen_layout_t *layout, ccgen_node_t *node,
                          const int16_t *const angles[CCGEN_AXES_MAX], uint32_t now_us,
                          ccgen_frame_t *frame);
int ccgen_node_transmit16(const ccgen_layout_t *const layout, ccgen_node_t *const node,
                          const int16_t *const angles[CCGEN_AXES_MAX], const uint32_t now_us,
                          ccgen_frame_t *const frame) {
    return inlined_node_transmit16(layout, node, angles, now_us, frame);
}

int ccgen_node_transmit32(const ccgen_layout_t *layout, ccgen_node_t *node,
                          const int32_t *const angles[CCGEN_AXES_MAX], uint32_t now_us,
                          ccgen_frame_t *frame);
int ccgen_node_transmit32(const ccgen_layout_t *const layout, ccgen_node_t *const node,
                          const int32_t *const angles[CCGEN_AXES_MAX], const uint32_t now_us,
                          ccgen_frame_t *const frame) {
    return inlined_node_transmit32(layout, node, angles, now_us, frame);
}

int ccgen_node_unsent(ccgen_node_t *node);
int ccgen_node_unsent(ccgen_node_t *const node) {
    return inlined_node_unsent(node);
}
