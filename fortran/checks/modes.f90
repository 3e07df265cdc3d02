! SPDX-License-Identifier: GPL-3.0-or-later
!> Lowest modes of a linearised model: frequencies, shapes, participation in base motion, and
!> damping.
!>
!> The modes are undamped, each with the real part of the moduli at its own frequency.  The damping
!> ratio of a mode is the sum of three parts: time integration; materials, with a mass-normalised
!> shape Σ Im g ε·Kε/(2ω²) + Σ (α x·Mx + β ε·Kε)/(2ω) over blocks (`dda_damping`); dashpots with
!> extensions s, Σ c s²/(2ω).  This is accurate for small damping that hardly couples modes.
!>
!> Blocks joined by springs form parts.  Up to three rigid motions of a part are not restrained by
!> its supports; they are exact null vectors of the linearised stiffness.
module dda_modes
   use dda_kinds, only: wp, pi
   use dda_damping, only: modulus_factor
   use dda_deflation, only: null_space_type
   use dda_eigen, only: eigenpairs_type, find_lowest_eigenvalues, select_pairs
   use dda_errors, only: error_type
   use dda_linear_model, only: linear_model_type, energy_distribution_type, energy_of, &
      set_moduli_at, is_dispersive, law_fractions, scheme_of_mode, stiffness_weights
   use dda_linear_terms, only: stretch_of, mean_dashpot, end_dashpot, term_support, blocks_in, &
      block_of
   use dda_scheme, only: scheme_type
   use dda_partition, only: join, name_parts
   use dda_scheme_response, only: free_damping, period_elongation
   use dda_sorting, only: ascending_order
   use dda_text, only: counted, to_text
   use dda_dense_eigen, only: solve_symmetric_eigen
   implicit none
   private
   public :: modes_type, find_modes, find_elastic

   !> Lowest modes with stiffness, by ascending frequency.  Arrays are [n] unless stated otherwise.
   type :: modes_type
      integer :: n = 0                              !< number of modes found
      integer :: rigid = 0  !< number of rigid-body modes of unsupported parts
      !> number of further motions without stiffness, such as hinges and slides
      integer :: mechanisms = 0
      real(wp), allocatable :: omega(:)             !< rad/s
      real(wp), allocatable :: frequency(:)         !< Hz
      real(wp), allocatable :: residual(:)          !< relative residual of the eigenpair
      real(wp), allocatable :: shape(:,:,:)         !< [6,blocks,n] mass-normalised
      real(wp), allocatable :: participation(:,:)  !< [2,n] Γ = φᵀMr for base motion in x and y, √kg
      !> [2,n] Γ² / total mass; sums to 1 over all modes
      real(wp), allocatable :: effective_mass(:,:)
      real(wp), allocatable :: damping(:)           !< ζ in free vibration at Δt
      real(wp), allocatable :: of_scheme(:)         !< part of ζ due to the time integration
      !> relative period error of the scheme; −1: no oscillation
      real(wp), allocatable :: elongation(:)
      real(wp) :: total_mass = 0.0_wp               !< kg per metre of thickness
      character(len=:), allocatable :: text        !< text on contacts and singular stiffness
   end type modes_type

   real(wp), parameter :: zero_frequency = 1.0e-14_wp  !< ω²/scale of ω_max² that counts as zero
   !> support stiffness/largest support stiffness that counts as zero
   real(wp), parameter :: no_support = 1.0e-12_wp

