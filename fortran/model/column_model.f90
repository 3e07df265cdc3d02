! SPDX-License-Identifier: GPL-3.0-or-later
!> The model of the column of a free field: blocks of a model with what holds and moves them from
!> below, tied to themselves.
!>
!> Settings, materials, joints, motions and stages are those of the model.  Loads, bolts and
!> measured points stay with the model; the column measures its own upper end.
module dda_column_model
   use dda_blocks, only: blocks_type, set_blocks, set_damping
   use dda_boundary, only: boundary_type
   use dda_free_field, only: free_field_type
   use dda_model, only: model_type
   use dda_stage, only: stage_type
   use dda_stop_settings, only: stop_settings_type
   implicit none
   private
   public :: column_model, column_blocks

contains

   !> The column of a free field as a model of its own.
   type(model_type) function column_model(model, field) result(column)
      type(model_type), intent(in) :: model        !< complete
      type(free_field_type), intent(in) :: field   !< one of its free fields
      logical :: kept(size(model%fixed_points))
      integer :: number(model%blocks%n), i

      number = 0
      number(field%block) = [(i, i=1, size(field%block))]
      column%title = 'free field, '//trim(field%side)
      column%file = model%file
      column%origin = model%origin
      column%control = model%control
      column%control%displaced_block = 0
      column%contact = model%contact
      column%stop = stop_settings_type()
      column%materials = model%materials
      column%joints = model%joints
      column%motions = model%motions
      column%block_names = model%block_names(field%block)
      allocate (column%body_names(0))
      column%blocks = column_blocks(model, field%block)
      kept = number(model%fixed_points%block) > 0
      column%fixed_points = pack(model%fixed_points, kept)
      column%fixed_points%block = number(column%fixed_points%block)
      call take_boundaries(column, model%boundaries, number)
      column%ties = field%tie
      allocate (column%welds(0), column%free_fields(0), column%loads(0), column%edge_loads(0), &
         column%bolts(0), column%amplifications(0), column%boundary_edges(0), &
         column%boundary_motions(0))
      column%points = [field%top]
      column%points%block = number(field%top%block)
      column%stages = [(column_stage(model%stages(i), field%block, kept), &
         i=1, size(model%stages))]
   end function column_model

   !> Copies of some blocks of a model, at the start.
   type(blocks_type) function column_blocks(model, list) result(blocks)
      type(model_type), intent(in) :: model  !< with its blocks and materials
      integer, intent(in) :: list(:)         !< [any] numbers of blocks, ascending
      integer, allocatable :: vertex(:)
      logical :: wanted(model%blocks%n)
      integer :: first(size(list) + 1), i, v

      wanted = .false.
      wanted(list) = .true.
      vertex = pack([(v, v=1, size(model%blocks%owner))], wanted(model%blocks%owner))
      first(1) = 1
      do i = 1, size(list)
         first(i + 1) = first(i) + model%blocks%first(list(i) + 1) - model%blocks%first(list(i))
      end do
      call set_blocks(blocks, first, model%blocks%vertex(:, vertex), model%blocks%material(list), &
         model%blocks%joint(vertex), model%materials, model%control%plane_strain)
      blocks%initial_stress = model%blocks%initial_stress(:, list)
      call set_damping(blocks, model%blocks%damping)
      blocks%half_size = model%blocks%half_size  ! distances of the search are the model's
   end function column_blocks

   !> What absorbs waves below the column.
   pure subroutine take_boundaries(column, boundaries, number)
      type(model_type), intent(inout) :: column            !< receives them
      type(boundary_type), intent(in) :: boundaries(:)     !< of the model
      integer, intent(in) :: number(:)                     !< [blocks] in the column, or 0
      type(boundary_type) :: own
      logical, allocatable :: kept(:)
      integer :: i, k

      allocate (column%boundaries(0))
      do i = 1, size(boundaries)
         own = boundaries(i)
         kept = number(own%piece%block) > 0
         if (.not. any(kept)) cycle
         own%point = pack(own%point, [(kept((k + 1)/2), k=1, 2*size(kept))])
         own%point%block = number(own%point%block)
         own%normal = own%normal(:, pack([(k, k=1, size(kept))], kept))
         own%dashpot = own%dashpot(:, pack([(k, k=1, size(kept))], kept))
         own%piece = pack(own%piece, kept)
         column%boundaries = [column%boundaries, own]
      end do
   end subroutine take_boundaries

   !> A stage without what the column has not.
   pure type(stage_type) function column_stage(stage, block, kept) result(own)
      type(stage_type), intent(in) :: stage  !< of the model
      integer, intent(in) :: block(:)        !< [any] of the column
      logical, intent(in) :: kept(:)         !< [fixed points] that the column has

      own = stage
      own%removed = stage%removed(block)
      own%released = pack(stage%released, kept)
      own%holds = pack(stage%holds, kept)
      own%added = [logical ::]
      own%dropped = [logical ::]
      own%loads = [logical ::]
   end function column_stage

end module dda_column_model
