! SPDX-License-Identifier: GPL-3.0-or-later
!> The highest frequency, its bracket, the part that governs it, and the modes that a time step
!> cannot resolve.
module test_omega_max
   use dda_kinds, only: wp
   use dda_eigen, only: eigenpairs_type, find_all_eigenvalues
   use dda_linear_model, only: linear_model_type, energy_distribution_type, energy_of, &
      set_penalty, &
      strain_energy
   use dda_linear_terms, only: term_normal, term_support
   use dda_omega_max, only: omega_max_type, find_omega_max
   use dda_unresolved, only: unresolved_type, count_unresolved
   use check_models, only: layered_site, layered_site_of_table_2, drum_column, brick_wall, &
      plane_strain_heap, loose_blocks, linear_of
   use testing, only: case, check, check_close, check_no_error, error
   implicit none

   type(linear_model_type) :: linear
   type(omega_max_type) :: result

contains

   subroutine brackets()
      call case('layered site, table I')
      call bracketed(layered_site(), term_support)
      call case('layered site, table II')
      call bracketed(layered_site_of_table_2(), term_support)
      call case('column')
      call bracketed(drum_column('1.0e8', ''), strain_energy)
      call case('wall, soft joints')
      call bracketed(brick_wall(6, 5, '1.0e10', ''), 0)
      call case('wall, stiff joints')
      call bracketed(brick_wall(7, 6, '1.0e12', ''), 0)
      call case('polygons, several materials, plane strain')
      call bracketed(plane_strain_heap(), 0)
      call case('blocks that do not touch')
      call bracketed(loose_blocks(), strain_energy)
   end subroutine brackets

   !> ω_max against LAPACK, inside its bracket, whose upper end is near.
   subroutine bracketed(text, kind)
      character(len=*), intent(in) :: text
      integer, intent(in) :: kind  !< what governs; 0: not checked
      type(energy_distribution_type) :: energy

      call linear_of(linear, text, 'closed')
      call find_omega_max(linear, result, error, tolerance=1.0e-10_wp)
      call check_no_error(error, 'omega_max')
      if (allocated(error)) return
      call check_close(result%omega, dense_omega(), 'ω_max', relative=1.0e-8_wp)
      call check(result%bracket%lower <= result%omega*(1 + 1.0e-9_wp), 'lower end')
      call check(result%bracket%upper >= result%omega, 'upper end')
      call check(result%bracket%upper <= 1.15_wp*result%omega, 'the upper end is near')
      if (kind > 0) call check(result%kind == kind, 'what governs')
      call check(index(result%text, result%governs) > 0, 'named in words')
      energy = energy_of(linear, result%shape)
      call check_close(energy%total, result%omega**2, 'energy of the mode', relative=1.0e-8_wp)
      call check_close(sum(energy%fraction), 1.0_wp, 'shares', relative=1.0e-12_wp)
   end subroutine bracketed

   real(wp) function dense_omega() result(omega)
      type(eigenpairs_type) :: pairs

      call find_all_eigenvalues(linear%stiffness, linear%mass, pairs, error)
      call check_no_error(error, 'LAPACK')
      omega = sqrt(pairs%value(pairs%n))
   end function dense_omega

   !> From strains to springs.
   subroutine many_penalties()
      integer :: i

      call linear_of(linear, brick_wall(5, 5, '1.0e10', ''), 'closed')
      do i = 6, 14
         call set_penalty(linear, 10.0_wp**i)
         call find_omega_max(linear, result, error, tolerance=1.0e-10_wp)
         call check_no_error(error, 'omega_max')
         call check_close(result%omega, dense_omega(), 'ω_max', relative=1.0e-8_wp)
         call check(result%bracket%upper >= result%omega, 'upper end')
         call check(result%bracket%upper <= 1.15_wp*result%omega, 'the upper end is near')
      end do
      call check(result%kind == term_normal .or. result%kind == term_support, &
         'stiff springs govern')
   end subroutine many_penalties

   !> A loose tolerance states the residual that it reached.
   subroutine a_loose_tolerance()
      type(omega_max_type) :: coarse, tight

      call linear_of(linear, brick_wall(30, 20, '1.0e12', ''), 'closed')
      call find_omega_max(linear, coarse, error, tolerance=1.0e-3_wp)
      call check_no_error(error, 'loose')
      call find_omega_max(linear, tight, error)
      call check_no_error(error, 'tight')
      call check(coarse%residual <= 1.0e-3_wp .and. tight%residual <= 1.0e-6_wp, 'residuals')
      call check(coarse%products < tight%products, 'loose is cheaper')
      call check_close(coarse%omega, tight%omega, 'and near', relative=1.0e-3_wp)
      call check(coarse%omega <= tight%omega*(1 + 1.0e-9_wp), 'from below')
   end subroutine a_loose_tolerance

   !> Bounds, inertia and LAPACK agree on how many modes lie beyond 4/Δt.
   subroutine modes_beyond_4_time_step()
      type(unresolved_type) :: unresolved
      type(eigenpairs_type) :: pairs
      real(wp), parameter :: steps(4) = [1.0e-3_wp, 2.0e-4_wp, 1.0e-4_wp, 1.0e-5_wp]
      integer :: i

      call linear_of(linear, brick_wall(8, 8, '1.0e11', ''), 'closed')
      call find_all_eigenvalues(linear%stiffness, linear%mass, pairs, error)
      do i = 1, size(steps)
         call count_unresolved(linear, steps(i), unresolved, error)
         call check_no_error(error, 'count')
         associate (beyond => count(pairs%value > (4.0_wp/steps(i))**2))
            call check(unresolved%at_least <= beyond .and. beyond <= unresolved%at_most, 'bounds')
            call check(unresolved%exact .and. unresolved%at_least == beyond, 'exact by inertia')
         end associate
      end do
      call check(unresolved%at_most == 0 .and. index(unresolved%text, 'all') == 1, &
         'all below, in words')
      call linear_of(linear, layered_site(), 'closed')
      call count_unresolved(linear, 1.0e-3_wp, unresolved, error)
      call check(unresolved%exact .and. unresolved%at_least == 66, 'layered site')
      call check(sum(unresolved%of_kind) == 66, 'kinds')
   end subroutine modes_beyond_4_time_step

end module test_omega_max
