!> A step of the open–close iteration that cannot go up.
!>
!> With the friction bounds held, the step's solution is the least of a convex function: inertia,
!> elasticity and loads are quadratic, each contact adds ½ k min(gap, 0)² and a slider whose
!> potential is quadratic up to its bound and linear beyond.  The slope of that function along the
!> way from the last d to the new one grows monotonically; where it crosses zero is where to stop.
module dda_line_search
   use dda_kinds, only: wp
   use dda_system, only: system_type
   use dda_block_matrix, only: multiply_block
   use dda_contact, only: contacts_type
   use dda_friction, only: laws_type, response_type, law_of, respond
   use dda_ordered_sums, only: pieces, first_of, last_of, most_pieces, parallel_from
   implicit none
   private
   public :: descend

   integer, parameter :: most_looks = 40
   !> a slope below this share of the first one is none
   real(wp), parameter :: flat = 1.0e-2_wp
   !> a slope below this share of the curvature is none
   real(wp), parameter :: rounding = 1.0e-10_wp

contains

   !> Shorten system%d towards system%previous_d if the function turns upwards before; `part` of the
   !> way is left.
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
         part = near  ! rounding may leave slopes that are equal or the wrong way round: then halve
         if (up > down) part = near - down*(far - near)/(up - down)
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
      real(wp) :: part(2, most_pieces), total(2)
      integer :: p, n

      n = size(system%d, 2)
      if (n < parallel_from) then
         total = quadratic_of(system, 1, n)
      else
         !$omp parallel do schedule(static)
         do p = 1, pieces(n)
            part(:, p) = quadratic_of(system, first_of(p, n), last_of(p, n))
         end do
         total = sum(part(:, :pieces(n)), 2)
      end if
      start = total(1)
      growth = total(2)
   end subroutine quadratic_slope

   !> Start and growth of some blocks.
   pure function quadratic_of(system, first, last) result(slope)
      type(system_type), intent(in) :: system
      integer, intent(in) :: first, last
      real(wp) :: slope(2), way(6), pull(6)
      integer :: b

      slope = 0.0_wp
      do b = first, last
         way = system%d(:, b) - system%previous_d(:, b)
         call multiply_block(system%base(:, :, b), system%previous_d(:, b), pull)
         slope(1) = slope(1) + dot_product(way, pull - system%load(:, b))
         call multiply_block(system%base(:, :, b), way, pull)
         slope(2) = slope(2) + dot_product(way, pull)
      end do
   end function quadratic_of

   !> How much each contact opens and slips on the way from the previous d to the new one.
   subroutine measure_way(system, contacts)
      type(system_type), intent(in) :: system
      type(contacts_type), intent(inout) :: contacts
      integer :: p

      if (contacts%n < parallel_from) then
         call measure_some_ways(system, contacts, 1, contacts%n)
         return
      end if
      !$omp parallel do schedule(static)
      do p = 1, pieces(contacts%n)
         call measure_some_ways(system, contacts, first_of(p, contacts%n), last_of(p, contacts%n))
      end do
   end subroutine measure_way

   pure subroutine measure_some_ways(system, contacts, first, last)
      type(system_type), intent(in) :: system
      type(contacts_type), intent(inout) :: contacts
      integer, intent(in) :: first, last
      real(wp) :: way_v(6), way_e(6)
      integer :: c

      do c = first, last
         way_v = system%d(:, contacts%block_v(c)) - system%previous_d(:, contacts%block_v(c))
         way_e = system%d(:, contacts%block_e(c)) - system%previous_d(:, contacts%block_e(c))
         contacts%gap_change(c) = dot_product(contacts%normal_v(:, c), way_v) &
            - dot_product(contacts%normal_e(:, c), way_e)
         contacts%slip_change(c) = dot_product(contacts%shear_v(:, c), way_v) &
            - dot_product(contacts%shear_e(:, c), way_e)
      end do
   end subroutine measure_some_ways

   !> Slope of all contacts a part of the way from the previous d to the new one.
   real(wp) function contact_slope(contacts, laws, part) result(slope)
      type(contacts_type), intent(in) :: contacts
      type(laws_type), intent(in) :: laws
      real(wp), intent(in) :: part
      real(wp) :: piece(most_pieces)
      integer :: p

      if (contacts%n < parallel_from) then
         slope = slope_of(contacts, laws, part, 1, contacts%n)
         return
      end if
      !$omp parallel do schedule(static)
      do p = 1, pieces(contacts%n)
         piece(p) = slope_of(contacts, laws, part, first_of(p, contacts%n), last_of(p, contacts%n))
      end do
      slope = sum(piece(:pieces(contacts%n)))
   end function contact_slope

   !> The same of some contacts.
   pure real(wp) function slope_of(contacts, laws, part, first, last) result(slope)
      type(contacts_type), intent(in) :: contacts
      type(laws_type), intent(in) :: laws
      real(wp), intent(in) :: part
      integer, intent(in) :: first, last
      type(response_type) :: response
      integer :: c

      slope = 0.0_wp
      do c = first, last
         response = respond(law_of(laws, contacts%joint(c), contacts%bonded(c), &
            contacts%bond_length(c), contacts%multiplier(c)), contacts%new_gap(c) &
            - (1.0_wp - part)*contacts%gap_change(c), contacts%stretch(c) + contacts%slip(c) &
            - (1.0_wp - part)*contacts%slip_change(c))
         slope = slope - response%normal_force*contacts%gap_change(c) + response%shear_force &
            *contacts%slip_change(c)
      end do
   end function slope_of

end module dda_line_search
