!> Random small systems of two blocks and a few contacts, for the tests of the open–close iteration,
!> with an independent reading of them: energy, gradient, forces.
module systems
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type
   use dda_system, only: prepare_system, set_matrix_pattern, system_type
   use dda_contact, only: contact_open, contacts_type, reserve
   use dda_elements, only: elements_type
   use dda_friction, only: laws_type, set_laws
   use dda_material, only: joint_type
   use dda_neighbours, only: neighbours_type
   use dda_scheme, only: step_type
   use models, only: random, random_vector
   implicit none
   private
   public :: pattern_of, random_system, stiffness, unknowns, flat, gap_row, slip_row, energy, gradient

   real(wp), parameter :: stiffness = 1.0e3_wp
   integer, parameter :: unknowns = 12

contains

   !> A system of n blocks on which no elements act, with the pattern of its near pairs.
   subroutine pattern_of(system, n, near)
      type(system_type), intent(out) :: system
      integer, intent(in) :: n  !< blocks
      type(neighbours_type), intent(in) :: near
      type(blocks_type) :: blocks
      type(elements_type) :: elements

      call prepare_system(system, n)
      blocks%n = n
      allocate (elements%kind(0))
      call set_matrix_pattern(system, blocks, near, elements, step_type())
   end subroutine pattern_of

   subroutine random_system(system, contacts, laws, count, friction_angle)
      type(system_type), intent(out) :: system
      type(contacts_type), intent(out) :: contacts
      type(laws_type), intent(out) :: laws
      integer, intent(in) :: count
      real(wp), intent(in) :: friction_angle
      type(neighbours_type) :: near
      real(wp) :: a(6, 6)
      integer :: b, c, k

      near%n_pairs = 1
      near%pair = reshape([1, 2], [2, 1])
      call pattern_of(system, 2, near)
      do b = 1, 2
         a = reshape(random_vector(36), [6, 6])
         system%linear%diagonal(:, :, b) = 100.0_wp*matmul(a, transpose(a))
         do k = 1, 6
            system%linear%diagonal(k, k, b) = system%linear%diagonal(k, k, b) + 30.0_wp
         end do
         system%load(:, b) = 10.0_wp*random_vector(6)
      end do
      call set_laws(laws, [joint_type('', friction_angle, 0.0_wp, 0.0_wp)], stiffness, 2.5_wp)
      call reserve(contacts, count)
      contacts%n = count
      do c = 1, count
         contacts%block_v(c) = 1 + modulo(c, 2)
         contacts%block_e(c) = 2 - modulo(c, 2)
         contacts%pair(c) = 1
         contacts%joint(c) = 1
         contacts%vertex(c) = c
         contacts%edge(c) = c
         contacts%normal_v(:, c) = random_vector(6)
         contacts%normal_e(:, c) = random_vector(6)
         contacts%shear_v(:, c) = random_vector(6)
         contacts%shear_e(:, c) = random_vector(6)
         contacts%gap(c) = random(-0.05_wp, 0.05_wp)
         contacts%stretch(c) = random(-0.01_wp, 0.01_wp)
         contacts%state(c) = contact_open
      end do
   end subroutine random_system

   pure function flat(d) result(vector)
      real(wp), intent(in) :: d(6, 2)
      real(wp) :: vector(unknowns)

      vector = reshape(d, [unknowns])
   end function flat

   !> ∂gap/∂d of contact c.
   pure function gap_row(contacts, c) result(row)
      type(contacts_type), intent(in) :: contacts
      integer, intent(in) :: c
      real(wp) :: row(unknowns)

      row = placed(contacts%normal_v(:, c), contacts%normal_e(:, c), contacts%block_v(c))
   end function gap_row

   !> ∂slip/∂d of contact c.
   pure function slip_row(contacts, c) result(row)
      type(contacts_type), intent(in) :: contacts
      integer, intent(in) :: c
      real(wp) :: row(unknowns)

      row = placed(contacts%shear_v(:, c), contacts%shear_e(:, c), contacts%block_v(c))
   end function slip_row

   pure function placed(of_vertex, of_edge, block_v) result(row)
      real(wp), intent(in) :: of_vertex(6), of_edge(6)
      integer, intent(in) :: block_v
      real(wp) :: row(unknowns)

      row = [of_vertex, -of_edge]
      if (block_v == 2) row = [-of_edge, of_vertex]
   end function placed

   !> ½ dᵀBd − fᵀd + Σ ½ k min(gap, 0)², without friction.
   pure real(wp) function energy(system, contacts, d)
      type(system_type), intent(in) :: system
      type(contacts_type), intent(in) :: contacts
      real(wp), intent(in) :: d(6, 2)
      integer :: b, c

      energy = 0.0_wp
      do b = 1, 2
         energy = energy + dot_product(d(:, b), 0.5_wp*matmul(system%linear%diagonal(:, :, b), d(:, b)) &
            - system%load(:, b))
      end do
      do c = 1, contacts%n
         energy = energy + 0.5_wp*stiffness*min(0.0_wp, contacts%gap(c) &
            + dot_product(gap_row(contacts, c), flat(d)))**2
      end do
   end function energy

   !> Its gradient.
   pure function gradient(system, contacts, d) result(slope)
      type(system_type), intent(in) :: system
      type(contacts_type), intent(in) :: contacts
      real(wp), intent(in) :: d(6, 2)
      real(wp) :: slope(unknowns)
      integer :: b, c

      do b = 1, 2
         slope(6*b - 5:6*b) = matmul(system%linear%diagonal(:, :, b), d(:, b)) - system%load(:, b)
      end do
      do c = 1, contacts%n
         slope = slope + stiffness*min(0.0_wp, contacts%gap(c) + dot_product(gap_row(contacts, c), &
            flat(d))) *gap_row(contacts, c)
      end do
   end function gradient

end module systems
