# SPDX-License-Identifier: BSD-3-Clause
"""Model of the communication of a step, and of its time on many ranks (doc/developer/prediction.md).

    build/venv/bin/python scripts/scaling_model.py --out doc/developer/scaling_prediction.png

Numbers of messages and bytes follow from the geometry of tiles; test/invariance/test_traffic.py compares them with
those of runs. The time per step adds assumptions about the machine, which `Machine` lists. The command writes the
figure and prints the table of the page.
"""
import argparse
import dataclasses
import math
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
TILE_CELLS, TILE_NODES = 6, 7           # cells and nodes along an edge of a tile, three dimensions
PARTICLES_OF_TILE = 8 * TILE_CELLS ** 3  # two along each edge of a cell
# Numbers per node in each exchange of patches of a step with the default method.
EXCHANGES = {"mpm": (7, 3), "ddmp": (17,)}
WORD = 8                                # bytes
TERMS = ("particles", "nodes of own tiles", "nodes of ghosts", "imbalance", "messages", "collective calls",
         "new cuts")


def copies(tiles, ranks):
    """Number of patches that a rank sends in an exchange. A segment of the space-filling curve with this number of
    tiles is approximated by a cube of e tiles along an edge, among other cubes of this size: each of 6 neighbours
    needs e^2 of its tiles, each of 12 neighbours e, each of 8 neighbours one. The number is bounded, because every
    other rank needs each tile at most once."""
    edge = tiles ** (1.0 / 3.0)
    return min(6 * edge ** 2 + 12 * edge + 8, tiles * (ranks - 1))


def traffic(method, tiles, ranks):
    """Messages and bytes of patches that a rank with this number of tiles sends in a step."""
    words = sum(1 + columns * TILE_NODES ** 3 for columns in EXCHANGES[method])
    return len(EXCHANGES[method]) * min(26, ranks - 1), WORD * copies(tiles, ranks) * words


@dataclasses.dataclass(frozen=True)
class Machine:
    """Assumptions about the machine and the run. Times in s."""
    rate: float = 6.7e6                 # particle updates per second of one core, ddmp in 3-D
    node_share: float = 0.2             # share of a step that is spent on the nodes of the rank's own tiles
    # share of a step that is spent on the way from particles to nodes; messages overlap with the part for inner tiles
    scatter_share: float = 1.0 / 3.0
    latency: float = 2.0e-6             # latency of a message, and of one level of a collective call
    bandwidth: float = 1.0e9            # bytes per second that a rank sends while all other ranks send
    calls: int = 4                      # number of collective calls in a step
    # ratio of the greatest to the mean work of the ranks at which the curve is divided anew
    imbalance: float = 1.1
    cuts_every: int = 25                # least number of steps between two divisions of the curve
    threads: int = 1                    # number of threads of a rank, which share its ghosts and messages


def predict(machine, particles, ranks):
    """Time of each part of a step (TERMS) [s], for a number of particles per rank in dense material with 8 particles
    per cell."""
    tiles = particles / PARTICLES_OF_TILE
    sent, size = traffic("ddmp", tiles, ranks)
    whole = particles / (machine.rate * machine.threads)
    own = whole * machine.node_share
    ghosts = own * copies(tiles, ranks) / tiles
    levels = math.ceil(math.log2(ranks)) if ranks > 1 else 0
    inner = max(0.0, tiles ** (1.0 / 3.0) - 2.0) ** 3 / tiles
    hidden = machine.scatter_share * whole * inner
    transit = sent * machine.latency + size / machine.bandwidth
    cuts = 2 * (levels * machine.latency + 2 * WORD * ranks / machine.bandwidth) / machine.cuts_every
    return dict(zip(TERMS, (
        whole - own, own, ghosts, (machine.imbalance - 1.0) * (whole + ghosts) if ranks > 1 else 0.0,
        max(0.0, transit - hidden),
        machine.calls * levels * machine.latency, cuts if ranks > 1 else 0.0)))


def seconds(machine, particles, ranks):
    """Time of a step [s]."""
    return sum(predict(machine, particles, ranks).values())


def text(value):
    """A number with three digits."""
    return f"{value:.0f}" if value >= 100 else f"{value:.3g}"


CASES = (("one thread per rank, 1 GB/s", Machine()),
         ("one thread per rank, 0.2 GB/s", Machine(bandwidth=0.2e9)),
         ("16 threads per rank, 3.2 GB/s", Machine(threads=16, bandwidth=3.2e9)))


def table(ranks=10 ** 4):
    """Markdown: terms of a step on many ranks."""
    lines = ["| machine | particles per core | " + " | ".join(TERMS) + " | step | efficiency |",
             "|" + "---|" * (len(TERMS) + 4)]
    for name, machine in CASES:
        for each in (10 ** 5, 10 ** 6, 10 ** 7):
            terms = predict(machine, each * machine.threads, max(1, ranks // machine.threads))
            alone = each / machine.rate
            lines.append(f"| {name} | $10^{round(math.log10(each))}$ | "
                         + " | ".join(text(1e3 * value) for value in terms.values())
                         + f" | {text(1e3 * sum(terms.values()))} | {alone / sum(terms.values()):.2f} |")
    return "\n".join(lines) + "\n"


def draw(path):
    """Left: time of the parts of a step over the number of ranks; right: strong scaling for a given number of
    particles."""
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from scree.plot import COLOURS
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.6, 4.4), layout="constrained")
    ranks = [2 ** n for n in range(0, 18)]
    machine, each = CASES[0][1], 10 ** 6
    parts = [predict(machine, each, n) for n in ranks]
    left.stackplot(ranks, [[1e3 * part[term] for part in parts] for term in TERMS], labels=TERMS,
                   colors=(COLOURS[0], COLOURS[5], COLOURS[4], COLOURS[6], COLOURS[1], COLOURS[2], COLOURS[3]))
    left.set(xscale="log", xlim=(1, ranks[-1]), xlabel="ranks", ylabel="time of a step [ms]",
             title="weak scaling, $10^6$ particles per rank")
    left.set_ylim(0, 1.45 * 1e3 * sum(parts[-1].values()))
    left.legend(frameon=False, fontsize=8, ncol=2, loc="upper left")
    total = 10 ** 10
    for colour, (name, machine) in zip(COLOURS, CASES):
        cores = [2 ** n for n in range(8, 21)]
        points = [(n, total / machine.rate / n / seconds(machine, total / n * machine.threads, n / machine.threads))
                  for n in cores]
        right.plot(*zip(*points), "o-", ms=3.5, color=colour, label=name)
    right.set(xscale="log", xlabel="cores", ylabel="parallel efficiency", ylim=(0, 1),
              title="strong scaling, $10^{10}$ particles")
    right.legend(frameon=False, fontsize=8, loc="lower left")
    for panel in (left, right):
        panel.spines[["top", "right"]].set_visible(False)
    figure.savefig(path, dpi=200)


def main():
    """Print the table and draw the figure."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, help="file of the figure")
    options = parser.parse_args()
    if options.out:
        sys.path.insert(0, str(ROOT / "python/src"))
        draw(options.out)
    print(table(), end="")


if __name__ == "__main__":
    main()
