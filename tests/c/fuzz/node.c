/**
 * \file node.c
 * \brief Fuzzes an exported joint's CAN node: frames good, damaged and foreign, time and requests.
 *
 * The input is a list of steps. Many frames get their check value repaired, so that what lies
 * behind the check is reached too. After every step:
 * - nothing is published but a complete set of frames of one counter, within the window, unharmed;
 * - angles are those of a plain 64-bit computation from the reference model;
 * - every frame that goes out is due, well-formed and protected, and says what the state says;
 * - each harmed frame is counted where it belongs, and no counter goes back.
 *
 * FUZZ_LAYOUT names the joint's layout. fuzz_reference.h defines `reference`, its two axes.
 */
#include <string.h>

#include "input.h"
#include "port_joint.h"

/** One axis of the reference model. */
typedef struct {
    uint8_t sensors;
    uint8_t shift;
    int64_t minimum[CCGEN_AXIS_SENSORS_MAX];
    int64_t maximum[CCGEN_AXIS_SENSORS_MAX];
    int64_t bias[PORT_SEGMENTS];
    int64_t weights[PORT_SEGMENTS][CCGEN_AXIS_SENSORS_MAX];
} reference_t;

#include "fuzz_reference.h" /* static const reference_t reference[2] */

#define SENSORS (PORT_SENSORS_U + PORT_SENSORS_V)
#define STEPS_MAX 400
#define QUIET_MAX_US 1800000000u /* ccgen_snapshot_tick() wants to be called each half hour */
#define LIMIT ((int64_t)((UINT64_C(1) << (PORT_PRECISION - 1)) - 1u))
#define MARK 0xA5

/** The first valid LENGTHS frame of its place in the snapshot in progress. */
typedef struct {
    bool came;
    int counter;
    uint64_t at_us;
    ccgen_frame_t frame;
} arrival_t;

/** The node and what an observer of its bus knows. */
typedef struct {
    port_node_t *node;
    uint64_t now_us;
    uint64_t ticked_us;
    uint64_t completed_us;
    bool completed;
    uint64_t started_us;
    bool started;
    uint16_t due; /* index of the next frame of an answer */
    uint8_t published;
    int missing;
    int64_t angles[2][PORT_SEGMENTS];
    bool estimated;
    uint32_t estimates;
    uint32_t failures;
    uint32_t overruns;
    uint8_t status_counter;
    int64_t zero[SENSORS];
    int32_t counts[SENSORS];              /* what the sensors' side sends */
    arrival_t arrivals[CCGEN_COUNTS_MAX]; /* by the frame's place among its kind */
} bus_t;

static const ccgen_layout_t *const layout = &FUZZ_LAYOUT;

static ccgen_snapshot_t *snapshot_of(bus_t *const bus) {
    return &bus->node->node.snapshot;
}

static uint32_t clock_of(const bus_t *const bus) {
    return (uint32_t)(bus->now_us & 0xFFFFFFFFu);
}

/** \return an integer of `bytes` bytes, written out so that it owes nothing to the runtime. */
static int64_t read_signed(const uint8_t *const data, const uint8_t bytes) {
    uint64_t word = 0;
    for (uint8_t i = 0; i < bytes; ++i) {
        word |= (uint64_t)data[i] << (8u * i);
    }
    const uint64_t sign = UINT64_C(1) << (8u * bytes - 1u);
    return (int64_t)(word ^ sign) - (int64_t)sign;
}

static int64_t lowest_of(const uint8_t bytes) {
    return -(int64_t)(UINT64_C(1) << (8u * bytes - 1u));
}

static const uint8_t *payload_of(const ccgen_frame_t *const frame) {
    return frame->data + ccgen_e2e_header(ccgen_layout_profile(layout));
}

/** \return count of a sensor in a frame; the type's lowest value for "no reading". */
static int64_t count_in(const ccgen_frame_t *const frame, const uint8_t place) {
    const int64_t count =
        read_signed(payload_of(frame) + place * layout->count_bytes, layout->count_bytes);
    return (count == lowest_of(layout->count_bytes)) ? INT32_MIN : count;
}

