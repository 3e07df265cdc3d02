!> Columns of W = L⁻¹ U for springs, each a u of two blocks.
!>
!> A column differs from zero only in the fronts between its blocks and the root, a few hundredths
!> of the factor. Columns go in chunks of fixed width, one column to a lane, each chunk by one
!> thread: bits depend neither on threads nor on what the other lanes hold.
module dda_path_columns
   use dda_kinds, only: wp, sp
   use dda_blas, only: sgemm
   use dda_cholesky_single, only: factor_type
   use dda_front_plan, only: front_plan_type, widest_part
   use dda_rank_one, only: rank_one_type, most_changes
   use dda_slices, only: slice_rows, slices_of
   implicit none
   private
   public :: columns_type, plan_columns, make_columns, multiply_columns, project_all, &
      subtract_all, lanes, chunks

   integer, parameter :: lanes = 16
   integer, parameter :: chunks = most_changes/lanes
   !> columns multiplied together, so that BLAS stays on one thread
   integer, parameter :: deep = 64

   !> The columns, and where they differ from zero.
   type :: columns_type
      !> [n] place of each row of blocks in the order of elimination
      integer, allocatable :: place(:)
      integer, allocatable :: front_of(:)         !< [n] front that eliminates it
      !> [fronts, chunks] W differs from zero in its own rows
      logical, allocatable :: touched(:,:)
      !> [fronts, chunks] the touched fronts, in postorder
      integer, allocatable :: path(:,:)
      integer :: length(chunks) = 0               !< how many
      real(sp), allocatable :: w(:,:,:,:)         !< [lanes, 6, n, chunks] W, in touched fronts
      !> [lanes, widest part, chunks] the part of W that a front sees
      real(sp), allocatable :: part(:,:,:)
   end type columns_type

