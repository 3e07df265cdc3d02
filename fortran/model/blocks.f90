! SPDX-License-Identifier: GPL-3.0-or-later
!> Blocks: shape, inertia, elasticity and state.
!>
!> A block has six generalised coordinates q = (x0, y0, θ, εx, εy, γxy): the position of its
!> centroid, its rotation and its strain in axes that turn with it.  A material point with reference
!> offset ρ from the centroid is at
!>
!>     x = x0 + R(θ) (I + ε) ρ ,
!>
!> Rotation is therefore exact, a rotating block retains its area, and no error accumulates.  The
!> unknowns d of a step (paper eq. 2) are increments of q, and the shape matrix T (eq. 4) is ∂x/∂q.
!> In these axes the mass matrix M = ρ ∫ TᵀT and the elastic matrix of a block are constant.
!>
!> If materials damp (`dda_damping`), a generalised Maxwell body adds D [(r − 1) e − r Σ ζ_l] to
!> the stress; e is the strain beyond `rest_strain`.
module dda_blocks
   use dda_kinds, only: wp
   use dda_damping, only: damping_type, is_damped, has_body
   use dda_material, only: material_type, elasticity
   use dda_ordered_sums, only: pieces, first_of, last_of, parallel_from
   use dda_polygon, only: area_of, centroid_of, second_moments
   implicit none
   private
   public :: blocks_type, set_blocks, begin_motion, keep_first_state, update_geometry, is_convex
   public :: mass_matrix, momentum_of, change_material, remove_block, position_of, offset_of, &
      shape_matrix, motion_of, reference_of, stress_of, set_damping, begin_memory, has_memory, &
      memory_strain, set_axes, smaller_side

   !> All blocks as structure of arrays; vertices of block b are first(b) … first(b+1)−1.
   type :: blocks_type
      ! unsaved, the input: n, first, owner, next, previous, material, joint, reference, radius
      ! unsaved, the input: area, mass, inertia, stiffness, half_size, mixed, removed, damps
      ! unsaved, the input: damping, body, inner, outline, interior_fraction, joined, joined_first
      ! unsaved, the input: whole_area
      integer :: n = 0
      ! Constants of the run
      integer, allocatable :: first(:)             !< [n+1] first vertex of each block
      integer, allocatable :: owner(:)             !< [vertices] block of each vertex
      integer, allocatable :: next(:)              !< [vertices] next vertex, counter-clockwise
      integer, allocatable :: previous(:)          !< [vertices] previous vertex
      integer, allocatable :: material(:)          !< [n] material of the block
      integer, allocatable :: joint(:)  !< [vertices] joint of the edge that begins at the vertex
      logical, allocatable :: mixed(:)  !< [n] the edges of the block have different joints
      integer, allocatable :: body(:)              !< [n] body of which the block is a cell; 0: none
      logical, allocatable :: inner(:)  !< [vertices] the edge after the vertex is within a body
      !> [2, vertices] the two edges of the body's outline at the vertex, possibly of other cells
      integer, allocatable :: outline(:,:)
      !> [n] fraction of the area outside the triangles of faces
      real(wp), allocatable :: interior_fraction(:)
      integer, allocatable :: joined_first(:)      !< [n+1] start of each cell in `joined`
      integer, allocatable :: joined(:)  !< joined cells (same body, larger numbers) of each cell
      real(wp), allocatable :: reference(:,:)      !< [2, vertices] offset ρ from the centroid, m
      real(wp), allocatable :: radius(:)           !< [n] farthest vertex from the centroid, m
      real(wp), allocatable :: area(:)             !< [n] reference area, m²
      real(wp), allocatable :: whole_area(:)  !< [n] area of the body of a cell, or of the block, m²
      real(wp), allocatable :: mass(:)             !< [n] mass, kg per metre of thickness
      !> [4,n] mass, kg, and second moments x², y², xy of mass about the centroid, kg m², per metre
      !> of thickness; kept for removed blocks, whose `mass` is 0
      real(wp), allocatable :: inertia(:,:)
      real(wp), allocatable :: stiffness(:,:,:)    !< [3,3,n] area × D
      real(wp), allocatable :: initial_stress(:,:) !< [3,n] in the axes of the block, Pa
      real(wp) :: half_size = 0.0_wp  !< half of the larger side of the initial bounding box, m
      ! Changed by stages
      logical, allocatable :: removed(:)           !< [n] removed from the model
      type(damping_type), allocatable :: damping(:) !< [materials] empty: no damping
      logical :: damps = .false.                   !< materials damp, and the stage is not static
      ! State
      real(wp), allocatable :: position(:,:)       !< [6,n] q: m, rad, –
      real(wp), allocatable :: velocity(:,:)       !< [6,n] dq/dt
      !> [6,n] acceleration by the time integration (paper eq. 5); only in runs
      real(wp), allocatable :: acceleration(:,:)
      !> [6,4,n] d/Δt of the last four steps, most recent first; only in runs
      real(wp), allocatable :: mean_velocity(:,:,:)
      real(wp), allocatable :: rest_strain(:,:)    !< [3,n] strain after statics; empty: no memory
      real(wp), allocatable :: memory(:,:,:)       !< [3,mechanisms,n] ζ_l
      ! Derived from the state
      real(wp), allocatable :: axes(:,:,:)         !< [2,2,n] R(θ)
      real(wp), allocatable :: gradient(:,:,:)     !< [2,2,n] R(θ)(I + ε)
      real(wp), allocatable :: vertex(:,:)         !< [2, vertices] present position, m
      !> [2, vertices] unit vector of the edge that begins at the vertex
      real(wp), allocatable :: along(:,:)
      real(wp), allocatable :: length(:)  !< [vertices] length of the edge after the vertex, m
   end type blocks_type

