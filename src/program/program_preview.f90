! SPDX-License-Identifier: BSD-3-Clause
!> A scene before it runs: its first state and its walls in files, and a picture of them.
!!
!! The program writes what only it knows; scree-post draws it. doc/developer/decisions.md says why
!! (Interface).
module program_preview
   use base_agreement, only: agree
   use base_error, only: error_t
   use base_kinds, only: int64, wp
   use io_file, only: file_exists, folder_of, join_path, make_folder, program_path
   use io_snapshot, only: snapshot_format_t, snapshot_write
   use io_xdmf, only: series_t
   use output_walls, only: write_walls
   use program_batch_job, only: quoted
   use program_plan, only: plan_t
   use scene_first_state, only: begin_run
   implicit none
   private

   public :: draw_preview, write_preview

   integer(int64), parameter :: most_particles = 2000000_int64 !! More are thinned out
   character(len=*), parameter :: newline = new_line("a")
   character(len=*), parameter :: tool = "scree-post" !! What draws

contains

   !> Write the first state and the walls into a folder of their own, beside that of the results, so
   !! that a preview never touches results. Collective.
   subroutine write_preview(plan, folder, error)
      class(plan_t), intent(inout) :: plan           !! Laid out, without particles
      character(len=:), allocatable, intent(out) :: folder !! Where the files are
      type(error_t), allocatable, intent(out) :: error !! Bodies cannot begin, files not written
      character(len=64), allocatable :: fields(:)
      type(snapshot_format_t) :: format
      type(series_t) :: series
      character(len=:), allocatable :: note

      folder = plan%outputs%folder
      folder = folder(:max(verify(folder, "/", back=.true.), 1))//"_preview"
      call begin_run(plan%simulation, plan%bodies, plan%survey, plan%shapes, error)
      if (allocated(error)) return
      associate (communicator => plan%simulation%machine%communicator, case => plan%outputs%case, &
         header => plan%outputs%header)
         if (communicator%rank == 0) call make_folder(folder, error)
         call agree(communicator, error)
         if (allocated(error)) return
         fields = [character(len=64) :: "identity", "material", "mass", "volume", "velocity"]
         if (size(plan%bodies) > 1) fields = [fields, [character(len=64) :: "body"]]
         format%stride = int(1 + plan%survey%particles/most_particles)
         header%time = 0.0_wp
         call series%open(communicator, folder, case//"_p", 0, note, error)
         if (allocated(error)) return
         call snapshot_write(communicator, series%path(0), plan%simulation%stores, fields, format, &
            header, error)
         if (.not. allocated(error)) call series%add(communicator, series%path(0), error)
         if (.not. allocated(error)) call series%close(communicator, error)
         if (.not. allocated(error)) call write_walls(plan%simulation, plan%outputs, &
            folder, plan%limits%time_end, error)
      end associate
   end subroutine write_preview

   !> Draw a preview with scree-post, or say what to type where it is not found. Call this when
   !! message passing has ended: it starts another program.
   subroutine draw_preview(folder, quiet, text)
      character(len=*), intent(in) :: folder         !! Where the files are
      logical, intent(in) :: quiet                   !! The tool prints nothing
      character(len=:), allocatable, intent(out) :: text !! What to tell the user, or empty
      character(len=:), allocatable :: program, silence
      integer :: code, status

      text = ""
      silence = merge(" >/dev/null", "           ", quiet)
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
      call execute_command_line(quoted(program)//" preview "//quoted(folder)//trim(silence), &
         exitstat=code, cmdstat=status)
      if (status /= 0 .or. code /= 0) text = "written to "//folder//". No picture: see above. "// &
         "To try again, type"//newline//"  "//quoted(program)//" preview "//quoted(folder)
   end subroutine draw_preview
end module program_preview
