# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""Programs, libraries and modules contain no path of the folder in which they were built.

Would catch a source that is passed to the compiler with its absolute path, and compiler flags in --version that contain
such a path: then two builds of one commit would differ, and a package would show where it was built.
"""

import gzip
import subprocess

import case

GZIP = b"\x1f\x8b"


def files_of(build):
    """The files that an installation of a build contains, but programs of flang, which have absolute paths in them."""
    modules = sorted((build / "modules").rglob("*.mod"))
    version = subprocess.run([build / "bin/scree", "--version"], capture_output=True, text=True, check=True).stdout
    return modules if "flang" in version else [build / "bin/scree", *build.glob("lib/libscree.so"), *modules]


def test_no_path_of_the_build(options):
    build = options.scree.parents[1]
    found = files_of(build)
    assert len(found) > 300, found[:3]
    offences = []
    for path in found:
        data = path.read_bytes()
        if path.suffix == ".mod":
            # gfortran compresses modules, flang writes text
            data = gzip.decompress(data) if data.startswith(GZIP) else data
        elif b"src/program/program_main.f90" not in data and b"src/run/run_type.f90" not in data:
            offences.append(f"{path.name} names no source, so this test sees nothing in it")
        if str(case.ROOT).encode() + b"/" in data:
            at = data.index(str(case.ROOT).encode() + b"/")
            offences.append(f"{path.name}: {data[at:at + 100].split(bytes([0]))[0].decode(errors='replace')}")
    assert not offences, "\n" + "\n".join(offences[:20])
