//! Points and grid: F14 to F16, F22 to F24.

use crate::cloud::Cloud;
use crate::kit::{
    H, PLASTER, STRONG, blow, body, cuboid, keeps_the_books, problem, rows, solved, told,
};
use cullet_fracture::brittle::{Brittle, grid_bias_warning};
use cullet_fracture::mpm::stencil::{Stencil, gather, packed, vector};
use cullet_geometry::shapes::{Detail, torus};
use cullet_geometry::{Solid, Surface, Vec3, math::unit};
use cullet_model::{
    BrittleProblem, Impact, Material, Refusal, Settings, Solver, Strength, StrengthField,
};
use cullet_plan::brittle::branched;

/// F14: cells are flattened across a plate that bends, and told. One that is hit where the contact,
/// widened to two cells of its plane, would be wider than the plate is thick is refused: it would
/// be punched.
#[test]
fn f14_a_thin_plate_is_flattened_or_refused() {
    let face = blow(Vec3::new(0.0, 0.0, 0.005), -Vec3::z(), 1e-4);
    let edge = blow(Vec3::new(-0.05, 0.0, 0.0), Vec3::x(), 1e-4);
    let plate = |thickness: f64, impact: Impact, spacing: f64| {
        let plate = problem(cuboid(Vec3::new(0.1, 0.1, thickness)), PLASTER, impact);
        let settings =
            Settings { spacing: Some(spacing), max_particles: 200_000, ..Settings::default() };
        BrittleProblem { settings, ..plate }
    };
    match Brittle::begin(plate(0.01, face, 0.005).into()) {
        Err(Refusal::TooThin { thickness, cells, minimum }) => {
            assert!((thickness - 0.01).abs() < 1e-9, "{thickness}");
            assert!(cells < minimum && minimum == 2.0, "{cells} of {minimum}");
        }
        other => panic!("{:?}", other.map(|_| ())),
    }
    assert!(Brittle::begin(plate(0.01, face, 0.003).into()).is_ok());
    let flat = Brittle::begin(plate(0.01, edge, 0.005).into()).expect("flattened");
    let cell = flat.domain().grid.spacing;
    assert!(cell.z < 0.0034 && cell.x > 0.005 && cell.x == cell.y, "{cell}");
    assert!(told("F14", &plate(0.01, edge, 0.005)) && !told("F14", &plate(0.05, edge, 0.01)));
    // A plate of a tenth of a cell is beyond flattening.
    assert!(matches!(
        Brittle::begin(plate(0.0005, edge, 0.005).into()),
        Err(Refusal::TooThin { .. })
    ));
}

/// F15: stretched to seven times its length a body is still one piece and bears what it is
/// stretched with: no point has left its kernel. Kernels laid over where the points are now would
/// have come apart.
#[test]
fn f15_a_sevenfold_stretch_parts_nothing() {
    let now = rows([6, 3, 3]).iter().map(|x| 7.0 * x.x / H).collect::<Vec<_>>();
    let unseen = (-18..=18).filter(|n| now.iter().all(|x| (x - f64::from(*n)).abs() >= 1.5));
    assert!(unseen.count() > 3, "nodes between the points see none");
    stretched(3.0, 8);
    stretched(7.0, 1);
}

/// Holds a body that is drawn out to so many times its length to its stress, and to being one piece
/// so many steps later.
fn stretched(stretch: f64, steps: usize) {
    let mut domain = body(&rows([6, 3, 3]), &STRONG);
    let count = domain.grid.nodes.len();
    domain.displace(|x| (stretch - 1.0) * Vec3::x() * x.x);
    let stresses = domain.stresses();
    // P = F S, and S₁₁ = μ(1 − C⁻¹₁₁) + λ/2 (J² − 1) C⁻¹₁₁ with C₁₁ = J²
    let square = stretch * stretch;
    let wanted =
        STRONG.shear() * (1.0 - 1.0 / square) + 0.5 * STRONG.lame() * (square - 1.0) / square;
    for stress in &stresses {
        assert!((stress[0] / wanted - 1.0).abs() < 1e-9, "{stress:?} of {wanted}");
    }
    domain.advance();
    // Σ m v x = −Δt V P₁₁, whichever nodes the points pull at.
    let nodes = &domain.grid.nodes;
    let places = (0..nodes.len()).map(|n| domain.grid.place(n).x);
    let pulls = nodes.velocity.iter().zip(&nodes.mass).zip(places);
    let pull: f64 = pulls.map(|((v, mass), x)| vector(*v).x * mass * x).sum();
    let volume: f64 = domain.particles.volume.iter().sum();
    let expected = -domain.step * volume * stretch * wanted;
    assert!((pull / expected - 1.0).abs() < 1e-9, "{pull} of {expected}");
    (1..steps).for_each(|_| _ = domain.advance());
    assert_eq!(domain.grid.nodes.len(), count);
    assert!(domain.pieces().iter().all(|piece| *piece == Some(0)), "one piece");
}

