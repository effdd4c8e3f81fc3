/**
 * \file sending_inline.h
 * \brief What sending.h describes, inline: where a joint's layout is known, it folds into code.
 */
#ifndef CCGEN_SENDING_INLINE_H
#define CCGEN_SENDING_INLINE_H

#include "ccgen/layout_inline.h"
#include "ccgen/sending.h"
#include "ccgen/snapshot.h"

/**
 * Sets the state to: nothing sent, silence before the first sending.
 * \param[in] layout
 * \param[out] sending
 * \return CCGEN_OK, or CCGEN_ERROR_ARGUMENT for a null pointer or an invalid layout
 */
static inline int ccgen_sending_init(const ccgen_layout_t *const layout,
                                     ccgen_sending_t *const sending) {
    if ((sending == NULL) || !ccgen_layout_valid(layout)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    for (uint8_t j = 0; j < CCGEN_SENSORS_MAX; ++j) {
        sending->counts[j] = INT32_MIN;
    }
    sending->sendings = 0;
    sending->overruns = 0;
    sending->number = (uint8_t)(layout->numbers - 1u);
    sending->window_us = layout->window_us;
    sending->window_max_us = ccgen_layout_window_max_us(layout);
    sending->now_us = 0;
    sending->begun_us = 0;
    sending->ahead_us = 0;
    sending->next = layout->lengths_frames;
    sending->handed = false;
    sending->started = false;
    sending->silent = true;
    return CCGEN_OK;
}

/**
 * Goes on from a number that was kept over a restart, without the silence.
 * \param[in] layout
 * \param[in,out] sending
 * \param[in] number  of the last sending, below `numbers` of the layout
 * \return CCGEN_OK; CCGEN_ERROR_ARGUMENT for a null pointer or another number, which is not taken
 */
static inline int ccgen_sending_resume(const ccgen_layout_t *const layout,
                                       ccgen_sending_t *const sending, const uint8_t number) {
    if ((layout == NULL) || (sending == NULL) || (number >= layout->numbers)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    sending->number = number;
    sending->silent = false;
    return CCGEN_OK;
}

/**
 * Replaces the window of the layout, which is how long a start is silent: that of the node.
 * \param[in,out] sending
 * \param[in] window_us  1 to ccgen_layout_window_max_us()
 * \return CCGEN_OK; CCGEN_ERROR_ARGUMENT for a null pointer or another window, which is not taken
 */
static inline int ccgen_sending_set_window(ccgen_sending_t *const sending,
                                           const uint32_t window_us) {
    if ((sending == NULL) || (window_us == 0u) || (window_us > sending->window_max_us)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    sending->window_us = window_us;
    return CCGEN_OK;
}

/** Takes note of the time. \return whether it is the first. */
static inline bool ccgen_sending_tick(ccgen_sending_t *const sending, const uint32_t now_us) {
    const bool first = !sending->started;
    if (first || ((now_us - sending->now_us) < CCGEN_BEHIND_US)) {
        sending->now_us = now_us;
    }
    sending->started = true;
    return first;
}

/** \return whether a sending is due, and how far it is then ahead of the cycles. */
static inline bool ccgen_sending_is_due(const ccgen_layout_t *const layout,
                                        const ccgen_sending_t *const sending,
                                        uint32_t *const ahead_us) {
    const uint32_t since_us = sending->now_us - sending->begun_us;
    const uint32_t wait_us = layout->cycle_us + sending->ahead_us;
    *ahead_us = (since_us < wait_us) ? (wait_us - since_us) : 0u;
    return *ahead_us <= (layout->cycle_us / 2u);
}

/**
 * Begins a sending, if one is due. What was not fetched of the one before is dropped and counted.
 * \param[in] layout
 * \param[in,out] sending
 * \param[in] now_us
 * \return 1: put all counts, then fetch its frames; 0: none is due, nothing has changed;
 *         CCGEN_ERROR_ARGUMENT for a null pointer
 */
static inline int ccgen_sending_begin(const ccgen_layout_t *const layout,
                                      ccgen_sending_t *const sending, const uint32_t now_us) {
    uint32_t ahead_us = 0;
    if ((layout == NULL) || (sending == NULL)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    if (ccgen_sending_tick(sending, now_us)) {
        sending->begun_us = now_us;
        if (sending->silent) {
            return 0;
        }
    } else if (sending->silent) {
        if ((sending->now_us - sending->begun_us) <= sending->window_us) {
            return 0;
        }
    } else if (!ccgen_sending_is_due(layout, sending, &ahead_us)) {
        return 0;
    } else {
        /* it is time */
    }
    sending->silent = false;
    sending->begun_us = sending->now_us;
    sending->ahead_us = ahead_us;
    const uint16_t number = (uint16_t)(sending->number + 1u);
    sending->number = (uint8_t)((number < layout->numbers) ? number : 0u);
    sending->sendings += 1u;
    sending->overruns += (sending->next < layout->lengths_frames) ? 1u : 0u;
    sending->next = 0;
    sending->handed = false;
    return 1;
}

/** \return a count as a signal of so many bytes; what does not fit is no reading. */
static inline int32_t ccgen_sending_signal(const int32_t count, const uint8_t bytes) {
    const int32_t narrow = (bytes == 2u) ? (int32_t)INT16_MIN : -INT32_C(0x800000);
    const int32_t none = (bytes == 4u) ? INT32_MIN : narrow; /* MISRA 10.3 */
    return ((count <= none) || (count > -(none + 1))) ? none : count;
}

/**
 * Fetches the next LENGTHS frame; the one before counts as sent by then. A count that the frame's
 * signal does not hold goes out as "no reading".
 * \param[in] layout
 * \param[in,out] sending
 * \param[out] frame  to send; written only with result 1
 * \return 1: send `frame` and call again; 0: nothing is due; CCGEN_ERROR_ARGUMENT for a null pointer
 */
static inline int ccgen_sending_transmit(const ccgen_layout_t *const layout,
                                         ccgen_sending_t *const sending,
                                         ccgen_frame_t *const frame) {
    if ((layout == NULL) || (sending == NULL) || (frame == NULL)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    sending->handed = false;
    if (sending->next >= layout->lengths_frames) {
        return 0;
    }
    const uint8_t first = (uint8_t)(sending->next * layout->counts_per_frame);
    const uint8_t left = (uint8_t)(layout->sensors - first);
    const uint8_t counts = (left < layout->counts_per_frame) ? left : layout->counts_per_frame;
    uint8_t *signal = ccgen_layout_open(layout, sending->next, frame);
    for (uint8_t i = 0; i < counts; ++i) {
        ccgen_put_signed(signal, layout->count_bytes,
                         ccgen_sending_signal(sending->counts[first + i], layout->count_bytes));
        signal += layout->count_bytes;
    }
    (void)ccgen_layout_close(layout, sending->number, (uint8_t)(counts * layout->count_bytes),
                             frame);
    sending->next = (uint8_t)(sending->next + 1u);
    sending->handed = true;
    return 1;
}

/**
 * Takes back the frame that was fetched last, for it could not be sent: it comes again.
 * \param[in,out] sending
 * \return 1: it comes again; 0: there is none, or a newer sending has replaced it;
 *         CCGEN_ERROR_ARGUMENT for a null pointer
 */
static inline int ccgen_sending_unsent(ccgen_sending_t *const sending) {
    if (sending == NULL) {
        return CCGEN_ERROR_ARGUMENT;
    }
    const bool handed = sending->handed;
    sending->handed = false;
    sending->next = (uint8_t)(sending->next - (handed ? 1u : 0u));
    return handed ? 1 : 0;
}

#endif /* CCGEN_SENDING_INLINE_H */
