! SPDX-License-Identifier: GPL-3.0-or-later
!> Warnings on a run: each has a topic and a sentence.
module dda_doubts
   use dda_archive, only: archive_type, serialise, serialise_count
   implicit none
   private
   public :: doubt_type, add_doubt, add_doubts, doubt_text, serialise_doubts

   character(len=*), parameter :: from_check = 'check: '  !< prefix of the warnings of a check

   !> A warning.
   type :: doubt_type
      character(len=:), allocatable :: topic  !< topic; blank: no topic
      character(len=:), allocatable :: text  !< a sentence
      logical :: of_check = .false.           !< reported by the check of the model
   end type doubt_type

contains

   !> Add a warning to a list, which need not be allocated.
   pure subroutine add_doubt(doubts, topic, text, of_check)
      type(doubt_type), allocatable, intent(inout) :: doubts(:)  !< list of warnings, extended
      character(len=*), intent(in) :: topic, text               !< see `doubt_type`
      logical, intent(in), optional :: of_check  !< see `doubt_type`; default: .false.
      type(doubt_type), allocatable :: longer(:)
      integer :: n

      n = 0
      if (allocated(doubts)) n = size(doubts)
      allocate (longer(n + 1))
      if (n > 0) longer(:n) = doubts
      longer(n + 1)%topic = topic
      longer(n + 1)%text = text
      if (present(of_check)) longer(n + 1)%of_check = of_check
      call move_alloc(longer, doubts)
   end subroutine add_doubt

   !> Add all warnings of another list.
   pure subroutine add_doubts(doubts, added_doubts)
      type(doubt_type), allocatable, intent(inout) :: doubts(:)  !< list of warnings, extended
      type(doubt_type), intent(in) :: added_doubts(:)                    !< warnings to add
      integer :: i

      do i = 1, size(added_doubts)
         call add_doubt(doubts, added_doubts(i)%topic, added_doubts(i)%text, &
            added_doubts(i)%of_check)
      end do
   end subroutine add_doubts

   !> Text of a warning: "topic: sentence", after "check: " for warnings of the check.
   pure function doubt_text(doubt) result(text)
      type(doubt_type), intent(in) :: doubt  !< warning
      character(len=:), allocatable :: text

      text = doubt%text
      if (doubt%topic /= '') text = doubt%topic//': '//text
      if (doubt%of_check) text = from_check//text
   end function doubt_text

   !> Save or restore a list of warnings; on reading, the archive determines its length.
   subroutine serialise_doubts(archive, doubts)
      type(archive_type), intent(inout) :: archive               !< archive that is written or read
      type(doubt_type), allocatable, intent(inout) :: doubts(:)  !< warnings of a run
      integer :: i, n

      n = size(doubts)
      call serialise_count(archive, n)
      if (archive%reading) then
         deallocate (doubts)
         allocate (doubts(n))
      end if
      do i = 1, n
         if (archive%reading) then
            doubts(i)%topic = ''
            doubts(i)%text = ''
         end if
         call serialise(archive, doubts(i)%topic)
         call serialise(archive, doubts(i)%text)
         call serialise(archive, doubts(i)%of_check)
      end do
   end subroutine serialise_doubts

end module dda_doubts
