! SPDX-License-Identifier: GPL-3.0-or-later
!> Checkpoints of a run: FILE.checkpoint and, as a second copy, FILE.checkpoint.previous.
!>
!> A checkpoint is written under a third name and then exchanged with the newest checkpoint, so that
!> a complete checkpoint exists at every moment.  The next checkpoint overwrites the old
!> file, because creation and removal of files cost more than the write.  A checkpoint
!> contains checksums of input and records, version and build, which must match on resuming.  Every
!> checkpoint outlives the process.  Flushing to the disk protects against failures of the machine;
!> flushes are rate-limited.  A flushed checkpoint remains as the previous checkpoint until a newer
!> one has been flushed.
module dda_checkpoint
   use, intrinsic :: iso_fortran_env, only: compiler_options, compiler_version
   use dda_kinds, only: long
   use dda_archive, only: archive_type, write_archive, serialise
   use dda_checked_file, only: begin_writing, end_writing, begin_reading, end_reading
   use dda_checksum, only: checksum_of
   use dda_errors, only: error_type, error_file, error_checkpoint, fail
   use dda_file_system, only: is_file, rename_file, exchange_files
   use dda_journal, only: journal_type, keep_name, flush_journal, extend_checksum, &
      serialise_mark, return_to_mark
   use dda_model, only: model_type, block_sources
   use dda_motion_curve, only: motion_curve_type
   use dda_output_place, only: checkpoint
   use dda_own_file, only: checkpoint_file, remove_own
   use dda_rate_limiter, only: rate_limiter_type, is_due, begin_task, end_task
   use dda_simulation, only: simulation_type
   use dda_start, only: start
   use dda_simulation_state, only: serialise_simulation
   use dda_text, only: quoted
   use dda_version, only: version
   implicit none
   private
   public :: checkpoints_type, begin_checkpoints, save_checkpoint, load_checkpoint, &
      has_checkpoint, remove_spare, remove_checkpoints

   !> contents of a checkpoint, as part of the version
   character(len=*), parameter :: layout = &
      ', checkpoints with springs of contacts, crossings, joint laws, bolts, impacts, '// &
      'free fields, motions of boundaries, mean velocities, kept variables of contacts first, '// &
      'maxima, broken faces, doubts as records, mean stresses, couplings of factors, '// &
      'gradients of contacts, rows by schema, water in joints and its relaxation, '// &
      'contractions and uses of factors, rows of gaps and slips'

   !> The checkpoints of an output.
   type :: checkpoints_type
      character(len=:), allocatable :: newest, previous, coming  !< file names
      logical :: newest_on_disk = .true.
      type(rate_limiter_type) :: flushing = rate_limiter_type(cost_ratio=400)
      type(archive_type) :: archive
      character(len=:), allocatable :: build  !< compiler and options
      integer(long) :: input = 0    !< checksum of the input text and block files
      integer(long) :: motions = 0  !< checksum of the motions made from the records
   end type checkpoints_type

