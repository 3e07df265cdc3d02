! SPDX-License-Identifier: GPL-3.0-or-later
!> Tree of fronts for a given order of elimination.
!>
!> Block columns that can be eliminated together form one front (a relaxed supernode).  A column is
!> merged into the front of its parent if the time saved (one front less, longer products) exceeds
!> the time spent on the additional stored zeros.  The number of columns of a front is limited,
!> because a sequence of narrower fronts is as fast and needs a smaller panel.
!>
!> References: J. W. H. Liu, SIAM J. Matrix Anal. Appl. 11 (1990) 134 (elimination tree);
!> C. Ashcraft, R. Grimes, ACM TOMS 15 (1989) 291 (relaxed supernodes).
module dda_elimination
   use dda_kinds, only: wp
   use dda_block_graph, only: block_graph_type
   implicit none
   private
   public :: front_tree_type, tree_of_fronts, front_cost

   !> largest number of columns of a front: more save no time (measured with 100,000 blocks)
   integer, parameter :: most_columns = 128

   !> Fronts in postorder: children before parents, each subtree a contiguous range.
   type :: front_tree_type
      integer :: n = 0                   !< number of block rows
      integer :: fronts = 0              !< number of fronts
      integer, allocatable :: order(:)   !< [n] block row of each permuted index
      integer, allocatable :: first(:)   !< [fronts+1] first permuted index of each front
      integer, allocatable :: parent(:)  !< [fronts] front that receives the update; 0 for a root
   end type front_tree_type

   !> Relaxed supernodes, formed from the leaves of the elimination tree upwards.
   !> A cluster is identified by its last column.
   type :: clusters_type
      integer, allocatable :: parent(:)   !< [n] parent in the elimination tree, 0 for a root
      integer, allocatable :: columns(:)  !< [n] columns in the cluster, 0 if merged
      integer, allocatable :: rows(:)     !< [n] rows of the front, with pivot rows
      integer, allocatable :: head(:)     !< [n] first column of the cluster
      integer, allocatable :: next(:)     !< [n] next column in the cluster, else 0
      integer, allocatable :: child(:)    !< [n] first child cluster, else 0
      integer, allocatable :: sibling(:)  !< [n] next child of the parent, else 0
   end type clusters_type

