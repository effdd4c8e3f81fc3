#include "ccgen/capture.h"

#include "ccgen/flash.h"

#define CYCLES 3u

static bool is_whole(const ccgen_capture_limits_t *const limits, const int32_t *const counts) {
    for (uint8_t j = 0; j < limits->sensors; ++j) {
        if ((counts[j] < CCGEN_FLASH_INT32(&limits->minimum[j])) ||
            (counts[j] > CCGEN_FLASH_INT32(&limits->maximum[j]))) {
            return false;
        }
    }
    return true;
}

static void begin_at(const ccgen_capture_limits_t *const limits, ccgen_capture_t *const capture,
                     const int32_t *const counts) {
    for (uint8_t j = 0; j < limits->sensors; ++j) {
        capture->zero[j] = counts[j];
    }
    capture->began = true;
}

void ccgen_capture_begin(const ccgen_layout_t *const layout,
                         const ccgen_capture_limits_t *const limits, ccgen_capture_t *const capture,
                         const ccgen_snapshot_t *const snapshot, const uint8_t snapshots) {
    const uint32_t cycles_us = CYCLES * layout->cycle_us;
    for (uint8_t j = 0; j < limits->sensors; ++j) {
        capture->sum[j] = 0;
    }
    capture->heard_us = snapshot->now_us;
    capture->patience_us = (cycles_us > CCGEN_CAPTURE_US) ? cycles_us : CCGEN_CAPTURE_US;
    capture->wanted = snapshots;
    capture->taken = 0;
    capture->began = false;
    if ((snapshot->snapshots > 0u) && !snapshot->stale && is_whole(limits, snapshot->counts)) {
        begin_at(limits, capture, snapshot->counts);
    }
}

/** Adds a snapshot. \return false where some sensor has strayed too far. */
static bool add(const ccgen_capture_limits_t *const limits, ccgen_capture_t *const capture,
                const int32_t *const counts) {
    for (uint8_t j = 0; j < limits->sensors; ++j) {
        const uint32_t count = (uint32_t)counts[j];
        const uint32_t zero = (uint32_t)capture->zero[j];
        const bool is_above = counts[j] >= capture->zero[j];
        const uint32_t away = is_above ? (count - zero) : (zero - count);
        if (away > (uint32_t)CCGEN_FLASH_INT32(&limits->still[j])) {
            return false;
        }
        capture->sum[j] += is_above ? (int32_t)away : -(int32_t)away; /* MISRA 10.8 */
    }
    return true;
}

/** \return sum / number to the nearest, halves away from 0. */
static int32_t mean(const int32_t sum, const uint8_t number) {
    const int32_t half = (int32_t)(number / 2u); /* MISRA 10.8 */
    return (sum >= 0) ? ((sum + half) / number) : -((half - sum) / number); /* MISRA 10.4 */
}

ccgen_result_t ccgen_capture_take(const ccgen_capture_limits_t *const limits,
                                  ccgen_capture_t *const capture,
                                  const ccgen_snapshot_t *const snapshot) {
    if (!is_whole(limits, snapshot->counts)) {
        return CCGEN_RESULT_BUSY;
    }
    if (!capture->began) {
        begin_at(limits, capture, snapshot->counts);
    }
    if (!add(limits, capture, snapshot->counts)) {
        return CCGEN_RESULT_MOVING;
    }
    capture->heard_us = snapshot->now_us;
    capture->taken = (uint8_t)(capture->taken + 1u);
    if (capture->taken < capture->wanted) {
        return CCGEN_RESULT_BUSY;
    }
    for (uint8_t j = 0; j < limits->sensors; ++j) {
        capture->zero[j] += mean(capture->sum[j], capture->wanted);
    }
    return CCGEN_RESULT_DONE;
}

ccgen_result_t ccgen_capture_wait(const ccgen_capture_t *const capture, const uint32_t now_us) {
    return ((now_us - capture->heard_us) > capture->patience_us) ? CCGEN_RESULT_SILENCE
                                                                 : CCGEN_RESULT_BUSY;
}
