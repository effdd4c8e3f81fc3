"""The exported C as a shared library: estimates, poses and Jacobians in batches."""

import ctypes
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ccgen.can.transports import not_run
from ccgen.errors import ToolError
from ccgen.fixedpoint import FixedPointModel

Integers = NDArray[np.int64]
Singles = NDArray[np.float32]


class JointLibrary:
    """What ports/shared offers for arrays; shapes as there.

    Args:
        path: the shared library.
        model: the joint's model; the library must have its shape.

    Raises:
        ToolError: the library cannot be loaded or is that of another joint.
    """

    def __init__(self, path: Path, model: FixedPointModel) -> None:
        try:
            self._library = ctypes.CDLL(str(path))
        except OSError as error:
            raise ToolError(f"{path}: cannot be loaded: {not_run(path, error)}") from error
        self._integer = np.dtype(f"int{model.precision}")
        self._columns = model.values
        self._poses = model.segments + 1
        shape = (ctypes.c_int32 * 4)()
        self._library.ccgen_shared_shape(shape)
        expected = [model.segments, model.readings.sensors, model.values, model.precision]
        if list(shape) != expected:
            raise ToolError(f"{path}: is the library of another joint")

    def estimate(self, counts: Integers, zero: Integers) -> tuple[Integers, Integers]:
        """Angles and results of snapshots that share a zero.

        Args:
            counts: shape (k, n).
            zero: shape (n,).

        Returns:
            Values of all axes, shape (k, values), and what the C returned for each snapshot,
            shape (k,).
        """
        angles = np.zeros((len(counts), self._columns), dtype=self._integer)
        results = np.zeros(len(counts), dtype=np.int8)
        self._call(
            "ccgen_batch_estimate", self._dense(counts), self._dense(zero), len(counts),
            angles, results,
        )  # fmt: skip
        return angles.astype(np.int64), results.astype(np.int64)

    def poses(self, angles: Integers) -> tuple[Singles, Singles]:
        """Positions (k, m + 1, 3) in metres and rotations (k, m + 1, 3, 3): segments, then tip."""
        positions = np.zeros((len(angles), self._poses, 3), dtype=np.float32)
        rotations = np.zeros((len(angles), self._poses, 3, 3), dtype=np.float32)
        self._call("ccgen_batch_poses", self._dense(angles), len(angles), positions, rotations)
        return positions, rotations

    def integer_poses(self, angles: Integers) -> Integers:
        """Poses in integers of all segments, (k, m, 12): axes X, Y, Z and position."""
        poses = np.zeros((len(angles), self._poses - 1, 12), dtype=np.int32)
        self._call("ccgen_batch_integer_poses", self._dense(angles), len(angles), poses)
        return poses.astype(np.int64)

    def integer_jacobians(self, angles: Integers) -> Integers:
        """Tip Jacobians in integers, (k, 6, values)."""
        jacobians = np.zeros((len(angles), 6, self._columns), dtype=np.int32)
        self._call("ccgen_batch_integer_jacobians", self._dense(angles), len(angles), jacobians)
        return jacobians.astype(np.int64)

    def functions(self, angles: Integers, words: int) -> Integers:
        """Results of the user's own functions, (k, words)."""
        results = np.zeros((len(angles), words), dtype=np.int32)
        self._call("ccgen_batch_functions", self._dense(angles), len(angles), results)
        return results.astype(np.int64)

    def jacobians(self, angles: Integers) -> Singles:
        """Tip Jacobians (k, 6, values)."""
        jacobians = np.zeros((len(angles), 6, self._columns), dtype=np.float32)
        self._call("ccgen_batch_jacobians", self._dense(angles), len(angles), jacobians)
        return jacobians

    def _dense(self, values: Integers) -> NDArray[np.signedinteger]:
        return np.ascontiguousarray(values, dtype=self._integer)

    def _call(self, name: str, *arguments: NDArray[np.generic] | int) -> None:
        converted = [
            ctypes.c_size_t(a) if isinstance(a, int) else ctypes.c_void_p(a.ctypes.data)
            for a in arguments
        ]
        result = getattr(self._library, name)(*converted)
        if result != 0:
            raise ToolError(f"{name} returned {result}")
