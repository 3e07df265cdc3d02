! SPDX-License-Identifier: GPL-3.0-or-later
!> Free-field columns of a run.  Each column is a separate run (`dda_column_model`), independent of
!> the model, and its step is computed before the step of the model.  It provides the motion of
!> a side of the model and the forces between its blocks and their images at t₀ + θΔt.
module dda_columns
   use dda_kinds, only: wp
   use dda_elements, only: face_forces, set_free_field_motion
   use dda_errors, only: error_type
   use dda_free_field, only: free_field_type
   use dda_material_damping, only: force_on_strains
   use dda_simulation, only: column_runs_type, simulation_type, next_step
   implicit none
   private
   public :: make_columns, column_count, column_of, pass_columns_to_sides, name_column

   !> Runs of all columns.
   type, extends(column_runs_type) :: columns_type
      type(simulation_type), allocatable :: run(:)  !< [free fields]
   end type columns_type

contains

   !> Allocate the runs of n columns.
   subroutine make_columns(simulation, n)
      type(simulation_type), intent(inout) :: simulation  !< a run and its state
      integer, intent(in) :: n                            !< number of free fields
      type(columns_type), allocatable :: columns

      if (n == 0) return
      allocate (columns)
      allocate (columns%run(n))
      call move_alloc(columns, simulation%columns)
   end subroutine make_columns

   !> Return the number of columns.
   pure integer function column_count(simulation)
      type(simulation_type), intent(in) :: simulation  !< a run and its state

      column_count = 0
      if (allocated(simulation%columns)) column_count = size(simulation%model%free_fields)
   end function column_count

   !> Return the run of a column.
   function column_of(simulation, i) result(run)
      type(simulation_type), intent(in), target :: simulation  !< a run and its state
      integer, intent(in) :: i                                 !< number of the column
      type(simulation_type), pointer :: run

      run => null()
      select type (columns => simulation%columns)
      type is (columns_type)
         run => columns%run(i)
      end select
   end function column_of

   !> Pass the solutions of the columns in this step to the sides of the model.
   !> In statics the solution is the equilibrium of the columns.
   subroutine pass_columns_to_sides(simulation)
      type(simulation_type), intent(inout) :: simulation  !< a run and its state
      type(simulation_type), pointer :: run
      integer :: i

      do i = 1, column_count(simulation)
         run => column_of(simulation, i)
         if (simulation%in_statics) run%system%d = 0.0_wp
         associate (field => simulation%model%free_fields(i))
            call set_free_field_motion(simulation%elements, i, field%block, run%blocks, &
               run%system%d, forces_at_side(run, field))
         end associate
      end do
   end subroutine pass_columns_to_sides

   !> Return the forces on the blocks at the side from their neighbours in level ground.
   !> Forces due to the strain of the cell in the triangle of a side face are subtracted, because
   !> the model includes them.
   function forces_at_side(run, field) result(force)
      type(simulation_type), intent(in) :: run     !< run of the column
      type(free_field_type), intent(in) :: field   !< free field of the model
      real(wp) :: force(6, run%blocks%n)           !< N/m and N
      integer :: i

      force = face_forces(run%elements, field%face, run%blocks, next_step(run), run%system%d)
      do i = 1, size(field%weld)
         associate (b => field%weld(i)%block(field%face), area => field%weld(i)%area(field%face))
            force(4:6, b) = force(4:6, b) - area/run%blocks%area(b) &
               *force_on_strains(run%blocks, next_step(run), b, run%system%d(:, b))
         end associate
      end do
   end function forces_at_side

   !> Add the name of the failed column to an error message.
   subroutine name_column(simulation, i, error)
      type(simulation_type), intent(in) :: simulation  !< a run and its state
      integer, intent(in) :: i                         !< number of the column
      type(error_type), allocatable, intent(inout) :: error  !< error of the column's run, if any

      if (allocated(error)) error%message = 'free field at the '// &
         trim(simulation%model%free_fields(i)%side)//' side: '//error%message
   end subroutine name_column

end module dda_columns
