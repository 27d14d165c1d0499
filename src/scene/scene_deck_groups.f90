! SPDX-License-Identifier: BSD-3-Clause
!> Keys of the deck that say what is where: regions, bodies, boundaries.
module scene_deck_groups
   use base_schema, only: schema_t
   use mesh_boundary, only: face_names
   use mesh_boundary_catalogue, only: boundary_names, choose_boundary
   use mesh_boundary_condition, only: boundary_condition_t
   implicit none
   private

   public :: declare_body, declare_boundary, declare_contact, declare_region

   character(len=*), parameter :: solids = &
      "shape = sphere cylinder ellipsoid cone torus halfspace" !! Shapes with a centre
   character(len=*), parameter :: round = "shape = sphere cylinder cone torus" !! With a radius
   character(len=*), parameter :: sets = "shape = union difference intersection"

contains

   !> Declare &region.
   subroutine declare_region(schema)
      type(schema_t), intent(inout) :: schema            !! Keys of the deck

      call schema%group("region", "a shape, or a set operation on shapes", many=.true.)
      call schema%text("region", "name", "what bodies and other regions refer to")
      call schema%text("region", "shape", "kind of shape", &
         words="box sphere cylinder cone ellipsoid torus halfspace prism stl voxel points "// &
         "union difference intersection")
      call schema%real("region", "lo(3)", "lower corner of a box", unit="m", owner="shape = box")
      call schema%real("region", "hi(3)", "upper corner of a box", unit="m", owner="shape = box")
      call schema%real("region", "centre(3)", "centre; of a cylinder or cone the middle of its "// &
         "axis, of a halfspace a point of its plane", unit="m", owner=solids)
      call schema%real("region", "radius", "radius; of a cone where its axis begins, of a "// &
         "torus of the circle in its middle", unit="m", range="> 0", owner=round)
      call schema%real("region", "radius2", "of a cone at the end of its axis, 0 = a tip; of a "// &
         "torus that of its section", unit="m", range=">= 0", owner="shape = cone torus")
      call schema%real("region", "semi_axes(3)", "half the axes, along x, y and z", unit="m", &
         range="> 0", owner="shape = ellipsoid")
      call schema%real("region", "axis(3)", "direction of the axis; of a prism one of the "// &
         "coordinates, in a plane scene the one that it lacks", default="0 0 1", &
         owner="shape = cylinder cone torus prism")
      call schema%real("region", "normal(3)", "direction out of the halfspace", &
         owner="shape = halfspace")
      call schema%real("region", "polygon(:400)", "corners of a prism in turn, two numbers "// &
         "each: in a plane scene x and z, in space the two coordinates other than its axis", &
         unit="m", owner="shape = prism")
      call schema%real("region", "span(2)", "where a prism begins and ends along its axis; in "// &
         "space only", unit="m", owner="shape = prism")
      call schema%text("region", "file", "of stl: facets; of voxel: HDF5, or MetaImage (.mhd, "// &
         ".mha); of points: CSV, or a snapshot (.hdf, .h5); lengths in the unit of the deck; "// &
         "path relative to the deck", owner="shape = stl voxel points")
      call schema%real("region", "point_volume", "volume of each point, where the file has none", &
         unit="m3", range="> 0", owner="shape = points")
      call schema%text("region", "from_body", "body of a snapshot whose points are taken; "// &
         "without it those of all bodies of the material", owner="shape = points")
      call schema%text("region", "dataset", "name of the voxels in an HDF5 file", &
         default="/voxels", owner="shape = voxel")
      call schema%integer("region", "voxel_value", "which voxels belong to it: those of this "// &
         "value, or nearest to it", default="1", owner="shape = voxel")
      call schema%real("region", "height", "length along the axis", unit="m", range="> 0", &
         owner="shape = cylinder cone")
      call schema%text("region", "of(:8)", &
         "regions that the set operation takes; difference: the "// &
         "first without the others", owner=sets)
      call schema%real("region", "scale", "factor, applied first", default="1.0", range="> 0")
      call schema%real("region", "rotate(3)", "angles about x, then y, then z, applied second", &
         unit="deg", default="0 0 0")
      call schema%text("region", "rotate_about", "what rotate keeps in its place: the origin, "// &
         "or the centre of the box around the shape", default="origin", words="origin centre")
      call schema%real("region", "translate(3)", "displacement, applied last", unit="m", &
         default="0 0 0")
      call schema%require("region", "name shape lo hi centre radius radius2 semi_axes "// &
         "normal polygon file height of")
      call schema%refer("region", "of", "region")
   end subroutine declare_region

   !> Declare &body.
   subroutine declare_body(schema)
      type(schema_t), intent(inout) :: schema            !! Keys of the deck

      call schema%group("body", "material points", many=.true.)
      call schema%text("body", "name", "name in outputs")
      call schema%text("body", "region", "where it is")
      call schema%text("body", "material", "what it is made of")
      call schema%integer("body", "ppc(3)", "points per cell along x, y, z", default="2 2 2", &
         range="> 0 <= 16")
      call schema%text("body", "packing", &
         "lattice: whole sites with their middles inside; cut: "// &
         "those at the surface have the volume and centre of what is inside; jitter: a lattice "// &
         "whose points are moved aside by chance, up to a quarter of their distance; "// &
         "poisson_disk: points at random, none near another; file: the points of its region", &
         default="lattice", words="lattice cut jitter poisson_disk file")
      call schema%text("body", "initial_stress", "zero; lithostatic: that of the weight of "// &
         "what lies above without a gap; file: that of the snapshot which its points come from", &
         default="zero", words="zero lithostatic file")
      call schema%real("body", "k0", "stress across gravity over that along it", default="0.5", &
         range=">= 0", owner="initial_stress = lithostatic")
      call schema%real("body", "velocity(3)", "velocity of its centre of mass", unit="m/s", &
         default="0 0 0")
      call schema%real("body", "speed", "velocity of its centre of mass along direction, in "// &
         "the place of velocity", unit="m/s", range=">= 0")
      call schema%real("body", "direction(3)", "direction of speed, of any length; with an "// &
         "angle a: sind(a), 0, cosd(a) in braces")
      call schema%text("body", "velocity_formula(3)", "components of a velocity that is added, "// &
         "as formulas of the place x, y, z at the start, such as '100*x', '0', '-100*z'", &
         unit="m/s")
      call schema%integer("body", "repeat(3)", "number of copies along x, y, z; the copies are "// &
         "called NAME_1, NAME_2 and so on", default="1 1 1", range=">= 1 <= 10000")
      call schema%real("body", "repeat_step(3)", "distance from one copy to the next along x, "// &
         "y, z", unit="m", default="0 0 0")
      call schema%real("body", "spin(3)", "angular velocity about its centre of mass", unit="1/s", &
         default="0 0 0")
      call schema%real("body", "temperature", "temperature at the start", unit="K", &
         default="293.0", &
         range=">= 0", owner="effects.thermal")
      call schema%real("body", "specific_energy", "internal energy per mass at the start; for "// &
         "materials that carry it", unit="J/kg", default="0.0", range=">= 0")
      call schema%integer("body", "field", "velocity field: bodies of the same number move as "// &
         "one where they meet; 0 = one of its own", default="0", range=">= 0", &
         owner="effects.contact")
      call schema%require("body", "name region material")
      call schema%refer("body", "region", "region")
      call schema%refer("body", "material", "material")
      call schema%former("body", "porosity", doc="pores belong to the material: its density is "// &
         "that with pores, eos_model = 'p_alpha' crushes them")
   end subroutine declare_body

   !> Declare &boundary.
   subroutine declare_boundary(schema)
      type(schema_t), intent(inout) :: schema
      class(boundary_condition_t), allocatable :: condition
      character(len=:), allocatable :: meanings, walls
      integer :: n

      call schema%group("boundary", &
         "what holds on a face of the grid, on a part of it, or in a rigid region; faces "// &
         "without one are open", many=.true.)
      call schema%text("boundary", "face", "one face or all that have no other", words="all")
      call schema%words("boundary", "face", face_names)
      call schema%text("boundary", "region", "without face: a rigid body, whose nodes have the "// &
         "type; with face: the part of the face in it")
      meanings = ""
      walls = ""
      do n = 1, size(boundary_names)
         call choose_boundary(boundary_names(n), condition)
         meanings = meanings//"; "//trim(boundary_names(n))//": "//condition%meaning()
         if (condition%suits_region()) walls = walls//" "//trim(boundary_names(n))
      end do
      call schema%text("boundary", "type", meanings(3:))
      call schema%words("boundary", "type", boundary_names)
      call schema%real("boundary", "velocity(3)", "velocity of the wall; of a face only with "// &
         "type = velocity", unit="m/s", default="0 0 0", owner="type ="//walls)
      call schema%text("boundary", "table", "file of lines t, vx, vy, vz in the units of the "// &
         "deck, added to velocity, straight between; path relative to the deck", &
         owner="type ="//walls)
      do n = 1, size(boundary_names)
         call choose_boundary(boundary_names(n), condition)
         call condition%declare(schema)
      end do
      call schema%real("boundary", "t_on", "time at which the wall comes, and a region begins "// &
         "to move", unit="s", default="0.0", range=">= 0", owner="type ="//walls)
      call schema%real("boundary", "t_off", "time at which it goes; a face is open then", &
         unit="s", range="> 0", owner="type ="//walls)
      call schema%real("boundary", "temperature", "temperature at which a whole face is held, "// &
         "where heat is conducted; without it is insulated", unit="K", range=">= 0", &
         owner="effects.thermal")
      call schema%require("boundary", "type")
      call schema%refer("boundary", "region", "region")
      call schema%former("boundary", "face = none", becomes="", doc="a rigid region stands "// &
         "without a face", holds=.true.)
   end subroutine declare_boundary

   !> Declare &contact.
   subroutine declare_contact(schema)
      type(schema_t), intent(inout) :: schema            !! Keys of the deck

      call schema%group("contact", &
         "what holds between two bodies; pairs without one slip freely", many=.true.)
      call schema%text("contact", "bodies(:2)", "names of the two, '*' for any other; pairs of "// &
         "names win over '*'", default="*", owner="effects.contact")
      call schema%text("contact", "law", "friction: Coulomb; stick: no slip while pressed "// &
         "together; bonded: one body until the bond breaks, friction then", default="friction", &
         words="friction stick frictionless bonded", owner="effects.contact")
      call schema%real("contact", "friction", "coefficient of friction", default="0.0", &
         range=">= 0", owner="effects.contact & law = friction bonded")
      call schema%real("contact", "bond_strength", "stress that breaks the bond, by tension "// &
         "and shear together; without it the bond holds for ever", unit="Pa", range="> 0", &
         owner="effects.contact & law = bonded")
      call schema%refer("contact", "bodies", "body")
   end subroutine declare_contact
end module scene_deck_groups
