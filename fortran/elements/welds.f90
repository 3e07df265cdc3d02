! SPDX-License-Identifier: GPL-3.0-or-later
!> Welded faces of bodies: springs between cells, which act at t₀ + θΔt like the elasticity of
!> blocks.
!>
!> Jumps are measured in axes that turn with the mean rotation of both cells.  The local variables q
!> of a face are therefore constant when its body turns, and its forces have no resultant and no
!> moment.  With G = ∂q/∂x for the twelve coordinates x, they are −Gᵀf, f = Σ c w s + f₀, s = w·q.
!> f₀ is the force at q = 0: initial stress, and stress retained when a material changes.
module dda_welds
   use dda_kinds, only: wp
   use dda_archive, only: archive_type, archive_values => serialise
   use dda_blocks, only: blocks_type, position_of, set_axes
   use dda_element, only: element_type
   use dda_energy, only: energy_type, add_energy, energy_algorithmic, energy_material_damping, &
      energy_welded
   use dda_linear_terms, only: linear_term_type, linear_terms_type, add_term, at_damping, &
      at_theta, term_weld
   use dda_material, only: material_type, elasticity
   use dda_scheme, only: step_type
   use dda_weld, only: weld_type, is_shifted, is_intact
   use dda_weld_damping, only: damped_fractions, damping_factor, memory_stretch, relaxing_stretch, &
      damping_energy, add_damping_loss, change_memory
   use dda_weld_springs, only: weld_springs_type, springs_of, n_deformations, max_springs, &
      cell_strain
   implicit none
   private
   public :: welds_type, new_welds, add_face_stress, add_jump_energies, deformations_of, &
      derivatives_of, weld_force

   !> All welded faces.
   type, extends(element_type) :: welds_type
      type(weld_type), allocatable :: weld(:)
      type(weld_springs_type), allocatable :: springs(:)  !< [faces]
      real(wp), allocatable :: force(:,:)                 !< [deformations,faces] f₀
      integer, allocatable :: material(:,:)               !< [2,faces] material of both cells
      !> [2,faces] damped fractions of springs, by material
      real(wp), allocatable :: damping_fraction(:,:)
      real(wp), allocatable :: hysteretic_fraction(:,:)  !< [2,faces] the same, with damping by laws
      real(wp), allocatable :: static_deformation(:,:)  !< [deformations,faces] q after statics
      !> [mechanisms,springs,2,faces] ζ_l of both materials; empty: no damping
      real(wp), allocatable :: memory(:,:,:,:)
   contains
      procedure :: add_linear_terms, add_force, add_stored_energy, add_to_budget, accept_step, &
         inherit_state, balance_reactions, serialise, add_face_force
   end type welds_type

   !> A face and its cells in a configuration.
   type :: configuration_type
      real(wp) :: turn(2, 2)           !< R_fᵀ, from the model's axes to those of the face
      real(wp) :: axes(2, 2, 2)        !< R of both cells
      real(wp) :: gradient(2, 2, 2)    !< R(I + ε) of both cells
      real(wp) :: jump(2, 2)           !< [u] and [u]_l in the model's axes, m
   end type configuration_type