/** Every count of a complete snapshot is that of the first frame in its place. */
static void check_coherent(const bus_t *const bus) {
    const ccgen_snapshot_t *const snapshot = &bus->node->node.snapshot;
    const uint8_t per_frame = ccgen_layout_slots(layout, layout->count_bytes);
    for (uint16_t index = 0; index < SENSORS; ++index) {
        const arrival_t *const arrival = &bus->arrivals[index / per_frame];
        CHECK(arrival->came && (arrival->counter == snapshot->counter));
        CHECK((bus->now_us - arrival->at_us) <= snapshot->window_us);
        CHECK(snapshot->counts[index] == count_in(&arrival->frame, (uint8_t)(index % per_frame)));
    }
}

/** \return mask of sensors out of range, as the node tells it. */
static int missing_in(const ccgen_snapshot_t *const snapshot) {
    int mask = 0;
    for (uint8_t j = 0; j < SENSORS; ++j) {
        const bool is_v = (j >= PORT_SENSORS_U);
        const uint8_t sensor = (uint8_t)(is_v ? (j - PORT_SENSORS_U) : j);
        const reference_t *const axis = &reference[is_v ? 1 : 0];
        const int64_t count = snapshot->counts[j];
        const bool inside = (count >= axis->minimum[sensor]) && (count <= axis->maximum[sensor]);
        mask |= inside ? 0 : (1 << (sensor + (is_v ? 8 : 0)));
    }
    return mask;
}

/** The plain computation: acc, shift, saturation. */
static int64_t angle_of(const bus_t *const bus, const int32_t *const counts, const int which,
                        const uint16_t segment) {
    const reference_t *const axis = &reference[which];
    const uint8_t first = (which == 0) ? 0u : PORT_SENSORS_U;
    int64_t acc = axis->bias[segment];
    for (uint8_t j = 0; j < axis->sensors; ++j) {
        acc += axis->weights[segment][j] * ((int64_t)counts[first + j] - bus->zero[first + j]);
    }
    const int64_t angle = acc >> axis->shift;
    return (angle > LIMIT) ? LIMIT : (angle < -LIMIT) ? -LIMIT : angle;
}

static void check_angles(const bus_t *const bus) {
    for (uint16_t i = 0; i < PORT_SEGMENTS; ++i) {
        CHECK(bus->node->angles.u[i] == bus->angles[0][i]);
        CHECK(bus->node->angles.v[i] == bus->angles[1][i]);
    }
}

static void forget(bus_t *const bus) {
    memset(bus->arrivals, 0, sizeof bus->arrivals);
}

/** A snapshot is complete: it must be coherent, and the node's answer the reference's. */
static void publish(bus_t *const bus, const int result) {
    const ccgen_snapshot_t *const snapshot = snapshot_of(bus);
    check_coherent(bus);
    bus->missing = missing_in(snapshot);
    bus->estimated = (bus->missing == 0);
    CHECK(result == (bus->estimated ? 1 : CCGEN_ERROR_MISSING));
    for (uint16_t i = 0; (i < PORT_SEGMENTS) && bus->estimated; ++i) {
        bus->angles[0][i] = angle_of(bus, snapshot->counts, 0, i);
        bus->angles[1][i] = angle_of(bus, snapshot->counts, 1, i);
    }
    bus->estimates += bus->estimated ? 1u : 0u;
    bus->failures += bus->estimated ? 0u : 1u;
    bus->overruns += (bus->due <= ccgen_layout_status_index(layout)) ? 1u : 0u;
    bus->due = ccgen_layout_lengths_frames(layout);
    bus->published = snapshot->counter;
    bus->completed = true;
    bus->completed_us = bus->now_us;
    forget(bus);
}

/** Bit by bit, most significant first, over one byte. */
static uint32_t crc_byte(uint32_t crc, const uint8_t byte, const uint8_t bits,
                         const uint32_t polynomial) {
    crc ^= (uint32_t)byte << (bits - 8u);
    for (uint8_t k = 0; k < 8u; ++k) {
        crc = (crc << 1) ^ ((((crc >> (bits - 1u)) & 1u) != 0u) ? polynomial : 0u);
    }
    return crc & ((1u << bits) - 1u);
}

