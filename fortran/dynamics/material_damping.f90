! SPDX-License-Identifier: GPL-3.0-or-later
!> Damping of the materials (`dda_damping`) in a step: terms of K̂ and f̂, energies, and the
!> update of the memory strains ζ_l of the generalised Maxwell branches.
!>
!> With h_l = ω_l Δt/2 and K the elastic matrix of a block,
!>
!>     K̂ += θ [(r − 1) − r Σ h_l Y_l/(1 + h_l)] K + (α M + β K)/Δt ,
!>     f̂ −= K [(r − 1) e₀ − r Σ ζ_l − θ r Σ 2h_l/(1 + h_l) (Y_l e₀ − ζ_l)] ,
!>
!> a step stores ½ (r − 1) e·Ke − r e·K Σ ζ_l + ½ r Σ ζ_l·Kζ_l/Y_l, and dissipates
!> r Σ Δζ_l·KΔζ_l/(Y_l ω_l Δt) + d·Cd/Δt.
module dda_material_damping
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type, has_memory, mass_matrix, memory_strain, momentum_of
   use dda_damping, only: damping_type, following
   use dda_ordered_sums, only: pieces, first_of, last_of, most_pieces, parallel_from
   use dda_scheme, only: step_type
   implicit none
   private
   public :: add_damping_matrix, add_damping_loads, damping_losses, damping_energy, &
      update_memories, force_on_strains

