# SPDX-License-Identifier: Apache-2.0
"""Longest path through a graph whose loops have bounds.

A loop that is entered once and whose head runs at most three times, between 1 and 4:

>>> successors = {1: [2], 2: [3], 3: [2, 4], 4: []}
>>> longest(successors, 1, {4}, dict.fromkeys(successors, 10), lambda loop: 3)
80
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import dataclass

Graph = Mapping[int, Sequence[int]]


@dataclass(frozen=True)
class Loop:
    """Nodes that can reach each other, entered by their head only.

    Attributes
    ----------
    latches : list
        Nodes from which the head is reached again.
    """

    head: int
    nodes: frozenset[int]
    latches: list[int]


class IrreducibleError(Exception):
    """A loop has more than one entry, so no head whose rounds could be counted."""

    def __init__(self, heads: list[int]) -> None:
        self.heads = heads
        super().__init__(f"loop with entries {', '.join(f'{head:x}' for head in heads)}")


def components(graph: Graph) -> list[list[int]]:
    """Return the strongly connected components of a graph, each behind those it leads to.

    Tarjan's algorithm (SIAM Journal on Computing 1, 1972) with a stack of its own.
    """
    order: dict[int, int] = {}
    low: dict[int, int] = {}
    pending: list[int] = []
    is_pending: set[int] = set()
    found: list[list[int]] = []
    for root in graph:
        work = [] if root in order else [(root, iter(graph[root]))]
        while work:
            node, rest = work[-1]
            if node not in order:
                order[node] = low[node] = len(order)
                pending.append(node)
                is_pending.add(node)
            after = next(rest, None)
            if after is None:
                work.pop()
                if work:
                    low[work[-1][0]] = min(low[work[-1][0]], low[node])
                if low[node] == order[node]:
                    at = pending.index(node)
                    found.append(pending[at:])
                    is_pending.difference_update(pending[at:])
                    del pending[at:]
            elif after not in order:
                work.append((after, iter(graph[after])))
            elif after in is_pending:
                low[node] = min(low[node], order[after])
    return found


def distances(
    graph: Graph, entry: int, cost: Mapping[int, int], rounds: Callable[[Loop], int]
) -> dict[int, int]:
    """Return the cost of the longest path from the entry to each node, both included.

    Parameters
    ----------
    graph : Graph
        Successors of every node; all can be reached from the entry.
    cost : mapping
        Of every node.
    rounds : callable
        How often the head of a loop runs at most each time the loop is entered, at least 1.

    Raises
    ------
    IrreducibleError
        A loop has several entries.
    """
    arrival, result = {entry: 0}, dict[int, int]()
    for nodes in reversed(components(graph)):
        if len(nodes) == 1 and nodes[0] not in graph[nodes[0]]:
            inside = {nodes[0]: arrival[nodes[0]] + cost[nodes[0]]}
        else:
            inside = _through_loop(graph, frozenset(nodes), arrival, cost, rounds)
        result |= inside
        for node in nodes:
            for after in graph[node]:
                if after not in inside:
                    arrival[after] = max(arrival.get(after, 0), inside[node])
    return result


def _through_loop(
    graph: Graph,
    nodes: frozenset[int],
    arrival: Mapping[int, int],
    cost: Mapping[int, int],
    rounds: Callable[[Loop], int],
) -> dict[int, int]:
    heads = sorted(nodes & arrival.keys())
    if len(heads) != 1:
        raise IrreducibleError(heads)
    head = heads[0]
    inside = {n: [s for s in graph[n] if s in nodes and s != head] for n in graph if n in nodes}
    one_round = distances(inside, head, cost, rounds)
    latches = sorted(node for node in nodes if head in graph[node])
    n_rounds = rounds(Loop(head, nodes, latches))
    before = arrival[head] + (n_rounds - 1) * max(one_round[latch] for latch in latches)
    return {node: before + one_round[node] for node in nodes}


def longest(
    graph: Graph,
    entry: int,
    ends: Set[int],
    cost: Mapping[int, int],
    rounds: Callable[[Loop], int],
) -> int:
    """Return the cost of the longest path from the entry to an end; see `distances`."""
    found = distances(graph, entry, cost, rounds)
    return max(found[end] for end in ends)
