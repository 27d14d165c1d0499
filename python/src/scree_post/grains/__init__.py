# SPDX-License-Identifier: BSD-3-Clause
"""Evaluation of cells of grains (scree --grains): constants of the granular law of the continuum.

    cell_run      files of a finished run: deck, history, moduli, contacts
    statistics    means with error bars, drift, bootstrap
    rheology      friction and volume fraction against the inertial number
    memory        strain and time over which the shear stress is kept, measured in several ways
    moduli        G and lambda from probes
    relaxation    closed solution of the relaxation law in simple shear
    material      &material block with provenance
    tables        CSV and JSON files
    pictures      figures; force_chains: grains and contact forces
"""
