! SPDX-License-Identifier: GPL-3.0-or-later
!> Points of welded faces that can break (`dda_material_points`): tractions on the intact face,
!> start of the joint, and its damage, opening and slip.
module dda_crack_points
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type
   use dda_crack_law, only: crack_law_type, is_spent
   use dda_material_points, only: material_points_type, acts, crack_points, places, &
      present_stress, total_strain
   use dda_overlap, only: weight
   use dda_weld_springs, only: n_deformations
   implicit none
   private
   public :: points_force, strength_ratios, begin_crack, crack_damage, crack_motion

contains

   !> Contribution of the points of whole face i to the forces on its deformations at present.
   pure function points_force(self, i, blocks) result(force)
      class(material_points_type), intent(in) :: self  !< elements of this kind
      integer, intent(in) :: i                       !< face
      type(blocks_type), intent(in) :: blocks        !< blocks in their present state
      real(wp) :: force(n_deformations)
      integer :: p, group, k

      force = 0.0_wp
      do group = 0, (self%first_crack - blocks%n)/(2*faces_of(self, blocks)) - 1
         do k = 1, 2
            p = blocks%n + 2*group*faces_of(self, blocks) + 2*(i - 1) + k
            if (acts(self, p, blocks)) force = force + self%area(p)*matmul(present_stress(self, p, &
               blocks), self%map(:, :, p))
         end do
      end do
   end function points_force

   !> Number of welded faces.
   pure integer function faces_of(self, blocks) result(faces)
      class(material_points_type), intent(in) :: self  !< elements with faces that can break
      type(blocks_type), intent(in) :: blocks        !< in any state

      faces = (self%n - self%first_crack)/crack_points
   end function faces_of

   !> Tractions at the points of whole face i for forces on its deformations.
   !> Their ratios to the strength are returned too.
   pure subroutine strength_ratios(self, i, force, traction, ratio)
      class(material_points_type), intent(in) :: self          !< elements of this kind
      integer, intent(in) :: i                               !< face that can break
      real(wp), intent(in) :: force(:)                       !< [deformations]
      real(wp), intent(out) :: traction(2, crack_points)     !< tension and shear, Pa
      real(wp), intent(out) :: ratio(crack_points)           !< 1: damage begins
      integer :: k, p

      do k = 1, crack_points
         p = self%first_crack + crack_points*(i - 1) + k
         associate (axes => self%map(:2, 1:2, p), length => self%face(p)%length)
            traction(:, k) = matmul(axes, force(1:2) + 3.0_wp*places(k)*force(3:4))/length
         end associate
         select type (law => self%slot(self%material(p))%law)
         type is (crack_law_type)
            ratio(k) = law%traction_ratio(traction(:, k))
         end select
      end do
   end subroutine strength_ratios

   !> Begin the joint of face i with tractions at its points.
   subroutine begin_crack(self, i, blocks, traction)
      class(material_points_type), intent(inout) :: self       !< elements of this kind
      integer, intent(in) :: i                               !< face that has just broken
      type(blocks_type), intent(in) :: blocks                !< blocks in their present state
      real(wp), intent(in) :: traction(2, crack_points)      !< tension and shear, Pa
      integer :: k, p

      do k = 1, crack_points
         p = self%first_crack + crack_points*(i - 1) + k
         self%state(:, p) = 0.0_wp
         self%point(p)%bounding = 0.0_wp
         self%reference(:, p) = total_strain(self, p, blocks)
         select type (law => self%slot(self%material(p))%law)
         type is (crack_law_type)
            self%reference(:2, p) = self%reference(:2, p) - traction(:, k)/law%springs()
         end select
      end do
   end subroutine begin_crack

   !> Find the weighted damage of face i, and whether its bonds have failed.
   pure subroutine crack_damage(self, i, damage, spent)
      class(material_points_type), intent(in) :: self  !< elements of this kind
      integer, intent(in) :: i                       !< broken face
      real(wp), intent(out) :: damage                !< damage of its points, with weights
      logical, intent(out) :: spent                  !< no bond is left
      integer :: k, p

      damage = 0.0_wp
      spent = .true.
      do k = 1, crack_points
         p = self%first_crack + crack_points*(i - 1) + k
         damage = damage + weight(crack_points, k)*self%state(1, p)
         spent = spent .and. is_spent(self%state(:, p))
      end do
   end subroutine crack_damage

   !> Find opening and slip at the points of face i, m, counted from the state without force.
   pure function crack_motion(self, i, blocks) result(motion)
      class(material_points_type), intent(in) :: self  !< elements of this kind
      integer, intent(in) :: i                       !< broken face
      type(blocks_type), intent(in) :: blocks        !< blocks in their present state
      real(wp) :: motion(2, crack_points), strain(3)
      integer :: k, p

      do k = 1, crack_points
         p = self%first_crack + crack_points*(i - 1) + k
         strain = total_strain(self, p, blocks) - self%reference(:, p)
         motion(:, k) = strain(:2)
      end do
   end function crack_motion

end module dda_crack_points