contains

   !> Find the `count` lowest modes with stiffness, or all if there are fewer.
   subroutine find_modes(linear, count, modes, error)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      integer, intent(in) :: count  !< number of modes
      type(modes_type), intent(out) :: modes  !< lowest modes
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      type(eigenpairs_type) :: pairs
      integer :: i, b

      call find_elastic(linear, count, pairs, modes%rigid, modes%mechanisms, error)
      if (.not. allocated(error) .and. is_dispersive(linear)) call adapt_moduli(linear, pairs, &
         error)
      if (allocated(error)) return
      modes%n = pairs%n
      modes%omega = sqrt(pairs%value)
      modes%frequency = modes%omega/(2.0_wp*pi)
      modes%residual = pairs%residual
      call move_alloc(pairs%vector, modes%shape)
      allocate (modes%of_scheme(modes%n), modes%elongation(modes%n), modes%damping(modes%n))
      do i = 1, modes%n
         call set_damping(linear, modes, i)
      end do
      modes%total_mass = sum(linear%block_mass)
      allocate (modes%participation(2, modes%n), source=0.0_wp)
      do i = 1, modes%n
         do b = 1, linear%n  ! Γ = φᵀMr with a unit translation r of all blocks
            modes%participation(:, i) = modes%participation(:, i) + matmul(modes%shape(:, b, i), &
               linear%mass(:, 1:2, b))
         end do
      end do
      modes%effective_mass = modes%participation**2/modes%total_mass
      call write_mode_text(linear, count, modes)
   end subroutine find_modes

   !> Set the damping ratios of mode i, and the elongation of its period by the scheme.
   !> A dynamic factor f multiplies velocities in each step, so its damping ratio is −ln f/(2ωΔt).
   subroutine set_damping(linear, modes, i)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      type(modes_type), intent(inout) :: modes  !< modes with frequencies and shapes
      integer, intent(in) :: i  !< number of the mode
      type(scheme_type) :: scheme

      associate (omega => modes%omega(i), shape => modes%shape(:, :, i), dt => linear%time_step)
         scheme = scheme_of_mode(linear, energy_of(linear, shape))
         modes%elongation(i) = period_elongation(scheme, omega, dt)
         modes%of_scheme(i) = min(1.0_wp, free_damping(scheme, omega, dt) &
            + dashpot_damping(linear, omega, shape, .true.) &
            - log(max(tiny(1.0_wp), linear%dynamic_factor))/(2.0_wp*omega*dt))
         modes%damping(i) = min(1.0_wp, modes%of_scheme(i) + dashpot_damping(linear, omega, &
            shape, .false.) + material_damping(linear, omega, shape))
      end associate
   end subroutine set_damping

   !> Iterate each mode with the moduli at its own frequency until the frequency does not change.
   !> Each iteration first computes ω² from the energies of the present shape with the moduli at ω,
   !> then a new shape.
   subroutine adapt_moduli(linear, pairs, error)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      type(eigenpairs_type), intent(inout) :: pairs  !< on return, modes with own moduli
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      integer, parameter :: most_passes = 10, inner_passes = 6
      real(wp), parameter :: close_enough = 1.0e-11_wp  !< relative change of ω²
      type(linear_model_type) :: work
      type(eigenpairs_type) :: refined
      type(energy_distribution_type) :: energy
      real(wp) :: last
      integer :: i, pass, inner, rigid, mechanisms

      work = linear
      do i = 1, pairs%n
         do pass = 1, most_passes
            do inner = 1, inner_passes
               call set_moduli_at(work, sqrt(pairs%value(i))/(2.0_wp*pi))
               energy = energy_of(work, pairs%vector(:, :, i))
               pairs%value(i) = energy%total
            end do
            call set_moduli_at(work, sqrt(pairs%value(i))/(2.0_wp*pi))
            call find_elastic(work, i, refined, rigid, mechanisms, error)
            if (allocated(error)) return
            last = pairs%value(i)
            pairs%value(i) = refined%value(i)
            pairs%vector(:, :, i) = refined%vector(:, :, i)
            pairs%residual(i) = refined%residual(i)
            if (abs(pairs%value(i) - last) <= close_enough*last) exit
         end do
      end do
   end subroutine adapt_moduli

   !> Damping ratio of a mass-normalised mode due to the materials of the blocks.
   pure real(wp) function material_damping(linear, omega, shape) result(ratio)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      real(wp), intent(in) :: omega       !< rad/s
      real(wp), intent(in) :: shape(:,:)  !< [6,n]
      real(wp) :: elastic
      integer :: b, i

      ratio = 0.0_wp
      do b = 1, linear%n
         if (linear%law(b) == 0) cycle
         associate (damping => linear%damping(linear%law(b)), x => shape(:, b))
            elastic = dot_product(x(4:6), matmul(linear%input_elastic(:, :, b), x(4:6)))
            ratio = ratio + aimag(modulus_factor(damping, omega))*elastic/(2.0_wp*omega**2) &
               + (damping%beta*elastic + damping%alpha*dot_product(x, matmul(linear%mass(:, :, b), &
               x)))/(2.0_wp*omega)
         end associate
      end do
      do i = 1, linear%terms%n
         associate (term => linear%terms%term(i), fraction => law_fractions(linear, &
            linear%terms%term(i)))
            if (.not. any(fraction > 0.0_wp)) cycle
            elastic = term%coefficient*stretch_of(term, shape)**2
            if (allocated(linear%input_coefficients)) elastic = linear%input_coefficients(i) &
               *stretch_of(term, shape)**2
            ratio = ratio + sum(fraction*(aimag(modulus_factor(linear%damping, omega)) &
               /(2.0_wp*omega**2) + linear%damping%beta/(2.0_wp*omega)))*elastic
         end associate
      end do
   end function material_damping

   !> Damping ratio of a mass-normalised mode due to dashpots of supports, or all other dashpots.
   !> Supports are integrated by backward Euler in every scheme: their dashpots are numerical.
   pure real(wp) function dashpot_damping(linear, omega, shape, of_supports) result(ratio)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      real(wp), intent(in) :: omega       !< rad/s
      real(wp), intent(in) :: shape(:,:)  !< [6,n]
      logical, intent(in) :: of_supports  !< dashpots of supports; .false.: all others
      integer :: i

      ratio = 0.0_wp
      do i = 1, linear%terms%n
         associate (term => linear%terms%term(i))
            if (all(term%instant /= [mean_dashpot, end_dashpot])) cycle
            if (of_supports .neqv. (term%kind == term_support .and. term%instant == end_dashpot)) &
               cycle
            ratio = ratio + term%coefficient*stretch_of(term, shape)**2/(2.0_wp*omega)
         end associate
      end do
   end function dashpot_damping

   !> Find the lowest eigenpairs with stiffness.
   !> Eigenvalues are recomputed from energies of springs and strains, to detect zero stiffness.
   subroutine find_elastic(linear, count, pairs, rigid, mechanism_count, error)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      integer, intent(in) :: count  !< number of modes
      type(eigenpairs_type), intent(out) :: pairs  !< eigenvalues and vectors
      !> number of rigid motions of unsupported parts; number of further motions without stiffness
      integer, intent(out) :: rigid, mechanism_count
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      type(null_space_type) :: null_space
      real(wp), allocatable :: motion(:,:,:)
      integer, parameter :: max_mechanisms = 100
      integer :: request, elastic, available, i

      mechanism_count = 0
      rigid = 0
      call find_parts(linear, null_space)
      call find_rigid_motions(linear, null_space, motion)
      call retain_unrestrained(linear, null_space, motion, error)
      if (allocated(error)) return
      rigid = null_space%dimension - 3*removed_blocks(linear)
      available = 6*linear%n - null_space%dimension
      do
         request = min(count + mechanism_count, available)
         call find_lowest_eigenvalues(linear%stiffness, linear%mass, request, pairs, error, &
            null_space)
         if (allocated(error)) return
         call set_and_sort_frequencies(linear, pairs, mechanism_count)
         elastic = pairs%n - mechanism_count
         if (elastic >= count .or. pairs%n < request .or. mechanism_count > max_mechanisms) exit
         if (request >= available) exit
      end do
      call select_pairs(pairs, [(i, i=mechanism_count + 1, pairs%n)])
   end subroutine find_elastic

   !> Number of blocks that stages have removed.
   pure integer function removed_blocks(linear)
      type(linear_model_type), intent(in) :: linear  !< linearised model

      removed_blocks = count(.not. linear%block_mass > 0.0_wp)
   end function removed_blocks

   !> Compute ω² = Σ k (extension)² + strain energies of each mass-normalised vector, and sort.
   subroutine set_and_sort_frequencies(linear, pairs, mechanism_count)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      type(eigenpairs_type), intent(inout) :: pairs  !< eigenvalues and vectors
      integer, intent(out) :: mechanism_count  !< number of modes without stiffness
      type(energy_distribution_type) :: energy
      real(wp) :: zero_stiffness_limit
      integer :: i

      do i = 1, pairs%n
         energy = energy_of(linear, pairs%vector(:, :, i))
         pairs%value(i) = energy%total
      end do
      call select_pairs(pairs, ascending_order(pairs%value))
      zero_stiffness_limit = zero_frequency*omega_max_scale(linear)
      mechanism_count = count(pairs%value < zero_stiffness_limit)
   end subroutine set_and_sort_frequencies

   !> Scale of ω_max²: largest ratio of diagonal terms of K and M.
   pure real(wp) function omega_max_scale(linear) result(scale)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      integer :: b, i

      scale = 0.0_wp
      do b = 1, linear%n
         do i = 1, 6
            scale = max(scale, linear%stiffness%diagonal(i, i, b)/linear%mass(i, i, b))
         end do
      end do
   end function omega_max_scale

   !> Write the text on contacts, singular stiffness and moduli of the modes.
   subroutine write_mode_text(linear, request, modes)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      integer, intent(in) :: request  !< number of modes
      type(modes_type), intent(inout) :: modes  !< lowest modes

      modes%text = counted(to_text(linear%n_closed), 'contact is closed', 'contacts are closed')
      if (linear%n_closed == 0) modes%text = 'no contact is closed'
      if (linear%n_sliding > 0) modes%text = modes%text//', '//to_text(linear%n_sliding)// &
         ' of them slide'
      if (allocated(linear%equilibrium%text)) modes%text = modes%text//'; '//linear%equilibrium%text
      if (modes%rigid > 0) modes%text = modes%text// &
         '; the stiffness is singular, because unsupported parts have '// &
         counted(to_text(modes%rigid), 'rigid-body mode', 'rigid-body modes')
      if (modes%mechanisms > 0) modes%text = modes%text//'; at least '// &
         to_text(modes%mechanisms)//' further modes have no stiffness (hinges or slides)'
      if (is_dispersive(linear)) modes%text = modes%text// &
         '; each mode uses the moduli and damping ratios of materials at its own frequency'
      if (modes%n < request) modes%text = modes%text//'; only '//to_text(modes%n)// &
         ' modes have stiffness'
   end subroutine write_mode_text

   !> Number the connected parts of the model.
   subroutine find_parts(linear, null_space)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      type(null_space_type), intent(inout) :: null_space  !< parts and their free rigid motions
      integer :: part(linear%n), i, b, k

      part = [(b, b=1, linear%n)]
      do i = 1, linear%terms%n
         do k = 2, blocks_in(linear%terms%term(i))
            call join(part, linear%terms%term(i)%block_a, block_of(linear%terms%term(i), k))
         end do
      end do
      call name_parts(part)
      allocate (null_space%group(linear%n))
      null_space%groups = 0
      do b = 1, linear%n
         if (part(b) == b) null_space%groups = null_space%groups + 1
         null_space%group(b) = null_space%groups
         if (part(b) < b) null_space%group(b) = null_space%group(part(b))
      end do
   end subroutine find_parts

   !> Compute two translations and the rotation of each part, mass-orthonormal.
   !> Rotation is about the centre of mass.  Blocks removed by a stage are separate parts.
   subroutine find_rigid_motions(linear, null_space, motion)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      type(null_space_type), intent(in) :: null_space  !< parts and their free rigid motions
      real(wp), allocatable, intent(out) :: motion(:,:,:)  !< [6,3,n]
      real(wp) :: mass(null_space%groups), centre(2, null_space%groups), &
         inertia(null_space%groups), arm(2)
      integer :: b, g

      mass = 0.0_wp
      centre = 0.0_wp
      inertia = 0.0_wp
      do b = 1, linear%n
         associate (g => null_space%group(b), m => linear%mass(1, 1, b))
            mass(g) = mass(g) + m
            centre(:, g) = centre(:, g) + m*linear%position(:, b)
         end associate
      end do
      centre = centre/spread(mass, 1, 2)
      do b = 1, linear%n
         g = null_space%group(b)
         arm = linear%position(:, b) - centre(:, g)
         inertia(g) = inertia(g) + linear%mass(3, 3, b) + linear%mass(1, 1, b)*dot_product(arm, arm)
      end do
      allocate (motion(6, 3, linear%n), source=0.0_wp)
      do b = 1, linear%n
         g = null_space%group(b)
         arm = linear%position(:, b) - centre(:, g)
         motion(1, 1, b) = 1.0_wp/sqrt(mass(g))
         motion(2, 2, b) = 1.0_wp/sqrt(mass(g))
         motion(1:3, 3, b) = [-arm(2), arm(1), 1.0_wp]/sqrt(inertia(g))
      end do
   end subroutine find_rigid_motions

   !> Retain the combinations of the rigid motions of each part that its supports do not restrain.
   subroutine retain_unrestrained(linear, null_space, motion, error)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      type(null_space_type), intent(inout) :: null_space  !< parts and their free rigid motions
      real(wp), intent(in) :: motion(:,:,:)  !< [6,3,n] rigid motions
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      real(wp) :: resistance(3, 3, null_space%groups), row(3)
      real(wp), allocatable :: values(:)
      integer :: i, g, b, n_restrained

      resistance = 0.0_wp
      do i = 1, linear%terms%n
         associate (term => linear%terms%term(i))
            if (term%block_b > 0 .or. .not. stiffness_weights(term%instant) > 0.0_wp) cycle
            g = null_space%group(term%block_a)
            row = matmul(term%row_a, motion(:, :, term%block_a))
            resistance(:, :, g) = resistance(:, :, g) + spread(row, 2, 3)*spread(row, 1, 3)
         end associate
      end do
      do g = 1, null_space%groups
         call solve_symmetric_eigen(resistance(:, :, g), values, error)
         if (allocated(error)) return
         n_restrained = count(values > no_support*values(3))
         resistance(:, 4 - n_restrained:, g) = 0.0_wp
         null_space%dimension = null_space%dimension + 3 - n_restrained
      end do
      allocate (null_space%basis(6, 3, linear%n))
      do b = 1, linear%n
         null_space%basis(:, :, b) = matmul(motion(:, :, b), resistance(:, :, null_space%group(b)))
      end do
   end subroutine retain_unrestrained

end module dda_modes
