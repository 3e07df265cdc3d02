! SPDX-License-Identifier: GPL-3.0-or-later
!> Base motion relative to which displacements, velocities and accelerations are reported.
!>
!> The base motion is the first of these that exists:
!>
!> - the motion of the supports, if all supports of this and later stages have one translation;
!> - the motion of the measured point that all groups &amplification name as base;
!> - the outcrop motion of the half-space below, if a single motion enters through its boundaries.
!>
!> Otherwise, values are absolute.
module dda_base_motion
   use dda_kinds, only: wp
   use dda_baseline, only: displacement_at, velocity_at
   use dda_blocks, only: blocks_type, position_of
   use dda_measure, only: measure_point
   use dda_model, only: model_type
   use dda_scheme, only: step_type, end_rate
   use dda_text, only: quoted
   implicit none
   private
   public :: base_type, base_kinds, begin_base, renew_base, update_base, base_text, &
      has_reference_motion

   integer, parameter :: base_absolute = 0  !< no base: values are absolute
   integer, parameter :: base_rests = 1     !< supports that do not move
   integer, parameter :: base_moves = 2     !< supports with one common motion
   integer, parameter :: base_point = 3     !< a measured point
   integer, parameter :: base_outcrop = 4   !< an outcrop of the half-space below
   integer, parameter :: base_kinds = base_outcrop  !< number of the last kind

   real(wp), parameter :: surface_factor = 2.0_wp !< ratio of free-surface motion to the upward wave
   !> rounding error of a direction vector/its length
   real(wp), parameter :: rounding = 1.0e-9_wp

   !> The base and its motion at the present time.
   type :: base_type
      integer :: kind = base_absolute           !< one of the kinds above
      integer :: point = 0                      !< measured point, or 0
      !> [2,motions] coefficient of each motion in x and y
      real(wp), allocatable :: coefficient(:,:)
      !> origin of displacements: position of the point, or displacement of the supports, m
      real(wp) :: zero(2) = 0.0_wp
      real(wp) :: displacement(2) = 0.0_wp      !< displacement since `begin_base`, m
      real(wp) :: velocity(2) = 0.0_wp          !< m/s
      real(wp) :: acceleration(2) = 0.0_wp      !< acceleration of the last step, m/s²
   end type base_type

