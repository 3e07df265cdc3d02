!> Explicit interfaces of the ARPACK routines in use.
!>
!> Both write to `tol`, so it must be a variable, and both keep saved variables, so they must not
!> run in two threads at once.
module dda_arpack
   use dda_kinds, only: wp
   implicit none
   private
   public :: dsaupd, dseupd

   interface
      !> Implicitly restarted Lanczos iteration, by reverse communication.
      subroutine dsaupd(ido, bmat, n, which, nev, tol, resid, ncv, v, ldv, iparam, ipntr, workd, &
         workl, lworkl, info)
         import :: wp
         integer, intent(inout) :: ido
         character(len=1), intent(in) :: bmat
         integer, intent(in) :: n, nev, ncv, ldv, lworkl
         character(len=2), intent(in) :: which
         real(wp), intent(inout) :: tol, resid(*), v(ldv, *), workd(*), workl(*)
         integer, intent(inout) :: iparam(*), ipntr(*), info
      end subroutine dsaupd

      !> Eigenvalues and vectors from a finished iteration; arguments from `bmat` on as it left
      !> them.
      subroutine dseupd(rvec, howmny, select, d, z, ldz, sigma, bmat, n, which, nev, tol, resid, &
         ncv, v, ldv, iparam, ipntr, workd, workl, lworkl, info)
         import :: wp
         logical, intent(in) :: rvec
         character(len=1), intent(in) :: howmny, bmat
         logical, intent(inout) :: select(*)
         real(wp), intent(inout) :: d(*), z(ldz, *)
         integer, intent(in) :: ldz, n, nev, ncv, ldv, lworkl
         real(wp), intent(in) :: sigma
         character(len=2), intent(in) :: which
         real(wp), intent(inout) :: tol, resid(*), v(ldv, *), workd(*), workl(*)
         integer, intent(inout) :: iparam(*), ipntr(*), info
      end subroutine dseupd
   end interface

end module dda_arpack
