//! Thin shells: their strains and steps, the copies of control points, the door. The law of a
//! section is in `section`, cracks in `cracks`.

mod cracks;
mod section;

use crate::kit::{Out, PLASTER, blow, cuboid, problem, solve};
use cullet_geometry::Vec3;
use cullet_geometry::nurbs::NurbsPatch;
use cullet_model::{BrittleProblem, Material, Settings};
use cullet_shell::domain::{ShellDomain, ShellMaterial};
use cullet_shell::kernel::PlaneStress;
use cullet_shell::midsurface::Midsurface;
use cullet_shell::section::SectionLaw;
use cullet_simd::SimdLevel;

type Shell = ShellDomain<f64, 9>;

const GLASS: Material = Material {
    density: 2500.0,
    young: 70e9,
    poisson: 0.3,
    failure_stress: 30e6,
    fracture_energy: 8.0,
};

/// t \[m\].
const THICKNESS: f64 = 3e-3;

/// Size of a cell of [`sheet`] \[m\].
const CELL: f64 = 2e-3;

/// A sheet about the origin that nothing breaks until it is given a strength.
fn sheet(cells: [usize; 2]) -> Shell {
    with_law(cells, SectionLaw::new(&GLASS))
}

fn with_law(cells: [usize; 2], law: SectionLaw) -> Shell {
    let size = cells.map(|n| n as f64 * CELL);
    let surface = Midsurface::of_patch(&NurbsPatch::sheet(size, cells, 2).expect("a sheet"));
    let points = surface.points();
    let material = ShellMaterial {
        law,
        density: GLASS.density,
        thickness: vec![THICKNESS; points],
        strength: vec![f64::INFINITY; points],
        softening_cells: 1.1,
    };
    ShellDomain::new(surface, material, SimdLevel::best())
}

fn place(shell: &Shell, point: usize) -> Vec3 {
    shell.surface.surface_point(point).place
}

/// Displaces all control points.
fn displace(shell: &mut Shell, of: impl Fn(&Vec3) -> Vec3) {
    for node in 0..shell.mass.len() {
        let u = of(&shell.surface.nodes[shell.origin[node] as usize]);
        shell.displacement[node] = [u.x, u.y, u.z, 0.0];
    }
}

fn energy(shell: &Shell) -> f64 {
    let sums = shell.sums();
    sums.kinetic + sums.elastic
}

/// Breaks points across a direction, all at once.
fn break_points(shell: &mut Shell, across: impl Fn(&Vec3) -> Option<Vec3>) {
    for point in shell.live() {
        if let Some(normal) = across(&place(shell, point)) {
            let [e1, e2] = shell.surface.surface_point(point).frame();
            shell.notch(point, [e1.dot(&normal), e2.dot(&normal)]);
        }
    }
}

/// F60: a sheet strained along one axis and held along the other stores ½Eε²/(1 − ν²). Three
/// dimensions projected, plane strain, store 1.225 times that.
#[test]
fn f60_the_law_is_plane_stress() {
    let stored = |law: SectionLaw| {
        let mut shell = with_law([8, 8], law);
        displace(&mut shell, |x| Vec3::new(1e-4 * x.x, 0.0, 0.0));
        let volume = (8.0 * CELL).powi(2) * THICKNESS;
        shell.elastic_energy() / (0.5 * GLASS.young / (1.0 - 0.09) * 1e-8 * volume)
    };
    let own = SectionLaw::new(&GLASS);
    // Green's strain is ε + ½ε².
    assert!((stored(own.clone()) - 1.0).abs() < 1.1e-4, "{}", stored(own.clone()));
    let modulus = GLASS.young * 0.7 / (1.3 * 0.4);
    let projected = SectionLaw { elastic: PlaneStress { modulus, poisson: 0.3 / 0.7 }, ..own };
    assert!((stored(projected) - 1.225).abs() < 1e-3);
}

