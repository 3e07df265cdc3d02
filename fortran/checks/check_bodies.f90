! SPDX-License-Identifier: GPL-3.0-or-later
!> Checks of bodies and their cells.
module dda_check_bodies
   use dda_kinds, only: wp, pi
   use dda_blocks, only: blocks_type, position_of
   use dda_check_report, only: add_check, add_line, report_type, verdict_warn
   use dda_counting_sort, only: sort_by_key
   use dda_elements, only: body_energies
   use dda_model, only: model_type
   use dda_simulation, only: simulation_type
   use dda_text, only: counted, to_text, short_text, quoted
   use dda_weld, only: weld_type, is_shifted
   implicit none
   private
   public :: body_or_block_count, block_count_text, dispersion_text, check_bodies

   integer, parameter :: bending_cells = 4  !< sufficient number of cells across a part that bends
   real(wp), parameter :: facing = -0.866_wp     !< cosine between edges that face each other
   !> start of rays as a fraction of the edge, not in its middle
   real(wp), parameter :: ray_fraction = 0.53_wp
   real(wp), parameter :: max_stress_error = 0.2_wp    !< largest stress error without a warning
   real(wp), parameter :: slender = 3.0_wp       !< largest length/height of cells in offset rows
   real(wp), parameter :: min_offset = 0.1_wp  !< smallest offset/edge length of offset rows

   !> Thinnest part of a body.
   type :: thinnest_type
      integer :: cells = huge(1)       !< number of cells across the part
      real(wp) :: width = 0.0_wp       !< m
      integer :: cell = 0              !< cell at one side of the part
   end type thinnest_type

