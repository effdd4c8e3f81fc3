/**
 * \file loop.c
 * \brief A sensor board and a node in one program, beside a chip with its own converter.
 *
 * Compiled with an exported joint: -include NAME_can.h "-DOF(name)=NAME_##name"
 * -DOF_CYCLE_US=NAME_CYCLE_US. The board's LENGTHS
 * frames go to the node; the chip takes the same readings directly. Both answer with the same
 * frames, bit for bit, and their angles are those of the estimator. Frames that cannot be sent come
 * again; the clock wraps on the way.
 */
#include <string.h>

#include "must.h"

#define SNAPSHOTS 3000u
#define SENSORS (sizeof(OF(counts_t)) / sizeof(OF(count_t)))

static OF(sensors_t) board;
static OF(node_t) node;
static OF(node_t) chip;

/** Numerical Recipes' generator; its upper bits. */
static uint32_t next_random(uint32_t *const seed) {
    *seed = *seed * 1664525u + 1013904223u;
    return (*seed >> 8) ^ (*seed << 20);
}

/** A count near the sensor's zero, or any at all. */
static OF(count_t) any_count(uint32_t *const seed, const OF(count_t) zero) {
    const bool near = (next_random(seed) % 64u) != 0u;
    const uint32_t bits = next_random(seed);
    return near ? (OF(count_t))(zero + (int)(bits % 401u) - 200) : (OF(count_t))bits;
}

/** A frame of the board that is sent at last. \return false where there is none. */
static bool fetch_from_board(uint32_t *const seed, ccgen_frame_t *const frame) {
    while (OF(sensors_transmit)(&board, frame) == 1) {
        if ((next_random(seed) % 8u) != 0u) {
            return true;
        }
        CHECK(OF(sensors_unsent)(&board) == 1);
    }
    return false;
}

static void same(const ccgen_frame_t *const one, const ccgen_frame_t *const other) {
    CHECK((one->id == other->id) && (one->length == other->length));
    CHECK(memcmp(one->data, other->data, one->length) == 0);
}

/** Answers of both, in step. \return how many frames. */
static unsigned answers(uint32_t *const seed, const uint32_t now_us) {
    ccgen_frame_t of_node;
    ccgen_frame_t of_chip;
    unsigned frames = 0;
    while (OF(node_transmit)(&node, now_us, &of_node) == 1) {
        CHECK(OF(node_transmit)(&chip, now_us, &of_chip) == 1);
        same(&of_node, &of_chip);
        if ((next_random(seed) % 8u) == 0u) {
            CHECK((OF(node_unsent)(&node) == 1) && (OF(node_unsent)(&chip) == 1));
        } else {
            ++frames;
        }
    }
    CHECK(OF(node_transmit)(&chip, now_us, &of_chip) == 0);
    return frames;
}

int main(void) {
    uint32_t seed = 7u;
    uint32_t now_us = 0u - 100u * OF_CYCLE_US;
    unsigned estimates = 0;
    unsigned frames = 0;
    CHECK(OF(sensors_init)(&board) == CCGEN_OK);
    CHECK((OF(node_init)(&node) == CCGEN_OK) && (OF(node_init)(&chip) == CCGEN_OK));
    OF(counts_t) counts;
    OF(count_t) zeros[SENSORS];
    CHECK(OF(zero)(&chip.joint, &counts) == CCGEN_OK);
    memcpy(zeros, &counts, sizeof zeros);
    CHECK(OF(sensors_pack)(&board, &counts, now_us) == 0); /* silent at first */
    now_us += OF_CYCLE_US;
    for (unsigned k = 0; k < SNAPSHOTS; ++k) {
        OF(angles_t) angles;
        OF(angles_t) read;
        ccgen_frame_t frame;
        int result = 0;
        uint8_t age_ms = 1;
        now_us += OF_CYCLE_US;
        for (unsigned j = 0; j < SENSORS; ++j) {
            const OF(count_t) count = any_count(&seed, zeros[j]);
            memcpy((unsigned char *)&counts + j * sizeof count, &count, sizeof count);
        }
        CHECK(OF(sensors_pack)(&board, &counts, now_us) == 1);
        while (fetch_from_board(&seed, &frame)) {
            CHECK(result == 0);
            result = OF(node_receive)(&node, &frame, now_us);
        }
        CHECK(OF(node_estimate)(&chip, &counts, now_us) == result);
        CHECK(memcmp(&node.angles, &chip.angles, sizeof angles) == 0);
        const int worth = OF(node_angles)(&chip, now_us, &read, &age_ms);
        CHECK((worth == OF(node_angles)(&node, now_us, NULL, NULL)) && (age_ms == 0u));
        if (OF(missing)(&chip.joint, &counts) == 0) {
            CHECK((result == 1) && (OF(estimate)(&chip.joint, &counts, &angles) >= CCGEN_OK));
            CHECK(memcmp(&angles, &read, sizeof angles) == 0);
            ++estimates;
        } else {
            CHECK(worth != CCGEN_ANGLES_GOOD);
        }
        frames += answers(&seed, now_us);
    }
    CHECK((estimates > SNAPSHOTS / 4u) && (estimates < SNAPSHOTS));
    CHECK((board.overruns == 0u) && (node.node.overruns == 0u) && (chip.node.overruns == 0u));
    CHECK(OF(node_estimate)(NULL, &counts, now_us) == CCGEN_ERROR_ARGUMENT);
    CHECK(OF(node_estimate)(&chip, NULL, now_us) == CCGEN_ERROR_ARGUMENT);
    CHECK(OF(node_angles)(NULL, now_us, NULL, NULL) == CCGEN_ERROR_ARGUMENT);
    CHECK(OF(sensors_pack)(NULL, &counts, now_us) == CCGEN_ERROR_ARGUMENT);
    CHECK(OF(sensors_pack)(&board, NULL, now_us) == CCGEN_ERROR_ARGUMENT);
    (void)printf("%u snapshots, %u estimated, %u frames\n", SNAPSHOTS, estimates, frames);
    return 0;
}
