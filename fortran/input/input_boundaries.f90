! SPDX-License-Identifier: GPL-3.0-or-later
!> Groups &boundary: edges of the outline that are fixed, rest on springs, or absorb waves.
!>
!> Fixed edges become fixed points at the Gauss points of the edges; other edges become
!> boundaries or free fields of the model.  Incoming motions are recorded.  No edge may have two
!> boundaries in the same direction.
module dda_input_boundaries
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type, position_of
   use dda_boundary, only: boundary_type, boundary_motion_type, boundary_edge_type
   use dda_edge_part, only: edge_part_type, gauss_points, part_length, part_normal
   use dda_errors, only: error_type
   use dda_free_field, only: free_field_type
   use dda_input_edges, only: choose_edges
   use dda_input_group, only: group_type, fail_input, is_set, positions, value_or, name_length
   use dda_input_groups, only: boundary_values, read_values
   use dda_input_free_field, only: find_column, check_ties
   use dda_input_points, only: find_motions
   use dda_input_settings, only: require_analysis
   use dda_material, only: material_type, elasticity
   use dda_model, only: model_type, block_label
   use dda_support, only: fixed_point_type, point_type
   use dda_text, only: quoted, short_text, to_text
   use dda_tie, only: tie_faces
   use dda_weld, only: weld_type, is_shifted, assign_triangles
   implicit none
   private
   public :: read_boundaries, check_rest, kind_type, boundary_kinds, effective_kind

   !> Properties of a kind of boundary.
   type :: kind_type
      character(len=16) :: name
      character(len=16) :: at_rest  !< equivalent kind in models with static stages only
      character(len=6) :: direction !< default direction in static stages, or blank
      logical :: holds              !< the boundary consists of fixed points
      logical :: absorbs            !< dashpots of a half-space along the edges absorb waves
   end type kind_type

   !> kinds of boundaries; new kinds are registered here
   type(kind_type), parameter :: boundary_kinds(7) = [ &
      kind_type('fixed', 'fixed', 'xy', .true., .false.), kind_type('roller', 'roller', 'normal', &
         .true., .false.), kind_type('springs', 'springs', 'xy', .true., .false.), &
         kind_type('viscous', 'fixed', 'xy', .false., .true.), kind_type('compliant', 'fixed', &
         'xy', .false., .true.), kind_type('tied', 'tied', '', .false., .false.), &
         kind_type('free_field', 'roller', 'normal', .false., .false.)]

   !> Values of a &boundary group and its kind.
   type, extends(boundary_values) :: reading_type
      type(kind_type) :: is                    !< kind of the boundary
   end type reading_type

   real(wp), parameter :: least_overlap = 1.0e-9_wp  !< smallest overlap/edge length of two parts
   real(wp), parameter :: parallel = 1.0e-6_wp      !< sine of the angle between equal directions

