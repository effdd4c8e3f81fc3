"""What the paper reports, and for which joints (Tables 1 to 4)."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Quartiles:
    """Median and quartiles of the joints' scores, % of the range of motion."""

    median: float
    q1: float
    q3: float


SEGMENTS = tuple(range(12, 49, 4))
RANGES_OF_MOTION_DEG = tuple(range(1, 9))
"""Table 1: 80 joints."""

SENSORS = (2, 3, 4, 5, 6)

Cell = tuple[str, str, int]
"""Placement, estimation method, number of sensors."""

SS, EE, HO, OO = "SS", "EE", "HO", "OO"
DEM, E_WAM, WAM = "DEM", "E-WAM", "WAM"

_ROWS: dict[tuple[str, str], tuple[tuple[float, float, float], ...]] = {
    (EE, DEM): (
        (8.309, 8.281, 8.321),
        (5.423, 5.305, 5.465),
        (4.033, 3.931, 4.077),
        (3.178, 3.105, 3.212),
        (2.634, 2.592, 2.672),
    ),
    (HO, E_WAM): (
        (7.561, 7.277, 7.735),
        (4.504, 4.280, 4.720),
        (3.090, 2.878, 3.230),
        (2.342, 2.257, 2.538),
        (1.914, 1.784, 1.993),
    ),
    (HO, WAM): (
        (1.552, 1.403, 2.086),
        (0.262, 0.181, 0.364),
        (0.0915, 0.0653, 0.112),
        (0.0434, 0.0289, 0.0538),
        (0.0366, 0.0228, 0.0475),
    ),
    (OO, WAM): (
        (1.542, 1.389, 2.063),
        (0.238, 0.175, 0.362),
        (0.0836, 0.0427, 0.106),
        (0.0368, 0.0220, 0.0506),
        (0.0315, 0.0215, 0.0437),
    ),
}

TABLE_2: dict[Cell, Quartiles] = {
    (SS, DEM, 1): Quartiles(16.71, 16.16, 16.92),
    **{
        (placement, method, sensors): Quartiles(*values)
        for (placement, method), row in _ROWS.items()
        for sensors, values in zip(SENSORS, row, strict=True)
    },
}
"""Table 2: its 21 cells in the paper's order."""

TABLE_3_CELLS = ((HO, E_WAM), (HO, WAM))
TABLE_3_DECREASE = (6.009, 4.243, 2.9985, 2.2986, 1.8774)
"""Table 3: by how much WAM lowers the median of E-WAM, for each number of sensors."""

TABLE_4_CELLS = ((HO, WAM), (OO, WAM))
TABLE_4_DECREASE = (0.010, 0.0240, 0.00790, 0.0066, 0.0051)
"""Table 4: by how much the optimised placement lowers the median of the heuristic one."""
