! SPDX-License-Identifier: BSD-3-Clause
!> Settings of HDF5 for files that several ranks write together: none, in a build without MPI, which
!! has one rank. The same interface as ../parallel/io_hdf5_ranks.f90.
module io_hdf5_ranks
   use base_communicator, only: communicator_t
   use hdf5, only: hid_t
   implicit none
   private

   public :: open_on_all_ranks, write_on_all_ranks

contains

   !> A file of one rank needs no settings.
   subroutine open_on_all_ranks(communicator, access_list)
      type(communicator_t), intent(in) :: communicator
      integer(hid_t), intent(in) :: access_list           !! File access property list
   end subroutine open_on_all_ranks

   !> A data set of one rank needs no settings.
   subroutine write_on_all_ranks(communicator, transfer_list)
      type(communicator_t), intent(in) :: communicator
      integer(hid_t), intent(in) :: transfer_list         !! Data transfer property list
   end subroutine write_on_all_ranks
end module io_hdf5_ranks
