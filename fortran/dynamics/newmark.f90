!> Newmark β = ½, γ = 1: "constant acceleration" in DDA's usage (paper eq. 5).
module dda_newmark
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type, update_geometry
   use dda_ordered_sums, only: pieces, first_of, last_of, parallel_from
   implicit none
   private
   public :: carry_velocity, integrate, kinetic_energy, farthest_move

contains

   !> Multiply the velocity carried into the step by the dynamic factor; return the energy it takes.
   subroutine carry_velocity(blocks, dynamic_factor, loss)
      type(blocks_type), intent(inout) :: blocks
      real(wp), intent(in) :: dynamic_factor
      real(wp), intent(out) :: loss
      real(wp) :: before

      loss = 0.0_wp
      if (dynamic_factor == 1.0_wp) return
      before = kinetic_energy(blocks)
      blocks%velocity = dynamic_factor*blocks%velocity
      loss = before - kinetic_energy(blocks)
   end subroutine carry_velocity

   !> Accept the step: new coordinates, velocities, accelerations and vertices.
   subroutine integrate(blocks, d, time_step)
      type(blocks_type), intent(inout) :: blocks
      real(wp), intent(in) :: d(:,:)      !< [6,n] increments of the coordinates
      real(wp), intent(in) :: time_step
      real(wp) :: new(6)
      integer :: b

      !$omp parallel do private(new) schedule(static) if (blocks%n >= parallel_from)
      do b = 1, blocks%n
         new = 2.0_wp/time_step*d(:, b) - blocks%velocity(:, b)
         blocks%acceleration(:, b) = (new - blocks%velocity(:, b))/time_step
         blocks%velocity(:, b) = new
         blocks%position(:, b) = blocks%position(:, b) + d(:, b)
      end do
      call update_geometry(blocks)
   end subroutine integrate

   !> ½ vᵀMv, J/m.
   real(wp) function kinetic_energy(blocks)
      type(blocks_type), intent(in) :: blocks
      real(wp) :: part(pieces(blocks%n))
      integer :: p, b

      !$omp parallel do schedule(static) if (blocks%n >= parallel_from)
      do p = 1, size(part)
         part(p) = 0.0_wp
         do b = first_of(p), last_of(p, blocks%n)
            part(p) = part(p) + form(blocks%inertia(:, :, b), blocks%velocity(:, b))
         end do
      end do
      kinetic_energy = 0.5_wp*sum(part)
   end function kinetic_energy

   !> vᵀMv
   pure real(wp) function form(m, v)
      real(wp), intent(in) :: m(6, 6), v(6)
      real(wp) :: mv(6)
      integer :: j

      mv = 0.0_wp
      do j = 1, 6
         mv = mv + m(:, j)*v(j)
      end do
      form = dot_product(mv, v)
   end function form

   !> A bound on how far any vertex moves by d, m.
   real(wp) function farthest_move(blocks, d) result(move)
      type(blocks_type), intent(in) :: blocks
      real(wp), intent(in) :: d(:,:)
      integer :: b

      move = 0.0_wp
      !$omp parallel do reduction(max:move) schedule(static) if (blocks%n >= parallel_from)
      do b = 1, blocks%n
         move = max(move, norm2(d(1:2, b)) + blocks%radius(b)*(abs(d(3, b)) + norm2(d(4:6, b))))
      end do
   end function farthest_move

end module dda_newmark
