! SPDX-License-Identifier: BSD-3-Clause
!> Keys of the group &boundary.
module scene_deck_groups
   use base_schema, only: schema_t
   use mesh_boundary, only: face_names
   use mesh_boundary_catalogue, only: boundary_names, choose_boundary
   use mesh_boundary_condition, only: boundary_condition_t
   implicit none
   private

   public :: declare_boundary

contains

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
   end subroutine declare_boundary
end module scene_deck_groups
