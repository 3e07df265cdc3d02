!> A Cholesky factor that follows changes of few springs without being made anew.
!>
!> With A = L Lᵀ and the changes U S Uᵀ (Sherman, Morrison, Woodbury; W. W. Hager, SIAM Review 31 (1989) 221)
!>
!>     (A + U S Uᵀ)⁻¹ = L⁻ᵀ (I − W C⁻¹ Wᵀ) L⁻¹,   W = L⁻¹ U,   C = S⁻¹ + Wᵀ W
!>
!> so the correction stands between the two halves of a solve.  A column of W differs from zero only in the fronts
!> between its blocks and the root, a few hundredths of the factor.  As A and A + U S Uᵀ are both positive definite,
!> C has a positive pivot for each spring put in and a negative one for each taken out (inertia of the two Schur
!> complements); where rounding says otherwise the changes are refused.  Columns go in chunks of fixed width, one
!> column to a lane, each chunk by one thread: bits depend neither on threads nor on what the other lanes hold.
module dda_low_rank
   use dda_kinds, only: wp, sp
   use dda_blas, only: sgemm
   use dda_cholesky_single, only: factor_type
   use dda_front_plan, only: front_plan_type, slice_rows, slices_of, widest_part
   use dda_rank_one, only: rank_one_type, most_changes
   implicit none
   private
   public :: low_rank_type, plan_low_rank, forget_low_rank, follow_changes, follow_again, correct

   integer, parameter :: lanes = 16
   integer, parameter :: chunks = most_changes/lanes
   integer, parameter :: deep = 64                !< columns multiplied together, so that BLAS stays on one thread

   !> The changes since the factor was made, and what follows from them.
   type :: low_rank_type
      type(rank_one_type) :: springs
      integer, allocatable :: place(:)            !< [n] place of each row of blocks in the order of elimination
      integer, allocatable :: front_of(:)         !< [n] front that eliminates it
      logical, allocatable :: touched(:,:)        !< [fronts, chunks] W differs from zero in its own rows
      integer, allocatable :: path(:,:)           !< [fronts, chunks] the touched fronts, in postorder
      integer :: length(chunks) = 0               !< how many
      real(sp), allocatable :: w(:,:,:,:)         !< [lanes, 6, n, chunks] W, in touched fronts
      real(sp), allocatable :: part(:,:,:)        !< [lanes, widest part, chunks] the part of W that a front sees
      real(wp) :: gram(most_changes, most_changes) = 0.0_wp      !< WᵀW, its lower triangle of chunks
      integer :: order(most_changes) = 0          !< springs put in, then those taken out
      real(wp) :: pivot(most_changes) = 0.0_wp    !< C = T D Tᵀ in that order
      real(wp) :: t(most_changes, most_changes) = 0.0_wp
   end type low_rank_type

