! SPDX-License-Identifier: GPL-3.0-or-later
!> Bodies of an input: cells are welded, and unsupported combinations are rejected.
module dda_input_welds
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type, is_convex
   use dda_cell_faces, only: find_faces, find_gap
   use dda_errors, only: error_type, error_input, fail
   use dda_growth, only: grow
   use dda_input_group, only: group_type, fail_input, positions, require_name
   use dda_model, only: model_type
   use dda_outlines, only: outlines_type
   use dda_partition, only: join, name_parts
   use dda_text, only: quoted, to_text
   use dda_weld, only: set_welds, weld_type
   implicit none
   private
   public :: weld_cells, check_bodies, block_title

contains

   !> Weld cells of bodies at their common faces.
   subroutine weld_cells(model, groups, outlines, error)
      type(model_type), intent(inout) :: model     !< model with its blocks
      type(group_type), intent(in) :: groups(:)    !< groups of the input, in its order
      type(outlines_type), intent(in) :: outlines  !< outlines of all blocks
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer :: b, detached, v

      if (allocated(error)) return
      associate (blocks => model%blocks)
         call number_bodies(outlines%body(:blocks%n), blocks%body, model%body_names)
         do b = 1, blocks%n
            if (allocated(error)) return
            if (blocks%body(b) == 0) cycle
            if (.not. all([(is_convex(blocks, v), v=blocks%first(b), blocks%first(b + 1) - 1)])) &
               call fail_input(error, groups(outlines%source(b)), &
               block_title(b, model%block_names(b))//' is a cell of a body '// &
               'and has an angle of 180° or more; divide it into convex cells')
         end do
         call find_faces(blocks, model%welds)
         call set_welds(blocks, model%welds)
         call find_detached_cell(blocks, model%welds, b, detached)
         if (b > 0) call fail_input(error, groups(outlines%source(b)), 'body '// &
            quoted(trim(outlines%body(b)))//' is not connected, because no faces weld block '// &
            to_text(b)//' to block '//to_text(detached)//'; give each part its own name')
         call set_fracture(model, groups, error)
         if (allocated(error)) return
         call find_gap(blocks, b, detached)
         if (b > 0) call fail_input(error, groups(outlines%source(b)), 'body '// &
            quoted(trim(outlines%body(b)))//': edges of block '//to_text(b)//' and block '// &
            to_text(detached)//' are closer than a tenth of a cell but do not coincide: '// &
            'the vertices of a shared face must be equal in both cells')
      end associate
   end subroutine weld_cells

   !> Set the joints that replace faces when they break.  A face has the joint given for its two
   !> materials.  If none is given, it has the weaker joint, in tension, of both materials.  Faces
   !> without a joint never break.
   subroutine set_fracture(model, groups, error)
      type(model_type), intent(inout) :: model   !< model with its welds
      type(group_type), intent(in) :: groups(:)  !< groups of the input, in its order
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer :: joint(size(model%materials)), group_numbers(size(model%materials)), i, m

      joint = 0
      group_numbers = positions(groups, 'material')
      do m = 1, size(joint)
         if (model%materials(m)%fracture == '') cycle
         call require_name(error, groups(group_numbers(m)), 'fracture', &
            model%materials(m)%fracture, model%joints%name, 'joint', joint(m))
         if (allocated(error)) return
         associate (joint_after_break => model%joints(joint(m)))
            if (joint_after_break%law /= 'cohesive' .or. &
               .not. joint_after_break%normal_stiffness > 0.0_wp) &
               call fail_input(error, groups(group_numbers(m)), 'fracture = '//quoted(trim( &
               joint_after_break%name))//" must be a joint of law 'cohesive' with a "// &
               'normal_stiffness_per_area')
         end associate
      end do
      do i = 1, size(model%welds)
         associate (both => joint(model%blocks%material(model%welds(i)%block)))
            if (any(both == 0)) cycle
            model%welds(i)%joint = both(minloc(model%joints(both)%tensile_strength, 1))
         end associate
      end do
      call set_interfaces(model, groups, error)
   end subroutine set_fracture

   !> Set the joint that replaces faces between two materials, if a joint is given for them.
   subroutine set_interfaces(model, groups, error)
      type(model_type), intent(inout) :: model   !< model with its welds
      type(group_type), intent(in) :: groups(:)  !< groups of the input, in its order
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer :: group_numbers(size(model%joints)), pair(2), i, j, k

      group_numbers = positions(groups, 'joint')
      do j = 1, size(group_numbers)
         associate (joint => model%joints(j), group => groups(group_numbers(j)))
            if (size(joint%between) == 0) cycle
            if (size(joint%between) /= 2) call fail_input(error, group, &
               '`between` needs two materials')
            do k = 1, min(2, size(joint%between))
               if (.not. allocated(error)) call require_name(error, group, 'between', &
                  joint%between(k), model%materials%name, 'material', pair(k))
            end do
            if (allocated(error)) return
         end associate
         do i = 1, size(model%welds)
            associate (found => model%blocks%material(model%welds(i)%block))
               if (all(found == pair) .or. all(found == pair(2:1:-1))) model%welds(i)%joint = j
            end associate
         end do
      end do
   end subroutine set_interfaces

   !> Number the bodies in the order of their first cells.
   pure subroutine number_bodies(name, number, names)
      character(len=*), intent(in) :: name(:)  !< [blocks] body of each block, or blank
      integer, intent(out) :: number(:)        !< [blocks] body of each block; 0: none
      character(len=len(name)), allocatable, intent(out) :: names(:)  !< [bodies]
      character(len=len(name)), allocatable :: longer(:)
      integer :: b, n, last

      allocate (longer(8))
      n = 0
      last = 0
      do b = 1, size(name)
         number(b) = 0
         if (name(b) == '') cycle
         if (last > 0) then
            if (longer(last) /= name(b)) last = 0  ! usually the last body
         end if
         if (last == 0) last = findloc(longer(:n), name(b), 1)
         if (last == 0) then
            n = n + 1
            call grow(longer, n)
            longer(n) = name(b)
            last = n
         end if
         number(b) = last
      end do
      names = longer(:n)
   end subroutine number_bodies

   !> Find a cell without a connection by faces to the first cell of its body; 0 if none.
   pure subroutine find_detached_cell(blocks, welds, detached_cell, first_cell)
      type(blocks_type), intent(in) :: blocks    !< blocks with their bodies
      type(weld_type), intent(in) :: welds(:)    !< welds of all bodies
      !> detached cell, 0: none; first cell of its body
      integer, intent(out) :: detached_cell, first_cell
      integer :: part(blocks%n), first(maxval(blocks%body)), i

      part = [(i, i=1, blocks%n)]
      do i = 1, size(welds)
         call join(part, welds(i)%block(1), welds(i)%block(2))
      end do
      call name_parts(part)
      first = 0
      do detached_cell = 1, blocks%n
         if (blocks%body(detached_cell) == 0) cycle
         if (first(blocks%body(detached_cell)) == 0) first(blocks%body(detached_cell)) &
            = detached_cell
         first_cell = first(blocks%body(detached_cell))
         if (part(detached_cell) /= part(first_cell)) return
      end do
      detached_cell = 0
   end subroutine find_detached_cell

   !> Check that stages remove only whole bodies.
   !> Otherwise remaining cells would have open faces without contacts.
   subroutine check_bodies(model, error)
      type(model_type), intent(in) :: model  !< model with its stages
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer :: s, i

      if (allocated(error)) return
      do s = 1, size(model%stages)
         do i = 1, size(model%welds)
            associate (removed => model%stages(s)%removed(model%welds(i)%block))
               if (removed(1) .eqv. removed(2)) cycle
               call fail(error, error_input, model%file//': stage '// &
                  quoted(trim(model%stages(s)%name))//' removes part of body '// &
                  quoted(trim(model%body_names(model%blocks%body(model%welds(i)%block(1)))))// &
                  ': remove the whole body, by its name, or make the removed part a separate body')
               return
            end associate
         end do
      end do
   end subroutine check_bodies

   !> Text of a block in a message: number and name.
   pure function block_title(b, name) result(title)
      integer, intent(in) :: b  !< number of the block
      character(len=*), intent(in) :: name  !< name of the block, or blank
      character(len=:), allocatable :: title

      title = trim('block '//to_text(b)//' '//name)
   end function block_title

end module dda_input_welds
