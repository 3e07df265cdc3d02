!> The linearised model of a simulation: mass, elasticity, and the springs of closed contacts and
!> fixed points, without inertia in the stiffness.
!>
!> Contacts count as one of: 'closed', all contacts in touch stick; 'present', as their states are
!> now; 'settled', as gravity closes them (`dda_equilibrium`); 'auto', settled if there is gravity,
!> else closed.
module dda_linear_model
   use dda_kinds, only: wp
   use dda_block_matrix, only: block_matrix_type, set_pattern
   use dda_blocks, only: shape_matrix, place_of
   use dda_contact, only: contacts_type, contact_open, contact_slide, contact_stick
   use dda_errors, only: error_type, error_input, fail
   use dda_equilibrium, only: equilibrium_type, settle
   use dda_simulation, only: simulation_type
   use dda_springs, only: springs_type, reserve_springs, add_spring, stretch_of, add_to_matrix, &
      spring_normal, spring_shear, spring_fixed, spring_kinds
   use dda_support, only: fixed_point_type, point_type
   use dda_text, only: quoted, to_text
   implicit none
   private
   public :: linear_model_type, energy_type, linearise, set_constants, block_label, spring_label, &
      energy_of
   public :: strain_energy, energy_kinds, kind_names, point_row

   integer, parameter :: strain_energy = spring_kinds + 1  !< kind of energy that is not in a spring
   integer, parameter :: energy_kinds = spring_kinds + 1
   character(len=*), parameter :: kind_names(energy_kinds) = &
      [character(len=22) :: 'normal contact springs', 'shear contact springs', 'fixed points', &
      'strain of blocks']
   real(wp), parameter :: touching = 1.0e-6_wp  !< of the smaller block: no gap

   !> K x and M x of small motions, and what they are made of.
   type :: linear_model_type
      integer :: n = 0                              !< blocks
      type(block_matrix_type) :: stiffness          !< K, N/m per metre of thickness
      real(wp), allocatable :: mass(:,:,:)          !< [6,6,n] M
      real(wp), allocatable :: elastic(:,:,:)       !< [3,3,n] of the strains
      type(springs_type) :: springs
      !> of each kind of spring, N/m per metre of thickness
      real(wp) :: constants(spring_kinds) = 0.0_wp
      real(wp) :: shear_ratio = 1.0_wp              !< k_n / k_s
      real(wp) :: fixed_point_ratio = 1.0_wp        !< fixed points / k_n
      real(wp) :: modulus = 0.0_wp                  !< stiffest block material, Pa
      real(wp) :: time_step = 0.0_wp                !< Δt of the run, s
      real(wp) :: dynamic_factor = 1.0_wp           !< of the run
      integer :: closed = 0                         !< contacts that are not open
      integer :: sliding = 0                        !< contacts among them that slide
      real(wp) :: penetration = 0.0_wp              !< deepest of them, m
      real(wp), allocatable :: block_mass(:)        !< [n] kg per metre of thickness
      real(wp), allocatable :: position(:,:)        !< [2,n] centroids, m, in the user's coordinates
      character(len=64), allocatable :: name(:)     !< [n] of the blocks
      type(fixed_point_type), allocatable :: fixed_points(:)
      integer :: base_motion(2) = 0                 !< motions of the base as body force
      type(point_type), allocatable :: points(:)    !< measured points
      real(wp), allocatable :: point_rows(:,:,:)    !< [2,6,points] their shape matrices
      type(equilibrium_type) :: settling               !< of 'settled'
   end type linear_model_type

   !> Where the energy of a motion is.
   type :: energy_type
      !> xᵀKx, sum of all springs and strains without cancellation
      real(wp) :: total = 0.0_wp
      real(wp) :: share(energy_kinds) = 0.0_wp    !< of each kind, sum 1 (0 if there is no energy)
      !> spring, or block for strain, that holds the most of its kind
      integer :: holder(energy_kinds) = 0
      real(wp) :: most(energy_kinds) = 0.0_wp     !< its share of all
   end type energy_type

