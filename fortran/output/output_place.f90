! SPDX-License-Identifier: GPL-3.0-or-later
!> Checks before a run writes its output and accompanying files: the run may replace only files of
!> earlier runs, and no file that it reads.
module dda_output_place
   use dda_errors, only: error_type, error_file, fail
   use dda_file_system, only: same_file, status_of, is_folder, folder_of
   use dda_byte_file, only: check_plain
   use dda_journal, only: journal_suffix
   use dda_model, only: model_type
   use dda_own_file, only: own_kind_type, netcdf_file, checkpoint_file, journal_file, &
      check_replaceable
   use dda_text, only: quoted
   implicit none
   private
   public :: check_target, partial, writing, checkpoint

   !> suffixes of the name of an output: output of an unfinished run; output before it is renamed;
   !> newest checkpoint
   character(len=*), parameter :: partial = '.partial', writing = '.writing', &
      checkpoint = '.checkpoint'

contains

   !> Return an error if the output cannot be written; this check writes nothing.
   subroutine check_target(model, resumes, error)
      type(model_type), intent(in) :: model  !< model with the path of its output
      !> the run resumes from a checkpoint, whose files are checked later
      logical, intent(in) :: resumes
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      logical :: folder
      integer :: i

      associate (file => model%output%file)
         folder = is_folder(file)
         if (file == '' .or. folder) then
            call fail(error, error_file, "the output '"//file//"' is a folder, not a file name")
         else if (.not. is_folder(folder_of(file))) then
            call fail(error, error_file, file//': the folder '//folder_of(file)//' does not exist')
         else if (model%output%named_by_input .and. .not. is_below(file, model%file)) then
            call fail(error, error_file, 'the output '//quoted(file)//' that '//model%file// &
               ' names is outside the working folder and the folder of the input; if this is '// &
               'intended, give the name when the run is started: --output, or output= in Python')
         end if
         if (any([(iachar(file(i:i)) < 32, i=1, len(file))]) .and. .not. allocated(error)) &
            call fail(error, error_file, 'the name of the output contains a control character')
         call check_name(file, netcdf_file, model, error)
         call check_name(file//partial, netcdf_file, model, error)
         call check_name(file//writing, netcdf_file, model, error)
         call check_name(file//journal_suffix, journal_file, model, error)
         call check_checkpoint('', error)
         call check_checkpoint('.previous', error)
         call check_checkpoint('.coming', error)
      end associate

   contains

      !> Check the name of a checkpoint of the output.
      subroutine check_checkpoint(suffix, error)
         character(len=*), intent(in) :: suffix  !< ending of the name
         type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

         associate (name => model%output%file//checkpoint//suffix)
            if (resumes) then
               call check_plain(name, status_of(name), error)
            else
               call check_name(name, checkpoint_file, model, error)
            end if
         end associate
      end subroutine check_checkpoint
   end subroutine check_target

   !> Return an error if a path cannot be written: it exists and is not a replaceable output, or the
   !> run reads it.
   subroutine check_name(name, kind, model, error)
      character(len=*), intent(in) :: name     !< path to be written
      type(own_kind_type), intent(in) :: kind  !< kind of the file
      type(model_type), intent(in) :: model    !< model as read from the input
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer :: i

      call refuse_read_file(model%file, 'the input')
      do i = 1, size(model%motions)
         call refuse_read_file(model%motions(i)%file, 'the record of motion '// &
            trim(model%motions(i)%name))
      end do
      if (allocated(model%block_files)) then
         do i = 1, size(model%block_files)
            call refuse_read_file(model%block_files(i)%file, 'the block file '// &
               model%block_files(i)%file)
         end do
      end if
      call check_replaceable(name, kind, error)

   contains

      !> Return an error if the path to be written is a file that the run reads.
      subroutine refuse_read_file(file, role)
         character(len=*), intent(in) :: file, role  !< path of the file; its role in a message

         if (allocated(error)) return
         if (same_file(name, file)) call fail(error, error_file, 'the output '//name// &
            ' would replace '//role)
      end subroutine refuse_read_file
   end subroutine check_name

   !> .true. if an output named by an input is within the working folder or the folder of the input.
   logical function is_below(name, input)  ! total
      character(len=*), intent(in) :: name   !< path of the output in the input
      character(len=*), intent(in) :: input  !< path of the input
      integer :: last

      is_below = index('/'//name//'/', '/../') == 0
      if (.not. is_below .or. index(name, '/') /= 1) return
      is_below = .false.
      last = index(name, '/', back=.true.)
      do while (last > 0 .and. .not. is_below)
         is_below = same_file(name(:last), '.')
         if (.not. is_below) is_below = same_file(name(:last), folder_of(input))
         last = index(name(:last - 1), '/', back=.true.)
      end do
   end function is_below

end module dda_output_place
