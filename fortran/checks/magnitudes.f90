! SPDX-License-Identifier: GPL-3.0-or-later
!> Notes on input values that probably have wrong units, or that have no effect.
module dda_magnitudes
   use dda_edge_load, only: load_level, load_surface
   use dda_kinds, only: wp, long
   use dda_model, only: half_size, model_type, run_steps
   use dda_text, only: quoted, short_text, to_text
   implicit none
   private
   public :: magnitude_notes, note_length

   integer, parameter :: note_length = 320  !< largest length of a note, bytes
   real(wp), parameter :: max_gravity = 30.0_wp   !< largest plausible value: 3 g, m/s²
   !> range of values that may be unit weights of soil or rock in kN/m³, or densities of geofoam in
   !> kg/m³
   real(wp), parameter :: unit_weights(2) = [10.0_wp, 40.0_wp]
   real(wp), parameter :: foam_moduli(2) = [1.0e5_wp, 1.0e8_wp]  !< Young's modulus of geofoam, Pa
   real(wp), parameter :: min_strength = 100.0_wp  !< less than the stress under 1 cm of soil, Pa
   real(wp), parameter :: max_acceleration = 45.0_wp  !< largest recorded value, m/s²
   real(wp), parameter :: largest_model = 5000.0_wp    !< m
   real(wp), parameter :: few_steps = 10.0_wp  !< smallest plausible number of steps in a motion
   real(wp), parameter :: max_speed = 40.0_wp     !< larger than speeds of falling rock, m/s
   real(wp), parameter :: max_rotation = 0.1_wp    !< largest rotation per step, rad (cosine 0.995)
   !> largest water level above the model/model height
   real(wp), parameter :: highest_head = 10.0_wp
   real(wp), parameter :: deepest_bed = 0.05_wp   !< largest settlement/model height

