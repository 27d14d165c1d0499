# SPDX-License-Identifier: BSD-3-Clause
"""Messages and bytes of the patches that a rank sends in a step, from the geometry of tiles.

test/invariance/test_traffic.py compares them with those of runs.
"""

import math

TILE_CELLS, TILE_NODES = 6, 7           # cells and nodes along an edge of a tile, three dimensions
# Numbers per node in each exchange of patches of a step with the default method, in three dimensions, and the layers of
# cells beside its tiles of which a rank needs the nodes.
EXCHANGES = {"mpm": ((7, 0), (3, 0)), "ddmp": ((17, 3),)}
COVERS = {"mpm": 0, "ddmp": 1}          # numbers per cell in the first of them: the part that particles cover
HEADER = 3                              # words of a patch before its numbers: key and box
WORD = 8                                # bytes


def copies(tiles, ranks):
    """Number of patches that a rank sends in an exchange to ranks beside faces, edges and corners of its tiles. A
    segment of the space-filling curve with this number of tiles is approximated by a cube of e tiles along an edge,
    among other cubes of this size: each of 6 neighbours needs e^2 of its tiles, each of 12 neighbours e, each of 8
    neighbours one. The number is bounded, because every other rank needs each tile at most once; ranks that are
    divided k times in two, each time in another direction, then have k ranks beside their faces."""
    edge = tiles ** (1.0 / 3.0)
    if 6 * edge ** 2 + 12 * edge + 8 <= tiles * (ranks - 1):
        return 6 * edge ** 2, 12 * edge, 8
    halved = math.log2(ranks)
    faces, edges = halved, halved * (halved - 1) / 2
    return tiles * faces, tiles * edges, tiles * (ranks - 1 - faces - edges)


def boxes_of(layers):
    """Nodes that a rank needs of a tile beside a face, an edge and a corner of its tiles."""
    return tuple((layers + 1) ** sides * TILE_NODES ** (3 - sides) for sides in (1, 2, 3))


def words_of(method, exchange, columns, nodes, cells):
    """Words of a patch in an exchange, from its numbers per node and those of its nodes and cells."""
    patch = HEADER + columns * nodes
    return patch + COVERS[method] * cells if exchange == 0 else patch


def traffic(method, tiles, ranks):
    """Messages and bytes of patches that a rank with this number of tiles sends in a step."""
    words = 0
    # few ranks with one tile each, in a periodic block, have the same neighbour on both sides
    one = tiles == 1 and ranks <= 26
    for exchange, (columns, layers) in enumerate(EXCHANGES[method]):
        for number, nodes in zip(copies(tiles, ranks), boxes_of(TILE_CELLS if one else layers)):
            words += number * words_of(method, exchange, columns, nodes, TILE_CELLS ** 3)
    return len(EXCHANGES[method]) * min(26, ranks - 1), WORD * words
