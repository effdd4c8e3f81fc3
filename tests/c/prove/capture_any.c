/**
 * \file capture_any.c
 * \brief Stands for ccgen/capture.c where a node is proven: a capture with any outcome, which is
 * begun before it is asked for, and not asked for any more once it has ended. capture.c proves the
 * capture itself.
 */
#include "capture_any.h"

#include "anything.h"
#include "ccgen/capture.h"

bool capture_goes_on = false;

void ccgen_capture_begin(const ccgen_layout_t *const layout,
                         const ccgen_capture_limits_t *const limits, ccgen_capture_t *const capture,
                         const ccgen_snapshot_t *const snapshot, const uint8_t snapshots) {
    (void)layout;
    (void)limits;
    (void)snapshot;
    //@ assert snapshots >= 1;
    Frama_C_make_unknown((char *)capture, sizeof *capture);
    capture_goes_on = true;
    //@ split capture_goes_on;
}

ccgen_result_t ccgen_capture_take(const ccgen_capture_limits_t *const limits,
                                  ccgen_capture_t *const capture,
                                  const ccgen_snapshot_t *const snapshot) {
    (void)snapshot;
    //@ assert capture_goes_on;
    capture_goes_on = either();
    //@ split capture_goes_on;
    if (capture_goes_on) {
        return CCGEN_RESULT_BUSY;
    }
    if (either()) {
        return CCGEN_RESULT_MOVING;
    }
    for (uint8_t j = 0; j < limits->sensors; ++j) {
        capture->zero[j] = (int32_t)Frama_C_long_interval(limits->minimum[j] - limits->still[j],
                                                          limits->maximum[j] + limits->still[j]);
    }
    return CCGEN_RESULT_DONE;
}

ccgen_result_t ccgen_capture_wait(const ccgen_capture_t *const capture, const uint32_t now_us) {
    (void)capture;
    (void)now_us;
    //@ assert capture_goes_on;
    capture_goes_on = either();
    //@ split capture_goes_on;
    return capture_goes_on ? CCGEN_RESULT_BUSY : CCGEN_RESULT_SILENCE;
}
