! SPDX-License-Identifier: GPL-3.0-or-later
!> The order in which block rows are eliminated.
!>
!> The graph of blocks gives the fill of the graph of scalars, with a sixth of its vertices.
!> Minimum degree is better for small walls.  Nested dissection is better for large walls, and its
!> tree balances threads better.  All orders are deterministic.
!>
!> References: P. R. Amestoy, T. A. Davis, I. S. Duff, ACM TOMS 30 (2004) 381, algorithm 837 (AMD);
!> G. Karypis, V. Kumar, SIAM J. Sci. Comput. 20 (1998) 359 (METIS);
!> A. George, J. W. H. Liu, ACM TOMS 5 (1979) 284 (start vertex of Cuthill–McKee).
module dda_ordering
   use, intrinsic :: iso_c_binding, only: c_double, c_int, c_int32_t, c_null_ptr, c_ptr
   use dda_kinds, only: wp
   use dda_block_graph, only: block_graph_type
   use dda_sorting, only: ascending_order
   implicit none
   private
   public :: fill_order, bandwidth_order, minimum_degree_order, dissection_order

   !> smallest number of blocks for which nested dissection saves more time than it costs
   integer, parameter :: dissection_from = 20000

   interface
      !> SuiteSparse: approximate minimum degree; 0-based indices; returns 0 or 1 on success.
      integer(c_int) function amd_order(n, start, index, order, control, info) &
         bind(c, name='amd_order')
         import :: c_int, c_ptr, c_double
         integer(c_int), value :: n  !< vertices
         integer(c_int), intent(in) :: start(*), index(*)  !< [n+1], [any] neighbours
         integer(c_int), intent(out) :: order(*)  !< [n]
         type(c_ptr), value :: control  !< null: defaults
         real(c_double), intent(out) :: info(*)  !< [20] statistics
      end function amd_order

      !> METIS 5: nested dissection; 0-based indices; returns 1 on success.
      integer(c_int) function metis_node_nd(n, start, index, weight, options, order, permuted) &
         bind(c, name='METIS_NodeND')
         import :: c_int, c_int32_t, c_ptr
         integer(c_int32_t), intent(in) :: n  !< vertices
         integer(c_int32_t), intent(in) :: start(*), index(*)  !< [n+1], [any] neighbours
         type(c_ptr), value :: weight, options  !< null: no weights, default options
         !> [n] permutation and its inverse
         integer(c_int32_t), intent(out) :: order(*), permuted(*)
      end function metis_node_nd
   end interface

contains

   !> Find an order of elimination with little fill: order(k) is the block row eliminated k-th.
   subroutine fill_order(graph, order)
      type(block_graph_type), intent(in) :: graph  !< graph of the block matrix
      integer, allocatable, intent(out) :: order(:)  !< [n] block row eliminated k-th
      logical :: success

      if (graph%n >= dissection_from .and. size(graph%neighbour) >= graph%n) then
         call dissection_order(graph, order, success)
      else
         call minimum_degree_order(graph, order, success)
      end if
      if (.not. success) call bandwidth_order(graph, order)
   end subroutine fill_order

   !> Find the approximate minimum degree order.
   subroutine minimum_degree_order(graph, order, success)
      type(block_graph_type), intent(in) :: graph  !< graph of the block matrix
      integer, allocatable, intent(out) :: order(:)  !< [n] block row eliminated k-th
      logical, intent(out) :: success !< .false.: the library lacks memory
      real(c_double) :: info(20)

      allocate (order(graph%n))
      success = amd_order(int(graph%n, c_int), graph%start - 1, graph%neighbour - 1, order, &
                       c_null_ptr, info) >= 0
      order = order + 1
   end subroutine minimum_degree_order

   !> Find the nested dissection order.
   subroutine dissection_order(graph, order, success)
      type(block_graph_type), intent(in) :: graph  !< graph of the block matrix
      integer, allocatable, intent(out) :: order(:)  !< [n] block row eliminated k-th
      logical, intent(out) :: success !< .false.: the library lacks memory
      integer(c_int32_t), allocatable :: permuted(:)

      allocate (order(graph%n), permuted(graph%n))
      success = metis_node_nd(int(graph%n, c_int32_t), graph%start - 1, graph%neighbour - 1, &
         c_null_ptr, c_null_ptr, order, permuted) == 1
      order = order + 1
   end subroutine dissection_order

   !> Find the reverse Cuthill–McKee order, one connected component after the other.
   pure subroutine bandwidth_order(graph, order)
      type(block_graph_type), intent(in) :: graph  !< graph of the block matrix
      integer, allocatable, intent(out) :: order(:)  !< [n] block row eliminated k-th
      integer, allocatable :: list(:), mark(:)
      integer :: v, n, last_level

      allocate (list(graph%n), mark(graph%n))
      mark = 0
      n = 0
      do v = 1, graph%n
         if (mark(v) > 0) cycle
         call append_connected(graph, peripheral_vertex(graph, v), mark, list, n, last_level)
      end do
      allocate (order(graph%n))
      order = list(graph%n:1:-1)
   end subroutine bandwidth_order

   !> Find a peripheral vertex of the component of v: a start vertex with many levels of few
   !> vertices.
   pure integer function peripheral_vertex(graph, v)
      type(block_graph_type), intent(in) :: graph  !< graph of the block matrix
      integer, intent(in) :: v  !< number of the vertex
      integer, allocatable :: list(:), mark(:)
      integer :: candidate, depth, deepest, n, last_level

      allocate (list(graph%n), mark(graph%n))
      candidate = v
      peripheral_vertex = v
      deepest = 0
      do
         mark = 0
         n = 0
         call append_connected(graph, candidate, mark, list, n, last_level)
         depth = mark(list(n))
         if (depth <= deepest) exit
         deepest = depth
         peripheral_vertex = candidate
         associate (last => list(last_level:n))
            candidate = last(minloc(degree(graph, last), 1))
         end associate
      end do
   end function peripheral_vertex

   !> Append all vertices connected to a vertex, level by level, in ascending degree.
   pure subroutine append_connected(graph, from, mark, list, n, last_level)
      type(block_graph_type), intent(in) :: graph  !< graph of the block matrix
      integer, intent(in) :: from  !< number of the vertex
      integer, intent(inout) :: mark(:)    !< [n] level of each vertex, 1 for `from`; 0: not reached
      integer, intent(inout) :: list(:)    !< [n] vertices found
      integer, intent(inout) :: n     !< number of vertices found
      integer, intent(out) :: last_level   !< position of the last level in the list
      integer :: head, v, w, e, start

      head = n + 1
      n = head
      last_level = head
      list(n) = from
      mark(from) = 1
      do while (head <= n)
         v = list(head)
         if (mark(v) > mark(list(last_level))) last_level = head
         start = n + 1
         do e = graph%start(v), graph%start(v + 1) - 1
            w = graph%neighbour(e)
            if (mark(w) > 0) cycle
            n = n + 1
            list(n) = w
            mark(w) = mark(v) + 1
         end do
         associate (met => list(start:n))
            met = met(ascending_order(real(degree(graph, met), wp)))
         end associate
         head = head + 1
      end do
   end subroutine append_connected

   !> Return the number of couplings of a block row.
   elemental integer function degree(graph, v)
      type(block_graph_type), intent(in) :: graph  !< graph of the block matrix
      integer, intent(in) :: v  !< number of the vertex

      degree = graph%start(v + 1) - graph%start(v)
   end function degree

end module dda_ordering