/// F61: forces of a strained sheet turn with it, and do no work in a turn; a stress in the wrong
/// frame does.
#[test]
fn f61_forces_turn_with_the_sheet() {
    let mut shell = sheet([6, 6]);
    let strained = |x: &Vec3| Vec3::new(1e-4 * x.x, -3e-5 * x.y, 0.02 * x.x * x.x / CELL);
    displace(&mut shell, strained);
    shell.strain();
    let nodes = shell.mass.len();
    let before: Vec<Vec3> = (0..nodes).map(|n| shell.force(n)).collect();
    let (sin, cos) = libm::sincos(0.7);
    let turn = |x: &Vec3| Vec3::new(cos * x.x - sin * x.z, x.y, sin * x.x + cos * x.z);
    let stored = shell.elastic_energy();
    displace(&mut shell, |x| turn(&(x + strained(x))) - x);
    shell.strain();
    let largest = before.iter().map(Vec3::norm).fold(0.0, f64::max);
    let off = |wanted: &dyn Fn(&Vec3) -> Vec3| {
        let each = before.iter().enumerate().map(|(n, f)| (shell.force(n) - wanted(f)).norm());
        each.fold(0.0, f64::max) / largest
    };
    assert!((shell.elastic_energy() / stored - 1.0).abs() < 1e-9);
    assert!(off(&turn) < 1e-7, "{}", off(&turn));
    assert!(off(&|f| *f) > 0.1);
}

/// F63, F64, F65: no moving least squares. Whatever is cut, the functions at every point are those
/// of before: their sum is 1, and what they say of a bent sheet is the same to the bit.
#[test]
fn f63_nothing_is_singular_however_much_is_cut() {
    let mut shell = sheet([10, 10]);
    break_points(&mut shell, |x| Some(Vec3::new(x.y, 1e-3 - x.x, 0.0).normalize()));
    for _ in 0..50 {
        shell.advance(|_, v| v);
    }
    assert!(shell.splits() > 50, "{} splits", shell.splits());
    let worst = shell.origin.iter().zip(&shell.mass);
    let whole = sheet([10, 10]).mass;
    let least = worst.map(|(&n, m)| m / whole[n as usize]).fold(f64::INFINITY, f64::min);
    assert!(least > 0.049, "{least}");
    assert!(shell.velocity.iter().all(|v| v.norm() < 1e-9));
}

#[test]
fn f64_a_field_does_not_jump_where_a_sheet_is_cut() {
    let mut shell = sheet([10, 10]);
    let bent = |x: &Vec3| Vec3::new(0.0, 0.0, 0.5 * x.y * x.y);
    displace(&mut shell, bent);
    let read = |shell: &Shell| -> Vec<Vec3> {
        let moved: Vec<Vec3> = (0..shell.mass.len()).map(|n| shell.moved(n)).collect();
        shell.live().map(|p| shell.interpolate(p, &moved)).collect()
    };
    let before = read(&shell);
    break_points(&mut shell, |x| (x.y < 0.0 && x.y > -0.5 * CELL).then(Vec3::y));
    // A step of no length parts control points and moves nothing.
    shell.step = 0.0;
    shell.advance(|_, v| v);
    assert!(shell.splits() > 10);
    let jump = |after: &[Vec3]| {
        let each = before.iter().zip(after).map(|(a, b)| (a - b).norm());
        each.fold(0.0, f64::max)
    };
    assert_eq!(jump(&read(&shell)), 0.0);
    // Least squares beside the cut would be off by κl²/8.
    let off: Vec<Vec3> = before.iter().map(|u| u - Vec3::z() * (CELL * CELL / 8.0)).collect();
    assert!(jump(&off) > 1e-7);
}

#[test]
fn f65_weights_sum_to_one_after_a_cut() {
    let mut shell = sheet([10, 10]);
    break_points(&mut shell, |x| (x.x.abs() < 0.5 * CELL).then(Vec3::x));
    shell.advance(|_, v| v);
    let sums = |factor: f64| -> f64 {
        let of = |p: usize| {
            let (nodes, shares) = shell.functions(p);
            assert!(nodes.iter().all(|&n| (n as usize) < shell.mass.len()));
            let first = shares[0] * (factor - 1.0);
            (shares.iter().sum::<f64>() + first - 1.0).abs()
        };
        shell.live().map(of).fold(0.0, f64::max)
    };
    assert!(shell.splits() > 0 && sums(1.0) < 1e-14, "{}", sums(1.0));
    // A weight that is a per cent off is found.
    assert!(sums(1.01) > 1e-4);
}

/// F69: a sheet that rings keeps its energy; velocities that are filtered by a thousandth do not.
#[test]
fn f69_a_sheet_rings_on() {
    let left = |filter: f64| {
        let mut shell = sheet([8, 8]);
        for (v, x) in shell.velocity.iter_mut().zip(&shell.surface.nodes) {
            v.z = 1e3 * x.x * x.y / CELL;
        }
        let first = energy(&shell);
        let mut mean = 0.0;
        for step in 0..4000 {
            shell.advance(|_, v| v * (1.0 - filter));
            if step >= 3000 {
                mean += energy(&shell) / 1000.0;
            }
        }
        mean / first
    };
    assert!((left(0.0) - 1.0).abs() < 0.02, "{}", left(0.0));
    assert!(left(1e-3) < 0.1);
}

