! SPDX-License-Identifier: GPL-3.0-or-later
!> Elasticity of a welded face, represented by springs.
!>
!> The energy of a face depends on ten deformations: the mean jump [u] and the linear
!> jump [u]_l of the displacement across it, in axes that turn with its cells, and the strains of
!> both cells.  With A_f = A_i + A_j, n from cell i to j, h = 2A_f/L and one material
!>
!>     ε_f = (A_i ε_i + A_j ε_j)/A_f − (L/A_f) sym(n ⊗ [u]) ,
!>     W = ½ A_f ε_f·Dε_f + (L/h) (½ μ |[u]|² + E′ |[u]_l|²/6) .
!>
!> For an isotropic material the first term consists of springs on ε_x + ε_y, ε_x − ε_y and γ, so a
!> face has seven springs with constant weights.  Between two materials each side has its own
!> strain, and the face has a displacement u* that minimises the energy.  Four springs then act on
!> strains (six minus two that u* eliminates) and four on jumps, with harmonic means of the moduli.
module dda_weld_springs
   use dda_kinds, only: wp
   use dda_weld, only: weld_type
   implicit none
   private
   public :: weld_springs_type, springs_of, n_deformations, max_springs, cell_strain, &
      strains_of, jump_stiffness

   integer, parameter :: n_deformations = 10  !< [u], [u]_l, ε_i, ε_j
   integer, parameter :: max_springs = 8
   !> positions of the strains of both cells among the deformations
   integer, parameter :: cell_strain(3, 2) = reshape([5, 6, 7, 8, 9, 10], [3, 2])

   !> Springs of a face.
   type :: weld_springs_type
      integer :: n = 0                                    !< number of springs
      real(wp) :: stiffness(max_springs) = 0.0_wp        !< c, per metre of thickness
      real(wp) :: weight(n_deformations, max_springs) = 0.0_wp  !< w: the stretch is w·q
   end type weld_springs_type

