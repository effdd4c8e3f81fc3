/**
 * \file node.c
 * \brief Fuzzes an exported joint's CAN node: frames good, damaged and foreign, time and requests.
 *
 * The input is a list of steps. Many frames get their check value repaired, so that what lies
 * behind the check is reached too. After every step:
 * - the node has published what the rule of snapshot.h, said again in rule.h, publishes, and counts
 *   what that counts;
 * - angles are those of a plain 64-bit computation from the reference model;
 * - every frame that goes out is due, well-formed and protected, and says what the state says;
 *   a STATUS tells every fault that no sent one has told, and no other;
 * - a frame that was taken back comes again.
 *
 * A quarter of the inputs steers a sender instead that keeps the contract of snapshot.h over a bus
 * that disturbs its frames (traffic.h). An observer tells its sendings apart by their counts, and
 * no estimate may mix two of them.
 */
#include <string.h>

#include "../reference.h"
#include "../rule.h"
#include "../traffic.h"
#include "input.h"

#define STEPS_MAX 400
#define SENDING_MAX 40
#define QUIET_MAX_US 1800000000u /* some function wants to be called each half hour */
#define BEHIND_MAX_US 0x7FFFFFFFu
#define EPOCH_US (UINT64_C(1) << 40) /* times below 0 are none */
#define MARK 0xA5

/** The node and what an observer of its bus knows. */
typedef struct {
    port_node_t *node;
    uint64_t now_us;
    uint64_t behind_us; /* of the stamps that the node is given */
    uint64_t told_us;   /* the latest that it was given */
    bool started;
    rule_t rule;
    uint64_t completed_us;
    bool completed;
    uint16_t due; /* index of the next frame of an answer */
    ccgen_handed_t handed;
    bool status_again;
    uint64_t status_us;
    uint64_t status_wait_us;
    uint8_t status_counter;
    bool health_due;
    uint64_t health_us;
    uint8_t health_counter;
    uint8_t owed;   /* faults that no sent status has told */
    uint8_t recent; /* those since the latest status was handed out */
    int published;
    int32_t missing;
    int64_t angles[PORT_VALUES];
    bool remembered; /* not forgotten in a silence */
    uint32_t states; /* of the axes */
    uint32_t corrupted;
    uint32_t malformed;
    uint32_t estimates;
    uint32_t failures;
    uint32_t overruns;
    int64_t zero[SENSORS];
    int32_t counts[SENSORS]; /* what the sensors' side sends */
    traffic_t *traffic;      /* a sender that keeps the contract; NULL: anything is sent */
} bus_t;

static uint64_t drawn = 1; /* of the traffic; the input stirs it */

static uint32_t traffic_draw(const uint32_t below) {
    drawn ^= drawn << 13;
    drawn ^= drawn >> 7;
    drawn ^= drawn << 17;
    return (uint32_t)(((drawn >> 32) * below) >> 32);
}

static ccgen_snapshot_t *snapshot_of(bus_t *const bus) {
    return &bus->node->node.snapshot;
}

static void owe(bus_t *const bus, const uint8_t fault) {
    bus->owed |= fault;
    bus->recent |= fault;
}

/** Notes which of the rule's counts have grown. */
static void owe_counted(bus_t *const bus, const rule_t *const before) {
    const rule_t *const after = &bus->rule;
    owe(bus, (after->repeated != before->repeated) ? CCGEN_FAULT_REPEATED : 0u);
    owe(bus, (after->reordered != before->reordered) ? CCGEN_FAULT_REORDERED : 0u);
    owe(bus, (after->lost != before->lost) ? CCGEN_FAULT_LOST : 0u);
    owe(bus, (after->late != before->late) ? CCGEN_FAULT_LATE : 0u);
}

