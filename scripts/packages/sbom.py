#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""List of the parts of Scree with versions and licences (SBOM), as CycloneDX 1.5 JSON.

    build/venv/bin/python scripts/packages/sbom.py --scree build/bin/scree FILE

Three kinds of parts: libraries that the program loads, found by ldd and dpkg; packages that the wheel needs, and those
whose files the manual contains, both as installed for the Python that runs this script. The versions are those found,
not those allowed. The time is that of SOURCE_DATE_EPOCH, so the same parts give the same file. An unknown licence is an
error. Needs dpkg, so it runs on Debian and Ubuntu.
"""

import argparse
import hashlib
import importlib.metadata
import json
import os
import re
import subprocess
import sys
import time
import uuid
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
GCC_RUNTIME = "GPL-3.0-or-later WITH GCC-exception-3.1"
# Licences of the libraries that the program itself needs, by the beginning of their Debian package; SPDX expressions.
# They are those of upstream; the copyright files of Debian list single files under other free licences.
NATIVE = {
    "libgfortran": GCC_RUNTIME, "libgomp": GCC_RUNTIME, "libgcc": GCC_RUNTIME, "libquadmath": "LGPL-2.1-or-later",
    "libc6": "LGPL-2.1-or-later", "libopenmpi": "BSD-3-Clause-Open-MPI", "libmpich": "mpich2",
    "libhdf5": "HDF5", "zlib1g": "Zlib"}
# Packages whose own metadata have no SPDX expression.
PYTHON = {
    "matplotlib": "PSF-2.0", "f90nml": "Apache-2.0", "scipy": "BSD-3-Clause", "tqdm": "MPL-2.0 AND MIT",
    "vtk": "BSD-3-Clause", "imageio-ffmpeg": "BSD-2-Clause", "mkdocs-material": "MIT", "mkdocs": "BSD-2-Clause",
    "django-static-mathjax": "Apache-2.0", "numpy": "BSD-3-Clause", "h5py": "BSD-3-Clause", "pandas": "BSD-3-Clause",
    "xarray": "Apache-2.0", "pyvista": "MIT",
    "mpi4py": "BSD-3-Clause"}
# The manual contains style and search of the first and MathJax of the second.
SITE = ("mkdocs-material", "django-static-mathjax")


def fail(text):
    """End with a message."""
    sys.exit(f"sbom.py: {text}")


def said(*words):
    """What a command prints."""
    try:
        return subprocess.run(words, check=True, text=True, capture_output=True).stdout
    except (OSError, subprocess.CalledProcessError) as error:
        fail(f"{words[0]} fails: {error}")


def owners_of(paths):
    """Debian packages that own files, which may be named by /lib or by /usr/lib."""
    names = set()
    for path in paths:
        answers = [subprocess.run(["dpkg", "-S", name], text=True, capture_output=True, check=False)
                   for name in (path, os.path.realpath(path), "/usr" + path)]
        owner = next((answer.stdout for answer in answers if answer.returncode == 0), "")
        if not owner:
            fail(f"no Debian package owns {path}; use a program that is linked to libraries of the system")
        names.add(owner.split(": ")[0].split(",")[0].split(":")[0])
    return names


def debian_licence(package):
    """Licence of most files of a package, from its machine-readable copyright file; empty if it has none."""
    path = Path("/usr/share/doc") / package / "copyright"
    text = path.read_text(encoding="utf-8", errors="replace") if path.is_file() else ""
    found = re.search(r"^Files: ?\*\n(?:(?!Files:).*\n)*?License: *(\S.*)$", text, re.M)
    return found.group(1).strip() if found else ""


def native_parts(program):
    """Components for the libraries that a program loads."""
    needed = set(re.findall(r"NEEDED +(\S+)", said("objdump", "-p", program)))
    lines = [line.split() for line in said("ldd", program).splitlines() if "=> /" in line]
    direct = owners_of(words[2] for words in lines if words[0] in needed)
    parts = []
    for package in sorted(owners_of(words[2] for words in lines) | direct):
        version, kind = said("dpkg-query", "-W", "-f", "${Version} ${Architecture}\n", package).split()[:2]
        part = {"type": "library", "name": package, "version": version,
                "purl": f"pkg:deb/debian/{package}@{version.replace('+', '%2B')}?arch={kind}",
                "properties": [{"name": "scree:used", "value": "linked" if package in direct else "by a library"}]}
        if package in direct:
            known = [licence for name, licence in NATIVE.items() if package.startswith(name)]
            if not known:
                fail(f"the licence of {package} is not known; add it to NATIVE")
            part["licenses"] = [{"expression": known[0]}]
        elif debian_licence(package):
            part["licenses"] = [{"license": {"name": debian_licence(package)}}]
        parts.append(part)
    return parts


def python_part(name, use):
    """Component for an installed Python package; none if it is not installed."""
    try:
        data = importlib.metadata.metadata(name)
    except importlib.metadata.PackageNotFoundError:
        return None
    licence = data.get("License-Expression") or PYTHON.get(name.lower())
    if not licence:
        fail(f"the licence of {name} is not known; add it to PYTHON")
    version = data["Version"]
    return {"type": "library", "name": name, "version": version, "purl": f"pkg:pypi/{name.lower()}@{version}",
            "licenses": [{"expression": licence}], "properties": [{"name": "scree:used", "value": use}]}


def mathjax_part():
    """Component for MathJax, whose version is in its script."""
    import mathjax

    script = Path(mathjax.__file__).parent / "static/mathjax/es5/tex-svg-full.js"
    found = re.search(r'VERSION="(\d+\.\d+\.\d+)"', script.read_text(encoding="utf-8"))
    if not found:
        fail(f"no version in {script}")
    version = found.group(1)
    return {"type": "library", "name": "mathjax", "version": version, "purl": f"pkg:npm/mathjax@{version}",
            "licenses": [{"expression": "Apache-2.0"}],
            "properties": [{"name": "scree:used", "value": "in the manual"}]}


def python_parts():
    """Components for what the wheel needs and for what the manual contains."""
    text = (ROOT / "python/pyproject.toml").read_text(encoding="utf-8")
    required, optional = text.split("[project.optional-dependencies]")
    names = re.findall(r'^   "([\w-]+)[<>=]', required, re.M)
    extra = re.findall(r'"([\w-]+)[<>=]', optional.split("\nrelease = [")[0])
    parts = [python_part(name, "by the wheel") for name in names]
    if None in parts:
        fail(f"{names[parts.index(None)]} is not installed; scripts/setup.sh installs it")
    parts += [part for name in extra if (part := python_part(name, "by an option of the wheel"))]
    parts += [part for name in SITE if (part := python_part(name, "in the manual"))]
    return [*parts, mathjax_part()]


def bill(program):
    """The whole document."""
    version = re.search(r"^project\(scree VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8"),
                        re.M).group(1)
    parts = native_parts(program) + python_parts()
    for part in parts:
        part["bom-ref"] = part["purl"]
    seconds = int(os.environ.get("SOURCE_DATE_EPOCH", time.time()))
    stamp = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(seconds))
    digest = hashlib.sha256(json.dumps([parts, version, stamp]).encode()).hexdigest()
    return {
        "$schema": "http://cyclonedx.org/schema/bom-1.5.schema.json", "bomFormat": "CycloneDX", "specVersion": "1.5",
        "serialNumber": f"urn:uuid:{uuid.UUID(digest[:32], version=4)}", "version": 1,
        "metadata": {"timestamp": stamp, "component": {
            "type": "application", "bom-ref": f"scree@{version}", "name": "scree", "version": version,
            "licenses": [{"expression": "BSD-3-Clause"}]}},
        "components": parts,
        "dependencies": [{"ref": f"scree@{version}", "dependsOn": sorted({part["bom-ref"] for part in parts})}]}


def main():
    """Write the file."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--scree", default=str(ROOT / "build/bin/scree"), help="the program; default build/bin/scree")
    parser.add_argument("file", help="the file to write")
    given = parser.parse_args()
    document = bill(given.scree)
    Path(given.file).write_text(json.dumps(document, indent=2) + "\n", encoding="utf-8")
    print(f"{len(document['components'])} parts in {given.file}")


if __name__ == "__main__":
    main()
