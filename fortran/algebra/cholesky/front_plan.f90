! SPDX-License-Identifier: GPL-3.0-or-later
!> The symbolic multifrontal Cholesky factor.
!>
!> A front is a dense matrix of 6×6 blocks: fully summed (pivot) columns, and the rows below with
!> nonzeros.  The pivot columns are eliminated in a dense panel and become columns of the factor;
!> the Schur complement is an update that is added to the parent front.  The symbolic factor
!> contains the position of every panel, update and matrix block, so that factorisation needs no
!> allocation.
!>
!> The columns of the factor are stored in the order in which a solve reads them
!> (`dda_packed_panels`).
!> References: I. S. Duff, J. K. Reid, ACM TOMS 9 (1983) 302 (multifrontal);
!> J. W. H. Liu, SIAM Review 34 (1992) 82.
module dda_front_plan
   use dda_growth, only: grow
   use dda_kinds, only: long, wp
   use dda_block_graph, only: block_graph_type
   use dda_counting_sort, only: sort_by_key
   use dda_elimination, only: front_cost, front_tree_type, tree_of_fronts
   use dda_packed_panels, only: packed_rows, packed_size, panels_of, pivot_panels
   use dda_task_plan, only: plan_tasks, task_plan_type
   implicit none
   private
   public :: front_plan_type, make_plan, plan_updates, longest_front_vector, &
      is_passed, locate_column, band

   integer, parameter :: band = 8  !< columns of an update stored together

   !> Symbolic Cholesky factor.  Rows and columns are identified by permuted index, the position in
   !> the order of elimination.
   type :: front_plan_type
      integer :: n = 0                     !< number of block rows
      integer :: entries = 0               !< number of lower blocks
      integer :: fronts = 0                !< number of fronts, in postorder
      integer, allocatable :: order(:)     !< [n] block row of each permuted index
      integer, allocatable :: first(:)     !< [fronts+1] first pivot of each front
      integer, allocatable :: parent(:)    !< [fronts] front that adds the update; 0 for a root
      integer, allocatable :: child_start(:) !< [fronts+1] start of each front in `child`
      integer, allocatable :: child(:)     !< [fronts] children of all fronts
      integer, allocatable :: row_start(:) !< [fronts+1] start of each front in `row`
      integer, allocatable :: row(:)       !< [rows] rows below the pivots, ascending
      integer, allocatable :: position(:)  !< [rows] positions of these rows in the parent's front
      !> [rows] end of the contiguous range of each row, as a position in the front
      integer, allocatable :: run_end(:)
      !> [fronts] number of leading rows that are pivots of the parent
      integer, allocatable :: inside(:)
      integer, allocatable :: entry_start(:) !< [n+1] start of each column in `entry`
      integer, allocatable :: entry(:)     !< [entries] number of the block; negative if transposed
      integer, allocatable :: entry_row(:) !< [entries] position of the row in the front
      !> [fronts+1] start of each front in the factor
      integer(long), allocatable :: factor_start(:)
      integer, allocatable :: pivot_panels(:) !< [fronts] number of packed panels of pivot rows
      integer(long) :: panel_of_task = 0   !< size of the largest panel of a task
      integer(long) :: panel_of_root = 0   !< size of the largest panel of a root front
      !> root fronts wait for all tasks; .false.: one thread processes all fronts in postorder
      logical :: tasks_first = .false.
      !> [fronts] offset of each update: in the workspace of a thread, or, for updates of root
      !> fronts and of their children, in the common workspace
      integer(long), allocatable :: update_start(:)
      integer(long) :: updates_passed = 0  !< size of the updates from tasks to root fronts
      integer(long) :: updates_of_task = 0 !< largest size of the updates within a task
      integer(long) :: updates_of_roots = 0 !< size of the updates of root fronts
      type(task_plan_type) :: sharing      !< division of fronts between threads
      !> [rows] position of each row in the solve vector, see `set_solve_rows`
      integer, allocatable :: solve_row(:)
      integer, allocatable :: shared_row(:) !< [any] rows of root fronts that tasks add to
      integer :: widest = 0                !< largest number of block rows in a front
   end type front_plan_type

