! SPDX-License-Identifier: BSD-3-Clause
!> The groups &grains and &cell: their keys, their checks, and the cell that they describe.
module grains_deck
   use base_constants, only: pi
   use base_kinds, only: int64, wp
   use base_text, only: brief
   use deck_reader, only: deck_t, group_t
   use deck_schema, only: changes_physics, schema_t
   use grains_cell, only: cell_t
   use grains_law, only: hertz_law, linear_law
   use grains_packing, only: fill_lattice, fill_random, grain_radii, set_masses
   use grains_path, only: check_stages, declare_stages
   implicit none
   private

   public :: check_grains, declare_grains, grains_memory, read_grains_cell, require_grains

   real(wp), parameter :: most_grains = 1.0e8_wp     !! As the key `number` allows

contains

   !> Declare &grains, &cell and &stage.
   subroutine declare_grains(schema)
      type(schema_t), intent(inout) :: schema        !! Keys of the deck

      call schema%group("grains", &
         "grains of a periodic cell, for scree --grains; simulations of a scene ignore it")
      call schema%text("grains", "shape", "grains: discs of 1 m thickness in x and y, or spheres", &
         default="discs", words="discs spheres")
      call schema%integer("grains", "number", "number of grains", range="> 1 <= 100000000", &
         owner="cell.packing = random")
      call schema%real("grains", "diameter", "mean diameter", unit="m", range="> 0")
      call schema%real("grains", "spread", "half the range of diameters, over the mean", &
         default="0.2", range=">= 0 < 0.9", owner="cell.packing = random")
      call schema%text("grains", "sizes", &
         "distribution of diameters: uniform over the range, or two sizes at its ends", &
         default="uniform", words="uniform two")
      call schema%real("grains", "density", "density of the solid", unit="kg/m3", range="> 0")
      call schema%text("grains", "law", "contact law: linear, springs of constant stiffness; "// &
         "hertz, elastic spheres after Hertz and Mindlin", default="linear", words="linear hertz")
      call schema%real("grains", "stiffness", "normal stiffness of a contact", unit="N/m", &
         range="> 0", owner="law = linear")
      call schema%real("grains", "tangential_ratio", "tangential over normal stiffness", &
         default="0.5", range="> 0 <= 1", owner="law = linear")
      call schema%real("grains", "young", "Young's modulus of the solid", unit="Pa", range="> 0", &
         owner="law = hertz")
      call schema%real("grains", "poisson", "Poisson's ratio of the solid", default="0.25", &
         range=">= 0 <= 0.5", owner="law = hertz")
      call schema%real("grains", "restitution", &
         "coefficient of restitution: speed after over speed before a collision", default="0.5", &
         range="> 0 <= 1")
      call schema%real("grains", "friction", "friction coefficient between grains", default="0.4", &
         range=">= 0")
      call schema%integer("grains", "steps_per_contact", "time steps in the shortest collision", &
         default="50", range=">= 10 <= 100000")
      call declare_cell(schema)
      call declare_stages(schema)
      call schema%forbid_change("grains", "*", "the grains and contacts of the checkpoint were "// &
         "made with it")
      call schema%allow_change("grains", "friction restitution", changes_physics)
   end subroutine declare_grains

   !> Declare &cell.
   subroutine declare_cell(schema)
      type(schema_t), intent(inout) :: schema        !! Keys of the deck

      call schema%group("cell", "periodic cell deformed by the &stage groups: of grains for "// &
         "scree --grains, of the particles of the scene without &grains")
      call schema%text("cell", "packing", "grains: random without overlap, or a perfect lattice", &
         default="random", words="random triangular fcc")
      call schema%integer("cell", "cells(3)", "grains: number of rectangular unit cells of the "// &
         "lattice, with two discs or four spheres each", range="> 0", &
         owner="packing = triangular fcc")
      call schema%real("cell", "overlap", &
         "grains: overlap of neighbours in the lattice over the diameter", default="0", &
         range=">= 0 < 0.1", owner="packing = triangular fcc")
      call schema%real("cell", "volume_fraction", &
         "grains: solid volume over cell volume; default: the greatest without overlap", &
         range="> 0 < 1", owner="packing = random")
      call schema%real("cell", "aspect(3)", &
         "grains: edge lengths of the cell relative to each other", default="1 1 1", range="> 0", &
         owner="packing = random")
      call schema%real("cell", "speed", &
         "grains: root mean square of a component of the random initial velocities", unit="m/s", &
         default="0", range=">= 0")
      call schema%integer("cell", "seed", "grains: seed of the random numbers", default="1", &
         range=">= 0")
      call schema%real("cell", "tilt", "tilt of the y edge along x over the length of the x "// &
         "edge; in a plane scene, of the z edge", default="0")
      call schema%real("cell", "pressure", "pressure held by the servos", unit="Pa", range="> 0")
      call schema%real("cell", "skin", &
         "grains: gap up to which neighbours are listed, over the mean diameter", default="0.25", &
         range="> 0 <= 2")
      call schema%forbid_change("cell", "* + -", "the cell of the checkpoint was made with it")
      call schema%allow_change("cell", "pressure skin", changes_physics)
   end subroutine declare_cell

   !> Keys that a deck for --grains must give.
   subroutine require_grains(schema)
      type(schema_t), intent(inout) :: schema        !! Keys of the deck

      call schema%require("grains", "number diameter density stiffness young")
      call schema%require("cell", "cells")
   end subroutine require_grains

   !> Checks that involve several keys.
   subroutine check_grains(deck)
      type(deck_t), intent(inout) :: deck
      type(group_t) :: grains, cell
      character(len=:), allocatable :: packing, shape, law
      real(wp) :: fraction, spread, reach
      integer :: number, d

      grains = deck%group("grains")
      cell = deck%group("cell")
      call grains%get("shape", shape)
      call grains%get("law", law)
      call grains%get("spread", spread)
      call grains%get("number", number)
      call cell%get("packing", packing)
      call cell%get("volume_fraction", fraction)
      d = merge(2, 3, shape == "discs")
      if (packing == "triangular" .and. d == 3) call deck%add_error(cell, &
         "a triangular lattice is of discs; use packing = 'fcc' for spheres [D347]", "packing")
      if (packing == "fcc" .and. d == 2) call deck%add_error(cell, &
         "an fcc lattice is of spheres; use packing = 'triangular' for discs [D347]", "packing")
      if (law == "hertz" .and. d == 2) call deck%add_error(grains, &
         "the law of Hertz is for spheres; for discs use law = 'linear' [D347]", "law")
      if (packing == "random" .and. grains%valid(["spread", "number"]) .and. &
         grains%given("number")) then
         reach = loosest(d, spread)
         if (cell%given("volume_fraction") .and. fraction > reach) call deck%add_error(cell, &
            "grains placed at random without overlap reach "//deck%shown(reach, "1")// &
            "; begin there and compress in a first &stage with servo = 'isotropic' [D347]", &
            "volume_fraction")
         if (number < 4**d) call deck%add_error(grains, &
            "a periodic cell needs four grains or more along each edge [D347]", "number")
      end if
      if (packing /= "random" .and. cell%given("cells") .and. cell%valid(["cells"])) &
         call check_lattice(deck, cell, d)
      call check_stages(deck)
   end subroutine check_grains

   !> Refuse a lattice of more grains than integers count.
   subroutine check_lattice(deck, group, dimension)
      type(deck_t), intent(inout) :: deck
      type(group_t), intent(in) :: group             !! &cell
      integer, intent(in) :: dimension
      real(wp) :: number

      number = lattice_grains(group, dimension)
      if (number > most_grains) call deck%add_error(group, "the lattice has "//brief(number)// &
         " grains; the greatest number is "//brief(most_grains)//": write fewer cells [D448]", &
         "cells")
   end subroutine check_lattice

   !> Grains of a lattice.
   real(wp) function lattice_grains(group, dimension) result(number)
      type(group_t), intent(in) :: group             !! &cell
      integer, intent(in) :: dimension
      integer :: cells(3)

      call group%get("cells", cells)
      number = product(real(cells(:dimension), wp))*merge(2.0_wp, 4.0_wp, dimension == 2)
   end function lattice_grains

   !> Memory of a cell on a number of ranks, each of which has all grains, before it is made [byte].
   !! Measured with 20000 to 200000 grains: 740 bytes per grain, and 370 for each of its neighbours
   !! (12 spheres or 6 discs in a dense cell; next to none while grains are far apart).
   real(wp) function grains_memory(deck, ranks) result(bytes)
      type(deck_t), intent(in) :: deck               !! Without errors
      integer, intent(in) :: ranks                   !! Number of them
      real(wp), parameter :: own = 740.0_wp, neighbour = 370.0_wp
      type(group_t) :: cell, grains, stage
      character(len=:), allocatable :: packing, shape
      integer :: count, n
      logical :: dense, discs

      grains = deck%group("grains")
      call grains%get("shape", shape)
      discs = shape == "discs"
      cell = deck%group("cell")
      call cell%get("packing", packing)
      dense = packing /= "random"
      call grains%get("number", count)
      bytes = real(count, wp)
      if (dense) bytes = lattice_grains(cell, merge(2, 3, discs))
      do n = 1, deck%count("stage")
         stage = deck%group("stage", n)
         dense = dense .or. stage%given("servo")
      end do
      bytes = bytes*(own*real(ranks, wp) + merge(neighbour, 0.0_wp, dense)*merge(6.0_wp, 12.0_wp, &
         discs))
   end function grains_memory

   !> Volume fraction at which the largest grains fit the sites of a square or cubic lattice, with a
   !! small margin [1].
   pure real(wp) function loosest(dimension, spread) result(fraction)
      integer, intent(in) :: dimension
      real(wp), intent(in) :: spread                 !! Key `spread` of &grains
      real(wp), parameter :: room = 0.9_wp

      fraction = room*merge(pi/4.0_wp, pi/6.0_wp, dimension == 2)/(1.0_wp + spread)**dimension
   end function loosest

   !> Make the cell. The same on all ranks.
   subroutine read_grains_cell(deck, cell)
      type(deck_t), intent(in) :: deck               !! Without errors
      type(cell_t), intent(inout) :: cell            !! With a communicator
      type(group_t) :: group, grains
      character(len=:), allocatable :: word
      real(wp) :: number, skin

      grains = deck%group("grains")
      group = deck%group("cell")
      call grains%get("shape", word)
      cell%box%dimension = merge(2, 3, word == "discs")
      call grains%get("diameter", cell%diameter)
      call grains%get("density", cell%density)
      call read_law(grains, cell)
      call group%get("packing", word)
      if (word == "random") then
         call pack_random(grains, group, cell)
      else
         call pack_lattice(group, cell)
      end if
      call group%get("tilt", number)
      call tilt_cell(number, cell)
      call group%get("skin", skin)
      cell%skin = skin*cell%diameter
      call choose_step(grains, cell)
   end subroutine read_grains_cell

   !> Read the contact law.
   subroutine read_law(grains, cell)
      type(group_t), intent(in) :: grains            !! &grains
      type(cell_t), intent(inout) :: cell
      character(len=:), allocatable :: word
      real(wp) :: stiffness, ratio, restitution, friction

      call grains%get("restitution", restitution)
      call grains%get("friction", friction)
      call grains%get("law", word)
      if (word == "linear") then
         call grains%get("stiffness", stiffness)
         call grains%get("tangential_ratio", ratio)
         cell%law = linear_law(stiffness, ratio, restitution, friction)
      else
         call grains%get("young", stiffness)
         call grains%get("poisson", ratio)
         cell%law = hertz_law(stiffness, ratio, restitution, friction)
      end if
   end subroutine read_law

   !> Grains at random.
   subroutine pack_random(grains, group, cell)
      type(group_t), intent(in) :: grains            !! &grains
      type(group_t), intent(in) :: group             !! &cell
      type(cell_t), intent(inout) :: cell
      character(len=:), allocatable :: sizes
      real(wp) :: spread, fraction, aspect(3), speed
      integer :: number, seed

      call grains%get("number", number)
      call grains%get("spread", spread)
      call grains%get("sizes", sizes)
      call group%get("seed", seed)
      fraction = loosest(cell%box%dimension, spread)
      if (group%given("volume_fraction")) call group%get("volume_fraction", fraction)
      call group%get("aspect", aspect)
      call group%get("speed", speed)
      call cell%grains%allocate(number)
      call grain_radii(int(seed, int64), cell%diameter, spread, sizes == "two", cell%grains%radius)
      call set_masses(cell)
      call fill_random(int(seed, int64), fraction, aspect, speed, cell)
   end subroutine pack_random

   !> Equal grains on a lattice.
   subroutine pack_lattice(group, cell)
      type(group_t), intent(in) :: group             !! &cell
      type(cell_t), intent(inout) :: cell
      real(wp) :: overlap
      integer :: cells(3)

      call group%get("cells", cells)
      call group%get("overlap", overlap)
      if (cell%box%dimension == 2) cells(3) = 1
      call cell%grains%allocate(product(cells)*merge(2, 4, cell%box%dimension == 2))
      cell%grains%radius = 0.5_wp*cell%diameter
      call set_masses(cell)
      call fill_lattice(cells, cell%diameter*(1.0_wp - overlap), cell)
   end subroutine pack_lattice

   !> Tilt the y edge without moving the grains. Integer parts of the tilt have no effect and are
   !! omitted: a tilt of 1 gives the same bits as 0.
   pure subroutine tilt_cell(tilt, cell)
      real(wp), intent(in) :: tilt                   !! Over the x edge [1]
      type(cell_t), intent(inout) :: cell
      real(wp) :: part

      part = tilt - anint(tilt)
      cell%box%edges(1, 2) = part*cell%box%edges(1, 1)
      if (.not. abs(part) > 0.0_wp) return
      cell%grains%place(1, :) = cell%grains%place(1, :) - part*cell%grains%place(2, :)
   end subroutine tilt_cell

   !> The time step: a fraction of the shortest collision of two of the smallest grains. The Hertz
   !! collision time depends on the speed; this one assumes an overlap of 2 % of the radius.
   subroutine choose_step(grains, cell)
      type(group_t), intent(in) :: grains            !! &grains
      type(cell_t), intent(inout) :: cell
      real(wp), parameter :: deep = 0.02_wp
      real(wp) :: mass, radius, stiffness
      integer :: steps

      call grains%get("steps_per_contact", steps)
      mass = 0.5_wp*minval(cell%grains%mass)
      radius = 0.5_wp*minval(cell%grains%radius)
      if (cell%law%hertz) then
         stiffness = 1.5_wp*cell%law%normal*sqrt(radius*deep*radius)
         cell%collision = pi*sqrt(mass/stiffness)
      else
         cell%collision = cell%law%duration(mass, radius, 1.0_wp)
      end if
      cell%dt = cell%collision/real(steps, wp)
   end subroutine choose_step
end module grains_deck
