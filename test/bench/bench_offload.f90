! SPDX-License-Identifier: BSD-3-Clause
!> Runs the kernels of a step of the plain method on a device: particles to nodes, nodes, nodes to
!! particles, for an elastic block with linear shape functions, whose particles stay in their cells.
!!
!! bench_offload [TILES] [STEPS]   tiles along each edge, of 6 x 6 x 6 cells with 8 particles
!!
!! The steps are done twice, by threads of the host and on the device, with the kernels of the
!! program, and must end in the same bits. Without -DSCREE_OFFLOAD=ON, without a device, and with
!! OMP_TARGET_OFFLOAD=DISABLED the host takes the part of the device. doc/developer/offload.md.
program bench_offload
   use base_kinds, only: wp
   use bench_offload_block, only: block_t
   use bench_offload_step, only: put_tables, tiles
   use omp_lib, only: omp_get_num_devices
   implicit none

   type(block_t) :: here, there
   character(len=32) :: word
   integer :: across, steps, step
   real(wp) :: seconds(3, 2), updates
   character(len=16) :: before

   across = 4
   steps = 20
   call get_command_argument(1, word)
   if (len_trim(word) > 0) read (word, *) across
   call get_command_argument(2, word)
   if (len_trim(word) > 0) read (word, *) steps
   call put_tables(across)
   call here%start_wave()
   before = here%digest()
   there = here
   seconds = 0.0_wp
   do step = 1, steps
      call here%advance(.false., seconds(:, 1))
   end do
   call there%to_device()
   do step = 1, steps
      call there%advance(.true., seconds(:, 2))
   end do
   call there%from_device()
   updates = real(steps, wp)*real(here%particles, wp)*real(tiles%all, wp)*1.0e-9_wp
   print "(a,i0,a,i0,a,i0)", "particles ", here%particles*tiles%all, "  steps ", steps, &
      "  devices ", omp_get_num_devices()
   print "(a)", "ns a particle and step  particles to nodes       nodes  nodes to particles"
   print "(a,3f16.2)", "threads         ", seconds(:, 1)/updates
   print "(a,3f16.2)", "device          ", seconds(:, 2)/updates
   print "(a)", "digest "//before//"  "//here%digest()//"  "//there%digest()
   if (.not. here%inside()) error stop "a particle left its cell: take fewer steps"
   if (here%digest() == before) error stop "nothing moved"
   if (here%digest() /= there%digest()) error stop "the device gave other bits"
end program bench_offload