/** Tells the node a time. \return the stamp; `told_us` is what it counts as. */
static uint32_t tell(bus_t *const bus) {
    const rule_t before = bus->rule;
    const uint64_t stamp_us = bus->now_us - bus->behind_us;
    if (!bus->started) {
        bus->started = true;
        bus->told_us = stamp_us;
        bus->completed_us = stamp_us;
    }
    bus->told_us = (stamp_us > bus->told_us) ? stamp_us : bus->told_us;
    rule_pass(&bus->rule, bus->told_us);
    owe_counted(bus, &before);
    const bool stale = (bus->told_us - bus->completed_us) > (3u * (uint64_t)layout->cycle_us);
    owe(bus, stale ? CCGEN_FAULT_STALE : 0u);
    return (uint32_t)(stamp_us & 0xFFFFFFFFu);
}

static void check_angles(const bus_t *const bus) {
    port_angle_t angles[PORT_VALUES];
    port_pack_angles(&bus->node->angles, angles);
    for (uint16_t i = 0; i < PORT_VALUES; ++i) {
        CHECK(angles[i] == bus->angles[i]);
    }
}

static void blank(bus_t *const bus) {
    for (uint16_t i = 0; i < PORT_VALUES; ++i) {
        bus->angles[i] = lowest_of(layout->angle_bytes);
    }
    bus->remembered = false;
}

/** Angles that no frame needs any more do not outlast a silence. */
static void forget(bus_t *const bus) {
    const bool stale = (bus->told_us - bus->completed_us) > (3u * (uint64_t)layout->cycle_us);
    if (bus->remembered && stale && (bus->due > ccgen_layout_status_index(layout))) {
        blank(bus);
    }
}

/** The node counts what the rule counts. */
static void check_counters(const bus_t *const bus) {
    const ccgen_snapshot_t *const snapshot = &bus->node->node.snapshot;
    const ccgen_node_t *const node = &bus->node->node;
    CHECK(snapshot->snapshots == bus->rule.snapshots);
    CHECK(snapshot->repeated == bus->rule.repeated);
    CHECK(snapshot->reordered == bus->rule.reordered);
    CHECK(snapshot->lost == bus->rule.lost);
    CHECK(snapshot->late == bus->rule.late);
    CHECK(snapshot->corrupted == bus->corrupted);
    CHECK(snapshot->malformed == bus->malformed);
    CHECK(node->estimates == bus->estimates);
    CHECK(node->failures == bus->failures);
    CHECK(node->overruns == bus->overruns);
    CHECK(node->missing == bus->missing);
    CHECK(snapshot->snapshots == (bus->estimates + bus->failures));
}

/** The counts of a complete snapshot are those of the frames that the rule has put together. */
static void check_counts(const bus_t *const bus) {
    const ccgen_snapshot_t *const snapshot = &bus->node->node.snapshot;
    const uint8_t bytes = layout->count_bytes;
    const uint8_t per_frame = layout->counts_per_frame;
    for (uint16_t index = 0; index < SENSORS; ++index) {
        const rule_place_t *const place = &bus->rule.taken[index / per_frame];
        const int64_t count = read_signed(&place->bytes[(index % per_frame) * bytes], bytes);
        CHECK(snapshot->counts[index] == ((count == lowest_of(bytes)) ? INT32_MIN : count));
    }
    CHECK(snapshot->number == bus->rule.newest);
}

/** A snapshot is complete: the node's answer must be the reference's. */
static void publish(bus_t *const bus, const int result) {
    const int32_t *const counts = snapshot_of(bus)->counts;
    check_counts(bus);
    CHECK((bus->traffic == NULL) || (traffic_sending_of(bus->traffic, counts) != 0u));
    bus->missing = missing_in(counts, bus->zero);
    bus->states = states_in(counts, bus->zero);
    const bool estimated = (bus->states != all_lost());
    CHECK(result == (estimated ? 1 : CCGEN_ERROR_MISSING));
    for (uint16_t i = 0; i < PORT_VALUES; ++i) {
        bus->angles[i] = angle_of(counts, bus->zero, i);
    }
    bus->remembered = estimated;
    owe(bus, (bus->missing == 0) ? 0u : CCGEN_FAULT_MISSING);
    bus->estimates += estimated ? 1u : 0u;
    bus->failures += estimated ? 0u : 1u;
    bus->overruns += (bus->due <= ccgen_layout_status_index(layout)) ? 1u : 0u;
    bus->due = layout->lengths_frames;
    bus->handed = (bus->handed == CCGEN_HANDED_ESTIMATE) ? CCGEN_HANDED_NOTHING : bus->handed;
    bus->published = bus->rule.newest;
    bus->completed = true;
    bus->completed_us = bus->told_us;
}

