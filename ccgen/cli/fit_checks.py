"""What `ccgen fit` prints of the checks of a joint's sensors."""

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from ccgen.cli.output import results, show_table

if TYPE_CHECKING:
    from ccgen.fixedpoint.joint_checks import JointChecks


def checks_json(checks: "JointChecks") -> list[dict[str, Any]]:
    """A record for each sensor."""
    return [asdict(row) for row in checks.sensors]


def show_checks(checks: "JointChecks", false_alarms: float) -> None:
    """Print a row for each sensor, where some are checked, and why others are not."""
    if checks.groups:
        _show_table(checks, false_alarms)
    for text in checks.notes:
        results().print(text, soft_wrap=True)


def _show_table(checks: "JointChecks", false_alarms: float) -> None:
    from rich.table import Table

    title = f"Faults that are seen, at {false_alarms:g} false alarms a snapshot"
    table = Table("sensor", title=title, title_justify="left")
    for heading in (
        "seen from\nmm",
        "% of largest\nreading",
        "isolated\nthen",
        "isolated\nfrom mm",
    ):
        table.add_column(heading, justify="right")
    for row in checks.sensors:
        seen = row.detectable_m is not None
        table.add_row(
            row.sensor,
            _number(row.detectable_m, 1e3),
            _number(row.detectable_percent),
            ("yes" if row.isolable else "no") if seen else "",
            _number(row.isolated_m, 1e3),
        )
    show_table(table)


def _number(value: float | None, unit: float = 1.0) -> str:
    return "not" if value is None else f"{unit * value:.3g}"
