"""Functions as JSON records, beside the axes of `model.json`."""

from pathlib import Path
from typing import Any

from ccgen.fixedpoint.storage import load_record
from ccgen.functions.integer import JointFunctions
from ccgen.polynomial.storage import compiled_function, compiled_record


def functions_record(functions: JointFunctions) -> dict[str, Any]:
    """The key "functions"; none where there are none."""
    if not functions:
        return {}
    return {
        "functions": {
            "source": functions.source,
            "sha256": functions.sha256,
            "compiled": [compiled_record(one) for one in functions.compiled],
        }
    }


def load_functions(path: Path) -> JointFunctions:
    """Read functions back from `model.json`.

    Raises:
        InputError: as of `ccgen.fixedpoint.storage.load_model`.
    """
    return load_record(path, _functions)


def _functions(record: dict[str, Any]) -> JointFunctions:
    if "functions" not in record:
        return JointFunctions()
    own = record["functions"]
    compiled = tuple(compiled_function(one) for one in own["compiled"])
    return JointFunctions(compiled, str(own["source"]), str(own["sha256"]))
