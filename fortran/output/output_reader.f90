! SPDX-License-Identifier: GPL-3.0-or-later
!> Reading of time histories from a complete or partial output.
module dda_output_reader
   use dda_kinds, only: wp
   use dda_errors, only: error_type, error_file, error_input, fail
   use dda_file_system, only: is_special
   use dda_netcdf_calls, only: dataset_type, path_of, checked
   use dda_text, only: quoted
   use netcdf, only: nf90_open, nf90_close, nf90_nowrite, nf90_inq_dimid, nf90_inq_varid, &
      nf90_inquire_dimension, nf90_inquire_variable, nf90_get_var, nf90_max_var_dims
   implicit none
   private
   public :: read_history, read_histories

contains

   !> Read the time history of a variable.
   subroutine read_history(file, quantity, at, time, values, error)
      character(len=*), intent(in) :: file      !< path of the output
      character(len=*), intent(in) :: quantity  !< name of the variable in the output
      !> index in the other dimensions of the variable, from 1, such as axis and point; empty for
      !> variables without other dimensions, such as `energy_kinetic`
      integer, intent(in) :: at(:)
      real(wp), allocatable, intent(out) :: time(:)    !< [samples] time, s
      real(wp), allocatable, intent(out) :: values(:)  !< [samples] values in the unit of the output
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      real(wp), allocatable :: columns(:,:)

      call read_histories(file, quantity, reshape(at, [size(at), 1]), time, columns, error)
      values = columns(:, 1)
   end subroutine read_history

   !> Read the time histories of a variable at some of its indices.
   subroutine read_histories(file, quantity, at, time, values, error)
      character(len=*), intent(in) :: file      !< path of the output
      character(len=*), intent(in) :: quantity  !< name of the variable in the output
      integer, intent(in) :: at(:,:)  !< [other dimensions, histories] as in `read_history`
      real(wp), allocatable, intent(out) :: time(:)  !< [samples] time, s
      !> [samples, histories] values in the unit of the output
      real(wp), allocatable, intent(out) :: values(:,:)
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      type(dataset_type) :: dataset
      real(wp), allocatable :: series(:)
      integer :: i, unused

      allocate (time(0), values(0, size(at, 2)))
      if (is_special(file)) call fail(error, error_file, file//' cannot be read, because it is '// &
         'not a regular file')
      if (allocated(error)) return
      dataset%file = file
      call checked(dataset, nf90_open(path_of(file), nf90_nowrite, dataset%id), 'open the file')
      if (.not. allocated(dataset%error)) then
         call read_series(dataset, 'time', [integer ::], time)
         deallocate (values)
         allocate (values(size(time), size(at, 2)), source=0.0_wp)
         do i = 1, size(at, 2)
            call read_series(dataset, quantity, at(:, i), series)
            if (.not. allocated(dataset%error)) values(:, i) = series
         end do
         unused = nf90_close(dataset%id)
      end if
      if (allocated(dataset%error)) error = dataset%error
   end subroutine read_histories

   !> Read all samples of a variable at an index.
   subroutine read_series(dataset, name, at, values)
      type(dataset_type), intent(inout) :: dataset  !< open dataset; retains the first error
      character(len=*), intent(in) :: name          !< name of the variable
      integer, intent(in) :: at(:)                  !< index in the other dimensions
      real(wp), allocatable, intent(out) :: values(:)  !< [samples] values
      integer :: id, time, samples, n, dimensions(nf90_max_var_dims)
      logical :: has_history

      allocate (values(0))
      if (allocated(dataset%error)) return
      call checked(dataset, nf90_inq_dimid(dataset%id, 'time', time), 'find the samples')
      call checked(dataset, nf90_inq_varid(dataset%id, name, id), 'find '//quoted(name))
      if (allocated(dataset%error)) return
      call checked(dataset, nf90_inquire_dimension(dataset%id, time, len=samples), &
         'count the samples')
      call checked(dataset, nf90_inquire_variable(dataset%id, id, ndims=n, dimids=dimensions), &
         'read '//quoted(name))
      if (allocated(dataset%error)) return
      has_history = n == size(at) + 1
      if (has_history) has_history = dimensions(n) == time
      if (.not. has_history) then
         call fail(dataset%error, error_input, dataset%file//': '//quoted(name)// &
            ' has no history at this index')
         return
      end if
      deallocate (values)
      allocate (values(samples))
      call checked(dataset, nf90_get_var(dataset%id, id, values, [at, 1], [0*at + 1, &
         samples]), 'read '//quoted(name))
   end subroutine read_series

end module dda_output_reader
