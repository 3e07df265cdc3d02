! SPDX-License-Identifier: GPL-3.0-or-later
!> Contact forces as interior points: an iteration that meets no state at its corner.
!>
!> A contact presses with N ≥ 0, and w = N + k_n g ≥ 0 is what keeps it open, N w = 0.  Friction
!> T = k_s s − λ₁ + λ₂ leaves b − T ≥ 0 and b + T ≥ 0 to its bound b, with λ₁ (b − T) = 0 and
!> λ₂ (b + T) = 0.  The three products are kept positive and equal to ε² instead, and ε goes to 0:
!> all contacts keep springs, whose shares N/(N + w) and 1/(1 + λ₁/(b − T) + λ₂/(b + T)) tell open
!> from closed and slide from stick ever more clearly.  On the path N differs from the law by ε at
!> most.
!>
!> Newton's method for the products, with predictor and correctors: S. Mehrotra, SIAM J. Optim. 2
!> (1992) 575; J. Gondzio, Comput. Optim. Appl. 6 (1996) 137.  The bound follows the normal force of
!> the last direction, since K̂ is symmetric.
module dda_interior_point
   use dda_kinds, only: wp
   use dda_contact, only: contacts_type
   use dda_friction, only: laws_type
   use dda_ordered_sums, only: pieces, first_of, last_of, most_pieces, parallel_from
   implicit none
   private
   public :: interior_type, begin_interior, stand_here, aim_at, aim_closer, follow_bounds, &
      assume_interior, measure_directions, take_share, mean_product

   integer, parameter :: pressed = 1, backward = 2, forward = 3  !< the three products of a contact
   integer, parameter :: toward(2) = [1, -1]                     !< signs of T in b − T and b + T
   real(wp), parameter :: range = 10.0_wp  !< of the product aimed at, in which products may lie
   real(wp), parameter :: inside = 0.9_wp  !< of the bound, that friction begins within

   !> The points of all contacts, and the direction that the last solution gives them.
   type :: interior_type
      integer :: n = 0                          !< contacts
      real(wp), allocatable :: factor(:,:,:)    !< [2,3,n] N, w; λ₁, b − T; λ₂, b + T, N/m
      real(wp), allocatable :: factor_way(:,:,:) !< [2,3,n] their changes, N/m
      real(wp), allocatable :: aim(:,:)         !< [3,n] products to come to, (N/m)²
      real(wp), allocatable :: shear(:)         !< [n] T, N/m
      real(wp), allocatable :: shear_way(:)     !< [n] its change, N/m
      real(wp), allocatable :: bound(:)         !< [n] b, N/m
      real(wp), allocatable :: bound_way(:)     !< [n] its change, N/m
      real(wp), allocatable :: trial(:,:)       !< [2,n] −k_n g and k_s s at the present d, N/m
      real(wp), allocatable :: place(:,:)       !< [2,n] gap and slip there, m
   end type interior_type

