"""Mutants of what `firmware_c/include` computes, on the host and on emulated cores."""

from mutants.mutant import Group, of

CORES = ("test_runtime_cores.py",)
THUMB1 = "(cortex-m0 or cortex_m0) and not O0"  # where the loop in assembly is compiled in


def on_host(file: str, *changes: tuple[str, ...]) -> Group:
    """Mutants of what the host computes, without the builds that take a compiler long."""
    return of(file, ("test_runtime_estimator.py",), *changes, chosen="not O2 and not O3")


INTEGER = of(
    "include/ccgen/integer.h",
    ("test_runtime_integer.py",),
    ("(word <= 0x7FFFu)", "(word < 0x7FFFu)", "the other branch gives 32767 too"),
    ("- word) - 1)", "- word))"),
    ("CCGEN_CAST(int32_t, ~word) - 1", "CCGEN_CAST(int32_t, ~word)"),
    ("CCGEN_CAST(int64_t, ~word) - 1", "CCGEN_CAST(int64_t, ~word)"),
    ("ccgen_signed32(word) >> 16", "ccgen_signed32(word) >> 15"),
)

SENSORS = (
    of(
        "include/ccgen/sensors16.h",
        ("test_runtime_sensors.py",),
        (
            "<= (uint32_t)(maximum - minimum)",
            "< (uint32_t)(maximum - minimum)",
        ),
        ("(uint32_t)(counts[j] - minimum)", "(uint32_t)(counts[j] - minimum + 1)"),
        ("difference >= CCGEN_FLASH_INT32(", "difference > CCGEN_FLASH_INT32("),
        ("difference <= CCGEN_FLASH_INT32(", "difference < CCGEN_FLASH_INT32("),
        (" || (sensors->difference_minimum == NULL)", " || true"),
        ("(int32_t)counts[j] - zero[j]", "(int32_t)counts[j] + zero[j]"),
        ("(has ? 0u : (UINT32_C(1) << j))", "(has ? 0u : (UINT32_C(1) << (j / 2u)))"),
        ("ccgen_sensors16_missing(sensors, zero, counts) == 0u", "true"),
        ("ccgen_sensors16_has(sensors, zero, counts, 0) &&", "true &&"),
        ("ccgen_sensors16_has(sensors, zero, counts, 7)", "true"),
        ("(value >= CCGEN_FLASH_INT16(", "(value > CCGEN_FLASH_INT16("),
        ("(value <= CCGEN_FLASH_INT16(", "(value < CCGEN_FLASH_INT16("),
        ("(mask << 1) | (inside ? 0u : 1u)", "(mask << 1) | (inside ? 0u : 2u)"),
    ),
    of(
        "include/ccgen/sensors32.h",
        ("test_runtime_sensors.py",),
        ("counts[j] >= CCGEN_FLASH_INT32(", "counts[j] > CCGEN_FLASH_INT32("),
        ("counts[j] <= CCGEN_FLASH_INT32(", "counts[j] < CCGEN_FLASH_INT32("),
        ("difference >= CCGEN_FLASH_INT32(", "difference > CCGEN_FLASH_INT32("),
        ("difference <= CCGEN_FLASH_INT32(", "difference < CCGEN_FLASH_INT32("),
        (" || (sensors->difference_minimum == NULL)", " || true"),
        ("(int64_t)counts[j] - zero[j]", "(int64_t)counts[j] + zero[j]"),
        ("(has ? 0u : (UINT32_C(1) << j))", "(has ? 0u : (UINT32_C(1) << (j / 2u)))"),
        ("ccgen_sensors32_missing(sensors, zero, counts) == 0u", "true"),
        ("ccgen_sensors32_has(sensors, zero, counts, 0) &&", "true &&"),
        ("ccgen_sensors32_has(sensors, zero, counts, 7)", "true"),
        ("(value >= CCGEN_FLASH_INT32(", "(value > CCGEN_FLASH_INT32("),
        ("(value <= CCGEN_FLASH_INT32(", "(value < CCGEN_FLASH_INT32("),
        ("(mask << 1) | (inside ? 0u : 1u)", "(mask << 1) | (inside ? 0u : 2u)"),
    ),
)

