! SPDX-License-Identifier: BSD-3-Clause
!> Compares the processors on which ranks may run with their numbers of threads, once at the start
!! of a run. By default `mpirun` of Open MPI binds each of one or two ranks to one core, so a run
!! with four threads a rank takes as long as one with a single thread.
module run_binding
   use base_communicator, only: communicator_t
   use base_hash, only: hash_text
   use base_kinds, only: int64, wp
   use base_process, only: allowed_processors, is_set, node_name, processors_online
   use base_text, only: number
   use run_launcher, only: launch_text
   implicit none
   private

   public :: binding_warning, find_conflict, processor_list, rank_binding_t

   integer, parameter :: heading = 3                 !! Words of a message before the mask
   integer, parameter :: word_bits = 64

   integer, parameter, public :: no_conflict = 0
   integer, parameter, public :: too_many_threads = 1 !! More threads than processors
   integer, parameter, public :: shared_processors = 2 !! Ranks are bound to the same processors

   !> Where a rank runs.
   type :: rank_binding_t
      integer(int64) :: node = 0                     !! Equal on ranks of one node
      integer :: online = 0                          !! Processors of the node
      integer :: threads = 0                         !! Most threads that the rank will use
      integer(int64), allocatable :: mask(:)         !! Bit n, through the words: processor n
   end type rank_binding_t