contains

   !> Points on the path of a radius ε, for the present gaps and slips.
   subroutine begin_interior(points, contacts, laws, radius)
      type(interior_type), intent(out) :: points  !< of the list
      type(contacts_type), intent(in) :: contacts !< this step's list, measured
      type(laws_type), intent(in) :: laws         !< plain, not damped
      real(wp), intent(in) :: radius              !< ε, N/m
      real(wp) :: trial(2), shear
      integer :: c, n

      n = contacts%n
      points%n = n
      allocate (points%factor(2, 3, n), points%factor_way(2, 3, n), points%aim(3, n), &
         points%shear(n), points%shear_way(n), points%bound(n), points%bound_way(n), &
         points%trial(2, n), points%place(2, n))
      points%factor_way = 0.0_wp
      points%shear = 0.0_wp
      points%shear_way = 0.0_wp
      points%bound = 0.0_wp
      do c = 1, n
         trial = trial_forces(contacts, laws, c)
         points%factor(:, :, c) = 0.0_wp
         if (contacts%bonded(c)) cycle
         associate (factor => points%factor(:, :, c), bound => points%bound(c))
            factor(:, pressed) = [rounded(trial(1), radius), rounded(-trial(1), radius)]
            bound = max(laws%friction(contacts%joint(c)), epsilon(bound))*factor(1, pressed)
            shear = min(abs(trial(2)), inside*bound)
            factor(2, backward:forward) = bound - toward*sign(shear, trial(2))
            factor(1, backward:forward) = radius**2/factor(2, backward:forward)
            points%shear(c) = sign(shear, trial(2))
         end associate
      end do
   end subroutine begin_interior

   !> max(x, 0) with a corner of radius ε: its product with the same of −x is ε².
   elemental real(wp) function rounded(x, radius)
      real(wp), intent(in) :: x       !< N/m
      real(wp), intent(in) :: radius  !< ε, N/m

      rounded = 0.5_wp*(abs(x) + hypot(x, 2*radius))
      if (x < 0.0_wp) rounded = radius**2/rounded
   end function rounded

   !> Forces of contact c at its gap and slip if it is closed and sticks, N/m.
   pure function trial_forces(contacts, laws, c) result(forces)
      type(contacts_type), intent(in) :: contacts  !< this step's list, measured
      type(laws_type), intent(in) :: laws          !< plain, not damped
      integer, intent(in) :: c                     !< number of the contact
      real(wp) :: forces(2)

      forces = [contacts%multiplier(c) - laws%normal_stiffness*contacts%new_gap(c), &
         laws%shear_stiffness*(contacts%stretch(c) + contacts%slip(c))]
   end function trial_forces

   !> The directions to come begin at the present gaps and slips.
   subroutine stand_here(points, contacts, laws)
      type(interior_type), intent(inout) :: points !< of the list
      type(contacts_type), intent(in) :: contacts  !< this step's list, measured
      type(laws_type), intent(in) :: laws          !< plain, not damped
      integer :: c

      !$omp parallel do schedule(static) &
      !$omp if (points%n >= parallel_from)
      do c = 1, points%n
         points%trial(:, c) = trial_forces(contacts, laws, c)
         points%place(:, c) = [contacts%new_gap(c), contacts%slip(c)]
      end do
   end subroutine stand_here

   !> Let the bounds follow the normal forces at a share of the last direction.
   subroutine follow_bounds(points, contacts, laws, share)
      type(interior_type), intent(inout) :: points !< of the list
      type(contacts_type), intent(in) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws          !< strength of the contacts
      real(wp), intent(in) :: share                !< 0: at the present ones
      integer :: c

      !$omp parallel do schedule(static) &
      !$omp if (points%n >= parallel_from)
      do c = 1, points%n
         points%bound_way(c) = laws%friction(contacts%joint(c))*max(0.0_wp, &
            points%factor(1, pressed, c) + share*points%factor_way(1, pressed, c)) - points%bound(c)
      end do
   end subroutine follow_bounds

   !> Aim at one product in all contacts, less what the products of the last changes would add,
   !> within a limit.
   subroutine aim_at(points, product_of, most)
      type(interior_type), intent(inout) :: points !< of the list
      real(wp), intent(in) :: product_of           !< ε², (N/m)²
      real(wp), intent(in) :: most                 !< of what they add, (N/m)²
      integer :: c

      !$omp parallel do schedule(static) &
      !$omp if (points%n >= parallel_from)
      do c = 1, points%n
         points%aim(:, c) = product_of &
            - max(-most, min(most, product(points%factor_way(:, :, c), 1)))
      end do
   end subroutine aim_at

   !> Aim so that products which a share of the last direction would bring out of range come nearer.
   subroutine aim_closer(points, product_of, share)
      type(interior_type), intent(inout) :: points !< of the list
      real(wp), intent(in) :: product_of           !< ε², (N/m)²
      real(wp), intent(in) :: share                !< of the direction
      real(wp) :: product_at(3)
      integer :: c

      !$omp parallel do private(product_at) schedule(static) &
      !$omp if (points%n >= parallel_from)
      do c = 1, points%n
         product_at = product(points%factor(:, :, c) + share*points%factor_way(:, :, c), 1)
         points%aim(:, c) = points%aim(:, c) + max(-range*product_of, &
            min(range*product_of, max(product_of/range, product_at)) - product_at)
      end do
   end subroutine aim_closer

   !> Forces that the contacts assume on the way to their aims, linear in gap and slip.
   subroutine assume_interior(points, contacts, laws)
      type(interior_type), intent(in) :: points       !< of the list
      type(contacts_type), intent(inout) :: contacts  !< gets `imposed_spring`, `imposed_force`
      type(laws_type), intent(in) :: laws             !< stiffness of the contacts
      real(wp) :: share(2), forces(2)
      integer :: c

      !$omp parallel do private(share, forces) schedule(static) &
      !$omp if (points%n >= parallel_from)
      do c = 1, points%n
         share = shares_of(points, contacts, c)
         forces = [points%factor(1, pressed, c), points%shear(c)] + ways_at(points, contacts, c, &
            [0.0_wp, 0.0_wp])
         associate (springs => contacts%imposed_spring(:, c))
            springs = share*[laws%normal_stiffness, laws%shear_stiffness]
            contacts%imposed_force(:, c) = forces + springs &
               *[points%place(1, c) - contacts%gap(c), -points%place(2, c)]
         end associate
      end do
   end subroutine assume_interior

   !> Shares of the springs that act in contact c.
   pure function shares_of(points, contacts, c) result(share)
      type(interior_type), intent(in) :: points    !< of the list
      type(contacts_type), intent(in) :: contacts  !< this step's list
      integer, intent(in) :: c                     !< number of the contact
      real(wp) :: share(2)

      share = 1.0_wp
      if (contacts%bonded(c)) return
      associate (factor => points%factor(:, :, c))
         share(1) = factor(1, pressed)/sum(factor(:, pressed))
         share(2) = 1.0_wp/(1.0_wp + sum(factor(1, backward:forward)/factor(2, backward:forward)))
      end associate
   end function shares_of

   !> Changes of normal and shear force of contact c, N/m, by those of its trial forces.
   pure function ways_at(points, contacts, c, trial_way) result(ways)
      type(interior_type), intent(in) :: points    !< of the list
      type(contacts_type), intent(in) :: contacts  !< this step's list
      integer, intent(in) :: c                     !< number of the contact
      real(wp), intent(in) :: trial_way(2)         !< N/m
      real(wp) :: ways(2), lacks(3), pull(2), share(2)

      associate (factor => points%factor(:, :, c), trial => points%trial(:, c), &
         shear => points%shear(c))
         ways = trial + trial_way - [factor(1, pressed), shear]
         if (contacts%bonded(c)) return
         share = shares_of(points, contacts, c)
         lacks = points%aim(:, c) - product(factor, 1)
         ways(1) = lacks(1)/sum(factor(:, pressed)) &
            + share(1)*(factor(2, pressed) - factor(1, pressed) + trial(1) + trial_way(1))
         pull = (lacks(backward:forward) - factor(1, backward:forward)*slack_ways(points, c)) &
            /factor(2, backward:forward)
         ways(2) = share(2)*(trial(2) + trial_way(2) - shear &
            - dot_product(toward, factor(1, backward:forward) + pull))
      end associate
   end function ways_at

   !> Changes of b − T and b + T while T stays, N/m.
   pure function slack_ways(points, c) result(ways)
      type(interior_type), intent(in) :: points  !< of the list
      integer, intent(in) :: c                   !< number of the contact
      real(wp) :: ways(2)

      ways = points%bound(c) + points%bound_way(c) - toward*points%shear(c) &
         - points%factor(2, backward:forward, c)
   end function slack_ways

   !> The direction of the last solution, and the longest share of it that keeps factors positive.
   subroutine measure_directions(points, contacts, laws, longest)
      type(interior_type), intent(inout) :: points !< of the list
      type(contacts_type), intent(in) :: contacts  !< this step's list, measured at the solution
      type(laws_type), intent(in) :: laws          !< stiffness of the contacts
      real(wp), intent(out) :: longest             !< at most 1
      real(wp) :: ways(2), lacks(3)
      integer :: c

      longest = 1.0_wp
      !$omp parallel do private(ways, lacks) reduction(min:longest) schedule(static) &
      !$omp if (points%n >= parallel_from)
      do c = 1, points%n
         if (contacts%bonded(c)) cycle
         associate (factor => points%factor(:, :, c), way => points%factor_way(:, :, c))
            ways = ways_at(points, contacts, c, &
               trial_forces(contacts, laws, c) - points%trial(:, c))
            lacks = points%aim(:, c) - product(factor, 1)
            way(:, pressed) = [ways(1), (lacks(1) - factor(2, pressed)*ways(1))/factor(1, pressed)]
            points%shear_way(c) = ways(2)
            way(2, backward:forward) = slack_ways(points, c) - toward*ways(2)
            way(1, backward:forward) = (lacks(backward:forward) - factor(1, backward:forward) &
               *way(2, backward:forward))/factor(2, backward:forward)
            longest = min(longest, minval(-factor/way, way < 0.0_wp))
         end associate
      end do
   end subroutine measure_directions

   !> Go a share of the direction.
   subroutine take_share(points, share)
      type(interior_type), intent(inout) :: points !< of the list
      real(wp), intent(in) :: share                !< less than the longest
      integer :: c

      !$omp parallel do schedule(static) &
      !$omp if (points%n >= parallel_from)
      do c = 1, points%n
         points%factor(:, :, c) = points%factor(:, :, c) + share*points%factor_way(:, :, c)
         points%shear(c) = points%shear(c) + share*points%shear_way(c)
         points%bound(c) = points%bound(c) + share*points%bound_way(c)
      end do
   end subroutine take_share

   !> Mean product after a share of the direction, (N/m)².
   real(wp) function mean_product(points, share)
      type(interior_type), intent(in) :: points !< of the list
      real(wp), intent(in) :: share             !< of the direction
      real(wp) :: piece(most_pieces)
      integer :: p

      !$omp parallel do schedule(static) &
      !$omp if (points%n >= parallel_from)
      do p = 1, pieces(points%n)
         associate (first => first_of(p, points%n), last => last_of(p, points%n))
            piece(p) = sum(product(points%factor(:, :, first:last) &
               + share*points%factor_way(:, :, first:last), 1))
         end associate
      end do
      mean_product = sum(piece(:pieces(points%n)))/(3*points%n)
   end function mean_product

end module dda_interior_point
