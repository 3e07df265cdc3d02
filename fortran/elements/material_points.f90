! SPDX-License-Identifier: GPL-3.0-or-later
!> Points at which a material law (`dda_material_law`) is evaluated, and the memory of the laws.
!> Strain points are in blocks, remainders of cells, and sides of welded faces.  If a law limits the
!> mean and linear jumps of a face, the jumps are points with `dda_jump_law`; broken faces have
!> points with `dda_crack_law`.
!>
!> Blocks and welded faces are linear elastic; a point adds the difference c = s − θDΔε − Dε of its
!> law.  At a face between two materials each side has its own strain, computed with the face
!> displacement of elastic materials (`dda_weld_springs`).
module dda_material_points
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type
   use dda_crack_law, only: crack_law_type
   use dda_element, only: element_type
   use dda_jump_law, only: jump_law_type
   use dda_material, only: material_type, elasticity
   use dda_material_law, only: material_law_type, strain_point_type, loss_scheme, losses
   use dda_overlap, only: weight
   use dda_scheme, only: scheme_type, step_type
   use dda_weld, only: weld_type, is_intact, weld_cracked
   use dda_weld_springs, only: n_deformations, jump_stiffness, strains_of
   use dda_welds, only: deformations_of
   implicit none
   private
   public :: material_points_type, set_points, has_law, acts, is_inactive, respond, jump_limit, &
      total_strain, present_stress, shape_stress, beyond_elastic, advance_point, copy_point_state, &
      crack_points, point_positions

   integer, parameter :: crack_points = 3            !< Lobatto points of a broken face
   !> ξ of these points
   real(wp), parameter :: point_positions(crack_points) = [-1.0_wp, 0.0_wp, 1.0_wp]

   real(wp), parameter :: arc_correction = 2.0_wp/3.0_wp  !< see `shape_stress`: 1 − (1/24)/(1/8)

   !> Container of a law.
   type :: slot_type
      class(material_law_type), allocatable :: law
   end type slot_type

   !> All points, without equations.
   type, abstract, extends(element_type) :: material_points_type
      integer :: n = 0
      logical, allocatable :: active(:)  !< [n] the point has a law other than elasticity
      !> [materials + 1 + joints] laws of materials, of jumps, of broken faces
      type(slot_type), allocatable :: slot(:)
      integer, allocatable :: material(:)                !< [n]
      integer, allocatable :: block(:,:)                 !< [2,n] block and 0, or cells of the face
      integer, allocatable :: side_points(:,:)  !< [2,n] points of the face of a jump, else 0
      integer, allocatable :: crack(:)                   !< [n] point 1 … 3 of a broken face, else 0
      integer :: first_crack = 0  !< number of points before the points of broken faces
      real(wp), allocatable :: area(:)                   !< [n] area, m²; 1 for jumps
      type(strain_point_type), allocatable :: point(:)   !< [n]
      type(weld_type), allocatable :: face(:)            !< [n]
      real(wp), allocatable :: map(:,:,:) !< [3,deformations,n] strain as a function of deformations
      real(wp), allocatable :: reference(:,:)            !< [3,n] strain at the start of the law
      real(wp), allocatable :: retained_stress(:,:)      !< [3,n] c retained from earlier laws, Pa
      real(wp), allocatable :: state(:,:)                !< [any,n] state of the laws
      logical :: static = .false.  !< in this static stage some laws are inactive
      !> [3,n] ε at which laws became inactive, else 0
      real(wp), allocatable :: inactive_strain(:,:)
      real(wp), allocatable :: inactive_stress(:,:)      !< [3,n] c of inactive laws, Pa
      real(wp), allocatable :: residual_work(:)  !< [n] work of the cohesion that remains, J/m³
      ! Variables of a step
      real(wp), allocatable :: strain(:,:)               !< [3,n] ε at the start of the step
   end type material_points_type