/** \return the check value of a frame, at least as long as its header. */
static uint32_t check_value(const ccgen_frame_t *const frame) {
    const uint8_t id[2] = {(uint8_t)(frame->id & 0xFFu), (uint8_t)((frame->id >> 8) & 0xFFu)};
    uint32_t crc = 0xFFFFu;
    if (layout->fd) {
        for (uint8_t i = 2; i < frame->length; ++i) {
            crc = crc_byte(crc, frame->data[i], 16, 0x1021u);
        }
        return crc_byte(crc_byte(crc, id[0], 16, 0x1021u), id[1], 16, 0x1021u);
    }
    crc = crc_byte(crc_byte(0, id[0], 8, 0x1Du), id[1], 8, 0x1Du);
    for (uint8_t i = 1; i < frame->length; ++i) {
        crc = crc_byte(crc, frame->data[i], 8, 0x1Du);
    }
    return crc;
}

/** \return the counter of a frame that a receiver must take; negative: why it must not. */
static int verdict(const ccgen_frame_t *const frame) {
    if (frame->remote || (frame->fd != layout->fd) || (frame->length != (layout->fd ? 64u : 8u))) {
        return CCGEN_ERROR_FORMAT;
    }
    const uint32_t crc = check_value(frame);
    const uint32_t told =
        layout->fd ? (frame->data[0] | ((uint32_t)frame->data[1] << 8)) : frame->data[0];
    const int counter = layout->fd ? frame->data[2] : (frame->data[1] & 0x0F);
    if (crc != told) {
        return CCGEN_ERROR_CRC;
    }
    return (layout->fd || (counter < 15)) ? counter : CCGEN_ERROR_FORMAT;
}

static bool is_lengths(const ccgen_frame_t *const frame) {
    return (frame->extended == layout->extended) && (frame->id >= layout->base_id) &&
           ((frame->id - layout->base_id) < ccgen_layout_lengths_frames(layout));
}

/** Counters only grow; a frame is counted as harmed when it is, and only then. */
static void check_counters(const ccgen_snapshot_t *const before,
                           const ccgen_snapshot_t *const after, const bool lengths,
                           const int counter) {
    const bool harmed = lengths && (counter < 0);
    const bool corrupted = harmed && (counter == CCGEN_ERROR_CRC);
    const uint32_t repeated = after->repeated - before->repeated;
    const uint32_t reordered = after->reordered - before->reordered;
    const uint32_t late = after->late - before->late;
    const uint32_t complete = after->snapshots - before->snapshots;
    CHECK((after->corrupted - before->corrupted) == (corrupted ? 1u : 0u));
    CHECK((after->malformed - before->malformed) == ((harmed && !corrupted) ? 1u : 0u));
    CHECK((repeated <= 1u) && (reordered <= 1u) && (late <= 1u) && (complete <= 1u));
    CHECK((repeated + reordered + late + complete) <= ((lengths && !harmed) ? 1u : 0u));
    CHECK((after->lost - before->lost) <= 256u);
}

/** Keeps the valid frames since the snapshot in progress began. */
static void remember(bus_t *const bus, const ccgen_snapshot_t *const before, const int counter,
                     const ccgen_frame_t *const frame) {
    ccgen_snapshot_t ticked = *before;
    (void)ccgen_snapshot_tick(layout, &ticked, clock_of(bus));
    const uint16_t modulus = ccgen_e2e_counter_modulus(ccgen_layout_profile(layout));
    const uint16_t ahead =
        (uint16_t)((snapshot_of(bus)->newest + modulus - before->newest) % modulus);
    CHECK((ticked.phase == CCGEN_SNAPSHOT_NONE) || ((2u * ahead) < modulus));
    if ((ticked.phase == CCGEN_SNAPSHOT_NONE) || (ahead > 0u)) {
        forget(bus);
    }
    arrival_t *const arrival = &bus->arrivals[frame->id - layout->base_id];
    if ((counter == snapshot_of(bus)->newest) && !arrival->came) {
        arrival->came = true;
        arrival->counter = counter;
        arrival->at_us = bus->now_us;
        arrival->frame = *frame;
    }
}

