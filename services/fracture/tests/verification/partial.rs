//! Cracks that stop inside a body, from problem to sheet.

use cullet_fracture::brittle::Brittle;
use cullet_geometry::{Solid, Vec3, shapes};
use cullet_model::{
    BrittleProblem, Fragmentation, Impact, Material, Progress, Settings, Solver, StrengthField,
    SurfaceLaw, entry,
};
use std::sync::Arc;

const PLASTER: Material = Material {
    density: 1150.0,
    young: 3e9,
    poisson: 0.2,
    failure_stress: 0.8e6,
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
        radius: 3e-2,
        energy,
        closing_speed,
        crushing_pressure: 1e12,
    };
    BrittleProblem {
        solid: Arc::new(Solid::outer(mesh)),
        material,
        strength: StrengthField { seed: 7, ..StrengthField::default() },
        surface: SurfaceLaw::of(&material),
        impacts: vec![hit],
        supports: Vec::new(),
        spin: Vec3::zeros(),
        settings: Settings { max_particles: 12000, ..Settings::default() },
        seed: 7,
    }
}

/// A bar that is bent by a push in its middle: cracks grow up from the far side and stop, the
/// largest of them across from the contact.
#[test]
fn a_bent_bar_has_a_crack_that_stops_inside() {
    let fracture = solve(&bar(0.42, PLASTER));
    let h = fracture.report.spacing;
    assert_eq!(fracture.fragments.len(), 1);
    let sheet = &fracture.fragments[0].sheet;
    sheet.validate().expect("sound");
    let face = |t: usize| {
        let [a, b, c] = sheet.mesh.corners(t);
        0.5 * (b - a).cross(&(c - a))
    };
    let area = |faces: &[usize]| faces.iter().map(|&t| face(t).norm()).sum::<f64>();
    let places = |faces: &[usize]| -> Vec<(Vec3, f64)> {
        let corners = faces.iter().flat_map(|&t| sheet.mesh.triangles[t]).map(|v| v as usize);
        corners.map(|v| (sheet.mesh.vertices[v], f64::from(sheet.damage_time[v]))).collect()
    };
    let cracks = sheet.mesh.components();
    let pulled = cracks.iter().filter(|c| places(c).iter().any(|(x, _)| x.y < -0.05 + 0.1 * h));
    let crack = pulled.max_by(|a, b| area(a).total_cmp(&area(b))).expect("a crack");
    let (size, own) = (area(crack), places(crack));
    // It stands across the bar, in its middle, and does not go through.
    assert!(size > 6.0 * h * h && size < 0.5 * 0.01, "{} cells²", size / (h * h));
    assert!(own.iter().all(|(x, _)| x.x.abs() < 0.045), "{own:?}");
    let across: f64 = crack.iter().map(|&t| face(t).x.abs()).sum();
    assert!(across > 0.85 * size, "{across} of {size}");
    // Some of its border lies inside the bar.
    let buried =
        |v: &u32| sheet.mesh.vertices[*v as usize].abs().zip_map(&HALF, |x, w| w - x).min();
    let ends = sheet.mesh.open_edges();
    let inside = ends.iter().filter(|edge| edge.iter().all(|v| buried(v) > h)).count();
    assert!(inside > 5, "{inside}");
    // The front came from the far side: later farther up.
    let middle = own.iter().map(|(x, _)| x.y).sum::<f64>() / own.len() as f64;
    let early = |low: bool| {
        let times = own.iter().filter(|(x, _)| (x.y < middle) == low).map(|(_, time)| *time);
        times.clone().sum::<f64>() / times.count() as f64
    };
    assert!(early(true) < early(false), "{} {}", early(true), early(false));
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
