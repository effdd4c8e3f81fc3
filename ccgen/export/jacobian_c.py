"""The integer tip Jacobian in C: what jacobian.h.j2 and jacobian.c.j2 are filled with."""

from itertools import accumulate
from typing import Any

from ccgen import __version__, resources
from ccgen.digits import rounded_up
from ccgen.fixedpoint.jacobian import JacobianModel
from ccgen.fixedpoint.model import FixedPointModel
from ccgen.polynomial.c_text import c_context


def jacobian_files(name: str, jacobian: JacobianModel, model: FixedPointModel) -> dict[str, str]:
    """The C file and header of a joint's integer tip Jacobian, by file name.

    Args:
        name: of the joint.
        jacobian: what is computed.
        model: whose axes its columns are.
    """
    values = _context(name, jacobian, model)
    return {
        f"{name}_jacobian.{ending}": resources.template(f"jacobian.{ending}.j2").render(values)
        for ending in ("h", "c")
    }


def _context(name: str, jacobian: JacobianModel, model: FixedPointModel) -> dict[str, Any]:
    task = jacobian.poses.task
    elongates = task.elongation_bits is not None
    several = len(task.sections) > 1
    rows = [axis.segments for axis in model.axes.values()]
    told = {
        "linear_bound": jacobian.bounds.linear,
        "angular_bound": jacobian.bounds.angular,
        "wide_linear_bound": jacobian.wide_bounds.linear,
        "wide_angular_bound": jacobian.wide_bounds.angular,
    }
    of_section = "angles->h[section], " if several else "angles->h[0], "
    functions = {
        "turn": jacobian.poses.turn, "place": jacobian.poses.place,
        "columns": jacobian.columns, "column": jacobian.column,
    }  # fmt: skip
    if jacobian.stretch is not None:
        functions["stretch"] = jacobian.stretch
    return {
        "name": name,
        "NAME": name.upper(),
        "version": __version__,
        "axes": list(model.axes),
        "axes_said": ", then ".join(model.axes),
        "first": dict(zip(model.axes, accumulate([0, *rows]), strict=False)),
        "elongates": elongates,
        "segments": task.segments,
        "ends": list(accumulate(task.sections)),
        "frame_bits": jacobian.poses.frame_bits,
        "linear_bits": jacobian.linear_bits,
        "angular_bits": jacobian.angular_bits,
        "place_h": ("angles->h, " if several else "angles->h[0], ") if elongates else "",
        "column_h": of_section if elongates else "",
        "angle": f"{task.angle:.3g}",
        "elongation": f"{task.elongation:.3g}",
        **{key: c_context(one) for key, one in functions.items()},
        **{key: f"{rounded_up(value, 2):.1e}" for key, value in told.items()},
    }
