/**
 * \file mixes.c
 * \brief Streams disturbed traffic to an exported joint's node and counts estimates that mix.
 *
 *     mixes SEED SNAPSHOTS WINDOW_CYCLES DELAY_CYCLES contract|any SHARE_CORRUPT node|model
 *
 * Streams until so many snapshots are published.
 *
 * An observer knows which sending every frame comes from, and tells sendings apart by their counts,
 * never by their numbers. What the node publishes must be what the rule of snapshot.h publishes
 * (rule.h), with the reference model's angles. With `model` the rule runs alone. One JSON object
 * goes to standard output.
 */
#include <inttypes.h>

#include "rule.h"
#include "traffic.h"

#define HARMED                                                                        \
    0x80000000u /* of a place's sending: bits were flipped and the check did not tell \
                 */
#define START_US (UINT64_C(0xFFFFFFFF) - 5000000u) /* the clock wraps soon, and again and again */

typedef struct {
    port_node_t node;
    bool with_node;
    rule_t rule;
    traffic_t traffic;
    uint64_t told_us;
    uint64_t completed_us;
    int64_t zero[SENSORS];
    uint32_t first_of_life;
    uint32_t published; /* sending of the latest estimate; 0 if it was none's */
    bool was_stale;     /* since the latest status */
    bool disturbed;     /* a stray frame came since the latest sending */
    bool restarted;     /* and no good sending was published since */
    uint32_t streak;    /* good sendings in a row */
    uint32_t flipped[TRAFFIC_BITS + 1u];
} run_t;

/** What came of it. */
typedef struct {
    uint64_t published;
    uint64_t late;      /* of them by a stray frame */
    uint64_t mixed;     /* without a harmed frame */
    uint64_t by_chance; /* of them: one number, and the frame that would tell did not come */
    uint64_t wrong;     /* with a harmed frame */
    uint64_t undetected;
    uint64_t restarts;
    uint64_t false_stale;
    uint64_t statuses;
    uint64_t slow; /* good sendings that should have been published */
    uint32_t worst_fault;
    uint32_t worst_restart;
} result_t;

static run_t run;
static result_t result;
static uint64_t state;

static uint32_t traffic_draw(const uint32_t below) {
    state ^= state >> 12;
    state ^= state << 25;
    state ^= state >> 27;
    return (uint32_t)((((state * UINT64_C(0x2545F4914F6CDD1D)) >> 32) * below) >> 32);
}

static uint32_t stamp_of(const uint64_t us) {
    return (uint32_t)(us & 0xFFFFFFFFu);
}

/** Time goes on for node and rule. */
static void tell(const uint64_t us) {
    run.told_us = (us > run.told_us) ? us : run.told_us;
    rule_pass(&run.rule, run.told_us);
    const uint64_t age_us = run.told_us - run.completed_us;
    run.was_stale = run.was_stale || (age_us > (3u * (uint64_t)layout->cycle_us));
}

static void check_status(const ccgen_frame_t *const frame) {
    const bool stale = (payload_of(frame)[4] & CCGEN_FAULT_STALE) != 0u;
    ++result.statuses;
    result.false_stale += (stale != run.was_stale) ? 1u : 0u;
}

/** Fetches all that is due; now and then a frame cannot be sent and comes again. */
static void transmit(const uint64_t us) {
    const uint16_t status = ccgen_layout_status_index(layout);
    const uint16_t health = ccgen_layout_health_index(layout);
    ccgen_frame_t frame;
    tell(us);
    while (run.with_node && (port_node_transmit(&run.node, stamp_of(us), &frame) == 1)) {
        if (traffic_draw(64) == 0u) {
            CHECK(port_node_unsent(&run.node) == 1);
            continue;
        }
        if (frame.id == (layout->base_id + status)) {
            check_status(&frame);
            run.was_stale = false;
            tell(us);
        } else if (frame.id != (layout->base_id + health)) {
            CHECK(verdict(&frame) == run.rule.newest);
        }
    }
}

/** \return whether a mix has one number and lacks the frame that would have told. */
static bool is_by_chance(void) {
    uint32_t newest = 0;
    for (int k = 0; k < run.rule.places; ++k) {
        const uint32_t id = run.rule.taken[k].sending;
        newest = (id > newest) ? id : newest;
    }
    const traffic_sending_t *const sending = traffic_sending(&run.traffic, newest);
    for (int k = 0; k < run.rule.places; ++k) {
        const rule_place_t *const place = &run.rule.taken[k];
        const traffic_sending_t *const other = traffic_sending(&run.traffic, place->sending);
        const bool told = (place->sending != newest) && (sending->at_us[k] > place->at_us);
        if (told || (other->number != sending->number)) {
            return false;
        }
    }
    return true;
}

static void check_angles(const int32_t *const counts) {
    port_angle_t angles[PORT_VALUES];
    port_pack_angles(&run.node.angles, angles);
    for (uint16_t i = 0; i < PORT_VALUES; ++i) {
        CHECK(angles[i] == angle_of(counts, run.zero, i));
    }
}

