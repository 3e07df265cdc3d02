!> Multifrontal Cholesky in single precision, a preconditioner at half the memory traffic.
module dda_cholesky_single
   use, intrinsic :: iso_c_binding, only: c_loc
   use dda_kinds, only: long, wp, rk => sp
   use dda_blas, only: gemm => sgemm
   ! Modules that the included body uses; named here so that the build sees them.
   use dda_block_graph, only: block_graph_type, graph_of
   use dda_block_matrix, only: block_matrix_type
   use dda_errors, only: error_solver, error_type, fail
   use dda_front_plan, only: front_plan_type, make_plan, widest_part
   use dda_large_pages, only: prefer_large_pages
   use dda_ordering, only: fill_order
   use dda_slices, only: slice_rows, slice_size, slices_of, own_slices
   use dda_text, only: to_text
   !$ use omp_lib, only: omp_get_num_threads, omp_get_thread_num
   include 'cholesky_body.inc'
end module dda_cholesky_single
