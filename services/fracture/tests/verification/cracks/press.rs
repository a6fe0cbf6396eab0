//! F11 and F13: what a striker's contact does to the body under it, on two grids.

use cullet_fracture::brittle::Brittle;
use cullet_fracture::mpm::{load_patch, symmetric};
use cullet_geometry::{Solid, Vec3, shapes};
use cullet_model::{
    BrittleProblem, Impact, Material, Progress, Settings, SolveInProgress, Solver, StrengthField,
    SurfaceLaw,
};
use std::sync::Arc;

const PLASTER: Material = Material {
    density: 1150.0,
    young: 3e9,
    poisson: 0.2,
    failure_stress: 3e6,
    fracture_energy: 5.0,
};
/// Edge of the block \[m\].
const EDGE: f64 = 0.1;

/// What a hit did.
#[derive(Clone, Copy, Debug, Default)]
struct Crater {
    /// Loaded area over that of the Hertz contact \[1\].
    loaded: f64,
    /// Share of broken mass within two contact radii of the contact, as Hertz has it and as the
    /// grid does \[1\].
    near: [f64; 2],
    /// Broken share of the body \[1\].
    broken: f64,
    /// Greatest share of damaged points that bore less than −5 σ_f at once \[1\].
    pressed: f64,
}

/// A ball of `radius` \[m\] and 0.2 kg, as stiff as the block, that hits its face at 5 m/s.
fn hit(radius: f64, spacing: f64) -> (Impact, BrittleProblem) {
    let (mass, speed) = (0.2, 7.0);
    let modulus = PLASTER.young / (1.0 - PLASTER.poisson * PLASTER.poisson) / 2.0;
    let energy = 0.5 * mass * speed * speed;
    // Hertz: ½ m v² = 8/15 E* √R δ^{5/2}, a = √(Rδ), t = 2.943 δ/v.
    let depth = (energy * 15.0 / (8.0 * modulus * radius.sqrt())).powf(0.4);
    let impact = Impact {
        point: Vec3::new(0.0, 0.5 * EDGE, 0.0),
        normal: -Vec3::y(),
        impulse: 2.0 * mass * speed,
        duration: 2.943 * depth / speed,
        radius: (radius * depth).sqrt(),
        energy,
        closing_speed: speed,
        crushing_pressure: 1e12,
    };
    let mesh = shapes::cuboid(Vec3::repeat(EDGE), shapes::Detail::default()).expect("a box");
    let settings =
        Settings { spacing: Some(spacing), max_particles: 200_000, ..Settings::default() };
    let problem = BrittleProblem {
        solid: Arc::new(Solid::outer(mesh)),
        material: PLASTER,
        strength: StrengthField { seed: 7, ..StrengthField::default() },
        surface: SurfaceLaw::of(&PLASTER),
        impacts: vec![impact],
        supports: Vec::new(),
        spin: Vec3::zeros(),
        settings,
        seed: 7,
    };
    (impact, problem)
}

fn crater(radius: f64, spacing: f64) -> Crater {
    let (impact, problem) = hit(radius, spacing);
    let mut run = Brittle::begin(problem.into()).expect("accepted");
    let mut crater = Crater::default();
    let wide = run.domain().particles.reference.iter().zip(&run.domain().particles.shielded);
    let reach = wide.filter(|(_, under)| **under).map(|(x, _)| x.xz().norm()).fold(0.0, f64::max);
    crater.loaded = (reach / impact.radius).powi(2);
    while run.domain().time < 2.0 * impact.duration {
        let Progress::Running(_) = SolveInProgress::advance(&mut run) else { break };
        let particles = &run.domain().particles;
        let (mut damaged, mut pressed) = (0.0, 0.0);
        for (s, damage) in run.domain().stresses().iter().zip(&particles.damage) {
            if *damage > 0.0 {
                damaged += 1.0;
                let least = symmetric::eigen(s).0.iter().fold(0.0_f64, |m, v| m.min(*v));
                pressed += f64::from(u8::from(least < -5.0 * PLASTER.failure_stress));
            }
        }
        crater.pressed = crater.pressed.max(pressed / f64::max(damaged, 100.0));
    }
    let particles = &run.domain().particles;
    let disc = impact.radius.max(load_patch::LEAST_RADIUS * spacing);
    let (mut near, mut all) = ([0.0; 2], 0.0);
    for p in (0..particles.len()).filter(|&p| particles.damage[p] >= 1.0) {
        let far = (particles.reference[p] - impact.point).norm();
        all += particles.volume[p];
        for (near, radius) in near.iter_mut().zip([impact.radius, disc]) {
            *near += if far < 2.0 * radius { particles.volume[p] } else { 0.0 };
        }
    }
    crater.near = near.map(|near| near / f64::max(all, f64::MIN_POSITIVE));
    crater.broken = all / EDGE.powi(3);
    crater
}

/// F11: the grid never loads less than Hertz's disc; what breaks under a wide contact does not
/// gather there. What broken points bear (F13) is only measured.
#[test]
fn a_contact_is_no_point_on_any_grid() {
    println!(
        "| ball | spacing | a/h | loaded | near Hertz's disc, the grid's | broken | pressed |"
    );
    for radius in [0.02, 1.5] {
        for spacing in [0.01, 0.005] {
            let a = hit(radius, spacing).0.radius;
            let Crater { loaded, near, broken, pressed } = crater(radius, spacing);
            println!(
                "| {radius} m | {spacing} m | {:.2} | {loaded:.2} | {:.2}, {:.2} | {broken:.3} | \
                 {pressed:.3} |",
                a / spacing,
                near[0],
                near[1]
            );
            assert!(loaded > 0.85, "{loaded} of Hertz's disc");
            assert!(broken > 0.0 && broken < 0.3, "{broken}");
        }
    }
}