contains

   !> Return the springs of a face between two materials.
   pure type(weld_springs_type) function springs_of(weld, moduli) result(springs)
      type(weld_type), intent(in) :: weld        !< face
      real(wp), intent(in) :: moduli(3, 3, 2)    !< elastic matrices D of both cells, Pa
      real(wp) :: stiffness(2)

      if (all(moduli(:, :, 1) == moduli(:, :, 2))) then
         call add_common_strain(springs, weld, moduli(:, :, 1))
      else
         call add_two_strains(springs, weld, moduli)
      end if
      stiffness = jump_stiffness(weld, moduli)
      call add_jumps(springs, 0, stiffness(1))
      call add_jumps(springs, 2, stiffness(2))
   end function springs_of

   !> Return the stiffness of the springs on the mean jump and on the linear jump, N/m per metre.
   pure function jump_stiffness(weld, moduli) result(stiffness)
      type(weld_type), intent(in) :: weld        !< face
      real(wp), intent(in) :: moduli(3, 3, 2)    !< elastic matrices D of both cells, Pa
      real(wp) :: stiffness(2), shear, stretch, ratio

      shear = harmonic_mean(moduli(3, 3, 1), moduli(3, 3, 2))
      stretch = harmonic_mean(plate_modulus(moduli(:, :, 1)), plate_modulus(moduli(:, :, 2)))
      ratio = 0.5_wp*weld%length**2/sum(weld%area)  ! L/h
      stiffness = [ratio*shear, ratio*stretch/3.0_wp]
   end function jump_stiffness

   !> Append springs on both components of a jump.
   pure subroutine add_jumps(springs, offset, stiffness)
      type(weld_springs_type), intent(inout) :: springs  !< springs; two are added
      integer, intent(in) :: offset         !< number of deformations before the jump
      real(wp), intent(in) :: stiffness     !< N/m per metre of thickness
      integer :: axis

      do axis = 1, 2
         springs%n = springs%n + 1
         springs%stiffness(springs%n) = stiffness
         springs%weight(:, springs%n) = 0.0_wp
         springs%weight(offset + axis, springs%n) = 1.0_wp
      end do
   end subroutine add_jumps

   !> Return the harmonic mean 2ab/(a + b).
   pure real(wp) function harmonic_mean(a, b)
      real(wp), intent(in) :: a, b  !< moduli, Pa

      harmonic_mean = a
      if (a /= b) harmonic_mean = 2.0_wp*a*b/(a + b)
   end function harmonic_mean

   !> Return E′ of a body: E in plane stress, E/(1 − ν²) in plane strain.
   pure real(wp) function plate_modulus(d) result(modulus)
      real(wp), intent(in) :: d(3, 3)  !< elastic matrix, Pa

      modulus = d(1, 1) - d(1, 2)**2/d(2, 2)
   end function plate_modulus

   !> Return the matrix that maps a jump u to the strains ε_x, ε_y, γ of sym(n ⊗ u).
   pure function jump_strain(weld) result(b)
      type(weld_type), intent(in) :: weld  !< face
      real(wp) :: b(3, 2)

      associate (nx => weld%along(2), ny => -weld%along(1))
         b = reshape([nx, 0.0_wp, ny, 0.0_wp, ny, nx], [3, 2])
      end associate
   end function jump_strain

   !> Find the combinations of ε_x, ε_y, γ that isotropy uncouples, and their moduli.
   pure subroutine separate_moduli(d, area, combination, stiffness)
      real(wp), intent(in) :: d(3, 3), area  !< elastic matrix, Pa; area, m²
      real(wp), intent(out) :: combination(3, 3)  !< one combination per column
      real(wp), intent(out) :: stiffness(3)  !< N/m per metre of thickness

      combination = reshape([1.0_wp, 1.0_wp, 0.0_wp, 1.0_wp, -1.0_wp, 0.0_wp, &
         0.0_wp, 0.0_wp, 1.0_wp], [3, 3])
      stiffness = area*[0.5_wp*(d(1, 1) + d(1, 2)), d(3, 3), d(3, 3)]
   end subroutine separate_moduli

   !> Append three springs on the common strain of a face.
   pure subroutine add_common_strain(springs, weld, d)
      type(weld_springs_type), intent(inout) :: springs  !< springs; three are added
      type(weld_type), intent(in) :: weld    !< face
      real(wp), intent(in) :: d(3, 3)        !< elastic matrix, Pa
      real(wp) :: combination(3, 3)

      associate (k => springs%n)
         call separate_moduli(d, sum(weld%area), combination, springs%stiffness(k + 1:k + 3))
         springs%weight(:, k + 1:k + 3) = matmul(transpose(common_strain_matrix(weld)), combination)
         k = k + 3
      end associate
   end subroutine add_common_strain

   !> Return the matrix that maps the deformations to ε_f.
   pure function common_strain_matrix(weld) result(strain)
      type(weld_type), intent(in) :: weld  !< face
      real(wp) :: strain(3, n_deformations)
      integer :: i, k

      strain = 0.0_wp
      strain(:, 1:2) = -weld%length/sum(weld%area)*jump_strain(weld)
      do k = 1, 2
         do i = 1, 3
            strain(i, cell_strain(i, k)) = weld%area(k)/sum(weld%area)
         end do
      end do
   end function common_strain_matrix

   !> Return the matrices that map the deformations to the strains of both sides.
   !> For equal moduli both strains are ε_f; otherwise u* equalises the tractions of both sides.
   pure function strains_of(weld, moduli) result(strain)
      type(weld_type), intent(in) :: weld      !< face
      real(wp), intent(in) :: moduli(3, 3, 2)  !< elastic matrices D of both cells, Pa
      real(wp) :: strain(3, n_deformations, 2)
      real(wp) :: jump(3, 2, 2), stiffness(2, 2)
      real(wp) :: traction(2, n_deformations), face_term(2, n_deformations)
      integer :: i, k

      strain = spread(common_strain_matrix(weld), 3, 2)
      if (all(moduli(:, :, 1) == moduli(:, :, 2))) return
      strain = 0.0_wp
      stiffness = 0.0_wp
      traction = 0.0_wp
      ! u* is relative to u_j, so all of [u] is on the first side: ε_i − (L/A_i) sym(n ⊗ [u]), ε_j.
      do k = 1, 2
         jump(:, :, k) = merge(1.0_wp, -1.0_wp, k == 1)*weld%length/weld%area(k)*jump_strain(weld)
         do i = 1, 3
            strain(i, cell_strain(i, k), k) = 1.0_wp
         end do
         if (k == 1) strain(:, 1:2, k) = -jump(:, :, k)
         face_term = weld%area(k)*matmul(transpose(jump(:, :, k)), matmul(moduli(:, :, k), &
            strain(:, :, k)))
         traction = traction + face_term
         stiffness = stiffness + weld%area(k)*matmul(transpose(jump(:, :, k)), &
            matmul(moduli(:, :, k), jump(:, :, k)))
      end do
      face_term = -matmul(inverse(stiffness), traction)
      do k = 1, 2
         strain(:, :, k) = strain(:, :, k) + matmul(jump(:, :, k), face_term)
      end do
   end function strains_of

   !> Return the inverse of a matrix.
   pure function inverse(matrix)
      real(wp), intent(in) :: matrix(2, 2)  !< regular matrix
      real(wp) :: inverse(2, 2)

      inverse = reshape([matrix(2, 2), -matrix(2, 1), -matrix(1, 2), matrix(1, 1)], [2, 2]) &
         /(matrix(1, 1)*matrix(2, 2) - matrix(1, 2)*matrix(2, 1))
   end function inverse

   !> Append springs on the strains of both sides; u* eliminates two of them.
   !>
   !> In √c s = B q + C u* the columns of C are made orthonormal.  The part of B q orthogonal to
   !> them does not depend on u* and gives the minimum of the energy over u*.
   pure subroutine add_two_strains(springs, weld, moduli)
      type(weld_springs_type), intent(inout) :: springs  !< springs; four are added
      type(weld_type), intent(in) :: weld      !< face
      real(wp), intent(in) :: moduli(3, 3, 2)  !< elastic matrices D of both cells, Pa
      real(wp) :: combination(3, 3), stiffness(3), jump(3, 2)
      real(wp) :: basis(6, 6), on_deformations(6, n_deformations), size_of
      integer :: side, i, k, n

      on_deformations = 0.0_wp
      do side = 1, 2
         call separate_moduli(moduli(:, :, side), weld%area(side), combination, stiffness)
         combination = combination*spread(sqrt(stiffness), 1, 3)
         associate (rows => [(3*(side - 1) + i, i=1, 3)])
            on_deformations(rows, cell_strain(:, side)) = transpose(combination)
            jump = weld%length/weld%area(side)*matmul(transpose(combination), jump_strain(weld))
            ! First side −(u_i − u*), second side (u_j − u*); u* is relative to u_j, so [u] is on
            ! the first side.
            if (side == 1) on_deformations(rows, 1:2) = -jump
            basis(rows, 1:2) = merge(1.0_wp, -1.0_wp, side == 1)*jump
         end associate
      end do
      basis(:, 3:6) = 0.0_wp
      n = 2
      call orthonormalise(basis, 1, size_of)
      call orthonormalise(basis, 2, size_of)
      do i = 1, 6
         if (n == 6) exit
         basis(:, n + 1) = 0.0_wp
         basis(i, n + 1) = 1.0_wp
         call orthonormalise(basis, n + 1, size_of)
         if (size_of < 0.3_wp) cycle
         n = n + 1
         k = springs%n + 1
         springs%n = k
         springs%stiffness(k) = 1.0_wp
         springs%weight(:, k) = matmul(basis(:, n), on_deformations)
      end do
   end subroutine add_two_strains

   !> Make column k orthogonal to earlier columns, with length 1.
   pure subroutine orthonormalise(basis, k, size_of)
      real(wp), intent(inout) :: basis(:,:)  !< vectors; columns 1 … k − 1 are orthonormal
      integer, intent(in) :: k               !< column
      real(wp), intent(out) :: size_of       !< length of the orthogonal part
      integer :: i, pass

      do pass = 1, 2
         do i = 1, k - 1
            basis(:, k) = basis(:, k) - dot_product(basis(:, i), basis(:, k))*basis(:, i)
         end do
         if (pass == 1) size_of = norm2(basis(:, k))
      end do
      if (size_of > 0.0_wp) basis(:, k) = basis(:, k)/norm2(basis(:, k))
   end subroutine orthonormalise

end module dda_weld_springs