static bool is_lengths(const ccgen_frame_t *const frame) {
    return (frame->extended == layout->extended) && (frame->id >= layout->base_id) &&
           ((frame->id - layout->base_id) < layout->lengths_frames);
}

/** What the rule makes of a frame. \return whether it completes a snapshot. */
static bool follow_rule(bus_t *const bus, const ccgen_frame_t *const frame) {
    const int number = verdict(frame);
    const rule_t before = bus->rule;
    rule_place_t place = {true, 0, bus->told_us, 0, {0}};
    if (!is_lengths(frame)) {
        return false;
    }
    if (number < 0) {
        const bool crc = (number == CCGEN_ERROR_CRC);
        bus->corrupted += crc ? 1u : 0u;
        bus->malformed += crc ? 0u : 1u;
        owe(bus, crc ? CCGEN_FAULT_CRC : CCGEN_FAULT_FORMAT);
        return false;
    }
    const uint16_t slot = (uint16_t)(frame->id - layout->base_id);
    place.length = counts_length(slot);
    memcpy(place.bytes, payload_of(frame), place.length);
    const bool complete = rule_receive(&bus->rule, number, slot, &place);
    owe_counted(bus, &before);
    return complete;
}

static void receive(bus_t *const bus, const ccgen_frame_t *const frame) {
    const ccgen_snapshot_t before = *snapshot_of(bus);
    const int result = port_node_receive(bus->node, frame, tell(bus));
    if (follow_rule(bus, frame)) {
        publish(bus, result);
    } else {
        CHECK(result == 0);
        forget(bus);
        CHECK(memcmp(before.counts, snapshot_of(bus)->counts, sizeof before.counts) == 0);
    }
    check_angles(bus);
}

/** A frame of this index is zero behind its signals. */
static void check_rest(const uint16_t index, const uint8_t *const payload, const size_t used) {
    const size_t all = (size_t)length_of(index) - (layout->fd ? 3u : 2u);
    for (size_t i = used; i < all; ++i) {
        CHECK(payload[i] == 0u);
    }
}

static void check_status(const bus_t *const bus, const uint8_t *const payload) {
    const uint64_t age_ms = (bus->told_us - bus->completed_us) / 1000u;
    CHECK((payload[0] | ((uint32_t)payload[1] << 8)) == (bus->rule.snapshots & 0xFFFFu));
    CHECK((payload[2] | (payload[3] << 8)) == bus->missing);
    CHECK(payload[4] == bus->owed);
    CHECK(payload[5] == ((bus->completed && (age_ms < 255u)) ? age_ms : 255u));
    check_rest(ccgen_layout_status_index(layout), payload, 6);
}

static void check_health(const bus_t *const bus, const uint8_t *const payload) {
    CHECK((payload[0] | ((uint32_t)payload[1] << 8)) == layout->fingerprint);
    CHECK((payload[2] == 0u) && (payload[3] == 0u) && (payload[5] == 0u));
    CHECK((payload[4] & 0x3Fu) == (0x30u | bus->states));
    CHECK((payload[4] >> 6) == (uint32_t)bus->node->joint.source);
    check_rest(ccgen_layout_health_index(layout), payload, 6);
}

static void check_answer(const bus_t *const bus, const uint16_t index,
                         const ccgen_frame_t *const frame) {
    const uint8_t *const payload = payload_of(frame);
    const uint8_t bytes = layout->angle_bytes;
    const uint8_t per_frame = layout->angles_per_frame;
    const uint16_t tip = ccgen_layout_tip_index(layout);
    if (index == tip) {
        for (uint8_t i = 0; i < 3u; ++i) {
            const bool none = (read_signed(payload + 2u * i, 2) == lowest_of(2));
            CHECK(none == ((bus->states & all_lost()) != 0u));
        }
        check_rest(index, payload, 6);
        return;
    }
    size_t used = 0;
    size_t place = (size_t)(index - layout->lengths_frames) * per_frame;
    for (uint8_t i = 0; (i < per_frame) && (place < PORT_VALUES); ++i) {
        CHECK(read_signed(payload + used, bytes) == bus->angles[place]);
        used += bytes;
        ++place;
    }
    check_rest(index, payload, used);
}

