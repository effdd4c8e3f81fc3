/**
 * \file traffic.h
 * \brief LENGTHS frames of a sender over a bus that loses, repeats, reorders, delays and harms
 * them.
 *
 * Every sending has counts of its own in every frame, so that an observer can tell sendings apart
 * without looking at their numbers. The sender may fall silent for many cycles and start anew at
 * any frame: as the contract of snapshot.h asks, or with any number at once.
 *
 * Draws come from the caller, as traffic_draw(); a fuzzer takes them from its input.
 */
#ifndef TRAFFIC_H
#define TRAFFIC_H

#include <string.h>

#include "reference.h"

#define TRAFFIC_TRANSIT 4096   /* frames under way */
#define TRAFFIC_SENDINGS 1024u /* remembered */
#define TRAFFIC_PLACES 16
#define TRAFFIC_WHOLE 65536u /* shares are in parts of this */
#define TRAFFIC_BITS 3u      /* most bits that are flipped */
#define TRAFFIC_LAG_US 64u   /* stamps may lag behind by less than this */

/** What happens, and how often. */
typedef struct {
    uint32_t drop; /* frames */
    uint32_t duplicate;
    uint32_t reorder; /* late by up to a cycle */
    uint32_t delay;   /* late by up to delay_cycles */
    uint32_t truncate;
    uint32_t corrupt;
    uint32_t outage;  /* sendings that begin one */
    uint32_t restart; /* sendings in which the sender starts anew */
    uint32_t delay_cycles;
    uint32_t outage_cycles;
    bool any_number; /* it starts anew with any number and without a silence */
} traffic_mix_t;

typedef struct {
    uint32_t id; /* 0: none */
    int number;
    bool whole; /* every frame is sent once, on time and unharmed */
    bool new_life;
    int32_t counts[SENSORS];
    uint64_t at_us[TRAFFIC_PLACES]; /* when its frame of a place arrived last, unharmed */
} traffic_sending_t;

/** A frame under way. */
typedef struct {
    uint64_t at_us;
    uint32_t id;
    uint8_t place;
    bool truncated;
    bool stray; /* a copy, or late */
    uint8_t flips;
    uint16_t bits[TRAFFIC_BITS];
} transit_t;

typedef struct {
    traffic_mix_t mix;
    uint64_t window_us;
    uint64_t next_us; /* of the next sending */
    int number;       /* of it */
    uint32_t id;      /* of the latest sending */
    uint32_t outage;  /* cycles of it left */
    bool starts_anew;
    int ahead;           /* how far numbers ran ahead of the cycles since... */
    uint64_t counted_us; /* ...this time */
    int count;           /* of frames under way: a heap by time */
    transit_t transit[TRAFFIC_TRANSIT];
    traffic_sending_t sendings[TRAFFIC_SENDINGS];
} traffic_t;

/** \return a number from 0 to `below` - 1. */
static uint32_t traffic_draw(uint32_t below);

static inline bool traffic_happens(const uint32_t share) {
    return (share > 0u) && (traffic_draw(TRAFFIC_WHOLE) < share);
}

static inline void traffic_start(traffic_t *const traffic, const traffic_mix_t *const mix,
                                 const uint64_t window_us, const uint64_t now_us) {
    memset(traffic, 0, sizeof *traffic);
    traffic->mix = *mix;
    traffic->window_us = window_us;
    traffic->next_us = now_us;
    traffic->counted_us = now_us;
    traffic->number = (int)traffic_draw((uint32_t)numbers_of_joint());
}

static inline traffic_sending_t *traffic_sending(traffic_t *const traffic, const uint32_t id) {
    return &traffic->sendings[id % TRAFFIC_SENDINGS];
}

static inline void traffic_swap(transit_t *const a, transit_t *const b) {
    const transit_t c = *a;
    *a = *b;
    *b = c;
}

static inline void traffic_push(traffic_t *const traffic, const transit_t *const frame) {
    transit_t *const heap = traffic->transit;
    int k = traffic->count;
    CHECK(k < TRAFFIC_TRANSIT);
    heap[k] = *frame;
    ++traffic->count;
    while ((k > 0) && (heap[k].at_us < heap[(k - 1) / 2].at_us)) {
        traffic_swap(&heap[k], &heap[(k - 1) / 2]);
        k = (k - 1) / 2;
    }
}

