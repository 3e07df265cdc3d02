! SPDX-License-Identifier: GPL-3.0-or-later
!> The linear part of a model as a sum of rank-one terms c u uᵀ: springs and dashpots between two
!> points.
!>
!> A term acts on row_a·x_a − row_b·x_b of two blocks, or of one block and the ground (block b = 0).
!> Its instant says on what: on the stretch at t₀ + θΔt or at the end of the step, on the mean
!> velocity d/Δt or on the velocity at the end.  What a closed contact gives has the same form.
module dda_linear_terms
   use dda_kinds, only: wp
   use dda_block_matrix, only: block_matrix_type, entry_of
   use dda_scheme, only: step_type, momentum_weight
   implicit none
   private
   public :: linear_term_type, linear_terms_type, clear_terms, add_term, stretch_of, &
      add_to_matrix, add_product, step_weights, scale_penalty, coupled_blocks
   public :: at_theta, at_end, mean_dashpot, end_dashpot, instants
   public :: term_normal, term_shear, term_support, term_boundary, term_tie, term_bolt, &
      term_free_side, term_kinds, term_names

   integer, parameter :: at_theta = 1      !< stiffness at t₀ + θΔt
   integer, parameter :: at_end = 2        !< stiffness at the end of the step
   integer, parameter :: mean_dashpot = 3  !< dashpot on d/Δt
   integer, parameter :: end_dashpot = 4   !< dashpot on the velocity at the end of the step
   integer, parameter :: instants = 4

   integer, parameter :: term_normal = 1   !< normal spring of a closed contact
   integer, parameter :: term_shear = 2    !< shear spring of a sticking contact
   integer, parameter :: term_support = 3  !< support of a fixed point
   integer, parameter :: term_boundary = 4 !< dashpot of an absorbing boundary
   integer, parameter :: term_tie = 5      !< spring between the two sides of a model
   integer, parameter :: term_bolt = 6     !< spring of a bolt
   integer, parameter :: term_free_side = 7 !< dashpot between a side and its free field
   integer, parameter :: term_kinds = 7
   character(len=*), parameter :: term_names(term_kinds) = [character(len=22) :: &
      'normal contact springs', 'shear contact springs', 'fixed points', 'absorbing boundaries', &
      'ties of the sides', 'bolts', 'free-field sides']

   !> One term.
   type :: linear_term_type
      integer :: kind = term_support        !< term_normal …
      integer :: instant = at_end           !< at_theta …
      integer :: source = 0                 !< number of the contact or element of that kind
      integer :: block_a = 0                !< first block
      integer :: block_b = 0                !< second block; 0: the ground
      integer :: motion = 0                 !< that the ground follows; 0: it stays
      logical :: damped = .false.           !< a dashpot keeps it from ringing
      logical :: of_penalty = .false.       !< in proportion to the normal stiffness k_n
      real(wp) :: coefficient = 0.0_wp      !< c, N/m or N s/m per metre of thickness
      real(wp) :: row_a(6) = 0.0_wp         !< of u
      real(wp) :: row_b(6) = 0.0_wp         !< of −u
      real(wp) :: place(2) = 0.0_wp         !< m, in the coordinates of the engine
   end type linear_term_type

   !> A list of terms; entries 1 … n count.
   type :: linear_terms_type
      integer :: n = 0
      type(linear_term_type), allocatable :: term(:)
   end type linear_terms_type

