# SPDX-License-Identifier: BSD-3-Clause
"""Random numbers that are a pure function of a seed, and the format of numbers in a deck."""

import math

MASK = (1 << 64) - 1


def mixed(value):
    """A permutation of the integers of 64 bits."""
    value = (value ^ value >> 30) * 0xBF58476D1CE4E5B9 & MASK
    value = (value ^ value >> 27) * 0x94D049BB133111EB & MASK
    return value ^ value >> 31


class Chance:
    """SplitMix64: the same numbers with any version of Python, any hash seed and on any machine."""

    def __init__(self, seed):
        # if the state were the seed itself, the next seed would give the same numbers, shifted by one
        self.state = mixed(seed ^ 0x5DEECE66D)

    def bits(self):
        """The next 64 bits."""
        self.state = (self.state + 0x9E3779B97F4A7C15) & MASK
        return mixed(self.state)

    def uniform(self, low=0.0, high=1.0):
        """Uniform between two numbers, rounded to four significant digits, so that rounding of the mathematics library
        has no effect."""
        return short(low + (high - low) * (self.bits() >> 11) / 9007199254740992.0)

    def log(self, low, high):
        """Uniform in the logarithm, rounded to four significant digits."""
        return short(math.exp(self.uniform(math.log(low), math.log(high))))

    def integer(self, low, high):
        """An integer from low to high, both included."""
        return low + self.bits() % (high - low + 1)

    def true(self, share):
        """True with a given probability."""
        return (self.bits() >> 11) / 9007199254740992.0 < share

    def choose(self, options):
        """One element of a list, or one of the keys of a dict with their weights."""
        if not isinstance(options, dict):
            return options[self.bits() % len(options)]
        level = (self.bits() >> 11) / 9007199254740992.0 * sum(options.values())
        for word, weight in options.items():
            level -= weight
            if level < 0.0:
                return word
        return word


def short(value):
    """A number with four significant digits."""
    return float(f"{value:.4g}")


def written(value):
    """A value as written in a deck."""
    if isinstance(value, bool):
        return ".true." if value else ".false."
    if isinstance(value, str):
        return f"'{value}'"
    if isinstance(value, (list, tuple)):
        return ", ".join(written(item) for item in value)
    return f"{value:.12g}" if isinstance(value, float) else str(value)


def group(kind, /, **keys):
    """A group of a deck; keys whose value is None are left out."""
    lines, line = [], f"&{kind}"
    for key, value in keys.items():
        if value is None:
            continue
        word = f"  {key} = {written(value)}"
        if len(line) + len(word) > 110:
            lines.append(line)
            line = ""
        line += word
    return "\n".join([*lines, line + " /"])
