! SPDX-License-Identifier: GPL-3.0-or-later
!> What a check says of bonded blocks that meet on several sides: blocks of constant strain that
!> hang together at all their corners can move as u_x = f(x) + g(y) alone, and contacts oppose all
!> other motions by (k_n + k_s) h² (∂²u/∂x∂y)²/4 per area.
module dda_check_lattice
   use dda_kinds, only: wp, pi
   use dda_check_report, only: report_type, add_line, verdict_ok, verdict_warn, advice_if
   use dda_simulation, only: simulation_type
   use dda_text, only: short_text
   implicit none
   private
   public :: check_lattice

   real(wp), parameter :: most_excess = 0.1_wp  !< of the wave velocity, without a warning
   real(wp), parameter :: crossing = 0.5_wp     !< sine of the angle between two rows of joints

contains

   !> How much too fast waves at 45° to the joints are, at the highest frequency of the motions.
   subroutine check_lattice(simulation, report)
      type(simulation_type), intent(in) :: simulation  !< a run and its state
      type(report_type), intent(inout) :: report  !< check report
      real(wp) :: stiffness, share, excess
      integer :: b

      if (.not. report%band%known) return
      associate (contact => simulation%model%contact, blocks => simulation%blocks, &
         meets => on_several_sides(simulation))
         stiffness = contact%normal_stiffness*(1.0_wp + 1.0_wp/contact%shear_ratio)
         share = 0.0_wp
         ! S waves: (k_n + k_s) (kh)²/8G of their own stiffness
         do b = 1, blocks%n
            if (meets(b)) share = max(share, stiffness*(2.0_wp*pi*report%band%highest &
               *blocks%area(b))**2*blocks%mass(b)/(8.0_wp*blocks%stiffness(3, 3, b)**2))
         end do
         if (.not. any(meets)) return
      end associate
      excess = sqrt(1.0_wp + share) - 1.0_wp
      call add_line(report, merge(verdict_ok, verdict_warn, excess <= most_excess), 'lattice', &
         'S waves at 45° to the rows of bonded blocks are up to '//short_text(100*excess)// &
         ' % too fast at '//short_text(report%band%highest)//' Hz; waves along the rows are not', &
         '(k_n + k_s)(k dx)²/8G', advice_if(excess > most_excess, 'smaller blocks, or contacts '// &
         'as stiff as the ground: square_lattice of Python (docs/building.md)'))
   end subroutine check_lattice

   !> Blocks that are bonded across edges of several directions.
   pure function on_several_sides(simulation) result(meets)
      type(simulation_type), intent(in) :: simulation  !< a run and its state
      logical :: meets(simulation%blocks%n)
      real(wp) :: first(2, simulation%blocks%n)
      integer :: c, side, b

      meets = .false.
      first = 0.0_wp
      associate (contacts => simulation%contacts(simulation%now), blocks => simulation%blocks)
         do c = 1, contacts%n
            if (.not. contacts%bonded(c)) cycle
            associate (along => blocks%along(:, contacts%edge(c)))
               do side = 1, 2
                  b = merge(contacts%block_v(c), contacts%block_e(c), side == 1)
                  if (.not. any(abs(first(:, b)) > 0.0_wp)) first(:, b) = along
                  if (abs(first(1, b)*along(2) - first(2, b)*along(1)) > crossing) &
                     meets(b) = .true.
               end do
            end associate
         end do
      end associate
   end function on_several_sides

end module dda_check_lattice
