"""Mutants of the ports for CAN controllers: bit timing, MCP2515, TWAI."""

from mutants.mutant import of

TIMING = of(
    "ports/can/can_timing.c",
    ("test_can_timing.py", "test_mcp2515.py"),
    ("PERMILLE_MIN = 700", "PERMILLE_MIN = 600"),
    ("(clock_hz % bitrate != 0u)", "false"),
    ("(quanta * permille) + 500u", "(quanta * permille)"),
    ("(off < least)", "(off <= least)"),
    ("segment2 > limits->segment2_max", "segment2 >= limits->segment2_max"),
    ("prescaler <= limits->prescaler_max", "prescaler < limits->prescaler_max"),
)

MCP2515 = of(
    "ports/mcp2515/can_mcp2515.c",
    ("test_mcp2515.py",),
    ("filters[(i < 2u) ? 0u : 2u].mask", "filters[i].mask"),
    ("put_id(&settings[28], filters[2].mask", "put_id(&settings[28], filters[0].mask"),
    ("(length > 8u) ? 8u : length", "length"),
    ("        can->aborting = true;\n", ""),
    ("if (can->busy || (", "if (("),
    ("        clear_bits(can, EFLG, overruns);\n", ""),
    ("    if (seen.control != CANCTRL_NORMAL) {\n", "    if (false) {\n"),
    ("extended ? (id >> 18) : id", "extended ? (id >> 17) : id"),
    ("        can->off = false;\n", ""),
)

TWAI = of(
    "ports/twai/can_twai.c",
    ("test_twai.py",),
    ("    all.id &= all.mask;\n", "", "what the mask leaves out is not compared"),
    ("(now_us - can->handed_us > can->cycle_us) || ", ""),
    ("        can->counters.bus_off += 1u;\n        recover(can);\n", "        recover(can);\n"),
    (
        "        can->counters.bus_off += 1u;\n        recover(can);\n",
        "        can->counters.bus_off += 1u;\n",
    ),
    ("        can->overran = lost;\n", ""),
    chosen="shoulder",
)

GROUPS = (TIMING, MCP2515, TWAI)
