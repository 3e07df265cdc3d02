! SPDX-License-Identifier: GPL-3.0-or-later
!> Modulus reduction and damping of soils over the shear strain, by formulas.
!>
!> Darendeli (2001), Development of a new family of normalized modulus reduction and material
!> damping curves, PhD, The University of Texas at Austin; Matasovic and Vucetic (1993), J. Geotech.
!> Eng. 119(11) (MKZ); Groholski et al. (2016), J. Geotech. Geoenviron. Eng. 142(9) (GQ/H).
module dda_soil_curves
   use dda_kinds, only: wp, pi
   use dda_branches, only: curve_type
   use dda_errors, only: error_type, error_input, fail
   use dda_interpolation, only: log_spaced
   use dda_text, only: to_text
   implicit none
   private
   public :: soil_type, find_curve

   integer, parameter :: samples = 91  !< number of strains in a table
   integer, parameter :: parts = 60    !< parts of an interval, in integrals of Masing's rules
   integer, parameter :: intervals_below = 60    !< intervals below the table, in these integrals
   real(wp), parameter :: strains(2) = [1.0e-6_wp, 0.0316227766016837933_wp]
   real(wp), parameter :: atmosphere = 101325.0_wp  !< Pa

   !> A soil, described by the parameters of its formula.
   type :: soil_type
      character(len=16) :: curve = ''         !< darendeli, hyperbolic, mkz, gqh or table
      real(wp) :: plasticity = 0.0_wp         !< PI, per cent
      real(wp) :: stress = atmosphere         !< mean effective stress, Pa
      real(wp) :: consolidation = 1.0_wp      !< OCR
      real(wp) :: frequency = 1.0_wp          !< frequency of the loading, Hz
      real(wp) :: cycles = 10.0_wp            !< loading cycles
      real(wp) :: reference = 0.0_wp          !< γ_r
      real(wp) :: factor = 1.0_wp             !< β of MKZ
      real(wp) :: power = 1.0_wp              !< s of MKZ
      real(wp) :: theta(5) = 0.0_wp           !< θ₁ … θ₅ of GQ/H
      type(curve_type) :: table               !< table given by the user
   end type soil_type