ESTIMATORS = (
    on_host(
        "include/ccgen/axis16.h",
        ("((int32_t)(low) + 0x8000)", "((int32_t)(low))"),
    ),
    on_host(
        "include/ccgen/estimator16.h",
        (
            "ccgen_evaluate16(axis, zero, counts, false, angles);",
            "ccgen_evaluate16(axis, zero, counts, true, angles);",
        ),
    ),
    on_host(
        "include/ccgen/estimator32.h",
        ("(uint64_t)axis->bias + ccgen_axis32_offset(axis)", "(uint64_t)axis->bias"),
        ("(uint32_t)(start >> 32)", "0u"),
        ("ccgen_axis32_difference(axis, zero, counts, 7)", "0"),
        ("uint8_t j = CCGEN_UNROLLED_MAX;", "uint8_t j = CCGEN_UNROLLED_MAX + 1u;"),
    ),
)

FACTORS16 = on_host(
    "include/ccgen/factors16.h",
    ("((axis->sensors + 1u) / 2u)", "(axis->sensors / 2u)"),
    (
        "(difference >= INT16_MIN)",
        "(difference > INT16_MIN)",
        "a difference that fits takes the path of one that does not, which gives the same bits",
    ),
    ("(difference >= INT16_MIN)", "(difference >= INT16_MIN - 1)"),
    ("(difference <= INT16_MAX)", "(difference <= INT16_MAX + 1)"),
    ("ccgen_fits16(axis, zero, counts, 0) && ", ""),
    (" && ccgen_fits16(axis, zero, counts, 7)", ""),
    ("uint8_t j = CCGEN_UNROLLED_MAX;", "uint8_t j = CCGEN_UNROLLED_MAX + 1u;"),
    (
        "(ccgen_difference16(axis, zero, counts, a) & 0xFFFFu)",
        "ccgen_difference16(axis, zero, counts, a)",
    ),
    ("(zero_a & 0xFFFFu)", "zero_a"),
    ("0u - (uint32_t)ccgen_value16(axis, zero, b)", "(uint32_t)ccgen_value16(axis, zero, b)"),
    ("difference << 15;", "difference << 14;"),
    (" - (difference << 16);", ";"),
    ("return bias + ((uint32_t)CCGEN_ANGLE16_LIMIT << axis->shift);", "return bias;"),
)

KERNEL16 = on_host(
    "include/ccgen/kernel16.h",
    ("if (2u * k >= axis->sensors) {", "if (2u * k + 1u >= axis->sensors) {"),
    ("sum, ccgen_low16(a), ccgen_low16(b)", "sum, ccgen_low16(a), ccgen_high16(b)"),
    ("const bool two = 2u * k + 1u < ", "const bool two = 2u * k + 2u < "),
    ("factors->narrow ? most", "true ? most"),
    ("(2u * k + 1u < axis->sensors)", "(2u * k + 2u < axis->sensors)"),
    ("(uint32_t)(ccgen_signed32(weights) >> 16)", "(weights >> 16)"),
    (
        "        if (steps > 2u * CCGEN_ANGLE16_LIMIT) {",
        "        if (steps >= 2u * CCGEN_ANGLE16_LIMIT) {",
        "the highest angle is clipped to itself",
    ),
    (
        "        if (steps > 2u * CCGEN_ANGLE16_LIMIT) {",
        "        if (steps > 2u * CCGEN_ANGLE16_LIMIT + 1u) {",
    ),
    ("steps = sum >> axis->shift;", "steps = (uint32_t)(ccgen_signed32(sum) >> axis->shift);"),
    ("? 0u : 2u * CCGEN_ANGLE16_LIMIT", "? 1u : 2u * CCGEN_ANGLE16_LIMIT"),
    ("(without >= 0x80000000u)", "(without >= 0x8000u)"),
    (
        "(without >= 0x80000000u)",
        "(without > 0x80000000u)",
        "the exporter proves that no sum is -2^31",
    ),
    (
        "        steps -= CCGEN_ANGLE16_LIMIT; /* MISRA 10.4 */\n",
        "        steps -= CCGEN_ANGLE16_LIMIT - 1u;\n",
    ),
    ("ccgen_words16(axis) > (pair + 1u)", "ccgen_words16(axis) > pair"),
    ("        sum += (uint32_t)biases[k];\n", ""),
    ("            biases += turn;\n", ""),
    ("    sum = ccgen_add_pairs16(axis, sum, factors, row, 1);\n", ""),
    ("        angle += turn;\n", "        angle += 1;\n"),
    ("ccgen_prepare16(axis, zero, counts, 3, &factors);", ""),
    ("uint8_t pair = CCGEN_PAIRS_UNROLLED;", "uint8_t pair = CCGEN_PAIRS_UNROLLED + 1u;"),
    ("uint8_t pair = 0;", "uint8_t pair = 1;"),
)

