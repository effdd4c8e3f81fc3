"""Cholesky factorisation of Newton's system along the chain, all samples at once.

The block of the Hessian between elements e < f is rows_e columns_f^T, with three columns. So is
the factor's: L_fe = columns_f g_e with g_e^T = L_ee^-1 (rows_e - columns_e S_e), where S_e sums
g_k g_k^T over the elements before e, and L_ee L_ee^T = H_ee - columns_e S_e columns_e^T. One
sweep from the base factors, another from the tip solves, each in a number of operations that grows
with E and not with its cube.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ccgen.shapes.loads.equilibrium import Array, Flags, Step, pivot_root


@dataclass(frozen=True, eq=False)
class System:
    """Newton's system H dx = r of N joints, its Hessian in parts.

    The block of H between elements e < f is rows_e columns_f^T.

    Attributes:
        rows: shape (E, 2, 3, N).
        columns: shape (E, 2, 3, N).
        diagonal: uu, uv and vv of the blocks on the diagonal, shape (E, 3, N).
        residual: r, the energy's negative gradient, shape (E, 2, N), newton metres.
        rate: its rate where the raised loads grow, shape (E, 2, N), newton metres.
    """

    rows: Array
    columns: Array
    diagonal: Array
    residual: Array
    rate: Array


def solve(system: System) -> Step:
    """Solve for the correction and the tangent."""
    scaled, triangles, stable = _towards_tip(system)
    solution = _towards_base(system.columns, scaled, triangles)
    return Step(solution[:, :, 0], solution[:, :, 1], stable)


def _towards_tip(system: System) -> tuple[Array, Array, Flags]:
    """Factor, and solve L z = r for both right-hand sides on the way.

    Returns:
        g_e^T with both z_e beside it, shape (E, 2, 3 + 2, N); the triangles L_ee, shape (E, 3, N);
        which joints are stable.
    """
    right = np.stack([system.residual, system.rate], axis=2)
    scaled = np.concatenate([system.rows, right], axis=2)
    triangles = np.empty_like(system.diagonal)
    sums = np.zeros((3, *scaled.shape[2:]))
    stable = np.ones(scaled.shape[-1], dtype=bool)
    for e, columns in enumerate(system.columns):
        before = np.einsum("ain,ijn->ajn", columns, sums)
        known = before[:, :3]
        uu = system.diagonal[e, 0] - (known[0] * columns[0]).sum(axis=0)
        uv = system.diagonal[e, 1] - (known[1] * columns[0]).sum(axis=0)
        vv = system.diagonal[e, 2] - (known[1] * columns[1]).sum(axis=0)
        first = pivot_root(uu, stable)
        below = uv / first
        second = pivot_root(vv - below * below, stable)
        triangles[e] = first, below, second
        row = scaled[e]
        row -= before
        row[0] /= first
        row[1] -= below * row[0]
        row[1] /= second
        sums += np.einsum("ain,ajn->ijn", row[:, :3], row)
    return scaled, triangles, stable


def _towards_base(columns: Array, scaled: Array, triangles: Array) -> Array:
    """Solve L^T x = z for both right-hand sides, shape (E, 2, 2, N)."""
    solution = np.empty((*scaled.shape[:2], 2, scaled.shape[-1]))
    sums = np.zeros((3, 2, scaled.shape[-1]))
    for e in reversed(range(len(scaled))):
        first, below, second = triangles[e]
        x = solution[e]
        x[:] = scaled[e, :, 3:] - np.einsum("ain,ijn->ajn", scaled[e, :, :3], sums)
        x[1] /= second
        x[0] = (x[0] - below * x[1]) / first
        sums += np.einsum("ain,ajn->ijn", columns[e], x)
    return solution
