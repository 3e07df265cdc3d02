! SPDX-License-Identifier: GPL-3.0-or-later
!> The groups &traction and &water: loads on edges.
module dda_input_edge_loads
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type, place_of
   use dda_edge_load, only: edge_load_type, load_uniform, load_level, load_surface, load_line
   use dda_edge_piece, only: edge_piece_type, reference_at
   use dda_errors, only: error_type
   use dda_input_edges, only: edge_choice_type, choose_edges, take_polyline, most_values
   use dda_input_group, only: place_type, place_of_group, input_error, check_read, require, &
      require_choice, require_list, unset, is_set, name_length
   use dda_input_names, only: mark_names, list_length
   use dda_model, only: model_type
   use dda_namelist_groups, only: group_type
   use dda_outline, only: outline_of, pieces_along
   use dda_text, only: quoted, to_text
   implicit none
   private
   public :: read_edge_loads

   integer, parameter :: most_times = 4096
   real(wp), parameter :: water_weight = 9810.0_wp  !< N/m³
   real(wp), parameter :: covered = 1.0e-6_wp  !< of a line's length that may lie on no edge

contains

   !> All tractions and waters of an input.
   subroutine read_edge_loads(model, file, groups, error)
      type(model_type), intent(inout) :: model  !< with its blocks
      character(len=*), intent(in) :: file  !< path
      type(group_type), intent(in) :: groups(:)  !< of the input, in its order
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(place_type) :: place
      type(edge_load_type) :: new
      integer :: i

      if (allocated(error)) return
      allocate (model%edge_loads(0))
      do i = 1, size(groups)
         place = place_of_group(file, groups(i))
         select case (groups(i)%name)
         case ('traction')
            call read_traction(groups(i)%text, place, model, new, error)
         case ('water')
            call read_water(groups(i)%text, place, model, new, error)
         case default
            cycle
         end select
         if (allocated(error)) return
         if (new%name /= '' .and. (any(model%edge_loads%name == new%name) .or. &
            any(model%bolts%name == new%name))) call input_error(error, place, 'name = '// &
            quoted(trim(new%name))//' is used twice')
         call note_ends(model%blocks, new)
         model%edge_loads = [model%edge_loads, new]
      end do
   end subroutine read_edge_loads

   !> Where the pieces end at first.
   pure subroutine note_ends(blocks, load)
      type(blocks_type), intent(in) :: blocks  !< in their first state
      type(edge_load_type), intent(inout) :: load  !< with its pieces
      integer :: k, i

      if (allocated(load%ends)) deallocate (load%ends)
      allocate (load%ends(2, 2, size(load%piece)))
      do k = 1, size(load%piece)
         do i = 1, 2
            load%ends(:, i, k) = place_of(blocks, load%piece(k)%block, reference_at(blocks, &
               load%piece(k), i - 1.0_wp))
         end do
      end do
   end subroutine note_ends

   !> &traction
   subroutine read_traction(group, place, model, new, error)
      character(len=*), intent(in) :: group  !< its text, on one line
      type(place_type), intent(in) :: place  !< of the group
      type(model_type), intent(in) :: model  !< with its blocks
      type(edge_load_type), intent(out) :: new  !< as the group says
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      character(len=name_length) :: name, side
      character(len=list_length) :: blocks
      character(len=256) :: message
      real(wp) :: along(most_values), edges(most_values), unit_weight
      real(wp), dimension(most_times) :: time, normal, shear, level
      logical :: follows
      integer :: status
      namelist /traction/ name, side, along, blocks, edges, time, normal, shear, level, &
         unit_weight, follows

      name = ''
      side = ''
      blocks = ''
      along = unset
      edges = unset
      time = unset
      normal = unset
      shear = unset
      level = unset
      unit_weight = water_weight
      follows = .true.
      read (group, nml=traction, iostat=status, iomsg=message)
      call check_read(error, place, status, message)
      call require(error, place, 'unit_weight', [unit_weight])
      call choose_edges(edge_choice_type(side, along, blocks, edges), place, model%blocks, &
         model%block_names, model%origin, new%piece, error)
      if (.not. any(is_set([normal, shear, level]))) call input_error(error, place, &
         'there is no load: give normal, shear or level')
      if (any(is_set(level)) .and. any(is_set([normal, shear]))) call input_error(error, place, &
         'level is that of a hydrostatic pressure, without normal and shear')
      new%name = name
      new%follows = follows
      new%unit_weight = unit_weight
      new%kind = merge(load_level, load_uniform, any(is_set(level)))
      call set_times(new, place, time, error)
      call take(new, place, 'normal', normal, 0.0_wp, new%normal, error)
      call take(new, place, 'shear', shear, 0.0_wp, new%shear, error)
      call take(new, place, 'level', level, 0.0_wp, new%level, error)
      if (new%kind == load_level .and. .not. allocated(error)) new%level = new%level &
         - model%origin(2)
   end subroutine read_traction

   !> The times of a load; without any it lasts for ever.
   subroutine set_times(load, place, time, error)
      type(edge_load_type), intent(inout) :: load  !< its times
      type(place_type), intent(in) :: place  !< of the group
      real(wp), intent(in) :: time(:)  !< s, as read
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      integer :: n

      n = count(is_set(time))
      load%held = n == 0
      load%time = [0.0_wp]
      if (n == 0) return
      call require_list(error, place, 'time', time(:n))
      if (n < 2) call input_error(error, place, 'time: at least 2 values are needed')
      if (any(time(2:n) < time(:n - 1))) call input_error(error, place, 'time must not decrease')
      load%time = time(:n)
   end subroutine set_times

   !> The values of a variable at the times of a load; one value counts for all of them.
   subroutine take(load, place, name, given, default, values, error)
      type(edge_load_type), intent(in) :: load  !< its times
      type(place_type), intent(in) :: place  !< of the group
      character(len=*), intent(in) :: name  !< of the variable
      real(wp), intent(in) :: given(:)  !< as read
      real(wp), intent(in) :: default  !< where none is given
      real(wp), allocatable, intent(out) :: values(:)  !< [times]
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      integer :: n

      n = count(is_set(given))
      values = spread(default, 1, size(load%time))
      if (n == 0 .or. allocated(error)) return
      call require_list(error, place, name, given(:n))
      if (n == 1) then
         values = given(1)
      else if (n /= size(load%time)) then
         call input_error(error, place, name//' must have one value, or as many as time ('// &
            to_text(size(load%time))//')')
      else
         values = given(:n)
      end if
   end subroutine take

   !> &water
   subroutine read_water(group, place, model, new, error)
      character(len=*), intent(in) :: group  !< its text, on one line
      type(place_type), intent(in) :: place  !< of the group
      type(model_type), intent(in) :: model  !< with its blocks
      type(edge_load_type), intent(out) :: new  !< as the group says
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      character(len=name_length) :: name, acts_on
      character(len=list_length) :: joints
      character(len=256) :: message
      real(wp), dimension(most_values) :: surface, along, head, pressure
      real(wp), dimension(most_times) :: time, rise, scale
      real(wp) :: unit_weight
      integer :: status
      namelist /water/ name, surface, along, head, pressure, acts_on, joints, unit_weight, time, &
         rise, scale

      name = ''
      acts_on = 'all'
      joints = ''
      surface = unset
      along = unset
      head = unset
      pressure = unset
      time = unset
      rise = unset
      scale = unset
      unit_weight = water_weight
      read (group, nml=water, iostat=status, iomsg=message)
      call check_read(error, place, status, message)
      call require(error, place, 'unit_weight', [unit_weight])
      call require_choice(error, place, 'acts_on', acts_on)
      if (any(is_set(surface)) .eqv. any(is_set(along))) call input_error(error, place, &
         'give either surface, a phreatic line, or along, with head or pressure at its points')
      if (allocated(error)) return
      new%name = name
      new%unit_weight = unit_weight
      call wettable(model, place, acts_on, joints, new%piece, error)
      if (any(is_set(surface))) then
         if (any(is_set([head, pressure]))) call input_error(error, place, &
            'head and pressure are those of the points of along')
         call set_surface(new, model, place, surface, error)
      else
         call set_line(new, model, place, along, head, pressure, error)
      end if
      call set_times(new, place, time, error)
      call take(new, place, 'scale', scale, 1.0_wp, new%normal, error)
      call take(new, place, 'rise', rise, 0.0_wp, new%level, error)
      new%shear = spread(0.0_wp, 1, size(new%time))
      new%held = .true.
   end subroutine read_water

   !> The edges that water may act on: all, those of joints between blocks, or those of the outline.
   subroutine wettable(model, place, acts_on, joints, pieces, error)
      type(model_type), intent(in) :: model  !< with its blocks
      type(place_type), intent(in) :: place  !< of the group
      character(len=*), intent(in) :: acts_on, joints  !< as read
      type(edge_piece_type), allocatable, intent(out) :: pieces(:)  !< of edges
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      logical :: all_blocks(model%blocks%n), wanted(size(model%joints))
      type(edge_piece_type), allocatable :: free(:)
      integer :: v

      all_blocks = .true.
      wanted = joints == ''
      allocate (pieces(0))
      call mark_names(joints, 'joints', model%joints%name, place, wanted, error)
      if (allocated(error)) return
      associate (blocks => model%blocks)
         pieces = [(edge_piece_type(blocks%owner(v), v), v=1, size(blocks%owner))]
         if (acts_on /= 'all') call outline_of(blocks, all_blocks, free)
         if (acts_on == 'faces') pieces = free
         if (acts_on == 'joints') pieces = without(pieces, free)
         pieces = pack(pieces, wanted(blocks%joint(pieces%edge)))
      end associate
   end subroutine wettable

   !> What is left of whole edges without some pieces of them, which are in the same order.
   function without(edges, pieces) result(left)
      type(edge_piece_type), intent(in) :: edges(:)   !< whole ones
      type(edge_piece_type), intent(in) :: pieces(:)  !< to leave out
      type(edge_piece_type), allocatable :: left(:)
      type(edge_piece_type) :: rest
      integer :: i, k, n

      allocate (left(size(edges) + size(pieces)))
      n = 0
      k = 1
      do i = 1, size(edges)
         rest = edges(i)
         do
            if (k > size(pieces)) exit
            if (pieces(k)%edge /= rest%edge) exit
            rest%to = pieces(k)%from
            call keep()
            rest%from = pieces(k)%to
            k = k + 1
         end do
         rest%to = 1.0_wp
         call keep()
      end do
      left = left(:n)

   contains

      !> Take what is there of the rest.
      subroutine keep()
         if (rest%to - rest%from <= covered) return
         n = n + 1
         left(n) = rest
      end subroutine keep
   end function without

   !> A phreatic line within the model.
   subroutine set_surface(load, model, place, given, error)
      type(edge_load_type), intent(inout) :: load  !< with its pieces
      type(model_type), intent(in) :: model  !< with its blocks
      type(place_type), intent(in) :: place  !< of the group
      real(wp), intent(in) :: given(:)  !< x, y, x, y …, m, as read
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      real(wp), allocatable :: line(:,:)
      real(wp) :: low, high, rounding
      integer :: j

      load%kind = load_surface
      call take_polyline(place, 'surface', given, model%origin, line, error)
      if (allocated(error)) return
      low = minval(model%blocks%vertex(1, :))
      high = maxval(model%blocks%vertex(1, :))
      rounding = covered*model%blocks%half_size
      do j = 1, size(line, 2)
         if (line(1, j) < low - rounding .or. line(1, j) > high + rounding) call input_error( &
            error, place, 'surface: there is water at ('//words_of(line(:, j) + model%origin)// &
            '), outside the model, which reaches from x = '//to_text(low + model%origin(1))// &
            ' to '//to_text(high + model%origin(1)))
         if (j == 1) cycle
         if (line(1, j) <= line(1, j - 1)) call input_error(error, place, &
            'surface: x must increase from point to point')
      end do
      load%line = line
   end subroutine set_surface

   !> A place in words.
   pure function words_of(point) result(words)
      real(wp), intent(in) :: point(2)  !< m
      character(len=:), allocatable :: words

      words = to_text(point(1))//', '//to_text(point(2))
   end function words_of

   !> Heads or pressures at the points of a line that lies on edges, straight between them.
   subroutine set_line(load, model, place, along, head, pressure, error)
      type(edge_load_type), intent(inout) :: load  !< with the pieces it may act on
      type(model_type), intent(in) :: model  !< with its blocks
      type(place_type), intent(in) :: place  !< of the group
      real(wp), intent(in) :: along(:), head(:), pressure(:)  !< m, m, Pa; as read
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      real(wp), allocatable :: line(:,:), values(:)
      type(edge_piece_type), allocatable :: all(:), found(:)
      integer :: j, n

      load%kind = load_line
      call take_polyline(place, 'along', along, model%origin, line, error)
      if (any(is_set(head)) .eqv. any(is_set(pressure))) call input_error(error, place, &
         'along needs either head or pressure at its points')
      if (allocated(error)) return
      n = size(line, 2)
      values = pack(pressure, is_set(pressure))
      if (any(is_set(head))) values = pack(head, is_set(head))
      if (size(values) /= n) call input_error(error, place, 'head or pressure must have as '// &
         'many values as along has points ('//to_text(n)//')')
      if (allocated(error)) return
      if (any(is_set(head))) values = load%unit_weight*(values - line(2, :) - model%origin(2))
      call require_list(error, place, merge('head    ', 'pressure', any(is_set(head))), values)
      all = load%piece
      load%piece = [edge_piece_type ::]
      allocate (load%at_ends(2, 0))
      do j = 1, n - 1
         found = pieces_along(model%blocks, all, line(:, j:j + 1))
         call check_cover(model, place, line(:, j:j + 1), found, error)
         call add_pressures(load, model%blocks, line(:, j:j + 1), values(j:j + 1), found)
      end do
   end subroutine set_line

   !> Pressures at the ends of pieces on a segment.
   pure subroutine add_pressures(load, blocks, segment, values, pieces)
      type(edge_load_type), intent(inout) :: load  !< with the pieces before
      type(blocks_type), intent(in) :: blocks  !< in their first state
      real(wp), intent(in) :: segment(2, 2), values(2)  !< its ends, m; pressures there, Pa
      type(edge_piece_type), intent(in) :: pieces(:)  !< on it
      real(wp) :: more(2, size(pieces))
      integer :: k, i

      do k = 1, size(pieces)
         do i = 1, 2
            more(i, k) = values(1) + share_of(blocks, pieces(k), i, segment) &
               *(values(2) - values(1))
         end do
      end do
      load%piece = [load%piece, pieces]
      load%at_ends = reshape([load%at_ends, more], [2, size(load%piece)])
   end subroutine add_pressures

   !> Place of an end of a piece along a segment: 0 at its first point, 1 at its second.
   pure real(wp) function share_of(blocks, piece, i, segment) result(share)
      type(blocks_type), intent(in) :: blocks     !< in their first state
      type(edge_piece_type), intent(in) :: piece  !< of an edge
      integer, intent(in) :: i                    !< 1 or 2, end of the piece
      real(wp), intent(in) :: segment(2, 2)       !< its ends, m
      real(wp) :: along(2)

      along = segment(:, 2) - segment(:, 1)
      share = dot_product(along, place_of(blocks, piece%block, reference_at(blocks, piece, &
         i - 1.0_wp)) - segment(:, 1))/dot_product(along, along)
   end function share_of

   !> All of a segment must lie on edges.
   subroutine check_cover(model, place, segment, pieces, error)
      type(model_type), intent(in) :: model  !< with its blocks
      type(place_type), intent(in) :: place  !< of the group
      real(wp), intent(in) :: segment(2, 2)  !< its ends, m
      type(edge_piece_type), intent(in) :: pieces(:)  !< on it
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      real(wp) :: along(2), done, reach, share(2)
      logical :: further
      integer :: k, i

      if (allocated(error)) return
      along = segment(:, 2) - segment(:, 1)
      done = 0.0_wp
      further = .true.
      do while (further)
         further = .false.
         do k = 1, size(pieces)
            share = [(share_of(model%blocks, pieces(k), i, segment), i=1, 2)]
            reach = maxval(share)
            if (minval(share) > done + covered .or. reach <= done + covered) cycle
            done = reach
            further = .true.
         end do
      end do
      if (done < 1.0_wp - covered) call input_error(error, place, 'along: there is water at ('// &
         words_of(segment(:, 1) + done*along + model%origin)// &
         '), outside the model or where no joint or face is')
   end subroutine check_cover

end module dda_input_edge_loads
