! SPDX-License-Identifier: GPL-3.0-or-later
!> The linear part of a model as a sum of rank-one terms c u uᵀ: springs and dashpots between two
!> points.
!>
!> A term acts on row_a·x_a − row_b·x_b of two blocks, or of one block and the ground (block b = 0);
!> the term of a cable also acts on the blocks between its ends.  `instant` selects the variable of
!> the term: stretch at t₀ + θΔt or at the end of the step, mean velocity d/Δt, velocity at the end,
!> or acceleration.  Terms of a closed contact have the same form.
module dda_linear_terms
   use dda_kinds, only: wp
   use dda_block_matrix, only: block_matrix_type, entry_of
   use dda_scheme, only: step_type, mass_weight, momentum_weight
   implicit none
   private
   public :: linear_term_type, linear_terms_type, add_term, reserve_term, set_rows, &
      blocks_in, block_of, get_row, stretch_of, add_to_matrix, add_parallel_terms, add_product, &
      add_products, step_weights, scale_penalty, coupled_blocks
   public :: at_theta, at_end, mean_dashpot, end_dashpot, at_damping, of_mass, instants
   public :: term_normal, term_shear, term_support, term_boundary, term_tie, term_bolt, &
      term_free_side, term_weld, term_point, term_bed, term_water, term_reservoir, term_kinds, &
      term_names, term_labels

   integer, parameter :: at_theta = 1      !< stiffness at t₀ + θΔt
   integer, parameter :: at_end = 2        !< stiffness at the end of the step
   integer, parameter :: mean_dashpot = 3  !< dashpot on d/Δt
   integer, parameter :: end_dashpot = 4   !< dashpot on the velocity at the end of the step
   !> part of K̂ due to damping and material laws, not used in the frequency domain
   integer, parameter :: at_damping = 5
   integer, parameter :: of_mass = 6       !< mass in the direction of the row
   integer, parameter :: instants = 6

   integer, parameter :: term_normal = 1   !< normal spring of a closed contact
   integer, parameter :: term_shear = 2    !< shear spring of a sticking contact
   integer, parameter :: term_support = 3  !< support of a fixed point
   integer, parameter :: term_boundary = 4 !< dashpot of an absorbing boundary
   integer, parameter :: term_tie = 5      !< spring between the two sides of a model
   integer, parameter :: term_bolt = 6     !< spring of a bolt
   integer, parameter :: term_free_side = 7 !< dashpot between a side and the free field
   integer, parameter :: term_weld = 8      !< spring of a welded face of a body
   integer, parameter :: term_point = 9     !< tangent of a strain point minus the elastic one
   integer, parameter :: term_bed = 10      !< spring of a bed
   integer, parameter :: term_water = 11    !< water enclosed at a node of a joint
   integer, parameter :: term_reservoir = 12 !< water that moves with a face
   integer, parameter :: term_kinds = 12
   character(len=*), parameter :: term_names(term_kinds) = [character(len=22) :: &
      'normal contact springs', 'shear contact springs', 'fixed points', 'absorbing boundaries', &
      'ties of the sides', 'bolts', 'free-field sides', 'welded faces', 'strain points', &
      'beds of springs', 'water in joints', 'water of a reservoir']

   character(len=*), parameter :: term_labels(term_kinds) = [character(len=27) :: &
      'the normal contact spring', 'the shear contact spring', 'a fixed point', &
      'a dashpot of the boundary', 'a tie of the sides', 'a bolt', &
      'a dashpot of the free field', 'a welded face', 'a strain point', &
      'a spring of a bed', 'water in a joint', 'water of a reservoir']

   !> One term.
   type :: linear_term_type
      integer :: kind = term_support        !< term_normal …
      integer :: instant = at_end           !< at_theta …
      integer :: source = 0                 !< number of the contact, or of the element in its kind
      integer :: block_a = 0                !< first block
      integer :: block_b = 0                !< second block; 0: the ground
      integer :: motion(2) = 0              !< motions of the ground in x and y; 0: fixed
      logical :: damped = .false.           !< a dashpot prevents ringing
      logical :: of_penalty = .false.       !< proportional to the normal stiffness k_n
      !> fractions damped by the materials of blocks a and b
      real(wp) :: damped_fraction(2) = 0.0_wp
      real(wp) :: coefficient = 0.0_wp      !< c, N/m, N s/m or kg per metre of thickness
      real(wp) :: row_a(6) = 0.0_wp         !< part of u for block a
      real(wp) :: row_b(6) = 0.0_wp         !< part of −u for block b
      integer, allocatable :: further_block(:)    !< other blocks of a cable
      real(wp), allocatable :: further_row(:,:)  !< [6,further] parts of u
      real(wp) :: position(2) = 0.0_wp         !< position in the coordinates of the engine, m
   end type linear_term_type

   !> A list of terms; entries 1 … n are used.
   type :: linear_terms_type
      integer :: n = 0
      type(linear_term_type), allocatable :: term(:)
   end type linear_terms_type

