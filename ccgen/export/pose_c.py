"""Integer poses in C: what the templates pose.h.j2 and pose.c.j2 are filled with."""

from collections.abc import Collection
from itertools import accumulate
from typing import Any

from ccgen import __version__, resources
from ccgen.digits import rounded_up
from ccgen.fixedpoint.pose import PoseModel
from ccgen.polynomial.c_text import c_context


def pose_files(name: str, model: PoseModel, axes: Collection[str] = ()) -> dict[str, str]:
    """The C file and header of a joint's integer poses, by file name.

    Args:
        name: of the joint.
        model: its poses.
        axes: those that the joint's header has; none where there is no such header.
    """
    values = _context(name, model) | {"axes": axes}
    return {
        f"{name}_pose.{ending}": resources.template(f"pose.{ending}.j2").render(values)
        for ending in ("h", "c")
    }


def _context(name: str, model: PoseModel) -> dict[str, Any]:
    task = model.task
    elongates = task.elongation_bits is not None
    kind = f"const int{task.precision}_t"
    parameters = [f"{kind} u[{task.segments}]", f"{kind} v[{task.segments}]"]
    if elongates:
        parameters.append(f"{kind} h[{len(task.sections)}]")
    whole = {"bound": model.bounds, "wide": model.wide_bounds}
    told = {
        "position_bound": whole["bound"].position,
        "rotation_bound": whole["bound"].rotation,
        "wide_position_bound": whole["wide"].position,
        "wide_rotation_bound": whole["wide"].rotation,
    }
    return {
        "name": name,
        "NAME": name.upper(),
        "version": __version__,
        "elongates": elongates,
        "parameters": ", ".join(parameters),
        "place_h": ("h, " if len(task.sections) > 1 else "h[0], ") if elongates else "",
        "segments": task.segments,
        "ends": list(accumulate(task.sections)),
        "frame_bits": model.frame_bits,
        "position_bits": model.position_bits,
        "bits_u": task.fraction_bits[0],
        "bits_v": task.fraction_bits[1],
        "bits_h": task.elongation_bits,
        "angle": f"{task.angle:.3g}",
        "elongation": f"{task.elongation:.3g}",
        "turn": c_context(model.turn),
        "place": c_context(model.place),
        **{key: f"{rounded_up(value, 2):.1e}" for key, value in told.items()},
    }
