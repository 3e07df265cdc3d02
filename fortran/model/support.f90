! SPDX-License-Identifier: GPL-3.0-or-later
!> Supports and loads at material points, measured points and measured joints.
module dda_support
   use dda_kinds, only: wp
   use dda_interpolation, only: find_interval
   implicit none
   private
   public :: fixed_point_type, load_type, point_type, measured_joint_type, load_at

   !> A material point tied by a spring to its initial position plus a prescribed displacement.
   type :: fixed_point_type
      character(len=64) :: name = ''
      integer :: block = 0
      real(wp) :: reference(2) = 0.0_wp             !< offset ρ from the centroid, m
      real(wp) :: position(2) = 0.0_wp                 !< initial position, m
      !> [2,2] unit vectors of the fixed directions, in columns: x and y, or normal and edge
      real(wp) :: axes(2, 2) = reshape([1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [2, 2])
      logical :: fixed_along(2) = .true.            !< fixed along each of these directions
      real(wp) :: stiffness = 0.0_wp                !< N/m per metre of thickness; 0: rigid
      !> the point becomes fixed along this direction in a later stage
      logical :: waiting(2) = .false.
      integer :: motion(2) = 0                      !< motion along each direction; 0: fixed
   end type fixed_point_type

   !> A force history at a material point, linear between its times, zero before and after.
   type :: load_type
      integer :: block = 0
      real(wp) :: reference(2) = 0.0_wp             !< offset ρ from the centroid, m
      real(wp), allocatable :: time(:)              !< s, ascending
      real(wp), allocatable :: force(:,:)           !< [2, times] N per metre of thickness
      real(wp) :: start = 0.0_wp                    !< origin of the times, s
      character(len=64) :: name = ''
   end type load_type

   !> A measured point.
   type :: point_type
      character(len=64) :: name = ''
      integer :: block = 0
      real(wp) :: reference(2) = 0.0_wp             !< offset ρ from the centroid, m
      real(wp) :: position(2) = 0.0_wp                 !< initial position, m
      integer :: other = 0  !< second block at the point, if none is named
   end type point_type

   !> A joint between two sets of blocks whose slip, opening and force are written to the output.
   type :: measured_joint_type
      character(len=64) :: name = ''
      !> [blocks] 1: set whose slip and force are reported; 2: other set; 0: neither
      integer, allocatable :: side(:)
   end type measured_joint_type

contains

   !> Force of a load at a time; zero before its first and after its last time.
   pure function load_at(load, time) result(force)
      type(load_type), intent(in) :: load  !< force history
      real(wp), intent(in) :: time  !< time, s
      real(wp) :: force(2)
      real(wp) :: fraction, since
      integer :: k, last

      force = 0.0_wp
      since = time - load%start
      if (since < load%time(1) .or. since > load%time(size(load%time))) return
      call find_interval(load%time, since, k, last, fraction)
      force = load%force(:, k) + fraction*(load%force(:, last) - load%force(:, k))
   end function load_at

end module dda_support
