# SPDX-License-Identifier: BSD-3-Clause
"""Every method, basis, transfer and order of the stress update flies a bar and throws two discs.

Would catch: a combination that stops to run, loses momentum, or changes its result for the better or the
worse without a word: what holds today for the good ones is held here, and the table is in
doc/theory/matrix_of_methods.md.

The problems are those of the tests free_bar and two_discs (cells of 0.5 m and of 0.025 m), without
artificial viscosity. A figure is the change of energy over that at the start, in percent: of the vibration of the
bar, of both discs. A run that ends with an error, or not in 100 s, is `x`, one with more than a hundred times
its energy `large`.

`--write FILE` puts the table into a file, `--only WORD` takes the methods whose name holds a word and judges
their momentum only.
"""
# label: long
# timeout: 3600

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "support"))
import bodies  # noqa: E402
import case    # noqa: E402
import report  # noqa: E402

TRANSFERS = {"flip": "", "pic": "", "apic": "", "aflip": "", "rflip": "", "xpic": " order_k=2", "fmpm": " order_k=2"}
UPDATES = ("usl", "usf", "musl")


def kinds(options):
    """Names of the methods: words of &run and &method; rules and bases as the program lists them."""
    listed = case.Case(options, "template", "").run("--template").output.split("\n")
    found = {}
    for key, method in (("quadrature", "ddmp"), ("basis", "mpm")):
        line = next(line for line in listed if line.strip(" !").startswith(f"{key} ="))
        for word in line.split("{")[1].split("}")[0].split("|"):
            found[f"{method} {word}"] = (method, f"{key}='{word}'")
    return found


def cell(result):
    """Change of energy in percent."""
    if result["code"]:
        return "x"
    return f"{100.0 * result['energy']:+.2f}" if abs(result["energy"]) < 100.0 else "large"


def measure(options, figures):
    """The table; `figures` gets both results of all combinations."""
    lines = ["| method | transfer | " + " | ".join(f"bar {word}" for word in UPDATES) + " | "
             + " | ".join(f"discs {word}" for word in UPDATES) + " |", "|---" * 8 + "|"]
    only = sys.argv[sys.argv.index("--only") + 1] if "--only" in sys.argv else ""
    for kind, (method, own) in kinds(options).items():
        if only not in kind:
            continue
        for transfer, more in TRANSFERS.items():
            cells = []
            for problem in (bodies.free_bar, bodies.two_discs):
                for update in UPDATES:
                    words = f"{own} transfer='{transfer}'{more} stress_update='{update}'"
                    result = problem(options, "run", method, words)
                    figures[kind, transfer, update, problem.__name__] = result
                    cells.append(cell(result))
            lines.append(f"| {kind} | `{transfer}` | " + " | ".join(cells) + " |")
            print(lines[-1], flush=True)
    return "\n".join(lines) + "\n"


def main():
    """All combinations; what is held is the momentum of all that run, and the energy of the good ones."""
    options = case.arguments()
    options.timeout = 100              # what is unstable may make ever shorter steps
    sheet = report.Report()
    figures = {}
    table = measure(options, figures)
    if "--write" in sys.argv:
        Path(sys.argv[sys.argv.index("--write") + 1]).write_text(table, encoding="utf-8")
    worst = max(result["momentum"] for result in figures.values()
                if not result["code"] and abs(result["energy"]) < 100.0)
    sheet.below("momentum, the worst of all that run", worst, 1.0e-13)
    if "--only" in sys.argv:
        sheet.end()
    sheet.require(len(figures) >= 7 * 7 * 3 * 2, "all combinations were tried")
    for transfer in ("flip", "apic", "aflip", "rflip", "xpic", "fmpm"):
        result = figures["ddmp point", transfer, "usl", "free_bar"]
        sheet.require(not result["code"], f"ddmp, {transfer}: the bar flies")
        sheet.below(f"ddmp, {transfer}: energy of the bar", result.get("energy", float("nan")), 0.01)
    for transfer in ("flip", "aflip", "rflip"):
        result = figures["ddmp point", transfer, "usl", "two_discs"]
        sheet.below(f"ddmp, {transfer}: energy of the discs", result.get("energy", float("nan")), 0.035)
    sheet.end()


if __name__ == "__main__":
    main()
