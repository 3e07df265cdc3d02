! SPDX-License-Identifier: GPL-3.0-or-later
!> The linear solvers by name.
module dda_solver_table
   use dda_abstract_solver, only: linear_solver_type
   use dda_factor_solver, only: factor_solver_type
   use dda_jacobi_solver, only: jacobi_solver_type
   use dda_lagged_solver, only: lagged_solver_type
   use dda_sor_solver, only: sor_solver_type
   implicit none
   private
   public :: solver_names, is_solver_name, make_solver

   !> names of the solvers; `auto` chooses among the others
   character(len=*), parameter :: solver_names(5) = [character(len=6) :: 'auto', 'direct', &
      'lagged', 'jacobi', 'sor']

contains

   !> .true. if a solver of this name exists.
   pure logical function is_solver_name(name)
      character(len=*), intent(in) :: name  !< text to test

      is_solver_name = any(solver_names == name)
   end function is_solver_name

   !> Create a solver by name, without a matrix.
   subroutine make_solver(name, solver)
      character(len=*), intent(in) :: name  !< one of `solver_names`, except 'auto'
      class(linear_solver_type), allocatable, intent(out) :: solver  !< solver with that method

      select case (name)
      case ('lagged')
         allocate (lagged_solver_type :: solver)
      case ('jacobi')
         allocate (jacobi_solver_type :: solver)
      case ('sor')
         allocate (sor_solver_type :: solver)
      case default
         allocate (factor_solver_type :: solver)
      end select
      solver%name = name
   end subroutine make_solver

end module dda_solver_table