/** What was handed out before counts as sent. */
static void settle(bus_t *const bus) {
    if (bus->handed == CCGEN_HANDED_STATUS) {
        bus->owed = bus->recent;
        bus->status_counter = (uint8_t)((bus->status_counter + 1u) % (layout->fd ? 256u : 15u));
    } else if (bus->handed == CCGEN_HANDED_HEALTH) {
        bus->health_counter = (uint8_t)((bus->health_counter + 1u) % (layout->fd ? 256u : 15u));
    }
    bus->handed = CCGEN_HANDED_NOTHING;
}

/** The frame of an index was handed out: what follows from it. */
static void hand_out(bus_t *const bus, const uint16_t index) {
    const uint16_t status = ccgen_layout_status_index(layout);
    const uint64_t cycle_us = layout->cycle_us;
    if (index > status) {
        bus->handed = CCGEN_HANDED_HEALTH;
        bus->health_due = false;
        bus->health_us = bus->told_us;
        return;
    }
    if (bus->due <= status) {
        bus->status_wait_us = cycle_us + cycle_us / 2u;
        ++bus->due;
    } else if (!bus->status_again) {
        bus->status_wait_us = cycle_us;
    }
    if (index != status) {
        bus->handed = CCGEN_HANDED_ESTIMATE;
        return;
    }
    bus->handed = CCGEN_HANDED_STATUS;
    bus->status_again = false;
    bus->recent = 0;
    bus->status_us = bus->told_us;
}

/** Fetches one frame and checks it. \return whether there was one. */
static bool transmit(bus_t *const bus) {
    const uint16_t status = ccgen_layout_status_index(layout);
    ccgen_frame_t untouched;
    ccgen_frame_t frame;
    memset(&untouched, MARK, sizeof untouched);
    memset(&frame, MARK, sizeof frame);
    const int result = port_node_transmit(bus->node, tell(bus), &frame);
    settle(bus);
    const bool health = bus->health_due || ((bus->told_us - bus->health_us) >= CCGEN_HEALTH_US);
    const bool due = (bus->due <= status) || health || bus->status_again ||
                     ((bus->told_us - bus->status_us) >= bus->status_wait_us);
    CHECK(result == (due ? 1 : 0));
    if (!due) {
        forget(bus);
        check_angles(bus);
        CHECK(memcmp(&frame, &untouched, sizeof frame) == 0);
        return false;
    }
    const uint16_t idle = health ? ccgen_layout_health_index(layout) : status;
    const uint16_t index = (bus->due <= status) ? bus->due : idle;
    const int own = (index == status) ? bus->status_counter : bus->health_counter;
    CHECK(verdict(&frame) == ((index >= status) ? own : bus->published));
    CHECK((frame.id == (layout->base_id + index)) && (frame.extended == layout->extended));
    CHECK(!frame.rate_switch);
    CHECK(memcmp(&frame.data[frame.length], untouched.data, sizeof frame.data - frame.length) == 0);
    if (index == status) {
        check_status(bus, payload_of(&frame));
    } else if (index > status) {
        check_health(bus, payload_of(&frame));
    } else {
        check_answer(bus, index, &frame);
    }
    hand_out(bus, index);
    forget(bus);
    check_angles(bus);
    return true;
}

/** Takes back the frame that was fetched last, if there is one. */
static void take_back(bus_t *const bus) {
    const ccgen_handed_t handed = bus->handed;
    CHECK(port_node_unsent(bus->node) == ((handed == CCGEN_HANDED_NOTHING) ? 0 : 1));
    bus->handed = CCGEN_HANDED_NOTHING;
    bus->due = (uint16_t)(bus->due - ((handed == CCGEN_HANDED_ESTIMATE) ? 1u : 0u));
    bus->status_again = bus->status_again || (handed == CCGEN_HANDED_STATUS);
    bus->health_due = bus->health_due || (handed == CCGEN_HANDED_HEALTH);
}

