! SPDX-License-Identifier: GPL-3.0-or-later
!> Messages on a failed step and warnings on a run, with problem, position, time and remedy.
module dda_diagnostics
   use dda_kinds, only: wp
   use dda_doubts, only: add_doubt, add_doubts, doubt_type
   use dda_energy, only: energy_residual, turnover, energy_geometric
   use dda_errors, only: error_type, error_convergence, error_input, error_memory, fail
   use dda_joint_ends, only: bending_doubts
   use dda_maxima, only: of_strain, of_penetration_ratio
   use dda_model, only: half_size
   use dda_simulation, only: simulation_type, block_name
   use dda_text, only: counted, short_text, to_text
   implicit none
   private
   public :: explain, check_state, audit_warning, doubt_state

   !> largest distance of a block from the origin/half the model size
   real(wp), parameter :: most_away = 1.0e4_wp
   !> tolerance of the energy balance/sum of all exchanged energies
   real(wp), parameter :: most_unexplained = 1.0e-6_wp
   real(wp), parameter :: most_strain = 0.02_wp  !< largest strain for small-strain theory
   !> largest penetration over size of the smaller block
   real(wp), parameter :: most_penetration = 0.05_wp
   !> largest energy gain of springs between steps/sum of all exchanged energies
   real(wp), parameter :: most_geometric = 1.0e-2_wp

