! SPDX-License-Identifier: GPL-3.0-or-later
!> Small models for the tests: groups of an input as text, polygons, blocks, and repeatable random
!> numbers.
module models
   use dda_energy, only: energy_algorithmic, energy_contact, energy_damping, energy_fracture, &
      energy_friction, energy_gravity, energy_initial, energy_input, energy_kinetic, &
      energy_kinetic_damping, energy_strain, energy_support
   use dda_kinds, only: wp, long, pi
   use dda_blocks, only: begin_motion, blocks_type, set_blocks
   use dda_energy, only: energy_type, energy_residual
   use dda_errors, only: error_type
   use dda_input, only: read_model
   use dda_material, only: material_type
   use dda_material_law, only: loss_damping, loss_plastic, loss_scheme, losses, material_law_type, &
      strain_point_type
   use dda_model, only: model_type
   use dda_outlines, only: add_outline, outlines_type
   use dda_scheme, only: scheme_type, step_type
   use dda_simulation, only: simulation_type
   use dda_stages, only: begin_simulation
   use dda_start, only: set_rates
   use dda_time_step, only: advance
   use testing, only: check, check_no_error
   implicit none
   private
   public :: begin, run, number, control_text, contact_text, joint_text, &
      block_text, rock
   public :: random, random_pairs, random_vector, sow, star, rectangle, turned, shifted, &
      make_rock_blocks, place_blocks, fan, relative_balance, walk, on_floor

   !> E = 5 GPa, ν = 0.25, ρ = 2500 kg/m³.
   character(len=*), parameter :: rock = &
      " &material name = 'rock' density = 2500.0 young_modulus = 5.0e9 poisson_ratio = 0.25 /"

   integer(long) :: seed = 1_long   !< of the random numbers

