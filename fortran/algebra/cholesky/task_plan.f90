! SPDX-License-Identifier: GPL-3.0-or-later
!> Division of the fronts of a tree into tasks and root fronts, which depends on the pattern only.
!>
!> Whole subtrees form independent tasks.  The fronts above them are the root fronts, each of which
!> is processed by all threads.  Because the division does not depend on the number of threads, sums
!> have a fixed order, and results are bit-identical.
module dda_task_plan
   use dda_kinds, only: wp
   use dda_counting_sort, only: sort_by_key
   use dda_sorting, only: ascending_order
   implicit none
   private
   public :: task_plan_type, plan_tasks

   !> Fronts of tasks for single threads, and root fronts for all threads.
   type :: task_plan_type
      integer :: tasks = 0               !< number of tasks
      !> [tasks+2] start of each task in `front`, the costliest task first; start of the root
      !> fronts; end of the root fronts
      integer, allocatable :: start(:)
      integer, allocatable :: front(:)   !< [fronts] task by task, each in postorder
      logical, allocatable :: is_root_front(:)  !< [fronts]
      logical :: is_shared = .false.     !< use of several threads saves time
   end type task_plan_type

   !> least cost for which threads save time, in the unit of `front_cost` (about 10 ns)
   real(wp), parameter :: worth_sharing = 5.0e4_wp
   !> largest fraction of the total cost in one task
   real(wp), parameter :: largest_task_fraction = 1.0_wp/12.0_wp

contains

   !> Cut the tree into subtrees that are cheap enough for one task.
   pure subroutine plan_tasks(parent, cost, plan)
      integer, intent(in) :: parent(:)  !< [fronts] parents in postorder; 0 for a root
      real(wp), intent(in) :: cost(:)   !< [fronts] cost of each front
      type(task_plan_type), intent(out) :: plan  !< tasks and root fronts
      real(wp) :: subtree(size(cost)), limit
      integer :: front

      subtree = cost
      do front = 1, size(cost)
         if (parent(front) > 0) subtree(parent(front)) = subtree(parent(front)) + subtree(front)
      end do
      limit = huge(limit)
      plan%is_shared = sum(cost) >= worth_sharing
      if (plan%is_shared) limit = largest_task_fraction*sum(cost)
      plan%is_root_front = subtree > limit
      call bind_tasks(parent, subtree, limit, plan)
   end subroutine plan_tasks

   !> Combine neighbouring subtrees below the root fronts into tasks, up to a limit of their cost.
   pure subroutine bind_tasks(parent, subtree, limit, plan)
      integer, intent(in) :: parent(:)  !< [fronts] parents in postorder; 0 for a root
      real(wp), intent(in) :: subtree(:)  !< [fronts] cost of each subtree
      real(wp), intent(in) :: limit       !< largest cost of a task
      type(task_plan_type), intent(inout) :: plan  !< receives the tasks
      integer, dimension(size(parent)) :: first, last, task
      integer :: front, begin, t
      integer, allocatable :: costliest_first(:)
      real(wp) :: load(size(parent))
      logical :: open  ! the last task may be extended

      begin = 1
      open = .false.
      do front = 1, size(parent)
         if (plan%is_root_front(front)) then
            begin = front + 1
            open = .false.
         else if (is_task_root(front)) then
            if (open) open = load(plan%tasks) + subtree(front) <= limit
            if (.not. open) then
               plan%tasks = plan%tasks + 1
               first(plan%tasks) = begin
               load(plan%tasks) = 0.0_wp
            end if
            open = .true.
            last(plan%tasks) = front
            load(plan%tasks) = load(plan%tasks) + subtree(front)
            begin = front + 1
         end if
      end do
      ! If the costliest tasks start first, threads finish at about the same time.
      costliest_first = ascending_order(-load(:plan%tasks))
      task = plan%tasks + 1
      do t = 1, plan%tasks
         task(first(costliest_first(t)):last(costliest_first(t))) = t
      end do
      call sort_by_key(plan%tasks + 1, task, plan%start, plan%front)

   contains

      pure logical function is_task_root(front)
         integer, intent(in) :: front  !< number of the front

         is_task_root = parent(front) == 0
         if (.not. is_task_root) is_task_root = plan%is_root_front(parent(front))
      end function is_task_root

   end subroutine bind_tasks

end module dda_task_plan