contains

   !> Curves of a soil; damping by Masing's rules if its formula has no damping.
   subroutine find_curve(soil, curve, error)
      type(soil_type), intent(in) :: soil     !< soil as described in the input
      type(curve_type), intent(out) :: curve  !< table of its curves
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      real(wp) :: fine((intervals_below + samples - 1)*parts + 1), largest_theta

      if (soil%curve == 'table') then
         curve = soil%table
         return
      end if
      curve%strain = log_spaced(strains(1), strains(2), samples)
      if (soil%curve == 'darendeli') then
         call add_darendeli(soil, curve)
         return
      end if
      fine = log_spaced(strains(1)*(strains(1)/strains(2))**(real(intervals_below, wp)/(samples - &
         1)), strains(2), size(fine))
      if (soil%curve == 'gqh') then
         largest_theta = maxval(gqh_theta(soil, fine/soil%reference))
         if (largest_theta > 1.0_wp) call fail(error, error_input, 'curve_fit gives θ = '// &
            to_text(largest_theta)//': θ must not exceed 1 at any strain')
         if (allocated(error)) return
      end if
      curve%reduction = min(1.0_wp, modulus_reduction(soil, curve%strain))
      curve%damping = masing_damping(fine, modulus_reduction(soil, fine))
   end subroutine find_curve

   !> Modulus ratio G_s/G of a formula at strains.
   elemental real(wp) function modulus_reduction(soil, strain)
      type(soil_type), intent(in) :: soil  !< soil as described in the input
      real(wp), intent(in) :: strain       !< above 0
      real(wp) :: x

      x = strain/soil%reference
      select case (soil%curve)
      case ('gqh')
         modulus_reduction = 2.0_wp/(1.0_wp + x + sqrt((1.0_wp + x)**2 - 4.0_wp*gqh_theta(soil, &
            x)*x))
      case ('mkz')
         modulus_reduction = 1.0_wp/(1.0_wp + soil%factor*x**soil%power)
      case default
         modulus_reduction = 1.0_wp/(1.0_wp + x)
      end select
   end function modulus_reduction

   !> θ of GQ/H at a strain divided by γ_r.
   elemental real(wp) function gqh_theta(soil, x) result(theta)
      type(soil_type), intent(in) :: soil  !< soil as described in the input
      real(wp), intent(in) :: x            !< above 0
      real(wp) :: power

      power = soil%theta(4)*x**soil%theta(5)
      theta = soil%theta(1) + soil%theta(2)*power/(soil%theta(3)**soil%theta(5) + power)
   end function gqh_theta

   !> Damping by Masing's rules at the strains of a table: D = (2/π) [2 ∫τ dγ/(τγ) − 1].
   !> The integral is computed by the trapezoidal rule; the soil is linear up to the first strain.
   pure function masing_damping(strain, reduced) result(damping)
      real(wp), intent(in) :: strain(:), reduced(:)  !< [(below + samples − 1) parts + 1] γ, G_s/G
      real(wp) :: damping(samples), stress(size(strain)), work
      integer :: i, k

      stress = strain*reduced
      work = 0.5_wp*strain(1)*stress(1)
      k = 0
      do i = 2, size(strain)
         work = work + 0.5_wp*(strain(i) - strain(i - 1))*(stress(i) + stress(i - 1))
         if (i < intervals_below*parts + 1 .or. mod(i - 1, parts) /= 0) cycle
         k = k + 1
         damping(k) = max(0.0_wp, 2.0_wp/pi*(2.0_wp*work/(stress(i)*strain(i)) - 1.0_wp))
      end do
   end function masing_damping

   !> Add Darendeli's curves; damping is constant where his polynomial would decrease.
   pure subroutine add_darendeli(soil, curve)
      type(soil_type), intent(in) :: soil       !< soil as described in the input
      type(curve_type), intent(inout) :: curve  !< curve; its strains are set
      real(wp), parameter :: a = 0.919_wp
      real(wp), parameter :: c(3) = [-1.1143_wp*a**2 + 1.8618_wp*a + 0.2523_wp, &
         0.0805_wp*a**2 - 0.0710_wp*a - 0.0095_wp, -0.0005_wp*a**2 + 0.0002_wp*a + 0.0003_wp]
      real(wp) :: reference, minimum, x, loop, stress
      integer :: i

      stress = soil%stress/atmosphere
      reference = 0.01_wp*(0.0352_wp + 0.0010_wp*soil%plasticity*soil%consolidation**0.3246_wp) &
         *stress**0.3483_wp
      minimum = (0.8005_wp + 0.0129_wp*soil%plasticity*soil%consolidation**(-0.1069_wp)) &
         *stress**(-0.2889_wp)*(1.0_wp + 0.2919_wp*log(soil%frequency))
      allocate (curve%reduction(samples), curve%damping(samples))
      do i = 1, samples
         x = curve%strain(i)/reference
         curve%reduction(i) = 1.0_wp/(1.0_wp + x**a)
         loop = 100.0_wp*hyperbola_loop(x)
         curve%damping(i) = 0.01_wp*(minimum + (0.6329_wp - 0.00566_wp*log(soil%cycles)) &
            *curve%reduction(i)**0.1_wp*loop*(c(1) + loop*(c(2) + loop*c(3))))
         if (i > 1) curve%damping(i) = max(curve%damping(i), curve%damping(i - 1))
      end do
      curve%damping = max(0.0_wp, min(0.999_wp, curve%damping))
   end subroutine add_darendeli

   !> Damping ratio by Masing's rules of a hyperbolic soil at a strain divided by γ_r.
   pure real(wp) function hyperbola_loop(x) result(ratio)
      real(wp), intent(in) :: x  !< above 0

      if (x < 1.0e-3_wp) then
         ratio = (2.0_wp*x/3.0_wp - x**2/3.0_wp)/pi
      else
         ratio = (4.0_wp*(x - log(1.0_wp + x))*(1.0_wp + x)/x**2 - 2.0_wp)/pi
      end if
   end function hyperbola_loop

end module dda_soil_curves