contains

   !> Begin a run at its first state; anything wrong is a failed check.
   subroutine begin(simulation, text, rates)
      type(simulation_type), intent(out) :: simulation
      character(len=*), intent(in) :: text
      real(wp), intent(in), optional :: rates(:,:)  !< [6,blocks] first rates; default: the input's
      type(model_type) :: model
      type(error_type), allocatable :: error

      call read_model(model, 'test.nml', text, error)
      if (.not. allocated(error)) call begin_simulation(simulation, model, error)
      if (present(rates) .and. .not. allocated(error)) call set_rates(simulation, rates, error)
      call check_no_error(error, 'the model starts')
   end subroutine begin

   !> Take steps until one fails; a failed step is a failed check.
   subroutine run(simulation, steps)
      type(simulation_type), intent(inout) :: simulation
      integer, intent(in) :: steps
      type(error_type), allocatable :: error
      integer :: i

      do i = 1, steps
         call advance(simulation, error)
         if (allocated(error)) exit
      end do
      call check_no_error(error, 'all steps close')
   end subroutine run

   !> The energy without a source, as a fraction of the largest energy of the budget.
   pure real(wp) function relative_balance(energy)
      type(energy_type), intent(in) :: energy
      real(wp) :: largest

      largest = maxval(abs([energy%value(energy_kinetic), energy%value(energy_strain), &
         energy%value(energy_contact), energy%value(energy_support), energy%value(energy_gravity), &
         energy%value(energy_input), energy%value(energy_friction), energy%value(energy_fracture), &
         energy%value(energy_algorithmic), energy%value(energy_kinetic_damping), &
         energy%value(energy_damping), energy%value(energy_initial)]))
      relative_balance = 0.0_wp
      if (largest > 0.0_wp) relative_balance = abs(energy_residual(energy))/largest
   end function relative_balance

   !> A number with all its digits.
   pure function number(value) result(text)
      real(wp), intent(in) :: value
      character(len=:), allocatable :: text
      character(len=32) :: buffer

      write (buffer, '(es24.16e3)') value
      text = trim(adjustl(buffer))
   end function number

   !> Text of the group &control.
   pure function control_text(time_step, steps, attributes) result(text)
      real(wp), intent(in) :: time_step
      integer, intent(in) :: steps
      character(len=*), intent(in) :: attributes   !< further variables
      character(len=:), allocatable :: text

      text = ' &control time_step = '//number(time_step)//' steps = '//number(real(steps, wp))// &
         ' '//attributes//' /'
   end function control_text

   !> Text of the group &contact.
   pure function contact_text(normal_stiffness, attributes) result(text)
      real(wp), intent(in) :: normal_stiffness
      character(len=*), intent(in) :: attributes
      character(len=:), allocatable :: text

      text = ' &contact normal_stiffness = '//number(normal_stiffness)//' '//attributes//' /'
   end function contact_text

   !> Text of a group &joint.
   pure function joint_text(friction_angle, cohesion, tensile_strength) result(text)
      real(wp), intent(in) :: friction_angle, cohesion, tensile_strength
      character(len=:), allocatable :: text

      text = ' &joint friction_angle = '//number(friction_angle)//' cohesion = '// &
         number(cohesion)//' tensile_strength = '//number(tensile_strength)//' /'
   end function joint_text

   !> Text of a group &block.
   pure function block_text(name, vertices, block_group_text) result(text)
      character(len=*), intent(in) :: name
      real(wp), intent(in) :: vertices(:,:)
      character(len=*), intent(in), optional :: block_group_text
      character(len=:), allocatable :: text
      integer :: i

      text = ' &block name = '''//name//''' '
      if (present(block_group_text)) text = text//block_group_text
      text = text//' vertices = '
      do i = 1, size(vertices, 2)
         text = text//number(vertices(1, i))//' '//number(vertices(2, i))//' '
      end do
      text = text//'/'
   end function block_text

   !> Text of a floor from (−2, −1) to (2, 0) m that four points hold, and of a block if given.
   pure function on_floor(block, block_group_text, point_text) result(text)
      real(wp), intent(in), optional :: block(:,:)    !< its vertices, m
      character(len=*), intent(in), optional :: block_group_text  !< in the group of the block
      character(len=*), intent(in), optional :: point_text  !< in the groups of the fixed points
      character(len=:), allocatable :: text, of_points
      real(wp) :: points(2, 4)
      integer :: i

      of_points = ''
      if (present(point_text)) of_points = point_text
      points = rectangle(-1.9_wp, -0.9_wp, 1.9_wp, -0.1_wp)
      text = block_text('floor', rectangle(-2.0_wp, -1.0_wp, 2.0_wp, 0.0_wp))
      if (present(block)) text = text//block_text('b', block, block_group_text)
      do i = 1, 4
         text = text//' &fixed_point x = '//number(points(1, i))//' y = '//number(points(2, i))// &
            ' '//of_points//' /'
      end do
   end function on_floor

   !> Begin the random numbers again, so that a test is repeatable by itself.
   subroutine sow(from)
      integer, intent(in) :: from

      seed = 1_long + abs(int(from, long))
   end subroutine sow

   !> Next random number between two bounds (Park and Miller's generator).
   real(wp) function random(lower, upper)
      real(wp), intent(in) :: lower, upper
      integer(long), parameter :: modulus = 2147483647_long

      seed = modulo(48271_long*seed, modulus)
      random = lower + (upper - lower)*real(seed, wp)/real(modulus, wp)
   end function random

   !> Random numbers between −1 and 1.
   function random_vector(n) result(values)
      integer, intent(in) :: n
      real(wp) :: values(n)
      integer :: i

      do i = 1, n
         values(i) = random(-1.0_wp, 1.0_wp)
      end do
   end function random_vector

   !> A star-shaped polygon round the origin, seldom convex.
   function star(m, lower, upper) result(vertices)
      integer, intent(in) :: m
      real(wp), intent(in) :: lower, upper   !< bounds of the radius
      real(wp) :: vertices(2, m)
      real(wp) :: angle, radius
      integer :: i

      do i = 1, m
         angle = 2.0_wp*pi*(real(i, wp) + random(-0.4_wp, 0.4_wp))/real(m, wp)
         radius = random(lower, upper)
         vertices(:, i) = radius*[cos(angle), sin(angle)]
      end do
   end function star

   !> The corners of a rectangle, counter-clockwise.
   pure function rectangle(left, bottom, right, top) result(vertices)
      real(wp), intent(in) :: left, bottom, right, top
      real(wp) :: vertices(2, 4)

      vertices = reshape([left, bottom, right, bottom, right, top, left, top], [2, 4])
   end function rectangle

   !> The vertices turned round the origin by an angle in radians.
   pure function turned(vertices, angle) result(copy)
      real(wp), intent(in) :: vertices(:,:), angle
      real(wp) :: copy(2, size(vertices, 2))

      copy = matmul(reshape([cos(angle), sin(angle), -sin(angle), cos(angle)], [2, 2]), vertices)
   end function turned

   !> The vertices shifted by one vector.
   pure function shifted(vertices, shift) result(copy)
      real(wp), intent(in) :: vertices(:,:), shift(2)
      real(wp) :: copy(2, size(vertices, 2))

      copy = vertices + spread(shift, 2, size(vertices, 2))
   end function shifted

   !> Create blocks of one material from the outlines, ready for time steps.
   subroutine make_rock_blocks(outlines, blocks)
      type(outlines_type), intent(in) :: outlines
      type(blocks_type), intent(out) :: blocks
      type(material_type) :: materials(1)
      integer :: material(outlines%n_vertices)

      materials(1) = material_type('rock', 2500.0_wp, 5.0e9_wp, 0.25_wp, 0.0_wp, 0.0_wp)
      material = 1
      call set_blocks(blocks, outlines%first(:outlines%n + 1), outlines%vertices, &
         material(:outlines%n), material, materials, .false.)
      call begin_motion(blocks)
   end subroutine make_rock_blocks

   !> Set one or two blocks of one rock.
   subroutine place_blocks(blocks, first, second)
      type(blocks_type), intent(out) :: blocks
      real(wp), intent(in) :: first(:,:)             !< [2,vertices] m
      real(wp), intent(in), optional :: second(:,:)  !< [2,vertices] m
      type(outlines_type) :: outlines

      call add_outline(outlines, first, 1, 1, 1, '')
      if (present(second)) call add_outline(outlines, second, 1, 1, 1, '')
      call make_rock_blocks(outlines, blocks)
   end subroutine place_blocks

   !> Find points and weights that integrate quadratics exactly over a polygon.
   !>
   !> The polygon is star-shaped round `centre`; the points are the middles of the sides of each
   !> triangle of the fan.
   pure subroutine fan(vertices, centre, points, weights)
      real(wp), intent(in) :: vertices(:,:), centre(2)
      real(wp), allocatable, intent(out) :: points(:,:), weights(:)
      real(wp) :: a(2), b(2)
      integer :: i, m

      m = size(vertices, 2)
      allocate (points(2, 3*m), weights(3*m))
      do i = 1, m
         a = vertices(:, i)
         b = vertices(:, modulo(i, m) + 1)
         points(:, 3*i - 2) = 0.5_wp*(a + b)
         points(:, 3*i - 1) = 0.5_wp*(a + centre)
         points(:, 3*i) = 0.5_wp*(b + centre)
         a = a - centre
         b = b - centre
         weights(3*i - 2:3*i) = 0.5_wp*(a(1)*b(2) - a(2)*b(1))/3.0_wp
      end do
   end subroutine fan

   !> Check energy and tangent of a material law on a path of 2,000 steps that turns in the plane.
   !>
   !> With θ = χ: s·Δε = Δψ + losses, each ≥ 0, to a fraction of the work; tangents are symmetric.
   subroutine walk(law, point, theta, rounding, path)
      class(material_law_type), intent(in) :: law
      type(strain_point_type), intent(inout) :: point
      real(wp), intent(in) :: theta, rounding(2)  !< error of the balance, loss below 0; of the work
      real(wp), intent(out) :: path(3, 2000)      !< stresses, Pa
      type(step_type) :: step
      real(wp) :: state(law%state_size()), strain(3), change(3), tangent(3, 3), loss(losses)
      real(wp) :: start_energy, work, max_imbalance, min_loss
      integer :: i

      step = step_type(scheme_type(theta, theta), 0.0_wp, 0.005_wp)
      state = 0.0_wp
      strain = 0.0_wp
      max_imbalance = 0.0_wp
      min_loss = 0.0_wp
      work = 0.0_wp
      do i = 1, size(path, 2)
         change = 10.0_wp**(-5.0_wp + 2.0_wp*modulo(0.37_wp*i, 1.0_wp))*([cos(0.02_wp*i), &
            -cos(0.02_wp*i), sin(0.03_wp*i)] + random_vector(3))
         start_energy = law%stored(point, state, strain)
         point%bounding = law%frozen_stress(point, state, strain, change, step)
         call law%respond(point, state, strain, change, step, path(:, i), tangent)
         call law%finish(point, state, strain, change, step, loss)
         strain = strain + change
         path(:, i) = path(:, i) + point%start_stress
         work = work + abs(dot_product(path(:, i), change))
         max_imbalance = max(max_imbalance, abs(dot_product(path(:, i), change) - sum(loss) &
            - law%stored(point, state, strain) + start_energy))
         min_loss = min(min_loss, loss(loss_plastic), loss(loss_damping), loss(loss_damping) &
            + loss(loss_scheme))
         call check(maxval(abs(tangent - transpose(tangent))) <= 1.0e-12_wp &
            *max(maxval(tangent), point%elasticity(1, 1)), 'the tangent is symmetric')
      end do
      call check(max_imbalance < rounding(1)*work, 'work is what is stored and lost')
      call check(min_loss > -rounding(2)*work, 'no loss is below 0')
   end subroutine walk

   !> Random pairs i ≠ j in any order, with repeats.
   function random_pairs(n, count) result(pairs)
      integer, intent(in) :: n, count
      integer :: pairs(2, count)
      integer :: p

      do p = 1, count
         pairs(1, p) = 1 + int(random(0.0_wp, real(n, wp) - 1.0e-6_wp))
         pairs(2, p) = 1 + modulo(pairs(1, p) + int(random(0.0_wp, real(n - 1, wp) - 1.0e-6_wp)), n)
      end do
   end function random_pairs

end module models