/** Lets time pass; now and then until the clock has come round since the latest snapshot. */
static void advance(bus_t *const bus, input_t *const input) {
    const uint8_t scale = (uint8_t)(take8(input) % 18u);
    const uint64_t step_us = (uint64_t)take16(input) << scale;
    const uint64_t round_us = bus->completed_us + UINT64_C(0x100000000) + (step_us % 0x40000u);
    const uint64_t until_us = (scale == 17u) ? round_us : (bus->now_us + step_us);
    bus->behind_us = 0;
    while (bus->now_us < until_us) {
        const uint64_t left_us = until_us - bus->now_us;
        if ((bus->now_us - bus->told_us) >= QUIET_MAX_US) {
            (void)transmit(bus);
        }
        const uint64_t quiet_us = QUIET_MAX_US - (bus->now_us - bus->told_us);
        bus->now_us += (left_us < quiet_us) ? left_us : quiet_us;
    }
}

/** Lets the stamps lag behind: mostly by little, now and then by as much as may be. */
static void lag(bus_t *const bus, input_t *const input) {
    const uint8_t how = take8(input);
    const uint32_t most_us = (how < 200u) ? 64u : BEHIND_MAX_US;
    bus->behind_us = bus->started ? (take32(input) % (most_us + UINT64_C(1))) : 0u;
}

/** Changes what the sensors read: mostly within range, now and then anything. */
static void move_sensors(bus_t *const bus, input_t *const input) {
    const uint8_t how = take8(input);
    for (uint8_t j = 0; j < SENSORS; ++j) {
        const reference_sensor_t *const sensor = &reference_sensors[j];
        const uint64_t places = (uint64_t)(sensor->maximum - sensor->minimum) + 1u;
        const uint32_t word = take32(input);
        const int64_t inside = sensor->minimum + (int64_t)(word % places);
        bus->counts[j] = (int32_t)inside;
        if ((how % 8u) == 0u) {
            const uint8_t raw[4] = {(uint8_t)word, (uint8_t)(word >> 8), (uint8_t)(word >> 16),
                                    (uint8_t)(word >> 24)};
            bus->counts[j] = (int32_t)read_signed(raw, layout->count_bytes);
        } else if ((how % 8u) == 1u) {
            bus->counts[j] =
                (int32_t)(((word & 1u) != 0u) ? sensor->maximum : sensor->minimum);
        }
    }
}

/** A whole snapshot under the next number: whatever came before, the node must take it. */
static void send_snapshot(bus_t *const bus, input_t *const input) {
    const int numbers = numbers_of_joint();
    const int number = (bus->rule.newest + 1 + take8(input) % (numbers / 4)) % numbers;
    const uint32_t snapshots = snapshot_of(bus)->snapshots;
    ccgen_frame_t frame;
    for (uint16_t slot = 0; slot < layout->lengths_frames; ++slot) {
        CHECK(snapshot_of(bus)->snapshots == snapshots);
        make_lengths(bus->counts, slot, number, &frame);
        receive(bus, &frame);
    }
    CHECK(snapshot_of(bus)->snapshots == (snapshots + 1u));
}

/** One frame of a snapshot, alone, under some number near the newest. */
static void make_one(const bus_t *const bus, input_t *const input, ccgen_frame_t *const frame) {
    const uint16_t slot = (uint16_t)(take8(input) % layout->lengths_frames);
    const int ahead = take8(input);
    const int number = bus->rule.newest + ((ahead < 128) ? (ahead % 4) : ahead);
    make_lengths(bus->counts, slot, number % numbers_of_joint(), frame);
}

/** Makes the check value right, whatever the counter. */
static void repair(ccgen_frame_t *const frame) {
    const uint32_t crc = check_value(frame);
    frame->data[0] = (uint8_t)(crc & 0xFFu);
    if (layout->fd) {
        frame->data[1] = (uint8_t)(crc >> 8);
    }
}

