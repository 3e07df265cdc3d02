!> netCDF calls that turn a bad status into one error naming file and action.
module dda_netcdf_calls
   use dda_kinds, only: wp
   use dda_errors, only: error_type, error_file, fail
   use netcdf, only: nf90_noerr, nf90_strerror, nf90_def_var, nf90_put_att, nf90_def_dim, &
      nf90_inquire_variable, nf90_inquire_attribute, nf90_get_att, nf90_global, nf90_max_name
   implicit none
   private
   public :: dataset_type, checked, define, define_dimension, describe, text_of, put

   !> An open file; once a call has failed the later ones do nothing.
   type :: dataset_type
      character(len=:), allocatable :: file
      integer :: id = -1
      type(error_type), allocatable :: error
   end type dataset_type

   !> Write values, in the order of the file, at a start and count.
   interface put
      module procedure put_real, put_integer
   end interface put

   ! The calls that take an array of any shape as a plain sequence are not in the netcdf module.
   interface
      integer function nf_put_vara_double(id, variable, start, count, values)
         import :: wp
         integer, intent(in) :: id, variable, start(*), count(*)  !< of the netCDF library
         real(wp), intent(in) :: values(*)  !< in the order of the file
      end function nf_put_vara_double

      integer function nf_put_vara_int(id, variable, start, count, values)
         integer, intent(in) :: id, variable, start(*), count(*)  !< of the netCDF library
         integer, intent(in) :: values(*)  !< in the order of the file
      end function nf_put_vara_int
   end interface

contains

   !> Note the error of a call, unless there was one before.
   subroutine checked(dataset, status, action)
      type(dataset_type), intent(inout) :: dataset  !< open; keeps the first error
      integer, intent(in) :: status  !< of a netCDF call
      character(len=*), intent(in) :: action  !< for the message: "cannot …"

      if (status == nf90_noerr .or. allocated(dataset%error)) return
      call fail(dataset%error, error_file, dataset%file//': cannot '//action//': '// &
         trim(nf90_strerror(status)))
   end subroutine checked

   !> Define a dimension; the result is its number.
   integer function define_dimension(dataset, name, length) result(id)
      type(dataset_type), intent(inout) :: dataset  !< open; keeps the first error
      character(len=*), intent(in) :: name  !< in the file
      integer, intent(in) :: length  !< of the dimension

      id = -1
      if (.not. allocated(dataset%error)) call checked(dataset, nf90_def_dim(dataset%id, name, &
         length, id), 'define dimension '//name)
   end function define_dimension

   !> Define a variable with its unit and long name.
   integer function define(dataset, name, kind, dimensions, units, meaning) result(id)
      type(dataset_type), intent(inout) :: dataset  !< open; keeps the first error
      character(len=*), intent(in) :: name  !< in the file
      integer, intent(in) :: kind  !< nf90_double, …
      integer, intent(in) :: dimensions(:)  !< netCDF dimensions, the fastest first
      character(len=*), intent(in) :: units, meaning  !< attributes `units` and `long_name`

      id = -1
      if (allocated(dataset%error)) return
      call checked(dataset, nf90_def_var(dataset%id, name, kind, dimensions, id), 'define '//name)
      if (allocated(dataset%error)) return
      call checked(dataset, nf90_put_att(dataset%id, id, 'units', units), 'describe '//name)
      call checked(dataset, nf90_put_att(dataset%id, id, 'long_name', meaning), 'describe '//name)
   end function define

   !> A text attribute of the file.
   subroutine describe(dataset, name, text)
      type(dataset_type), intent(inout) :: dataset  !< open; keeps the first error
      character(len=*), intent(in) :: name, text  !< of the attribute

      if (allocated(dataset%error)) return
      call checked(dataset, nf90_put_att(dataset%id, nf90_global, name, text), &
         'write attribute '//name)
   end subroutine describe

   !> A text attribute of the file; blank if it has none of that name.
   function text_of(dataset, name) result(text)
      type(dataset_type), intent(in) :: dataset  !< open
      character(len=*), intent(in) :: name      !< of the attribute
      character(len=:), allocatable :: text
      integer :: length

      text = ''
      if (nf90_inquire_attribute(dataset%id, nf90_global, name, len=length) /= nf90_noerr) return
      deallocate (text)
      allocate (character(len=length) :: text)
      if (nf90_get_att(dataset%id, nf90_global, name, text) /= nf90_noerr) text = ''
   end function text_of

   !> Real numbers.
   subroutine put_real(dataset, variable, values, start, count)
      type(dataset_type), intent(inout) :: dataset  !< open; keeps the first error
      integer, intent(in) :: variable  !< netCDF variable
      real(wp), contiguous, intent(in) :: values(:)  !< in the order of the file
      integer, intent(in) :: start(:), count(:)  !< [dimensions] from 1

      if (allocated(dataset%error)) return
      call checked(dataset, nf_put_vara_double(dataset%id, variable, start, count, values), &
         'write '//name_of(dataset, variable))
   end subroutine put_real

   !> Whole numbers.
   subroutine put_integer(dataset, variable, values, start, count)
      type(dataset_type), intent(inout) :: dataset  !< open; keeps the first error
      integer, intent(in) :: variable  !< netCDF variable
      integer, contiguous, intent(in) :: values(:)  !< in the order of the file
      integer, intent(in) :: start(:), count(:)  !< [dimensions] from 1

      if (allocated(dataset%error)) return
      call checked(dataset, nf_put_vara_int(dataset%id, variable, start, count, values), &
         'write '//name_of(dataset, variable))
   end subroutine put_integer

   !> Name of a variable, for messages.
   function name_of(dataset, variable) result(name)
      type(dataset_type), intent(in) :: dataset  !< open
      integer, intent(in) :: variable  !< netCDF variable
      character(len=:), allocatable :: name
      character(len=nf90_max_name) :: buffer

      name = 'a variable'
      if (nf90_inquire_variable(dataset%id, variable, buffer) == nf90_noerr) name = trim(buffer)
   end function name_of

end module dda_netcdf_calls
