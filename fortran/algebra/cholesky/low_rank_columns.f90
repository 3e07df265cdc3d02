! SPDX-License-Identifier: GPL-3.0-or-later
!> Columns of W = L⁻¹ U for a low-rank update of a Cholesky factor; each u has two nonzero blocks.
!>
!> A column is nonzero only along its elimination path, the fronts from its blocks to the root (a
!> few hundredths of the factor).  Each panel, one vector width of columns, is processed by one
!> thread, so that results depend neither on threads nor on the other columns of a panel.
module dda_low_rank_columns
   use dda_kinds, only: wp, sp
   use dda_errors, only: error_type
   use dda_free_memory, only: require_for_factor, fail_allocation
   use dda_lapack, only: sgemm
   use dda_cholesky_single, only: factor_type
   use dda_front_plan, only: front_plan_type, longest_front_vector
   use dda_rank_one, only: rank_one_type, most_changes
   use dda_registers, only: wide_registers
   use dda_packed_panels, only: packed_rows, panels_of
   use dda_team, only: largest_team
   implicit none
   private
   public :: low_rank_columns_type, plan_columns, make_columns, multiply_columns, project_vector, &
      subtract_columns, vector_width, column_panels

   integer, parameter :: vector_width = 16                          !< columns in a panel
   integer, parameter :: column_panels = most_changes/vector_width  !< number of panels
   !> largest number of pivot columns per product for which BLAS uses only one thread
   integer, parameter :: pivots_together = 64

   !> The columns and their nonzero fronts.
   type :: low_rank_columns_type
      integer, allocatable :: permuted(:)       !< [n] permuted index of each block row
      integer, allocatable :: front_of(:)       !< [n] front that eliminates each block row
      !> [fronts, panels] W is not 0 in a front's pivot rows
      logical, allocatable :: is_nonzero(:,:)
      integer, allocatable :: path(:,:)         !< [fronts, panels] touched fronts in postorder
      integer :: path_length(column_panels) = 0 !< number of touched fronts
      real(sp), allocatable :: w(:,:,:,:)       !< [width, 6, n, panels] W, in touched fronts
      !> [width, longest, panels] rows of W in a front
      real(sp), allocatable :: front_vector(:,:,:)
   end type low_rank_columns_type

