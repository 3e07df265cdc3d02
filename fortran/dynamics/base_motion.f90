! SPDX-License-Identifier: GPL-3.0-or-later
!> The motion of the base that displacements, velocities and accelerations count from.
!>
!> It is that of the supports where one translation is the motion of all that hold, now or in a
!> later stage; else that of the measured point which all groups &amplification name as their base;
!> else nothing, and values are absolute.
module dda_base_motion
   use dda_kinds, only: wp
   use dda_baseline, only: displacement_at, velocity_at
   use dda_blocks, only: blocks_type, place_of
   use dda_measure, only: measure_point
   use dda_model, only: model_type
   use dda_scheme, only: step_type, end_rate
   use dda_text, only: quoted
   implicit none
   private
   public :: base_type, base_point, begin_base, renew_base, update_base, base_words, &
      counts_from_motion

   integer, parameter :: base_absolute = 0  !< nothing that all values could count from
   integer, parameter :: base_rests = 1     !< supports that stay
   integer, parameter :: base_moves = 2     !< supports that move alike
   integer, parameter :: base_point = 3     !< a measured point

   real(wp), parameter :: same = 1.0e-9_wp  !< of a motion: rounding of directions

   !> The base and its motion at the present time.
   type :: base_type
      integer :: kind = base_absolute
      integer :: point = 0                      !< measured point, or 0
      real(wp), allocatable :: share(:,:)       !< [2,motions] of each motion in x and y
      !> what counts as no displacement: place of the point, or displacement of the supports, m
      real(wp) :: zero(2) = 0.0_wp
      real(wp) :: displacement(2) = 0.0_wp      !< since counting began, m
      real(wp) :: velocity(2) = 0.0_wp          !< m/s
      real(wp) :: acceleration(2) = 0.0_wp      !< of the last step, m/s²
   end type base_type

