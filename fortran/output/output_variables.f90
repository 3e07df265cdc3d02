! SPDX-License-Identifier: GPL-3.0-or-later
!> Parts of the output schema that a model has: families of variables, lengths of dimensions,
!> positions of numbers in a sample.
module dda_output_variables
   use dda_breaking, only: can_break
   use dda_netcdf_calls, only: name_length
   use dda_output_schema
   use dda_simulation, only: simulation_type
   implicit none
   private
   public :: families_of, lengths_of, numbers_of, offset_in_sample, size_of_sample, is_in

contains

   !> .true. for each family of output variables that the model has.
   pure function families_of(simulation) result(has)
      type(simulation_type), intent(in) :: simulation  !< simulation at its present time
      logical :: has(number_of_families)
      integer :: lengths(size(dimension_names)), i

      lengths = lengths_of(simulation)
      has = .true.
      has(in_measured_joints) = lengths(dim_measured_joint) > 0
      has(in_bolts) = lengths(dim_bolt) > 0
      has([in_flow_nodes, in_flow_channels, in_flow_network]) = lengths(dim_flow_channel) > 0
      has(in_cables) = lengths(dim_through) > 0
      has(in_boundary_motions) = lengths(dim_boundary) > 0
      has(in_boundary_edges) = lengths(dim_boundary_edge) > 0
      has(in_bodies) = lengths(dim_body) > 0
      has(in_yielding) = any(simulation%model%materials%yields())
      has(in_breaking) = can_break(simulation%model)
      associate (laws => simulation%laws)
         do i = 1, size(contact_columns)  ! state variables of joint laws
            associate (variable => output_variables(contact_columns(i)))
               if (variable%family > in_contacts_of_laws) has(variable%family) = &
                  any(laws%columns%name == variable%name(9:))
            end associate
         end do
         has(in_contacts_between_corners) = laws%cohesive .or. laws%pointed
         has(in_contacts_of_laws) = laws%cohesive .or. laws%pointed .or. .not. laws%plain
      end associate
   end function families_of

   !> Lengths of the dimensions in one row, thus 1 for samples, frames and contacts.
   pure function lengths_of(simulation) result(lengths)
      type(simulation_type), intent(in) :: simulation  !< simulation at its present time
      integer :: lengths(size(dimension_names)), i

      lengths([dim_time, dim_frame, dim_contact]) = 1
      lengths([dim_axis, dim_side]) = 2
      lengths(dim_component) = 3
      lengths(dim_coordinate4) = 4
      lengths(dim_coordinate) = 6
      lengths(dim_letter) = name_length
      lengths(dim_maximum) = number_of_maxima
      lengths(dim_block) = simulation%blocks%n
      lengths(dim_vertex) = size(simulation%blocks%owner)
      associate (model => simulation%model)
         lengths(dim_point) = size(model%points)
         lengths(dim_joint) = size(model%joints)
         lengths(dim_measured_joint) = size(model%measured_joints)
         lengths(dim_bolt) = size(model%bolts)
         lengths([dim_flow_node, dim_flow_channel]) = 0
         if (allocated(model%flow)) lengths([dim_flow_node, dim_flow_channel]) = &
            [size(model%flow%pressure), size(model%flow%channel)]
         lengths(dim_through) = sum([(size(model%bolts(i)%block) - 2, i=1, size(model%bolts))])
         lengths(dim_body) = size(model%body_names)
         lengths(dim_boundary) = size(model%boundary_motions)
         lengths(dim_boundary_edge) = size(model%boundary_edges)
      end associate
   end function lengths_of

   !> Number of values of a variable in a row, or in total if it is written once.
   pure integer function numbers_of(variable, lengths)
      type(output_variable_type), intent(in) :: variable    !< variable of the schema
      integer, intent(in) :: lengths(:)                     !< lengths of all dimensions

      numbers_of = product(lengths(variable%dimensions(:count(variable%dimensions > 0))))
   end function numbers_of

   !> .true. if a variable is written in each row of a kind.
   elemental logical function is_in(variable, row, has)
      type(output_variable_type), intent(in) :: variable  !< variable of the schema
      integer, intent(in) :: row  !< kind: each_time, each_frame or each_contact
      logical, intent(in) :: has  !< the model has the family of the variable

      is_in = variable%row == row .and. has
   end function is_in

   !> Number of values in a sample before a variable; the index after the last gives the total.
   pure integer function offset_in_sample(simulation, variable_index) result(offset)
      type(simulation_type), intent(in) :: simulation  !< simulation at its present time
      integer, intent(in) :: variable_index            !< index of the variable in the schema
      integer :: lengths(size(dimension_names)), i

      lengths = lengths_of(simulation)
      offset = 0
      do i = 1, variable_index - 1
         if (output_variables(i)%row == each_time) offset = offset &
            + numbers_of(output_variables(i), lengths)
      end do
   end function offset_in_sample

   !> Number of values of a sample.
   pure integer function size_of_sample(simulation)
      type(simulation_type), intent(in) :: simulation  !< simulation at its present time

      size_of_sample = offset_in_sample(simulation, size(output_variables) + 1)
   end function size_of_sample

end module dda_output_variables