KERNEL16_ON_CORES = (
    of(
        "include/ccgen/kernel16.h",
        CORES,
        (" &&\n        (axis->sensors <= CCGEN_UNROLLED_MAX)) {", ") {"),
        chosen=THUMB1,
    ),
    of(
        "include/ccgen/kernel16.h",
        CORES,
        ("(uint32_t)__qadd16(ccgen_signed32(clipped), 1)", "clipped + 1u"),
        ("__ssat(value, 16)", "__ssat(value, 15)"),
        chosen="cortex-m4 and not instructions",
    ),
    of(
        "include/ccgen/kernel16.h",
        CORES,
        ("clipped + ((clipped + CCGEN_ANGLE16_LIMIT) >> 31);", "clipped;"),
        chosen="cortex-m3",
    ),
    of(
        "include/ccgen/kernel16.h",
        ("test_polynomial_cores.py::test_products_in_avrs_assembly_have_the_bits_of_plain_c",),
        ("ccgen_right(steps, axis->shift)", "ccgen_right(steps, 8)"),
        ("steps >>= 8;", "steps >>= 7;"),
    ),
    of(
        "include/ccgen/factors16.h",
        CORES,
        ("return bias - ((uint32_t)1 << axis->shift);", "return bias;"),
        chosen="cortex-m4 and not instructions",
    ),
)

KERNEL32 = on_host(
    "include/ccgen/kernel32.h",
    ("uint8_t sensor = 0;", "uint8_t sensor = 1;"),
    (
        "(uint32_t)counts[sensor] - (uint32_t)zero[sensor]",
        "(uint32_t)counts[sensor] + (uint32_t)zero[sensor]",
    ),
    (
        "if (sensor >= axis->sensors) {",
        "if (sensor > axis->sensors) {",
        "there the second weight of a pair is 0",
    ),
    ("(int64_t)ccgen_signed32(weight)", "(int64_t)weight"),
    ("axis->sensors > (sensor + 1u)", "axis->sensors > sensor"),
    ("((uint64_t)0x80000000u << axis->shift)", "((uint64_t)0x40000000u << axis->shift)"),
    ("ccgen_signed64(sum) >> axis->shift", "sum >> axis->shift"),
    ("(sum >> 32) >= ((uint64_t)1 << axis->shift)", "(sum >> 32) > ((uint64_t)1 << axis->shift)"),
    ("? 0u : 0xFFFFFFFFu", "? 0xFFFFFFFFu : 0u"),
    ("(steps == 0u) ? 1u : steps", "steps"),
    ("((uint64_t)factors->start_high << 32) | factors->start_low", "factors->start_low"),
    ("        sum += (uint64_t)biases[k];\n", ""),
    ("    sum = ccgen_axis32_add_pair(axis, sum, factors, row, 3);\n", ""),
    ("            biases += turn;\n", ""),
)

