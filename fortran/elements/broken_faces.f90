! SPDX-License-Identifier: GPL-3.0-or-later
!> Elements of faces that break: forces on welded faces, and the joints that replace them.
module dda_broken_faces
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type
   use dda_crack_points, only: points_force, strength_ratios, begin_crack, crack_damage, &
      crack_motion
   use dda_elements, only: elements_type
   use dda_material_points, only: crack_points
   use dda_strain_points, only: strain_points_type
   use dda_weld, only: weld_type, weld_cracked, weld_whole
   use dda_weld_springs, only: n_deformations
   use dda_welds, only: welds_type, weld_force
   implicit none
   private
   public :: face_force, face_strength, begin_joint, joint_damage, joint_motion, edge_damage, &
      crack_points

contains

   !> Forces on the deformations of whole face i in the present state.
   pure function face_force(elements, i, blocks) result(force)
      type(elements_type), intent(in) :: elements  !< of the model
      integer, intent(in) :: i                     !< face
      type(blocks_type), intent(in) :: blocks      !< blocks in their present state
      real(wp) :: force(n_deformations)
      integer :: k

      force = 0.0_wp
      do k = 1, size(elements%kind)
         select type (element => elements%kind(k)%element)
         type is (welds_type)
            force = force + weld_force(element, i, blocks)
         type is (strain_points_type)
            force = force + points_force(element, i, blocks)
         end select
      end do
   end function face_force

   !> Tractions at the points of whole face i for such forces, relative to their strength.
   pure subroutine face_strength(elements, i, force, traction, ratio)
      type(elements_type), intent(in) :: elements         !< of the model
      integer, intent(in) :: i                            !< face
      real(wp), intent(in) :: force(n_deformations)       !< of `face_force`
      real(wp), intent(out) :: traction(2, crack_points)  !< tension and shear, Pa
      real(wp), intent(out) :: ratio                      !< the largest
      real(wp) :: ratios(crack_points)
      integer :: k

      traction = 0.0_wp
      ratio = 0.0_wp
      do k = 1, size(elements%kind)
         select type (element => elements%kind(k)%element)
         type is (strain_points_type)
            call strength_ratios(element, i, force, traction, ratios)
            ratio = maxval(ratios)
         end select
      end do
   end subroutine face_strength

   !> Begin the joint of face i with tractions at its points.
   subroutine begin_joint(elements, i, blocks, traction)
      type(elements_type), intent(inout) :: elements     !< of the model
      integer, intent(in) :: i                           !< face that has just broken
      type(blocks_type), intent(in) :: blocks            !< blocks in their present state
      real(wp), intent(in) :: traction(2, crack_points)  !< tension and shear, Pa
      integer :: k

      do k = 1, size(elements%kind)
         select type (element => elements%kind(k)%element)
         type is (strain_points_type)
            call begin_crack(element, i, blocks, traction)
         end select
      end do
   end subroutine begin_joint

   !> Find the mean damage of the joint of face i, and whether its bond has failed.
   pure subroutine joint_damage(elements, i, damage, spent)
      type(elements_type), intent(in) :: elements  !< of the model
      integer, intent(in) :: i                     !< broken face
      real(wp), intent(out) :: damage              !< damage of its points, with weights
      logical, intent(out) :: spent                !< no bond is left
      integer :: k

      damage = 0.0_wp
      spent = .false.
      do k = 1, size(elements%kind)
         select type (element => elements%kind(k)%element)
         type is (strain_points_type)
            call crack_damage(element, i, damage, spent)
         end select
      end do
   end subroutine joint_damage

   !> Find opening and slip at the points of the joint of face i, m.
   pure function joint_motion(elements, i, blocks) result(motion)
      type(elements_type), intent(in) :: elements  !< of the model
      integer, intent(in) :: i                     !< broken face
      type(blocks_type), intent(in) :: blocks      !< blocks in their present state
      real(wp) :: motion(2, crack_points)
      integer :: k

      motion = 0.0_wp
      do k = 1, size(elements%kind)
         select type (element => elements%kind(k)%element)
         type is (strain_points_type)
            motion = crack_motion(element, i, blocks)
         end select
      end do
   end function joint_motion

   !> Mean damage of the faces of each edge, weighted by length: 0 whole, 1 broken.
   pure function edge_damage(elements, welds, edges) result(damage)
      type(elements_type), intent(in) :: elements  !< of the model
      type(weld_type), intent(in) :: welds(:)      !< all faces
      integer, intent(in) :: edges                 !< of all blocks
      real(wp) :: damage(edges), length(edges), own
      logical :: spent
      integer :: i

      damage = 0.0_wp
      length = 0.0_wp
      do i = 1, size(welds)
         length(welds(i)%edge) = length(welds(i)%edge) + welds(i)%length
         if (welds(i)%state == weld_whole) cycle
         own = 1.0_wp
         if (welds(i)%state == weld_cracked) call joint_damage(elements, i, own, spent)
         damage(welds(i)%edge) = damage(welds(i)%edge) + own*welds(i)%length
      end do
      where (length > 0.0_wp) damage = damage/length
   end function edge_damage

end module dda_broken_faces
