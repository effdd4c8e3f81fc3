"""`ccgen calibrate`: gains, zeros, noise and delay of a joint's sensors from its recordings."""

import math
from collections.abc import Iterator, Set
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ccgen.cli.output import note, print_json, progress, results, show_table

if TYPE_CHECKING:
    from ccgen.calibration.calibrate import Calibrated
    from ccgen.calibration.places import Place
    from ccgen.joint.calibration import SensorCalibration


def calibrate(
    joint_file: Annotated[Path, typer.Argument(metavar="JOINT", help="The joint file.")],
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Find gain and sign, zero, noise and delay of each sensor from the joint's recordings.

    Recordings of use "fit" count: with segment angles, with bodies or markers, of the straight
    joint alone, or a few rows of known angles. What is found goes into the file that the joint
    file names as calibration, or into NAME.calibration.toml beside it; the joint file itself stays
    as it is. Sensors that are swapped, reversed, stuck or slipping are named.

    \b
    Example:
      ccgen calibrate finger.toml
    """
    from ccgen.calibration.calibrate import calibrate as found_by
    from ccgen.joint.calibration_file import check_replaceable, uncalibrated
    from ccgen.joint.file import read_joint

    joint = read_joint(joint_file, uncalibrated)
    name = joint.calibration or f"{joint.name}.calibration.toml"
    path = joint_file.parent / name
    check_replaceable(path, joint, joint_file)
    with progress().status("following the recordings"):
        found = found_by(joint)
    found.write(path)
    for line in found.notes:
        note(line)
    for one in found.suspicious:
        note(f"warning: sensor {one.name} ({one.kind}): {one.text}")
    if json:
        print_json(_record(found) | {"file": str(path)})
    else:
        _show(joint.name, found)
    note(f"wrote {path}")
    if joint.calibration is None:
        note(
            f"{joint_file} does not read it yet; add this line above its first table: "
            f'calibration = "{name}"'
        )


def _record(found: "Calibrated") -> dict[str, Any]:
    pairs = zip(found.calibration.sensors, found.places, strict=True)
    return {
        "sensors": [_sensor(sensor, place) for sensor, place in pairs],
        "delay_s": found.calibration.delay,
        "delay_s_std": found.calibration.delay_std,
        "suspicious": [
            {"name": one.name, "kind": one.kind, "text": one.text} for one in found.suspicious
        ],
        "notes": list(found.notes),
    }


def _sensor(sensor: "SensorCalibration", place: "Place") -> dict[str, Any]:
    return {
        "name": sensor.name,
        "metres_per_count": sensor.metres_per_count,
        "metres_per_count_std": sensor.metres_per_count_std,
        "zero": sensor.zero,
        "zero_std": sensor.zero_std,
        "noise_m": sensor.noise,
        "noise_m_std": sensor.noise_std,
        "radius_m": place.radius,
        "radius_m_std": place.radius_std,
        "angle_deg": _degrees(place.angle),
        "angle_deg_std": _degrees(place.angle_std),
    }


def _degrees(radians: float | None) -> float | None:
    return None if radians is None else math.degrees(radians)


def _show(name: str, found: "Calibrated") -> None:
    from rich.table import Table

    pairs = list(zip(found.calibration.sensors, found.places, strict=True))
    columns = {
        "um\na count": [_told(s.metres_per_count, s.metres_per_count_std, 1e6) for s, _ in pairs],
        "zero\ncounts": [_told(s.zero, s.zero_std) for s, _ in pairs],
        "noise\nmm": [_told(s.noise, s.noise_std, 1e3) for s, _ in pairs],
        "radius\nmm": [_told(p.radius, p.radius_std, 1e3) for _, p in pairs],
        "angle\ndeg": [_told(_degrees(p.angle), _degrees(p.angle_std)) for _, p in pairs],
    }
    shown = {title: cells for title, cells in columns.items() if set(cells) != {_UNKNOWN}}
    table = Table("sensor", title=f"{name}: sensors and deviations", title_justify="left")
    for title in shown:
        table.add_column(title, justify="right")
    for row in zip((sensor.name for sensor, _ in pairs), *shown.values(), strict=True):
        table.add_row(*row)
    show_table(table)
    for line in _said(columns.keys() - shown.keys(), found):
        results().print(line, soft_wrap=True)


def _said(missing: Set[str], found: "Calibrated") -> Iterator[str]:
    """What stands beneath the table: the delay, and what no sensor's recording determines."""
    delay, std = found.calibration.delay, found.calibration.delay_std
    if delay is not None and std is not None:
        sure = "as stated" if std == 0 else f"± {1e3 * std:.2g}"
        yield f"The sensors lag behind the reference by {1e3 * delay:.1f} ms ({sure})."
    if "um\na count" in missing:
        yield "Gains are not determined: that takes the joint bent by known angles."
    elif "radius\nmm" in missing:
        yield (
            "Radii are not determined: bending sees gain times radius alone; recorded elongation "
            "would tell them apart."
        )


_UNKNOWN = "not known"


def _told(value: float | None, std: float | None, scale: float = 1.0) -> str:
    """A value and its deviation, to the second digit of the deviation."""
    if value is None or std is None:
        return _UNKNOWN if value is None else f"{scale * value:.4g}"
    value, std = scale * value, scale * std
    digits = 3 if std <= 0 else min(max(1 - math.floor(math.log10(std)), 0), 9)
    return f"{value:.{digits}f} ± {std:.{digits}f}"