contains

   !> Create welded faces with the initial stress of their blocks.
   type(welds_type) function new_welds(welds, blocks, materials, plane_strain) result(self)
      type(weld_type), intent(in) :: welds(:)  !< welds of the model
      type(blocks_type), intent(in) :: blocks  !< blocks with their materials
      type(material_type), intent(in) :: materials(:)  !< materials of the model
      logical, intent(in) :: plane_strain              !< plane strain; .false.: plane stress
      real(wp) :: moduli(3, 3, 2)
      integer :: i, k

      self%weld = welds
      allocate (self%springs(size(welds)), self%force(n_deformations, size(welds)), &
         self%material(2, size(welds)), self%damping_fraction(2, size(welds)), &
         self%hysteretic_fraction(2, size(welds)))
      do i = 1, size(welds)
         self%material(:, i) = blocks%material(welds(i)%block)
         do k = 1, 2
            moduli(:, :, k) = elasticity(materials(self%material(k, i)), plane_strain)
         end do
         self%springs(i) = springs_of(welds(i), moduli)
         self%force(:, i) = initial_force(welds(i), blocks%initial_stress(:, welds(i)%block))
         self%hysteretic_fraction(:, i) = damped_fractions(welds(i), self%material(:, i), &
            [moduli(1, 1, 1), moduli(1, 1, 2)], blocks%damping)
         self%damping_fraction(:, i) = self%hysteretic_fraction(:, i)
         if (size(blocks%damping) == 0) cycle
         where (blocks%damping(self%material(:, i))%by_law) self%damping_fraction(:, i) = 0.0_wp
      end do
      call begin_memory(self, blocks)
   end function new_welds

   !> Reset the memory of the springs: extensions are measured from the present state.
   pure subroutine begin_memory(self, blocks)
      class(welds_type), intent(inout) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks   !< blocks in their present state
      integer :: i

      if (allocated(self%memory)) deallocate (self%memory, self%static_deformation)
      if (all(self%damping_fraction <= 0.0_wp)) then
         allocate (self%memory(0, max_springs, 2, 0), self%static_deformation(n_deformations, 0))
         return
      end if
      allocate (self%memory(maxval(blocks%damping%n), max_springs, 2, size(self%weld)), &
         source=0.0_wp)
      allocate (self%static_deformation(n_deformations, size(self%weld)))
      do i = 1, size(self%weld)
         self%static_deformation(:, i) = deformations_of(self%weld(i), blocks)
      end do
   end subroutine begin_memory

   !> .true. if the springs of face i damp in a step.
   pure logical function is_damped(self, i, blocks)
      class(welds_type), intent(in) :: self    !< elements of this kind
      integer, intent(in) :: i                 !< number of the face
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state

      is_damped = blocks%damps .and. any(self%damping_fraction(:, i) > 0.0_wp)
   end function is_damped

   !> Return the damping forces on the deformations of face i.
   !> If `step` is present, they include θ × the relaxation in the step.
   pure function damping_force(self, i, blocks, q, step) result(force)
      class(welds_type), intent(in) :: self    !< elements of this kind
      integer, intent(in) :: i                 !< number of the face
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      real(wp), intent(in) :: q(n_deformations) !< deformations
      type(step_type), intent(in), optional :: step  !< the present step
      real(wp) :: force(n_deformations), stretch, e
      integer :: j, k

      force = 0.0_wp
      if (.not. is_damped(self, i, blocks)) return
      associate (springs => self%springs(i))
         do j = 1, springs%n
            e = dot_product(springs%weight(:, j), q - self%static_deformation(:, i))
            stretch = 0.0_wp
            do k = 1, 2
               if (.not. self%damping_fraction(k, i) > 0.0_wp) cycle
               associate (law => blocks%damping(self%material(k, i)), &
                  memory => self%memory(:, j, k, i))
                  stretch = stretch + self%damping_fraction(k, i)*memory_stretch(law, e, memory)
                  if (present(step)) stretch = stretch - self%damping_fraction(k, &
                     i)*step%scheme%theta*relaxing_stretch(law, e, memory, step%time_step)
               end associate
            end do
            force = force + springs%stiffness(j)*stretch*springs%weight(:, j)
         end do
      end associate
   end function damping_force

   !> Return three damping energies of face i, J per metre of thickness: stored at the end of the
   !> step; lost by the materials; Δσ·Δε of the damping stresses.
   pure function damping_energies(self, i, blocks, q, change, time_step) result(energy)
      class(welds_type), intent(in) :: self    !< elements of this kind
      integer, intent(in) :: i                 !< number of the face
      type(blocks_type), intent(in) :: blocks  !< blocks at the start of the step
      real(wp), intent(in) :: q(n_deformations)  !< deformations at the start
      real(wp), intent(in), optional :: change(n_deformations)  !< increment of q in a step
      real(wp), intent(in), optional :: time_step               !< Δt of that step, s
      real(wp) :: energy(3), end_memory(size(self%memory, 1)), e, increment
      integer :: j, k

      energy = 0.0_wp
      if (.not. is_damped(self, i, blocks)) return
      increment = 0.0_wp
      do j = 1, self%springs(i)%n
         associate (weight => self%springs(i)%weight(:, j))
            e = dot_product(weight, q - self%static_deformation(:, i))
            if (present(change)) increment = dot_product(weight, change)
         end associate
         do k = 1, 2
            if (.not. self%damping_fraction(k, i) > 0.0_wp) cycle
            associate (law => blocks%damping(self%material(k, i)), &
               stiffness => self%damping_fraction(k, i)*self%springs(i)%stiffness(j), &
               memory => self%memory(:, j, k, i))
               end_memory = memory
               if (present(change)) then
                  call change_memory(law, e, increment, time_step, end_memory)
                  call add_damping_loss(law, stiffness, increment, end_memory - memory, time_step, &
                     energy(2:3))
               end if
               energy(1) = energy(1) + stiffness*damping_energy(law, e + increment, end_memory)
            end associate
         end do
      end do
   end function damping_energies

   !> Return the force f₀ of initial stresses on the deformations of a face.
   !> It is A_i σ_f and A_j σ_f on the strains and −L σ_f n on the jump; σ_f is the mean by area.
   pure function initial_force(weld, stress) result(force)
      type(weld_type), intent(in) :: weld    !< face
      real(wp), intent(in) :: stress(3, 2)   !< stress of both cells, Pa
      real(wp) :: force(n_deformations), mean(3)
      integer :: k

      force = 0.0_wp
      mean = matmul(stress, weld%area)/sum(weld%area)
      associate (nx => weld%along(2), ny => -weld%along(1))
         force(1:2) = -weld%length*[mean(1)*nx + mean(3)*ny, mean(3)*nx + mean(2)*ny]
      end associate
      do k = 1, 2
         force(cell_strain(:, k)) = weld%area(k)*mean
      end do
   end function initial_force

   !> .true. if the face is intact and both cells exist.
   pure logical function is_active(weld, blocks)
      type(weld_type), intent(in) :: weld      !< face
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state

      is_active = is_intact(weld) .and. .not. any(blocks%removed(weld%block))
   end function is_active

   !> Return the deformations of a face in the present state.
   pure function deformations_of(weld, blocks) result(q)
      type(weld_type), intent(in) :: weld      !< face
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      real(wp) :: q(n_deformations)             !< m, strains
      type(configuration_type) :: cells
      integer :: k

      cells = predicted_cells(weld, blocks, 0.0_wp)
      q(1:2) = matmul(cells%turn, cells%jump(:, 1))
      q(3:4) = matmul(cells%turn, cells%jump(:, 2))
      do k = 1, 2
         q(cell_strain(:, k)) = blocks%position(4:6, weld%block(k))
      end do
   end function deformations_of

   !> Predict both cells at a later time from their present rates.
   pure type(configuration_type) function predicted_cells(weld, blocks, interval) result(cells)
      type(weld_type), intent(in) :: weld      !< face
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      real(wp), intent(in) :: interval            !< s
      real(wp) :: coordinates(6, 2), angle
      integer :: k, b

      associate (half => 0.5_wp*weld%length*weld%along, jump => cells%jump)
         do k = 1, 2
            b = weld%block(k)
            coordinates(:, k) = blocks%position(:, b)
            if (abs(interval) > 0.0_wp) then
               coordinates(:, k) = coordinates(:, k) + interval*blocks%velocity(:, b)
               call set_axes(coordinates(:, k), cells%axes(:, :, k), cells%gradient(:, :, k))
            else
               cells%axes(:, :, k) = blocks%axes(:, :, b)
               cells%gradient(:, :, k) = blocks%gradient(:, :, b)
            end if
         end do
         jump(:, 1) = coordinates(1:2, 1) - coordinates(1:2, 2) - weld%shift &
            + (matmul(cells%gradient(:, :, 1), weld%middle(:, 1)) &
            - matmul(cells%gradient(:, :, 2), weld%middle(:, 2)))
         jump(:, 2) = matmul(cells%gradient(:, :, 1) - cells%gradient(:, :, 2), half)
      end associate
      angle = 0.5_wp*(coordinates(3, 1) + coordinates(3, 2))
      cells%turn = reshape([cos(angle), -sin(angle), sin(angle), cos(angle)], [2, 2])
   end function predicted_cells

   !> Return the matrix G of a face at the middle of a step, predicted from present rates.
   !> If a body turns at a rate ω, the increment of q has an error of order (ωΔt)³.
   pure function derivatives_of(weld, blocks, step) result(g)
      type(weld_type), intent(in) :: weld      !< face
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step      !< the present step
      real(wp) :: g(n_deformations, 6, 2)
      type(configuration_type) :: cells
      real(wp) :: rotated_axes(2, 2)
      integer :: i, k

      cells = predicted_cells(weld, blocks, 0.5_wp*step%time_step)
      ! The axes turn by half of the rotation of each cell.
      rotated_axes = 0.5_wp*matmul(cells%turn, reshape([cells%jump(2, 1), -cells%jump(1, 1), &
         cells%jump(2, 2), -cells%jump(1, 2)], [2, 2]))
      g = 0.0_wp
      do k = 1, 2
         associate (sign => 3.0_wp - 2.0_wp*k)
            g(1:2, 1:2, k) = sign*cells%turn
            g(1:2, 3:6, k) = sign*matmul(cells%turn, shape_columns(cells, k, weld%middle(:, k)))
            g(3:4, 3:6, k) = sign*matmul(cells%turn, shape_columns(cells, k, &
               0.5_wp*weld%length*weld%along))
         end associate
         g(1:2, 3, k) = g(1:2, 3, k) + rotated_axes(:, 1)
         g(3:4, 3, k) = g(3:4, 3, k) + rotated_axes(:, 2)
         do i = 1, 3
            g(cell_strain(i, k), 3 + i, k) = 1.0_wp
         end do
      end do
   end function derivatives_of

   !> Return the effect of rotation and strains of cell k on an offset ρ: the last 4 columns of T.
   pure function shape_columns(cells, k, reference) result(shape)
      type(configuration_type), intent(in) :: cells    !< both cells
      integer, intent(in) :: k               !< cell, 1 or 2
      real(wp), intent(in) :: reference(2)   !< ρ, m
      real(wp) :: shape(2, 4), offset(2)

      offset = matmul(cells%gradient(:, :, k), reference)
      associate (axes => cells%axes(:, :, k))
         shape(:, 1) = [-offset(2), offset(1)]
         shape(:, 2) = axes(:, 1)*reference(1)
         shape(:, 3) = axes(:, 2)*reference(2)
         shape(:, 4) = 0.5_wp*(axes(:, 1)*reference(2) + axes(:, 2)*reference(1))
      end associate
   end function shape_columns

   !> Return the force f = Σ c w s + f₀.
   pure function spring_force(springs, constant_part, q) result(force)
      type(weld_springs_type), intent(in) :: springs     !< of a face
      real(wp), intent(in) :: constant_part(n_deformations)      !< f₀
      real(wp), intent(in) :: q(n_deformations)           !< deformations
      real(wp) :: force(n_deformations)
      integer :: i

      force = constant_part
      do i = 1, springs%n
         force = force + springs%stiffness(i)*dot_product(springs%weight(:, i), q) &
            *springs%weight(:, i)
      end do
   end function spring_force

   !> Append the springs of all faces.
   subroutine add_linear_terms(self, blocks, step, terms)
      class(welds_type), intent(in) :: self            !< elements of this kind
      type(blocks_type), intent(in) :: blocks          !< blocks in their present state
      type(step_type), intent(in) :: step              !< the present step
      type(linear_terms_type), intent(inout) :: terms  !< springs and dashpots
      type(linear_term_type) :: term
      real(wp) :: g(n_deformations, 6, 2), factor, damped(2)
      integer :: i, k

      term%kind = term_weld
      do i = 1, size(self%weld)
         if (.not. is_active(self%weld(i), blocks)) cycle
         g = derivatives_of(self%weld(i), blocks, step)
         term%source = i
         term%block_a = self%weld(i)%block(1)
         term%block_b = self%weld(i)%block(2)
         term%damped_fraction = self%hysteretic_fraction(:, i)
         if (term%block_a == term%block_b) then  ! image of the same block
            term%block_b = 0
            term%damped_fraction = [sum(self%hysteretic_fraction(:, i)), 0.0_wp]
            g(:, :, 1) = g(:, :, 1) + g(:, :, 2)
         end if
         damped = term%damped_fraction
         term%position = position_of(blocks, term%block_a, self%weld(i)%middle(:, 1))
         associate (springs => self%springs(i))
            factor = 0.0_wp
            if (is_damped(self, i, blocks)) factor = sum([(self%damping_fraction(k, &
               i)*damping_factor(blocks%damping(self%material(k, i)), step), k=1, 2)])
            do k = 1, springs%n
               term%instant = at_theta
               term%coefficient = springs%stiffness(k)
               term%row_a = matmul(springs%weight(:, k), g(:, :, 1))
               term%row_b = -matmul(springs%weight(:, k), g(:, :, 2))
               term%damped_fraction = damped
               call add_term(terms, term)
               if (.not. abs(factor) > 0.0_wp) cycle
               term%instant = at_damping
               term%coefficient = factor*springs%stiffness(k)
               term%damped_fraction = 0.0_wp
               call add_term(terms, term)
            end do
         end associate
      end do
   end subroutine add_linear_terms

   !> Add the forces −Gᵀf of each face.
   subroutine add_force(self, blocks, step, load)
      class(welds_type), intent(in) :: self        !< elements of this kind
      type(blocks_type), intent(in) :: blocks      !< blocks in their present state
      type(step_type), intent(in) :: step          !< the present step
      real(wp), intent(inout) :: load(:,:)         !< [6,blocks] forces, N/m …
      real(wp) :: g(n_deformations, 6, 2), q(n_deformations), force(n_deformations)
      integer :: i, k, b

      do i = 1, size(self%weld)
         if (.not. is_active(self%weld(i), blocks)) cycle
         g = derivatives_of(self%weld(i), blocks, step)
         q = deformations_of(self%weld(i), blocks)
         force = spring_force(self%springs(i), self%force(:, i), q) &
            + damping_force(self, i, blocks, q, step)
         do k = 1, 2
            b = self%weld(i)%block(k)
            load(:, b) = load(:, b) - matmul(force, g(:, :, k))
         end do
      end do
   end subroutine add_force

   !> Add the forces of images on the cells of one side, at t₀ + θΔt of a step with a known d.
   subroutine add_face_force(self, side, blocks, step, d, load)
      class(welds_type), intent(in) :: self    !< elements of this kind
      integer, intent(in) :: side              !< side of each face, 1 or 2
      type(blocks_type), intent(in) :: blocks  !< blocks at the start of the step
      type(step_type), intent(in) :: step      !< the present step
      real(wp), intent(in) :: d(:,:)           !< [6,blocks] increments of the coordinates
      real(wp), intent(inout) :: load(:,:)     !< [6,blocks] forces, N/m …
      real(wp) :: g(n_deformations, 6, 2), q(n_deformations), change(n_deformations)
      real(wp) :: force(n_deformations), none(n_deformations), factor
      integer :: i, k

      none = 0.0_wp
      do i = 1, size(self%weld)
         if (.not. is_shifted(self%weld(i))) cycle
         g = derivatives_of(self%weld(i), blocks, step)
         q = deformations_of(self%weld(i), blocks)
         factor = step%scheme%theta
         if (is_damped(self, i, blocks)) factor = factor + sum([(self%damping_fraction(k, &
            i)*damping_factor(blocks%damping(self%material(k, i)), step), k=1, 2)])
         associate (block => self%weld(i)%block)
            change = matmul(g(:, :, 1), d(:, block(1))) + matmul(g(:, :, 2), d(:, block(2)))
            force = spring_force(self%springs(i), self%force(:, i), q) + damping_force(self, i, &
               blocks, q, step) + factor*spring_force(self%springs(i), none, change)
            load(:, block(side)) = load(:, block(side)) - matmul(force, g(:, :, side))
         end associate
      end do
   end subroutine add_face_force

   !> Return the energy ½ Σ c s² + f₀·q.
   pure real(wp) function spring_energy(springs, constant_part, q) result(energy)
      type(weld_springs_type), intent(in) :: springs  !< of a face
      real(wp), intent(in) :: constant_part(n_deformations)   !< f₀
      real(wp), intent(in) :: q(n_deformations)        !< deformations

      energy = 0.5_wp*dot_product(spring_force(springs, constant_part, q) + constant_part, q)
   end function spring_energy

   !> Add the stored energy of all faces, including that of their damping.
   subroutine add_stored_energy(self, blocks, step, energy)
      class(welds_type), intent(in) :: self        !< elements of this kind
      type(blocks_type), intent(in) :: blocks      !< blocks in their present state
      type(step_type), intent(in) :: step          !< the next step
      type(energy_type), intent(inout) :: energy   !< energy budget, J per metre
      real(wp) :: q(n_deformations), total, damped(3)
      integer :: i

      total = 0.0_wp
      do i = 1, size(self%weld)
         if (.not. is_active(self%weld(i), blocks)) cycle
         q = deformations_of(self%weld(i), blocks)
         damped = damping_energies(self, i, blocks, q)
         total = total + spring_energy(self%springs(i), self%force(:, i), q) + damped(1)
      end do
      call add_energy(energy, energy_welded, total)
   end subroutine add_stored_energy

   !> Add the energy at the end of the step, and the loss (θ − ½) Σ c Δs² of the scheme.
   subroutine add_to_budget(self, blocks, step, d, energy)
      class(welds_type), intent(in) :: self        !< elements of this kind
      type(blocks_type), intent(in) :: blocks      !< blocks in their present state
      type(step_type), intent(in) :: step          !< the present step
      real(wp), intent(in) :: d(:,:)               !< [6,blocks] increments of the coordinates
      type(energy_type), intent(inout) :: energy   !< energy budget, J per metre
      real(wp) :: g(n_deformations, 6, 2), q(n_deformations), change(n_deformations)
      real(wp) :: none(n_deformations), total, loss, damped(3)
      integer :: i

      none = 0.0_wp
      total = 0.0_wp
      loss = 0.0_wp
      damped = 0.0_wp
      do i = 1, size(self%weld)
         if (.not. is_active(self%weld(i), blocks)) cycle
         q = deformations_of(self%weld(i), blocks)
         g = derivatives_of(self%weld(i), blocks, step)
         associate (a => self%weld(i)%block(1), b => self%weld(i)%block(2))
            change = matmul(g(:, :, 1), d(:, a)) + matmul(g(:, :, 2), d(:, b))
         end associate
         damped = damped + damping_energies(self, i, blocks, q, change, step%time_step)
         total = total + spring_energy(self%springs(i), self%force(:, i), q + change)
         loss = loss + 2.0_wp*spring_energy(self%springs(i), none, change)
      end do
      call add_energy(energy, energy_welded, total + damped(1))
      call add_energy(energy, energy_material_damping, damped(2))
      call add_energy(energy, energy_algorithmic, (step%scheme%theta - 0.5_wp)*(loss + damped(3)))
   end subroutine add_to_budget

   !> Accept the step: update the memories of the springs.
   subroutine accept_step(self, blocks, step, d)
      class(welds_type), intent(inout) :: self     !< elements of this kind
      type(blocks_type), intent(in) :: blocks      !< blocks at the start of the step
      type(step_type), intent(in) :: step          !< the present step
      real(wp), intent(in) :: d(:,:)               !< [6,blocks] increments of the coordinates
      real(wp) :: g(n_deformations, 6, 2), q(n_deformations), change(n_deformations)
      integer :: i, j, k

      do i = 1, size(self%weld)
         if (.not. is_damped(self, i, blocks)) cycle
         if (.not. is_active(self%weld(i), blocks)) cycle
         q = deformations_of(self%weld(i), blocks) - self%static_deformation(:, i)
         g = derivatives_of(self%weld(i), blocks, step)
         associate (a => self%weld(i)%block(1), b => self%weld(i)%block(2), &
            weight => self%springs(i)%weight)
            change = matmul(g(:, :, 1), d(:, a)) + matmul(g(:, :, 2), d(:, b))
            do j = 1, self%springs(i)%n
               do k = 1, 2
                  if (self%damping_fraction(k, i) > 0.0_wp) call change_memory( &
                     blocks%damping(self%material(k, i)), &
                     dot_product(weight(:, j), q), dot_product(weight(:, j), change), &
                     step%time_step, self%memory(:, j, k, i))
               end do
            end do
         end associate
      end do
   end subroutine accept_step

   !> Start the memory of the springs at the deformations in static equilibrium.
   subroutine balance_reactions(self, blocks, unbalanced)
      class(welds_type), intent(inout) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks   !< blocks in static equilibrium
      real(wp), intent(in) :: unbalanced(:,:)   !< [6,blocks] sum of all forces, N/m …

      call begin_memory(self, blocks)
   end subroutine balance_reactions

   !> Inherit the present forces; a change of moduli does not change them.
   subroutine inherit_state(self, former, blocks)
      class(welds_type), intent(inout) :: self   !< elements of this kind
      class(element_type), intent(in) :: former  !< former element, of the same type
      type(blocks_type), intent(in) :: blocks    !< blocks in their present state
      real(wp) :: q(n_deformations), none(n_deformations)
      integer :: i

      none = 0.0_wp
      select type (former)
      class is (welds_type)
         do i = 1, size(self%weld)
            if (all(self%material(:, i) == former%material(:, i))) then
               self%force(:, i) = former%force(:, i)
               if (size(self%memory, 4) > 0 .and. size(former%memory, 4) > 0) then
                  self%memory(:, :, :, i) = former%memory(:, :, :, i)
                  self%static_deformation(:, i) = former%static_deformation(:, i)
               end if
            else
               q = deformations_of(self%weld(i), blocks)
               self%force(:, i) = spring_force(former%springs(i), former%force(:, i), q) &
                  + damping_force(former, i, blocks, q) - spring_force(self%springs(i), none, q)
            end if
         end do
      end select
   end subroutine inherit_state

   !> Save or restore the forces f₀ and the memory of the springs.
   subroutine serialise(self, archive)
      class(welds_type), intent(inout) :: self       !< elements of this kind
      type(archive_type), intent(inout) :: archive   !< archive that is written or read

      call archive_values(archive, self%force)
      call archive_values(archive, self%static_deformation)
      call archive_values(archive, self%memory)
   end subroutine serialise

   !> Return the forces on the deformations of face i in the present state.
   pure function weld_force(self, i, blocks) result(force)
      class(welds_type), intent(in) :: self    !< elements of this kind
      integer, intent(in) :: i                 !< number of the face
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      real(wp) :: force(n_deformations), q(n_deformations)

      q = deformations_of(self%weld(i), blocks)
      force = spring_force(self%springs(i), self%force(:, i), q) + damping_force(self, i, blocks, q)
   end function weld_force

   !> Add the contribution of faces to the mean stress of their cells, Pa, in the axes of the cell.
   !> The contribution is the force on the strains of the cell over its area.
   pure subroutine add_face_stress(self, blocks, stress)
      class(welds_type), intent(in) :: self    !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      real(wp), intent(inout) :: stress(:,:)   !< [3,blocks] Pa
      real(wp) :: force(n_deformations)
      integer :: i, k, b

      do i = 1, size(self%weld)
         if (.not. is_active(self%weld(i), blocks)) cycle
         force = weld_force(self, i, blocks)
         do k = 1, 2
            b = self%weld(i)%block(k)
            stress(:, b) = stress(:, b) + force(cell_strain(:, k))/blocks%area(b)
         end do
      end do
   end subroutine add_face_stress

   !> Add half of the jump energy of each face to each of its cells, and sum the energy of faces.
   !> Jump energy η² = Σ (L/h) μ (|[u]|² + |[u]_l|²/3); energy ½ Σ c s²; J per metre of thickness.
   pure subroutine add_jump_energies(self, blocks, error, strain_energy)
      type(welds_type), intent(in) :: self       !< elements of this kind
      type(blocks_type), intent(in) :: blocks    !< blocks in their present state
      real(wp), intent(inout) :: error(:)        !< [blocks] η²
      real(wp), intent(inout) :: strain_energy          !< energy of all faces
      real(wp) :: q(n_deformations), none(n_deformations), half
      integer :: i, k, b

      none = 0.0_wp
      do i = 1, size(self%weld)
         if (.not. is_active(self%weld(i), blocks)) cycle
         q = deformations_of(self%weld(i), blocks)
         ! The last four springs belong to the mean jump and the linear jump.
         associate (springs => self%springs(i))
            half = 0.5_wp*springs%stiffness(springs%n - 3)*(sum(q(1:2)**2) + sum(q(3:4)**2)/3.0_wp)
            strain_energy = strain_energy + spring_energy(springs, none, q)
         end associate
         do k = 1, 2
            b = self%weld(i)%block(k)
            error(b) = error(b) + half
         end do
      end do
   end subroutine add_jump_energies

end module dda_welds