static inline transit_t traffic_pop(traffic_t *const traffic) {
    transit_t *const heap = traffic->transit;
    const transit_t first = heap[0];
    int k = 0;
    --traffic->count;
    heap[0] = heap[traffic->count];
    for (;;) {
        int least = k;
        for (int child = 2 * k + 1; child <= (2 * k + 2); ++child) {
            if ((child < traffic->count) && (heap[child].at_us < heap[least].at_us)) {
                least = child;
            }
        }
        if (least == k) {
            return first;
        }
        traffic_swap(&heap[k], &heap[least]);
        k = least;
    }
}

/** Chooses different bits of a frame. */
static inline void traffic_choose_bits(transit_t *const frame) {
    const uint32_t bits = 8u * ccgen_layout_frame_length(layout, frame->place);
    const uint32_t first = traffic_draw(bits);
    const uint32_t second = traffic_draw(bits - 1u);
    const uint32_t third = traffic_draw(bits - 2u);
    frame->bits[0] = (uint16_t)first;
    frame->bits[1] = (uint16_t)((first + 1u + second) % bits);
    frame->bits[2] = (uint16_t)((first + 1u + third) % bits);
    if (third >= second) {
        frame->bits[2] = (uint16_t)((first + 2u + third) % bits);
    }
}

/** Sends one frame of a sending, or what becomes of it. \return whether it came through whole. */
static inline bool traffic_frame(traffic_t *const traffic, const uint8_t place,
                                 const uint64_t at_us) {
    const traffic_mix_t *const mix = &traffic->mix;
    const uint32_t cycle_us = layout->cycle_us;
    transit_t frame = {at_us, traffic->id, place, false, false, 0, {0}};
    if (traffic_happens(mix->drop)) {
        return false;
    }
    if (traffic_happens(mix->reorder)) {
        frame.at_us += 1u + traffic_draw(cycle_us);
        frame.stray = true;
    } else if (traffic_happens(mix->delay)) {
        frame.at_us += cycle_us + (uint64_t)traffic_draw(1000u * (mix->delay_cycles - 1u)) *
                                      (cycle_us / 1000u);
        frame.stray = true;
    }
    frame.truncated = traffic_happens(mix->truncate);
    if (traffic_happens(mix->corrupt)) {
        frame.flips = (uint8_t)(1u + traffic_draw(TRAFFIC_BITS));
        traffic_choose_bits(&frame);
    }
    traffic_push(traffic, &frame);
    if (traffic_happens(mix->duplicate)) {
        transit_t copy = {at_us, traffic->id, place, false, true, 0, {0}};
        copy.at_us += 1u + traffic_draw(1000u * mix->delay_cycles) * (uint64_t)(cycle_us / 1000u) /
                               ((traffic_draw(2) == 0u) ? 1u : 40u);
        traffic_push(traffic, &copy);
        return false;
    }
    return !frame.stray && !frame.truncated && (frame.flips == 0u);
}

/** A sending with counts of its own, in range. */
static inline traffic_sending_t *traffic_new_sending(traffic_t *const traffic) {
    ++traffic->id;
    traffic_sending_t *const sending = traffic_sending(traffic, traffic->id);
    memset(sending, 0, sizeof *sending);
    sending->id = traffic->id;
    sending->number = traffic->number;
    sending->new_life = traffic->starts_anew;
    for (uint8_t j = 0; j < SENSORS; ++j) {
        const reference_sensor_t *const sensor = &reference_sensors[j];
        const uint64_t values = (uint64_t)(sensor->maximum - sensor->minimum) + 1u;
        uint64_t x = (uint64_t)traffic->id * UINT64_C(0x9E3779B97F4A7C15) +
                     (uint64_t)(j + 1u) * UINT64_C(0xD1B54A32D192ED03);
        x = (x ^ (x >> 31)) * UINT64_C(0xBF58476D1CE4E5B9);
        sending->counts[j] = (int32_t)(sensor->minimum + (int64_t)((x >> 16) % values));
    }
    traffic->starts_anew = false;
    return sending;
}

/** The latest time at which a frame that is under way arrives. */
static inline uint64_t traffic_last_us(const traffic_t *const traffic) {
    uint64_t last_us = 0;
    for (int k = 0; k < traffic->count; ++k) {
        last_us = (traffic->transit[k].at_us > last_us) ? traffic->transit[k].at_us : last_us;
    }
    return last_us;
}

/** Keeps silent for a window after the last frame; then any number will do. */
static inline void traffic_fall_silent(traffic_t *const traffic, const uint64_t now_us) {
    const int count = (traffic_draw(2) == 0u) ? traffic->count : 0;
    traffic->count -= count;
    for (int k = 0; k < count; ++k) { /* what waited in the sender is gone with it */
        const transit_t frame = traffic->transit[k];
        if (frame.at_us <= now_us) {
            traffic_push(traffic, &frame);
        }
    }
    const uint64_t last_us = traffic_last_us(traffic);
    traffic->next_us = ((last_us > now_us) ? last_us : now_us) + traffic->window_us +
                       TRAFFIC_LAG_US + 1u + traffic_draw(2u * layout->cycle_us);
    traffic->number = (int)traffic_draw((uint32_t)numbers_of_joint());
    traffic->ahead = 0;
    traffic->counted_us = traffic->next_us;
}

