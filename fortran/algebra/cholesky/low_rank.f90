! SPDX-License-Identifier: GPL-3.0-or-later
!> Low-rank update of a Cholesky factor for a few rank-one terms that were added or removed.
!>
!> With A = L Lᵀ and the changes U S Uᵀ (Sherman, Morrison, Woodbury; W. W. Hager, SIAM Review 31
!> (1989) 221)
!>
!>     (A + U S Uᵀ)⁻¹ = L⁻ᵀ (I − W C⁻¹ Wᵀ) L⁻¹,   W = L⁻¹ U,   C = S⁻¹ + Wᵀ W
!>
!> so the correction is applied between the forward and the backward solve.  Since A and A + U S Uᵀ
!> are positive definite, C has a positive pivot for each added term and a negative pivot for each
!> removed term (inertia of the two Schur complements).  If rounding violates this, the update is
!> rejected.
!>
!> A term that changes repeatedly, such as of a contact that opens and closes, retains its column of
!> W; terms that cancel are not part of C.
module dda_low_rank
   use dda_kinds, only: wp, sp
   use dda_cholesky_single, only: factor_type
   use dda_errors, only: error_type
   use dda_front_plan, only: front_plan_type
   use dda_low_rank_columns, only: low_rank_columns_type, plan_columns, make_columns, &
      multiply_columns, project_vector, subtract_columns, vector_width, column_panels
   use dda_rank_one, only: rank_one_type, most_changes, ignored_change, add_change, forget_changes
   implicit none
   private
   public :: low_rank_type, plan_low_rank, free_low_rank, update_low_rank, rebuild_low_rank, correct

   !> The changes since the factorisation, with W and C.
   type :: low_rank_type
      ! unsaved, follows from the springs and the factor: columns, gram, n, order, pivot, t
      type(rank_one_type) :: terms
      type(low_rank_columns_type) :: columns               !< W
      integer :: n = 0                            !< number of terms that do not cancel
      integer :: order(most_changes) = 0          !< [n] added terms, then removed terms
      !> [most_changes, most_changes] WᵀW, lower triangle of panels
      real(wp), allocatable :: gram(:,:)
      !> [most_changes, most_changes] C = T D Tᵀ in the order above
      real(wp), allocatable :: t(:,:)
      real(wp) :: pivot(most_changes) = 0.0_wp    !< D
   end type low_rank_type

