! SPDX-License-Identifier: GPL-3.0-or-later
!> Estimate, before the run, of the difference between the motions of sides and their free fields,
!> for waves that are long relative to the depth.
!>
!> Ground of depth H(x) on a radiating base moves horizontally like a bar, with u(x) constant over
!> the depth:
!>
!>     (E'H u')' + (ρH ω² − iωZ) u = −2iωZ u_in ,
!>
!> with the modulus E' for plane strain, the impedance Z = ρV_s of the base, and dashpots at both
!> ends that connect the sides to the free field 2 u_in/(1 + iωρH/Z), the solution for level ground.
module dda_side_departure
   use dda_kinds, only: wp, pi
   use dda_material, only: elasticity
   use dda_model, only: model_type
   implicit none
   private
   public :: find_side_departure

   integer, parameter :: cells = 400  !< number of cells of the bar between both sides

   !> Bar with values per cell and at both ends.
   type :: bar_type
      real(wp) :: length = 0.0_wp                !< length of a cell, m
      real(wp) :: mass(cells) = 0.0_wp           !< ρH of each cell, kg/m²
      real(wp) :: modulus(cells) = 0.0_wp        !< E'H of each cell, N/m
      real(wp) :: base = 0.0_wp                  !< Z, Pa s/m
      real(wp) :: dashpot(2) = 0.0_wp  !< dashpot of the left and right side, N s/m per metre
   end type bar_type

contains

   !> Find the largest difference between a side and its free field, relative to the free field.
   !> The result is negative if no base radiates waves or no side has a free field.
   subroutine find_side_departure(model, x, frequency, departure)
      type(model_type), intent(in) :: model     !< model as read from the input
      real(wp), intent(in) :: x(:)              !< [vertices] positions at the start, m
      real(wp), intent(inout) :: frequency  !< Hz; reduced so that waves are at least 4 depths long
      real(wp), intent(out) :: departure        !< relative difference
      type(bar_type) :: bar
      complex(wp) :: u(cells + 1), free(2)
      real(wp) :: omega

      departure = -1.0_wp
      bar = make_side_bar(model, x)
      if (.not. (bar%base > 0.0_wp .and. maxval(bar%dashpot) > 0.0_wp)) return
      omega = min(2.0_wp*pi*frequency, 0.5_wp*pi*bar%base/maxval(bar%mass))
      frequency = omega/(2.0_wp*pi)
      free = 2.0_wp/cmplx(1.0_wp, omega*bar%mass([1, cells])/bar%base, wp)
      u = bar_motion(bar, omega, free)
      departure = maxval(abs(u([1, cells + 1])/free - 1.0_wp), mask=bar%dashpot > 0.0_wp)
   end subroutine find_side_departure

   !> Distribute the blocks over the cells that they overlap, and set dashpots of base and sides.
   type(bar_type) function make_side_bar(model, x) result(bar)
      type(model_type), intent(in) :: model  !< model as read from the input
      real(wp), intent(in) :: x(:)           !< [vertices] positions at the start, m
      real(wp) :: left, low, high, plate, share(cells)
      integer :: b, i

      left = minval(x)
      bar%length = (maxval(x) - left)/cells
      associate (blocks => model%blocks)
         do b = 1, blocks%n
            associate (own => x(blocks%first(b):blocks%first(b + 1) - 1), &
               d => blocks%area(b)*elasticity(model%materials(blocks%material(b)), &
               model%control%plane_strain))
               low = minval(own) - left
               high = maxval(own) - left
               share = [(max(0.0_wp, min(high, i*bar%length) - max(low, (i - 1)*bar%length)), &
                  i=1, cells)]/((high - low)*bar%length)
               plate = d(1, 1) - d(1, 2)**2/d(2, 2)
               bar%mass = bar%mass + share*blocks%mass(b)
               bar%modulus = bar%modulus + share*plate
            end associate
         end do
      end associate
      do i = 1, size(model%boundaries)
         if (model%boundaries(i)%kind == 'compliant') bar%base = bar%base &
            + 2.0_wp*sum(model%boundaries(i)%dashpot(2, :))/(cells*bar%length)
      end do
      do i = 1, size(model%free_fields)
         associate (field => model%free_fields(i), side => merge(1, 2, &
            model%free_fields(i)%side == 'left'))
            bar%dashpot(side) = 2.0_wp*sum(field%boundary%dashpot(1, :))
         end associate
      end do
   end function make_side_bar

   !> Solve for the motion at the ends of the cells for u_in = 1, by tridiagonal elimination.
   pure function bar_motion(bar, omega, free) result(u)
      type(bar_type), intent(in) :: bar
      real(wp), intent(in) :: omega       !< rad/s
      complex(wp), intent(in) :: free(2)  !< motion of the free fields of the sides
      complex(wp) :: u(cells + 1)
      complex(wp) :: diagonal(cells + 1), own, side(2)
      real(wp) :: k
      integer :: i

      diagonal = 0.0_wp
      u = 0.0_wp
      side = cmplx(0.0_wp, omega*bar%dashpot, wp)
      diagonal([1, cells + 1]) = side
      u([1, cells + 1]) = side*free
      do i = 1, cells
         own = 0.5_wp*bar%length*cmplx(-omega**2*bar%mass(i), omega*bar%base, wp)
         diagonal(i:i + 1) = diagonal(i:i + 1) + bar%modulus(i)/bar%length + own
         u(i:i + 1) = u(i:i + 1) + bar%length*cmplx(0.0_wp, omega*bar%base, wp)
      end do
      do i = 1, cells
         k = bar%modulus(i)/bar%length
         diagonal(i + 1) = diagonal(i + 1) - k**2/diagonal(i)
         u(i + 1) = u(i + 1) + k*u(i)/diagonal(i)
      end do
      u(cells + 1) = u(cells + 1)/diagonal(cells + 1)
      do i = cells, 1, -1
         u(i) = (u(i) + bar%modulus(i)/bar%length*u(i + 1))/diagonal(i)
      end do
   end function bar_motion

end module dda_side_departure
