! SPDX-License-Identifier: BSD-3-Clause
!> scree --preview: writes the first state and the walls of a scene, and has scree-post draw them.
!!
!! The reason for the two programs is in doc/developer/decisions.md, section Interface.
module program_preview
   use base_agreement, only: agree
   use base_error, only: error_t
   use base_file, only: file_exists, folder_of, join_path, make_folder, program_path
   use base_kinds, only: int64, wp
   use io_series, only: series_t
   use io_snapshot, only: snapshot_format_t, snapshot_write
   use output_walls, only: write_walls
   use run_resume_command, only: quoted
   use run_setup, only: run_setup_t
   use scene_first_state, only: make_first_state
   implicit none
   private

   public :: draw_preview, write_preview

   !> Of a larger scene every n-th is written
   integer(int64), parameter :: most_particles = 2000000_int64
   character(len=*), parameter :: newline = new_line("a")
   character(len=*), parameter :: tool = "scree-post" !! Program that draws

contains

   !> Write the first state and the walls into a separate folder beside that of the results, so that
   !! a preview does not change results. Collective.
   subroutine write_preview(setup, folder, error)
      class(run_setup_t), intent(inout) :: setup           !! Without particles
      character(len=:), allocatable, intent(out) :: folder !! Folder of the files
      type(error_t), allocatable, intent(out) :: error !! The first state cannot be built or written
      character(len=64), allocatable :: fields(:)
      type(snapshot_format_t) :: format
      type(series_t) :: series
      character(len=:), allocatable :: note

      folder = setup%outputs%folder
      folder = folder(:max(verify(folder, "/", back=.true.), 1))//"_preview"
      call make_first_state(setup%simulation, setup%bodies, setup%survey, setup%shapes, error)
      if (allocated(error)) return
      associate (communicator => setup%simulation%machine%communicator, case => &
         setup%outputs%case, &
         header => setup%outputs%header)
         if (communicator%rank == 0) call make_folder(folder, error)
         call agree(communicator, error)
         if (allocated(error)) return
         fields = [character(len=64) :: "identity", "material", "mass", "volume", "velocity"]
         if (size(setup%bodies) > 1) fields = [fields, [character(len=64) :: "body"]]
         format%stride = int(1 + setup%survey%particles/most_particles)
         header%time = 0.0_wp
         call series%open(communicator, folder, case//"_p", 0, note, error)
         if (allocated(error)) return
         call snapshot_write(communicator, series%path(0), setup%simulation%stores, fields, &
            format, &
            header, error)
         if (.not. allocated(error)) call series%add(communicator, series%path(0), error)
         if (.not. allocated(error)) call series%close(communicator, error)
         if (.not. allocated(error)) call write_walls(setup%simulation, setup%outputs, &
            folder, setup%limits%time_end, error)
      end associate
   end subroutine write_preview

   !> Draw a preview with scree-post, or print the command if it is not found. Call this after the
   !! end of message passing, since it starts another program.
   subroutine draw_preview(folder, quiet, text)
      character(len=*), intent(in) :: folder         !! Folder of the files
      logical, intent(in) :: quiet                   !! Suppress the output of scree-post
      character(len=:), allocatable, intent(out) :: text !! Message for the user, or empty
      character(len=:), allocatable :: program, redirection
      integer :: code, status

      text = ""
      redirection = merge(" >/dev/null", "           ", quiet)
      program = join_path(folder_of(program_path()), "../venv/bin/"//tool)
      if (.not. file_exists(program)) program = tool
      call execute_command_line("command -v "//quoted(program)//" >/dev/null 2>&1", &
         exitstat=code, cmdstat=status)
      if (status /= 0 .or. code /= 0) then
         text = "written to "//folder//". No picture: scree-post was not found. "// &
            "scripts/setup.sh installs it; then type"//newline// &
            "  build/venv/bin/"//tool//" preview "//quoted(folder)
         return
      end if
      call execute_command_line(quoted(program)//" preview "//quoted(folder)//trim(redirection), &
         exitstat=code, cmdstat=status)
      if (status /= 0 .or. code /= 0) text = &
         "written to "//folder//". No picture: see the messages "// &
         "above. To try again, type"//newline//"  "//quoted(program)//" preview "//quoted(folder)
   end subroutine draw_preview
end module program_preview
