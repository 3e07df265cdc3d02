! SPDX-License-Identifier: GPL-3.0-or-later
!> Calls of netCDF; a bad status is converted to an error that names the file and the action.
module dda_netcdf_calls
   use, intrinsic :: iso_c_binding, only: c_null_char
   use dda_kinds, only: wp
   use dda_errors, only: error_type, error_file, fail
   use dda_text, only: to_text, valid_text
   use netcdf, only: nf90_noerr, nf90_strerror, nf90_def_var, nf90_put_att, nf90_def_dim, &
      nf90_inq_dimid, nf90_inq_varid, nf90_inquire_attribute, nf90_get_att, nf90_put_var, &
      nf90_global
   implicit none
   private
   public :: dataset_type, path_of, checked, define_dimension, define_variable, &
      describe_variable, describe_flags, describe, describe_number, text_of, put, &
      name_length, put_names

   integer, parameter :: name_length = 64     !< length of names in a file
   integer, parameter :: names_at_once = 256  !< number of names per write

   !> An open file; after a failed call, later calls do nothing.
   type :: dataset_type
      character(len=:), allocatable :: file
      integer :: id = -1
      type(error_type), allocatable :: error
   end type dataset_type

   ! The netcdf module has no call for an array of any shape passed as a contiguous sequence.
   interface
      integer function nf_put_vara_double(id, variable, start, count, values)
         import :: wp
         integer, intent(in) :: id, variable, start(*), count(*)  !< arguments of the netCDF library
         real(wp), intent(in) :: values(*)  !< values in the order of the file
      end function nf_put_vara_double
   end interface

