# SPDX-License-Identifier: BSD-3-Clause
"""The subcommands of scree-post: one module and one word in this list each.

A module has SUMMARY (a line for scree-post --help), EXAMPLES (lines after "scree-post"), its
docstring (the text of --help), add_arguments(parser), and run(arguments), which returns an exit
code or raises ScreeError.
"""
COMMANDS = ("preview", "info", "plot", "picture", "movie", "radiograph", "fragments", "grains", "means",
            "paraview", "compare", "sweep", "accuracy", "validate", "check", "eos", "terrain")