/** The counts that the rule has put together. */
static void read_counts(int32_t *const counts) {
    const uint8_t bytes = layout->count_bytes;
    const uint8_t per_frame = layout->counts_per_frame;
    for (uint16_t j = 0; j < SENSORS; ++j) {
        const uint8_t *const at = &run.rule.taken[j / per_frame].bytes[(j % per_frame) * bytes];
        const int64_t count = read_signed(at, bytes);
        counts[j] = (count == lowest_of(bytes)) ? INT32_MIN : (int32_t)count;
    }
}

static void publish(const int answer) {
    int32_t counts[SENSORS];
    bool harmed = false;
    read_counts(counts);
    run.completed_us = run.told_us;
    for (int k = 0; k < run.rule.places; ++k) {
        harmed = harmed || ((run.rule.taken[k].sending & HARMED) != 0u);
    }
    if (run.with_node) {
        CHECK(memcmp(run.node.node.snapshot.counts, counts, sizeof counts) == 0);
        CHECK(answer ==
              ((states_in(counts, run.zero) == all_lost()) ? CCGEN_ERROR_MISSING : 1));
    }
    if (run.with_node && (answer == 1)) {
        check_angles(counts);
    }
    run.published = traffic_sending_of(&run.traffic, counts);
    ++result.published;
    if (run.published != 0u) {
        return;
    }
    if (harmed) {
        ++result.wrong;
        return;
    }
    ++result.mixed;
    result.by_chance += is_by_chance() ? 1u : 0u;
}

/** What the rule makes of a frame. \return whether it completes a snapshot. */
static bool follow_rule(const transit_t *const transit, const ccgen_frame_t *const frame) {
    const int number = verdict(frame);
    const bool whole = (transit->flips == 0u) && !transit->truncated;
    rule_place_t place = {true, transit->id, run.told_us, counts_length(transit->place), {0}};
    if (!transit->truncated) {
        run.flipped[transit->flips] += 1u;
        result.undetected += ((transit->flips > 0u) && (number != CCGEN_ERROR_CRC)) ? 1u : 0u;
    }
    if (number < 0) {
        CHECK(!whole);
        return false;
    }
    if (whole) {
        traffic_sending(&run.traffic, transit->id)->at_us[transit->place] = run.told_us;
    } else {
        place.sending |= HARMED;
    }
    memcpy(place.bytes, payload_of(frame), place.length);
    return rule_receive(&run.rule, number, transit->place, &place);
}

static void receive(const transit_t *const transit) {
    const uint64_t stamp_us = transit->at_us - traffic_draw(TRAFFIC_LAG_US);
    ccgen_frame_t frame;
    traffic_arrive(&run.traffic, transit, &frame);
    if (transit->stray || transit->truncated || (transit->flips > 0u)) {
        run.disturbed = true;
        run.restarted =
            run.restarted || (run.traffic.mix.any_number && (transit->id < run.first_of_life));
    }
    tell(stamp_us);
    const int answer = run.with_node ? port_node_receive(&run.node, &frame, stamp_of(stamp_us)) : 1;
    if (follow_rule(transit, &frame)) {
        result.late += transit->stray ? 1u : 0u;
        publish(answer);
    } else {
        CHECK(!run.with_node || (answer == 0));
    }
    transmit(transit->at_us);
}

/** Whether the node recovered in time, seen when the cycle of a sending has ended. */
static void judge(const uint32_t id, const uint32_t patience) {
    const traffic_sending_t *const sending = traffic_sending(&run.traffic, id);
    const bool good = (id > 0u) && sending->whole && !run.disturbed;
    run.streak = good ? (run.streak + 1u) : 0u;
    run.disturbed = false;
    if (!good) {
        return;
    }
    if (run.published == id) {
        run.restarted = false;
        return;
    }
    uint32_t *const worst = run.restarted ? &result.worst_restart : &result.worst_fault;
    *worst = (run.streak > *worst) ? run.streak : *worst;
    result.slow += (run.streak >= (run.restarted ? patience : 2u)) ? 1u : 0u;
}

static void stream(const uint32_t snapshots, const uint32_t patience) {
    traffic_t *const traffic = &run.traffic;
    while (result.published < snapshots) {
        if ((traffic->count > 0) && (traffic->transit[0].at_us < traffic->next_us)) {
            const transit_t transit = traffic_pop(traffic);
            receive(&transit);
            continue;
        }
        judge(traffic->id, patience);
        transmit(traffic->next_us);
        const traffic_sending_t *const sending = traffic_send(traffic);
        if (sending->new_life) {
            ++result.restarts;
            run.first_of_life = sending->id;
            run.restarted = true;
            run.streak = 0;
        }
    }
}

/** \return the bits by which the check of a frame differs from what it tells. */
static uint32_t syndrome(const ccgen_frame_t *const frame) {
    const uint32_t told =
        layout->fd ? (frame->data[0] | ((uint32_t)frame->data[1] << 8)) : frame->data[0];
    return check_value(frame) ^ told;
}