/// F16: the strain that a point sees on its way through the cells of a field u = x² is even: it
/// does not jump at their faces, as that of linear kernels does.
#[test]
fn f16_strain_does_not_jump_at_faces() {
    let place = |n: i32| f64::from(n) * H;
    let quadratic = |x: f64| {
        let stencil = Stencil::new(&Vec3::new(x, 0.3 * H, 0.6 * H), &Vec3::repeat(H));
        let value = |k: usize| place(stencil.cell[0] + k as i32 / 9).powi(2);
        let nodes = std::array::from_fn(|k| packed(Vec3::x() * value(k)));
        gather(&nodes, &stencil, &Vec3::repeat(4.0 / H)).1[(0, 0)]
    };
    let linear = |x: f64| {
        let low = libm::floor(x / H) as i32;
        (place(low + 1).powi(2) - place(low).powi(2)) / H
    };
    let jump = |slope: &dyn Fn(f64) -> f64| {
        let ways = (0..400).map(|k| (f64::from(k) - 200.0) * 0.05 * H);
        ways.map(|x| (slope(x + 1e-9 * H) - slope(x - 1e-9 * H)).abs() / H).fold(0.0, f64::max)
    };
    assert!(jump(&quadratic) < 1e-6, "{}", jump(&quadratic));
    assert!((jump(&linear) - 2.0).abs() < 1e-6, "{}", jump(&linear));
    let error = (0..400).map(|k| (f64::from(k) - 200.0) * 0.05 * H);
    let error = error.map(|x| (quadratic(x) - 2.0 * x).abs() / H).fold(0.0, f64::max);
    assert!(error < 1.0, "{error} cells from 2x");
}

/// Share of the directions to the nearest points that lie within 15° of the grid's axes, over that
/// of directions that are all alike likely.
fn along_axes(points: &[Vec3]) -> f64 {
    let near = libm::cos(15_f64.to_radians());
    let along = points.iter().enumerate().filter(|(p, x)| {
        let others = points.iter().enumerate().filter(|(q, _)| q != p).map(|(_, y)| y - *x);
        let next = others.min_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()));
        next.is_some_and(|way| way.amax() > near * way.norm())
    });
    along.count() as f64 / points.len() as f64 / (3.0 * (1.0 - near))
}

/// A block of voxels, all of its faces new.
fn stairs() -> Solid {
    let mesh = cuboid(Vec3::repeat(0.1));
    let surface = vec![Surface::crack(0.0); mesh.triangles.len()];
    Solid { mesh, surface }
}

/// F22: points are scattered, so that they know nothing of the grid's axes, as rows of them do;
/// faces that lie along the grid are told.
#[test]
fn f22_points_know_no_axes_and_faces_that_do_are_told() {
    let cube = problem(cuboid(Vec3::repeat(0.1)), PLASTER, blow(Vec3::x() * -0.05, Vec3::x(), 1.0));
    let solve = Brittle::begin(cube.into()).expect("accepted");
    let scattered = along_axes(&solve.domain().particles.reference);
    let laid = along_axes(&rows([10, 10, 10])[..500]);
    println!("{scattered:.2} of chance, rows {laid:.2}");
    assert!((0.6..1.5).contains(&scattered) && laid > 5.0, "{scattered} and {laid}");
    let cut = |normal: Vec3| {
        let cloud = Cloud::in_cube(0.08, |p| p.dot(&normal).abs() < 0.064);
        let parts = cloud.cut().parts;
        assert_eq!(parts.len(), 2);
        grid_bias_warning(parts.iter().map(|part| &part.solid))
    };
    // A plane crack lies along some grid as often as not; steps in two directions lie in no other.
    assert_eq!(cut(Vec3::y()), None);
    assert_eq!(cut(Vec3::new(1.0, 0.7, 0.5).normalize()), None);
    let words = grid_bias_warning([stairs()].iter()).expect("it leans");
    assert!(words.ends_with("times as often as chance (F22)"), "{words}");
}