static void damage(input_t *const input, ccgen_frame_t *const frame) {
    const uint8_t what = take8(input);
    const uint8_t value = take8(input);
    switch (what % 8u) {
        case 0:
            frame->length = value;
            break;
        case 1:
            frame->fd = !frame->fd;
            break;
        case 2:
            frame->extended = !frame->extended;
            break;
        case 3:
            frame->remote = true;
            break;
        case 4:
            frame->id ^= (uint32_t)1u << (value % 32u);
            break;
        case 5:
            frame->data[1] |= 0x0Fu; /* where P01 has its counter, which ends at 14 */
            break;
        default:
            frame->data[take8(input) % frame->length] ^= value;
            break;
    }
    if (frame->length > CCGEN_FRAME_CAPACITY) {
        frame->length = CCGEN_FRAME_CAPACITY;
    }
    if (what >= 128u) {
        repair(frame);
    }
}

static void make_any(input_t *const input, ccgen_frame_t *const frame) {
    const uint8_t flags = take8(input);
    const uint16_t indices = (uint16_t)(ccgen_layout_status_index(layout) + 2u);
    memset(frame, 0, sizeof *frame);
    frame->id = ((flags & 1u) != 0u) ? take32(input) : (layout->base_id + take8(input) % indices);
    frame->extended = ((flags & 2u) != 0u) ? !layout->extended : layout->extended;
    frame->fd = ((flags & 4u) != 0u) ? !layout->fd : layout->fd;
    frame->remote = ((flags & 24u) == 24u);
    frame->rate_switch = (flags & 32u) != 0u;
    frame->length = length_of((uint16_t)(frame->id - layout->base_id));
    if ((flags & 64u) != 0u) {
        frame->length = (uint8_t)(take8(input) % (CCGEN_FRAME_CAPACITY + 1u));
    }
    for (uint8_t i = 0; i < frame->length; ++i) {
        frame->data[i] = take8(input);
    }
    if ((flags & 128u) != 0u) {
        repair(frame);
    }
}

/** Takes what the sensors read as zero, by a capture or as one that was kept. */
static void take_zero(bus_t *const bus, const bool captured) {
    port_counts_t counts;
    port_count_t list[SENSORS];
    int32_t refused = 0;
    bool inside = true;
    for (uint8_t j = 0; j < SENSORS; ++j) {
        const reference_sensor_t *const sensor = &reference_sensors[j];
        const int64_t count = bus->counts[j];
        const bool accepted = (count >= sensor->zero_minimum) && (count <= sensor->zero_maximum);
        refused |= accepted ? 0 : ((int32_t)1 << sensor->bit);
        inside = inside && (count >= sensor->minimum) && (count <= sensor->maximum);
        list[j] = (port_count_t)count;
    }
    port_unpack_counts(list, &counts);
    CHECK(port_check_zero(&counts) == refused);
    const int refusal = inside ? CCGEN_ERROR_RANGE : CCGEN_ERROR_MISSING;
    CHECK((captured ? port_capture_zero(&bus->node->joint, &counts)
                    : port_restore_zero(&bus->node->joint, &counts)) ==
          ((refused == 0) ? CCGEN_OK : refusal));
    for (uint8_t j = 0; (j < SENSORS) && (refused == 0); ++j) {
        bus->zero[j] = bus->counts[j];
    }
    int64_t held[SENSORS];
    read_zero(&bus->node->joint, held);
    CHECK(memcmp(held, bus->zero, sizeof held) == 0);
}

static void step(bus_t *const bus, input_t *const input) {
    ccgen_frame_t frame;
    switch (take8(input) % 12u) {
        case 0:
            advance(bus, input);
            break;
        case 1:
            move_sensors(bus, input);
            break;
        case 2:
            send_snapshot(bus, input);
            break;
        case 3:
            make_one(bus, input, &frame);
            damage(input, &frame);
            receive(bus, &frame);
            break;
        case 4:
            make_any(input, &frame);
            receive(bus, &frame);
            break;
        case 5:
            for (uint8_t n = take8(input); (n > 0u) && transmit(bus); --n) {
                if ((take8(input) % 8u) == 1u) {
                    take_back(bus);
                }
            }
            break;
        case 6:
            take_zero(bus, (take8(input) % 2u) == 0u);
            break;
        case 7: {
            const uint32_t window_us = take32(input) >> (take8(input) % 32u);
            const bool fits = (window_us >= 1u) && (window_us <= PORT_WINDOW_MAX_US);
            CHECK((port_node_set_window(bus->node, window_us) == CCGEN_OK) == fits);
            bus->rule.window_us = fits ? window_us : bus->rule.window_us;
            break;
        }
        case 8:
            take_back(bus);
            break;
        case 9:
            lag(bus, input);
            break;
        default:
            make_one(bus, input, &frame);
            receive(bus, &frame);
            break;
    }
}