contains

   !> Read all boundaries of an input.
   subroutine read_boundaries(model, groups, error)
      type(model_type), intent(inout) :: model  !< model with blocks, motions and fixed points
      type(group_type), intent(in) :: groups(:)  !< groups of the input, in its order
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(reading_type) :: reading
      type(edge_part_type), allocatable :: parts(:)
      integer, allocatable :: group_numbers(:)
      integer :: i

      if (allocated(error)) return
      allocate (model%boundary_edges(0), model%boundaries(0), model%boundary_motions(0), &
         model%ties(0), model%free_fields(0))
      group_numbers = positions(groups, 'boundary')
      do i = 1, size(group_numbers)
         associate (group => groups(group_numbers(i)))
            call read_boundary(group, reading, error)
            if (allocated(error)) return
            select case (reading%kind)
            case ('tied')
               call tie_sides(model, group, reading, parts, error)
            case ('free_field')
               call add_free_field(model, group, reading, parts, error)
            case default
               call choose_edges(group, reading%edges, model, parts, error)
               call check_kind(reading, group, model, error)
               if (.not. allocated(error)) call add_boundary(model, group, reading, parts, error)
            end select
            if (allocated(error)) return
            if (.not. is_fixed_kind(reading)) reading%direction = 'xy'
            call reserve_edges(model, groups(group_numbers(:i))%line, group, parts, &
               trim(reading%direction), error)
         end associate
      end do
   end subroutine read_boundaries

   !> .true. if the boundary consists of fixed points.
   pure logical function is_fixed_kind(reading)  ! total
      type(reading_type), intent(in) :: reading  !< group as read

      is_fixed_kind = reading%is%holds .or. reading%motion_is == 'within'
   end function is_fixed_kind

   !> Kind of a group, replaced by 'fixed' if motion_is = 'within'.
   pure function effective_kind(group) result(kind)
      type(group_type), intent(in) :: group  !< &boundary, checked
      character(len=:), allocatable :: kind
      type(boundary_values) :: input
      type(error_type), allocatable :: error

      call read_values(group, input, error)
      kind = trim(input%kind)
      if (input%motion_is == 'within') kind = 'fixed'
   end function effective_kind

   !> Reject support by dashpots alone under gravity: the model would sink without limit.
   subroutine check_rest(model, groups, error)
      type(model_type), intent(in) :: model  !< model with boundaries and stages
      type(group_type), intent(in) :: groups(:)  !< groups of the input, in its order
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer :: i

      if (allocated(error)) return
      if (size(model%boundaries) == 0 .or. model%stages(1)%static) return
      if (norm2(model%control%gravity) == 0.0_wp) return
      do i = 1, size(groups)
         if (groups(i)%name /= 'boundary') cycle
         call fail_input(error, groups(i), 'dashpots cannot support weight, so a model with '// &
            'gravity needs settle = .true. of &control, or a static stage first')
      end do
   end subroutine check_rest

   !> Read the variables of a group.
   subroutine read_boundary(group, reading, error)
      type(group_type), intent(in) :: group  !< group of the input
      type(reading_type), intent(out) :: reading  !< group as read
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer :: k

      call read_values(group, reading%boundary_values, error)
      if (allocated(error)) return
      k = findloc(boundary_kinds%name == reading%kind, .true., 1)
      if (k > 0) reading%is = boundary_kinds(k)
      if (k == 0) call fail_input(error, group, 'kind = '//quoted(reading%kind)// &
         ' is not registered in dda_input_boundaries')
   end subroutine read_boundary

   !> .true. if the boundary follows a motion, or has an incoming motion.
   pure logical function has_motion(reading)  ! total
      class(boundary_values), intent(in) :: reading  !< values of the group

      has_motion = any([reading%motion_x, reading%motion_y] /= '')
   end function has_motion

   !> Check the values of a boundary, and the properties of the model that its kind requires.
   subroutine check_kind(reading, group, model, error)
      type(reading_type), intent(inout) :: reading  !< group as read; defaults are set
      type(group_type), intent(in) :: group  !< group of the input
      type(model_type), intent(in) :: model  !< model with its motions
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      if (reading%direction == '') reading%direction = reading%is%direction
      if (reading%kind == 'roller' .and. reading%direction == 'xy') call fail_input(error, group, &
         "a roller fixes one direction: 'normal', 'x' or 'y'; kind = 'fixed' fixes both")
      if (reading%direction == 'normal' .and. has_motion(reading) .and. is_fixed_kind(reading)) &
         call fail_input(error, group, "motion_x and motion_y need direction = 'x', 'y' or 'xy'")
      if (reading%is%absorbs) call require_analysis(error, group, model%control, &
         'dashpots for waves')
      if (reading%is%absorbs .and. model%control%dynamic_factor < 1.0_wp) call fail_input(error, &
         group, 'dashpots require velocities, so dynamic_factor of &control must be 1')
      if (reading%is%absorbs .and. any(model%control%base_motion > 0)) call fail_input(error, &
         group, 'dashpots cannot be used in the frame of a base that base_motion_x and '// &
         'base_motion_y of '// &
         "&control accelerate; apply the motion to a boundary of kind = 'compliant'")
   end subroutine check_kind

   !> Tie the left side to the right side of the model.
   subroutine tie_sides(model, group, reading, parts, error)
      type(model_type), intent(inout) :: model  !< receives the ties
      type(group_type), intent(in) :: group  !< group of the input
      type(reading_type), intent(in) :: reading  !< group as read
      type(edge_part_type), allocatable, intent(out) :: parts(:)  !< both sides
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(edge_part_type), allocatable :: left_faces(:), right_faces(:)
      type(weld_type), allocatable :: welds(:)
      real(wp) :: width

      if (are_tied(model)) call fail_input(error, group, 'the sides may be tied only once')
      if (size(model%free_fields) > 0) call reject_ties_and_fields(group, error)
      if (model%contact%original_rules) call fail_input(error, group, &
         "ties require bonds, which contact_rules = 'original' of &contact does not support")
      call choose_edges(group, reading%edges, model, left_faces, error, 'left')
      call choose_edges(group, reading%edges, model, right_faces, error, 'right')
      if (allocated(error)) return
      width = maxval(model%blocks%vertex(1, :)) - minval(model%blocks%vertex(1, :))
      call tie_faces(model%blocks, right_faces, left_faces, [width, 0.0_wp], model%ties, welds)
      call check_ties(model, group, model%blocks, model%ties, error)
      call assign_triangles(model%blocks, welds)
      model%welds = [model%welds, welds]
      parts = [left_faces, right_faces]
      if (.not. are_tied(model)) call fail_input(error, group, &
         'the left and the right side are at different heights, so no edges can be tied')
   end subroutine tie_sides

   !> .true. if the left side is tied or welded to the right side.
   pure logical function are_tied(model)
      type(model_type), intent(in) :: model  !< model with its blocks

      are_tied = size(model%ties) > 0
      if (.not. are_tied) are_tied = any(is_shifted(model%welds))
   end function are_tied

   !> Reject a model with both tied sides and free fields.
   subroutine reject_ties_and_fields(group, error)
      type(group_type), intent(in) :: group  !< group of the input
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      call fail_input(error, group, "kind = 'tied' and kind = 'free_field' both "// &
         'continue the ground beyond a side; remove one of them')
   end subroutine reject_ties_and_fields

   !> Add a free field beyond a side.
   subroutine add_free_field(model, group, reading, parts, error)
      type(model_type), intent(inout) :: model  !< model that receives the free field
      type(group_type), intent(in) :: group  !< group of the input
      type(reading_type), intent(in) :: reading  !< group as read
      type(edge_part_type), allocatable, intent(out) :: parts(:)  !< the side
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(free_field_type) :: field

      field%side = reading%edges%side(:len(field%side))
      if (all(field%side /= ['left ', 'right'])) call fail_input(error, group, &
         "kind = 'free_field' needs side = 'left' or side = 'right', and acts on the whole side")
      if (are_tied(model)) call reject_ties_and_fields(group, error)
      if (any(model%free_fields%side == field%side)) call fail_input(error, group, &
         'this side already has a free field; remove this group')
      if (model%contact%original_rules) call fail_input(error, group, 'a free field requires '// &
         "bonds, which contact_rules = 'original' of &contact does not support")
      if (model%control%dynamic_factor < 1.0_wp) call fail_input(error, group, &
         'dashpots require velocities, so dynamic_factor of &control must be 1')
      call require_analysis(error, group, model%control, 'the waves of a free field')
      call choose_edges(group, reading%edges, model, parts, error)
      if (allocated(error)) return
      field%boundary%name = reading%name
      field%boundary%kind = reading%kind
      field%boundary%part = parts
      field%boundary%point = boundary_points(model, reading, parts)
      call set_half_space(field%boundary, model, reading, group, error)
      call find_column(model, group, field, error)
      field%top = highest_corner(model%blocks, parts)
      model%free_fields = [model%free_fields, field]
      model%boundary_motions = [model%boundary_motions, boundary_motion_type(label(reading, &
         'free field '//field%side), [field%top], [1.0_wp], field=size(model%free_fields))]
   end subroutine add_free_field

   !> Return the highest corner of parts of edges.
   pure type(point_type) function highest_corner(blocks, parts) result(top)
      type(blocks_type), intent(in) :: blocks         !< blocks of the model
      type(edge_part_type), intent(in) :: parts(:)  !< parts, at least one
      integer :: corner(2*size(parts)), highest_index

      corner = [parts%edge, blocks%next(parts%edge)]
      highest_index = corner(maxloc(blocks%vertex(2, corner), 1))
      top = point_type('', blocks%owner(highest_index), blocks%reference(:, highest_index), &
         blocks%vertex(:, highest_index))
   end function highest_corner

   !> Name of a group, or a substitute.
   pure character(len=name_length) function label(reading, substitute)
      type(reading_type), intent(in) :: reading  !< group as read
      character(len=*), intent(in) :: substitute      !< text for a boundary without a name

      label = reading%name
      if (label == '') label = substitute
   end function label

   !> Add supports or dashpots at the Gauss points of the parts.
   subroutine add_boundary(model, group, reading, parts, error)
      type(model_type), intent(inout) :: model  !< receives the boundary
      type(group_type), intent(in) :: group  !< group of the input
      type(reading_type), intent(in) :: reading  !< group as read
      type(edge_part_type), intent(in) :: parts(:)  !< edges
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(boundary_type) :: new
      type(fixed_point_type), allocatable :: points(:)
      integer :: motion(2), i

      motion = 0
      call find_motions(group, [reading%motion_x, reading%motion_y], model%motions, motion, error)
      if (allocated(error)) return
      points = boundary_points(model, reading, parts)
      if (is_fixed_kind(reading)) then
         do i = 1, size(points)
            points(i)%motion = motion
         end do
         if (reading%is%holds .and. any(motion > 0 .and. .not. points(1)%fixed_along)) &
            call fail_input(error, group, 'a motion is given in a direction that is not fixed')
         model%fixed_points = [model%fixed_points, points]
         return
      end if
      if (.not. reading%is%absorbs) call fail_input(error, group, 'kind = '// &
         quoted(reading%kind)//' neither supports nor absorbs: add_boundary rejects it')
      new%name = reading%name
      new%kind = reading%kind
      new%part = parts
      new%point = points
      new%motion = motion
      if (reading%motion_is == 'incoming') new%factor = 2.0_wp
      call set_half_space(new, model, reading, group, error)
      model%boundaries = [model%boundaries, new]
      if (any(motion > 0)) model%boundary_motions = [model%boundary_motions, &
         mean_motion(model%blocks, new, label(reading, 'boundary '// &
         to_text(size(model%boundaries))))]
   end subroutine add_boundary

   !> Add the incoming motion of a boundary, and the mean motion of its edges.
   !> The incoming motion is half of the outcrop motion.
   pure type(boundary_motion_type) function mean_motion(blocks, boundary, name) result(mean)
      type(blocks_type), intent(in) :: blocks        !< blocks of the model
      type(boundary_type), intent(in) :: boundary    !< compliant boundary
      character(len=*), intent(in) :: name           !< name of the boundary
      integer :: i

      mean%name = name
      mean%point = [(point_type('', boundary%point(i)%block, boundary%point(i)%reference, &
         boundary%point(i)%position), i=1, size(boundary%point))]
      mean%weight = [(part_length(blocks, boundary%part((i + 1)/2)), i=1, size(mean%point))]
      mean%weight = mean%weight/sum(mean%weight)
      mean%motion = boundary%motion
      mean%factor = 0.5_wp*boundary%factor
   end function mean_motion

   !> Find the Gauss points of parts, and their fixed directions.
   function boundary_points(model, reading, parts) result(points)
      type(model_type), intent(in) :: model  !< model with its blocks
      type(reading_type), intent(in) :: reading  !< group as read
      type(edge_part_type), intent(in) :: parts(:)  !< edges
      type(fixed_point_type), allocatable :: points(:)  !< [2 × parts]
      real(wp) :: reference(2, 2), normal(2)
      integer :: i, g

      allocate (points(2*size(parts)))
      points%name = reading%name
      do i = 1, size(parts)
         reference = gauss_points(model%blocks, parts(i))
         normal = part_normal(model%blocks, parts(i))
         do g = 1, 2
            associate (point => points(2*i - 2 + g))
               point%block = parts(i)%block
               point%reference = reference(:, g)
               point%position = position_of(model%blocks, point%block, point%reference)
               point%stiffness = 0.5_wp*part_length(model%blocks, parts(i)) &
                  *value_or(reading%stiffness_per_area, 0.0_wp)
               point%fixed_along = [index(reading%direction, 'x') > 0, index(reading%direction, &
                  'y') > 0]
               if (reading%direction == 'normal') then
                  point%fixed_along = [.true., .false.]
                  point%axes = reshape([normal(1), normal(2), -normal(2), normal(1)], [2, 2])
               end if
            end associate
         end do
      end do
   end function boundary_points

   !> Set normals, and dashpots of the half-space; default: the material of each block.
   subroutine set_half_space(boundary, model, reading, group, error)
      type(boundary_type), intent(inout) :: boundary  !< boundary with its parts
      type(model_type), intent(in) :: model  !< model with its blocks and materials
      type(reading_type), intent(in) :: reading  !< group as read
      type(group_type), intent(in) :: group  !< group of the input
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(material_type) :: rock
      real(wp) :: density, speed(2), moduli(3, 3)
      integer :: i

      associate (parts => boundary%part)
         allocate (boundary%normal(2, size(parts)), boundary%dashpot(2, size(parts)))
         do i = 1, size(parts)
            rock = model%materials(model%blocks%material(parts(i)%block))
            moduli = elasticity(rock, model%control%plane_strain)
            speed = sqrt([moduli(1, 1), moduli(3, 3)]/rock%density)  ! V_p, V_s
            density = value_or(reading%density, rock%density)
            if (is_set(reading%shear_velocity)) speed = speed*(reading%shear_velocity/speed(2))
            speed(1) = value_or(reading%pressure_velocity, speed(1))
            if (speed(1) <= speed(2)) call fail_input(error, group, &
               'pressure_velocity ('//short_text(speed(1))// &
               ' m/s) must exceed the velocity of S waves ('//short_text(speed(2))//' m/s)')
            boundary%normal(:, i) = part_normal(model%blocks, parts(i))
            boundary%dashpot(:, i) = 0.5_wp*density*part_length(model%blocks, parts(i))*speed
         end do
      end associate
   end subroutine set_half_space

   !> Add the parts of a group; reject parts that have a boundary in the same direction.
   subroutine reserve_edges(model, lines, group, parts, direction, error)
      type(model_type), intent(inout) :: model  !< model; receives the parts
      integer, intent(in) :: lines(:)  !< [groups &boundary so far] line numbers in the input
      type(group_type), intent(in) :: group  !< group of the input
      type(edge_part_type), intent(in) :: parts(:)  !< parts of the group
      character(len=*), intent(in) :: direction  !< direction as in `boundary_edge_type`
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      logical :: has_boundary(size(model%blocks%owner))
      integer :: i, k

      has_boundary = .false.
      has_boundary(model%boundary_edges%part%edge) = .true.
      do i = 1, size(parts)
         if (.not. has_boundary(parts(i)%edge)) cycle
         do k = 1, size(model%boundary_edges)
            if (.not. overlaps(model%blocks, parts(i), direction, model%boundary_edges(k))) cycle
            call fail_input(error, group, 'edge '//to_text(parts(i)%edge &
               - model%blocks%first(parts(i)%block) + 1)//' of '// &
               block_label(model, parts(i)%block)//' has the &boundary of line '// &
               to_text(lines(model%boundary_edges(k)%group))//' already; leave the edge out '// &
               'of one group, or set different directions')
            return
         end do
      end do
      model%boundary_edges = [model%boundary_edges, (boundary_edge_type(size(lines), parts(i), &
         direction), i=1, size(parts))]
   end subroutine reserve_edges

   !> .true. if a part overlaps a part of another group, and both act in one direction.
   pure logical function overlaps(blocks, part, direction, existing)
      type(blocks_type), intent(in) :: blocks         !< blocks of the model
      type(edge_part_type), intent(in) :: part      !< new part
      character(len=*), intent(in) :: direction       !< direction of the new boundary
      type(boundary_edge_type), intent(in) :: existing   !< existing part
      real(wp) :: a(2), b(2)

      overlaps = part%edge == existing%part%edge .and. min(part%to, existing%part%to) &
         - max(part%from, existing%part%from) > least_overlap
      if (.not. overlaps .or. direction == 'xy' .or. existing%direction == 'xy') return
      a = unit_vector(blocks, part, direction)
      b = unit_vector(blocks, part, existing%direction)
      overlaps = abs(a(1)*b(2) - a(2)*b(1)) <= parallel
   end function overlaps

   !> Direction of a boundary that acts in one direction.
   pure function unit_vector(blocks, part, direction) result(vector)
      type(blocks_type), intent(in) :: blocks      !< blocks of the model
      type(edge_part_type), intent(in) :: part   !< part of an edge with the boundary
      character(len=*), intent(in) :: direction    !< 'x', 'y' or 'normal'
      real(wp) :: vector(2)

      vector = part_normal(blocks, part)
      if (direction == 'x') vector = [1.0_wp, 0.0_wp]
      if (direction == 'y') vector = [0.0_wp, 1.0_wp]
   end function unit_vector

end module dda_input_boundaries
