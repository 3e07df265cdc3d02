! SPDX-License-Identifier: GPL-3.0-or-later
!> Strain points of materials that have a law of their own (`dda_material_law`): blocks, rests of
!> cells, sides of welded faces, and, where a law limits them, the mean and the linear jump of these
!> faces, whose law is `dda_jump_law`; and the points of broken faces, whose law is `dda_crack_law`.
!>
!> Blocks and welded faces are linear elastic; a point adds what its law has beyond that, c = s −
!> θDΔε − Dε.  It is solved by Newton's method: the step is solved with c linear about an increment,
!> and again about its solution, until c at the solution is the one that was solved with.  c is the
!> derivative of a potential less a quadratic one, so where the law is convex a step is the least of
!> a convex function, and `slope_beyond` makes its line search exact.
!>
!> Bounds that a law holds at the stress of a step are taken from the last solution until they agree
!> or a number of rounds has passed; they are then off by what the last round changed.
!>
!> At a face between two materials each side has its own strain, with the displacement of the face
!> that small strains give it (`dda_weld_springs`).
module dda_strain_points
   use dda_kinds, only: wp
   use dda_archive, only: archive_type, archive_values => serialise
   use dda_blocks, only: blocks_type
   use dda_crack_law, only: crack_law_type, is_spent
   use dda_element, only: element_type
   use dda_energy, only: energy_type, add_energy, energy_algorithmic, energy_fracture, &
      energy_friction, energy_law, energy_material, energy_plastic
   use dda_jump_law, only: jump_law_type
   use dda_linear_terms, only: linear_term_type, linear_terms_type, add_term, at_damping, &
      term_point
   use dda_material, only: material_type, elasticity
   use dda_material_law, only: material_law_type, strain_point_type, loss_damping, loss_plastic, &
      loss_scheme, losses
   use dda_motion, only: motion_type
   use dda_ordered_sums, only: parallel_from
   use dda_scheme, only: scheme_type, step_type
   use dda_overlap, only: weight
   use dda_weld, only: weld_type, is_shifted, is_whole, weld_cracked
   use dda_weld_springs, only: n_deformations, jump_stiffness, own_strain, strains_of
   use dda_welds, only: deformations_of, derivatives_of
   implicit none
   private
   public :: strain_points_type, new_strain_points, add_point_stress, bounds_are_off, &
      largest_plastic_strain, worst_point, points_force, strength_ratios, begin_crack, &
      crack_damage, crack_motion, crack_points

   real(wp), parameter :: tolerance = 1.0e-11_wp     !< of a stress, over the largest
   real(wp), parameter :: rounding = 1.0e-15_wp      !< of the elastic stress of a strain
   real(wp), parameter :: agreed = 1.0e-7_wp         !< of a stress in bounds, over the largest
   integer, parameter :: most_held = 15              !< rounds in which bounds are taken anew
   real(wp), parameter :: no_curvature = 1.0e-13_wp  !< of D: a tangent that is none
   integer, parameter :: crack_points = 3            !< of a broken face, by Lobatto
   real(wp), parameter :: places(crack_points) = [-1.0_wp, 0.0_wp, 1.0_wp]  !< ξ of them

   !> A law of a material.
   type :: slot_type
      class(material_law_type), allocatable :: law
   end type slot_type

   !> All points.
   type, extends(element_type) :: strain_points_type
      integer :: n = 0
      logical, allocatable :: active(:)                  !< [n] there is more than elasticity
      !> [materials + 1 + joints] of materials, of jumps, of faces that break
      type(slot_type), allocatable :: slot(:)
      integer, allocatable :: material(:)                !< [n]
      integer, allocatable :: block(:,:)                 !< [2,n] block and 0, or cells of the face
      integer, allocatable :: side(:,:)                  !< [2,n] points of a jump's face, else 0
      integer, allocatable :: crack(:)                   !< [n] point 1 … 3 of a broken face, else 0
      integer :: first_crack = 0                         !< points before those of broken faces
      real(wp), allocatable :: area(:)                   !< [n] m²; of jumps 1
      type(strain_point_type), allocatable :: point(:)   !< [n]
      type(weld_type), allocatable :: face(:)            !< [n]
      real(wp), allocatable :: map(:,:,:)                !< [3,deformations,n] its strain by these
      real(wp), allocatable :: reference(:,:)            !< [3,n] strain where the law began
      real(wp), allocatable :: carried(:,:)              !< [3,n] c that stays from laws before, Pa
      real(wp), allocatable :: state(:,:)                !< [any,n] of the laws
      logical :: static = .false.                        !< laws that rest do
      real(wp), allocatable :: rest(:,:)                 !< [3,n] ε at which they began to, else 0
      real(wp), allocatable :: kept(:,:)                 !< [3,n] c that they keep meanwhile, Pa
      real(wp), allocatable :: rest_energy(:)            !< [n] work of kept c, J/m³
      ! Of a step
      real(wp), allocatable :: operator(:,:,:,:)         !< [3,6,2,n] Δε by increments of blocks
      real(wp), allocatable :: strain(:,:)               !< [3,n] ε at its start
      real(wp), allocatable :: change(:,:)               !< [3,n] Δε about which c is linear
      real(wp), allocatable :: stress(:,:)               !< [3,n] c there, Pa
      real(wp), allocatable :: tangent(:,:,:)            !< [3,3,n] ∂c/∂Δε there, Pa
      integer :: round = 0                               !< solutions so far
      integer :: worst = 0                               !< of the last solution, 0: all agree
   contains
      procedure :: prepare
      procedure :: add_linear
      procedure :: add_force
      procedure :: slope_beyond
      procedure :: revise
      procedure :: add_stored
      procedure :: account
      procedure :: accept
      procedure :: inherit
      procedure :: freeze
      procedure :: serialise
      procedure :: add_face_force
   end type strain_points_type

