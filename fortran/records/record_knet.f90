!> K-NET and KiK-net ASCII format: 17 header lines with a name in the first 18 columns, samples.
!>
!> Reference: NIED, *K-NET ASCII format* (www.kyoshin.bosai.go.jp): sampling frequency `100Hz`,
!> duration in seconds, scale factor `2000(gal)/8388608`; acceleration in gal is the integer
!> sample times the factor.  Raw records have an offset, which is left for the baseline to remove.
module dda_record_knet
   use dda_kinds, only: wp, long
   use dda_errors, only: error_type
   use dda_text, only: quoted, to_text
   use dda_text_lines, only: line_reader_type, fail_at
   use dda_record_type, only: record_type, acceleration
   use dda_record_samples, only: read_trace, take_line, check_count, check_time_step, &
      first_number
   implicit none
   private
   public :: is_knet, read_knet

   integer, parameter :: header_lines = 17
   integer, parameter :: name_columns = 18

   !> Values of a K-NET header.
   type :: knet_header_type
      real(wp) :: frequency = -1.0_wp  ! samples/s
      real(wp) :: duration = -1.0_wp   ! s
      real(wp) :: factor = 0.0_wp      ! gal per count
   end type knet_header_type

contains

   !> Whether a file that begins so is a K-NET file.
   pure function is_knet(first) result(is)
      character(len=*), intent(in) :: first   !< its first line
      logical :: is

      is = index(first, 'Origin Time') == 1
   end function is_knet

   !> Read the one trace of a K-NET file, in gal.
   subroutine read_knet(reader, record, error)
      type(line_reader_type), intent(inout) :: reader        !< at the start of the file
      type(record_type), intent(inout) :: record  !< filled from the file
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      type(knet_header_type) :: header
      integer(long) :: samples

      record%quantity = acceleration
      record%unit = 'gal'
      call read_header(reader, record, header, error)
      if (.not. allocated(error)) call check_header(reader, header, samples, record%time_step, &
         error)
      if (.not. allocated(error)) call read_trace(reader, samples, &
         'samples (frequency × duration)', record%values, error)
      if (.not. allocated(error)) call scale_counts(reader, header%factor, record%values, error)
   end subroutine read_knet

   !> The 17 header lines.
   subroutine read_header(reader, record, header, error)
      type(line_reader_type), intent(inout) :: reader  !< of the file
      type(record_type), intent(inout) :: record  !< filled from the file
      type(knet_header_type), intent(out) :: header  !< as read
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      character(len=:), allocatable :: text, rest
      integer :: line

      do line = 1, header_lines
         call take_line(reader, text, 'the 17 header lines of K-NET', error)
         if (allocated(error)) return
         rest = trim(adjustl(text(min(name_columns, len(text)) + 1:)))
         call read_item(reader, text, rest, record, header, error)
         if (allocated(error)) return
      end do
   end subroutine read_header

   !> Take what one line of the header states.
   subroutine read_item(reader, text, rest, record, header, error)
      type(line_reader_type), intent(in) :: reader  !< of the file, for messages
      character(len=*), intent(in) :: text, rest  !< the line; what stands after its name
      type(record_type), intent(inout) :: record  !< filled from the file
      type(knet_header_type), intent(inout) :: header  !< as read so far
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure

      if (index(text, 'Origin Time') == 1) then
         record%description = 'event of '//rest
      else if (index(text, 'Station Code') == 1) then
         record%station = rest
      else if (index(text, 'Sampling Freq') == 1) then
         call first_number(reader, rest, 'sampling frequency', header%frequency, error)
      else if (index(text, 'Duration Time') == 1) then
         call first_number(reader, rest, 'duration', header%duration, error)
      else if (index(text, 'Scale Factor') == 1) then
         call read_factor(reader, rest, header%factor, error)
      else if (index(text, 'Dir.') == 1) then
         record%description = record%description//', direction '//rest
      end if
   end subroutine read_item

   !> `2000(gal)/8388608`
   subroutine read_factor(reader, text, factor, error)
      type(line_reader_type), intent(in) :: reader  !< of the file, for messages
      character(len=*), intent(in) :: text  !< line of the file
      real(wp), intent(out) :: factor  !< gal per count
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      real(wp), parameter :: largest = 1.0e12_wp
      real(wp) :: full_scale, counts
      integer :: slash

      factor = 0.0_wp
      slash = index(text, '/')
      if (index(text, '(gal)/') == 0) then
         call fail_at(error, reader, 'the scale factor '//quoted(text)// &
            " has not the form 'number(gal)/number'")
         return
      end if
      call first_number(reader, text(:slash - 1), 'scale factor', full_scale, error)
      if (.not. allocated(error)) call first_number(reader, text(slash + 1:), 'scale factor', &
         counts, error)
      if (allocated(error)) return
      if (full_scale <= 0.0_wp .or. full_scale > largest .or. counts < 1.0_wp &
         .or. counts > largest) then
         call fail_at(error, reader, 'the scale factor '//quoted(text)// &
            ' is not a positive number of gal per count')
         return
      end if
      factor = full_scale/counts
   end subroutine read_factor

   !> Time step and number of samples from frequency and duration.
   subroutine check_header(reader, header, samples, time_step, error)
      type(line_reader_type), intent(in) :: reader  !< of the file, for messages
      type(knet_header_type), intent(in) :: header  !< as read
      integer(long), intent(out) :: samples  !< declared by the header
      real(wp), intent(out) :: time_step  !< s
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      real(wp), parameter :: largest = 1.0e12_wp

      samples = 0
      time_step = 0.0_wp
      if (header%frequency <= 0.0_wp .or. header%duration <= 0.0_wp &
         .or. header%factor <= 0.0_wp) then
         call fail_at(error, reader, 'the header does not state sampling frequency, duration '// &
            'and scale factor'//' as positive numbers')
         return
      end if
      time_step = 1.0_wp/max(header%frequency, 1.0e-30_wp)
      call check_time_step(reader, time_step, error)
      if (allocated(error)) return
      call check_count(reader, anint(min(header%frequency*min(header%duration, largest), &
         largest)), samples, error)
   end subroutine check_header

   !> Counts to gal.
   subroutine scale_counts(reader, factor, values, error)
      type(line_reader_type), intent(in) :: reader  !< of the file, for messages
      real(wp), intent(in) :: factor  !< gal per count
      real(wp), intent(inout) :: values(:)  !< [samples] counts, then gal
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      ! counts; keeps the product far from overflow
      real(wp), parameter :: largest = 1.0e12_wp

      if (maxval(abs(values)) > largest) then
         call fail_at(error, reader, 'a sample of '//to_text(maxval(abs(values)))//' counts')
         return
      end if
      values = values*factor
   end subroutine scale_counts

end module dda_record_knet
