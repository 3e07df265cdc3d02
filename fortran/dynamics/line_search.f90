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
   use dda_ordered_sums, only: pieces, first_of, last_of, parallel_from
   implicit none
   private
   public :: descend

   integer, parameter :: most_looks = 40
   real(wp), parameter :: flat = 1.0e-6_wp        !< a slope below this share of the first one is none
   real(wp), parameter :: rounding = 1.0e-10_wp  !< a slope below this share of the curvature is none

contains

   !> Shorten system%d towards system%previous_d if the function turns upwards before; `part` of the way is left.
   !>
   !> On entry the contacts hold gap and slip of the new d.
   subroutine descend(system, contacts, laws, part)
      type(system_type), intent(inout) :: system
      type(contacts_type), intent(inout) :: contacts
      type(laws_type), intent(in) :: laws
      real(wp), intent(out) :: part
      real(wp) :: start, growth, up, down, far, near, here, first
      integer :: look

      part = 1.0_wp
      call quadratic_slope(system, start, growth)
      call measure_way(system, contacts)
      up = start + growth + contact_slope(contacts, laws, 1.0_wp)
      if (up <= abs(growth)*rounding) return
      down = start + contact_slope(contacts, laws, 0.0_wp)
      first = down
      near = 0.0_wp
      far = 1.0_wp
      ! Regula falsi; halving the slope of an end that stays (Illinois) keeps it from creeping.
      do look = 1, most_looks
         part = near - down*(far - near)/(up - down)
         if (.not. (part > near .and. part < far)) part = 0.5_wp*(near + far)
         here = start + part*growth + contact_slope(contacts, laws, part)
         if (abs(here) <= flat*abs(first)) exit
         if (here > 0.0_wp) then
            far = part
            up = here
            down = 0.5_wp*down
         else
            near = part
            down = here
            up = 0.5_wp*up
         end if
      end do
      system%d = system%previous_d + part*(system%d - system%previous_d)
   end subroutine descend

   !> Slope of the quadratic part at the previous d, and how much it grows up to the new one.
   subroutine quadratic_slope(system, start, growth)
      type(system_type), intent(in) :: system
      real(wp), intent(out) :: start, growth
      real(wp) :: way(6), part(2, pieces(size(system%d, 2))), total(2)
      integer :: p, b

      !$omp parallel do private(way) schedule(static) if (size(system%d, 2) >= parallel_from)
      do p = 1, size(part, 2)
         part(:, p) = 0.0_wp
         do b = first_of(p), last_of(p, size(system%d, 2))
            way = system%d(:, b) - system%previous_d(:, b)
            part(1, p) = part(1, p) &
               + dot_product(way, matmul(system%base(:, :, b), system%previous_d(:, b)) - system%load(:, b))
            part(2, p) = part(2, p) + dot_product(way, matmul(system%base(:, :, b), way))
         end do
      end do
      total = sum(part, 2)
      start = total(1)
      growth = total(2)
   end subroutine quadratic_slope

   !> How much each contact opens and slips on the way from the previous d to the new one.
   subroutine measure_way(system, contacts)
      type(system_type), intent(in) :: system
      type(contacts_type), intent(inout) :: contacts
      real(wp) :: way_v(6), way_e(6)
      integer :: c

      !$omp parallel do private(way_v, way_e) schedule(static) if (contacts%n >= parallel_from)
      do c = 1, contacts%n
         way_v = system%d(:, contacts%block_v(c)) - system%previous_d(:, contacts%block_v(c))
         way_e = system%d(:, contacts%block_e(c)) - system%previous_d(:, contacts%block_e(c))
         contacts%opening(c) = dot_product(contacts%normal_v(:, c), way_v) - dot_product(contacts%normal_e(:, c), way_e)
         contacts%slipping(c) = dot_product(contacts%shear_v(:, c), way_v) - dot_product(contacts%shear_e(:, c), way_e)
      end do
   end subroutine measure_way

   !> Slope of all contacts a part of the way from the previous d to the new one.
   real(wp) function contact_slope(contacts, laws, part) result(slope)
      type(contacts_type), intent(in) :: contacts
      type(laws_type), intent(in) :: laws
      real(wp), intent(in) :: part
      type(response_type) :: response
      real(wp) :: piece(pieces(contacts%n))
      integer :: p, c

      !$omp parallel do private(response) schedule(static) if (contacts%n >= parallel_from)
      do p = 1, size(piece)
         piece(p) = 0.0_wp
         do c = first_of(p), last_of(p, contacts%n)
            response = respond(law_of(laws, contacts%joint(c), contacts%bonded(c), contacts%bond_length(c), &
               contacts%pressure(c)), contacts%new_gap(c) - (1.0_wp - part)*contacts%opening(c), &
               contacts%stretch(c) + contacts%slip(c) - (1.0_wp - part)*contacts%slipping(c))
            piece(p) = piece(p) - response%normal_force*contacts%opening(c) + response%shear_force*contacts%slipping(c)
         end do
      end do
      slope = sum(piece)
   end function contact_slope

end module dda_line_search