contains

   !> Number of bodies plus blocks outside bodies.
   pure integer function body_or_block_count(model)
      type(model_type), intent(in) :: model  !< model with its blocks

      body_or_block_count = size(model%body_names) + count(model%blocks%body == 0)
   end function body_or_block_count

   !> Text on the numbers of blocks, bodies and cells.
   pure function block_count_text(model) result(text)
      type(model_type), intent(in) :: model  !< model with its blocks
      character(len=:), allocatable :: text

      text = counted(to_text(body_or_block_count(model)), 'block', 'blocks')
      if (size(model%body_names) > 0) text = text//', '//to_text(size(model%body_names))// &
         ' of '//to_text(count(model%blocks%body > 0))//' cells'
   end function block_count_text

   !> Text on the error of the speed of S waves along a row of blocks or cells.
   !> The relative error is +(kΔx)²/24 in blocks, and −(kΔx)²/48 in cells of bodies.
   function dispersion_text(blocks, eta) result(text)
      type(blocks_type), intent(in) :: blocks  !< blocks
      real(wp), intent(in) :: eta              !< block size over wavelength, Δx/λ
      character(len=:), allocatable :: text

      if (any(blocks%body > 0)) then
         text = short_text(100*(2.0_wp*pi*eta)**2/48.0_wp)//' % too slow'
      else
         text = short_text(100*(2.0_wp*pi*eta)**2/24.0_wp)//' % too fast'
      end if
   end function dispersion_text

   !> Check the resolution of bodies by their cells: number of cells across the thinnest part,
   !> slender cells in offset rows, and error of initial stresses.
   subroutine check_bodies(simulation, report)
      type(simulation_type), intent(in) :: simulation  !< a run and its state
      type(report_type), intent(inout) :: report  !< check report
      type(thinnest_type) :: thinnest
      real(wp) :: energies(2), error
      integer :: offset

      associate (model => simulation%model, blocks => simulation%blocks)
         if (size(model%body_names) == 0) return
         thinnest = thinnest_part(blocks, model%welds, model%boundary_edges%part%edge, &
            blocks%body > 0)
         if (thinnest%cell > 0) call add_check(report, thinnest%cells >= bending_cells, 'cells', &
            'body '//quoted(trim(model%body_names(blocks%body(thinnest%cell))))//' has '// &
            to_text(thinnest%cells)//' cells across its thinnest part of '// &
            short_text(thinnest%width)//' m; bending requires '//to_text(bending_cells), &
            'deflection of a beam', 'if this part bends, use cells of '// &
            short_text(thinnest%width/bending_cells)//' m')
         call check_yielding(model, blocks, report)
         offset = find_offset_cell(blocks, model%welds)
         if (offset > 0) call add_line(report, verdict_warn, 'cells', 'cells of body '// &
            quoted(trim(model%body_names(blocks%body(offset))))//' in offset rows are longer '// &
            'than '//short_text(slender)//' times their height, so S waves along the rows are '// &
            'about 10 % too fast', 'dispersion of Bloch waves', 'shorter cells')
         energies = body_energies(simulation%elements, blocks)
         if (.not. energies(2) > 0.0_wp) return
         error = sqrt(energies(1)/energies(2))
         call add_check(report, error <= max_stress_error, 'cells', 'the initial stresses of '// &
            'bodies have an error of about '//short_text(100*error)//' % in the energy norm', &
            'stress jumps at faces', 'smaller cells')
      end associate
   end subroutine check_bodies

   !> Warn if a body of yielding material is less than four cells thick.
   !> A cell yields by its mean stress, without the bending stress within the cell.
   subroutine check_yielding(model, blocks, report)
      type(model_type), intent(in) :: model        !< model with its materials
      type(blocks_type), intent(in) :: blocks      !< blocks in their present state
      type(report_type), intent(inout) :: report   !< check report
      type(thinnest_type) :: thinnest
      logical :: yields(size(model%materials))
      integer :: m

      yields = [(model%materials(m)%yields(), m=1, size(yields))]
      thinnest = thinnest_part(blocks, model%welds, model%boundary_edges%part%edge, &
         blocks%body > 0 .and. yields(blocks%material))
      if (thinnest%cell == 0 .or. thinnest%cells >= bending_cells) return
      call add_line(report, verdict_warn, 'cells', 'yielding body '//quoted(trim(model%body_names( &
         blocks%body(thinnest%cell))))//' has only '//to_text(thinnest%cells)//' cells across '// &
         short_text(thinnest%width)//' m; cells yield by their mean stress, so bending parts '// &
         'with fewer than '//to_text(bending_cells)//' cells are too strong', &
         'mean stress of a cell', 'cells of '//short_text(thinnest%width/bending_cells)//' m')
   end subroutine check_yielding

   !> Find the thinnest part: fewest cells between two opposite free sides of a body.
   pure type(thinnest_type) function thinnest_part(blocks, welds, bounded, examined) &
      result(thinnest)
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(weld_type), intent(in) :: welds(:)  !< welds of all bodies
      integer, intent(in) :: bounded(:)        !< edges with a boundary
      logical, intent(in) :: examined(:)         !< [blocks] cells whose sides are examined
      integer, allocatable :: first(:), weld(:)
      logical :: is_free_side(size(blocks%owner))
      integer :: b, e, i, cells
      real(wp) :: width

      call sort_by_key(blocks%n, [(welds(i)%block, i=1, size(welds))], first, weld)
      weld = (weld + 1)/2
      is_free_side = .not. blocks%inner
      is_free_side(bounded) = .false.
      do b = 1, blocks%n
         if (.not. examined(b)) cycle
         do e = blocks%first(b), blocks%first(b + 1) - 1
            if (.not. is_free_side(e)) cycle
            call count_crossed_cells(blocks, welds, first, weld, is_free_side, e, cells, width)
            if (cells > 0 .and. cells < thinnest%cells) thinnest = thinnest_type(cells, width, b)
         end do
      end do
   end function thinnest_part

   !> Count the cells that a ray from an edge crosses up to an opposite side.
   !> The count is 0 if there is no opposite side.
   pure subroutine count_crossed_cells(blocks, welds, first, weld, is_free_side, edge, cells, width)
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(weld_type), intent(in) :: welds(:)  !< welds of all bodies
      integer, intent(in) :: first(:), weld(:) !< first weld of each cell; welds by cells
      logical, intent(in) :: is_free_side(:)           !< [vertices] the edge is a free side
      integer, intent(in) :: edge              !< free edge, by its first vertex
      integer, intent(out) :: cells            !< number of cells that the ray crosses
      real(wp), intent(out) :: width           !< length of the ray, m
      real(wp) :: position(2), direction(2), distance
      integer :: cell, exit_edge

      position = blocks%vertex(:, edge) + ray_fraction*blocks%length(edge)*blocks%along(:, edge)
      direction = [-blocks%along(2, edge), blocks%along(1, edge)]
      cell = blocks%owner(edge)
      exit_edge = edge
      width = 0.0_wp
      do cells = 1, blocks%n
         call find_exit_edge(blocks, cell, position, direction, exit_edge, distance)
         if (exit_edge == 0) exit
         width = width + distance
         position = position + distance*direction
         if (is_free_side(exit_edge)) then
            if (dot_product(blocks%along(:, exit_edge), blocks%along(:, edge)) < facing) return
            exit
         end if
         exit_edge = edge_welded_at(blocks, welds(weld(first(cell):first(cell + 1) - 1)), &
            exit_edge, position)
         if (exit_edge == 0) exit
         cell = blocks%owner(exit_edge)
      end do
      cells = 0
   end subroutine count_crossed_cells

   !> Edge that is welded to a given edge at a position; 0 if there is none.
   pure integer function edge_welded_at(blocks, welds, edge, position) result(welded_edge)
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(weld_type), intent(in) :: welds(:)  !< welds of the cell of the edge
      integer, intent(in) :: edge              !< edge by its first vertex
      real(wp), intent(in) :: position(2)            !< m
      real(wp), parameter :: half_edge = 0.5001_wp  !< half of an edge, with tolerance
      integer :: i

      welded_edge = 0
      do i = 1, size(welds)
         if (all(welds(i)%edge /= edge)) cycle
         if (is_shifted(welds(i))) cycle
         if (norm2(position_of(blocks, welds(i)%block(1), welds(i)%middle(:, 1)) - position) &
            > half_edge*welds(i)%length) cycle
         welded_edge = welds(i)%edge(merge(2, 1, welds(i)%edge(1) == edge))
         return
      end do
   end function edge_welded_at

   !> Find the edge at which a ray leaves a cell, and the distance from the entry.
   pure subroutine find_exit_edge(blocks, cell, entry_point, direction, edge, distance)
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      integer, intent(in) :: cell              !< convex cell
      real(wp), intent(in) :: entry_point(2), direction(2)  !< entry, m; unit vector of the ray
      integer, intent(inout) :: edge           !< edge of entry; edge of exit, or 0
      real(wp), intent(out) :: distance        !< m
      real(wp) :: outward, edge_distance
      integer :: e, entry_edge

      entry_edge = edge
      edge = 0
      distance = huge(1.0_wp)
      do e = blocks%first(cell), blocks%first(cell + 1) - 1
         if (e == entry_edge) cycle
         associate (normal => [blocks%along(2, e), -blocks%along(1, e)])
            outward = dot_product(normal, direction)
            if (.not. outward > 0.0_wp) cycle
            edge_distance = max(0.0_wp, dot_product(normal, blocks%vertex(:, e) - &
               entry_point)/outward)
         end associate
         if (.not. edge_distance < distance) cycle
         distance = edge_distance
         edge = e
      end do
   end subroutine find_exit_edge

   !> Find a slender cell in offset rows, in which faces are shorter than both edges; 0 if none.
   pure integer function find_offset_cell(blocks, welds) result(cell)
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(weld_type), intent(in) :: welds(:)  !< welds of all bodies
      real(wp) :: heights(2), lengths(2)
      integer :: i

      cell = 0
      do i = 1, size(welds)
         lengths = blocks%length(welds(i)%edge)
         if (welds(i)%length > (1.0_wp - min_offset)*minval(lengths)) cycle
         heights = blocks%area(welds(i)%block)/lengths
         if (all(lengths <= slender*heights)) cycle
         cell = welds(i)%block(1)
         return
      end do
   end function find_offset_cell

end module dda_check_bodies
