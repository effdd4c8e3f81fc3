/**
 * \file batch.c
 * \brief Estimates many drawn snapshots on the target and prints checksums for a comparison.
 *
 * Nothing comes in; lines of text go out over the UART, numbers in hexadecimal:
 *
 *     vectors COMPARED MISMATCHES POSES MISMATCHES   the built-in self-test, where it fits
 *     angles SEED SUM               a block of BATCH_SNAPSHOTS snapshots, drawn from SEED on
 *     tip X Y Z                     tip position of drawn angles, bits of the floats, if there are any
 *     poses SUM                     checksum over the bits of all those tip poses
 *     integers SUM                  checksum over the tip poses in integers of the same angles
 *     jacobians SUM                 likewise over the tip Jacobians in integers
 *     functions SUM                 likewise over what the user's own functions give, if any
 *     end
 *
 * Drawing and checksum are those of selftest/.
 */
#include "board.h"
#include "ccgen/integer.h"
#include "port_joint.h"
#include "port_selftest.h"

#ifndef BATCH_SEED
#define BATCH_SEED 0u
#endif
#ifndef BATCH_BLOCKS
#define BATCH_BLOCKS 16u
#endif
#ifndef BATCH_SNAPSHOTS
#define BATCH_SNAPSHOTS 256u
#endif
#ifndef BATCH_POSES
#define BATCH_POSES 64u
#endif
/* The vectors stand in flash; a core that copies its constants to RAM may have no room for them. */
#ifndef BATCH_VECTORS
#define BATCH_VECTORS 1
#endif

#ifndef PORT_INTEGERS_ONLY
/** A single-precision number and its bits. */
typedef union {
    float number;
    uint32_t bits;
} word_t;
#endif

static void print(const char *text) {
    while (*text != '\0') {
        board_write((uint8_t)*text);
        ++text;
    }
}

static void print_hex(const uint32_t word) {
    static const char digits[] = "0123456789abcdef";
    board_write(' ');
    for (uint8_t shift = 32; shift > 0u;) {
        shift = (uint8_t)(shift - 4u);
        board_write((uint8_t)digits[(word >> shift) & 0xFu]);
    }
}

#if BATCH_VECTORS
static void check_vectors(void) {
    port_selftest_t result;
    (void)port_selftest(&result);
    print("vectors");
    print_hex(result.compared);
    print_hex(result.mismatches);
    print_hex(result.poses);
    print_hex(result.pose_mismatches);
    print("\n");
}
#endif

static void check_angles(void) {
    for (uint32_t block = 0; block < BATCH_BLOCKS; ++block) {
        const uint32_t seed = BATCH_SEED + block;
        print("angles");
        print_hex(seed);
        print_hex(port_selftest_block(seed, BATCH_SNAPSHOTS));
        print("\n");
    }
}

/** The generator of selftest/. */
static uint32_t draw(uint32_t *const state) {
    *state += UINT32_C(0x9E3779B9);
    uint32_t x = *state;
    x = (x ^ (x >> 16)) * UINT32_C(0x85EBCA6B);
    x = (x ^ (x >> 13)) * UINT32_C(0xC2B2AE35);
    return x ^ (x >> 16);
}

/** Angles over the full range of their type: the top bits of the draws. */
static void draw_angles(uint32_t *const state, port_angles_t *const angles) {
    port_angle_t list[PORT_VALUES];
    for (uint8_t i = 0; i < PORT_VALUES; ++i) {
        const int32_t x = ccgen_signed32(draw(state));
        list[i] = (port_angle_t)(x >> (32 - PORT_PRECISION));
    }
    port_unpack_angles(list, angles);
}

static uint32_t add_word(const uint32_t sum, const uint32_t word) {
    return sum * UINT32_C(16777619) + word;
}

#ifndef PORT_INTEGERS_ONLY
static uint32_t add(const uint32_t sum, const float number) {
    word_t word;
    word.number = number;
    return add_word(sum, word.bits);
}

