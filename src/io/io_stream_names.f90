! SPDX-License-Identifier: BSD-3-Clause
!> Names of the files that a run writes: what each kind of stream is called.
module io_stream_names
   implicit none
   private

   public :: stream_file, stream_kind

   integer, parameter, public :: of_particles = 1        !! Files of all particles
   integer, parameter, public :: of_slices = 2           !! Files of those near a plane
   integer, parameter, public :: of_cells = 3            !! Files of fields on the grid
   integer, parameter, public :: of_ledger = 4           !! Table of the ledger
   integer, parameter, public :: of_bins = 5             !! Table of profiles
   integer, parameter, public :: of_fragments = 6        !! Table of fragments
   integer, parameter, public :: stream_kinds = 6        !! Number of kinds
   !> What the deck calls them, and the ends of the names of their files.
   character(len=9), parameter :: kinds(stream_kinds) = [character(len=9) :: "particles", &
      "slice", "grid", "history", "profile", "fragments"]
   character(len=14), parameter :: endings(stream_kinds) = [character(len=14) :: "_p", "_s", &
      "_g", "_history.csv", "_profile.csv", "_fragments.csv"]

contains

   !> Kind of a stream from its key `kind`, 0 if there is none of that name.
   pure integer function stream_kind(word) result(kind)
      character(len=*), intent(in) :: word               !! As in the deck

      do kind = stream_kinds, 1, -1
         if (kinds(kind) == word) return
      end do
   end function stream_kind

   !> Name of a table, or what the names of snapshots begin with. The first stream of a kind does
   !! without its name.
   pure function stream_file(case, name, kind, number) result(file)
      character(len=*), intent(in) :: case               !! Prefix of all files
      character(len=*), intent(in) :: name               !! Name of the stream
      integer, intent(in) :: kind                        !! Kind of the stream
      integer, intent(in) :: number                      !! Number among those of its kind
      character(len=:), allocatable :: file

      if (number == 1) then
         file = case//trim(endings(kind))
      else
         file = case//"_"//name//trim(endings(kind))
      end if
   end function stream_file
end module io_stream_names
