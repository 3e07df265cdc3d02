! SPDX-License-Identifier: GPL-3.0-or-later
!> Explicit interfaces of the ARPACK routines that are used.
!>
!> Both routines write to `tol`, which must be a variable.  They have saved variables and must not
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
         integer, intent(inout) :: ido  !< next action; 0 at first
         character(len=1), intent(in) :: bmat  !< 'I': standard problem
         integer, intent(in) :: n, nev, ncv, ldv, lworkl  !< sizes; numbers of eigenvalues, vectors
         character(len=2), intent(in) :: which  !< 'LA': algebraically largest
         !> tolerance, vectors, workspace
         real(wp), intent(inout) :: tol, resid(*), v(ldv, *), workd(*), workl(*)
         integer, intent(inout) :: iparam(*), ipntr(*), info  !< options, pointers, 0 on success
      end subroutine dsaupd

      !> Compute eigenvalues and eigenvectors of a finished iteration.
      !> `bmat` and the arguments after it must be those of the last call of dsaupd.
      subroutine dseupd(rvec, howmny, select, d, z, ldz, sigma, bmat, n, which, nev, tol, resid, &
         ncv, v, ldv, iparam, ipntr, workd, workl, lworkl, info)
         import :: wp
         logical, intent(in) :: rvec  !< compute vectors too
         character(len=1), intent(in) :: howmny, bmat  !< 'A': all; 'I': standard problem
         logical, intent(inout) :: select(*)  !< workspace
         real(wp), intent(inout) :: d(*), z(ldz, *)  !< eigenvalues, ascending, and vectors
         integer, intent(in) :: ldz, n, nev, ncv, ldv, lworkl  !< sizes as for dsaupd
         real(wp), intent(in) :: sigma  !< shift, not used
         character(len=2), intent(in) :: which  !< 'LA': algebraically largest
         !> tolerance, vectors, workspace
         real(wp), intent(inout) :: tol, resid(*), v(ldv, *), workd(*), workl(*)
         integer, intent(inout) :: iparam(*), ipntr(*), info  !< options, pointers, 0 on success
      end subroutine dseupd
   end interface

end module dda_arpack