contains

   !> Create an error with cause, position and remedy.
   subroutine explain(simulation, reason, error)
      type(simulation_type), intent(in) :: simulation  !< a run and its state
      character(len=*), intent(in) :: reason  !< cause of the failure
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      character(len=:), allocatable :: location, advice
      integer :: c, kind

      kind = error_convergence
      if (allocated(error)) kind = error%kind
      location = ''
      c = simulation%iteration%unconverged
      if (c > 0) then
         associate (contacts => simulation%contacts(simulation%now))
            location = '; worst contact: a vertex of block '// &
               block_name(simulation, contacts%block_v(c))//' on an edge of block '// &
               block_name(simulation, contacts%block_e(c))//', error of its force '// &
               to_text(simulation%iteration%residual)//' N/m, allowed '// &
               to_text(simulation%iteration%tolerance)
         end associate
      end if
      advice = "; try a smaller time_step, or time_step_control = 'adaptive'"
      if (simulation%model%control%adaptive) advice = '; try a smaller least_time_step or a '// &
         'lower normal_stiffness'
      if (kind == error_memory .or. kind == error_input) then
         location = ''
         advice = ''
      end if
      call fail(error, kind, 'step '//to_text(simulation%step + 1)//' at t = '// &
         to_text(simulation%time)//' s, time step '//to_text(simulation%time_step)//' s: '// &
         reason//location//advice)
   end subroutine explain

   !> Check the new state: all values are finite, and all blocks are near the model.
   subroutine check_state(simulation, error)
      type(simulation_type), intent(in) :: simulation  !< a run and its state
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      character(len=:), allocatable :: problem
      real(wp) :: limit
      integer :: b

      limit = most_away*half_size(simulation%model%blocks)
      associate (blocks => simulation%blocks)
         if (are_finite_and_near(blocks%n, blocks%position, blocks%velocity, limit) &
            .and. abs(energy_residual(simulation%energy)) <= huge(1.0_wp)) return
         problem = 'a strain, a velocity or an energy is not a finite number'
         do b = 1, blocks%n
            if (all(abs(blocks%position(1:2, b)) <= limit)) cycle
            problem = 'block '//block_name(simulation, b)//' has left the model: it is '// &
               to_text(norm2(blocks%position(1:2, b)))//' m from the model centre, allowed '// &
               to_text(limit)
            exit
         end do
      end associate
      call fail(error, error_convergence, 'step '//to_text(simulation%step)//' at t = '// &
         to_text(simulation%time)//' s: '//problem// &
         '; look at loads, supports and initial values, or try a smaller time_step')
   end subroutine check_state

   !> .true. if all centroids are within a distance of the origin, and all other values are finite.
   pure logical function are_finite_and_near(n, position, velocity, bound) result(sound)  ! total
      integer, intent(in) :: n  !< blocks
      real(wp), intent(in) :: position(6, n), velocity(6, n)  !< coordinates and their rates
      real(wp), intent(in) :: bound  !< allowed distance, m
      integer :: b

      sound = are_finite(6*n, position) .and. are_finite(6*n, velocity)
      do b = 1, n
         sound = sound .and. abs(position(1, b)) <= bound .and. abs(position(2, b)) <= bound
      end do
   end function are_finite_and_near

   !> .true. if all values are finite; the loop has no exit, so that it can be vectorised.
   pure logical function are_finite(n, values)  ! total
      integer, intent(in) :: n           !< number of values
      real(wp), intent(in) :: values(n)  !< any values
      integer :: i, others

      others = 0
      do i = 1, n
         others = others + merge(0, 1, abs(values(i)) <= huge(1.0_wp))
      end do
      are_finite = others == 0
   end function are_finite

   !> Return a warning of the energy audit; '' if the energies balance.
   pure function audit_warning(simulation) result(text)
      type(simulation_type), intent(in) :: simulation  !< a run and its state
      character(len=:), allocatable :: text
      real(wp) :: scale, limit

      text = ''
      scale = turnover(simulation%energy)
      limit = max(most_unexplained*scale, rounding_energy(simulation))
      if (abs(energy_residual(simulation%energy)) > limit) then
         text = 'the energy audit does not balance: '// &
            to_text(energy_residual(simulation%energy))// &
            ' of '//to_text(scale)//' J/m are unexplained, limit '//to_text(limit)// &
            '; try a lower force_tolerance'
      else if (abs(simulation%energy%value(energy_geometric)) > max(most_geometric*scale, &
         limit)) then
         text = 'the geometry of contacts changed so much that their springs gained '// &
            to_text(simulation%energy%value(energy_geometric))//' of '//to_text(scale)// &
            ' J/m between steps; try a smaller time_step'
      end if
   end function audit_warning

   !> Add warnings on values beyond the limits of the method: the largest strains and penetrations
   !> of the whole run, and the present variables of joint laws.
   pure subroutine doubt_state(simulation, doubts)
      type(simulation_type), intent(in) :: simulation            !< a run and its state
      type(doubt_type), allocatable, intent(inout) :: doubts(:)  !< warnings are added

      call add_strain_warning(simulation, doubts)
      call add_penetration_warning(simulation, doubts)
      call add_doubts(doubts, bending_doubts(simulation))
      if (simulation%counters%tables_off > 0) call add_doubt(doubts, 'water table', &
         'the search did not converge in '//counted(to_text(simulation%counters%tables_off), &
         'step', 'steps')//': pressures near the water table are inaccurate')
      call add_memory_warnings(simulation, doubts)
   end subroutine doubt_state

   !> Add warnings if variables of joint laws exceed their limits.
   pure subroutine add_memory_warnings(simulation, doubts)
      type(simulation_type), intent(in) :: simulation            !< a run and its state
      type(doubt_type), allocatable, intent(inout) :: doubts(:)  !< warnings may be added
      real(wp) :: worst
      integer :: k

      if (simulation%laws%plain) return
      associate (contacts => simulation%contacts(simulation%now), &
         columns => simulation%laws%columns)
         do k = 1, size(columns)
            worst = maxval([0.0_wp, contacts%memory(k, :contacts%n)])
            if (worst > columns(k)%limit) call add_doubt(doubts, 'joint law', &
               'contact_'//trim(columns(k)%name)//' is '//short_text(worst)//', limit '// &
               short_text(columns(k)%limit)//': '//trim(columns(k)%advice))
         end do
      end associate
   end subroutine add_memory_warnings

   !> Add a warning on the largest strain, if it is too large.
   pure subroutine add_strain_warning(simulation, doubts)
      type(simulation_type), intent(in) :: simulation            !< a run and its state
      type(doubt_type), allocatable, intent(inout) :: doubts(:)  !< a warning may be added

      associate (most => simulation%maxima%largest(of_strain))
         if (most%value > most_strain) call add_doubt(doubts, 'strain', 'block '// &
            block_name(simulation, most%owners(1))//' has a strain of '// &
               short_text(100*most%value)// &
            ' % at t = '//short_text(most%time)//' s; small-strain theory holds up to '// &
            short_text(100*most_strain)//' %')
      end associate
   end subroutine add_strain_warning

   !> Add a warning on the largest penetration relative to the smaller block, if it is too large.
   pure subroutine add_penetration_warning(simulation, doubts)
      type(simulation_type), intent(in) :: simulation            !< a run and its state
      type(doubt_type), allocatable, intent(inout) :: doubts(:)  !< a warning may be added

      associate (most => simulation%maxima%largest(of_penetration_ratio))
         if (most%value > most_penetration) call add_doubt(doubts, 'penetration', &
            'a vertex of block '//block_name(simulation, most%owners(1))//' penetrates '// &
            short_text(most%value*minval(simulation%maxima%size_of(most%owners)))// &
            ' m into block '//block_name(simulation, most%owners(2))//' at t = '// &
            short_text(most%time)//' s, '//short_text(100*most%value)// &
            ' % of the size of the smaller block, limit '//short_text(100*most_penetration)//' %')
      end associate
   end subroutine add_penetration_warning

   !> Return the energy residual due to rounding of positions, J/m.  It has three parts: the work of
   !> weight along rounding errors of all steps, the work of force noise along the path, and the
   !> kinetic energy of rounding errors per Δt.
   pure real(wp) function rounding_energy(simulation)
      type(simulation_type), intent(in) :: simulation  !< a run and its state
      real(wp) :: position_error, mass

      position_error = 16*epsilon(1.0_wp)*half_size(simulation%model%blocks)
      mass = sum(simulation%blocks%mass)
      rounding_energy = real(simulation%step, wp)*position_error*norm2( &
         simulation%model%control%gravity)*mass + simulation%iteration%noise*simulation%path &
         + 0.5_wp*mass*(position_error/simulation%time_step)**2
   end function rounding_energy

end module dda_diagnostics
