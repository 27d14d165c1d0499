! SPDX-License-Identifier: BSD-3-Clause
!> Settings of HDF5 for files that several ranks write together. A build without MPI has an HDF5
!! without these functions and compiles ../serial/io_hdf5_ranks.f90 instead.
module io_hdf5_ranks
   use base_communicator, only: communicator_t
   use hdf5, only: h5fd_mpio_collective_f, h5pset_all_coll_metadata_ops_f, &
      h5pset_coll_metadata_write_f, h5pset_dxpl_mpio_f, h5pset_fapl_mpio_f, hid_t
   implicit none
   private

   public :: open_on_all_ranks, write_on_all_ranks

contains

   !> Let all ranks open a file together.
   subroutine open_on_all_ranks(communicator, access_list)
      type(communicator_t), intent(in) :: communicator
      integer(hid_t), intent(in) :: access_list           !! File access property list
      integer :: group, hints, status

      if (communicator%size == 1) return
      call communicator%native(group, hints)
      call h5pset_fapl_mpio_f(access_list, group, hints, status)
      call h5pset_all_coll_metadata_ops_f(access_list, .true., status)
      call h5pset_coll_metadata_write_f(access_list, .true., status)
   end subroutine open_on_all_ranks

   !> Let all ranks write a data set together.
   subroutine write_on_all_ranks(communicator, transfer_list)
      type(communicator_t), intent(in) :: communicator
      integer(hid_t), intent(in) :: transfer_list         !! Data transfer property list
      integer :: status

      if (communicator%size > 1) &
         call h5pset_dxpl_mpio_f(transfer_list, h5fd_mpio_collective_f, status)
   end subroutine write_on_all_ranks
end module io_hdf5_ranks
