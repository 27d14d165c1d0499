# SPDX-License-Identifier: BSD-3-Clause
"""Messages and bytes of the patches that a rank sends in a step, from the geometry of tiles.

test/invariance/test_traffic.py compares them with those of runs.
"""

TILE_CELLS, TILE_NODES = 6, 7           # cells and nodes along an edge of a tile, three dimensions
# Numbers per node in each exchange of patches of a step with the default method.
EXCHANGES = {"mpm": (7, 3), "ddmp": (17,)}
COVERS = {"mpm": 0, "ddmp": 1}          # numbers per cell in the first of them: the part that particles cover
WORD = 8                                # bytes


def copies(tiles, ranks):
    """Number of patches that a rank sends in an exchange. A segment of the space-filling curve with this number of
    tiles is approximated by a cube of e tiles along an edge, among other cubes of this size: each of 6 neighbours
    needs e^2 of its tiles, each of 12 neighbours e, each of 8 neighbours one. The number is bounded, because every
    other rank needs each tile at most once."""
    edge = tiles ** (1.0 / 3.0)
    return min(6 * edge ** 2 + 12 * edge + 8, tiles * (ranks - 1))


def words_of(method, nodes, cells):
    """Words of the patches of a tile with a number of nodes and of cells in a step, each with its key."""
    return sum(1 + columns * nodes for columns in EXCHANGES[method]) + COVERS[method] * cells


def traffic(method, tiles, ranks):
    """Messages and bytes of patches that a rank with this number of tiles sends in a step."""
    words = words_of(method, TILE_NODES ** 3, TILE_CELLS ** 3)
    return len(EXCHANGES[method]) * min(26, ranks - 1), WORD * copies(tiles, ranks) * words