contains

   !> Add the damping forces on the strains of all blocks at d = 0.
   subroutine add_damping_loads(blocks, step, load)
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step      !< the present step
      real(wp), intent(inout) :: load(:,:)     !< [6,blocks] f̂, N/m and N
      integer :: b

      !$omp parallel do schedule(static) if (blocks%n >= parallel_from)
      do b = 1, blocks%n
         if (blocks%damping(blocks%material(b))%n == 0) cycle
         load(4:6, b) = load(4:6, b) - blocks%interior_fraction(b) &
            *matmul(blocks%stiffness(:, :, b), damping_strain(blocks, step, b))
      end do
   end subroutine add_damping_loads

   !> Return the losses by damping, and Δσ·Δε of the damping stresses, of all blocks in a step.
   !> The unit is J per metre of thickness; ζ_l must not yet be updated.
   function damping_losses(blocks, step, d) result(total)
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step      !< the present step
      real(wp), intent(in) :: d(:,:)           !< [6,blocks] increments of the coordinates
      real(wp) :: total(2), part(2, most_pieces)
      integer :: p, b

      part = 0.0_wp
      !$omp parallel do schedule(static) private(b) if (blocks%n >= parallel_from)
      do p = 1, pieces(blocks%n)
         do b = first_of(p, blocks%n), last_of(p, blocks%n)
            call add_damping_loss(blocks, step, b, d(:, b), part(1, p), part(2, p))
         end do
      end do
      total = sum(part(:, :pieces(blocks%n)), 2)
   end function damping_losses

   !> Return the energy of the Maxwell branches of all blocks minus ½ ε·Kε, J per metre.
   real(wp) function damping_energy(blocks) result(energy)
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      real(wp) :: part(most_pieces)
      integer :: p, b

      part = 0.0_wp
      !$omp parallel do schedule(static) private(b) if (blocks%n >= parallel_from)
      do p = 1, pieces(blocks%n)
         do b = first_of(p, blocks%n), last_of(p, blocks%n)
            part(p) = part(p) + energy_of_block(blocks, b)
         end do
      end do
      energy = sum(part(:pieces(blocks%n)))
   end function damping_energy

   !> Update ζ_l of all blocks at the end of a step, before the strains are updated.
   subroutine update_memories(blocks, step, d)
      type(blocks_type), intent(inout) :: blocks  !< blocks at the start of the step
      type(step_type), intent(in) :: step         !< the present step
      real(wp), intent(in) :: d(:,:)              !< [6,blocks] increments of the coordinates
      integer :: b, l

      if (.not. has_memory(blocks)) return
      !$omp parallel do schedule(static) private(l) if (blocks%n >= parallel_from)
      do b = 1, blocks%n
         associate (damping => blocks%damping(blocks%material(b)))
            if (damping%by_law) cycle
            do l = 1, damping%n
               blocks%memory(:, l, b) = blocks%memory(:, l, b) &
                  + (relaxation_change(blocks, damping, b, l, step%time_step) &
                  + following(damping, l, step%time_step)*d(4:6, b))
            end do
         end associate
      end do
   end subroutine update_memories

   !> Add the damping terms of K̂ of block b, constant for a given Δt.
   pure subroutine add_damping_matrix(blocks, step, b, matrix)
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step      !< the present step
      integer, intent(in) :: b                 !< number of the block
      real(wp), intent(inout) :: matrix(6, 6)  !< diagonal block of K̂

      matrix(4:6, 4:6) = matrix(4:6, 4:6) &
         + damping_factor(blocks, step, b)*blocks%interior_fraction(b)*blocks%stiffness(:, :, b)
      associate (damping => blocks%damping(blocks%material(b)))
         if (damping%alpha > 0.0_wp) matrix = matrix + damping%alpha/step%time_step &
            *mass_matrix(blocks%inertia(:, b))
      end associate
   end subroutine add_damping_matrix

   !> Return the damping part of the factor by which K̂ contains the elastic matrix of block b.
   pure real(wp) function damping_factor(blocks, step, b) result(factor)
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step      !< the present step
      integer, intent(in) :: b                 !< number of the block
      integer :: l

      associate (damping => blocks%damping(blocks%material(b)))
         factor = 0.0_wp
         if (damping%by_law) return
         factor = damping%unrelaxed - 1.0_wp
         do l = 1, damping%n
            factor = factor - damping%unrelaxed*following(damping, l, step%time_step)
         end do
         factor = step%scheme%theta*factor + damping%beta/step%time_step
      end associate
   end function damping_factor

   !> Return the strain whose elastic stress equals the damping stress at d = 0.
   pure function damping_strain(blocks, step, b) result(strain)
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step      !< the present step
      integer, intent(in) :: b                 !< number of the block
      real(wp) :: strain(3)
      integer :: l

      strain = 0.0_wp
      associate (damping => blocks%damping(blocks%material(b)))
         if (damping%n == 0 .or. damping%by_law) return
         do l = 1, damping%n
            strain = strain + relaxation_change(blocks, damping, b, l, step%time_step)
         end do
         strain = memory_strain(blocks, b) - step%scheme%theta*damping%unrelaxed*strain
      end associate
   end function damping_strain

   !> Return the generalised forces of the stress of block b at t₀ + θΔt of a step with known d.
   !> The stress acts on the whole area of the block, including the triangles of faces.
   pure function force_on_strains(blocks, step, b, d) result(force)
      type(blocks_type), intent(in) :: blocks  !< blocks at the start of the step
      type(step_type), intent(in) :: step      !< the present step
      integer, intent(in) :: b                 !< number of the block
      real(wp), intent(in) :: d(6)             !< increments of the coordinates
      real(wp) :: force(3), strain(3)

      strain = blocks%position(4:6, b) + step%scheme%theta*d(4:6)
      if (blocks%damps) strain = strain + damping_strain(blocks, step, b) &
         + damping_factor(blocks, step, b)*d(4:6)
      force = -matmul(blocks%stiffness(:, :, b), strain) &
         - blocks%area(b)*blocks%initial_stress(:, b)
   end function force_on_strains

   !> Add the losses of block b in a step, before ζ_l is updated.
   pure subroutine add_damping_loss(blocks, step, b, d, material, scheme)
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step      !< the present step
      integer, intent(in) :: b                 !< number of the block
      real(wp), intent(in) :: d(6)             !< increments of the coordinates
      real(wp), intent(inout) :: material      !< loss by damping, J per metre of thickness
      real(wp), intent(inout) :: scheme        !< Δσ·Δε of the damping stress, J per metre
      real(wp) :: change(3), total(3)
      integer :: l

      associate (damping => blocks%damping(blocks%material(b)), dt => step%time_step, &
         stiffness => blocks%interior_fraction(b)*blocks%stiffness(:, :, b))
         if (damping%by_law) return
         total = (damping%unrelaxed - 1.0_wp)*d(4:6)
         do l = 1, damping%n
            change = relaxation_change(blocks, damping, b, l, dt) + following(damping, l, dt)*d(4:6)
            total = total - damping%unrelaxed*change
            material = material + damping%unrelaxed*dot_product(change, matmul(stiffness, change)) &
               /(damping%weight(l)*damping%omega(l)*dt)
         end do
         scheme = scheme + dot_product(d(4:6), matmul(stiffness, total))
         material = material + damping%beta/dt*dot_product(d(4:6), matmul(stiffness, d(4:6)))
         if (damping%alpha > 0.0_wp) material = material + damping%alpha/dt &
            *dot_product(d, momentum_of(blocks%inertia(:, b), d))
      end associate
   end subroutine add_damping_loss

   !> Return the energy in the Maxwell branches of block b minus ½ ε·Kε, J per metre of thickness.
   pure real(wp) function energy_of_block(blocks, b) result(energy)
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      integer, intent(in) :: b                 !< number of the block
      real(wp) :: strain(3), sum_of(3)
      integer :: l

      energy = 0.0_wp
      associate (damping => blocks%damping(blocks%material(b)))
         if (damping%n == 0 .or. damping%by_law) return
         sum_of = 0.0_wp
         do l = 1, damping%n
            associate (memory => blocks%memory(:, l, b))
               sum_of = sum_of + memory
               energy = energy + 0.5_wp*damping%unrelaxed/damping%weight(l) &
                  *dot_product(memory, matmul(blocks%stiffness(:, :, b), memory))
            end associate
         end do
         strain = blocks%position(4:6, b) - blocks%rest_strain(:, b)
         energy = energy + dot_product(strain, matmul(blocks%stiffness(:, :, b), &
            0.5_wp*(damping%unrelaxed - 1.0_wp)*strain - damping%unrelaxed*sum_of))
         energy = blocks%interior_fraction(b)*energy
      end associate
   end function energy_of_block

   !> Return the change of ζ of block b within the step at constant strain, 2h/(1 + h) (Y e₀ − ζ).
   pure function relaxation_change(blocks, damping, b, l, time_step)
      type(blocks_type), intent(in) :: blocks    !< blocks at the start of the step
      type(damping_type), intent(in) :: damping  !< damping of the block
      integer, intent(in) :: b, l                !< block; mechanism
      real(wp), intent(in) :: time_step          !< Δt, s
      real(wp) :: relaxation_change(3)

      associate (h => 0.5_wp*damping%omega(l)*time_step)
         relaxation_change = 2.0_wp*h/(1.0_wp + h)*(damping%weight(l)*(blocks%position(4:6, b) &
            - blocks%rest_strain(:, b)) - blocks%memory(:, l, b))
      end associate
   end function relaxation_change

end module dda_material_damping