LOAD = on_host(
    "include/ccgen/load.h",
    ("(segments % 4u)", "(segments % 2u)"),
    ("(segments % 3u) == 0u", "true"),
    ("(segments % 2u) == 0u", "true"),
    ("    *second = ccgen_load(from);\n", "    *second = **from;\n"),
)

LOAD_ON_CORES = of(
    "include/ccgen/load.h",
    CORES,
    ('"ldrd %0, %1, [%2], #8"', '"ldrd %0, %1, [%2], #4"'),
    ('"ldr %0, [%1], #4"', '"ldr %0, [%1]"'),
    chosen="cortex-m3",
)

KERNEL16_THUMB1 = of(
    "include/ccgen/kernel16_thumb1.h",
    CORES,
    ('".if %c[sensors] > " #b "\\n"', '".if %c[sensors] > 1 + " #b "\\n"'),
    ('"asrs " word ", " word ", #16\\n"', '"lsrs " word ", " word ", #16\\n"'),
    ('"asrs " word ", " word ", #16\\n"', '"asrs " word ", " word ", #15\\n"'),
    (
        "&CCGEN_THUMB1_FACTOR(6), &CCGEN_THUMB1_FACTOR(7)",
        "&CCGEN_THUMB1_FACTOR(7), &CCGEN_THUMB1_FACTOR(6)",
    ),
    ('"subs r5, r5, #2\\n"', '"subs r5, r5, #1\\n"'),
    ('"lsrs r5, r5, #1\\n"', '"lsrs r5, r5, #2\\n"'),
    ('"negs r5, r5\\n"', '""'),
    (
        '"bhi  .Lccgen_clip_',
        '"bhs  .Lccgen_clip_',
        "the highest angle is clipped to itself",
    ),
    ('"bhi  .Lccgen_clip_', '"bgt  .Lccgen_clip_'),
    ('".if %c[sensors] > 2\\n"', '".if %c[sensors] > 1\\n"'),
    ('".if %c[sensors] > 6\\n"', '".if %c[sensors] > 7\\n"'),
    ('".elseif %c[sensors] > 4\\n"', '".elseif %c[sensors] > 5\\n"'),
    ('CCGEN_THUMB1_PAIR("r3", 2, 3)', 'CCGEN_THUMB1_PAIR("r2", 2, 3)'),
    ('CCGEN_THUMB1_PAIR("r3", 6, 7)', 'CCGEN_THUMB1_PAIR("r3", 7, 6)'),
    ('CCGEN_THUMB1_SHIFT("lsrs")', 'CCGEN_THUMB1_SHIFT("asrs")'),
    ('CCGEN_THUMB1_SHIFT("asrs")', 'CCGEN_THUMB1_SHIFT("lsrs")'),
    ('CCGEN_THUMB1_SHIFT("lsls")', 'CCGEN_THUMB1_SHIFT("lsrs")'),
    ('".if %c[bits]\\n"', '".if %c[bits] > 7\\n"'),
    ('"strh r5, [%[angle], #2*\\\\i]\\n"', '"strh r5, [%[angle], #0]\\n"'),
    ('"adds %[angle], %[angle], #2*%c[turn]\\n"', '"adds %[angle], %[angle], #2\\n"'),
    (
        '".if %c[turn]*(5+4*%c[sensors]) < 116\\n"',
        '".if %c[turn]*(5+4*%c[sensors]) < 50\\n"',
        "a loop that a short branch would close is closed by a long one",
    ),
    ('"b    2f\\n"', '""'),
    (
        '"asrs r5, r5, #31\\n"',
        '"asrs r5, r5, #30\\n"',
        "the bit that this leaves in place of the sign's is the one that 65534 lacks",
    ),
    ('"mvns r5, r5\\n"', '""'),
    ('"ands r5, r5, r6\\n"', '""'),
    ('[saturates] "i"(axis->saturates)', '[saturates] "i"(0)'),
    ('[bits] "i"(known ? axis->shift : 0)', '[bits] "i"(axis->shift & 15)'),
    chosen=THUMB1,
)