contains

   !> Make room for a new pattern; W is not touched before it is used.
   subroutine plan_columns(columns, plan)
      type(columns_type), intent(inout) :: columns
      type(front_plan_type), intent(in) :: plan
      integer :: front, i

      if (allocated(columns%w)) deallocate (columns%place, columns%front_of, columns%touched, &
         columns%path, columns%w, columns%part)
      allocate (columns%place(plan%n), columns%front_of(plan%n))
      allocate (columns%touched(plan%fronts, chunks), columns%path(plan%fronts, chunks))
      allocate (columns%w(lanes, 6, plan%n, chunks), columns%part(lanes, widest_part(plan), chunks))
      do front = 1, plan%fronts
         do i = plan%first(front), plan%first(front + 1) - 1
            columns%place(plan%order(i)) = i
            columns%front_of(plan%order(i)) = front
         end do
      end do
   end subroutine plan_columns

   !> The columns of some chunks.
   subroutine make_columns(columns, factor, springs, first, last)
      type(columns_type), intent(inout) :: columns
      type(factor_type), intent(in) :: factor
      type(rank_one_type), intent(in) :: springs
      integer, intent(in) :: first, last
      integer :: chunk

      !$omp parallel do schedule(dynamic, 1) if (factor%plan%sharing%is_shared)
      do chunk = first, last
         call find_path(columns, factor%plan, springs, chunk)
         call lay_springs(columns, factor%plan, springs, chunk)
         call climb(factor%plan, factor%sliced, columns%length(chunk), columns%path(:, chunk), &
            columns%part(:, :, chunk), columns%w(:, :, :, chunk))
      end do
   end subroutine make_columns

   !> The fronts between the springs of a chunk and the root.
   pure subroutine find_path(columns, plan, springs, chunk)
      type(columns_type), intent(inout) :: columns
      type(front_plan_type), intent(in) :: plan
      type(rank_one_type), intent(in) :: springs
      integer, intent(in) :: chunk
      integer :: i, side, front

      columns%touched(:, chunk) = .false.
      do i = lanes*(chunk - 1) + 1, min(lanes*chunk, springs%n)
         do side = 1, 2
            front = columns%front_of(springs%block(side, i))
            do while (front > 0)
               if (columns%touched(front, chunk)) exit
               columns%touched(front, chunk) = .true.
               front = plan%parent(front)
            end do
         end do
      end do
      columns%length(chunk) = 0
      do front = 1, plan%fronts
         if (.not. columns%touched(front, chunk)) cycle
         columns%length(chunk) = columns%length(chunk) + 1
         columns%path(columns%length(chunk), chunk) = front
      end do
   end subroutine find_path

   !> Put U into the rows of a path.
   pure subroutine lay_springs(columns, plan, springs, chunk)
      type(columns_type), intent(inout) :: columns
      type(front_plan_type), intent(in) :: plan
      type(rank_one_type), intent(in) :: springs
      integer, intent(in) :: chunk
      integer :: i, side, lane, place

      do i = 1, columns%length(chunk)
         associate (front => columns%path(i, chunk))
            columns%w(:, :, plan%first(front):plan%first(front + 1) - 1, chunk) = 0.0_sp
         end associate
      end do
      do lane = 1, min(lanes, springs%n - lanes*(chunk - 1))
         i = lanes*(chunk - 1) + lane
         do side = 1, 2
            place = columns%place(springs%block(side, i))
            columns%w(lane, :, place, chunk) = columns%w(lane, :, place, chunk) &
               + real(springs%u(:, side, i), sp)
         end do
      end do
   end subroutine lay_springs

   !> L w = u up the fronts of a path.
   pure subroutine climb(plan, sliced, length, path, part, w)
      type(front_plan_type), intent(in) :: plan
      real(sp), intent(in) :: sliced(*)
      integer, intent(in) :: length, path(length)
      real(sp), intent(inout) :: part(lanes, widest_part(plan))  !< workspace
      real(sp), intent(inout) :: w(lanes, 6, plan%n)
      integer :: i, own, below

      do i = 1, length
         associate (front => path(i))
            own = plan%first(front + 1) - plan%first(front)
            below = plan%row_start(front + 1) - plan%row_start(front)
            call climb_front(own, below, sliced(plan%part_start(front)), &
               plan%row(plan%row_start(front):plan%row_start(front + 1) - 1), plan%first(front), &
               part, w)
         end associate
      end do
   end subroutine climb

   !> Solve with the pivots of a front, subtract from the rows below.
   pure subroutine climb_front(own, below, sliced, row, first, part, w)
      integer, intent(in) :: own, below, row(below), first
      real(sp), intent(in) :: sliced(slice_rows, 6, *)
      real(sp), intent(inout) :: part(lanes, 6*(own + below) + 2*slice_rows)
      real(sp), intent(inout) :: w(lanes, 6, *)
      integer :: j, s, r, at, under

      under = 6*own + slice_rows
      call fetch(own, below, row, first, w, part)
      at = 1
      do j = 1, own
         call multiply_lanes(sliced(1, 1, at), part(1, 6*j - 5))
         do s = 1, slices_of(own - j)
            call subtract_lanes(sliced(1, 1, at + s), part(1, 6*j - 5), &
               part(1, 6*j + 1 + slice_rows*(s - 1)))
         end do
         at = at + 1 + slices_of(own - j)
      end do
      do j = 1, own
         do s = 1, slices_of(below)
            call subtract_lanes(sliced(1, 1, at + s - 1), part(1, 6*j - 5), &
               part(1, under + 1 + slice_rows*(s - 1)))
         end do
         at = at + slices_of(below)
      end do
      do r = 1, own
         w(:, :, first + r - 1) = part(:, 6*r - 5:6*r)
      end do
      do r = 1, below
         w(:, :, row(r)) = part(:, under + 6*r - 5:under + 6*r)
      end do
   end subroutine climb_front

   !> The rows of W that a front sees; zeros behind own rows and behind the last, where slices
   !> reach.
   pure subroutine fetch(own, below, row, first, w, part)
      integer, intent(in) :: own, below, row(below), first
      real(sp), intent(in) :: w(lanes, 6, *)
      real(sp), intent(inout) :: part(lanes, 6*(own + below) + 2*slice_rows)
      integer :: r, under

      under = 6*own + slice_rows
      do r = 1, own
         part(:, 6*r - 5:6*r) = w(:, :, first + r - 1)
      end do
      part(:, 6*own + 1:under) = 0.0_sp
      do r = 1, below
         part(:, under + 6*r - 5:under + 6*r) = w(:, :, row(r))
      end do
      part(:, under + 6*below + 1:) = 0.0_sp
   end subroutine fetch

   !> x = T x in all lanes, T lower triangular with zeros above.
   pure subroutine multiply_lanes(t, x)
      real(sp), intent(in) :: t(slice_rows, 6)
      real(sp), intent(inout) :: x(lanes, 6)
      real(sp) :: z(lanes, 6)
      integer :: i

      z = x
      do i = 1, 6
         x(:, i) = t(i, 1)*z(:, 1) + t(i, 2)*z(:, 2) + t(i, 3)*z(:, 3) + t(i, 4)*z(:, 4) &
            + t(i, 5)*z(:, 5) + t(i, 6)*z(:, 6)
      end do
   end subroutine multiply_lanes

   !> y = y − A x in all lanes, A one slice.
   pure subroutine subtract_lanes(a, x, y)
      real(sp), intent(in) :: a(slice_rows, 6), x(lanes, 6)
      real(sp), intent(inout) :: y(lanes, slice_rows)
      integer :: i

      do i = 1, slice_rows
         y(:, i) = y(:, i) - (a(i, 1)*x(:, 1) + a(i, 2)*x(:, 2) + a(i, 3)*x(:, 3) &
            + a(i, 4)*x(:, 4) + a(i, 5)*x(:, 5) + a(i, 6)*x(:, 6))
      end do
   end subroutine subtract_lanes

   !> WᵀW of some chunks with all up to them.
   subroutine multiply_columns(columns, plan, first, last, gram)
      type(columns_type), intent(in) :: columns
      type(front_plan_type), intent(in) :: plan
      integer, intent(in) :: first, last
      real(wp), intent(inout) :: gram(most_changes, most_changes)  !< the lower triangle of chunks
      integer :: row, column

      !$omp parallel do schedule(dynamic, 1) private(column) if (plan%sharing%is_shared)
      do row = first, last
         do column = 1, row
            call multiply_chunks(columns, plan, row, column, &
               gram(lanes*(row - 1) + 1:lanes*row, lanes*(column - 1) + 1:lanes*column))
         end do
      end do
   end subroutine multiply_columns

   !> WᵀW of two chunks: sums over the fronts that both touch, in double precision from front to
   !> front.
   subroutine multiply_chunks(columns, plan, row, column, total)
      type(columns_type), intent(in) :: columns
      type(front_plan_type), intent(in) :: plan
      integer, intent(in) :: row, column
      real(wp), intent(inout) :: total(:,:)
      real(sp) :: product(lanes, lanes)
      integer :: i, place, count

      total = 0.0_wp
      do i = 1, columns%length(row)
         associate (front => columns%path(i, row))
            if (.not. columns%touched(front, column)) cycle
            do place = plan%first(front), plan%first(front + 1) - 1, deep
               count = min(deep, plan%first(front + 1) - place)
               call sgemm('N', 'T', lanes, lanes, 6*count, 1.0_sp, columns%w(1, 1, place, row), &
                  lanes, columns%w(1, 1, place, column), lanes, 0.0_sp, product, lanes)
               total = total + product
            end do
         end associate
      end do
   end subroutine multiply_chunks

   !> Wᵀ y of some chunks.
   subroutine project_all(columns, plan, used, y, share)
      type(columns_type), intent(in) :: columns
      type(front_plan_type), intent(in) :: plan
      integer, intent(in) :: used
      real(sp), intent(in) :: y(6, plan%n)
      real(wp), intent(out) :: share(lanes, chunks)
      integer :: chunk

      !$omp parallel do schedule(dynamic, 1) if (plan%sharing%is_shared)
      do chunk = 1, used
         call project(columns, plan, chunk, y, share(:, chunk))
      end do
   end subroutine project_all

   !> Wᵀ y of one chunk.
   pure subroutine project(columns, plan, chunk, y, share)
      type(columns_type), intent(in) :: columns
      type(front_plan_type), intent(in) :: plan
      integer, intent(in) :: chunk
      real(sp), intent(in) :: y(6, plan%n)
      real(wp), intent(out) :: share(lanes)
      real(sp) :: part(lanes)
      integer :: i, place, k

      share = 0.0_wp
      do i = 1, columns%length(chunk)
         part = 0.0_sp
         do place = plan%first(columns%path(i, chunk)), plan%first(columns%path(i, chunk) + 1) - 1
            do k = 1, 6
               part = part + columns%w(:, k, place, chunk)*y(k, place)
            end do
         end do
         share = share + part
      end do
   end subroutine project

   !> y = y − W x of some chunks.
   subroutine subtract_all(columns, plan, used, x, y)
      type(columns_type), intent(in) :: columns
      type(front_plan_type), intent(in) :: plan
      integer, intent(in) :: used
      real(wp), intent(in) :: x(lanes, chunks)
      real(sp), intent(inout) :: y(6, plan%n)
      integer :: front

      !$omp parallel do schedule(static) if (plan%sharing%is_shared)
      do front = 1, plan%fronts
         call subtract_front(columns, plan, front, used, x, y)
      end do
   end subroutine subtract_all

   !> y = y − W x in the own rows of one front.
   pure subroutine subtract_front(columns, plan, front, used, x, y)
      type(columns_type), intent(in) :: columns
      type(front_plan_type), intent(in) :: plan
      integer, intent(in) :: front, used
      real(wp), intent(in) :: x(lanes, chunks)
      real(sp), intent(inout) :: y(6, plan%n)
      real(sp) :: part(lanes, 6)
      integer :: chunk, place, k

      if (.not. any(columns%touched(front, :used))) return
      do place = plan%first(front), plan%first(front + 1) - 1
         part = 0.0_sp
         do chunk = 1, used
            if (.not. columns%touched(front, chunk)) cycle
            do k = 1, 6
               part(:, k) = part(:, k) + columns%w(:, k, place, chunk)*real(x(:, chunk), sp)
            end do
         end do
         part(:8, :) = part(:8, :) + part(9:, :)
         part(:4, :) = part(:4, :) + part(5:8, :)
         y(:, place) = y(:, place) - ((part(1, :) + part(2, :)) + (part(3, :) + part(4, :)))
      end do
   end subroutine subtract_front

end module dda_path_columns
