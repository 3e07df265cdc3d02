! SPDX-License-Identifier: GPL-3.0-or-later
!> Number and kind of modes that a time step cannot resolve (ω > 4/Δt, paper eq. 13).
!>
!> Two bounds need no eigenvalue of the model.  The block-diagonal matrix of `find_upper_blocks`
!> bounds the eigenvalues of K (Courant–Fischer), so its number of modes beyond the limit is an
!> upper bound.  Diagonal blocks of K without a common spring are uncoupled, so their number of
!> modes beyond the limit is a lower bound by Cauchy's interlacing theorem.  In small models, modes
!> are counted exactly.
module dda_unresolved
   use dda_kinds, only: wp
   use dda_block_matrix, only: block_matrix_type
   use dda_dense_eigen, only: solve_block_eigen, is_above
   use dda_eigen, only: eigenpairs_type, find_all_eigenvalues
   use dda_errors, only: error_type
   use dda_inertia, only: count_above
   use dda_linear_model, only: linear_model_type, energy_distribution_type, energy_of, &
      energy_kinds, kind_names, stiffness_weights
   use dda_linear_terms, only: add_product, blocks_in, get_row
   use dda_mass_factor, only: mass_factor_type, factor_mass
   use dda_omega_max, only: find_upper_blocks
   use dda_text, only: short_text, to_text
   implicit none
   private
   public :: unresolved_type, count_unresolved

   !> Number and kind of modes beyond 4/Δt.
   type :: unresolved_type
      real(wp) :: limit = 0.0_wp              !< 4/Δt, rad/s
      integer :: modes = 0                    !< number of modes of the model, 6 per block
      integer :: at_least = 0                 !< lower bound of the number of modes beyond 4/Δt
      integer :: at_most = 0                  !< upper bound of this number
      logical :: exact = .false.              !< both bounds are equal
      !> number of modes, counted in `at_most`, by the kind with the most energy
      integer :: of_kind(energy_kinds) = 0
      character(len=:), allocatable :: text
   end type unresolved_type

   !> largest number of blocks for which all modes are computed
   integer, parameter :: dense_blocks = 50
   !> largest number of multiplications for a count by inertia, about ½ s
   real(wp), parameter :: affordable = 1.0e9_wp