contains

   !> Notes on values, one per line.
   function magnitude_notes(model) result(notes)
      type(model_type), intent(in) :: model  !< model as read from the input
      character(len=note_length), allocatable :: notes(:)
      integer :: i

      allocate (notes(0))
      call note_control(model, notes)
      do i = 1, size(model%materials)
         call note_material(model, i, notes)
      end do
      do i = 1, size(model%joints)
         associate (joint => model%joints(i))
            call note_strength('cohesion', joint%cohesion, joint%name, notes)
            call note_strength('tensile_strength', joint%tensile_strength, joint%name, notes)
         end associate
      end do
      do i = 1, size(model%motions)
         call note_motion(model, i, notes)
      end do
      do i = 1, size(model%edge_loads)
         call note_water(model, i, notes)
      end do
      call note_settlement(model, notes)
      i = findloc(model%boundaries%kind == 'compliant', .true., 1)
      if (i == 0) return
      call note_if(notes, all(model%boundaries(i)%motion == 0), &
         'the compliant &boundary has no '// &
         "motion, so no waves enter through it. Set motion_x or motion_y, or use kind = 'viscous'")
   end function magnitude_notes

   !> Add a note if a condition is .true.
   pure subroutine note_if(notes, condition, text)
      character(len=note_length), allocatable, intent(inout) :: notes(:)  !< notes so far
      logical, intent(in) :: condition       !< condition of the note
      character(len=*), intent(in) :: text  !< text of the note

      if (condition) notes = [character(len=note_length) :: notes, text]
   end subroutine note_if

   !> Check gravity, sizes and output.
   subroutine note_control(model, notes)
      type(model_type), intent(in) :: model  !< model as read from the input
      character(len=note_length), allocatable, intent(inout) :: notes(:)  !< notes so far
      real(wp) :: g(2), width
      integer(long) :: steps, interval

      g = model%control%gravity
      width = 2.0_wp*half_size(model%blocks)
      steps = run_steps(model)
      interval = model%output%history_interval
      call note_if(notes, norm2(g) > max_gravity, 'gravity = '//short_text(g(1))//', '// &
         short_text(g(2))//' m/s²: is it meant in cm/s² or mm/s²? On Earth it is 0, -9.81')
      call note_if(notes, abs(g(1)) > 0.0_wp .and. .not. abs(g(2)) > 0.0_wp, 'gravity = '// &
         short_text(g(1))//', 0 m/s² acts only along x; the second value is vertical: 0, -9.81')
      call note_if(notes, width > largest_model, 'the model is '//short_text(width)// &
         ' m wide or high; lengths must be in m, not in mm')
      call note_if(notes, steps > 0 .and. interval > steps, 'history_interval = '// &
         to_text(interval)//' of &output is more than the '//to_text(steps)//' steps of the run'// &
         ': histories contain only its start and end')
      call note_if(notes, size(model%free_fields) == 1, 'only one side has a free field: give '// &
         'both sides one, or neither')
   end subroutine note_control

   !> Check density and initial velocity of a material, and yielding of a block without mesh.
   subroutine note_material(model, i, notes)
      type(model_type), intent(in) :: model  !< model as read from the input
      integer, intent(in) :: i               !< material
      character(len=note_length), allocatable, intent(inout) :: notes(:)  !< notes so far
      character(len=:), allocatable :: subject
      logical :: yields
      real(wp) :: speed, rotation

      associate (material => model%materials(i), yields_alone => model%blocks%material == i)
         subject = '&material '//quoted(trim(material%name))
         yields = material%yields()
         speed = norm2(material%initial_velocity(1:2))
         rotation = abs(material%initial_velocity(3))*model%control%time_step
         call note_if(notes, speed > max_speed, 'initial_velocity of '//subject//' is '// &
            short_text(speed)//' m/s, faster than falling rock')
         call note_if(notes, rotation > max_rotation, 'initial_velocity of '//subject// &
            ' turns its blocks by '//short_text(rotation)// &
            ' rad per step; check the third value (rad/s), or use a smaller time_step')
         call note_if(notes, material%density >= unit_weights(1) .and. material%density < &
            unit_weights(2) .and. (material%young_modulus < foam_moduli(1) .or. &
            material%young_modulus > foam_moduli(2)), 'density = '// &
            short_text(material%density)//' kg/m³ of '//subject//': is it a unit weight in '// &
            'kN/m³? That would be '//short_text(1000.0_wp*material%density/9.81_wp)//' kg/m³')
         call note_if(notes, yields .and. count(yields_alone) == 1 .and. &
            any(yields_alone .and. model%blocks%body == 0), subject//' yields, but '// &
            'its block has uniform strain and yields as a whole; mesh the block (&mesh)')
      end associate
   end subroutine note_material

   !> Check for strengths that are almost zero.
   pure subroutine note_strength(variable, value, joint, notes)
      character(len=*), intent(in) :: variable, joint  !< names in the input
      real(wp), intent(in) :: value                    !< Pa
      character(len=note_length), allocatable, intent(inout) :: notes(:)  !< notes so far

      call note_if(notes, value > 0.0_wp .and. value < min_strength, variable//' = '// &
         short_text(value)//' Pa of &joint '//quoted(trim(joint))//' is almost zero: is it '// &
         'meant in kPa or MPa?')
   end subroutine note_strength

   !> Check acceleration and length of a motion.
   subroutine note_motion(model, i, notes)
      type(model_type), intent(in) :: model  !< model as read from the input
      integer, intent(in) :: i               !< motion
      character(len=note_length), allocatable, intent(inout) :: notes(:)  !< notes so far
      real(wp) :: peak_acceleration

      associate (motion => model%motions(i), step => model%control%time_step)
         if (.not. allocated(motion%curve%acceleration)) return
         peak_acceleration = maxval(abs(motion%curve%acceleration))
         call note_if(notes, peak_acceleration > max_acceleration .and. motion%file /= '', &
            'motion '//quoted(trim(motion%name))//': PGA = '//short_text(peak_acceleration)// &
            ' m/s² is '//short_text(peak_acceleration/9.81_wp)//' g: is the record in gal '// &
            '(cm/s²), or scaled twice?')
         call note_if(notes, motion%curve%duration < few_steps*step .and. motion%file /= '', &
            'motion '//quoted(trim(motion%name))//' lasts '//short_text(motion%curve%duration)// &
            ' s, fewer than ten steps of time_step = '//short_text(step)//' s')
      end associate
   end subroutine note_motion

   !> Check for water levels far above the model, or below the whole model.
   pure subroutine note_water(model, i, notes)
      type(model_type), intent(in) :: model  !< model as read from the input
      integer, intent(in) :: i               !< load on edges
      character(len=note_length), allocatable, intent(inout) :: notes(:)  !< notes so far
      character(len=:), allocatable :: subject
      real(wp) :: level, lowest, highest

      associate (load => model%edge_loads(i))
         if (all(load%kind /= [load_level, load_surface])) return
         lowest = minval(model%blocks%vertex(2, :))
         highest = maxval(model%blocks%vertex(2, :))
         level = maxval(load%level)
         if (load%kind == load_surface) level = level + maxval(load%line(2, :))
         subject = trim(merge('&traction', '&water   ', load%kind == load_level))
         if (load%name /= '') subject = subject//' '//quoted(trim(load%name))
         call note_if(notes, level > highest + highest_head*(highest - lowest), subject// &
            ' reaches up to '//short_text(level - highest)//' m above the model, which is '// &
            short_text(highest - lowest)//' m high: are its levels in m, along y?')
         call note_if(notes, level <= lowest, &
            subject//' has no effect, because the water is below the model')
      end associate
   end subroutine note_water

   !> Check the settlement of the model under its weight on a bed of springs.
   pure subroutine note_settlement(model, notes)
      type(model_type), intent(in) :: model  !< model as read from the input
      character(len=note_length), allocatable, intent(inout) :: notes(:)  !< notes so far
      real(wp) :: stiffness, depth, height, weight(2), fraction
      integer :: i, axis

      weight = sum(model%blocks%mass)*model%control%gravity
      if (.not. norm2(weight) > 0.0_wp .or. size(model%boundaries) > 0) return
      stiffness = 0.0_wp
      do i = 1, size(model%fixed_points)
         associate (point => model%fixed_points(i))
            do axis = 1, 2
               fraction = dot_product(point%axes(:, axis), weight/norm2(weight))**2
               if (.not. (point%fixed_along(axis) .and. fraction > 0.0_wp)) cycle
               if (.not. point%stiffness > 0.0_wp) return
               stiffness = stiffness + fraction*point%stiffness
            end do
         end associate
      end do
      if (.not. stiffness > 0.0_wp) return
      depth = norm2(weight)/stiffness
      height = maxval(model%blocks%vertex(2, :)) - minval(model%blocks%vertex(2, :))
      call note_if(notes, depth > deepest_bed*height, 'the weight presses the model about '// &
         short_text(depth)//' m into its bed of springs: is stiffness_per_area meant in '// &
         'kPa/m or MPa/m?')
   end subroutine note_settlement

end module dda_magnitudes