contains

   !> Allocate the columns for a pattern; unwritten memory pages of W are not used.
   subroutine plan_columns(columns, plan, error)
      type(low_rank_columns_type), intent(out) :: columns  !< W
      type(front_plan_type), intent(in) :: plan  !< symbolic factor
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      character(len=*), parameter :: purpose = 'the update of the factor'
      real(wp), parameter :: of_block = storage_size(1.0_sp)/8*vector_width*6*column_panels ! bytes
      integer :: front, i, status

      call require_for_factor(of_block*plan%n, plan%n, merge(largest_team(), 1, &
         plan%sharing%is_shared), purpose, error)
      if (allocated(error)) return
      allocate (columns%permuted(plan%n), columns%front_of(plan%n))
      allocate (columns%is_nonzero(plan%fronts, column_panels))
      allocate (columns%path(plan%fronts, column_panels))
      allocate (columns%front_vector(vector_width, longest_front_vector(plan), column_panels))
      allocate (columns%w(vector_width, 6, plan%n, column_panels), stat=status)
      if (status /= 0) then
         call fail_allocation(of_block*plan%n, purpose, error)
         return
      end if
      do front = 1, plan%fronts
         do i = plan%first(front), plan%first(front + 1) - 1
            columns%permuted(plan%order(i)) = i
            columns%front_of(plan%order(i)) = front
         end do
      end do
   end subroutine plan_columns

   !> Compute the columns of several panels.
   subroutine make_columns(columns, factor, terms, first, last)
      type(low_rank_columns_type), intent(inout) :: columns  !< W
      type(factor_type), intent(in) :: factor  !< L
      type(rank_one_type), intent(in) :: terms  !< U
      integer, intent(in) :: first, last  !< first and last panel
      integer :: panel

      !$omp parallel do schedule(dynamic, 1) if (factor%plan%sharing%is_shared)
      do panel = first, last
         call find_elimination_path(columns, factor%plan, terms, panel)
         call scatter_terms(columns, factor%plan, terms, panel)
         call forward_path(columns, factor, panel)
      end do
   end subroutine make_columns

   !> List the fronts on the elimination paths of the terms of a panel.
   pure subroutine find_elimination_path(columns, plan, terms, panel)
      type(low_rank_columns_type), intent(inout) :: columns  !< W
      type(front_plan_type), intent(in) :: plan  !< symbolic factor
      type(rank_one_type), intent(in) :: terms  !< U
      integer, intent(in) :: panel  !< number of the panel
      integer :: i, side, front

      columns%is_nonzero(:, panel) = .false.
      do i = vector_width*(panel - 1) + 1, min(vector_width*panel, terms%n)
         do side = 1, 2
            front = columns%front_of(terms%block(side, i))
            do while (front > 0)
               if (columns%is_nonzero(front, panel)) exit
               columns%is_nonzero(front, panel) = .true.
               front = plan%parent(front)
            end do
         end do
      end do
      columns%path_length(panel) = 0
      do front = 1, plan%fronts
         if (.not. columns%is_nonzero(front, panel)) cycle
         columns%path_length(panel) = columns%path_length(panel) + 1
         columns%path(columns%path_length(panel), panel) = front
      end do
   end subroutine find_elimination_path

   !> Copy the columns u into the pivot rows on their elimination paths.
   pure subroutine scatter_terms(columns, plan, terms, panel)
      type(low_rank_columns_type), intent(inout) :: columns  !< W
      type(front_plan_type), intent(in) :: plan  !< symbolic factor
      type(rank_one_type), intent(in) :: terms  !< U
      integer, intent(in) :: panel  !< number of the panel
      integer :: i, side, c, pivot

      do i = 1, columns%path_length(panel)
         associate (front => columns%path(i, panel))
            columns%w(:, :, plan%first(front):plan%first(front + 1) - 1, panel) = 0.0_sp
         end associate
      end do
      do c = 1, min(vector_width, terms%n - vector_width*(panel - 1))
         i = vector_width*(panel - 1) + c
         do side = 1, 2
            pivot = columns%permuted(terms%block(side, i))
            columns%w(c, :, pivot, panel) = columns%w(c, :, pivot, panel) &
               + real(terms%u(:, side, i), sp)
         end do
      end do
   end subroutine scatter_terms

   !> Solve L w = u through the fronts of the elimination paths.
   pure subroutine forward_path(columns, factor, panel)
      type(low_rank_columns_type), intent(inout) :: columns  !< u; on return, w
      type(factor_type), intent(in) :: factor  !< L
      integer, intent(in) :: panel  !< number of the panel
      integer :: i

      associate (plan => factor%plan)
         do i = 1, columns%path_length(panel)
            associate (front => columns%path(i, panel))
               call forward_front(plan%first(front + 1) - plan%first(front), &
                  plan%row_start(front + 1) - plan%row_start(front), &
                  factor%packed(plan%factor_start(front)), &
                  plan%row(plan%row_start(front):plan%row_start(front + 1) - 1), &
                  plan%first(front), columns%front_vector(1, 1, panel), columns%w(1, 1, 1, panel))
            end associate
         end do
      end associate
   end subroutine forward_path

   !> Solve for the pivots of a front and subtract their products from the rows below.
   pure subroutine forward_front(pivots, below, packed, row, first, front_vector, w)
      !> size, rows and first pivot of the front
      integer, intent(in) :: pivots, below, row(below), first
      real(sp), intent(in) :: packed(packed_rows, 6, *)  !< L of the front
      !> rows of W in the front
      real(sp), intent(inout) :: front_vector(vector_width, 6*(pivots + below) + 2*packed_rows)
      real(sp), intent(inout) :: w(vector_width, 6, *)  !< one panel of W
      integer :: j, s, r, at, offset

      offset = 6*pivots + packed_rows
      call gather_front(pivots, below, row, first, w, front_vector)
      at = 1
      do j = 1, pivots
         do s = 1, panels_of(pivots - j)
            call subtract_panel(packed(1, 1, at + s), front_vector(1, 6*j - 5), &
               front_vector(1, 6*j + 1 + packed_rows*(s - 1)))
         end do
         at = at + 1 + panels_of(pivots - j)
      end do
      do j = 1, pivots
         do s = 1, panels_of(below)
            call subtract_panel(packed(1, 1, at + s - 1), front_vector(1, 6*j - 5), &
               front_vector(1, offset + 1 + packed_rows*(s - 1)))
         end do
         at = at + panels_of(below)
      end do
      at = 1
      do r = 1, pivots
         call multiply_triangle(packed(1, 1, at), front_vector(1, 6*r - 5), w(1, 1, first + r - 1))
         at = at + 1 + panels_of(pivots - r)
      end do
      do r = 1, below
         w(:, :, row(r)) = front_vector(:, offset + 6*r - 5:offset + 6*r)
      end do
   end subroutine forward_front

   !> Gather the rows of W in a front.
   !> Zeros fill the packed panels after the pivot rows and after the last row.
   pure subroutine gather_front(pivots, below, row, first, w, front_vector)
      !> size, rows and first pivot of the front
      integer, intent(in) :: pivots, below, row(below), first
      real(sp), intent(in) :: w(vector_width, 6, *)  !< one panel of W
      !> rows of W in the front
      real(sp), intent(inout) :: front_vector(vector_width, 6*(pivots + below) + 2*packed_rows)
      integer :: r, offset

      offset = 6*pivots + packed_rows
      do r = 1, pivots
         front_vector(:, 6*r - 5:6*r) = w(:, :, first + r - 1)
      end do
      front_vector(:, 6*pivots + 1:offset) = 0.0_sp
      do r = 1, below
         front_vector(:, offset + 6*r - 5:offset + 6*r) = w(:, :, row(r))
      end do
      front_vector(:, offset + 6*below + 1:) = 0.0_sp
   end subroutine gather_front

   !> Compute y = T x for a panel of columns; T is lower triangular, with zeros above the diagonal.
   pure subroutine multiply_triangle(t, x, y)
      real(sp), intent(in) :: t(packed_rows, 6), x(vector_width, 6)  !< one packed panel; x
      real(sp), intent(inout) :: y(vector_width, 6)  !< [width, 6] rows of W
      integer :: i

      do i = 1, 6
         y(:, i) = t(i, 1)*x(:, 1) + t(i, 2)*x(:, 2) + t(i, 3)*x(:, 3) + t(i, 4)*x(:, 4) &
            + t(i, 5)*x(:, 5) + t(i, 6)*x(:, 6)
      end do
   end subroutine multiply_triangle

   !> Compute y = y − A x for a panel of columns; A is one packed panel of L.
   pure subroutine subtract_panel(a, x, y)
      real(sp), intent(in) :: a(packed_rows, 6), x(vector_width, 6)  !< A and x
      real(sp), intent(inout) :: y(vector_width, packed_rows)  !< y
      integer :: i

      do i = 1, packed_rows
         y(:, i) = y(:, i) - (a(i, 1)*x(:, 1) + a(i, 2)*x(:, 2) + a(i, 3)*x(:, 3) &
            + a(i, 4)*x(:, 4) + a(i, 5)*x(:, 5) + a(i, 6)*x(:, 6))
      end do
   end subroutine subtract_panel

   !> Compute the block rows of WᵀW of several panels, up to the diagonal.
   subroutine multiply_columns(columns, plan, first, last, gram)
      type(low_rank_columns_type), intent(in) :: columns  !< W
      type(front_plan_type), intent(in) :: plan  !< symbolic factor
      integer, intent(in) :: first, last  !< first and last panel
      !> WᵀW, lower triangle of panels
      real(wp), intent(inout) :: gram(most_changes, most_changes)
      integer :: row, column

      !$omp parallel do schedule(dynamic, 1) private(column) if (plan%sharing%is_shared)
      do row = first, last
         do column = 1, row
            call multiply_panels(columns, plan, row, column, &
               gram(vector_width*(row - 1) + 1:vector_width*row, &
               vector_width*(column - 1) + 1:vector_width*column))
         end do
      end do
   end subroutine multiply_columns

   !> Compute the block of WᵀW of two panels in double precision, summed over their common fronts.
   subroutine multiply_panels(columns, plan, row, column, total)
      type(low_rank_columns_type), intent(in) :: columns  !< W
      type(front_plan_type), intent(in) :: plan  !< symbolic factor
      integer, intent(in) :: row, column  !< numbers of the panels
      real(wp), intent(inout) :: total(:,:)  !< [width, width] block of WᵀW of the two panels
      real(sp) :: product(vector_width, vector_width)
      integer :: i, pivot, count

      total = 0.0_wp
      do i = 1, columns%path_length(row)
         associate (front => columns%path(i, row))
            if (.not. columns%is_nonzero(front, column)) cycle
            do pivot = plan%first(front), plan%first(front + 1) - 1, pivots_together
               count = min(pivots_together, plan%first(front + 1) - pivot)
               call multiply_transposed(6*count, columns%w(1, 1, pivot, row), &
                  columns%w(1, 1, pivot, column), product)
               total = total + product
            end do
         end associate
      end do
   end subroutine multiply_panels

   !> Compute P = A Bᵀ for rows of two panels.
   subroutine multiply_transposed(rows, a, b, p)
      integer, intent(in) :: rows  !< number of rows of the panels
      real(sp), intent(in) :: a(vector_width, rows), b(vector_width, rows)  !< A and B
      real(sp), intent(inout) :: p(vector_width, vector_width)  !< P

      if (wide_registers) then
         call multiply_in_registers(rows, a, b, 0, p)
         call multiply_in_registers(rows, a, b, vector_width/2, p(1, vector_width/2 + 1))
      else
         call sgemm('N', 'T', vector_width, vector_width, rows, 1.0_sp, a, vector_width, b, &
            vector_width, 0.0_sp, p, vector_width)
      end if
   end subroutine multiply_transposed

   !> Compute eight columns of P = A Bᵀ.
   pure subroutine multiply_in_registers(rows, a, b, before, p)
      integer, intent(in) :: rows, before  !< rows of the panels; columns of P before these eight
      real(sp), intent(in) :: a(vector_width, rows), b(vector_width, rows)  !< A and B
      real(sp), intent(inout) :: p(vector_width, 8)  !< eight columns of P
      real(sp), dimension(vector_width) :: p1, p2, p3, p4, p5, p6, p7, p8
      integer :: i, k

      p1 = 0.0_sp
      p2 = 0.0_sp
      p3 = 0.0_sp
      p4 = 0.0_sp
      p5 = 0.0_sp
      p6 = 0.0_sp
      p7 = 0.0_sp
      p8 = 0.0_sp
      do k = 1, rows
         !$omp simd
         do i = 1, vector_width
            p1(i) = p1(i) + a(i, k)*b(before + 1, k)
            p2(i) = p2(i) + a(i, k)*b(before + 2, k)
            p3(i) = p3(i) + a(i, k)*b(before + 3, k)
            p4(i) = p4(i) + a(i, k)*b(before + 4, k)
            p5(i) = p5(i) + a(i, k)*b(before + 5, k)
            p6(i) = p6(i) + a(i, k)*b(before + 6, k)
            p7(i) = p7(i) + a(i, k)*b(before + 7, k)
            p8(i) = p8(i) + a(i, k)*b(before + 8, k)
         end do
      end do
      p(:, 1) = p1
      p(:, 2) = p2
      p(:, 3) = p3
      p(:, 4) = p4
      p(:, 5) = p5
      p(:, 6) = p6
      p(:, 7) = p7
      p(:, 8) = p8
   end subroutine multiply_in_registers

   !> Compute Wᵀ y of several panels.
   subroutine project_vector(columns, plan, panels, y, projection)
      type(low_rank_columns_type), intent(in) :: columns  !< W
      type(front_plan_type), intent(in) :: plan  !< symbolic factor
      integer, intent(in) :: panels  !< number of panels with columns
      real(sp), intent(in) :: y(6, plan%n)  !< vector in permuted order
      real(wp), intent(out) :: projection(vector_width, column_panels)  !< Wᵀ y
      integer :: panel

      !$omp parallel do schedule(dynamic, 1) if (plan%sharing%is_shared)
      do panel = 1, panels
         call multiply_transposed_panel(columns, plan, panel, y, projection(:, panel))
      end do
   end subroutine project_vector

   !> Compute Wᵀ y of one panel.
   pure subroutine multiply_transposed_panel(columns, plan, panel, y, projection)
      type(low_rank_columns_type), intent(in) :: columns  !< W
      type(front_plan_type), intent(in) :: plan  !< symbolic factor
      integer, intent(in) :: panel  !< number of the panel
      real(sp), intent(in) :: y(6, plan%n)  !< vector in permuted order
      real(wp), intent(out) :: projection(vector_width)  !< Wᵀ y
      real(sp) :: partial(vector_width)
      integer :: i, pivot, k

      projection = 0.0_wp
      do i = 1, columns%path_length(panel)
         partial = 0.0_sp
         associate (front => columns%path(i, panel))
            do pivot = plan%first(front), plan%first(front + 1) - 1
               do k = 1, 6
                  partial = partial + columns%w(:, k, pivot, panel)*y(k, pivot)
               end do
            end do
         end associate
         projection = projection + partial
      end do
   end subroutine multiply_transposed_panel

   !> Compute y = y − W x of several panels.
   subroutine subtract_columns(columns, plan, panels, x, y)
      type(low_rank_columns_type), intent(in) :: columns  !< W
      type(front_plan_type), intent(in) :: plan  !< symbolic factor
      integer, intent(in) :: panels  !< number of panels with columns
      real(wp), intent(in) :: x(vector_width, column_panels)  !< value for each column
      real(sp), intent(inout) :: y(6, plan%n)  !< vector in permuted order
      integer :: front

      !$omp parallel do schedule(static) if (plan%sharing%is_shared)
      do front = 1, plan%fronts
         call subtract_front(columns, plan, front, panels, x, y)
      end do
   end subroutine subtract_columns

   !> Compute y = y − W x in the pivot rows of one front.
   pure subroutine subtract_front(columns, plan, front, panels, x, y)
      type(low_rank_columns_type), intent(in) :: columns  !< W
      type(front_plan_type), intent(in) :: plan  !< symbolic factor
      integer, intent(in) :: front, panels  !< number of the front; number of panels with columns
      real(wp), intent(in) :: x(vector_width, column_panels)  !< value for each column
      real(sp), intent(inout) :: y(6, plan%n)  !< vector in permuted order
      real(sp) :: partial(vector_width, 6)
      integer :: panel, pivot, k

      if (.not. any(columns%is_nonzero(front, :panels))) return
      do pivot = plan%first(front), plan%first(front + 1) - 1
         partial = 0.0_sp
         do panel = 1, panels
            if (.not. columns%is_nonzero(front, panel)) cycle
            do k = 1, 6
               partial(:, k) = partial(:, k) + columns%w(:, k, pivot, panel)*real(x(:, panel), sp)
            end do
         end do
         partial(:8, :) = partial(:8, :) + partial(9:, :)
         partial(:4, :) = partial(:4, :) + partial(5:8, :)
         y(:, pivot) = y(:, pivot) - ((partial(1, :) + partial(2, :)) &
            + (partial(3, :) + partial(4, :)))
      end do
   end subroutine subtract_front

end module dda_low_rank_columns