contains

   !> Count the modes beyond 4/Δt.
   subroutine count_unresolved(linear, time_step, unresolved, error)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      real(wp), intent(in) :: time_step  !< Δt, s
      type(unresolved_type), intent(out) :: unresolved  !< modes beyond 4/Δt
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      type(mass_factor_type) :: mass
      integer :: exact

      unresolved%limit = 4.0_wp/time_step
      unresolved%modes = 6*linear%n
      if (linear%n <= dense_blocks) then
         call count_by_lapack(linear, unresolved, error)
      else
         call find_upper_bound(linear, unresolved, error)
         if (allocated(error)) return
         call find_lower_bound(linear, unresolved)
         if (unresolved%at_least < unresolved%at_most) then
            call factor_mass(mass, linear%mass, error)
            if (allocated(error)) return
            call count_above(linear%stiffness, mass, unresolved%limit**2, affordable, exact, &
               unresolved%exact)
            if (unresolved%exact) unresolved%at_least = exact
            if (unresolved%exact) unresolved%at_most = exact
         end if
      end if
      unresolved%exact = unresolved%at_least == unresolved%at_most
      call write_unresolved_text(unresolved)
   end subroutine count_unresolved

   !> Compute all modes by LAPACK, and count the modes beyond the limit.
   subroutine count_by_lapack(linear, unresolved, error)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      type(unresolved_type), intent(inout) :: unresolved  !< modes beyond 4/Δt
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      type(eigenpairs_type) :: pairs
      type(energy_distribution_type) :: energy
      integer :: i, kind

      call find_all_eigenvalues(linear%stiffness, linear%mass, pairs, error)
      if (allocated(error)) return
      do i = 1, pairs%n
         if (pairs%value(i) <= unresolved%limit**2) cycle
         unresolved%at_most = unresolved%at_most + 1
         energy = energy_of(linear, pairs%vector(:, :, i))
         kind = maxloc(energy%fraction, 1)
         unresolved%of_kind(kind) = unresolved%of_kind(kind) + 1
      end do
      unresolved%at_least = unresolved%at_most
   end subroutine count_by_lapack

   !> Find the upper bound: count the modes beyond the limit of `find_upper_blocks`.
   subroutine find_upper_bound(linear, unresolved, error)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      type(unresolved_type), intent(inout) :: unresolved  !< modes beyond 4/Δt
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      real(wp), allocatable :: upper(:,:,:), by_kind(:,:,:,:)
      real(wp) :: values(6), vectors(6, 6)
      integer :: b, i, kind

      call find_upper_blocks(linear, upper)
      call split_block_stiffness(linear, by_kind)
      do b = 1, linear%n
         if (is_above(unresolved%limit**2, upper(:, :, b), linear%mass(:, :, b))) cycle
         call solve_block_eigen(upper(:, :, b), linear%mass(:, :, b), values, vectors, error)
         if (allocated(error)) return
         do i = 1, 6
            if (values(i) <= unresolved%limit**2) cycle
            unresolved%at_most = unresolved%at_most + 1
            kind = governing_kind(vectors(:, i), by_kind(:, :, :, b))
            unresolved%of_kind(kind) = unresolved%of_kind(kind) + 1
         end do
      end do
   end subroutine find_upper_bound

   !> Split the matrices of `find_upper_blocks` by kind; the factor of a term is its block count.
   subroutine split_block_stiffness(linear, by_kind)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      real(wp), allocatable, intent(out) :: by_kind(:,:,:,:)  !< [6,6,kinds,n]
      real(wp) :: k, row(6)
      integer :: i, j, b

      allocate (by_kind(6, 6, energy_kinds, linear%n), source=0.0_wp)
      by_kind(4:6, 4:6, energy_kinds, :) = linear%elastic
      do i = 1, linear%terms%n
         associate (term => linear%terms%term(i))
            k = blocks_in(term)*term%coefficient*stiffness_weights(term%instant)
            do j = 1, blocks_in(term)
               call get_row(term, j, b, row)
               call add_product(by_kind(:, :, term%kind, b), k, row, row)
            end do
         end associate
      end do
   end subroutine split_block_stiffness

   !> Find the kind of stiffness with the most energy in the motion of a block.
   pure integer function governing_kind(x, by_kind)
      real(wp), intent(in) :: x(6), by_kind(:,:,:)
      real(wp) :: energy(energy_kinds)
      integer :: kind

      do kind = 1, energy_kinds
         energy(kind) = dot_product(x, matmul(by_kind(:, :, kind), x))
      end do
      governing_kind = maxloc(energy, 1)
   end function governing_kind

   !> Find the lower bound: count the modes beyond the limit of blocks without common springs.
   subroutine find_lower_bound(linear, unresolved)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      type(unresolved_type), intent(inout) :: unresolved  !< modes beyond 4/Δt
      logical :: is_selected(linear%n)
      real(wp) :: values(6), vectors(6, 6)
      type(error_type), allocatable :: error
      integer :: b

      is_selected = .false.
      do b = 1, linear%n
         if (shares_spring(linear%stiffness, is_selected, b)) cycle
         if (is_above(unresolved%limit**2, linear%stiffness%diagonal(:, :, b), &
            linear%mass(:, :, b))) cycle
         call solve_block_eigen(linear%stiffness%diagonal(:, :, b), linear%mass(:, :, b), values, &
            vectors, error)
         if (allocated(error)) return
         is_selected(b) = .true.
         unresolved%at_least = unresolved%at_least + count(values > unresolved%limit**2)
      end do
   end subroutine find_lower_bound

   !> .true. if a spring joins block b and an earlier selected block.
   pure logical function shares_spring(matrix, is_selected, b)
      type(block_matrix_type), intent(in) :: matrix  !< block matrix
      logical, intent(in) :: is_selected(:)
      integer, intent(in) :: b  !< number of the block

      shares_spring = any(is_selected(matrix%column(matrix%row_start(b):matrix%row_start(b + 1) - &
         1)))
   end function shares_spring

   !> Write the text on the number and kind of unresolved modes.
   subroutine write_unresolved_text(unresolved)
      type(unresolved_type), intent(inout) :: unresolved  !< modes beyond 4/Δt
      real(wp) :: fraction
      integer :: kind
      logical :: first

      associate (u => unresolved)
         if (u%at_most == 0) then
            u%text = 'all '//to_text(u%modes)//' modes lie below 4/time_step = '// &
               short_text(u%limit)//' rad/s'
            return
         end if
         u%text = to_text(u%at_least)
         if (.not. u%exact) u%text = 'between '//to_text(u%at_least)//' and '//to_text(u%at_most)
         u%text = u%text//' of '//to_text(u%modes)//' modes lie beyond 4/time_step = '// &
            short_text(u%limit)//' rad/s and are not resolved, mostly in '
         first = .true.
         do kind = 1, energy_kinds
            if (u%of_kind(kind) == 0) cycle
            if (.not. first) u%text = u%text//', '
            first = .false.
            fraction = real(u%of_kind(kind), wp)/real(sum(u%of_kind), wp)
            u%text = u%text//trim(kind_names(kind))//' ('//to_text(nint(100*fraction))//' %)'
         end do
         u%text = u%text//"; the line 'ringing' reports how fast they decay"
      end associate
   end subroutine write_unresolved_text

end module dda_unresolved