static void receive(bus_t *const bus, const ccgen_frame_t *const frame) {
    const ccgen_snapshot_t before = *snapshot_of(bus);
    const bool lengths = is_lengths(frame);
    const int counter = verdict(frame);
    const int result = port_node_receive(bus->node, frame, clock_of(bus));
    bus->ticked_us = bus->now_us;
    if (!bus->started) {
        bus->started = true;
        bus->started_us = bus->now_us;
    }
    if (lengths && (counter >= 0)) {
        remember(bus, &before, counter, frame);
    }
    check_counters(&before, snapshot_of(bus), lengths, counter);
    if (snapshot_of(bus)->snapshots != before.snapshots) {
        publish(bus, result);
    } else {
        CHECK(result == 0);
        CHECK(memcmp(before.counts, snapshot_of(bus)->counts, sizeof before.counts) == 0);
    }
    check_angles(bus);
}

/** What a frame does not need is 0. */
static void check_rest(const uint8_t *const payload, const size_t used) {
    const size_t all =
        ccgen_layout_frame_length(layout) - ccgen_e2e_header(ccgen_layout_profile(layout));
    for (size_t i = used; i < all; ++i) {
        CHECK(payload[i] == 0u);
    }
}

static void check_status(const bus_t *const bus, const ccgen_snapshot_t *const before,
                         const uint8_t *const payload) {
    const uint64_t age_ms = (bus->now_us - bus->completed_us) / 1000u;
    const uint64_t since_us = bus->now_us - (bus->completed ? bus->completed_us : bus->started_us);
    CHECK((payload[0] | ((uint32_t)payload[1] << 8)) == (before->snapshots & 0xFFFFu));
    CHECK((payload[2] | (payload[3] << 8)) == bus->missing);
    CHECK((payload[4] & before->faults) == before->faults);
    CHECK((payload[4] & CCGEN_FAULT_STALE) != 0 || since_us <= (3u * (uint64_t)layout->cycle_us));
    check_rest(payload, 6);
    CHECK(payload[5] == ((bus->completed && (age_ms < 255u)) ? age_ms : 255u));
}

static void check_answer(const bus_t *const bus, const uint16_t index,
                         const ccgen_frame_t *const frame) {
    const uint8_t *const payload = payload_of(frame);
    const uint8_t bytes = layout->angle_bytes;
    const uint8_t per_frame = ccgen_layout_slots(layout, bytes);
    const uint16_t tip = ccgen_layout_tip_index(layout);
    if (index == tip) {
        for (uint8_t i = 0; i < 3u; ++i) {
            CHECK((read_signed(payload + 2u * i, 2) == lowest_of(2)) == !bus->estimated);
        }
        check_rest(payload, 6);
        return;
    }
    size_t used = 0;
    size_t place = (size_t)(index - ccgen_layout_lengths_frames(layout)) * per_frame;
    for (uint8_t i = 0; (i < per_frame) && (place < (2u * PORT_SEGMENTS)); ++i) {
        const int64_t angle = bus->angles[place / PORT_SEGMENTS][place % PORT_SEGMENTS];
        CHECK(read_signed(payload + used, bytes) == (bus->estimated ? angle : lowest_of(bytes)));
        used += bytes;
        ++place;
    }
    check_rest(payload, used);
}

/** Fetches one frame and checks it. \return whether there was one. */
static bool transmit(bus_t *const bus) {
    const uint16_t status = ccgen_layout_status_index(layout);
    const ccgen_snapshot_t before = *snapshot_of(bus);
    ccgen_frame_t untouched;
    ccgen_frame_t frame;
    memset(&untouched, MARK, sizeof untouched);
    memset(&frame, MARK, sizeof frame);
    const int result = port_node_transmit(bus->node, clock_of(bus), &frame);
    bus->ticked_us = bus->now_us;
    if (!bus->started) {
        bus->started = true;
        bus->started_us = bus->now_us;
    }
    check_counters(&before, snapshot_of(bus), false, 0);
    CHECK((result == 1) || ((result == 0) && (bus->due > status)));
    if (result == 0) {
        CHECK(memcmp(&frame, &untouched, sizeof frame) == 0);
        return false;
    }
    const uint16_t index = (bus->due <= status) ? bus->due : status;
    CHECK(verdict(&frame) == ((index == status) ? bus->status_counter : bus->published));
    CHECK((frame.id == (layout->base_id + index)) && (frame.extended == layout->extended));
    CHECK(memcmp(&frame.data[frame.length], untouched.data, sizeof frame.data - frame.length) == 0);
    if (index == status) {
        const uint16_t modulus = ccgen_e2e_counter_modulus(ccgen_layout_profile(layout));
        check_status(bus, &before, payload_of(&frame));
        bus->status_counter = (uint8_t)((bus->status_counter + 1u) % modulus);
        CHECK(snapshot_of(bus)->faults == 0u);
    } else {
        check_answer(bus, index, &frame);
    }
    bus->due = (uint16_t)((bus->due <= status) ? (bus->due + 1u) : bus->due);
    return true;
}