contains

   !> Set the base of a model; displacements are measured from the present time.
   subroutine begin_base(base, model, blocks, time)
      type(base_type), intent(out) :: base       !< base of the model
      type(model_type), intent(in) :: model      !< model of the run
      type(blocks_type), intent(in) :: blocks    !< blocks in their present state
      real(wp), intent(in) :: time               !< s

      allocate (base%coefficient(2, size(model%motions)), source=0.0_wp)
      call renew_base(base, model, blocks, time)
   end subroutine begin_base

   !> Update the base after supports or motions have changed; its displacement does not jump.
   subroutine renew_base(base, model, blocks, time)
      type(base_type), intent(inout) :: base     !< base of the model
      type(model_type), intent(in) :: model      !< model of the run
      type(blocks_type), intent(in) :: blocks    !< blocks in their present state
      real(wp), intent(in) :: time               !< s
      real(wp) :: motion(2, 2), unused(2, 2)

      call find_base(base, model)
      base%velocity = 0.0_wp
      select case (base%kind)
      case (base_moves, base_outcrop)
         motion = motion_at(base, model, time)
         base%zero = motion(:, 1) - base%displacement
         base%velocity = motion(:, 2)
      case (base_point)
         associate (point => model%points(base%point))
            base%zero = position_of(blocks, point%block, point%reference) - base%displacement
            call measure_point(blocks, point, unused(:, 1), base%velocity, unused(:, 2))
         end associate
      end select
   end subroutine renew_base

   !> Find the common translation of all supports as a linear combination of the motions.
   !> Its components along the supported directions fit the support motions by least squares.
   pure subroutine find_base(base, model)
      type(base_type), intent(inout) :: base     !< kind and coefficients are set
      type(model_type), intent(in) :: model      !< model of the run
      real(wp) :: matrix(2, 2), right(2, size(model%motions))
      integer :: i, axis, holding

      matrix = 0.0_wp
      right = 0.0_wp
      holding = 0
      do i = 1, size(model%fixed_points)
         associate (point => model%fixed_points(i))
            do axis = 1, 2
               if (.not. (point%fixed_along(axis) .or. point%waiting(axis))) cycle
               holding = holding + 1
               associate (n => point%axes(:, axis), m => point%motion(axis))
                  matrix = matrix + spread(n, 2, 2)*spread(n, 1, 2)
                  if (m > 0) right(:, m) = right(:, m) + n
               end associate
            end do
         end associate
      end do
      base%coefficient = matmul(pseudo_inverse(matrix), right)
      base%kind = base_rests
      if (any(abs(right) > 0.0_wp)) base%kind = base_moves
      if (holding == 0 .or. .not. all_follow(base, model)) base%kind = base_absolute
      base%point = named_point(model)
      if (base%kind /= base_absolute) return
      if (base%point > 0) then
         base%kind = base_point
      else
         call find_outcrop(base, model)
      end if
   end subroutine find_base

   !> Find the outcrop motion, if the same motion enters from all half-spaces.
   pure subroutine find_outcrop(base, model)
      type(base_type), intent(inout) :: base     !< kind and coefficients are set
      type(model_type), intent(in) :: model      !< model of the run
      integer :: i, axis, first

      first = 0
      do i = 1, size(model%boundary_motions)
         associate (own => model%boundary_motions(i))
            if (own%field > 0) cycle
            if (first == 0) first = i
            if (any(own%motion /= model%boundary_motions(first)%motion) .or. &
               abs(own%factor - model%boundary_motions(first)%factor) > 0.0_wp) return
         end associate
      end do
      if (first == 0) return
      base%kind = base_outcrop
      base%coefficient = 0.0_wp
      do axis = 1, 2
         associate (own => model%boundary_motions(first))
            if (own%motion(axis) > 0) base%coefficient(axis, own%motion(axis)) &
               = surface_factor*own%factor
         end associate
      end do
   end subroutine find_outcrop

   !> Return the Moore–Penrose inverse of a sum of dyads n nᵀ of unit vectors.
   pure function pseudo_inverse(matrix) result(inverse)
      real(wp), intent(in) :: matrix(2, 2)  !< symmetric, positive semi-definite
      real(wp) :: inverse(2, 2), trace, determinant

      trace = matrix(1, 1) + matrix(2, 2)
      determinant = matrix(1, 1)*matrix(2, 2) - matrix(1, 2)*matrix(2, 1)
      if (determinant > rounding*trace**2) then
         inverse = reshape([matrix(2, 2), -matrix(2, 1), -matrix(1, 2), matrix(1, 1)], [2, 2]) &
            /determinant
      else
         inverse = matrix/max(trace, 1.0_wp)**2
      end if
   end function pseudo_inverse

   !> .true. if the motion of every support is the motion of the base.
   pure logical function all_follow(base, model)  ! total
      type(base_type), intent(in) :: base        !< base with its coefficients
      type(model_type), intent(in) :: model      !< model of the run
      integer :: i, axis, m

      all_follow = .true.
      do i = 1, size(model%fixed_points)
         associate (point => model%fixed_points(i))
            do axis = 1, 2
               if (.not. (point%fixed_along(axis) .or. point%waiting(axis))) cycle
               do m = 1, size(model%motions)
                  all_follow = all_follow .and. abs(dot_product(point%axes(:, axis), &
                     base%coefficient(:, m)) - merge(1.0_wp, 0.0_wp, &
                        m == point%motion(axis))) <= rounding
               end do
            end do
         end associate
      end do
   end function all_follow

   !> Find the measured point that all groups &amplification name as base; 0 if there is none.
   pure integer function named_point(model) result(point)
      type(model_type), intent(in) :: model      !< model of the run

      point = 0
      if (size(model%amplifications) == 0) return
      point = model%amplifications(1)%base
      if (any(model%amplifications%base /= point)) point = 0
   end function named_point

   !> Update the motion of the base at the end of a step, as for supports (dda_spring_element).
   subroutine update_base(base, model, blocks, step, time)
      type(base_type), intent(inout) :: base     !< base of the model
      type(model_type), intent(in) :: model      !< model of the run
      type(blocks_type), intent(in) :: blocks    !< blocks at the end of the step
      type(step_type), intent(in) :: step        !< the present step
      real(wp), intent(in) :: time               !< time at the end of the step, s
      real(wp) :: former(2), motion(2, 2), unused(2)

      select case (base%kind)
      case (base_moves, base_outcrop)
         former = base%displacement
         motion = motion_at(base, model, time)
         base%displacement = motion(:, 1) - base%zero
         if (step%scheme%chi > 0.5_wp) motion(:, 2) = end_rate(step, base%displacement - former, &
            base%velocity)
         base%acceleration = (motion(:, 2) - base%velocity)/step%time_step
         base%velocity = motion(:, 2)
      case (base_point)
         associate (point => model%points(base%point))
            call measure_point(blocks, point, unused, base%velocity, base%acceleration)
            base%displacement = position_of(blocks, point%block, point%reference) - base%zero
         end associate
      end select
   end subroutine update_base

   !> Return the displacement, m, and velocity, m/s, of the supports at a time.
   pure function motion_at(base, model, time) result(motion)
      type(base_type), intent(in) :: base        !< base of kind `base_moves`
      type(model_type), intent(in) :: model      !< model of the run
      real(wp), intent(in) :: time               !< s
      real(wp) :: motion(2, 2)
      integer :: m

      motion = 0.0_wp
      do m = 1, size(model%motions)
         if (.not. any(base%coefficient(:, m) /= 0.0_wp)) cycle
         associate (coefficient => base%coefficient(:, m), curve => model%motions(m)%curve)
            motion(:, 1) = motion(:, 1) + coefficient*displacement_at(curve, time)
            motion(:, 2) = motion(:, 2) + coefficient*velocity_at(curve, time)
         end associate
      end do
   end function motion_at

   !> .true. if motions act on the model; reports then name the reference motion.
   pure logical function has_reference_motion(base, model)
      type(base_type), intent(in) :: base        !< base of the model
      type(model_type), intent(in) :: model      !< model of the run

      has_reference_motion = base%kind /= base_rests .and. size(model%motions) > 0
   end function has_reference_motion

   !> Return a text on the reference of reported displacements, velocities and accelerations.
   pure function base_text(base, model) result(text)
      type(base_type), intent(in) :: base        !< base of the model
      type(model_type), intent(in) :: model      !< model of the run
      character(len=:), allocatable :: text

      select case (base%kind)
      case (base_rests)
         text = 'relative to the supports, which do not move'
      case (base_moves)
         text = 'relative to the moving supports'
      case (base_point)
         text = 'relative to the point '//quoted(trim(model%points(base%point)%name))
      case (base_outcrop)
         text = 'relative to the outcrop motion of its base'
      case default
         text = 'absolute: the model has no supports'
         if (size(model%fixed_points) > 0) text = 'absolute: supports move differently'
         if (size(model%amplifications) == 0) text = text// &
            ' and no &amplification names a base'
      end select
   end function base_text

end module dda_base_motion
