! SPDX-License-Identifier: GPL-3.0-or-later
!> The linearised model of a run: modes, transfer function, penalties.
module api_modes
   use, intrinsic :: iso_c_binding, only: c_double, c_double_complex, c_int
   use api_failure, only: check_size, error
   use api_handles, only: find_run, slots
   use dda_advice, only: penalty_type, find_penalty_for_frequency, find_penalty_for_shift
   use dda_errors, only: error_input, fail
   use dda_interrupts, only: fail_if_stopped
   use dda_linear_model, only: linear_model_type, linearise
   use dda_modes, only: modes_type, find_modes
   use dda_run, only: run_type
   use dda_transfer, only: transfer_type, prepare_transfer, transfer_at, undamped_transfer_at
   implicit none
   private
   public :: mode_shapes, make_matrices, transfer_of, penalty_for

contains

   !> Lowest modes: frequency (Hz), damping and period elongation by the scheme, participation in x
   !> and y (sqrt(kg)), effective mass in x and y as shares; shapes [6, blocks, modes],
   !> mass-normalised.
   subroutine mode_shapes(handle, which, n, wanted, found, values, shapes, words)
      integer(c_int), intent(in) :: handle, n, wanted
      character(len=*), intent(in) :: which  !< contacts: 'auto', 'closed', 'present' or 'settled'
      integer(c_int), intent(out) :: found
      real(c_double), intent(out) :: values(7, wanted), shapes(6, n, wanted)
      character(len=2048), intent(out) :: words
      type(linear_model_type) :: linear
      type(modes_type) :: modes
      integer :: i

      call linear_model_of(handle, which, linear)
      if (.not. allocated(error)) call check_size(n, linear%n)
      if (.not. allocated(error)) call find_modes(linear, wanted, modes, error)
      if (allocated(error)) return
      found = min(wanted, modes%n)
      words = modes%text
      do i = 1, found
         values(:, i) = [modes%frequency(i), modes%damping(i), modes%elongation(i), &
            modes%participation(:, i), modes%effective_mass(:, i)]
         shapes(:, :, i) = modes%shape(:, :, i)
      end do
   end subroutine mode_shapes

   !> Make the table that `read_table` hands over, with the entries of the matrices [4, entries]:
   !> matrix (0: stiffness, 1: mass, per metre of thickness; 2: displacements x and y of each
   !> measured point in turn), row and column from 0, value.
   subroutine make_matrices(handle, which, sizes)
      integer(c_int), intent(in) :: handle
      character(len=*), intent(in) :: which  !< contacts: 'auto', 'closed', 'present' or 'settled'
      integer(c_int), intent(out) :: sizes(2)
      type(linear_model_type) :: linear
      real(c_double), allocatable :: table(:,:)
      integer :: i, e, n

      sizes = 0
      call linear_model_of(handle, which, linear)
      if (allocated(error)) return
      n = 0
      associate (k => linear%stiffness)
         allocate (table(4, 72*(linear%n + size(k%column)) + 12*size(linear%points)))
         do i = 1, linear%n
            call put(0, i, i, k%diagonal(:, :, i))
            call put(1, i, i, linear%mass(:, :, i))
            do e = k%row_start(i), k%row_start(i + 1) - 1
               call put(0, i, k%column(e), k%lower(:, :, e))
               call put(0, k%column(e), i, transpose(k%lower(:, :, e)))
            end do
         end do
      end associate
      do i = 1, size(linear%points)
         call put(2, i, linear%points(i)%block, linear%point_rows(:, :, i))
      end do
      sizes = [4, n]
      slots(handle)%table = table(:, :n)

   contains

      !> A block of a matrix at a block row and column.
      subroutine put(matrix, row, column, values)
         integer, intent(in) :: matrix, row, column
         real(c_double), intent(in) :: values(:,:)
         integer :: r, c

         do c = 1, 6
            do r = 1, size(values, 1)
               n = n + 1
               table(:3, n) = [matrix, (row - 1)*size(values, 1) + r - 1, 6*(column - 1) + c - 1]
               table(4, n) = values(r, c)
            end do
         end do
      end subroutine put
   end subroutine make_matrices

   !> Transfer function between two measured points (from 1) for base motion along an axis (1 x, 2
   !> y).
   subroutine transfer_of(handle, which, points, axis, n, frequency, damped, values)
      integer(c_int), intent(in) :: handle, points(2), axis, n, damped
      character(len=*), intent(in) :: which
      real(c_double), intent(in) :: frequency(n)
      complex(c_double_complex), intent(out) :: values(n)
      type(linear_model_type) :: linear
      type(transfer_type) :: transfer
      integer :: i

      call linear_model_of(handle, which, linear)
      if (.not. allocated(error)) call prepare_transfer(transfer, linear, points, [axis, axis], &
         axis, maxval(frequency), error)
      do i = 1, n
         if (.not. allocated(error)) call fail_if_stopped(error)
         if (allocated(error)) return
         if (damped == 1) values(i) = transfer_at(transfer, frequency(i))
         if (damped /= 1) values(i) = undamped_transfer_at(transfer, frequency(i))
      end do
   end subroutine transfer_of

   !> The penalty that gives the first mode a frequency (Hz), or that lowers it by a percentage of
   !> its stiff limit: stiffness, frequency, stiff limit.
   subroutine penalty_for(handle, which, aim, target, values)
      integer(c_int), intent(in) :: handle
      character(len=*), intent(in) :: which
      character(len=*), intent(in) :: aim    !< of `target`: 'frequency' or 'shift'
      real(c_double), intent(in) :: target
      real(c_double), intent(out) :: values(3)
      type(linear_model_type) :: linear
      type(penalty_type) :: penalty

      call linear_model_of(handle, which, linear)
      if (allocated(error)) return
      if (aim == 'frequency') call find_penalty_for_frequency(linear, target, penalty, error)
      if (aim == 'shift') call find_penalty_for_shift(linear, target, penalty, error)
      if (allocated(error)) return
      values = [penalty%normal_stiffness, penalty%frequency, penalty%rigid_frequency]
      if (.not. penalty%reached) call fail(error, error_input, penalty%text)
   end subroutine penalty_for

   !> The linearised model of a run.
   subroutine linear_model_of(handle, which, linear)
      integer(c_int), intent(in) :: handle
      character(len=*), intent(in) :: which
      type(linear_model_type), intent(out) :: linear
      type(run_type), pointer :: run

      call find_run(handle, run, error)
      if (.not. allocated(error)) call linearise(linear, run%simulation, which, error)
   end subroutine linear_model_of

end module api_modes
