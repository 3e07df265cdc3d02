! SPDX-License-Identifier: GPL-3.0-or-later
!> Groups &in_situ: initial stress of the ground from the weight above each block.
!>
!> σy = −∫ρg dy along the vertical through the centroid, and σx = K₀σy, in addition to the initial
!> stress of the material.  Columns of equal width list the blocks that a vertical line may cross.
module dda_input_in_situ
   use dda_kinds, only: wp
   use dda_counting_sort, only: sort_by_key
   use dda_errors, only: error_type
   use dda_input_group, only: group_type, fail_input, is_set, positions, require_name
   use dda_input_groups, only: in_situ_values, read_values
   use dda_interpolation, only: table_value
   use dda_model, only: model_type
   use dda_text, only: to_text
   implicit none
   private
   public :: read_in_situ

   integer, parameter :: most_columns = 4096
   real(wp), parameter :: touching = 1.0e-6_wp  !< tolerance/half the model size

   !> The blocks in columns of equal width.
   type :: columns_type
      real(wp) :: left, width                      !< left end and width of a column, m
      integer, allocatable :: first(:), block(:)  !< [columns+1] start of columns; blocks by columns
   end type columns_type

   !> Weight and top of the ground above a point.
   type :: cover_type
      real(wp) :: weight = 0.0_wp                  !< weight per area, Pa
      real(wp) :: top = -huge(1.0_wp)              !< highest block, m
      real(wp) :: unit_weight = 0.0_wp             !< unit weight of the highest block, N/m³
   end type cover_type

