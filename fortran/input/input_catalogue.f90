! SPDX-License-Identifier: GPL-3.0-or-later
!> Everything that an input may say, published once: the groups and, of each variable, its kind,
!> unit, default, allowed values and meaning.  The reader checks by it; Python and the documents ask
!> for it.
module dda_input_catalogue
   use dda_kinds, only: wp
   use dda_linear_solver, only: solver_names
   use dda_record_format, only: known_formats
   use dda_record_units, only: known_units
   use dda_text, only: closest, joined, quoted, to_text
   implicit none
   private
   public :: variable_type, input_groups, find_variable, all_variables, range_of
   public :: built_groups, unknown_group, unknown_variable, above_zero, usable, most_blocks, &
      most_vertices

   !> A group of the namelist file.
   type :: group_entry_type
      character(len=14) :: name
      logical :: repeats          !< may appear more than once
   end type group_entry_type

   real(wp), parameter :: usable = 1.0e30_wp           !< no input number is larger
   real(wp), parameter :: above_zero = tiny(1.0_wp)    !< as `lowest`: any positive number
   real(wp), parameter :: most_blocks = 2.0e6_wp       !< of a group
   integer, parameter :: most_vertices = 512           !< of a block
   character(len=*), parameter :: solvers = "'"//trim(solver_names(1))//"', '"// &
      trim(solver_names(2))//"', '"//trim(solver_names(3))//"', '"//trim(solver_names(4))// &
      "', '"//trim(solver_names(5))//"', '"//trim(solver_names(6))//"'"

   !> A variable of a group.
   type :: variable_type
      character(len=26) :: name
      character(len=9) :: kind                !< 'real', 'integer', 'text', 'logical', or a list
      character(len=12) :: unit               !< blank: a pure number or a text
      character(len=44) :: default            !< in words; 'required' if there is none
      character(len=256) :: meaning           !< one line
      real(wp) :: lowest = -usable, highest = usable  !< of each number
      !> of a text: "'one', 'another'", or in words what it may be
      character(len=64) :: allowed = ''
      character(len=14) :: group = ''         !< set by `all_variables`
   end type variable_type

   type(group_entry_type), parameter :: input_groups(*) = [ &
      group_entry_type('run', .false.), group_entry_type('control', .false.), &
      group_entry_type('contact', .false.), group_entry_type('output', .false.), &
      group_entry_type('material', .true.), group_entry_type('joint', .true.), &
      group_entry_type('motion', .true.), group_entry_type('block', .true.), &
      group_entry_type('blocks', .true.), &
      group_entry_type('layers', .true.), group_entry_type('drums', .true.), &
      group_entry_type('wall', .true.), group_entry_type('fixed_point', .true.), &
      group_entry_type('boundary', .true.), group_entry_type('bolt', .true.), &
      group_entry_type('traction', .true.), group_entry_type('water', .true.), &
      group_entry_type('load', .true.), group_entry_type('measured_point', .true.), &
      group_entry_type('stage', .true.), group_entry_type('amplification', .true.), &
      group_entry_type('stop', .false.)]

   !> Groups that the package turns into blocks.
   character(len=15), parameter :: built_groups(*) = [character(len=15) :: 'region', 'surface', &
      'joint_line', 'joint_set', 'voronoi', 'hole', 'tunnel', 'excavation', 'cutting', 'arch', &
      'pier', 'lintel', 'colonnade', 'retaining_wall', 'multi_leaf_wall', 'polygons']

   type(variable_type), parameter :: naming_variables(2) = [ &
      variable_type('material', 'text', '', 'the first', &
         'material of the blocks', allowed='the name of a &material'), &
      variable_type('joint', 'text', '', 'the first', &
         'joint of their sides', allowed='the name of a &joint')]

   type(variable_type), parameter :: generated_variables(1) = [ &
      variable_type('name', 'text', '', "'layer', 'drum' or 'brick'", &
         'the blocks are name_1, name_2 …', allowed='at most 56 characters')]

   type(variable_type), parameter :: own_name_variables(1) = [ &
      variable_type('name', 'text', '', 'blank', 'name of the block', allowed='any')]

   type(variable_type), parameter :: point_variables(3) = [ &
      variable_type('x', 'real', 'm', 'required', 'place of the point'), &
      variable_type('y', 'real', 'm', 'required', 'place of the point'), &
      variable_type('block', 'text', '', 'the first that holds the point', &
         'block that the point belongs to', allowed='the name or number of a block')]

   type(variable_type), parameter :: edge_variables(4) = [ &
      variable_type('side', 'text', '', 'any', 'edges on a side of the box round the model, or '// &
         'that face upwards', allowed="'left', 'right', 'bottom', 'top', 'surface'"), &
      variable_type('along', 'real list', 'm', 'anywhere', &
         'x, y, x, y …: edges on a polyline of 2 to 256 points; of an edge, what lies on it'), &
      variable_type('blocks', 'text', '', 'all', &
         'blocks that the edges belong to', allowed="names: 'one, two, all_*'"), &
      variable_type('edges', 'real list', '', 'all', &
         'numbers of edges of these blocks, 1 from their first vertex on', 1.0_wp, 512.0_wp)]

   type(variable_type), parameter :: run_variables(1) = [ &
      variable_type('title', 'text', '', 'blank', 'title of the run', allowed='any')]

   type(variable_type), parameter :: control_variables(17) = [ variable_type('time_step', 'real', &
      's', 'required', 'Δt; the largest one when adaptive', 1.0e-15_wp, 1.0e9_wp), &
      variable_type('steps', 'integer', '', 'this or duration', 'number of steps of Δt', 1.0_wp, &
      1.0e12_wp), variable_type('duration', 'real', 's', 'this or steps', &
      'duration of the run, rounded to whole steps', above_zero), &
      variable_type('time_step_control', 'text', '', "'fixed'", &
      'adaptive: Δt shrinks when a step does not close or moves too far, then recovers', &
      allowed="'fixed', 'adaptive'"), variable_type('least_time_step', 'real', 's', &
      '10⁻⁶ time_step', 'smallest Δt when adaptive', above_zero), &
      variable_type('max_displacement_ratio', 'real', '', '0.01', &
      'largest displacement of a step over half the model size; sets the distance at '// &
      "which contacts are listed, at most a fifth of the smallest block's radius; "// &
      'exceeded steps are repeated when adaptive, counted when fixed', 1.0e-8_wp, 1.0_wp), &
      variable_type('dynamic_factor', 'real', '', '1', &
      'share of the velocity carried into each step: 1 dynamic, 0 static', 0.0_wp, 1.0_wp), &
      variable_type('integration', 'text', '', "'dda'", &
      'dda: Newmark with β = ½, γ = 1; midpoint: no damping; theta: θ-method; backward_euler', &
      allowed="'dda', 'midpoint', 'theta', 'backward_euler'"), variable_type('theta', 'real', '', &
      '0.75', "θ = χ of integration = 'theta'; damping ratio (θ − ½) ω Δt", 0.5_wp, 1.0_wp), &
      variable_type('damping_ratio', 'real', '', 'none', &
      "in place of theta: wanted of integration = 'theta' at damping_frequency", 0.0_wp, 10.0_wp), &
      variable_type('damping_frequency', 'real', 'Hz', 'none', &
      'frequency of damping_ratio, below 1/(2 time_step)', above_zero), variable_type('gravity', &
      'real list', 'm/s²', '0, 0', 'acceleration of gravity, x and y'), variable_type('settle', &
      'logical', '', '.false.', 'the model is brought to rest under gravity and the loads of '// &
      'time 0 before the first '//'step; displacements count from there'), &
      variable_type('analysis', 'text', '', "'plane_stress'", 'elastic law of the blocks; '// &
      'required where materials have velocities, or a boundary absorbs or has a free field', &
      allowed="'plane_stress', 'plane_strain'"), variable_type('base_motion_x', 'text', '', &
      'none', 'motion whose acceleration acts as body force along x, in the frame of the base', &
      allowed='the name of a &motion'), variable_type('base_motion_y', 'text', '', 'none', &
      'the same along y', allowed='the name of a &motion'), variable_type('solver', 'text', '', &
      "'auto'", 'direct: sparse Cholesky of 6×6 blocks; lagged: conjugate gradients with an '// &
      'older '//'factor; jacobi: with the diagonal blocks; banded: LAPACK; sor: the '// &
      "original's; "//'auto chooses by size and stiffness', allowed=solvers)]

   type(variable_type), parameter :: contact_variables(7) = [ &
      variable_type('normal_stiffness', 'real', 'N/m', "40 × the largest Young's modulus × 1 m", &
         'penalty stiffness k_n of a closed contact', 1.0e-3_wp, 1.0e18_wp), &
      variable_type('shear_ratio', 'real', '', '2.5', 'k_n / k_s', 1.0e-3_wp, 1.0e6_wp), &
      variable_type('fixed_point_ratio', 'real', '', '100', &
         'stiffness of fixed points / k_n', 1.0e-6_wp, 1.0e6_wp), &
      variable_type('penetration_tolerance', 'real', 'm', '0: penalty alone', &
         'above 0, an augmented Lagrangian drives penetration below it at any penalty', &
         0.0_wp, 1.0e3_wp), &
      variable_type('contact_rules', 'text', '', "'consistent'", &
         "original: the original DDA's open–close rules, for comparison", &
         allowed="'consistent', 'original'"), &
      variable_type('force_tolerance', 'real', '', '10⁻⁹', &
         'of the open–close iteration, over the largest block weight or contact force', &
         1.0e-15_wp, 1.0e-2_wp), &
      variable_type('max_iterations', 'integer', '', '400', &
         'open–close iterations in a step', 2.0_wp, 1.0e4_wp)]

   type(variable_type), parameter :: material_variables(15) = [ &
      variable_type('name', 'text', '', 'blank', &
         'name that block groups refer to', allowed='any, used once'), &
      variable_type('density', 'real', 'kg/m³', 'required', 'density', 1.0e-15_wp, 1.0e15_wp), &
      variable_type('young_modulus', 'real', 'Pa', 'this or velocities', &
         "Young's modulus", 1.0e-6_wp, 1.0e18_wp), &
      variable_type('poisson_ratio', 'real', '', 'this or velocities', &
         "Poisson's ratio", -0.99_wp, 0.499_wp), &
      variable_type('shear_velocity', 'real', 'm/s', 'none', &
         'velocity of S waves; with pressure_velocity in place of young_modulus and '// &
         'poisson_ratio', 1.0e-9_wp, 1.0e9_wp), &
      variable_type('pressure_velocity', 'real', 'm/s', 'none', &
         'velocity of P waves in the solid', 1.0e-9_wp, 1.0e9_wp), &
      variable_type('damping_ratio', 'real', '', '0: none', &
         'damping ratio at all frequencies of damping_band, or at the two rayleigh_frequencies', &
         0.0_wp, 0.5_wp), &
      variable_type('reference_frequency', 'real', 'Hz', '1', &
         'frequency at which a material with a damping ratio at all frequencies has the '// &
         'modulus that is given', 1.0e-9_wp, 1.0e9_wp), &
      variable_type('damping_band', 'real list', 'Hz', '0.1, 50', &
         'lowest and highest frequency of the damping ratio; the time step may lower the '// &
         'highest one where it is not given', 1.0e-9_wp, 1.0e9_wp), &
      variable_type('mechanisms', 'integer', '', 'as many as are needed', &
         'relaxation mechanisms of the damping ratio at all frequencies', 2.0_wp, 16.0_wp), &
      variable_type('rayleigh_alpha', 'real', '1/s', '0', &
         'share α of the mass in the viscosity of Rayleigh damping', 0.0_wp, 1.0e9_wp), &
      variable_type('rayleigh_beta', 'real', 's', '0', &
         'share β of the stiffness in it', 0.0_wp, 1.0e9_wp), &
      variable_type('rayleigh_frequencies', 'real list', 'Hz', 'none', &
         'two frequencies at which Rayleigh damping has damping_ratio', 1.0e-9_wp, 1.0e9_wp), &
      variable_type('initial_stress', 'real list', 'Pa', '0, 0, 0', &
         'σx, σy, τxy at the start, tension positive'), &
      variable_type('initial_velocity', 'real list', 'm/s, rad/s', '0, 0, 0', &
         'velocity of its blocks at the start: x, y, rotation')]

   type(variable_type), parameter :: joint_variables(20) = [ &
      variable_type('name', 'text', '', 'blank', &
         'name that block groups refer to', allowed='any, used once'), &
      variable_type('friction_angle', 'real', 'degrees', 'required', &
         'friction angle; of barton_bandis the residual one, φ_r', 0.0_wp, 89.0_wp), &
      variable_type('cohesion', 'real', 'Pa', '0', &
         'cohesion of joints that are whole at the start, until they break', 0.0_wp, 1.0e15_wp), &
      variable_type('tensile_strength', 'real', 'Pa', '0', &
         'tensile strength of the same', 0.0_wp, 1.0e15_wp), &
      variable_type('law', 'text', '', "'coulomb'", 'mohr_coulomb: peak and residual '// &
         'strength, dilation; barton_bandis: hyperbolic closure, strength of rough walls', &
         allowed="'coulomb', 'mohr_coulomb', 'barton_bandis'"), &
      variable_type('normal_stiffness_per_area', 'real', 'Pa/m', 'normal_stiffness, N/m', &
         'normal stiffness of the joint, times the length that a contact stands for; k_ni of '// &
         'barton_bandis', 1.0_wp, 1.0e18_wp), &
      variable_type('shear_stiffness_per_area', 'real', 'Pa/m', 'the normal one / shear_ratio', &
         'shear stiffness of the joint, likewise', 1.0_wp, 1.0e18_wp), &
      variable_type('residual_friction_angle', 'real', 'degrees', 'friction_angle', &
         'mohr_coulomb: friction angle after failure', 0.0_wp, 89.0_wp), &
      variable_type('residual_cohesion', 'real', 'Pa', '0', &
         'mohr_coulomb: cohesion after failure', 0.0_wp, 1.0e15_wp), &
      variable_type('residual_tensile_strength', 'real', 'Pa', '0', &
         'mohr_coulomb: tensile strength after failure', 0.0_wp, 1.0e15_wp), &
      variable_type('weakening_slip', 'real', 'm', '0: at once', &
         'mohr_coulomb: slip over which peak strength falls to the residual one', 0.0_wp, &
         1.0e6_wp), &
      variable_type('dilation_angle', 'real', 'degrees', '0', &
         'mohr_coulomb: slip lifts the joint by its tangent', 0.0_wp, 60.0_wp), &
      variable_type('dilation_slip', 'real', 'm', 'without limit', &
         'mohr_coulomb: slip after which the joint dilates no more', above_zero), &
      variable_type('jrc', 'real', '', 'required by its law', &
         'barton_bandis: joint roughness coefficient', 0.0_wp, 30.0_wp), &
      variable_type('jcs', 'real', 'Pa', 'required by its law', &
         'barton_bandis: joint wall compressive strength', 1.0_wp, 1.0e12_wp), &
      variable_type('compressive_strength', 'real', 'Pa', 'none', &
         'barton_bandis: σ_c of the rock, which with jrc and jcs gives k_ni and V_m where they '// &
         'are not given', 1.0_wp, 1.0e12_wp), &
      variable_type('max_closure', 'real', 'm', 'from compressive_strength', &
         'barton_bandis: largest closure V_m', 1.0e-12_wp, 1.0e3_wp), &
      variable_type('strength_reduction', 'real', '', '1', &
         'barton_bandis: its shear strength is divided by it', 1.0e-9_wp, 1.0e9_wp), &
      variable_type('restitution', 'real', '', 'none: as the scheme and the step make it', &
         'velocity after an impact over that before it; its unbonded contacts do not ring', &
         0.0_wp, 1.0_wp), &
      variable_type('damping', 'real', 'N s/m', '0', &
         'normal dashpot of each of its closed, unbonded contacts, per metre of thickness; its '// &
         'force is never tensile', 0.0_wp, 1.0e18_wp)]

   type(variable_type), parameter :: motion_variables(12) = [ &
      variable_type('name', 'text', '', 'required', &
         'name that fixed points and base motions refer to', allowed='any, used once'), &
      variable_type('file', 'text', '', 'this or values', &
         'record, relative to the folder of the input', allowed='a readable file'), &
      variable_type('format', 'text', '', "'auto'", &
         'format of the record', allowed=known_formats), &
      variable_type('quantity', 'text', '', "the header's", &
         'quantity of the samples; must agree with the header of the record', &
         allowed="'acceleration', 'velocity', 'displacement'"), &
      variable_type('unit', 'text', '', "the header's", &
         'unit of the samples; must agree with the header of the record', allowed=known_units), &
      variable_type('time_step', 'real', 's', "the header's", &
         'time between samples, where the record does not say', above_zero), &
      variable_type('values', 'real list', 'SI', 'this or file', &
         'samples in the input itself, at most 4096'), &
      variable_type('scale', 'real', '', '1', 'factor on the samples', -1.0e9_wp, 1.0e9_wp), &
      variable_type('taper', 'real', '', '0', &
         'share of the record under a cosine taper', 0.0_wp, 1.0_wp), &
      variable_type('drift_order', 'integer', '', '2 for accelerations, else 0', &
         'order of the least-squares polynomial taken from the velocity', 0.0_wp, 2.0_wp), &
      variable_type('channel', 'integer', '', '1', &
         'section of a COSMOS file, of those of the quantity', 1.0_wp), &
      variable_type('after_end', 'text', '', "'continue' if a velocity is left", &
         'after the record the support goes on with the velocity that is left, or is held; '// &
         "'continue' leaves the end free where drift is removed or displacements are joined", &
         allowed="'continue', 'hold'")]

   type(variable_type), parameter :: block_variables(2) = [ variable_type('vertices', 'real list', &
      'm', 'required', 'x, y, x, y … counter-clockwise, of any simple polygon; at most 512 '// &
      'vertices'), variable_type('edge_joints', 'text list', '', 'joint', &
      'joint of each edge, from the one between the first two vertices on; a blank or missing '// &
      'one is that of the block', allowed='names of &joint groups, at most one an edge')]

   type(variable_type), parameter :: blocks_variables(1) = [ &
      variable_type('file', 'text', '', 'required', &
         'netCDF file of blocks, relative to the folder of the input', allowed='a readable file')]

   type(variable_type), parameter :: layers_variables(5) = [ &
      variable_type('left', 'real', 'm', '0', 'left side of the stack'), &
      variable_type('bottom', 'real', 'm', '0', 'lower side of the first layer'), &
      variable_type('width', 'real', 'm', 'required', 'width of a layer', above_zero), &
      variable_type('thickness', 'real', 'm', 'required', 'thickness of a layer', above_zero), &
      variable_type('count', 'integer', '', '1', 'number of layers', 1.0_wp, most_blocks)]

   type(variable_type), parameter :: drums_variables(6) = [ &
      variable_type('centre', 'real', 'm', '0', 'axis of the column'), &
      variable_type('bottom', 'real', 'm', '0', 'lower side of the first drum'), &
      variable_type('width', 'real', 'm', 'required', &
         'width of the column at its foot', above_zero), &
      variable_type('top_width', 'real', 'm', 'width', 'width at its top', above_zero), &
      variable_type('height', 'real', 'm', 'required', 'height of a drum', above_zero), &
      variable_type('count', 'integer', '', '1', 'number of drums', 1.0_wp, most_blocks)]

   type(variable_type), parameter :: rest_variables(2) = [ &
      variable_type('geostatic', 'logical', '', '.false.', &
         'the blocks begin with the vertical stress of their weight'), &
      variable_type('overburden', 'real', 'Pa', '0', &
         'vertical pressure on the highest block that this stress holds as well', 0.0_wp, &
         1.0e12_wp)]

   type(variable_type), parameter :: wall_variables(7) = [ &
      variable_type('left', 'real', 'm', '0', 'left side of the wall'), &
      variable_type('bottom', 'real', 'm', '0', 'lower side of the first course'), &
      variable_type('brick_length', 'real', 'm', 'required', 'length of a brick', above_zero), &
      variable_type('brick_height', 'real', 'm', 'required', 'height of a brick', above_zero), &
      variable_type('bricks', 'integer', '', '1', &
         'bricks in a course, in running bond', 1.0_wp, 1.0e6_wp), &
      variable_type('courses', 'integer', '', '1', 'number of courses', 1.0_wp, most_blocks), &
      variable_type('head_joint', 'real', 'm', '0', &
         'width by which the joints between bricks of a course are open', 0.0_wp)]

   type(variable_type), parameter :: fixed_point_variables(4) = [ &
      variable_type('name', 'text', '', 'blank', 'name that stages release it by', allowed='any'), &
      variable_type('direction', 'text', '', "'xy'", &
         'directions in which the point is held', allowed="'x', 'y', 'xy', 'none'"), &
      variable_type('motion_x', 'text', '', 'none', &
         'motion that the point follows along x', allowed='the name of a &motion'), &
      variable_type('motion_y', 'text', '', 'none', &
         'motion that the point follows along y', allowed='the name of a &motion')]

   type(variable_type), parameter :: boundary_variables(9) = [ &
      variable_type('name', 'text', '', 'blank', &
         'name in the output, and that stages release fixed edges by', allowed='any'), &
      variable_type('kind', 'text', '', 'required', &
         'fixed; roller: held along its normal; viscous: dashpots; compliant: with a motion; '// &
         'tied: the left side meets the right one; free_field: level ground goes on', &
         allowed="'fixed', 'roller', 'viscous', 'compliant', 'tied', 'free_field'"), &
      variable_type('direction', 'text', '', "'xy'; of a roller 'normal'", &
         'directions that are held; of a boundary that absorbs waves in static stages', &
         allowed="'x', 'y', 'xy', 'normal'"), &
      variable_type('density', 'real', 'kg/m³', "the block's", &
         'density of the half-space behind', 1.0e-15_wp, 1.0e15_wp), &
      variable_type('shear_velocity', 'real', 'm/s', "the block's", &
         'its S wave velocity', above_zero), &
      variable_type('pressure_velocity', 'real', 'm/s', "in the block's ratio", &
         'its P wave velocity', above_zero), &
      variable_type('motion_x', 'text', '', 'none', &
         'motion along x that comes in, or that fixed edges follow', &
         allowed='the name of a &motion'), &
      variable_type('motion_y', 'text', '', 'none', &
         'the same along y', allowed='the name of a &motion'), &
      variable_type('motion_is', 'text', '', "'outcrop'", &
         'outcrop: of the free surface of the half-space; incoming: half of it; within: of the '// &
         'boundary itself, which follows it', allowed="'outcrop', 'incoming', 'within'")]

   type(variable_type), parameter :: bolt_variables(16) = [ &
      variable_type('name', 'text', '', 'required', &
         'name in the output, and that stages add or drop it by', allowed='any, used once'), &
      variable_type('from', 'real list', 'm', 'required', 'x and y of the first end'), &
      variable_type('to', 'real list', 'm', 'required', 'x and y of the other end'), &
      variable_type('from_block', 'text', '', 'the first that holds the point', &
         'block that the first end is in', allowed='the name or number of a block'), &
      variable_type('to_block', 'text', '', 'the first that holds the point', &
         'block that the other end is in', allowed='the name or number of a block'), &
      variable_type('grouted', 'logical', '', '.false.', &
         'springs at each joint that it crosses, in place of one between its ends'), &
      variable_type('compression', 'logical', '', '.false.', 'it takes compression as well'), &
      variable_type('axial_stiffness', 'real', 'N/m', 'required', &
         'force over elongation; grouted: of each joint', 1.0e-3_wp, 1.0e18_wp), &
      variable_type('shear_stiffness', 'real', 'N/m', '0', &
         'grouted: force over slip of each joint', 0.0_wp, 1.0e18_wp), &
      variable_type('pretension', 'real', 'N/m', '0', &
         'axial force when it is put in', 0.0_wp, 1.0e15_wp), &
      variable_type('yield_force', 'real', 'N/m', 'none', &
         'axial force at which it yields', above_zero), &
      variable_type('shear_yield_force', 'real', 'N/m', 'none', &
         'grouted: shear force at which it yields', above_zero), &
      variable_type('rupture_elongation', 'real', 'm', 'none', &
         'elongation since it was put in at which it breaks', above_zero), &
      variable_type('rupture_slip', 'real', 'm', 'none', &
         'grouted: slip since then at which it breaks', above_zero), &
      variable_type('through', 'real list', 'm', 'none', &
         'x and y of the points that a cable passes freely between its ends, in its order'), &
      variable_type('through_block', 'text list', '', 'the first that holds the point', &
         'blocks that these points are in', allowed='names or numbers of blocks')]

   type(variable_type), parameter :: traction_variables(7) = [ &
      variable_type('name', 'text', '', 'blank', 'name that stages add or drop it by', &
         allowed='any, used once'), &
      variable_type('time', 'real list', 's', 'at all times', &
         '2 to 4096 times that do not decrease; linear between, zero outside'), &
      variable_type('normal', 'real list', 'Pa', '0', &
         'pressure on the edges at each of them, or one value'), &
      variable_type('shear', 'real list', 'Pa', '0', &
         'traction along the edges, counter-clockwise round the block'), &
      variable_type('level', 'real list', 'm', 'none', &
         'hydrostatic pressure below this level, in place of normal and shear'), &
      variable_type('unit_weight', 'real', 'N/m³', '9810', 'of the fluid', above_zero), &
      variable_type('follows', 'logical', '', '.true.', &
         'it acts on the edges as they move and turn, else as they were at first')]

   type(variable_type), parameter :: water_variables(11) = [ &
      variable_type('name', 'text', '', 'blank', 'name that stages add or drop it by', &
         allowed='any, used once'), &
      variable_type('surface', 'real list', 'm', 'this or along', &
         'x, y, x, y …: phreatic line, hydrostatic below it; no water beyond its ends'), &
      variable_type('along', 'real list', 'm', 'this or surface', &
         'x, y, x, y …: line along joints or faces with head or pressure at its points'), &
      variable_type('head', 'real list', 'm', 'this or pressure', &
         'level to which water would rise at each point of along'), &
      variable_type('pressure', 'real list', 'Pa', 'this or head', &
         'pressure at each point of along'), &
      variable_type('acts_on', 'text', '', "'all'", 'edges that it acts on', &
         allowed="'all', 'joints', 'faces'"), &
      variable_type('joints', 'text', '', 'all', 'joints of these edges', &
         allowed="names: 'one, two, all_*'"), &
      variable_type('unit_weight', 'real', 'N/m³', '9810', 'of water', above_zero), &
      variable_type('time', 'real list', 's', 'at all times', &
         '2 to 4096 times that do not decrease; linear between, constant outside'), &
      variable_type('rise', 'real list', 'm', '0', &
         'of the surface or the heads at each of them'), &
      variable_type('scale', 'real list', '', '1', 'factor on the pressure at each of them')]

   type(variable_type), parameter :: load_variables(*) = [ &
      variable_type('name', 'text', '', 'blank', 'name that stages begin it by', allowed='any'), &
      variable_type('time', 'real list', 's', 'required', '2 to 4096 times that do not decrease'), &
      variable_type('force_x', 'real list', 'N/m', '0 at all times', &
         'force along x at each of them: linear between, zero outside'), &
      variable_type('force_y', 'real list', 'N/m', '0 at all times', &
         'force along y at each of them')]

   type(variable_type), parameter :: measured_variables(1) = [ &
      variable_type('name', 'text', '', 'required', &
         'name of the point in the output', allowed='any, used once')]

   type(variable_type), parameter :: stage_variables(*) = [ &
      variable_type('name', 'text', '', 'required', &
         'name of the stage in the output', allowed='any, used once'), &
      variable_type('kind', 'text', '', "'dynamic'", &
         'static: to rest, in no time; dynamic: steps of Δt', allowed="'static', 'dynamic'"), &
      variable_type('duration', 'real', 's', 'this or steps', &
         'of a dynamic stage, rounded to whole steps', above_zero), &
      variable_type('steps', 'integer', '', 'this or duration', &
         'of a dynamic stage', 1.0_wp, 1.0e12_wp), &
      variable_type('time_step', 'real', 's', 'that of &control', &
         'Δt of a dynamic stage', 1.0e-15_wp, 1.0e9_wp), &
      variable_type('integration', 'text', '', 'that of &control', &
         'of a dynamic stage', allowed="'dda', 'midpoint', 'theta', 'backward_euler'"), &
      variable_type('theta', 'real', '', 'that of &control', &
         "θ = χ of integration = 'theta'", 0.5_wp, 1.0_wp), &
      variable_type('zero_displacements', 'logical', '', '.false.', &
         'displacements of measured points count from the beginning of the stage'), &
      variable_type('remove', 'text', '', 'none', &
         'blocks that are taken out: excavation', allowed="names: 'one, two, all_*'"), &
      variable_type('release', 'text', '', 'none', &
         'fixed points that let go', allowed="names: 'one, two, all_*'"), &
      variable_type('hold', 'text', '', 'none', &
         'fixed points that hold from now on, where they stand', &
         allowed="names: 'one, two, all_*'"), &
      variable_type('loads', 'text', '', 'none', &
         'loads whose times count from the stage', allowed="names: 'one, two, all_*'"), &
      variable_type('motions', 'text', '', 'none', &
         'motions that begin with the stage; others begin with the first dynamic one', &
         allowed="names: 'one, two, all_*'"), &
      variable_type('add', 'text', '', 'none', &
         'bolts, tractions and water that begin with the stage; others are there from the start', &
         allowed="names: 'one, two, all_*'"), &
      variable_type('drop', 'text', '', 'none', &
         'bolts, tractions and water that end with it', allowed="names: 'one, two, all_*'"), &
      variable_type('change_joints', 'text', '', 'none', &
         'joints in place of others from now on', allowed="'old -> new, old -> new'"), &
      variable_type('change_materials', 'text', '', 'none', &
         'materials in place of others; stresses stay', allowed="'old -> new, old -> new'")]

   type(variable_type), parameter :: amplification_variables(6) = [ &
      variable_type('surface', 'text', '', "'surface'", &
         'point whose acceleration spectrum is divided', allowed='the name of a &measured_point'), &
      variable_type('base', 'text', '', "'base'", &
         'point whose acceleration spectrum divides', allowed='the name of a &measured_point'), &
      variable_type('direction', 'text', '', "'x'", &
         'component of the acceleration', allowed="'x', 'y'"), &
      variable_type('lowest', 'real', 'Hz', 'required', &
         'lower end of the band in which the peak is sought', above_zero), &
      variable_type('highest', 'real', 'Hz', 'required', &
         'its upper end, above lowest', above_zero), &
      variable_type('padding', 'integer', '', '8', &
         'length of the series with zeros over its length', 1.0_wp, 64.0_wp)]

   type(variable_type), parameter :: stop_variables(7) = [ &
      variable_type('displacement', 'real', 'm', 'no limit', &
         'of the centroid of a block, beyond which the run ends', above_zero), &
      variable_type('tilt', 'real', 'degrees', 'no limit', &
         'of a block, either way, beyond which the run ends', above_zero), &
      variable_type('fallen', 'integer', '', 'no limit', &
         'blocks displaced by more than they are large (√area): collapse', 1.0_wp, most_blocks), &
      variable_type('rest_time', 'real', 's', 'no end by rest', &
         'time without movement, in the last stage, after motions and loads', above_zero), &
      variable_type('rest_movement', 'real', 'm', "10⁻⁶ of the model's larger side", &
         'of a vertex within rest_time, up to which nothing moves', above_zero), &
      variable_type('blocks', 'text', '', "'*': all", &
         'blocks that are watched', allowed="names: 'one, two, all_*'"), &
      variable_type('reference', 'text', '', 'none: first places', &
         'block that displacement and tilt count against', allowed='the name of a block')]

   type(variable_type), parameter :: output_variables(7) = [ &
      variable_type('file', 'text', '', "the input's name with .nc", &
         'netCDF-4 output, relative to the working folder', allowed='a name at or below it'), &
      variable_type('history_interval', 'integer', 'steps', '1', &
         'steps between samples of points and energies', 1.0_wp, 1.0e9_wp), &
      variable_type('history_seconds', 'real', 's', 'by history_interval', &
         'time between samples; adaptive steps end there', above_zero), &
      variable_type('block_interval', 'integer', 'steps', '0: first and last', &
         'steps between frames of blocks and contacts', 0.0_wp, 1.0e9_wp), &
      variable_type('block_seconds', 'real', 's', 'by block_interval', &
         'time between frames; adaptive steps end there', above_zero), &
      variable_type('checkpoint_interval', 'integer', 'steps', '0: none by steps', &
         'steps between checkpoints', 0.0_wp, 1.0e9_wp), &
      variable_type('checkpoint_minutes', 'real', 'min', '1', &
         'minutes of the clock between checkpoints; 0: none by the clock', 0.0_wp, 1.0e6_wp)]

contains

   !> The variables of a group; none if there is no such group.
   pure function variables_of(group) result(list)
      character(len=*), intent(in) :: group           !< name, in lower case
      type(variable_type), allocatable :: list(:)

      select case (group)
      case ('run')
         list = run_variables
      case ('control')
         list = control_variables
      case ('contact')
         list = contact_variables
      case ('output')
         list = output_variables
      case ('material')
         list = material_variables
      case ('joint')
         list = joint_variables
      case ('motion')
         list = motion_variables
      case ('block')
         list = [block_variables, own_name_variables, naming_variables]
      case ('blocks')
         list = [blocks_variables, naming_variables]
      case ('layers')
         list = [layers_variables, rest_variables, generated_variables, naming_variables]
      case ('drums')
         list = [drums_variables, generated_variables, naming_variables]
      case ('wall')
         list = [wall_variables, rest_variables, generated_variables, naming_variables]
      case ('stage')
         list = stage_variables
      case ('amplification')
         list = amplification_variables
      case ('stop')
         list = stop_variables
      case default
         list = acting_variables_of(group)
      end select
   end function variables_of

   !> The variables of a group that acts on blocks or measures them; none of another.
   pure function acting_variables_of(group) result(list)
      character(len=*), intent(in) :: group           !< name, in lower case
      type(variable_type), allocatable :: list(:)

      select case (group)
      case ('fixed_point')
         list = [point_variables, fixed_point_variables]
      case ('boundary')
         list = [boundary_variables(:2), edge_variables, boundary_variables(3:)]
      case ('bolt')
         list = bolt_variables
      case ('traction')
         list = [traction_variables, edge_variables]
      case ('water')
         list = water_variables
      case ('load')
         list = [point_variables, load_variables]
      case ('measured_point')
         list = [measured_variables, point_variables]
      case default
         allocate (list(0))
      end select
   end function acting_variables_of

   !> The variables of all groups, in the order of `input_groups`.
   pure function all_variables() result(list)
      type(variable_type), allocatable :: list(:)
      type(variable_type), allocatable :: of_group(:)
      integer :: g

      allocate (list(0))
      do g = 1, size(input_groups)
         of_group = variables_of(input_groups(g)%name)
         of_group%group = input_groups(g)%name
         list = [list, of_group]
      end do
   end function all_variables

   !> A variable by name; its name is blank if the group has none of that name.
   pure function find_variable(group, name) result(variable)
      character(len=*), intent(in) :: group, name     !< in lower case
      type(variable_type) :: variable
      type(variable_type), allocatable :: list(:)
      integer :: i

      allocate (list, source=variables_of(group))
      i = findloc(list%name == name, .true., 1)
      variable = variable_type('', '', '', '', '')
      if (i > 0) variable = list(i)
   end function find_variable

   !> The allowed values of a variable, in words.
   pure function range_of(variable) result(text)
      type(variable_type), intent(in) :: variable     !< of the catalogue
      character(len=:), allocatable :: text

      if (variable%kind(:4) == 'text') then
         text = trim(variable%allowed)
      else if (variable%kind == 'logical') then
         text = '.true., .false.'
      else if (variable%lowest == above_zero) then
         text = 'above 0'
      else if (variable%lowest == -usable) then
         text = 'any number'
      else if (variable%highest == usable) then
         text = 'at least '//to_text(variable%lowest)
      else
         text = 'between '//to_text(variable%lowest)//' and '//to_text(variable%highest)
      end if
   end function range_of

   !> The message for a group that does not exist: the closest one, or all of them.
   pure function unknown_group(name, file) result(message)
      character(len=*), intent(in) :: name            !< as the input has it
      character(len=*), intent(in) :: file            !< path of the input
      character(len=:), allocatable :: message
      integer :: g

      if (any(built_groups == name)) then
         message = "joints, regions and masonry are turned into blocks by 'sitedda build "//file// &
            "', whose result can be run"
         return
      end if
      g = closest(name, input_groups%name)
      message = 'there is no such group; '
      if (g > 0) message = message//'is &'//trim(input_groups(g)%name)//' meant? '
      message = message//'known are &'//joined(input_groups%name, ', &')
   end function unknown_group

   !> The message for a variable that a group does not have: the closest one of the group, the group
   !> that has it, or all of the group.
   pure function unknown_variable(group, name) result(message)
      character(len=*), intent(in) :: group           !< that exists
      character(len=*), intent(in) :: name            !< as the input has it
      character(len=:), allocatable :: message
      type(variable_type), allocatable :: own(:), all(:)
      integer :: i

      allocate (own, source=variables_of(group))
      allocate (all, source=all_variables())
      message = 'there is no variable '//quoted(name)//' in this group; '
      i = findloc(all%name == name, .true., 1)
      if (i > 0) then
         message = message//'it belongs to &'//trim(all(i)%group)
         return
      end if
      i = closest(name, own%name)
      if (i > 0) message = message//'is '//quoted(own(i)%name)//' meant? '
      message = message//'known are '//joined(own%name, ', ')
   end function unknown_variable

end module dda_input_catalogue
