!> A step of the open–close iteration that cannot go up.
!>
!> With the friction bounds held, the step's solution is the least of a convex function: inertia,
!> elasticity and loads are quadratic, each contact adds ½ k min(gap, 0)² and a slider whose potential
!> is quadratic up to its bound and linear beyond.  The slope of that function along the way from the
!> last d to the new one grows monotonically; where it crosses zero is where to stop.
module dda_line_search
   use dda_kinds, only: wp
   use dda_assembly, only: system_type
   use dda_contact, only: contacts_type
   use dda_friction, only: laws_type, response_type, law_of, respond
   implicit none
   private
   public :: descend

   integer, parameter :: bisections = 40
   real(wp), parameter :: rounding = 1.0e-10_wp  !< a slope below this share of the curvature is none

contains

   !> Shorten system%d towards system%previous_d if the function turns upwards before; `part` of the way is left.
   !>
   !> On entry the contacts hold gap and slip of the new d.
   subroutine descend(system, contacts, laws, part)
      type(system_type), intent(inout) :: system
      type(contacts_type), intent(in) :: contacts
      type(laws_type), intent(in) :: laws
      real(wp), intent(out) :: part
      real(wp) :: low, high, middle, start, growth
      integer :: i

      call quadratic_slope(system, start, growth)
      part = 1.0_wp
      if (start + growth + contact_slope(system, contacts, laws, 1.0_wp) <= abs(growth)*rounding) return
      low = 0.0_wp
      high = 1.0_wp
      do i = 1, bisections
         middle = 0.5_wp*(low + high)
         if (start + middle*growth + contact_slope(system, contacts, laws, middle) > 0.0_wp) then
            high = middle
         else
            low = middle
         end if
      end do
      part = high
      system%d = system%previous_d + part*(system%d - system%previous_d)
   end subroutine descend

   !> Slope of the quadratic part at the previous d, and how much it grows up to the new one.
   pure subroutine quadratic_slope(system, start, growth)
      type(system_type), intent(in) :: system
      real(wp), intent(out) :: start, growth
      real(wp) :: way(6)
      integer :: b

      start = 0.0_wp
      growth = 0.0_wp
      do b = 1, size(system%d, 2)
         way = system%d(:, b) - system%previous_d(:, b)
         start = start + dot_product(way, matmul(system%base(:, :, b), system%previous_d(:, b)) - system%load(:, b))
         growth = growth + dot_product(way, matmul(system%base(:, :, b), way))
      end do
   end subroutine quadratic_slope

   !> Slope of all contacts a part of the way from the previous d to the new one.
   pure real(wp) function contact_slope(system, contacts, laws, part) result(slope)
      type(system_type), intent(in) :: system
      type(contacts_type), intent(in) :: contacts
      type(laws_type), intent(in) :: laws
      real(wp), intent(in) :: part
      type(response_type) :: response
      real(wp) :: opening, slipping
      integer :: c

      slope = 0.0_wp
      do c = 1, contacts%n
         associate (i => contacts%block_v(c), j => contacts%block_e(c))
            opening = dot_product(contacts%normal_v(:, c), system%d(:, i) - system%previous_d(:, i)) &
               - dot_product(contacts%normal_e(:, c), system%d(:, j) - system%previous_d(:, j))
            slipping = dot_product(contacts%shear_v(:, c), system%d(:, i) - system%previous_d(:, i)) &
               - dot_product(contacts%shear_e(:, c), system%d(:, j) - system%previous_d(:, j))
         end associate
         response = respond(law_of(laws, contacts%joint(c), contacts%bonded(c), contacts%bond_length(c), contacts%pressure(c)), &
            contacts%new_gap(c) - (1.0_wp - part)*opening, contacts%stretch(c) + contacts%slip(c) - (1.0_wp - part)*slipping)
         slope = slope - response%normal_force*opening + response%shear_force*slipping
      end do
   end function contact_slope

end module dda_line_search
