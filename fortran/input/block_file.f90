! SPDX-License-Identifier: GPL-3.0-or-later
!> Reader of blocks in a netCDF file, with checks of their numbers and names.
!>
!> Values are read only if their sizes are consistent with each other, with the length of the file
!> and with the free memory.  The format must be the classic format, because HDF5 crashes on some
!> damaged files.
module dda_block_file
   use, intrinsic :: iso_fortran_env, only: int8
   use dda_archive, only: archive_type, serialise, write_archive
   use dda_byte_file, only: byte_file_type, close_file, open_file, read_bytes, size_of_file, to_read
   use dda_checksum, only: checksum_of
   use dda_classic_header, only: has_known_types
   use dda_errors, only: error_type, error_input, fail
   use dda_free_memory, only: free_memory
   use dda_input_variable, only: usable
   use dda_kinds, only: wp, long
   use dda_netcdf_calls, only: dataset_type, path_of, checked
   use dda_outlines, only: most_blocks, max_vertices
   use dda_text, only: to_text, quoted
   use netcdf, only: nf90_open, nf90_close, nf90_nowrite, nf90_noerr, nf90_inq_varid, &
      nf90_inquire_variable, nf90_inquire_dimension, nf90_get_var, nf90_max_var_dims, nf90_char, &
      nf90_double, nf90_float, nf90_int, nf90_short, nf90_byte
   implicit none
   private
   public :: block_file_type, read_block_file

   integer, parameter :: name_length = 64
   integer(long), parameter :: bytes_of_number = 8         !< bytes of a number in memory
   character(len=3), parameter :: mark = 'CDF'             !< mark of the classic format
   !> bytes; a usual header has a few hundred
   integer(long), parameter :: longest_header = 2_long**20

   !> The blocks of a file.
   type :: block_file_type
      integer, allocatable :: first(:)         !< [blocks+1] first vertex of each block
      real(wp), allocatable :: vertices(:,:)   !< [2, vertices] counter-clockwise, m
      integer, allocatable :: material(:)      !< [blocks] number in `materials`, 0: none given
      integer, allocatable :: body(:)          !< [blocks] number in `bodies`, 0: none
      integer, allocatable :: edge_joint(:)    !< [vertices] number in `joints`, 0: none given
      character(len=name_length), allocatable :: names(:) !< [blocks] names; blank if there are none
      character(len=name_length), allocatable :: materials(:)  !< [materials]
      character(len=name_length), allocatable :: joints(:)     !< [joints]
      character(len=name_length), allocatable :: bodies(:)     !< [bodies]
      integer(long) :: checksum = 0            !< checksum of all these values
   end type block_file_type

   !> An open file and its length.
   type :: reader_type
      type(dataset_type) :: dataset
      integer(long) :: bytes = 0
   end type reader_type