/// F71: the step of bending cells is stable just below its bound and not above.
#[test]
fn f71_the_step_of_a_bending_sheet_is_its_bound() {
    let grown = |share: f64| {
        let mut shell = sheet([10, 10]);
        shell.step = share * shell.stable_step();
        for (n, v) in shell.velocity.iter_mut().enumerate() {
            v.z = f64::from(u32::from(n % 2 == 0)) - 0.5;
        }
        let first = energy(&shell);
        for _ in 0..3000 {
            shell.advance(|_, v| v);
            if energy_is_lost(&shell) {
                return f64::INFINITY;
            }
        }
        energy(&shell) / first
    };
    // Bending decides: membranes alone would allow three times as much.
    const { assert!(CELL < THICKNESS) };
    assert!((grown(0.95) - 1.0).abs() < 0.5, "{}", grown(0.95));
    assert!(grown(1.1) > 1e3, "{}", grown(1.1));
}

fn energy_is_lost(shell: &Shell) -> bool {
    shell.velocity.iter().any(|v| v.norm() > 1e6 || !v.norm().is_finite())
}

/// F88: numbers that fade ahead of a wave are none that processors are slow with: of a sheet whose
/// corner is struck, few are ever below the least normal number.
#[test]
fn f88_few_numbers_are_denormal_ahead_of_a_front() {
    let mut shell = sheet([60, 60]);
    shell.velocity[0] = Vec3::new(0.0, 0.0, 1.0);
    let denormal = |x: &f64| *x != 0.0 && x.abs() < f64::MIN_POSITIVE;
    let mut worst = 0.0_f64;
    for _ in 0..200 {
        shell.advance(|_, v| v);
        let all = shell.velocity.iter().flat_map(|v| v.iter());
        let share = all.filter(|x| denormal(x)).count() as f64 / (3 * shell.mass.len()) as f64;
        worst = worst.max(share);
    }
    println!("F88: {worst:.4} of the numbers at most");
    assert!(worst < 0.05, "{worst}");
    assert!(denormal(&1e-310) && !denormal(&0.0) && !denormal(&1e-300));
}

/// A pane hit in its middle.
fn pane(size: [f64; 3], material: Material, settings: Settings) -> BrittleProblem {
    let hit = blow(Vec3::new(0.0, 0.0, 0.5 * size[2]), -Vec3::z(), 0.5);
    let settings = Settings { max_particles: 4000, ..settings };
    BrittleProblem { settings, ..problem(cuboid(Vec3::from(size)), material, hit) }
}

fn refused(problem: &BrittleProblem) -> Option<String> {
    match solve("shell", problem) {
        Out::Refused(why) => Some(why.to_string()),
        _ => None,
    }
}

/// F70: a striker a thousand times as heavy as the pane gives it no more than it has, and the
/// energy of the solve is accounted for.
#[test]
fn f70_a_heavy_striker_does_not_ring_on_a_light_pane() {
    let strong = Material { failure_stress: 3e8, fracture_energy: 1e6, ..PLASTER };
    let mut heavy = pane([0.12, 0.12, 0.004], strong, Settings::default());
    let mass = 1e3 * 0.12 * 0.12 * 0.004 * PLASTER.density;
    let hit = &mut heavy.impacts[0];
    (hit.closing_speed, hit.impulse, hit.energy) = (0.5, mass * 0.5, 0.125 * mass);
    let Out::Done(done) = solve("shell", &heavy) else { panic!("solved") };
    let balance = done.report.detail("energy_balance").expect("a balance");
    assert!((balance - 1.0).abs() < 0.05, "{balance}");
    let given = done.report.detail("delivered_impulse").expect("an impulse");
    assert!(given > 0.0 && given < 2.0 * mass * 0.5, "{given}");
}

