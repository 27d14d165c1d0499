! SPDX-License-Identifier: BSD-3-Clause
!> Description of the run for output files and checkpoints.
module output_description
   use base_version, only: compiler_flags, compiler_name, compiler_version_text, git_commit, &
      version_text
   use deck_reader, only: deck_t, group_t
   use deck_units, only: system_number, system_si
   use io_checkpoint, only: checkpoint_place_t
   use mesh_boundary_walls, only: face_names
   use output_streams, only: outputs_t
   use particle_body, only: body_t
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: describe_simulation

contains

   !> Set folder, case and the description of the run that files hold.
   subroutine describe_simulation(deck, simulation, bodies, deck_text, folder, outputs, place)
      type(deck_t), intent(in) :: deck
      type(simulation_t), intent(in) :: simulation
      type(body_t), intent(in) :: bodies(:)          !! Bodies of the scene
      character(len=*), intent(in) :: deck_text      !! Text as written
      character(len=:), allocatable, intent(in) :: folder !! From the command line, if given
      type(outputs_t), intent(inout) :: outputs      !! Gets folder, case and header
      type(checkpoint_place_t), intent(inout) :: place !! Gets folder, case and how many to keep
      type(group_t) :: group
      character(len=:), allocatable :: word
      integer :: n

      group = deck%group("run")
      call group%get("case", outputs%case)
      outputs%folder = "out/"//outputs%case
      if (allocated(folder)) outputs%folder = folder
      associate (header => outputs%header)
         header%code = "scree"
         header%version = version_text
         header%git = git_commit
         header%compiler = compiler_name//" "//compiler_version_text
         header%flags = compiler_flags()
         header%case = outputs%case
         call group%get("title", header%title)
         call group%get("dimension", header%dimension)
         header%symmetry = ""
         do n = 1, 6
            if (simulation%space%boundary%mirrors(n) .and. &
               simulation%space%grid%active(ishft(n + 1, -1))) &
               header%symmetry = trim(header%symmetry//" "//face_names(n))
         end do
         header%symmetry = trim(adjustl(header%symmetry))
         header%deck = deck_text
         header%echo = deck%echo()
         header%axisymmetric = simulation%space%grid%axisymmetric
         group = deck%group("units")
         call group%get("output_units", word)
         header%units%system = max(system_number(word), system_si)
         allocate (header%body_names(size(bodies)), header%material_names(deck%count("material")))
         header%body_materials = bodies%store
         do n = 1, size(bodies)
            header%body_names(n) = bodies(n)%name
         end do
         ! with contact a material has a store for each of its velocity fields
         if (allocated(simulation%effects%contact)) header%body_materials = &
            simulation%effects%contact%material(header%body_materials)
         do n = 1, size(header%material_names)
            group = deck%group("material", n)
            call group%get("name", word)
            header%material_names(n) = word
         end do
      end associate
      place%folder = outputs%folder
      place%case = outputs%case
      place%version = version_text
      place%deck = deck_text
      place%echo = outputs%header%echo
      group = deck%group("checkpoint")
      call group%get("keep", place%keep)
   end subroutine describe_simulation
end module output_description