PRODUCT = of(
    "include/ccgen/product.h",
    ("test_polynomial.py::test_products_are_rounded_down_by_either_kind_of_core",),
    ("(b * INT32_C(65536))", "(b * INT32_C(32768))"),
    ("(CCGEN_CAST(int64_t, a) * b) >> 32", "(CCGEN_CAST(int64_t, a) * b) >> 31"),
    ("CCGEN_UNSIGNED(a)) >> 16);", "CCGEN_UNSIGNED(a)) >> 17);"),
    (" + lowest;", ";"),
    ("CCGEN_UNSIGNED(b)) >> 16);", "CCGEN_UNSIGNED(b)) >> 17);"),
    (" + (first & 0xFFFF);", ";"),
    ("(first & 0xFFFF)", "(first & 0x7FFF)"),
    ("(second >> 16);", "0;"),
    ("    return a * b;\n", "    return a + b;\n"),
    ("return sum + CCGEN_CAST(uint32_t, ", "return sum - CCGEN_CAST(uint32_t, "),
)

AVR_PRODUCT = of(
    "include/ccgen/product.h",
    ("test_polynomial_cores.py::test_products_in_avrs_assembly_have_the_bits_of_plain_c",),
    ('"mov %[behind], r1\\n\\t"', '"clr %[behind]\\n\\t"'),
    ("a >> (bits & ~7)", "a >> (bits & ~15)"),
    (
        "} else if (bits < 16) {",
        "} else if (bits < 24) {",
        "a byte more is shifted, which holds signs alone and stays as it is: slower, the same bits",
    ),
    ('mov %D0, %C0"\n                : ', 'mov %D0, %D0"\n                : '),
    ("            __asm__(once once : ", "            __asm__(once : "),
    ("CCGEN_HALVE(result, bits, CCGEN_HALVE_3)", "CCGEN_HALVE(result, bits, CCGEN_HALVE_2)"),
    (
        '"mul %C[a], %A[b]\\n\\t"\n        "add %C[p], r0',
        '"mul %C[a], %B[b]\\n\\t"\n        "add %C[p], r0',
    ),
    ('"adc %C[s], %[zero]\\n\\t"', '"adc %C[s], r0\\n\\t"'),
    ('"mov %[x], r1\\n\\t"', '"mov %[x], r0\\n\\t"'),
)

QUEUE = of(
    "include/ccgen/queue.h",
    (
        "test_runtime_queue.py::test_frames_come_out_whole_and_in_order_whenever_the_interrupt_strikes",
    ),
    (
        "(CCGEN_CAST(uint8_t, head - queue->tail) == CCGEN_QUEUE_PLACES) ||",
        "(CCGEN_CAST(uint8_t, head - queue->tail) == 255) ||",
    ),
    ("    queue->at_us[place] = now_us;\n", ""),
    ("    to->remote = frame->remote;\n", ""),
    ("    to->rate_switch = frame->rate_switch;\n", ""),
    ("    frame->extended = from->extended;\n", ""),
    ("    if (queue->head == tail) {\n        return false;\n    }\n", ""),
    (
        "queue->tail = CCGEN_CAST(uint8_t, tail + 1u)",
        "queue->tail = CCGEN_CAST(uint8_t, tail + 2u)",
    ),
    ("(frame->length > CCGEN_FRAME_CAPACITY)", "false"),
)

CHECKED = ("test_runtime_check.py",)