/** The sender keeps on for some cycles. */
static void keep_sending(bus_t *const bus, const uint8_t cycles) {
    traffic_t *const traffic = bus->traffic;
    const uint32_t last = traffic->id + cycles;
    while (traffic->id != last) {
        ccgen_frame_t frame;
        if ((traffic->count == 0) || (traffic->transit[0].at_us >= traffic->next_us)) {
            (void)traffic_send(traffic);
            continue;
        }
        const transit_t transit = traffic_pop(traffic);
        traffic_arrive(traffic, &transit, &frame);
        bus->now_us = transit.at_us;
        bus->behind_us = bus->started ? traffic_draw(TRAFFIC_LAG_US) : 0u;
        receive(bus, &frame);
        bus->behind_us = 0;
        for (uint32_t n = traffic_draw(40); (n > 0u) && transmit(bus); --n) {
            if (traffic_draw(16) == 0u) {
                take_back(bus);
            }
        }
        check_counters(bus);
    }
}

/** A sender that keeps the contract, and a window that the node keeps. */
static void start_sending(bus_t *const bus, input_t *const input) {
    static traffic_t traffic; /* large */
    const uint32_t cycles = 1u + take8(input) % (PORT_WINDOW_MAX_US / layout->cycle_us);
    const traffic_mix_t mix = {
        64u * take8(input),
        64u * take8(input),
        64u * take8(input),
        64u * take8(input),
        16u * take8(input),
        0,
        8u * take8(input),
        8u * take8(input),
        2u + take8(input) % ((uint32_t)numbers_of_joint() / 2u - 3u),
        90,
        false,
    };
    drawn = take64(input) | 1u;
    bus->rule.window_us = (uint64_t)cycles * layout->cycle_us;
    CHECK(port_node_set_window(bus->node, cycles * layout->cycle_us) == CCGEN_OK);
    traffic_start(&traffic, &mix, bus->rule.window_us, bus->now_us + TRAFFIC_LAG_US);
    bus->traffic = &traffic;
}

static void start(bus_t *const bus, input_t *const input) {
    memset(bus, 0, sizeof *bus);
    bus->node = (port_node_t *)malloc(sizeof *bus->node); /* watched at its ends */
    CHECK(bus->node != NULL);
    memset(bus->node, MARK, sizeof *bus->node);
    CHECK(port_node_init(bus->node) == CCGEN_OK);
    bus->due = (uint16_t)(ccgen_layout_status_index(layout) + 1u);
    bus->health_due = true;
    bus->states = all_lost();
    bus->now_us = EPOCH_US + take32(input);
    bus->told_us = bus->now_us;
    rule_start(&bus->rule, numbers_of_joint(), layout->lengths_frames,
               layout->cycle_us, layout->window_us);
    read_zero(&bus->node->joint, bus->zero);
    blank(bus);
    check_angles(bus);
}

int LLVMFuzzerTestOneInput(const uint8_t *const data, const size_t size) {
    static bus_t bus; /* large */
    input_t input = {data, size};
    start(&bus, &input);
    if ((take8(&input) % 4u) == 1u) {
        start_sending(&bus, &input);
        for (int k = 0; (k < SENDING_MAX) && (input.left > 0u); ++k) {
            drawn ^= (uint64_t)take8(&input) << 32;
            drawn |= 1u;
            keep_sending(&bus, 8);
        }
    }
    for (int k = 0; (bus.traffic == NULL) && (k < STEPS_MAX) && (input.left > 0u); ++k) {
        step(&bus, &input);
        check_counters(&bus);
    }
    free(bus.node);
    return 0;
}
