! SPDX-License-Identifier: GPL-3.0-or-later
!> Loads on edges: tractions, and pressure of water on faces and in joints.
module dda_edge_load
   use dda_kinds, only: wp
   use dda_edge_part, only: edge_part_type
   use dda_interpolation, only: find_interval
   implicit none
   private
   public :: edge_load_type, values_at, history_of, load_uniform, load_level, load_surface, &
      load_line

   integer, parameter :: load_uniform = 1  !< traction, equal on all parts
   integer, parameter :: load_level = 2    !< hydrostatic pressure below a level
   integer, parameter :: load_surface = 3  !< hydrostatic pressure below a phreatic line
   integer, parameter :: load_line = 4     !< pressures at the ends of each part

   !> A load (group &traction or &water).
   type :: edge_load_type
      character(len=64) :: name = ''
      integer :: kind = load_uniform
      logical :: present = .true.                    !< part of the model; stages may change this
      !> the load acts on the moving edges; .false.: on the initial edges
      logical :: follows = .true.
      type(edge_part_type), allocatable :: part(:) !< parts of edges on which the load acts
      real(wp), allocatable :: ends(:,:,:)           !< [2,2,parts] initial ends of the parts, m
      real(wp), allocatable :: at_ends(:,:)          !< [2,parts] pressures of `load_line`, Pa
      real(wp), allocatable :: line(:,:)             !< [2,points] phreatic line, x ascending, m
      real(wp) :: unit_weight = 0.0_wp               !< unit weight of water, N/m³
      real(wp) :: reservoir = 0.0_wp                 !< depth H of Westergaard's mass, m; 0: none
      logical :: acts_always = .false.                      !< values are constant outside the times
      real(wp), allocatable :: time(:)               !< s, ascending
      real(wp), allocatable :: normal(:)  !< [times] pressure, Pa; for water, factor of the pressure
      real(wp), allocatable :: shear(:)              !< [times] shear traction along the edge, Pa
      real(wp), allocatable :: level(:)  !< [times] level, m; for water, rise of the level
   end type edge_load_type

contains

   !> Pressure, shear and water level of a load at a time; for &water: factor of the pressure,
   !> shear, rise of the level.  Values are linear between the times of a load, and constant beyond
   !> them.
   pure function values_at(load, time) result(values)
      type(edge_load_type), intent(in) :: load  !< load with its times
      real(wp), intent(in) :: time              !< time, s
      real(wp) :: values(3)                     !< pressure (Pa) or factor, shear (Pa), level (m)
      real(wp) :: fraction
      integer :: k, last

      call find_interval(load%time, min(max(time, load%time(1)), load%time(size(load%time))), k, &
         last, fraction)
      values = history_of(load, k) + fraction*(history_of(load, last) - history_of(load, k))
   end function values_at

   !> Values of a load at one of its times.
   pure function history_of(load, k) result(values)
      type(edge_load_type), intent(in) :: load  !< load with its times
      integer, intent(in) :: k                  !< number of the time
      real(wp) :: values(3)                     !< see `values_at`

      values = [load%normal(k), load%shear(k), load%level(k)]
   end function history_of

end module dda_edge_load
