!> Stages of a run: statics to rest, then dynamics.
module dda_stages
   use dda_kinds, only: wp
   use dda_blocks, only: place_of
   use dda_contact_response, only: accept_contacts
   use dda_energy, only: energy_type, energy_terms, energy_values
   use dda_energy_budget, only: start_energy_budget
   use dda_equilibrium, only: equilibrium_type, equilibrate
   use dda_errors, only: error_type
   use dda_simulation, only: simulation_type, counters_type, next_step
   use dda_start, only: start
   use dda_model, only: model_type
   use dda_text, only: to_text
   implicit none
   private
   public :: begin_simulation, begin_first_stage

contains

   !> Set up a run of a model, at rest if it is to begin so.
   subroutine begin_simulation(simulation, model, error)
      type(simulation_type), intent(out) :: simulation
      type(model_type), intent(in) :: model
      type(error_type), allocatable, intent(out) :: error

      call start(simulation, model, error)
      if (.not. allocated(error)) call begin_first_stage(simulation, error)
   end subroutine begin_simulation

   !> Bring a simulation that has just been started to rest if it is to begin so.
   subroutine begin_first_stage(simulation, error)
      type(simulation_type), intent(inout) :: simulation
      type(error_type), allocatable, intent(out) :: error

      if (.not. simulation%model%control%settle) return
      call settle(simulation, error)
      if (allocated(error)) error%message = simulation%model%file//': the model does not settle: '// &
         error%message//'; look at its supports, joints and first gaps'
   end subroutine begin_first_stage

   !> Rest under gravity and the loads of time 0 becomes the first state: displacements, energies
   !> and counts begin from there.
   subroutine settle(simulation, error)
      type(simulation_type), intent(inout) :: simulation
      type(error_type), allocatable, intent(out) :: error
      type(equilibrium_type) :: equilibrium
      integer :: i

      call equilibrate(simulation, equilibrium, error)
      if (allocated(error)) return
      simulation%statics = 'began '//equilibrium%words//'; '//budget_in_words(simulation%energy)
      associate (points => simulation%model%points)
         do i = 1, size(points)
            points(i)%place = place_of(simulation%blocks, points(i)%block, points(i)%reference)
         end do
      end associate
      simulation%counters = counters_type(searches=simulation%counters%searches)
      simulation%path = 0.0_wp
      simulation%last_time_step = 0.0_wp
      simulation%iteration%iterations = 0
      call accept_contacts(simulation%contacts(simulation%now), simulation%laws)
      call start_energy_budget(simulation%energy, simulation%blocks, &
         simulation%contacts(simulation%now), simulation%laws, simulation%elements, &
         next_step(simulation))
   end subroutine settle

   !> The terms of a budget that are not zero.
   pure function budget_in_words(energy) result(words)
      type(energy_type), intent(in) :: energy
      character(len=:), allocatable :: words
      real(wp) :: values(size(energy_terms))
      integer :: i

      values = energy_values(energy)
      words = 'its energies, J/m:'
      do i = 1, size(values)
         if (abs(values(i)) > 0.0_wp) words = words//' '//trim(energy_terms(i)%name)//' '// &
            to_text(values(i))
      end do
   end function budget_in_words

end module dda_stages