/** Lets time pass; now and then until the clock has come round since the latest snapshot. */
static void advance(bus_t *const bus, input_t *const input) {
    const uint8_t scale = (uint8_t)(take8(input) % 18u);
    const uint64_t step_us = (uint64_t)take16(input) << scale;
    const uint64_t round_us = bus->completed_us + UINT64_C(0x100000000) + (step_us % 0x40000u);
    const uint64_t until_us = (scale == 17u) ? round_us : (bus->now_us + step_us);
    while (bus->now_us < until_us) {
        const uint64_t left_us = until_us - bus->now_us;
        if ((bus->now_us - bus->ticked_us) >= QUIET_MAX_US) {
            (void)transmit(bus);
        }
        const uint64_t quiet_us = QUIET_MAX_US - (bus->now_us - bus->ticked_us);
        bus->now_us += (left_us < quiet_us) ? left_us : quiet_us;
    }
}

/** Changes what the sensors read: mostly within range, now and then anything. */
static void move_sensors(bus_t *const bus, input_t *const input) {
    const uint8_t how = take8(input);
    for (uint8_t j = 0; j < SENSORS; ++j) {
        const bool is_v = (j >= PORT_SENSORS_U);
        const uint8_t sensor = (uint8_t)(is_v ? (j - PORT_SENSORS_U) : j);
        const reference_t *const axis = &reference[is_v ? 1 : 0];
        const uint64_t places = (uint64_t)(axis->maximum[sensor] - axis->minimum[sensor]) + 1u;
        const uint32_t word = take32(input);
        const int64_t inside = axis->minimum[sensor] + (int64_t)(word % places);
        bus->counts[j] = (int32_t)inside;
        if ((how % 8u) == 0u) {
            const uint8_t raw[4] = {(uint8_t)word, (uint8_t)(word >> 8), (uint8_t)(word >> 16),
                                    (uint8_t)(word >> 24)};
            bus->counts[j] = (int32_t)read_signed(raw, layout->count_bytes);
        } else if ((how % 8u) == 1u) {
            bus->counts[j] =
                (int32_t)(((word & 1u) != 0u) ? axis->maximum[sensor] : axis->minimum[sensor]);
        }
    }
}

/** The LENGTHS frame that a sound sender would send. */
static void make_lengths(const bus_t *const bus, const uint16_t slot, const uint8_t counter,
                         ccgen_frame_t *const frame) {
    const uint8_t bytes = layout->count_bytes;
    const uint8_t per_frame = ccgen_layout_slots(layout, bytes);
    uint8_t *const payload = frame->data + ccgen_e2e_header(ccgen_layout_profile(layout));
    memset(frame, 0, sizeof *frame);
    ccgen_layout_begin(layout, slot, frame);
    for (uint8_t i = 0; i < per_frame; ++i) {
        const size_t index = (size_t)slot * per_frame + i;
        if (index < SENSORS) {
            ccgen_put_signed(&payload[i * bytes], bytes, bus->counts[index]);
        }
    }
    CHECK(ccgen_layout_protect(layout, counter, frame) == CCGEN_OK);
}

/** A whole snapshot under the next counter: whatever came before, the node must take it. */
static void send_snapshot(bus_t *const bus, input_t *const input) {
    const uint16_t modulus = ccgen_e2e_counter_modulus(ccgen_layout_profile(layout));
    const uint16_t ahead = (uint16_t)(1u + take8(input) % (modulus / 4u));
    const uint8_t counter = (uint8_t)((snapshot_of(bus)->newest + ahead) % modulus);
    const uint32_t snapshots = snapshot_of(bus)->snapshots;
    ccgen_frame_t frame;
    for (uint16_t slot = 0; slot < ccgen_layout_lengths_frames(layout); ++slot) {
        CHECK(snapshot_of(bus)->snapshots == snapshots);
        make_lengths(bus, slot, counter, &frame);
        receive(bus, &frame);
    }
    CHECK(snapshot_of(bus)->snapshots == (snapshots + 1u));
}