contains

   !> Read all groups &in_situ of an input.
   subroutine read_in_situ(model, groups, error)
      type(model_type), intent(inout) :: model   !< model with its blocks
      type(group_type), intent(in) :: groups(:)  !< groups of the input, in its order
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(columns_type) :: columns
      type(in_situ_values) :: input
      integer, allocatable :: list(:)
      logical :: is_stressed(size(model%materials)), is_selected(size(model%materials))
      integer :: i, m

      list = positions(groups, 'in_situ')
      if (size(list) == 0) return
      allocate (model%stress_gradient(2, model%blocks%n), source=0.0_wp)
      columns = make_columns(model)
      is_stressed = .false.
      do i = 1, size(list)
         associate (group => groups(list(i)))
            call read_values(group, input, error)
            m = 0
            if (input%material /= '') call require_name(error, group, 'material', input%material, &
               model%materials%name, 'material', m)
            call check_values(group, input, model, error)
            if (allocated(error)) return
            is_selected = m == 0
            if (m > 0) is_selected(m) = .true.
            if (any(is_stressed .and. is_selected)) call fail_input(error, group, &
               'another &in_situ already stresses this material; name each material once')
            is_stressed = is_stressed .or. is_selected
            call set_block_stress(group, input, m, columns, model, error)
         end associate
         if (allocated(error)) return
      end do
   end subroutine read_in_situ

   !> Check that lists match and that gravity acts downwards.
   subroutine check_values(group, input, model, error)
      type(group_type), intent(in) :: group        !< group of the input
      type(in_situ_values), intent(in) :: input    !< values of the group
      type(model_type), intent(in) :: model        !< model with its gravity
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      associate (gravity => model%control%gravity, depth => input%depth, x => input%surface(1, :))
         if (abs(gravity(1)) > 0.0_wp .or. .not. gravity(2) < 0.0_wp) call fail_input(error, &
            group, 'initial stress needs gravity that acts downwards; gravity is '// &
            to_text(gravity))
         if (size(input%k0) > 1 .and. size(depth) /= size(input%k0)) call fail_input(error, group, &
            '`k0` has '//to_text(size(input%k0))//' values and `depth` has '// &
            to_text(size(depth))//': give one `depth` for each `k0`')
         if (size(depth) > 0 .and. size(input%k0) /= size(depth)) call fail_input(error, group, &
            '`depth` requires one value of `k0` for each depth')
         if (any(depth(2:) <= depth(:size(depth) - 1))) call fail_input(error, group, &
            'the values of `depth` must ascend')
         if (any(x(2:) <= x(:size(x) - 1))) call fail_input(error, group, &
            'the points of `surface` must be given from left to right')
         if (is_set(input%unit_weight) .and. size(input%surface, 2) == 0) call fail_input(error, &
            group, 'unit_weight applies to ground between the model and `surface`: give `surface`')
      end associate
   end subroutine check_values

   !> Set the stress of the blocks of material m, or of all blocks.
   subroutine set_block_stress(group, input, m, columns, model, error)
      type(group_type), intent(in) :: group        !< group of the input
      type(in_situ_values), intent(in) :: input    !< values of the group
      integer, intent(in) :: m                     !< number of the material; 0: all
      type(columns_type), intent(in) :: columns    !< columns of the blocks
      type(model_type), intent(inout) :: model     !< model whose blocks receive stress
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(cover_type) :: cover
      real(wp) :: surface_level, ratio
      integer :: b

      do b = 1, model%blocks%n
         associate (blocks => model%blocks, material => model%materials(model%blocks%material(b)))
            if (m > 0 .and. blocks%material(b) /= m) cycle
            associate (x => blocks%position(1, b), y => blocks%position(2, b))
               cover = cover_above(model, columns, x, y)
               surface_level = cover%top
               if (size(input%surface, 2) > 0) surface_level = table_value(input%surface(1, :), &
                  input%surface(2, :), x + model%origin(1)) - model%origin(2)
               if (surface_level < cover%top - touching*blocks%half_size) call fail_input(error, &
                  group, '`surface` is '//to_text(cover%top - surface_level)//' m below the '// &
                  'top of the model at x = '//to_text(x + model%origin(1)))
               if (allocated(error)) return
               if (is_set(input%unit_weight)) cover%unit_weight = input%unit_weight
               cover%weight = cover%weight + cover%unit_weight*max(0.0_wp, surface_level - &
                  cover%top)
               ratio = material%poisson_ratio/(1.0_wp - material%poisson_ratio)
               if (size(input%k0) == 1) ratio = input%k0(1)
               if (size(input%depth) > 0) ratio = table_value(input%depth, input%k0, &
                  surface_level - y)
               blocks%initial_stress(1:2, b) = blocks%initial_stress(1:2, b) &
                  - cover%weight*[ratio, 1.0_wp]
               model%stress_gradient(:, b) = norm2(model%control%gravity)*material%density &
                  *[ratio, 1.0_wp]
            end associate
         end associate
      end do
   end subroutine set_block_stress

   !> Weight and top of the ground above a point; upper edges of blocks add weight, lower edges
   !> subtract.
   pure function cover_above(model, columns, x, y) result(cover)
      type(model_type), intent(in) :: model      !< model with its blocks
      type(columns_type), intent(in) :: columns  !< columns of the blocks
      real(wp), intent(in) :: x, y               !< m
      type(cover_type) :: cover
      real(wp) :: height, unit_weight
      integer :: c, i, v, b

      associate (blocks => model%blocks)
         c = column_at(columns, x)
         do i = columns%first(c), columns%first(c + 1) - 1
            b = columns%block(i)
            unit_weight = norm2(model%control%gravity)*model%materials(blocks%material(b))%density
            do v = blocks%first(b), blocks%first(b + 1) - 1
               associate (from => blocks%vertex(:, v), to => blocks%vertex(:, blocks%next(v)))
                  if ((from(1) <= x) .eqv. (to(1) <= x)) cycle
                  height = from(2) + (x - from(1))/(to(1) - from(1))*(to(2) - from(2))
                  cover%weight = cover%weight + sign(unit_weight*max(0.0_wp, height - y), &
                     from(1) - to(1))
                  if (height <= cover%top) cycle
                  cover%top = height
                  cover%unit_weight = unit_weight
               end associate
            end do
         end do
      end associate
   end function cover_above

   !> Build the columns with the blocks of a model.
   function make_columns(model) result(columns)
      type(model_type), intent(in) :: model  !< model with its blocks
      type(columns_type) :: columns
      integer, allocatable :: key(:), block_of(:), order(:)
      integer :: span(2, model%blocks%n), b, c, n, k

      associate (blocks => model%blocks, x => model%blocks%vertex(1, :))
         n = min(most_columns, blocks%n)
         columns%left = minval(x)
         columns%width = (maxval(x) - columns%left)/n
         allocate (columns%first(n + 1))
         do b = 1, blocks%n
            associate (input => x(blocks%first(b):blocks%first(b + 1) - 1))
               span(:, b) = [column_at(columns, minval(input)), column_at(columns, maxval(input))]
            end associate
         end do
         k = sum(span(2, :) - span(1, :) + 1)
         allocate (key(k), block_of(k))
         k = 0
         do b = 1, blocks%n
            do c = span(1, b), span(2, b)
               k = k + 1
               key(k) = c
               block_of(k) = b
            end do
         end do
         call sort_by_key(n, key, columns%first, order)
         columns%block = block_of(order)
      end associate
   end function make_columns

   !> Column that contains a vertical line.
   pure integer function column_at(columns, x) result(c)
      type(columns_type), intent(in) :: columns  !< with their widths
      real(wp), intent(in) :: x                  !< m

      c = min(size(columns%first) - 1, 1 + int((x - columns%left)/columns%width))
   end function column_at

end module dda_input_in_situ
