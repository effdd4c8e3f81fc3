"""Shorter products where the wanted errors leave room for them.

Bits to spare are the same for all operations. Where products just miss a shorter form, some of
them may have it all the same: the proof of the whole plan decides.
"""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass

from ccgen.polynomial.graph import Graph
from ccgen.polynomial.planner import Draft, Task

_MOST = 10
"""Bits that a shorter form may lack."""


@dataclass(frozen=True)
class _Group:
    """Products that have an operand in common; they are shortened together."""

    nodes: tuple[int, ...]


def cheapened(task: Task, spare: int, draft: Draft) -> Draft:
    """A plan with shorter products that still meets the wanted errors.

    Args:
        task: what is planned.
        spare: bits to spare of the draft.
        draft: a plan that meets them.
    """
    relief: dict[int, int] = {}
    best = draft
    for group in _groups(task.graph, draft.lacking):
        trial = relief | {node: draft.lacking[node] for node in group.nodes}
        found = task.planned(spare, trial)
        if found and found.cost < best.cost and found.excess(task.outputs) <= 1:
            best, relief = found, trial
    return best


def _groups(graph: Graph, lacking: Mapping[int, int]) -> list[_Group]:
    nodes = [node for node, bits in lacking.items() if bits <= _MOST]
    uses = Counter(operand for node in nodes for operand in set(graph.nodes[node].operands))
    found: dict[int, list[int]] = {}
    for node in nodes:
        shared = max(graph.nodes[node].operands, key=lambda operand: uses[operand])
        found.setdefault(shared, []).append(node)
    groups = [_Group(tuple(row)) for row in found.values()]
    return sorted(groups, key=lambda group: -len(group.nodes))
