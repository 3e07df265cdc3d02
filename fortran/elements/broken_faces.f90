! SPDX-License-Identifier: GPL-3.0-or-later
!> Welded faces that break: forces and tractions on intact faces; start of the joints that replace
!> broken faces; damage, opening and slip of these joints.
module dda_broken_faces
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type
   use dda_crack_law, only: crack_law_type, has_failed
   use dda_elements, only: elements_type
   use dda_material_points, only: material_points_type, acts, crack_points, point_positions, &
      present_stress, total_strain
   use dda_overlap, only: weight
   use dda_strain_points, only: strain_points_type
   use dda_weld, only: weld_type, weld_cracked, weld_intact
   use dda_weld_springs, only: n_deformations
   use dda_welds, only: welds_type, weld_force
   implicit none
   private
   public :: face_force, find_face_strength, begin_joint, find_joint_damage, joint_motion, &
      edge_damage, crack_points

contains

   !> Return the forces on the deformations of intact face i in the present state.
   pure function face_force(elements, i, blocks) result(force)
      type(elements_type), intent(in) :: elements  !< elements of the model
      integer, intent(in) :: i                     !< number of the face
      type(blocks_type), intent(in) :: blocks      !< blocks in their present state
      real(wp) :: force(n_deformations)
      integer :: k

      force = 0.0_wp
      do k = 1, size(elements%kind)
         select type (element => elements%kind(k)%element)
         type is (welds_type)
            force = force + weld_force(element, i, blocks)
         type is (strain_points_type)
            force = force + force_of_points(element, i, blocks)
         end select
      end do
   end function face_force

   !> Return the forces of the points of intact face i on its deformations in the present state.
   pure function force_of_points(points, i, blocks) result(force)
      class(material_points_type), intent(in) :: points  !< elements of this kind
      integer, intent(in) :: i                           !< number of the face
      type(blocks_type), intent(in) :: blocks            !< blocks in their present state
      real(wp) :: force(n_deformations)
      integer :: p, group, k, faces

      force = 0.0_wp
      faces = (points%n - points%first_crack)/crack_points
      do group = 0, (points%first_crack - blocks%n)/(2*faces) - 1
         do k = 1, 2
            p = blocks%n + 2*group*faces + 2*(i - 1) + k
            if (acts(points, p, blocks)) force = force + points%area(p) &
               *matmul(present_stress(points, p, blocks), points%map(:, :, p))
         end do
      end do
   end function force_of_points

   !> Return the tractions at the points of intact face i due to given forces, and the largest ratio
   !> of traction to strength.
   pure subroutine find_face_strength(elements, i, force, traction, ratio)
      type(elements_type), intent(in) :: elements         !< elements of the model
      integer, intent(in) :: i                            !< face that can break
      real(wp), intent(in) :: force(n_deformations)       !< forces from `face_force`
      real(wp), intent(out) :: traction(2, crack_points)  !< tension and shear, Pa
      real(wp), intent(out) :: ratio                      !< largest ratio; damage begins at 1
      integer :: k, c, p

      traction = 0.0_wp
      ratio = 0.0_wp
      do k = 1, size(elements%kind)
         select type (points => elements%kind(k)%element)
         type is (strain_points_type)
            do c = 1, crack_points
               p = points%first_crack + crack_points*(i - 1) + c
               traction(:, c) = matmul(points%map(:2, 1:2, p), force(1:2) &
                  + 3.0_wp*point_positions(c)*force(3:4))/points%face(p)%length
               select type (law => points%slot(points%material(p))%law)
               type is (crack_law_type)
                  ratio = max(ratio, law%traction_ratio(traction(:, c)))
               end select
            end do
         end select
      end do
   end subroutine find_face_strength

   !> Begin the joint of face i with tractions at its points.
   subroutine begin_joint(elements, i, blocks, traction)
      type(elements_type), intent(inout) :: elements     !< elements of the model
      integer, intent(in) :: i                           !< face that has just broken
      type(blocks_type), intent(in) :: blocks            !< blocks in their present state
      real(wp), intent(in) :: traction(2, crack_points)  !< tension and shear, Pa
      integer :: k, c, p

      do k = 1, size(elements%kind)
         select type (points => elements%kind(k)%element)
         type is (strain_points_type)
            do c = 1, crack_points
               p = points%first_crack + crack_points*(i - 1) + c
               points%state(:, p) = 0.0_wp
               points%point(p)%bounding = 0.0_wp
               points%reference(:, p) = total_strain(points, p, blocks)
               select type (law => points%slot(points%material(p))%law)
               type is (crack_law_type)
                  points%reference(:2, p) = points%reference(:2, p) - traction(:, c)/law%springs()
               end select
            end do
         end select
      end do
   end subroutine begin_joint

   !> Find the mean damage of the joint of face i, and whether its bond has failed.
   pure subroutine find_joint_damage(elements, i, damage, failed)
      type(elements_type), intent(in) :: elements  !< elements of the model
      integer, intent(in) :: i                     !< broken face
      real(wp), intent(out) :: damage              !< weighted mean damage of the points
      logical, intent(out) :: failed                !< the bond has failed at all points
      integer :: k, c, p

      damage = 0.0_wp
      failed = .false.
      do k = 1, size(elements%kind)
         select type (points => elements%kind(k)%element)
         type is (strain_points_type)
            failed = .true.
            do c = 1, crack_points
               p = points%first_crack + crack_points*(i - 1) + c
               damage = damage + weight(crack_points, c)*points%state(1, p)
               failed = failed .and. has_failed(points%state(:, p))
            end do
         end select
      end do
   end subroutine find_joint_damage

   !> Find opening and slip, m, at the points of the joint of face i, relative to zero force.
   pure function joint_motion(elements, i, blocks) result(motion)
      type(elements_type), intent(in) :: elements  !< elements of the model
      integer, intent(in) :: i                     !< broken face
      type(blocks_type), intent(in) :: blocks      !< blocks in their present state
      real(wp) :: motion(2, crack_points), strain(3)
      integer :: k, c, p

      motion = 0.0_wp
      do k = 1, size(elements%kind)
         select type (points => elements%kind(k)%element)
         type is (strain_points_type)
            do c = 1, crack_points
               p = points%first_crack + crack_points*(i - 1) + c
               strain = total_strain(points, p, blocks) - points%reference(:, p)
               motion(:, c) = strain(:2)
            end do
         end select
      end do
   end function joint_motion

   !> Return the mean damage of the faces of each edge, weighted by length: 0 intact, 1 broken.
   pure function edge_damage(elements, welds, edges) result(damage)
      type(elements_type), intent(in) :: elements  !< elements of the model
      type(weld_type), intent(in) :: welds(:)      !< all faces
      integer, intent(in) :: edges                 !< number of edges of all blocks
      real(wp) :: damage(edges), length(edges), face_damage
      logical :: failed
      integer :: i

      damage = 0.0_wp
      length = 0.0_wp
      do i = 1, size(welds)
         length(welds(i)%edge) = length(welds(i)%edge) + welds(i)%length
         if (welds(i)%state == weld_intact) cycle
         face_damage = 1.0_wp
         if (welds(i)%state == weld_cracked) call find_joint_damage(elements, i, face_damage, &
            failed)
         damage(welds(i)%edge) = damage(welds(i)%edge) + face_damage*welds(i)%length
      end do
      where (length > 0.0_wp) damage = damage/length
   end function edge_damage

end module dda_broken_faces
