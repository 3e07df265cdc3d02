!> The graph of a symmetric block matrix: who is coupled to whom, seen from both sides.
module dda_block_graph
   implicit none
   private
   public :: block_graph_type, graph_of

   !> Undirected graph of block rows, compressed by vertices.
   type :: block_graph_type
      integer :: n = 0                     !< vertices: block rows
      integer, allocatable :: start(:)     !< [n+1] first neighbour of each vertex
      integer, allocatable :: neighbour(:) !< [2 entries] the other end of each coupling
      integer, allocatable :: entry(:)     !< [2 entries] which lower block couples them
   end type block_graph_type

contains

   !> Both directions of the strictly lower pattern.
   pure subroutine graph_of(n, row_start, column, graph)
      integer, intent(in) :: n               !< block rows
      integer, intent(in) :: row_start(n + 1) !< first lower entry of each row
      integer, intent(in) :: column(:)       !< [entries] column < row
      type(block_graph_type), intent(out) :: graph  !< with every coupling seen from both ends
      integer :: next(n), row, e

      graph%n = n
      allocate (graph%neighbour(2*size(column)), graph%entry(2*size(column)))
      call count_neighbours(n, row_start, column, graph%start)
      next = graph%start(:n)
      do row = 1, n
         do e = row_start(row), row_start(row + 1) - 1
            call add_neighbour(graph, next, row, column(e), e)
            call add_neighbour(graph, next, column(e), row, e)
         end do
      end do
   end subroutine graph_of

   pure subroutine add_neighbour(graph, next, vertex, other, entry)
      type(block_graph_type), intent(inout) :: graph  !< being filled
      integer, intent(inout) :: next(:)  !< [n] where each vertex's next neighbour goes
      integer, intent(in) :: vertex, other, entry  !< two coupled block rows and their lower block

      graph%neighbour(next(vertex)) = other
      graph%entry(next(vertex)) = entry
      next(vertex) = next(vertex) + 1
   end subroutine add_neighbour

   !> Where each vertex's neighbours begin.
   pure subroutine count_neighbours(n, row_start, column, start)
      integer, intent(in) :: n  !< block rows
      integer, intent(in) :: row_start(n + 1), column(:)  !< lower pattern, as in `graph_of`
      integer, allocatable, intent(out) :: start(:)  !< [n+1] first neighbour of each vertex
      integer :: v, e

      allocate (start(n + 1), source=0)
      do v = 1, n
         start(v + 1) = row_start(v + 1) - row_start(v)
      end do
      do e = 1, size(column)
         start(column(e) + 1) = start(column(e) + 1) + 1
      end do
      start(1) = 1
      do v = 1, n
         start(v + 1) = start(v) + start(v + 1)
      end do
   end subroutine count_neighbours

end module dda_block_graph
