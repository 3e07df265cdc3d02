! SPDX-License-Identifier: GPL-3.0-or-later
!> Model of a free-field column: blocks of a model with the supports and motions below them; the
!> left and right sides of the column are tied to each other.
!>
!> Settings, materials, joints, motions and stages of the model are copied, but not loads, bolts and
!> measured points; the motion of the column is measured at its upper end.
module dda_column_model
   use dda_blocks, only: blocks_type, set_blocks, set_damping
   use dda_boundary, only: boundary_type
   use dda_free_field, only: free_field_type
   use dda_model, only: model_type
   use dda_stage, only: stage_type
   use dda_settings, only: stop_settings_type
   use dda_weld, only: set_welds, assign_triangles, weld_type, welds_within
   implicit none
   private
   public :: column_model, copy_blocks

contains

   !> Create the model of the column of a free field.
   type(model_type) function column_model(model, field) result(column)
      type(model_type), intent(in) :: model        !< complete model
      type(free_field_type), intent(in) :: field   !< free field of the model
      logical :: has_point(size(model%fixed_points))
      integer :: number(model%blocks%n), i

      number = 0
      number(field%block) = [(i, i=1, size(field%block))]
      column%title = 'free field, '//trim(field%side)
      column%file = model%file
      column%origin = model%origin
      column%control = model%control
      column%control%displaced = 0
      column%contact = model%contact
      column%stop = stop_settings_type()
      column%materials = model%materials
      column%joints = model%joints
      column%motions = model%motions
      column%block_names = model%block_names(field%block)
      column%body_names = model%body_names
      call copy_blocks(model, field%block, column%blocks, column%welds)
      call assign_triangles(column%blocks, field%weld)
      column%welds = [column%welds, field%weld]
      has_point = number(model%fixed_points%block) > 0
      column%fixed_points = pack(model%fixed_points, has_point)
      column%fixed_points%block = number(column%fixed_points%block)
      call add_dashpots(column, model%boundaries, number)
      column%ties = field%tie
      if (allocated(model%stress_gradient)) column%stress_gradient = &
         model%stress_gradient(:, field%block)
      allocate (column%free_fields(0), column%loads(0), column%edge_loads(0), column%bolts(0), &
         column%measured_joints(0), column%amplifications(0), column%boundary_edges(0), &
         column%boundary_motions(0))
      column%points = [field%top]
      column%points%block = number(field%top%block)
      column%stages = [(column_stage(model%stages(i), field%block, has_point), &
         i=1, size(model%stages))]
   end function column_model

   !> Copy some blocks of a model, in their initial state, and their welds.
   subroutine copy_blocks(model, list, blocks, welds)
      type(model_type), intent(in) :: model  !< model with its blocks and materials
      integer, intent(in) :: list(:)         !< [any] numbers of blocks, ascending
      type(blocks_type), intent(out) :: blocks  !< blocks in their initial state
      type(weld_type), allocatable, intent(out) :: welds(:)  !< welds between them
      integer, allocatable :: vertex(:)
      integer :: number(model%blocks%n), of_vertex(size(model%blocks%owner))
      integer :: first(size(list) + 1), i, v

      number = 0
      number(list) = [(i, i=1, size(list))]
      vertex = pack([(v, v=1, size(of_vertex))], number(model%blocks%owner) > 0)
      of_vertex = 0
      of_vertex(vertex) = [(v, v=1, size(vertex))]
      first(1) = 1
      do i = 1, size(list)
         first(i + 1) = first(i) + model%blocks%first(list(i) + 1) - model%blocks%first(list(i))
      end do
      call set_blocks(blocks, first, model%blocks%vertex(:, vertex), model%blocks%material(list), &
         model%blocks%joint(vertex), model%materials, model%control%plane_strain)
      blocks%initial_stress = model%blocks%initial_stress(:, list)
      call set_damping(blocks, model%blocks%damping)
      blocks%half_size = model%blocks%half_size  ! same search distances as in the model
      blocks%body = model%blocks%body(list)
      welds = welds_within(model%welds, number, of_vertex)
      call set_welds(blocks, welds)
      call copy_joined_pairs(blocks, model%blocks, number)
   end subroutine copy_blocks

   !> Copy the pairs of cells of the column that have no contacts.
   pure subroutine copy_joined_pairs(blocks, original, number)
      type(blocks_type), intent(inout) :: blocks  !< blocks of the column
      type(blocks_type), intent(in) :: original     !< blocks of the model
      integer, intent(in) :: number(:)  !< [blocks of the model] number in the column, or 0
      integer :: b, i

      if (size(original%joined) == 0) return
      deallocate (blocks%joined)
      allocate (blocks%joined(0), blocks%joined_first(blocks%n + 1))
      blocks%joined_first(1) = 1
      do b = 1, original%n
         if (number(b) == 0) cycle
         associate (list => number([(original%joined(i), &
            i=original%joined_first(b), original%joined_first(b + 1) - 1)]))
            blocks%joined = [blocks%joined, pack(list, list > 0)]
         end associate
         blocks%joined_first(number(b) + 1) = size(blocks%joined) + 1
      end do
   end subroutine copy_joined_pairs

   !> Add dashpots below the column.
   pure subroutine add_dashpots(column, boundaries, number)
      type(model_type), intent(inout) :: column            !< column; receives the dashpots
      type(boundary_type), intent(in) :: boundaries(:)     !< boundaries of the model
      integer, intent(in) :: number(:)                     !< [blocks] number in the column, or 0
      type(boundary_type) :: copy
      logical, allocatable :: has_point(:)
      integer :: i, k

      allocate (column%boundaries(0))
      do i = 1, size(boundaries)
         copy = boundaries(i)
         has_point = number(copy%part%block) > 0
         if (.not. any(has_point)) cycle
         copy%point = pack(copy%point, [(has_point((k + 1)/2), k=1, 2*size(has_point))])
         copy%point%block = number(copy%point%block)
         copy%normal = copy%normal(:, pack([(k, k=1, size(has_point))], has_point))
         copy%dashpot = copy%dashpot(:, pack([(k, k=1, size(has_point))], has_point))
         copy%part = pack(copy%part, has_point)
         column%boundaries = [column%boundaries, copy]
      end do
   end subroutine add_dashpots

   !> Copy a stage; objects outside the column are omitted.
   pure type(stage_type) function column_stage(stage, block, has_point) result(own)
      type(stage_type), intent(in) :: stage  !< stage of the model
      integer, intent(in) :: block(:)        !< [any] block of the column
      logical, intent(in) :: has_point(:)    !< [fixed points] .true. if the column has the point

      own = stage
      own%removed = stage%removed(block)
      own%released = pack(stage%released, has_point)
      own%holds = pack(stage%holds, has_point)
      own%added = [logical ::]
      own%dropped = [logical ::]
      own%loads = [logical ::]
   end function column_stage

end module dda_column_model
