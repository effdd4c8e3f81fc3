"""Figure 7: the medians of Table 2 as grouped bars, with quartiles."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ccgen.study.joints import all_joints
from ccgen.study.paper import DEM, E_WAM, EE, HO, OO, SENSORS, SS, WAM
from ccgen.study.tables import Row, find, table2_csv

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_GROUPS = {
    (SS, DEM): "#999999",
    (EE, DEM): "#E69F00",
    (HO, E_WAM): "#56B4E9",
    (HO, WAM): "#0072B2",
    (OO, WAM): "#D55E00",
}
"""Colours told apart by readers of any colour vision (Okabe and Ito)."""

_WIDTH = 0.2
_TEXT = 9


def figure7_csv(rows: Sequence[Row]) -> bytes:
    """The bars and their quartiles as CSV, the paper's beside them."""
    return table2_csv(rows)


def figure7(rows: Sequence[Row], joints: int) -> "Figure":
    """Draw Table 2, on a linear axis as in the paper and on a logarithmic one.

    Args:
        rows: the 21 rows of Table 2.
        joints: how many joints they are of.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 7.0), layout="constrained")
    linear, logarithmic = figure.subplots(2, 1, sharex=True)
    for axes in (linear, logarithmic):
        for number, group in enumerate(_GROUPS):
            _draw_group(axes, rows, group, number, bars=axes is linear)
        axes.set_ylabel("error / % of range of motion", fontsize=_TEXT)
        axes.grid(axis="y", alpha=0.3)
        axes.set_axisbelow(True)
        axes.tick_params(labelsize=_TEXT)
        axes.spines[["top", "right"]].set_visible(False)
    logarithmic.set_yscale("log")
    logarithmic.set_xticks([1, *SENSORS])
    logarithmic.set_xlabel("sensors per bending axis", fontsize=_TEXT)
    linear.legend(frameon=False, fontsize=_TEXT)
    linear.set_title(
        f"Average segment error: {_over(joints)}; ○ the paper, {len(all_joints())} joints",
        fontsize=_TEXT + 1,
    )
    return figure


def _over(joints: int) -> str:
    return "one joint" if joints == 1 else f"median and quartiles over {joints} joints"


def _draw_group(
    axes: "Axes", rows: Sequence[Row], group: tuple[str, str], number: int, bars: bool
) -> None:
    """Medians of one placement and method; single sensors stand alone in their place.

    On a logarithmic axis they are marks: a bar has a foot, and there is no zero to set it on.
    """
    sensors = (1,) if group[0] == SS else SENSORS
    found = [find(rows, (*group, n)) for n in sensors]
    places = np.array(sensors) + (0 if group[0] == SS else (number - 2.5) * _WIDTH)
    medians = np.array([row["median"] for row in found])
    spread = np.abs([[row["q1"], row["q3"]] for row in found] - medians[:, None]).T
    colour, label = _GROUPS[group], ", ".join(group)
    if bars:
        axes.bar(places, medians, _WIDTH, color=colour, label=label)
    else:
        axes.plot(places, medians, "s", markersize=7, color=colour, label=label)
    axes.errorbar(places, medians, spread, fmt="none", ecolor="black", elinewidth=1, capsize=2)
    paper = [row["paper"]["median"] for row in found]
    axes.plot(places, paper, "o", markersize=4, markerfacecolor="white", color="black", zorder=3)
