"""Errors on recordings: told by weights that do not know the rows that they are told on.

A recording to fit to is cut into contiguous blocks of time. Each block is judged by weights, gains,
zeros and delay that were found without it. A recording to score with is judged whole.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ccgen.errors import InputError
from ccgen.estimation.axes import estimated
from ccgen.estimation.errors import ErrorRow, Missed, Pooled, deviations, errors_of
from ccgen.estimation.fit import Task, fit_task
from ccgen.estimation.recorded import BLOCKS, Recorded, recorded
from ccgen.estimation.sources import RECORDING, Source, ideal_readings
from ccgen.estimation.weights import Floats, Weights
from ccgen.recordings.progress import Report
from ccgen.sensing.readings import normalised_response

if TYPE_CHECKING:
    from ccgen.joint import Joint
    from ccgen.recordings.recording import Recording
    from ccgen.recordings.reference import Reference

Flags = NDArray[np.bool_]
AxisWeights = Mapping[str, Weights]
"""Weights by output axis."""


@dataclass(frozen=True, eq=False)
class Block:
    """What was found without one block of time.

    Attributes:
        found: recordings, from whose other rows alone something was learned.
        task: sources without the block's rows.
        weights: fitted to them.
    """

    found: Recorded
    task: Task
    weights: AxisWeights

    @cached_property
    def quick(self) -> Task:
        """The same task for weights that are compared only, with fewer rows of recordings."""
        sources = [
            one.thinned if one.name.startswith(RECORDING) else one for one in self.task.sources
        ]
        return replace(self.task, sources=sources, exact=False)


Choice = Callable[[Block], AxisWeights]
"""Weights to judge in the place of those that were fitted."""


@dataclass(frozen=True, eq=False)
class RecordedFit:
    """Weights fitted to a joint with recordings, and what fits them again without a block.

    Attributes:
        recordings: of the joint, read.
        whole: references, task and weights of everything.
        simulated: sources to fit to beside the recordings.
        method: by which weights are fitted.
        rounding: as of `Missed`.
        report: told of the progress.
    """

    recordings: Sequence["Recording"]
    whole: Block
    simulated: Sequence[Source]
    method: str
    rounding: Mapping[str, float]
    report: Report

    @cached_property
    def blocks(self) -> list[Block]:
        """What is found and fitted without each block."""
        blocks = []
        for k in range(BLOCKS):
            self.report("held-out blocks", k, BLOCKS)
            found = recorded(self.whole.found.stated, self.recordings, k, self.whole.found)
            task = Task(found.joint, [*self.simulated, *found.sources(without=k)], exact=False)
            blocks.append(Block(found, task, fit_task(task, self.method)))
        self.report("held-out blocks", BLOCKS, BLOCKS)
        return blocks

    def errors(self) -> list[ErrorRow]:
        """Rows of every recording, in the order of the joint file; of real counts with noise."""
        return [row for i in range(len(self.whole.found.references)) for row in self._rows(i)]

    def judged(self, number: int, noise: bool, choice: Choice | None = None) -> Pooled:
        """Errors on one recording.

        Args:
            number: of the recording.
            noise: whether simulated readings have noise.
            choice: of other weights than those that were fitted.
        """
        parts = self._parts(number)
        truth = self.whole.found.references[number]
        return Pooled([part.missed(truth, noise, self.rounding, choice) for part in parts])

    def _parts(self, number: int) -> "list[_Part]":
        found = self.whole.found
        truth = found.references[number]
        known = found.rows(truth)
        if truth.use != "fit":
            return [_Part(self.whole, number, known)]
        parts = [
            _Part(block, number, known & (truth.block == k)) for k, block in enumerate(self.blocks)
        ]
        return [part for part in parts if part.rows.any()]

    def _rows(self, number: int) -> list[ErrorRow]:
        truth = self.whole.found.references[number]
        noises = (True,) if truth.lengths is not None else (False, True)
        judged = [self.judged(number, noise) for noise in noises]
        _check(truth, judged[0])
        # Noise that is added to simulated readings spreads estimates, it does not move them.
        stations = None if truth.dense else truth.stations(self._estimate(number, judged[0]))
        return [
            errors_of(truth.name, found, noise, True, stations)
            for noise, found in zip(noises, judged, strict=True)
        ]

    def _estimate(self, number: int, found: Pooled) -> Floats:
        """Estimates of all rows of a recording, NaN where there is none, shape (N, 2m + S)."""
        estimate = np.full(self.whole.found.references[number].state.shape, np.nan)
        for part, one in zip(self._parts(number), found.parts, strict=True):
            estimate[part.rows] = one.estimate
        return estimate


@dataclass(frozen=True, eq=False)
class _Part:
    """Rows of a recording, and what was found without them.

    Attributes:
        block: sensors, task and weights.
        number: of the recording.
        rows: which of its N rows, shape (N,).
    """

    block: Block
    number: int
    rows: Flags

    def missed(
        self,
        truth: "Reference",
        noise: bool,
        rounding: Mapping[str, float],
        choice: Choice | None,
    ) -> Missed:
        """Errors on the rows: of the real readings, or of simulated ones."""
        found, joint = self.block.found, self.block.found.joint
        weights = self.block.weights if choice is None else choice(self.block)
        shapes = found.shapes(truth, self.rows)
        covariance = None if truth.covariance is None else truth.covariance[self.rows]
        readings = found.readings(found.references[self.number])
        place = spread = None
        if truth.sighting is not None:
            place, spread = (whole[self.rows] for whole in truth.sighting.tips)
        if readings is not None:
            read, deviation = readings[self.rows], np.zeros((len(shapes), len(joint.sensors)))
        else:
            read = ideal_readings(joint, shapes)
            deviation = deviations(joint, shapes.state) if noise else np.zeros_like(read)
            covariance, spread = _as_seen(joint, weights, covariance), None
        estimate = estimated(joint, weights, read)
        added = rounding if noise else {}
        return Missed(
            joint, weights, shapes.state, estimate, deviation, added, covariance,
            place=place, place_spread=spread,
        )  # fmt: skip


def _as_seen(joint: "Joint", weights: AxisWeights, covariance: Floats | None) -> Floats | None:
    """Covariance of errors where readings are simulated, so that they follow the true states."""
    if covariance is None:
        return None
    whole = estimated(joint, weights, normalised_response(joint).T).T
    missed = whole - np.eye(len(whole))
    return np.asarray(missed @ covariance @ missed.T)


def _check(truth: "Reference", found: Pooled) -> None:
    for axis in found.joint.axes:
        if np.isnan(found.known(axis)).all():
            raise InputError(
                f"{truth.name}: no row has readings of every sensor of axis {axis} beside a shape; "
                "record all sensors together with the reference"
            )
