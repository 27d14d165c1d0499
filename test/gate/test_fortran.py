# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""Rules for the Fortran files of src/ that no compiler checks.

Would catch a module with a state of its own, a hidden sum over threads, and public names without documentation.
"""

import re

from scree.units import parse
from sources import ROOT, Module, code_of, lines_of, place, project_files

# Arguments whose type and name are sufficient documentation.
EVIDENT = {"self", "simulation", "space", "materials", "stores", "fields", "field", "scheme",
           "effects", "clock", "balance", "machine", "grid", "tile", "error", "deck", "schema"}
# Families of modules whose names do not begin with the name of their room.
FAMILIES = {"law": "material", "eos": "material", "damage": "material", "basis": "transfer", "velocity": "transfer",
            "quadrature": "ddmp", "stream": "output", "boundary": "mesh"}
# Dummy arguments that need no docstring, because type and name are sufficient: derived types, and these names.
DERIVED = re.compile(r"^(?:type|class)\s*\(", re.I)
PLAIN_NAMES = {"body", "edge", "key", "label", "line", "name", "p", "path", "point", "text", "tile", "unit"}
# Sums of reals in vectors whose order does not matter: whole numbers, and one that is only checked to be finite.
EXACT_IN_ANY_ORDER = {("damage_johnson_cook", "flowing"), ("law_johnson_cook", "number"),
                      ("law_steinberg_guinan", "number"), ("material_tension", "number"), ("step_bounds", "bad"),
                      ("step_bounds", "fast"), ("step_bounds", "load"), ("step_bounds", "steep")}
SOURCES = project_files(".f90", under="src")
# Names and saved variables of mpi_f08 follow the MPI standard.
MODULES = [Module(path) for path in SOURCES if path.name not in ("main.f90", "mpi_f08.f90")]


def test_no_source_includes_another():
    """The build does not track included files (scripts/build.sh): a changed one would not be compiled again."""
    offences = [place(path, number) for path in project_files(".f90", ".pf", ".in")
                for number, line in enumerate(lines_of(path), 1) if re.match(r"\s*#?\s*include\s*['\"]", line, re.I)]
    assert offences == []


def folder_of(module):
    """The folder of src/ that contains a module; a module may be in a subfolder for one variant of the build."""
    return module.path.relative_to(ROOT / "src").parts[0]


def documented(lines, line):
    """True if a `!>` paragraph is directly above a line."""
    above = line - 2
    while above >= 0 and lines[above].lstrip().startswith("!"):
        if lines[above].lstrip().startswith("!>"):
            return True
        above -= 1
    return False


def explains_itself(declaration):
    """True for a declaration of dummy arguments whose types and names are sufficient documentation."""
    names = re.findall(r"(\w+)(?:\([^()]*\))?", declaration.split("::")[1].lower())
    return bool(DERIVED.match(declaration)) or set(names) <= PLAIN_NAMES


def units_in(text):
    """Units in the declarations of keys and of fields of particles, and in derived columns."""
    text = re.sub(r"&\s*\n\s*", "", text)
    field = r"worker%(?:scalar|vector|whole)\(\"\w+\", *\"([^\"]*)\""
    return [unit for pattern in (field, r"\bunit=\"([^\"]*)\"", r"%unit = \"([^\"]+)\"")
            for unit in re.findall(pattern, text)]


def test_units_are_known():
    """Would catch a unit without powers: files would store zeros for it, and Python would not convert its numbers."""
    units = {unit for path in SOURCES for unit in units_in(path.read_text(encoding="utf-8"))}
    assert {"1", "kg", "m/s", "J/(kg K)", "N/m", "deg"} <= units
    assert [unit for unit in sorted(units) if parse(unit) is None] == []
    assert parse("furlong/s") is None


def public_names():
    """Public names of each module; whether each one counts, or its documentation gives a reason for a second home."""
    homes = {}
    for module in MODULES:
        lines = lines_of(module.path)
        first = next(number for number, line in enumerate(lines, 1) if re.match(r"module\s", line, re.I))
        header = "\n".join(lines[:first])
        imported = {name for _, _, text in module.uses for name in re.findall(r"\w+", text.split("only", 1)[-1])}
        reasons = [word.replace("*", r"\w*") for word in re.findall(r"`([\w*]+)`", header)]
        homes.setdefault(module.name, {}).update({
            name: name not in imported or not any(re.fullmatch(word, name) for word in reasons)
            for name in module.public})
    return homes


def repeated_names(homes):
    """Public names that several modules have."""
    found = {}
    for module, names in homes.items():
        for name, counts in names.items():
            if counts:
                found.setdefault(name, []).append(module)
    return [f"{name} is public in {', '.join(sorted(modules))}"
            for name, modules in sorted(found.items()) if len(modules) > 1]


class TestFortranGate:
    """One rule per test; all violations are listed."""

    def none(self, offences):
        assert len(offences) == 0, "\n" + "\n".join(offences)

    def test_sources_are_found(self):
        assert len(MODULES) > 5
        assert sum(len(module.procedures) for module in MODULES) > 20

    def test_no_setting_in_documentation(self):
        """FORD takes a paragraph whose first line begins with a word and a colon for a setting, and drops its text."""
        self.none([f"{place(path, number)} begins with a setting for FORD: {line.strip()}"
                   for path in SOURCES for number, line in enumerate(lines_of(path), 1)
                   if re.match(r"\s*!> *\w+:(\s|$)", line)])

    def test_path_is_name(self):
        offences = []
        for module in MODULES:
            prefix = module.name.split("_")[0]
            if module.name != module.path.stem:
                offences.append(f"{place(module.path, 1)} holds module {module.name}")
            if folder_of(module) != FAMILIES.get(prefix, prefix):
                offences.append(f"{place(module.path, 1)} has no name of its folder")
        self.none(offences)

    def test_header(self):
        offences = []
        for module in MODULES:
            if not module.implicit_none:
                offences.append(f"{place(module.path, 1)} implicit none is missing")
            if not module.private:
                offences.append(f"{place(module.path, 1)} private is missing")
            offences += [f"{place(module.path, line)} use without only: {text}"
                         for _, line, text in module.uses if not re.search(r",\s*only\s*:", text)]
        self.none(offences)

    def test_no_state(self):
        # a signal handler has no arguments of its own, so its flag must be a module variable
        self.none([f"{place(module.path, line)} module variable: {text}"
                   for module in MODULES for line, text in module.variables
                   if (module.name, "volatile") != ("run_signals", *re.findall("volatile", text))])

    def test_libraries_stay_in_their_files(self):
        offences = []
        for module in MODULES:
            for name, line, _ in module.uses:
                if name in ("mpi", "mpi_f08") and module.name != "base_communicator":
                    offences.append(f"{place(module.path, line)} only base_communicator uses MPI")
                if name == "hdf5" and not module.name.startswith("io_hdf5"):
                    offences.append(f"{place(module.path, line)} only io_hdf5* use HDF5")
        self.none(offences)

    def test_no_preprocessor(self):
        self.none([place(path, number) for path in SOURCES
                   for number, line in enumerate(lines_of(path), 1) if line.startswith("#")])

    def test_documentation(self):
        offences = []
        for module in MODULES:
            lines = lines_of(module.path)
            first = next(number for number, line in enumerate(lines, 1)
                         if re.match(r"module\s", line, re.I))
            if not documented(lines, first):
                offences.append(f"{place(module.path, first)} module {module.name} has no !>")
            for name, line in module.types:
                if not documented(lines, line):
                    offences.append(f"{place(module.path, line)} type {name} has no !>")
            for name, line, *_ in module.procedures:
                if name in module.interface() and not documented(lines, line):
                    offences.append(f"{place(module.path, line)} {name} has no !>")
        self.none(offences)

    def test_public_names_are_unique(self):
        """Would catch a name with two meanings, and a second home of one thing.

        Variants of a module for two builds have the same names. A module may make a name of another one public as well
        if its documentation names it and gives the reason.
        """
        assert {"pi", "xx", "xz", "symmetric"} <= public_names()["base_constants"].keys()
        self.none(repeated_names(public_names()))

    def test_repeated_names_are_found(self):
        """The rule itself."""
        homes = {"one": {"part_t": True, "whole_t": True}, "two": {"part_t": True}, "three": {"whole_t": False}}
        assert repeated_names(homes) == ["part_t is public in one, two"]
        homes["three"]["part_t"] = True
        assert repeated_names(homes) == ["part_t is public in one, three, two"]

    def test_arguments_are_documented(self):
        offences = []
        for module in MODULES:
            lines = lines_of(module.path)
            for name, _, _, arguments, body in module.procedures:
                if name not in module.interface():
                    continue
                for line, text in body:
                    if "intent(" not in text.lower() or explains_itself(text):
                        continue
                    end = line
                    while code_of(lines[end - 1]).endswith("&"):
                        end += 1
                    beside = any("!!" in lines[number] for number in range(line - 1, end))
                    evident = re.search(r":: *(\w+)", text).group(1) in EVIDENT
                    if not (beside or evident or documented(lines, line)):
                        offences.append(f"{place(module.path, line)} {name}: no !! on {text}")
        self.none(offences)

    def test_what_explains_itself(self):
        """The rule itself: numbers need a docstring with meaning and unit, objects and paths do not."""
        for text in ("class(store_t), intent(inout) :: self", "type(error_t), allocatable, intent(out) :: error",
                     "character(len=*), intent(in) :: path", "integer, intent(in) :: tile"):
            assert explains_itself(text), text
        for text in ("real(wp), intent(in) :: dt", "integer, intent(in) :: tile, count",
                     "real(wp), intent(in) :: position(3)"):
            assert not explains_itself(text), text

    def test_open_mp_says_what_is_shared(self):
        offences = []
        for path in SOURCES:
            text = path.read_text(encoding="utf-8").lower()
            for found in re.finditer(r"^\s*!\$omp parallel.*(?:&\n\s*!\$omp.*)*", text, re.M):
                number = text.count("\n", 0, found.start() + 1) + 1
                if "default(none)" not in found.group(0):
                    offences.append(f"{place(path, number)} has no default(none)")
                if "reduction(" in found.group(0) and re.search(r"reduction\(\+", found.group(0)):
                    offences.append(f"{place(path, number)} sums in an order that threads decide")
        self.none(offences)

    def test_vectors_sum_no_reals(self):
        """The last bits of such a sum depend on the number of reals in a vector of the processor."""
        offences, sums = [], 0
        for path in SOURCES:
            text = path.read_text(encoding="utf-8").lower()
            for found in re.finditer(r"^\s*!\$omp [^\n]*\bsimd\b.*(?:&\n\s*!\$omp.*)*", text, re.M):
                number = text.count("\n", 0, found.start() + 1) + 1
                for names in re.findall(r"reduction\s*\(\s*[+*-]\s*:([^)]*)\)", found.group(0)):
                    for name in re.findall(r"\w+", names):
                        declared = re.findall(rf"^\s*(?:\w+ )*(integer|real|complex)\b[^!\n]*\b{name}\b",
                                              text[:found.start()], re.M)
                        sums += 1
                        if declared[-1:] != ["integer"] and (path.stem, name) not in EXACT_IN_ANY_ORDER:
                            offences.append(f"{place(path, number)} sums {name} in an order that the processor "
                                            "decides; see add_products of base_lane_sum")
        assert sums > 5, "counts of particles are sums in vectors"
        self.none(offences)

    def test_no_fast_math(self):
        files = project_files(".txt", ".cmake", ".sh")
        word = "fast-" + "math"
        self.none([place(path, number) for path in files if path.is_relative_to(ROOT / "scripts")
                   or path.suffix != ".sh" for number, line in enumerate(lines_of(path), 1)
                   if word in line])
