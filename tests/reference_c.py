"""An exported folder's integer reference model as C, for drivers that hold a node against it."""

from collections.abc import Iterable
from pathlib import Path

from ccgen.fixedpoint import AxisModel
from ccgen.targets.exported import open_exported


def reference(folder: Path) -> str:
    """Both axes of the model: the text of fuzz_reference.h."""
    model = open_exported(folder).model
    return f"static const reference_t reference[2] = {{{_axis(model.u)}, {_axis(model.v)}}};\n"


def _axis(model: AxisModel) -> str:
    fields = [str(model.sensors), str(model.shift)]
    fields += [_numbers(values) for values in (model.minimum, model.maximum, model.bias)]
    fields.append(f"{{{', '.join(map(_numbers, model.weights))}}}")
    return f"{{{', '.join(fields)}}}"


def _numbers(values: Iterable[int]) -> str:
    return f"{{{', '.join(f'INT64_C({value})' for value in values)}}}"