/** Enumerates flips of 1, 2 and 3 bits. \param[out] rates shares of them that the check misses */
static void miss_rates(double rates[TRAFFIC_BITS + 1u]) {
    static uint32_t flips[8u * CCGEN_FRAME_CAPACITY];
    const uint32_t bits = 8u * ccgen_layout_frame_length(layout, 0);
    uint64_t missed[TRAFFIC_BITS + 1u] = {0, 0, 0, 0};
    ccgen_frame_t frame;
    memset(&frame, 0, sizeof frame);
    ccgen_layout_begin(layout, 0, &frame);
    const uint32_t base = syndrome(&frame);
    for (uint32_t i = 0; i < bits; ++i) {
        frame.data[i / 8u] ^= (uint8_t)(1u << (i % 8u));
        flips[i] = syndrome(&frame) ^ base;
        frame.data[i / 8u] ^= (uint8_t)(1u << (i % 8u));
        missed[1] += (flips[i] == 0u) ? 1u : 0u;
        for (uint32_t j = 0; j < i; ++j) {
            const uint32_t two = flips[i] ^ flips[j];
            missed[2] += (two == 0u) ? 1u : 0u;
            for (uint32_t k = 0; k < j; ++k) {
                missed[3] += (two == flips[k]) ? 1u : 0u;
            }
        }
    }
    const double n = (double)bits;
    rates[1] = (double)missed[1] / n;
    rates[2] = (double)missed[2] / (n * (n - 1.0) / 2.0);
    rates[3] = (double)missed[3] / (n * (n - 1.0) * (n - 2.0) / 6.0);
}

static void print(void) {
    double rates[TRAFFIC_BITS + 1u] = {0.0, 0.0, 0.0, 0.0};
    double expected = 0.0;
    uint32_t corrupted = 0;
    miss_rates(rates);
    for (uint32_t k = 1; k <= TRAFFIC_BITS; ++k) {
        expected += rates[k] * run.flipped[k];
        corrupted += run.flipped[k];
    }
    (void)printf("{\"sendings\": %" PRIu32 ", \"published\": %" PRIu64 ", \"late\": %" PRIu64
                 ", \"mixed\": %" PRIu64 ", \"by_chance\": %" PRIu64 ", \"wrong\": %" PRIu64,
                 run.traffic.id, result.published, result.late, result.mixed, result.by_chance,
                 result.wrong);
    (void)printf(", \"corrupted\": %" PRIu32 ", \"undetected\": %" PRIu64
                 ", \"undetected_expected\": %.3f, \"restarts\": %" PRIu64 ", \"slow\": %" PRIu64,
                 corrupted, result.undetected, expected, result.restarts, result.slow);
    (void)printf(", \"unpublished_after_fault\": %" PRIu32
                 ", \"unpublished_after_restart\": %" PRIu32 ", \"statuses\": %" PRIu64
                 ", \"false_stale\": %" PRIu64 "}\n",
                 result.worst_fault, result.worst_restart, result.statuses, result.false_stale);
}

static void start(const char *const argv[]) {
    const uint32_t window_cycles = (uint32_t)strtoul(argv[3], NULL, 10);
    const uint64_t window_us = (uint64_t)window_cycles * layout->cycle_us;
    const traffic_mix_t mix = {
        TRAFFIC_WHOLE / 50u,
        TRAFFIC_WHOLE / 50u,
        TRAFFIC_WHOLE / 50u,
        TRAFFIC_WHOLE / 50u,
        TRAFFIC_WHOLE / 100u,
        (uint32_t)strtoul(argv[6], NULL, 10),
        TRAFFIC_WHOLE / 400u,
        TRAFFIC_WHOLE / 200u,
        (uint32_t)strtoul(argv[4], NULL, 10),
        90,
        strcmp(argv[5], "any") == 0,
    };
    state = strtoull(argv[1], NULL, 10) * UINT64_C(0x9E3779B97F4A7C15) + 1u;
    run.with_node = (strcmp(argv[7], "node") == 0);
    run.told_us = START_US;
    run.completed_us = START_US;
    CHECK(port_node_init(&run.node) == CCGEN_OK);
    CHECK(port_node_set_window(&run.node, (uint32_t)window_us) == CCGEN_OK);
    read_zero(&run.node.joint, run.zero);
    rule_start(&run.rule, numbers_of_joint(), layout->lengths_frames, layout->cycle_us,
               window_us);
    traffic_start(&run.traffic, &mix, window_us, START_US + TRAFFIC_LAG_US);
    transmit(START_US);
}

int main(int argc, char *argv[]) {
    CHECK(argc == 8);
    const uint32_t snapshots = (uint32_t)strtoul(argv[2], NULL, 10);
    const uint32_t window_cycles = (uint32_t)strtoul(argv[3], NULL, 10);
    start((const char *const *)argv);
    stream(snapshots, (window_cycles > 2u) ? (window_cycles + 2u) : 4u);
    print();
    return 0;
}
