/**
 * \file capture.c
 * \brief Proof driver: a joint's capture meets any snapshots without a fault, from its beginning to
 * its end.
 *
 * A capture that goes on wants more snapshots than it has taken; no sum is farther from 0 than so
 * many times what a reading at rest may stray; and it began within the ranges. Whatever number it
 * has taken, it keeps this, with one more, or has ended.
 */
#include CAN_SOURCE

#include "anything.h"

int main(void);

/** Any snapshot; its flags are true or false, as C wants them. */
static void any_snapshot(ccgen_snapshot_t *const snapshot) {
    Frama_C_make_unknown((char *)snapshot, sizeof *snapshot);
    snapshot->stale = either();
}

/** Any capture that goes on and has taken so many snapshots. */
static void any_capture(ccgen_capture_t *const capture, const uint8_t taken) {
    Frama_C_make_unknown((char *)capture, sizeof *capture);
    capture->wanted = (uint8_t)Frama_C_interval(taken + 1, UINT8_MAX);
    capture->taken = taken;
    capture->began = either();
    for (uint8_t j = 0; j < capture_limits.sensors; ++j) {
        const int32_t strayed = (int32_t)taken * capture_still[j];
        capture->sum[j] = (int32_t)Frama_C_long_interval(-strayed, strayed);
        capture->zero[j] = (int32_t)Frama_C_long_interval(capture_minimum[j], capture_maximum[j]);
    }
}

/** Uses a capture that goes on, and shows that it is as it was taken for granted. */
static void hold(const ccgen_capture_t *const capture, const uint8_t taken) {
    uint32_t now_us;
    Frama_C_make_unknown((char *)&now_us, sizeof now_us);
    (void)ccgen_capture_wait(capture, now_us);
    //@ assert capture->taken == taken;
    //@ assert capture->wanted > taken;
    for (uint8_t j = 0; j < capture_limits.sensors; ++j) {
        const int32_t strayed = (int32_t)taken * capture_still[j];
        //@ assert -strayed <= capture->sum[j] <= strayed;
        if (capture->began) {
            //@ assert capture_minimum[j] <= capture->zero[j] <= capture_maximum[j];
        }
    }
}

/** Shows that the zero of a capture that is done is no farther off than capture_any.c has it. */
static void end(const ccgen_capture_t *const capture) {
    for (uint8_t j = 0; j < capture_limits.sensors; ++j) {
        //@ assert capture->zero[j] >= capture_minimum[j] - capture_still[j];
        //@ assert capture->zero[j] <= capture_maximum[j] + capture_still[j];
    }
}

static void begin_anything(void) {
    ccgen_capture_t capture;
    ccgen_snapshot_t snapshot;
    any_snapshot(&snapshot);
    const uint8_t wanted = (uint8_t)Frama_C_interval(1, UINT8_MAX);
    ccgen_capture_begin(&LAYOUT, &capture_limits, &capture, &snapshot, wanted);
    hold(&capture, 0);
}

/** Takes any snapshot into any capture that has taken so many. */
static void take_behind(const uint8_t taken) {
    ccgen_capture_t capture;
    ccgen_snapshot_t snapshot;
    any_snapshot(&snapshot);
    any_capture(&capture, taken);
    switch (ccgen_capture_take(&capture_limits, &capture, &snapshot)) {
        case CCGEN_RESULT_BUSY:
            hold(&capture, (capture.taken == taken) ? taken : (uint8_t)(taken + 1));
            break;
        case CCGEN_RESULT_DONE:
            end(&capture);
            break;
        default:
            break;
    }
}

int main(void) {
    begin_anything();
    //@ loop unroll 255;
    for (uint8_t taken = 0; taken < UINT8_MAX; ++taken) {
        take_behind(taken);
    }
    return 0;
}