static uint32_t add_pose(uint32_t sum, const port_pose_t *const pose) {
    for (uint8_t row = 0; row < 3u; ++row) {
        for (uint8_t column = 0; column < 3u; ++column) {
            sum = add(sum, pose->rotation[row][column]);
        }
        sum = add(sum, pose->position[row]);
    }
    return sum;
}

static void print_tip(const port_pose_t *const pose) {
    print("tip");
    for (uint8_t k = 0; k < 3u; ++k) {
        word_t word;
        word.number = pose->position[k];
        print_hex(word.bits);
    }
    print("\n");
}

/** \return whether every pose could be computed */
static bool check_poses(void) {
    uint32_t state = BATCH_SEED;
    uint32_t sum = 0;
    for (uint32_t k = 0; k < BATCH_POSES; ++k) {
        port_angles_t angles;
        port_pose_t pose;
        draw_angles(&state, &angles);
        if (port_tip_pose(&angles, &pose) != CCGEN_OK) {
            return false;
        }
        sum = add_pose(sum, &pose);
        print_tip(&pose);
    }
    print("poses");
    print_hex(sum);
    print("\n");
    return true;
}
#endif

/** \return whether every pose could be computed */
static bool check_integer_poses(void) {
    uint32_t state = BATCH_SEED;
    uint32_t sum = 0;
    for (uint32_t k = 0; k < BATCH_POSES; ++k) {
        port_angles_t angles;
        port_integer_pose_t pose;
        draw_angles(&state, &angles);
        if (port_integer_tip_pose(&angles, &pose) != CCGEN_OK) {
            return false;
        }
        for (uint8_t i = 0; i < 9u; ++i) {
            sum = add_word(sum, (uint32_t)pose.rotation[i]);
        }
        for (uint8_t i = 0; i < 3u; ++i) {
            sum = add_word(sum, (uint32_t)pose.position[i]);
        }
    }
    print("integers");
    print_hex(sum);
    print("\n");
    return true;
}

/** \return whether every Jacobian could be computed */
static bool check_integer_jacobians(void) {
    uint32_t state = BATCH_SEED;
    uint32_t sum = 0;
    for (uint32_t k = 0; k < BATCH_POSES; ++k) {
        port_angles_t angles;
        int32_t jacobian[6][PORT_VALUES];
        draw_angles(&state, &angles);
        if (port_integer_tip_jacobian(&angles, jacobian) != CCGEN_OK) {
            return false;
        }
        for (uint8_t row = 0; row < 6u; ++row) {
            for (uint16_t i = 0; i < PORT_VALUES; ++i) {
                sum = add_word(sum, (uint32_t)jacobian[row][i]);
            }
        }
    }
    print("jacobians");
    print_hex(sum);
    print("\n");
    return true;
}

#if PORT_FUNCTION_WORDS > 0
/** \return whether every function could be computed */
static bool check_functions(void) {
    uint32_t state = BATCH_SEED;
    uint32_t sum = 0;
    for (uint32_t k = 0; k < BATCH_POSES; ++k) {
        port_angles_t angles;
        int32_t words[PORT_FUNCTION_WORDS];
        draw_angles(&state, &angles);
        if (port_functions(&angles, words) != CCGEN_OK) {
            return false;
        }
        for (uint16_t i = 0; i < PORT_FUNCTION_WORDS; ++i) {
            sum = add_word(sum, (uint32_t)words[i]);
        }
    }
    print("functions");
    print_hex(sum);
    print("\n");
    return true;
}
#endif

int main(void) {
    board_init();
#if BATCH_VECTORS
    check_vectors();
#endif
    check_angles();
#ifndef PORT_INTEGERS_ONLY
    if (!check_poses()) {
        board_end(BOARD_WRONG);
    }
#endif
    if (!check_integer_poses() || !check_integer_jacobians()) {
        board_end(BOARD_WRONG);
    }
#if PORT_FUNCTION_WORDS > 0
    if (!check_functions()) {
        board_end(BOARD_WRONG);
    }
#endif
    print("end\n");
    board_end(BOARD_DONE);
}