contains

   !> The points of a model: of all blocks, of both sides of all welded faces, and of the jumps of
   !> these.
   type(strain_points_type) function new_strain_points(welds, blocks, materials, cracks, &
      plane_strain) result(self)
      type(weld_type), intent(in) :: welds(:)          !< of the model
      type(blocks_type), intent(in) :: blocks          !< in their present state
      type(material_type), intent(in) :: materials(:)  !< of the model
      type(crack_law_type), intent(in) :: cracks(:)    !< [joints] of faces that break
      logical, intent(in) :: plane_strain              !< else plane stress
      real(wp) :: moduli(3, 3, size(materials))
      integer :: m, most
      logical :: with_jumps

      allocate (self%slot(size(materials) + 1 + size(cracks)))
      allocate (jump_law_type :: self%slot(size(materials) + 1)%law)
      most = 0
      with_jumps = any(materials%yields())
      do m = 1, size(materials)
         moduli(:, :, m) = elasticity(materials(m), plane_strain)
         if (.not. allocated(materials(m)%own_law)) cycle
         allocate (self%slot(m)%law, source=materials(m)%own_law)
         most = max(most, materials(m)%own_law%state_size())
      end do
      do m = 1, size(cracks)
         allocate (self%slot(size(materials) + 1 + m)%law, source=cracks(m))
         most = max(most, cracks(m)%state_size())
      end do
      self%first_crack = blocks%n + merge(4, 2, with_jumps)*size(welds)
      call reserve(self, self%first_crack + merge(crack_points, 0, any(welds%joint > 0)) &
         *size(welds), most)
      self%point%plane_strain = plane_strain
      call set_block_points(self, blocks, moduli)
      call set_face_points(self, welds, blocks, moduli)
      if (with_jumps) call set_jump_points(self, welds, blocks, moduli)
      if (any(welds%joint > 0)) call set_crack_points(self, welds, size(materials) + 1)
   end function new_strain_points

   !> A material has a law of its own.
   pure logical function has_law(self, material)
      class(strain_points_type), intent(in) :: self  !< with its laws
      integer, intent(in) :: material                !< number

      has_law = allocated(self%slot(material)%law)
   end function has_law

   !> Arrays for n points with states of a size.
   subroutine reserve(self, n, states)
      class(strain_points_type), intent(inout) :: self  !< gets its arrays
      integer, intent(in) :: n, states                  !< points; numbers of a state

      self%n = n
      allocate (self%material(n), self%block(2, n), self%side(2, n), self%crack(n), source=0)
      allocate (self%point(n), self%face(n))
      allocate (self%active(n), source=.false.)
      allocate (self%area(n), self%map(3, n_deformations, n), self%reference(3, n), &
         self%carried(3, n), self%state(states, n), self%rest(3, n), self%kept(3, n), &
         self%rest_energy(n), self%operator(3, 6, 2, n), self%strain(3, n), self%change(3, n), &
         self%stress(3, n), self%tangent(3, 3, n), source=0.0_wp)
   end subroutine reserve

   !> Points of blocks, and of what welded faces leave of cells.
   subroutine set_block_points(self, blocks, moduli)
      class(strain_points_type), intent(inout) :: self  !< with its arrays
      type(blocks_type), intent(in) :: blocks           !< in their present state
      real(wp), intent(in) :: moduli(:,:,:)             !< [3,3,materials] D, Pa
      integer :: b

      do b = 1, blocks%n
         self%block(1, b) = b
         self%area(b) = blocks%rest_share(b)*blocks%area(b)
         call begin_point(self, b, blocks, blocks%material(b), moduli, blocks%initial_stress(:, b))
      end do
   end subroutine set_block_points

   !> Points of welded faces; one material has the first alone.
   subroutine set_face_points(self, welds, blocks, moduli)
      class(strain_points_type), intent(inout) :: self  !< with its arrays
      type(weld_type), intent(in) :: welds(:)           !< of the model
      type(blocks_type), intent(in) :: blocks           !< in their present state
      real(wp), intent(in) :: moduli(:,:,:)             !< [3,3,materials] D, Pa
      real(wp) :: map(3, n_deformations, 2), mean(3)
      integer :: i, k, p

      do i = 1, size(welds)
         associate (weld => welds(i), material => blocks%material(welds(i)%block))
            map = strains_of(weld, moduli(:, :, material))
            mean = matmul(blocks%initial_stress(:, weld%block), weld%area)/sum(weld%area)
            do k = 1, 2
               p = blocks%n + 2*(i - 1) + k
               self%block(:, p) = weld%block
               self%face(p) = weld
               self%map(:, :, p) = map(:, :, k)
               self%area(p) = weld%area(k)
               if (material(1) == material(2)) self%area(p) = merge(sum(weld%area), 0.0_wp, k == 1)
               call begin_point(self, p, blocks, material(k), moduli, mean)
            end do
         end associate
      end do
   end subroutine set_face_points

   !> Points of the jumps of welded faces, of the mean and the linear one.
   subroutine set_jump_points(self, welds, blocks, moduli)
      class(strain_points_type), intent(inout) :: self  !< with its arrays and other points
      type(weld_type), intent(in) :: welds(:)           !< of the model
      type(blocks_type), intent(in) :: blocks           !< in their present state
      real(wp), intent(in) :: moduli(:,:,:)             !< [3,3,materials] D, Pa
      real(wp) :: stiffness(2)
      integer :: i, j, k, p

      do i = 1, size(welds)
         stiffness = jump_stiffness(welds(i), moduli(:, :, blocks%material(welds(i)%block)))
         do k = 1, 2
            p = blocks%n + 2*size(welds) + 2*(i - 1) + k
            self%block(:, p) = welds(i)%block
            self%face(p) = welds(i)
            self%area(p) = 1.0_wp
            self%side(:, p) = blocks%n + 2*(i - 1) + [1, 2]
            self%material(p) = size(moduli, 3) + 1
            do j = 1, 2
               self%map(j, 2*(k - 1) + j, p) = 1.0_wp
               self%point(p)%elasticity(j, j) = stiffness(k)
            end do
            self%point(p)%length = 1.0_wp
            self%reference(:, p) = total_strain(self, p, blocks)
            self%point(p)%held = matmul(self%point(p)%elasticity, self%reference(:, p))
            self%active(p) = cap_of(self, p) < huge(1.0_wp)
         end do
      end do
   end subroutine set_jump_points

   !> Points of faces that can break: opening and slip by the deformations.
   subroutine set_crack_points(self, welds, before)
      class(strain_points_type), intent(inout) :: self  !< with its arrays and other points
      type(weld_type), intent(in) :: welds(:)           !< of the model
      integer, intent(in) :: before                     !< slots before those of joints
      integer :: i, k, p

      do i = 1, size(welds)
         if (welds(i)%joint == 0) cycle
         associate (along => welds(i)%along)
            do k = 1, crack_points
               p = self%first_crack + crack_points*(i - 1) + k
               self%crack(p) = k
               self%block(:, p) = welds(i)%block
               self%face(p) = welds(i)
               self%material(p) = before + welds(i)%joint
               self%area(p) = weight(crack_points, k)*welds(i)%length
               self%point(p)%length = self%area(p)
               select type (law => self%slot(self%material(p))%law)
               type is (crack_law_type)
                  self%point(p)%cap = maxval(law%springs())
               end select
               ! w = −[u] − ξ[u]_l, along n and along the face.
               self%map(1, 1:2, p) = -[along(2), -along(1)]
               self%map(2, 1:2, p) = -along
               self%map(:2, 3:4, p) = places(k)*self%map(:2, 1:2, p)
               self%active(p) = welds(i)%state == weld_cracked
               self%tangent(1, 1, p) = 1.0_wp  ! both cells are coupled
            end do
         end associate
      end do
   end subroutine set_crack_points

   !> What the jump of point p may carry in a step, N/m, by the points of its face at its start.
   pure real(wp) function cap_of(self, p) result(cap)
      class(strain_points_type), intent(in) :: self  !< with strains at the start of the step
      integer, intent(in) :: p                       !< point of a jump
      integer :: k

      cap = huge(1.0_wp)
      do k = 1, 2
         associate (side => self%side(k, p))
            if (.not. self%active(side)) cycle
            if (.not. has_law(self, self%material(side))) cycle
            cap = min(cap, self%slot(self%material(side))%law%jump_cap(self%point(side), &
               self%state(:, side), self%strain(:, side)))
         end associate
      end do
      if (cap < huge(1.0_wp)) cap = cap*self%face(p)%length
   end function cap_of

   !> The law of point p begins in the present state, under the elastic stress of its strain.
   subroutine begin_point(self, p, blocks, material, moduli, initial)
      class(strain_points_type), intent(inout) :: self  !< with blocks, area and map of the point
      integer, intent(in) :: p                          !< point
      type(blocks_type), intent(in) :: blocks           !< in their present state
      integer, intent(in) :: material                   !< of the point
      real(wp), intent(in) :: moduli(:,:,:)             !< [3,3,materials] D, Pa
      real(wp), intent(in) :: initial(3)                !< stress at no strain, Pa

      self%material(p) = material
      self%reference(:, p) = total_strain(self, p, blocks)
      self%point(p)%elasticity = moduli(:, :, material)
      self%point(p)%held = initial + matmul(moduli(:, :, material), self%reference(:, p))
      self%point(p)%length = sqrt(self%area(p))
      self%point(p)%thickness = self%point(p)%length
      if (self%block(2, p) > 0) self%point(p)%thickness = self%area(p)/self%face(p)%length
      self%active(p) = self%area(p) > 0.0_wp
      if (self%active(p)) self%active(p) = has_law(self, material)
   end subroutine begin_point

   !> Strain of point p in the present state, from the shape that was drawn on.
   pure function total_strain(self, p, blocks) result(strain)
      class(strain_points_type), intent(in) :: self  !< elements of this kind
      integer, intent(in) :: p                       !< point
      type(blocks_type), intent(in) :: blocks        !< in their present state
      real(wp) :: strain(3)

      if (self%block(2, p) == 0) then
         strain = blocks%position(4:6, self%block(1, p))
      else
         strain = matmul(self%map(:, :, p), deformations_of(self%face(p), blocks))
      end if
   end function total_strain

   !> Point p acts, and its blocks are there.
   pure logical function acts(self, p, blocks)
      class(strain_points_type), intent(in) :: self  !< elements of this kind
      integer, intent(in) :: p                       !< point
      type(blocks_type), intent(in) :: blocks        !< in their present state

      acts = self%active(p) .and. .not. blocks%removed(self%block(1, p))
      if (.not. acts .or. self%block(2, p) == 0) return
      acts = .not. blocks%removed(self%block(2, p))
      if (self%crack(p) > 0) then
         acts = acts .and. self%face(p)%state == weld_cracked
      else
         acts = acts .and. is_whole(self%face(p))
      end if
   end function acts

   !> Point p keeps its stress beyond elasticity, as its law rests in static stages.
   pure logical function resting(self, p)
      class(strain_points_type), intent(in) :: self  !< elements of this kind
      integer, intent(in) :: p                       !< point

      resting = self%static
      if (resting) resting = has_law(self, self%material(p))
      if (resting) resting = self%slot(self%material(p))%law%rests()
   end function resting

   !> c of point p in a step, and its derivative by Δε.
   pure subroutine respond(self, p, strain, change, step, stress, tangent)
      class(strain_points_type), intent(in) :: self      !< elements of this kind
      integer, intent(in) :: p                           !< point
      real(wp), intent(in) :: strain(3), change(3)       !< ε at the start, Δε
      type(step_type), intent(in) :: step                !< the one being taken
      real(wp), intent(out) :: stress(3), tangent(3, 3)  !< Pa

      stress = self%carried(:, p)
      tangent = 0.0_wp
      if (resting(self, p)) then
         stress = self%kept(:, p)
      else if (has_law(self, self%material(p))) then
         associate (theta => step%scheme%theta, d => self%point(p)%elasticity)
            call self%slot(self%material(p))%law%respond(self%point(p), self%state(:, p), strain, &
               change, step, stress, tangent)
            stress = stress - matmul(d, strain + theta*change) + self%carried(:, p)
            tangent = tangent - theta*d
         end associate
      end if
   end subroutine respond

   !> The largest plastic strain of all points of each block.
   pure function largest_plastic_strain(self, blocks) result(strain)
      class(strain_points_type), intent(in) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks        !< in their present state
      real(wp) :: strain(blocks%n), own
      integer :: p, k

      strain = 0.0_wp
      do p = 1, self%n
         if (.not. acts(self, p, blocks)) cycle
         if (.not. has_law(self, self%material(p))) cycle
         own = self%slot(self%material(p))%law%plastic_strain(self%state(:, p))
         do k = 1, count(self%block(:, p) > 0)
            associate (b => self%block(k, p))
               strain(b) = max(strain(b), own)
            end associate
         end do
      end do
   end function largest_plastic_strain

   !> Before a step: strains at its start, and c about an increment.
   subroutine prepare(self, blocks, step, d)
      class(strain_points_type), intent(inout) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks           !< at the start of the step
      type(step_type), intent(in) :: step               !< the one being taken
      real(wp), intent(in) :: d(:,:)                    !< [6,blocks] increments of the coordinates
      integer :: p

      self%round = 0
      !$omp parallel do schedule(static) if (self%n >= parallel_from)
      do p = 1, self%n
         if (acts(self, p, blocks)) &
            self%strain(:, p) = total_strain(self, p, blocks) - self%reference(:, p)
      end do
      !$omp parallel do schedule(static) if (self%n >= parallel_from)
      do p = 1, self%n
         if (.not. acts(self, p, blocks)) cycle
         if (self%side(1, p) > 0) self%point(p)%cap = cap_of(self, p)
         call hold_bounds(self, p, [0.0_wp, 0.0_wp, 0.0_wp], step, 0.0_wp)
         call set_operator(self, p, blocks, step)
         self%change(:, p) = change_of(self, p, d)
         call respond(self, p, self%strain(:, p), self%change(:, p), step, self%stress(:, p), &
            self%tangent(:, :, p))
      end do
   end subroutine prepare

   !> Bounds of point p are held at the stress of a change of strain, if they are off.
   subroutine hold_bounds(self, p, change, step, allowed)
      class(strain_points_type), intent(inout) :: self  !< elements of this kind
      integer, intent(in) :: p                          !< point
      real(wp), intent(in) :: change(3)                 !< Δε
      type(step_type), intent(in) :: step               !< the one being taken
      real(wp), intent(in) :: allowed                   !< that they may be off, Pa
      real(wp) :: stress(3)

      if (resting(self, p)) return
      if (.not. has_law(self, self%material(p))) return
      stress = self%slot(self%material(p))%law%held_stress(self%point(p), self%state(:, p), &
         self%strain(:, p), change, step)
      if (any(abs(stress - self%point(p)%bounding) > allowed)) self%point(p)%bounding = stress
   end subroutine hold_bounds

   !> Δε of point p by the increments of its blocks.
   subroutine set_operator(self, p, blocks, step)
      class(strain_points_type), intent(inout) :: self  !< elements of this kind
      integer, intent(in) :: p                          !< point
      type(blocks_type), intent(in) :: blocks           !< at the start of the step
      type(step_type), intent(in) :: step               !< the one being taken
      real(wp) :: g(n_deformations, 6, 2)
      integer :: i, k

      if (self%block(2, p) == 0) then
         self%operator(:, :, :, p) = 0.0_wp
         do i = 1, 3
            self%operator(i, 3 + i, 1, p) = 1.0_wp
         end do
         return
      end if
      g = derivatives_of(self%face(p), blocks, step)
      do k = 1, 2
         self%operator(:, :, k, p) = matmul(self%map(:, :, p), g(:, :, k))
      end do
   end subroutine set_operator

   !> Δε of point p.
   pure function change_of(self, p, d) result(change)
      class(strain_points_type), intent(in) :: self  !< prepared for the step
      integer, intent(in) :: p                       !< point
      real(wp), intent(in) :: d(:,:)                 !< [6,blocks] increments of the coordinates
      real(wp) :: change(3)

      change = matmul(self%operator(:, :, 1, p), d(:, self%block(1, p)))
      if (self%block(2, p) > 0) change = change + matmul(self%operator(:, :, 2, p), &
         d(:, self%block(2, p)))
   end function change_of

   !> The tangents of all points, A T = Σ c u uᵀ.
   subroutine add_linear(self, blocks, step, terms)
      class(strain_points_type), intent(in) :: self    !< elements of this kind
      type(blocks_type), intent(in) :: blocks          !< in their present state
      type(step_type), intent(in) :: step              !< the one being taken
      type(linear_terms_type), intent(inout) :: terms  !< springs and dashpots
      type(linear_term_type) :: term
      real(wp) :: factor(3), direction(3, 3)
      integer :: p, i, n

      term%kind = term_point
      term%instant = at_damping
      do p = 1, self%n
         if (.not. acts(self, p, blocks)) cycle
         call split(self%tangent(:, :, p), no_curvature*self%point(p)%elasticity(1, 1), n, factor, &
            direction)
         term%source = p
         term%block_a = self%block(1, p)
         term%place = blocks%position(1:2, term%block_a)
         do i = 1, n
            term%coefficient = self%area(p)*factor(i)
            term%block_b = self%block(2, p)
            term%row_a = matmul(direction(:, i), self%operator(:, :, 1, p))
            if (term%block_b > 0) term%row_b = -matmul(direction(:, i), self%operator(:, :, 2, p))
            if (term%block_b == term%block_a) term%row_a = term%row_a - term%row_b
            if (term%block_b == term%block_a) term%block_b = 0  ! its own image
            call add_term(terms, term)
         end do
      end do
   end subroutine add_linear

   !> A symmetric matrix as Σ f u uᵀ, the largest on the diagonal first.
   pure subroutine split(matrix, none, n, factor, direction)
      real(wp), intent(in) :: matrix(3, 3)             !< symmetric
      real(wp), intent(in) :: none                     !< what is none on its diagonal
      integer, intent(out) :: n                        !< terms
      real(wp), intent(out) :: factor(3), direction(3, 3)
      real(wp) :: rest(3, 3)
      integer :: i, j

      rest = 0.5_wp*(matrix + transpose(matrix))
      do n = 0, 2
         i = maxloc(abs([rest(1, 1), rest(2, 2), rest(3, 3)]), 1)
         if (abs(rest(i, i)) <= none) return
         factor(n + 1) = rest(i, i)
         direction(:, n + 1) = rest(:, i)/rest(i, i)
         do j = 1, 3
            rest(:, j) = rest(:, j) - factor(n + 1)*direction(j, n + 1)*direction(:, n + 1)
         end do
      end do
   end subroutine split

   !> −A Bᵀ(c − T Δε) of each point.
   subroutine add_force(self, blocks, motions, step, load)
      class(strain_points_type), intent(in) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks        !< in their present state
      type(motion_type), intent(in) :: motions(:)    !< prescribed ones
      type(step_type), intent(in) :: step            !< the one being taken
      real(wp), intent(inout) :: load(:,:)           !< [6,blocks] N/m …
      real(wp) :: force(3)
      integer :: p, k

      do p = 1, self%n
         if (.not. acts(self, p, blocks)) cycle
         force = self%area(p)*(self%stress(:, p) - matmul(self%tangent(:, :, p), self%change(:, p)))
         do k = 1, 2
            associate (b => self%block(k, p))
               if (b > 0) load(:, b) = load(:, b) - matmul(force, self%operator(:, :, k, p))
            end associate
         end do
      end do
   end subroutine add_force

   !> Add what images exert on the cells of one side beyond elasticity, in a step whose increment d
   !> is known.
   subroutine add_face_force(self, side, blocks, step, d, load)
      class(strain_points_type), intent(in) :: self  !< prepared for the step
      integer, intent(in) :: side                    !< of each face, 1 or 2
      type(blocks_type), intent(in) :: blocks        !< at the start of the step
      type(step_type), intent(in) :: step            !< the one being taken
      real(wp), intent(in) :: d(:,:)                 !< [6,blocks] increments of the coordinates
      real(wp), intent(inout) :: load(:,:)           !< [6,blocks] N/m …
      real(wp) :: stress(3), tangent(3, 3)
      integer :: p

      do p = 1, self%n
         if (.not. acts(self, p, blocks)) cycle
         if (self%block(2, p) == 0) cycle
         if (.not. is_shifted(self%face(p))) cycle
         call respond(self, p, self%strain(:, p), change_of(self, p, d), step, stress, tangent)
         associate (b => self%block(side, p))
            load(:, b) = load(:, b) - self%area(p)*matmul(stress, self%operator(:, :, side, p))
         end associate
      end do
   end subroutine add_face_force

   !> What c, less what is linear of it, works on a way from one increment of the step to another,
   !> at a share of the way: beyond the slope of the linear problem, J per metre of thickness.
   real(wp) function slope_beyond(self, blocks, step, from, to, share) result(slope)
      class(strain_points_type), intent(in) :: self  !< prepared for the step
      type(blocks_type), intent(in) :: blocks        !< at the start of the step
      type(step_type), intent(in) :: step            !< the one being taken
      real(wp), intent(in) :: from(:,:), to(:,:)     !< [6,blocks] increments of the coordinates
      real(wp), intent(in) :: share                  !< 0 … 1
      real(wp) :: way(3), stress(3), tangent(3, 3), change(3), part(self%n)
      integer :: p

      !$omp parallel do schedule(static) private(way, stress, tangent, change) &
      !$omp if (self%n >= parallel_from)
      do p = 1, self%n
         part(p) = 0.0_wp
         if (.not. acts(self, p, blocks)) cycle
         change = change_of(self, p, from)
         way = change_of(self, p, to) - change
         change = change + share*way
         call respond(self, p, self%strain(:, p), change, step, stress, tangent)
         stress = stress - self%stress(:, p) - matmul(self%tangent(:, :, p), change &
            - self%change(:, p))
         part(p) = self%area(p)*dot_product(stress, way)
      end do
      slope = sum(part)
   end function slope_beyond

   !> Points whose c at a solution is not the one that was solved with are linear about it from now
   !> on, and so are all others.
   subroutine revise(self, blocks, step, d, changed)
      class(strain_points_type), intent(inout) :: self  !< prepared for the step
      type(blocks_type), intent(in) :: blocks           !< at the start of the step
      type(step_type), intent(in) :: step               !< the one being taken
      real(wp), intent(in) :: d(:,:)                    !< [6,blocks] increments of the coordinates
      integer, intent(inout) :: changed                 !< states that have changed
      real(wp) :: stress(3), tangent(3, 3), change(3), off(self%n), scale(self%n), noise(self%n)
      integer :: p

      self%round = self%round + 1
      off = 0.0_wp
      scale = 0.0_wp
      noise = 0.0_wp
      !$omp parallel do schedule(static) private(stress, tangent, change) &
      !$omp if (self%n >= parallel_from)
      do p = 1, self%n
         if (.not. acts(self, p, blocks)) cycle
         change = change_of(self, p, d)
         if (self%round <= most_held) call hold_bounds(self, p, change, step, &
            agreed*norm2(self%point(p)%held + self%stress(:, p) &
            + matmul(self%point(p)%elasticity, self%strain(:, p) + step%scheme%theta*change)))
         call respond(self, p, self%strain(:, p), change, step, stress, tangent)
         associate (point => self%point(p), elastic => matmul(self%point(p)%elasticity, &
            self%strain(:, p) + step%scheme%theta*change))
            off(p) = point%length*norm2(stress - self%stress(:, p) &
               - matmul(self%tangent(:, :, p), change - self%change(:, p)))
            scale(p) = point%length*norm2(point%held + elastic + stress)
            noise(p) = point%length*norm2(elastic)
            if (self%crack(p) > 0) noise(p) = point%length*point%cap*norm2(self%strain(:, p) &
               + change)
         end associate
         self%change(:, p) = change
         self%stress(:, p) = stress
         self%tangent(:, :, p) = tangent
      end do
      self%worst = 0
      if (self%n == 0) return
      if (maxval(off) > max(tolerance*maxval(scale), rounding*maxval(noise))) then
         self%worst = maxloc(off, 1)
         changed = changed + count(off > tolerance*maxval(scale))
      end if
   end subroutine revise

   !> The first block of the point that agrees least with the last solution, 0 if all do.
   pure integer function worst_point(self) result(block)
      class(strain_points_type), intent(in) :: self  !< elements of this kind

      block = 0
      if (self%worst > 0) block = self%block(1, self%worst)
   end function worst_point

   !> What point p stores beyond an elastic one at a strain, J/m³.
   pure real(wp) function beyond_elastic(self, p, state, strain) result(energy)
      class(strain_points_type), intent(in) :: self  !< elements of this kind
      integer, intent(in) :: p                       !< point
      real(wp), intent(in) :: state(:)               !< [any] of its law
      real(wp), intent(in) :: strain(3)              !< ε
      real(wp) :: at(3)

      energy = self%rest_energy(p)
      if (resting(self, p)) then
         at = self%rest(:, p)
         energy = energy + dot_product(self%kept(:, p) - self%carried(:, p), strain - at)
      else
         at = strain
      end if
      energy = energy + dot_product(self%carried(:, p), strain)
      if (.not. has_law(self, self%material(p))) return
      energy = energy + self%slot(self%material(p))%law%stored(self%point(p), state, at) &
         - 0.5_wp*dot_product(at, matmul(self%point(p)%elasticity, at)) &
         - dot_product(self%point(p)%held, at)
   end function beyond_elastic

   !> What all points store beyond elastic ones.
   subroutine add_stored(self, blocks, motions, step, energy)
      class(strain_points_type), intent(in) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks        !< in their present state
      type(motion_type), intent(in) :: motions(:)    !< prescribed ones
      type(step_type), intent(in) :: step            !< the one to come
      type(energy_type), intent(inout) :: energy     !< J per metre of thickness
      real(wp) :: part(self%n)
      integer :: p

      part = 0.0_wp
      do p = 1, self%n
         if (acts(self, p, blocks)) part(p) = self%area(p)*beyond_elastic(self, p, &
            self%state(:, p), total_strain(self, p, blocks) - self%reference(:, p))
      end do
      call add_energy(energy, energy_law, sum(part))
   end subroutine add_stored

   !> Energy at the end of the step, and losses.
   subroutine account(self, blocks, motions, step, d, energy)
      class(strain_points_type), intent(in) :: self  !< prepared for the step
      type(blocks_type), intent(in) :: blocks        !< at the start of the step
      type(motion_type), intent(in) :: motions(:)    !< prescribed ones
      type(step_type), intent(in) :: step            !< the one being taken
      real(wp), intent(in) :: d(:,:)                 !< [6,blocks] increments of the coordinates
      type(energy_type), intent(inout) :: energy     !< J per metre of thickness
      real(wp) :: state(size(self%state, 1)), loss(losses), change(3), part(losses + 1, self%n)
      integer :: p

      part = 0.0_wp
      !$omp parallel do schedule(static) private(state, loss, change) &
      !$omp if (self%n >= parallel_from)
      do p = 1, self%n
         if (.not. acts(self, p, blocks)) cycle
         change = change_of(self, p, d)
         state = self%state(:, p)
         call take_step(self, p, state, change, step, loss)
         part(:, p) = self%area(p)*[loss, beyond_elastic(self, p, state, self%strain(:, p) &
            + change)]
      end do
      call add_energy(energy, energy_law, sum(part(losses + 1, :)))
      associate (n => self%first_crack)
         call add_energy(energy, energy_plastic, sum(part(loss_plastic, :n)))
         call add_energy(energy, energy_material, sum(part(loss_damping, :n)))
         call add_energy(energy, energy_fracture, sum(part(loss_plastic, n + 1:)))
         call add_energy(energy, energy_friction, sum(part(loss_damping, n + 1:)))
      end associate
      call add_energy(energy, energy_algorithmic, sum(part(loss_scheme, :)))
   end subroutine account

   !> Take the state of point p to the end of a step; its losses, of the scheme beyond elasticity.
   pure subroutine take_step(self, p, state, change, step, loss)
      class(strain_points_type), intent(in) :: self  !< prepared for the step
      integer, intent(in) :: p                       !< point
      real(wp), intent(inout) :: state(:)            !< [any] of its law
      real(wp), intent(in) :: change(3)              !< Δε
      type(step_type), intent(in) :: step            !< the one being taken
      real(wp), intent(out) :: loss(losses)          !< J/m³

      loss = 0.0_wp
      if (resting(self, p)) return
      if (.not. has_law(self, self%material(p))) return
      call self%slot(self%material(p))%law%finish(self%point(p), state, self%strain(:, p), &
         change, step, loss)
      loss(loss_scheme) = loss(loss_scheme) - (step%scheme%theta - 0.5_wp) &
         *dot_product(change, matmul(self%point(p)%elasticity, change))
   end subroutine take_step

   !> States at the end of the step.
   subroutine accept(self, blocks, motions, step, d)
      class(strain_points_type), intent(inout) :: self  !< prepared for the step
      type(blocks_type), intent(in) :: blocks           !< at the start of the step
      type(motion_type), intent(in) :: motions(:)       !< prescribed ones
      type(step_type), intent(in) :: step               !< the one being taken
      real(wp), intent(in) :: d(:,:)                    !< [6,blocks] increments of the coordinates
      real(wp) :: loss(losses)
      integer :: p

      !$omp parallel do schedule(static) private(loss) if (self%n >= parallel_from)
      do p = 1, self%n
         if (acts(self, p, blocks)) call take_step(self, p, self%state(:, p), &
            change_of(self, p, d), step, loss)
      end do
   end subroutine accept

   !> Bounds that are held at the stress of the step were taken anew as often as is allowed, and may
   !> not agree with it.
   pure logical function bounds_are_off(self)
      class(strain_points_type), intent(in) :: self  !< elements of this kind

      bounds_are_off = self%round > most_held
   end function bounds_are_off

   !> c of point p in the present state.
   pure function present_stress(self, p, blocks) result(stress)
      class(strain_points_type), intent(in) :: self  !< elements of this kind
      integer, intent(in) :: p                       !< point
      type(blocks_type), intent(in) :: blocks        !< in their present state
      real(wp) :: stress(3), tangent(3, 3)

      call respond(self, p, total_strain(self, p, blocks) - self%reference(:, p), &
         [0.0_wp, 0.0_wp, 0.0_wp], step_type(scheme_type(1.0_wp, 1.0_wp)), stress, tangent)
   end function present_stress

   !> In static stages laws that rest keep what they have beyond elasticity.
   subroutine freeze(self, blocks, motions, time)
      class(strain_points_type), intent(inout) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks           !< in their present state
      type(motion_type), intent(in) :: motions(:)       !< prescribed ones
      real(wp), intent(in) :: time                      !< whose loads and places stay, s
      integer :: p

      if (self%static) return
      do p = 1, self%n
         if (.not. acts(self, p, blocks)) cycle
         self%kept(:, p) = present_stress(self, p, blocks)
         self%rest(:, p) = total_strain(self, p, blocks) - self%reference(:, p)
      end do
      self%static = .true.
   end subroutine freeze

   !> States pass to the same points.  A law that has rested goes on from the strain at which it
   !> began to.  Where the law is another one, what its stress had beyond elasticity stays.
   subroutine inherit(self, before, blocks)
      class(strain_points_type), intent(inout) :: self  !< elements of this kind
      class(element_type), intent(in) :: before         !< those of the same type
      type(blocks_type), intent(in) :: blocks           !< in their present state
      integer :: p

      select type (before)
      class is (strain_points_type)
         do p = 1, self%n
            call take_over(self, p, before, source_of(before, p), blocks)
         end do
      end select
   end subroutine inherit

   !> The point that had the stress of point p: the first of a face of one material.
   pure integer function source_of(before, p) result(source)
      class(strain_points_type), intent(in) :: before  !< elements before
      integer, intent(in) :: p                         !< point

      source = p
      if (before%area(p) <= 0.0_wp .and. before%block(2, p) > 0) source = p - 1
   end function source_of

   !> Point p takes over the state of a point before.
   subroutine take_over(self, p, before, old, blocks)
      class(strain_points_type), intent(inout) :: self  !< elements of this kind
      integer, intent(in) :: p, old                     !< point, and that before
      class(strain_points_type), intent(in) :: before   !< elements before
      type(blocks_type), intent(in) :: blocks           !< in their present state
      real(wp) :: moved(3)
      logical :: other

      if (.not. (self%active(p) .or. before%active(old)) .or. self%area(p) <= 0.0_wp) return
      other = self%material(p) /= before%material(old)
      if (self%side(1, p) > 0) other = any(self%material(self%side(:, p)) &
         /= before%material(self%side(:, p)))
      if (other) then
         self%active(p) = .true.
         self%carried(:, p) = present_stress(before, old, blocks)
         self%point(p)%held = before%point(old)%held + matmul(before%point(old)%elasticity, &
            self%reference(:, p) - before%reference(:, old)) + self%carried(:, p)
         return
      end if
      self%point(p)%held = before%point(old)%held
      self%point(p)%bounding = before%point(old)%bounding
      self%reference(:, p) = before%reference(:, old)
      self%carried(:, p) = before%carried(:, old)
      self%active(p) = .true.
      self%state(:, p) = before%state(:, old)
      self%rest_energy(p) = before%rest_energy(old)
      if (.not. resting(before, old)) return
      moved = total_strain(self, p, blocks) - self%reference(:, p) - before%rest(:, old)
      self%rest_energy(p) = self%rest_energy(p) + dot_product(before%kept(:, old), moved)
      self%reference(:, p) = self%reference(:, p) + moved
      self%point(p)%held = self%point(p)%held + matmul(self%point(p)%elasticity, moved)
   end subroutine take_over

   !> What points keep.
   subroutine serialise(self, archive)
      class(strain_points_type), intent(inout) :: self  !< elements of this kind
      type(archive_type), intent(inout) :: archive      !< written or read
      real(wp) :: held(3, self%n), bounding(3, self%n)
      integer :: p

      do p = 1, self%n
         held(:, p) = self%point(p)%held
         bounding(:, p) = self%point(p)%bounding
      end do
      call archive_values(archive, held)
      call archive_values(archive, bounding)
      call archive_values(archive, self%active)
      do p = 1, self%n
         self%point(p)%held = held(:, p)
         self%point(p)%bounding = bounding(:, p)
      end do
      call archive_values(archive, self%reference)
      call archive_values(archive, self%carried)
      call archive_values(archive, self%state)
      call archive_values(archive, self%rest_energy)
   end subroutine serialise

   !> What points add to the mean stress of blocks, Pa, in the axes of the block.
   subroutine add_point_stress(self, blocks, stress)
      class(strain_points_type), intent(in) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks        !< in their present state
      real(wp), intent(inout) :: stress(:,:)         !< [3,blocks] Pa
      real(wp) :: own(3)
      integer :: p, i, k

      do p = 1, self%n
         if (self%side(1, p) > 0 .or. self%crack(p) > 0) exit  ! jumps are no stress of a cell
         if (.not. acts(self, p, blocks)) cycle
         own = self%area(p)*present_stress(self, p, blocks)
         if (self%block(2, p) == 0) then
            associate (b => self%block(1, p))
               stress(:, b) = stress(:, b) + own/blocks%area(b)
            end associate
            cycle
         end if
         do k = 1, 2
            associate (b => self%block(k, p))
               do i = 1, 3
                  stress(i, b) = stress(i, b) + dot_product(own, &
                     self%map(:, own_strain(i, k), p))/blocks%area(b)
               end do
            end associate
         end do
      end do
   end subroutine add_point_stress

   !> What the points of whole face i add to the forces on its deformations in the present state.
   pure function points_force(self, i, blocks) result(force)
      class(strain_points_type), intent(in) :: self  !< elements of this kind
      integer, intent(in) :: i                       !< face
      type(blocks_type), intent(in) :: blocks        !< in their present state
      real(wp) :: force(n_deformations)
      integer :: p, group, k

      force = 0.0_wp
      do group = 0, (self%first_crack - blocks%n)/(2*faces_of(self, blocks)) - 1
         do k = 1, 2
            p = blocks%n + 2*group*faces_of(self, blocks) + 2*(i - 1) + k
            if (acts(self, p, blocks)) force = force + self%area(p)*matmul(present_stress(self, p, &
               blocks), self%map(:, :, p))
         end do
      end do
   end function points_force

   !> Number of welded faces.
   pure integer function faces_of(self, blocks) result(faces)
      class(strain_points_type), intent(in) :: self  !< with points of faces that can break
      type(blocks_type), intent(in) :: blocks        !< in any state

      faces = (self%n - self%first_crack)/crack_points
   end function faces_of

   !> Tractions at the points of whole face i under forces on its deformations, and how much of
   !> their strength they are.
   pure subroutine strength_ratios(self, i, force, traction, ratio)
      class(strain_points_type), intent(in) :: self          !< elements of this kind
      integer, intent(in) :: i                               !< face that can break
      real(wp), intent(in) :: force(:)                       !< [deformations]
      real(wp), intent(out) :: traction(2, crack_points)     !< tension and shear, Pa
      real(wp), intent(out) :: ratio(crack_points)           !< 1: damage begins
      integer :: k, p

      do k = 1, crack_points
         p = self%first_crack + crack_points*(i - 1) + k
         associate (axes => self%map(:2, 1:2, p), length => self%face(p)%length)
            traction(:, k) = matmul(axes, force(1:2) + 3.0_wp*places(k)*force(3:4))/length
         end associate
         select type (law => self%slot(self%material(p))%law)
         type is (crack_law_type)
            ratio(k) = law%traction_ratio(traction(:, k))
         end select
      end do
   end subroutine strength_ratios

   !> The joint of face i begins with tractions at its points.
   subroutine begin_crack(self, i, blocks, traction)
      class(strain_points_type), intent(inout) :: self       !< elements of this kind
      integer, intent(in) :: i                               !< face that has just broken
      type(blocks_type), intent(in) :: blocks                !< in their present state
      real(wp), intent(in) :: traction(2, crack_points)      !< tension and shear, Pa
      integer :: k, p

      do k = 1, crack_points
         p = self%first_crack + crack_points*(i - 1) + k
         self%state(:, p) = 0.0_wp
         self%point(p)%bounding = 0.0_wp
         self%reference(:, p) = total_strain(self, p, blocks)
         select type (law => self%slot(self%material(p))%law)
         type is (crack_law_type)
            self%reference(:2, p) = self%reference(:2, p) - traction(:, k)/law%springs()
         end select
      end do
   end subroutine begin_crack

   !> Damage of face i, of its points by their weights; whether its bonds are gone.
   pure subroutine crack_damage(self, i, damage, spent)
      class(strain_points_type), intent(in) :: self  !< elements of this kind
      integer, intent(in) :: i                       !< broken face
      real(wp), intent(out) :: damage                !< of its points by their weights
      logical, intent(out) :: spent                  !< no bond is left
      integer :: k, p

      damage = 0.0_wp
      spent = .true.
      do k = 1, crack_points
         p = self%first_crack + crack_points*(i - 1) + k
         damage = damage + weight(crack_points, k)*self%state(1, p)
         spent = spent .and. is_spent(self%state(:, p))
      end do
   end subroutine crack_damage

   !> Opening and slip at the points of face i, m, from where the joint is free of force.
   pure function crack_motion(self, i, blocks) result(motion)
      class(strain_points_type), intent(in) :: self  !< elements of this kind
      integer, intent(in) :: i                       !< broken face
      type(blocks_type), intent(in) :: blocks        !< in their present state
      real(wp) :: motion(2, crack_points), strain(3)
      integer :: k, p

      do k = 1, crack_points
         p = self%first_crack + crack_points*(i - 1) + k
         strain = total_strain(self, p, blocks) - self%reference(:, p)
         motion(:, k) = strain(:2)
      end do
   end function crack_motion

end module dda_strain_points
