# SPDX-License-Identifier: BSD-3-Clause
"""Drawing of pictures, used by `scree.picture`, `scree.radiograph` and the commands of scree-post.

    page              a snapshot as a figure, and the areal density of one
    view, space       particles in a plane, and in space as lit balls (render)
    radiograph_page   film, areal density and particles beside each other (areal_density, smear)
    colour, look      what particles are coloured by; letters, units of labels, saving
    box, shape, walls corners of the domain, sizes of particles and mirror images, boundaries
    view_options      the options that pictures and films share; quantity: numbers with units
"""
