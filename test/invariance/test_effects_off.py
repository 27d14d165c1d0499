# SPDX-License-Identifier: BSD-3-Clause
"""An effect that is switched off has no influence: the same bits, bytes and phases as if the deck did not name it.

Would catch: a field that is allocated although nothing requested it, an exchange or a phase of an effect that is off,
and an effect that changes the state although it is off. Effects that are on must change the state; otherwise the test
would show nothing. The scenes name usl, because some effects exclude usavg, the default of elastic material; the others
are compared with it too. Instructions are counted by test/bench/effects.py.
"""
# timeout: 200

import case
import effects

STEPS = 12
# Effects with a phase of their own; all other effects are timed in the phases of every run.
OWN_PHASE = {"conduction": "heat conduction", "contact": "contact"}


def test_effects_off(options, sheet):
    """Every effect with a switch."""
    seen = {}

    def run(name, deck):
        if deck not in seen:
            summary = case.Case(options, name, deck.replace("{steps}", str(STEPS))).run("-q").summary
            seen[deck] = (summary["digest"], summary["bytes_per_particle"],
                          {phase: times["calls"] for phase, times in summary["timers"].items()})
        return seen[deck]

    compared = 0
    for name, (off, never, on) in effects.EFFECTS.items():
        if off is None and name not in OWN_PHASE:
            continue
        with_it = run(f"{name}_on", on)
        without = run(f"{name}_off", off or never)
        # failure, softening and differences of temperature begin after these few steps
        if name not in ("damage", "size_scatter", "voids", "melting", "rate", "conduction"):
            sheet.require(with_it[0] != without[0], f"{name}: acts when it is on")
        for phase in OWN_PHASE.values():
            sheet.require((phase in with_it[2]) == (OWN_PHASE.get(name) == phase), f"{name}: phases when it is on")
            sheet.require(phase not in without[2], f"{name}: no phase when it is off")
        sheet.require(with_it[1] >= without[1] or name == "strength", f"{name}: bytes do not fall")
        if off is None or never is None or name == "strength":
            continue
        compared += 1
        never_named = run(f"{name}_never", never)
        sheet.require(without[0] == never_named[0], f"{name}: the same bits off and never named")
        sheet.require(without[1] == never_named[1], f"{name}: the same bytes off and never named")
        sheet.require(without[2] == never_named[2], f"{name}: the same phases, called as often")
    sheet.require(compared >= 8, "effects were compared")
    for name in ("artificial_viscosity", "gravity", "contact", "damping", "antilock"):
        off, never, _ = (deck.replace("stress_update='usl'", "") for deck in effects.EFFECTS[name])
        other = run(f"{name}_never_usavg", never)
        sheet.require(run(f"{name}_off_usavg", off) == other,
                      f"{name}: with usavg the same bits, bytes and phases off and never named")
        sheet.require(other[0] != run(f"{name}_never", effects.EFFECTS[name][1])[0], f"{name}: usavg differs from usl")
    for name in ("thermal", "damage", "size_scatter", "voids", "conduction"):
        off, never, on = effects.EFFECTS[name]
        sheet.above(f"{name}: bytes that it carries", run(name, on)[1] - run(name, off or never)[1], 8.0)