/// F22: a ring parts in arcs across its tube, where the band of a crack is as wide as a third of
/// the tube; no fragment of it is a heap of voxels.
#[test]
fn f22_a_ring_breaks_off_the_grid() {
    let ring = torus(0.09, 0.03, Detail::default()).expect("a ring");
    let mut broke = 0;
    for seed in 1..=4 {
        let impact = blow(Vec3::new(0.12, 0.0, 0.0), -Vec3::x(), 3.0);
        let mut problem = problem(ring.clone(), PLASTER, impact);
        problem.settings.max_particles = 8000;
        (problem.seed, problem.strength.seed) = (seed, seed);
        let fracture = solved(&problem);
        keeps_the_books("ring", &problem, &fracture);
        println!("seed {seed}: {} fragments", fracture.fragments.len());
        broke += usize::from(fracture.fragments.len() > 1);
        assert_eq!(
            grid_bias_warning(fracture.fragments.iter().map(|part| &part.solid)),
            None,
            "seed {seed}"
        );
    }
    assert_eq!(broke, 4);
}

/// F23: flaws are smooth over four spacings, and where a scene gives them a length they are the
/// same on every grid; flaws a spacing long would differ from point to point. Half again as many
/// pieces on a finer grid are told.
#[test]
fn f23_flaws_are_longer_than_the_grid() {
    let far: Vec<Vec3> =
        (0..400).map(|i| Vec3::from([0, 1, 2].map(|a| 100.0 * H * unit(5, a, i)))).collect();
    let alike = |grid: f64| {
        let (mut both, mut own) = (0.0, 0.0);
        for seed in 0..6 {
            let strength = Strength::new(&StrengthField { seed, ..StrengthField::default() }, grid);
            for x in &far {
                let one = strength.factor(x) - 1.0;
                both += one * (strength.factor(&(x + Vec3::x() * H)) - 1.0);
                own += one * one;
            }
        }
        both / own
    };
    // exp(−(r/ℓ)²) at ℓ = 4r, and at ℓ = r.
    let (smooth, rough) = (alike(H), alike(0.25 * H));
    assert!(smooth > 0.88 && rough < 0.55, "{smooth} and {rough}");
    let given = StrengthField { correlation: Some(8.0 * H), ..StrengthField::default() };
    let on = |grid: f64| Strength::new(&given, grid);
    assert!(far.iter().all(|x| on(H).factor(x) == on(0.5 * H).factor(x)));
    assert!(branched(10, 15).is_some_and(|words| words.contains("(F23)")));
    assert_eq!(branched(10, 14), None);
}

/// F24: a solve ends when nothing has grown for a while, whatever share is damaged: after a tap at
/// once, and after a blow that crushes a body when all of that is done. A bar that its spin pulls
/// apart is in pieces with a ninth of it damaged; its time is up while it still breaks, as is told.
#[test]
fn f24_a_solve_ends_when_nothing_grows() {
    let cube = |impulse: f64| {
        let hit = blow(Vec3::new(-0.05, 0.01, 0.015), Vec3::x(), impulse);
        problem(cuboid(Vec3::repeat(0.1)), PLASTER, hit)
    };
    let tap = cube(1e-4);
    let (cost, quiet) = (Brittle::accepts(&tap.clone().into()).expect("accepted"), solved(&tap));
    assert_eq!(quiet.fragments.len(), 1);
    assert!((quiet.report.steps as f64) < 0.7 * cost.steps, "{:?}", quiet.report);
    let crushing = cube(6.0);
    let crushed = solved(&crushing);
    keeps_the_books("crushed", &crushing, &crushed);
    // A bar that spins as fast as it can bear: σ = ½ρω²L² in the middle, L = 0.2 m.
    let (gypsum, stress) = (Material { fracture_energy: 200.0, ..PLASTER }, 3.3e6);
    let hit = blow(Vec3::new(0.0, 0.04, 0.0), -Vec3::y(), 0.02);
    let mut bar = problem(cuboid(Vec3::new(0.4, 0.08, 0.08)), gypsum, hit);
    bar.settings.max_particles = 4000;
    bar.spin = Vec3::z() * (2.0 * stress / (PLASTER.density * 0.04)).sqrt();
    let parted = solved(&bar);
    let shares =
        [&parted, &crushed].map(|one| one.report.detail("damaged_fraction").unwrap_or_default());
    let counts = [&parted, &crushed].map(|one| one.fragments.len());
    println!("{counts:?} fragments of {shares:?} damaged");
    assert!(counts[0] > 1 && shares[0] < 0.35, "{counts:?}, {shares:?}");
    assert!(counts[1] > 5 * counts[0] && shares[1] > 0.9, "{counts:?}, {shares:?}");
    let late = [&quiet, &parted]
        .map(|one| one.report.warnings.iter().any(|line| line.starts_with("still breaking")));
    assert_eq!(late, [false, true], "{:?}", parted.report.warnings);
}