contains

   !> Discard the changes and the memory, for a new pattern.
   subroutine free_low_rank(low)
      type(low_rank_type), intent(inout) :: low  !< update without columns on return

      call forget_changes(low%terms)
      if (allocated(low%columns%w)) deallocate (low%columns%w)
   end subroutine free_low_rank

   !> Allocate the update for a pattern, if not yet allocated.
   subroutine plan_low_rank(low, plan, error)
      type(low_rank_type), intent(inout) :: low  !< update; receives memory
      type(front_plan_type), intent(in) :: plan  !< symbolic factor
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      if (.not. allocated(low%columns%w)) call plan_columns(low%columns, plan, error)
      if (allocated(low%t)) return
      allocate (low%gram(most_changes, most_changes), low%t(most_changes, most_changes), &
         source=0.0_wp)
   end subroutine plan_low_rank

   !> Add changes to the update, unless they are too many or the update would be inaccurate.
   subroutine update_low_rank(low, factor, changes, success)
      type(low_rank_type), intent(inout) :: low  !< update of the factor
      type(factor_type), intent(in) :: factor  !< L of the matrix before all changes
      type(rank_one_type), intent(in) :: changes  !< changes of the matrix that `low` represents
      logical, intent(out) :: success  !< .false.: the matrix must be factorised
      integer :: n_old, first, i, term

      success = changes%n <= most_changes
      if (.not. success) return
      n_old = low%terms%n
      do i = 1, changes%n
         term = find_term(low%terms, changes%block(:, i), changes%u(:, :, i))
         if (term == 0) then
            call add_change(low%terms, changes%block(1, i), changes%u(:, 1, i), &
               changes%block(2, i), -changes%u(:, 2, i), changes%k(i))
         else
            low%terms%k(term) = added_stiffness(low%terms%k(term), changes%k(i))
         end if
      end do
      success = low%terms%n <= most_changes
      first = merge(n_old/vector_width, column_panels, low%terms%n > n_old) + 1
      if (success) call rebuild_low_rank(low, factor, first, success)
   end subroutine update_low_rank

   !> Find the existing term with the same u, apart from changes of geometry; 0 if there is none.
   pure integer function find_term(terms, block, u)
      type(rank_one_type), intent(in) :: terms  !< terms in W
      integer, intent(in) :: block(2)  !< numbers of the two block rows
      real(wp), intent(in) :: u(6, 2)  !< u to search for
      integer :: i

      do i = 1, min(terms%n, most_changes)
         if (any(terms%block(:, i) /= block)) cycle
         find_term = i
         if (sum((terms%u(:, :, i) - u)**2) <= ignored_change**2*sum(u**2)) return
      end do
      find_term = 0
   end function find_term

   !> Sum of two stiffnesses; zero if they nearly cancel.
   pure real(wp) function added_stiffness(a, b) result(total)
      real(wp), intent(in) :: a, b  !< N/m

      total = a + b
      if (abs(total) <= ignored_change*max(abs(a), abs(b))) total = 0.0_wp
   end function added_stiffness

   !> Compute W, WᵀW and C, starting with the first panel that has new terms.
   subroutine rebuild_low_rank(low, factor, first, success)
      type(low_rank_type), intent(inout) :: low  !< update of the factor
      type(factor_type), intent(in) :: factor  !< L of the matrix before all changes
      integer, intent(in) :: first  !< first panel of columns to compute
      logical, intent(out) :: success  !< .false.: the matrix must be factorised
      integer :: last

      last = (low%terms%n + vector_width - 1)/vector_width
      call make_columns(low%columns, factor, low%terms, first, last)
      call multiply_columns(low%columns, factor%plan, first, last, low%gram)
      call order_terms(low)
      call factorise_capacity(low, success)
   end subroutine rebuild_low_rank

   !> Order the terms with added terms first, because their block of C is positive definite.
   pure subroutine order_terms(low)
      type(low_rank_type), intent(inout) :: low  !< update of the factor
      integer :: i, n, pass

      n = 0
      do pass = 1, 2
         do i = 1, low%terms%n
            if (.not. merge(1.0_wp, -1.0_wp, pass == 1)*low%terms%k(i) > 0.0_wp) cycle
            n = n + 1
            low%order(n) = i
         end do
      end do
      low%n = n
   end subroutine order_terms

   !> Factorise C = T D Tᵀ; fail if the sign of a pivot differs from that of its term.
   pure subroutine factorise_capacity(low, success)
      type(low_rank_type), intent(inout) :: low  !< update of the factor
      logical, intent(out) :: success  !< .false.: the matrix must be factorised
      integer :: i, j, n

      n = low%n
      success = .true.
      do j = 1, n
         do i = j, n
            low%t(i, j) = low%gram(max(low%order(i), low%order(j)), min(low%order(i), low%order(j)))
         end do
         low%t(j, j) = low%t(j, j) + 1.0_wp/low%terms%k(low%order(j))
      end do
      do j = 1, n
         low%pivot(j) = low%t(j, j)
         success = low%pivot(j)*low%terms%k(low%order(j)) > 0.0_wp
         if (.not. success) return
         low%t(j + 1:n, j) = low%t(j + 1:n, j)/low%pivot(j)
         do i = j + 1, n
            low%t(i:n, i) = low%t(i:n, i) - low%t(i:n, j)*(low%t(i, j)*low%pivot(j))
         end do
      end do
   end subroutine factorise_capacity

   !> Compute y = (I − W C⁻¹ Wᵀ) y, between the forward and the backward solve.
   subroutine correct(low, plan, y)
      type(low_rank_type), intent(in) :: low  !< update of the factor
      type(front_plan_type), intent(in) :: plan  !< symbolic factor
      real(sp), intent(inout) :: y(6, plan%n)  !< vector in permuted order
      real(wp) :: projection(vector_width, column_panels)
      integer :: panels

      panels = (low%terms%n + vector_width - 1)/vector_width
      call project_vector(low%columns, plan, panels, y, projection)
      call solve_capacity(low, projection)
      call subtract_columns(low%columns, plan, panels, projection, y)
   end subroutine correct

   !> Solve C x = b in place; x is zero for columns without a term and for cancelled terms.
   pure subroutine solve_capacity(low, x)
      type(low_rank_type), intent(in) :: low  !< update of the factor
      real(wp), intent(inout) :: x(most_changes)  !< value for each term
      real(wp) :: z(most_changes)
      integer :: i, n

      n = low%n
      do i = 1, n
         z(i) = x(low%order(i))
      end do
      do i = 1, n
         z(i + 1:n) = z(i + 1:n) - low%t(i + 1:n, i)*z(i)
      end do
      z(:n) = z(:n)/low%pivot(:n)
      do i = n, 1, -1
         z(i) = z(i) - dot_product(low%t(i + 1:n, i), z(i + 1:n))
      end do
      x = 0.0_wp
      do i = 1, n
         x(low%order(i)) = z(i)
      end do
   end subroutine solve_capacity

end module dda_low_rank