contains

   !> Convert a name to a path for netCDF, which strips leading blanks and control characters.
   !> netCDF also treats a name with a colon as an address.
   pure function path_of(name) result(path)
      character(len=*), intent(in) :: name  !< path of a file
      character(len=:), allocatable :: path

      path = name
      if (index(name, '/') /= 1) path = './'//name
   end function path_of

   !> Record the error of a call; an earlier error is retained.
   subroutine checked(dataset, status, action)
      type(dataset_type), intent(inout) :: dataset  !< open; retains the first error
      integer, intent(in) :: status  !< status of a netCDF call
      character(len=*), intent(in) :: action  !< action for the message: "cannot …"

      if (status == nf90_noerr .or. allocated(dataset%error)) return
      call fail(dataset%error, error_file, dataset%file//': cannot '//action//': '// &
         trim(nf90_strerror(status)))
   end subroutine checked

   !> Define a dimension.
   subroutine define_dimension(dataset, name, length)
      type(dataset_type), intent(inout) :: dataset  !< open; retains the first error
      character(len=*), intent(in) :: name  !< name in the file
      integer, intent(in) :: length  !< length of the dimension
      integer :: unused

      if (.not. allocated(dataset%error)) call checked(dataset, nf90_def_dim(dataset%id, name, &
         length, unused), 'define dimension '//name)
   end subroutine define_dimension

   !> Define a variable with defined dimensions.
   subroutine define_variable(dataset, name, kind, dimensions)
      type(dataset_type), intent(inout) :: dataset  !< open; retains the first error
      character(len=*), intent(in) :: name           !< name in the file
      integer, intent(in) :: kind                    !< nf90_double, …
      character(len=*), intent(in) :: dimensions(:)  !< names of the dimensions, the fastest first
      integer :: i, id, ids(size(dimensions))

      do i = 1, size(dimensions)
         if (allocated(dataset%error)) return
         call checked(dataset, nf90_inq_dimid(dataset%id, trim(dimensions(i)), ids(i)), &
            'define '//name)
      end do
      if (.not. allocated(dataset%error)) call checked(dataset, nf90_def_var(dataset%id, name, &
         kind, ids, id), 'define '//name)
   end subroutine define_variable

   !> Write a text attribute of a variable, if it is not blank.
   subroutine describe_variable(dataset, variable, name, text)
      type(dataset_type), intent(inout) :: dataset  !< open; retains the first error
      character(len=*), intent(in) :: variable      !< name of the variable
      character(len=*), intent(in) :: name, text    !< name and text of the attribute
      integer :: id

      if (allocated(dataset%error) .or. text == '') return
      call checked(dataset, nf90_inq_varid(dataset%id, variable, id), 'find '//variable)
      if (.not. allocated(dataset%error)) call checked(dataset, nf90_put_att(dataset%id, id, &
         name, trim(text)), 'describe '//variable)
   end subroutine describe_variable

   !> Write the meanings of the values 0, 1, … of a variable, by the CF conventions.
   subroutine describe_flags(dataset, variable, meanings)
      type(dataset_type), intent(inout) :: dataset  !< open; retains the first error
      character(len=*), intent(in) :: variable      !< name of the variable
      character(len=*), intent(in) :: meanings      !< one word per value; blank: no meanings
      integer :: id, i

      call describe_variable(dataset, variable, 'flag_meanings', meanings)
      if (allocated(dataset%error) .or. meanings == '') return
      call checked(dataset, nf90_inq_varid(dataset%id, variable, id), 'find '//variable)
      associate (words => count([(meanings(i:i) == ' ', i=1, len_trim(meanings))]))
         if (.not. allocated(dataset%error)) call checked(dataset, nf90_put_att(dataset%id, id, &
            'flag_values', [(i, i=0, words)]), 'describe '//variable)
      end associate
   end subroutine describe_flags

   !> Write a text attribute of the file.
   subroutine describe(dataset, name, text)
      type(dataset_type), intent(inout) :: dataset  !< open; retains the first error
      character(len=*), intent(in) :: name, text  !< name and text of the attribute

      if (allocated(dataset%error)) return
      call checked(dataset, nf90_put_att(dataset%id, nf90_global, name, text), &
         'write attribute '//name)
   end subroutine describe

   !> Write a number as an attribute of the file.
   subroutine describe_number(dataset, name, value)
      type(dataset_type), intent(inout) :: dataset  !< open; retains the first error
      character(len=*), intent(in) :: name  !< name of the attribute, with its unit
      real(wp), intent(in) :: value  !< value in the unit of the name

      if (allocated(dataset%error)) return
      call checked(dataset, nf90_put_att(dataset%id, nf90_global, name, value), &
         'write attribute '//name)
   end subroutine describe_number

   !> Read a text attribute of the file; blank if missing.
   function text_of(dataset, name) result(text)  ! total
      type(dataset_type), intent(in) :: dataset  !< open
      character(len=*), intent(in) :: name      !< name of the attribute
      character(len=:), allocatable :: text
      integer :: length

      text = ''
      if (nf90_inquire_attribute(dataset%id, nf90_global, name, len=length) /= nf90_noerr) return
      deallocate (text)
      allocate (character(len=length) :: text)
      if (nf90_get_att(dataset%id, nf90_global, name, text) /= nf90_noerr) text = ''
   end function text_of

   !> Write numbers to a section of a variable, converted to its type.
   subroutine put(dataset, name, values, start, count)
      type(dataset_type), intent(inout) :: dataset  !< open; retains the first error
      character(len=*), intent(in) :: name  !< name of the variable
      real(wp), contiguous, intent(in) :: values(:)  !< values in the order of the file
      integer, intent(in) :: start(:), count(:)  !< [dimensions] from 1
      integer :: variable

      if (allocated(dataset%error)) return
      call checked(dataset, nf90_inq_varid(dataset%id, trim(name), variable), 'find '//name)
      if (.not. allocated(dataset%error)) call checked(dataset, nf_put_vara_double(dataset%id, &
         variable, start, count, values), 'write '//name)
   end subroutine put

   !> Write names that end in NUL; bytes that are not UTF-8 become question marks.
   subroutine put_names(dataset, variable, names, substitute)
      type(dataset_type), intent(inout) :: dataset  !< open; retains the first error
      character(len=*), intent(in) :: variable  !< variable with the dimension `name_length` first
      character(len=*), intent(in) :: names(:)  !< [names] blank-padded
      character(len=*), intent(in), optional :: substitute !< text and number for a blank name
      character(len=name_length) :: c_names(names_at_once), name
      integer :: first, i, n, id

      if (allocated(dataset%error) .or. size(names) == 0) return
      call checked(dataset, nf90_inq_varid(dataset%id, variable, id), 'find '//variable)
      do first = 1, size(names), names_at_once
         if (allocated(dataset%error)) exit
         n = min(names_at_once, size(names) - first + 1)
         do i = 1, n
            name = names(first + i - 1)
            if (name == '' .and. present(substitute)) name = substitute//to_text(first + i - 1)
            c_names(i) = valid_text(name)
            c_names(i)(len_trim(name) + 1:) = repeat(c_null_char, name_length)
         end do
         call checked(dataset, nf90_put_var(dataset%id, id, c_names(:n), start=[1, first], &
            count=[name_length, n]), 'write '//variable)
      end do
   end subroutine put_names

end module dda_netcdf_calls
