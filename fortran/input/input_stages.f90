! SPDX-License-Identifier: GPL-3.0-or-later
!> Groups &stage: the sequence of changes of a run.
module dda_input_stages
   use dda_kinds, only: wp, long
   use dda_errors, only: error_type
   use dda_input_group, only: group_type, fail_input, given, is_set, positions, require_name, &
      require_new_name, unset, value_or, mark_names
   use dda_input_groups, only: stage_values, read_values
   use dda_input_settings, only: count_steps, set_integration
   use dda_model, only: model_type
   use dda_scheme, only: default_theta
   use dda_settings, only: control_type
   use dda_stage, only: stage_type, never
   use dda_text, only: quoted
   implicit none
   private
   public :: read_stages

contains

   !> Read the stages of an input.
   !> Without &stage, &control gives a dynamic stage, after a static stage if settle = .true.
   subroutine read_stages(model, groups, error)
      type(model_type), intent(inout) :: model  !< model with blocks, supports, motions, materials
      type(group_type), intent(in) :: groups(:)  !< groups of the input, in its order
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer, allocatable :: group_numbers(:)
      integer :: s

      if (allocated(error)) return
      group_numbers = positions(groups, 'stage')
      if (size(group_numbers) == 0) then
         call set_control_stages(model)
         return
      end if
      allocate (model%stages(size(group_numbers)))
      do s = 1, size(group_numbers)
         call read_stage(groups(group_numbers(s)), model, s, error)
         call check_history(model, s, groups(group_numbers(s)), error)
         if (allocated(error)) return
      end do
      call begin_other_motions(model%stages)
      call wait_for_stages(model)
      call begin_control(model)
   end subroutine read_stages

   !> Set the stages of a model without &stage groups.
   pure subroutine set_control_stages(model)
      type(model_type), intent(inout) :: model  !< model as read from the input
      integer :: s

      associate (control => model%control)
         allocate (model%stages(merge(2, 1, control%settle)))
         do s = 1, size(model%stages)
            call set_unchanged_stage(model, model%stages(s))
         end do
         model%stages(1)%name = 'rest'
         model%stages(1)%static = .true.
         associate (stage => model%stages(size(model%stages)))
            stage%name = 'run'
            stage%static = .false.
            stage%time_step = control%time_step
            stage%steps = control%step_count
            stage%duration = control%duration
            stage%integration = control%integration
            stage%theta = control%theta
            stage%zero_displacements = control%settle
            stage%begins = .true.
         end associate
      end associate
   end subroutine set_control_stages

   !> Set a stage that does not change the model.
   pure subroutine set_unchanged_stage(model, stage)
      type(model_type), intent(in) :: model  !< model as read from the input
      type(stage_type), intent(inout) :: stage  !< stage to complete
      integer :: i

      allocate (stage%removed(model%blocks%n), source=.false.)
      allocate (stage%released(size(model%fixed_points)), source=.false.)
      allocate (stage%holds(size(model%fixed_points)), source=.false.)
      allocate (stage%loads(size(model%loads)), source=.false.)
      allocate (stage%begins(size(model%motions)), source=.false.)
      allocate (stage%added(size(model%bolts) + size(model%edge_loads)), source=.false.)
      stage%dropped = stage%added
      stage%joint = [(i, i=1, size(model%joints))]
      stage%material = [(i, i=1, size(model%materials))]
   end subroutine set_unchanged_stage

   !> Start motions that are not listed in any stage with the first dynamic stage.
   pure subroutine begin_other_motions(stages)
      type(stage_type), intent(inout) :: stages(:)
      integer :: m, s, dynamic

      dynamic = findloc(stages%static, .false., 1)
      if (dynamic == 0) return
      do m = 1, size(stages(1)%begins)
         if (.not. any([(stages(s)%begins(m), s=1, size(stages))])) &
            stages(dynamic)%begins(m) = .true.
      end do
   end subroutine begin_other_motions

   !> Deactivate fixed points and loads until the stage that adds them.
   pure subroutine wait_for_stages(model)
      type(model_type), intent(inout) :: model  !< model with all its stages
      integer :: s, i

      do s = 1, size(model%stages)
         associate (n => size(model%bolts), added => model%stages(s)%added)
            model%bolts%present = model%bolts%present .and. .not. added(:n)
            model%edge_loads%present = model%edge_loads%present .and. .not. added(n + 1:)
         end associate
         do i = 1, size(model%fixed_points)
            associate (point => model%fixed_points(i))
               if (.not. model%stages(s)%holds(i)) cycle
               point%waiting = point%fixed_along
               point%fixed_along = .false.
            end associate
         end do
         do i = 1, size(model%loads)
            if (model%stages(s)%loads(i)) model%loads(i)%start = never
         end do
      end do
   end subroutine wait_for_stages

   !> Copy the settings of the first dynamic stage to `control`, for the checks.
   pure subroutine begin_control(model)
      type(model_type), intent(inout) :: model  !< model as read from the input
      integer :: dynamic

      dynamic = findloc(model%stages%static, .false., 1)
      if (dynamic == 0) return
      associate (stage => model%stages(dynamic), control => model%control)
         control%time_step = stage%time_step
         control%step_count = stage%steps
         control%integration = stage%integration
         control%theta = stage%theta
      end associate
   end subroutine begin_control

   !> Read one &stage.
   subroutine read_stage(group, model, s, error)
      type(group_type), intent(in) :: group  !< group of the input
      type(model_type), intent(inout) :: model  !< model as read from the input
      integer, intent(in) :: s  !< number of the stage
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(stage_values) :: input

      call read_values(group, input, error)
      call require_new_name(error, group, input%name, model%stages(:s - 1)%name)
      if (allocated(error)) return
      associate (stage => model%stages(s))
         stage%name = input%name
         stage%static = input%kind == 'static'
         stage%zero_displacements = input%zero_displacements
         stage%displacement = value_or(input%displacement, huge(1.0_wp))
         call set_unchanged_stage(model, stage)
         call set_stepping(stage, input, model%control, group, error)
         call read_lists(model, group, input, stage, error)
      end associate
   end subroutine read_stage

   !> Find the items in the lists of a stage.
   subroutine read_lists(model, group, input, stage, error)
      type(model_type), intent(in) :: model  !< model as read from the input
      type(group_type), intent(in) :: group  !< group of the input
      type(stage_values), intent(in) :: input  !< values of the group
      type(stage_type), intent(inout) :: stage  !< stage to complete
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      character(len=64) :: names(size(stage%added))

      names(:size(model%bolts)) = model%bolts%name
      names(size(model%bolts) + 1:) = model%edge_loads%name
      call mark_names(input%remove, 'remove', model%block_names, group, stage%removed, error)
      call mark_names(input%release, 'release', model%fixed_points%name, group, stage%released, &
         error)
      call mark_names(input%hold, 'hold', model%fixed_points%name, group, stage%holds, error)
      call mark_names(input%loads, 'loads', model%loads%name, group, stage%loads, error)
      call mark_names(input%motions, 'motions', model%motions%name, group, stage%begins, error)
      call mark_names(input%add, 'add', names, group, stage%added, error)
      call mark_names(input%drop, 'drop', names, group, stage%dropped, error)
      call replace_names(group, input%change_joints, 'joint', model%joints%name, stage%joint, error)
      call replace_names(group, input%change_materials, 'material', model%materials%name, &
         stage%material, error)
   end subroutine read_lists

   !> Set number and length of steps, and their integration.
   subroutine set_stepping(stage, input, control, group, error)
      type(stage_type), intent(inout) :: stage  !< stage to complete
      type(stage_values), intent(inout) :: input     !< values of the group
      type(control_type), intent(in) :: control      !< default settings
      type(group_type), intent(in) :: group          !< group of the input
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(control_type) :: settings

      if (allocated(error)) return
      if (stage%static) return
      settings = control
      settings%time_step = value_or(input%time_step, control%time_step)
      call count_steps(error, group, settings%time_step, input%duration, input%steps)
      if (input%integration == '') input%integration = control%integration
      if (given(group, 'integration') .or. is_set(input%theta)) call set_integration(group, &
         trim(input%integration), value_or(input%theta, default_theta), unset, unset, settings, &
            error)
      if (allocated(error)) return
      stage%time_step = settings%time_step
      stage%steps = int(input%steps, long)
      stage%duration = value_or(input%duration, 0.0_wp)
      stage%integration = settings%integration
      stage%theta = settings%theta
   end subroutine set_stepping

   !> Read replacements 'old -> new, old -> new'.
   subroutine replace_names(group, list, kind, names, replacements, error)
      type(group_type), intent(in) :: group          !< group of the input
      character(len=*), intent(in) :: list, kind     !< list as read; 'joint' or 'material'
      character(len=*), intent(in) :: names(:)       !< known names
      integer, intent(inout) :: replacements(:)               !< [names] replacement of each name
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      character(len=:), allocatable :: variable, remainder, entry
      integer :: comma, arrow, from, to

      variable = 'change_'//kind//'s'
      remainder = trim(list)
      do while (len(remainder) > 0 .and. .not. allocated(error))
         comma = index(remainder//',', ',')
         entry = trim(adjustl(remainder(:comma - 1)))
         remainder = trim(remainder(min(comma + 1, len(remainder) + 1):))
         arrow = index(entry, '->')
         if (arrow == 0) call fail_input(error, group, variable//' = '//quoted(entry)// &
            " must have the form 'old -> new'")
         if (allocated(error)) return
         call require_name(error, group, variable, trim(entry(:arrow - 1)), names, kind, from)
         call require_name(error, group, variable, trim(adjustl(entry(arrow + 2:))), names, kind, &
            to)
         if (allocated(error)) return
         replacements(from) = to
      end do
   end subroutine replace_names

   !> Check that no item is removed twice and no motion begins twice.
   subroutine check_history(model, s, group, error)
      type(model_type), intent(in) :: model  !< model as read from the input
      integer, intent(in) :: s  !< stage just read
      type(group_type), intent(in) :: group
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      logical :: removed_so_far(model%blocks%n)
      integer :: k

      if (allocated(error)) return
      if (model%stages(s)%static .and. any(model%stages(s)%begins)) call fail_input(error, group, &
         'motions cannot begin with a static stage, which has no time')
      removed_so_far = model%stages(s)%removed
      do k = 1, s - 1
         associate (before => model%stages(k), now => model%stages(s))
            call refuse_repeated(before%removed .and. now%removed, 'remove: block', &
               model%block_names, 'has been removed in')
            call refuse_repeated(before%holds .and. now%holds, 'hold: fixed point', &
               model%fixed_points%name, 'has been held since')
            call refuse_repeated(before%loads .and. now%loads, 'loads:', model%loads%name, &
               'has begun in')
            call refuse_repeated(before%begins .and. now%begins, 'motions:', model%motions%name, &
               'has begun in')
            removed_so_far = removed_so_far .or. before%removed
         end associate
      end do
      if (all(removed_so_far)) call fail_input(error, group, '`remove` would leave no block')

   contains

      !> Reject a stage that repeats an action of an earlier stage.
      subroutine refuse_repeated(repeated, action, names, verb)
         logical, intent(in) :: repeated(:)          !< [names] named in stage k and in this stage
         character(len=*), intent(in) :: action, names(:), verb  !< action; all names; its verb
         integer :: i

         i = findloc(repeated, .true., 1)
         if (i > 0) call fail_input(error, group, action//' '//quoted(trim(names(i)))//' '// &
            verb//' stage '//quoted(trim(model%stages(k)%name)))
      end subroutine refuse_repeated

   end subroutine check_history

end module dda_input_stages
