! SPDX-License-Identifier: GPL-3.0-or-later
!> Text on the properties that a picture does not show: elastic law of the blocks, and motions.
module dda_model_description
   use dda_kinds, only: wp
   use dda_baseline, only: motion_curve_type
   use dda_model, only: model_type
   use dda_motion, only: motion_type
   use dda_text, only: quoted, short_text
   implicit none
   private
   public :: model_description

   integer, parameter :: line_length = 400
   real(wp), parameter :: peak_rounding = 1.0e-14_wp  !< largest relative rounding error of a peak

contains

   !> Text: one line on the elastic law, and one line per motion.
   pure function model_description(model) result(lines)
      type(model_type), intent(in) :: model  !< model as read from the input
      character(len=line_length), allocatable :: lines(:)
      integer :: i

      allocate (lines(1 + size(model%motions)))
      lines(1) = 'analysis: '//merge('plane strain', 'plane stress', model%control%plane_strain)
      if (.not. model%control%analysis_given) lines(1) = trim(lines(1))//' (the default)'
      do i = 1, size(model%motions)
         lines(i + 1) = motion_text(model%motions(i), any(model%control%base_motion == i))
      end do
   end function model_description

   !> Text on a motion: peaks, removed drift, final values and continuation.
   pure function motion_text(motion, as_body_force) result(text)
      type(motion_type), intent(in) :: motion   !< motion of the model
      logical, intent(in) :: as_body_force      !< the acceleration acts in the frame of the base
      character(len=:), allocatable :: text
      real(wp) :: peaks(3)

      associate (curve => motion%curve)
         peaks = peaks_of(curve)
         text = 'motion '//quoted(trim(motion%name))//': PGA '//short_text(peaks(1))// &
            ' m/s², PGV '//short_text(peaks(2))//' m/s, PGD '//short_text(peaks(3))//' m; '
         if (any(curve%removed > 0.0_wp)) then
            text = text//'drift removal changed it by up to '//short_text(curve%removed(1))// &
               ' m/s and '//short_text(curve%removed(2))//' m; '
         else
            text = text//'no drift removed; '
         end if
         text = text//'ends with '//short_text(final_velocity(curve))//' m/s at '// &
            short_text(final_place(curve))//' m'//motion_end_text(curve, as_body_force)
         if (abs(curve%cut_velocity) > 0.0_wp) text = text//' (its last two samples move at '// &
            short_text(curve%cut_velocity)//" m/s: after_end = 'continue' keeps this velocity)"
      end associate
   end function motion_text

   !> Text on the continuation of a motion after its last sample.
   pure function motion_end_text(curve, as_body_force) result(text)
      type(motion_curve_type), intent(in) :: curve  !< curve of the motion
      logical, intent(in) :: as_body_force  !< the acceleration acts in the frame of the base
      character(len=:), allocatable :: text

      if (as_body_force) then
         text = ', without a body force afterwards'
      else if (abs(curve%velocity_after) > 0.0_wp) then
         text = ' and continues with this velocity'
      else if (abs(final_velocity(curve)) > 0.0_wp) then
         text = ' and is stopped there within a step, which is an impact'
      else
         text = ' and is held there'
      end if
   end function motion_end_text

   !> Velocity at the last sample, m/s; values within rounding are 0.
   pure real(wp) function final_velocity(curve)
      type(motion_curve_type), intent(in) :: curve  !< curve of a motion

      final_velocity = curve%velocity(size(curve%velocity))
      if (curve%ends_at_rest) final_velocity = 0.0_wp
   end function final_velocity

   !> Displacement at the last sample, m; values within rounding are 0.
   pure real(wp) function final_place(curve)
      type(motion_curve_type), intent(in) :: curve  !< curve of a motion

      final_place = curve%displacement(size(curve%displacement))
      if (abs(final_place) < peak_rounding*max(maxval(abs(curve%displacement)), curve%removed(2))) &
         final_place = 0.0_wp
   end function final_place

   !> Largest acceleration (m/s²), velocity (m/s) and displacement (m); values within rounding of
   !> the others are 0.
   pure function peaks_of(curve) result(peaks)
      type(motion_curve_type), intent(in) :: curve  !< curve of a motion
      real(wp) :: peaks(3), rounding(3)

      peaks = [maxval(abs(curve%acceleration)), maxval(abs(curve%velocity)), &
         maxval(abs(curve%displacement))]
      if (.not. curve%time_step > 0.0_wp) return
      associate (step => curve%time_step, whole => curve%duration, velocity => max(peaks(2), &
         curve%removed(1)), displacement => max(peaks(3), curve%removed(2)))
         rounding = peak_rounding*[max(velocity/step, displacement/step**2), max(peaks(1)*whole, &
            displacement/step), max(peaks(1)*whole**2, velocity*whole, displacement)]
      end associate
      where (peaks < rounding) peaks = 0.0_wp
   end function peaks_of

end module dda_model_description