contains

   !> Read a file; an error names the file, the variable and the block.
   subroutine read_block_file(blocks, file, error)
      type(block_file_type), intent(out) :: blocks  !< receives the values of the file
      character(len=*), intent(in) :: file  !< path
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      type(reader_type) :: reader

      reader%dataset%file = file
      call check_file_length(reader, error)
      if (allocated(error)) return
      call checked(reader%dataset, nf90_open(path_of(file), nf90_nowrite, reader%dataset%id), &
         'be read as netCDF')
      if (.not. allocated(reader%dataset%error)) then
         call read_variables(reader, blocks)
         if (nf90_close(reader%dataset%id) /= nf90_noerr) continue  ! errors are irrelevant
      end if
      if (allocated(reader%dataset%error)) then
         call fail(error, error_input, reader%dataset%error%message)
      else
         blocks%checksum = checksum_of_blocks(blocks)
      end if
   end subroutine read_block_file

   !> Check the length of the file, which must have the classic format.
   subroutine check_file_length(reader, error)
      type(reader_type), intent(inout) :: reader  !< reader; its file name is set
      !> the file is missing or has another format
      type(error_type), allocatable, intent(out) :: error
      type(byte_file_type) :: bytes
      integer(int8), allocatable :: head(:)

      call open_file(bytes, reader%dataset%file, to_read, error)
      if (allocated(error)) then
         error%kind = error_input
         return
      end if
      reader%bytes = size_of_file(bytes)
      allocate (head(max(min(reader%bytes, longest_header), int(len(mark), long))), source=0_int8)
      if (reader%bytes >= len(mark)) call read_bytes(bytes, head, error)
      call close_file(bytes, error)
      if (allocated(error)) return
      if (transfer(head(:len(mark)), mark) /= mark) then
         call fail(error, error_input, reader%dataset%file// &
            ' does not have the classic netCDF format (NETCDF3_64BIT_OFFSET)')
      else if (.not. has_known_types(head)) then
         call fail(error, error_input, reader%dataset%file//' is damaged, or does not have the '// &
            'classic netCDF format (NETCDF3_64BIT_OFFSET); its header has unknown types')
      end if
   end subroutine check_file_length

   !> Read all variables and retain the first error.
   subroutine read_variables(reader, blocks)
      type(reader_type), intent(inout) :: reader  !< open file; retains the first error
      type(block_file_type), intent(inout) :: blocks  !< receives the values
      integer, allocatable :: corners(:)
      integer :: n, vertices

      n = length_of(reader, 'corners', 1, int(most_blocks))
      vertices = length_of(reader, 'vertices', 2, max_vertices*n)
      if (allocated(reader%dataset%error)) return
      if (n == 0) call refuse_file(reader, 'the file contains no blocks')
      call read_integers(reader, 'corners', n, corners)
      call find_first_vertices(reader, corners, vertices, blocks%first)
      call read_vertices(reader, vertices, blocks%vertices)
      call read_names(reader, 'material_name', blocks%materials)
      call read_names(reader, 'joint_name', blocks%joints)
      call read_names(reader, 'body_name', blocks%bodies)
      call read_names(reader, 'name', blocks%names, n)
      call read_numbers(reader, 'material', n, blocks%materials, blocks%material)
      call read_numbers(reader, 'edge_joint', vertices, blocks%joints, blocks%edge_joint)
      call read_numbers(reader, 'body', n, blocks%bodies, blocks%body)
   end subroutine read_variables

   !> Set the reason why the file cannot be used, unless there is an earlier reason.
   subroutine refuse_file(reader, reason)
      type(reader_type), intent(inout) :: reader  !< open file; retains the first error
      character(len=*), intent(in) :: reason  !< reason

      if (.not. allocated(reader%dataset%error)) call fail(reader%dataset%error, error_input, &
         reader%dataset%file//': '//reason)
   end subroutine refuse_file

   !> .true. if the file has a variable of this name.
   logical function has_named(reader, name)
      type(reader_type), intent(in) :: reader  !< open
      character(len=*), intent(in) :: name  !< name of the variable
      integer :: id

      has_named = nf90_inq_varid(reader%dataset%id, name, id) == nf90_noerr
   end function has_named

   !> Check kind, shape and size of a variable; return its last dimension, or 0 on failure.
   integer function length_of(reader, name, rank, max_count) result(length)
      type(reader_type), intent(inout) :: reader  !< open file; retains the first error
      character(len=*), intent(in) :: name  !< name of the variable
      integer, intent(in) :: rank  !< 1: numbers; 2: pairs of numbers
      integer, intent(in) :: max_count  !< largest number of values
      integer :: shape_of(2)

      length = 0
      call find_shape(reader, name, rank, .false., shape_of)
      if (allocated(reader%dataset%error)) return
      if (rank == 2 .and. shape_of(1) /= 2) then
         call refuse_file(reader, name//' must contain x and y of each vertex, not '// &
            to_text(shape_of(1))//' numbers')
      else if (shape_of(rank) > max_count) then
         call refuse_file(reader, name//' contains '//to_text(shape_of(rank))// &
            ' values, more than '//to_text(max_count))
      else
         length = shape_of(rank)
      end if
   end function length_of

   !> Find the lengths of the dimensions of a variable, fastest first.
   subroutine find_shape(reader, name, rank, text, shape_of)
      type(reader_type), intent(inout) :: reader  !< open file; retains the first error
      character(len=*), intent(in) :: name  !< name of the variable
      integer, intent(in) :: rank  !< required number of dimensions
      logical, intent(in) :: text  !< .true.: characters required; .false.: numbers
      integer, intent(out) :: shape_of(2)  !< lengths; 1 beyond `rank`
      integer, parameter :: numeric(*) = [nf90_double, nf90_float, nf90_int, nf90_short, nf90_byte]
      integer :: id, kind, dimensions, of_dimension(nf90_max_var_dims), i

      shape_of = 1
      if (allocated(reader%dataset%error)) return
      if (.not. has_named(reader, name)) call refuse_file(reader, 'there is no variable '// &
         quoted(name))
      call checked(reader%dataset, nf90_inq_varid(reader%dataset%id, name, id), 'find '//name)
      if (allocated(reader%dataset%error)) return
      call checked(reader%dataset, nf90_inquire_variable(reader%dataset%id, id, xtype=kind, &
         ndims=dimensions, dimids=of_dimension), 'describe '//name)
      if (allocated(reader%dataset%error)) return
      if (dimensions /= rank) then
         call refuse_file(reader, name//' must have '//to_text(rank)//' dimensions, not '// &
            to_text(dimensions))
      else if (text .and. kind /= nf90_char .or. .not. (text .or. any(kind == numeric))) then
         call refuse_file(reader, name//' must contain '//trim(merge('characters', 'numbers   ', &
            text)))
      end if
      do i = 1, rank
         if (allocated(reader%dataset%error)) return
         call checked(reader%dataset, nf90_inquire_dimension(reader%dataset%id, of_dimension(i), &
            len=shape_of(i)), 'describe '//name)
      end do
      call check_bytes(reader, name, shape_of)
   end subroutine find_shape

   !> Check that the values of a variable fit into the file and into free memory.
   subroutine check_bytes(reader, name, shape_of)
      type(reader_type), intent(inout) :: reader  !< open file; retains the first error
      character(len=*), intent(in) :: name  !< name of the variable
      integer, intent(in) :: shape_of(2)  !< lengths of the dimensions
      real(wp) :: values

      if (allocated(reader%dataset%error)) return
      values = product(real(shape_of, wp))
      if (any(shape_of < 0) .or. values > reader%bytes) then
         call refuse_file(reader, name//' declares '//to_text(int(values, long))// &
            ' values, more than a file of '//to_text(reader%bytes)//' bytes can contain')
      else if (4*bytes_of_number*values > free_memory()) then
         call refuse_file(reader, name//' contains '//to_text(int(values, long))// &
            ' values, too many for the free memory')
      end if
   end subroutine check_bytes

   !> Read whole numbers.
   subroutine read_integers(reader, name, n, values)
      type(reader_type), intent(inout) :: reader  !< open file; retains the first error
      character(len=*), intent(in) :: name  !< name of the variable
      integer, intent(in) :: n  !< required number of names of values
      integer, allocatable, intent(out) :: values(:)  !< [n], 0 on failure
      integer :: id, length, kind

      allocate (values(n), source=0)
      length = length_of(reader, name, 1, huge(1))
      if (allocated(reader%dataset%error)) return
      if (length /= n) call refuse_file(reader, name//' contains '//to_text(length)// &
         ' values, not '//to_text(n))
      if (allocated(reader%dataset%error)) return
      call checked(reader%dataset, nf90_inq_varid(reader%dataset%id, name, id), 'find '//name)
      call checked(reader%dataset, nf90_inquire_variable(reader%dataset%id, id, xtype=kind), &
         'describe '//name)
      if (any(kind == [nf90_double, nf90_float])) call refuse_file(reader, name// &
         ' must contain whole numbers, of an integer type')
      if (allocated(reader%dataset%error)) return
      call checked(reader%dataset, nf90_get_var(reader%dataset%id, id, values), 'read '//name)
   end subroutine read_integers

   !> Find the first vertex of each block from the number of corners of each block.
   subroutine find_first_vertices(reader, corners, vertices, first)
      type(reader_type), intent(inout) :: reader  !< open file; retains the first error
      integer, intent(in) :: corners(:)  !< [blocks]
      integer, intent(in) :: vertices    !< number of vertices in the file
      integer, allocatable, intent(out) :: first(:)  !< [blocks+1]
      integer :: b

      allocate (first(size(corners) + 1), source=1)
      do b = 1, size(corners)
         if (corners(b) < 3 .or. corners(b) > max_vertices) call refuse_file(reader, 'block '// &
            to_text(b)//' has '//to_text(corners(b))//' corners; 3 to '//to_text(max_vertices)// &
            ' are possible')
         if (allocated(reader%dataset%error)) return
         first(b + 1) = first(b) + corners(b)
      end do
      if (first(b) - 1 /= vertices) call refuse_file(reader, 'the blocks have '// &
         to_text(first(b) - 1)//' corners, but vertices contains '//to_text(vertices))
   end subroutine find_first_vertices

   !> Read the positions of the corners, which must be finite and not too large.
   subroutine read_vertices(reader, n, vertices)
      type(reader_type), intent(inout) :: reader  !< open file; retains the first error
      integer, intent(in) :: n  !< number of vertices
      real(wp), allocatable, intent(out) :: vertices(:,:)  !< [2, n] m
      integer :: id, v

      if (allocated(reader%dataset%error)) return
      allocate (vertices(2, n))
      call checked(reader%dataset, nf90_inq_varid(reader%dataset%id, 'vertices', id), &
         'find vertices')
      call checked(reader%dataset, nf90_get_var(reader%dataset%id, id, vertices), 'read vertices')
      do v = 1, n
         if (allocated(reader%dataset%error)) return
         if (.not. all(abs(vertices(:, v)) <= usable)) call refuse_file(reader, 'vertex '// &
            to_text(v)//' is at ('//to_text(vertices(:, v))//'): coordinates must be finite '// &
            'and not too large')
      end do
   end subroutine read_vertices

   !> Read names; blank if the file has no such variable.
   subroutine read_names(reader, name, names, n)
      type(reader_type), intent(inout) :: reader  !< open file; retains the first error
      character(len=*), intent(in) :: name  !< name of the variable
      character(len=name_length), allocatable, intent(out) :: names(:)  !< blank-padded
      integer, intent(in), optional :: n  !< required number of names
      character(len=:), allocatable :: text(:)
      integer :: id, i, last, shape_of(2)

      if (present(n)) allocate (names(n), source=repeat(' ', name_length))
      if (.not. present(n)) allocate (names(0))
      if (allocated(reader%dataset%error)) return
      if (.not. has_named(reader, name)) return
      call find_shape(reader, name, 2, .true., shape_of)
      if (present(n)) then
         if (shape_of(2) /= n) call refuse_file(reader, name//' contains '//to_text(shape_of(2))// &
            ' names, not '//to_text(n))
      end if
      if (shape_of(1) > name_length) call refuse_file(reader, name//' has names of '// &
         to_text(shape_of(1))//' bytes; at most '//to_text(name_length)//' are possible')
      if (shape_of(2) > most_blocks) call refuse_file(reader, name//' contains too many names')
      if (allocated(reader%dataset%error)) return
      call checked(reader%dataset, nf90_inq_varid(reader%dataset%id, name, id), 'find '//name)
      allocate (character(len=shape_of(1)) :: text(shape_of(2)))
      if (size(text) > 0 .and. shape_of(1) > 0) call checked(reader%dataset, &
         nf90_get_var(reader%dataset%id, id, text, count=shape_of), 'read '//name)
      names = text
      do i = 1, size(names)
         last = scan(names(i)//achar(0), achar(0)) - 1
         names(i) = names(i)(:last)
      end do
   end subroutine read_names

   !> Read positions in a list of names; 0 (none) if the file has no such variable.
   subroutine read_numbers(reader, name, n, names, numbers)
      type(reader_type), intent(inout) :: reader  !< open file; retains the first error
      character(len=*), intent(in) :: name  !< name of the variable
      integer, intent(in) :: n  !< required number of names of values
      character(len=*), intent(in) :: names(:)  !< list of names, numbered from 1
      integer, allocatable, intent(out) :: numbers(:)  !< [n]
      integer :: i

      if (.not. has_named(reader, name)) then
         allocate (numbers(n), source=0)
         return
      end if
      call read_integers(reader, name, n, numbers)
      i = findloc(numbers < 0 .or. numbers > size(names), .true., 1)
      if (i > 0) call refuse_file(reader, name//'('//to_text(i)//') = '//to_text(numbers(i))// &
         ' is not one of the '//to_text(size(names))//' names in '//name(index(name, '_') + 1:)// &
         '_name; 0 means none')
   end subroutine read_numbers

   !> Checksum of all values that a run reads from the file.
   integer(long) function checksum_of_blocks(blocks) result(checksum)
      type(block_file_type), intent(inout) :: blocks  !< blocks of the file, unchanged
      type(archive_type) :: archive
      character(len=:), allocatable :: text
      integer :: i

      call write_archive(archive)
      call serialise(archive, blocks%first)
      call serialise(archive, blocks%vertices)
      call serialise(archive, blocks%material)
      call serialise(archive, blocks%edge_joint)
      text = ''
      do i = 1, size(blocks%materials)
         text = text//trim(blocks%materials(i))//new_line('a')
      end do
      do i = 1, size(blocks%joints)
         text = text//trim(blocks%joints(i))//new_line('a')
      end do
      if (size(blocks%bodies) > 0) call serialise(archive, blocks%body)
      do i = 1, size(blocks%bodies)
         text = text//trim(blocks%bodies(i))//new_line('a')
      end do
      call serialise(archive, text)
      do i = 1, size(blocks%names)
         text = trim(blocks%names(i))
         call serialise(archive, text)
      end do
      checksum = checksum_of(archive%bytes(:archive%at))
   end function checksum_of_blocks

end module dda_block_file
