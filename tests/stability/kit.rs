//! What the modules of the suite share: solids, points on a grid, blows, and what every fracture
//! must keep.

use cullet_fracture::damage::Softening;
use cullet_fracture::mpm::Domain;
use cullet_fracture::particles::Particles;
use cullet_geometry::boolean::Exact;
use cullet_geometry::{Solid, TriMesh, Vec3, shapes};
use cullet_model::{
    BrittleProblem, Failure, Fragmentation, Impact, Material, Progress, Refusal, Settings,
    StrengthField, SurfaceLaw,
};
use cullet_worker::families::by_name;
use std::sync::Arc;

pub(crate) const PLASTER: Material = Material {
    density: 1150.0,
    young: 3e9,
    poisson: 0.2,
    failure_stress: 3e6,
    fracture_energy: 5.0,
};

/// As stiff, and nothing breaks it.
pub(crate) const STRONG: Material =
    Material { failure_stress: 1e20, fracture_energy: 1e40, ..PLASTER };

/// Grid spacing of [`body`] \[m\].
pub(crate) const H: f64 = 0.01;

/// Holds a mesh to being a closed, outward solid that the exact kernel takes and that does not
/// cross itself.
pub(crate) fn is_solid(mesh: &TriMesh) {
    assert!(mesh.is_closed(), "{} open or crowded edges", mesh.non_manifold_edges().len());
    let exact = Exact::new(&Solid::outer(mesh.clone())).expect("the kernel takes it");
    assert!(exact.volume() > 0.0, "volume {}", exact.volume());
    assert!(!exact.crosses_itself().expect("it can be asked"), "it crosses itself");
}

pub(crate) fn cuboid(size: Vec3) -> TriMesh {
    shapes::cuboid(size, shapes::Detail::default()).expect("a box")
}

/// Eight points a cell in rows: a block of `cells` about the origin.
pub(crate) fn rows(cells: [usize; 3]) -> Vec<Vec3> {
    let [nx, ny, nz] = cells.map(|n| 2 * n);
    let all = (0..nx * ny * nz).map(|i| [i / (ny * nz), i / nz % ny, i % nz]);
    let middle = Vec3::new(nx as f64, ny as f64, nz as f64) * 0.5;
    all.map(|at| (Vec3::from(at.map(|k| k as f64 + 0.5)) - middle) * (0.5 * H)).collect()
}

/// Points on a grid of [`H`], each with its share of a cell.
pub(crate) fn body(points: &[Vec3], material: &Material) -> Domain {
    uneven(points, material, |_| 1.0)
}

/// Likewise, with a strength at each place over the material's.
pub(crate) fn uneven(
    points: &[Vec3],
    material: &Material,
    strength: impl Fn(&Vec3) -> f64,
) -> Domain {
    let volume = points.len() as f64 * H * H * H / 8.0;
    let mut particles = Particles::at_rest(points, volume, material.density);
    particles.strength = points.iter().map(strength).collect();
    Domain::new(particles, material, Softening::on_grid(material, H), Vec3::repeat(H))
}

/// Kinetic and elastic energy \[J\].
pub(crate) fn energy(domain: &Domain) -> f64 {
    domain.kinetic_energy() + domain.elastic_energy()
}

/// A blow of a striker that is as heavy as what gives way: I = m* v, E = ½ m* v².
pub(crate) fn blow(point: Vec3, normal: Vec3, impulse: f64) -> Impact {
    Impact {
        point,
        normal: normal.normalize(),
        impulse,
        duration: 1.2e-4,
        radius: 6e-3,
        energy: 10.0 * impulse,
        closing_speed: 20.0,
        crushing_pressure: 1e12,
    }
}

pub(crate) fn problem(mesh: TriMesh, material: Material, impact: Impact) -> BrittleProblem {
    BrittleProblem {
        solid: Arc::new(Solid::outer(mesh)),
        material,
        strength: StrengthField { seed: 7, ..StrengthField::default() },
        surface: SurfaceLaw::of(&material),
        impacts: vec![impact],
        supports: Vec::new(),
        spin: Vec3::zeros(),
        settings: Settings { max_particles: 2000, ..Settings::default() },
        seed: 7,
    }
}

/// How a solve can come out.
#[derive(Debug)]
pub(crate) enum Out {
    Done(Box<Fragmentation>),
    Refused(Refusal),
    Failed(Failure),
}

/// Solves with the family of that name.
pub(crate) fn solve(family: &str, problem: &BrittleProblem) -> Out {
    let entry = by_name(family).expect("in the table");
    let mut run = match (entry.begin)(problem.clone().into()) {
        Ok(run) => run,
        Err(refusal) => return Out::Refused(refusal),
    };
    loop {
        match run.advance() {
            Progress::Running(_) => {}
            Progress::Done(outcome) => {
                return Out::Done(Box::new(outcome.fracture().expect("a fracture")));
            }
            Progress::Failed(failure) => return Out::Failed(failure),
        }
    }
}

/// Solves a problem that has to have an outcome.
pub(crate) fn solved(problem: &BrittleProblem) -> Fragmentation {
    match solve("brittle", problem) {
        Out::Done(fracture) => *fracture,
        other => panic!("{other:?}"),
    }
}

/// Whether the report of a solve tells of a mode.
pub(crate) fn told(mode: &str, problem: &BrittleProblem) -> bool {
    let mark = format!("({mode})");
    solved(problem).report.warnings.iter().any(|line| line.contains(&mark))
}

/// Holds a fracture to its books: closed parts whose volumes sum with the grains' to the body's,
/// motions that are numbers, and the momentum that the blows gave.
pub(crate) fn keeps_the_books(what: &str, problem: &BrittleProblem, fracture: &Fragmentation) {
    let whole = problem.solid.mesh.signed_volume();
    let (mut volume, mut momentum) = (0.0, Vec3::zeros());
    for fragment in &fracture.fragments {
        let mesh = &fragment.solid.mesh;
        assert!(mesh.is_closed() && mesh.signed_volume() > 0.0, "{what}: an open fragment");
        let motion = fragment.velocity.iter().chain(fragment.spin.iter());
        assert!(motion.copied().all(f64::is_finite), "{what}: a motion that is no number");
        volume += mesh.signed_volume();
        momentum += fragment.velocity * mesh.signed_volume();
    }
    for grain in &fracture.debris {
        assert!(grain.volume > 0.0 && grain.size > 0.0, "{what}: {grain:?}");
        volume += grain.volume;
        momentum += grain.velocity * grain.volume;
    }
    assert!((volume / whole - 1.0).abs() < 1e-9, "{what}: {volume} of {whole} m³");
    if let [impact] = problem.impacts[..] {
        let wanted =
            impact.normal * fracture.report.detail("delivered_impulse").unwrap_or_default();
        let got = momentum * problem.material.density;
        let error = (got - wanted).norm();
        assert!(error <= 1e-9 * wanted.norm() + 1e-15, "{what}: momentum {got} of {wanted}");
    }
}
