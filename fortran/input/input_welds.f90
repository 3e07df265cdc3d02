! SPDX-License-Identifier: GPL-3.0-or-later
!> Bodies of an input: their cells are welded, and what bodies cannot have yet is refused.
module dda_input_welds
   use dda_blocks, only: blocks_type, is_convex
   use dda_cell_faces, only: find_faces
   use dda_errors, only: error_type, error_input, fail
   use dda_growth, only: grow
   use dda_input_group, only: group_type, input_error
   use dda_model, only: model_type
   use dda_outlines, only: outlines_type
   use dda_text, only: quoted, to_text
   use dda_weld, only: set_welds, weld_type
   implicit none
   private
   public :: weld_cells, check_bodies, block_title

contains

   !> Cells of bodies are welded at their common faces.
   subroutine weld_cells(model, groups, outlines, error)
      type(model_type), intent(inout) :: model     !< with its blocks
      type(group_type), intent(in) :: groups(:)    !< of the input, in its order
      type(outlines_type), intent(in) :: outlines  !< of all blocks
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      integer :: b, other

      if (allocated(error)) return
      associate (blocks => model%blocks)
         call number_bodies(outlines%body(:blocks%n), blocks%body, model%body_names)
         do b = 1, blocks%n
            if (allocated(error)) return
            if (blocks%body(b) == 0) cycle
            if (.not. all_convex(blocks, b)) call input_error(error, groups(outlines%source(b)), &
               block_title(b, model%block_names(b))//' is a cell of a body '// &
               'and has an angle of 180° or more: divide it into convex cells')
         end do
         call find_faces(blocks, model%welds)
         call set_welds(blocks, model%welds)
         call find_loose(blocks, model%welds, b, other)
         if (b > 0) call input_error(error, groups(outlines%source(b)), 'body '// &
            quoted(trim(outlines%body(b)))//' is not in one piece: no faces weld block '// &
            to_text(b)//' to block '//to_text(other)//'; give each piece a name of its own')
      end associate
   end subroutine weld_cells

   !> Bodies get numbers in the order of their first cells.
   pure subroutine number_bodies(name, number, names)
      character(len=*), intent(in) :: name(:)  !< [blocks] of the body of each, or blank
      integer, intent(out) :: number(:)        !< [blocks] of the body of each; 0: none
      character(len=len(name)), allocatable, intent(out) :: names(:)  !< [bodies]
      character(len=len(name)), allocatable :: more(:)
      integer :: b, n, last

      allocate (more(8))
      n = 0
      last = 0
      do b = 1, size(name)
         number(b) = 0
         if (name(b) == '') cycle
         if (last > 0) then
            if (more(last) /= name(b)) last = 0  ! cells mostly follow each other
         end if
         if (last == 0) last = findloc(more(:n), name(b), 1)
         if (last == 0) then
            n = n + 1
            call grow(more, n)
            more(n) = name(b)
            last = n
         end if
         number(b) = last
      end do
      names = more(:n)
   end subroutine number_bodies

   !> All angles of block b are below 180°.
   pure logical function all_convex(blocks, b) result(convex)
      type(blocks_type), intent(in) :: blocks  !< at the start
      integer, intent(in) :: b                 !< block
      integer :: v

      do v = blocks%first(b), blocks%first(b + 1) - 1
         convex = is_convex(blocks, v)
         if (.not. convex) return
      end do
   end function all_convex

   !> A cell that no faces join with the first cell of its body; 0 if there is none.
   pure subroutine find_loose(blocks, welds, loose, first_cell)
      type(blocks_type), intent(in) :: blocks    !< with bodies
      type(weld_type), intent(in) :: welds(:)    !< of all bodies
      integer, intent(out) :: loose, first_cell  !< blocks
      integer :: part(blocks%n), first(maxval(blocks%body)), i, one, other

      part = [(i, i=1, blocks%n)]
      do i = 1, size(welds)
         one = root_of(welds(i)%block(1))
         other = root_of(welds(i)%block(2))
         part(max(one, other)) = min(one, other)
      end do
      first = 0
      do loose = 1, blocks%n
         if (blocks%body(loose) == 0) cycle
         if (first(blocks%body(loose)) == 0) first(blocks%body(loose)) = loose
         first_cell = first(blocks%body(loose))
         if (root_of(loose) /= root_of(first_cell)) return
      end do
      loose = 0

   contains

      !> First cell of the piece that a cell is part of.
      pure integer function root_of(cell) result(root)
         integer, intent(in) :: cell  !< number of a block

         root = cell
         do while (part(root) /= root)
            root = part(root)
         end do
      end function root_of
   end subroutine find_loose

   !> What bodies cannot have yet: free fields at their sides.
   subroutine check_bodies(model, error)
      type(model_type), intent(in) :: model  !< complete
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      integer :: i

      if (allocated(error)) return
      associate (blocks => model%blocks)
         do i = 1, size(model%free_fields)
            associate (block => model%free_fields(i)%block)
               if (any(blocks%body(block) > 0)) call fail(error, error_input, model%file// &
                  ': the free field at the '//trim(model%free_fields(i)%side)//' side has '// &
                  'blocks of a body, which its column cannot have yet: leave body out there')
            end associate
            if (allocated(error)) return
         end do
      end associate
   end subroutine check_bodies

   !> A block in a message: number and name.
   pure function block_title(b, name) result(title)
      integer, intent(in) :: b  !< number of the block
      character(len=*), intent(in) :: name  !< of the block, or blank
      character(len=:), allocatable :: title

      title = trim('block '//to_text(b)//' '//name)
   end function block_title

end module dda_input_welds