/** Goes on at once with a number that the bus has not just seen. */
static inline void traffic_skip(traffic_t *const traffic, const uint64_t now_us) {
    const int numbers = numbers_of_joint();
    const int seen = (numbers + 1) / 2 + ((numbers == 15) ? 6 : 100);
    const uint64_t seen_us = (uint64_t)seen * layout->cycle_us;
    const int skipped = 1 + (int)traffic_draw((uint32_t)(numbers - seen));
    if ((now_us - traffic->counted_us) > seen_us) {
        traffic->counted_us = now_us;
        traffic->ahead = 0;
    }
    if ((traffic->ahead + skipped) > ((numbers - seen) / 2)) {
        traffic_fall_silent(traffic, now_us);
        return;
    }
    traffic->ahead += skipped;
    traffic->number = (traffic->number + skipped) % numbers;
    traffic->next_us = now_us + layout->cycle_us + traffic_draw(layout->cycle_us);
}

/** The sender has gone before its frame of some place. */
static inline void traffic_restart(traffic_t *const traffic, const uint64_t now_us) {
    traffic->starts_anew = true;
    if (traffic->mix.any_number) {
        traffic->number = (int)traffic_draw((uint32_t)numbers_of_joint());
        traffic->next_us = now_us + 1u + traffic_draw(layout->cycle_us);
    } else if (traffic_draw(2) == 0u) {
        traffic_fall_silent(traffic, now_us);
    } else {
        traffic_skip(traffic, now_us);
    }
}

/** One sending, at next_us: its frames go under way. */
static inline traffic_sending_t *traffic_send(traffic_t *const traffic) {
    const traffic_mix_t *const mix = &traffic->mix;
    const uint8_t places = layout->lengths_frames;
    const uint32_t gap_us = layout->cycle_us / 40u;
    const uint64_t begin_us = traffic->next_us + traffic_draw(layout->cycle_us / 10u);
    const bool restarts = traffic_happens(mix->restart);
    const uint8_t sent = restarts ? (uint8_t)traffic_draw(places + 1u) : places;
    traffic_sending_t *const sending = traffic_new_sending(traffic);
    if ((traffic->outage == 0u) && traffic_happens(mix->outage)) {
        traffic->outage = 1u + traffic_draw(mix->outage_cycles);
    }
    sending->whole = !restarts && (traffic->outage == 0u);
    for (uint8_t place = 0; (place < sent) && (traffic->outage == 0u); ++place) {
        const uint64_t at_us = begin_us + (uint64_t)place * gap_us + traffic_draw(gap_us);
        sending->whole = traffic_frame(traffic, place, at_us) && sending->whole;
    }
    traffic->outage -= (traffic->outage > 0u) ? 1u : 0u;
    if (restarts) {
        traffic_restart(traffic, begin_us + (uint64_t)sent * gap_us);
    } else {
        traffic->next_us += layout->cycle_us;
        traffic->number = (traffic->number + 1) % numbers_of_joint();
    }
    return sending;
}

/** The frame as it arrives. */
static inline void traffic_arrive(traffic_t *const traffic, const transit_t *const transit,
                                  ccgen_frame_t *const frame) {
    const traffic_sending_t *const sending = traffic_sending(traffic, transit->id);
    CHECK(sending->id == transit->id);
    make_lengths(sending->counts, transit->place, sending->number, frame);
    for (uint8_t k = 0; k < transit->flips; ++k) {
        frame->data[transit->bits[k] / 8u] ^= (uint8_t)(1u << (transit->bits[k] % 8u));
    }
    if (transit->truncated) {
        frame->length = (uint8_t)(frame->length - 1u);
    }
}

/** \return the sending whose counts these are, however long ago; 0 if they are none's. */
static inline uint32_t traffic_sending_of(traffic_t *const traffic, const int32_t *const counts) {
    for (uint32_t back = 0; (back < TRAFFIC_SENDINGS) && (back < traffic->id); ++back) {
        const traffic_sending_t *const sending = traffic_sending(traffic, traffic->id - back);
        if (memcmp(sending->counts, counts, sizeof sending->counts) == 0) {
            return sending->id;
        }
    }
    return 0;
}

#endif /* TRAFFIC_H */
