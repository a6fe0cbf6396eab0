//! Materials at every bound, blows where they are worst, and bodies broken again and again.

use crate::kit::{Out, PLASTER, blow, cuboid, keeps_the_books, problem, solve};
use cullet_geometry::{Solid, Vec3};
use cullet_model::{BrittleProblem, Fragmentation, Impact, Material, Refusal};
use std::sync::Arc;

/// Holds both families to an outcome in words or a fracture that keeps its books; the fracture.
fn holds(what: &str, problem: &BrittleProblem) -> [Option<Fragmentation>; 2] {
    ["brittle", "geometric"].map(|family| match solve(family, problem) {
        Out::Done(fracture) => {
            keeps_the_books(&format!("{what}, {family}"), problem, &fracture);
            Some(*fracture)
        }
        Out::Refused(refusal) => {
            assert!(!refusal.to_string().is_empty(), "{what}, {family}");
            None
        }
        Out::Failed(failure) => panic!("{what}, {family}: {failure}"),
    })
}

fn side_blow(impulse: f64) -> Impact {
    blow(Vec3::new(-0.1, 0.02, 0.03), Vec3::x(), impulse)
}

fn cube(material: Material, impact: Impact) -> BrittleProblem {
    problem(cuboid(Vec3::repeat(0.2)), material, impact)
}

/// A blow of a tenth of the body's mass at a hundredth of the speed of sound.
fn scaled_blow(material: &Material) -> Impact {
    let sound = (material.young / material.density).sqrt();
    let (mass, speed) = (0.1 * material.density * 0.008, 0.01 * sound);
    let (energy, duration) = (0.5 * mass * speed * speed, 0.6 / sound);
    Impact { energy, duration, closing_speed: speed, ..side_blow(mass * speed) }
}

/// Each property at both ends of what the brittle solver takes is solved, refused for a limit of
/// cost, or given up in words; just beyond, it is refused by its name.
#[test]
fn materials_at_their_bounds_end_in_words_and_beyond_are_refused_by_name() {
    type Set = fn(&mut Material, f64);
    let bounds: [(&str, Set, f64, f64); 5] = [
        ("density", |m, x| m.density = x, 1e-3, 1e6),
        ("Young", |m, x| (m.failure_stress, m.young) = (1e-3 * x, x), 1.0, 1e14),
        ("Poisson", |m, x| m.poisson = x, -0.5, 0.49),
        ("fracture energy", |m, x| m.fracture_energy = x, 1e-9, 1e9),
        ("failure stress", |m, x| m.failure_stress = 3e9 * x, 1e-5, 1e-1),
    ];
    for (name, set, low, high) in bounds {
        for (value, beyond) in [(low, low - 1e-3 * high.abs().min(low.abs())), (high, 1.001 * high)]
        {
            let mut material = PLASTER;
            set(&mut material, value);
            let what = format!("{name} at {value:e}");
            let problem = cube(material, scaled_blow(&material));
            match solve("brittle", &problem) {
                Out::Done(fracture) => keeps_the_books(&what, &problem, &fracture),
                Out::Refused(Refusal::TooLarge { .. }) => {}
                other => panic!("{what}: {other:?}"),
            }
            match solve("geometric", &problem) {
                Out::Done(fracture) => keeps_the_books(&what, &problem, &fracture),
                other => panic!("{what}: {other:?}"),
            }
            set(&mut material, beyond);
            match solve("brittle", &BrittleProblem { material, ..problem }) {
                Out::Refused(Refusal::OutOfRange { what, .. }) => {
                    assert!(what.contains(name), "{what} for {name}");
                }
                other => panic!("{name} at {beyond:e}: {other:?}"),
            }
        }
    }
}

/// On a corner, on an edge, along a face, beside the body, in its middle, a hair off the surface.
#[test]
fn blows_at_edges_and_corners_and_grazing_keep_the_books() {
    let d = 0.1;
    let places = [
        ("corner", Vec3::repeat(d), -Vec3::repeat(1.0)),
        ("corner, along an edge", Vec3::repeat(d), -Vec3::x()),
        ("edge", Vec3::new(d, d, 0.0), Vec3::new(-1.0, -1.0, 0.0)),
        ("edge, outward", Vec3::new(d, d, 0.02), Vec3::new(1.0, 1.0, 0.0)),
        ("grazing", Vec3::new(0.0, 0.0, d), Vec3::new(1.0, 0.0, -1e-3)),
        ("along a face", Vec3::new(0.0, 0.0, d), Vec3::x()),
        ("beside", Vec3::new(0.0, 0.5 * d, 3.0 * d), -Vec3::z()),
        ("middle", Vec3::zeros(), Vec3::new(0.3, 0.2, 0.1)),
        ("a hair off", Vec3::new(-d - 1e-12, 1e-12, 0.0), Vec3::x()),
    ];
    for (what, point, normal) in places {
        let [brittle, geometric] = holds(what, &cube(PLASTER, blow(point, normal, 3.0)));
        assert!(brittle.is_some() && geometric.is_some(), "{what}: refused");
    }
}

