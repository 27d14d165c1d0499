# SPDX-License-Identifier: BSD-3-Clause
"""The subcommands of scree-post: a module and a word in this list each.

A module holds SUMMARY (a line for scree-post --help), EXAMPLES (lines behind "scree-post"), its
docstring (what --help says), add_arguments(parser), and run(arguments), which returns an exit code
or raises ScreeError.
"""
COMMANDS = ("preview", "info", "plot", "picture", "movie", "radiograph", "fragments", "grains", "means",
            "paraview", "compare", "sweep", "accuracy", "check", "eos")
