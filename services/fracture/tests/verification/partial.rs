//! Cracks that stop inside a body, from problem to sheet.

use cullet_fracture::brittle::Brittle;
use cullet_geometry::{Solid, Vec3, shapes};
use cullet_model::{
    BrittleProblem, Fragmentation, Impact, Material, Progress, Settings, Solver, StrengthField,
    entry,
};
use std::sync::Arc;

const PLASTER: Material = Material {
    density: 1150.0,
    young: 3e9,
    poisson: 0.2,
    failure_stress: 3e6,
    fracture_energy: 5.0,
};

/// Half the edges of the bar \[m\].
const HALF: Vec3 = Vec3::new(0.15, 0.05, 0.05);

fn solve(problem: &BrittleProblem) -> Fragmentation {
    let entry = entry::<Brittle>();
    let mut run = (entry.begin)(problem.clone().into()).expect("accepted");
    loop {
        match run.advance() {
            Progress::Running(_) => {}
            Progress::Done(outcome) => return outcome.fracture().expect("a fracture"),
            Progress::Failed(failure) => panic!("{failure}"),
        }
    }
}

fn bar(impulse: f64, material: Material) -> BrittleProblem {
    let mesh = shapes::cuboid(Vec3::new(0.3, 0.1, 0.1), shapes::Detail::default()).expect("a box");
    let (closing_speed, energy) = (20.0, 10.0 * impulse);
    let hit = Impact {
        point: Vec3::new(0.0, 0.05, 0.0),
        normal: -Vec3::y(),
        impulse,
        duration: 2.4e-4,
        radius: 1e-2,
        energy,
        closing_speed,
        crushing_pressure: 1e12,
    };
    BrittleProblem {
        solid: Arc::new(Solid::outer(mesh)),
        material,
        strength: StrengthField { seed: 7, ..StrengthField::default() },
        impacts: vec![hit],
        supports: Vec::new(),
        spin: Vec3::zeros(),
        settings: Settings { max_particles: 12000, ..Settings::default() },
        seed: 7,
    }
}

/// A bar that is bent by a push in its middle: a cone under the contact, and below it a crack that
/// grows up from the far side and stops.
#[test]
fn a_bent_bar_has_a_crack_that_stops_inside() {
    let problem = bar(0.4, PLASTER);
    let fracture = solve(&problem);
    let h = fracture.report.spacing;
    // A chip may come off under the contact.
    let volumes = fracture.fragments.iter().map(|f| f.solid.mesh.signed_volume());
    assert!(volumes.skip(1).sum::<f64>() < 0.01 * problem.solid.mesh.signed_volume());
    let sheet = &fracture.fragments[0].sheet;
    sheet.validate().expect("sound");
    assert!(sheet.mesh.area() > 20.0 * h * h, "{} cells²", sheet.mesh.area() / (h * h));
    // It stands across the bar, most of it in its middle, from the pulled side up into it.
    let middle = |v: &Vec3| v.x.abs() < 0.045;
    let corners = (0..sheet.mesh.triangles.len()).map(|t| sheet.mesh.corners(t));
    let faces: Vec<Vec3> = corners
        .filter(|[a, b, c]| middle(&((a + b + c) / 3.0)))
        .map(|[a, b, c]| 0.5 * (b - a).cross(&(c - a)))
        .collect();
    let area: f64 = faces.iter().map(Vec3::norm).sum();
    assert!(area > 0.8 * sheet.mesh.area(), "{area} of {}", sheet.mesh.area());
    let heights = sheet.mesh.vertices.iter().filter(|v| middle(v)).map(|v| v.y);
    let y = (heights.clone().fold(f64::MAX, f64::min), heights.fold(f64::MIN, f64::max));
    assert!(y.0 < -0.05 + h && y.1 - y.0 > 4.0 * h, "{y:?}");
    // It does not go through: some of its border lies inside the bar.
    assert!(sheet.mesh.area() < 0.9 * 0.01, "{}", sheet.mesh.area());
    let buried =
        |v: &u32| sheet.mesh.vertices[*v as usize].abs().zip_map(&HALF, |x, w| w - x).min();
    let ends = sheet.mesh.open_edges();
    let inside = ends.iter().filter(|edge| edge.iter().all(|v| buried(v) > h)).count();
    assert!(inside > 5, "{inside}");
    let across: f64 = faces.iter().map(|face| face.x.abs()).sum();
    assert!(across > 0.9 * area, "{across} of {area}");
    // The front came from below the contact and ran away from it: later farther down.
    let early = |low: bool| {
        let own = sheet.mesh.vertices.iter().zip(&sheet.damage_time);
        let half = own.filter(|(p, _)| (p.y < 0.5 * (y.0 + y.1)) == low);
        let times: Vec<f64> = half.map(|(_, time)| f64::from(*time)).collect();
        times.iter().sum::<f64>() / times.len() as f64
    };
    assert!(early(false) < early(true), "{} {}", early(false), early(true));
}

/// The same with a hairline: the slit is there, and neither mass nor momentum is lost.
#[test]
fn a_hairline_keeps_mass_and_momentum() {
    let plain = bar(0.4, PLASTER);
    let before = solve(&plain);
    let h = before.report.spacing;
    let mut problem = plain.clone();
    problem.settings.brittle.hairline = Some(0.1 * h);
    let after = solve(&problem);
    assert_eq!(after.report.warnings, before.report.warnings);
    let slit = &after.fragments[0];
    assert!(slit.sheet.is_empty() && slit.solid.mesh.is_closed() && !after.debris.is_empty());
    let dust: f64 = after.debris.iter().map(|grain| grain.volume).sum();
    let wanted = 0.1 * h * before.fragments[0].sheet.mesh.area();
    assert!((dust / wanted - 1.0).abs() < 0.15, "{dust} of {wanted}");
    let whole = problem.solid.mesh.signed_volume();
    let parts = after.fragments.iter().map(|f| f.solid.mesh.signed_volume());
    let volume = parts.sum::<f64>() + dust;
    assert!((volume / whole - 1.0).abs() < 1e-12, "{volume} of {whole}");
    let momentum = |fracture: &Fragmentation| -> Vec3 {
        let parts = fracture.fragments.iter();
        let parts = parts.map(|f| f.velocity * f.solid.mesh.signed_volume());
        let grains = fracture.debris.iter().map(|g| g.velocity * g.volume);
        parts.chain(grains).sum()
    };
    let (a, b) = (momentum(&before), momentum(&after));
    assert!((a - b).norm() < 1e-9 * a.norm(), "{a} {b}");
    problem.settings.brittle.hairline = Some(0.5 * h);
    let refusal =
        Brittle::accepts(&problem.clone().into()).expect_err("wider than the grid resolves");
    assert!(refusal.to_string().contains("width of hairlines"), "{refusal}");
}