contains

   !> Linearise a started simulation; it stays as it is.
   subroutine linearise(linear, simulation, which, error)
      type(linear_model_type), intent(out) :: linear
      type(simulation_type), intent(in) :: simulation
      character(len=*), intent(in) :: which  !< contacts: 'closed', 'present', 'settled' or 'auto'
      type(error_type), allocatable, intent(out) :: error
      type(simulation_type) :: settled

      select case (which)
      case ('closed', 'present')
         call build(linear, simulation, which == 'closed')
      case ('settled', 'auto')
         if (norm2(simulation%model%control%gravity) == 0.0_wp .and. which == 'auto') then
            call build(linear, simulation, .true.)
            return
         end if
         call settle(settled, simulation, linear%settling)
         call build(linear, settled, .false.)
         call restore_run(linear, simulation)
      case default
         call fail(error, error_input, 'contacts '//quoted(which)// &
            " are not known; use 'closed', 'present', 'settled' or 'auto'")
      end select
   end subroutine linearise

   subroutine build(linear, simulation, all_closed)
      type(linear_model_type), intent(inout) :: linear
      type(simulation_type), intent(in) :: simulation
      logical, intent(in) :: all_closed
      integer :: p

      associate (model => simulation%model, blocks => simulation%blocks)
         linear%n = blocks%n
         linear%mass = blocks%inertia
         linear%elastic = blocks%stiffness
         linear%block_mass = blocks%mass
         linear%position = blocks%position(1:2, :) + spread(model%origin, 2, blocks%n)
         linear%name = model%block_names
         linear%shear_ratio = simulation%laws%normal_stiffness/simulation%laws%shear_stiffness
         linear%fixed_point_ratio = model%contact%fixed_point_ratio
         linear%modulus = maxval(blocks%stiffness(1, 1, :)/blocks%area)
         linear%time_step = model%control%time_step
         linear%dynamic_factor = model%control%dynamic_factor
         linear%fixed_points = model%fixed_points
         linear%base_motion = model%control%base_motion
         linear%points = model%points
         allocate (linear%point_rows(2, 6, size(model%points)))
         do p = 1, size(model%points)
            linear%point_rows(:, :, p) = shape_matrix(blocks, model%points(p)%block, &
               model%points(p)%reference)
         end do
      end associate
      associate (contacts => simulation%contacts(simulation%now))
         linear%penetration = max(0.0_wp, -minval([0.0_wp, contacts%gap(:contacts%n)]))
         call reserve_springs(linear%springs, 2*contacts%n + 2*size(linear%fixed_points))
         call add_contacts(linear, simulation, contacts, all_closed)
      end associate
      call add_fixed_points(linear, simulation)
      call set_pattern(linear%stiffness, linear%n, coupled_blocks(linear%springs))
      call set_constants(linear, simulation%laws%normal_stiffness)
   end subroutine build

   !> What the settling left out.
   subroutine restore_run(linear, simulation)
      type(linear_model_type), intent(inout) :: linear
      type(simulation_type), intent(in) :: simulation

      linear%dynamic_factor = simulation%model%control%dynamic_factor
      linear%base_motion = simulation%model%control%base_motion
      linear%fixed_points = simulation%model%fixed_points
   end subroutine restore_run

   subroutine add_contacts(linear, simulation, contacts, all_closed)
      type(linear_model_type), intent(inout) :: linear
      type(simulation_type), intent(in) :: simulation
      type(contacts_type), intent(in) :: contacts
      logical, intent(in) :: all_closed
      real(wp) :: place(2), reach
      integer :: c, state

      do c = 1, contacts%n
         associate (v => contacts%block_v(c), e => contacts%block_e(c))
            state = contacts%state(c)
            if (all_closed) then
               reach = touching*min(simulation%blocks%radius(v), simulation%blocks%radius(e))
               state = merge(contact_stick, contact_open, contacts%gap(c) <= reach &
                  .or. contacts%bonded(c))
            end if
            if (state == contact_open) cycle
            place = simulation%blocks%vertex(:, contacts%vertex(c)) + simulation%model%origin
            linear%closed = linear%closed + 1
            call add_spring(linear%springs, spring_normal, c, [v, e], contacts%normal_v(:, c), &
               contacts%normal_e(:, c), place)
            if (state == contact_slide) then
               linear%sliding = linear%sliding + 1
            else
               call add_spring(linear%springs, spring_shear, c, [v, e], contacts%shear_v(:, c), &
                  contacts%shear_e(:, c), place)
            end if
         end associate
      end do
   end subroutine add_contacts

   subroutine add_fixed_points(linear, simulation)
      type(linear_model_type), intent(inout) :: linear
      type(simulation_type), intent(in) :: simulation
      real(wp) :: t(2, 6), row(6), place(2)
      real(wp), parameter :: nothing(6) = 0.0_wp
      integer :: i, axis

      do i = 1, size(linear%fixed_points)
         associate (point => linear%fixed_points(i))
            t = shape_matrix(simulation%blocks, point%block, point%reference)
            place = place_of(simulation%blocks, point%block, point%reference) &
               + simulation%model%origin
            do axis = 1, 2
               row = t(axis, :)
               if (point%held(axis)) call add_spring(linear%springs, spring_fixed, i, &
                  [point%block, 0], row, nothing, place)
            end do
         end associate
      end do
   end subroutine add_fixed_points

   !> Pairs of blocks that springs couple.
   pure function coupled_blocks(springs) result(pairs)
      type(springs_type), intent(in) :: springs
      integer, allocatable :: pairs(:,:)
      integer :: i, count

      allocate (pairs(2, springs%n))
      count = 0
      do i = 1, springs%n
         if (springs%kind(i) /= spring_normal) cycle
         count = count + 1
         pairs(:, count) = [springs%block_a(i), springs%block_b(i)]
      end do
      pairs = pairs(:, :count)
   end function coupled_blocks

   !> Set the normal stiffness; shear springs and fixed points keep their ratios to it.
   subroutine set_constants(linear, normal_stiffness)
      type(linear_model_type), intent(inout) :: linear
      real(wp), intent(in) :: normal_stiffness  !< k_n, N/m per metre of thickness
      integer :: b

      linear%constants = normal_stiffness*[1.0_wp, 1.0_wp/linear%shear_ratio, &
         linear%fixed_point_ratio]
      linear%stiffness%lower = 0.0_wp
      linear%stiffness%diagonal = 0.0_wp
      do b = 1, linear%n
         linear%stiffness%diagonal(4:6, 4:6, b) = linear%elastic(:, :, b)
      end do
      call add_to_matrix(linear%springs, linear%constants, linear%stiffness)
   end subroutine set_constants

   !> Where the energy of a motion is (its Rayleigh quotient, split).
   pure function energy_of(linear, x) result(energy)
      type(linear_model_type), intent(in) :: linear
      real(wp), intent(in) :: x(:,:)  !< [6,n]
      type(energy_type) :: energy
      real(wp) :: part
      integer :: i

      do i = 1, linear%springs%n
         part = linear%constants(linear%springs%kind(i))*stretch_of(linear%springs, i, x)**2
         call book(energy, linear%springs%kind(i), i, part)
      end do
      do i = 1, linear%n
         part = dot_product(x(4:6, i), matmul(linear%elastic(:, :, i), x(4:6, i)))
         call book(energy, strain_energy, i, part)
      end do
      energy%total = sum(energy%share)
      if (energy%total <= tiny(1.0_wp)) return
      energy%share = energy%share/energy%total
      energy%most = energy%most/energy%total
   end function energy_of

   pure subroutine book(energy, kind, holder, part)
      type(energy_type), intent(inout) :: energy
      integer, intent(in) :: kind, holder
      real(wp), intent(in) :: part

      energy%share(kind) = energy%share(kind) + part
      if (part > energy%most(kind)) energy%holder(kind) = holder
      energy%most(kind) = max(energy%most(kind), part)
   end subroutine book

   !> A block by number and name.
   pure function block_label(linear, b) result(label)
      type(linear_model_type), intent(in) :: linear
      integer, intent(in) :: b
      character(len=:), allocatable :: label

      label = 'block '//to_text(b)
      if (linear%name(b) /= '') label = label//' '//quoted(linear%name(b))
   end function block_label

   !> A spring by its kind, blocks and place.
   pure function spring_label(linear, i) result(label)
      type(linear_model_type), intent(in) :: linear
      integer, intent(in) :: i
      character(len=:), allocatable :: label

      associate (springs => linear%springs)
         select case (springs%kind(i))
         case (spring_normal)
            label = 'the normal contact spring between '
         case (spring_shear)
            label = 'the shear contact spring between '
         case default
            label = 'fixed point '//to_text(springs%source(i))//' of '
         end select
         label = label//block_label(linear, springs%block_a(i))
         if (springs%block_b(i) > 0) label = label//' and '//block_label(linear, springs%block_b(i))
         label = label//' at ('//to_text(springs%place(1, i))//', '// &
            to_text(springs%place(2, i))//') m'
      end associate
   end function spring_label

   !> Row that gives the displacement of a measured point along an axis.
   pure function point_row(linear, point, axis) result(row)
      type(linear_model_type), intent(in) :: linear
      integer, intent(in) :: point  !< number of the measured point
      integer, intent(in) :: axis   !< 1: x, 2: y
      real(wp) :: row(6)

      row = linear%point_rows(axis, :, point)
   end function point_row

end module dda_linear_model