/// Strikers from a grain to a mountain, from a creep to a shell: an answer in words or books kept.
#[test]
fn blows_of_every_size_keep_the_books() {
    let sizes = [1e-12, 1e-6, 1e-3, 30.0];
    let speeds = [1e-3, 1.0, 300.0, 5e3];
    for (impulse, speed) in sizes.into_iter().flat_map(|i| speeds.map(|v| (i, v))) {
        let impact =
            Impact { energy: 0.5 * impulse * speed, closing_speed: speed, ..side_blow(impulse) };
        for (duration, radius) in [(1e-7, 1e-6), (1e-4, 6e-3), (3e-2, 0.3)] {
            let impact = Impact { duration, radius, ..impact };
            let what = format!("{impulse} N·s at {speed} m/s, {duration} s, {radius} m");
            let body = cube(PLASTER, impact);
            match solve("geometric", &body) {
                Out::Done(fracture) => keeps_the_books(&what, &body, &fracture),
                other => panic!("{what}: {other:?}"),
            }
            match solve("brittle", &BrittleProblem { settings: coarse(&body), ..body.clone() }) {
                Out::Done(fracture) => keeps_the_books(&what, &body, &fracture),
                Out::Refused(refusal) => assert!(!refusal.to_string().is_empty(), "{what}"),
                Out::Failed(failure) => assert!(!failure.to_string().is_empty(), "{what}"),
            }
        }
    }
}

fn coarse(problem: &BrittleProblem) -> cullet_model::Settings {
    cullet_model::Settings { max_particles: 400, ..problem.settings }
}

/// The largest fragment as a body of its own, its centre at the origin.
fn largest(fracture: &Fragmentation) -> Solid {
    let volume = |solid: &Solid| solid.mesh.signed_volume();
    let solids = fracture.fragments.iter().map(|f| &f.solid);
    let mut solid =
        solids.max_by(|a, b| volume(a).total_cmp(&volume(b))).expect("a fragment").clone();
    let centre = solid.mesh.mass_properties().centroid;
    solid.mesh = solid.mesh.translated(-centre);
    solid
}

/// Breaks the largest fragment of a cube ten times over; how often it broke, and the grains.
fn again(family: &str, impulse: impl Fn(f64) -> f64) -> (usize, usize) {
    let mut solid = Solid::outer(cuboid(Vec3::repeat(0.2)));
    let (mut broke, mut grains) = (0, 0);
    for generation in 0..10 {
        let volume = solid.mesh.signed_volume();
        // From another side each time, at the corner that is farthest out there.
        let way = Vec3::new(1.0, 0.3, -0.2 + 0.1 * f64::from(generation)).normalize()
            * if generation % 2 == 0 { 1.0 } else { -1.0 };
        let corners = solid.mesh.vertices.iter();
        let point = corners.max_by(|a, b| a.dot(&way).total_cmp(&b.dot(&way))).expect("a corner");
        let mut problem = problem(cuboid(Vec3::repeat(1.0)), PLASTER, side_blow(1.0));
        let mut impact = blow(*point, -point, impulse(volume));
        impact.radius = 0.03 * libm::cbrt(volume);
        problem.solid = Arc::new(solid.clone());
        problem.impacts = vec![impact];
        problem.settings.debris = 5e-3;
        problem.settings.max_particles = 5000;
        (problem.seed, problem.strength.seed) = (generation as u64, generation as u64);
        let what = format!("{family}, generation {generation}");
        match solve(family, &problem) {
            Out::Done(fracture) => {
                keeps_the_books(&what, &problem, &fracture);
                let (parts, loose) = (fracture.fragments.len(), fracture.debris.len());
                println!("{what}: {parts} fragments, {loose} grains");
                broke += usize::from(parts > 1 || loose > 0);
                grains += loose;
                solid = largest(&fracture);
            }
            Out::Refused(refusal) => println!("{what}: {refusal}"),
            Out::Failed(failure) => panic!("{what}: {failure}"),
        }
    }
    let (parts, left) = (broke, solid.mesh.signed_volume());
    println!("{family}: broke {parts} times, {grains} grains, {left:.2e} m³ left");
    (broke, grains)
}

/// Ten generations: closed, volumes and momentum exact, grains booked, each time.
#[test]
fn ten_generations_keep_the_books() {
    let (broke, _) = again("geometric", |volume| 400.0 * volume);
    assert!(broke >= 8, "geometric pieces broke {broke} times");
    let (broke, grains) = again("brittle", |volume| 900.0 * volume);
    assert!(broke >= 6 && grains > 0, "brittle pieces broke {broke} times, {grains} grains");
}