contains

   !> Create the points of a model: blocks, sides and jumps of welded faces, faces that can break.
   subroutine set_points(self, welds, blocks, materials, cracks, plane_strain)
      class(material_points_type), intent(inout) :: self  !< receives its points
      type(weld_type), intent(in) :: welds(:)          !< welds of the model
      type(blocks_type), intent(in) :: blocks          !< blocks in their present state
      type(material_type), intent(in) :: materials(:)  !< materials of the model
      type(crack_law_type), intent(in) :: cracks(:)    !< [joints] cracks of faces that break
      logical, intent(in) :: plane_strain              !< plane strain; .false.: plane stress
      real(wp) :: moduli(3, 3, size(materials))
      integer :: m, size_limit
      logical :: with_jumps

      allocate (self%slot(size(materials) + 1 + size(cracks)))
      allocate (jump_law_type :: self%slot(size(materials) + 1)%law)
      size_limit = 0
      with_jumps = any(materials%yields())
      do m = 1, size(materials)
         moduli(:, :, m) = elasticity(materials(m), plane_strain)
         if (.not. allocated(materials(m)%own_law)) cycle
         allocate (self%slot(m)%law, source=materials(m)%own_law)
         size_limit = max(size_limit, materials(m)%own_law%state_size())
      end do
      do m = 1, size(cracks)
         allocate (self%slot(size(materials) + 1 + m)%law, source=cracks(m))
         size_limit = max(size_limit, cracks(m)%state_size())
      end do
      self%first_crack = blocks%n + merge(4, 2, with_jumps)*size(welds)
      call allocate_points(self, self%first_crack + merge(crack_points, 0, any(welds%joint > 0)) &
         *size(welds), size_limit)
      self%point%plane_strain = plane_strain
      call create_block_points(self, blocks, moduli)
      call create_face_points(self, welds, blocks, moduli)
      if (with_jumps) call create_jump_points(self, welds, blocks, moduli)
      if (any(welds%joint > 0)) call create_crack_points(self, welds, size(materials) + 1)
   end subroutine set_points

   !> .true. if a material has its own law.
   pure logical function has_law(self, material)  ! total
      class(material_points_type), intent(in) :: self  !< points with laws
      integer, intent(in) :: material                !< number of the material

      has_law = allocated(self%slot(material)%law)
   end function has_law

   !> Allocate arrays for n points with states of a given size.
   subroutine allocate_points(self, n, states)
      class(material_points_type), intent(inout) :: self  !< receives its arrays
      integer, intent(in) :: n, states                  !< numbers of points and of state variables

      self%n = n
      allocate (self%material(n), self%block(2, n), self%side_points(2, n), self%crack(n), source=0)
      allocate (self%point(n), self%face(n))
      allocate (self%active(n), source=.false.)
      allocate (self%area(n), self%map(3, n_deformations, n), self%reference(3, n), &
         self%retained_stress(3, n), self%state(states, n), self%inactive_strain(3, n), &
         self%inactive_stress(3, n), self%residual_work(n), self%strain(3, n), source=0.0_wp)
   end subroutine allocate_points

   !> Create points of blocks, and of the remainders of cells beside welded faces.
   subroutine create_block_points(self, blocks, moduli)
      class(material_points_type), intent(inout) :: self  !< points with arrays
      type(blocks_type), intent(in) :: blocks           !< blocks in their present state
      real(wp), intent(in) :: moduli(:,:,:)             !< [3,3,materials] D, Pa
      integer :: b

      do b = 1, blocks%n
         self%block(1, b) = b
         self%area(b) = blocks%interior_fraction(b)*blocks%area(b)
         call begin_point(self, b, blocks, blocks%material(b), moduli, blocks%initial_stress(:, b))
      end do
   end subroutine create_block_points

   !> Create points of welded faces; faces within one material have one point.
   subroutine create_face_points(self, welds, blocks, moduli)
      class(material_points_type), intent(inout) :: self  !< points with arrays
      type(weld_type), intent(in) :: welds(:)           !< welds of the model
      type(blocks_type), intent(in) :: blocks           !< blocks in their present state
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
   end subroutine create_face_points

   !> Create the points of the mean and of the linear jump of each welded face.
   subroutine create_jump_points(self, welds, blocks, moduli)
      class(material_points_type), intent(inout) :: self  !< points with arrays and other points
      type(weld_type), intent(in) :: welds(:)           !< welds of the model
      type(blocks_type), intent(in) :: blocks           !< blocks in their present state
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
            self%side_points(:, p) = blocks%n + 2*(i - 1) + [1, 2]
            self%material(p) = size(moduli, 3) + 1
            do j = 1, 2
               self%map(j, 2*(k - 1) + j, p) = 1.0_wp
               self%point(p)%elasticity(j, j) = stiffness(k)
            end do
            self%point(p)%length = 1.0_wp
            self%reference(:, p) = total_strain(self, p, blocks)
            self%point(p)%start_stress = matmul(self%point(p)%elasticity, self%reference(:, p))
            self%active(p) = jump_limit(self, p) < huge(1.0_wp)
         end do
      end do
   end subroutine create_jump_points

   !> Create points of faces that can break; map the deformations of a face to opening and slip.
   subroutine create_crack_points(self, welds, offset)
      class(material_points_type), intent(inout) :: self  !< points with arrays and other points
      type(weld_type), intent(in) :: welds(:)           !< welds of the model
      integer, intent(in) :: offset                     !< number of laws before those of joints
      integer :: i, k, p

      do i = 1, size(welds)
         if (welds(i)%joint == 0) cycle
         associate (along => welds(i)%along)
            do k = 1, crack_points
               p = self%first_crack + crack_points*(i - 1) + k
               self%crack(p) = k
               self%block(:, p) = welds(i)%block
               self%face(p) = welds(i)
               self%material(p) = offset + welds(i)%joint
               self%area(p) = weight(crack_points, k)*welds(i)%length
               self%point(p)%length = self%area(p)
               select type (law => self%slot(self%material(p))%law)
               type is (crack_law_type)
                  self%point(p)%cap = maxval(law%springs())
                  self%point(p)%strength = law%joint%strengths(1)
               end select
               ! w = −[u] − ξ[u]_l, along n and along the face.
               self%map(1, 1:2, p) = -[along(2), -along(1)]
               self%map(2, 1:2, p) = -along
               self%map(:2, 3:4, p) = point_positions(k)*self%map(:2, 1:2, p)
               self%active(p) = welds(i)%state == weld_cracked
            end do
         end associate
      end do
   end subroutine create_crack_points

   !> Return the largest force of jump p in a step, N/m, from the initial stress of its face.
   pure real(wp) function jump_limit(self, p) result(cap)
      class(material_points_type), intent(in) :: self  !< points, with strains at the start
      integer, intent(in) :: p                       !< point of a jump
      integer :: k, side

      cap = huge(1.0_wp)
      do k = 1, 2
         side = self%side_points(k, p)
         if (.not. self%active(side)) cycle
         if (.not. has_law(self, self%material(side))) cycle
         cap = min(cap, self%slot(self%material(side))%law%jump_cap(self%point(side), &
            self%state(:, side), self%strain(:, side)))
      end do
      if (cap < huge(1.0_wp)) cap = cap*self%face(p)%length
   end function jump_limit

   !> Begin the law of point p in the present state, with elastic stress.
   subroutine begin_point(self, p, blocks, material, moduli, initial)
      class(material_points_type), intent(inout) :: self  !< points with block, area and map of p
      integer, intent(in) :: p                          !< number of the point
      type(blocks_type), intent(in) :: blocks           !< blocks in their present state
      integer, intent(in) :: material                   !< material of the point
      real(wp), intent(in) :: moduli(:,:,:)             !< [3,3,materials] D, Pa
      real(wp), intent(in) :: initial(3)                !< stress at zero strain, Pa

      self%material(p) = material
      self%reference(:, p) = total_strain(self, p, blocks)
      self%point(p)%elasticity = moduli(:, :, material)
      self%point(p)%start_stress = initial + matmul(moduli(:, :, material), self%reference(:, p))
      self%point(p)%length = sqrt(self%area(p))
      self%point(p)%thickness = self%point(p)%length
      if (self%block(2, p) > 0) self%point(p)%thickness = self%area(p)/self%face(p)%length
      self%active(p) = self%area(p) > 0.0_wp
      if (self%active(p)) self%active(p) = has_law(self, material)
   end subroutine begin_point

   !> Return the strain of point p in the present state, relative to the input geometry.
   pure function total_strain(self, p, blocks) result(strain)
      class(material_points_type), intent(in) :: self  !< elements of this kind
      integer, intent(in) :: p                       !< number of the point
      type(blocks_type), intent(in) :: blocks        !< blocks in their present state
      real(wp) :: strain(3)

      if (self%block(2, p) == 0) then
         strain = blocks%position(4:6, self%block(1, p))
      else
         strain = matmul(self%map(:, :, p), deformations_of(self%face(p), blocks))
      end if
   end function total_strain

   !> .true. if point p acts and its blocks exist.
   pure logical function acts(self, p, blocks)
      class(material_points_type), intent(in) :: self  !< elements of this kind
      integer, intent(in) :: p                       !< number of the point
      type(blocks_type), intent(in) :: blocks        !< blocks in their present state

      acts = self%active(p) .and. .not. blocks%removed(self%block(1, p))
      if (.not. acts .or. self%block(2, p) == 0) return
      acts = .not. blocks%removed(self%block(2, p))
      if (self%crack(p) > 0) then
         acts = acts .and. self%face(p)%state == weld_cracked
      else
         acts = acts .and. is_intact(self%face(p))
      end if
   end function acts

   !> .true. if the law of point p is inactive in this static stage; c is then constant.
   pure logical function is_inactive(self, p)
      class(material_points_type), intent(in) :: self  !< elements of this kind
      integer, intent(in) :: p                       !< number of the point

      is_inactive = self%static
      if (is_inactive) is_inactive = has_law(self, self%material(p))
      if (is_inactive) is_inactive = self%slot(self%material(p))%law%rests()
   end function is_inactive

   !> Find c of point p in a step, and its derivative with respect to Δε.
   pure subroutine respond(self, p, strain, change, step, stress, tangent)
      class(material_points_type), intent(in) :: self      !< elements of this kind
      integer, intent(in) :: p                           !< number of the point
      real(wp), intent(in) :: strain(3), change(3)       !< ε at the start, Δε
      type(step_type), intent(in) :: step                !< the present step
      real(wp), intent(out) :: stress(3), tangent(3, 3)  !< Pa

      stress = self%retained_stress(:, p)
      tangent = 0.0_wp
      if (is_inactive(self, p)) then
         stress = self%inactive_stress(:, p)
      else if (has_law(self, self%material(p))) then
         associate (theta => step%scheme%theta, d => self%point(p)%elasticity)
            call self%slot(self%material(p))%law%respond(self%point(p), self%state(:, p), strain, &
               change, step, stress, tangent)
            stress = stress - matmul(d, strain + theta*change) + self%retained_stress(:, p)
            tangent = tangent - theta*d
         end associate
      end if
   end subroutine respond

   !> Return the stress c of point p in the present state.
   pure function present_stress(self, p, blocks) result(stress)
      class(material_points_type), intent(in) :: self  !< elements of this kind
      integer, intent(in) :: p                       !< number of the point
      type(blocks_type), intent(in) :: blocks        !< blocks in their present state
      real(wp) :: stress(3), tangent(3, 3)

      call respond(self, p, total_strain(self, p, blocks) - self%reference(:, p), &
         [0.0_wp, 0.0_wp, 0.0_wp], step_type(scheme_type(1.0_wp, 1.0_wp)), stress, tangent)
   end function present_stress

   !> Return the stress, part of `retained_stress`, that corrects the area change of point p for a
   !> large plastic jump of its face.
   !>
   !> Cells that turn by an angle a relative to each other about the middle of a face approach by
   !> ha²/8, but arcs by ha²/24.  The work of the pressure p of the sides on the difference is
   !> removed by a force ⅔ p (h/L) [u]_l on the plastic linear jump.
   pure function shape_stress(self, p) result(stress)
      class(material_points_type), intent(in) :: self  !< elements of this kind
      integer, intent(in) :: p                       !< number of the point
      real(wp) :: stress(3), pressure
      integer :: k, side

      stress = 0.0_wp
      if (self%block(2, p) == 0 .or. .not. has_law(self, self%material(p))) return
      stress = self%slot(self%material(p))%law%shape_stress(self%state(:, p))
      if (self%side_points(1, p) == 0 .or. .not. self%map(1, 3, p) > 0.0_wp) return
      pressure = 0.0_wp
      do k = 1, 2
         side = self%side_points(k, p)
         if (.not. self%active(side)) cycle
         if (has_law(self, self%material(side))) pressure = max(pressure, &
            self%slot(self%material(side))%law%pressure(self%state(:, side)))
      end do
      stress(1:2) = pressure*arc_correction*2.0_wp*sum(self%face(p)%area)/self%face(p)%length**2 &
         *self%state(1:2, p)
   end function shape_stress

   !> Return the energy of point p minus the elastic energy at the same strain, J/m³.
   pure real(wp) function beyond_elastic(self, p, state, strain) result(energy)
      class(material_points_type), intent(in) :: self  !< elements of this kind
      integer, intent(in) :: p                       !< number of the point
      real(wp), intent(in) :: state(:)               !< [any] state of the law of the point
      real(wp), intent(in) :: strain(3)              !< ε
      real(wp) :: at(3)

      energy = self%residual_work(p)
      if (is_inactive(self, p)) then
         at = self%inactive_strain(:, p)
         energy = energy + dot_product(self%inactive_stress(:, p) - self%retained_stress(:, p), &
            strain - at)
      else
         at = strain
      end if
      energy = energy + dot_product(self%retained_stress(:, p), strain)
      if (.not. has_law(self, self%material(p))) return
      energy = energy + self%slot(self%material(p))%law%stored(self%point(p), state, at) &
         - 0.5_wp*dot_product(at, matmul(self%point(p)%elasticity, at)) &
         - dot_product(self%point(p)%start_stress, at)
   end function beyond_elastic

   !> Advance the state of point p by a step, and find its losses.
   pure subroutine advance_point(self, p, state, change, step, loss)
      class(material_points_type), intent(in) :: self  !< points, prepared for the step
      integer, intent(in) :: p                       !< number of the point
      real(wp), intent(inout) :: state(:)            !< [any] state of the law of the point
      real(wp), intent(in) :: change(3)              !< Δε
      type(step_type), intent(in) :: step            !< the present step
      real(wp), intent(out) :: loss(losses)          !< J/m³

      loss = 0.0_wp
      if (is_inactive(self, p)) return
      if (.not. has_law(self, self%material(p))) return
      call self%slot(self%material(p))%law%finish(self%point(p), state, self%strain(:, p), &
         change, step, loss)
      loss(loss_scheme) = loss(loss_scheme) - (step%scheme%theta - 0.5_wp) &
         *dot_product(change, matmul(self%point(p)%elasticity, change))
   end subroutine advance_point

   !> Copy the state of a former point to point p.
   subroutine copy_point_state(self, p, former, former_point, blocks)
      class(material_points_type), intent(inout) :: self  !< elements of this kind
      integer, intent(in) :: p, former_point                     !< point, and former point
      class(material_points_type), intent(in) :: former   !< former elements
      type(blocks_type), intent(in) :: blocks           !< blocks in their present state
      real(wp) :: strain_change(3)
      logical :: differs

      if (.not. (self%active(p) .or. former%active(former_point)) .or. self%area(p) <= &
         0.0_wp) return
      differs = self%material(p) /= former%material(former_point)
      if (self%side_points(1, p) > 0) differs = any(self%material(self%side_points(:, p)) &
         /= former%material(self%side_points(:, p)))
      if (differs) then
         self%active(p) = .true.
         self%retained_stress(:, p) = present_stress(former, former_point, blocks)
         self%point(p)%start_stress = former%point(former_point)%start_stress &
            + matmul(former%point(former_point)%elasticity, &
            self%reference(:, p) - former%reference(:, former_point)) + self%retained_stress(:, p) &
            - shape_stress(former, former_point)
         return
      end if
      self%point(p)%start_stress = former%point(former_point)%start_stress
      self%point(p)%bounding = former%point(former_point)%bounding
      self%reference(:, p) = former%reference(:, former_point)
      self%retained_stress(:, p) = former%retained_stress(:, former_point)
      self%active(p) = .true.
      self%state(:, p) = former%state(:, former_point)
      self%residual_work(p) = former%residual_work(former_point)
      if (.not. is_inactive(former, former_point)) return
      strain_change = total_strain(self, p, blocks) - self%reference(:, p) &
         - former%inactive_strain(:, former_point)
      self%residual_work(p) = self%residual_work(p) + dot_product(former%inactive_stress(:, &
         former_point), strain_change)
      self%reference(:, p) = self%reference(:, p) + strain_change
      self%point(p)%start_stress = self%point(p)%start_stress + matmul(self%point(p)%elasticity, &
         strain_change)
   end subroutine copy_point_state

end module dda_material_points
