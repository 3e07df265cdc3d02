! SPDX-License-Identifier: GPL-3.0-or-later
!> Models that the suites of the pre-checks share, as input texts.
module check_models
   use dda_kinds, only: wp
   use dda_linear_model, only: linear_model_type, linearise
   use dda_simulation, only: simulation_type
   use dda_text, only: to_text
   use models, only: begin, rock
   use testing, only: check_no_error, error
   implicit none
   private
   public :: layered_site, layered_site_of_table_2, drum_column, brick_wall, plane_strain_heap
   public :: loose_blocks, free_stack, hinged_bar, linear_of

   character(len=*), parameter :: nl = new_line('a')
   character(len=*), parameter :: glue = ' friction_angle=50.0, cohesion=1.0e8, '// &
      'tensile_strength=1.0e8 /'

contains

   !> Text of Table I of the paper: 15 equal layers on a base of the same rock.
   function layered_site(damping) result(text)
      character(len=*), intent(in), optional :: damping  !< in &material
      character(len=:), allocatable :: text, damping_text

      damping_text = ''
      if (present(damping)) damping_text = damping
      text = input_header('1.0e-3', '', '1.5e12')//"&material name='rock', density=2643.0, "// &
         'young_modulus=4.788e9, poisson_ratio=0.25 '//damping_text//' /'//nl// &
         "&layers name='base', bottom=-1.0, width=15.0, thickness=1.0 /"//nl// &
         "&layers name='layer', bottom=0.0, width=15.0, thickness=1.0, count=15 /"//nl// &
         feet(15.0_wp)//"&measured_point name='base', x=7.5, y=-0.5, block='base_1' /"//nl// &
         "&measured_point name='surface', x=7.5, y=14.5, block='layer_15' /"//nl
   end function layered_site

   !> Text of Table II of the paper: five rocks of three layers each, on a base of the lowest rock.
   function layered_site_of_table_2() result(text)
      character(len=:), allocatable :: text
      real(wp), parameter :: density(5) = [2643.0_wp, 2483.0_wp, 2243.0_wp, 2162.0_wp, 2403.0_wp]
      real(wp), parameter :: elastic_modulus(5) = [4.8e9_wp, 4.0e9_wp, 4.2e9_wp, 4.1e9_wp, 4.5e9_wp]
      integer :: i

      text = input_header('1.0e-3', '', '1.5e12')
      do i = 1, 5
         text = text//"&material name='"//to_text(i)//"', density="//to_text(density(i))// &
            ', young_modulus='//to_text(elastic_modulus(i))//', poisson_ratio=0.25 /'//nl
      end do
      text = text//"&layers name='base', material='1', bottom=-1.0, width=15.0, thickness=1.0 /"//nl
      do i = 1, 5
         text = text//"&layers name='rock_"//to_text(i)//"', material='"//to_text(i)// &
            "', bottom="//to_text(3*(i - 1))//'.0, width=15.0, thickness=1.0, count=3 /'//nl
      end do
      text = text//feet(15.0_wp)//"&measured_point name='base', x=7.5, y=-0.5, block='base_1' /"// &
         nl//"&measured_point name='surface', x=7.5, y=14.5, block='rock_5_3' /"//nl
   end function layered_site_of_table_2

   !> Text of ten drums of 0.6 × 0.5 m, E 17 GPa, ν 0.22, ρ 2250, on a base held at four points.
   function drum_column(penalty, settings, is_bonded) result(text)
      character(len=*), intent(in) :: penalty    !< N/m
      character(len=*), intent(in) :: settings       !< in &control
      logical, intent(in), optional :: is_bonded    !< default: yes
      character(len=:), allocatable :: text

      text = input_header('1.0e-3', settings, penalty, is_bonded)// &
         "&material name='stone', density=2250.0, young_modulus=17.0e9, poisson_ratio=0.22 /"// &
         nl//"&layers name='base', left=-0.3, bottom=-0.5, width=0.6, thickness=0.5 /"//nl// &
         "&drums name='drum', centre=0.0, width=0.6, height=0.5, count=10 /"//nl// &
         '&fixed_point x=-0.25, y=-0.4 /'//nl//'&fixed_point x=0.25, y=-0.4 /'//nl// &
         '&fixed_point x=-0.25, y=-0.1 /'//nl//'&fixed_point x=0.25, y=-0.1 /'//nl// &
         "&measured_point name='base', x=0.0, y=-0.25, block='base_1' /"//nl// &
         "&measured_point name='top', x=0.0, y=4.75, block='drum_10' /"//nl
   end function drum_column

   !> Text of a running-bond wall of 1 × 0.5 m bricks on a base held at four points.
   !>
   !> E 10 GPa, ν 0.25, ρ 2500. The displacement ratio keeps the search, whose reach follows the
   !> size of the model, short of a brick.
   function brick_wall(bricks, courses, penalty, settings) result(text)
      integer, intent(in) :: bricks, courses
      character(len=*), intent(in) :: penalty  !< N/m
      character(len=*), intent(in) :: settings     !< in &control
      character(len=:), allocatable :: text

      text = input_header('1.0e-3', ', max_displacement_ratio=0.001'//settings, penalty)// &
         "&material name='clay', density=2500.0, young_modulus=10.0e9, poisson_ratio=0.25 /"//nl// &
         "&layers name='base', bottom=-1.0, width="//to_text(bricks)//'.0, thickness=1.0 /'//nl// &
         "&wall name='brick', brick_length=1.0, brick_height=0.5, bricks="//to_text(bricks)// &
         ', courses='//to_text(courses)//' /'//nl//feet(real(bricks, wp))// &
         "&measured_point name='base', x=0.5, y=-0.5, block='base_1' /"//nl// &
         "&measured_point name='top', x=0.5, y="//to_text(0.5_wp*courses - 0.25_wp)//' /'//nl
   end function brick_wall

   !> Text of the groups &control, &contact and &joint.
   function input_header(time_step, settings, penalty, is_bonded) result(text)
      character(len=*), intent(in) :: time_step, settings, penalty
      logical, intent(in), optional :: is_bonded
      character(len=:), allocatable :: text

      text = '&control time_step='//time_step//', steps=1000'//settings//' /'//nl// &
         '&contact normal_stiffness='//penalty//' /'//nl
      if (present(is_bonded)) then
         if (.not. is_bonded) then
            text = text//"&joint name='joint', friction_angle=40.0 /"//nl
            return
         end if
      end if
      text = text//"&joint name='joint',"//glue//nl
   end function input_header

   !> Text of triangles, a trapezium and rectangles of two rocks in plane strain.
   function plane_strain_heap() result(text)
      character(len=:), allocatable :: text

      text = input_header('1.0e-3', ", analysis='plane_strain'", '3.0e10')// &
         "&material name='hard', density=2700.0, young_modulus=20.0e9, poisson_ratio=0.3 /"//nl// &
         "&material name='soft', density=1900.0, young_modulus=2.0e9, poisson_ratio=0.2 /"//nl// &
         "&block name='floor', material='hard', vertices=0.0,-1.0, 6.0,-1.0, 6.0,0.0, 0.0,0.0 /"// &
         nl//"&block name='left', material='soft', vertices=0.0,0.0, 3.0,0.0, 2.0,1.5, 0.0,1.5 "// &
         '/'//nl//"&block name='right', material='hard', vertices=3.0,0.0, 6.0,0.0, 6.0,1.5, "// &
         '2.0,1.5 /'//nl//"&block name='wedge', material='soft', vertices=0.0,1.5, 4.0,1.5, "// &
         '1.5,3.0 /'//nl//"&block name='chip', material='hard', vertices=4.2,1.5, 5.5,1.5, "// &
         '5.0,2.2 /'//nl//'&fixed_point x=0.5, y=-0.5 /'//nl//'&fixed_point x=5.5, y=-0.6 /'//nl
   end function plane_strain_heap

   !> Text of eleven blocks of one rock that do not touch.
   function loose_blocks() result(text)
      character(len=:), allocatable :: text
      integer :: i

      text = input_header('1.0e-3', ', max_displacement_ratio=0.0004', '1.0e10')// &
         rock//nl
      do i = 0, 10
         text = text//'&layers left='//to_text(2*i)//'.0, bottom=0.0, width=1.0, thickness=0.'// &
            to_text(4 + modulo(i, 3))//' /'//nl
      end do
   end function loose_blocks

   !> Text of a stack without supports.
   function free_stack(count) result(text)
      integer, intent(in) :: count
      character(len=:), allocatable :: text

      text = input_header('1.0e-3', '', '1.0e10')// &
         rock//nl// &
         '&layers width=2.0, thickness=0.5, count='//to_text(count)//' /'//nl
   end function free_stack

   !> Text of one block on one fixed point.
   function hinged_bar(size) result(text)
      real(wp), intent(in) :: size  !< half of its width, m
      character(len=:), allocatable :: text

      text = input_header('1.0e-3', '', '1.0e10')// &
         rock//nl// &
         '&layers width='//to_text(2*size)//', thickness='//to_text(size/2)//' /'//nl// &
         '&fixed_point x='//to_text(size/10)//', y='//to_text(0.4_wp*size)//' /'//nl
   end function hinged_bar

   !> Text of four fixed points in a base block of the given width and 1 m of height below y = 0.
   function feet(width) result(text)
      real(wp), intent(in) :: width
      character(len=:), allocatable :: text
      integer :: i, j

      text = ''
      do i = 1, 2
         do j = 1, 2
            text = text//'&fixed_point x='//to_text(merge(width/6, 5*width/6, i == 1))//', y='// &
               to_text(merge(-0.25_wp, -0.75_wp, j == 1))//' /'//nl
         end do
      end do
   end function feet

   !> Linearise the model of an input text.
   subroutine linear_of(linear, text, contact_choice)
      type(linear_model_type), intent(out) :: linear
      character(len=*), intent(in) :: text, contact_choice
      type(simulation_type) :: simulation

      call begin(simulation, text)
      call linearise(linear, simulation, contact_choice, error)
      call check_no_error(error, 'linearise')
   end subroutine linear_of

end module check_models