def check_of(bits: int) -> Group:
    """Mutants of parity values, and of what is quiet."""
    return of(
        f"include/ccgen/check{bits}.h",
        CHECKED,
        ("all |= ", "all = "),
        ("(all >> check->quiet_bits) >> 1", "all >> check->quiet_bits"),
        (f"(uint{2 * bits}_t)1 << check->quiet_bits", f"(uint{2 * bits}_t)1 << check->shift"),
        ("-(parity[i] + 1) : parity[i]", "-(parity[i] + 1) : 0"),
        ("sizes > 0x7FFFu", "sizes > 0xFFFFu"),
        ("sizes >>= check->shift", "sizes >>= 0"),
        (" >> (check->shift + more)", " >> check->shift"),
        ("    if (!ccgen_alarms(", "    if (ccgen_alarms("),
        ("parity + kept, ", "parity, "),
        ("rows->sensors > CCGEN_UNROLLED_MAX", "rows->sensors > 1u + CCGEN_UNROLLED_MAX"),
    )


RESIDUALS = of(
    "include/ccgen/residuals.h",
    CHECKED,
    ("(0u - sum)", "sum"),
    ("        row += check->sensors;\n", "        row += values;\n"),
    (
        "(size[j] > largest)",
        "(size[j] >= largest)",
        "where two are as large nobody is named, whichever comes first",
    ),
    ("            second = largest;\n", ""),
    ("        } else if (size[j] > second) {\n", "        } else if (size[j] > largest) {\n"),
    ("            first = j;\n", ""),
    ("((largest - second) > margin)", "((largest - second) >= margin)"),
    ("(&check->margin[first]) >> more", "(&check->margin[first])"),
    ("size[j] > ((uint32_t)CCGEN_FLASH_INT32(", "size[j] >= ((uint32_t)CCGEN_FLASH_INT32("),
    ("(&check->threshold[j]) >> more", "(&check->threshold[j])"),
)


def serving_of(bits: int, rows: str) -> Group:
    """Mutants of what serves while sensors are absent."""
    return of(
        f"include/ccgen/serving{bits}.h",
        CHECKED,
        ("(absent & (absent - 1u)) != 0u", "absent > 0xFFFFu"),
        ("        return own;\n", "        return without;\n"),
        ("rest > 1u", "rest > 2u"),
        (f"(CCGEN_FLASH_POINTER(&one->{rows}) != NULL) ? one : NULL", "one"),
        ("i < segments", "i + 1u < segments"),
        (f"INT{bits}_MIN", f"INT{bits}_MIN + 1"),
    )


WATCH = of(
    "include/ccgen/watch.h",
    CHECKED,
    ("CCGEN_OUT_AFTER 3u", "CCGEN_OUT_AFTER 4u"),
    ("CCGEN_BACK_AFTER 20u", "CCGEN_BACK_AFTER 19u"),
    ("watch->out ? watch->sensor : CCGEN_NOBODY", "CCGEN_NOBODY"),
    (
        "(verdict == watch->sensor) || (verdict == CCGEN_VERDICT_UNNAMED)",
        "verdict == watch->sensor",
    ),
    ("(verdict == watch->sensor) || (verdict", "(verdict"),
    ("        watch->run = 0;\n        return;\n", "        return;\n"),
    ("verdict >= CCGEN_VERDICT_UNNAMED", "verdict > CCGEN_VERDICT_UNNAMED"),
    (", watch->run + 1u) : 1u", ", watch->run + 1u) : 0u"),
    ("        watch->sensor = verdict;\n", ""),
    (
        "            watch->run = 0;\n            watch->out = true;\n",
        "            watch->out = true;\n",
    ),
    ("watch->out ? (UINT32_C(1)", "(watch->run > 0u) ? (UINT32_C(1)"),
    ("watch->out ? watch->sensor : verdict", "verdict"),
)

GROUPS = (
    INTEGER,
    *SENSORS,
    *ESTIMATORS,
    FACTORS16,
    KERNEL16,
    *KERNEL16_ON_CORES,
    KERNEL32,
    LOAD,
    LOAD_ON_CORES,
    KERNEL16_THUMB1,
    PRODUCT,
    AVR_PRODUCT,
    QUEUE,
    check_of(16),
    check_of(32),
    serving_of(16, "rows"),
    serving_of(32, "weights"),
    RESIDUALS,
    WATCH,
)
