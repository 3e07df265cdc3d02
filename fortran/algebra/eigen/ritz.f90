!> Ritz vectors of a load: a small model that answers one excitation as the large one does.
!>
!> The Krylov space of Gᵀ(K − σM)⁻¹G from the load itself is made by Lanczos steps, each kept
!> orthogonal to all before.  The static answer is in it exactly, and modes that the load does not
!> excite are not.
module dda_ritz
   use dda_kinds, only: wp
   use dda_arnoldi, only: operator_type
   use dda_dense_eigen, only: symmetric_eigen
   use dda_errors, only: error_type
   implicit none
   private
   public :: ritz_type, start_ritz, extend_ritz, solve_ritz

   !> Lanczos basis and the eigenvalues of the operator in it.
   type :: ritz_type
      integer :: m = 0                        !< basis vectors
      logical :: complete = .false.           !< the space is invariant: the answers are exact
      real(wp) :: load = 0.0_wp               !< length of the load vector
      !> [size,room] orthonormal basis; q(:,1) along the load
      real(wp), allocatable :: q(:,:)
      real(wp), allocatable :: alpha(:)       !< [room] diagonal of T
      !> [room] sub-diagonal of T; beta(m) leads out of the space
      real(wp), allocatable :: beta(:)
      real(wp), allocatable :: value(:)       !< [m] eigenvalues of T, ascending
      real(wp), allocatable :: vector(:,:)    !< [m,m] eigenvectors of T
   end type ritz_type

contains

   !> Begin with a load (in coordinates of the standard problem) and room for some vectors.
   subroutine start_ritz(ritz, load, room)
      type(ritz_type), intent(out) :: ritz  !< with its first vector
      real(wp), intent(in) :: load(:)  !< [6n]
      integer, intent(in) :: room  !< at least 1

      allocate (ritz%q(size(load), room + 1), ritz%alpha(room), ritz%beta(room))
      ritz%load = norm2(load)
      ritz%complete = .not. ritz%load > 0.0_wp
      ritz%q(:, 1) = 0.0_wp
      if (.not. ritz%complete) ritz%q(:, 1) = load/ritz%load
   end subroutine start_ritz

   !> Add vectors until there are `wanted` or the space is invariant.
   subroutine extend_ritz(ritz, operator, wanted)
      type(ritz_type), intent(inout) :: ritz  !< its basis grows
      class(operator_type), intent(inout) :: operator  !< its products are counted
      integer, intent(in) :: wanted  !< vectors, at most the room
      real(wp), parameter :: nothing = 1.0e-13_wp  !< of the first diagonal element
      real(wp) :: w(size(ritz%q, 1))
      integer :: pass, i

      do while (ritz%m < wanted .and. .not. ritz%complete)
         ritz%m = ritz%m + 1
         associate (m => ritz%m)
            call operator%apply(ritz%q(:, m), w)
            operator%products = operator%products + 1
            ritz%alpha(m) = dot_product(ritz%q(:, m), w)
            do pass = 1, 2
               do i = m, 1, -1
                  w = w - dot_product(ritz%q(:, i), w)*ritz%q(:, i)
               end do
            end do
            ritz%beta(m) = norm2(w)
            ritz%complete = ritz%beta(m) <= nothing*abs(ritz%alpha(1)) .or. m == size(w)
            if (ritz%complete) ritz%beta(m) = 0.0_wp
            ritz%q(:, m + 1) = 0.0_wp
            if (.not. ritz%complete) ritz%q(:, m + 1) = w/ritz%beta(m)
         end associate
      end do
   end subroutine extend_ritz

   !> Eigenvalues and vectors of T.
   subroutine solve_ritz(ritz, error)
      type(ritz_type), intent(inout) :: ritz  !< gets values and vectors
      type(error_type), allocatable, intent(out) :: error  !< LAPACK has failed
      integer :: i

      if (allocated(ritz%vector)) deallocate (ritz%vector)
      allocate (ritz%vector(ritz%m, ritz%m), source=0.0_wp)
      do i = 1, ritz%m
         ritz%vector(i, i) = ritz%alpha(i)
         if (i < ritz%m) ritz%vector(i + 1, i) = ritz%beta(i)
      end do
      call symmetric_eigen(ritz%vector, ritz%value, error)
   end subroutine solve_ritz

end module dda_ritz