contains

   !> Make room for a new pattern; W is not touched before it is used.
   subroutine plan_low_rank(low, plan)
      type(low_rank_type), intent(inout) :: low
      type(front_plan_type), intent(in) :: plan
      integer :: front, i

      call forget_low_rank(low)
      if (allocated(low%w)) deallocate (low%place, low%front_of, low%touched, low%path, low%w, low%part)
      allocate (low%place(plan%n), low%front_of(plan%n), low%touched(plan%fronts, chunks), low%path(plan%fronts, chunks))
      allocate (low%w(lanes, 6, plan%n, chunks), low%part(lanes, widest_part(plan), chunks))
      do front = 1, plan%fronts
         do i = plan%first(front), plan%first(front + 1) - 1
            low%place(plan%order(i)) = i
            low%front_of(plan%order(i)) = front
         end do
      end do
   end subroutine plan_low_rank

   !> The factor is new: nothing has changed since.
   pure subroutine forget_low_rank(low)
      type(low_rank_type), intent(inout) :: low

      low%springs%n = 0
   end subroutine forget_low_rank

   !> Take over more changes; .false. if they are too many, or cannot be followed in this precision.
   subroutine follow_changes(low, factor, changes, done)
      type(low_rank_type), intent(inout) :: low
      type(factor_type), intent(in) :: factor
      type(rank_one_type), intent(in) :: changes
      logical, intent(out) :: done
      integer :: first

      first = low%springs%n/lanes + 1
      done = low%springs%n + changes%n <= most_changes
      if (.not. done) return
      associate (old => low%springs%n, n => low%springs%n + changes%n)
         low%springs%block(:, old + 1:n) = changes%block(:, :changes%n)
         low%springs%u(:, :, old + 1:n) = changes%u(:, :, :changes%n)
         low%springs%k(old + 1:n) = changes%k(:changes%n)
      end associate
      low%springs%n = low%springs%n + changes%n
      call follow_from(low, factor, first, done)
   end subroutine follow_changes

   !> Make all that follows from the noted springs anew, to the same bits.
   subroutine follow_again(low, factor, done)
      type(low_rank_type), intent(inout) :: low
      type(factor_type), intent(in) :: factor
      logical, intent(out) :: done

      call follow_from(low, factor, 1, done)
   end subroutine follow_again

   !> W, WᵀW and C from the first chunk on that holds new springs.
   subroutine follow_from(low, factor, first, done)
      type(low_rank_type), intent(inout) :: low
      type(factor_type), intent(in) :: factor
      integer, intent(in) :: first
      logical, intent(out) :: done
      integer :: last

      last = (low%springs%n + lanes - 1)/lanes
      call make_columns(low, factor, first, last)
      call multiply_columns(low, factor%plan, first, last)
      call order_springs(low)
      call factorise_capacity(low, done)
   end subroutine follow_from

   !> W of some chunks.
   subroutine make_columns(low, factor, first, last)
      type(low_rank_type), intent(inout) :: low
      type(factor_type), intent(in) :: factor
      integer, intent(in) :: first, last
      integer :: chunk

      !$omp parallel do schedule(dynamic, 1) if (factor%plan%sharing%is_shared)
      do chunk = first, last
         call find_path(low, factor%plan, chunk)
         call lay_springs(low, factor%plan, chunk)
         call climb(factor%plan, factor%sliced, low%length(chunk), low%path(:, chunk), low%part(:, :, chunk), &
            low%w(:, :, :, chunk))
      end do
   end subroutine make_columns

   !> The fronts between the springs of a chunk and the root.
   pure subroutine find_path(low, plan, chunk)
      type(low_rank_type), intent(inout) :: low
      type(front_plan_type), intent(in) :: plan
      integer, intent(in) :: chunk
      integer :: i, side, front

      low%touched(:, chunk) = .false.
      do i = lanes*(chunk - 1) + 1, min(lanes*chunk, low%springs%n)
         do side = 1, 2
            front = low%front_of(low%springs%block(side, i))
            do while (front > 0)
               if (low%touched(front, chunk)) exit
               low%touched(front, chunk) = .true.
               front = plan%parent(front)
            end do
         end do
      end do
      low%length(chunk) = 0
      do front = 1, plan%fronts
         if (.not. low%touched(front, chunk)) cycle
         low%length(chunk) = low%length(chunk) + 1
         low%path(low%length(chunk), chunk) = front
      end do
   end subroutine find_path

   !> Put U into the rows of a path.
   pure subroutine lay_springs(low, plan, chunk)
      type(low_rank_type), intent(inout) :: low
      type(front_plan_type), intent(in) :: plan
      integer, intent(in) :: chunk
      integer :: i, side, lane, place

      do i = 1, low%length(chunk)
         associate (front => low%path(i, chunk))
            low%w(:, :, plan%first(front):plan%first(front + 1) - 1, chunk) = 0.0_sp
         end associate
      end do
      do lane = 1, min(lanes, low%springs%n - lanes*(chunk - 1))
         i = lanes*(chunk - 1) + lane
         do side = 1, 2
            place = low%place(low%springs%block(side, i))
            low%w(lane, :, place, chunk) = low%w(lane, :, place, chunk) + real(low%springs%u(:, side, i), sp)
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
            call climb_front(own, below, sliced(plan%part_start(front)), plan%row(plan%row_start(front)), &
               plan%first(front), part, w)
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
            call subtract_lanes(sliced(1, 1, at + s), part(1, 6*j - 5), part(1, 6*j + 1 + slice_rows*(s - 1)))
         end do
         at = at + 1 + slices_of(own - j)
      end do
      do j = 1, own
         do s = 1, slices_of(below)
            call subtract_lanes(sliced(1, 1, at + s - 1), part(1, 6*j - 5), part(1, under + 1 + slice_rows*(s - 1)))
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

   !> The rows of W that a front sees; zeros behind own rows and behind the last, where slices reach.
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
         x(:, i) = t(i, 1)*z(:, 1) + t(i, 2)*z(:, 2) + t(i, 3)*z(:, 3) + t(i, 4)*z(:, 4) + t(i, 5)*z(:, 5) + t(i, 6)*z(:, 6)
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

   !> WᵀW of new chunks with all up to them.
   subroutine multiply_columns(low, plan, first, last)
      type(low_rank_type), intent(inout) :: low
      type(front_plan_type), intent(in) :: plan
      integer, intent(in) :: first, last
      integer :: row, column

      !$omp parallel do schedule(dynamic, 1) private(column) if (plan%sharing%is_shared)
      do row = first, last
         do column = 1, row
            call multiply_chunks(low, plan, row, column)
         end do
      end do
   end subroutine multiply_columns

   subroutine multiply_chunks(low, plan, row, column)
      type(low_rank_type), intent(inout) :: low
      type(front_plan_type), intent(in) :: plan
      integer, intent(in) :: row, column
      real(sp) :: product(lanes, lanes)
      real(wp) :: total(lanes, lanes)
      integer :: i, place, count

      total = 0.0_wp
      do i = 1, low%length(row)
         associate (front => low%path(i, row))
            if (.not. low%touched(front, column)) cycle
            do place = plan%first(front), plan%first(front + 1) - 1, deep
               count = min(deep, plan%first(front + 1) - place)
               call sgemm('N', 'T', lanes, lanes, 6*count, 1.0_sp, low%w(:, :, place, row), lanes, &
                  low%w(:, :, place, column), lanes, 0.0_sp, product, lanes)
               total = total + product
            end do
         end associate
      end do
      low%gram(lanes*(row - 1) + 1:lanes*row, lanes*(column - 1) + 1:lanes*column) = total
   end subroutine multiply_chunks

   !> Springs put in come first: their part of C is positive definite by itself.
   pure subroutine order_springs(low)
      type(low_rank_type), intent(inout) :: low
      integer :: i, filled, pass

      filled = 0
      do pass = 1, 2
         do i = 1, low%springs%n
            if ((low%springs%k(i) > 0.0_wp) .neqv. (pass == 1)) cycle
            filled = filled + 1
            low%order(filled) = i
         end do
      end do
   end subroutine order_springs

   !> C = T D Tᵀ; .false. if a pivot has not the sign of its spring.
   pure subroutine factorise_capacity(low, done)
      type(low_rank_type), intent(inout) :: low
      logical, intent(out) :: done
      integer :: i, j, n

      n = low%springs%n
      do j = 1, n
         do i = j, n
            low%t(i, j) = low%gram(max(low%order(i), low%order(j)), min(low%order(i), low%order(j)))
         end do
         low%t(j, j) = low%t(j, j) + 1.0_wp/low%springs%k(low%order(j))
      end do
      do j = 1, n
         low%pivot(j) = low%t(j, j)
         done = low%pivot(j)*low%springs%k(low%order(j)) > 0.0_wp
         if (.not. done) return
         low%t(j + 1:n, j) = low%t(j + 1:n, j)/low%pivot(j)
         do i = j + 1, n
            low%t(i:n, i) = low%t(i:n, i) - low%t(i:n, j)*(low%t(i, j)*low%pivot(j))
         end do
      end do
      done = .true.
   end subroutine factorise_capacity

   !> y = (I − W C⁻¹ Wᵀ) y, between the two halves of a solve.
   subroutine correct(low, plan, y)
      type(low_rank_type), intent(in) :: low
      type(front_plan_type), intent(in) :: plan
      real(sp), intent(inout) :: y(6, plan%n)
      real(wp) :: share(lanes, chunks)
      integer :: chunk, used, front

      if (low%springs%n == 0) return
      used = (low%springs%n + lanes - 1)/lanes
      !$omp parallel if (plan%sharing%is_shared)
      !$omp do schedule(dynamic, 1)
      do chunk = 1, used
         call project(low, plan, chunk, y, share(:, chunk))
      end do
      !$omp end do
      !$omp single
      call solve_capacity(low, share)
      !$omp end single
      !$omp do schedule(static)
      do front = 1, plan%fronts
         call subtract_columns(low, plan, front, used, share, y)
      end do
      !$omp end do
      !$omp end parallel
   end subroutine correct

   !> Wᵀ y of one chunk.
   pure subroutine project(low, plan, chunk, y, share)
      type(low_rank_type), intent(in) :: low
      type(front_plan_type), intent(in) :: plan
      integer, intent(in) :: chunk
      real(sp), intent(in) :: y(6, plan%n)
      real(wp), intent(out) :: share(lanes)
      real(sp) :: part(lanes)
      integer :: i, place, k

      share = 0.0_wp
      do i = 1, low%length(chunk)
         part = 0.0_sp
         do place = plan%first(low%path(i, chunk)), plan%first(low%path(i, chunk) + 1) - 1
            do k = 1, 6
               part = part + low%w(:, k, place, chunk)*y(k, place)
            end do
         end do
         share = share + part
      end do
   end subroutine project

   !> x = C⁻¹ x, for all springs; zeros in the lanes that hold none.
   pure subroutine solve_capacity(low, x)
      type(low_rank_type), intent(in) :: low
      real(wp), intent(inout) :: x(most_changes)
      real(wp) :: z(most_changes)
      integer :: i, n

      n = low%springs%n
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
      x(n + 1:) = 0.0_wp
      do i = 1, n
         x(low%order(i)) = z(i)
      end do
   end subroutine solve_capacity

   !> y = y − W x in the own rows of one front.
   pure subroutine subtract_columns(low, plan, front, used, x, y)
      type(low_rank_type), intent(in) :: low
      type(front_plan_type), intent(in) :: plan
      integer, intent(in) :: front, used
      real(wp), intent(in) :: x(lanes, chunks)
      real(sp), intent(inout) :: y(6, plan%n)
      real(sp) :: part(lanes, 6)
      integer :: chunk, place, k

      if (.not. any(low%touched(front, :used))) return
      do place = plan%first(front), plan%first(front + 1) - 1
         part = 0.0_sp
         do chunk = 1, used
            if (.not. low%touched(front, chunk)) cycle
            do k = 1, 6
               part(:, k) = part(:, k) + low%w(:, k, place, chunk)*real(x(:, chunk), sp)
            end do
         end do
         part(:8, :) = part(:8, :) + part(9:, :)
         part(:4, :) = part(:4, :) + part(5:8, :)
         y(:, place) = y(:, place) - ((part(1, :) + part(2, :)) + (part(3, :) + part(4, :)))
      end do
   end subroutine subtract_columns

end module dda_low_rank
