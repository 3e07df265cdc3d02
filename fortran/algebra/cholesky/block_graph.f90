! SPDX-License-Identifier: GPL-3.0-or-later
!> Adjacency graph of a symmetric block matrix: each coupling is listed at both of its block rows.
module dda_block_graph
   use dda_block_matrix, only: block_matrix_type
   implicit none
   private
   public :: block_graph_type, graph_of

   !> Undirected graph of block rows, compressed by vertices.
   type :: block_graph_type
      integer :: n = 0                     !< number of vertices (block rows)
      integer, allocatable :: start(:)     !< [n+1] first neighbour of each vertex
      integer, allocatable :: neighbour(:) !< [2 × entries] other row of each coupling, ascending
      integer, allocatable :: entry(:)     !< [2 × entries] lower block of each coupling
   end type block_graph_type

contains

   !> Build the graph of a matrix: the lower entries by rows, then by columns.
   pure subroutine graph_of(matrix, graph, coupled)
      type(block_matrix_type), intent(in) :: matrix  !< matrix; only its pattern is read
      type(block_graph_type), intent(out) :: graph   !< graph of the block rows
      logical, intent(in), optional :: coupled(:)  !< [entries] entries that are used; default: all
      integer :: v, e, middle

      graph%n = matrix%n
      graph%start = matrix%row_start + matrix%below_start - 1
      allocate (graph%neighbour(2*size(matrix%column)), graph%entry(2*size(matrix%column)))
      do v = 1, matrix%n
         middle = matrix%row_start(v + 1) + matrix%below_start(v) - 1
         associate (start => graph%start, row => matrix%row_start, below => matrix%below_start)
            graph%neighbour(start(v):middle - 1) = matrix%column(row(v):row(v + 1) - 1)
            graph%entry(start(v):middle - 1) = [(e, e=row(v), row(v + 1) - 1)]
            graph%neighbour(middle:start(v + 1) - 1) = matrix%below_row(below(v):below(v + 1) - 1)
            graph%entry(middle:start(v + 1) - 1) = matrix%below_entry(below(v):below(v + 1) - 1)
         end associate
      end do
      if (present(coupled)) call drop_uncoupled(coupled, graph)
   end subroutine graph_of

   !> Remove couplings from a graph, such as those of zero blocks.
   pure subroutine drop_uncoupled(coupled, graph)
      logical, intent(in) :: coupled(:)               !< [entries] couplings that remain
      type(block_graph_type), intent(inout) :: graph  !< graph of all couplings
      integer :: v, e, first, retained

      retained = 0
      do v = 1, graph%n
         first = graph%start(v)
         graph%start(v) = retained + 1
         do e = first, graph%start(v + 1) - 1
            if (.not. coupled(graph%entry(e))) cycle
            retained = retained + 1
            graph%neighbour(retained) = graph%neighbour(e)
            graph%entry(retained) = graph%entry(e)
         end do
      end do
      graph%start(graph%n + 1) = retained + 1
      graph%neighbour = graph%neighbour(:retained)
      graph%entry = graph%entry(:retained)
   end subroutine drop_uncoupled

end module dda_block_graph