contains

   !> Append a term.
   pure subroutine add_term(terms, term)
      type(linear_terms_type), intent(inout) :: terms  !< springs and dashpots
      type(linear_term_type), intent(in) :: term  !< term

      call reserve_term(terms)
      terms%term(terms%n) = term
   end subroutine add_term

   !> Lengthen the list by one term; the term retains its earlier values and memory.
   pure subroutine reserve_term(terms)
      type(linear_terms_type), intent(inout) :: terms  !< springs and dashpots

      terms%n = terms%n + 1
      if (.not. allocated(terms%term)) allocate (terms%term(16))
      if (size(terms%term) < terms%n) call double_memory(terms)
   end subroutine reserve_term

   !> Double the memory of the list.
   pure subroutine double_memory(terms)
      type(linear_terms_type), intent(inout) :: terms  !< springs and dashpots
      type(linear_term_type), allocatable :: longer(:)

      allocate (longer(2*size(terms%term)))
      longer(:size(terms%term)) = terms%term
      call move_alloc(longer, terms%term)
   end subroutine double_memory

   !> Set the blocks and the vector u of a term of two or more points.
   !> Rows of points of the same block are added.
   pure subroutine set_rows(term, block, row)
      type(linear_term_type), intent(inout) :: term  !< term
      integer, intent(in) :: block(:)   !< [points] blocks, not all the same
      real(wp), intent(in) :: row(:,:)  !< [6,points] rows of u
      integer :: first(size(block)), n, k

      n = 0
      do k = 1, size(block)
         if (findloc(block, block(k), 1) < k) cycle
         n = n + 1
         first(n) = k
      end do
      term%block_a = block(first(1))
      term%block_b = block(first(2))
      term%row_a = sum_of_rows(first(1))
      term%row_b = -sum_of_rows(first(2))
      if (n == 2) return
      term%further_block = block(first(3:n))
      term%further_row = reshape([(sum_of_rows(first(k)), k=3, n)], [6, n - 2])

   contains

      !> Sum of the rows of the points of a block.
      pure function sum_of_rows(k) result(sum)
         integer, intent(in) :: k  !< first point of the block
         real(wp) :: sum(6)
         integer :: j

         sum = row(:, k)
         do j = k + 1, size(block)
            if (block(j) == block(k)) sum = sum + row(:, j)
         end do
      end function sum_of_rows
   end subroutine set_rows

   !> Return the number of blocks that a term acts on.
   pure integer function blocks_in(term) result(n)
      type(linear_term_type), intent(in) :: term  !< term

      n = merge(1, 2, term%block_b == 0)
      if (allocated(term%further_block)) n = n + size(term%further_block)
   end function blocks_in

   !> Return the number of the k-th block of a term.
   pure integer function block_of(term, k) result(block)
      type(linear_term_type), intent(in) :: term  !< term
      integer, intent(in) :: k          !< 1 … `blocks_in`

      select case (k)
      case (1)
         block = term%block_a
      case (2)
         block = term%block_b
      case default
         block = term%further_block(k - 2)
      end select
   end function block_of

   !> Find the k-th block of a term, and its part of u.
   pure subroutine get_row(term, k, block, row)
      type(linear_term_type), intent(in) :: term  !< term
      integer, intent(in) :: k          !< 1 … `blocks_in`
      integer, intent(out) :: block     !< number of the block
      real(wp), intent(out) :: row(6)   !< part of u

      block = block_of(term, k)
      select case (k)
      case (1)
         row = term%row_a
      case (2)
         row = -term%row_b
      case default
         row = term%further_row(:, k - 2)
      end select
   end subroutine get_row

   !> Return the factors of the terms in K̂, by instant: θ, 1, 1/Δt, 1/(χΔt), 1, 1/(χΔt²).
   pure function step_weights(step) result(weights)
      type(step_type), intent(in) :: step  !< the present step
      real(wp) :: weights(instants)  !< 1, 1, 1/s, 1/s, 1, 1/s²

      weights = [step%scheme%theta, 1.0_wp, 1.0_wp/step%time_step, momentum_weight(step), 1.0_wp, &
         mass_weight(step)]
   end function step_weights

   !> Return the extension u·x of a term in a motion x of all blocks.
   pure real(wp) function stretch_of(term, x) result(stretch)
      type(linear_term_type), intent(in) :: term  !< term
      real(wp), intent(in) :: x(:,:)  !< [6,blocks]
      real(wp) :: row(6)
      integer :: k, b

      stretch = 0.0_wp
      do k = 1, blocks_in(term)
         call get_row(term, k, b, row)
         stretch = stretch + dot_product(row, x(:, b))
      end do
   end function stretch_of

   !> Scale all terms that are proportional to the penalty.
   pure subroutine scale_penalty(terms, ratio)
      type(linear_terms_type), intent(inout) :: terms  !< springs and dashpots
      real(wp), intent(in) :: ratio  !< new k_n over old k_n
      integer :: i

      do i = 1, terms%n
         if (terms%term(i)%of_penalty) terms%term(i)%coefficient = ratio*terms%term(i)%coefficient
      end do
   end subroutine scale_penalty

   !> List the pairs of blocks that terms couple, once for consecutive terms with the same pair.
   pure function coupled_blocks(terms) result(pairs)
      type(linear_terms_type), intent(in) :: terms  !< springs and dashpots
      integer, allocatable :: pairs(:,:)  !< [2,any]
      integer :: i, j, k, count

      count = 0
      do i = 1, terms%n
         if (.not. repeats_blocks(terms, i)) count = count &
            + blocks_in(terms%term(i))*(blocks_in(terms%term(i)) - 1)/2
      end do
      allocate (pairs(2, count))
      count = 0
      do i = 1, terms%n
         if (repeats_blocks(terms, i)) cycle
         do j = 2, blocks_in(terms%term(i))
            do k = 1, j - 1
               count = count + 1
               pairs(:, count) = [block_of(terms%term(i), k), block_of(terms%term(i), j)]
            end do
         end do
      end do
   end function coupled_blocks

   !> .true. if term i acts on the same blocks as the term before it.
   pure logical function repeats_blocks(terms, i)
      type(linear_terms_type), intent(in) :: terms  !< springs and dashpots
      integer, intent(in) :: i  !< number of the term
      integer :: k

      repeats_blocks = .false.
      if (i == 1) return
      associate (term => terms%term(i), before => terms%term(i - 1))
         if (blocks_in(term) /= blocks_in(before)) return
         do k = 1, blocks_in(term)
            if (block_of(term, k) /= block_of(before, k)) return
         end do
      end associate
      repeats_blocks = .true.
   end function repeats_blocks

   !> Add weight × c u uᵀ of all terms to a matrix.  The sum is incomplete if its pattern lacks a
   !> pair of their blocks.
   !>
   !> The position in the matrix is searched only once for the consecutive springs of a welded face.
   pure subroutine add_to_matrix(terms, weights, matrix, fits)
      type(linear_terms_type), intent(in) :: terms  !< springs and dashpots
      real(wp), intent(in) :: weights(instants)  !< weight by instant; 0: omit the term
      type(block_matrix_type), intent(inout) :: matrix  !< block matrix
      logical, intent(out) :: fits  !< .false.: the pattern lacks pairs, and the sum is incomplete
      real(wp) :: c
      integer :: i, pair(2), entry

      fits = .true.
      pair = 0
      do i = 1, terms%n
         associate (term => terms%term(i))
            c = weights(term%instant)*term%coefficient
            if (.not. abs(c) > 0.0_wp) cycle
            call add_product(matrix%diagonal(:, :, term%block_a), c, term%row_a, term%row_a)
            if (term%block_b == 0) cycle
            if (pair(1) /= term%block_a .or. pair(2) /= term%block_b) then
               pair = [term%block_a, term%block_b]
               entry = entry_of(matrix, pair(1), pair(2))
            end if
            call add_product(matrix%diagonal(:, :, pair(2)), c, term%row_b, term%row_b)
            call add_coupling(matrix, entry, pair, -c, term%row_a, term%row_b, fits)
            if (allocated(term%further_block)) call add_further(term, c, size(term%further_block), &
               term%further_block, term%further_row, matrix, fits)
         end associate
         if (.not. fits) return
      end do
   end subroutine add_to_matrix

   !> Add the part of c u uᵀ that acts on the further blocks of a term.
   pure subroutine add_further(term, c, n, block, row, matrix, fits)
      type(linear_term_type), intent(in) :: term  !< term with further blocks
      real(wp), intent(in) :: c  !< factor, N/m per metre of thickness
      integer, intent(in) :: n, block(n)  !< further blocks
      real(wp), intent(in) :: row(6, n)   !< their parts of u
      type(block_matrix_type), intent(inout) :: matrix  !< block matrix
      logical, intent(inout) :: fits  !< set to .false. if the pattern lacks a pair
      integer :: j, k

      do j = 1, n
         call add_product(matrix%diagonal(:, :, block(j)), c, row(:, j), row(:, j))
         call add_coupling(matrix, entry_of(matrix, term%block_a, block(j)), &
            [term%block_a, block(j)], c, term%row_a, row(:, j), fits)
         call add_coupling(matrix, entry_of(matrix, term%block_b, block(j)), &
            [term%block_b, block(j)], -c, term%row_b, row(:, j), fits)
         do k = 1, j - 1
            call add_coupling(matrix, entry_of(matrix, block(k), block(j)), [block(k), block(j)], &
               c, row(:, k), row(:, j), fits)
         end do
      end do
   end subroutine add_further

   !> Add the terms c u uᵀ between the same n blocks to a matrix, unless its pattern lacks a pair.
   pure subroutine add_parallel_terms(terms, n, c, block, row, matrix, fits)
      integer, intent(in) :: terms, n           !< numbers of terms and of blocks
      real(wp), intent(in) :: c(terms)          !< coefficients
      integer, intent(in) :: block(n)           !< blocks of each term
      real(wp), intent(in) :: row(6, n, terms)  !< parts of u
      type(block_matrix_type), intent(inout) :: matrix  !< block matrix
      logical, intent(inout) :: fits  !< set to .false. if the pattern lacks a pair
      integer :: j, k, entry

      do j = 1, n
         call add_sum(matrix%diagonal(:, :, block(j)), j, j)
         do k = 1, j - 1
            entry = entry_of(matrix, block(j), block(k))
            fits = fits .and. entry > 0
            if (.not. fits) return
            if (block(j) > block(k)) call add_sum(matrix%lower(:, :, entry), j, k)
            if (block(j) < block(k)) call add_sum(matrix%lower(:, :, entry), k, j)
         end do
      end do

   contains

      !> Add the sum of c a bᵀ to a block, two terms at once; a and b are two parts of u.
      pure subroutine add_sum(values, of_row, of_column)
         real(wp), intent(inout) :: values(6, 6)  !< block of the matrix
         integer, intent(in) :: of_row, of_column  !< numbers of the parts, 1 … n
         integer :: i

         do i = 1, terms - 1, 2
            call add_products(values, row(:, of_row, i), row(:, of_column, i), c(i), &
               row(:, of_row, i + 1), row(:, of_column, i + 1), c(i + 1))
         end do
         if (modulo(terms, 2) == 1) call add_products(values, row(:, of_row, terms), &
            row(:, of_column, terms), c(terms), row(:, of_row, terms), row(:, of_column, terms), &
            0.0_wp)
      end subroutine add_sum
   end subroutine add_parallel_terms

   !> Add c a bᵀ to the lower block of a pair of blocks.
   pure subroutine add_coupling(matrix, entry, pair, c, a, b, fits)
      type(block_matrix_type), intent(inout) :: matrix  !< block matrix
      integer, intent(in) :: entry  !< number of the lower block; 0: the pattern lacks it
      integer, intent(in) :: pair(2)  !< blocks of the rows a and b
      real(wp), intent(in) :: c  !< factor, N/m per metre of thickness
      real(wp), intent(in) :: a(6), b(6)  !< rows of the two blocks
      logical, intent(inout) :: fits  !< set to .false. if the pattern lacks the pair

      if (entry == 0) then
         fits = .false.
      else if (pair(1) > pair(2)) then
         call add_product(matrix%lower(:, :, entry), c, a, b)
      else
         call add_product(matrix%lower(:, :, entry), c, b, a)
      end if
   end subroutine add_coupling

   !> Add the product: block += c a bᵀ.
   pure subroutine add_product(block, c, a, b)
      real(wp), intent(inout) :: block(6, 6)  !< 6×6 block of a matrix
      real(wp), intent(in) :: c  !< factor, N/m per metre of thickness
      real(wp), intent(in) :: a(6), b(6)  !< rows of the two blocks
      real(wp) :: scaled_row(6)
      integer :: row

      scaled_row = c*b
      do row = 1, 6  ! 30 % less time than a loop over columns
         block(row, :) = block(row, :) + scaled_row*a(row)
      end do
   end subroutine add_product

   !> Add products: block += k₁ a₁b₁ᵀ + k₂ a₂b₂ᵀ.
   !>
   !> Loops over four and two rows map to vector registers; unrolled loops would be slower because
   !> of rearrangements.
   pure subroutine add_products(block, a1, b1, k1, a2, b2, k2)
      real(wp), intent(inout) :: block(6, 6)  !< 6×6 block of a matrix
      real(wp), intent(in) :: a1(6), b1(6), k1, a2(6), b2(6), k2  !< rows of blocks; factors, N/m
      integer :: column, row

      do column = 1, 6
         !GCC$ unroll 1
         do row = 1, 4
            block(row, column) = block(row, column) + (k1*b1(column))*a1(row) &
               + (k2*b2(column))*a2(row)
         end do
         !GCC$ unroll 1
         do row = 5, 6
            block(row, column) = block(row, column) + (k1*b1(column))*a1(row) &
               + (k2*b2(column))*a2(row)
         end do
      end do
   end subroutine add_products

end module dda_linear_terms