/// F72: a thickness and an energy of cracks are needed.
#[test]
fn f72_a_shell_without_thickness_or_toughness_is_refused() {
    let size = [0.12, 0.12, 0.004];
    let brittle = pane(size, Material { fracture_energy: 0.0, ..PLASTER }, Settings::default());
    assert!(refused(&brittle).expect("refused").contains("fracture energy"));
    let thick = refused(&pane([0.12, 0.12, 0.12], PLASTER, Settings::default()));
    assert!(thick.expect("refused").contains("times as thick"));
    let coarse = Settings { spacing: Some(0.012), ..Settings::default() };
    assert_eq!(refused(&pane(size, PLASTER, coarse)), None);
}

/// F86: cells of more than four thicknesses, which lock in bending, are refused with the bound.
#[test]
fn f86_cells_that_would_lock_are_refused() {
    let spaced = |h: f64| {
        let settings = Settings { spacing: Some(h), ..Settings::default() };
        refused(&pane([0.3, 0.3, 0.004], PLASTER, settings))
    };
    let why = spaced(0.02).expect("refused");
    assert!(why.contains("cells over the thickness") && why.contains('4'), "{why}");
    assert_eq!(spaced(0.015), None);
}

/// F87: two points a direction see every alternating displacement of control points; one, in the
/// middle of a cell, would not.
#[test]
fn f87_no_checkerboard_is_without_energy() {
    let alternating = |n: usize| if (n % 12 + n / 12).is_multiple_of(2) { 1e-6 } else { -1e-6 };
    for axis in 0..3 {
        let mut shell = sheet([10, 10]);
        for n in 0..shell.mass.len() {
            shell.displacement[n][axis] = alternating(n);
        }
        // Of the stiffest of such patterns: e = 2u/l, or κ = 4u/l² over the thickness.
        let strain = match axis {
            2 => 4e-6 / (CELL * CELL) * THICKNESS / 12.0_f64.sqrt(),
            _ => 2e-6 / CELL,
        };
        let volume = (10.0 * CELL).powi(2) * THICKNESS;
        let scale = 0.5 * shell.law.elastic.modulus * strain * strain * volume;
        let share = shell.elastic_energy() / scale;
        println!("F87: axis {axis}: {share:.4}");
        assert!(share > 0.02, "axis {axis}: {share}");
    }
}

/// F84: a sliver of a cell that is cut off leaves no copy lighter than a twentieth, and the step
/// stays stable.
#[test]
fn f84_a_sliver_shortens_no_step() {
    let mut shell = sheet([12, 12]);
    let edge = 6.0 * CELL;
    // One point of a cell between the cut and the edge.
    break_points(&mut shell, |x| (x.y > edge - CELL && x.y < edge - 0.5 * CELL).then(Vec3::y));
    for (n, v) in shell.velocity.iter_mut().enumerate() {
        v.z = f64::from(u32::from(n % 3 == 0)) - 0.3;
    }
    let first = energy(&shell);
    for _ in 0..3000 {
        shell.advance(|_, v| v);
    }
    let whole = sheet([12, 12]).mass;
    let ratios = shell.origin.iter().zip(&shell.mass).map(|(&n, m)| m / whole[n as usize]);
    let least = ratios.fold(f64::INFINITY, f64::min);
    assert!(shell.splits() >= 12 && least >= 0.05 - 1e-12, "{least}");
    assert!(energy(&shell) < 1.5 * first, "{}", energy(&shell) / first);
    // Without the floor a copy of this sliver would weigh next to nothing.
    assert!(least < 0.2, "{least}");
}

/// F85: hundreds of copies, and all move on as the sheet did.
#[test]
fn f85_copies_add_no_momentum() {
    let mut shell = sheet([12, 12]);
    let motion = Vec3::new(1.0, 2.0, 3.0);
    shell.velocity.fill(motion);
    let mass: f64 = shell.mass.iter().sum();
    break_points(&mut shell, |x| {
        let band = ((x.x + x.y) / CELL).floor() as i64;
        (band.rem_euclid(3) == 0).then(|| Vec3::new(1.0, 1.0, 0.0).normalize())
    });
    shell.advance(|_, v| v);
    assert!(shell.splits() > 100, "{} splits", shell.splits());
    let momentum = shell.sums().momentum;
    let added = shell.added_energy() / (0.5 * mass * motion.norm_squared());
    let error = (momentum / mass - motion).norm() / motion.norm();
    println!("F85: {error:.3e} of the momentum, {added:.3e} of the energy");
    assert!((error - added).abs() < 1e-12 && error < 0.02, "{error} {added}");
    assert!(shell.velocity.iter().all(|v| (v - motion).norm() < 1e-9));
}
