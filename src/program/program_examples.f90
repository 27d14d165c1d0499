! SPDX-License-Identifier: BSD-3-Clause
!> The examples of the program: their list, and copies in new folders.
module program_examples
   use base_error, only: error_t, exit_file, exit_input, fail
   use base_file, only: file_exists, folder_of, join_path, list_folder, longest_name, make_folder, &
      program_path, read_file, write_file
   use base_text, only: append, closest, join, line_end, text_t
   use base_version, only: share_folder
   use run_resume_command, only: quoted
   implicit none
   private

   public :: copied_t, copy_example, examples_text, next_steps

   character(len=*), parameter :: scene = "scene.nml" !! Deck of each example
   character(len=*), parameter :: plot = "plot.py"   !! Script for all examples
   character(len=*), parameter :: view = "view.py"   !! ParaView script for all examples
   character(len=*), parameter :: newline = new_line("a")

   !> An example that was copied.
   type :: copied_t
      character(len=:), allocatable :: folder        !! Folder of the copy
      character(len=:), allocatable :: deck          !! Name of its deck
      type(text_t), allocatable :: files(:)          !! Names of its files
      logical :: has_grains = .false.                !! Is the deck for scree --grains?
   end type copied_t

contains

   !> Find the folder of the examples from that of the program.
   subroutine find_examples(folder, error)
      character(len=:), allocatable, intent(out) :: folder !! Folder of the examples
      type(error_t), allocatable, intent(out) :: error !! Not found
      character(len=:), allocatable :: home

      home = folder_of(program_path())
      folder = join_path(home, share_folder//"/input")
      if (file_exists(folder//"/.")) return
      ! the build tree has them here, whatever the names of the installation folders
      folder = join_path(home, "../share/scree/input")
      if (file_exists(folder//"/.")) return
      call fail(error, exit_file, "the examples are not in the folder of this installation, '"// &
         join_path(home, share_folder//"/input")//"'; install again, with cmake --install [C203]")
   end subroutine find_examples

   !> List the examples: folders with a scene.
   subroutine list_examples(folder, names, error)
      character(len=*), intent(in) :: folder         !! Folder of the examples
      type(text_t), allocatable, intent(out) :: names(:) !! Names in alphabetical order
      type(error_t), allocatable, intent(out) :: error !! The folder cannot be read
      character(len=longest_name), allocatable :: entries(:)
      integer :: n

      allocate (names(0))
      call list_folder(folder, "", "", entries, error)
      if (allocated(error)) return
      do n = 1, size(entries)
         if (entries(n)(1:1) == ".") cycle
         if (file_exists(join_path(folder, trim(entries(n))//"/"//scene))) &
            call append(names, trim(entries(n)))
      end do
   end subroutine list_examples

   !> One line for each example: its name and the title of its README.
   subroutine examples_text(text, error)
      character(len=:), allocatable, intent(out) :: text !! One line per example
      type(error_t), allocatable, intent(out) :: error !! Not found or unreadable
      character(len=:), allocatable :: folder, readme
      type(text_t), allocatable :: names(:)
      integer :: n
      integer, parameter :: column = 20              ! where the descriptions begin

      text = ""
      call find_examples(folder, error)
      if (allocated(error)) return
      call list_examples(folder, names, error)
      if (allocated(error)) return
      do n = 1, size(names)
         call read_file(join_path(folder, names(n)%text//"/README.md"), readme, error)
         if (allocated(error)) return
         text = text//names(n)%text//repeat(" ", max(column - len(names(n)%text), 1))// &
            readme(verify(readme, "# "):index(readme//newline, newline) - 1)//newline
      end do
   end subroutine examples_text

   !> Copy an example into a new or empty folder, without the scripts that evaluate it, which need
   !! the tools of the sources.
   subroutine copy_example(name, target_folder, copied, error)
      character(len=*), intent(in) :: name           !! Name of the example
      character(len=*), intent(in) :: target_folder  !! Folder to create
      type(copied_t), intent(out) :: copied          !! Copied files
      type(error_t), allocatable, intent(out) :: error !! No such example, or not writable
      character(len=:), allocatable :: near, folder, text
      character(len=longest_name), allocatable :: entries(:)
      type(text_t), allocatable :: names(:)
      integer :: n

      call find_examples(folder, error)
      if (.not. allocated(error)) call list_examples(folder, names, error)
      if (allocated(error)) return
      if (.not. any([(names(n)%text == name, n=1, size(names))])) then
         near = closest(name, names)
         if (near /= "") near = "; did you mean "//near//"?"
         call fail(error, exit_input, "command line: error: there is no example '"//name// &
            "', but "//join(names, " ")//near//" [C201]")
         return
      end if
      call prepare_folder(target_folder, error)
      if (allocated(error)) return
      copied%folder = target_folder
      copied%deck = name//".nml"
      call list_folder(join_path(folder, name), "", "", entries, error)
      if (allocated(error)) return
      do n = 1, size(entries)
         if (entries(n)(1:1) == "." .or. index(entries(n), ".py ") > 0) cycle
         ! such as __pycache__
         if (file_exists(join_path(folder, name//"/"//trim(entries(n))//"/."))) cycle
         call copy_file(join_path(folder, name), trim(entries(n)), name, copied, error)
         if (allocated(error)) return
      end do
      call read_file(join_path(folder, name//"/"//scene), text, error)
      if (allocated(error)) return
      copied%has_grains = index(newline//text, newline//"&grains") > 0
      ! the scripts draw particles
      if (copied%has_grains) return
      call copy_file(folder, plot, name, copied, error)
      if (.not. allocated(error)) call copy_file(folder, view, name, copied, error)
   end subroutine copy_example

   !> Make a folder, or accept an empty one.
   subroutine prepare_folder(folder, error)
      character(len=*), intent(in) :: folder         !! New or empty
      type(error_t), allocatable, intent(out) :: error !! Not empty, or not writable
      character(len=longest_name), allocatable :: entries(:)

      if (file_exists(folder)) then
         if (file_exists(folder//"/.")) then
            call list_folder(folder, "", "", entries, error)
            if (allocated(error)) return
            if (all(entries == "." .or. entries == "..")) return
         end if
         call fail(error, exit_file, "'"//folder// &
            "' exists and is not overwritten; choose another name [C202]")
         return
      end if
      call make_folder(folder, error)
   end subroutine prepare_folder

   !> Copy one file; paths in the README become those of the copy.
   subroutine copy_file(folder, name, example, copied, error)
      character(len=*), intent(in) :: folder         !! Folder of the file
      character(len=*), intent(in) :: name           !! Name
      character(len=*), intent(in) :: example        !! Name of the example
      type(copied_t), intent(inout) :: copied        !! Receives the file name
      type(error_t), allocatable, intent(out) :: error !! Not readable or not writable
      character(len=:), allocatable :: text, new_name

      call read_file(join_path(folder, name), text, error)
      if (allocated(error)) return
      new_name = name
      if (name == scene) new_name = copied%deck
      if (name == "README.md") text = copied_readme(text, example)
      call write_file(join_path(copied%folder, new_name), text, error)
      if (.not. allocated(error)) call append(copied%files, new_name)
   end subroutine copy_file

   !> README of a copy: links and paths that exist only in the sources are replaced.
   function copied_readme(readme, example) result(text)
      character(len=*), intent(in) :: readme         !! Text in the sources
      character(len=*), intent(in) :: example        !! Name of the example
      character(len=:), allocatable :: text
      character(len=*), parameter :: outside = "](../"
      character(len=*), parameter :: measuring = newline//"build/venv/bin/python "
      integer :: bracket, first, last, path

      text = readme
      do
         first = index(text, measuring)
         if (first == 0) exit
         text = text(:first - 1)//text(line_end(text, first + 1) + 1:)
      end do
      do
         first = index(text, outside)
         if (first == 0) exit
         last = first + index(text(first:), ")") - 1
         path = first + 2 + verify(text(first + 2:), "./") - 1
         bracket = index(text(:first), "[", back=.true.)
         if (text(bracket - 1:bracket - 1) == "!") then
            ! pictures are not copied
            text = text(:bracket - 2)//text(last + 1:)
         else
            text = text(:bracket - 1)//text(bracket + 1:first - 1)//" (in the sources, "// &
               text(path:last)//text(last + 1:)
         end if
      end do
      text = replaced(text, "input/"//example//"/", "")
      text = replaced(text, "build/bin/scree", "scree")
      text = replaced(text, scene, example//".nml")
      text = replaced(text, "scripts/run.sh "//example, "scree "//example)
      text = text//newline//"This is a copy of the example `"//example// &
         "` of Scree. `scripts/`, `doc/` and `test/` are folders of the sources."//newline
   end function copied_readme

   !> A text with all occurrences of one word replaced by another that does not contain it.
   pure function replaced(text, old, new) result(changed)
      character(len=*), intent(in) :: text           !! Text
      character(len=*), intent(in) :: old            !! Word to replace
      character(len=*), intent(in) :: new            !! Word that replaces it
      character(len=:), allocatable :: changed
      integer :: first, from

      changed = ""
      from = 1
      do
         first = index(text(from:), old)
         if (first == 0) exit
         changed = changed//text(from:from + first - 2)//new
         from = from + first - 1 + len(old)
      end do
      changed = changed//text(from:)
   end function replaced

   !> Commands for the next steps of the user.
   function next_steps(copied) result(text)
      type(copied_t), intent(in) :: copied           !! Copied files
      character(len=:), allocatable :: text
      character(len=:), allocatable :: program

      program = "scree"
      if (started_by_path()) program = quoted(program_path())
      text = "made "//copied%folder//": "//join(copied%files, " ")//newline// &
         "next:"//newline// &
         "  cd "//quoted(copied%folder)//newline
      if (copied%has_grains) then
         program = "  "//program//" --grains "
         text = text//program//"--check "//copied%deck//newline//program//copied%deck//newline// &
            "  scree-post grains out/"//copied%deck(:len(copied%deck) - 4)//newline
         return
      end if
      text = text// &
         "  "//program//" --check "//copied%deck//newline// &
         "  "//program//" "//copied%deck//newline// &
         "  python3 "//plot//"      # needs numpy, h5py and matplotlib"//newline// &
         "  paraview --script="//view//newline// &
         "  sbatch job.slurm       # on a cluster"//newline
   end function next_steps

   !> True if the program was started by a path: then its name alone may not be found.
   logical function started_by_path() result(by_path)
      character(len=:), allocatable :: word
      integer :: length

      call get_command_argument(0, length=length)
      allocate (character(len=length) :: word)
      call get_command_argument(0, word)
      by_path = index(word, "/") > 0
   end function started_by_path
end module program_examples
