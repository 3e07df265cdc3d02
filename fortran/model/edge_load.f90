! SPDX-License-Identifier: GPL-3.0-or-later
!> Loads on edges: tractions, and the pressure of water on faces and in joints.
module dda_edge_load
   use dda_kinds, only: wp
   use dda_edge_piece, only: edge_piece_type
   implicit none
   private
   public :: edge_load_type, value_at, load_uniform, load_level, load_surface, load_line

   integer, parameter :: load_uniform = 1  !< the same traction everywhere
   integer, parameter :: load_level = 2    !< hydrostatic below a level
   integer, parameter :: load_surface = 3  !< hydrostatic below a phreatic line
   integer, parameter :: load_line = 4     !< pressures at the ends of each piece

   !> One load (group &traction or &water).
   type :: edge_load_type
      character(len=64) :: name = ''
      integer :: kind = load_uniform
      logical :: present = .true.                    !< a stage may add it, or take it away
      logical :: follows = .true.                    !< the edges as they move; else as they were
      type(edge_piece_type), allocatable :: piece(:) !< that it acts on
      real(wp), allocatable :: ends(:,:,:)           !< [2,2,pieces] their first ends, m
      real(wp), allocatable :: at_ends(:,:)          !< [2,pieces] pressures of `load_line`, Pa
      real(wp), allocatable :: line(:,:)             !< [2,points] phreatic line, x ascending, m
      real(wp) :: unit_weight = 0.0_wp               !< of water, N/m³
      logical :: held = .false.                      !< first and last value last for ever
      real(wp), allocatable :: time(:)               !< s, ascending
      real(wp), allocatable :: normal(:)             !< [times] pressure, Pa; of water its factor
      real(wp), allocatable :: shear(:)              !< [times] along the edge, Pa
      real(wp), allocatable :: level(:)              !< [times] m; of water its rise
   end type edge_load_type

contains

   !> A quantity of a load at a time: linear between its times; outside zero, or held.
   pure real(wp) function value_at(load, values, time) result(value)
      type(edge_load_type), intent(in) :: load  !< its times
      real(wp), intent(in) :: values(:)         !< [times]
      real(wp), intent(in) :: time              !< s
      integer :: k, n
      real(wp) :: share

      n = size(load%time)
      value = 0.0_wp
      if (time < load%time(1) .or. time > load%time(n)) then
         if (load%held) value = merge(values(1), values(n), time < load%time(1))
         return
      end if
      k = max(1, min(n - 1, count(load%time <= time)))
      value = values(min(k, n))
      if (n == 1) return
      share = 1.0_wp
      if (load%time(k + 1) > load%time(k)) share = (time - load%time(k)) &
         /(load%time(k + 1) - load%time(k))
      value = values(k) + share*(values(k + 1) - values(k))
   end function value_at

end module dda_edge_load