contains

   !> Compute the symbolic factor of a matrix with the given graph and order of elimination.
   pure subroutine make_plan(graph, order, plan)
      type(block_graph_type), intent(in) :: graph  !< graph of the block matrix
      integer, intent(in) :: order(graph%n)  !< block row eliminated k-th
      type(front_plan_type), intent(out) :: plan  !< symbolic factor
      type(front_tree_type) :: tree
      integer :: permuted(graph%n), front_at(graph%n), front, k

      call tree_of_fronts(graph, order, tree)
      plan%n = graph%n
      plan%entries = size(graph%neighbour)/2
      plan%fronts = tree%fronts
      call move_alloc(tree%order, plan%order)
      call move_alloc(tree%first, plan%first)
      call move_alloc(tree%parent, plan%parent)
      permuted(plan%order) = [(k, k=1, plan%n)]
      do front = 1, plan%fronts
         front_at(plan%first(front):plan%first(front + 1) - 1) = front
      end do
      call list_children(plan)
      call list_rows(graph, permuted, front_at, plan)
      call find_parent_rows(plan)
      call list_entries(graph, permuted, front_at, plan)
      call divide_fronts(plan)
      call plan_panels(plan)
      call set_solve_rows(plan)
   end subroutine make_plan

   !> List the children of each front, in postorder.
   pure subroutine list_children(plan)
      type(front_plan_type), intent(inout) :: plan  !< symbolic factor, incomplete
      integer, allocatable :: order(:)
      integer :: front

      plan%child = pack([(front, front=1, plan%fronts)], plan%parent > 0)
      call sort_by_key(plan%fronts, plan%parent(plan%child), plan%child_start, order)
      plan%child = plan%child(order)
   end subroutine list_children

   !> List the rows below each front.
   !> Row i is below each front on the tree path from a neighbour of i to i; each list ascends.
   pure subroutine list_rows(graph, permuted, front_at, plan)
      type(block_graph_type), intent(in) :: graph  !< graph of the block matrix
      !> permuted index of each row; front of each permuted index
      integer, intent(in) :: permuted(graph%n), front_at(graph%n)
      type(front_plan_type), intent(inout) :: plan  !< symbolic factor, incomplete
      integer, allocatable :: of_front(:), row(:), order(:)
      integer :: mark(plan%fronts), i, e, front, n

      mark = 0
      n = 0
      do i = 1, plan%n
         mark(front_at(i)) = i
         do e = graph%start(plan%order(i)), graph%start(plan%order(i) + 1) - 1
            if (permuted(graph%neighbour(e)) > i) cycle
            front = front_at(permuted(graph%neighbour(e)))
            do while (mark(front) /= i)
               mark(front) = i
               n = n + 1
               call grow(of_front, n)
               call grow(row, n)
               of_front(n) = front
               row(n) = i
               front = plan%parent(front)
            end do
         end do
      end do
      call grow(row, n)
      call grow(of_front, n)
      call sort_by_key(plan%fronts, of_front(:n), plan%row_start, order)
      plan%row = row(order)
   end subroutine list_rows

   !> Find the position of the rows of each front in its parent, and their contiguous ranges.
   pure subroutine find_parent_rows(plan)
      type(front_plan_type), intent(inout) :: plan  !< symbolic factor, incomplete
      integer :: front, start, last, i

      allocate (plan%position(size(plan%row)), plan%run_end(size(plan%row)), &
         plan%inside(plan%fronts))
      plan%widest = 0
      do front = 1, plan%fronts
         start = plan%row_start(front)
         last = plan%row_start(front + 1) - 1
         plan%widest = max(plan%widest, plan%first(front + 1) - plan%first(front) + last - start &
            + 1)
         plan%inside(front) = 0
         if (last < start) cycle
         call find_positions(plan, front, plan%parent(front))
         plan%run_end(last) = last - start + 1
         do i = last - 1, start, -1
            plan%run_end(i) = plan%run_end(i + 1)
            if (plan%position(i + 1) /= plan%position(i) + 1) plan%run_end(i) = i - start + 1
         end do
      end do
   end subroutine find_parent_rows

   !> Find the positions of the rows of a front in the rows of its parent; both lists ascend.
   pure subroutine find_positions(plan, front, parent)
      type(front_plan_type), intent(inout) :: plan  !< symbolic factor, incomplete
      integer, intent(in) :: front, parent  !< a front and the parent front
      integer :: pivots, i, p

      pivots = plan%first(parent + 1) - plan%first(parent)
      p = plan%row_start(parent)
      do i = plan%row_start(front), plan%row_start(front + 1) - 1
         if (plan%row(i) < plan%first(parent + 1)) then
            plan%position(i) = plan%row(i) - plan%first(parent) + 1
            plan%inside(front) = plan%inside(front) + 1
         else
            do while (plan%row(p) < plan%row(i))
               p = p + 1
            end do
            plan%position(i) = pivots + p - plan%row_start(parent) + 1
         end if
      end do
   end subroutine find_positions

   !> Find the column and row of each lower block; its column is the one that is eliminated first.
   pure subroutine list_entries(graph, permuted, front_at, plan)
      type(block_graph_type), intent(in) :: graph  !< graph of the block matrix
      !> permuted index of each row; front of each permuted index
      integer, intent(in) :: permuted(graph%n), front_at(graph%n)
      type(front_plan_type), intent(inout) :: plan  !< symbolic factor, incomplete
      integer :: local(graph%n), front, pivots, i, j, e, count

      allocate (plan%entry_start(plan%n + 1), plan%entry(plan%entries), &
         plan%entry_row(plan%entries))
      count = 0
      do j = 1, plan%n
         front = front_at(j)
         pivots = plan%first(front + 1) - plan%first(front)
         if (j == plan%first(front)) then
            do i = 1, pivots
               local(j + i - 1) = i
            end do
            do i = plan%row_start(front), plan%row_start(front + 1) - 1
               local(plan%row(i)) = pivots + i - plan%row_start(front) + 1
            end do
         end if
         plan%entry_start(j) = count + 1
         do e = graph%start(plan%order(j)), graph%start(plan%order(j) + 1) - 1
            i = permuted(graph%neighbour(e))
            if (i < j) cycle
            count = count + 1
            plan%entry(count) = graph%entry(e)
            if (plan%order(i) < plan%order(j)) plan%entry(count) = -graph%entry(e)
            plan%entry_row(count) = local(i)
         end do
      end do
      plan%entry_start(plan%n + 1) = count + 1
   end subroutine list_entries

   !> Divide the fronts between threads.
   pure subroutine divide_fronts(plan)
      type(front_plan_type), intent(inout) :: plan  !< symbolic factor, incomplete
      real(wp) :: cost(plan%fronts)
      integer :: front

      do front = 1, plan%fronts
         cost(front) = front_cost(pivot_columns(plan, front), pivot_columns(plan, front) &
            + rows_below(plan, front))
      end do
      call plan_tasks(plan%parent, cost, plan%sharing)
   end subroutine divide_fronts

   !> Set the sizes of the panels and of the factor, which is stored in the order of a solve.
   !> Each thread eliminates in a panel with the size of the largest front of a task.
   pure subroutine plan_panels(plan)
      type(front_plan_type), intent(inout) :: plan  !< symbolic factor, incomplete
      integer(long) :: numbers
      integer :: front

      allocate (plan%factor_start(plan%fronts + 1), plan%pivot_panels(plan%fronts))
      plan%factor_start(1) = 1
      do front = 1, plan%fronts
         associate (pivots => pivot_columns(plan, front))
            plan%pivot_panels(front) = pivot_panels(pivots)
            plan%factor_start(front + 1) = plan%factor_start(front) &
               + packed_size*(plan%pivot_panels(front) &
               + int(pivots, long)*panels_of(rows_below(plan, front)))
            numbers = 36*int(pivots, long)*(pivots + rows_below(plan, front))
         end associate
         if (plan%sharing%is_root_front(front)) then
            plan%panel_of_root = max(plan%panel_of_root, numbers)
         else
            plan%panel_of_task = max(plan%panel_of_task, numbers)
         end if
      end do
   end subroutine plan_panels

   !> Return the largest size of a front vector: pivot rows and rows below, padded to whole panels.
   pure integer function longest_front_vector(plan)
      type(front_plan_type), intent(in) :: plan  !< symbolic factor

      longest_front_vector = 6*plan%widest + 2*packed_rows
   end function longest_front_vector

   !> Assign memory to the updates, for a given number of threads.
   !> Updates from tasks to root fronts are stored until all tasks are done; root fronts then use
   !> the workspaces of threads.  A single thread adds each update immediately.
   pure subroutine plan_updates(plan, threads)
      type(front_plan_type), intent(inout) :: plan  !< symbolic factor with fronts and tasks
      integer, intent(in) :: threads  !< number of threads
      integer :: level(plan%fronts), t, front

      plan%tasks_first = threads > 1
      plan%updates_passed = 0
      plan%updates_of_task = 0
      plan%updates_of_roots = 0
      if (allocated(plan%update_start)) deallocate (plan%update_start)
      allocate (plan%update_start(plan%fronts))
      do front = plan%fronts, 1, -1
         level(front) = 0
         if (plan%parent(front) > 0) level(front) = level(plan%parent(front)) + 1
         if (.not. is_passed(plan, front)) cycle
         plan%update_start(front) = plan%updates_passed
         plan%updates_passed = plan%updates_passed + update_length(plan, front)
      end do
      if (.not. plan%tasks_first) then
         call stack_updates([(front, front=1, plan%fronts)], level, 0_long, plan, &
            plan%updates_of_task)
         return
      end if
      associate (start => plan%sharing%start, tasks => plan%sharing%tasks)
         do t = 1, tasks
            call stack_updates(plan%sharing%front(start(t):start(t + 1) - 1), level, 0_long, plan, &
               plan%updates_of_task)
         end do
         call stack_updates(plan%sharing%front(start(tasks + 1):), level, plan%updates_passed, &
            plan, plan%updates_of_roots)
      end associate
   end subroutine plan_updates

   !> Stack the updates of the fronts of a task, or of the root fronts.
   !> Odd and even levels of the tree use different stacks, because an update is computed while the
   !> updates of its children still exist.
   pure subroutine stack_updates(fronts, level, offset, plan, peak_size)
      integer, intent(in) :: fronts(:)  !< some fronts, in postorder
      integer, intent(in) :: level(:)   !< [fronts] distance of each front from its root
      integer(long), intent(in) :: offset  !< size of the memory before the stacks
      type(front_plan_type), intent(inout) :: plan  !< symbolic factor, incomplete
      integer(long), intent(inout) :: peak_size  !< largest size of the stacks so far
      integer(long) :: height(0:1), peak(0:1)
      integer :: i, c, child

      height = 0
      peak = 0
      do i = 1, size(fronts)
         associate (front => fronts(i), mine => mod(level(fronts(i)), 2))
            do c = plan%child_start(front), plan%child_start(front + 1) - 1
               child = plan%child(c)
               if (.not. is_passed(plan, child)) &
                  height(1 - mine) = height(1 - mine) - update_length(plan, child)
            end do
            if (is_passed(plan, front)) cycle
            plan%update_start(front) = offset + height(mine)
            height(mine) = height(mine) + update_length(plan, front)
            peak(mine) = max(peak(mine), height(mine))
         end associate
      end do
      do i = 1, size(fronts)
         if (is_passed(plan, fronts(i))) cycle
         if (mod(level(fronts(i)), 2) == 1) plan%update_start(fronts(i)) = &
            plan%update_start(fronts(i)) + peak(0)
      end do
      peak_size = max(peak_size, sum(peak))
   end subroutine stack_updates

   !> Assign positions in the solve vector to the rows below each front.
   !>
   !> Different tasks must not add to the same rows of the vector.  Contributions of a task to root
   !> fronts are therefore stored in separate rows at the end, one per row of its root's update.
   pure subroutine set_solve_rows(plan)
      type(front_plan_type), intent(inout) :: plan  !< symbolic factor, incomplete
      integer :: shared(plan%n), front, i, last_column

      plan%solve_row = plan%row
      last_column = plan%n
      allocate (plan%shared_row(0))
      do front = plan%fronts, 1, -1
         if (plan%sharing%is_root_front(front)) cycle
         associate (rows => plan%row(plan%row_start(front):plan%row_start(front + 1) - 1))
            if (is_subtree_root(plan, front)) then
               last_column = plan%first(front + 1) - 1
               shared(rows) = plan%n + size(plan%shared_row) + [(i, i=1, size(rows))]
               plan%shared_row = [plan%shared_row, rows]
            else if (plan%parent(front) == 0) then
               last_column = plan%n
            end if
         end associate
         do i = plan%row_start(front), plan%row_start(front + 1) - 1
            if (plan%row(i) > last_column) plan%solve_row(i) = shared(plan%row(i))
         end do
      end do
   end subroutine set_solve_rows

   !> .true. if the parent of a front is a root front, but the front is not.
   pure logical function is_subtree_root(plan, front)
      type(front_plan_type), intent(in) :: plan  !< symbolic factor
      integer, intent(in) :: front  !< number of the front

      is_subtree_root = .false.
      if (plan%sharing%is_root_front(front) .or. plan%parent(front) == 0) return
      is_subtree_root = plan%sharing%is_root_front(plan%parent(front))
   end function is_subtree_root

   !> .true. if the update of a front passes from a task to a root front that waits for all tasks.
   pure logical function is_passed(plan, front)
      type(front_plan_type), intent(in) :: plan  !< symbolic factor
      integer, intent(in) :: front  !< number of the front

      is_passed = plan%tasks_first
      if (is_passed) is_passed = is_subtree_root(plan, front)
   end function is_passed

   !> Return the number of block columns that a front eliminates.
   pure integer function pivot_columns(plan, front)
      type(front_plan_type), intent(in) :: plan  !< symbolic factor
      integer, intent(in) :: front  !< number of the front

      pivot_columns = plan%first(front + 1) - plan%first(front)
   end function pivot_columns

   !> Return the number of block rows of the update of a front.
   pure integer function rows_below(plan, front)
      type(front_plan_type), intent(in) :: plan  !< symbolic factor
      integer, intent(in) :: front  !< number of the front

      rows_below = plan%row_start(front + 1) - plan%row_start(front)
   end function rows_below

   !> Return the update size of a front; each band of columns has the rows from its first column on.
   pure integer(long) function update_length(plan, front)
      type(front_plan_type), intent(in) :: plan  !< symbolic factor
      integer, intent(in) :: front  !< number of the front
      integer :: rows, ld, skipped

      rows = rows_below(plan, front)
      update_length = 0
      if (rows == 0) return
      call locate_column(rows, rows, update_length, ld, skipped)
      update_length = update_length + 6*ld
   end function update_length

   !> Find the position of a block column in an update.
   pure subroutine locate_column(rows, column, offset, ld, skipped)
      integer, intent(in) :: rows, column    !< block rows of the update; column of the update
      integer(long), intent(out) :: offset   !< number of values before the column
      integer, intent(out) :: ld, skipped  !< length of the column; omitted block rows above
      integer :: bands

      bands = (column - 1)/band
      skipped = bands*band
      ld = 6*(rows - skipped)
      offset = 18*skipped*int(2*rows - skipped + band, long) &
         + 6*int(ld, long)*(column - 1 - skipped)
   end subroutine locate_column

end module dda_front_plan
