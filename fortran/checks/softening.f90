! SPDX-License-Identifier: GPL-3.0-or-later
!> Warnings on cohesive joints whose crack zones are not resolved by their contact points, or that
!> fail within one step.
module dda_softening
   use dda_kinds, only: wp
   use dda_model, only: model_type
   use dda_scheme, only: scheme_named, scheme_type
   use dda_text, only: quoted, short_text
   implicit none
   private
   public :: coarse_points, long_steps

   real(wp), parameter :: least_spacings = 2.0_wp !< least cohesive zone over spacing of points
   !> limit of `long_steps` over the time step for which bounds of the fracture energy differ by at
   !> most 10 % even if a joint fails suddenly (measured with bars)
   real(wp), parameter :: fine_steps = 20.0_wp

contains

   !> Warning on joint j if its cohesive zone E'G/T² has fewer than three points; otherwise blank.
   pure function coarse_points(model, j) result(words)
      type(model_type), intent(in) :: model  !< model as read from the input
      integer, intent(in) :: j               !< joint
      character(len=:), allocatable :: words
      real(wp) :: zone, spacing

      words = ''
      associate (joint => model%joints(j))
         zone = minval(model%materials%young_modulus)*joint%fracture_energy &
            /joint%tensile_strength**2
         spacing = longest_edge(model, j)/(joint%contact_points - 1)
         if (zone >= least_spacings*spacing) return
         words = 'the cohesive zone EG/T² of joint '//quoted(trim(joint%name))//' is '// &
            short_text(zone)//' m long, but its contact points are up to '//short_text(spacing)// &
            ' m apart: the strength depends on the size of the blocks; try contact_points = 5 '// &
            'or smaller blocks'
      end associate
   end function coarse_points

   !> Warning on joint j if it softens faster than inertia can resist within a step; else blank.
   !> Condition: M/(χΔt²) < T²/(2G) with the two lightest blocks.
   pure function long_steps(model, j) result(words)
      type(model_type), intent(in) :: model  !< model as read from the input
      integer, intent(in) :: j               !< joint
      character(len=:), allocatable :: words
      type(scheme_type) :: scheme
      real(wp) :: slope, limit

      words = ''
      scheme = scheme_named(model%control%integration, model%control%theta)
      associate (joint => model%joints(j))
         slope = 0.5_wp*max(joint%tensile_strength**2/joint%fracture_energy, &
            joint%cohesion**2/joint%shear_fracture_energy)
         if (joint%softening == 'exponential') slope = 2*slope
         limit = sqrt(0.5_wp*least_mass(model, j)/(scheme%chi*slope))
         if (model%control%time_step <= limit) return
         words = 'joint '//quoted(trim(joint%name))//' softens within a step of time_step = '// &
            short_text(model%control%time_step)//' s: above '//short_text(limit)//' s the '// &
            'time of failure depends on time_step; below '//short_text(limit/fine_steps)//' s '// &
            'the bounds of its fracture energy differ by at most 10 %, even in sudden failure'
      end associate
   end function long_steps

   !> Length of the longest edge with joint j, m.
   pure real(wp) function longest_edge(model, j) result(longest)
      type(model_type), intent(in) :: model  !< model as read from the input
      integer, intent(in) :: j               !< joint
      integer :: v

      longest = 0.0_wp
      associate (blocks => model%blocks)
         do v = 1, size(blocks%owner)
            if (blocks%joint(v) == j) longest = max(longest, &
               norm2(blocks%reference(:, blocks%next(v)) - blocks%reference(:, v)))
         end do
      end associate
   end function longest_edge

   !> Smallest block mass per length of edge with joint j, kg/m².
   pure real(wp) function least_mass(model, j) result(least)
      type(model_type), intent(in) :: model  !< model as read from the input
      integer, intent(in) :: j               !< joint
      integer :: v

      least = huge(1.0_wp)
      associate (blocks => model%blocks)
         do v = 1, size(blocks%owner)
            if (blocks%joint(v) == j) least = min(least, blocks%mass(blocks%owner(v)) &
               /norm2(blocks%reference(:, blocks%next(v)) - blocks%reference(:, v)))
         end do
      end associate
   end function least_mass

end module dda_softening