contains

   !> The base of a model; displacements count from the present time.
   subroutine begin_base(base, model, blocks, time)
      type(base_type), intent(out) :: base       !< of the model
      type(model_type), intent(in) :: model      !< of the run
      type(blocks_type), intent(in) :: blocks    !< in their present state
      real(wp), intent(in) :: time               !< s

      allocate (base%share(2, size(model%motions)), source=0.0_wp)
      call renew_base(base, model, blocks, time)
   end subroutine begin_base

   !> Supports or motions have changed: the displacement goes on from its present value.
   subroutine renew_base(base, model, blocks, time)
      type(base_type), intent(inout) :: base     !< of the model
      type(model_type), intent(in) :: model      !< of the run
      type(blocks_type), intent(in) :: blocks    !< in their present state
      real(wp), intent(in) :: time               !< s
      real(wp) :: unused(2, 2)

      call find_base(base, model)
      base%velocity = 0.0_wp
      select case (base%kind)
      case (base_moves)
         base%zero = moved(base, model, time) - base%displacement
         base%velocity = moving(base, model, time)
      case (base_point)
         associate (point => model%points(base%point))
            base%zero = place_of(blocks, point%block, point%reference) - base%displacement
            call measure_point(blocks, point, unused(:, 1), base%velocity, unused(:, 2))
         end associate
      end select
   end subroutine renew_base

   !> What all supports that hold have in common: the translation Σ share u of the motions u that
   !> has their components along the directions held, by least squares.
   pure subroutine find_base(base, model)
      type(base_type), intent(inout) :: base     !< gets its kind and its shares
      type(model_type), intent(in) :: model      !< of the run
      real(wp) :: matrix(2, 2), right(2, size(model%motions))
      integer :: i, axis, holding

      matrix = 0.0_wp
      right = 0.0_wp
      holding = 0
      do i = 1, size(model%fixed_points)
         associate (point => model%fixed_points(i))
            do axis = 1, 2
               if (.not. (point%held(axis) .or. point%waiting(axis))) cycle
               holding = holding + 1
               associate (n => point%axes(:, axis), m => point%motion(axis))
                  matrix = matrix + spread(n, 2, 2)*spread(n, 1, 2)
                  if (m > 0) right(:, m) = right(:, m) + n
               end associate
            end do
         end associate
      end do
      base%share = matmul(inverse_of(matrix), right)
      base%kind = base_rests
      if (any(abs(right) > 0.0_wp)) base%kind = base_moves
      if (holding == 0 .or. .not. agree(base, model)) base%kind = base_absolute
      base%point = named_point(model)
      if (base%kind == base_absolute .and. base%point > 0) base%kind = base_point
   end subroutine find_base

   !> The Moore–Penrose inverse of a sum of dyads n nᵀ of unit vectors.
   pure function inverse_of(matrix) result(inverse)
      real(wp), intent(in) :: matrix(2, 2)  !< symmetric, not negative
      real(wp) :: inverse(2, 2), trace, determinant

      trace = matrix(1, 1) + matrix(2, 2)
      determinant = matrix(1, 1)*matrix(2, 2) - matrix(1, 2)*matrix(2, 1)
      if (determinant > same*trace**2) then
         inverse = reshape([matrix(2, 2), -matrix(2, 1), -matrix(1, 2), matrix(1, 1)], [2, 2]) &
            /determinant
      else
         inverse = matrix/max(trace, 1.0_wp)**2
      end if
   end function inverse_of

   !> Every support that holds moves as the base does.
   pure logical function agree(base, model)
      type(base_type), intent(in) :: base        !< with its shares
      type(model_type), intent(in) :: model      !< of the run
      integer :: i, axis, m

      agree = .true.
      do i = 1, size(model%fixed_points)
         associate (point => model%fixed_points(i))
            do axis = 1, 2
               if (.not. (point%held(axis) .or. point%waiting(axis))) cycle
               do m = 1, size(model%motions)
                  agree = agree .and. abs(dot_product(point%axes(:, axis), base%share(:, m)) &
                     - merge(1.0_wp, 0.0_wp, m == point%motion(axis))) <= same
               end do
            end do
         end associate
      end do
   end function agree

   !> The measured point that all groups &amplification name as their base; 0 without one.
   pure integer function named_point(model) result(point)
      type(model_type), intent(in) :: model      !< of the run

      point = 0
      if (size(model%amplifications) == 0) return
      point = model%amplifications(1)%base
      if (any(model%amplifications%base /= point)) point = 0
   end function named_point

   !> Its motion at the end of a step, as supports have it (`dda_spring_element`).
   subroutine update_base(base, model, blocks, step, time)
      type(base_type), intent(inout) :: base     !< of the model
      type(model_type), intent(in) :: model      !< of the run
      type(blocks_type), intent(in) :: blocks    !< at the end of the step
      type(step_type), intent(in) :: step        !< the one taken
      real(wp), intent(in) :: time               !< of its end, s
      real(wp) :: before(2), velocity(2), unused(2)

      select case (base%kind)
      case (base_moves)
         before = base%displacement
         base%displacement = moved(base, model, time) - base%zero
         velocity = moving(base, model, time)
         if (step%scheme%chi > 0.5_wp) velocity = end_rate(step, base%displacement - before, &
            base%velocity)
         base%acceleration = (velocity - base%velocity)/step%time_step
         base%velocity = velocity
      case (base_point)
         associate (point => model%points(base%point))
            call measure_point(blocks, point, unused, base%velocity, base%acceleration)
            base%displacement = place_of(blocks, point%block, point%reference) - base%zero
         end associate
      end select
   end subroutine update_base

   !> Displacement of the supports at a time, m.
   pure function moved(base, model, time)
      type(base_type), intent(in) :: base        !< supports that move
      type(model_type), intent(in) :: model      !< of the run
      real(wp), intent(in) :: time               !< s
      real(wp) :: moved(2)
      integer :: m

      moved = 0.0_wp
      do m = 1, size(model%motions)
         if (any(base%share(:, m) /= 0.0_wp)) moved = moved + base%share(:, m) &
            *displacement_at(model%motions(m)%curve, time)
      end do
   end function moved

   !> Velocity of the supports at a time, m/s.
   pure function moving(base, model, time)
      type(base_type), intent(in) :: base        !< supports that move
      type(model_type), intent(in) :: model      !< of the run
      real(wp), intent(in) :: time               !< s
      real(wp) :: moving(2)
      integer :: m

      moving = 0.0_wp
      do m = 1, size(model%motions)
         if (any(base%share(:, m) /= 0.0_wp)) moving = moving + base%share(:, m) &
            *velocity_at(model%motions(m)%curve, time)
      end do
   end function moving

   !> It is worth saying what values count from: something moves the model.
   pure logical function counts_from_motion(base, model)
      type(base_type), intent(in) :: base        !< of the model
      type(model_type), intent(in) :: model      !< of the run

      counts_from_motion = base%kind /= base_rests .and. size(model%motions) > 0
   end function counts_from_motion

   !> Words on the origin that values count from.
   pure function base_words(base, model) result(words)
      type(base_type), intent(in) :: base        !< of the model
      type(model_type), intent(in) :: model      !< of the run
      character(len=:), allocatable :: words

      select case (base%kind)
      case (base_rests)
         words = 'relative to the supports, which do not move'
      case (base_moves)
         words = 'relative to the moving supports'
      case (base_point)
         words = 'relative to the point '//quoted(trim(model%points(base%point)%name))
      case default
         words = 'absolute, since nothing holds the model'
         if (size(model%fixed_points) > 0) words = 'absolute, since supports move differently'
         if (size(model%amplifications) == 0) words = words// &
            ' and no &amplification names a base'
      end select
   end function base_words

end module dda_base_motion