contains

   !> Warning if threads of the run share a processor although the node may have others; empty if
   !! not. The same on all ranks. Collective.
   function binding_warning(communicator, threads) result(text)
      type(communicator_t), intent(in) :: communicator
      integer, intent(in) :: threads                 !! Most threads that this rank will use
      character(len=:), allocatable :: text
      type(rank_binding_t), allocatable :: ranks(:)
      integer(int64), allocatable :: kinds(:)
      integer(int64) :: kind(1)
      integer :: first, such

      call gather_bindings(communicator, threads, ranks)
      kind = find_conflict(ranks, communicator%rank + 1)
      call communicator%gather(kind, kinds)
      text = ""
      if (all(kinds == no_conflict)) return
      first = findloc(kinds /= no_conflict, .true., dim=1)
      such = count(kinds /= no_conflict)
      text = "warning: "//conflict_text(ranks, first, int(kinds(first)))
      if (such > 1) text = text//" ("//number(such)//" such ranks)"
      text = text//"; "//advice(ranks, first)//" [R131]"
   end function binding_warning

   !> Get the bindings of all ranks. Collective.
   subroutine gather_bindings(communicator, threads, ranks)
      type(communicator_t), intent(in) :: communicator
      integer, intent(in) :: threads                 !! Most threads that this rank will use
      type(rank_binding_t), allocatable, intent(out) :: ranks(:)
      integer(int64), allocatable :: message(:), messages(:)
      character(len=:), allocatable :: node
      integer :: first, n, words

      associate (mask => allowed_processors())
         words = findloc(mask /= 0, .true., dim=1, back=.true.)
         words = nint(communicator%maximum(real(max(words, 1), wp)))
         node = node_name()
         message = [hash_text(trim(node)), int(processors_online(), int64), &
            int(threads, int64), mask(:words)]
         if (node == "") message(heading + 1:) = 0
      end associate
      call communicator%gather(message, messages)
      allocate (ranks(communicator%size))
      do n = 1, size(ranks)
         first = (n - 1)*(heading + words)
         ranks(n)%node = messages(first + 1)
         ranks(n)%online = int(messages(first + 2))
         ranks(n)%threads = int(messages(first + 3))
         ranks(n)%mask = messages(first + heading + 1:first + heading + words)
      end do
   end subroutine gather_bindings

   !> What is wrong with the binding of a rank. Ranks that may use all processors of the node, or
   !! all those of the run on it, are not bound, and may be more than the processors.
   pure integer function find_conflict(ranks, this) result(kind)
      type(rank_binding_t), intent(in) :: ranks(:)   !! All ranks
      integer, intent(in) :: this                    !! Index of the rank
      integer(int64), allocatable :: whole(:)
      integer :: n, processors, threads

      kind = no_conflict
      processors = count_bits(ranks(this)%mask)
      if (processors == 0) return                    ! not known
      if (ranks(this)%threads > processors) then
         kind = too_many_threads
         return
      end if
      if (processors >= ranks(this)%online) return
      whole = ranks(this)%mask
      threads = 0
      do n = 1, size(ranks)
         if (ranks(n)%node /= ranks(this)%node) cycle
         whole = ior(whole, ranks(n)%mask)
         if (all(iand(ranks(n)%mask, not(ranks(this)%mask)) == 0)) &
            threads = threads + ranks(n)%threads
      end do
      if (all(whole == ranks(this)%mask) .and. processors > 1) return
      if (threads > processors) kind = shared_processors
   end function find_conflict

   !> Number of bits that are set.
   pure integer function count_bits(mask) result(bits)
      integer(int64), intent(in) :: mask(:)

      bits = sum(popcnt(mask))
   end function count_bits

   !> The conflict of a rank in words.
   function conflict_text(ranks, this, kind) result(text)
      type(rank_binding_t), intent(in) :: ranks(:)   !! All ranks
      integer, intent(in) :: this                    !! Index of the rank
      integer, intent(in) :: kind                    !! One of the constants above
      character(len=:), allocatable :: text

      associate (rank => ranks(this))
         text = "processor "//processor_list(rank%mask)
         if (count_bits(rank%mask) > 1) text = "processors "//processor_list(rank%mask)
         if (kind == too_many_threads) then
            text = "rank "//number(this - 1)//" has "//number(rank%threads)// &
               " threads and may only run on "//text
         else
            text = "rank "//number(this - 1)//" shares "//text//" with other ranks"
         end if
      end associate
   end function conflict_text

   !> How to start the run: on cores of their own, or with fewer threads if the node has too few.
   function advice(ranks, this) result(text)
      type(rank_binding_t), intent(in) :: ranks(:)   !! All ranks
      integer, intent(in) :: this                    !! Index of a rank with a conflict
      character(len=:), allocatable :: text
      integer :: here, n, threads
      logical :: by_mpirun, by_slurm

      by_mpirun = is_set("OMPI_COMM_WORLD_SIZE")
      by_slurm = is_set("SLURM_STEP_ID")
      here = 0
      threads = 0
      do n = 1, size(ranks)
         if (ranks(n)%node /= ranks(this)%node) cycle
         here = here + 1
         threads = threads + ranks(n)%threads
      end do
      associate (rank => ranks(this))
         if (size(ranks) == 1 .and. .not. (by_mpirun .or. by_slurm)) then
            text = "use OMP_NUM_THREADS="//number(count_bits(rank%mask))// &
               ", or allow it more processors (taskset, the limits of a container or a job)"
         else if (threads > rank%online) then
            text = "the node has "//number(rank%online)//" processors for "//number(threads)// &
               " threads: use OMP_NUM_THREADS="//number(max(rank%online/here, 1))
         else if (by_slurm .and. .not. by_mpirun) then
            text = "start it with 'srun --ntasks="//number(size(ranks))//" --cpus-per-task="// &
               number(rank%threads)//" --cpu-bind=cores'"
         else
            text = "start it with '"//trim(launch_text(size(ranks), rank%threads))//"'"
         end if
      end associate
   end function advice

   !> Numbers of processors as ranges, such as 0-3,8.
   pure function processor_list(mask) result(text)
      integer(int64), intent(in) :: mask(:)          !! Bit n, through the words: processor n
      character(len=:), allocatable :: text
      integer :: first, last

      text = ""
      first = 0
      do while (first < word_bits*size(mask))
         last = first
         do while (is_allowed(mask, last))
            last = last + 1
         end do
         if (last > first) then
            if (text /= "") text = text//","
            text = text//number(first)
            if (last > first + 1) text = text//"-"//number(last - 1)
         end if
         first = last + 1
      end do
   end function processor_list

   !> True if a processor is in the mask.
   pure logical function is_allowed(mask, processor) result(allowed)
      integer(int64), intent(in) :: mask(:)
      integer, intent(in) :: processor               !! From 0

      allowed = .false.
      if (processor < word_bits*size(mask)) allowed = &
         btest(mask(processor/word_bits + 1), mod(processor, word_bits))
   end function is_allowed
end module run_binding