contains

   !> Create the blocks from polygons, unstrained in their reference shape.
   subroutine set_blocks(blocks, first, vertices, material, joint, materials, plane_strain)
      type(blocks_type), intent(out) :: blocks !< blocks in their initial state
      integer, intent(in) :: first(:)         !< [n+1] first vertex of each polygon
      real(wp), intent(in) :: vertices(:,:)   !< [2, any] counter-clockwise, m
      integer, intent(in) :: material(:)               !< [n] material of each block
      integer, intent(in) :: joint(:)  !< [vertices] joint of the edge that begins at the vertex
      type(material_type), intent(in) :: materials(:)  !< [materials]
      logical, intent(in) :: plane_strain              !< plane strain; .false.: plane stress
      integer :: b

      call allocate_blocks(blocks, size(first) - 1, first(size(first)) - 1)
      blocks%first = first
      blocks%material = material
      blocks%joint = joint
      do b = 1, blocks%n
         blocks%mixed(b) = any(joint(first(b):first(b + 1) - 1) /= joint(first(b)))
         call set_block(blocks, b, vertices(:, first(b):first(b + 1) - 1), materials(material(b)), &
            plane_strain)
      end do
      blocks%whole_area = blocks%area
      call update_geometry(blocks)
      blocks%vertex = vertices(:, :first(blocks%n + 1) - 1)
      blocks%half_size = 0.5_wp*maxval(maxval(blocks%vertex, 2) - minval(blocks%vertex, 2))
   end subroutine set_blocks

   !> Allocate the arrays of blocks and vertices.
   pure subroutine allocate_blocks(blocks, n, vertices)
      type(blocks_type), intent(inout) :: blocks  !< blocks; receives all arrays of a model
      integer, intent(in) :: n, vertices          !< numbers of blocks and of vertices

      blocks%n = n
      allocate (blocks%owner(vertices), blocks%next(vertices), blocks%previous(vertices))
      allocate (blocks%reference(2, vertices), blocks%vertex(2, vertices), &
         blocks%along(2, vertices), blocks%length(vertices))
      allocate (blocks%removed(n), source=.false.)
      allocate (blocks%body(n), source=0)
      allocate (blocks%inner(vertices), source=.false.)
      allocate (blocks%outline(2, vertices))
      allocate (blocks%interior_fraction(n), source=1.0_wp)
      allocate (blocks%joined(0))
      allocate (blocks%mixed(n), blocks%radius(n), blocks%area(n), blocks%mass(n), &
         blocks%inertia(4, n), blocks%stiffness(3, 3, n))
      allocate (blocks%initial_stress(3, n), blocks%axes(2, 2, n), blocks%gradient(2, 2, n))
      allocate (blocks%position(6, n), blocks%velocity(6, n), source=0.0_wp)
      allocate (blocks%damping(0), blocks%rest_strain(3, 0), blocks%memory(3, 0, 0))
   end subroutine allocate_blocks

   !> Allocate the arrays of blocks that only runs need.
   pure subroutine begin_motion(blocks)
      type(blocks_type), intent(inout) :: blocks  !< blocks in their initial state

      allocate (blocks%acceleration(6, blocks%n), blocks%mean_velocity(6, 4, blocks%n), &
         source=0.0_wp)
   end subroutine begin_motion

   !> Deallocate data of the model's blocks that are also in the blocks of the run.
   !> The initial state and the lists that stages change remain.
   pure subroutine keep_first_state(blocks)
      type(blocks_type), intent(inout) :: blocks  !< initial blocks, before `begin_motion`

      deallocate (blocks%owner, blocks%next, blocks%previous, blocks%mixed, blocks%inner, &
         blocks%outline, blocks%interior_fraction, blocks%reference, blocks%radius, &
            blocks%whole_area)
      deallocate (blocks%inertia, blocks%stiffness, blocks%removed, blocks%velocity, blocks%axes, &
         blocks%gradient, blocks%vertex, blocks%along, blocks%length)
   end subroutine keep_first_state

   !> Set the damping of the materials; strains count from the present state.
   subroutine set_damping(blocks, damping)
      type(blocks_type), intent(inout) :: blocks  !< blocks in their initial state
      type(damping_type), intent(in) :: damping(:)  !< [materials] fitted damping

      if (.not. any(is_damped(damping))) return
      blocks%damping = damping
      blocks%damps = .true.
      if (.not. any(has_body(damping))) return
      blocks%rest_strain = blocks%position(4:6, :)
      deallocate (blocks%memory)
      allocate (blocks%memory(3, maxval(damping%n), blocks%n), source=0.0_wp)
   end subroutine set_damping

   !> .true. if a material has a generalised Maxwell body.
   pure logical function has_memory(blocks)  ! total
      type(blocks_type), intent(in) :: blocks  !< blocks

      has_memory = size(blocks%memory, 3) > 0
   end function has_memory

   !> Reset the Maxwell bodies of all blocks: strains count from the present state.
   pure subroutine begin_memory(blocks)
      type(blocks_type), intent(inout) :: blocks  !< blocks in their present state

      if (.not. has_memory(blocks)) return
      blocks%rest_strain = blocks%position(4:6, :)
      blocks%memory = 0.0_wp
   end subroutine begin_memory

   !> Strain (r − 1) e − r Σ ζ_l that the Maxwell body of block b adds to the elastic strain.
   pure function memory_strain(blocks, b) result(strain)
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      integer, intent(in) :: b                 !< number of the block
      real(wp) :: strain(3)
      integer :: l

      strain = 0.0_wp
      if (.not. (blocks%damps .and. has_memory(blocks))) return
      associate (damping => blocks%damping(blocks%material(b)))
         if (damping%n == 0 .or. damping%by_law) return
         do l = 1, damping%n
            strain = strain + blocks%memory(:, l, b)
         end do
         strain = (damping%unrelaxed - 1.0_wp)*(blocks%position(4:6, b) &
            - blocks%rest_strain(:, b)) - damping%unrelaxed*strain
      end associate
   end function memory_strain

   !> Set the constants and the initial state of block b.
   pure subroutine set_block(blocks, b, polygon, material, plane_strain)
      type(blocks_type), intent(inout) :: blocks   !< blocks with allocated arrays
      integer, intent(in) :: b                     !< block to set
      real(wp), intent(in) :: polygon(:,:)         !< [2, any] counter-clockwise, m
      type(material_type), intent(in) :: material  !< material of the block
      logical, intent(in) :: plane_strain          !< plane strain; .false.: plane stress
      real(wp) :: centre(2)
      integer :: from, to, v

      from = blocks%first(b)
      to = blocks%first(b + 1) - 1
      centre = centroid_of(polygon)
      blocks%owner(from:to) = b
      blocks%next(from:to) = [(v + 1, v=from, to - 1), from]
      blocks%previous(from:to) = [to, (v, v=from, to - 1)]
      blocks%outline(1, from:to) = blocks%previous(from:to)
      blocks%outline(2, from:to) = [(v, v=from, to)]
      blocks%reference(:, from:to) = polygon - spread(centre, 2, size(polygon, 2))
      blocks%radius(b) = maxval(norm2(blocks%reference(:, from:to), 1))
      blocks%area(b) = area_of(polygon)
      blocks%mass(b) = material%density*blocks%area(b)
      blocks%inertia(:, b) = [blocks%mass(b), &
         material%density*second_moments(blocks%reference(:, from:to))]
      blocks%stiffness(:, :, b) = blocks%area(b)*elasticity(material, plane_strain)
      blocks%initial_stress(:, b) = material%initial_stress
      blocks%position(1:2, b) = centre
      blocks%velocity(1:3, b) = material%initial_velocity
   end subroutine set_block

   !> Change the material of block b in its present state without a change of its stress.
   !> A new Maxwell body counts strains from the present strain.
   pure subroutine change_material(blocks, b, number, material, plane_strain)
      type(blocks_type), intent(inout) :: blocks  !< blocks in their present state
      integer, intent(in) :: b       !< number of the block
      integer, intent(in) :: number  !< number of the new material
      type(material_type), intent(in) :: material  !< new material
      logical, intent(in) :: plane_strain          !< plane strain; .false.: plane stress
      real(wp) :: stiffness(3, 3)

      stiffness = blocks%area(b)*elasticity(material, plane_strain)
      if (has_memory(blocks)) then
         blocks%initial_stress(:, b) = blocks%initial_stress(:, b) &
            + matmul(blocks%stiffness(:, :, b), memory_strain(blocks, b))/blocks%area(b)
         blocks%rest_strain(:, b) = blocks%position(4:6, b)
         blocks%memory(:, :, b) = 0.0_wp
      end if
      blocks%material(b) = number
      blocks%initial_stress(:, b) = blocks%initial_stress(:, b) + matmul(blocks%stiffness(:, :, b) &
         - stiffness, blocks%position(4:6, b))/blocks%area(b)
      blocks%stiffness(:, :, b) = stiffness
      blocks%mass(b) = material%density*blocks%area(b)
      blocks%inertia(:, b) = [blocks%mass(b), material%density &
         *second_moments(blocks%reference(:, blocks%first(b):blocks%first(b + 1) - 1))]
   end subroutine change_material

   !> Remove block b from the model: no force acts on it; its position and inertia are retained.
   pure subroutine remove_block(blocks, b)
      type(blocks_type), intent(inout) :: blocks  !< blocks in their present state
      integer, intent(in) :: b  !< number of the block

      blocks%removed(b) = .true.
      blocks%mass(b) = 0.0_wp
      blocks%initial_stress(:, b) = 0.0_wp
      blocks%position(4:6, b) = 0.0_wp
      if (has_memory(blocks)) then
         blocks%rest_strain(:, b) = 0.0_wp
         blocks%memory(:, :, b) = 0.0_wp
      end if
      blocks%velocity(:, b) = 0.0_wp
      blocks%acceleration(:, b) = 0.0_wp
      blocks%mean_velocity(:, :, b) = 0.0_wp
   end subroutine remove_block

   !> Mass matrix M = ρ ∫ TᵀT of a block.
   pure function mass_matrix(inertia) result(m)
      real(wp), intent(in) :: inertia(4)  !< see `blocks_type`
      real(wp) :: m(6, 6)

      associate (mass => inertia(1), xx => inertia(2), yy => inertia(3), xy => inertia(4))
         m = 0.0_wp
         m(1, 1) = mass
         m(2, 2) = mass
         m(3:6, 3) = [xx + yy, -xy, xy, 0.5_wp*(xx - yy)]
         m(3:6, 4) = [-xy, xx, 0.0_wp, 0.5_wp*xy]
         m(3:6, 5) = [xy, 0.0_wp, yy, 0.5_wp*xy]
         m(3:6, 6) = [0.5_wp*(xx - yy), 0.5_wp*xy, 0.5_wp*xy, 0.25_wp*(xx + yy)]
      end associate
   end function mass_matrix

   !> Momenta M v of a block in its coordinates.
   pure function momentum_of(inertia, v) result(momentum)
      real(wp), intent(in) :: inertia(4)  !< see `blocks_type`
      real(wp), intent(in) :: v(6)        !< rates of the coordinates: m/s, rad/s, 1/s
      real(wp) :: momentum(6), half

      associate (mass => inertia(1), xx => inertia(2), yy => inertia(3), xy => inertia(4))
         half = 0.5_wp*v(6)  ! half of the shear strain
         momentum(1:2) = mass*v(1:2)
         momentum(3) = (xx + yy)*v(3) + (xx - yy)*half + xy*(v(5) - v(4))
         momentum(4) = xx*v(4) + xy*(half - v(3))
         momentum(5) = yy*v(5) + xy*(half + v(3))
         momentum(6) = 0.5_wp*((xx - yy)*v(3) + (xx + yy)*half + xy*(v(4) + v(5)))
      end associate
   end function momentum_of

   !> Compute axes, deformation gradients, vertices and edges from the coordinates q.
   subroutine update_geometry(blocks)
      type(blocks_type), intent(inout) :: blocks  !< coordinates; geometry is updated
      integer :: p

      if (blocks%n < parallel_from) then
         call update_geometry_range(blocks, 1, blocks%n)
         return
      end if
      !$omp parallel do schedule(static)
      do p = 1, pieces(blocks%n)
         call update_geometry_range(blocks, first_of(p, blocks%n), last_of(p, blocks%n))
      end do
   end subroutine update_geometry

   !> Update the geometry of blocks first … last.
   pure subroutine update_geometry_range(blocks, first, last)
      type(blocks_type), intent(inout) :: blocks  !< coordinates; geometry is updated
      integer, intent(in) :: first, last          !< first and last index
      integer :: b

      do b = first, last
         call set_axes(blocks%position(:, b), blocks%axes(:, :, b), blocks%gradient(:, :, b))
         associate (from => blocks%first(b), n => blocks%first(b + 1) - blocks%first(b))
            call set_vertices(n, blocks%position(1:2, b), blocks%gradient(:, :, b), &
               blocks%reference(:, from), blocks%vertex(:, from))
         end associate
      end do
      do b = first, last
         associate (from => blocks%first(b), n => blocks%first(b + 1) - blocks%first(b))
            call set_edges(n, blocks%vertex(:, from), blocks%along(:, from))
         end associate
      end do
      associate (from => blocks%first(first), n => blocks%first(last + 1) - blocks%first(first))
         call find_lengths(n, blocks%along(:, from), blocks%length(from))
      end associate
   end subroutine update_geometry_range

   !> Compute R(θ) and R(θ)(I + ε) of a block.
   pure subroutine set_axes(q, axes, gradient)
      real(wp), intent(in) :: q(6)  !< coordinates of the block
      real(wp), intent(out) :: axes(2, 2), gradient(2, 2)  !< R(θ), R(θ)(I + ε)
      real(wp) :: c, s

      c = cos(q(3))
      s = sin(q(3))
      axes(:, 1) = [c, s]
      axes(:, 2) = [-s, c]
      gradient(:, 1) = axes(:, 1)*(1.0_wp + q(4)) + axes(:, 2)*0.5_wp*q(6)
      gradient(:, 2) = axes(:, 1)*0.5_wp*q(6) + axes(:, 2)*(1.0_wp + q(5))
   end subroutine set_axes

   !> Compute the positions of the n vertices of a block.
   pure subroutine set_vertices(n, centre, gradient, reference, vertex)
      integer, intent(in) :: n
      real(wp), intent(in) :: centre(2), gradient(2, 2)
      real(wp), intent(in) :: reference(2, n)  !< offsets ρ, m
      real(wp), intent(out) :: vertex(2, n)    !< m
      integer :: v

      do v = 1, n
         vertex(:, v) = centre + gradient(:, 1)*reference(1, v) + gradient(:, 2)*reference(2, v)
      end do
   end subroutine set_vertices

   !> Compute the edges between the n vertices of a block.
   pure subroutine set_edges(n, vertex, edge)
      integer, intent(in) :: n              !< number of vertices
      real(wp), intent(in) :: vertex(2, n)  !< m
      real(wp), intent(out) :: edge(2, n)   !< m
      integer :: v

      do v = 1, n - 1
         edge(:, v) = vertex(:, v + 1) - vertex(:, v)
      end do
      edge(:, n) = vertex(:, 1) - vertex(:, n)
   end subroutine set_edges

   !> Find the lengths of n edges, and divide the edges by them.
   !> A loop over the edges of all blocks can be vectorised.
   pure subroutine find_lengths(n, edge, length)
      integer, intent(in) :: n               !< number of edges
      real(wp), intent(inout) :: edge(2, n)  !< edges, m; then unit vectors
      real(wp), intent(out) :: length(n)     !< m
      integer :: v

      do v = 1, n
         length(v) = sqrt(edge(1, v)**2 + edge(2, v)**2)
         edge(1, v) = edge(1, v)/length(v)
         edge(2, v) = edge(2, v)/length(v)
      end do
   end subroutine find_lengths

   !> .true. if the angle of the block at vertex v is less than 180°.
   pure logical function is_convex(blocks, v)  ! total
      type(blocks_type), intent(in) :: blocks  !< vertices of each block
      integer, intent(in) :: v                 !< vertex
      real(wp) :: incoming(2), outgoing(2)

      incoming = blocks%reference(:, v) - blocks%reference(:, blocks%previous(v))
      outgoing = blocks%reference(:, blocks%next(v)) - blocks%reference(:, v)
      is_convex = incoming(1)*outgoing(2) - incoming(2)*outgoing(1) > 0.0_wp
   end function is_convex

   !> Present offset from the centroid, m, of the material point with reference offset ρ.
   pure function offset_of(blocks, b, reference) result(offset)
      type(blocks_type), intent(in) :: blocks  !< present state
      integer, intent(in) :: b                 !< number of the block
      real(wp), intent(in) :: reference(2)     !< offset ρ, m
      real(wp) :: offset(2)

      offset = blocks%gradient(:, 1, b)*reference(1) + blocks%gradient(:, 2, b)*reference(2)
   end function offset_of

   !> Present position, m, of the material point with reference offset ρ.
   pure function position_of(blocks, b, reference) result(position)
      type(blocks_type), intent(in) :: blocks  !< present state
      integer, intent(in) :: b                 !< number of the block
      real(wp), intent(in) :: reference(2)     !< offset ρ, m
      real(wp) :: position(2)

      position = blocks%position(1:2, b) + offset_of(blocks, b, reference)
   end function position_of

   !> Reference offset ρ of the material point with present position `position`.
   pure function reference_of(blocks, b, position) result(reference)
      type(blocks_type), intent(in) :: blocks  !< present state
      integer, intent(in) :: b                 !< number of the block
      real(wp), intent(in) :: position(2)         !< m
      real(wp) :: reference(2)
      real(wp) :: offset(2), determinant

      offset = position - blocks%position(1:2, b)
      associate (f => blocks%gradient(:, :, b))
         determinant = f(1, 1)*f(2, 2) - f(1, 2)*f(2, 1)
         reference(1) = (f(2, 2)*offset(1) - f(1, 2)*offset(2))/determinant
         reference(2) = (f(1, 1)*offset(2) - f(2, 1)*offset(1))/determinant
      end associate
   end function reference_of

   !> Shape matrix T [2,6] of the material point ρ of block b (paper eq. 4): u = T d.
   pure function shape_matrix(blocks, b, reference) result(t)
      type(blocks_type), intent(in) :: blocks  !< present state
      integer, intent(in) :: b                 !< number of the block
      real(wp), intent(in) :: reference(2)     !< offset ρ, m
      real(wp) :: t(2, 6)
      real(wp) :: offset(2)

      offset = offset_of(blocks, b, reference)
      associate (axes => blocks%axes(:, :, b))
         t(:, 1) = [1.0_wp, 0.0_wp]
         t(:, 2) = [0.0_wp, 1.0_wp]
         t(:, 3) = [-offset(2), offset(1)]
         t(:, 4) = axes(:, 1)*reference(1)
         t(:, 5) = axes(:, 2)*reference(2)
         t(:, 6) = 0.5_wp*(axes(:, 1)*reference(2) + axes(:, 2)*reference(1))
      end associate
   end function shape_matrix

   !> Motion T d of the material point ρ of block b, for increments or rates of its coordinates.
   pure function motion_of(blocks, b, reference, d) result(motion)
      type(blocks_type), intent(in) :: blocks  !< present state
      integer, intent(in) :: b                 !< number of the block
      real(wp), intent(in) :: reference(2)     !< offset ρ, m
      real(wp), intent(in) :: d(6)  !< increments (m, rad, strains), or rates per s or per s²
      real(wp) :: motion(2)
      real(wp) :: offset(2)

      offset = offset_of(blocks, b, reference)
      associate (axes => blocks%axes(:, :, b))
         motion = d(1:2) + d(3)*[-offset(2), offset(1)] &
            + (d(4)*reference(1) + 0.5_wp*d(6)*reference(2))*axes(:, 1) &
            + (d(5)*reference(2) + 0.5_wp*d(6)*reference(1))*axes(:, 2)
      end associate
   end function motion_of

   !> Mean stress (σx, σy, τxy) of block b in the axes of the model, Pa.
   pure function stress_of(blocks, b, of_faces) result(stress)
      type(blocks_type), intent(in) :: blocks  !< present state
      integer, intent(in) :: b                 !< number of the block
      !> contribution of welded faces to the stress of a cell in its axes, Pa
      real(wp), intent(in), optional :: of_faces(3)
      real(wp) :: stress(3)
      real(wp) :: local(3), tensor(2, 2), r(2, 2)

      local = blocks%initial_stress(:, b) + matmul(blocks%stiffness(:, :, b), &
         blocks%position(4:6, b))/blocks%area(b)
      if (blocks%damps) local = local + matmul(blocks%stiffness(:, :, b), &
         memory_strain(blocks, b))/blocks%area(b)
      if (present(of_faces)) local = blocks%interior_fraction(b)*local + of_faces
      r = blocks%axes(:, :, b)
      tensor = reshape([local(1), local(3), local(3), local(2)], [2, 2])
      tensor = matmul(r, matmul(tensor, transpose(r)))
      stress = [tensor(1, 1), tensor(2, 2), tensor(1, 2)]
   end function stress_of

   !> Smaller side of block b: the smallest width of its vertices normal to an edge, m.
   pure real(wp) function smaller_side(blocks, b) result(side)
      type(blocks_type), intent(in) :: blocks  !< blocks with their reference shapes
      integer, intent(in) :: b                 !< number of the block
      real(wp) :: edge(2)
      integer :: v

      side = huge(1.0_wp)
      associate (shape => blocks%reference(:, blocks%first(b):blocks%first(b + 1) - 1))
         do v = 1, size(shape, 2)
            edge = shape(:, 1 + mod(v, size(shape, 2))) - shape(:, v)
            edge = edge/norm2(edge)
            associate (height => edge(1)*shape(2, :) - edge(2)*shape(1, :))
               side = min(side, maxval(height) - minval(height))
            end associate
         end do
      end associate
   end function smaller_side

end module dda_blocks