contains

   !> Empty the list; its memory stays.
   pure subroutine clear_terms(terms)
      type(linear_terms_type), intent(inout) :: terms  !< springs and dashpots

      terms%n = 0
   end subroutine clear_terms

   !> Append a term.
   pure subroutine add_term(terms, term)
      type(linear_terms_type), intent(inout) :: terms  !< springs and dashpots
      type(linear_term_type), intent(in) :: term  !< one of the list

      terms%n = terms%n + 1
      if (.not. allocated(terms%term)) allocate (terms%term(16))
      if (size(terms%term) < terms%n) call widen(terms)
      terms%term(terms%n) = term
   end subroutine add_term

   pure subroutine widen(terms)
      type(linear_terms_type), intent(inout) :: terms  !< springs and dashpots
      type(linear_term_type), allocatable :: more(:)

      allocate (more(2*size(terms%term)))
      more(:size(terms%term)) = terms%term
      call move_alloc(more, terms%term)
   end subroutine widen

   !> Factor of a term of each instant in K̂: θ, 1, 1/Δt, 1/(χΔt).
   pure function step_weights(step) result(weights)
      type(step_type), intent(in) :: step  !< the one being taken
      real(wp) :: weights(instants)  !< 1, 1, 1/s, 1/s

      weights = [step%scheme%theta, 1.0_wp, 1.0_wp/step%time_step, momentum_weight(step)]
   end function step_weights

   !> u·x of a term in a motion x of all blocks.
   pure real(wp) function stretch_of(term, x) result(stretch)
      type(linear_term_type), intent(in) :: term  !< one of the list
      real(wp), intent(in) :: x(:,:)  !< [6,blocks]

      stretch = dot_product(term%row_a, x(:, term%block_a))
      if (term%block_b > 0) stretch = stretch - dot_product(term%row_b, x(:, term%block_b))
   end function stretch_of

   !> Give all terms in proportion to the penalty another one.
   pure subroutine scale_penalty(terms, ratio)
      type(linear_terms_type), intent(inout) :: terms  !< springs and dashpots
      real(wp), intent(in) :: ratio  !< new k_n over old
      integer :: i

      do i = 1, terms%n
         if (terms%term(i)%of_penalty) terms%term(i)%coefficient = ratio*terms%term(i)%coefficient
      end do
   end subroutine scale_penalty

   !> Pairs of blocks that terms couple; they may repeat.
   pure function coupled_blocks(terms) result(pairs)
      type(linear_terms_type), intent(in) :: terms  !< springs and dashpots
      integer, allocatable :: pairs(:,:)  !< [2,any]
      integer :: i, count

      allocate (pairs(2, terms%n))
      count = 0
      do i = 1, terms%n
         if (terms%term(i)%block_b == 0) cycle
         count = count + 1
         pairs(:, count) = [terms%term(i)%block_a, terms%term(i)%block_b]
      end do
      pairs = pairs(:, :count)
   end function coupled_blocks

   !> Add weight × c u uᵀ of all terms to a matrix whose pattern holds them.
   pure subroutine add_to_matrix(terms, weights, matrix)
      type(linear_terms_type), intent(in) :: terms  !< springs and dashpots
      real(wp), intent(in) :: weights(instants)  !< by the instant of a term; 0 leaves it out
      type(block_matrix_type), intent(inout) :: matrix  !< block matrix
      integer :: i, entry
      real(wp) :: c

      do i = 1, terms%n
         associate (term => terms%term(i))
            c = weights(term%instant)*term%coefficient
            if (.not. abs(c) > 0.0_wp) cycle
            associate (a => term%block_a, b => term%block_b)
               call add_product(matrix%diagonal(:, :, a), c, term%row_a, term%row_a)
               if (b == 0) cycle
               call add_product(matrix%diagonal(:, :, b), c, term%row_b, term%row_b)
               entry = entry_of(matrix, a, b)
               if (a > b) then
                  call add_product(matrix%lower(:, :, entry), -c, term%row_a, term%row_b)
               else
                  call add_product(matrix%lower(:, :, entry), -c, term%row_b, term%row_a)
               end if
            end associate
         end associate
      end do
   end subroutine add_to_matrix

   !> block += c a bᵀ
   pure subroutine add_product(block, c, a, b)
      real(wp), intent(inout) :: block(6, 6)  !< 6×6 block of a matrix
      real(wp), intent(in) :: c  !< factor, N/m per metre of thickness
      real(wp), intent(in) :: a(6), b(6)  !< rows of the two blocks
      integer :: column

      do column = 1, 6
         block(:, column) = block(:, column) + (c*b(column))*a
      end do
   end subroutine add_product

end module dda_linear_terms
