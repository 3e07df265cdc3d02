! SPDX-License-Identifier: GPL-3.0-or-later
!> Rigid-body modes of unsupported parts of a model, in closed form.
!>
!> Blocks joined by springs form parts.  Up to three rigid motions of a part are not restrained by
!> its supports; they are exact null vectors of the linearised stiffness.
module dda_rigid_modes
   use dda_kinds, only: wp
   use dda_deflation, only: null_space_type
   use dda_dense_eigen, only: symmetric_eigen
   use dda_errors, only: error_type
   use dda_linear_model, only: linear_model_type, stiffness_weights
   use dda_linear_terms, only: blocks_in, get_row
   implicit none
   private
   public :: find_rigid_modes

   real(wp), parameter :: nothing = 1.0e-12_wp !< stiffness that counts as zero over the largest one

contains

   !> Find the connected parts of a model and their unrestrained rigid motions.
   subroutine find_rigid_modes(linear, free, error)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      type(null_space_type), intent(out) :: free  !< parts and their free rigid motions
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      real(wp), allocatable :: motion(:,:,:)

      call find_parts(linear, free)
      call rigid_motions(linear, free, motion)
      call retain_unrestrained(linear, free, motion, error)
   end subroutine find_rigid_modes

   !> Number the connected parts of the model.
   subroutine find_parts(linear, free)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      type(null_space_type), intent(inout) :: free  !< parts and their free rigid motions
      integer :: parent(linear%n), roots(2), i, b, k
      real(wp) :: row(6)

      parent = [(b, b=1, linear%n)]
      do i = 1, linear%terms%n
         associate (term => linear%terms%term(i))
            do k = 2, blocks_in(term)
               call get_row(term, k, b, row)
               roots = [find_root(parent, term%block_a), find_root(parent, b)]
               ! The first block of a part is its root.
               parent(maxval(roots)) = minval(roots)
            end do
         end associate
      end do
      allocate (free%group(linear%n))
      free%groups = 0
      do b = 1, linear%n
         if (parent(b) == b) free%groups = free%groups + 1
         free%group(b) = free%groups
         if (parent(b) < b) free%group(b) = free%group(parent(b))
      end do
   end subroutine find_parts

   !> Find the root of the part of a block, and shorten the path to it.
   integer function find_root(parent, b) result(root)
      integer, intent(inout) :: parent(:)  !< [n] another block of the same part; root: itself
      integer, intent(in) :: b  !< number of the block

      root = b
      do while (parent(root) /= root)
         parent(root) = parent(parent(root))
         root = parent(root)
      end do
   end function find_root

   !> Compute two translations and the rotation of each part, mass-orthonormal.
   !> Rotation is about the centre of mass.  Blocks removed by a stage are separate parts.
   subroutine rigid_motions(linear, free, motion)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      type(null_space_type), intent(in) :: free  !< parts and their free rigid motions
      real(wp), allocatable, intent(out) :: motion(:,:,:)  !< [6,3,n]
      real(wp) :: mass(free%groups), centre(2, free%groups), inertia(free%groups), arm(2)
      integer :: b

      mass = 0.0_wp
      centre = 0.0_wp
      inertia = 0.0_wp
      do b = 1, linear%n
         associate (g => free%group(b), m => linear%mass(1, 1, b))
            mass(g) = mass(g) + m
            centre(:, g) = centre(:, g) + m*linear%position(:, b)
         end associate
      end do
      centre = centre/spread(mass, 1, 2)
      do b = 1, linear%n
         associate (g => free%group(b))
            arm = linear%position(:, b) - centre(:, g)
            inertia(g) = inertia(g) + linear%mass(3, 3, b) + linear%mass(1, 1, b)*dot_product(arm, &
               arm)
         end associate
      end do
      allocate (motion(6, 3, linear%n), source=0.0_wp)
      do b = 1, linear%n
         associate (g => free%group(b))
            arm = linear%position(:, b) - centre(:, g)
            motion(1, 1, b) = 1.0_wp/sqrt(mass(g))
            motion(2, 2, b) = 1.0_wp/sqrt(mass(g))
            motion(1:3, 3, b) = [-arm(2), arm(1), 1.0_wp]/sqrt(inertia(g))
         end associate
      end do
   end subroutine rigid_motions

   !> Retain the combinations of the rigid motions of each part that its supports do not restrain.
   subroutine retain_unrestrained(linear, free, motion, error)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      type(null_space_type), intent(inout) :: free  !< parts and their free rigid motions
      real(wp), intent(in) :: motion(:,:,:)  !< [6,3,n] rigid motions
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      real(wp) :: resistance(3, 3, free%groups), row(3)
      real(wp), allocatable :: values(:)
      integer :: i, g, b, held

      resistance = 0.0_wp
      do i = 1, linear%terms%n
         associate (term => linear%terms%term(i))
            if (term%block_b > 0 .or. .not. stiffness_weights(term%instant) > 0.0_wp) cycle
            g = free%group(term%block_a)
            row = matmul(term%row_a, motion(:, :, term%block_a))
            resistance(:, :, g) = resistance(:, :, g) + spread(row, 2, 3)*spread(row, 1, 3)
         end associate
      end do
      do g = 1, free%groups
         call symmetric_eigen(resistance(:, :, g), values, error)
         if (allocated(error)) return
         held = count(values > nothing*values(3))
         resistance(:, 4 - held:, g) = 0.0_wp
         free%dimension = free%dimension + 3 - held
      end do
      allocate (free%basis(6, 3, linear%n))
      do b = 1, linear%n
         free%basis(:, :, b) = matmul(motion(:, :, b), resistance(:, :, free%group(b)))
      end do
   end subroutine retain_unrestrained

end module dda_rigid_modes
