! SPDX-License-Identifier: GPL-3.0-or-later
!> Joint laws against their formulas: potential and slope of the normal force, strength, dilation.
module test_joint_laws
   use dda_kinds, only: wp, pi
   use dda_barton_bandis, only: closure_of_joint
   use dda_contact, only: contacts_type, reserve
   use dda_friction, only: accept_contacts, find_bound, find_response, laws_type, set_laws
   use dda_joint_contact, only: joint_state => state_of, store_state
   use dda_joint_law, only: joint_state_type, net_slip, response_type, slip_path, weakened
   use dda_joint_laws, only: law_slot_type, create_joint_law
   use dda_material, only: joint_type
   use dda_overlap, only: node, weight
   use models, only: random
   use testing, only: check, check_close
   implicit none

   real(wp), parameter :: length = 0.7_wp  !< m
   integer, parameter :: lifted = 4        !< column of 'plesha'
   type(law_slot_type) :: slot

contains

   !> A contact that has slipped and weakened.
   pure type(joint_state_type) function state_of(path, weakening) result(state)
      real(wp), intent(in) :: path, weakening

      state = joint_state_type(length)
      state%memory([slip_path, weakened]) = [path, weakening]
   end function state_of

   !> JRC 10, JCS = σ_c = 100 MPa: k_ni 20.35 MPa/mm, V_m 0.136871 mm.
   pure type(joint_type) function rough() result(joint)
      joint%law = 'barton_bandis'
      joint%friction_angle = 30.0_wp
      joint%jrc = 10.0_wp
      joint%jcs = 1.0e8_wp
      call closure_of_joint(10.0_wp, 1.0e8_wp, 1.0e8_wp, joint%normal_stiffness, &
         joint%max_closure)
   end function rough

   subroutine index_values()
      type(joint_type) :: joint

      joint = rough()
      call check_close(joint%normal_stiffness, 2.035e10_wp, 'k_ni', 1.0e-12_wp)
      call check_close(joint%max_closure, 1.3687092e-4_wp, 'V_m', 1.0e-6_wp)
   end subroutine index_values

   subroutine hyperbolic_closure()
      type(joint_state_type) :: state
      real(wp), parameter :: stress(3) = [1.0e6_wp, 5.0e6_wp, 1.0e7_wp]
      real(wp), parameter :: closure(3) = [3.6158e-5_wp, 8.7903e-5_wp, 1.07053e-4_wp]
      real(wp) :: x, h
      integer :: i

      call create_joint_law(slot, rough(), 1.0_wp, 2.5_wp)
      state = state_of(0.0_wp, 1.0_wp)
      do i = 1, 3
         call check_close(slot%law%closure(state, stress(i)*length), closure(i), 'published', &
            1.0e-5_wp)
      end do
      do i = -2, 24
         x = 0.04_wp*i*1.3687e-4_wp
         h = 1.0e-10_wp
         associate (law => slot%law)
            call check_close(law%closure(state, law%normal_force(state, x)), x, 'inverse', &
               1.0e-12_wp, 1.0e-18_wp)
            call check_close((law%stored(state, x + h) - law%stored(state, x - h))/(2*h), &
               law%normal_force(state, x), 'slope of the potential', 1.0e-4_wp, 1.0e-3_wp)
            call check_close((law%normal_force(state, x + h) - law%normal_force(state, x - h)) &
               /(2*h)/law%tangent(state, x), 1.0_wp, 'slope of the force', 1.0e-3_wp)
            call check(law%tangent(state, x + h) >= law%tangent(state, x), 'convex')
         end associate
      end do
      do i = 1, 8  ! across the end of the hyperbola, at 100 JCS, and far beyond V_m
         call check_close(slot%law%closure(state, length*10.0_wp**(6 + i)), merge(hyperbola(i), &
            hyperbola(4) + (10.0_wp**(6 + i) - 1.0e10_wp)/2.035e10_wp &
            /(1.0_wp + 1.0e10_wp/2.035e10_wp/1.3687092e-4_wp)**2, i <= 4), 'closure', 1.0e-6_wp)
         x = slot%law%closure(state, length*10.0_wp**(6 + i))
         call check_close(slot%law%normal_force(state, x), length*10.0_wp**(6 + i), 'inverse', &
            1.0e-9_wp)
      end do
      call check_close(slot%law%tangent(state, 1.0_wp), slot%law%tangent(state, 1.0e3_wp), &
         'a stress beyond any wall has a bounded slope')

   contains

      pure real(wp) function hyperbola(i) result(closure)
         integer, intent(in) :: i  !< power of ten of the stress in MPa

         closure = 10.0_wp**(6 + i)/(2.035e10_wp + 10.0_wp**(6 + i)/1.3687092e-4_wp)
      end function hyperbola

   end subroutine hyperbolic_closure

   subroutine strength_of_rough_walls()
      type(joint_state_type) :: state
      real(wp), parameter :: stress(3) = [1.0e6_wp, 5.0e6_wp, 1.0e7_wp]
      real(wp), parameter :: strength(3) = [1.19175e6_wp, 4.66426e6_wp, 8.39100e6_wp]
      integer :: i

      call create_joint_law(slot, rough(), 1.0_wp, 2.5_wp)
      state = state_of(0.0_wp, 1.0_wp)
      do i = 1, 3
         call check_close(slot%law%strength(state, stress(i)*length)/length, strength(i), &
            'published', 5.0e-6_wp)
      end do
      call check_close(slot%law%strength(state, 1.0_wp), tan(70*pi/180), 'at most 70°', 1.0e-12_wp)
      call check_close(slot%law%strength(state, 2.0e8_wp*length), 2.0e8_wp*length &
         *tan(30*pi/180), 'at least φ_r', 1.0e-12_wp)
      call check_close(slot%law%strength(state, -1.0_wp), 0.0_wp, 'in tension')
   end subroutine strength_of_rough_walls

   pure type(joint_type) function weakening() result(joint)
      joint%law = 'mohr_coulomb'
      joint%friction_angle = 40.0_wp
      joint%residual_friction_angle = 25.0_wp
      joint%cohesion = 3.0e5_wp
      joint%residual_cohesion = 1.0e5_wp
      joint%tensile_strength = 2.0e5_wp
      joint%weakening_slip = 0.02_wp
      joint%dilation_angle = 8.0_wp
      joint%dilation_slip = 0.05_wp
   end function weakening

   subroutine peak_and_residual_strength()
      type(joint_state_type) :: state
      real(wp), parameter :: force = 1.0e6_wp
      real(wp) :: w, friction

      call create_joint_law(slot, weakening(), 1.0e9_wp, 2.5_wp)
      call check(.not. slot%law%brittle, 'weakens by slip')
      associate (whole => state_of(0.0_wp, 0.0_wp))
         state = slot%law%state_after_slip(whole, -0.005_wp, 0.0_wp)
         w = state%memory(weakened)
         call check_close(w, 0.25_wp, 'a quarter of the slip')
         state = slot%law%state_after_slip(whole, 1.0_wp, 0.0_wp)
         call check_close(state%memory(weakened), 1.0_wp, 'all of it')
      end associate
      friction = 0.75_wp*tan(40*pi/180) + 0.25_wp*tan(25*pi/180)
      call check_close(slot%law%strength(state_of(0.005_wp, w), force), &
         friction*force + 2.5e5_wp*length, 'strength', 1.0e-12_wp)
      call check_close(slot%law%tension(state_of(0.005_wp, w)), 1.5e5_wp*length, &
         'tension', 1.0e-12_wp)
   end subroutine peak_and_residual_strength

   !> N = k_n [x + tan ψ Δs], Δs = t − τ(N)/k_s, up to the limiting slip.
   subroutine dilation()
      type(joint_state_type) :: state
      real(wp) :: force, slip, t, path
      integer :: i, k

      call create_joint_law(slot, weakening(), 1.0e9_wp, 2.5_wp)
      do i = 0, 6
         do k = 1, 4
            path = 0.01_wp*i
            state = state_of(path, 0.5_wp)
            t = 0.006_wp*k
            associate (law => slot%law)
               force = law%sliding_force(state, 1.0e-3_wp, t)
               slip = t - law%strength(state, force)/law%shear_spring(state)
               call check_close(force, law%normal_force(state, 1.0e-3_wp &
                  + law%lift(law%state_after_slip(state, slip, 0.0_wp)) - law%lift(state)), &
                  'normal force', 1.0e-12_wp)
            end associate
         end do
      end do
   end subroutine dilation

   !> Asperities of 15° on faces of 30°.
   pure type(joint_type) function worn() result(joint)
      joint%law = 'plesha'
      joint%friction_angle = 30.0_wp
      joint%asperity_angle = 15.0_wp
      joint%asperity_wear = 5.0e-6_wp
      joint%normal_stiffness = 2.0e10_wp
      joint%shear_stiffness = 1.0e10_wp
   end function worn

   !> tan(φ ± α), ± tan α, α₀ exp(−cW); the normal force is that of the lift of the same slip.
   subroutine asperities()
      type(joint_state_type) :: state, end_state
      real(wp) :: force, slip, angle
      integer :: direction

      call create_joint_law(slot, worn(), 1.0_wp, 1.0_wp)
      do direction = -1, 1, 2
         state = state_of(0.0_wp, 0.0_wp)
         state%memory(net_slip:lifted) = [0.02_wp, 5.0e-3_wp]
         state%slip_sign = real(direction, wp)
         call check_close(slot%law%strength(state, 1.0e6_wp), 1.0e6_wp &
            *tan((30 + direction*15)*pi/180), 'strength', 1.0e-12_wp)
         force = slot%law%sliding_force(state, 1.5e-3_wp, 4.0e-3_wp)
         slip = 4.0e-3_wp - slot%law%strength(state, force)/slot%law%shear_spring(state)
         end_state = slot%law%state_after_slip(state, direction*slip, &
            slot%law%strength(state, force))
         call check_close(end_state%memory(lifted) - state%memory(lifted), &
            direction*tan(15*pi/180)*slip, 'lift', 1.0e-12_wp)
         call check_close(force, slot%law%normal_force(state, 1.5e-3_wp + end_state%memory(lifted) &
            - state%memory(lifted)), 'normal force', 1.0e-12_wp)
         angle = 15*exp(-5.0e-6_wp*slot%law%strength(state, force)*slip/length)
         end_state%memory(net_slip) = 0.02_wp
         end_state%slip_sign = 1.0_wp
         call check_close(slot%law%strength(end_state, 1.0_wp), tan((30 + angle)*pi/180), 'wear', &
            1.0e-12_wp)
      end do
   end subroutine asperities

   !> No step of 10,000 random cycles under random loads gains energy by slip and lift; a joint
   !> descends only after it has risen, because asperities only wear.
   subroutine random_cycles_of_a_rough_joint()
      type(contacts_type) :: contacts
      type(laws_type) :: laws
      real(wp) :: loss, min_loss, max_loss, min_lift, travel
      integer :: cycle, step, passed

      call set_laws(laws, [worn()], 1.0_wp, 1.0_wp)
      min_loss = 0.0_wp
      max_loss = 0.0_wp
      min_lift = 0.0_wp
      travel = 0.0_wp
      passed = 0
      do cycle = 1, 10000
         if (modulo(cycle, 1000) == 1) call begin_contact(contacts, laws)
         do step = 1, 8
            call step_contact(contacts, laws, random(-5.0e-3_wp, 5.0e-3_wp), &
               random(-2.0e-5_wp, 1.0e-4_wp), loss)
            min_loss = min(min_loss, loss)
            max_loss = max(max_loss, loss)
            min_lift = min(min_lift, contacts%memory(lifted, 1))
            travel = max(travel, contacts%memory(lifted, 1))
            if (contacts%trial_past_centre(1)) passed = passed + 1
         end do
      end do
      call check(min_loss >= -1.0e-12_wp*max_loss, 'no slip gains energy')
      call check(min_lift >= -1.0e-12_wp, 'lifted')
      call check(travel > 1.0e-3_wp .and. passed > 10000, 'up, down, and through the centre')
   end subroutine random_cycles_of_a_rough_joint

   !> With a frozen force the response is monotone, so that the energy of a step is convex: also if
   !> the normal force is far above the frozen one, and beyond zero net slip.
   subroutine frozen_friction_is_monotone()
      type(contacts_type) :: contacts
      type(laws_type) :: laws
      type(response_type) :: a, b
      real(wp) :: at(2, 2), work, min_work
      integer :: i, passed, driven

      call set_laws(laws, [worn()], 1.0_wp, 1.0_wp)
      min_work = 0.0_wp
      passed = 0
      driven = 0
      do i = 1, 20000
         call begin_contact(contacts, laws)
         contacts%was_closed = .true.
         contacts%memory(net_slip, 1) = random(-1.0e-3_wp, 1.0e-3_wp)
         contacts%memory(lifted, 1) = tan(15*pi/180)*abs(contacts%memory(net_slip, 1))
         contacts%frozen_bound = [max(0.0_wp, random(-1.0e5_wp, 1.0e6_wp))]
         contacts%frozen_lifting = [1.0_wp]
         at = reshape([random(-5.0e-4_wp, 5.0e-4_wp), random(-3.0e-3_wp, 3.0e-3_wp), &
            random(-5.0e-4_wp, 5.0e-4_wp), random(-3.0e-3_wp, 3.0e-3_wp)], [2, 2])
         call find_response(contacts, laws, 1, at(1, 1), at(2, 1), a)
         call find_response(contacts, laws, 1, at(1, 2), at(2, 2), b)
         work = (a%shear_force - b%shear_force)*(at(2, 1) - at(2, 2)) &
            - (a%normal_force - b%normal_force)*(at(1, 1) - at(1, 2))
         min_work = min(min_work, work)
         if (a%past_centre) passed = passed + 1
         if (a%shear_force*at(2, 1) < 0.0_wp) driven = driven + 1
      end do
      call check(min_work >= -1.0e-6_wp, 'monotone')
      call check(passed > 1000 .and. driven > 500, 'beyond zero net slip; descents driven by N')
   end subroutine frozen_friction_is_monotone

   !> A bonded joint with dilation retains its cohesion and tension if the frozen force is zero.
   subroutine frozen_tension()
      type(contacts_type) :: contacts
      type(laws_type) :: laws
      type(joint_type) :: joint
      type(response_type) :: response
      real(wp), parameter :: weakening_slip(2) = [0.0_wp, 1.0_wp]
      integer :: i

      do i = 1, 2  ! brittle, weakening
         joint = weakening()
         joint%weakening_slip = weakening_slip(i)
         joint%cohesion = 1.0e6_wp
         joint%tensile_strength = 1.0e6_wp
         call set_laws(laws, [joint], 1.0e9_wp, 2.5_wp)
         call begin_contact(contacts, laws)
         contacts%bonded = .true.
         contacts%was_closed = .true.
         contacts%frozen_bound = [0.0_wp]
         contacts%frozen_lifting = [1.0_wp]
         associate (law => laws%slot(1)%law, state => joint_state(contacts, laws%slot(1)%law, 1))
            call find_response(contacts, laws, 1, 7.0e4_wp/law%initial_spring(state), &
               7.0e4_wp/law%shear_spring(state), response)
         end associate
         call check_close(response%normal_force, -7.0e4_wp, 'normal force', 1.0e-12_wp)
         call check_close(response%shear_force, 7.0e4_wp, 'shear force', 1.0e-12_wp)
         call check(response%strength_ratio < 0.0_wp, 'intact')
      end do
   end subroutine frozen_tension

   !> A search has not converged while a small frozen force gives an open contact its cohesion.
   subroutine frozen_cohesion_of_an_open_contact()
      type(contacts_type) :: contacts
      type(laws_type) :: laws
      type(response_type) :: response
      real(wp) :: bound, lifting, difference

      call set_laws(laws, [weakening()], 1.0e9_wp, 2.5_wp)
      call begin_contact(contacts, laws)
      contacts%was_closed = .true.
      contacts%frozen_bound = [1.0e-12_wp]
      contacts%frozen_lifting = [1.0_wp]
      contacts%new_gap = 1.0e-3_wp
      contacts%slip = 1.0e-3_wp
      call find_response(contacts, laws, 1, 1.0e-3_wp, 1.0e-3_wp, response)
      contacts%normal_force(1) = response%normal_force
      contacts%shear_force(1) = response%shear_force
      call check_close(response%shear_force, 3.0e5_wp*length, 'frozen cohesion', 1.0e-12_wp)
      call find_bound(contacts, laws, 1, bound, lifting, difference)
      call check_close(difference, 3.0e5_wp*length, 'not the force of the law', 1.0e-12_wp)
      contacts%frozen_bound = 0.0_wp
      call find_response(contacts, laws, 1, 1.0e-3_wp, 1.0e-3_wp, response)
      call check(.not. abs(response%shear_force) > 0.0_wp, 'an open contact has no shear force')
   end subroutine frozen_cohesion_of_an_open_contact

   !> One contact under a joint law, whole and without load.
   subroutine begin_contact(contacts, laws)
      type(contacts_type), intent(inout) :: contacts
      type(laws_type), intent(in) :: laws

      contacts%with_laws = .true.
      contacts%with_net_slip = .true.
      contacts%initial_memory = laws%columns%initial
      call reserve(contacts, 1)
      contacts%n = 1
      contacts%joint = 1
      contacts%bonded = .false.
      contacts%length = length
      contacts%stiffness_fraction = 1.0_wp
      contacts%memory = 0.0_wp
      contacts%stretch = 0.0_wp
      contacts%normal_force = 0.0_wp
   end subroutine begin_contact

   !> Slip to a position, m, from the centre, at a closure, m, both at the end of a step;
   !> `lost` is the work of friction minus the energy stored by the lift, J/m.
   subroutine step_contact(contacts, laws, position, closure, loss)
      type(contacts_type), intent(inout) :: contacts
      type(laws_type), intent(in) :: laws
      real(wp), intent(in) :: position, closure
      real(wp), intent(out) :: loss
      type(response_type) :: response
      real(wp) :: lift, stretch

      lift = contacts%memory(lifted, 1)
      stretch = contacts%stretch(1)
      contacts%was_closed(1) = contacts%normal_force(1) > 0.0_wp
      contacts%slip(1) = position - contacts%memory(net_slip, 1)
      call find_response(contacts, laws, 1, lift - closure, stretch + contacts%slip(1), response)
      contacts%trial_state(1) = response%state
      contacts%trial_past_centre(1) = response%past_centre
      contacts%normal_force(1) = response%normal_force
      contacts%shear_force(1) = response%shear_force
      call accept_contacts(contacts, laws)
      loss = response%shear_force*(contacts%slip(1) - (contacts%stretch(1) - stretch)) &
         - response%normal_force*(contacts%memory(lifted, 1) - lift)
   end subroutine step_contact

   !> The memory of two laws is one table, in which equal names are one column.
   subroutine memory_of_two_laws()
      type(laws_type) :: laws
      type(contacts_type) :: contacts
      type(joint_state_type) :: state

      call set_laws(laws, [yielding(), worn(), weakening()], 1.0_wp, 1.0_wp)
      call check(all(laws%columns%name == [character(len=24) :: 'slip_path', 'weakened', &
         'net_slip', 'reversal', 'slip_direction', 'lifted']), 'columns')
      call check(all(laws%columns%initial == [0, 1, 0, 0, 0, 0]), 'of contacts without history')
      call begin_contact(contacts, laws)
      contacts%memory(:, 1) = [1, 2, 3, 4, 5, 6]
      associate (first => laws%slot(1)%law, second => laws%slot(2)%law)
         state = joint_state(contacts, first, 1)
         call check(all(state%memory(:4) == [1, 2, 4, 5]), 'a law without a centre')
         state = joint_state(contacts, second, 1)
         call check(all(state%memory(:4) == [1, 2, 3, 6]), 'a law with one')
         state%memory(4) = 7.0_wp
         call store_state(contacts, second, 1, state)
      end associate
      call check(all(contacts%memory(:, 1) == [1, 2, 3, 4, 5, 7]), 'kept')
   end subroutine memory_of_two_laws

   !> σ_c = 2 MPa, G_c = 500 N/m.
   pure type(joint_type) function soft() result(joint)
      joint%law = 'crushing'
      joint%friction_angle = 30.0_wp
      joint%crushing_strength = 2.0e6_wp
      joint%crushing_energy = 500.0_wp
      joint%normal_stiffness = 1.0e10_wp
   end function soft

   !> min(k x, σ_c L), its potential and slope; closure beyond it is plastic, the unloading elastic;
   !> small steps to the plastic closure 2 G_c/σ_c lose G_c per area.
   subroutine crushing()
      type(joint_state_type) :: state
      real(wp), parameter :: k_n = 1.0e10_wp*length, crushing_force = 2.0e6_wp*length, h = 1.0e-9_wp
      real(wp) :: x, dissipated, start_closure
      integer :: i

      call create_joint_law(slot, soft(), 1.0_wp, 2.5_wp)
      associate (law => slot%law)
         state = joint_state_type(length)
         do i = -2, 8
            x = (i + 0.5_wp)*1.0e-4_wp
            call check_close(law%normal_force(state, x), min(k_n*x, crushing_force), 'force', &
               1.0e-12_wp)
            call check_close((law%stored(state, x + h) - law%stored(state, x - h))/(2*h), &
               law%normal_force(state, x), 'slope of the potential', 1.0e-6_wp)
            call check_close(law%tangent(state, x), merge(k_n, 0.0_wp, k_n*x < crushing_force), &
               'slope')
         end do
         state%closure = 3.0e-4_wp
         state = law%state_after_slip(state, 0.0_wp, 0.0_wp)
         call check_close(-law%lift(state), 3.0e-4_wp - crushing_force/k_n, 'plastic closure', &
            1.0e-12_wp)
         call check_close(law%normal_force(state, 1.0e-5_wp), k_n*1.0e-5_wp, 'unloads', 1.0e-12_wp)
         state%closure = 2.5e-4_wp
         call check_close(law%lift(law%state_after_slip(state, 0.0_wp, 0.0_wp)), law%lift(state), &
            'kept')
         state = joint_state_type(length)
         dissipated = 0.0_wp
         do i = 1, 10000
            start_closure = -law%lift(state)
            state%closure = 1.0e-7_wp*i
            associate (force => law%normal_force(state, state%closure - start_closure))
               state = law%state_after_slip(state, 0.0_wp, 0.0_wp)
               dissipated = dissipated - force*(law%lift(state) + start_closure)
            end associate
         end do
         call check_close(dissipated, 500*length, 'fracture energy', 1.0e-3_wp)
         call check(law%normal_force(state, 1.0_wp) == 0.0_wp, 'no strength is left')
      end associate
   end subroutine crushing

   !> Lobatto's rule of n points is exact for polynomials up to the degree 2n − 3.
   subroutine points_of_overlaps()
      integer, parameter :: rules(*) = [2, 3, 5, 9, 17]
      integer :: degree, i, k

      do k = 1, size(rules)
         do degree = 0, 2*rules(k) - 3
            call check_close(sum([(weight(rules(k), i)*node(rules(k), i)**degree, i=1, &
               rules(k))]), 1.0_wp/(degree + 1), 'rule', 1.0e-13_wp)
         end do
      end do
   end subroutine points_of_overlaps

   !> φ_m from 45° to 30°.
   pure type(joint_type) function yielding() result(joint)
      joint%law = 'continuously_yielding'
      joint%friction_angle = 30.0_wp
      joint%initial_friction_angle = 45.0_wp
      joint%roughness = 2.0e-3_wp
      joint%normal_stiffness = 1.0e10_wp
      joint%shear_stiffness = 1.0e10_wp
   end function yielding

   !> Slip in two parts is slip in one; it is elastic at first, and again as it turns; slopes agree.
   subroutine continuous_yield()
      type(joint_state_type) :: state, reversed
      real(wp), parameter :: slip = 5.0e-5_wp, force = 1.0e6_wp*length
      real(wp) :: full_step_force, half_step_force, slope, second_force

      call create_joint_law(slot, yielding(), 1.0_wp, 1.0_wp)
      state = joint_state_type(length, normal_force=force)
      call slot%law%flow(state, force, 2*slip, full_step_force, slope)
      call check_close(full_step_force, force*(1 - exp(-2*1.0e10_wp*slip*length/force)), &
         'closed form')
      call slot%law%flow(state, force, slip, half_step_force, slope)
      state%stretch = half_step_force/slot%law%shear_spring(state)
      call slot%law%flow(state, force, state%stretch + slip, second_force, slope)
      call check_close(second_force, full_step_force, 'two parts', 1.0e-12_wp)
      reversed = slot%law%state_after_slip(state, slip - (second_force - &
         half_step_force)/(1.0e10_wp*length), second_force)
      reversed%stretch = second_force/(1.0e10_wp*length)
      call slot%law%flow(reversed, force, reversed%stretch - 1.0e-12_wp, half_step_force, slope)
      call check_close(slope, 1.0e10_wp*length, 'elastic as it turns', 1.0e-6_wp)
      call slot%law%flow(reversed, force, reversed%stretch + 1.0e-9_wp, half_step_force, slope)
      call check_close((half_step_force - second_force)/1.0e-9_wp, slope, 'slope', 1.0e-4_wp)
      call slot%law%flow(reversed, 0.0_wp, slip, half_step_force, slope)
      call check(half_step_force == 0.0_wp .and. slope == 0.0_wp, 'no normal force, no friction')
   end subroutine continuous_yield

   !> k_s (t − vΔt) = N μ(v) beyond the threshold, elastic below; θ = L/v + (θ₀ − L/v) exp(−vt/L).
   subroutine friction_of_velocity()
      type(joint_type) :: joint
      type(joint_state_type) :: state, end_state
      real(wp), parameter :: force = 1.0e6_wp, step = 1.0e-3_wp
      real(wp) :: k_s, v, t, shear, slope, upper_force, age
      integer :: i

      joint = yielding()
      joint%law = 'rate_state'
      joint%direct_effect = 0.01_wp
      joint%evolution_effect = 0.015_wp
      joint%threshold_velocity = 1.0e-9_wp
      joint%reference_velocity = 1.0e-6_wp
      joint%state_distance = 1.0e-4_wp
      joint%initial_age = 2.0_wp
      call create_joint_law(slot, joint, 1.0_wp, 1.0_wp)
      state = joint_state_type(length, time_step=step)
      k_s = slot%law%shear_spring(state)
      do i = -8, 2, 2
         v = 10.0_wp**i
         shear = force*(tan(30*pi/180) + 0.01_wp*log((v + 1.0e-9_wp)/1.0e-6_wp) &
            + 0.015_wp*log(2.0e-2_wp))
         t = -(shear/k_s + v*step)
         call slot%law%flow(state, force, t, upper_force, slope)
         call check_close(upper_force, -shear, 'at a velocity', 1.0e-9_wp)
         call slot%law%flow(state, force, t*(1 + 1.0e-7_wp), shear, slope)
         call check_close((shear - upper_force)/(1.0e-7_wp*t), slope, 'slope', 1.0e-3_wp)
         end_state = slot%law%state_after_slip(state, -v*step, upper_force)
         age = 1.0e-4_wp/v + (2.0_wp - 1.0e-4_wp/v)*exp(-v*step/1.0e-4_wp)
         call check_close(end_state%memory(3), age, 'age', 1.0e-6_wp)
         call check_close(end_state%memory(4), -v, 'velocity', 1.0e-12_wp)
      end do
      call slot%law%flow(state, force, 1.0e-6_wp, shear, slope)
      call check_close(shear, 1.0e-6_wp*k_s, 'sticks', 1.0e-12_wp)
      state%time_step = 0.0_wp
      call slot%law%flow(state, force, 1.0_wp, shear, slope)
      call check_close(shear, slot%law%strength(state, force), 'on the way to rest', 1.0e-12_wp)
   end subroutine friction_of_velocity

   subroutine stiffness()
      type(joint_type) :: joint
      type(joint_state_type) :: state

      state = state_of(0.0_wp, 0.0_wp)
      joint%friction_angle = 35.0_wp
      call create_joint_law(slot, joint, 1.0e9_wp, 2.5_wp)
      call check_close(slot%law%initial_spring(state), 1.0e9_wp, 'per contact')
      call check_close(slot%law%shear_spring(state), 4.0e8_wp, 'its shear spring', 1.0e-12_wp)
      joint%normal_stiffness = 3.0e9_wp
      call create_joint_law(slot, joint, 1.0e9_wp, 2.5_wp)
      call check_close(slot%law%initial_spring(state), 2.1e9_wp, 'per area', 1.0e-12_wp)
      call check_close(slot%law%shear_spring(state), 8.4e8_wp, 'its shear spring', 1.0e-12_wp)
      joint%shear_stiffness = 1.0e9_wp
      call create_joint_law(slot, joint, 1.0e9_wp, 2.5_wp)
      call check_close(slot%law%shear_spring(state), 7.0e8_wp, 'one of its own', 1.0e-12_wp)
   end subroutine stiffness

end module test_joint_laws
