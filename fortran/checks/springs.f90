!> The springs of a linearised model: contact springs and fixed points, as rows and constants.
!>
!> A spring stretches by row_a·x_a − row_b·x_b and has the energy ½ k (stretch)²; a fixed point has
!> no block b.  All springs of a kind have the same constant.
module dda_springs
   use dda_kinds, only: wp
   use dda_block_matrix, only: block_matrix_type, entry_of
   implicit none
   private
   public :: springs_type, reserve_springs, add_spring, stretch_of, add_to_matrix
   public :: spring_normal, spring_shear, spring_fixed, spring_kinds

   integer, parameter :: spring_normal = 1  !< of a closed contact
   integer, parameter :: spring_shear = 2   !< of a sticking contact
   integer, parameter :: spring_fixed = 3   !< of a fixed point, in one direction
   integer, parameter :: spring_kinds = 3

   !> A list of springs; entries 1 … n count.
   type :: springs_type
      integer :: n = 0
      integer, allocatable :: kind(:)      !< one of the three
      integer, allocatable :: source(:)    !< number of the contact or fixed point
      integer, allocatable :: block_a(:)   !< block of the vertex, or of the fixed point
      integer, allocatable :: block_b(:)   !< block of the edge; 0 at a fixed point
      real(wp), allocatable :: row_a(:,:)  !< [6,any]
      real(wp), allocatable :: row_b(:,:)  !< [6,any]
      real(wp), allocatable :: place(:,:)  !< [2,any] m, in the user's coordinates
   end type springs_type

contains

   !> An empty list with room.
   pure subroutine reserve_springs(springs, room)
      type(springs_type), intent(out) :: springs
      integer, intent(in) :: room

      allocate (springs%kind(room), springs%source(room), springs%block_a(room), &
         springs%block_b(room))
      allocate (springs%row_a(6, room), springs%row_b(6, room), springs%place(2, room))
   end subroutine reserve_springs

   !> Append a spring; there must be room.
   pure subroutine add_spring(springs, kind, source, blocks, row_a, row_b, place)
      type(springs_type), intent(inout) :: springs
      integer, intent(in) :: kind, source
      integer, intent(in) :: blocks(2)  !< a and b
      real(wp), intent(in) :: row_a(6), row_b(6), place(2)

      springs%n = springs%n + 1
      associate (i => springs%n)
         springs%kind(i) = kind
         springs%source(i) = source
         springs%block_a(i) = blocks(1)
         springs%block_b(i) = blocks(2)
         springs%row_a(:, i) = row_a
         springs%row_b(:, i) = row_b
         springs%place(:, i) = place
      end associate
   end subroutine add_spring

   !> Stretch of spring i in a motion x of all blocks.
   pure real(wp) function stretch_of(springs, i, x) result(stretch)
      type(springs_type), intent(in) :: springs
      integer, intent(in) :: i
      real(wp), intent(in) :: x(:,:)  !< [6,blocks]

      stretch = dot_product(springs%row_a(:, i), x(:, springs%block_a(i)))
      if (springs%block_b(i) > 0) stretch = stretch - dot_product(springs%row_b(:, i), &
         x(:, springs%block_b(i)))
   end function stretch_of

   !> Add all springs to a stiffness matrix whose pattern holds them.
   pure subroutine add_to_matrix(springs, constants, matrix)
      type(springs_type), intent(in) :: springs
      real(wp), intent(in) :: constants(spring_kinds)  !< N/m per metre of thickness
      type(block_matrix_type), intent(inout) :: matrix
      integer :: i, entry

      do i = 1, springs%n
         associate (a => springs%block_a(i), b => springs%block_b(i), &
            k => constants(springs%kind(i)), row_a => springs%row_a(:, i), &
            row_b => springs%row_b(:, i))
            call add_product(matrix%diagonal(:, :, a), k, row_a, row_a)
            if (b == 0) cycle
            call add_product(matrix%diagonal(:, :, b), k, row_b, row_b)
            entry = entry_of(matrix, a, b)
            if (a > b) then
               call add_product(matrix%lower(:, :, entry), -k, row_a, row_b)
            else
               call add_product(matrix%lower(:, :, entry), -k, row_b, row_a)
            end if
         end associate
      end do
   end subroutine add_to_matrix

   !> block += k a bᵀ
   pure subroutine add_product(block, k, a, b)
      real(wp), intent(inout) :: block(6, 6)
      real(wp), intent(in) :: k, a(6), b(6)
      integer :: column

      do column = 1, 6
         block(:, column) = block(:, column) + (k*b(column))*a
      end do
   end subroutine add_product

end module dda_springs