contains

   !> Build the tree of fronts of a graph eliminated in the given order, and refine the order.
   pure subroutine tree_of_fronts(graph, order, tree)
      type(block_graph_type), intent(in) :: graph  !< graph of the block matrix
      integer, intent(in) :: order(graph%n)  !< block row eliminated k-th
      type(front_tree_type), intent(out) :: tree  !< fronts in postorder
      type(clusters_type) :: clusters
      integer, allocatable :: permuted(:)
      integer :: k

      allocate (permuted(graph%n))
      permuted(order) = [(k, k=1, graph%n)]
      allocate (clusters%parent(graph%n), clusters%rows(graph%n))
      call count_rows(graph, order, permuted, clusters%parent, clusters%rows)
      call merge_clusters(graph%n, clusters)
      call number_fronts(graph%n, order, clusters, tree)
   end subroutine tree_of_fronts

   !> Find the elimination tree and the number of blocks in each column of the factor.
   !> Row i of the factor has a nonzero in each column on the tree paths from the neighbours of i to
   !> i.  The last column of each path before i is a child of i.
   pure subroutine count_rows(graph, order, permuted, parent, rows)
      type(block_graph_type), intent(in) :: graph  !< graph of the block matrix
      integer, intent(in) :: order(graph%n), permuted(graph%n)  !< permutation and its inverse
      integer, intent(out) :: parent(graph%n)  !< parent of each column, 0 for a root
      integer, intent(out) :: rows(graph%n)  !< rows in each column
      integer :: mark(graph%n), i, j, e

      parent = 0
      rows = 1
      mark = 0
      do i = 1, graph%n
         mark(i) = i
         do e = graph%start(order(i)), graph%start(order(i) + 1) - 1
            j = permuted(graph%neighbour(e))
            if (j > i) cycle
            do while (mark(j) /= i)
               if (parent(j) == 0) parent(j) = i
               mark(j) = i
               rows(j) = rows(j) + 1
               j = parent(j)
            end do
         end do
      end do
   end subroutine count_rows

   !> Merge child clusters into the columns of their parents if that reduces the cost.
   pure subroutine merge_clusters(n, clusters)
      integer, intent(in) :: n  !< number of block rows
      type(clusters_type), intent(inout) :: clusters  !< clusters; changed by the merger
      integer :: k, child, next_sibling

      allocate (clusters%columns(n), clusters%head(n), clusters%next(n), source=1)
      allocate (clusters%child(n), clusters%sibling(n), source=0)
      clusters%head = [(k, k=1, n)]
      clusters%next = 0
      do k = 1, n
         child = clusters%child(k)
         clusters%child(k) = 0
         do while (child > 0)
            next_sibling = clusters%sibling(child)
            if (is_cheaper_merged(clusters, child, k)) then
               call merge_child(clusters, child, k)
            else
               call add_child(clusters, child, k)
            end if
            child = next_sibling
         end do
         if (clusters%parent(k) > 0) call add_child(clusters, k, clusters%parent(k))
      end do
   end subroutine merge_clusters

   pure logical function is_cheaper_merged(clusters, child, k)
      type(clusters_type), intent(in) :: clusters  !< clusters of the tree
      integer, intent(in) :: child, k  !< clusters by their last columns

      associate (columns => clusters%columns, rows => clusters%rows)
         is_cheaper_merged = columns(child) + columns(k) <= most_columns
         if (.not. is_cheaper_merged) return
         is_cheaper_merged = front_cost(columns(child) + columns(k), columns(child) + rows(k)) &
            <= front_cost(columns(child), rows(child)) + front_cost(columns(k), rows(k))
      end associate
   end function is_cheaper_merged

   !> Return the time for a front (assembly, elimination, update), in units of one 6×6 product.
   pure real(wp) function front_cost(columns, rows)
      integer, intent(in) :: columns  !< block columns to eliminate
      integer, intent(in) :: rows     !< block rows, with pivot rows
      real(wp), parameter :: per_front = 8.0_wp      ! cost of calls and loops
      real(wp), parameter :: per_panel_block = 1.0_wp ! cost to clear, fill and scale
      real(wp), parameter :: per_update_block = 1.5_wp ! cost to write it and add it to the parent
      real(wp) :: c, u

      c = real(columns, wp)
      u = real(rows - columns, wp)
      front_cost = per_front + per_panel_block*c*(u + 0.5_wp*c) + per_update_block*0.5_wp*u*(u &
         + 1.0_wp) + 0.5_wp*c*(u*(u + c) + c*c/3.0_wp)
   end function front_cost

   !> Merge a child into cluster k: its columns come first, and its children become children of k.
   pure subroutine merge_child(clusters, child, k)
      type(clusters_type), intent(inout) :: clusters  !< clusters; changed by the merger
      integer, intent(in) :: child, k  !< clusters by their last columns
      integer :: grandchild, next_sibling

      clusters%next(child) = clusters%head(k)
      clusters%head(k) = clusters%head(child)
      clusters%columns(k) = clusters%columns(k) + clusters%columns(child)
      clusters%rows(k) = clusters%rows(k) + clusters%columns(child)
      clusters%columns(child) = 0
      grandchild = clusters%child(child)
      do while (grandchild > 0)
         next_sibling = clusters%sibling(grandchild)
         call add_child(clusters, grandchild, k)
         grandchild = next_sibling
      end do
   end subroutine merge_child

   !> Make `child` the first child of cluster k.
   pure subroutine add_child(clusters, child, k)
      type(clusters_type), intent(inout) :: clusters  !< clusters; changed by the merger
      integer, intent(in) :: child, k  !< clusters by their last columns

      clusters%sibling(child) = clusters%child(k)
      clusters%child(k) = child
   end subroutine add_child

   !> Number the fronts and list their columns consecutively.
   pure subroutine number_fronts(n, order, clusters, tree)
      integer, intent(in) :: n  !< number of block rows
      integer, intent(in) :: order(n)  !< block row eliminated k-th
      type(clusters_type), intent(in) :: clusters  !< clusters of the tree
      type(front_tree_type), intent(out) :: tree  !< fronts in postorder
      integer, allocatable :: cluster(:)
      integer :: front, k, columns

      tree%n = n
      tree%fronts = count(clusters%columns > 0)
      allocate (tree%order(n), tree%first(tree%fronts + 1), tree%parent(tree%fronts), &
         cluster(tree%fronts))
      call find_postorder(n, clusters, cluster, tree%parent)
      columns = 0
      do front = 1, tree%fronts
         tree%first(front) = columns + 1
         k = clusters%head(cluster(front))
         do while (k > 0)
            columns = columns + 1
            tree%order(columns) = order(k)
            k = clusters%next(k)
         end do
      end do
      tree%first(tree%fronts + 1) = n + 1
   end subroutine number_fronts

   !> Compute a postorder of the clusters, as the reverse of a stack traversal.
   pure subroutine find_postorder(n, clusters, cluster, parent)
      integer, intent(in) :: n  !< number of block rows
      type(clusters_type), intent(in) :: clusters  !< clusters of the tree
      integer, intent(out) :: cluster(:)  !< [fronts] cluster that becomes each front
      integer, intent(out) :: parent(:)   !< [fronts] parent of each front, 0 for a root
      integer :: stack(n), above(n), height, front, k, child

      height = 0
      do k = 1, n
         if (clusters%columns(k) == 0 .or. clusters%parent(k) > 0) cycle
         height = height + 1
         stack(height) = k
         above(k) = 0
      end do
      do front = size(cluster), 1, -1
         k = stack(height)
         height = height - 1
         cluster(front) = k
         parent(front) = above(k)
         child = clusters%child(k)
         do while (child > 0)
            height = height + 1
            stack(height) = child
            above(child) = front
            child = clusters%sibling(child)
         end do
      end do
   end subroutine find_postorder

end module dda_elimination