contains

   !> Set the names of the files and the checksums of the input.
   subroutine begin_checkpoints(checkpoints, model)
      type(checkpoints_type), intent(out) :: checkpoints  !< checkpoints of the output
      type(model_type), intent(in) :: model  !< model as read from the input

      checkpoints%newest = model%output%file//checkpoint
      checkpoints%previous = checkpoints%newest//'.previous'
      checkpoints%coming = checkpoints%newest//'.coming'
      checkpoints%build = build_of_program()
      call digest_model(model, checkpoints%input, checkpoints%motions)
      call write_archive(checkpoints%archive)  ! allocates the memory of the archive
   end subroutine begin_checkpoints

   !> Compute the checksums of an input and its files.
   subroutine digest_model(model, input, motions)
      type(model_type), intent(in) :: model  !< model as read from the input
      integer(long), intent(out) :: input, motions  !< checksums of text and block files, of motions
      type(archive_type) :: archive
      type(motion_curve_type) :: curve
      character(len=:), allocatable :: text
      integer :: i

      text = model%text//block_sources(model)
      call write_archive(archive)
      call serialise(archive, text)
      input = checksum_of(archive%bytes(:archive%at))
      call write_archive(archive)
      do i = 1, size(model%motions)
         curve = model%motions(i)%curve
         call serialise(archive, curve%time_step)
         call serialise(archive, curve%displacement)
         call serialise(archive, curve%velocity)
         call serialise(archive, curve%acceleration)
         call serialise(archive, curve%higher)
         call serialise(archive, curve%velocity_after)
      end do
      motions = checksum_of(archive%bytes(:archive%at))
   end subroutine digest_model

   !> .true. if there is a checkpoint from which to resume.
   logical function has_checkpoint(checkpoints)
      type(checkpoints_type), intent(in) :: checkpoints  !< checkpoints of the output

      has_checkpoint = is_file(checkpoints%newest)
      if (.not. has_checkpoint) has_checkpoint = is_file(checkpoints%previous)
   end function has_checkpoint

   !> Remove the file into which the next checkpoint would be written.
   subroutine remove_spare(checkpoints)
      type(checkpoints_type), intent(in) :: checkpoints  !< checkpoints of the output

      call remove_own(checkpoints%coming, checkpoint_file)
   end subroutine remove_spare

   !> Remove all checkpoints of the output.
   subroutine remove_checkpoints(checkpoints)
      type(checkpoints_type), intent(in) :: checkpoints  !< checkpoints of the output

      call remove_spare(checkpoints)
      call remove_own(checkpoints%newest, checkpoint_file)
      call remove_own(checkpoints%previous, checkpoint_file)
   end subroutine remove_checkpoints

   !> Write a checkpoint; older ones remain until it is complete.
   subroutine save_checkpoint(checkpoints, simulation, journal, error)
      type(checkpoints_type), intent(inout) :: checkpoints  !< checkpoints of the output
      type(simulation_type), intent(inout) :: simulation  !< simulation, written or read
      type(journal_type), intent(inout) :: journal  !< journal of the run
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer(long) :: time
      logical :: to_disk

      call system_clock(time)
      to_disk = is_due(checkpoints%flushing, time)
      call begin_task(checkpoints%flushing)
      call keep_name(journal, error)
      call flush_journal(journal, to_disk, error)
      call extend_checksum(journal, error)
      if (.not. allocated(error)) call begin_writing(checkpoints%coming, checkpoints%archive, error)
      if (.not. allocated(error)) then
         call serialise_identity(checkpoints, error)
         call serialise_mark(checkpoints%archive, journal)
         call serialise_simulation(checkpoints%archive, simulation)
         call end_writing(checkpoints%archive, to_disk, error)
      end if
      if (allocated(error)) then
         call remove_spare(checkpoints)
      else
         call rename_written(checkpoints, to_disk, error)
      end if
      if (to_disk) call end_task(checkpoints%flushing)
   end subroutine save_checkpoint

   !> Give the new checkpoint the name of the newest.
   subroutine rename_written(checkpoints, on_disk, error)
      type(checkpoints_type), intent(inout) :: checkpoints  !< checkpoints of the output
      logical, intent(in) :: on_disk  !< the coming checkpoint is flushed to the disk
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      logical :: success

      if (checkpoints%newest_on_disk) then
         success = rename_file(checkpoints%newest, checkpoints%previous)
         success = rename_file(checkpoints%coming, checkpoints%newest)
      else
         success = exchange_files(checkpoints%coming, checkpoints%newest)
         if (.not. success) success = rename_file(checkpoints%coming, checkpoints%newest)
      end if
      checkpoints%newest_on_disk = on_disk
      if (.not. success) call fail(error, error_file, checkpoints%coming// &
         ' cannot be renamed to '//checkpoints%newest)
   end subroutine rename_written

   !> Set a started run to the state of the newest valid checkpoint.
   subroutine load_checkpoint(checkpoints, simulation, journal, model, notice, error)
      type(checkpoints_type), intent(inout) :: checkpoints  !< checkpoints of the output
      type(simulation_type), intent(inout) :: simulation  !< simulation, written or read
      type(journal_type), intent(inout) :: journal  !< journal of the run
      type(model_type), intent(in) :: model  !< model as read from the input
      !> message on the loaded file and the reason
      character(len=:), allocatable, intent(out) :: notice
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(error_type), allocatable :: reason
      logical :: unused

      call load_from(checkpoints%newest, checkpoints, simulation, journal, reason)
      if (.not. allocated(reason)) then
         notice = 'from '//checkpoints%newest
         return
      end if
      call start(simulation, model, error)
      if (.not. allocated(error)) call load_from(checkpoints%previous, checkpoints, simulation, &
         journal, error)
      if (allocated(error)) then
         if (is_file(checkpoints%previous)) reason%message = reason%message//'; '//error%message
         call fail(error, error_checkpoint, reason%message)
         return
      end if
      unused = rename_file(checkpoints%previous, checkpoints%newest)
      notice = 'from '//checkpoints%previous//', because '//reason%message
   end subroutine load_checkpoint

   !> Load a file; it is an error if the file is incomplete or not a checkpoint of this run.
   subroutine load_from(name, checkpoints, simulation, journal, error)
      character(len=*), intent(in) :: name  !< path
      type(checkpoints_type), intent(inout) :: checkpoints  !< checkpoints of the output
      type(simulation_type), intent(inout) :: simulation  !< simulation, written or read
      type(journal_type), intent(inout) :: journal  !< journal of the run
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      call begin_reading(name, checkpoints%archive, error)
      if (allocated(error)) return
      call serialise_identity(checkpoints, error)
      if (allocated(error)) then
         error%message = name//' '//error%message
      else
         call serialise_mark(checkpoints%archive, journal)
         call serialise_simulation(checkpoints%archive, simulation)
      end if
      call end_reading(checkpoints%archive, error)
      if (allocated(error)) return
      if (allocated(checkpoints%archive%failure)) then
         call fail(error, error_file, name//' cannot be read: '//checkpoints%archive%failure)
      else
         call return_to_mark(journal, error)
      end if
   end subroutine load_from

   !> Save or check version, build and input of a checkpoint.
   subroutine serialise_identity(checkpoints, error)
      type(checkpoints_type), intent(inout) :: checkpoints  !< checkpoints of the output
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      character(len=:), allocatable :: maker, build
      integer(long) :: input, motions

      maker = version//layout
      build = checkpoints%build
      input = checkpoints%input
      motions = checkpoints%motions
      call serialise(checkpoints%archive, maker)
      call serialise(checkpoints%archive, build)
      call serialise(checkpoints%archive, input)
      call serialise(checkpoints%archive, motions)
      if (maker /= version//layout) then
         call fail(error, error_file, 'was made by version '//quoted(maker)// &
            ', but this program is version '//quoted(version//layout))
      else if (build /= checkpoints%build) then
         call fail(error, error_file, 'was made by another build: '//quoted(build))
      else if (input /= checkpoints%input) then
         call fail(error, error_file, 'was made from another input or block file')
      else if (motions /= checkpoints%motions) then
         call fail(error, error_file, 'was made with other records')
      end if
   end subroutine serialise_identity

   !> Compiler and its options, without options that name folders.
   pure function build_of_program() result(build)
      character(len=:), allocatable :: build
      character(len=:), allocatable :: options
      integer :: gap
      logical :: is_folder

      build = compiler_version()
      options = compiler_options()//' '
      is_folder = .false.
      do while (len(options) > 0)
         gap = index(options, ' ')
         if (.not. is_folder .and. index(options, '-I ') /= 1 .and. index(options, '-J ') /= 1) &
            build = build//' '//options(:gap - 1)
         is_folder = index(options, '-I ') == 1 .or. index(options, '-J ') == 1
         options = options(gap + 1:)
      end do
   end function build_of_program

end module dda_checkpoint