/** One frame of a snapshot, alone, under some counter near the newest. */
static void make_one(const bus_t *const bus, input_t *const input, ccgen_frame_t *const frame) {
    const uint16_t modulus = ccgen_e2e_counter_modulus(ccgen_layout_profile(layout));
    const uint16_t slot = (uint16_t)(take8(input) % ccgen_layout_lengths_frames(layout));
    const uint8_t ahead = take8(input);
    const uint16_t counter =
        (uint16_t)((bus->node->node.snapshot.newest + ((ahead < 128u) ? (ahead % 4u) : ahead)) %
                   modulus);
    make_lengths(bus, slot, (uint8_t)counter, frame);
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
    frame->length = ccgen_layout_frame_length(layout);
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

static void capture_zero(bus_t *const bus) {
    port_counts_t counts;
    port_count_t *const lists[2] = {counts.u, counts.v};
    bool inside = true;
    for (uint8_t j = 0; j < SENSORS; ++j) {
        const bool is_v = (j >= PORT_SENSORS_U);
        const uint8_t sensor = (uint8_t)(is_v ? (j - PORT_SENSORS_U) : j);
        const reference_t *const axis = &reference[is_v ? 1 : 0];
        lists[is_v ? 1 : 0][sensor] = (port_count_t)bus->counts[j];
        inside = inside && (bus->counts[j] >= axis->minimum[sensor]) &&
                 (bus->counts[j] <= axis->maximum[sensor]);
    }
    CHECK(port_capture_zero(&bus->node->joint, &counts) ==
          (inside ? CCGEN_OK : CCGEN_ERROR_MISSING));
    for (uint8_t j = 0; (j < SENSORS) && inside; ++j) {
        bus->zero[j] = bus->counts[j];
    }
}

static void step(bus_t *const bus, input_t *const input) {
    ccgen_frame_t frame;
    switch (take8(input) % 10u) {
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
            }
            break;
        case 6:
            capture_zero(bus);
            break;
        case 7: {
            const uint32_t window_us = take32(input);
            const bool fits = (window_us >= 1u) && (window_us <= CCGEN_PERIOD_MAX_US);
            CHECK((port_node_set_window(bus->node, window_us) == CCGEN_OK) == fits);
            break;
        }
        default:
            make_one(bus, input, &frame);
            receive(bus, &frame);
            break;
    }
}

static void check_totals(const bus_t *const bus) {
    CHECK(bus->node->node.estimates == bus->estimates);
    CHECK(bus->node->node.failures == bus->failures);
    CHECK(bus->node->node.overruns == bus->overruns);
    CHECK(bus->node->node.missing == bus->missing);
    CHECK(bus->node->node.snapshot.snapshots == (bus->estimates + bus->failures));
}

static void start(bus_t *const bus, input_t *const input) {
    memset(bus, 0, sizeof *bus);
    bus->node = (port_node_t *)malloc(sizeof *bus->node); /* watched at its ends */
    CHECK(bus->node != NULL);
    memset(bus->node, MARK, sizeof *bus->node);
    CHECK(port_node_init(bus->node) == CCGEN_OK);
    bus->due = (uint16_t)(ccgen_layout_status_index(layout) + 1u);
    bus->now_us = take32(input);
    bus->ticked_us = bus->now_us;
    for (uint8_t j = 0; j < PORT_SENSORS_U; ++j) {
        bus->zero[j] = bus->node->joint.zero.u[j];
    }
    for (uint8_t j = 0; j < PORT_SENSORS_V; ++j) {
        bus->zero[PORT_SENSORS_U + j] = bus->node->joint.zero.v[j];
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *const data, const size_t size) {
    static bus_t bus; /* large */
    input_t input = {data, size};
    start(&bus, &input);
    for (int k = 0; (k < STEPS_MAX) && (input.left > 0u); ++k) {
        step(&bus, &input);
        check_totals(&bus);
    }
    free(bus.node);
    return 0;
}
