! SPDX-License-Identifier: GPL-3.0-or-later
!> What a model has that is seldom meant: it may be run, but not without a word.
module dda_model_notes
   use dda_kinds, only: wp
   use dda_model, only: model_type, is_held
   use dda_text, only: quoted, to_text
   implicit none
   private
   public :: model_notes

   !> kg/m³: lighter than any material of blocks, geofoam included; a number in g/cm³ is below
   real(wp), parameter :: least_density = 10.0_wp
   integer, parameter :: note_length = 160

contains

   !> Notes on a model, a line each.
   pure function model_notes(model) result(notes)
      type(model_type), intent(in) :: model  !< as read from the input
      character(len=note_length), allocatable :: notes(:)

      notes = [density_notes(model), support_notes(model), motion_notes(model)]
   end function model_notes

   !> Densities that may be meant in g/cm³.
   pure function density_notes(model) result(notes)
      type(model_type), intent(in) :: model  !< as read from the input
      character(len=note_length), allocatable :: notes(:)
      integer :: i

      allocate (notes(0))
      do i = 1, size(model%materials)
         associate (material => model%materials(i))
            if (material%density < least_density) notes = [character(len=note_length) :: notes, &
               'density = '//to_text(material%density)//' kg/m³ of &material '// &
               quoted(material%name)//': is it meant in g/cm³? Water has 1000 kg/m³']
         end associate
      end do
   end function density_notes

   !> Blocks that nothing holds, though something accelerates them.
   pure function support_notes(model) result(notes)
      type(model_type), intent(in) :: model  !< as read from the input
      character(len=note_length), allocatable :: notes(:)

      allocate (notes(0))
      if (is_held(model) .or. norm2(model%control%gravity) <= 0.0_wp) return
      notes = [character(len=note_length) :: 'all blocks fall: there is no &fixed_point and no '// &
         '&boundary that holds one']
   end function support_notes

   !> Motions that nothing follows.
   pure function motion_notes(model) result(notes)
      type(model_type), intent(in) :: model  !< as read from the input
      character(len=note_length), allocatable :: notes(:)
      logical :: used(0:size(model%motions))
      integer :: i

      used = .false.
      used(model%control%base_motion) = .true.
      do i = 1, size(model%fixed_points)
         used(model%fixed_points(i)%motion) = .true.
      end do
      do i = 1, size(model%boundaries)
         used(model%boundaries(i)%motion) = .true.
      end do
      allocate (notes(0))
      do i = 1, size(model%motions)
         if (.not. used(i)) notes = [character(len=note_length) :: notes, '&motion '// &
            quoted(model%motions(i)%name)//' moves nothing: no motion_x, motion_y, '// &
            'base_motion_x or base_motion_y names it']
      end do
   end function motion_notes

end module dda_model_notes
