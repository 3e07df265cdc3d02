! SPDX-License-Identifier: GPL-3.0-or-later
!> Warnings on bending of bonded joints with two contact points.  Such joints are three times too
!> stiff and strong in bending, compared with linear stress; results do not show this error.
!>
!> If two contacts, each with half of an overlap, have the stresses σ ± s, a linear stress of the
!> same moment is σ ± 3 s at the ends.
module dda_joint_ends
   use dda_kinds, only: wp
   use dda_contact, only: contacts_type
   use dda_doubts, only: add_doubt, doubt_type
   use dda_overlap, only: overlap_type, overlap_of, narrow
   use dda_simulation, only: simulation_type, block_name
   use dda_text, only: quoted, short_text
   implicit none
   private
   public :: bending_topic, bending_doubts

   character(len=*), parameter :: bending_topic = 'bending'  !< topic of the warnings

   real(wp), parameter :: most_bending = 0.2_wp   !< smallest reported bending/mean stress
   real(wp), parameter :: least_bending = 0.01_wp !< smallest significant bending stress/strength
   real(wp), parameter :: linear = 3.0_wp         !< bending stress of linear stress/of two contacts

contains

   !> Add a warning for each joint with a bonded overlap that bends.
   pure function bending_doubts(simulation) result(doubts)
      type(simulation_type), intent(in) :: simulation  !< run whose contacts are evaluated
      type(doubt_type), allocatable :: doubts(:)
      real(wp) :: mean, bending, stress(2)
      integer :: j, c, worst

      allocate (doubts(0))
      associate (contacts => simulation%contacts(simulation%now), laws => simulation%laws)
         do j = 1, size(laws%points)
            worst = 0
            stress = 0.0_wp
            if (laws%points(j) /= 2 .or. max(laws%cohesion(j), laws%tension(j)) <= 0.0_wp) cycle
            do c = 1, contacts%n
               if (.not. contacts%bonded(c) .or. contacts%joint(c) /= j) cycle
               call find_end_stresses(simulation, c, mean, bending)
               if (bending <= max(stress(2), most_bending*abs(mean), &
                  least_bending*max(laws%cohesion(j), laws%tension(j)))) cycle
               stress = [mean, bending]
               worst = c
            end do
            if (worst > 0) call add_doubt(doubts, bending_topic, overlap_text(simulation, worst, &
               stress))
         end do
      end associate
   end function bending_doubts

   !> Find the mean tension and the bending stress over the overlap of contact c, Pa.  The stress is
   !> assumed linear; the bending stress is its end value minus its mean.  Both results are 0 if the
   !> other end is not bonded.
   pure subroutine find_end_stresses(simulation, c, mean, bending)
      type(simulation_type), intent(in) :: simulation  !< run whose contacts are evaluated
      integer, intent(in) :: c                         !< bonded contact
      real(wp), intent(out) :: mean, bending           !< mean tension and bending stress, Pa
      integer :: k

      mean = 0.0_wp
      bending = 0.0_wp
      associate (contacts => simulation%contacts(simulation%now))
         do k = c + 1, contacts%n
            if (contacts%pair(k) /= contacts%pair(c)) return
            if (.not. contacts%bonded(k)) cycle
            if (any(overlapping_edges(simulation, k) /= overlapping_edges(simulation, c))) cycle
            mean = 0.5_wp*(mean_tension(contacts, c) + mean_tension(contacts, k))
            bending = 0.5_wp*linear*abs(mean_tension(contacts, c) - mean_tension(contacts, k))
            return
         end do
      end associate
   end subroutine find_end_stresses

   !> Return the mean tension over the bonded length of contact c, Pa.
   pure real(wp) function mean_tension(contacts, c)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step, evaluated
      integer, intent(in) :: c                     !< bonded contact

      mean_tension = -contacts%normal_force(c)/contacts%bond_length(c)
   end function mean_tension

   !> Find the two edges that overlap at contact c, the lower number first.
   pure function overlapping_edges(simulation, c) result(edges)
      type(simulation_type), intent(in) :: simulation  !< run whose contacts are listed
      integer, intent(in) :: c                         !< contact at a corner
      integer :: edges(2)
      type(overlap_type) :: next_overlap, former_overlap

      associate (contacts => simulation%contacts(simulation%now), blocks => simulation%blocks)
         associate (e => contacts%edge(c), v => contacts%vertex(c))
            next_overlap = overlap_of(blocks, e, v, narrow)
            former_overlap = overlap_of(blocks, e, blocks%previous(v), narrow)
            edges = [e, merge(v, blocks%previous(v), next_overlap%length >= former_overlap%length)]
         end associate
      end associate
      edges = [minval(edges), maxval(edges)]
   end function overlapping_edges

   !> Return a text on the overlap of contact c.
   pure function overlap_text(simulation, c, stress) result(text)
      type(simulation_type), intent(in) :: simulation  !< a run and its state
      integer, intent(in) :: c                         !< bonded contact
      real(wp), intent(in) :: stress(2)  !< mean tension and bending stress, Pa
      character(len=:), allocatable :: text, deviation

      deviation = ''
      if (stress(2) < 100*abs(stress(1))) deviation = ', '// &
         short_text(100*stress(2)/abs(stress(1)))//' % from the mean'
      associate (contacts => simulation%contacts(simulation%now))
         text = 'the bond of blocks '//block_name(simulation, contacts%block_v(c))// &
            ' and '//block_name(simulation, contacts%block_e(c))//', &joint '// &
            quoted(trim(simulation%model%joints(contacts%joint(c))%name))// &
            ', has a tension of '//short_text(stress(1) + stress(2))//' Pa at one end and '// &
            short_text(stress(1) - stress(2))//' Pa at the other'//deviation//', but its two '// &
            'contacts have '//short_text(stress(1) + stress(2)/linear)//' and '// &
            short_text(stress(1) - stress(2)/linear)//' Pa: its strength in bending is three '// &
            'times too high; try contact_points = '// &
            merge('5', '3', any(simulation%model%stages%static))
      end associate
   end function overlap_text

end module dda_joint_ends
