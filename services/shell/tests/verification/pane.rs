//! Panes of glass under a ball: what parts, what it costs, and that all of it adds up.

use cullet_geometry::shapes::{self, Detail};
use cullet_geometry::{Solid, Vec3};
use cullet_model::{
    BrittleProblem, Fragmentation, Impact, Material, Problem, Progress, Settings, SolveOutcome,
    Solver, StrengthField, Support,
};
use cullet_shell::Shell;
use std::sync::Arc;

const GLASS: Material = Material {
    density: 2440.0,
    young: 72e9,
    poisson: 0.22,
    failure_stress: 50e6,
    fracture_energy: 8.0,
};

/// A steel ball that meets the upper face of a pane: H1.
fn ball(radius: f64, speed: f64, pane: f64, point: Vec3) -> Impact {
    let mass = 7850.0 * 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    let reduced = 1.0 / (1.0 / mass + 1.0 / pane);
    let modulus = 1.0 / ((1.0 - 0.09) / 200e9 + (1.0 - 0.22 * 0.22) / 72e9);
    let stiffness = 4.0 / 3.0 * modulus * radius.sqrt();
    let approach = (1.25 * reduced * speed * speed / stiffness).powf(0.4);
    Impact {
        point,
        normal: -Vec3::z(),
        impulse: 2.0 * reduced * speed,
        duration: 2.943_3 * approach / speed,
        radius: (radius * approach).sqrt(),
        energy: 0.5 * reduced * speed * speed,
        closing_speed: speed,
        crushing_pressure: 1e12,
    }
}

/// A pane under a ball, on supports at its corners.
fn pane(size: [f64; 3], radius: f64, speed: f64, settings: Settings) -> BrittleProblem {
    let mesh = shapes::cuboid(Vec3::from(size), Detail::default()).unwrap();
    let mass = GLASS.density * mesh.signed_volume();
    let [x, y, z] = size.map(|s| 0.5 * s);
    let corner = |k: usize| Support {
        point: Vec3::new(if k % 2 == 0 { -x } else { x }, if k < 2 { -y } else { y }, -z) * 0.97,
        normal: Vec3::z(),
        radius: 5e-3,
        mobility: 0.0,
    };
    BrittleProblem {
        solid: Arc::new(Solid::outer(mesh)),
        material: GLASS,
        strength: StrengthField { weibull: 7.0, seed: 4, ..StrengthField::even() },
        impacts: vec![ball(radius, speed, mass, Vec3::new(0.006, -0.004, z))],
        supports: (0..4).map(corner).collect(),
        spin: Vec3::zeros(),
        settings,
        seed: 1,
    }
}

fn solve(problem: BrittleProblem) -> Fragmentation {
    let mut solve = Shell::begin(Problem::from(problem)).expect("accepted");
    loop {
        match solve.advance() {
            Progress::Running(_) => {}
            Progress::Done(outcome) => {
                return match outcome {
                    SolveOutcome::Broken(parts) | SolveOutcome::Unchanged(parts) => *parts,
                    SolveOutcome::Deformed(_) => panic!("deformed"),
                };
            }
            Progress::Failed(failure) => panic!("{failure}"),
        }
    }
}

fn draw(name: &str, found: &Fragmentation, size: f64) {
    let Ok(folder) = std::env::var("CULLET_DRAW") else { return };
    let mut svg = format!(
        "<svg xmlns='http://www.w3.org/2000/svg' width='900' height='900' viewBox='{0} {0} {1} {1}'>",
        -0.5 * size,
        size
    );
    for (k, fragment) in found.fragments.iter().enumerate() {
        let mesh = &fragment.solid.mesh;
        for (t, _) in mesh.triangles.iter().enumerate() {
            let [a, b, c] = mesh.corners(t);
            let n = (b - a).cross(&(c - a)).normalize();
            if n.z > 0.99 {
                let hue = (k * 137) % 360;
                svg += &format!(
                    "<path d='M{} {}L{} {}L{} {}Z' fill='hsl({hue},60%,70%)' stroke='none'/>",
                    a.x, -a.y, b.x, -b.y, c.x, -c.y
                );
            }
        }
        for t in 0..mesh.triangles.len() {
            if !matches!(fragment.solid.surface[t], cullet_geometry::Surface::Outer) {
                let [a, b, c] = mesh.corners(t);
                let top = [a, b, c].into_iter().filter(|x| x.z > 0.0039).collect::<Vec<_>>();
                if top.len() == 2 {
                    svg += &format!(
                        "<path d='M{} {}L{} {}' stroke='black' stroke-width='{}'/>",
                        top[0].x,
                        -top[0].y,
                        top[1].x,
                        -top[1].y,
                        size / 800.0
                    );
                }
            }
        }
    }
    svg += "</svg>";
    std::fs::write(format!("{folder}/{name}.svg"), svg).unwrap();
}

#[test]
fn a_pane_breaks_into_a_star() {
    let settings = Settings { spacing: Some(4e-3), max_particles: 60_000, ..Settings::default() };
    for speed in [2.0, 4.0, 10.0] {
        let started = std::time::Instant::now();
        let problem = pane([0.3, 0.3, 0.008], 0.025, speed, settings);
        let volume = problem.solid.mesh.signed_volume();
        let found = solve(problem);
        println!(
            "{speed} m/s: {} fragments, {} grains, area {:.4} m2, dissipated {:.3} J, {:?} s",
            found.fragments.len(),
            found.debris.len(),
            found.report.crack_area,
            found.report.dissipated_energy,
            started.elapsed()
        );
        println!("   {:?} {:?}", found.report.details, found.report.warnings);
        println!("   steps {} simulated {}", found.report.steps, found.report.simulated);
        draw(&format!("pane-{speed}"), &found, 0.3);
        let sum: f64 = found.fragments.iter().map(|f| f.solid.mesh.signed_volume()).sum::<f64>()
            + found.debris.iter().map(|g| g.volume).sum::<f64>();
        assert!((sum / volume - 1.0).abs() < 1e-9, "{sum}");
        for fragment in &found.fragments {
            assert!(fragment.solid.mesh.is_closed());
        }
    }
}
